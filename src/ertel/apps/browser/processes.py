"""Runs as processes of their own: started by `ertel run`, watched through their directory, stopped by SIGINT, resumed.

Each process has a session of its own, so that it goes on when the app is closed or its terminal is.  What is known of
a run comes from its directory, so that the app also shows, stops and resumes runs that were started elsewhere.
"""

import os
import signal
import subprocess
import sys
import tempfile
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from enum import Enum
from functools import lru_cache
from pathlib import Path
from time import monotonic
from typing import IO, Any

from ertel.apps.browser.folder import Folder
from ertel.model.status import Status
from ertel.results.kinds import as_now
from ertel.runs import files, progress_file

ERTEL = (sys.executable, "-P", "-m", "ertel")  # -P: a file typer.py in the folder is none of ours
STOPPED = (0, 130, -signal.SIGINT)  # exit codes of a run that ended or was asked to
FLUSH = "2"  # seconds between what a live picture can show


class Phase(Enum):
    """How a run stands."""

    COMPILING = "compiling"
    RUNNING = "running"
    STOPPING = "stopping"
    FINISHED = "finished"
    INTERRUPTED = "interrupted"
    FAILED = "failed"

    @property
    def is_active(self) -> bool:
        """Whether a process works on the run."""
        return self in (Phase.COMPILING, Phase.RUNNING, Phase.STOPPING)


@dataclass(frozen=True)
class Standing:
    """How a run stands.  progress: as in progress.json, if there is one.  seconds: since this app started it."""

    phase: Phase
    progress: Mapping[str, Any] | None = None
    message: str = ""
    seconds: float = 0.0

    @property
    def done(self) -> float:
        """The share of the run that is done."""
        return float(self.progress["done"]) if self.progress else 0.0


@dataclass
class _Started:
    """A process that this app started; its messages go to a file without a name."""

    process: subprocess.Popen[bytes]
    arguments: Sequence[str]
    messages: IO[bytes]
    since: float = field(default_factory=monotonic)
    asked_to_stop: bool = False

    def last_message(self) -> str:
        """The last sentence that the process said."""
        self.messages.seek(0)
        said = self.messages.read()[-20_000:].decode(errors="replace").splitlines()
        ours = [line.removeprefix("ertel: ") for line in said if line.startswith("ertel: ")]
        return ours[-1] if ours else f"the process ended with code {self.process.returncode} and said nothing"


class Processes:
    """The runs of a folder as processes.  command: how ertel is started."""

    def __init__(self, folder: Folder, command: Sequence[str] = ERTEL):
        self.folder, self._command = folder, command
        self._started: dict[Path, _Started] = {}

    # -- started and stopped ------------------------------------------------------------------------------------------

    def start(self, name: str, case: str) -> Path:
        """Write a case file and run it; the directory of the run, which the process makes.

        Raises OSError where the folder cannot be written.
        """
        file, run = self.folder.write_case(name, case)
        self._launch(run, ["run", str(file), "--out", str(run)])
        return run

    def resume(self, run: Path) -> None:
        """Continue a run, or begin again where it was stopped before it made its directory.

        Raises ValueError where a process works on it.
        """
        if self.standing(run).phase.is_active:
            raise ValueError(f"{self.folder.name_of(run)}: is running; there is nothing to resume")
        begun = run.exists() or run not in self._started
        self._launch(run, ["resume", str(run)] if begun else self._started[run].arguments)

    def _launch(self, run: Path, arguments: Sequence[str]) -> None:
        messages = tempfile.TemporaryFile()  # noqa: SIM115 - open as long as the process writes
        process = subprocess.Popen(
            [*self._command, *arguments, "--quiet", "--flush", FLUSH],
            cwd=self.folder.root,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=messages,
            start_new_session=True,
        )
        self._started[run] = _Started(process, arguments, messages)

    def stop(self, run: Path) -> None:
        """Ask a run to stop after its current step or grid; asked twice, it stops at once.  It can be resumed.

        Raises ValueError where no process works on it.
        """
        ours = self._started.get(run)
        if ours and ours.process.poll() is None:
            ours.asked_to_stop = True
            ours.process.send_signal(signal.SIGINT)
            return
        process = _computing(run)
        if process is None:
            raise ValueError(f"{self.folder.name_of(run)}: does not run; there is nothing to stop")
        os.kill(process, signal.SIGINT)

    def knows(self, run: Path) -> bool:
        """Whether this app started a run, the directory of which may not be there yet."""
        return run in self._started

    def ours(self) -> list[Path]:
        """The runs that this app started and that still go on."""
        return [run for run, started in self._started.items() if started.process.poll() is None]

    # -- watched ------------------------------------------------------------------------------------------------------

    def standing(self, run: Path) -> Standing:
        """How a run stands."""
        progress, ours = progress_file.read(run), self._started.get(run)
        if ours and ours.process.poll() is None:
            return Standing(_phase_of(ours, progress), progress, seconds=monotonic() - ours.since)
        if ours and ours.process.returncode not in STOPPED and not _outcome(run):
            return Standing(Phase.FAILED, progress, ours.last_message())
        if not _outcome(run) and files.is_locked(run):
            return Standing(Phase.RUNNING if progress and _lives(progress["process"]) else Phase.COMPILING, progress)
        return _ended(run, progress)


def _phase_of(ours: _Started, progress: Mapping[str, Any] | None) -> Phase:
    if ours.asked_to_stop:
        return Phase.STOPPING
    is_its = progress is not None and progress["process"] == ours.process.pid
    return Phase.RUNNING if is_its else Phase.COMPILING


def _ended(run: Path, progress: Mapping[str, Any] | None) -> Standing:
    """How a run stands that no process works on."""
    status = _outcome(run) or (progress or {}).get("status")
    if status == Status.CONVERGED.value:
        return Standing(Phase.FINISHED, progress)
    if status in (Status.INTERRUPTED.value, Status.RUNNING.value, None):
        return Standing(Phase.INTERRUPTED, progress)
    known = [each for each in Status if each.value == status]
    return Standing(Phase.FAILED, progress, f"{status}; {known[0].advice}" if known else str(status))


def summary_of(run: Path) -> dict[str, Any] | None:
    """The summary of a run, None where there is none that can be read."""
    path = run / "summary.json"
    with suppress(OSError, ValueError):
        return _summary(path, path.stat().st_mtime_ns)
    return None


@lru_cache(maxsize=64)
def _summary(path: Path, changed: int) -> dict[str, Any]:
    """The content of a file that was changed then."""
    return as_now(files.unsealed(path.read_bytes()))


def _outcome(run: Path) -> str | None:
    """The status in the summary of a run."""
    summary = summary_of(run)
    return str(summary["status"]) if summary else None


def _lives(process: int) -> bool:
    try:
        os.kill(process, 0)
    except OSError:
        return False
    return True


def _computing(run: Path) -> int | None:
    """The process that computes a run: it holds the lock, and wrote the progress."""
    progress = progress_file.read(run)
    if progress and progress["status"] == Status.RUNNING.value and files.is_locked(run) and _lives(progress["process"]):
        return int(progress["process"])
    return None
