"""Rough surfaces: measured maps and self-affine sums of waves, what a grid keeps of them, and how they end."""

from contextlib import suppress
from dataclasses import replace
from io import BytesIO

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ertel.case.height_map import HeightMap, Measured, array_in
from ertel.physics.motion import STEADY_ROLLING
from ertel.physics.surfaces import Feature, SelfAffine, Spot, Waviness, height, kept_share, smooth_step
from ertel.physics.units import Quantity

X = np.linspace(-1.0, 1.0, 41)[None, :]
Y = np.linspace(-0.8, 0.8, 33)[:, None]
ROUGH = SelfAffine(rms=0.02, hurst=0.8, shortest=0.1, longest=1.0, seed=3)
NOISE = np.random.default_rng(0).normal(size=(24, 40))


def points(n: int, length: float) -> np.ndarray:
    """The places of n points of a map of this length with its middle at 0."""
    return (np.arange(n) + 0.5) * length / n - length / 2


def measured(heights, length_x=4.0, length_y=2.4, **placed) -> Measured:
    """A map in the units of a case, as high as it says."""
    found = HeightMap(heights)
    return Measured(found, length_x, length_y, found.rms, **placed)


def sampled(shape, columns: int, rows: int, length_x: float, length_y: float, **placed) -> Measured:
    """A measured map of another shape."""
    heights = shape.heights(points(columns, length_x)[None, :], points(rows, length_y)[:, None])
    return measured(heights, length_x, length_y, **placed)


# -- measured ---------------------------------------------------------------------------------------------------------


def test_a_map_of_a_wave_is_the_wave_to_fourth_order() -> None:
    wave = Waviness(0.01, 0.75, 1.0)
    errors = [
        np.abs(sampled(wave, 2 * n, n, 3.0, 2.4, taper=0.2).heights(X, Y) - wave.heights(X, Y)).max() / 0.01
        for n in (32, 64, 128)
    ]
    orders = np.log2(errors[:-1]) - np.log2(errors[1:])
    assert errors[-1] < 1e-5
    assert (orders > 3.8).all()


def test_a_map_goes_through_its_heights() -> None:
    m = measured(NOISE, taper=0.3)
    inner = (slice(4, -4), slice(4, -4))
    found = m.heights(points(40, 4.0)[None, :], points(24, 2.4)[:, None])
    np.testing.assert_allclose(found[inner], NOISE[inner], atol=1e-12)


def test_a_map_has_the_rms_that_it_is_given_and_no_unit_of_its_own() -> None:
    one, two = measured(NOISE), replace(measured(1e-6 * NOISE), rms=HeightMap(NOISE).rms)
    np.testing.assert_allclose(one.heights(X, Y), two.heights(X, Y), rtol=1e-12)


@given(st.floats(-3.0, 3.0), st.floats(-3.0, 3.0), st.floats(-180.0, 180.0))
def test_a_map_is_placed_and_turned(x, y, angle) -> None:
    """At the place to which a point of the map goes is the height of that point."""
    here = measured(NOISE)
    turn = np.radians(angle)
    moved = x + X * np.cos(turn) - Y * np.sin(turn), y + X * np.sin(turn) + Y * np.cos(turn)
    np.testing.assert_allclose(replace(here, x=x, y=y, angle=angle).heights(*moved), here.heights(X, Y), atol=1e-9)


def test_a_map_is_smooth_and_ends_smoothly() -> None:
    """Nothing at its edges and beyond, two continuous derivatives on the way there, all of it inside the taper."""
    m = measured(np.full((8, 8), 2.0), 2.0, 2.0, taper=0.4)
    assert not m.heights(np.array([1.0, 1.5, -1.0, 40.0]), 0.0).any()
    assert m.heights(0.6, 0.0) == pytest.approx(2.0)
    x = np.linspace(0.4, 1.2, 3201)
    curvature = np.diff(m.heights(x, 0.0), 2) / (x[1] - x[0]) ** 2
    assert np.abs(np.diff(curvature)).max() < 0.02 * np.abs(curvature).max()
    x = np.linspace(-0.5, 0.5, 4001)
    between_points = np.diff(measured(NOISE).heights(x, 0.11), 2) / (x[1] - x[0]) ** 2
    assert np.abs(np.diff(between_points)).max() < 0.02 * np.ptp(between_points)


@pytest.mark.parametrize(
    ("heights", "message"),
    [
        (np.ones(3), "^heights: is 3; must be a map of 4 to 4096 points a side, or a profile of 4 to 1048576$"),
        (np.ones((5, 1)), "^heights: is 5 x 1; must be a map"),
        (np.ones((1, 5, 5)), "^heights: is 1 x 5 x 5; must be a map"),
        (1.0, "^heights: is a number; must be a map"),
        (np.ones((3, 9)), "^heights: is 3 x 9; must be a map of 4 to 4096 points a side"),
        (np.where(NOISE > 1, np.nan, NOISE), "^heights: has gaps"),
        (np.zeros((5, 5)), "^heights: are all zero"),
        (1e300 * NOISE / np.abs(NOISE).max(), r"^heights: reach 1e\+300; .* must be between 1e-30 and 1e\+30$"),
        (1e-320 * NOISE / np.abs(NOISE).max(), r"^heights: reach 1e-320; .* must be between 1e-30 and 1e\+30$"),
    ],
)
def test_what_is_no_map_is_said(heights, message) -> None:
    with pytest.raises(ValueError, match=message):
        HeightMap(heights)


def test_a_map_without_sizes_is_refused_and_so_is_a_taper_that_meets_itself() -> None:
    with pytest.raises(ValueError, match=r"^length_x: missing"):
        Measured(HeightMap(NOISE))
    with pytest.raises(ValueError, match=r"^file = 'disc.txt': must be a HeightMap"):
        Measured("disc.txt")
    with pytest.raises(ValueError, match=r"^taper = 1.3 a: must be at most half"):
        measured(NOISE, taper=1.3)


def test_maps_of_the_same_heights_are_the_same_map() -> None:
    one, two = HeightMap(NOISE), HeightMap(NOISE.tolist())
    assert one == two and hash(one) == hash(two)
    assert HeightMap(NOISE.reshape(40, 24)) != one != HeightMap(NOISE + 1e-12)
    assert HeightMap(array_in(one.to_bytes())) == one


def test_arrays_in_metres_have_their_lengths() -> None:
    m = Measured.of(NOISE, (2e-6, 1e-6), x=0.5)
    lengths = (Quantity(size, "m") for size in (40 * 2e-6, 24 * 1e-6, HeightMap(NOISE).rms))
    assert (m.length_x, m.length_y, m.rms, m.x) == (*lengths, 0.5)
    with pytest.raises(ValueError, match=r"^spacing = 0.0: must be above zero"):
        Measured.of(NOISE, 0.0)


# -- a profile --------------------------------------------------------------------------------------------------------

WAVE = Waviness(0.01, 0.75)
OF_WAVE = WAVE.heights(points(512, 12.0), 0.0)  # sixteen waves, the mirror image of each end fits


def profile(heights=OF_WAVE, length=12.0, **placed) -> Measured:
    return Measured(HeightMap(heights), length, rms=HeightMap(heights).rms, **placed)


def test_a_profile_of_a_wave_is_the_wave_at_all_y() -> None:
    found = profile(taper=1.0)
    assert found.file.heights.shape == (1, 512) and found.file == HeightMap([OF_WAVE])
    np.testing.assert_allclose(found.heights(X, 0.0), WAVE.heights(X, 0.0), atol=1e-7)
    np.testing.assert_array_equal(found.heights(X, 5.0), found.heights(X, 0 * X))
    np.testing.assert_allclose(found.heights_above(0.75, X, 0.0), WAVE.heights(X, 0.0), atol=1e-7)
    np.testing.assert_allclose(found.heights_above(1.5, X, 0.0), 0.0, atol=1e-12)
    assert found.even == (True, False) and found.is_uniform_along_y
    assert found.size == pytest.approx(2 * 12 / 512) and found.covered == pytest.approx((10.0, np.inf))


def test_a_profile_is_tapered_at_its_two_ends() -> None:
    """Over a tenth of its length, if nothing else is said; its middle is at x."""
    level = profile(np.full(100, 2.0), 4.0, x=1.0)
    places = np.array([-1.0, -0.8, -0.6, 1.0, 2.6, 2.8, 3.0])
    np.testing.assert_allclose(level.heights(places, 0.0), [0, 1, 2, 2, 2, 1, 0], atol=1e-12)


def test_heights_in_a_row_are_a_profile() -> None:
    m = Measured.of(OF_WAVE, "2 um", cutoff=0.5)
    rms = Quantity(HeightMap(OF_WAVE).rms, "m")
    assert (m.length_x, m.length_y, m.rms, m.cutoff) == (Quantity(512 * 2e-6, "m"), None, rms, 0.5)
    assert Measured.of(OF_WAVE[None], 2e-6, cutoff=0.5) == m
    with pytest.raises(ValueError, match=r"^spacing = \(2e-06, 1e-06\): must be .* one number, or two for a map$"):
        Measured.of(OF_WAVE, (2e-6, 1e-6))
    for name in ("length_y", "y", "angle"):
        with pytest.raises(ValueError, match=f"^{name} = 1.0: a profile is the same at all y; leave it out$"):
            profile(**{name: 1.0})


# -- self-affine ------------------------------------------------------------------------------------------------------

PERIOD = np.arange(256) / 32  # one period of 8 longest waves


def spectrum(heights: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The wave numbers in a period, and the power of every wave."""
    n = np.fft.fftfreq(256, 1 / 256)
    return np.hypot(n, n[:, None]), np.abs(np.fft.fft2(heights)) ** 2


def test_its_heights_have_the_rms_that_is_given_are_gaussian_and_the_same_in_all_directions() -> None:
    period = ROUGH.heights(PERIOD[None, :], PERIOD[:, None])
    assert period.std() == pytest.approx(0.02, rel=1e-9)
    assert period.mean() == pytest.approx(0.0, abs=1e-12)
    z = period / period.std()
    assert abs(np.mean(z**3)) < 0.2
    assert np.mean(z**4) == pytest.approx(3.0, abs=0.4)
    shifts = [(0, 10), (10, 0), (7, 7), (7, -7)]
    differences = [float(np.mean((np.roll(period, shift, (0, 1)) - period) ** 2)) for shift in shifts]
    assert np.ptp(differences) < 0.15 * np.mean(differences)


@pytest.mark.parametrize("hurst", [0.3, 0.8, 1.0])
def test_its_spectrum_falls_with_the_hurst_exponent(hurst) -> None:
    wave_number, power = spectrum(replace(ROUGH, hurst=hurst).heights(PERIOD[None, :], PERIOD[:, None]))
    inside = (wave_number >= 8) & (wave_number <= 80)
    slope = np.polyfit(np.log(wave_number[inside]), np.log(power[inside]), 1)[0]
    assert slope == pytest.approx(-2 * (1 + hurst), rel=1e-6)


def test_it_has_no_waves_beyond_its_wavelengths_and_a_flat_spectrum_above_the_rolloff() -> None:
    rough = replace(ROUGH, rolloff=0.4)
    wave_number, power = spectrum(rough.heights(PERIOD[None, :], PERIOD[:, None]))
    assert power[(wave_number < 8) | (wave_number > 80)].max() < 1e-20 * power.max()
    flat = power[(wave_number >= 8) & (wave_number <= 20)]
    np.testing.assert_allclose(flat, flat[0], rtol=1e-6)


def test_it_is_made_from_its_seed_alone() -> None:
    """Not of the versions of what it is made with: a stored run is of this very surface."""
    np.random.seed(1)
    first = ROUGH.heights(X, Y)
    np.random.seed(2)
    state = np.random.get_state()[1].copy()
    np.testing.assert_array_equal(replace(ROUGH, seed=3).heights(X, Y), first)
    np.testing.assert_array_equal(np.random.get_state()[1], state)
    other = replace(ROUGH, seed=4).heights(X, Y)
    assert abs(np.corrcoef(first.ravel(), other.ravel())[0, 1]) < 0.5
    stored = [0.015897500571773485, -0.003417118367155514]
    np.testing.assert_allclose(ROUGH.heights(np.array([0.0, 0.3]), 0.1), stored, rtol=1e-9)


def test_a_shorter_cutoff_adds_waves_and_moves_none() -> None:
    """The phases of the long waves do not depend on how many short ones there are."""
    finer = replace(ROUGH, shortest=0.05)
    long_waves = finer.heights_above(0.2, X, Y) / ROUGH.heights_above(0.2, X, Y)
    np.testing.assert_allclose(long_waves, long_waves[0, 0], rtol=1e-6)


def test_it_is_one_surface_on_every_grid_and_for_every_shape_of_arrays() -> None:
    whole = ROUGH.heights(X, Y)
    np.testing.assert_allclose(ROUGH.heights(X[:, ::2], Y[::4]), whole[::4, ::2], atol=1e-15)
    np.testing.assert_allclose(ROUGH.heights(X + 0 * Y, Y + 0 * X), whole, atol=1e-15)
    np.testing.assert_allclose(ROUGH.heights(X[0], 0.0), ROUGH.heights(X, np.zeros((1, 1)))[0], atol=1e-15)


@given(st.floats(-20.0, 20.0), st.integers(-2, 2), st.integers(-2, 2))
def test_it_repeats_itself_after_its_period(x, m, n) -> None:
    assert ROUGH.heights(x + 8.0 * m, 8.0 * n) == pytest.approx(ROUGH.heights(x, 0.0), abs=1e-11)


# -- what a grid keeps ------------------------------------------------------------------------------------------------


def test_a_cutoff_keeps_long_waves_whole_and_nothing_of_those_below_half_of_it() -> None:
    np.testing.assert_array_equal(kept_share(1.0 / np.array([100.0, 1.0, 0.5, 0.1, 1e-9])), [1, 1, 0, 0, 0])
    assert kept_share(1.5) == 0.5
    assert (np.diff(kept_share(np.linspace(0.9, 2.1, 50))) <= 0).all()
    assert smooth_step(0.25) + smooth_step(0.75) == 1.0


@pytest.mark.parametrize("shape", [ROUGH, sampled(ROUGH, 160, 160, 4.0, 4.0)], ids=["self-affine", "measured"])
def test_what_is_resolved_is_not_touched(shape) -> None:
    """A cutoff below all waves changes nothing; of a cutoff above all of them nothing is left."""
    whole = shape.heights(X, Y)
    np.testing.assert_allclose(shape.heights_above(0.5 * shape.size, X, Y), whole, atol=1e-12 * np.abs(whole).max())
    assert np.abs(shape.heights_above(100.0, X, Y) - shape.heights_above(100.0, 0.0, 0.0)).max() < 1e-3 * whole.std()


@pytest.mark.parametrize(("wavelength", "left"), [(0.5, 1.0), (0.125, 0.0)])
def test_a_map_loses_its_short_waves_and_keeps_the_long_ones(wavelength, left) -> None:
    wave = Waviness(0.01, wavelength)
    m = sampled(wave, 192, 64, 3.0, 3.0, taper=0.5)
    inner = X[:, 5:-5] + 0 * Y
    np.testing.assert_allclose(m.heights_above(0.3, inner, Y), left * wave.heights(inner, Y), atol=2e-5)


def test_a_cutoff_of_its_own_is_one_of_a_grid_and_only_rough_surfaces_have_one() -> None:
    m = measured(NOISE)
    np.testing.assert_array_equal(replace(m, cutoff=0.5).heights(X, Y), m.heights_above(0.5, X, Y))
    np.testing.assert_array_equal(replace(m, cutoff=0.5).heights_above(0.2, X, Y), m.heights_above(0.5, X, Y))
    cut, whole = (height([Feature(Spot(0.1, height=0.02))], STEADY_ROLLING, 0.0, X, Y, *c) for c in ((10.0,), ()))
    np.testing.assert_array_equal(cut, whole)


def test_the_size_is_that_of_the_shortest_wave() -> None:
    sizes = ROUGH.size, measured(NOISE).size, measured(NOISE, cutoff=0.5).size
    assert sizes == pytest.approx((0.1, 0.2, 0.5))
    assert measured(NOISE, taper=0.2).covered == pytest.approx((3.6, 2.0))


def test_any_bit_of_the_header_of_an_array_may_be_wrong() -> None:
    """NumPy evaluates the header as Python, which fails in several ways."""
    stream = BytesIO()
    np.save(stream, np.ones((16, 16)))
    content = stream.getvalue()
    for bit in range(8 * 128):
        changed = bytearray(content)
        changed[bit // 8] ^= 1 << bit % 8
        with suppress(ValueError):
            array_in(bytes(changed))
