"""Line contacts: scales and numbers by hand, the dry impact of a cylinder, the oil far out, film formulas."""

import re
from math import log, pi, sqrt

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad, solve_ivp

from ertel.numerics.halfspace import line_coefficients
from ertel.physics import line_films
from ertel.physics.dry_contact import HertzLine
from ertel.physics.film_formulas import FormulaFilm
from ertel.physics.geometry import Geometry, LineContact
from ertel.physics.line_scales import LineParameters, line_impact_scales, line_rolling_scales
from ertel.physics.lubricant import Barus, DowsonHigginson, Incompressible, Lubricant, Roelands
from ertel.physics.scales import HamrockDowson, hamrock_dowson, parameters

ROLLER = line_rolling_scales(R=0.01, load=2000.0, mean_speed=1.0, E_prime=226e9, length=0.01)
FALLING = line_impact_scales(R=0.01, mass=0.3, speed=1.0, E_prime=226e9, length=0.02)


def test_scales_of_a_roller():
    p = parameters(ROLLER, eta0=0.04, alpha=20e-9)
    assert (ROLLER.a, ROLLER.p_h, ROLLER.hertz.reach) == pytest.approx((150.1173e-6, 848.163e6, 66.615), rel=1e-5)
    assert (p.lambda_bar, p.alpha_bar) == pytest.approx((0.01672898, 16.96326), rel=1e-6)
    assert ROLLER.load == pytest.approx(2000.0)
    U, G, W = hamrock_dowson(ROLLER, 0.04, 20e-9)
    assert (p.M, p.L) == pytest.approx((W / sqrt(2 * U), G * (2 * U) ** 0.25))


def test_scales_of_an_impact():
    p = parameters(FALLING, eta0=0.04, alpha=20e-9)
    assert (FALLING.a, FALLING.p_h, FALLING.hertz.reach) == pytest.approx((283.978e-6, 1.604476e9, 70.428), rel=1e-5)
    assert (p.lambda_bar, p.alpha_bar) == pytest.approx((0.0460012, 32.0895), rel=1e-5)
    assert FALLING.approach == pytest.approx(21.966e-6, rel=1e-4)
    assert FALLING.ball_mass == pytest.approx(0.3)
    assert 0.3 * 1.0**2 / 2 == pytest.approx(FALLING.energy * FALLING.hertz.inertia / 2)


@given(M=st.floats(0.1, 1e4), L=st.floats(0.0, 30.0))
def test_moes_numbers_go_both_ways(M: float, L: float):
    p = LineParameters.from_moes(M, L)
    assert (p.M, p.L) == pytest.approx((M, L))
    assert (p.at(4.0, 0.25).M, p.at(4.0, 0.25).L) == pytest.approx((8.0 * M, L / sqrt(2.0)))


def test_displacement_of_the_hertz_pressure():
    """It is kappa - X^2/2 inside the contact: the kernel fits the dry approach."""
    x = np.linspace(-1.0, 1.0, 2001)
    kernel = line_coefficients(2001, x[1] - x[0], 50.0)[0]
    P = np.sqrt(1.0 - x**2)
    for i in (1000, 1400, 1800):
        displacement = kernel[abs(np.arange(2001) - i)] @ P / pi
        assert displacement == pytest.approx(HertzLine(50.0).approach - x[i] ** 2 / 2, abs=3e-5)


def test_dry_pressure_carries_its_load():
    for load in (0.3, 1.0, 2.0):
        total = quad(
            lambda x, load=load: float(LineContact().dry_pressure(load, np.array(x), 0.0)), -1.5, 1.5, limit=200
        )[0]
        assert total == pytest.approx(load * LineContact().hertz_load, rel=1e-4)


@pytest.mark.parametrize(("reach", "turns"), [(20.0, 1.5422), (100.0, 1.5501), (1000.0, 1.5560)])
def test_dry_impact(reach: float, turns: float):
    """Newton's law with the load of the dry contact takes 2 x 1.55 kappa, and the edge moves as the energy says."""
    line = LineContact(length_ratio=reach)
    kappa = line.hertz.approach
    assert line.hertz.contact_time / 2 == pytest.approx(turns * kappa, rel=1e-4)

    def motion(T: float, y: list[float]) -> list[float]:
        load, V = y  # the load determines Delta: dDelta = V dT
        return [line.dry_load_rate(line.dry_approach(load), V) if load > 0 else 0.0, -load / line.hertz.inertia]

    done = solve_ivp(motion, (0.0, 2 * kappa), [1e-9, 1.0], rtol=1e-9, atol=1e-12, dense_output=True)
    half = [T for T in np.linspace(0.0, 2 * kappa, 4001) if done.sol(T)[1] > 0][-1]
    assert half == pytest.approx(turns * kappa, rel=1e-3)
    assert done.sol(half)[0] == pytest.approx(1.0, abs=1e-4)  # the load F* at maximum approach
    A = 0.8
    T = half * next(s for s in np.linspace(0, 1, 20001) if done.sol(half * s)[0] >= A**2)
    speed = (sqrt(done.sol(T + 1e-3)[0]) - sqrt(done.sol(T - 1e-3)[0])) / 2e-3
    assert line.hertz.front_speed(A) == pytest.approx(speed, rel=3e-4)


def test_oil_far_out_is_the_limit_of_slender_ellipses():
    X, Y = np.array([-3.0, -2.0, 2.5]), np.zeros(3)
    slender, line = Geometry(0.01), LineContact()
    assert line.far_flow(0.4, 1.0, X, Y) == pytest.approx(slender.far_flow(0.4, 1.0, X, Y), rel=0.02)
    assert line.gap(X, Y) == pytest.approx(slender.gap(X, Y))


def test_a_growing_deformation_acts_like_a_speed():
    """Reynolds' equation in a parabola that rises by ln(reach/X), integrated from far."""
    line, X = LineContact(length_ratio=30.0), 3.0
    rate = line.compliance * line.hertz_load

    def flow(x: float) -> float:  # the integral of the rate from the middle
        return rate * x * (log(30.0 / x) + 1.0)

    pressure = quad(lambda x: flow(x) / (x**2 / 2) ** 3, X, np.inf)[0]
    assert float(line.rising(np.array([X]), 1.0)[0]) / 2 / (X**2 / 2) ** 2 == pytest.approx(pressure)


FILMS = {  # of an independent dense program, Roelands' oil of 22 /GPa: M, L: H_c, H_min
    (10, 10): (0.18981, 0.16117), (20, 10): (0.08577, 0.07422), (50, 10): (0.029917, 0.02652),
    (200, 10): (0.006080, 0.00554),
}  # fmt: skip


ALPHA = 22e-9


def formulas_of(M: float, L: float, oil: Lubricant) -> list[FormulaFilm]:
    p, U, G = LineParameters.from_moes(M, L), (L / (ALPHA * 226e9)) ** 4 / 2, ALPHA * 226e9
    return line_films.line_films(p, oil, HamrockDowson(U, G, M * sqrt(2 * U)))


@pytest.mark.parametrize("M", [10, 20, 50, 200])
def test_formulas_are_as_near_as_they_say(M: int):
    central, minimum = FILMS[M, 10]
    films = {film.name: film for film in formulas_of(M, 10, Lubricant(Roelands(ALPHA, 0.6), DowsonHigginson()))}
    assert films["Dowson-Higginson"].minimum == pytest.approx(minimum, rel=0.035)
    assert -0.08 < films["Masjedi-Khonsari"].central / central - 1 < -0.01
    assert 0.12 < films["Dowson-Toyoda"].central / central - 1 < 0.36
    assert all(film.inside for film in films.values())


BARUS_FILMS = [(10, 5, 0.1505, 0.1136), (10, 15, 0.2885, 0.219), (50, 5, 0.02446, 0.01832), (50, 15, 0.0491, 0.03684)]


@pytest.mark.parametrize(("M", "L", "central", "minimum"), BARUS_FILMS)
def test_films_of_barus_oil_are_within_their_own_ranges(M: int, L: int, central: float, minimum: float):
    """Films of validation/contacts/line_formulas.md; nothing is said of the law with another density."""
    for density, compared in ((Incompressible(), True), (DowsonHigginson(), False)):
        films = formulas_of(M, L, Lubricant(Barus(ALPHA), density))
        assert [film.inside for film in films] == [compared] * 4
        assert ["not compared" in film.valid for film in films] == [not compared] * 4
        for film in films if compared else ():
            low, high = map(float, re.findall(r"([-+]?\d+) to ([-+]?\d+) %", film.valid)[0])
            known = minimum if film.central is None else central
            assert low - 0.5 <= 100 * ((film.central or film.minimum or 0.0) / known - 1) <= high + 0.5, film


def test_moes_fit_of_isoviscous_films():
    """Of L = 0 it is the minimum film; the regimes have its asymptotes."""
    for M, minimum in ((3, 0.24298), (10, 0.05201), (100, 0.003127)):
        assert line_films.expected_line_film(LineParameters.from_moes(M, 0)) == pytest.approx(minimum, rel=0.045)
    assert line_films.regime_of_line(100, 10) == "piezoviscous, elastic"
    assert line_films.regime_of_line(0.1, 0) == "isoviscous, rigid"
    assert line_films.regime_of_line(100, 0) == "isoviscous, elastic"
