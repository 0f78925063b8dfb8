"""The laws of measured oils: modulus, Tait, Doolittle.  What holds for every law is in test_lubricant."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ertel.physics.pressure_laws import Doolittle, Modulus, Tait

A = st.floats(2e7, 1e8)
K0 = st.floats(0.8e9, 2e9)
K0_PRIME = st.floats(5.0, 15.0)
SQUALANE = Doolittle(5.258, 0.6633, 1.312e9, 11.74)  # at 25 degC


@given(A)
def test_a_modulus_law_without_b_is_barus(a):
    assert Modulus(a, 0.0).viscosity(3e8) == pytest.approx(np.exp(3e8 / a), rel=1e-12)


@given(A, st.floats(0.0, 0.2), st.floats(1e6, 3e9))
def test_the_modulus_law_starts_with_alpha_and_ends_at_one_over_b(a, b, p):
    law = Modulus(a, b)
    assert jax.grad(lambda p: jnp.log(law.viscosity(p)))(0.0) == pytest.approx(1 / a, rel=1e-12)
    assert np.log(law.viscosity(p)) <= min(p / a, 1 / b if b > 1e-6 else np.inf) * (1 + 1e-9)


@given(K0, K0_PRIME)
def test_taits_law_has_its_bulk_modulus_and_its_derivative(K0, K0_prime):
    """K = -V dp/dV = rho dp/drho is K0 at ambient pressure, and dK/dp is K0'."""
    law = Tait(K0, K0_prime)

    def modulus(p):
        return law.density(p) / jax.grad(law.density)(p)

    assert modulus(0.0) == pytest.approx(K0, rel=1e-12)
    assert jax.grad(modulus)(0.0) == pytest.approx(K0_prime, rel=1e-9)


@given(K0, K0_PRIME, st.floats(0.5, 0.7), st.floats(2.0, 6.0))
def test_doolittles_alpha_is_the_slope_at_ambient_pressure(K0, K0_prime, R, B):
    law = Doolittle(B, R, K0, K0_prime)
    assert jax.grad(lambda p: jnp.log(law.viscosity(p)))(0.0) == pytest.approx(law.alpha, rel=1e-10)


def test_doolittles_law_is_the_one_of_free_volume():
    """eta/eta0 = exp(B V_occ/(V - V_occ) - B V_occ/(V0 - V_occ)), Doolittle's own form."""
    p = np.linspace(0.0, 1e9, 7)
    V, occupied = Tait(1.312e9, 11.74).volume(p), 0.6633
    own = np.exp(5.258 * (occupied / (V - occupied) - occupied / (1 - occupied)))
    np.testing.assert_allclose(SQUALANE.viscosity(p), own, rtol=1e-12)


def test_a_law_of_its_own_wants_its_data():
    from ertel.physics.lubricant import Oil

    with pytest.raises(ValueError, match=r'^viscosity = "doolittle": has data of its own; give them as \{ law = "dool'):
        Oil(viscosity="doolittle")
