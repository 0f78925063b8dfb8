"""The table of a law of asperities: values, slopes, energies, and what Newton's iteration asks for."""

import jax.numpy as jnp
import numpy as np
import pytest

from ertel.equations.touch import STEEP, Asperities
from ertel.physics.asperities import ExponentialTouch, GreenwoodTripp, Persson

LENGTH = 0.05
EXPONENTIAL = Asperities.of(ExponentialTouch(3.0, LENGTH).curve(0.0, 0.0), 1.0, 1.0)
H = jnp.geomspace(1e-4, 1.5, 40)
EXACT = 3.0 * jnp.exp(-H / LENGTH)


def test_the_table_is_the_law():
    assert np.allclose(EXPONENTIAL.pressure(H), EXACT, rtol=1e-7, atol=0.0)
    assert np.allclose(EXPONENTIAL.stored(H)[:30], LENGTH * EXACT[:30], rtol=1e-3, atol=0.0)


@pytest.mark.parametrize("law", [Persson(5e-5, 1e-6), GreenwoodTripp(), ExponentialTouch(3e9, 4e-8)], ids=str)
def test_slope_and_energy_are_derivatives(law):
    asperities = Asperities.of(law.curve(1e-7, 1.1e11), 1e9, 1e-6)
    gap = jnp.geomspace(1e-3, 0.4, 30)
    step = 1e-5 * gap
    rise = (asperities.pressure(gap + step) - asperities.pressure(gap - step)) / (2 * step)
    assert np.allclose(asperities.tangent(100.0 + 0 * gap, gap).stiffness, -rise, rtol=1e-5, atol=0.0)
    wide = 0.01 * gap
    released = asperities.stored(gap - wide) - asperities.stored(gap + wide)
    assert np.allclose(released / (2 * wide), asperities.pressure(gap), rtol=0.02, atol=0.0)


def test_a_gap_far_too_small_takes_a_tangent_further_out():
    P = jnp.full(3, 0.1)
    tight = jnp.array([1e-3, 0.01, 0.3])
    line = EXPONENTIAL.tangent(P, tight)
    out = -LENGTH * np.log((0.1 + STEEP) / 3.0)  # where P_c = P + STEEP
    assert np.allclose(line.stiffness[:2], (0.1 + STEEP) / LENGTH, rtol=1e-4)
    assert np.allclose(line.value[:2], (0.1 + STEEP) * (1 + (out - tight[:2]) / LENGTH), rtol=1e-4)
    # elsewhere it is the law's own
    assert np.isclose(line.value[2], 3.0 * np.exp(-0.3 / LENGTH), rtol=1e-6)


def test_a_closed_gap_is_a_number():
    line = EXPONENTIAL.tangent(jnp.zeros(2), jnp.array([0.0, -0.5]))
    assert np.isfinite(line).all() and np.isfinite(EXPONENTIAL.pressure(jnp.array([0.0, -0.5]))).all()
    assert EXPONENTIAL.pressure(jnp.array([50.0]))[0] < 1e-100


def test_the_share_of_area_is_one_at_most():
    asperities = Asperities.of(Persson(5e-5, 1e-6).curve(1e-7, 1.1e11), 1e9, 1e-6)
    area = asperities.touching(jnp.geomspace(1e-5, 5.0, 50))
    assert np.all(area <= 1.0) and np.all(np.diff(area) <= 0.0) and area[-1] < 1e-12
