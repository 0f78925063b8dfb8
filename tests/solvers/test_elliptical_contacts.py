"""Elliptical contacts solved: exchange of the axes, the circle as a limit, reversed flow, work, rolling resistance."""

from collections.abc import Mapping
from dataclasses import replace
from math import pi
from typing import Any

import jax
import numpy as np
import pytest
from cases import march, parse_case

from ertel.case.case import Case
from ertel.case.estimates import grid_of
from ertel.case.sections import Drive
from ertel.equations import discretise
from ertel.equations.account import Friction, friction
from ertel.equations.state import State
from ertel.numerics.integrals import Plane
from ertel.numerics.stencils import unfolded
from ertel.physics.dry_contact import hertz_ellipse
from ertel.physics.surfaces import Feature, Waviness
from ertel.results.summary import comparisons
from ertel.runs.response import respond, respond_in_rolling, respond_linearly
from ertel.solvers import steady
from ertel.solvers.grid_solution import GridSolution
from ertel.solvers.transient import Transient2D

D, M, L = 0.4, 50.0, 5.0
KAPPA = hertz_ellipse(D).kappa
FRICTION = jax.jit(friction)


def case_of(kind: str, contact: Mapping[str, Any], **sections: Any) -> Case:
    return parse_case({"contact": {"kind": kind, **contact}, **sections})


def rolled(
    nodes: int, angle: float = 0.0, ratio: float = D, solver: Mapping[str, float] | None = None, **changes: Any
) -> Case:
    contact = {"M": M, "L": L, "radius_ratio": ratio, **changes, "entrainment_angle": f"{angle} deg"}
    return case_of("rolling", contact, solver={"nodes": nodes, **(solver or {})})


def swapped(nodes: int, angle: float, solver: Mapping[str, float] | None = None) -> Case:
    """The contact of `rolled` with x and y exchanged: M and L with the other radius; lengths are KAPPA times."""
    there = {name: KAPPA * length for name, length in (solver or {}).items()}
    return rolled(nodes, angle, 1 / D, there, M=M * D**1.25, L=L * D**0.25)


# along the axes: the grid of an ellipse of 0.1, whose program it shares
LONG = {"half_width": 3.0, "half_width_y": 6.75, "inlet": 4.5}


def whole(s: GridSolution, name: str = "H") -> np.ndarray:
    return np.asarray(unfolded(getattr(s, name), s.grid.even))


# -- exchange of the axes ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("angle", "other", "mirrored"),
    [pytest.param(0.0, 90.0, False, marks=pytest.mark.slow), (35.0, -55.0, False), (35.0, 55.0, True)],
)
def test_the_film_does_not_know_which_axis_is_called_x(angle: float, other: float, mirrored: bool) -> None:
    """In units of the swapped ellipse lengths are kappa times, films kappa^2/D times as large."""
    solver = LONG if angle == 0.0 else None
    first, second = rolled(33, angle, solver=solver), swapped(33, other, solver)
    one, two = (steady.steady_film(case).finest for case in (first, second))
    assert one.status.ok and two.status.ok
    assert one.measure()["load"] == pytest.approx(2 * pi / (3 * KAPPA), rel=1e-8)
    assert two.grid.x == pytest.approx(KAPPA * one.grid.x, abs=1e-12)
    assert two.grid.y == pytest.approx(KAPPA * one.grid.y, abs=1e-12)
    H, P = whole(two), whole(two, "P")
    H, P = (H[::-1], P[::-1]) if mirrored else (H, P)
    assert H == pytest.approx(whole(one) * KAPPA**2 / D, abs=1e-7)
    assert P == pytest.approx(whole(one, "P"), abs=1e-6)
    of_one, of_two = (friction_of(case, s) for case, s in ((first, one), (second, two)))
    unit = KAPPA / D  # a/R is as many times as large for the first
    assert of_two.sliding[0] == pytest.approx(unit * of_one.sliding[0], rel=1e-5)
    assert of_two.rolling[0] == pytest.approx(unit * of_one.rolling[0], rel=1e-4)
    assert of_two.rolling[1] == pytest.approx(unit * of_one.rolling[1] * (-1 if mirrored else 1), rel=1e-4)
    assert of_two.power == pytest.approx(unit * of_one.power, rel=1e-5)


def friction_of(case: Case, s: GridSolution) -> Friction:
    """The friction when the surfaces slide by 0.3."""
    c, load = discretise.contact_of(case, s.grid), case.geometry.hertz_load
    found = FRICTION(Plane.of(s.grid), c, s.P, s.H, 0.3, 1.0, load)
    return Friction(*(np.asarray(part) for part in found))


def dropped(ratio: float, lambda_bar: float, time_unit: float, **solver: Any) -> tuple[State, Transient2D]:
    """An impact after six steps."""
    contact = {"lambda_bar": lambda_bar, "alpha_bar": 10.0, "radius_ratio": ratio}
    case = case_of("impact", contact, solver=solver, time={"start_approach": -0.3 * time_unit})
    method = Transient2D(case)
    return march(method, 0.1 * time_unit, 6)[0], method


@pytest.mark.slow
@pytest.mark.parametrize(("nodes", "long", "half_width"), [(33, 33, 4.5), (33, 49, 3.0)])
def test_an_impact_does_not_know_which_axis_is_called_x(nodes: int, long: int, half_width: float) -> None:
    """lambda_bar goes as R^2/(t0 b^2 p_h) with t0 = b^2/(R v0): as kappa^4/D^3 on swapping; times as kappa^2/D."""
    unit, lambda_bar = KAPPA**2 / D, 0.01
    a, first = dropped(D, lambda_bar, 1.0, nodes=nodes, half_width=half_width, half_width_y=4.5)
    sides = {"half_width": 4.5 * KAPPA, "half_width_y": half_width * KAPPA}
    b, second = dropped(1 / D, lambda_bar * KAPPA**4 / D**3, unit, nodes=long, **sides)
    assert first.grid.x * KAPPA == pytest.approx(second.grid.y)
    assert first.grid.even == second.grid.even == (True, True)
    assert (b.approach / unit, b.velocity) == pytest.approx((a.approach, a.velocity), rel=1e-4)
    assert second.measure(b)["F"] == pytest.approx(first.measure(a)["F"], rel=1e-4)
    assert np.asarray(b.H).T / unit == pytest.approx(np.asarray(a.H), rel=1e-3)


# -- limits -----------------------------------------------------------------------------------------------------------


def test_reversed_flow_turns_the_film_by_half_a_turn() -> None:
    ahead = rolled(33, 35.0)
    back = parse_case({**ahead.to_data(), "motion": {"entrainment": -1.0}})
    one, two = (steady.steady_film(case).finest for case in (ahead, back))
    assert whole(two) == pytest.approx(whole(one)[::-1, ::-1], abs=1e-9)
    assert np.abs(whole(one) - whole(one)[::-1]).max() > 1e-3  # no symmetry about Y = 0 at an angle


# -- work and grids ---------------------------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize("ratio", [0.1, 10.0])
def test_the_work_does_not_grow_with_the_ellipticity(ratio: float) -> None:
    def iterations(ratio: float) -> float:
        s = steady.steady_film(rolled(33, ratio=ratio, M=200.0, L=10.0)).finest
        assert s.status.is_solved
        return s.krylov / s.newton

    assert iterations(ratio) < 1.5 * iterations(1.0)


@pytest.mark.slow
def test_rolling_resistance() -> None:
    """1/2 of the double integral of H dP/dX is near 7.5/(kappa M_BH) (Biboulet and Houpert 2010).

    With the length of the inlet it goes on rising, as its logarithm (`validation/contacts`).
    """
    case = rolled(65, ratio=0.25, M=240.5, L=10.0)
    coarse, fine = (_resistance(s) for s in steady.steady_film(case).solutions)
    p = case.parameters
    limit = 7.5 / (p.hertz.kappa * p.M_BH)
    assert p.M_BH == pytest.approx(100, rel=1e-2)
    assert fine + (fine - coarse) / 3 == pytest.approx(limit, rel=0.12)


def _resistance(s: GridSolution) -> float:
    slope = np.gradient(whole(s, "P"), s.grid.spacing, axis=1)
    return float(0.5 * (whole(s) * slope).sum() * s.grid.spacing**2)


@pytest.mark.parametrize("angle", [0.0, 35.0])
def test_runs_for_the_error_keep_the_spacing_and_widen_the_domain(angle: float) -> None:
    case = rolled(65, angle)
    found = {name: grid_of(other) for name, other in comparisons(case).items()}
    grid, half, wide = grid_of(case), found["grid"], found["domain"]
    assert (half.spacing, wide.spacing) == pytest.approx((2 * grid.spacing, 2 * grid.spacing))
    assert (half.x[0], half.x[-1], half.y[-1]) == pytest.approx((grid.x[0], grid.x[-1], grid.y[-1]))
    assert wide.x[0] < 1.3 * half.x[0] and wide.x[-1] > half.x[-1] and wide.y[-1] > 1.3 * half.y[-1]


# -- in time, and responses -------------------------------------------------------------------------------------------

WAVES = Waviness(1.0, 1.5, 1.5)


def at_rest(*features: Feature) -> Case:
    """Surface 1, of which the waves are, at rest under an ellipse at an angle."""
    return replace(rolled(33, 35.0), drive=Drive(slide_to_roll=-2.0), roughness=features)


@pytest.mark.slow
def test_a_steady_film_stays_as_it_is() -> None:
    case = parse_case({**rolled(33, 35.0).to_data(), "solver": {"method": "transient", "nodes": 33}})
    first, *_, last = march(Transient2D(case), 0.1, 3)[::-1]
    assert np.asarray(last.H) == pytest.approx(np.asarray(first.H), abs=2e-5)
    assert last.approach == pytest.approx(first.approach, abs=2e-5)


@pytest.mark.slow
def test_the_response_to_waves_is_the_change_of_the_steady_film() -> None:
    """But for the oil outside: it follows Delta in the steady film, and is left as it is in the response."""
    A = 1e-4
    high, low = (steady.steady_film(at_rest(Feature(replace(WAVES, amplitude=height)))).finest for height in (A, -A))
    found = respond_in_rolling(at_rest(), [[Feature(WAVES)]])
    change = found["dH_amplitude"][0].values * np.cos(found["dH_phase"][0].values)
    assert np.abs(high.whole((high.H - low.H) / (2 * A)) - change).max() < 5e-4


@pytest.mark.slow
def test_the_tangent_linear_impact_is_the_limit_of_the_finite_ones() -> None:
    A = 1e-4
    case = case_of(
        "impact",
        {"M": 200, "L": 10, "radius_ratio": D},
        solver={"nodes": 33, "tolerance": 1e-7},
        time={"step": 0.05, "start_approach": -0.3, "until": 0.5},
        output={"interval": 0.5},
    )
    linear = respond_linearly(case, [[Feature(WAVES)]])
    both = respond(case, [[], [Feature(replace(WAVES, amplitude=A))], [Feature(replace(WAVES, amplitude=-A))]])
    finite = (both.dH[1] - both.dH[2]).values / (2 * A)
    assert np.abs(linear.dH[0].values - finite).max() < 1e-3 * np.abs(finite).max()
