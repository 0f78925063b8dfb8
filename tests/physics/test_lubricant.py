"""The oil laws: their definitions, their limits, and that the solver can differentiate and compile them."""

from dataclasses import dataclass
from math import exp, log

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from ertel.equations.contact import traceable
from ertel.physics.lubricant import (
    ALPHA,
    DENSITY_PRESSURE,
    ETA0,
    P0_ROELANDS,
    Barus,
    Density,
    Doolittle,
    DowsonHigginson,
    Incompressible,
    Isoviscous,
    Lubricant,
    Modulus,
    Oil,
    Roelands,
    Tait,
    Viscosity,
    roelands_exponent,
)

P = np.linspace(0.0, 1.5, 16)  # GPa
VOLUME, OCCUPIED = 1 - np.log(1 + P / 1.312 * 12.74) / 12.74, 0.6633  # squalane's at 25 degC
FREE = OCCUPIED / (VOLUME - OCCUPIED) - OCCUPIED / (1 - OCCUPIED)
LAWS = [
    (Isoviscous(), np.ones(16)),
    (Barus(12.0), np.exp(12.0 * P)),
    (Roelands(22.0, 0.6, 0.196), np.exp(22.0 * 0.196 / 0.6 * ((1 + P / 0.196) ** 0.6 - 1))),
    (Modulus(0.05, 0.03), np.exp(P / (0.05 + 0.03 * P))),
    (Doolittle(5.258, OCCUPIED, 1.312, 11.74), np.exp(5.258 * FREE)),
    (Incompressible(), np.ones(16)),
    (DowsonHigginson(0.59), (0.59 + 1.34 * P) / (0.59 + P)),
    (Tait(1.312, 11.74), 1 / VOLUME),
]


def value(law: Viscosity | Density, pressure):
    return law.viscosity(pressure) if hasattr(law, "viscosity") else law.density(pressure)


@pytest.mark.parametrize(("law", "formula"), LAWS, ids=lambda law: type(law).__name__)
def test_every_law(law, formula):
    """Its formula; for any number, keeping shape and precision; compiled with the law as an argument."""
    assert_allclose(value(law, P.reshape(4, 4)), formula.reshape(4, 4), rtol=1e-12)
    for number in (0.5, np.float64(0.5), np.array(0.5), jnp.array(0.5)):
        assert np.shape(value(law, number)) == () and float(value(law, number)) == float(value(law, 0.5))
    assert jnp.asarray(value(law, P)).dtype == jnp.float64
    traceable(Lubricant(law, law))
    assert_allclose(jax.jit(value)(law, P), value(law, P), rtol=1e-13)
    difference = (value(law, P[1:] + 1e-6) - value(law, P[1:] - 1e-6)) / 2e-6
    assert_allclose(jax.vmap(jax.grad(lambda p: value(law, p)))(P[1:]), difference, rtol=1e-7, atol=1e-8)


@given(st.floats(0.8, 2.0), st.floats(5.0, 15.0), st.floats(0.5, 0.7), st.floats(2.0, 6.0))
def test_laws_begin_at_ambient_pressure_as_they_say(K0, K0_prime, R, B):
    """d ln(eta)/dp = alpha, whatever Roelands' z and p0; K = rho dp/drho is K0, and dK/dp is K0'."""
    doolittle, tait = Doolittle(B, R, K0, K0_prime), Tait(K0, K0_prime)
    for law, alpha in ((Barus(B), B), (Roelands(B, R, K0), B), (doolittle, doolittle.alpha)):
        slope = jax.grad(lambda p, law=law: jnp.log(law.viscosity(p)))(0.0)
        assert slope == pytest.approx(alpha, rel=1e-10)
    modulus, change = jax.value_and_grad(lambda p: tait.density(p) / jax.grad(tait.density)(p))(0.0)
    assert (modulus, change) == (pytest.approx(K0, rel=1e-12), pytest.approx(K0_prime, rel=1e-9))


def test_new_constants_need_no_new_compilation():
    traces: list[Barus] = []
    traceable(Lubricant(Barus(1.0), Incompressible()))

    @jax.jit
    def viscosity(law, pressure):
        traces.append(law)
        return law.viscosity(pressure)

    for alpha_bar in (5.0, 10.0, 20.0):
        assert_allclose(viscosity(Barus(alpha_bar), P), np.exp(alpha_bar * P), rtol=1e-13)
    assert len(traces) == 1


@dataclass(frozen=True)
class PowerLaw:
    """A user's own law: eta/eta0 = (1 + c P)^n."""

    c: float
    n: float

    def viscosity(self, pressure):
        return (1 + self.c * pressure) ** self.n


def test_a_users_own_law_takes_its_place():
    oil = traceable(Lubricant(PowerLaw(3.0, 4.0), DowsonHigginson(2.0)))
    flow = jax.jit(lambda oil, p: oil.density(p) / oil.viscosity(p))
    assert_allclose(flow(oil, P), DowsonHigginson(2.0).density(P) / (1 + 3 * P) ** 4, rtol=1e-13)
    assert jax.grad(lambda p: oil.viscosity(p))(0.0) == pytest.approx(12.0)


# -- in SI ------------------------------------------------------------------------------------------------------------


@given(st.floats(1e-8, 3e-8), st.floats(0.005, 1.0), st.floats(1e8, 2e9), st.floats(0.0, 2e9))
def test_the_laws_are_the_formulas_of_the_books_in_any_unit_of_pressure(alpha, eta0, p_h, p):
    """eta = eta0 exp{(ln eta0 + 9.67)[(1 + p/p0)^z - 1]}, rho = rho0 (p1 + 1.34 p)/(p1 + p), p in Pa, eta0 in Pa s."""
    oil = Oil(eta0=eta0, alpha=alpha)
    seen = oil.under(p_h)
    z = alpha * 1.96e8 / (log(eta0) + 9.67)
    viscosity = exp((log(eta0) + 9.67) * ((1 + p / 1.96e8) ** z - 1))
    assert oil.viscosity_law.viscosity(p) == pytest.approx(viscosity, rel=1e-10)
    assert seen.viscosity(p / p_h) == pytest.approx(oil.viscosity_law.viscosity(p), rel=1e-12)
    assert oil.density_law.density(p) == pytest.approx((5.9e8 + 1.34 * p) / (5.9e8 + p), rel=1e-13)
    assert seen.density(p / p_h) == pytest.approx(oil.density_law.density(p), rel=1e-12)


@given(st.floats(0.0, 2e9))
def test_the_density_of_a_mineral_oil(p):
    """Dowson and Higginson's rho/rho0 = 1 + 0.6 p/(1 + 1.7 p), p in GPa, of which (p1 + 1.34 p)/(p1 + p) is a form."""
    assert DowsonHigginson().density(p) == pytest.approx(1 + 0.6e-9 * p / (1 + 1.7e-9 * p), abs=0.011)


def test_constants_of_a_typical_mineral_oil():
    """Its z is the one of equations.md and of reference/impact.json."""
    assert Oil().completed() == Oil(eta0=0.04, alpha=2.2e-8)
    assert Oil(eta0=0.1, alpha=1e-8).completed() == Oil(eta0=0.1, alpha=1e-8)
    assert (Roelands(ALPHA, 0.6).p0, DowsonHigginson().p1) == (1.96e8, 5.9e8)
    assert roelands_exponent(ALPHA, ETA0) == pytest.approx(0.668, abs=5e-4)
    assert Oil(eta0=0.04, reference="one") == Oil(eta0=0.04, reference="another")


@pytest.mark.parametrize(
    ("oil", "viscosity", "density"),
    [
        ({"viscosity": "barus", "density": "incompressible"}, Barus(2e-8), Incompressible()),
        ({"viscosity": Barus(3e-8), "density": DowsonHigginson(6e8)}, Barus(3e-8), DowsonHigginson(6e8)),
        ({"eta0": 0.04}, Roelands(2e-8, roelands_exponent(2e-8, 0.04), P0_ROELANDS), DowsonHigginson()),
        ({"eta0": 0.04, "p0": 2e8}, Roelands(2e-8, roelands_exponent(2e-8, 0.04, 2e8), 2e8), DowsonHigginson()),
        ({"eta0": 0.04, "z": 0.6}, Roelands(2e-8, 0.6, P0_ROELANDS), DowsonHigginson()),
        ({"alpha": None, "viscosity": "isoviscous"}, Isoviscous(), DowsonHigginson()),
        ({"alpha": None, "viscosity": Isoviscous()}, Isoviscous(), DowsonHigginson()),
    ],
    ids=str,
)
def test_laws_by_name_as_records_and_from_data(oil, viscosity, density):
    found = Oil(**{"alpha": 2e-8, **oil})
    assert (found.viscosity_law, found.density_law) == (viscosity, density)
    assert found.is_isoviscous == (viscosity == Isoviscous())


@pytest.mark.parametrize(
    ("law", "message"),
    [
        ({"viscosity": "barus"}, "^alpha: missing; this viscosity law needs it"),
        ({"eta0": 0.04}, "^alpha: missing; this viscosity law needs it"),
        ({"alpha": 2e-8}, "^eta0: missing; this viscosity law needs it"),
        ({"alpha": 2e-8, "eta0": 6e-5}, "^eta0 = 6e-05 Pa s: Roelands' law needs"),
        ({"viscosity": "tar"}, r"^viscosity = \"tar\": allowed: 'isoviscous', 'barus' or 'roelands'"),
        ({"viscosity": "µ" + "x" * 80}, rf'^viscosity = "µ{"x" * 59}": allowed: '),
        ({"density": "lead"}, r"^density = \"lead\": allowed: 'incompressible' or 'dowson-higginson'"),
        (
            {"viscosity": PowerLaw(1.0, 2.0)},
            r"^viscosity = PowerLaw.*: PowerLaw: .*registered viscosity.*ertel\.viscosity_laws\.register",
        ),
        ({"density": Barus(1.0)}, r"^density = Barus.*: Barus: .*registered density.*ertel\.density_laws\.register"),
        ({"viscosity": "doolittle"}, r'^viscosity = "doolittle": has data of its own; give them as \{ law = "dool'),
    ],
    ids=str,
)
def test_a_law_that_is_not_known_or_lacks_its_data_is_refused(law, message):
    with pytest.raises(ValueError, match=message):
        _ = Oil(**law).viscosity_law


def test_the_enthalpy_is_the_integral_of_the_specific_volume() -> None:
    """Also in closed form: 1/rho = (1 + s)/(1 + 1.34 s), s = p/p1; an incompressible oil stores no energy."""
    oil = Lubricant(Isoviscous(), DowsonHigginson(), 1.2e9)
    s = oil.p_h * P / DENSITY_PRESSURE
    exact = (s / 1.34 + (1 - 1 / 1.34) * np.log1p(1.34 * s) / 1.34) * DENSITY_PRESSURE / oil.p_h
    assert_allclose(oil.enthalpy(P), exact, rtol=1e-6)
    small = oil.compression(np.array([1e-4]))  # P^2/(2 K), K = p1/(0.34 p_h)
    assert_allclose(small, 1e-8 / 2 * 0.34 * oil.p_h / DENSITY_PRESSURE, rtol=1e-3)
    stiff = Lubricant(Isoviscous(), Incompressible())
    assert_allclose(stiff.enthalpy(P), P, rtol=1e-14)
    assert_allclose(stiff.compression(P), 0.0, atol=1e-15)


def test_a_newtonian_oil_flows_by_the_cube_of_the_film_and_not_where_surfaces_overlap():
    """rho H^3/(eta lambda_bar), with the arrays of NumPy and through the transformations of JAX."""
    oil, H = Lubricant(Barus(2.0), DowsonHigginson(1.0)), np.array([-0.1, 0.0, 0.5, 2.0])
    eps = oil.mobility(np.full(4, 0.3), H, 0.25)
    assert_allclose(eps, oil.density(0.3) * np.array([0, 0, 0.5, 2]) ** 3 / (exp(0.6) * 0.25), rtol=1e-14)

    def thin(H):
        return Lubricant(Isoviscous(), Incompressible()).mobility(jnp.zeros(2), H, 0.5)

    value, change = jax.jvp(jax.jit(thin), (jnp.asarray([0.3, -1.0]),), (jnp.ones(2),))
    assert_allclose(value, [2 * 0.3**3, 0.0])
    assert_allclose(change, [6 * 0.3**2, 0.0])
