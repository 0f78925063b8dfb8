"""The laws of shear thinning: their formulas, their limits, and what every law must do."""

from dataclasses import dataclass
from math import sinh
from typing import Annotated

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from numpy.testing import assert_allclose

from ertel.equations.contact import traceable
from ertel.equations.shear import shear
from ertel.physics.fluidity import Carreau, Fluidity, Limited, NewtonianOil, ReeEyring, cut_off
from ertel.physics.laws.carreau_yasuda import CarreauYasuda
from ertel.physics.units import STRESS, marks

TAU = np.array([1.0, 1e3, 1e6, 5e6, 2e7, 6e7])  # Pa
LAWS = [
    NewtonianOil(),
    ReeEyring(5e6),
    Carreau(6e6, 0.42),
    CarreauYasuda(6e6, 0.42, 1.2),
    Limited(NewtonianOil(), 0.05),
    Limited(ReeEyring(5e6), 0.05),
    Limited(Carreau(6e6, 0.42), 0.05, sharpness=0.05),
]
FLOW = jax.jit(shear)
every_law = pytest.mark.parametrize("law", LAWS, ids=str)


@every_law
def test_a_law_is_newtonian_at_rest_positive_and_rising(law: Fluidity) -> None:
    assert law.fluidity(0.0, 1e9) == pytest.approx(1.0, abs=1e-15)
    phi = law.fluidity(np.linspace(0.0, 3e8, 3001), 1e9)
    assert np.all(np.isfinite(phi)) and np.all(np.diff(phi) >= -1e-15 * phi[1:])


@every_law
def test_the_stress_is_nearly_the_inverse(law: Fluidity) -> None:
    """It starts an iteration: half to twice the stress is near enough."""
    ratio = law.stress(law.fluidity(TAU, 1e9) * TAU, 1e9) / TAU
    assert np.all((ratio > 0.5) & (ratio < 2.0))
    assert_allclose(law.stress(1e-3, 1e9), 1e-3, rtol=1e-9)


@every_law
def test_numpy_and_jax_agree_and_derivatives_are_finite(law: Fluidity) -> None:
    traceable(law)
    for method in ("fluidity", "stress"):
        of = getattr(law, method)
        assert_allclose(jax.jit(of)(jnp.asarray(TAU), jnp.full(6, 1e9)), of(TAU, np.full(6, 1e9)), rtol=1e-12)
        slope = jax.jit(jax.vmap(jax.grad(of), (0, None)))(np.array([1e-150, *TAU, 1e12]), 1e9)
        assert np.all(np.isfinite(slope))


def test_formulas() -> None:
    assert ReeEyring(5e6).fluidity(1e7, 0.0) == pytest.approx(sinh(2.0) / 2.0, rel=1e-14)
    assert ReeEyring(5e6).stress(5e6 * sinh(2.0), 0.0) == pytest.approx(1e7, rel=1e-14)
    assert Carreau(6e6, 0.5).fluidity(12e6, 0.0) == pytest.approx(5.0**0.5, rel=1e-14)
    assert CarreauYasuda(6e6, 0.5, 2.0).fluidity(TAU, 0.0) == pytest.approx(Carreau(6e6, 0.5).fluidity(TAU, 0.0))
    assert_allclose(Carreau(6e6, 1.0).fluidity(TAU, 0.0), 1.0)
    soft, sharp = (CarreauYasuda(6e6, 0.42, a).fluidity(TAU[:3], 0.0) for a in (1.0, 4.0))
    assert np.all(sharp < soft)  # it bends later
    far = Limited(ReeEyring(5e6), 0.05, 1e13)  # changes nothing
    assert_allclose(far.fluidity(TAU, 0.0), ReeEyring(5e6).fluidity(TAU, 0.0), rtol=1e-9)


def test_a_limited_newtonian_oil_has_the_law_of_gecim_and_winer_below_its_limit() -> None:
    law = Limited(NewtonianOil(), 0.05, sharpness=0.02)
    limit = law.limit(1e9)
    assert limit == 4e6 + 0.05 * 1e9 == law.limit(np.array([1e9]))[0]
    assert law.limit(-1e8) == 4e6
    tau = np.array([0.1, 0.5, 0.9, 0.97]) * limit
    assert_allclose(law.fluidity(tau, 1e9) * tau, limit * np.arctanh(tau / limit), rtol=1e-13)
    assert_allclose(law.stress(limit * np.arctanh(tau / limit), 1e9), tau, rtol=1e-12)


def test_the_exponential_part_joins_with_value_slope_and_curvature() -> None:
    law = Limited(NewtonianOil(), 0.05, ambient=1.0, sharpness=0.1)

    def rate(u):
        return law.fluidity(u, 0.0) * u

    derivatives = jax.jit(lambda u: (rate(u), jax.grad(rate)(u), jax.grad(jax.grad(rate))(u)))
    for below, above, rel in zip(derivatives(0.9 - 1e-7), derivatives(0.9 + 1e-7), (1e-5, 1e-5, 1e-4), strict=True):
        assert float(above) == pytest.approx(float(below), rel=rel)
    growth = 2 * 0.9 / (1 - 0.9**2)
    assert rate(2.0) / rate(1.5) == pytest.approx(np.exp(0.5 * growth), rel=0.02)


@pytest.mark.parametrize("rate", [1e9, 1e11, 1e13])
def test_the_limit_holds_within_what_the_sharpness_says(rate: float) -> None:
    """Shear rates of 20 to 2e5 times tau_L: the stress exceeds tau_L by sharpness per factor e of the rate."""
    law = Limited(traceable(NewtonianOil()), 0.05, sharpness=0.02)
    s = np.array([[rate], [0.0]])
    stress = FLOW(traceable(law), np.full(1, 1e9), s, 0.0 * s).stress[0, 0]
    excess = float(stress) / law.limit(1e9) - 1.0
    assert -0.02 < excess < 0.02 * np.log(rate / law.limit(1e9))


def test_marks_say_what_is_allowed() -> None:
    exponent = marks(Carreau)["n"]
    assert [bool(exponent.complaint(n)) for n in (0.0, 0.4, 1.0, 1.2)] == [True, False, False, True]


@dataclass(frozen=True)
class Rabinowitsch:
    """A user's own law."""

    tau0: Annotated[float, STRESS]

    def fluidity(self, stress, pressure):
        return 1 + (stress / self.tau0) ** 2

    def stress(self, rate, pressure):
        return rate / (1 + (rate / self.tau0) ** 2) ** (1 / 3)


def test_a_users_own_law_takes_its_place() -> None:
    """For phi = 1 + x^2 the flow along the gradient has a closed form: S_0 t + S_1 g = t + t^3 + t g^2/4."""
    law = traceable(Rabinowitsch(1.0))
    t, g = 1.7, 0.9
    s = t + t**3 + t * g**2 / 4
    found = FLOW(law, np.zeros(1), np.array([[s], [0.0]]), np.array([[g], [0.0]]))
    assert found.stress[0, 0] == pytest.approx(t, rel=1e-9)
    assert found.flux[0, 0] == pytest.approx(g / 12 + t**2 * g / 4 + g**3 / 80, rel=1e-9)


def test_stress_that_is_cut_off_keeps_its_direction() -> None:
    stress = np.array([[3.0, 0.3], [4.0, 0.4]])
    assert_allclose(cut_off(stress, np.array([1.0, 1.0])), [[0.6, 0.3], [0.8, 0.4]])
