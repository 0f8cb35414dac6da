"""Tasks on a cluster: memory claimed, lost workers made good, results as they come."""

import os
import time
import uuid
from concurrent.futures import CancelledError
from dataclasses import replace

from distributed import Client, as_completed

from . import tasks as work

# Futures alive at a time: a scheduler and a client that keep more of them slow down.
MOST_ALIVE = 10_000
# Assets whose needs are asked for by one task.
PIECE = 64
# Seconds to wait for a scheduler and for a first worker.
TIMEOUT = 30.0


class ClusterError(RuntimeError):
    """The cluster, or the program on it, is not there or is there no more."""


def build(
    tasks,
    scheduler=None,
    lodc="lodc",
    output=None,
    options=(),
    on_result=None,
    timeout=TIMEOUT,
):
    """Builds all tasks on a cluster.

    `scheduler` is the path of a scheduler file, an address, or none for what Dask is configured for
    (`DASK_SCHEDULER_ADDRESS`). Returns one line of the report for each task, in their order.
    `on_result(done, of, line)` is called as results come. Tasks that are the same work are done
    once. Raises ClusterError if no scheduler or worker answers within `timeout` seconds, if `lodc`
    cannot be run there, or if the scheduler is lost.
    """
    lines = [None] * len(tasks)
    client = connect(scheduler, timeout)
    try:
        largest_worker(client, timeout)
        ask_one(client, lodc, options, timeout)
        tasks = estimated(client, tasks, lodc, options)
        for done, line in enumerate(results(client, tasks, lodc, output, options, timeout), 1):
            number = line.pop("number")
            lines[number] = line
            if on_result:
                on_result(done, len(tasks), {"number": number, **line})
    except (CancelledError, OSError) as error:
        done = sum(line is not None for line in lines)
        raise ClusterError(
            f"the scheduler is lost ({error or type(error).__name__}): {done} of {len(lines)} "
            "assets are done; run it again with -- --if-changed to go on"
        )
    finally:
        client.close(timeout=1)
    return lines


def connect(scheduler, timeout):
    """Returns a client of a scheduler, which may be about to write its file."""
    is_file = scheduler is not None and ":" not in scheduler
    end = time.monotonic() + timeout
    while is_file and not os.path.isfile(scheduler):
        if time.monotonic() > end:
            what = f"no scheduler wrote this file within {timeout:g} s: start `dask scheduler`"
            raise ClusterError(f"{scheduler}: {what}")
        time.sleep(0.1)
    where = {"scheduler_file": scheduler} if is_file else {"address": scheduler}
    if scheduler is None and not configured():
        names = "--scheduler-file, --scheduler or DASK_SCHEDULER_ADDRESS"
        raise ClusterError(f"no scheduler: give {names}")
    try:
        return Client(timeout=timeout, **where)
    except (OSError, ValueError) as error:
        name = scheduler or configured()
        raise ClusterError(f"{name}: no scheduler answers within {timeout:g} s ({error})")


def configured():
    """Returns the address that Dask is configured for, if there is one."""
    import dask

    return dask.config.get("scheduler-address", None)


def largest_worker(client, timeout=TIMEOUT):
    """Returns the most memory that a worker offers.

    Raises ClusterError if there is no worker, or one without the resource MEM.
    """
    try:
        client.wait_for_workers(1, timeout=timeout)
    except TimeoutError:
        raise ClusterError(f"no worker came within {timeout:g} s: start `dask worker`")
    workers = client.scheduler_info(n_workers=-1)["workers"].values()
    offers = [worker["resources"].get("MEM", 0) for worker in workers]
    if not all(offers):
        raise ClusterError("a worker offers no memory: start it with --resources MEM=BYTES")
    return int(max(offers))


def ask_one(client, lodc, options, timeout):
    """Asks one worker for the program, and whether it takes the options."""
    future = client.submit(work.probe, lodc, tuple(options), key=f"lodc-probe-{uuid.uuid4().hex}")
    try:
        return future.result(timeout=timeout)
    except TimeoutError:
        raise ClusterError(f"no worker answered within {timeout:g} s")
    except RuntimeError as error:
        raise ClusterError(f"a worker was asked first: {error}")


def estimated(client, tasks, lodc, options):
    """Returns the tasks with the memory that workers' `lodc` says they need."""
    run = uuid.uuid4().hex
    pieces = [tasks[i : i + PIECE] for i in range(0, len(tasks), PIECE)]
    asked = [
        client.submit(work.estimate, piece, lodc, tuple(options), key=f"lodc-estimate-{run}-{i}")
        for i, piece in enumerate(pieces)
    ]
    needs = [need for future in asked for need in future.result()]
    return [replace(task, memory=need) for task, need in zip(tasks, needs)]


def results(client, tasks, lodc, output, options, timeout=TIMEOUT, completed=as_completed):
    """Yields the line of each task, with its number, as they come.

    The longest come first, so that the last to end are short ones; a window of them is alive.
    """
    # A scheduler answers a key that it knows with the result that it has, whoever asks: keys of
    # one run must not be those of another.
    run = uuid.uuid4().hex
    groups = {}
    for task in tasks:
        groups.setdefault(work.content_key(task, lodc, output, options), []).append(task)
    waiting = iter(longest_first(groups.items()))
    owners, most = {}, largest_worker(client, timeout)

    def submit(key, group, memory, again=False):
        key = f"lodc-{run}-{key}{'-whole-worker' if again else ''}"
        owners[key] = (group, memory)
        asked = (group[0], lodc, output, tuple(options), memory)
        return client.submit(work.run, *asked, key=key, resources={"MEM": memory}, pure=False)

    def next_one():
        found = next(waiting, None)
        # What no worker has room for still runs once, alone.
        return found and submit(*found, min(found[1][0].memory, most))

    alive = completed([future for _ in range(MOST_ALIVE) if (future := next_one())])
    for future in alive:
        group, memory = owners.pop(future.key)
        if future.status == "cancelled":
            raise CancelledError("its tasks were cancelled")
        if future.status == "finished":
            line = future.result()
        else:
            line = work.failure(group[0], 70, f"no result: {future.exception()}")
        if work.lacks_memory(line) and memory < (most := largest_worker(client, timeout)):
            # It needs more than was estimated: once more, with a worker to itself. What takes too
            # much time, or has too many triangles, does so on any worker.
            key = future.key.removeprefix(f"lodc-{run}-")
            alive.add(submit(key, group, most, again=True))
            continue
        for task in group:
            yield {"number": task.number, **line, "input": task.input}
        if more := next_one():
            alive.add(more)


def longest_first(groups):
    """Returns groups of equal tasks, those first that are expected to take longest."""
    return sorted(groups, key=lambda group: (-group[1][0].memory, group[1][0].number))


def summary(lines):
    """Returns the numbers of assets by what became of them."""
    failed = sum(line["status"] != 0 for line in lines)
    up_to_date = sum(line["up_to_date"] for line in lines)
    return {"built": len(lines) - failed - up_to_date, "up_to_date": up_to_date, "failed": failed}
