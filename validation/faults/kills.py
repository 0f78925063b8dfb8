"""Kills: after any of them `ertel resume` gives the run that was never disturbed, and loses no flushed step."""

import random
import shutil
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from children import KILLED, Ended, Fault, command, die, die_torn, disk_full, fingerprint, gathered, in_child, terminate
from kinds import Kind, flush_every

STOPPED = (143, -15)  # exit codes after SIGTERM
EDGE = 20  # changes of files at the beginning and at the end of a run that are tried more often
LONGEST = 60.0  # s, after which a process is killed
LIMITS = (1000, 30_000)  # bytes: smaller and larger than the files of a small run


@dataclass(frozen=True)
class Known:
    """What is known of an undisturbed run.  operations: changes of files; seconds: its duration."""

    kind: Kind
    run: Path
    operations: int
    seconds: float
    found: dict[str, str]


@dataclass(frozen=True)
class Outcome:
    """How a trial ended: one word, and what explains it.  kills: how many processes were ended by force."""

    word: str
    why: str = ""
    kills: int = 0


class Trial:
    """A run in a new directory that is disturbed again and again."""

    def __init__(self, known: Known, place: Path):
        self.known, self.inside, self.run = known, place, place / "run"
        self.flushed: dict[str, int] = {}
        self.kills, self.steps = 0, list[str]()

    def go(self, fault: Fault | None = None, killed_after: float = 0.0, judge: bool = False) -> Ended:
        """Run the case, or resume it where there is something to resume."""
        start = self.known.kind.command(self.run)
        ended = command(start, self.inside, fault, self.run if judge else None, killed_after)
        for run, steps in ended.resumed.items():
            if steps < self.flushed.get(run, 0):
                ended.failure += f"lost: {self.flushed[run]} flushed, resumed from {steps}"
        self.flushed |= ended.flushed
        self.kills += ended.code in (KILLED, -9)
        self.steps.append(f"{start[0]}: {ended.code}")
        return ended

    def last(self) -> Outcome:
        """Resume without a fault and judge."""
        ended = self.go(judge=True)
        word, why = judged(ended, self.known)
        return Outcome(word, f"{why} ({', '.join(self.steps)})", self.kills)


def judged(ended: Ended, known: Known) -> tuple[str, str]:
    """The outcome of a command that should have ended well."""
    if ended.failure:
        return ended.failure.split(":")[0].split("\\n")[0][:40], ended.failure
    if "Different:" in ended.said:
        return "differs", ended.said[-300:]
    if ended.traceback:
        return "traceback", ended.said[-2000:]
    if ended.code:
        return "refused", f"exit code {ended.code}: {ended.said}"
    other = [name for name in {**known.found, **ended.found} if known.found.get(name) != ended.found.get(name)]
    return ("differs", f"in {', '.join(other)}") if other else ("equal", "")


def undisturbed(kind: Kind, place: Path) -> Known:
    """The run without a fault, with a flush after every step.  Raises RuntimeError where it fails."""
    flush_every(0.0)
    started, run = time.monotonic(), place / "run"
    ended = command(kind.command(run), place, judge=run)
    if ended.code or ended.failure:
        raise RuntimeError(f"{kind.name}: {ended.said} {ended.failure}")
    return Known(kind, run, ended.operations, time.monotonic() - started, ended.found)


# -- ways to disturb a run --------------------------------------------------------------------------------------------


def killed_once(trial: Trial, dice: random.Random) -> Outcome:
    """End before the n-th change of a file."""
    trial.go(_end(dice, trial.known.operations))
    return trial.last()


def killed_twice(trial: Trial, dice: random.Random) -> Outcome:
    """End the run, and then also the process that resumes it."""
    trial.go(_end(dice, trial.known.operations))
    trial.go(_end(dice, trial.known.operations // 2))
    return trial.last()


def stopped_and_killed(trial: Trial, dice: random.Random) -> Outcome:
    """Stop the run by SIGTERM, then end the process that resumes it."""
    n = dice.randint(1, trial.known.operations)
    ended = trial.go(Fault(terminate, n))
    if ended.traceback:
        return Outcome("traceback", f"SIGTERM before change {n}: {ended.said[-2000:]}")
    trial.go(_end(dice, trial.known.operations // 2))
    return trial.last()


def killed_at_a_time(trial: Trial, dice: random.Random) -> Outcome:
    """Send SIGKILL after a random time."""
    trial.go(killed_after=dice.uniform(0.02, 1.0) * trial.known.seconds)
    return trial.last()


def _end(dice: random.Random, operations: int) -> Fault:
    """Death anywhere in a run; more often near its end, where the outcome is written, and at its very beginning."""
    early, late = min(EDGE, operations), max(operations - EDGE, 0)
    ranges = dice.choices([(1, operations), (late + 1, operations), (1, early)], [0.6, 0.25, 0.15])[0]
    return Fault(die_torn if dice.random() < 0.3 else die, dice.randint(*ranges))


KILLS: dict[str, Callable[[Trial, random.Random], Outcome]] = {
    "killed": killed_once,
    "killed again": killed_twice,
    "stopped, killed": stopped_and_killed,
    "killed at a time": killed_at_a_time,
}


def full_disk(trial: Trial, dice: random.Random) -> Outcome:
    """No space is left from the n-th change on; later there is."""
    return _refusing(trial, Fault(disk_full, dice.randint(1, trial.known.operations), lasts=True))


def short_files(trial: Trial, dice: random.Random) -> Outcome:
    """No file may be larger than so many bytes; later it may."""
    return _refusing(trial, Fault(limit=dice.randint(*LIMITS)))


def _refusing(trial: Trial, fault: Fault) -> Outcome:
    ended = trial.go(fault)
    trial.steps.append(ended.said.strip()[-200:])
    if ended.traceback or ended.failure:
        return Outcome("traceback" if ended.traceback else "hung", ended.said[-2000:] + ended.failure)
    if ended.code and (ended.code not in (1, 2) or not ended.one_sentence):
        return Outcome("no sentence", f"exit code {ended.code}: {ended.said}")
    return trial.last()


def real_processes(trial: Trial, dice: random.Random) -> Outcome:
    """Kill `python -m ertel` at a random time, and let another process go on."""
    kind, patience = trial.known.kind, dice.uniform(1.0, LONGEST)
    workers = ("--jobs", "2") if kind.is_study else ()  # of dask
    first = _process(*kind.command(trial.run), *workers, patience=patience)
    trial.kills += first.code == -9
    trial.steps.append(f"killed after {patience:.1f} s" if trial.kills else "not killed")
    ended = _process(*kind.command(trial.run), *workers, patience=3600.0)
    if not ended.code:
        run = trial.run
        ended.found = in_child(lambda tell: tell(found={**fingerprint(run), **gathered(run)}, text=""))[0].found
    word, why = judged(ended, trial.known)
    return Outcome(word, f"{why} ({', '.join(trial.steps)})", trial.kills)


def _process(*arguments: str, patience: float) -> Ended:
    with subprocess.Popen([sys.executable, "-m", "ertel", *arguments], stderr=subprocess.PIPE, text=True) as process:
        try:
            said = process.communicate(timeout=patience)[1]
        except subprocess.TimeoutExpired:
            process.kill()
            said = process.communicate()[1]
    return Ended(process.returncode, said=said)


PROCESSES = {"SIGKILL": real_processes}
DISKS: dict[str, Callable[[Trial, random.Random], Outcome]] = {"disk full": full_disk, "files too large": short_files}


def tried(way: Callable[[Trial, random.Random], Outcome], known: Known, place: Path, dice: random.Random) -> Outcome:
    """One trial in a new directory, which is deleted where all went well."""
    place.mkdir(parents=True)
    outcome = way(Trial(known, place), dice)
    if outcome.word == "equal":
        shutil.rmtree(place)
    return outcome
