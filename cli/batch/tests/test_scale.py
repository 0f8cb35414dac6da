"""100,000 assets on 1,000 workers, in virtual time: what hands tasks out is what does so on a
cluster; only the clock and the workers are made up."""

import heapq
import json
import random
import unittest

from lodc_batch import cluster
from lodc_batch.tasks import Task

ASSETS, WORKERS, LOST = 100_000, 1_000, 0.01


class Simulated:
    """A scheduler of workers in virtual time: a task goes to the first worker that is free, the
    earliest first; of a lost worker it goes to another one, from its start."""

    def __init__(self, seconds, seed):
        self.seconds, self.random = seconds, random.Random(seed)
        self.free = [0.0] * WORKERS
        self.running, self.alive, self.most_alive, self.now = [], 0, 0, 0.0
        self.work = self.order = 0

    def scheduler_info(self, n_workers):
        return {"workers": {n: {"resources": {"MEM": 64 << 30}} for n in range(WORKERS)}}

    def wait_for_workers(self, _count, timeout):
        pass

    def submit(self, _function, task, *_args, key, **_how):
        self.alive += 1
        self.most_alive = max(self.most_alive, self.alive)
        seconds = self.seconds[task.number]
        start = max(heapq.heappop(self.free), self.now)
        if self.random.random() < LOST:
            # Somewhere in the middle; a worker takes its place half a minute later.
            lost = start + self.random.random() * seconds
            heapq.heappush(self.free, lost + 30)
            start = max(heapq.heappop(self.free), lost)
        self.work += seconds
        end = start + seconds
        heapq.heappush(self.free, end)
        self.order += 1
        heapq.heappush(self.running, (end, self.order, Done(key, task)))

    def completed(self, _futures):
        while self.running:
            self.now, _, future = heapq.heappop(self.running)
            self.alive -= 1
            yield future


class Done:
    status = "finished"

    def __init__(self, key, task):
        self.key, self.task = key, task

    def result(self):
        return {"input": self.task.input, "status": 0, "up_to_date": False}


class Iterated:
    """Futures as they end, to which more can be added."""

    def __init__(self, futures):
        self.futures = futures

    def __iter__(self):
        return self.futures

    def add(self, _future):
        pass


class Scale(unittest.TestCase):
    def makespan(self, seed):
        """Returns max(work / workers, longest) / makespan, and the most tasks alive."""
        draw = random.Random(seed)
        # Sizes with a heavy tail (Pareto, index 1.2): most are small, some very large.
        sizes = [min(draw.paretovariate(1.2), 3e4) for _ in range(ASSETS)]
        # Time follows what is estimated, more or less.
        seconds = [0.2 * size * draw.lognormvariate(0, 0.4) for size in sizes]
        tasks = [
            Task(n, json.dumps({"input": f"{n}.obj"}), f"{n}.obj", int(size * 1e6))
            for n, size in enumerate(sizes)
        ]
        simulated = Simulated(seconds, seed)
        completed = lambda futures: Iterated(simulated.completed(futures))
        done = list(cluster.results(simulated, tasks, "lodc", "out", (), completed=completed))
        self.assertEqual({line["number"] for line in done}, set(range(ASSETS)))
        bound = max(simulated.work / WORKERS, max(seconds))
        return bound / simulated.now, simulated.most_alive

    def test_workers_are_busy_until_the_end(self):
        for seed in (1, 2):
            efficiency, alive = self.makespan(seed)
            self.assertGreaterEqual(efficiency, 0.9)
            self.assertLessEqual(alive, cluster.MOST_ALIVE)


if __name__ == "__main__":
    unittest.main()
