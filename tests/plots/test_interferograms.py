"""Interferograms of runs: what the picture shows is the film of the run, in every kind of run."""

import numpy as np
import pytest
from made_up import BALL_FALLS, BALL_ROLLS, MOES_FALLS, dry_impact, steady
from PIL import Image, ImageSequence

from ertel import plots
from ertel.case.spaces import radii
from ertel.optics import Monochromatic, TwoBeams, White
from ertel.plots import interferograms as page
from ertel.plots.view import View


@pytest.fixture(scope="module")
def ball():
    return dry_impact(BALL_FALLS)


@pytest.fixture(scope="module")
def rolls():
    return steady(BALL_ROLLS)


@pytest.fixture
def few_pixels(monkeypatch):
    monkeypatch.setattr(page, "PIXELS", 40)


def images(figure):
    """The picture and the chart below the profile, as arrays."""
    return [np.asarray(axes.images[0].get_array()) for axes in figure.axes]


def on_pixels(view, film_scale):
    """What is seen on the pixels: film, density and void."""
    return page.seen_on(view, page.pixels_around([view]), film_scale)


@pytest.mark.parametrize("every", [1, 8])
def test_rings_of_a_paraboloid_on_a_coarse_grid(ball, every):
    """As many as its film has half wavelengths, also where a ring is finer than a cell; none that is not there."""
    coarse = ball.isel(X=slice(0, None, every), Y=slice(0, None, every), frame=[48])
    r2 = coarse["X"] ** 2 + coarse["Y"] ** 2
    H = coarse["H"].copy(data=np.broadcast_to(r2.T, coarse["H"].shape))
    coarse, light, rig = coarse.assign(H=H, oil=H), Monochromatic(coherence=np.inf), TwoBeams()
    scale = 4 * light.wavelength / rig.oil_index  # m: eight rings to r = a, the last ones a sixteenth of it wide
    figure = plots.interferogram(coarse, light=light, rig=rig, film_scale=scale)
    grey = images(figure)[0]
    side = figure.axes[0].get_xlim()[1] / (ball["X"].attrs["si_factor"] * 1e6)
    outwards = grey[len(grey) // 2, grey.shape[1] // 2 :]
    crossings = np.count_nonzero(np.diff(np.sign(outwards - (outwards.min() + outwards.max()) / 2)))
    assert crossings == pytest.approx(2 * 8 * side**2, abs=1)


def test_picture_is_the_film_of_the_run(ball, rolls, few_pixels):
    """Each pixel has the grey of the film and of the oil's density at its place."""
    light, rig = Monochromatic(coherence=np.inf), TwoBeams()
    seen = on_pixels(View.of(rolls), rolls["H"].attrs["si_factor"])
    nodes = rolls["H"].interp(X=seen["X"], Y=seen["Y"]) * rolls["H"].attrs["si_factor"]
    np.testing.assert_allclose(seen["film"], nodes, atol=4e-9)
    np.testing.assert_array_equal(seen["density"], 1.0)  # BARUS is incompressible
    (grey, _) = images(plots.interferogram(rolls, light=light, rig=rig))
    values = [seen[name].values for name in ("film", "density", "void")]
    expected = page.Chart(rig, light, float(seen["film"].max())).picture(*values)[..., 0]
    np.testing.assert_allclose(grey, expected, atol=0.01)
    density = on_pixels(View(ball, 48), 1e-6)["density"]  # of oil under pressure
    assert density[0, 0] == 1.0
    assert density.max() == pytest.approx(1.24, abs=0.01)  # Dowson and Higginson's at 1.4 GPa
    # They are finest at the edge of the contact.
    r = radii(101, 2.0)
    run = dry_impact(MOES_FALLS, radial=True).isel(frame=[48]).interp(r=r)
    run = run.assign(H=run["H"].copy(data=(0.1 + r[None, :] ** 2 / 2)))
    x = np.linspace(-1.3, 1.3, 27)
    seen = page._on_pixels(View.of(run), "H", x, np.zeros(1), smooth=True)
    np.testing.assert_allclose(seen[0], 0.1 + x**2 / 2, rtol=1e-9)


@pytest.mark.parametrize(("film_scale", "is_said"), [(1e-6, False), (1e-4, True)])  # a film of 0.05 and 5 um
def test_white_light_says_where_it_has_no_colours(ball, few_pixels, film_scale, is_said):
    figure = plots.interferogram(ball, light=White(), film_scale=film_scale)
    said = [text.get_text() for text in figure.axes[0].texts]
    assert said == ["no colours here, try mono"] * is_said


def test_picture_has_oil_and_air(ball, few_pixels):
    """The layer where the gap is not full; the full film and its chart are the same to the last bit."""
    layer = 0.3  # a^2/R
    starved = ball.assign(oil=np.minimum(ball["H"], layer).assign_attrs(ball["H"].attrs))
    optics = {"light": Monochromatic(coherence=np.inf), "rig": TwoBeams(), "film_scale": 4e-7}
    grey, chart = images(plots.interferogram(starved, **optics))
    full, of_films = images(plots.interferogram(ball, **optics))
    seen = on_pixels(View.of(starved), 4e-7)
    film, void = seen["film"].values, seen["void"].values
    beyond = film > 1.3 * layer * 4e-7  # a cell
    np.testing.assert_allclose((film - void)[beyond], layer * 4e-7, rtol=5e-3)
    wet = film < 0.4 * layer * 4e-7
    np.testing.assert_array_equal(grey[wet], full[wet])
    np.testing.assert_array_equal(chart[:, 20], of_films[:, 20])
    assert np.abs(grey - full)[beyond].max() > 0.1 and np.abs(chart - of_films)[:, 0].max() > 0.1


def test_animation(ball, few_pixels, tmp_path):
    """One picture for every map, for ever."""
    path = tmp_path / "ball.webp"
    plots.animation(ball.isel(frame=slice(0, 60, 20))).save(path, writer="pillow", dpi=30)
    with Image.open(path) as movie:
        assert movie.n_frames == 3 and movie.info["loop"] == 0
        first, _, last = (np.asarray(each.convert("L"), dtype=float) for each in ImageSequence.Iterator(movie))
    assert np.abs(last - first).max() > 50
