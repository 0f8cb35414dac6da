"""Builds a folder in parts on a Ray cluster.

`ray job submit -- python ray_levels.py models levels 64`

The folders and `lodc` have the same paths on all nodes. A part whose node is lost runs again.
"""

import subprocess
import sys

import ray

THREADS = 4
MEMORY = 8 << 30


@ray.remote(num_cpus=THREADS, memory=MEMORY, max_retries=3)
def build(models, levels, part, parts):
    """Builds one part; returns its number, the exit status and the last line that was said."""
    command = ["lodc", "build", models, "-o", levels, "--if-changed", "--shard", f"{part}/{parts}"]
    command += ["--jobs", str(THREADS), "--limit", f"memory={MEMORY}", "--report", "jsonl"]
    done = subprocess.run(command, capture_output=True, text=True)
    return part, done.returncode, (done.stderr.strip().splitlines() or [""])[-1]


def main(models, levels, parts):
    """Builds all parts; returns the highest status."""
    ray.init()
    waiting = [build.remote(models, levels, part + 1, parts) for part in range(parts)]
    worst = 0
    while waiting:
        done, waiting = ray.wait(waiting)
        for part, status, said in ray.get(done):
            print(f"part {part} of {parts}: {said or 'done'}", flush=True)
            worst = max(worst, status)
    return worst


if __name__ == "__main__":
    sys.exit(main(sys.argv[1], sys.argv[2], int(sys.argv[3])))
