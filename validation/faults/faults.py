"""Disturb small runs in every way that a machine has, and count what became of them.

    python validation/faults/faults.py kills --count 500 --seed 1
    python validation/faults/faults.py disk --count 100
    python validation/faults/faults.py bits --count 2000

Exit code 0: nothing was silent, nothing flushed was lost, no traceback.  A failure is printed with its number;
`--only NUMBER` with the same seed repeats it, and its directory is kept.
"""

import argparse
import os
import random
import sys
import time
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path
from tempfile import mkdtemp

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("JAX_PLATFORMS", "cpu")  # before JAX is imported

import bits  # noqa: E402
import kills  # noqa: E402
import kinds  # noqa: E402
from kills import Outcome  # noqa: E402

GOOD = ("equal", "unchanged", "refused damage")
Campaign = Iterator[tuple[int, str, str, Outcome]]  # number of the trial, kind of run, what was done to it, its end


def main() -> int:
    """Run the campaign that the command line asks for."""
    asked = _arguments()
    place = Path(mkdtemp(prefix=f"faults-{asked.what}-"))
    print(f"{asked.what}: {asked.count} trials, seed {asked.seed}, kinds {' '.join(asked.kinds)}, in {place}", flush=True)
    started, counts, kills_made, failed = time.monotonic(), Counter[tuple[str, str, str]](), 0, 0
    chosen = kinds.kinds(place, asked.kinds)
    kinds.record(chosen)
    for number, kind, way, outcome in CAMPAIGNS[asked.what](asked, chosen, place):
        counts[kind, way, outcome.word] += 1
        kills_made += outcome.kills
        if outcome.word not in GOOD:
            failed += 1
            print(f"trial {number}, {kind}, {way}: {outcome.word}: {outcome.why}", flush=True)
    _print_table(counts)
    print(f"{sum(counts.values())} trials, {kills_made} kills, {failed} failed, {time.monotonic() - started:.0f} s")
    return 1 if failed else 0


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=CAMPAIGNS)
    parser.add_argument("--count", type=int, default=20, help="number of trials")
    parser.add_argument("--seed", type=int, default=random.SystemRandom().randrange(10**6), help="default by chance")
    parser.add_argument("--kinds", nargs="+", choices=kinds.NAMES, default=kinds.NAMES, help="kinds of run")
    parser.add_argument("--only", type=int, help="number of the one trial to repeat")
    return parser.parse_args()


def _numbers(asked: argparse.Namespace) -> Iterator[tuple[int, random.Random]]:
    """The number of each trial and its dice."""
    for number in range(asked.count) if asked.only is None else [asked.only]:
        yield number, random.Random(f"{asked.seed} {number}")


def _disturbed(ways: dict[str, Callable[..., Outcome]]) -> Callable[..., Campaign]:
    def campaign(asked: argparse.Namespace, chosen: dict[str, kinds.Kind], place: Path) -> Campaign:
        known = [kills.undisturbed(kind, _made(place / kind.name)) for kind in chosen.values()]
        for number, dice in _numbers(asked):
            own, way = known[number % len(known)], list(ways)[number // len(known) % len(ways)]
            yield number, own.kind.name, way, kills.tried(ways[way], own, place / f"trial-{number}", dice)

    return campaign


def _damaged(asked: argparse.Namespace, chosen: dict[str, kinds.Kind], place: Path) -> Campaign:
    stored = [run for kind in chosen.values() for run in bits.prepared(kind, _made(place / kind.name))]
    for number, dice in _numbers(asked):
        run, way = stored[number % len(stored)], bits.way(dice)
        yield number, run.name, way, bits.tried(run, way, place / f"trial-{number}", dice)


CAMPAIGNS: dict[str, Callable[..., Campaign]] = {
    "kills": _disturbed(kills.KILLS),
    "disk": _disturbed(kills.DISKS),
    "bits": _damaged,
}


def _made(directory: Path) -> Path:
    directory.mkdir()
    return directory


def _print_table(counts: Counter[tuple[str, str, str]]) -> None:
    """A row for each kind of run and fault, a column for each outcome."""
    words = sorted({word for _, _, word in counts}, key=lambda word: (word not in GOOD, word))
    print(f"{'run':24}{'fault':20}" + "".join(f"{word:>16}" for word in words))
    for kind, way in dict.fromkeys((kind, way) for kind, way, _ in counts):
        print(f"{kind:24}{way:20}" + "".join(f"{counts[kind, way, word]:16}" for word in words))


if __name__ == "__main__":
    sys.exit(main())
