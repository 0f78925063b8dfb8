"""The loop: events, maps, resuming, failure, and the user's own laws."""

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import Annotated, Any, ClassVar

import jax.numpy as jnp
import numpy as np
import pytest
from cases import course_with, impact, march, steps_of

from ertel.case.case import Case
from ertel.case.status import Status
from ertel.equations.approach import NewtonsLaw, PrescribedApproach
from ertel.equations.state import Method, State, Stepping
from ertel.physics.lubricant import Oil
from ertel.physics.motion import constant
from ertel.physics.registry import VISCOSITY_LAWS
from ertel.physics.units import COMPLIANCE
from ertel.results.errors import with_error
from ertel.results.result import Result
from ertel.runs.courses import TransientRun, course_of
from ertel.runs.drive import Recorder, drive, simulate
from ertel.runs.stepping import Step
from ertel.solvers.radial import RadialImpact
from ertel.solvers.transient import Transient2D


def short(**time: object) -> Case:
    return impact(200, 10, 33, time={"until": 1.2, **time})


def simulated(case: Case, method: Method) -> Result:
    """A run in memory with a method that is not the case's own."""
    course = course_with(case, method)
    gathering = Recorder(course)
    return gathering.result(drive(course, [gathering]))


@cache
def through_the_maximum() -> Result:
    return simulate(impact(200, 10, 33, output={"interval": 0.25}, time={"until": 2.75}))


@cache
def to_the_maximum() -> Result:
    return simulate(impact(200, 10, 33))


@cache
def whole_course() -> tuple[TransientRun, list[Step]]:
    """A short run, step by step."""
    case = short()
    course = course_with(case, Transient2D(case))
    seen: list[Step] = []
    drive(course, [seen.append])
    return course, seen


def test_maps_lie_at_exact_times_and_events_are_kept() -> None:
    data = through_the_maximum().dataset
    times, events = data.frame.values, data.event.values
    np.testing.assert_allclose(times[events == 0], 0.25 * np.arange(1, 11), rtol=1e-12)  # 2.75 is the end
    assert np.sum(events == 1) == 1 and np.sum(events == 2) == 1
    assert float(data.time[-1]) == pytest.approx(2.75, rel=1e-12)


def test_values_at_maximum_approach_come_from_the_turning_point() -> None:
    result = through_the_maximum()
    peak, data = result.summary["max_approach"], result.dataset
    assert peak["Delta"] >= float(data.Delta.max()) - 1e-9
    i = int(data.Delta.values.argmax())
    assert float(data.time[i - 1]) < peak["T"] < float(data.time[i + 1])
    frame = data.isel(frame=int((data.event == 1).values.argmax()))
    assert float(frame.H.isel(X=16, Y=16)) == pytest.approx(peak["H_c"], rel=1e-14)


def test_a_resumed_run_equals_an_uninterrupted_one_bit_for_bit() -> None:
    course, whole = whole_course()
    middle = len(whole) // 2
    stored = {key: np.array(value) for key, value in course.to_arrays(whole[middle]).items()}
    rest = steps_of(course.case, course.method, course.from_arrays(stored))
    assert len(rest) == len(whole) - middle - 1
    for a, b in zip(whole[middle + 1 :], rest, strict=True):
        assert a.record == b.record
        assert a.state.counts == b.state.counts
    for a, b in zip(whole[-1].state.levels, rest[-1].state.levels, strict=True):
        assert np.array_equal(a.P, b.P) and np.array_equal(a.H, b.H)
        assert (a.T, a.approach, a.velocity) == (b.T, b.approach, b.velocity)


class Unwilling(Method):
    """A method that fails whenever the step is longer than it likes."""

    def __init__(self, method: Transient2D, longest: float):
        self.method, self.longest = method, longest
        self.coordinates = method.coordinates
        for name in ("start", "solve", "measure", "friction", "whole"):
            setattr(self, name, getattr(method, name))

    def attempt(self, levels: Sequence[State], step: float) -> Stepping:
        new = yield from self.method.attempt(levels, step)
        return new if step <= self.longest else replace(new, status=Status.NEWTON_STALLED)


def test_a_step_that_fails_is_repeated_smaller() -> None:
    case = short(until=0.2, step=0.05)
    method = Unwilling(Transient2D(case), 0.02)
    data = simulated(case, method).dataset
    assert float(data.time[-1]) == pytest.approx(0.2)
    assert float(data.dT.max()) <= 0.02
    assert float(data.rejected.sum()) > 0


def test_a_run_that_must_give_up_keeps_what_it_has() -> None:
    case = short(until=0.2)
    method = Transient2D(case)
    steps = 0

    def tire(levels: Sequence[State], step: float) -> Stepping:
        nonlocal steps
        steps += 1
        new = yield from method.attempt(levels, step)
        return new if steps <= 4 else replace(new, status=Status.NEWTON_STALLED)

    tired = Unwilling(method, 1.0)
    tired.attempt = tire  # type: ignore[method-assign]
    result = simulated(case, tired)
    assert result.status is Status.STEP_TOO_SMALL
    assert result.status.advice
    assert result.summary["status"] == "the time step became too small"
    assert result.dataset.sizes["time"] == 4


def test_a_fixed_step_is_fixed() -> None:
    data = simulate(short(step=0.05)).dataset
    np.testing.assert_allclose(data.dT.values, 0.05, rtol=1e-9)


def test_first_contact_is_resolved_automatically() -> None:
    """The step falls by itself when the oil stiffens and grows again later."""
    data = simulate(impact(1000, 10, 65)).dataset
    dT = data.dT.values
    contact = int(np.argmax(data.F.values > 0.01))
    assert dT[:contact].max() > 2.5 * dT[contact : contact + 10].min()
    assert dT[-3:].max() > 1.5 * dT[contact : contact + 10].min()


@VISCOSITY_LAWS.register("linear")
@dataclass(frozen=True)
class Linear:
    """A user's own law: eta/eta0 = 1 + beta p."""

    beta: Annotated[float, COMPLIANCE]
    reference: ClassVar[str] = "the user"

    def viscosity(self, p: Any) -> Any:
        return 1.0 + self.beta * jnp.asarray(p)


def test_a_users_own_viscosity_law_needs_no_derivative() -> None:
    case = short(until=1.0)
    p_h = case.lubricant.p_h
    case = replace(case, oil=Oil(viscosity=Linear(5.0 / p_h), density="incompressible"))
    assert float(case.lubricant.viscosity(1.0)) == pytest.approx(6.0)
    result = simulate(case)
    assert result.status is Status.CONVERGED
    assert result.summary["newton_iterations"] < 1.5 * result.summary["steps"]


@pytest.mark.parametrize("method", [Transient2D, RadialImpact])
def test_a_rig_may_prescribe_the_approach(method: type[Transient2D] | type[RadialImpact]) -> None:
    """Pressed in to Delta = 0.5 and held: the motion is the rig's, and the load that of a dry ball pressed in further,
    by part of the film that stays between."""

    def motion(T: float) -> float:
        return -1.0 + 1.5 * np.sin(np.pi / 2 * min(T / 1.5, 1.0))

    case = impact(200, 10, 65, time={"until": 2.5, "tolerance": 1e-3})
    data = simulated(case, method(case, PrescribedApproach(motion))).dataset
    np.testing.assert_allclose(data.Delta.values, [motion(T) for T in data.time.values], atol=1e-12)
    H_c = float(data.H_c[-1])
    assert H_c > 0.1
    assert 0.5**1.5 < float(data.F[-1]) < (0.5 + H_c) ** 1.5


def test_a_rig_may_press_with_a_given_load() -> None:
    """A law in which Delta has no weight, for bodies that start apart."""
    method = Transient2D(impact(20, 5, 33, time={"start_approach": -0.3}), NewtonsLaw(0.0, constant(0.3)))
    for level in march(method, 0.1, 2)[:2]:
        assert method.measure(level)["F"] == pytest.approx(0.3, rel=1e-5)


def test_the_summary_has_the_promised_keys() -> None:
    summary = to_the_maximum().summary
    reached = ["T", "Delta", "F", "P_c", "P_max", "H_c", "H_min", "X_min", "Y_min", "power_loss"]
    assert list(summary["max_approach"]) == reached
    promised = "kind lambda_bar alpha_bar M L max_approach restitution steps newton_iterations krylov_iterations"
    assert set(f"{promised} convolutions compilations wall_s status".split()) <= set(summary)
    assert summary["restitution"] is None


def test_progress_goes_from_nothing_to_all() -> None:
    for until in ("max-approach", "rebound", 2.0):
        course = course_of(impact(200, 10, 65, solver={"method": "radial"}, time={"until": until}))
        shares: list[float] = []
        drive(course, [lambda step, course=course, shares=shares: shares.append(course.progress(step).done)])
        assert 0 <= shares[0] < 0.05
        assert shares[-1] > 0.75
        assert all(a <= b for a, b in itertools.pairwise(shares))


def test_warnings_speak_where_they_should() -> None:
    coarse = simulate(impact(1000, 10, 33, time={"until": 1.2}))
    assert any("pressure sweep" in w for w in coarse.summary["warnings"])
    thin = simulate(impact(1000, 10, 33))
    assert any("the film vanishes" in w for w in thin.summary["warnings"])
    assert thin.status.value == thin.summary["status"] == "the film vanishes on this grid"
    assert (thin.summary["budgets"], thin.summary["extremes"]) == ({}, {})
    near = simulate(impact(200, 10, 33, time={"start_approach": -0.2, "until": 1.0}))
    assert any("initial gap" in w for w in near.summary["warnings"])
    small = simulate(impact(20, 5, 33, solver={"half_width": 2.0}, time={"until": 1.8}))
    assert any("outside the domain" in w for w in small.summary["warnings"])
    good = simulate(impact(200, 10, 257, solver={"method": "radial"}))
    assert good.summary["warnings"] == []


def test_error_estimate_is_exact_for_the_orders_that_it_assumes() -> None:
    def at(h: float, step: float, width: float) -> dict[str, Any]:
        H_c = 0.07 + 3 * h**2 - 2 * step**2 + 0.01 / width**3
        return {"max_approach": {"H_c": H_c, "H_min": 0.01 - h**2, "Delta": 0.96 + h**2 + 0.05 / width**3}}

    fine = at(0.01, 0.01, 2.0)
    others = {"grid": at(0.02, 0.01, 2.0), "time": at(0.02, 0.01 * 0.5**0.5, 2.0), "domain": at(0.02, 0.01, 3.0)}
    case = impact(200, 10, 33)
    found = with_error(case, fine, others)["error_estimate"]
    assert found["H_c"]["extrapolated"] == pytest.approx(0.07, rel=1e-12)
    parts = {"grid": -3e-4, "time": 2e-4, "domain": -0.00125}
    assert {name: found["H_c"][name] for name in parts} == pytest.approx(parts, rel=1e-9)
    assert found["H_c"]["error"] == pytest.approx(sum(part**2 for part in parts.values()) ** 0.5, rel=1e-9)
    assert [found[name]["dominant"] for name in ("H_c", "H_min", "Delta_max")] == ["domain", "grid", "domain"]
    assert found["Delta_max"]["value"] == fine["max_approach"]["Delta"]
    assert with_error(case, fine, {**others, "time": {"max_approach": None}})["error_estimate"] is None
