"""Closed forms of Eyring's flow against the design's table, and the law of small gradients."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from ertel.physics.fluidity import Carreau, ReeEyring
from ertel.physics.shear import eyring_flow_factor, eyring_stress, small_gradient_mobility

SIGMA = np.array([0.5, 1.0, 2.0, 4.0, 8.0])


@pytest.mark.parametrize(
    ("B", "at_rest", "factors"),
    [
        (0, 1.0, [1.025224, 1.103638, 1.461574, 3.841079, 61.132936]),
        (1, 1.414214, [1.420842, 1.449116, 1.669069, 3.88212, 61.133817]),
        (10, 10.049875, [9.890484, 9.455686, 8.191172, 6.815509, 61.220932]),
        (100, 100.005, [98.37739, 93.91707, 80.610459, 56.431213, 69.38225]),
    ],
)
def test_table(B: float, at_rest: float, factors: list) -> None:
    assert_allclose(eyring_flow_factor(B, SIGMA), factors, rtol=6e-8 + 5e-7)
    assert float(eyring_flow_factor(B, 0.0)) == pytest.approx(at_rest, rel=1e-6)
    assert float(eyring_stress(B, 0.0)) == pytest.approx(np.arcsinh(B))


def test_series_and_closed_form_meet() -> None:
    low, high = eyring_flow_factor(3.0, np.array([0.1 - 1e-12, 0.1 + 1e-12]))
    assert low == pytest.approx(high, rel=1e-12)


def test_small_gradients() -> None:
    x = np.array([0.3, 2.0, 5.0])
    along, across = small_gradient_mobility(ReeEyring(1.0), x, 0.0)
    assert_allclose(along, np.cosh(x), rtol=1e-9)
    assert_allclose(across, np.sinh(x) / x, rtol=1e-13)
    along, across = small_gradient_mobility(Carreau(1.0, 0.5), x, 0.0)
    assert_allclose(along, (1 + 2 * x**2) / np.sqrt(1 + x**2), rtol=1e-9)
    assert_allclose(across, np.sqrt(1 + x**2), rtol=1e-13)
