"""What is linked into the program: read by `notices` and `release`."""

import json
import pathlib
import subprocess

HERE = pathlib.Path(__file__).parent


def linked(target="all"):
    """Packages from outside in the program for a target, as (name, version)."""
    words = ["cargo", "tree", "-p", "lodc-cli", "-e", "normal", "--target", target]
    words += ["--prefix", "none", "--locked", "--format", "{p}"]
    lines = subprocess.run(words, check=True, stdout=subprocess.PIPE, text=True, cwd=HERE).stdout
    # Packages of this repository and procedural macros are followed by a parenthesis; the latter
    # run when the program is built.
    found = {line.removesuffix(" (*)") for line in lines.splitlines()}
    return sorted(tuple(line.split(" v")) for line in found if line and "(" not in line)


def metadata():
    """All packages of the lock file, as cargo describes them."""
    words = ["cargo", "metadata", "--format-version", "1", "--locked"]
    text = subprocess.run(words, check=True, stdout=subprocess.PIPE, cwd=HERE).stdout
    return json.loads(text)["packages"]
