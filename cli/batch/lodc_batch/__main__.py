"""Command line: `lodc-batch LIST --scheduler-file S [-o OUT] [--report F] [-- OPTIONS]`."""

import argparse
import json
import sys

from .cluster import TIMEOUT, ClusterError, build, summary
from .tasks import read_list


def arguments(argv):
    """Parses the command line; what follows `--` is for `lodc build`."""
    argv = list(argv)
    options = []
    if "--" in argv:
        place = argv.index("--")
        argv, options = argv[:place], argv[place + 1 :]
    parser = argparse.ArgumentParser(prog="lodc-batch", description=__doc__)
    parser.add_argument("list", help="assets, a JSON document in each line (docs/CLI.md)")
    file = {"dest": "scheduler", "metavar": "FILE", "help": "of `dask scheduler`"}
    parser.add_argument("--scheduler-file", **file)
    parser.add_argument(
        "--scheduler",
        metavar="ADDRESS",
        help="such as tcp://10.0.0.1:8786 [default: DASK_SCHEDULER_ADDRESS]",
    )
    parser.add_argument("-o", "--output", help="folder of the results, or a URL")
    parser.add_argument("--lodc", default="lodc", help="the program, as workers reach it")
    parser.add_argument("--report", help="append a line for each asset as it ends, and a summary")
    parser.add_argument(
        "--timeout",
        type=float,
        default=TIMEOUT,
        metavar="S",
        help=f"seconds to wait for a scheduler and a first worker [default: {TIMEOUT:g}]",
    )
    parsed = parser.parse_args(argv)
    parsed.options = options
    return parsed


def show(done, of, line):
    """Prints one result as it comes."""
    what = "up to date" if line["up_to_date"] else line["error"] or line["output"]
    print(f"[{done}/{of}] {line['input']}: {what}", file=sys.stderr, flush=True)


def main(argv=None):
    """Builds a list; returns the highest status of its assets, 4 if the cluster fails."""
    args = arguments(sys.argv[1:] if argv is None else argv)
    try:
        tasks = read_list(args.list)
        report = open(args.report, "w") if args.report else None
    except (OSError, ValueError) as error:
        print(f"lodc-batch: {error}", file=sys.stderr)
        return 3
    lines = []

    def on_result(done, of, line):
        lines.append(line)
        show(done, of, line)
        write(line)

    def write(line):
        if report:
            report.write(json.dumps(line) + "\n")
            report.flush()

    status = 0
    try:
        where = (args.scheduler, args.lodc, args.output, args.options)
        build(tasks, *where, on_result, args.timeout)
    except ClusterError as error:
        print(f"lodc-batch: {error}", file=sys.stderr)
        status = 4
    counts = summary(lines)
    write({"summary": counts})
    print(", ".join(f"{n} {what.replace('_', ' ')}" for what, n in counts.items()), file=sys.stderr)
    return max([status, *(line["status"] for line in lines)])


if __name__ == "__main__":
    sys.exit(main())
