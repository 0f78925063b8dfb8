"""Colours of films in white light: the standard observer, screens, and the chart that pictures are made from."""

import numpy as np
import pytest

from ertel.optics import BlackBody, Chart, Daylight, Monochromatic, Rig, TwoBeams, White, reflection
from ertel.optics import light as colour

NM = 1e-9
RIG = Rig(oil_index=1.5)
HUNDREDS = np.arange(0, 600, 100) * NM


@pytest.fixture(scope="module")
def science():
    with np.printoptions():  # which it changes, and with them messages that other tests read
        return pytest.importorskip("colour", reason="another program for colours, of the extra test")


# -- the eye and the screen -------------------------------------------------------------------------------------------


def test_table_is_that_of_the_cie(science):
    wavelengths, functions = colour.observer()
    observer, lamp = science.MSDS_CMFS["CIE 1931 2 Degree Standard Observer"], science.SDS_ILLUMINANTS["D65"]
    np.testing.assert_allclose(functions, [observer[nm] for nm in wavelengths / NM], atol=1e-15)
    np.testing.assert_allclose(Daylight().power(wavelengths), [lamp[nm] for nm in wavelengths / NM], rtol=1e-12)


def test_sums_of_the_observer():
    """The three functions have the same area: light of equal energy is white."""
    np.testing.assert_allclose(colour.observer()[1].sum(axis=0) * 5, 106.86, atol=0.06)


@pytest.mark.parametrize("lamp", [Daylight(), BlackBody(3200)])
def test_mirror_is_white_in_any_light(lamp):
    np.testing.assert_allclose(colour.weights(lamp)[1].sum(axis=0), 1.0, atol=1e-4)


@pytest.mark.parametrize("lamp", [Daylight(), BlackBody(3200)])
def test_spectra_become_colours(science, lamp):
    """XYZ, adaptation and sRGB's curve against another program, of a spectrum that a screen can show."""
    wavelengths, functions = colour.observer()
    spectrum = 0.5 + 0.2 * np.cos((wavelengths - 500 * NM) / (60 * NM))
    white = (lamp.power(wavelengths)[:, None] * functions).sum(axis=0)
    XYZ = (lamp.power(wavelengths)[:, None] * functions * spectrum[:, None]).sum(axis=0) / white[1]
    expected = science.XYZ_to_sRGB(
        XYZ, science.XYZ_to_xy(white), chromatic_adaptation_transform="XYZ Scaling", apply_cctf_encoding=True
    )
    np.testing.assert_allclose(colour.encode(spectrum @ colour.weights(lamp)[1]), expected, atol=3e-4)


def test_colours_that_a_screen_has_not():
    """They keep their luminance and lose saturation; colours that it has stay."""
    wild = np.array([[-0.1, 0.3, 0.1], [0.5, 1.1, -0.2], [0.2, 0.4, 0.6], [2.0, 2.0, 2.0]])
    shown = colour.into_gamut(wild)
    assert shown.min() >= 0.0 and shown.max() <= 1.0
    np.testing.assert_allclose(shown[:3] @ colour.LUMINANCE, wild[:3] @ colour.LUMINANCE)
    np.testing.assert_array_equal(shown[2], wild[2])
    np.testing.assert_array_equal(shown[3], 1.0)
    grey = wild[0] @ colour.LUMINANCE
    np.testing.assert_allclose(np.cross(shown[0] - grey, wild[0] - grey), 0.0, atol=1e-15)  # the same hue


# -- films in white light ---------------------------------------------------------------------------------------------


def test_reference_colours():
    """Of the design, which has Gaussian fits of the observer: their sums differ by 0.15 %, single values by more."""
    expected = [
        (0.389, 0.390, 0.399), (0.017, 0.059, 0.122), (0.501, 0.244, 0.061),
        (-0.079, 0.170, 0.412), (0.540, 0.126, 0.143), (-0.109, 0.312, 0.111),
    ]  # fmt: skip
    np.testing.assert_allclose(White(BlackBody(5500)).colours(RIG, HUNDREDS, 1.5), expected, atol=2.5e-3)


def test_thick_films_are_not_aliased():
    """Against 40 wavelengths in every 5 nm; the sum over the table alone would show colours that are not there."""
    table, weight = colour.weights(Daylight())
    fine = np.linspace(table[0], table[-1], 40 * (len(table) - 1) + 1)
    dense = np.stack([np.interp(fine, table, channel) for channel in weight.T], axis=-1)
    dense /= dense.sum(axis=0)
    film = np.linspace(0.0, 30e-6, 121)
    expected = np.array([RIG.fringes(fine, 1.5).reflectance(1.5 * h) @ dense for h in film])
    coarse = np.array([RIG.fringes(table, 1.5).reflectance(1.5 * h) @ weight for h in film])
    found = White().colours(RIG, film, 1.5)
    np.testing.assert_allclose(found, expected, atol=1e-3)
    assert np.abs(coarse - expected).max() > 0.1
    np.testing.assert_allclose(found[40:], np.broadcast_to(White().mean(RIG, 1.5), found[40:].shape), atol=5e-3)


# -- chart and pictures -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("light", [Monochromatic(), White()])
def test_chart_is_the_light_itself(light):
    film, density = np.meshgrid(np.linspace(0.0, 2e-6, 301), np.linspace(1.0, 1.25, 7))
    chart = Chart(RIG, light, 2e-6, 1.25)
    found = chart.linear(film, density)
    np.testing.assert_allclose(found, light.colours(RIG, film, RIG.index(density)), atol=1e-3)
    np.testing.assert_array_equal(chart.linear(film[3, 90], density[3, 90]), found[3, 90])  # of one film


@pytest.mark.parametrize("pixels", [24, 48, 96, 400])
def test_no_ghost_rings(pixels):
    """The fringes of a paraboloid get finer outwards: they are grey where the pixels cannot show them."""
    x = np.linspace(-1.0, 1.0, pixels)
    film = 10e-6 * (x[:, None] ** 2 + x[None, :] ** 2)
    chart = Chart(RIG, Monochromatic(coherence=np.inf), film.max())
    change = np.hypot(*np.gradient(1.5 * film))  # of a fringe of half a wavelength, from pixel to pixel
    light = chart.linear(film, 1.0, change)[..., 0]
    ghost = np.abs(light - RIG.fringes(532 * NM, 1.5).mean) / 0.2
    assert ghost[change > 0.75 * 532 * NM / 2].max(initial=0.0) < 0.01
    plain = chart.linear(film, 1.0)[..., 0]
    fine = change < 0.03 * 532 * NM / 2
    np.testing.assert_allclose(light[fine], plain[fine], atol=0.01)


# -- oil above air ----------------------------------------------------------------------------------------------------

LASER = Monochromatic(coherence=np.inf)
GLASS, METAL, STEEL_INDEX = (RIG.glass, RIG.coatings[0].medium, RIG.surface)


def layered(film, void, order=("oil", "air"), wavelength=532 * NM):
    """The reflectance of the whole stack of layers, without harmonics."""
    index, thickness = {"oil": 1.5, "air": 1.0}, {"oil": film - void, "air": void}
    ends = [medium.index(wavelength) for medium in (GLASS, METAL, STEEL_INDEX)]
    stack = [*ends[:2], *(index[each] for each in order), ends[2]]
    return np.abs(reflection(stack, [8 * NM, *(thickness[each] for each in order)], wavelength)) ** 2


def test_a_void_is_a_layer_of_air_below_the_oil():
    """Against the stack of layers, which has all beams; in white light thin films, of which every line is coherent."""
    film, void = np.meshgrid(np.linspace(0.8e-6, 3e-6, 41), np.linspace(1 * NM, 0.7e-6, 17))
    found = Chart(RIG, LASER, film.max()).linear(film, 1.0, void=void)[..., 0]
    np.testing.assert_allclose(found, layered(film, void), atol=4e-3)
    thin, air = film / 4, void / 4
    lines = zip(*colour.weights(Daylight()), strict=True)
    expected = sum(layered(thin, air, wavelength=wavelength)[..., None] * weight for wavelength, weight in lines)
    np.testing.assert_allclose(Chart(RIG, White(), thin.max()).linear(thin, 1.0, void=air), expected, atol=4e-3)


@pytest.mark.parametrize("light", [LASER, White()])
@pytest.mark.parametrize("rig", [RIG, TwoBeams(oil_index=1.5)])
def test_a_void_begins_as_a_full_film(light, rig):
    film = np.linspace(0.1e-6, 2e-6, 101)
    chart = Chart(rig, light, film.max())
    np.testing.assert_allclose(chart.linear(film, 1.0, void=1e-15), chart.linear(film, 1.0), atol=4e-3)


def test_beyond_the_coherence_the_oil_keeps_the_colour_of_its_own():
    oil, turn = np.linspace(0.0, 1e-6, 51)[:, None], 266 * NM * np.arange(32) / 32
    far = Chart(RIG, Monochromatic(), 1e-4).linear(oil + 60e-6, 1.0, void=60e-6)[..., 0]
    mean = layered(oil + turn, turn).mean(axis=1, keepdims=True)
    np.testing.assert_allclose(far, mean, atol=4e-3)
    assert np.ptp(mean) > 0.1


def test_rings_hardly_tell_which_surface_carries_the_oil():
    """Their phase over the path n oil + air, as a share of a fringe; oil on the glass gives the stronger ones."""
    share = np.arange(32) / 32
    path, wave = 266 * NM * share, np.exp(-2j * np.pi * share)
    oil, air = path[:, None] / 1.5, path[None, :]
    orders = ("oil", "air"), ("air", "oil")
    on_glass, on_steel = (wave @ layered(oil + air, air, order) @ wave for order in orders)
    assert abs(np.angle(on_glass / on_steel)) / (2 * np.pi) < 0.05
    assert abs(on_glass) > 1.5 * abs(on_steel)


def test_no_ghost_rings_beside_air():
    """The air below a layer of oil: where its fringes are too fine, the picture has the one colour of the layer."""
    x = np.linspace(-1.0, 1.0, 96)
    film = 0.5e-6 + 20e-6 * (x[:, None] ** 2 + x[None, :] ** 2)
    picture = Chart(RIG, LASER, film.max()).picture(film, np.ones_like(film), np.maximum(film - 1e-6, 0.0))[..., 0]
    far = np.hypot(x[:, None], x[None, :])[1:-1, 1:-1] > 0.7  # the gradient is one-sided on the edge
    assert np.ptp(picture[1:-1, 1:-1][far]) < 0.02 < np.ptp(picture)


def test_brightest_film_is_white():
    film = np.linspace(0, 1e-6, 500)
    for light in (Monochromatic(), White()):
        shown = Chart(RIG, light, 1e-6).shown(film, 1.0)
        assert shown.min() >= 0.0 and 0.98 < shown.max() <= 1.0
