"""Stored runs of every kind, what is in them, and death in the middle of a run."""

import itertools
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from functools import cached_property
from pathlib import Path
from typing import Any

import pytest
import xarray as xr
from cases import RADIAL, SHORT_FALL, physics, stop_after

import ertel
from ertel.case.case import Case
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

    def _stored(self, name: str, *observers: Any) -> Path:
        store = RunStore.create(self._place / name, self.case, self.run)
        if observers:
            compute(store, observers)
        return store.directory

    @cached_property
    def begun(self) -> Path:
        return self._stored("begun")

    @cached_property
    def finished(self) -> Path:
        return self._stored("finished", lambda item: None)

    @cached_property
    def cut(self) -> Path:
        return self._stored("cut", stop_after(CUT[self.name]))

    def is_whole(self, run: RunStore) -> bool:
        return self._is(run.case, run.dataset(), run.summary())

    def _is(self, case: Case, data: xr.Dataset, summary: dict[str, Any] | None) -> bool:
        xr.testing.assert_identical(physics(data), physics(self.whole.dataset))
        about, expected = of_no_process(data.attrs), of_no_process(self.whole.dataset.attrs)
        if case.name != self.case.name:  # a flipped letter of the name is an edit that users may make
            assert replace(case, name=self.case.name) == self.case
            about = about | {key: expected[key] for key in ("title", "case")}
        assert about == expected
        return summary is not None and of_no_process(summary) == of_no_process(self.whole.summary)

    def opened(self, directory: Path) -> bool:
        """Whether a run is read as it should be; False where it is refused, in one sentence."""
        with _refused_in_a_sentence():
            found = RunStore.open(directory).result()
            return self._is(found.case, found.dataset, dict(found.summary))
        return False

    def resumed(self, directory: Path) -> bool:
        """Whether a run is what it should be after it was continued; False where it is refused, in one sentence."""
        with _refused_in_a_sentence():
            run = RunStore.open(directory)
            compute(run)
            return self.is_whole(run)
        return False


@contextmanager
def _refused_in_a_sentence() -> Iterator[None]:
    try:
        yield
    except StoreError as error:
        assert "\n" not in str(error) and len(str(error)) < 600


# -- death ------------------------------------------------------------------------------------------------------------


class Evil:
    """An object whose pickle runs code when it is loaded."""

    def __reduce__(self) -> tuple[object, ...]:
        return pytest.fail, ("a pickle was loaded",)


class Killed(BaseException):
    """Nobody catches it, like SIGKILL."""


@contextmanager
def killed(
    monkeypatch: pytest.MonkeyPatch, place: Any, name: str, when: str = "after", count: int = 1
) -> Iterator[None]:
    """End this block before or after the given call of a function; it may also come to its own end before."""
    original, calls = getattr(place, name), itertools.count(1)

    def deadly(*arguments: Any, **options: Any) -> Any:
        last = next(calls) == count
        if last and when == "before":
            raise Killed
        result = original(*arguments, **options)
        if last:
            raise Killed
        return result

    with monkeypatch.context() as patch:
        patch.setattr(place, name, deadly)
        try:
            yield
        except Killed:
            return
        assert next(calls) <= count, "it was killed and went on"
