"""Movies of the film and of the pressure over the surface of a run in time, as matplotlib animations.

    ertel.plots.movie(result.dataset, "pressure", rate=20).save("pressure.gif", writer="pillow")

The frames are at equal times; between two maps the fields are interpolated linearly, as profiles are.  The colours and
the part of the surface that is shown are the same in all frames.
"""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.animation import FuncAnimation, PillowWriter
from matplotlib.axes import Axes
from PIL import Image

from ertel.plots.drawing import NoFigure, compose
from ertel.plots.fields import draw_film_map, draw_pressure_map
from ertel.plots.view import Limits, View, require_maps
from ertel.results.figures import MADE_BY, is_steady
from ertel.results.profiles import between

PER_SECOND = 12.0  # frames
SECONDS = 8.0  # of a movie
MARK = (8 + len(MADE_BY)).to_bytes(4, "big") + b"free" + MADE_BY.encode()  # a box at the end of the file, passed over
FOR_PALETTE = 8  # frames whose colours a GIF has
FASTEST = 50.0  # frames a second that a GIF can have
MOVIES: Mapping[str, Callable[..., None]] = {"film": draw_film_map, "pressure": draw_pressure_map}


def movie(dataset: xr.Dataset, what: str = "film", rate: float = PER_SECOND) -> FuncAnimation:
    """The film thickness or the pressure over the surface through a run in time, as an animation of eight seconds.

    Parameters
    ----------
    dataset : xarray.Dataset
        A run in time.
    what : str
        "film" or "pressure".  The colours of films are those of the picture `film`, thicker ones have the last one;
        those of pressures reach up to the highest in a map.
    rate : float
        Frames a second, from 1 to 50.

    Returns
    -------
    FuncAnimation
        `save("film.gif", writer="pillow")` writes it.

    Raises
    ------
    NoFigure
        A steady contact, fewer than two maps, another picture or rate.
    """
    if what not in MOVIES:
        raise NoFigure(f"what = {what!r}: must be one of {', '.join(MOVIES)} in a movie")
    if not 1.0 <= rate <= FASTEST:
        raise NoFigure(f"rate = {rate:g}: must be from 1 to {FASTEST:g} frames a second")
    dataset = in_motion(dataset)
    first, T = View(dataset, 0), dataset["frame"].values
    top = 1.5 * View.of(dataset).film_inside() if what == "film" else max(float(dataset["P"].max()), 0.01)
    limits = Limits(top, first.extent(first.x, first.midlines("P").max(axis=0)))
    times = np.linspace(T[0], T[-1], round(rate * SECONDS))

    def draw(axes: Axes, T: float) -> str:
        view = View(between(dataset, T), 0, limits=limits)
        MOVIES[what](axes, view)
        return view.clock

    return animated(draw, times.tolist(), first.title, rate)


def in_motion(dataset: xr.Dataset) -> xr.Dataset:
    """The run, loaded.  Raises NoFigure for a steady contact, a line contact, and fewer than two maps."""
    if is_steady(dataset):
        raise NoFigure("animation: a steady contact does not move; draw its picture")
    require_maps(dataset, "animation")
    if (count := dataset.sizes["frame"]) < 2:
        raise NoFigure(f"animation: the run has {count} maps, and needs 2 to move; let it run on")
    return dataset.load()


def animated(
    draw: Callable[[Axes, Any], str], frames: Sequence[float], heading: Sequence[str], rate: float
) -> FuncAnimation:
    """A panel that is drawn again for each frame, and laid out once and for all.

    draw: it draws a frame into axes and gives its time, which comes into the title.
    """
    figure = compose(frames[0], [[draw]], heading)
    figure.set_dpi(100)
    figure.draw_without_rendering()
    figure.set_layout_engine(None)  # with "none" matplotlib draws each frame twice, once for its layout
    axes = figure.axes[0]

    def update(frame: float) -> list[Any]:
        axes.clear()
        clock = draw(axes, frame)
        axes.set_title(f"{axes.get_title().partition(',')[0]}, {clock}")
        return []

    return FuncAnimation(figure, update, frames=frames, interval=1000.0 / rate)


class PaletteWriter(PillowWriter):
    """A writer of GIF whose frames share 256 colours, those of some of them: half of the bytes of `PillowWriter`."""

    def finish(self) -> None:
        """Write the frames."""
        frames = [frame.convert("RGB") for frame in self._frames]  # type: ignore[has-type]
        some = np.concatenate([np.asarray(frame) for frame in frames[:: max(1, len(frames) // FOR_PALETTE)]])
        palette = Image.fromarray(some).quantize(method=Image.Quantize.FASTOCTREE)
        self._frames = [frame.quantize(palette=palette, dither=Image.Dither.NONE) for frame in frames]
        super().finish()


def save_movie(movie: FuncAnimation, file: Path, rate: float) -> None:
    """Write an animation as GIF, WebP or MP4, by the ending of the file, with the mark of ertel's files."""
    writer: Any = {".gif": PaletteWriter, ".webp": PillowWriter}.get(file.suffix)
    movie.save(file, writer=writer(fps=rate) if writer else "ffmpeg")
    file.write_bytes(file.read_bytes() + MARK)
