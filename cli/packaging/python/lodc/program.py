"""The program ``lodc``, which comes in the same wheel."""

import os
import re
import shutil
import subprocess
import sysconfig
from collections.abc import Iterable

from .errors import FormatError, ProgramError

USAGE, INPUT = 2, 3


def program() -> str:
    """The path of the program: that of this installation, else the first one on the search path."""
    name = "lodc" + (sysconfig.get_config_var("EXE") or "")
    schemes = [sysconfig.get_default_scheme(), sysconfig.get_preferred_scheme("user")]
    folders = [sysconfig.get_path("scripts", scheme) for scheme in schemes]
    # `pip install --target` puts programs beside the packages.
    folders.append(os.path.join(os.path.dirname(os.path.dirname(__file__)), "bin"))
    for folder in folders:
        path = os.path.join(folder, name)
        if os.path.isfile(path):
            return path
    found = shutil.which("lodc")
    if found is None:
        raise ProgramError(f"the program lodc is not in {', '.join(folders)}", USAGE)
    return found


def run(words: Iterable[str]) -> tuple[bytes, list[str]]:
    """Runs the program: what it writes on standard output, and its warnings."""
    done = subprocess.run([program(), *words], stdin=subprocess.DEVNULL, capture_output=True)
    lines = done.stderr.decode("utf-8", "replace").splitlines()
    lines = [line.removeprefix("lodc: ") for line in lines]
    warnings = [line for line in lines if ": warning: " in line]
    said = "\n".join(line for line in lines if line not in warnings)
    if done.returncode == USAGE:
        raise wrong_usage(said)
    if done.returncode == INPUT:
        raise FormatError("", said)
    if done.returncode:
        raise ProgramError(said or f"lodc ended with {done.returncode}", done.returncode)
    return done.stdout, warnings


def wrong_usage(said: str) -> Exception:
    """What Python raises where the program explains its options: TypeError for an unknown one."""
    said = said.removeprefix("error: ").split("\n\nUsage:")[0]
    unknown = re.match(r"unexpected argument '--([\w-]+)", said)
    if unknown is None:
        lines = (line.strip() for line in said.splitlines())
        return ValueError(" ".join(line for line in lines if line and "--help" not in line))
    similar = re.search(r"similar argument exists: '--([\w-]+)", said)
    tip = f"; did you mean {similar[1].replace('-', '_')!r}?" if similar else ""
    return TypeError(f"{unknown[1].replace('-', '_')!r}: unknown option{tip}")


def options(given: dict[str, object]) -> list[str]:
    """Options as words of a command line: ``lock_border=True`` is ``--lock-border``, a list one
    option for each entry, a dict ``KEY=VALUE`` with commas; None and False are left out."""
    words = []
    for name, value in given.items():
        flag = "--" + name.replace("_", "-")
        for one in value if isinstance(value, (list, tuple)) else [value]:
            if one is True:
                words.append(flag)
            elif isinstance(one, dict):
                words.append(f"{flag}={','.join(f'{k}={v}' for k, v in one.items())}")
            elif isinstance(one, (str, int, float, os.PathLike)) and one is not False:
                words.append(f"{flag}={os.fspath(one) if isinstance(one, os.PathLike) else one}")
            elif one is not None and one is not False:
                raise TypeError(f"{name}={one!r}: neither text, a number, True nor False")
    return words
