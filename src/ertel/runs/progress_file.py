"""progress.json in a run directory: how far the run is, for programs that watch it.

    {"status": "running", "T": 1.07, "step": 83, "done": 0.43, "seconds": 12.1, "seconds_left": 15.9,
     "written": "2026-11-22T10:15:03+00:00", "process": 4711}

status: as in the summary.  T: time in t0, null for a steady contact.  step: the number of time steps, or of grids.
done: the share of the run, 0 to 1, about.  seconds: since this process took the run over.  seconds_left: an estimate
from the pace so far, null before there is one, among others while programs are compiled.  written: when.

The file is renewed at most once a second, under another name and then renamed, so that readers find the old content or
the new one.  It is not part of the data of the run: without checksum, not waited for until it is on the disk, and
nothing is computed from it.  A run that was killed leaves "running" behind, until another process takes it over; the
lock tells.  `process` is a number on the machine of the run, and is never signalled.

This module does not import JAX, so that programs that only watch a run stay small.
"""

import json
import os
import time
from collections.abc import Mapping
from contextlib import suppress
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pydantic import BaseModel, Field

from ertel.case.status import Status
from ertel.runs.files import content_of

if TYPE_CHECKING:  # it brings JAX, which readers do not need
    from ertel.runs.courses import Course, Item

PROGRESS = "progress.json"
INTERVAL = 1.0  # s
LARGEST_PROCESS = 2**31  # numbers of processes are below it


class _Content(BaseModel, strict=True, extra="allow", allow_inf_nan=False):
    """The values that readers count on."""

    status: str
    T: float | None
    step: int = Field(ge=0)
    done: float = Field(ge=0.0, le=1.0)
    seconds: float
    seconds_left: float | None
    written: str
    process: int = Field(gt=0, lt=LARGEST_PROCESS)


class ProgressFile:
    """An observer that keeps the progress of a run in its directory."""

    def __init__(self, directory: Path, course: "Course"):
        self._path, self._course = directory / PROGRESS, course
        self._started = time.monotonic()
        self._first: tuple[float, float] | None = None  # time and share done when the first item came
        self._written = -INTERVAL

    def __call__(self, item: "Item") -> None:
        """Write the progress, unless it was written a moment ago."""
        now, done = time.monotonic(), self._course.fraction(item)
        if self._first is None and item.record:
            self._first = now, done
        if item.status is not Status.RUNNING or now - self._written >= INTERVAL:
            self._written = now
            self.write(item)

    def write(self, item: "Item") -> None:
        """Write the progress; a disk that refuses it stops no run."""
        done = 1.0 if item.status.ok else self._course.fraction(item)
        content = {
            "status": item.status.value,
            **self._course.place(item),
            "done": round(done, 4),
            "seconds": round(time.monotonic() - self._started, 1),
            "seconds_left": self._left(item.status, done),
            "written": datetime.now(UTC).isoformat(timespec="seconds"),
            "process": os.getpid(),
        }
        _replace(self._path, content)

    def _left(self, status: Status, done: float) -> float | None:
        """Seconds to the end at the pace since the first item; compiling came before it."""
        if status is not Status.RUNNING:
            return 0.0 if status.ok else None
        if self._first is None or done <= self._first[1]:
            return None
        then, share = self._first
        return round((time.monotonic() - then) * (1.0 - done) / (done - share), 1)


def _replace(path: Path, content: Mapping[str, Any]) -> None:
    draft = path.with_name(f"{path.name}.partial")
    try:
        draft.write_text(json.dumps(content) + "\n", encoding="ascii")
        draft.replace(path)
    except OSError:
        with suppress(OSError):
            draft.unlink()  # a full disk needs its space


def settle(directory: Path) -> None:
    """Call a run interrupted whose process was killed: the next process is at it, but has not come to an item yet."""
    found = read(directory)
    if found and found["status"] == Status.RUNNING.value:
        _replace(directory / PROGRESS, {**found, "status": Status.INTERRUPTED.value})


def read(directory: Path) -> dict[str, Any] | None:
    """The progress of a run; None where there is none or it cannot be read."""
    with suppress(OSError, ValueError):
        return _Content.model_validate_json(content_of(directory / PROGRESS)).model_dump()
    return None
