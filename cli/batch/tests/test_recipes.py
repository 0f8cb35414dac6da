"""The recipes of docs/ci for many machines, run as they stand on a folder of meshes."""

import os
import re
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import yaml

from .test_cluster import LODC, grid

CI = Path(__file__).resolve().parents[3] / "docs" / "ci"
# Runs tasks at once, where it is asked for them: what a recipe uses of Ray.
RAY = """
def init(): pass
def remote(**how):
    assert set(how) <= {"num_cpus", "memory", "max_retries"}
    class Task:
        def __init__(self, function): self.remote = function
    return Task
def wait(futures): return futures[:1], futures[1:]
def get(futures): return futures
"""


class Recipes(unittest.TestCase):
    def setUp(self):
        self.folder = Path(tempfile.mkdtemp(prefix="lodc-recipes-")).resolve()
        os.chdir(self.folder)
        Path("models").mkdir()
        Path("bin").mkdir()
        Path("bin/lodc").symlink_to(LODC)
        for number in range(12):
            Path(f"models/{number}.obj").write_text(grid(3, number))
        self.environment = {**os.environ, "PATH": f"{self.folder}/bin:{os.environ['PATH']}"}

    def run_it(self, command, **more):
        environment = {**self.environment, **more}
        return subprocess.run(command, env=environment, check=True, capture_output=True, text=True)

    def check_all(self):
        built = sorted(path.name for path in Path("levels").iterdir())
        self.assertEqual(built, sorted(f"{number}.obj.lodc" for number in range(12)))

    def test_slurm(self):
        script = CI / "slurm.sh"
        count = re.search(r"--array=1-(\d+)", script.read_text())[1]
        for part in range(int(count)):
            task = {"SLURM_ARRAY_TASK_ID": str(part + 1), "SLURM_ARRAY_TASK_COUNT": count}
            self.run_it(["sh", script], SLURM_CPUS_PER_TASK="1", **task)
        self.check_all()

    def test_ray(self):
        Path("ray.py").write_text(RAY)
        run = [sys.executable, CI / "ray_levels.py", "models", "levels", "3"]
        done = self.run_it(run, PYTHONPATH=str(self.folder))
        self.assertIn("part 3 of 3", done.stdout)
        self.check_all()

    def test_github_matrix(self):
        jobs = yaml.safe_load((CI / "github-matrix.yml").read_text())["jobs"]
        parts = jobs["part"]["strategy"]["matrix"]["part"]
        for part in parts:
            for step in jobs["part"]["steps"]:
                if "run" in step:
                    self.run_it(["sh", "-c", step["run"].replace("${{ matrix.part }}", str(part))])
        self.check_all()
        self.assertEqual(jobs["all"]["needs"], "part")

    def test_the_others_can_be_parsed(self):
        for path in CI.glob("*.y*ml"):
            self.assertTrue(list(yaml.safe_load_all(path.read_text())), path)


if __name__ == "__main__":
    unittest.main()
