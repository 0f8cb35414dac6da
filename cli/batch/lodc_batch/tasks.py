"""Tasks: one asset each, and what a worker does with it."""

import hashlib
import json
import os
import signal
import subprocess
from dataclasses import dataclass
from pathlib import Path

# Memory that a byte of an input may come to, as `lodc build` estimates it for folders.
MEMORY_OF_BYTE = 14
# What the smallest asset claims: the program, its threads' stacks, a share of the worker.
LEAST_MEMORY = 64 << 20


@dataclass(frozen=True)
class Task:
    """One line of a list."""

    number: int  # from 0, in the order of the list
    line: str
    input: str
    memory: int  # bytes that it may need


def read_list(path):
    """Returns the tasks of a list (docs/CLI.md, `--manifest`).

    Raises ValueError for a line that is not a JSON object with an `input`.
    """
    tasks = []
    for number, line in enumerate(Path(path).read_text().splitlines(), 1):
        if not line.strip():
            continue
        try:
            name = json.loads(line)["input"]
        except (ValueError, KeyError, TypeError) as error:
            raise ValueError(f"{path}: line {number}: no JSON object with an input: {error}")
        tasks.append(Task(len(tasks), line, name, expected_memory(name)))
    return tasks


def files_of(name):
    """Returns the files of an asset that are there: itself and the `.bin` beside it."""
    names = {name, str(Path(name).with_suffix(".bin"))}
    return sorted(path for path in names if os.path.isfile(path))


def expected_memory(name):
    """Returns the bytes of memory that an asset may need, from the size of its files."""
    return max(LEAST_MEMORY, sum(map(os.path.getsize, files_of(name))) * MEMORY_OF_BYTE)


def content_key(task, lodc, output, options):
    """Returns what identifies the work of a task: contents of its files, options, output.

    64 hexadecimal digits. The task's line names its own options and output.
    """
    words = [task.line, lodc, output, *options]
    key = hashlib.sha256(json.dumps(words).encode())
    for path in files_of(task.input):
        key.update(digest(path))
    return key.hexdigest()


def digest(path):
    """Returns 32 bytes that stand for a file's content; none if the file cannot be read."""
    hashed = hashlib.sha256()
    try:
        with open(path, "rb") as file:
            while chunk := file.read(1 << 20):
                hashed.update(chunk)
    except OSError:
        # The build will fail and say why.
        return b""
    return hashed.digest()


def run(task, lodc, output, options, memory):
    """Builds one asset within `memory` bytes. Returns its line of the report."""
    command = [lodc, "build", "--manifest", "-", "--report", "json", "-q", "--jobs", "1"]
    command += ["--limit", f"memory={memory}", *options]
    if output:
        command += ["-o", output]
    done = subprocess.run(command, input=task.line, capture_output=True, text=True)
    try:
        report = json.loads(done.stdout)["inputs"][0]
        keys = ("input", "output", "status", "error", "up_to_date", "seconds")
        return {key: report[key] for key in keys}
    except (ValueError, KeyError, IndexError):
        return failure(task, *died(done))


def died(done):
    """Returns status and message of a process that left no report."""
    if done.returncode < 0:
        return 70, f"ended by {signal.Signals(-done.returncode).name}"
    last = (done.stderr.strip().splitlines() or ["it said nothing"])[-1]
    return done.returncode or 70, last


def failure(task, status, error):
    """Returns the line of the report of an asset that came to nothing."""
    return {
        "input": task.input,
        "output": "",
        "status": status,
        "error": error,
        "up_to_date": False,
        "seconds": None,
    }
