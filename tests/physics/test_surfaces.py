"""Surface features: their shapes, and that each moves with its own surface."""

from dataclasses import dataclass, replace
from math import inf

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ertel.case.height_map import HeightMap, Measured
from ertel.physics.motion import FREE_BALL, STEADY_ROLLING, constant
from ertel.physics.surfaces import Feature, RingWaviness, SelfAffine, Spot, Waviness, even, height
from ertel.physics.units import Quantity

X = np.linspace(-2.0, 2.0, 41)[None, :]
Y = np.linspace(-1.0, 1.0, 21)[:, None]


ROUGH = SelfAffine(rms=0.02, hurst=0.8, shortest=0.1, longest=1.0)


def test_waviness_is_a_product_of_cosines_and_rings_are_round() -> None:
    """An infinite wavelength leaves its direction smooth."""
    found = Waviness(0.1, 0.5, 0.25).heights(X, Y)
    np.testing.assert_allclose(found, 0.1 * np.cos(4 * np.pi * X) * np.cos(8 * np.pi * Y))
    transverse, longitudinal = Waviness(0.1, 0.5).heights(X, Y), Waviness(0.1, inf, 0.5).heights(X, Y)
    assert np.ptp(np.broadcast_to(transverse, (21, 41)), axis=0).max() == 0
    assert np.ptp(np.broadcast_to(longitudinal, (21, 41)), axis=1).max() == 0
    ring, angle = RingWaviness(0.1, 0.5), np.linspace(0, 6, 7)
    np.testing.assert_allclose(ring.heights(0.7 * np.cos(angle), 0.7 * np.sin(angle)), 0.1 * np.cos(2.8 * np.pi))


@pytest.mark.parametrize("whole", [Waviness(0.1, inf, 1.0), ROUGH])
def test_a_surface_enters_behind_its_front(whole) -> None:
    """Nothing before the front, all of it a ramp behind, smooth between."""
    heights, entering = whole.heights(X, Y), replace(whole, front=0.5, ramp=1.0).heights(X, Y)
    assert not entering[:, X[0] >= 0.5].any()
    np.testing.assert_array_equal(entering[:, X[0] <= -0.5], heights[:, X[0] <= -0.5])
    np.testing.assert_allclose(entering[:, X[0] == 0.0], heights[:, X[0] == 0.0] / 2)


def test_a_spot_has_its_height_at_its_centre_and_none_far_away() -> None:
    cavity = Spot(0.1, height=-0.02, x=0.3, y=-0.1)
    assert cavity.heights(0.3, -0.1) == -0.02
    assert cavity.heights(0.3 + 0.12, -0.1) == pytest.approx(0.0, abs=1e-17)  # the cosine's first zero, 1.2 radii away
    assert abs(cavity.heights(0.8, 0.0)) < 1e-12
    bump, deep = Spot(0.3, height=0.02), Spot(0.3, depth=0.02)
    assert (bump.heights(0.0, 0.0), deep.heights(0.0, 0.0)) == (0.02, -0.02)
    np.testing.assert_array_equal(deep.heights(X, Y), Spot(0.3, height=-0.02).heights(X, Y))


MAP = Measured(HeightMap(np.random.default_rng(0).normal(size=(24, 40))), 4.0, 2.4, 0.02)


@pytest.mark.parametrize(("shape", "close"), [(Spot(0.3, 0.01), 1e-15), (ROUGH, 1e-12), (MAP, 1e-12)])
@given(st.floats(-2.0, 2.0), st.floats(0.0, 3.0), st.sampled_from([1, 2]))
def test_a_feature_moves_with_its_own_surface(shape, close, slide_to_roll, T, surface) -> None:
    """Surface 1 at 1 + S/2, surface 2 at 1 - S/2, in units u_m."""
    motion = replace(STEADY_ROLLING, sliding=constant(slide_to_roll))
    speed = 1 + (0.5 if surface == 1 else -0.5) * slide_to_roll
    found = height([Feature(shape, surface)], motion, T, X, Y)
    np.testing.assert_allclose(found, shape.heights(X - speed * T, Y), atol=close)


def test_features_add_up_and_stand_still_without_entrainment() -> None:
    one, two = Waviness(0.1, 0.5, 0.5), Spot(0.1, depth=0.02)
    found = height([Feature(one, 1), Feature(two, 2)], FREE_BALL, 3.0, X, Y)
    np.testing.assert_allclose(found, one.heights(X, Y) + two.heights(X, Y))
    np.testing.assert_array_equal(height([], FREE_BALL, 0.0, X, Y), np.zeros((21, 41)), strict=True)


# -- what a shape says of itself --------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("shape", "arguments", "message"),
    [
        (Spot, {"radius": 0.3}, "height: missing; allowed: height .* or depth"),
        (Spot, {"radius": 0.3, "height": 0.1, "depth": 0.1}, "height: is given together with depth"),
        (Waviness, {"amplitude": 0.1}, "wavelength_x: missing; needed: wavelength_x or wavelength_y"),
        (Waviness, {"amplitude": 0.1, "wavelength_x": 0.5, "ramp": 1.0}, "ramp = 1.0: needs front"),
        (SelfAffine, {"shortest": 1.0}, "shortest = 1 a: must be below longest, 1 a"),
        (SelfAffine, {"rolloff": 2.0}, "rolloff = 2 a: must be from shortest, 0.1 a, to longest, 1 a"),
        (SelfAffine, {"period": 0.5}, "period = 0.5 a: must be at least longest, 1 a"),
        (SelfAffine, {"shortest": 0.001}, "shortest = 0.001 a: .* period of 8 a; must be at least 0.0078125 a"),
        (SelfAffine, {"ramp": 0.1}, "ramp = 0.1: needs front"),
        (SelfAffine, {"front": 0.1}, "front = 0.1: needs ramp"),
    ],
)
def test_what_is_no_shape_is_said(shape, arguments, message) -> None:
    with pytest.raises(ValueError, match=f"^{message}"):
        shape(**(vars(ROUGH) | arguments if shape is SelfAffine else arguments))


@pytest.mark.parametrize(
    "shape",
    [
        Waviness(0.1, 0.5, 0.7),
        Waviness(0.1, 0.5, 0.7, phase_x=0.3),
        Waviness(0.1, 0.5, 0.7, phase_y=0.3),
        Waviness(0.1, 0.5, 0.7, phase_x=np.pi, phase_y=-np.pi),
        Waviness(0.1, 0.5, front=0.5),
        RingWaviness(0.1, 0.5, phase=0.3),
        RingWaviness(0.1, 0.5, x=0.2),
        Spot(0.3, 0.1, y=0.2),
        Spot(0.3, 0.1),
    ],
    ids=str,
)
def test_a_shape_that_says_that_it_is_even_is(shape) -> None:
    heights = np.broadcast_to(shape.heights(X, Y), (21, 41))
    in_y, in_x = np.allclose(heights, heights[::-1]), np.allclose(heights, heights[:, ::-1])
    assert shape.even == (in_y, in_x)


@dataclass(frozen=True)
class Ramp:
    """A shape of a user's own, which says nothing of itself."""

    def heights(self, X, Y):
        return 0.1 * X


def test_features_are_even_where_all_say_so() -> None:
    """A shape of one's own needs no more than heights."""
    middle, aside = Feature(Spot(0.3, 0.1)), Feature(Spot(0.3, 0.1, x=0.5))
    assert even([]) == (True, True)
    assert even([middle, aside]) == (True, False)
    assert even([Feature(Ramp())]) == (False, False)
    np.testing.assert_allclose(height([Feature(Ramp())], STEADY_ROLLING, 0.5, X, Y)[0], 0.1 * (X[0] - 0.5))


def test_sizes_in_si_are_not_heights_of_a_case() -> None:
    with pytest.raises(TypeError, match=r"^1e-08 m: is in SI"):
        Spot(0.3, Quantity(1e-8, "m")).heights(X, Y)
