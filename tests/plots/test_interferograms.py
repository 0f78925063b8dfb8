"""Interferograms of runs: what the picture shows is the film of the run, in every kind of run."""

import numpy as np
import pytest
from drawn import edge_of_oil, words
from made_up import BALL_FALLS, BALL_ROLLS, MOES_FALLS, as_in_time, dry_impact, in_time, steady
from PIL import Image, ImageSequence

from ertel import plots
from ertel.case.definition import radii
from ertel.inputs.python import rolling
from ertel.optics import Constant, Layer, Monochromatic, Rig, TwoBeams, White
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


def values_of(seen):
    """Film, density and void on the pixels."""
    return [seen[name].values for name in ("film", "density", "void")]


def crossings(line):
    return np.count_nonzero(np.diff(np.sign(line - (line.min() + line.max()) / 2)))


def test_the_film_of_a_radial_run_is_that_of_its_nodes():
    """They are finest at the edge of the contact."""
    r = radii(101, 2.0)
    run = dry_impact(MOES_FALLS, radial=True).isel(frame=[48]).interp(r=r)
    run = run.assign(H=run["H"].copy(data=(0.1 + r[None, :] ** 2 / 2)))
    x = np.linspace(-1.3, 1.3, 27)
    seen = page._on_pixels(View.of(run), "H", x, np.zeros(1), smooth=True)
    np.testing.assert_allclose(seen[0], 0.1 + x**2 / 2, rtol=1e-9)


# -- the picture ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("every", [1, 4, 8])
def test_rings_of_a_paraboloid_on_a_coarse_grid(ball, every):
    """As many as its film has half wavelengths, also where a ring is finer than a cell; none that is not there."""
    coarse = ball.isel(X=slice(0, None, every), Y=slice(0, None, every), frame=[48])
    r2 = coarse["X"] ** 2 + coarse["Y"] ** 2
    H = coarse["H"].copy(data=np.broadcast_to(r2.T, coarse["H"].shape))
    coarse = coarse.assign(H=H, oil=H)
    light, rig = Monochromatic(coherence=np.inf), TwoBeams()
    scale = 4 * light.wavelength / rig.oil_index  # m: eight rings to r = a, the last ones a sixteenth of it wide
    figure = plots.interferogram(coarse, light=light, rig=rig, film_scale=scale)
    grey = images(figure)[0]
    side = figure.axes[0].get_xlim()[1] / (ball["X"].attrs["si_factor"] * 1e6)
    outwards = grey[len(grey) // 2, grey.shape[1] // 2 :]
    orders = 8 * side**2
    assert crossings(outwards) == pytest.approx(2 * orders, abs=1)


def test_picture_is_the_film_of_the_run(ball, rolls, few_pixels):
    """Each pixel has the grey of the film and of the oil's density at its place."""
    light, rig = Monochromatic(coherence=np.inf), TwoBeams()
    view = View.of(rolls)
    seen = page.seen_on(view, page.pixels_around([view]), rolls["H"].attrs["si_factor"])
    nodes = rolls["H"].interp(X=seen["X"], Y=seen["Y"]) * rolls["H"].attrs["si_factor"]
    np.testing.assert_allclose(seen["film"], nodes, atol=4e-9)
    np.testing.assert_array_equal(seen["density"], 1.0)  # BARUS is incompressible
    (grey, _) = images(plots.interferogram(rolls, light=light, rig=rig))
    expected = page.Chart(rig, light, float(seen["film"].max())).picture(*values_of(seen))[..., 0]
    np.testing.assert_allclose(grey, expected, atol=0.01)
    view = View(ball, 48)
    density = page.seen_on(view, page.pixels_around([view]), 1e-6)["density"]  # of oil under pressure
    assert density[0, 0] == 1.0
    assert density.max() == pytest.approx(1.24, abs=0.01)  # Dowson and Higginson's at 1.4 GPa


def test_kinds_of_runs(ball, rolls, few_pixels):
    moving = in_time(as_in_time(BALL_ROLLS), -1.0)
    pictures = {name: plots.interferogram(data) for name, data in {"": ball, "→": rolls, "←": moving}.items()}
    for arrow, figure in pictures.items():
        said = figure.axes[0].get_title()
        assert said.startswith("Interferogram at 532 nm") and said.endswith(arrow)
        assert figure.axes[0].get_xlabel() == "$x$ (µm)"
        assert figure.axes[1].get_ylabel() == "film thickness $h$ (nm)"
    dimensionless = plots.interferogram(dry_impact(MOES_FALLS), film_scale=3e-6)
    assert dimensionless.axes[0].get_xlabel() == "$X$ ($a^*$)"
    assert dimensionless.axes[1].get_ylabel() == "film thickness $h$ (nm)"


def test_a_long_contact_is_turned_as_in_maps(few_pixels):
    """Its picture, edges and labels; the flow goes downwards."""
    run = steady(rolling(M=200, L=10, radius_ratio=0.08, nodes=81))
    axes = plots.interferogram(run, film_scale=1e-6).axes[0]
    across, along = page.pixels_around([View(run)])
    (image,) = axes.images
    assert image.get_array().shape[:2] == (len(across), len(along)) and len(along) > 2 * len(across)
    np.testing.assert_allclose(image.get_extent(), [along[0], along[-1], across[0], across[-1]])
    assert axes.get_ylim() == (across[-1], across[0])
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("$Y$ ($a$)", "$X$ ($a$)")
    assert axes.get_title().endswith("flow \N{DOWNWARDS ARROW}")


def test_radial_run_is_revolved(few_pixels):
    grey = images(plots.interferogram(dry_impact(BALL_FALLS, radial=True)))[0]
    np.testing.assert_allclose(grey, grey.T, atol=1e-12)
    np.testing.assert_allclose(grey, grey[::-1], atol=1e-12)
    whole = images(plots.interferogram(dry_impact(BALL_FALLS)))[0]
    assert np.median(np.abs(grey - whole)) < 0.02


def test_white_light_is_in_colour_by_its_name_too(ball, few_pixels):
    figure = plots.interferogram(ball, light=White())
    picture, chart = images(figure)
    assert picture.shape == (40, 40, 3) and chart.shape[-1] == 3
    assert np.ptp(picture, axis=-1).max() > 0.3
    assert figure.axes[0].get_title() == "Interferogram in white light"
    np.testing.assert_array_equal(images(plots.interferogram(ball, light="white"))[0], picture)


def test_layers_change_the_picture_and_the_profile_is_the_film_of_the_mid_line(ball, few_pixels):
    bare = images(plots.interferogram(ball, rig=Rig(coatings=())))[0]
    figure = plots.interferogram(ball, rig=Rig(coatings=(Layer(Constant(3.0, 3.0), 10e-9),)))
    assert np.abs(bare - images(figure)[0]).max() > 0.1
    film, (bottom, top) = figure.axes[1].get_lines()[0].get_ydata(), figure.axes[1].get_ylim()
    assert film[20] == pytest.approx(0.05 * ball["H"].attrs["si_factor"] * 1e9, rel=0.1)
    assert bottom == 0.0 and top > film[20]


# -- where the gap is not full ----------------------------------------------------------------------------------------

LAYER = 0.3  # a^2/R


def on_a_layer(run):
    """The same film, with a layer of oil that does not fill it everywhere."""
    return run.assign(oil=run["H"].copy(data=np.minimum(run["H"].values, LAYER)))


@pytest.mark.parametrize("radial", [False, True])
def test_edge_of_the_full_film(radial, few_pixels):
    """A line where the film is as thick as the layer, in the film map and in the interferogram, with its name."""
    run = dry_impact(BALL_FALLS, radial=radial)
    frame = int(np.flatnonzero(run["event"].values)[0])
    H, axis = run["H"].values[frame], (run["r"] if radial else run["X"]).values
    middle = H if radial else H[40]
    radius = np.interp(LAYER, middle[axis >= 0], axis[axis >= 0]) * run["r" if radial else "X"].attrs["si_factor"] * 1e6
    wet = on_a_layer(run)
    for axes in (plots.film(wet).axes[0], plots.interferogram(wet).axes[0]):
        r = np.hypot(*edge_of_oil(axes).T)
        assert len(r) and np.all(abs(r - radius) < 0.05 * radius)  # a cell
        assert "edge of the full film" in words(axes)
    for axes in (plots.film(run).axes[0], plots.interferogram(run).axes[0]):
        assert not len(edge_of_oil(axes)) and not words(axes)


def test_picture_has_oil_and_air(ball, few_pixels):
    """The layer where the gap is not full; the full film and its chart are the same to the last bit."""
    optics = {"light": Monochromatic(coherence=np.inf), "rig": TwoBeams(), "film_scale": 4e-7}
    grey, chart = images(plots.interferogram(on_a_layer(ball), **optics))
    full, of_films = images(plots.interferogram(ball, **optics))
    view = View.of(on_a_layer(ball))
    film, _, void = values_of(page.seen_on(view, page.pixels_around([view]), 4e-7))
    beyond = film > 1.3 * LAYER * 4e-7  # a cell
    np.testing.assert_allclose((film - void)[beyond], LAYER * 4e-7, rtol=5e-3)
    wet = film < 0.4 * LAYER * 4e-7
    np.testing.assert_array_equal(grey[wet], full[wet])
    np.testing.assert_array_equal(chart[:, 20], of_films[:, 20])
    assert np.abs(grey - full)[beyond].max() > 0.1 and np.abs(chart - of_films)[:, 0].max() > 0.1


# -- animation --------------------------------------------------------------------------------------------------------


def test_animation(ball, few_pixels, tmp_path):
    """One picture for every map, for ever."""
    path = tmp_path / "ball.webp"
    plots.animation(ball.isel(frame=slice(0, 60, 20))).save(path, writer="pillow", dpi=30)
    with Image.open(path) as movie:
        assert movie.n_frames == 3 and movie.info["loop"] == 0
        first, _, last = (np.asarray(each.convert("L"), dtype=float) for each in ImageSequence.Iterator(movie))
    assert np.abs(last - first).max() > 50


def test_animation_shows_every_moment_alike(ball, few_pixels, monkeypatch):
    """The same pixels and the same exposure, also when it skips maps."""
    monkeypatch.setattr(page, "FRAMES", 20)
    movie = plots.animation(ball)
    frames = list(movie.new_frame_seq())
    assert frames == list(range(0, 78, 4))
    movie._draw_was_started = True  # or it complains that nobody saved it
    movie._draw_frame(48)
    axes = movie._fig.axes[0]
    grey = np.asarray(axes.images[0].get_array())
    time = float((ball["frame"][48] - 1.0) * ball["frame"].attrs["si_factor"]) * 1e6
    assert axes.get_title() == f"Interferogram at 532 nm, $t$ = {time:.4g} µs"
    pixels = page.pixels_around([View(ball, frame) for frame in frames])
    film, density, _ = values_of(page.seen_on(View(ball, 48), pixels, ball["H"].attrs["si_factor"]))
    expected = page.Chart(Rig(), Monochromatic(), 1e-5, density.max()).picture(film, density)
    np.testing.assert_allclose(grey, expected[..., 0], atol=0.01)


def test_edge_moves_with_the_film(ball, few_pixels):
    """It is there only while a part of the gap is full: not before the ball is wet, and not in a pool."""
    run = on_a_layer(ball)
    run["oil"][1] = run["H"][1]
    movie = plots.animation(run.isel(frame=[0, 1, 24, 48]))
    movie._draw_was_started = True
    axes, radii = movie._fig.axes[0], []
    for frame in (0, 1, 2, 3, 0):
        movie._draw_frame(frame)
        edge = np.hypot(*edge_of_oil(axes).T)
        assert bool(words(axes)) == bool(len(edge))
        radii.append(edge.mean() if len(edge) else 0.0)
    assert radii[0] == radii[1] == radii[4] == 0.0 < radii[2] < radii[3]
