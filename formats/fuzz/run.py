"""Coverage-guided fuzzing of the readers with a stable toolchain: `just fuzz`.

run.py [--runs N | --minutes N] [--jobs N] [--timeout S] [TARGET...]

Builds the targets, gives each its seeds (fixtures, small files of LODC_CORPUS), runs them, and
prints a line of figures for each. Ends with 1 if there was a find: its input is in
formats/fuzz/artifacts/TARGET, and `run.py TARGET --input FILE` tries it again.
"""
import argparse
import concurrent.futures
import os
import pathlib
import re
import struct
import subprocess
import sys
import time

FUZZ = pathlib.Path(__file__).resolve().parent
ROOT = FUZZ.parent.parent
# Which files are seeds of a target, by their extensions.
SEEDS = {
    "verify": ["glb", "gltf", "obj", "ply", "stl"],
    **{name: [name] for name in ["glb", "gltf", "lodc", "lods", "obj", "ply", "stl"]},
}
# Largest number of bytes of an input, where it is not DEFAULT_MAX_BYTES. Chosen by hand: short
# inputs run fast.
MAX_BYTES = {"verify": 4096}
DEFAULT_MAX_BYTES = 16384
# What cargo-fuzz passes, but for the address sanitizer: that needs a nightly toolchain, and there
# is no unsafe code.
FLAGS = ["passes=sancov-module", "codegen-units=1", "debug-assertions", "overflow-checks"] + [
    f"llvm-args=-sanitizer-coverage-{what}"
    for what in ["level=4", "inline-8bit-counters", "pc-table", "trace-compares"]
]


def build(targets):
    """Builds targets. Returns the folder of their programs."""
    host = subprocess.run(["rustc", "-vV"], stdout=subprocess.PIPE, text=True, check=True).stdout
    host = re.search("host: (.*)", host)[1]
    # With a target, build scripts and macros are not instrumented.
    flags = " ".join(f"-C{flag}" for flag in FLAGS) + " --cfg fuzzing"
    environment = os.environ | {"RUSTFLAGS": flags, "CARGO_PROFILE_RELEASE_INCREMENTAL": "false"}
    words = ["cargo", "build", "--release", "--locked", "--target", host]
    words += [word for target in targets for word in ("--bin", target)]
    subprocess.run(words, cwd=FUZZ, env=environment, check=True)
    folder = os.environ.get("CARGO_TARGET_DIR", FUZZ / "target")
    return pathlib.Path(folder).resolve() / host / "release"


def square(extensions):
    """A square as small files of formats that the fixtures do not have."""
    corners = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]
    faces = [(0, 1, 2), (0, 2, 3)]
    orders = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}
    numbers = ["x", "y", "z", "nx", "ny", "nz", "s", "t"]
    if "ply" in extensions:
        for kind, order in orders.items():
            colours = "".join(f"property uchar {name}\n" for name in ["red", "green", "blue"])
            head = f"ply\nformat {kind} 1.0\nelement vertex 4\n"
            head += "".join(f"property float {name}\n" for name in numbers)
            head += f"{colours}element face 2\nproperty list uchar int vertex_indices\nend_header\n"
            body = b""
            for x, y, z in corners:
                row = [x, y, z, 0, 0, 1, x, y, 255 * x, 0, 7]
                text = " ".join(map(str, row)).encode() + b"\n"
                body += struct.pack(order + "8f3B", *row) if order else text
            for face in faces:
                text = ("3 " + " ".join(map(str, face)) + "\n").encode()
                body += struct.pack(order + "B3i", 3, *face) if order else text
            yield f"{kind}.ply", head.encode() + body
    if "stl" in extensions:
        text, body = "solid square\n", struct.pack("<80xI", len(faces))
        for face in faces:
            body += struct.pack("<12fH", 0, 0, 1, *(x for v in face for x in corners[v]), 0)
            loop = "".join("vertex {} {} {}\n".format(*corners[v]) for v in face)
            text += f"facet normal 0 0 1\nouter loop\n{loop}endloop\nendfacet\n"
        yield "ascii.stl", (text + "endsolid square\n").encode()
        yield "binary.stl", body


def seed(target, max_bytes):
    """Fills the folder of a target's seeds with files of at most `max_bytes`. Returns it."""
    folder = FUZZ / "corpus" / target
    folder.mkdir(parents=True, exist_ok=True)
    for name, content in square(SEEDS[target]):
        (folder / name).write_bytes(content)
    places = [ROOT / "fixtures", pathlib.Path(os.environ.get("LODC_CORPUS", "none"))]
    for place in places:
        for path in sorted(place.rglob("*.*")):
            is_seed = path.suffix[1:].lower() in SEEDS[target] and path.is_file()
            if is_seed and path.stat().st_size <= max_bytes:
                name = "-".join(path.relative_to(place).parts)
                # Of a stream the first byte says in how large pieces it comes.
                head = b"\x3f" if target == "lods" else b""
                (folder / name).write_bytes(head + path.read_bytes())
    return folder


def fuzz(program, target, asked):
    """Runs a target. Returns how many finds there were."""
    max_bytes = MAX_BYTES.get(target, DEFAULT_MAX_BYTES)
    found = FUZZ / "artifacts" / target
    found.mkdir(parents=True, exist_ok=True)
    before = set(found.iterdir())
    words = [program, seed(target, max_bytes), f"-max_len={max_bytes}"]
    words += [f"-timeout={asked.timeout}"]
    words += [f"-artifact_prefix={found}/", "-rss_limit_mb=2048", "-print_final_stats=1", "-seed=1"]
    words += ["-reload=0", "-report_slow_units=5"]
    words += [f"-max_total_time={60 * asked.minutes}"] if asked.minutes else [f"-runs={asked.runs}"]
    log = FUZZ / "artifacts" / f"{target}.log"
    environment, began = os.environ | {"RAYON_NUM_THREADS": "1"}, time.monotonic()
    with log.open("w") as out:
        subprocess.run(words, stdout=out, stderr=out, env=environment)
    text = log.read_text(errors="replace")
    figure = lambda pattern: (re.findall(pattern, text) or ["?"])[-1]
    runs, seconds = figure(r"number_of_executed_units: (\d+)"), time.monotonic() - began
    covered, edges = figure(r"cov: (\d+)"), figure(r"(\d+) inline 8-bit counters")
    finds = sorted(set(found.iterdir()) - before)
    covered = f"{covered} of {edges} edges"
    line = f"{target}: {runs} runs in {seconds:.0f} s, {covered}, {len(finds)} finds"
    print(line, *finds, flush=True)
    return len(finds)


def main():
    """Runs what is asked for."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("targets", nargs="*", default=list(SEEDS))
    parser.add_argument("--runs", type=int, default=1_000_000)
    parser.add_argument("--minutes", type=int)
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    parser.add_argument("--timeout", type=int, default=20, help="seconds of one input")
    parser.add_argument("--input", help="tries this file alone")
    asked = parser.parse_args()
    folder = build(asked.targets)
    if asked.input:
        sys.exit(subprocess.run([folder / asked.targets[0], asked.input]).returncode)
    with concurrent.futures.ThreadPoolExecutor(asked.jobs) as pool:
        finds = pool.map(lambda target: fuzz(folder / target, target, asked), asked.targets)
        sys.exit(sum(finds) > 0)


main()
