"""Physical input, (lambda_bar, alpha_bar), Moes' (M, L) and Hamrock and Dowson's (U, G, W) are one set of facts."""

from math import inf, isinf, nan, pi, sqrt

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ertel.physics.materials import drop_speed, reduced_modulus, sphere_mass
from ertel.physics.scales import Parameters, Scales, hamrock_dowson, impact_scales, parameters, rolling_scales


def decades(low: float, high: float) -> st.SearchStrategy[float]:
    """Numbers spread evenly over the decades from 10^low to 10^high."""
    return st.floats(low, high).map(lambda power: 10.0**power)


# from a watch's ruby to a wrecking ball, from rubber to diamond, from slow motion to a gun
IMPACTS = st.builds(
    impact_scales, R=decades(-4, 0), mass=decades(-9, 3), speed=decades(-4, 3), E_prime=decades(6, 12.3)
)
ETA0 = decades(-4, 2)
ALPHA = decades(-10, -7)
POSITIVE = decades(-6, 6)


def close(value, rel: float = 1e-12):
    return pytest.approx(value, rel=rel, abs=0)


# reference/impact.json, dimensional_example: steel ball of 20 mm on a steel plane at 0.1 m/s
STEEL = impact_scales(R=0.01, mass=0.0326726, speed=0.1, E_prime=226.37e9)
STEEL_PARAMETERS = parameters(STEEL, eta0=0.1, alpha=2.2e-8)


def test_steel_ball_of_the_reference():
    s, p = STEEL, STEEL_PARAMETERS
    scaled = s.film, s.a, s.load, s.p_h, s.t0
    assert scaled == close((3.74064e-06, 0.000193407, 109.181, 1393610000.0, 3.74064e-05), 5e-6)
    numbers = p.stokes, p.lambda_bar, p.alpha_bar, p.M, p.L
    assert numbers == close((17.3333, 0.0615385, 30.6595, 48.8118, 23.0237), 5e-6)


@given(decades(-4, 0), decades(-9, 3), decades(-4, 3), decades(6, 12.3), ETA0, ALPHA)
def test_an_impact(R, mass, speed, E_prime, eta0, alpha):
    """Its energy, Hertz' relations, equation 2, and the film where a rigid ball stops, independent of E' and m."""
    s = impact_scales(R, mass, speed, E_prime)
    assert (s.speed, s.ball_mass) == (close(speed), close(mass))
    assert 0.5 * s.ball_mass * s.speed**2 == close(4 / 15 * s.E_prime * sqrt(s.R) * s.film**2.5)
    assert s.load == close(2 / 3 * s.E_prime * sqrt(s.R) * s.film**1.5)
    assert s.p_h == close(1.5 * s.load / (pi * s.a**2))
    assert s.p_h == close(s.E_prime * s.a / (pi * s.R))
    p = parameters(s, eta0, alpha)
    assert p.lambda_bar == close(12 * eta0 * s.R**3 * s.speed / (s.a**4 * s.p_h))
    assert p.stokes == close(s.ball_mass * s.speed / (6 * pi * eta0 * s.R**2))
    film = sqrt(3 * alpha * eta0 * s.R * s.speed)  # in a Barus oil
    assert 0.5 * sqrt(p.alpha_bar * p.lambda_bar) * s.film == close(film)


@given(decades(-4, 0), decades(-3, 6), decades(-4, 2), decades(6, 12.3), ETA0, ALPHA)
def test_a_rolling_contact(R, load, mean_speed, E_prime, eta0, alpha):
    """Hertz' relation, equation 6, and U, G, W by their definition."""
    s = rolling_scales(R, load, mean_speed, E_prime)
    assert (s.front_speed, s.load) == (close(mean_speed), close(load))
    assert s.p_h == close(s.E_prime * s.a / (pi * s.R))
    assert parameters(s, eta0, alpha).lambda_bar == close(12 * eta0 * s.front_speed * s.R**2 / (s.a**3 * s.p_h))
    ugw = eta0 * s.front_speed / (s.E_prime * s.R), alpha * s.E_prime, s.load / (s.E_prime * s.R**2)
    assert hamrock_dowson(s, eta0, alpha) == close(ugw)


@given(IMPACTS, ETA0, ALPHA, decades(-3, 3), decades(-3, 3), decades(-3, 3))
def test_dimensionless_numbers_know_no_units(s, eta0, alpha, metre, second, kilogram):
    """Another system of units changes every input and no dimensionless number: Buckingham's theorem."""
    pascal = kilogram / (metre * second**2)
    other = impact_scales(s.R * metre, s.ball_mass * kilogram, s.speed * metre / second, E_prime=s.E_prime * pascal)
    p, q = parameters(s, eta0, alpha), parameters(other, eta0 * pascal * second, alpha / pascal)
    assert (q.lambda_bar, q.alpha_bar) == (close(p.lambda_bar, 1e-11), close(p.alpha_bar, 1e-11))


@given(POSITIVE, POSITIVE, POSITIVE)
def test_nabla2_both_forms_of_equation_16(lambda_bar, alpha_bar, wavelength):
    p = Parameters(lambda_bar, alpha_bar)
    assert p.M / p.L == close(4 / (alpha_bar * lambda_bar))
    assert p.nabla2(wavelength) == close(wavelength * sqrt(p.M / p.L))
    assert p.nabla2(wavelength) == close(wavelength * 2 / sqrt(alpha_bar * lambda_bar))
    if alpha_bar >= 1:
        assert p.trapped_film == close(sqrt(p.L / p.M))


def test_without_piezoviscosity():
    p = Parameters(0.01, 0.0)
    assert isinf(p.nabla2(0.5))
    assert p.trapped_film == close(0.03135)


@given(decades(9, 12), st.floats(-0.9, 0.5), decades(9, 12), st.floats(-0.9, 0.5))
def test_reduced_modulus(E1, nu1, E2, nu2):
    assert 2 / reduced_modulus(E1, nu1, E2, nu2) == close((1 - nu1**2) / E1 + (1 - nu2**2) / E2)


def test_mass_drop_and_modulus_of_steel():
    assert reduced_modulus(206e9, 0.3, 206e9, 0.3) == pytest.approx(226.37e9, abs=0.005e9)
    assert sphere_mass(radius=0.01, density=7800) == pytest.approx(0.0326726, abs=5e-8)
    assert drop_speed(height=0.1) == close(sqrt(2 * 9.80665 * 0.1))


POSITIVE_ARGUMENTS = [
    (impact_scales, {"R": 0.01, "mass": 0.03, "speed": 0.1, "E_prime": 2e11}),
    (rolling_scales, {"R": 0.01, "load": 10.0, "mean_speed": 1.0, "E_prime": 2e11}),
    (sphere_mass, {"radius": 0.01, "density": 7800.0}),
    (drop_speed, {"height": 0.1}),
    (Scales, {"R": 0.01, "E_prime": 2e11, "a": 2e-4, "p_h": 1e9, "t0": 1e-5}),
    (lambda lambda_bar: Parameters(lambda_bar, 1.0), {"lambda_bar": 1.0}),
    (lambda M: Parameters.from_moes(M, 10.0), {"M": 1.0}),
    (lambda eta0: parameters(STEEL, eta0, 2e-8), {"eta0": 1.0}),
    (lambda wavelength: STEEL_PARAMETERS.nabla2(wavelength), {"wavelength": 1.0}),
    (lambda E1=2e11, E2=2e11: reduced_modulus(E1, 0.3, E2, 0.3), {"E1": 2e11, "E2": 2e11}),
]


@pytest.mark.parametrize(
    ("function", "arguments", "name"), [(f, args, name) for f, args in POSITIVE_ARGUMENTS for name in args]
)
@pytest.mark.parametrize("bad", [0.0, -1.0, nan, inf, -inf])
def test_what_must_be_positive_is_refused_by_name(function, arguments, name, bad):
    with pytest.raises(ValueError, match=rf"^{name} = {bad}: must be finite and above zero$"):
        function(**(arguments | {name: bad}))


@pytest.mark.parametrize("bad", [-1e-9, nan, inf])
def test_what_may_be_zero_but_not_negative(bad):
    calls = {
        "alpha_bar": lambda: Parameters(0.01, bad),
        "L": lambda: Parameters.from_moes(100.0, bad),
        "alpha": lambda: parameters(STEEL, 0.1, bad),
    }
    for name, call in calls.items():
        with pytest.raises(ValueError, match=f"^{name} = {bad}: must be finite and not below zero$"):
            call()


@pytest.mark.parametrize("bad", [-1.0, 0.51, nan, inf])
def test_poissons_ratio(bad):
    with pytest.raises(ValueError, match=f"nu1 = {bad}: Poisson's ratio must be above -1 and not above 0.5"):
        reduced_modulus(2e11, bad, 2e11, 0.3)
