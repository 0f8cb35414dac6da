"""Long tests of the program as a process, with figures: `just campaign`.

campaign.py LODC [--only kills,faults,determinism,sbom] [--kills N] [--repeats N]

Prints a line of figures for each, and ends with 1 if a promise of docs/RELIABILITY.md was broken.
Faults need strace.
"""
import argparse
import hashlib
import json
import os
import pathlib
import random
import shutil
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent
SMALL = ROOT / "fixtures/machine_part.glb"
PLACES = [("UTC", "C"), ("Asia/Tokyo", "de_DE.UTF-8"), ("America/Lima", "tr_TR.UTF-8")]
CALLS = ["openat", "read", "write", "fsync", "rename", "flock"]


def run(command, **more):
    """A run of the program, without what it prints."""
    kept = {"stdout": subprocess.DEVNULL, "stderr": subprocess.PIPE}
    return subprocess.run(command, timeout=120, **kept, **more)


def build(lodc, out, *more):
    """The words of a build."""
    return [lodc, "build", str(SMALL), "-o", str(out), "-q", *more]


def state(folder, old, new):
    """Which file is there, and what is left besides; a torn file is neither."""
    content = (folder / "a.lodc").read_bytes()
    left = [path.name for path in folder.iterdir() if path.name != "a.lodc"]
    return {old: "old", new: "new"}.get(content, "torn"), left


def kills(lodc, asked):
    """Kills builds over an old file at seeded moments."""
    seeded, counts, broken = random.Random(7), {"old": 0, "new": 0, "torn": 0}, 0
    with tempfile.TemporaryDirectory() as scratch:
        folder = pathlib.Path(scratch)
        began = time.monotonic()
        run(build(lodc, folder / "a.lodc"), check=True)
        whole = time.monotonic() - began
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
            failed = passed = number = 0
            while True:
                number += 1
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
            print(f"faults: {call}: {number - 1} calls, {counts}")
    return broken


def determinism(lodc, asked):
    """Builds with other threads, time zones, languages and folders."""
    hashes, runs = set(), 0
    for repeat in range(asked.repeats):
        for jobs in (1, 2, 3, 8):
            with tempfile.TemporaryDirectory() as folder:
                zone, language = PLACES[runs % len(PLACES)]
                around = os.environ | {"TZ": zone, "LANG": language, "LC_ALL": language}
                for program in [lodc, *asked.other]:
                    out = pathlib.Path(folder) / "a.lodc"
                    words = build(program, out, "--jobs", str(jobs))
                    run(words, env=around, cwd=folder, check=True)
                    hashes.add(hashlib.sha256(out.read_bytes()).hexdigest())
                    runs += 1
    print(f"determinism: {runs} builds by {1 + len(asked.other)} programs, {len(hashes)} hash")
    return len(hashes) - 1


def sbom(_, asked):
    """A CycloneDX list of the packages that the program is built from."""
    words = ["cargo", "metadata", "--format-version", "1", "--locked", "--offline"]
    found = json.loads(subprocess.run(words, stdout=subprocess.PIPE, check=True, cwd=ROOT).stdout)
    nodes = {node["id"]: node for node in found["resolve"]["nodes"]}
    waiting = [p["id"] for p in found["packages"] if p["name"] == "lodc-cli"]
    inside = set()
    while waiting:
        package = waiting.pop()
        if package in inside:
            continue
        inside.add(package)
        # What only tests need is not in the program.
        is_needed = lambda d: any(kind["kind"] != "dev" for kind in d["dep_kinds"])
        waiting += [d["pkg"] for d in nodes[package]["deps"] if is_needed(d)]
    parts = [
        {
            "type": "library",
            "name": p["name"],
            "version": p["version"],
            "purl": f"pkg:cargo/{p['name']}@{p['version']}",
            "licenses": [{"expression": p["license"]}] if p["license"] else [],
        }
        for p in sorted(found["packages"], key=lambda p: (p["name"], p["version"]))
        if p["id"] in inside
    ]
    bom = {"bomFormat": "CycloneDX", "specVersion": "1.5", "version": 1, "components": parts}
    asked.sbom.parent.mkdir(parents=True, exist_ok=True)
    asked.sbom.write_text(json.dumps(bom, indent=1) + "\n")
    nameless = sum(not part["licenses"] for part in parts)
    print(f"sbom: {len(parts)} packages in {asked.sbom}, {nameless} without a licence")
    return nameless


def main():
    """Runs what is asked for."""
    tests = {"kills": kills, "faults": faults, "determinism": determinism, "sbom": sbom}
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("lodc", type=lambda path: str(pathlib.Path(path).resolve()))
    same = "another build of the program, which gives the same bytes"
    parser.add_argument("--other", action="append", default=[], help=same)
    parser.add_argument("--only", default=",".join(tests))
    parser.add_argument("--kills", type=int, default=1000)
    parser.add_argument("--repeats", type=int, default=20)
    parser.add_argument("--sbom", type=pathlib.Path, default=ROOT / "target/lodc.cdx.json")
    asked = parser.parse_args()
    sys.exit(sum(tests[name](asked.lodc, asked) for name in asked.only.split(",")) > 0)


main()
