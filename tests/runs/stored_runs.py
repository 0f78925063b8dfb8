"""Stored runs of every kind, and what is in them."""

from collections.abc import Callable
from dataclasses import replace
from functools import cached_property
from pathlib import Path
from typing import Any

import pytest
import xarray as xr
from cases import RADIAL, SHORT_FALL, physics, stop_after

import ertel
from ertel.inputs.case_files import parse_case
from ertel.runs.drive import Run, result_of, run_of
from ertel.runs.files import StoreError
from ertel.runs.stepping import StepLimits, TransientRun
from ertel.runs.store import RunStore, compute
from ertel.solvers.radial import RadialImpact

OWN = ("wall_s", "compilations", "date_created")  # of the process
BALL = {"radius": "10 mm", "E_prime": "219.7802 GPa"}
OIL = {"eta0": "40 mPa*s", "alpha": "22 / GPa"}
NINE_STEPS = {"time": {"tolerance": 0.01, "until": 0.2}, "output": {"interval": 0.05}}
FALL = {**BALL, "mass": "33 g", "speed": "0.1 m/s"}
ROLL = {"kind": "rolling", **BALL, "load": "3.888524 N", "mean_speed": "0.502636 m/s"}  # M = 20, L = 10
STEADY = {"name": "small", "contact": ROLL, "lubricant": OIL, "solver": {"nodes": 65}}  # of reference/rolling.json
CASES = {
    "impact": parse_case({"name": "small", "contact": FALL, "lubricant": OIL, "solver": {"nodes": 33}, **NINE_STEPS}),
    "radial": parse_case({**RADIAL, **NINE_STEPS}),
    "steady": parse_case(STEADY),
    "ends at a time": SHORT_FALL,
    "ends at an event": parse_case({**RADIAL, "time": {"tolerance": 0.02, "until": "max-approach"}}),
    "gives up": SHORT_FALL,
}
LIMITS = {"gives up": StepLimits(first=0.03, smallest=0.02)}
CUT = {"impact": 3, "radial": 5, "steady": 1}  # items after which a run is interrupted


def of_no_process(values: dict[str, Any]) -> dict[str, Any]:
    """What two runs of a case have in common."""
    return {key: value for key, value in values.items() if key not in OWN}


class Kind:
    """A kind of run: its case, its result in memory, and its directories, made when they are asked for."""

    def __init__(self, name: str, place: Path):
        self.name, self.case, self._place = name, CASES[name], place

    @property
    def run(self) -> Run:
        limits = LIMITS.get(self.name)
        return TransientRun(self.case, RadialImpact(self.case), limits) if limits else run_of(self.case)

    @cached_property
    def whole(self) -> ertel.Result:
        return result_of(self.run)

    @cached_property
    def begun(self) -> Path:
        return RunStore.create(self._place / "begun", self.case, self.run).directory

    @cached_property
    def finished(self) -> Path:
        compute(store := RunStore.create(self._place / "finished", self.case, self.run))
        return store.directory

    @cached_property
    def cut(self) -> Path:
        compute(store := RunStore.create(self._place / "cut", self.case, self.run), [stop_after(CUT[self.name])])
        return store.directory

    def is_whole(self, run: RunStore) -> bool:
        """Whether a stored run is the one in memory; its data and its case must be."""
        found = run.result()
        xr.testing.assert_identical(physics(found.dataset), physics(self.whole.dataset))
        about, expected = of_no_process(found.dataset.attrs), of_no_process(self.whole.dataset.attrs)
        if found.case.name != self.case.name:  # a flipped letter of the name is an edit that users may make
            assert replace(found.case, name=self.case.name) == self.case
            about |= {key: expected[key] for key in ("title", "case")}
        assert about == expected
        assert of_no_process(dict(found.summary)) == of_no_process(self.whole.summary)
        return True

    def opened(self, directory: Path, do: Callable[[RunStore], object] = lambda run: None) -> bool:
        """Whether a run is as it should be, after something was done; False where it is refused, in one sentence."""
        try:
            run = RunStore.open(directory)
            do(run)
            return self.is_whole(run)
        except StoreError as error:
            assert "\n" not in str(error) and len(str(error)) < 600
        return False

    def resumed(self, directory: Path) -> bool:
        """The same, of a run that is continued."""
        return self.opened(directory, compute)


class Evil:
    """An object whose pickle runs code when it is loaded."""

    def __reduce__(self) -> tuple[object, ...]:
        return pytest.fail, ("a pickle was loaded",)
