"""Reflectance of coated glass, oil and steel: reference values, another program, limits."""

import numpy as np
import pint
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ertel.optics import (
    BK7,
    CHROMIUM,
    SILICA,
    STEEL,
    Constant,
    Layer,
    Monochromatic,
    Rig,
    TwoBeams,
    film_of_intensity,
    lorentz_lorenz,
    reflection,
)

NM, UNITS = 1e-9, pint.UnitRegistry()
GREEN = 550 * NM
WINDOW = np.linspace(-GREEN / 6, GREEN / 6, 101)  # a period


def chromium(nanometres, kind=Rig):
    return kind(coatings=(Layer(CHROMIUM, nanometres * NM),), oil_index=1.5)


# -- media ------------------------------------------------------------------------------------------------------------


def test_indices_of_media():
    found = BK7.index(np.array([450, 532, 550, 653]) * NM)
    np.testing.assert_allclose(found, [1.52532, 1.51947, 1.51852, 1.51443], atol=6e-6)
    assert SILICA.index(589.3 * NM) == pytest.approx(1.4584, abs=5e-5)
    assert (CHROMIUM.index(549 * NM), STEEL.index(549 * NM)) == (3.18 + 3.33j, 2.95 + 2.93j)
    assert STEEL.index(565.5 * NM) == pytest.approx((2.95 + 2.93j + 2.94 + 2.99j) / 2)  # half way between two


def test_wavelengths_outside_a_table_are_refused():
    with pytest.raises(ValueError, match="wavelength = 5000 nm: must be from 188 to 1937 nm"):
        CHROMIUM.index(np.array([5e-7, 5e-6]))


def test_oil_under_pressure():
    np.testing.assert_allclose(lorentz_lorenz([1.0, 1.1, 1.2, 1.3], 1.48), [1.48, 1.53738, 1.59738, 1.66031], atol=6e-6)
    np.testing.assert_allclose(lorentz_lorenz([1.1, 1.2, 1.25], 1.5), [1.56038, 1.62369, 1.65656], atol=6e-6)


@pytest.mark.parametrize(
    ("made", "message"),
    [
        (
            lambda: Layer(CHROMIUM, 8.0),
            "thickness = 8.0: must be a length from 0 to 0.0001 m; plain numbers are",
        ),
        (lambda: Rig(oil_index=0.9), "oil_index = 0.9"),
        (lambda: Monochromatic(532), "wavelength = 532: must be a length from 2e-07 to 1e-05 m"),
        (lambda: Layer(CHROMIUM, "8 nm"), "thickness = 8 nm: must be a length"),
        (lambda: Monochromatic(UNITS.Quantity(532, "kg")), "wavelength = 532 kilogram: must be a length"),
    ],
)
def test_impossible_parameters_are_refused(made, message):
    with pytest.raises(ValueError, match=message):
        made()


def test_lengths_may_have_a_unit():
    assert Layer(CHROMIUM, UNITS.Quantity(8, "nm")) == Layer(CHROMIUM, 8 * NM)
    assert Monochromatic(UNITS.Quantity(532, "nm"), UNITS.Quantity(20, "um")).wavelength == pytest.approx(532 * NM)
    assert Monochromatic(coherence=np.inf).reach == np.inf


# -- reflectance ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("coating", "at_contact", "dark", "darkest", "bright", "brightest"),
    [
        (5, 0.3805, 80.75, 0.0004, 167.25, 0.4393),
        (8, 0.3869, 80.25, 0.0430, 165.5, 0.4716),
        (10, 0.3912, 79.25, 0.0884, 164.25, 0.4895),
        (15, 0.4011, 73.5, 0.2026, 161.25, 0.5220),
    ],
)
def test_reference_values(coating, at_contact, dark, darkest, bright, brightest):
    """Of the design, on films every quarter of a nanometre."""
    film = np.arange(0.0, 183.0, 0.25)
    R = chromium(coating).fringes(GREEN, 1.5).reflectance(1.5 * film * NM)
    np.testing.assert_allclose([R[0], R.min(), R.max()], [at_contact, darkest, brightest], atol=5e-5)
    assert [film[R.argmin()], film[R.argmax()]] == pytest.approx([dark, bright], abs=0.25)


INDEX = st.builds(complex, st.floats(1.0, 4.0), st.floats(0.0, 4.0))
STACK = st.lists(st.tuples(INDEX, st.floats(0.0, 300.0)), max_size=4)


@given(st.floats(1.0, 2.0), STACK, INDEX, st.floats(400.0, 700.0))
def test_any_stack_against_tmm(first, layers, last, wavelength):
    tmm = pytest.importorskip("tmm", reason="another program for thin films, of the extra test")
    indices, thicknesses = [first, *(n for n, _ in layers), last], [d for _, d in layers]
    expected = tmm.coh_tmm("s", indices, [np.inf, *thicknesses, np.inf], 0.0, wavelength)["r"]
    assert reflection(indices, thicknesses, wavelength) == pytest.approx(expected, abs=1e-9)
    assert abs(expected) <= 1.0 + 1e-12


COATINGS = st.lists(
    st.tuples(st.sampled_from([CHROMIUM, SILICA, BK7, Constant(2.0, 0.5)]), st.floats(0.0, 400.0)), max_size=3
)


@given(COATINGS, st.floats(1.4, 1.7), st.floats(400.0, 700.0), st.floats(0.0, 3000.0))
def test_the_series_of_beams_is_the_recursion(layers, index, wavelength, film):
    rig = Rig(coatings=tuple(Layer(medium, d * NM) for medium, d in layers))
    media = [BK7, *(medium for medium, _ in layers), Constant(index), STEEL]
    expected = reflection(
        [medium.index(wavelength * NM) for medium in media], [*(d for _, d in layers), film], wavelength
    )
    fringes = rig.fringes(wavelength * NM, index)
    R = float(fringes.reflectance(index * film * NM))
    assert R == pytest.approx(abs(expected) ** 2, abs=1e-12)
    assert 0.0 <= R <= 1.0
    assert float(fringes.reflectance(index * film * NM, np.ones_like)) == pytest.approx(R, abs=1e-5)


def test_nothing_comes_back_from_glass_in_oil_of_its_own_index():
    rig = Rig(coatings=(), surface=BK7, oil_index=float(BK7.index(GREEN).real))
    assert rig.fringes(GREEN, rig.oil_index).reflectance(np.linspace(0, 1e-6, 50)) == pytest.approx(0.0, abs=1e-15)


@pytest.mark.parametrize("density", [1.0, 1.2])
@pytest.mark.parametrize("kind", [Rig, TwoBeams])
def test_period(kind, density):
    """Fringes repeat after wavelength/(2 n), and not sooner."""
    rig = chromium(10, kind)
    n = float(rig.index(density))
    film, fringes = np.linspace(0.0, GREEN / (2 * n), 201), rig.fringes(GREEN, n)
    np.testing.assert_allclose(fringes.reflectance(n * film + GREEN / 2), fringes.reflectance(n * film), atol=1e-12)
    assert np.count_nonzero(np.diff(np.sign(np.gradient(fringes.reflectance(n * film))))) <= 2


def test_two_beams_are_a_cosine():
    film = np.linspace(0.0, GREEN / 3, 61)[:-1]
    R = chromium(10, TwoBeams).fringes(GREEN, 1.5).reflectance(1.5 * film)
    assert np.abs(np.fft.rfft(R))[2:].max() < 1e-12 * R.sum()
    assert np.abs(np.fft.rfft(chromium(10).fringes(GREEN, 1.5).reflectance(1.5 * film)))[2] > 0.01 * R.sum()


@pytest.mark.parametrize(("coating", "error"), [(5, 10.6), (10, 16.4), (15, 20.0)])
def test_error_of_two_beams(coating, error):
    """What the docstring of TwoBeams says, with the best constant phase."""
    film = 20 * NM + np.linspace(0.0, GREEN / 1.5, 2001)
    R = chromium(coating).fringes(GREEN, 1.5).reflectance(1.5 * film)
    found = film_of_intensity(R, chromium(coating, TwoBeams), GREEN, film[0], limits=(R.min(), R.max()))
    assert (found - film).max() - (found - film).min() == pytest.approx(2 * error * NM, rel=0.01)


def test_fringes_fade_with_the_coherence():
    light, rig = Monochromatic.of_width(GREEN, 10 * NM), chromium(8)
    assert light.coherence == pytest.approx(0.6643 * GREEN**2 / (10 * NM), rel=1e-4)
    half = light.coherence / 3  # the film that makes a path difference of one coherence length
    near, middle, there, far = (light.colours(rig, h + WINDOW, 1.5) for h in (GREEN / 6, 5e-6, half, 50e-6))
    assert np.ptp(there) / np.ptp(near) == pytest.approx(np.exp(-np.pi / 2), rel=0.1)
    assert np.ptp(far) < 1e-9 < np.ptp(middle) < np.ptp(near)
    np.testing.assert_allclose(far[:, 0], rig.fringes(GREEN, 1.5).mean, rtol=1e-9)


def test_fading_is_the_mean_over_the_line():
    """Against the sum over a Gaussian spectrum, of constant indices."""
    rig = Rig(BK7, (Layer(Constant(3.2, 3.3), 8 * NM),), Constant(2.95, 2.93), 1.5)
    width, film = 20 * NM, np.linspace(0.0, 5e-6, 200)
    light = Monochromatic.of_width(GREEN, width)
    frequency = np.linspace(-3, 3, 4001) * width / GREEN**2
    spectrum = np.exp(-4 * np.log(2) * (frequency * GREEN**2 / width) ** 2)
    wavelengths = 1 / (1 / GREEN + frequency)
    expected = [np.average(rig.fringes(wavelengths, 1.5).reflectance(1.5 * h), weights=spectrum) for h in film]
    np.testing.assert_allclose(light.colours(rig, film, 1.5)[:, 0], expected, atol=2e-3)
