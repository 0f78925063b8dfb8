"""The load of the oil outside the domain: against the rigid ball, and against runs on a wide domain."""

from functools import cache

import numpy as np
import pytest
import xarray as xr
from cases import impact

from ertel.results import balances
from ertel.results.result import Result
from ertel.runs.drive import simulate

HERTZ = 2 * np.pi / 3


def rigid_ball(r: np.ndarray, w: float, gap: float) -> tuple[np.ndarray, np.ndarray]:
    """P and H of a rigid ball that comes with V = 1 through oil with lambda_bar = 0.1, where P = 0 at r = w."""
    H = gap + r**2 / 2
    return 0.1 / 4 * (H**-2 - (gap + w**2 / 2) ** -2), H


def lost(w: float, gap: float) -> float:
    """The load on the whole plane less that of `rigid_ball`, exactly: the integral of 2 pi r P."""
    H = gap + w**2 / 2
    whole = np.pi / 2 * 0.1 / gap
    within = np.pi / 2 * 0.1 * (1 / gap - 1 / H) - np.pi * w**2 * 0.1 / 4 / H**2
    return (whole - within) / HERTZ


@pytest.mark.parametrize("w", [2.0, 4.0])
@pytest.mark.parametrize("gap", [0.05, 1.0])
def test_the_load_that_a_rigid_ball_loses(w: float, gap: float) -> None:
    r = np.linspace(0.0, w, 401)
    P, H = rigid_ball(r, w, gap)
    data = xr.Dataset({"P": (("frame", "r"), P[None]), "H": (("frame", "r"), H[None])}, {"r": r})
    assert float(balances.outer_load(data)[0]) == pytest.approx(lost(w, gap), rel=0.01)


@pytest.mark.parametrize("gap", [0.05, 1.0])
def test_a_square_loses_more_than_the_circle_around_it_and_less_than_the_circle_within(gap: float) -> None:
    x = np.linspace(-2.0, 2.0, 129)
    P, H = rigid_ball(np.hypot(x[:, None], x[None, :]), 2.0, gap)
    fields = {name: (("frame", "Y", "X"), field[None]) for name, field in {"P": P, "H": H}.items()}
    found = float(balances.outer_load(xr.Dataset(fields, {"Y": x, "X": x}))[0])
    assert lost(2 * 2**0.5, gap) < found < lost(2.0, gap)
    assert found == pytest.approx(lost(4 / np.pi**0.5, gap), rel=0.05)  # the circle of the same area


@cache
def run(M: float, L: float, half_width: float) -> Result:
    return simulate(impact(M, L, 129, solver={"method": "radial", "half_width": half_width}))


def test_the_stated_error_is_the_true_one() -> None:
    """Within a factor of two, for approach and load; and the advised width is enough."""
    narrow = run(20, 5, 2.0)
    share = balances.uncertain_momentum(narrow.case, narrow.dataset)
    (said,) = [warning for warning in narrow.warnings if "outside the domain" in warning]
    assert f"uncertain by about {share:.1%} of the ball's" in said
    advised = balances.needed_half_width(narrow.case, share)
    assert f"use solver.half_width >= {advised:g}" in said
    wide = run(20, 5, advised)
    assert not any("outside the domain" in warning for warning in wide.warnings)
    for name in ("Delta", "F"):
        assert 0.5 < share / off(narrow, wide, name) < 2


def test_where_nothing_is_said_little_is_off() -> None:
    narrow, wide = run(100, 10, 2.0), run(100, 10, 4.0)
    assert not any("outside the domain" in warning for warning in narrow.warnings)
    assert max(off(narrow, wide, name) for name in ("Delta", "F")) < balances.UNCERTAIN_MOMENTUM


def off(narrow: Result, wide: Result, name: str) -> float:
    return abs(narrow.summary["max_approach"][name] / wide.summary["max_approach"][name] - 1)
