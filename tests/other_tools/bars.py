"""Bars on the time that lodc takes, beside gltfpack and others: `just other-tools` without a mesh.

Every number is processor time of whole processes on one core, the least of some turns in which all
commands take their place; simplification alone is timed inside its process. Models are made by
`models.py`. A bar that needs an older lodc is left out without `--base PROGRAM`."""

import argparse
import glob
import json
import os
import platform
import shutil
import subprocess
import sys
import tempfile
from importlib import metadata

import models
import numpy as np

LEVELS = ("1", "0.5", "0.25", "0.1")
SIMPLIFY = os.path.join(os.path.dirname(os.path.abspath(__file__)), "simplify.mjs")


def seconds(command):
    """Processor time of a command and its children."""
    quiet = subprocess.DEVNULL
    process = subprocess.Popen(command, stdout=quiet, stderr=quiet)
    _, status, used = os.wait4(process.pid, 0)
    if status:
        sys.exit(f"{command} failed")
    return used.ru_utime + used.ru_stime


def least(turns, jobs):
    """For each named list of commands the least time that it took together."""
    best = dict.fromkeys(jobs, float("inf"))
    for _ in range(turns):
        for name, commands in jobs.items():
            best[name] = min(best[name], sum(map(seconds, commands)))
    return best


def words(command):
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


def packers(folder, native):
    """Programs named gltfpack, by what they are: from npm, and a native one."""
    found = {}
    script = os.path.join(folder, "node_modules/gltfpack/cli.js")
    if shutil.which("node") and os.path.exists(script):
        found["npm"] = ["node", script]
    native = native or shutil.which("gltfpack")
    if native:
        found["native"] = [native]
    return found


class Lodc:
    """Commands of one program; all on one thread."""

    def __init__(self, program, folder):
        self.program, self.folder = program, folder

    def extract(self, source, *more):
        out = os.path.join(self.folder, "level.glb")
        words = ["--ratio", "10%", "--no-refit", "-o", out, "-q", *more]
        return [self.program, "extract", source, *words]

    def chain(self, source):
        return [self.program, "chain", source, "-o", os.path.join(self.folder, "chain.glb"), "-q"]

    def build(self, source, *more):
        out = os.path.join(self.folder, "mesh.lodc")
        return [self.program, "build", source, "-o", out, "-q", *more]

    def verify(self):
        return [self.program, "verify", os.path.join(self.folder, "mesh.lodc"), "-q"]

    def stages(self, source):
        report = words([*self.build(source, "--models", "none"), "--report", "json"])
        return {s["name"]: s["seconds"] for s in json.loads(report)["inputs"][0]["stages"]}


def pack(gltfpack, source, folder, ratio="0.1"):
    out = os.path.join(folder, "packed.glb")
    return [*gltfpack, "-si", ratio, "-se", "1", "-i", source, "-o", out]


def row(what, value, bar, note=""):
    verdict = "met" if value <= bar else "MISSED"
    print(f"{what:52} {value:7.2f} {bar:7.2f}  {verdict:6} {note}", flush=True)


def beside_gltfpack(lodc, tools, start, given, at):
    """One level and chains, and many small assets, against gltfpack."""
    extract = {"textured": 1.5, "scan": 2.0, "scene": 3.0}
    chain = {"scan": 1.0, "scene": 2.0}
    jobs = {}
    for kind in extract:
        source = at(kind + ".glb")
        jobs["extract", kind, "lodc"] = [lodc.extract(source)]
        for name, tool in tools.items():
            jobs["extract", kind, name] = [pack(tool, source, lodc.folder)]
    for kind in chain:
        source = at(kind + ".glb")
        jobs["chain", kind, "lodc"] = [lodc.chain(source)]
        for name, tool in tools.items():
            jobs["chain", kind, name] = [pack(tool, source, lodc.folder, r) for r in LEVELS]
    best = least(given.turns, jobs)
    small = sorted(glob.glob(at("small/*.*")))
    # Once: many runs are their own mean.
    best |= least(
        1,
        {
            ("extract", "small", "lodc"): [lodc.extract(f) for f in small],
            ("build", "small", "lodc"): [lodc.build(f, "--models", "none") for f in small],
            **{
                ("extract", "small", n): [pack(t, f, lodc.folder) for f in small]
                for n, t in tools.items()
            },
        },
    )
    bars = [("extract", kind, bar, 1) for kind, bar in extract.items()]
    bars += [("chain", kind, bar, len(LEVELS)) for kind, bar in chain.items()]
    bars += [("extract", "small", 1.5, len(small)), ("build", "small", 3.0, len(small))]
    for job, kind, bar, runs in bars:
        own = best[job, kind, "lodc"]
        for name in tools:
            tool = best["extract" if kind == "small" else job, kind, name]
            note = f"{own:.3f} s, {tool:.3f} s"
            row(f"{job}, {kind} / gltfpack ({name})", own / tool, bar, note)
            if name == "npm":
                less = tool - runs * start
                row(f"{job}, {kind} / gltfpack (npm, less node)", own / less, bar)


def beside_itself(lodc, base, given, at):
    """Metrics and stages against each other, and an older program."""
    textured, scan = at("textured.glb"), at("scan.glb")
    whole = lambda metric: lodc.build(textured, "--models", "none", "--metric", metric)
    level = lambda metric: lodc.extract(textured, "--metric", metric)
    metrics = ("hybrid", "quadric")
    jobs = {("all", m): [whole(m)] for m in metrics} | {("one", m): [level(m)] for m in metrics}
    best = least(given.turns, jobs)
    row("hybrid / quadric, all levels", best["all", "hybrid"] / best["all", "quadric"], 10)
    row("hybrid / quadric, one level", best["one", "hybrid"] / best["one", "quadric"], 6)
    for kind, bar in (("textured", 3.0), ("scene", 3.0), ("scan", 1.4)):
        runs = [lodc.stages(at(kind + ".glb")) for _ in range(given.turns)]
        times = {stage: min(run[stage] for run in runs) for stage in ("errors", "simplify")}
        row(f"errors / simplify, {kind}", times["errors"] / times["simplify"], bar)
    if base:
        best = least(
            given.turns,
            {
                "base": [base.build(scan, "--metric", "quadric")],
                "build": [lodc.build(scan)],
                "verify": [lodc.verify()],
            },
        )
        row("build of all models, scan / older lodc", best["build"] / best["base"], 0.65)
        row("verify, scan / older lodc's build", best["verify"] / best["base"], 1.5)


def simplification(lodc, given, at):
    """Simplification alone: lodc to all levels, others to 10 %."""
    points, _, _, faces = models.scan()
    print(f"\nsimplification alone, {len(faces):,} triangles: lodc to all levels, others to 10 %")
    runs = [lodc.stages(at("scan.glb"))["simplify"] for _ in range(given.turns)]
    print(f"  lodc {min(runs):.3f} s")
    raw = at("scan.bin")
    with open(raw, "wb") as out:
        out.write(np.array([len(points), len(faces)], "<u4").tobytes())
        out.write(points.astype("<f4").tobytes() + faces.astype("<u4").tobytes())
    if os.path.exists(os.path.join(given.npm, "node_modules/meshoptimizer")):
        said = words(["node", SIMPLIFY, given.npm, raw, str(given.turns)])
        print(f"  meshoptimizer {said.strip()}")
    try:
        import time

        import fast_simplification

        best = float("inf")
        for _ in range(given.turns):
            begun = time.process_time()
            fast_simplification.simplify(points, faces.astype(np.int32), target_reduction=0.9)
            best = min(best, time.process_time() - begun)
        version = metadata.version("fast-simplification")
        print(f"  fast-simplification {version}: {best:.3f} s")
    except ImportError as why:
        print(f"  fast-simplification is left out: {why}")


def main():
    told = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    told.add_argument("--lodc", default="target/release/lodc", help="the program")
    told.add_argument("--base", help="an older program, for bars on its times")
    told.add_argument("--npm", default="target/other_tools", help="folder with node_modules")
    told.add_argument("--gltfpack", help="a native gltfpack, if it is not on the path")
    told.add_argument("--turns", type=int, default=3, help="turns, of which the least counts")
    given = told.parse_args()
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})
    shared = "/dev/shm" if os.path.isdir("/dev/shm") else None
    with tempfile.TemporaryDirectory(dir=shared) as folder:
        at = lambda name: os.path.join(folder, name)
        models.write_all(folder)
        lodc = Lodc(given.lodc, folder)
        tools = packers(given.npm, given.gltfpack)
        start = min(seconds(["node", "-e", "0"]) for _ in range(5)) if "npm" in tools else 0.0
        print(f"{words([given.lodc, '--version']).strip()}, {platform.machine()}, one core")
        for name, tool in tools.items():
            said = subprocess.run([*tool, "-v"], capture_output=True, text=True, check=False)
            print(f"{name}: {(said.stdout or said.stderr).strip().splitlines()[0]}")
        print(f"node starts in {start:.3f} s\n\n{'':52} {'ratio':>7} {'bar':>7}")
        beside_gltfpack(lodc, tools, start, given, at)
        beside_itself(lodc, given.base and Lodc(given.base, folder), given, at)
        simplification(lodc, given, at)


if __name__ == "__main__":
    main()
