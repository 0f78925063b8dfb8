"""Which runs share their compiled programs, and compiling ahead by short runs.

A program depends on the kind of run, the number of nodes, the axes of symmetry and the laws of the oil; not on M, L,
the constants of the oil, tolerances, times or how far the grid reaches.
"""

from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from ertel.case.case import Case
from ertel.case.derived import grid_of
from ertel.case.status import Status
from ertel.inputs.case_files import parse_case
from ertel.runs.batch import shape_of
from ertel.runs.compile import compilations
from ertel.runs.courses import course_of
from ertel.runs.directory import read_progress
from ertel.runs.store import RunStore, compute

STEPS = 4  # the first three have histories of different length
STEADY, IN_TIME = 257, 129  # nodes per side: the largest of the usual grids
USUAL = (
    {"name": f"steady rolling, 33 to {STEADY}", "contact": {"kind": "rolling"}, "solver": {"nodes": STEADY}},
    {"name": f"impact, {IN_TIME}", "contact": {"kind": "impact"}, "solver": {"method": "2d", "nodes": IN_TIME}},
    {"name": f"impact, {STEADY}", "contact": {"kind": "impact"}, "solver": {"method": "2d", "nodes": STEADY}},
    {"name": "impact, radial, 401", "contact": {"kind": "impact"}, "solver": {"method": "radial", "nodes": 401}},
)
OIL = {"viscosity": "roelands", "density": "dowson-higginson", "eta0": "40 mPa*s", "alpha": "22 / GPa"}
EXTENT = ("solver.half_width", "solver.half_width_y", "solver.inlet")  # numbers that a program is given


def program_of(case: Case) -> str:
    """A text that is the same for runs that need the same compiled programs."""
    shape = {name: value for name, value in shape_of(case).items() if name not in EXTENT}
    across = grid_of(case).nodes_y
    return repr((case.kind, across, sorted(shape.items()), case.thermal is not None))


def has_compiled(case: Case, directory: Path) -> bool:
    """Say whether the run in a directory has all its programs while it goes on; each steady grid has its own."""
    said = None if case.is_steady else read_progress(directory)
    return said is not None and said["status"] == Status.RUNNING.value and said["step"] > STEPS


def usual_cases() -> Iterator[Case]:
    """Smooth contacts on the usual grids, with the usual laws of the oil."""
    for case in USUAL:
        yield parse_case({**case, "contact": {**case["contact"], "M": 200, "L": 10}, "lubricant": OIL})  # type: ignore[dict-item]


def warm_up(case: Case) -> int:
    """Compile what a run of the case needs: the number of programs that were compiled or fetched from the disk.

    A steady case is run to its end, a run in time for a few steps; the results are deleted.
    """
    before = compilations()
    steps = iter(range(STEPS))

    def enough(item: Any) -> bool:
        if method is None or next(steps, None) is not None:
            return False
        method.measure(item.state.levels[0])  # as at the moments of which maps are kept
        method.friction(item.state.levels[0])
        return True

    course: Any = course_of(case)
    method = None if case.is_steady else course.method
    with TemporaryDirectory() as directory:
        compute(RunStore.create(Path(directory) / "run", case, course), [enough])
    return compilations() - before
