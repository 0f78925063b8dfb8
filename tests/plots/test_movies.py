"""Movies of film and pressure: frames at equal times, the same colours and the same surface in all of them."""

import numpy as np
import pytest
from made_up import BALL_FALLS, dry_impact
from matplotlib.animation import FuncAnimation
from matplotlib.figure import Figure
from PIL import Image, ImageSequence

from ertel import plots
from ertel.plots.movies import save_movie
from ertel.results.profiles import between


@pytest.fixture(scope="module")
def ball():
    """Seven maps, not at equal times."""
    return dry_impact(BALL_FALLS).isel(frame=[0, 5, 20, 30, 48, 55, 70])


@pytest.mark.parametrize(("what", "name", "unit"), [("film", "H", 1e-9), ("pressure", "P", 1e9)])
def test_frames_are_at_equal_times_and_alike(ball, what, name, unit):
    movie = plots.movie(ball, what, rate=1)
    times = list(movie.new_frame_seq())
    np.testing.assert_allclose(times, np.linspace(float(ball["frame"][0]), float(ball["frame"][-1]), 8))
    movie._draw_was_started = True  # or it complains that nobody saved it
    axes, seen = movie._fig.axes[0], []
    for T in times[2:5]:
        movie._draw_frame(T)
        (image,) = axes.images
        seen.append((image.get_clim(), axes.get_xlim(), axes.get_ylim(), axes.get_position().bounds))
        t = (T - 1.0) * ball["frame"].attrs["si_factor"] * 1e6
        assert axes.get_title().endswith(f", $t$ = {t:.4g} µs")
        values = np.asarray(image.get_array())
        rows, columns = values.shape[-2:]
        middle = between(ball, T)[name].isel(frame=0).sel(X=0.0, Y=0.0, method="nearest")
        in_unit = float(middle) * ball[name].attrs["si_factor"] / unit
        assert values.reshape(rows, columns)[rows // 2, columns // 2] == pytest.approx(in_unit)
    assert seen[0] == seen[1] == seen[2] and len(movie._fig.axes) == 2


def test_a_gif_has_one_palette_and_half_the_bytes(tmp_path):
    """Noise, in which no two frames are alike, and steps of brightness, which remain."""
    figure = Figure(figsize=(2, 2), dpi=50)
    image = figure.add_axes((0, 0, 1, 1)).imshow(np.zeros((50, 50)), vmin=0, vmax=1, cmap="viridis")
    noise = np.random.default_rng(0).random((6, 50, 50)) * 0.1 + np.linspace(0, 0.9, 6)[:, None, None]
    animation = FuncAnimation(figure, lambda values: image.set_data(values), frames=noise, cache_frame_data=False)
    save_movie(animation, tmp_path / "own.gif", 10)
    animation.save(tmp_path / "pillow.gif", writer="pillow", fps=10)
    sizes, frames = [], []
    for name in ("own.gif", "pillow.gif"):
        sizes.append((tmp_path / name).stat().st_size)
        with Image.open(tmp_path / name) as movie:
            frames.append([np.asarray(each.convert("RGB"), dtype=float) for each in ImageSequence.Iterator(movie)])
    assert sizes[0] < 0.75 * sizes[1]
    assert len(frames[0]) == 6 and np.abs(np.subtract(*frames)).mean(axis=(1, 2, 3)).max() < 6.0


def test_between_two_maps_fields_are_interpolated_linearly(ball):
    first, second = (float(ball["frame"][number]) for number in (2, 3))
    found = between(ball, 0.75 * first + 0.25 * second)
    expected = 0.75 * ball["P"].values[2] + 0.25 * ball["P"].values[3]
    np.testing.assert_allclose(found["P"].values[0], expected)
    np.testing.assert_allclose(between(ball, second)["H"].values[0], ball["H"].values[3])
    assert found.sizes["frame"] == 1 and found.sizes["time"] == ball.sizes["time"]
