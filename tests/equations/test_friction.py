"""The friction of a film at one time: closed forms, signs, units, and what the budget of energy says of it."""

from dataclasses import replace
from functools import cache
from math import exp, pi

import jax
import numpy as np
import pytest
from cases import BARUS, OIL, parse_case, rolled, steady_solver
from closed_forms import hertz_mean_stress
from numpy.testing import assert_allclose

from ertel.case.case import Case
from ertel.case.estimates import grid_of
from ertel.case.sections import Drive
from ertel.case.status import Status
from ertel.equations.account import Friction, friction
from ertel.equations.contact import Contact, bare_contact, traceable
from ertel.equations.thinning import ThinningFlow
from ertel.numerics.grid import Grid
from ertel.numerics.integrals import Plane
from ertel.physics.dry_contact import HERTZ_LOAD
from ertel.physics.fluidity import Limited, ReeEyring
from ertel.physics.geometry import CIRCLE
from ertel.physics.lubricant import Barus, Incompressible, Lubricant
from ertel.physics.motion import constant
from ertel.physics.scales import Parameters
from ertel.solvers import steady as solver
from ertel.solvers.grid_solution import GridSolution

FRICTION = jax.jit(friction)  # its results are read by NumPy, which compiles nothing


def square(nodes: int = 33, half_width: float = 1.5) -> Grid:
    return Grid(nodes, nodes, 2 * half_width / (nodes - 1))


def contact(grid: Grid, lambda_bar: float, alpha_bar: float, tau0: float | None = None) -> Contact:
    """Barus' oil, Newtonian or Eyring's with tau0 in units p_h a/R."""
    plain = bare_contact(CIRCLE, grid, lambda_bar, Lubricant(Barus(alpha_bar), Incompressible()))
    return plain if tau0 is None else replace(plain, flow=ThinningFlow(traceable(ReeEyring(tau0)), 1.0, 1.0, 0.0))


def of(grid: Grid, c: Contact, P: np.ndarray, H: np.ndarray, sliding: float, load: float = 1.0) -> Friction:
    return Friction(*jax.tree.map(np.asarray, FRICTION(Plane.of(grid), c, P, H, sliding, load, HERTZ_LOAD)))


def test_couette_flow_in_a_uniform_film():
    """tau = eta (u1 - u2)/h everywhere: in these units lambda_bar U S/(12 H)."""
    grid = square()
    P = np.full(grid.shape, 0.5)
    H = np.full(grid.shape, 0.2)
    tau = 0.03 * exp(2.0) * 0.7 / (12 * 0.2)
    result = of(grid, contact(grid, 0.03, 4.0), P, H, 0.7, load=0.8)
    assert_allclose(result.stress[0], tau, rtol=1e-12)
    assert_allclose(result.stress[1], 0.0)
    assert_allclose(result.loss, 0.7 * tau, rtol=1e-12)
    assert_allclose(result.sliding, [9 * tau / (0.8 * HERTZ_LOAD), 0.0], rtol=1e-12)
    assert_allclose(result.rolling, 0.0, atol=1e-15)
    assert float(result.power) == pytest.approx(9 * 0.7 * tau / HERTZ_LOAD, rel=1e-12)


def test_poiseuille_flow_in_a_uniform_film():
    """Loss h^3 (grad p)^2/(12 eta): H^3 (grad P)^2/lambda_bar; each surface is pulled by h/2 grad p."""
    grid = square()
    P = 3.0 + np.asarray(0.4 * grid.x[None, :] + 0.3 * grid.y[:, None])
    result = of(grid, contact(grid, 0.03, 0.0), P, np.full(grid.shape, 0.2), 0.0, load=0.8)
    assert_allclose(result.loss, 0.2**3 * 0.25 / 0.03, rtol=1e-11)
    assert_allclose(result.rolling, [0.5 * 0.2 * slope * 9 / (0.8 * HERTZ_LOAD) for slope in (0.4, 0.3)], rtol=1e-11)
    assert_allclose(result.stress, 0.0)


def test_no_stress_is_counted_where_the_film_cavitates():
    grid = square()
    P = np.asarray(np.where(grid.x[None, :] < 0, 1.0, 0.0) + 0 * grid.y[:, None])
    result = of(grid, contact(grid, 0.03, 0.0), P, np.full(grid.shape, 0.2), 0.7)
    assert float(np.abs(np.where(P > 0, 0.0, result.stress)).max()) == 0.0
    assert float(result.stress[0, 16, 3]) > 0.0


@pytest.mark.parametrize("sliding", [1e-4, 1e4])
def test_friction_counts_no_stress_above_the_limit(sliding: float):
    """With the flux's law the stress goes on rising above tau_L: by 5 % of it for every factor of e in the rate."""
    grid, P = hertz(33)
    law = Limited(ReeEyring(1.0), Lambda=0.5, ambient=0.1)
    c = replace(contact(grid, 1.0, 10.0), flow=ThinningFlow(traceable(law), 1.0, 1.0, 0.0))
    result = of(grid, c, P, np.full(grid.shape, 0.01), sliding)
    limit, stress = 0.1 + 0.5 * P, np.hypot(*result.stress)
    assert float(np.max(stress - limit)) < 1e-12
    if sliding > 1.0:  # all of the pressurised film is at its limit
        assert_allclose(stress, np.where(P > 0.0, limit, 0.0), rtol=1e-12)


def test_without_a_load_the_coefficients_are_zero():
    grid = square()
    nothing = np.zeros(grid.shape)
    result = of(grid, contact(grid, 0.03, 0.0), nothing, nothing + 0.2, 0.7, load=0.0)
    assert_allclose([*result.sliding, *result.rolling, result.power], 0.0)


# -- a film of uniform thickness under Hertz pressure -----------------------------------------------------------------


def hertz(nodes: int) -> tuple[Grid, np.ndarray]:
    grid = square(nodes, 1.05)
    return grid, np.sqrt(np.maximum(1.0 - np.asarray(grid.x[None, :] ** 2 + grid.y[:, None] ** 2), 0.0))


def eyring_mean(alpha_bar: float, ln_S_c: float, film: float = 1e-5) -> float:
    """The mean of tau/tau0 over the contact.  tau0 = 1, so that pressure in a film so thin does not shear the oil."""
    grid, P = hertz(129)
    speed = exp(ln_S_c - 2 / 3 * alpha_bar) * 12 * film  # with lambda_bar = 1 the shear stress at p = 0 is speed/(12 H)
    result = of(grid, contact(grid, 1.0, alpha_bar, tau0=1.0), P, np.full(grid.shape, film), speed)
    return float(result.sliding[0]) * HERTZ_LOAD / pi


@pytest.mark.parametrize("alpha_bar", [10.0, 20.0, 30.0])
def test_the_mean_stress_of_an_eyring_oil_under_hertz_pressure(alpha_bar: float):
    """To three digits."""
    for ln_S_c in (-2, 0, 4, 8):
        assert eyring_mean(alpha_bar, ln_S_c) == pytest.approx(hertz_mean_stress(exp(ln_S_c), alpha_bar), rel=1e-3)


COMPARED = [name for name in Friction._fields if name != "boundary"]  # which only asperities have


def test_an_eyring_oil_of_high_stress_is_newtonian():
    grid, P = hertz(129)
    H = np.full(grid.shape, 0.1) + 0.02 * np.asarray(grid.x[None, :])
    thin, plain = (of(grid, contact(grid, 0.1, 4.0, tau0), P, H, 0.7) for tau0 in (1e8, None))
    for name in COMPARED:
        expected = np.asarray(getattr(plain, name))
        assert_allclose(getattr(thin, name), expected, rtol=1e-9, atol=1e-11 * np.abs(expected).max(), err_msg=name)


def test_the_coefficients_do_not_depend_on_the_units():
    """A contact in SI is the dimensionless one with its lambda_bar and alpha_bar; a/R turns units into coefficients."""
    ball = {"kind": "rolling", "radius": "12 mm", "load": "30 N", "mean_speed": "0.7 m/s", "E_prime": "220 GPa"}
    oil = {"eta0": "30 mPa*s", "alpha": "18 / GPa", "viscosity": "barus", "density": "incompressible"}
    si = parse_case({"contact": {**ball, "slide_to_roll": 0.2}, "lubricant": oil, "solver": {"nodes": 33}})
    p, scales = si.parameters, si.scales
    assert scales is not None
    moes = rolled(p, BARUS, si.solver, Drive(slide_to_roll=0.2))
    grid = grid_of(si)
    P = np.asarray(si.geometry.dry_pressure(1.0, grid.kept_x[None, :], grid.kept_y[:, None]))
    H = 0.1 + np.asarray(si.geometry.gap(grid.kept_x[None, :], grid.kept_y[:, None]))
    one, two = (film_of(case, grid, P, H).account.friction for case in (si, moes))
    for name in COMPARED:
        assert_allclose(getattr(one, name), getattr(two, name), rtol=1e-9, atol=1e-12, err_msg=name)
    # in SI: the integral of eta (u1 - u2)/h over the load
    pascal = 0.03 * np.exp(18e-9 * np.asarray(P) * scales.p_h) * 0.2 * 0.7 / (np.asarray(H) * scales.film)
    force = float(Plane.of(grid).total(np.where(P > 0, np.asarray(pascal), 0.0))) * scales.a**2
    assert float(one.sliding[0]) * scales.a_over_R == pytest.approx(force / 30.0, rel=1e-9)
    pressed = Plane.of(grid).total(one.loss - 0.2 * one.stress[0]) * scales.a**2 * scales.power_per_area
    assert float(one.power) * scales.power == pytest.approx(0.2 * 0.7 * force + float(pressed), rel=1e-9)


def film_of(case: Case, grid: Grid, P: np.ndarray, H: np.ndarray) -> GridSolution:
    return GridSolution(case, grid, P, H, 1.0, 0.0, Status.CONVERGED, 0, 0, 0.0)


# -- solved contacts --------------------------------------------------------------------------------------------------

pressure_only_inside = pytest.mark.usefixtures("nothing_outside")


@cache
def films(speed: float = 1.0, slide_to_roll: float = 0.3) -> tuple[GridSolution, ...]:
    """A contact on grids of 33 and 65 nodes."""
    drive = Drive(entrainment=constant(speed), slide_to_roll=slide_to_roll)
    case = rolled(Parameters.from_moes(20, 5), OIL, steady_solver(65, inlet=None, half_width=4.0), drive)
    return solver.steady_film(case).solutions


@pressure_only_inside
@pytest.mark.parametrize(
    "motion", [(-1.0, 0.3), *(pytest.param(m, marks=pytest.mark.slow) for m in ((1.0, 0.3), (1.0, -0.3)))]
)
def test_the_surfaces_spend_what_heats_the_oil(motion: tuple[float, float]):
    """Sliding speed times sliding force, and rolling speed times the resistance of both: of order 2 as the budget."""
    speed, ratio = motion
    errors = []
    for s in films(*motion):
        terms, result, _ = s.account
        of_sliding, of_rolling = float(result.sliding[0]) * ratio * speed, 2 * float(result.rolling[0]) * speed
        assert of_sliding > 0 and of_rolling > 0
        assert float(result.power) == pytest.approx(of_sliding + terms["dissipation"], rel=1e-12)
        assert of_rolling == pytest.approx(terms["power_from_surfaces"] - terms["power_to_surfaces"], rel=1e-9)
        errors.append(float(result.power) / (of_sliding + of_rolling - terms["outside_power"]) - 1)
        assert result.sliding[1] == result.rolling[1] == 0.0
    assert abs(errors[-1]) < 0.01
    assert errors[0] / errors[1] > 3.5, errors


@pressure_only_inside
def test_direction():
    """The sliding coefficient changes its sign with the sliding, the rolling coefficient with the rolling."""
    there, faster, back = (films(*motion)[-1].account.friction for motion in ((1.0, 0.3), (1.0, -0.3), (-1.0, 0.3)))
    assert_allclose(faster.sliding, -there.sliding, rtol=1e-12)
    assert_allclose(faster.rolling, there.rolling, rtol=1e-12)
    assert_allclose(faster.loss, there.loss, rtol=1e-12)
    assert_allclose(back.rolling, -there.rolling, rtol=1e-5)
    assert_allclose(back.sliding, -there.sliding, rtol=1e-5)
    assert_allclose(back.loss[:, ::-1], there.loss, rtol=0, atol=1e-5 * float(there.loss.max()))
