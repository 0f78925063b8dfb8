"""Reproduce the figures of the paper, with their data, on one page:

    python papers/boundary_layers all --quick          # coarse grids, nine minutes on one core
    python papers/boundary_layers fig4 --out paper     # one figure at full resolution
    python papers/boundary_layers lines --quick        # those for cylinders: line1 to line7

After an interruption the same command continues.
"""

import argparse
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

import ertel
from boundary_layers import figures
from boundary_layers.tasks import Failure, Task


def main(arguments: list[str] | None = None) -> int:
    """Run what is missing, print the path of the page; the exit code."""
    parser = argparse.ArgumentParser(
        "boundary_layers", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        "figure", nargs="?", default="all", choices=[*figures.GROUPS, *figures.FIGURES], metavar="all|lines|fig1|..."
    )
    parser.add_argument("--quick", action="store_true", help="use coarse grids")
    parser.add_argument("--out", type=Path, default=Path("paper"), help="directory of the page (default: paper)")
    parser.add_argument("--jobs", type=int, default=1, help="number of processes (default: 1)")
    asked = parser.parse_args(arguments)
    if asked.jobs < 1:
        parser.error(f"argument --jobs: {asked.jobs}: must be one or more")
    names = figures.names_of(asked.figure)
    ertel.cache()
    try:
        runs, done, seconds = figures.expected(names, asked.quick, asked.out, asked.jobs)
        print(f"{runs} runs, {done} of them done; about {max(seconds / 60, 1):.0f} min", file=sys.stderr, flush=True)
        page, missing = figures.make(names, asked.quick, asked.out, asked.jobs, _report)
    except OSError as error:
        print(f"cannot write to {asked.out}: {error.strerror}; the same command continues", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        print("interrupted; the same command continues", file=sys.stderr)
        return 130
    print(page)
    for name, reason in missing.items():
        print(f"{name} failed: {reason}", file=sys.stderr)
    return 1 if missing else 0


def _report(task: Task, result: object) -> None:
    state = f"failed: {result.reason}" if isinstance(result, Failure) else "done"
    print(f"{task.name}: {state}", file=sys.stderr, flush=True)


if __name__ == "__main__":
    sys.exit(main())
