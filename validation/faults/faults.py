"""Disturb small runs in every way that a machine has, and count what became of them.

    python validation/faults/faults.py campaign --seed 23
    python validation/faults/faults.py kills --count 440 --seed 14
    python validation/faults/faults.py disk processes --count 40
    python validation/faults/faults.py bits --count 2250

kills: a process ends before its n-th change of a file, or at a random time; what is left is resumed.
disk: no space is left from the n-th change on, or files may not be larger than so many bytes; later it is resumed.
bits: a bit of a stored run is flipped, a file is cut short or deleted; all commands answer as before or refuse.
campaign: 500 kills or more, 100 full disks, 2000 damaged files, 20 000 case files; prints the tables for README.md.
processes: kills and resumes of `python -m ertel` itself, without the shortcuts of the others (slow).

Exit code 0: nothing was silent, no flushed step was lost, no traceback.  A failure is printed with its number;
`--only NUMBER` with the same seed, count and kinds repeats it, and its directory is kept.  Ctrl-C ends with the table.
`--log FILE` keeps a line of each trial; the same command with the same file leaves out those that it has.
"""

import argparse
import json
import os
import random
import signal
import subprocess
import sys
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path
from tempfile import mkdtemp
from typing import Any

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("JAX_PLATFORMS", "cpu")  # before JAX is imported
# each program runs some ten times; a child by fork has not the threads of its parent, for which large arrays would wait
os.environ.setdefault("XLA_FLAGS", "--xla_backend_optimization_level=0 --xla_cpu_multi_thread_eigen=false")
os.environ.setdefault("NPROC", "1")

import bits
import kills
import kinds
from kills import Known, Outcome

WHOLE = {"kills": 440, "disk": 100, "bits": 2000}  # trials of a campaign; 440 make some 520 kills
CASE_FILES = Path(__file__).with_name("case_files.py")
STORED: list[bits.Stored] = []  # that are damaged, made once
GOOD = ("equal", "unchanged", "refused damage")
Campaign = Iterator[tuple[int, str, str, Outcome]]  # number of the trial, kind of run, what was done to it, its end


def main() -> int:
    """Run the campaigns that the command line asks for."""
    asked = _arguments()
    signal.signal(signal.SIGINT, signal.default_int_handler)  # in the background, too
    place = Path(mkdtemp(prefix="faults-"))
    print(f"seed {asked.seed}, kinds {' '.join(asked.kinds)}, in {place}", flush=True)
    chosen = kinds.kinds(place, asked.kinds)
    kinds.record(chosen)
    known = [kills.undisturbed(kind, _made(place / kind.name)) for kind in chosen.values()]
    whole = WHOLE if "campaign" in asked.what else dict.fromkeys(asked.what, asked.count)
    with suppress(KeyboardInterrupt):
        for asked.count, what in _parts(whole):
            _do(asked, what, known, place)
    if asked.log:
        _print_log(asked)
    failed = asked.failed
    if "campaign" in asked.what:
        failed += subprocess.run([sys.executable, CASE_FILES, "--seed", str(asked.seed)], check=False).returncode
    return 1 if failed else 0


def _parts(whole: dict[str, int]) -> Iterator[tuple[int, str]]:
    """So many trials of each campaign: a tenth of all campaigns, two tenths, ..., so that a stop cuts all of them."""
    tenths = 10 if whole is WHOLE else 1
    return ((count * part // tenths, what) for part in range(1, tenths + 1) for what, count in whole.items())


def _do(asked: argparse.Namespace, what: str, known: list[Known], place: Path) -> None:
    """Do the trials of a campaign that are left, up to the asked number of them, and print what became of them."""
    started, counts, failed = _cpu_seconds(), Counter[tuple[str, str]](), asked.failed
    kills_made = 0
    try:
        for number, kind, way, outcome in CAMPAIGNS[what](asked, known, _made(place / what)):
            counts[kind, outcome.word] += 1
            kills_made += outcome.kills
            _keep(asked, what, number, kind, way, outcome)
            if outcome.word not in GOOD:
                asked.failed += 1
                print(f"{what}, trial {number}, {kind}, {way}: {outcome.word}: {outcome.why}", flush=True)
    finally:
        _print_table(what, counts)
        words = f"{counts.total()} trials, {kills_made} kills, {asked.failed - failed} failed"
        print(f"{what}, seed {asked.seed}: {words}, {_cpu_seconds() - started:.0f} s", flush=True)


def _keep(asked: argparse.Namespace, what: str, number: int, kind: str, way: str, outcome: Outcome) -> None:
    """Write the line of a trial, and remember that it is done."""
    asked.done.add((what, number))
    if asked.log:
        line = {"seed": asked.seed, "what": what, "number": number, "kind": kind, "way": way, **vars(outcome)}
        with asked.log.open("a") as file:
            file.write(json.dumps(line) + "\n")


def _lines(asked: argparse.Namespace) -> list[dict[str, Any]]:
    """What the log has of this seed."""
    lines = asked.log.read_text().splitlines() if asked.log and asked.log.exists() else []
    return [line for line in map(json.loads, lines) if line["seed"] == asked.seed]


def _print_log(asked: argparse.Namespace) -> None:
    """The tables of all that the log has of this seed."""
    lines = _lines(asked)
    for what in dict.fromkeys(line["what"] for line in lines):
        own = [line for line in lines if line["what"] == what]
        _print_table(what, Counter((line["kind"], line["word"]) for line in own))
        bad, ended = [line for line in own if line["word"] not in GOOD], sum(line["kills"] for line in own)
        print(f"{what}, seed {asked.seed}, in all: {len(own)} trials, {ended} kills, {len(bad)} failed")


def _cpu_seconds() -> float:
    """Of this process and of the children that ended."""
    return sum(os.times()[:4])


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", nargs="+", choices=[*CAMPAIGNS, "campaign"])
    parser.add_argument("--count", type=int, default=20, help="number of trials of each; campaign: as it is")
    parser.add_argument("--seed", type=int, default=random.SystemRandom().randrange(10**6), help="default by chance")
    parser.add_argument("--kinds", nargs="+", choices=kinds.NAMES, default=kinds.NAMES, help="kinds of run")
    parser.add_argument("--only", type=int, help="number of the one trial to repeat")
    parser.add_argument("--log", type=Path, help="file with a line of each trial, to go on from")
    asked = parser.parse_args()
    asked.failed = 0
    asked.done = {(line["what"], line["number"]) for line in _lines(asked)}
    return asked


def _numbers(asked: argparse.Namespace, what: str) -> Iterator[tuple[int, random.Random]]:
    """The number of each trial that is not done, and its dice."""
    left = [number for number in range(asked.count) if (what, number) not in asked.done]
    for number in left if asked.only is None else [asked.only]:
        yield number, random.Random(f"{asked.seed} {number}")


def _disturbed(ways: dict[str, Callable[..., Outcome]]) -> Callable[..., Campaign]:
    def campaign(asked: argparse.Namespace, known: list[Known], place: Path) -> Campaign:
        kinds.flush_every(0.0)
        for number, dice in _numbers(asked, place.name):
            own, way = known[number % len(known)], list(ways)[number // len(known) % len(ways)]
            yield number, own.kind.name, way, kills.tried(ways[way], own, place / f"trial-{number}", dice)

    return campaign


def _damaged(asked: argparse.Namespace, known: list[Known], place: Path) -> Campaign:
    if not STORED:
        kinds.flush_every(0.0)
        STORED.extend(run for own in known for run in bits.prepared(own, _made(place / own.kind.name)))
    kinds.flush_every(5.0)
    for number, dice in _numbers(asked, place.name):
        run, way = STORED[number % len(STORED)], bits.way(dice)
        yield number, run.name, way, bits.tried(run, way, place / f"trial-{number}", dice)


CAMPAIGNS: dict[str, Callable[..., Campaign]] = {
    "kills": _disturbed(kills.KILLS),
    "disk": _disturbed(kills.DISKS),
    "bits": _damaged,
    "processes": _disturbed(kills.PROCESSES),
}


def _made(directory: Path) -> Path:
    directory.mkdir(exist_ok=True)
    return directory


def _print_table(what: str, counts: Counter[tuple[str, str]]) -> None:
    """A table for the README: a row for each kind of run, a column for each outcome."""
    words = sorted({word for _, word in counts}, key=lambda word: (word not in GOOD, word))
    rows = [[what, *words], ["---"] * (len(words) + 1)]
    rows += [[kind, *(str(counts[kind, word]) for word in words)] for kind in dict.fromkeys(kind for kind, _ in counts)]
    print("\n".join(f"| {' | '.join(row)} |" for row in rows))


if __name__ == "__main__":
    sys.exit(main())
