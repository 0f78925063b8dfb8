"""Surface features: their shapes, and that each moves with its own surface."""

from dataclasses import replace
from math import inf

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ertel.physics.motion import FREE_BALL, STEADY_ROLLING
from ertel.physics.surfaces import Feature, RingWaviness, Spot, Waviness, height

X = np.linspace(-2.0, 2.0, 41)[None, :]
Y = np.linspace(-1.0, 1.0, 21)[:, None]


def test_isotropic_waviness_is_a_product_of_cosines() -> None:
    found = Waviness(0.1, 0.5, 0.25).heights(X, Y)
    np.testing.assert_allclose(found, 0.1 * np.cos(4 * np.pi * X) * np.cos(8 * np.pi * Y))


def test_an_infinite_wavelength_leaves_its_direction_smooth() -> None:
    transverse, longitudinal = Waviness(0.1, 0.5).heights(X, Y), Waviness(0.1, inf, 0.5).heights(X, Y)
    assert np.ptp(np.broadcast_to(transverse, (21, 41)), axis=0).max() == 0
    assert np.ptp(np.broadcast_to(longitudinal, (21, 41)), axis=1).max() == 0


def test_a_wave_enters_behind_its_front() -> None:
    """Nothing before the front, all of it a ramp behind, smooth between."""
    whole, entering = Waviness(0.1, inf, 1.0), Waviness(0.1, inf, 1.0, front=0.5, ramp=1.0)
    share = (entering.heights(X, Y) / whole.heights(X, Y))[0]
    assert (share[X[0] >= 0.5] == 0).all()
    assert (share[X[0] <= -0.5] == 1).all()
    assert share[X[0] == 0.0] == pytest.approx(0.5)


def test_rings_are_round() -> None:
    ring = RingWaviness(0.1, 0.5)
    angle = np.linspace(0, 6, 7)
    np.testing.assert_allclose(ring.heights(0.7 * np.cos(angle), 0.7 * np.sin(angle)), 0.1 * np.cos(2.8 * np.pi))


def test_a_spot_has_its_height_at_its_centre_and_none_far_away() -> None:
    cavity = Spot(0.1, height=-0.02, x=0.3, y=-0.1)
    assert cavity.heights(0.3, -0.1) == -0.02
    assert cavity.heights(0.3 + 0.12, -0.1) == pytest.approx(0.0, abs=1e-17)  # the cosine's first zero, 1.2 radii away
    assert abs(cavity.heights(0.8, 0.0)) < 1e-12


@given(st.floats(-2.0, 2.0), st.floats(0.0, 3.0), st.sampled_from([1, 2]))
def test_a_feature_moves_with_its_own_surface(slide_to_roll, T, surface) -> None:
    """Surface 1 at 1 + S/2, surface 2 at 1 - S/2, in units u_m."""
    motion = replace(STEADY_ROLLING, slide_to_roll=slide_to_roll)
    spot = Spot(0.3, 0.01)
    speed = 1 + (0.5 if surface == 1 else -0.5) * slide_to_roll
    found = height([Feature(spot, surface)], motion, T, X, Y)
    np.testing.assert_allclose(found, spot.heights(X - speed * T, Y), atol=1e-15)


def test_features_add_up_and_stand_still_without_entrainment() -> None:
    one, two = Waviness(0.1, 0.5, 0.5), Spot(0.1, depth=0.02)
    found = height([Feature(one, 1), Feature(two, 2)], FREE_BALL, 3.0, X, Y)
    np.testing.assert_allclose(found, one.heights(X, Y) + two.heights(X, Y))


def test_no_features_no_height() -> None:
    assert not height([], FREE_BALL, 0.0, X, Y).any()
    assert height([], FREE_BALL, 0.0, X, Y).shape == (21, 41)
