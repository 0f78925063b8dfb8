"""Solid contact: an independent dense program at equal grid, the dry limit, counts, runs in time, balances."""

from dataclasses import replace
from functools import cache
from math import pi
from typing import Any, NamedTuple

import jax.numpy as jnp
import numpy as np
import pytest
from cases import parse_case

from ertel.case.case import Case
from ertel.case.height_map import Measured
from ertel.equations import contact
from ertel.equations.approach import balanced
from ertel.equations.flow import steady_rate
from ertel.equations.touch import Asperities
from ertel.inputs.python import Oil, quantity
from ertel.inputs.python import rolling as rolling_case
from ertel.numerics import multigrid
from ertel.numerics.grid import Grid, Symmetry
from ertel.numerics.stencils import integral
from ertel.physics.asperities import ExponentialTouch, GapCurve, summits
from ertel.physics.geometry import CIRCLE
from ertel.physics.lubricant import DowsonHigginson, Lubricant, Roelands, roelands_exponent
from ertel.physics.scales import Parameters
from ertel.physics.surfaces import Feature, SelfAffine
from ertel.results.figures import figures_of
from ertel.runs.drive import simulate
from ertel.runs.store import run
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
    whole = {"contact": about, "lubricant": OIL, "solver": {"nodes": nodes}, "surfaces": surfaces}
    return parse_case({**whole, **sections})


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


def with_map(**changes: Any) -> Any:
    """A smooth ball slides on a measured disc at rest, whose short waves are the asperities."""
    heights = SelfAffine(1.5e-7, 0.8, 0.1, 2.0, period=8.0, seed=3).heights(NODES, NODES[:, None])
    shape = replace(Measured.of(heights, 800e-6 / 128), cutoff=changes.pop("cutoff", None))
    about = {**BALL, "load": "38.9 N", "mean_speed": "0.1 m/s", "slide_to_roll": 2.0, "nodes": 33} | changes
    law = {"law": "measured", **about.pop("law", {})}
    rough = [Feature(shape, 2)] if about.pop("rough", True) else []
    return rolling_case(**about, oil=Oil(**OIL), roughness=rough, surfaces={"asperities": law})


NODES = np.arange(-64, 64) / 16


@pytest.mark.filterwarnings("ignore")
def test_a_measured_map_parts_into_gap_and_law():
    """The waves that 16 cells do not resolve are the law; the run and its stored case know the same sigma."""
    case = with_map(cutoff=quantity("300 um"))
    assert 0.5 < case.sigma / 1.5e-7 < 1.0
    kept = simulate(case)
    assert kept.summary["status"] == "converged" and kept.summary["newton_iterations"] <= 12
    assert kept.summary["Lambda"] == pytest.approx(kept.summary["si"]["h_min_m"] / case.sigma)
    law_alone = simulate(with_map(cutoff=quantity("1 m")))
    assert law_alone.case.sigma == pytest.approx(1.5e-7, rel=1e-4)
    assert float(abs(kept.dataset["H"] - law_alone.dataset["H"]).max()) > 1e-3
    again = Case.from_data(case.to_data(), case.maps)
    assert again == case and again.digest == case.digest and again.sigma == case.sigma


def test_waves_that_the_grid_does_not_resolve_belong_to_the_law():
    coarse, fine = with_map(), with_map(nodes=65)
    cells = [case.features[0].shape.cutoff / case.spacing for case in (coarse, fine)]
    assert cells == pytest.approx([16, 16]) and coarse.sigma > fine.sigma
    # a cutoff that the grid cannot show: what the grid leaves out, below four cells, is in the law, too
    short = with_map(cutoff=quantity("30 um"))
    assert short.sigma == pytest.approx(with_map(cutoff=quantity(f"{4 * short.spacing * short.scales.a} m")).sigma)
    assert with_map(law={"shortest": "100 um"}).sigma < coarse.sigma


def test_a_law_of_measured_waves_needs_a_map_with_waves_left():
    with pytest.raises(ValueError, match="needs a measured map"):
        with_map(rough=False)
    with pytest.raises(ValueError, match="leave it no waves"):
        with_map(nodes=513, half_width=1.5, inlet=1.5, cutoff=quantity("10 um"))


def test_asperities_that_cannot_carry_the_load_are_refused():
    p_h = rolling().scales.p_h
    weak = {"law": "exponential", "pressure": f"{1.2 * p_h} Pa", "length": "40 nm"}
    for surfaces in ({"sigma": SIGMA, "asperities": PERSSON, "hardness": f"{1.2 * p_h} Pa"}, {"asperities": weak}):
        with pytest.raises(ValueError, match="cannot carry the load without oil"):
            rolling(surfaces=surfaces)
    assert rolling(surfaces={"sigma": SIGMA, "asperities": PERSSON, "hardness": f"{1.4 * p_h} Pa"})


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("speed", [0.3, 0.05])
def test_a_steep_law_in_a_film_far_below_the_grid_starts_from_the_dry_contact(speed: float):
    """Greenwood and Tripp's law on 65 nodes: from the coarser grid it took up to 100 Newton iterations, or failed."""
    steep = {"sigma": SIGMA, "asperities": {"law": "greenwood-tripp"}}
    result = simulate(rolling(speed, nodes=65, surfaces=steep))
    assert result.summary["status"] == "converged"
    assert int(result.dataset["newton_iterations"][-1]) <= 16


class Until:
    """Stops a run after so many steps."""

    def __init__(self, steps: int) -> None:
        self.left = steps

    def __call__(self, result: Any) -> bool:
        self.left -= 1
        return self.left == 0


@pytest.mark.filterwarnings("ignore")
def test_a_rough_ball_rolls_through_a_film_as_thin_as_its_hills(tmp_path):
    """Mass to 1 %, energy to 2 % on this coarse grid, at most 1.5 Newton iterations a step; a stop changes nothing."""
    hills = {"shape": "waviness", "amplitude": "150 nm", "wavelength_x": "300 um", "front": "-150 um", "ramp": "60 um"}
    sections = {
        "solver": {"method": "transient", "nodes": 33, "half_width": 2.0, "inlet": 2.5},
        "roughness": [hills],
        "time": {"until": 1.5, "tolerance": 1e-3},
    }
    case = rolling(0.5, **sections)
    whole = run(case, tmp_path / "whole")
    s, d = whole.summary, whole.dataset
    assert s["status"] == "converged" and float(d["asperity_share"].max()) > 0.3
    assert s["budgets"]["mass"]["imbalance"] < 0.01 and s["budgets"]["energy"]["imbalance"] < 0.02
    assert float(d["newton_iterations"].sum()) <= 1.5 * d.sizes["time"]
    assert run(case, tmp_path / "parts", observers=[Until(d.sizes["time"] // 2)]).summary["status"] == "interrupted"
    parts = run(case, tmp_path / "parts").dataset
    assert parts.sizes["time"] == d.sizes["time"]
    for name in ("asperity_share", "H_min", "P_asperity", "newton_iterations"):
        assert np.array_equal(parts[name], d[name]), name
