"""Line contacts solved: films of an independent program, layers, symmetry, work, balances, waves, impacts."""

from dataclasses import replace
from functools import cache
from typing import Any

import jax
import numpy as np
import pytest
from cases import BARUS, ISOVISCOUS, march, parse_case

from ertel.case.case import Case
from ertel.case.height_map import HeightMap, Measured
from ertel.numerics import stencils
from ertel.numerics.grid import Grid, Symmetry, extrapolate
from ertel.physics.line_scales import LineParameters
from ertel.physics.surfaces import Feature, Waviness
from ertel.runs.drive import simulate
from ertel.runs.response import respond_in_rolling
from ertel.solvers import steady
from ertel.solvers.grid_solution import GridSolution
from ertel.solvers.transient import Transient2D

LINE = {"radius_ratio": 0}
ROLLING = {"kind": "rolling", **LINE}


def rolling(M: float = 10, L: float = 10, nodes: int = 129, oil: Any = None, **sections: Any) -> Case:
    contact = {**ROLLING, "M": M, "L": L} if L else {**ROLLING, "M": M}
    data = {"contact": contact, "solver": {"nodes": nodes}, "lubricant": oil or {}}
    return parse_case({**data, **sections})


@cache
def film(M: float = 10, L: float = 10, nodes: int = 129, layer: float | None = None) -> GridSolution:
    oil = {"layer": layer} if layer else {}
    return steady.SteadyFilm(rolling(M, L, nodes, oil)).solve([])


def impact(nodes: int = 129, length_ratio: float = 100.0, oil: Any = None, **sections: Any) -> Case:
    about = {"M": 20, "L": 10, **LINE, "length_ratio": length_ratio}
    data = {"contact": about, "solver": {"nodes": nodes}, "lubricant": oil or {}, "time": {"until": "rebound"}}
    return parse_case({**data, **sections})


@pytest.mark.parametrize(
    ("M", "L", "H_c", "H_min", "P_c", "flow"),
    [(3, 5, 0.55613, 0.44032, 0.9473, 0.58609), (10, 10, 0.18981, 0.16117, 0.98113, 0.22131)],
)
def test_steady_films(M: float, L: float, H_c: float, H_min: float, P_c: float, flow: float):
    """Of an independent dense program with an infinite inlet."""
    coarse, fine = ({**s.measure(), **s.account.terms} for s in steady.steady_film(rolling(M, L, 257)).solutions)
    found = {name: extrapolate(coarse[name], fine[name]).extrapolated for name in ("H_c", "H_min", "P_c", "inflow")}
    assert found["H_c"] == pytest.approx(H_c, rel=2e-3)
    assert found["H_min"] == pytest.approx(H_min, rel=0.01)
    assert found["P_c"] == pytest.approx(P_c, rel=1e-3)
    assert found["inflow"] == pytest.approx(flow, rel=5e-3)
    assert fine["outflow"] == pytest.approx(fine["inflow"], rel=1e-9)


BARUS_TABLE = {"viscosity": "barus", "density": "incompressible"}


@pytest.mark.parametrize(
    ("M", "L", "oil", "domain", "H_c"),
    [
        (3, 8, {}, {"half_width": 1.75, "inlet": 2.25}, 0.6898),
        pytest.param(10, 15, BARUS_TABLE, {}, 0.2880, marks=pytest.mark.slow),
    ],
)
def test_a_thick_film_is_found_from_a_dry_contact(M: float, L: float, oil: Any, domain: Any, H_c: float):
    """On each grid in a few iterations: Newton's iteration is not lost where the surfaces overlap.

    The film on the short inlet is 2.4 % above that on the usual one.  The other one is that of the dense program in
    validation/contacts/line.py, with P = 0 at X = -10.5.
    """
    solutions = steady.steady_film(rolling(M, L, 257, oil, solver={"nodes": 257, **domain})).solutions
    assert all(s.status.ok and s.newton < 20 for s in solutions)
    coarse, fine = (s.measure()["H_c"] for s in solutions)
    assert extrapolate(coarse, fine).extrapolated == pytest.approx(H_c, rel=2e-3)


@pytest.mark.slow  # four grids and three oils more
@pytest.mark.parametrize(
    ("M", "L", "oil", "H_c", "H_min"),
    [
        (20, 10, None, 0.08577, 0.07422),
        (20, 11, BARUS, 0.11011, 0.08298),
        (50, 10, None, 0.029917, 0.02652),
        (100, 11, None, 0.014273, 0.01289),
        (200, 10, None, 0.006080, 0.00554),
        (3, 0, ISOVISCOUS, 0.31109, 0.24298),
        (10, 0, ISOVISCOUS, 0.065987, 0.05201),
        (100, 0, ISOVISCOUS, 0.003933, 0.003127),
    ],
)
def test_all_steady_films(M: float, L: float, oil: Any, H_c: float, H_min: float):
    """To 0.2 %, the minimum to 1 %."""
    law = {"viscosity": oil.viscosity, "density": oil.density} if oil else {}
    *_, coarse, fine = (s.measure() for s in steady.steady_film(rolling(M, L, 2049, law)).solutions)
    assert extrapolate(coarse["H_c"], fine["H_c"]).extrapolated == pytest.approx(H_c, rel=2e-3)
    assert extrapolate(coarse["H_min"], fine["H_min"]).extrapolated == pytest.approx(H_min, rel=0.01)


def test_the_film_is_of_second_order():
    one, two, three = (s.measure()["H_c"] for s in steady.steady_film(rolling(nodes=513)).solutions)
    assert (two - one) / (three - two) == pytest.approx(4.0, rel=0.25)


def test_the_length_changes_the_approach_alone():
    """Delta by ln(Lambda)/2, under a load that is balanced."""
    short = steady.SteadyFilm(rolling(contact={**ROLLING, "M": 10, "L": 10, "length_ratio": 20})).solve([])
    assert short.H == pytest.approx(np.asarray(film().H), abs=1e-9)
    assert film().approach - short.approach == pytest.approx(np.log(5.0) / 2, abs=1e-8)


def test_a_row_may_have_as_many_nodes_as_a_side():
    assert rolling(nodes=4097).method.axes == ("X",)
    assert [grid.nodes_x for grid in steady.grids_of(rolling(nodes=4097))] == [4097, 2049, 1025, 513, 257, 129]


def test_reversed_flow_mirrors_the_film():
    back = steady.SteadyFilm(rolling(motion={"entrainment": -1.0})).solve([])
    assert np.asarray(back.P)[:, ::-1] == pytest.approx(np.asarray(film().P), abs=1e-10)


@pytest.mark.parametrize("share", [0.5, 1.5])
def test_the_film_is_the_layer_or_the_flooded_one(share: float):
    """Nothing leaks to the sides: rho_c H_c is the layer, up to what passes a flooded contact."""
    flooded = film().account.terms["inflow"]
    starved = film(layer=share * flooded)
    H_c, P_c = (starved.measure()[name] for name in ("H_c", "P_c"))
    passes = float(starved.case.lubricant.density(P_c)) * H_c
    assert passes == pytest.approx(min(share, 1.0) * flooded, rel=2e-3 if share < 1.0 else 0.02)
    assert starved.account.terms["outflow"] == pytest.approx(starved.account.terms["inflow"], rel=0.02)
    if share > 1.0:
        assert np.asarray(starved.P) == pytest.approx(np.asarray(film().P))


def test_a_layer_must_be_more_or_less_than_what_passes_at_all_times():
    flooded = film().account.terms["inflow"]
    motion = {"entrainment": [[0, 1], [1, 3]]}
    solver = {"nodes": 129, "method": "transient"}
    layers = [
        rolling(oil={"layer": r * flooded}, solver=solver, motion=motion, time={"until": 1}) for r in (0.5, 1.5, 9)
    ]
    assert steady.fed(layers[0]) is layers[0] and steady.fed(layers[2]).layer is None
    with pytest.raises(ValueError, match=r"lubricant.layer = .* is more than passes at T = 0 .*, and less"):
        steady.fed(layers[1])


def test_newton_solves_a_row_directly():
    """The preconditioner is the factorised Jacobian: two Krylov iterations with a given load, at any load."""
    for s in (film(), film(100, 10)):
        assert s.krylov == 2 * s.newton


def test_an_impact():
    """Against an independent dense program; balances, restitution, and a dry contact time.

    Delta is .05 % off on this grid, and .007 % on 257 nodes; `test_impacts_on_fine_rows` has bounds for finer ones.
    """
    values = simulate(impact()).summary
    assert values["restitution"] == pytest.approx(0.9841, abs=5e-4)
    assert values["T"] == pytest.approx(5.4299, rel=1e-3)
    assert (values["Delta"], values["F"]) == pytest.approx((2.7802, 0.9754), rel=1e-3)
    assert values["H_c"] == pytest.approx(0.1401, rel=0.02)  # of second order: 1.3 % on this grid
    for name in ("momentum", "energy"):
        assert values["budgets"][name]["imbalance"] < 1e-3


@pytest.mark.slow  # three grids of programs
@pytest.mark.parametrize(
    ("oil", "length_ratio", "of_bodies", "H_c", "H_min", "e"),
    [
        ({}, 100.0, (2.7802, 0.9754), 0.1401, 0.0192, 0.9841),
        ({}, 20.0, (1.9604, 0.9621), 0.1525, 0.0261, 0.9757),
        ({"layer": 0.3}, 100.0, (2.8058, 0.9837), 0.12239, 0.0187, 0.9913),
    ],
)
def test_impacts_on_fine_rows(oil: Any, length_ratio: float, of_bodies: Any, H_c: float, H_min: float, e: float):
    """To 0.2 %, the minimum to 1 %, approach and load to 3e-4 on the grid, restitution to 3e-4."""
    coarse, fine = (simulate(impact(nodes, length_ratio, oil)).summary for nodes in (257, 513))
    assert extrapolate(coarse["H_c"], fine["H_c"]).extrapolated == pytest.approx(H_c, rel=2e-3)
    assert extrapolate(coarse["H_min"], fine["H_min"]).extrapolated == pytest.approx(H_min, rel=0.01)
    assert (fine["Delta"], fine["F"]) == pytest.approx(of_bodies, rel=3e-4)
    assert fine["restitution"] == pytest.approx(e, abs=3e-4)


@pytest.mark.slow
def test_an_impact_on_one_side_is_that_on_both():
    """The film is even in X; it may be stored on one side."""
    cases = (impact(129, solver={"nodes": 129, "fold": fold}) for fold in (True, False))
    one, both = (march(Transient2D(case), 0.1, 15)[0] for case in cases)
    assert np.asarray(one.H)[0] == pytest.approx(np.asarray(both.H)[0, 64:], rel=1e-4)


def test_a_rigid_cylinder_comes_near():
    """Before it touches, P = lambda_bar V/(2 H^2) with H = X^2/2 - Delta."""
    level = march(Transient2D(impact(contact={"M": 200, "L": 10, **LINE})), 0.1, 5)[0]
    X = np.linspace(-3.0, 3.0, 129)[64:]
    lambda_bar = LineParameters.from_moes(200, 10).lambda_bar
    rigid = lambda_bar * level.velocity / (2 * (X**2 / 2 - level.approach) ** 2)
    assert np.asarray(level.P)[0] == pytest.approx(rigid, rel=0.02)


@pytest.mark.parametrize("even", [Symmetry(), Symmetry(x=True), Symmetry(y=True, x=True)])
def test_one_row_is_a_plane_that_does_not_change_along_y(even: Symmetry):
    """The flow in one row is that in the middle row of a plane."""
    row = Grid(33, 1, 0.1, even=even)
    rng = np.random.default_rng(1)
    P, eps = (rng.uniform(0.5, 1.0, row.shape) for _ in range(2))
    plane_even = Symmetry(False, even.x)
    tall = [np.repeat(f, 5, axis=0) for f in (P, eps)]
    one = stencils.diffusion(stencils.Pair(jax.numpy.asarray(eps)), jax.numpy.asarray(P), even)
    many = stencils.diffusion(stencils.Pair(jax.numpy.asarray(tall[1])), jax.numpy.asarray(tall[0]), plane_even)
    assert np.asarray(one)[0, :-1] == pytest.approx(np.asarray(many)[2, :-1])
    assert np.asarray(stencils.inside(jax.numpy.asarray(P), even))[0, -2] == P[0, -2]
    slopes = stencils.node_slopes(jax.numpy.asarray(P), 0.1, even)
    assert np.asarray(slopes[1]) == pytest.approx(0.0)


@pytest.mark.slow  # fine rows
def test_waves_that_pass():
    """A_d/A_i of an independent program with oil that carries waves without loss."""
    lengths = {4.0: 0.0298, 2.0: 0.0708, 1.0: 0.1792, 0.5: 0.3904, 0.25: 0.6767, 0.125: 0.890}
    waves = [[Feature(Waviness(1.0, wavelength_x=length))] for length in lengths]
    coarse, fine = (
        respond_in_rolling(rolling(100, 11, nodes), waves)["dH_amplitude"].sel(X=0.0, method="nearest").values
        for nodes in (513, 1025)
    )
    assert fine + (fine - coarse) / 3 == pytest.approx(np.array(list(lengths.values())), abs=3e-3)


def test_a_measured_profile_of_a_wave_is_the_wave():
    """The film to 1e-6, with the surface at rest; sixteen waves, so that the mirror image of each end fits."""
    wave, length = Waviness(0.01, wavelength_x=0.75), 12.0
    heights = HeightMap(wave.heights((np.arange(1024) + 0.5) * length / 1024 - length / 2, 0.0))
    measured = Measured(heights, length, rms=heights.rms, taper=0.5)
    at_rest = rolling(motion={"slide_to_roll": -2.0})
    rough = (replace(at_rest, roughness=(Feature(shape),)) for shape in (wave, measured))
    expected, found = (np.asarray(steady.SteadyFilm(case).solve([]).H) for case in rough)
    np.testing.assert_allclose(found, expected, rtol=1e-6)
    assert np.abs(found - np.asarray(film().H)).max() > 0.005


@pytest.mark.slow
def test_waves_in_time_are_those_of_the_response():
    """A run with steps of one cell reaches the periodic response."""
    wave, nodes = Waviness(1e-4, wavelength_x=1.0), 129
    case = rolling(20, 10, nodes)
    expected = float(respond_in_rolling(case, [[Feature(wave)]])["dH_amplitude"].sel(X=0.0, method="nearest")[0])
    rough = {"shape": "waviness", "amplitude": 1e-4, "wavelength_x": 1.0}
    solver = {"nodes": nodes, "method": "transient", "tolerance": 1e-7}
    time = {"step": case.spacing, "until": 8.0}
    run = simulate(rolling(20, 10, nodes, solver=solver, roughness=[rough], time=time)).dataset
    late = run["H_c"].values[run["time"].values > 6.0]
    assert (late.max() - late.min()) / 2 == pytest.approx(expected, rel=0.02)


@pytest.mark.slow
def test_a_roller_with_friction():
    """Ree-Eyring oil, 5 MPa, slide-to-roll 0.02: of the independent program."""
    contact = {"kind": "rolling", "radius": "10 mm", "length": "10 mm", "load": "2 kN", "mean_speed": "1 m/s"}
    oil = {"eta0": "40 mPa*s", "alpha": "20 / GPa", "rheology": {"law": "ree-eyring", "tau0": "5 MPa"}}
    bodies = {"E_prime": "226 GPa", "slide_to_roll": 0.02}
    data = {"contact": {**contact, **bodies}, "lubricant": oil, "solver": {"nodes": 257}}
    summary = simulate(parse_case(data)).summary
    assert summary["H_c_extrapolated"] == pytest.approx(0.1248, rel=6e-3)
    assert summary["mu_sliding"] == pytest.approx(0.02092, rel=1e-3)
