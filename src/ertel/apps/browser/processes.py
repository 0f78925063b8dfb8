"""Runs as processes of their own: started by `ertel run`, watched through their directory, stopped by a file, resumed.

Each process has a session of its own, so that it goes on when the app is closed or its terminal is.  What is known of
a run comes from its directory, so that the app also shows, stops and resumes runs that were started elsewhere, on
another machine too.  Signals go to child processes of the app only, never to a number that a file holds.
"""

import signal
import subprocess
import sys
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from enum import Enum
from pathlib import Path
from time import monotonic
from typing import IO, Any

from ertel.apps.browser.folder import Folder, fault_of, progress_of, summary_of
from ertel.apps.terminal import capital
from ertel.case.status import Status
from ertel.results.numbers import duration
from ertel.runs import files
from ertel.runs.directory import CASE, RUNS, ask_to_stop, find_runs, is_asked_to_stop, numbered, remove

ERTEL = (sys.executable, "-P", "-m", "ertel")  # -P: a file typer.py in the folder is none of ours
STOPPED = (0, 130, 143, -signal.SIGTERM)  # exit codes of a run that ended or was asked to
KILLED = -9
TRACTION = "traction"  # where curves are
FLUSH = ("--flush", "2")  # seconds between what a live picture can show
SAID = "ertel: "  # how a message begins

COMPILING = (
    "Starting, then compiling: once per machine and grid size, usually 10 to 60 s. "
    "Later runs on this grid begin after a few seconds."
)


class Phase(Enum):
    """The phases of a run, or of a study: the word for each, and its icon."""

    NEW = "not started", "insights"
    COMPILING = "compiling", "hourglass_top"
    RUNNING = "running", "play_circle"
    STOPPING = "stopping", "pause_circle"
    FINISHED = "finished", "check_circle"
    INTERRUPTED = "interrupted", "pause_circle"
    FAILED = "failed", "error"
    DAMAGED = "cannot be read", "broken_image"

    def __init__(self, word: str, icon: str):
        self.word, self.icon = word, icon

    @property
    def is_active(self) -> bool:
        """True if a process works on the run."""
        return self in (Phase.COMPILING, Phase.RUNNING, Phase.STOPPING)


@dataclass(frozen=True)
class RunStatus:
    """The phase of a run.  progress: as in progress.json, if there is one.  seconds: since this app started it."""

    phase: Phase
    progress: Mapping[str, Any] | None = None
    message: str = ""
    seconds: float = 0.0

    @property
    def done(self) -> float:
        """The share of the run that is done."""
        return float(self.progress["done"]) if self.progress else 0.0

    @property
    def text(self) -> str:
        """The status in a sentence."""
        progress = self.progress or {}
        match self.phase:
            case Phase.COMPILING:
                return COMPILING + (f" It began {self.seconds:.0f} s ago." if self.seconds else "")
            case Phase.STOPPING:
                return "Stopping: the current step or grid is finished first, then it can be resumed."
            case Phase.FAILED | Phase.DAMAGED:
                return capital(self.message)
        place = f"grid {progress.get('step', 0)}, the coarse ones first"
        if progress.get("T") is not None:
            place = f"T = {progress['T']:.3f}, step {progress['step']}"
        place = progress.get("message", place)
        if self.phase is Phase.INTERRUPTED:
            return f"Interrupted at {place}; it can be resumed." if progress else "Interrupted before its first step."
        seconds_left = progress.get("seconds_left")
        left = "" if seconds_left is None else f", about {duration(seconds_left)} left"
        share = f"{self.done:.0%} · " if self.done else ""  # which a fit does not know
        took = f" · {duration(progress['seconds'])}" if "seconds" in progress else ""
        return f"{share}{place}{took}{left}"


@dataclass
class _Started:
    """A process that this app started; its messages go to a file without a name."""

    process: subprocess.Popen[bytes]
    arguments: Sequence[str]
    messages: IO[bytes]
    since: float = field(default_factory=monotonic)
    asked_to_stop: bool = False

    @property
    def is_alive(self) -> bool:
        return self.process.poll() is None

    @property
    def fault(self) -> str:
        """The last sentence of a process that ended by itself, and not well; empty of any other one."""
        code = self.process.poll()
        if code is None or code in STOPPED or (self.asked_to_stop and code == KILLED):
            return ""
        self.messages.seek(0)
        lines = self.messages.read()[-20_000:].decode(errors="replace").splitlines()
        said = [line.removeprefix(SAID) for line in lines if line.startswith(SAID)]
        return said[-1] if said else f"the process ended with code {code} and said nothing"


class Processes:
    """The runs of a folder as processes.  command: how ertel is started."""

    def __init__(self, folder: Folder, command: Sequence[str] = ERTEL):
        self.folder, self._command = folder, command
        self._started: dict[Path, _Started] = {}

    # -- asked for ----------------------------------------------------------------------------------------------------

    def start(self, name: str, case: str) -> Path:
        """Write a case file and run it; the directory of the run, which the process makes.

        Neither takes the name of a file that a study of the folder has as its case.  Raises OSError where the folder
        cannot be written.
        """
        file, run = self.folder.write(name, case.encode(), RUNS, but=self.folder.awaited())
        self._launch(run, ["run", str(file), "--out", str(run), *FLUSH])
        return run

    def trace(self, run: Path, values: str) -> Path:
        """Compute the traction curve of a run over slide-to-roll ratios; its directory, which the process makes."""
        place = next(each for each in numbered(self.folder.root / TRACTION / run.name) if not each.exists())
        self._launch(place, ["traction", str(run / CASE), f"--slide-to-roll={values}", "--out", str(place)])
        return place

    def resume(self, run: Path) -> None:
        """Continue a run, or begin again where it was stopped before it made its directory; begin or continue a study.

        Raises ValueError where a process works on it.
        """
        if self.status(run).phase.is_active:
            raise ValueError(f"{self.folder.name_of(run)}: is running; there is nothing to resume")
        arguments = ["resume", str(run), *FLUSH]
        if file := self.folder.file_of(run):
            arguments = [run.parent.name.removesuffix("s"), str(file), "--out", str(run)]
        elif not run.exists() and run in self._started:
            arguments = [*self._started[run].arguments]
        self._launch(run, arguments)

    def _launch(self, run: Path, arguments: Sequence[str]) -> None:
        messages = tempfile.TemporaryFile()  # noqa: SIM115 - open as long as the process writes
        process = subprocess.Popen(
            [*self._command, *arguments, "--quiet"],
            cwd=self.folder.root,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=messages,
            start_new_session=True,
        )
        self._started[run] = _Started(process, arguments, messages)

    def stop(self, run: Path) -> None:
        """Ask a run to stop after its current step or grid.  It can be resumed.

        One that this app started ends at once where it has not begun to compute, and when it is asked again.  Raises
        ValueError where no process works on the run, or where one of another program is asked again; OSError where the
        file that asks cannot be made.
        """
        ours, computes = self._started.get(run), files.is_locked(run)
        if ours and ours.is_alive:
            if ours.asked_to_stop:
                ours.process.kill()
            elif not computes:
                ours.process.terminate()
            ours.asked_to_stop = True
        elif not computes:
            raise ValueError(f"{self.folder.name_of(run)}: does not run; there is nothing to stop")
        elif is_asked_to_stop(run):
            raise ValueError(f"{self.folder.name_of(run)}: is asked to stop already; it does so after its current step")
        if computes:
            ask_to_stop(run)

    def delete(self, place: Path) -> None:
        """Delete a run, or a study with all its runs.

        Raises ValueError where a process works on it, and where its directory has files that ertel does not write;
        OSError where the system refuses.
        """
        name, runs = self.folder.name_of(place), list(find_runs(place))
        if {place, *runs} & {*self.ours()}:
            raise ValueError(f"{name}: is running; stop it before you delete it")
        remove(place, name)
        for each in (place, *runs):
            self._started.pop(each, None)

    def knows(self, run: Path) -> bool:
        """True if this app started a run, the directory of which may not be there yet."""
        return run in self._started

    def ours(self) -> list[Path]:
        """The runs that this app started and that still go on."""
        return [run for run, started in self._started.items() if started.is_alive]

    # -- watched ------------------------------------------------------------------------------------------------------

    def status(self, run: Path) -> RunStatus:
        """The phase and the progress of a run."""
        if not run.exists() and run not in self._started:
            return RunStatus(Phase.NEW)
        progress, ours, summary = progress_of(run), self._started.get(run), summary_of(run)
        outcome = str(summary["status"]) if summary else None
        if ours and ours.is_alive:
            begun = progress is not None and progress.get("process", ours.process.pid) == ours.process.pid
            return RunStatus(_active(begun, ours.asked_to_stop), progress, seconds=monotonic() - ours.since)
        if outcome is None and files.is_locked(run):  # a process of another program, perhaps on another machine
            begun = progress is not None and progress["status"] == Status.RUNNING.value
            return RunStatus(_active(begun, is_asked_to_stop(run)), progress)
        if ours and outcome is None and (fault := ours.fault):
            return RunStatus(Phase.FAILED, progress, fault)
        if fault := fault_of(run):
            return RunStatus(Phase.DAMAGED, progress, fault)
        return _ended(outcome or (progress or {}).get("status"), progress)


def _active(begun: bool, asked_to_stop: bool) -> Phase:
    """The phase of a run that a process works on."""
    if asked_to_stop:
        return Phase.STOPPING
    return Phase.RUNNING if begun else Phase.COMPILING


def _ended(status: str | None, progress: Mapping[str, Any] | None) -> RunStatus:
    """The status of a run that no process works on."""
    if status == Status.CONVERGED.value:
        return RunStatus(Phase.FINISHED, progress)
    if status in (Status.INTERRUPTED.value, Status.RUNNING.value, None):
        return RunStatus(Phase.INTERRUPTED, progress)
    known = [each for each in Status if each.value == status]
    return RunStatus(Phase.FAILED, progress, f"{status}; {known[0].advice}" if known else str(status))
