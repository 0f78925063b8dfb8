"""The laws of asperities against their integrals, against rough surfaces pressed together by FFT, and their limits."""

from math import erfc, pi, sqrt

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ertel.case.height_map import Measured
from ertel.physics.asperities import ExponentialTouch, GreenwoodTripp, MeasuredWaves, Persson, persson_curve, summits
from ertel.physics.surfaces import SelfAffine

# F_{5/2}(k) by adaptive integration of the normal distribution
SUMMITS = {0: 0.616634, 0.5: 0.240402, 1: 0.080562, 1.5: 0.022863, 2: 0.005424, 3: 0.000171, 4: 2e-6}
# pressure over E* times the rms slope, and the mean gap over sigma: mean of periodic random surfaces of 512^2 nodes
# with waves q0 to 16 q0, pressed together dry by FFT and constrained conjugate gradients
PRESSED = {0.1: 0.556, 0.2: 0.275}


def test_integrals_of_the_summits():
    k = np.array(list(SUMMITS), dtype=float)
    assert summits(2.5, k) == pytest.approx(list(SUMMITS.values()), abs=6e-7)
    # F_1 by its closed form, from surfaces that are far apart to those pressed together
    k = np.linspace(-9.0, 5.0, 8)
    closed = np.exp(-(k**2) / 2) / sqrt(2 * pi) - k * np.array([0.5 * erfc(x / sqrt(2)) for x in k])
    assert summits(1.0, k) == pytest.approx(closed, rel=1e-6, abs=1e-12)


def test_persson_against_surfaces_pressed_together():
    q = np.geomspace(1.0, 16.0, 600)
    spectrum = q**-3.6
    slope = np.sqrt(np.trapezoid(spectrum * q**3, q) / np.trapezoid(spectrum * q, q))  # of a surface with sigma 1
    curve = persson_curve(tuple(q), tuple(spectrum), 1.0, 1.0)
    for pressure, gap in PRESSED.items():
        p = np.interp(gap, curve.h, curve.p)
        assert p / (pressure * slope) == pytest.approx(1.0, abs=0.1)


def test_greenwood_and_tripp_with_the_same_moments_are_far_too_soft():
    """Their summits stand about one sigma above the mean plane, which the moments of a whole surface do not know.

    Density and radius of the summits of an isotropic surface: Nayak PR. J Lubr Technol 1971;93:398.
    """
    q = np.geomspace(1.0, 16.0, 600)
    spectrum = q**-3.6 / (2 * pi * np.trapezoid(q**-2.6, q))
    m0, m2, m4 = (np.trapezoid(spectrum * q ** (n + 1), q) * pi * factor for n, factor in ((0, 2), (2, 1), (4, 0.75)))
    density, radius = m4 / m2 / (6 * pi * sqrt(3)), 3 * sqrt(pi) / 8 / sqrt(m4)
    curve = GreenwoodTripp(density * radius * sqrt(m0), sqrt(sqrt(m0) / radius)).curve(sqrt(m0), 1.0)
    p = np.interp(PRESSED[0.1], curve.h, curve.p)
    assert p < 0.2 * 0.1 * sqrt(2 * m2)


LAWS = st.one_of(
    st.builds(Persson, longest=st.floats(2e-5, 1e-3), shortest=st.floats(1e-7, 1e-5), hurst=st.floats(0.3, 0.95)),
    st.builds(GreenwoodTripp, density=st.floats(0.01, 0.1), sharpness=st.floats(0.01, 0.5)),
    st.builds(ExponentialTouch, pressure=st.floats(1e6, 1e11), length=st.floats(1e-9, 1e-6)),
)


@settings(max_examples=12, deadline=None)
@given(law=LAWS, sigma=st.floats(1e-9, 1e-6), modulus=st.floats(1e8, 1e12))
def test_a_law_falls_with_the_gap_and_scales_with_the_modulus(law, sigma, modulus):
    curve, stiffer = law.curve(sigma, modulus), law.curve(sigma, 2 * modulus)
    assert np.all(np.diff(curve.h) > 0) and np.all(np.diff(curve.p) < 0) and np.all(curve.p > 0)
    if not isinstance(law, ExponentialTouch):
        assert np.allclose(stiffer.p, 2 * np.interp(stiffer.h, curve.h, curve.p), rtol=1e-6)
        assert np.all((curve.area > 0) & (curve.area <= 1)) and np.all(np.diff(curve.area) <= 0)


def test_a_light_touch_is_exponential():
    """Persson: ln p falls by one over 0.43 to 0.46 sigma."""
    curve = Persson(longest=50e-6, shortest=1e-6).curve(1e-7, 1e11)
    light = curve.p < 1e-7 * curve.p[0]
    steps = -np.diff(curve.h[light]) / np.diff(np.log(curve.p[light]))
    assert np.allclose(steps, steps[0], rtol=1e-3) and 0.40 < steps[0] / 1e-7 < 0.50


def test_hardness_holds_the_pressure_of_the_spots():
    curve = Persson(longest=50e-6, shortest=1e-6).curve(1e-7, 1e11)
    capped = curve.capped(5e9)
    assert np.all(capped.p <= 5e9 * curve.area * (1 + 1e-12)) and np.any(capped.p < curve.p)
    assert curve.capped(1e15).p is not None and np.array_equal(curve.capped(1e15).p, curve.p)


def test_waves_must_have_a_range():
    with pytest.raises(ValueError, match="must be below longest"):
        Persson(longest=1e-6, shortest=2e-6)


PERIOD, POINTS = 8.0, 256
PLACES = np.arange(POINTS) * PERIOD / POINTS


def self_affine(shortest: float, longest: float) -> Measured:
    """A map of one period of a random surface, rms 1 with Hurst exponent 0.8; lengths without units."""
    heights = SelfAffine(1.0, 0.8, shortest, longest, period=PERIOD, seed=4).heights(PLACES, PLACES[:, None])
    return Measured.of(heights, 1.0, length_x=PERIOD, length_y=PERIOD, rms=1.0)


@pytest.mark.parametrize("cutoff", [0.3, 0.71, 1.5])
def test_the_map_above_its_cutoff_and_the_waves_below_have_its_variance_together(cutoff: float):
    surface = self_affine(0.1, 2.0)
    points = np.arange(POINTS)
    kept = surface.file.at(points, points[:, None], (cutoff * POINTS / PERIOD,) * 2)
    lost = surface.lost_waves(cutoff)
    assert 0.0 < lost.rms < 1.0
    assert np.mean(kept**2) + lost.variance.sum() == pytest.approx(1.0, rel=1e-12)
    assert lost.q[0] > 2 * pi / cutoff * 0.98


def test_the_waves_of_a_map_have_the_law_of_its_numbers():
    """A surface made of a spectrum, and Persson's law of it: pressures within 5 % up to a gap of two sigma."""
    waves = self_affine(0.125, 1.0).lost_waves(100.0)
    measured = MeasuredWaves().curve(1.0, 1.0, waves)
    numbers = Persson(longest=1.0, shortest=0.125, hurst=0.8).curve(1.0, 1.0)
    assert waves.rms == pytest.approx(1.0, rel=1e-9) and not measured.complaint
    for gap in (0.01, 0.1, 0.3, 1.0, 2.0):
        p, expected = (np.exp(np.interp(gap, curve.h, np.log(curve.p))) for curve in (measured, numbers))
        assert p == pytest.approx(expected, rel=0.05)
