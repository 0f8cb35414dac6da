"""Long tests of the program as a process, with figures: `just campaign`.

campaign.py LODC [--only kills,faults,determinism,clean,kinds,large] [--short] [--seed N]

Prints a line of figures for each, and ends with 1 if a promise of docs/RELIABILITY.md was broken.
What is random follows from the seed, which is printed. Faults need strace, kinds a C compiler and
a Python with numpy, which LODC_PYTHON names (else this one).
"""

import argparse
import array
import concurrent.futures
import hashlib
import itertools
import math
import os
import pathlib
import random
import resource
import shutil
import struct
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent
SMALL = ROOT / "fixtures/machine_part.glb"
PLACES = [("UTC", "C"), ("Asia/Tokyo", "de_DE.UTF-8"), ("America/Lima", "tr_TR.UTF-8")]
# Files and options that always give the same bytes.
SAME = [("machine_part.glb", ""), ("machine_part.glb", "--metric hybrid"), ("terrain.obj", "")]
SAME += [("skinned_tube_u8.glb", ""), ("non_manifold_fan.obj", "--sequence stream")]
CALLS = ["openat", "read", "write", "fsync", "rename", "flock"]
# What `tests/run --all` does of it: a tenth and less.
SHORT = {"kills": 100, "repeats": 1, "every": 10, "files": 60}
# Sources of clean files: bytes of one in a corpus, triangles.
SMALL_FILE, MOST = 64 << 10, 1500
METRICS = ["quadric", "quadric", "quadric", "hybrid", "viewpoint", "kl"]
OPTIONS = ["--preserve-topology", "--lock-border", "--no-attributes", "--sequence stream"]
OPTIONS += ["--layout gpu", "--models none", "--strips cache"]
OPTIONS += ["--effort thorough", "--poses 0", "--weight normal=3"]


def run(command, **more):
    """A run of the program, without what it prints."""
    kept = {"stdout": subprocess.DEVNULL, "stderr": subprocess.PIPE}
    return subprocess.run(command, timeout=600, **kept, **more)


def build(lodc, out, *more, mesh=SMALL):
    """The words of a build."""
    return [lodc, "build", str(mesh), "-o", str(out), "-q", *more]


def state(folder, old, new):
    """Which file is there, and what is left besides; a torn file is neither."""
    content = (folder / "a.lodc").read_bytes()
    left = [path.name for path in folder.iterdir() if path.name != "a.lodc"]
    return {old: "old", new: "new"}.get(content, "torn"), left


def kills(lodc, asked):
    """Kills builds over an old file at seeded moments."""
    seeded, counts, broken = random.Random(asked.seed), {"old": 0, "new": 0, "torn": 0}, 0
    with tempfile.TemporaryDirectory() as scratch:
        folder = pathlib.Path(scratch)
        whole = 0
        for _ in range(5):
            began = time.monotonic()
            run(build(lodc, folder / "a.lodc"), check=True)
            whole = max(whole, time.monotonic() - began)
        new, old = (folder / "a.lodc").read_bytes(), b"the file before"
        for _ in range(asked.kills):
            (folder / "a.lodc").write_bytes(old)
            child = subprocess.Popen(build(lodc, folder / "a.lodc"), stderr=subprocess.DEVNULL)
            time.sleep(seeded.uniform(0, 1.2 * whole))
            child.kill()
            child.wait()
            counts[state(folder, old, new)[0]] += 1
        run(build(lodc, folder / "a.lodc"), check=True)
        broken = counts["torn"] + len(state(folder, old, new)[1])
    print(f"kills: {asked.kills} in {whole:.3f} s: {counts}, {broken} torn or left behind")
    return broken


def faults(lodc, asked):
    """Lets the n-th call of the system fail, for each n until none fails."""
    if not shutil.which("strace"):
        print("faults: left out, there is no strace")
        return 0
    broken = 0
    with tempfile.TemporaryDirectory() as scratch:
        folder = pathlib.Path(scratch)
        run(build(lodc, folder / "a.lodc"), check=True)
        new, old = (folder / "a.lodc").read_bytes(), b"the file before"
        for call in CALLS:
            failed = passed = 0
            # The few calls that put a file into place all fail in turn, whatever is asked.
            every = asked.every if call in ("openat", "read") else 1
            first = random.Random(asked.seed).randint(1, every)
            for number in itertools.count(first, every):
                (folder / "a.lodc").write_bytes(old)
                log = folder / "log"
                trace = ["strace", "-f", "-qq", "-o", str(log), "-e", f"trace={call}"]
                trace += ["-e", f"inject={call}:error=EIO:when={number}"]
                ended = run(trace + build(lodc, folder / "a.lodc", "--jobs", "1"))
                reached = "INJECTED" in log.read_text(errors="replace")
                log.unlink()
                if not reached:
                    break
                there, left = state(folder, old, new)
                # A fault that does not matter ends with 0.
                status = ended.returncode
                if there != ("old" if status else "new") or left or status == 101:
                    print(f"faults: {call} {number}: status {status}, {there}, {left}")
                    print(ended.stderr.decode(errors="replace"))
                    broken += 1
                    for name in left:
                        (folder / name).unlink()
                passed += ended.returncode == 0
                failed += ended.returncode != 0
            counts = f"{failed} ended runs, {passed} did not matter"
            print(f"faults: {call}: {failed + passed} calls, {counts}")
    return broken


def determinism(lodc, asked):
    """Builds with other threads, time zones, languages and folders."""
    hashes, runs = {case: set() for case in SAME}, 0
    for _ in range(asked.repeats):
        for (mesh, options), jobs in itertools.product(SAME, (1, 2, 3, 8)):
            with tempfile.TemporaryDirectory() as folder:
                zone, language = PLACES[runs % len(PLACES)]
                around = os.environ | {"TZ": zone, "LANG": language, "LC_ALL": language}
                for program in [lodc, *asked.other]:
                    out, source = pathlib.Path(folder) / "a.lodc", ROOT / "fixtures" / mesh
                    words = build(program, out, "--jobs", str(jobs), *options.split(), mesh=source)
                    run(words, env=around, cwd=folder, check=True)
                    hashes[mesh, options].add(hashlib.sha256(out.read_bytes()).hexdigest())
                    runs += 1
    most = max(len(found) for found in hashes.values())
    programs = f"{1 + len(asked.other)} programs"
    print(f"determinism: {runs} builds by {programs}, {len(SAME)} assets, {most} hash of each")
    return most - 1


def sources(lodc, folder):
    """Small meshes: fixtures and, if there is one, the corpus; each as OBJ, too."""
    places = [ROOT / "fixtures", pathlib.Path(os.environ.get("LODC_CORPUS", "none"))]
    found = [p for place in places for p in sorted(place.rglob("*.*")) if p.is_file()]
    found = [p for p in found if p.suffix in (".glb", ".gltf", ".obj", ".ply", ".stl")]
    found = [p for p in found if p.stat().st_size <= SMALL_FILE and not p.name.startswith("x_")]
    texts = []
    for number, path in enumerate(found):
        text = folder / f"{number}.obj"
        words = [lodc, "extract", path, "--lod", "0", "--textures", "keep", "-o", text, "-q"]
        if not run(words + ["--limit", f"triangles={MOST}"]).returncode:
            texts.append(text)
    return found + 5 * texts


def damaged(text, seeded):
    """The text of an OBJ file with damage as scanners and scripts leave it."""
    lines = text.splitlines()
    points = [i for i, line in enumerate(lines) if line.startswith("v ")]
    faces = [i for i, line in enumerate(lines) if line.startswith("f ")]
    some = lambda all: seeded.sample(all, seeded.randint(0, 1 + len(all) // 8)) if all else []
    spike, axis = seeded.choice([1e-6, 0.01, 1.0]), seeded.randint(1, 3)
    flat = seeded.choice([0, 1e-4, 1, 1, 1, 50])
    for i in some(points):
        words = lines[i].split()
        words[axis] = str(float(words[axis]) + spike * (seeded.random() - 0.5))
        lines[i] = " ".join(words)
    for i in some(points):
        lines[i] = lines[seeded.choice(points)]
    for i in points:
        words = lines[i].split()
        words[axis] = str(float(words[axis]) * flat)
        lines[i] = " ".join(words)
    for i in some(faces):
        head, *corners = lines[i].split()
        lines[i] = " ".join([head, *reversed(corners)])
    for i in some(faces):
        lines[i] = ""
    return "\n".join(lines) + "\n"


def clean(lodc, asked):
    """Builds meshes, whole and damaged, with options; `verify` sees nothing wrong with them."""
    with tempfile.TemporaryDirectory() as scratch:
        folder = pathlib.Path(scratch)
        meshes = sources(lodc, folder)

        def one(number):
            """None if a mesh is refused, else whether `verify` is silent."""
            seeded = random.Random(f"{asked.seed} {number}")
            mesh, out = seeded.choice(meshes), folder / f"{number}.lodc"
            if mesh.parent == folder and seeded.random() < 0.9:
                text = damaged(mesh.read_text(), seeded)
                mesh = folder / f"damaged{number}.obj"
                mesh.write_text(text)
            weld = seeded.choice([[], [], ["--weld", "0.001"]])
            words = ["--metric", seeded.choice(METRICS), "--limit", f"triangles={MOST}", *weld]
            words += " ".join(seeded.sample(OPTIONS, seeded.randint(0, 2))).split()
            built = run([lodc, "build", mesh, "-o", out, "-q", "--jobs", "1", *words])
            if built.returncode:
                return None if built.returncode in (3, 5) else f"{words}: {built.stderr}"
            checked = run([lodc, "verify", out, "--source", mesh, "-q", "--jobs", "1", *weld])
            out.unlink()
            if not checked.returncode:
                return True
            kept = ROOT / f"target/alarm{number}{mesh.suffix}"
            shutil.copy(mesh, kept)
            return f"{mesh} ({kept}) {words}: {checked.stderr.decode(errors='replace')}"

        with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
            found, alarms, tried = 0, [], 0
            while found + len(alarms) < asked.files:
                more = range(tried, tried + asked.files - found - len(alarms))
                ended = list(pool.map(one, more))
                tried = more.stop
                found += ended.count(True)
                alarms += [end for end in ended if isinstance(end, str)]
    print(f"clean: {found} files of {tried} meshes pass `verify`, {len(alarms)} alarms", *alarms)
    return len(alarms)


def kinds(lodc, asked):
    """Compares what levels of many kinds of meshes state with a second evaluator: tests/kinds."""
    python = os.environ.get("LODC_PYTHON", sys.executable)
    words = [python, ROOT / "tests/kinds", lodc, *(["--short"] if asked.short else [])]
    if not asked.short:
        words += ["--csv", ROOT / "target/kinds.csv"]
    status = subprocess.run(words).returncode
    print(f"kinds: status {status}")
    return status


def wavy(path, triangles):
    """Writes a wavy square as PLY. Returns its triangles."""
    side = math.isqrt(triangles // 2)
    with path.open("wb") as out:
        head = f"ply\nformat binary_little_endian 1.0\nelement vertex {(side + 1) ** 2}\n"
        head += "property float x\nproperty float y\nproperty float z\n"
        head += f"element face {2 * side * side}\nproperty list uchar int vertex_indices\n"
        out.write(f"{head}end_header\n".encode())
        xs = [4 * i / side for i in range(side + 1)]
        waves = [math.sin(5 * x) for x in xs]
        for y, wave in zip(xs, waves):
            row = (v for x, other in zip(xs, waves) for v in (x, y, 0.1 * wave * other))
            out.write(array.array("f", row).tobytes())
        face = struct.Struct("<BiiiBiii").pack
        for y in range(side):
            low = range(y * (side + 1), y * (side + 1) + side)
            up = side + 1
            row = (face(3, a, a + 1, a + up, 3, a + up, a + 1, a + 1 + up) for a in low)
            out.write(b"".join(row))
    return 2 * side * side


def large(lodc, asked):
    """Builds a large mesh without models."""
    with tempfile.TemporaryDirectory() as scratch:
        mesh, out = pathlib.Path(scratch) / "wavy.ply", pathlib.Path(scratch) / "wavy.lodc"
        triangles = wavy(mesh, asked.large)
        before, began = resource.getrusage(resource.RUSAGE_CHILDREN), time.monotonic()
        words = [lodc, "build", mesh, "-o", out, "--models", "none", "--jobs", "1", "-v"]
        ended = subprocess.run(words).returncode
        wall, after = time.monotonic() - began, resource.getrusage(resource.RUSAGE_CHILDREN)
        used = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
        figures = f"{used:.0f} s of processor time ({wall:.0f} s), {after.ru_maxrss / 1024:.0f} MiB"
        size = out.stat().st_size / 1e6 if out.exists() else 0
    print(f"large: {triangles} triangles: {figures}, {size:.0f} MB file, status {ended}")
    return ended


def main():
    """Runs what is asked for."""
    usual = [kills, faults, determinism, clean, kinds]
    tests = {test.__name__: test for test in [*usual, large]}
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("lodc", type=lambda path: str(pathlib.Path(path).resolve()))
    same = "another build of the program, which gives the same bytes"
    parser.add_argument("--other", action="append", default=[], help=same)
    parser.add_argument("--only", default=",".join(test.__name__ for test in usual))
    parser.add_argument("--short", action="store_true", help="a tenth of it and less")
    parser.add_argument("--seed", type=int, default=random.randrange(1 << 32))
    parser.add_argument("--kills", type=int, default=1000)
    parser.add_argument("--every", type=int, default=1, help="each N-th openat and read fails")
    parser.add_argument("--repeats", type=int, default=20)
    parser.add_argument("--files", type=int, default=1000, help="clean files")
    parser.add_argument("--large", type=int, default=5_000_000, help="triangles")
    if "--short" in sys.argv:
        parser.set_defaults(**SHORT)
    asked = parser.parse_args()
    print(f"seed {asked.seed}", flush=True)
    sys.exit(sum(tests[name](asked.lodc, asked) for name in asked.only.split(",")) > 0)


main()
