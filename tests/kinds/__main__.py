"""What levels state, for many kinds of meshes, beside a second evaluator: `just campaign-kinds`.

python3 tests/kinds LODC [--kinds a,b] [--sizes 500,10000] [--ways file,direct,...] [--seed N]
    [--csv FILE] [--cache FOLDER] [--list]

Needs numpy and a C compiler. For each kind, size and level the file's curve, one level by itself,
refitted levels, chains and views are compared with what distance.c measures; files and levels have
to pass `verify` as they were written, and to be refused with other numbers; levels chosen by error
are compared with the coarsest ones that could have been. Ends with 1 if a bar is missed.
"""

import argparse
import csv
import json
import math
import multiprocessing
import os
import pathlib
import pickle
import subprocess
import sys
import tempfile
import time

sys.path.insert(0, str(pathlib.Path(__file__).parent))

import files
import kinds
from distance import Surface, measure

SHARES = [0.7, 0.5, 0.25, 0.15, 0.1, 0.05, 0.01, 0.004]
WAYS = ["file", "direct", "chain", "refit", "view", "injected", "choice"]
# At 100,000 triangles.
LARGE = [
    "closed_scan",
    "soup",
    "ground",
    "needles",
    "thin_shell",
    "hair",
    "tree",
    "high_valence",
    "own_quads",
    "wires",
]
# What `--short` does of it, with the smallest size.
SHORT = [
    "closed_scan",
    "soup",
    "own_quads",
    "thin_shell",
    "nested_spheres",
    "needles",
    "ground",
    "tiles",
    "hair",
    "wires",
]
INJECTED = [("error", 0.6), ("error", 2.2), ("rms", 0.7), ("rms", 1.4)]
COARSER = [1.05, 1.1, 1.15, 1.2, 1.3, 1.4, 1.5, 1.7, 2, 2.5, 3, 4, 6]
# Stated errors are bounds: a level that measures this much less than was asked for has to be found.
MARGIN = 1.06
VIEWS = [("silhouette", 0.5), ("pixels", None), ("sphere", 0.05)]
COLUMNS = ["kind", "size", "seed", "way", "level", "lod", "triangles", "error", "rms"]
COLUMNS += ["low", "high", "true_rms", "fault", "factor", "note"]
# This share of the size is nothing: what single precision leaves of stated numbers.
NOTHING = 3e-9


class Case:
    """One mesh: what is made of it, and what was found."""

    def __init__(self, asked, name, size, folder):
        self.asked, self.name, self.size, self.folder = asked, name, size, folder
        self.rows, self.known = [], {}
        positions, triangles, *more = kinds.make(name, size, asked.seed)
        self.mesh = folder / "in.ply"
        kinds.write(self.mesh, positions, triangles, *more)
        self.input = Surface(positions, triangles)
        self.diagonal = float(abs(positions.max(0) - positions.min(0)).max())
        self.cache = asked.cache and asked.cache / f"{self.input.key.hex()[:24]}.pickle"
        if self.cache and self.cache.exists():
            self.known = pickle.loads(self.cache.read_bytes())

    def row(self, way, level="", **found):
        self.rows.append(
            {
                "kind": self.name,
                "size": self.size,
                "seed": self.asked.seed,
                "way": way,
                "level": level,
                **found,
            }
        )
        return self.rows[-1]

    def lodc(self, *words):
        """Runs the program. Returns status, standard output, standard error, processor time."""
        words = [self.asked.lodc, *map(str, words)]
        with tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as err:
            child = subprocess.Popen(words, stdout=out, stderr=err, cwd=self.folder)
            ended, used = time.monotonic() + self.asked.patience, None
            while not used:
                pid, status, used = os.wait4(child.pid, os.WNOHANG)
                used = used if pid else None
                if not used and time.monotonic() > ended:
                    child.kill()
                time.sleep(0.002)
            child.returncode = os.waitstatus_to_exitcode(status)
            out.seek(0), err.seek(0)
            return child.returncode, out.read(), err.read().decode(errors="replace"), used.ru_utime

    def document(self, way, level, *words):
        """The JSON document of a run; None if it failed."""
        status, out, err, _ = self.lodc(*words, "--json", "-q", "--jobs", 1)
        if status:
            self.row(way, level, fault="fails", factor=math.inf, note=err.strip()[:200])
            return None
        return json.loads(out)

    def measured(self, surface):
        found = self.known.get(surface.key)
        if found is None:
            found = self.known[surface.key] = measure(self.input, surface)
        return found

    def is_more(self, a, b):
        return a > b + NOTHING * self.diagonal

    def is_flat(self, measured, stated):
        """Whether nothing was lost, and rounding is all that is stated."""
        return measured <= 1e-9 * self.diagonal and stated <= 2e-7 * self.diagonal

    def judge(self, row, finer, factor=1.5):
        """Compares what a level states with what was measured at it and at finer ones."""
        faults = []
        add = lambda name, ratio: faults.append((ratio, name))
        error, rms = row["error"], row["rms"]
        error, nothing = math.inf if error is None else error, NOTHING * self.diagonal
        if self.is_more(row["low"] / 1.05, error):
            add("error too small", row["low"] / max(error, nothing))
        # Where bounds stay apart, what was found is near: a quarter more is allowed for.
        far = max(m.low for m in finer)
        high = max(min(m.high, 1.25 * m.low + nothing) for m in finer)
        if self.is_more(error / factor, high) and not self.is_flat(far, error):
            add("error too large", error / max(high, nothing))
        if rms is None:
            add("no rms", math.inf)
        else:
            if self.is_more(row["true_rms"] / 1.1, rms):
                add("rms too small", row["true_rms"] / max(rms, nothing))
            most = max(m.rms for m in finer)
            if self.is_more(rms / 1.1, most) and not self.is_flat(most, rms):
                add("rms too large", rms / max(most, nothing))
        faults.sort(reverse=True)
        row["fault"] = "; ".join(name for _, name in faults)
        row["factor"] = max([ratio for ratio, _ in faults], default="")
        row["note"] = "; ".join(f"{name} x {ratio:.3g}" for ratio, name in faults)
        return faults

    def verify(self, way, *words):
        """`verify` accepts what was written."""
        status, out, err, used = self.lodc("verify", *words, "--json", "-q", "--jobs", 1)
        if status:
            said = [err.strip()[:200]] if status != 1 else []
            try:
                for file in json.loads(out)["files"]:
                    said += [
                        f"{pathlib.Path(file['file']).name}: {c['check']}: {c['first_difference']}"
                        for c in file["checks"]
                        if c["ok"] is False
                    ]
                    said += [file["error"]] if file["error"] else []
            except ValueError:
                pass
            self.row(way, "verify", fault="refused", factor=math.inf, note=" | ".join(said)[:400])
        return used

    def refused(self, what, *words):
        """`verify` refuses numbers that are not so."""
        status, out, err, _ = self.lodc("verify", *words, "--json", "-q", "--jobs", 1)
        if status == 1:
            self.row("injected", what)
        else:
            self.row("injected", what, fault="passed", factor=math.inf, note=f"status {status}")

    # Ways

    def build(self):
        """Builds the file, as it is timed."""
        self.file = self.folder / "a.lodc"
        words = [
            "build",
            self.mesh,
            "-o",
            self.file,
            "--models",
            "none",
            "--report",
            "json",
            "-q",
            "--jobs",
            1,
        ]
        status, out, err, used = self.lodc(*words)
        if status:
            self.row(
                "file",
                "build",
                fault="fails",
                factor=math.inf,
                note=f"{status} {err.strip()[:200]}",
            )
            return False
        stages = {s["name"]: s["seconds"] for s in json.loads(out)["inputs"][0]["stages"]}
        share = stages["errors"] / max(sum(stages.values()), 1e-9)
        checked = self.verify("file", self.file)
        self.row("time", "errors", error=share * used, note="seconds")
        self.row("time", "build", error=used, note="seconds")
        self.row("time", "verify", error=checked, note="seconds")
        self.sequence = files.Sequence(self.file)
        return True

    def level(self, way, share, surface, stated):
        """A row of a level."""
        m = self.measured(surface)
        numbers = {"low": m.low, "high": m.high, "true_rms": m.rms}
        if m.high > 1.03 * m.low:
            numbers["note"] = "measured within bounds only"
        return self.row(
            way, share, lod=stated["lod"], triangles=surface.count,
            error=math.inf if stated["error"] is None else stated["error"],
            rms=stated["rms"], **numbers,
        )  # fmt: skip

    def single(self, way, input, *words, shares=None):
        """Levels one by one."""
        finer, written = [], []
        for number, share in enumerate(shares or SHARES):
            out = self.folder / f"{way}{number}.glb"
            asked = ["--ratio", share] if share else []
            found = self.document(way, share, "extract", input, *asked, *words, "-o", out)
            if not found:
                continue
            surface = next(files.levels(out))
            row = self.level(way, share, surface, found)
            finer.append(self.measured(surface))
            if way == "refit":
                finer = finer[-1:]
            faults = self.judge(row, finer + self.finer.get(share, []))
            if faults and way == "file":
                self.file_origin(row, finer)
            if way == "file":
                self.stated[share] = (found["error"], found["rms"])
                self.finer[share] = list(finer)
            if way == "direct" and share in self.stated:
                self.agree(row, share)
            if way != "file":
                written.append(out)
        if written:
            self.verify(way, *written, "--source", self.mesh)

    def file_origin(self, row, finer):
        """A curve never falls: what it states may come from a finer level than those that were
        measured. Measures the levels where the numbers come from and judges again."""
        s = self.sequence
        for numbers, stated in ((s.errors, row["error"]), (s.rms, row["rms"])):
            if stated is None or not math.isfinite(stated):
                continue
            finer.append(self.origin(numbers, stated))
        self.judge(row, finer)

    def origin(self, numbers, stated):
        """The first level that states a number of the file's curve."""
        step = int((numbers >= stated * 0.9999).argmax())
        return self.measured(self.sequence.surface(step))

    def agree(self, row, share):
        """File and direct agree within 1.1 x, where neither has a reason to differ: the larger
        numbers of finer levels count for the file."""
        error, rms = self.stated[share]
        s = self.sequence
        pairs = (("error", error, row["error"], s.errors), ("rms", rms, row["rms"], s.rms))
        for name, a, b, curve in pairs:
            if a is None or b is None or not math.isfinite(b):
                continue
            least, most = sorted((a, b))
            if not self.is_more(most / 1.1, least):
                continue
            # What the file states is the largest of the finer levels as well.
            key = "low" if name == "error" else "rms"
            earlier = max(getattr(m, key) for m in [*self.finer[share], self.origin(curve, a)])
            # Coordinates in single precision are rounded by that much.
            if most <= 1e-7 * self.diagonal:
                continue
            if a == most and not self.is_more(a / 1.1, max(earlier, b)):
                continue
            self.row(
                "agree",
                share,
                error=a,
                rms=b,
                fault=f"{name}: file and direct differ",
                factor=most / max(least, 1e-30),
            )

    def file_way(self):
        self.single("file", self.file, "--no-refit")

    def direct_way(self):
        self.single("direct", self.mesh, "--no-refit")

    def refit_way(self):
        self.single("refit", self.file)

    def chain_way(self):
        """A chain of all levels."""
        out = self.folder / "chain.glb"
        shares = ",".join(f"{100 * share:g}%" for share in SHARES)
        found = self.document("chain", "", "chain", self.mesh, "--levels", shares, "-o", out)
        if not found:
            return
        finer = []
        for share, stated, surface in zip(SHARES, found["levels"], files.levels(out)):
            row = self.level("chain", share, surface, stated)
            finer.append(self.measured(surface))
            self.judge(row, finer + self.finer.get(share, []))
        self.verify("chain", out, "--source", self.mesh)
        if "injected" in self.asked.ways:
            for name, factor in self.injected(finer):
                changed = self.folder / "changed.glb"
                files.with_numbers(out, changed, **{name: factor})
                self.refused(f"chain {name} x {factor}", changed, "--source", self.mesh)

    def view_way(self):
        """Views: the eye stands beside the mesh."""
        low, high = (getattr(self.input.corners.reshape(-1, 3), side)(0) for side in ("min", "max"))
        eye = ",".join(f"{x:.9g}" for x in high + 0.4 * (high - low))
        target = ",".join(f"{x:.9g}" for x in low + 0.3 * (high - low))
        written = []
        for criterion, share in VIEWS:
            out = self.folder / f"{criterion}.glb"
            words = ["--criterion", criterion]
            words += ["--target", target] if criterion == "sphere" else ["--eye", eye]
            words += ["--pixels", 3] if criterion == "pixels" else ["--ratio", share]
            found = self.document("view", criterion, "extract", self.file, *words, "-o", out)
            if not found:
                continue
            surface = next(files.levels(out))
            row = self.level("view", criterion, surface, found)
            self.judge(row, [self.measured(surface)])
            written.append(out)
        if written:
            self.verify("view", *written, "--source", self.mesh)

    def injected(self, measured):
        """What is injected into levels: no mean distances where all are negligible, as below a
        millionth of the size."""
        is_seen = max(m.rms for m in measured) > 1e-5 * self.diagonal
        return [(name, factor) for name, factor in INJECTED if is_seen or name != "rms"]

    def injected_way(self):
        """`verify` refuses curves with other numbers."""
        for name, factor in self.injected(self.finer[SHARES[0]]):
            out = self.folder / "injected.lodc"
            moved = files.injected(self.file, out, **{name: factor})
            # A mean distance is never above the largest: nothing was injected then.
            if name == "error" or factor < 1 or moved > 1.2:
                self.refused(f"{name} x {factor}", out)

    def choice_way(self):
        """`--error` and `--rms` choose levels that keep to it and are hardly finer than needed."""
        s, found = self.sequence, []
        for share in SHARES:
            found.append(self.measured(s.surface(s.step(int(share * self.input.count)))))
        for name, key, slack in (("error", "high", 1.05), ("rms", "rms", 1.1)):
            values = [max(getattr(m, key) for m in found[: k + 1]) for k in range(len(found))]
            for a, b in ((1, 2), (4, 5), (5, 6)):
                if not (0 < values[a] and math.isfinite(values[b])):
                    continue
                wanted = math.sqrt(values[a] * values[b])
                if wanted < 100 * NOTHING * self.diagonal:
                    continue
                out = self.folder / "choice.glb"
                level = f"{name} {a}"
                chosen = self.document(
                    "choice", level, "extract", self.file, f"--{name}", wanted, "-o", out
                )
                if not chosen:
                    continue
                surface = next(files.levels(out))
                m = self.measured(surface)
                count = chosen["triangles"]
                best = self.coarsest(count, wanted / MARGIN, "low" if name == "error" else "rms")
                beyond, loose = (m.low if name == "error" else m.rms) / wanted, count / best
                faults = []
                if beyond > slack:
                    faults.append("chosen level is beyond")
                if loose > 1.5 and count - best > 8:
                    faults.append("chosen level is too fine")
                self.row(
                    "choice", level, lod=chosen["lod"], triangles=count, error=wanted,
                    low=m.low, high=m.high, true_rms=m.rms, fault="; ".join(faults),
                    factor=beyond if beyond > slack else loose, note=f"{best} triangles would do",
                )  # fmt: skip

    def coarsest(self, count, wanted, key):
        """The triangles of the coarsest level that keeps to a distance as all finer ones do: level
        by level at first, then by shares."""
        s, best = self.sequence, count
        fewer = [c for c in sorted(set(s.counts.tolist()), reverse=True) if 0 < c < count]
        for triangles in fewer[:8] + [int(count / more) for more in COARSER]:
            if not 0 < triangles < best:
                continue
            step = s.step(triangles)
            if s.counts[step] < 1 or getattr(self.measured(s.surface(step)), key) > wanted:
                break
            best = int(s.counts[step])
        return best

    def run(self):
        self.stated, self.finer = {}, {}
        if self.build():
            for way in WAYS:
                if way in self.asked.ways:
                    getattr(self, f"{way}_way")()
        if self.cache:
            self.cache.write_bytes(pickle.dumps(self.known))
        return self.rows


def one(job):
    """Runs a case in a process of its own."""
    asked, name, size = job
    began = time.monotonic()
    with tempfile.TemporaryDirectory(prefix="lodc-kinds-") as folder:
        case = Case(asked, name, size, pathlib.Path(folder))
        try:
            rows = case.run()
        except Exception as wrong:
            case.row("campaign", fault="broken", factor=math.inf, note=repr(wrong)[:300])
            rows = case.rows
            if asked.debug:
                raise
    return name, size, rows, time.monotonic() - began


def times(rows):
    """Rows for kinds whose errors take longer than bars allow."""
    of = {(r["kind"], r["size"], r["level"]): r["error"] for r in rows if r["way"] == "time"}
    for (name, size, stage), seconds in list(of.items()):
        if stage == "errors":
            scan = of.get(("closed_scan", size, "errors"))
            bar, what = scan and max(4 * scan, 0.05), "errors beyond 4 x a scan's"
        elif stage == "verify":
            bar, what = max(3 * of[name, size, "build"], 0.1), "verify beyond 3 x the build"
        else:
            continue
        if bar and seconds > bar:
            unit = scan if stage == "errors" else of[name, size, "build"]
            rows.append(
                {
                    "kind": name,
                    "size": size,
                    "way": "time",
                    "level": stage,
                    "error": seconds,
                    "fault": what,
                    "factor": seconds / max(unit, 1e-3),
                }
            )


def write(path, rows):
    """Writes all cells as CSV."""
    if path:
        with path.open("w", newline="") as out:
            table = csv.DictWriter(out, COLUMNS)
            table.writeheader()
            table.writerows(rows)


def summary(rows, worst):
    """The cells that miss a bar, the worst of each fault first."""
    bad = [r for r in rows if r.get("fault")]
    by = {}
    for r in bad:
        for fault in r["fault"].split("; "):
            by.setdefault((r["way"], fault), []).append(r)
    levels = sum(r["way"] in WAYS for r in rows)
    print(
        f"{levels} cells of {len({(r['kind'], r['size']) for r in rows})} meshes, "
        f"{len(bad)} beyond a bar"
    )
    for (way, fault), cells in sorted(by.items()):
        cells.sort(key=lambda r: -r["factor"])
        print(f"\n{way}: {fault}: {len(cells)} cells of {len({r['kind'] for r in cells})} kinds")
        for r in cells[:worst]:
            numbers = "  ".join(
                f"{k} {r[k]:.4g}"
                for k in ("error", "rms", "low", "true_rms")
                if isinstance(r.get(k), float)
            )
            print(
                f"  {r['kind']:16} {r['size']:6} {r['level']!s:14} x {r['factor']:.3g}  {numbers}  "
                f"{r.get('note', '')}"
            )
    loose = sorted(r["factor"] for r in rows if r["way"] == "choice" and "beyond" not in r["fault"])
    if loose:
        print(
            f"\nchoices: triangles x {loose[len(loose) // 2]:.3g} in the median, "
            f"x {loose[-1]:.3g} at worst"
        )
    return bad


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("lodc", nargs="?", default="target/release/lodc")
    parser.add_argument("--kinds", default=",".join(kinds.KINDS))
    parser.add_argument("--sizes", default="500,10000,100000")
    parser.add_argument("--ways", default=",".join(WAYS))
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    parser.add_argument(
        "--patience", type=float, default=300, help="seconds for one run of the program"
    )
    parser.add_argument("--worst", type=int, default=5, help="cells shown of each fault")
    parser.add_argument("--csv", type=pathlib.Path)
    parser.add_argument("--cache", type=pathlib.Path, help="folder that keeps what was measured")
    parser.add_argument("--debug", action="store_true")
    parser.add_argument("--short", action="store_true", help="ten kinds of 500 triangles")
    parser.add_argument("--list", action="store_true")
    asked = parser.parse_args()
    if asked.short:
        asked.kinds, asked.sizes = ",".join(SHORT), "500"
    if asked.list:
        sys.exit(print(*kinds.KINDS, sep="\n"))
    asked.lodc = str(pathlib.Path(asked.lodc).resolve())
    asked.ways = asked.ways.split(",")
    if asked.cache:
        asked.cache.mkdir(parents=True, exist_ok=True)
    names, sizes = asked.kinds.split(","), [int(size) for size in asked.sizes.split(",")]
    is_all = asked.kinds == parser.get_default("kinds")
    jobs = [
        (asked, name, size)
        for size in sorted(sizes, reverse=True)
        for name in names
        if size < 50000 or not is_all or name in LARGE
    ]
    if asked.short:
        # What only large meshes meet: built and verified.
        jobs.insert(0, (argparse.Namespace(**vars(asked) | {"ways": []}), "ground", 100000))
    os.nice(5)
    rows, began = [], time.monotonic()
    with multiprocessing.Pool(asked.jobs, maxtasksperchild=20) as pool:
        for name, size, found, took in pool.imap_unordered(one, jobs):
            rows += found
            faults = sum(bool(r.get("fault")) for r in found)
            print(f"{name} {size}: {took:.1f} s, {faults} beyond", file=sys.stderr, flush=True)
            write(asked.csv, rows)
    # The short run is part of tests, which look at no clock.
    if not asked.short:
        times(rows)
    write(asked.csv, rows)
    bad = summary(rows, asked.worst)
    print(f"{time.monotonic() - began:.0f} s")
    sys.exit(bool(bad))


if __name__ == "__main__":
    main()
