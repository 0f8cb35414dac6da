"""Tasks on a cluster: memory claimed, lost workers made good, results as they come."""

import uuid

from distributed import Client, as_completed

from . import tasks as work


def build(tasks, scheduler_file, lodc="lodc", output=None, options=(), on_result=None):
    """Builds all tasks on the cluster of a scheduler file.

    Returns one line of the report for each, in their order. `on_result(done, of, line)` is called
    as results come. Tasks that are the same work are done once.
    """
    lines, done = [None] * len(tasks), 0
    # A scheduler answers a key that it knows with the result that it has, whoever asks: keys of
    # one run must not be those of another.
    run = uuid.uuid4().hex
    with Client(scheduler_file=scheduler_file) as client:
        most = largest_worker(client)
        futures, owners = [], {}
        for task in sorted(tasks, key=lambda task: (-task.memory, task.number)):
            key = f"lodc-{run}-{work.content_key(task, lodc, output, options)}"
            owners.setdefault(key, []).append(task)
            if len(owners[key]) > 1:
                continue
            # What no worker has room for still runs once, alone, and ends with status 5.
            memory = min(task.memory, most)
            future = client.submit(
                work.run,
                task,
                lodc,
                output,
                tuple(options),
                memory,
                key=key,
                resources={"MEM": memory},
                pure=False,
            )
            futures.append(future)
        for future in as_completed(futures):
            for task in owners[future.key]:
                if future.status == "finished":
                    line = future.result()
                else:
                    line = work.failure(task, 70, f"no result: {future.exception()}")
                lines[task.number] = line
                done += 1
                if on_result:
                    on_result(done, len(tasks), line)
    return lines


def largest_worker(client):
    """Returns the most memory that a worker offers.

    Raises RuntimeError if there is no worker, or one without the resource MEM.
    """
    client.wait_for_workers(1)
    workers = client.scheduler_info(n_workers=-1)["workers"].values()
    offers = [worker["resources"].get("MEM", 0) for worker in workers]
    if not all(offers):
        raise RuntimeError("a worker offers no memory: start it with --resources MEM=BYTES")
    return int(max(offers))


def summary(lines):
    """Returns the numbers of assets by what became of them."""
    failed = sum(line["status"] != 0 for line in lines)
    up_to_date = sum(line["up_to_date"] for line in lines)
    return {"built": len(lines) - failed - up_to_date, "up_to_date": up_to_date, "failed": failed}
