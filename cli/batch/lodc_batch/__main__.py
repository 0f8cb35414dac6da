"""Command line: `lodc-batch LIST --scheduler-file S [-o OUT] [--report F] [-- OPTIONS]`."""

import argparse
import json
import sys

from .cluster import build, summary
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
    parser.add_argument("--scheduler-file", required=True, help="of `dask scheduler`")
    parser.add_argument("-o", "--output", help="folder of the results")
    parser.add_argument("--lodc", default="lodc", help="the program, as workers reach it")
    parser.add_argument("--report", help="write a line for each asset and a summary to this file")
    parsed = parser.parse_args(argv)
    parsed.options = options
    return parsed


def show(done, of, line):
    """Prints one result as it comes."""
    what = "up to date" if line["up_to_date"] else line["error"] or line["output"]
    print(f"[{done}/{of}] {line['input']}: {what}", file=sys.stderr, flush=True)


def main(argv=None):
    """Builds a list; returns the highest status of its assets."""
    args = arguments(sys.argv[1:] if argv is None else argv)
    try:
        tasks = read_list(args.list)
    except (OSError, ValueError) as error:
        print(f"lodc-batch: {error}", file=sys.stderr)
        return 3
    lines = build(tasks, args.scheduler_file, args.lodc, args.output, args.options, show)
    counts = summary(lines)
    if args.report:
        with open(args.report, "w") as file:
            for line in [*lines, {"summary": counts}]:
                file.write(json.dumps(line) + "\n")
    print(", ".join(f"{n} {what.replace('_', ' ')}" for what, n in counts.items()), file=sys.stderr)
    return max((line["status"] for line in lines), default=0)


if __name__ == "__main__":
    sys.exit(main())
