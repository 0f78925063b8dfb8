"""Solid contact: an independent dense program at equal grid, the dry limit, counts, runs in time, balances."""

from dataclasses import replace
from functools import cache
from math import pi
from typing import Any, NamedTuple

import jax.numpy as jnp
import numpy as np
import pytest
from cases import parse_case

from ertel.equations import contact
from ertel.equations.approach import balanced
from ertel.equations.flow import steady_rate
from ertel.equations.touch import Asperities
from ertel.numerics import multigrid
from ertel.numerics.grid import Grid, Symmetry
from ertel.numerics.stencils import integral
from ertel.physics.asperities import ExponentialTouch, GapCurve, summits
from ertel.physics.geometry import CIRCLE
from ertel.physics.lubricant import DowsonHigginson, Lubricant, Roelands, roelands_exponent
from ertel.physics.scales import Parameters
from ertel.results.figures import figures_of
from ertel.runs.drive import simulate
from ertel.solvers import guesses, nonlinear, steady

GRID = Grid(49, 49, 6.0 / 48, -1.5, 0.0, Symmetry(y=True))  # P = 0 on its edge, no oil outside
LOAD = 2 * pi / 3
ALPHA, ETA0, TOLERANCE = 22e-9, 0.04, 1e-9


def exponential(pressure: float, length: float) -> Asperities:
    return Asperities.of(ExponentialTouch(pressure, length).curve(0.0, 0.0), 1.0, 1.0)


def greenwood_tripp(pressure: float, sigma: float) -> Asperities:
    k = np.linspace(-9.0, 8.0, 1200)
    return Asperities.of(GapCurve(sigma * summits(1.0, -k), pressure * summits(2.5, k)), 1.0, 1.0)


class Touched(NamedTuple):
    """share of the load, H, P, Delta; Newton and Krylov iterations."""

    share: float
    H: Any
    P: Any
    approach: float
    newton: int
    krylov: int
    converged: bool

    @property
    def numbers(self) -> tuple[float, ...]:
        return self.share, float(self.H[0, 36]), float(self.H.min()), float(self.P[0, 36]), self.approach


@cache
def film(M: float, L: float, law: str, first: float, second: float) -> Touched:
    """A steady film on the grid, from the dry contact."""
    p = Parameters.from_moes(M, L)
    oil = Lubricant(Roelands(ALPHA, roelands_exponent(ALPHA, ETA0)), DowsonHigginson(), p.alpha_bar / ALPHA)
    asperities = exponential(first, second) if law == "exponential" else greenwood_tripp(first, second)
    c = replace(contact.bare_contact(CIRCLE, GRID, p.lambda_bar, oil), asperities=asperities)
    elastic = multigrid.deformation_operators(GRID, CIRCLE.compliance, nonlinear.PRECISION, CIRCLE.reach)
    problem = nonlinear.Problem(
        c,
        elastic,
        steady_rate(1.0),
        balanced(1.0, CIRCLE.hertz_load),
        TOLERANCE,
        TOLERANCE / CIRCLE.hertz_load,
        steady.ALGORITHMS,
    )
    P, approach = guesses.dry_guess(CIRCLE, GRID, 1.0)
    lift, H = guesses.lifted(c, P, approach, LOAD, 0.025)
    P_f = np.maximum(P - np.asarray(asperities.pressure(H)), 0.0)
    s, found = nonlinear.solve(problem, P, approach - float(lift), P_f)
    share = float(integral(s.P - s.own, GRID.spacing, GRID.even)) / LOAD
    return Touched(share, s.H, s.P, float(found), int(s.newton), int(s.krylov), bool(s.converged))


# M, L, law with its two numbers; share, H_c, H_min, W(0), Delta of the dense program
DENSE = [
    (200, 10, "exponential", 3, 0.05, 0.804828, 0.083754, 0.073137, 0.96904, 0.88015),
    (200, 10, "exponential", 3, 0.02, 0.365721, 0.050541, 0.039465, 0.98620, 0.93572),
    (1000, 10, "exponential", 3, 0.02, 0.941038, 0.026011, 0.025301, 0.97941, 0.95549),
    (200, 10, "greenwood-tripp", 2, 0.05, 0.330580, 0.048894, 0.038050, 0.98693, 0.93822),
    (50, 5, "greenwood-tripp", 2, 0.05, 0.005670, 0.138046, 0.084077, 0.99542, 0.84083),
]


@pytest.mark.parametrize("row", DENSE, ids=lambda row: "-".join(map(str, row[:5])))
def test_a_dense_program_at_equal_grid(row: tuple[Any, ...]):
    found = film(*row[:5])
    assert found.converged
    assert found.numbers[0] == pytest.approx(row[5], abs=1e-5)
    assert found.numbers[1:3] == pytest.approx(row[6:8], abs=1e-6)
    assert found.numbers[3:] == pytest.approx(row[8:], abs=1e-5)
    assert found.newton <= 12 and found.krylov <= 40  # 8 and 24 without asperities


def test_a_factor_of_an_exponential_only_moves_the_bodies():
    """Without oil P does not depend on P0; Delta grows by d ln P0.  The dry film on this grid, whose speed is small."""
    soft, hard = (film(1e6, 0.5, "exponential", P0, 0.05) for P0 in (1.5, 10.0))
    assert min(soft.share, hard.share) > 0.9999
    assert soft.approach - hard.approach == pytest.approx(0.05 * np.log(10 / 1.5), rel=1e-4)
    assert float(jnp.abs(soft.P - hard.P).max()) < 1e-3
    # of the same contact on rings, by a dense program: P(0) .9284, P(1) .2419
    assert float(soft.P[0, 36]) == pytest.approx(0.9284, abs=2e-3)
    assert float(soft.P[0, 44]) == pytest.approx(0.2419, abs=0.01)


SIGMA = "100 nm"
BALL = {"radius": "10 mm", "E1": "200 GPa", "nu1": 0.3, "E2": "200 GPa", "nu2": 0.3}
OIL = {"eta0": "40 mPa*s", "alpha": "22 / GPa"}
PERSSON = {"law": "persson", "longest": "50 um", "shortest": "1 um"}


def rolling(speed: float = 0.3, load: float = 38.9, sigma: str = SIGMA, nodes: int = 33, **sections: Any) -> Any:
    about = {"kind": "rolling", **BALL, "load": f"{load} N", "mean_speed": f"{speed} m/s", "slide_to_roll": 0.1}
    surfaces = {"sigma": sigma, "asperities": PERSSON, "boundary_friction": 0.12}
    return parse_case(
        {"contact": about, "lubricant": OIL, "solver": {"nodes": nodes}, "surfaces": surfaces, **sections}
    )


@cache
def rolled(**changes: Any) -> Any:
    return simulate(rolling(**changes))


@pytest.mark.filterwarnings("ignore")
def test_the_share_falls_with_the_film_and_rises_with_load_and_roughness():
    def share(**changes: Any) -> float:
        return rolled(**changes).summary["asperity_share"]

    assert 0.999 > share(speed=0.03) > share() > share(speed=3.0) > 0.0
    assert share(load=80.0) > share() and share(sigma="150 nm") > share()


@pytest.mark.filterwarnings("ignore")
def test_the_friction_of_asperities_is_a_share_of_the_load():
    s, data = rolled().summary, rolled().dataset
    assert s["mu_boundary"] == pytest.approx(0.12 * s["asperity_share"], rel=1e-9)
    assert s["mu_oil"] + s["mu_boundary"] == pytest.approx(s["mu_sliding"], rel=1e-12)
    assert s["Lambda"] == pytest.approx(s["si"]["h_min_m"] / 100e-9)
    assert (
        float(data["P_asperity"].max()) == pytest.approx(s["P_asperity_max"])
        and (data["P"] >= data["P_asperity"]).all()
    )
    assert s["budgets"]["energy"]["imbalance"] < 0.02
    assert "asperities" in figures_of(data)
    [panel, _] = rolled().plot.asperities().axes
    assert panel.get_title().startswith("Pressure of asperities")


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore")
def test_a_starved_film_and_the_mirror_of_a_reversed_flow():
    thin = rolled(speed=0.5).summary
    starved = simulate(rolling(0.5, lubricant={**OIL, "layer": "150 nm"}, nodes=33)).summary
    assert starved["status"] == "converged" and 0.3 < starved["asperity_share"] < 1.0
    assert starved["budgets"]["mass"]["imbalance"] < 1e-6
    back = rolled(speed=-0.5).summary
    assert back["H_c"] == pytest.approx(thin["H_c"], rel=1e-9)
    assert back["asperity_share"] == pytest.approx(thin["asperity_share"], rel=1e-9)
    assert back["mu_boundary"] == pytest.approx(-thin["mu_boundary"], rel=1e-9)


@pytest.mark.filterwarnings("ignore")
def test_smooth_surfaces_are_the_limit_of_no_asperities():
    data = rolling(5.0).to_data()
    smooth = simulate(parse_case({name: part for name, part in data.items() if name != "surfaces"})).summary
    rough = rolled(speed=5.0, sigma="5 nm").summary
    assert rough["asperity_share"] < 1e-12
    assert rough["H_c"] == pytest.approx(smooth["H_c"], rel=1e-5)


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore")
def test_a_rough_ball_hits_an_oiled_plate():
    """The energy of the asperities comes back: with them the ball loses less.  At most 1.5 Newton iterations a step."""
    data = {
        "contact": {**BALL, "mass": "32.7 g", "speed": "0.1 m/s"},
        "lubricant": {"eta0": "10 mPa*s", "alpha": "22 / GPa"},
        "solver": {"nodes": 33},
        "time": {"until": "rebound", "tolerance": 2e-4},
        "surfaces": {"sigma": "600 nm", "asperities": PERSSON},
    }
    result = simulate(parse_case(data))
    s, d = result.summary, result.dataset
    assert s["status"] == "converged" and s["asperity_share"] > 0.3
    assert 0.95 < s["restitution"] < 1.0
    assert all(balance["imbalance"] < 0.01 for balance in s["budgets"].values())
    assert (
        float(d["asperity_energy"].max()) > 0.01 * 0.4
    )  # of the ball's energy at the start: without it it would not close
    assert float(d["newton_iterations"].sum()) <= 1.5 * d.sizes["time"]
