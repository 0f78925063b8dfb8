"""The runs with which a run is compared for its error, and how honest the estimate is."""

from functools import cache
from typing import Any

import numpy as np
import pytest
from cases import impact

from ertel.case.case import Case
from ertel.case.definition import grid_of
from ertel.case.sections import Time
from ertel.inputs.case_files import parse_case
from ertel.physics.units import Quantity
from ertel.results.summary import comparisons, in_smaller_steps, with_error
from ertel.runs.drive import simulate
from ertel.solvers import radial


def compared(case: Case) -> dict[str, Any]:
    others = {name: simulate(other).summary for name, other in comparisons(case).items()}
    return with_error(case, simulate(case).summary, others)


@pytest.mark.parametrize("nodes", [65, 97, 129, 257, 385])
def test_the_wider_grid_has_the_spacing_and_the_nodes_of_the_half_grid(nodes: int) -> None:
    case = parse_case({"contact": {"kind": "rolling", "M": 100, "L": 5}, "solver": {"nodes": nodes}})
    half, wide = (grid_of(comparisons(case)[name]) for name in ("grid", "domain"))
    assert wide.spacing == pytest.approx(half.spacing, rel=1e-12)
    assert -wide.x[0] == pytest.approx(1.5 * -half.x[0], rel=0.03)
    assert wide.x[-1] == pytest.approx(1.5 * half.x[-1], rel=0.03)
    assert np.abs(wide.x).min() == pytest.approx(0, abs=1e-9)


def test_the_wider_radial_grid_is_as_fine_in_the_contact() -> None:
    found = comparisons(impact(200, 10, 129, solver={"method": "radial", "half_width": 4.0}))
    half, wide = (radial.radii(found[name].solver.nodes, found[name].solver.half_width) for name in ("grid", "domain"))
    assert (half[-1], wide[-1]) == (4.0, 6.0)
    assert np.diff(wide).min() == pytest.approx(np.diff(half).min(), rel=0.02)


def test_smaller_steps_have_half_the_error() -> None:
    assert in_smaller_steps(Time(step=0.02)).step == pytest.approx(0.02 * 0.5**0.5)
    assert in_smaller_steps(Time(step=Quantity(1e-5, "s"))).step == Quantity(1e-5 * 0.5**0.5, "s")
    assert in_smaller_steps(Time(tolerance=8e-4)).tolerance == pytest.approx(8e-4 / 8**0.5)


def test_a_steady_contact_has_no_error_in_time() -> None:
    assert sorted(comparisons(parse_case({"contact": {"kind": "rolling", "M": 100, "L": 5}}))) == ["domain", "grid"]


ROUGH = [
    {"nodes": 129, "half_width": 3.0, "tolerance": 5e-5},
    pytest.param({"nodes": 129, "half_width": 8.0, "tolerance": 3e-4}, marks=pytest.mark.slow),
    {"nodes": 129, "half_width": 2.0, "tolerance": 5e-5},
]


def ball(nodes: int, half_width: float, tolerance: float) -> Case:
    solver = {"method": "radial", "half_width": half_width}
    return impact(50, 5, nodes, solver=solver, time={"tolerance": tolerance})


@cache
def truth() -> dict[str, float]:
    return simulate(ball(401, 12.0, 1e-5)).summary["max_approach"]


@pytest.mark.parametrize("rough", ROUGH)
def test_the_estimate_is_honest(rough: dict[str, float]) -> None:
    """True error over estimated error: for H_c a half to 2; Delta's parts may cancel, it is never understated."""
    true, found = truth(), compared(ball(**rough))["error_estimate"]  # type: ignore[arg-type]
    ratio = {
        name: abs(found[name]["value"] - true[key]) / found[name]["error"]
        for name, key in {"H_c": "H_c", "Delta_max": "Delta"}.items()
    }
    assert 0.5 < ratio["H_c"] < 2, found["H_c"]
    assert (0.5 if rough["half_width"] == 2.0 else 0) < ratio["Delta_max"] < 2, found["Delta_max"]
    assert found["H_c"]["dominant"] == "time"
    assert rough["half_width"] > 2 or found["Delta_max"]["dominant"] == "domain"
