"""Front and film of an impact: on made-up fields whose answer is known, and on one small run."""

import numpy as np
import pytest
from made_up import dry_front

from ertel.physics import amplitude_reduction, hertz
from ertel.results import fronts

TOUCH = 1.0


@pytest.mark.parametrize("two_dimensional", [False, True])
def test_front_of_the_dry_impact_follows_the_exact_law(two_dimensional):
    front = fronts.front(dry_front(two_dimensional=two_dimensional))
    np.testing.assert_allclose(front.A, hertz.contact_radius(front.T - TOUCH), atol=0.008)
    inside = (front.A > 0.3) & (front.A < 0.98)
    np.testing.assert_allclose(front.speed[inside], hertz.front_speed(front.A[inside]), rtol=2e-3, atol=0.02)


def test_front_tells_when_it_passed_and_how_fast():
    front = fronts.front(dry_front())
    X = np.array([0.4, 0.75, 0.95])
    np.testing.assert_allclose(front.passed(X), TOUCH + hertz.time_at(X**2), atol=2e-3)
    np.testing.assert_allclose(front.speed_at(X), hertz.front_speed(X), rtol=5e-3)
    assert np.isnan(front.speed_at(1.2)) and np.isnan(front.passed(0.01))


def test_front_from_maps_needs_maps():
    with pytest.raises(ValueError, match="too few times"):
        fronts.front(dry_front(interval=10.0))


def test_amplitude_reduction():
    """Eq. (15), by the direction of the waves."""
    assert amplitude_reduction.ratio_left(0.0) == 1.0
    assert amplitude_reduction.ratio_left([10.0]) == pytest.approx([0.25])
    assert amplitude_reduction.ratio_left(2.0, 0.0) == amplitude_reduction.ratio_left(2.0)  # transverse: the same curve
    assert amplitude_reduction.ratio_left(2.0, 2.0) == amplitude_reduction.ratio_left(2.0 * np.exp(0.5))
    assert amplitude_reduction.ratio_left(2.0, np.inf) == amplitude_reduction.ratio_left(2.0 * np.e)
    with pytest.raises(ValueError, match=r"^ratio = -1"):
        amplitude_reduction.ratio_left(2.0, -1)
