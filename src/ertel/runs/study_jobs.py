"""A run of a study as a job: an ordinary run directory, begun or continued, by whichever worker takes it."""

import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ertel.case.case import Case
from ertel.case.height_map import HeightMap
from ertel.equations import discretise
from ertel.runs.batch import shape_of
from ertel.runs.courses import Run, StepResult
from ertel.runs.store import CASE, RunStore, Taken, compute
from ertel.runs.warm_up import STEPS
from ertel.runs.workers import READY, Job, Wire

OFTEN = 0.5  # s between news
EXTENT = ("solver.half_width", "solver.half_width_y", "solver.inlet")  # numbers that a program is given


def job_of(directory: Path, case: Case) -> Job:
    """The job that brings the run in a directory to its end."""
    return Job(case.digest, run_in, (str(directory), case.to_data(), case.maps), program_of(case))


def run_in(wire: Wire, directory: str, data: Mapping[str, Any], maps: Mapping[str, HeightMap]) -> str:
    """Begin or continue the run of a case in a directory; its status.

    data, maps: of the case, see `Case.from_data`.  Raises StoreError where the directory holds something else or
    another process computes the run.
    """
    if wire.stopped():
        return "interrupted"
    store = _store(Path(directory), Case.from_data(data, maps))
    told = _Telling(wire, store.course)
    return str(compute(store, [told, lambda item: wire.stopped()])["status"])


def _store(directory: Path, case: Case) -> RunStore:
    if not (directory / CASE).exists():
        try:
            return RunStore.create(directory, case)
        except Taken:  # by another process, just now
            pass
    return RunStore.open(directory)


class _Telling:
    """An observer that tells how far a run is, and when its programs are compiled."""

    def __init__(self, wire: Wire, course: Run):
        self._wire, self._course = wire, course
        self._items, self._told = 0, 0.0

    def __call__(self, item: StepResult) -> None:
        if not item.record:
            return
        self._items += 1
        ready = self._items == STEPS + 1 and not self._course.case.is_steady  # each grid has its own programs
        if ready or time.monotonic() - self._told > OFTEN:
            self._told = time.monotonic()
            self._wire.tell({"done": self._course.fraction(item), "text": self._course.message(item), READY: ready})


def program_of(case: Case) -> str:
    """What the compiled programs of a run depend on; not M, L, tolerances, times or how far the grid reaches."""
    shape = {name: value for name, value in shape_of(case).items() if name not in EXTENT}
    across = discretise.grid_of(case).nodes_y
    return repr((case.kind, across, sorted(shape.items()), case.thermal is not None))
