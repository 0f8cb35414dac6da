"""Tasks: one asset each, and what a worker does with it."""

import hashlib
import json
import os
import signal
import subprocess
import tempfile
from dataclasses import dataclass, replace
from pathlib import Path

from . import remote

# Bytes of memory that a byte of an input may come to, where its header cannot be asked.
MEMORY_OF_BYTE = 14
# What the smallest asset claims: the program, its threads' stacks, a share of the worker.
LEAST_MEMORY = 64 << 20
# The status of an asset that a limit has stopped.
LIMIT = 5


@dataclass(frozen=True)
class Task:
    """One line of a list."""

    number: int  # from 0, in the order of the list
    line: str
    input: str
    memory: int = LEAST_MEMORY  # bytes that it may need


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
        tasks.append(Task(len(tasks), line, name))
    return tasks


def command(lodc, options, *more):
    """Returns a build of the list that comes on standard input."""
    return [lodc, "build", "--manifest", "-", "-q", "--jobs", "1", *more, *options]


def probe(lodc, options):
    """Returns the version of `lodc`, run on this worker with these options.

    Raises RuntimeError with words if it cannot be run, or takes no such option.
    """
    try:
        version = subprocess.run([lodc, "--version"], capture_output=True, text=True)
    except OSError as error:
        raise RuntimeError(f"`{lodc}` cannot be run there: {error.strerror}")
    if version.returncode != 0:
        raise RuntimeError(f"`{lodc} --version` ends with {died(version)[1]}")
    # A list of nothing: options are read, nothing is built.
    asked = [*command(lodc, options), "--estimate"]
    tried = subprocess.run(asked, input="", capture_output=True, text=True)
    if tried.returncode == 2:
        raise RuntimeError(died(tried)[1])
    return version.stdout.strip()


def estimate(tasks, lodc, options):
    """Returns the bytes of memory that each task may need, as this worker's `lodc` says."""
    local = [task for task in tasks if not remote.is_url(task.input)]
    asked = command(lodc, options, "--estimate", "--report", "json")
    lines = "\n".join(task.line for task in local)
    needs = {}
    if local:
        said = subprocess.run(asked, input=lines, capture_output=True, text=True)
        try:
            inputs = json.loads(said.stdout)["inputs"]
            needs = {task.number: known["memory"] for task, known in zip(local, inputs)}
        except (ValueError, KeyError):
            pass
    return [needs.get(task.number) or by_size(task) for task in tasks]


def by_size(task):
    """Returns the bytes of memory that an asset may need, by the size of its files."""
    if remote.is_url(task.input):
        size = remote.size(task.input)
    else:
        size = sum(map(os.path.getsize, files_of(task.input)))
    return max(LEAST_MEMORY, size * MEMORY_OF_BYTE)


def files_of(name):
    """Returns the files of an asset that are there: itself and the `.bin` beside it."""
    names = {name, str(Path(name).with_suffix(".bin"))}
    return sorted(path for path in names if os.path.isfile(path))


def content_key(task, lodc, output, options, files=None):
    """Returns what identifies the work of a task: contents of its files, options, output.

    64 hexadecimal digits. The task's line names its own options and output. Files at URLs are known
    by what their place says of them (size, entity tag), unless they are at hand as `files`.
    """
    words = [task.line, lodc, output, *options]
    if files is None and remote.is_url(task.input):
        words.append(remote.tag(task.input))
    key = hashlib.sha256(json.dumps(words).encode())
    for path in files_of(task.input) if files is None else files:
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
    if remote.is_url(task.input) or remote.is_url(output or ""):
        with tempfile.TemporaryDirectory(prefix="lodc-batch-") as scratch:
            return staged(task, lodc, output, options, memory, Path(scratch))
    return built(task, lodc, output, options, memory)


def staged(task, lodc, output, options, memory, scratch):
    """Builds an asset that is at a URL, or whose result goes to one, in a folder of its own."""
    try:
        asset = json.loads(task.line)
        name = remote.name(task.input)
        target = asset.pop("output", None)
        if target is None:
            place = (output or task.input.rsplit("/", 1)[0]).rstrip("/")
            target = f"{place}/{name}.lodc"
        files = remote.fetch(task.input, scratch / "in")
        key = content_key(replace(task, input=name), lodc, output, options, files)
        if "--if-changed" in options and remote.read(f"{target}.key") == key.encode():
            return {**line_of(task), "output": target, "up_to_date": True, "seconds": 0.0}
        made = scratch / "out" / f"{name}.lodc"
        made.parent.mkdir()
        asset.update(input=str(files[0]), output=str(made))
        own = [option for option in options if option != "--if-changed"]
        line = built(replace(task, line=json.dumps(asset)), lodc, None, own, memory)
        if line["status"] == 0:
            remote.put(made, target)
            remote.write(f"{target}.key", key.encode())
        return {**line, "input": task.input, "output": target}
    except (OSError, ValueError, ImportError) as error:
        return failure(task, 3, f"{task.input}: {error}")


def built(task, lodc, output, options, memory):
    """Runs the program on one asset."""
    where = ["-o", output] if output else []
    limit = ["--report", "json", "--limit", f"memory={memory}"]
    asked = command(lodc, options, *limit, *where)
    try:
        done = subprocess.run(asked, input=task.line, capture_output=True, text=True)
    except OSError as error:
        return failure(task, 70, f"`{lodc}` cannot be run: {error.strerror}")
    try:
        report = json.loads(done.stdout)["inputs"][0]
        return {key: report[key] for key in line_of(task)}
    except (ValueError, KeyError, IndexError):
        return failure(task, *died(done))


def lacks_memory(line):
    """Returns whether a line of the report says that an asset needs more memory than it had."""
    return line["status"] == LIMIT and "--limit memory=" in (line["error"] or "")


def died(done):
    """Returns status and message of a process that left no report."""
    if done.returncode < 0:
        return 70, f"ended by {signal.Signals(-done.returncode).name}"
    lines = done.stderr.strip().splitlines()
    # Of a usage message the first line says what is wrong.
    wrong = [line for line in lines if line.startswith("error:")]
    return done.returncode or 70, (wrong or lines[-1:] or ["it said nothing"])[0]


def line_of(task):
    """Returns the line of the report of an asset that all went well with, but for its output."""
    return {
        "input": task.input,
        "output": "",
        "status": 0,
        "error": None,
        "up_to_date": False,
        "seconds": None,
    }


def failure(task, status, error):
    """Returns the line of the report of an asset that came to nothing."""
    return {**line_of(task), "status": status, "error": error}
