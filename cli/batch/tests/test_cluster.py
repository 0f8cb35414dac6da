"""Schedulers and workers on this machine: 200 assets, three of them poison, one too large, and a
worker that is killed in the middle; two runs on one scheduler. `LODC` names the program."""

import json
import os
import signal
import subprocess
import sys
import tempfile
import threading
import unittest
from dataclasses import replace
from pathlib import Path

from lodc_batch import ClusterError, build, read_list
from lodc_batch.__main__ import main
from lodc_batch.cluster import summary
from lodc_batch.tasks import content_key

LODC = os.environ["LODC"]
MEM = 200 << 20


def grid(n, seed):
    """Returns an OBJ of 2 n² triangles."""
    rows = range(n + 1)
    height = lambda x, y: (x * 7 + y * 13 + seed * 31) % 11 / 40
    points = [f"v {x} {y} {height(x, y)}" for y in rows for x in rows]
    at = lambda x, y: y * (n + 1) + x + 1
    cells = [(x, y) for y in range(n) for x in range(n)]
    faces = [
        f"f {at(x, y)} {at(x + 1, y)} {at(x + 1, y + 1)} {at(x, y + 1)}" for x, y in cells
    ]
    return "\n".join(points + faces) + "\n"


class Cluster:
    """A scheduler and workers on the loopback interface."""

    def __init__(self, folder, workers):
        self.file = str(folder / "cluster.json")
        host = ["--host", "127.0.0.1"]
        self.log = log = open(folder / "cluster.log", "w")
        dask = [sys.executable, "-m", "dask"]
        start = lambda *args: subprocess.Popen([*dask, *args], stdout=log, stderr=log, cwd=folder)
        scheduler = ["--port", "0", "--no-dashboard", "--scheduler-file", self.file]
        self.processes = [start("scheduler", *host, *scheduler)]
        options = ["--scheduler-file", self.file, "--nthreads", "1", "--no-nanny", *host]
        options += ["--resources", f"MEM={MEM}", "--no-dashboard", "--local-directory", str(folder)]
        self.processes += [start("worker", *options) for _ in range(workers)]

    def kill_a_worker(self):
        self.processes[1].send_signal(signal.SIGKILL)

    def stop(self):
        for process in reversed(self.processes):
            process.kill()
            process.wait()
        self.log.close()


class Batch(unittest.TestCase):
    def setUp(self):
        self.folder = Path(tempfile.mkdtemp(prefix="lodc-batch-")).resolve()
        os.chdir(self.folder)

    def assets(self):
        """200 assets: 196 good, two malformed, one that ends its process, one too large."""
        (self.folder / "in").mkdir()
        names = []
        for number in range(200):
            name = f"in/{number:03}.obj"
            text = grid(3 + number % 9, number)
            if number in (20, 90):
                text = "v 0 0 0\nf 1 2 3\n"
            if number == 50:
                text += "# kill\n"
            if number == 150:
                text = grid(750, number)
            Path(name).write_text(text)
            names.append(name)
        options = {"models": "interactive"}
        lines = [json.dumps({"input": name, "options": options}) for name in names]
        Path("list.jsonl").write_text("\n".join(lines))

    def wrapper(self):
        """A program that is ended by the system for one input, as if it had taken all memory."""
        path = self.folder / "lodc-or-die"
        path.write_text(
            "#!/bin/sh\nline=$(cat)\n"
            'case "$line" in *050.obj*) kill -9 $$;; esac\n'
            f'printf "%s" "$line" | exec "{LODC}" "$@"\n'
        )
        path.chmod(0o755)
        return str(path)

    def test_poison_and_a_lost_worker_cost_nobody_else(self):
        self.assets()
        serial = [LODC, "build", "--manifest", "list.jsonl", "-o", "serial", "-q", "--jobs", "1"]
        subprocess.run(serial, capture_output=True)
        cluster = Cluster(self.folder, 3)
        killed = threading.Event()

        def on_result(done, _of, _line):
            if done == 40 and not killed.is_set():
                cluster.kill_a_worker()
                killed.set()

        try:
            tasks = read_list("list.jsonl")
            lines = build(tasks, cluster.file, self.wrapper(), "out", (), on_result)
        finally:
            cluster.stop()
        self.assertTrue(killed.is_set())
        self.assertEqual([line["input"] for line in lines], [task.input for task in tasks])
        self.assertEqual(summary(lines), {"built": 196, "up_to_date": 0, "failed": 4})
        failed = {line["input"]: line["status"] for line in lines if line["status"]}
        expected = {"in/020.obj": 3, "in/050.obj": 70, "in/090.obj": 3, "in/150.obj": 5}
        self.assertEqual(failed, expected)
        there = sorted(str(p.relative_to("out")) for p in Path("out").rglob("*") if p.is_file())
        good = [task.input for task in tasks if task.input not in expected]
        self.assertEqual(there, [f"{name}.lodc" for name in good], "and no temporary file")
        for name in there:
            files = [Path(folder, name).read_bytes() for folder in ("out", "serial")]
            self.assertEqual(*files)

    def test_an_asset_that_needs_more_than_was_estimated_gets_a_whole_worker(self):
        tasks = self.meshes("in", 0)
        program = self.folder / "lodc-underestimates"
        # Says that everything needs 70 MiB; refuses to build the third mesh in less than 150 MB.
        program.write_text(
            f"""#!{sys.executable}
import json, subprocess, sys
lines = "" if "--version" in sys.argv else sys.stdin.read()
if "--estimate" in sys.argv:
    inputs = [{{"memory": 70 << 20}} for line in lines.splitlines()]
    print(json.dumps({{"inputs": inputs}}))
    sys.exit(0)
limit = [int(a.split("=")[1]) for a in sys.argv if a.startswith("memory=")]
with open("limits", "a") as file:
    file.write(f"{{limit}}\\n" if "3.obj" in lines else "")
if "3.obj" in lines and limit[0] < 150e6:
    report = {{"input": "in/3.obj", "output": "", "status": 5}}
    report["error"] = "in/3.obj: may need more memory (--limit memory=SIZE)"
    print(json.dumps({{"inputs": [{{**report, "up_to_date": False, "seconds": 0}}]}}))
    sys.exit(5)
sys.exit(subprocess.run([{LODC!r}, *sys.argv[1:]], input=lines, text=True).returncode)
"""
        )
        program.chmod(0o755)
        cluster = Cluster(self.folder, 2)
        try:
            lines = build(tasks, cluster.file, str(program), "out")
        finally:
            cluster.stop()
        self.assertEqual(summary(lines), {"built": 6, "up_to_date": 0, "failed": 0})
        limits = Path("limits").read_text().splitlines()
        self.assertEqual(limits, [f"[{70 << 20}]", f"[{MEM}]"])

    def test_an_asset_that_takes_too_much_time_is_not_tried_again(self):
        self.meshes("in", 0)
        late = {"input": "in/2.obj", "options": {"limit": "time=0s"}}
        lines = Path("in.jsonl").read_text().splitlines()
        Path("in.jsonl").write_text("\n".join([*lines[:2], json.dumps(late), *lines[3:]]))
        program = self.folder / "lodc-counts"
        program.write_text(
            "#!/bin/sh\nlines=$(cat)\n"
            'case "$lines $*" in *--estimate*) ;; *2.obj*) echo >> runs;; esac\n'
            f'printf "%s" "$lines" | exec "{LODC}" "$@"\n'
        )
        program.chmod(0o755)
        cluster = Cluster(self.folder, 2)
        try:
            lines = build(read_list("in.jsonl"), cluster.file, str(program), "out")
        finally:
            cluster.stop()
        self.assertEqual([line["status"] for line in lines], [0, 0, 5, 0, 0, 0])
        self.assertIn("--limit time=", lines[2]["error"])
        self.assertEqual(Path("runs").read_text(), "\n", "it ran once")

    def test_what_is_not_there_is_said_in_a_line_within_the_time(self):
        tasks = self.meshes("in", 0)
        asked = lambda scheduler, lodc=LODC, options=(), seconds=3: build(
            tasks, scheduler, lodc, "out", options, timeout=seconds
        )
        with self.assertRaisesRegex(ClusterError, "no.json: no scheduler wrote this file"):
            asked("no.json", seconds=0.2)
        with self.assertRaisesRegex(ClusterError, "no scheduler answers within 2 s"):
            asked("tcp://127.0.0.1:9", seconds=2)
        with self.assertRaisesRegex(ClusterError, "DASK_SCHEDULER_ADDRESS"):
            asked(None)
        cluster = Cluster(self.folder, 0)
        try:
            with self.assertRaisesRegex(ClusterError, "no worker came within 5 s"):
                asked(cluster.file, seconds=5)
        finally:
            cluster.stop()
        Path("cluster.json").unlink()
        cluster = Cluster(self.folder, 1)
        try:
            with self.assertRaisesRegex(ClusterError, "`no-lodc` cannot be run there: No such"):
                asked(cluster.file, "no-lodc", seconds=30)
            with self.assertRaisesRegex(ClusterError, "asked first: error: .*--no-such"):
                asked(cluster.file, options=("--no-such",), seconds=30)
            report = ["--report", "r.jsonl", "--scheduler-file", cluster.file, "--lodc", "no-lodc"]
            self.assertEqual(main(["in.jsonl", *report]), 4)
            self.assertEqual(json.loads(Path("r.jsonl").read_text())["summary"]["built"], 0)
        finally:
            cluster.stop()
        self.assertFalse(Path("out").exists())

    def test_a_lost_scheduler_is_said_with_what_is_done_and_how_to_go_on(self):
        tasks = self.meshes("in", 0)
        slow = self.folder / "slow-lodc"
        slow.write_text(f'#!/bin/sh\ncase "$*" in *--limit*) sleep 1;; esac\nexec "{LODC}" "$@"\n')
        slow.chmod(0o755)
        cluster = Cluster(self.folder, 1)

        def on_result(done, _of, _line):
            if done == 2:
                cluster.processes[0].send_signal(signal.SIGKILL)

        try:
            with self.assertRaisesRegex(ClusterError, "2 of 6 assets are done; .*--if-changed"):
                build(tasks, cluster.file, str(slow), "out", (), on_result, timeout=5)
        finally:
            cluster.stop()

    def test_the_report_has_lines_as_assets_end(self):
        self.meshes("in", 0)
        cluster = Cluster(self.folder, 1)
        try:
            where = ["--scheduler-file", cluster.file, "--lodc", LODC]
            self.assertEqual(main(["in.jsonl", *where, "-o", "out", "--report", "r.jsonl"]), 0)
        finally:
            cluster.stop()
        *lines, last = map(json.loads, Path("r.jsonl").read_text().splitlines())
        self.assertEqual({line["number"] for line in lines}, set(range(6)))
        self.assertEqual(last, {"summary": {"built": 6, "up_to_date": 0, "failed": 0}})

    def test_two_runs_at_once_each_get_their_own_results(self):
        runs = [self.meshes("first", 0), self.meshes("second", 100)]
        cluster = Cluster(self.folder, 2)
        others = []

        def on_result(done, _of, _line):
            # The second run comes and goes while the first one holds its results.
            if done == 3:
                others.extend(build(runs[1], cluster.file, LODC, "second.out"))

        try:
            lines = build(runs[0], cluster.file, LODC, "first.out", (), on_result)
        finally:
            cluster.stop()
        for name, lines in (("first", lines), ("second", others)):
            self.assertEqual(summary(lines), {"built": 6, "up_to_date": 0, "failed": 0})
            for number, line in enumerate(lines):
                mesh = f"{name}/{number}.obj"
                out = f"{name}.out/{mesh}.lodc"
                self.assertEqual([line["input"], line["output"]], [mesh, out])
                subprocess.run([LODC, "build", mesh, "-o", "serial.lodc", "-q"], check=True)
                self.assertEqual(Path(out).read_bytes(), Path("serial.lodc").read_bytes(), mesh)

    def meshes(self, name, seed):
        """Tasks of a list of six meshes in a folder."""
        Path(name).mkdir()
        lines = []
        for number in range(6):
            path = f"{name}/{number}.obj"
            Path(path).write_text(grid(4, seed + number))
            lines.append(json.dumps({"input": path}))
        Path(f"{name}.jsonl").write_text("\n".join(lines))
        return read_list(f"{name}.jsonl")

    def test_the_key_of_a_task_is_that_of_its_work(self):
        first, *_ = self.meshes("in", 0)
        key = lambda task=first, output="out", options=(): content_key(task, LODC, output, options)
        as_it_was = key()
        self.assertEqual(as_it_was, key(replace(first, number=7)))
        line = json.dumps({"input": first.input, "options": {"models": "speed"}})
        keys = [key(replace(first, line=line)), key(output="other"), key(options=("--force",))]
        Path(first.input).write_text(grid(4, 50))
        keys.append(key())
        self.assertEqual(len({as_it_was, *keys}), 5)

    def test_a_list_that_is_none_is_refused_with_its_line(self):
        Path("list.jsonl").write_text('{"input": "a.obj"}\n{"output": "x"}\n')
        with self.assertRaisesRegex(ValueError, "line 2"):
            read_list("list.jsonl")


if __name__ == "__main__":
    unittest.main()
