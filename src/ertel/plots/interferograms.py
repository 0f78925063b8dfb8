"""Interferograms: a run as a microscope above coated glass shows it, as a picture and as an animation.

The film and the density of the oil are interpolated from the grid to the pixels of the picture, so that fringes finer
than the grid are drawn as they are.  Beside the picture is the film along the mid-line on the colour chart: the colour
that every film thickness would have there, with the oil as dense as it is there.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
import xarray as xr
from matplotlib.animation import FuncAnimation
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from scipy.interpolate import CubicSpline, RectBivariateSpline

from ertel.optics import Chart, Light, Monochromatic, Rig
from ertel.plots import steady, stored
from ertel.plots.drawing import (
    WIDEST,
    At,
    NoFigure,
    Panel,
    Scale,
    Values,
    axis_label,
    compose,
    is_physical,
    lateral,
    reach,
    scale,
    stretch,
    title,
)
from ertel.plots.moments import entrainment, heading, profiles_of
from ertel.results.variables import is_steady

PIXELS = 480  # along the longer side of a picture
ROUND = 1.7  # how far round the contact the picture reaches, in its half widths
ORDERS = 4.5  # fringes of the film that the colour chart shows, at least
FRAMES = 120  # of an animation, at most
PER_SECOND = 12
TICKS = 6  # along the longer side of a picture


@dataclass(frozen=True)
class Window:
    """The pixels of a picture: their positions in a*."""

    x: Values
    y: Values

    @classmethod
    def round(cls, dataset: xr.Dataset, frames: Sequence[int | None]) -> "Window":
        """Round the contact, as wide as all of the frames need."""
        side = max(_side(dataset, frame) for frame in frames)
        right, top = _edges(dataset)
        left = -right if "r" in dataset else float(dataset["X"].values[0])
        x0, x1, y1 = max(-side, left), min(side, right), min(side * stretch(dataset), top)
        spacing = max(x1 - x0, 2.0 * y1) / PIXELS
        return cls(
            np.linspace(x0, x1, max(round((x1 - x0) / spacing), 2)),
            np.linspace(-y1, y1, max(round(2 * y1 / spacing), 2)),
        )


@dataclass(frozen=True)
class Seen:
    """Film (m) and rho/rho0 over the pixels of a window, (y, x)."""

    film: Values
    density: Values

    @classmethod
    def of(cls, dataset: xr.Dataset, frame: int | None, window: Window, film_scale: float) -> "Seen":
        """Of one frame, or of the steady film.  film_scale: a*^2/R in m."""
        H = np.maximum(_on_pixels(dataset, "H", frame, window, smooth=True), 0.0)
        P = np.maximum(_on_pixels(dataset, "P", frame, window, smooth=False), 0.0)
        return cls(H * film_scale, stored.density(dataset, P))


def _values(dataset: xr.Dataset, name: str, frame: int | None) -> Values:
    return np.asarray((dataset[name] if frame is None else dataset[name].isel(frame=frame)).values)


def _edges(dataset: xr.Dataset) -> tuple[float, float]:
    """How far the grid reaches along x and y."""
    along, across = ("r", "r") if "r" in dataset else ("X", "Y")
    return float(dataset[along].values[-1]), float(dataset[across].values[-1])


def _side(dataset: xr.Dataset, frame: int | None) -> float:
    """How far from the centre one frame is shown along x."""
    P = _values(dataset, "P", frame)
    x, profile = (dataset["r"].values, P) if "r" in dataset else (dataset["X"].values, P.max(axis=0))
    return min(ROUND * reach(np.asarray(x), profile), WIDEST * stored.geometry(dataset).extent[0])


def _on_pixels(dataset: xr.Dataset, name: str, frame: int | None, window: Window, smooth: bool) -> Values:
    """A field on the pixels: by cubic splines, or linear where it has edges."""
    values = _values(dataset, name, frame)
    if "r" not in dataset:
        order = 3 if smooth else 1
        spline = RectBivariateSpline(dataset["Y"].values, dataset["X"].values, values, kx=order, ky=order)
        return np.asarray(spline(window.y, window.x))
    r, pixels = np.asarray(dataset["r"].values), np.hypot(window.y[:, None], window.x[None, :])
    if smooth:  # the film is even in r; beyond the grid, in the corners, it goes on
        return np.asarray(CubicSpline(r, values, bc_type=((1, 0.0), "not-a-knot"))(pixels))
    return np.interp(pixels, r, values)


def _film_scale(dataset: xr.Dataset, given: float | None) -> float:
    """a*^2/R in m."""
    if given is not None:
        if not 0.0 < given < 1.0:
            raise NoFigure(f"film_scale = {given:g}: must be above 0 and below 1 m; it is a*^2/R in metres")
        return given
    if not is_physical(dataset):
        raise NoFigure(
            "interferogram: the run is dimensionless, and light needs a film in nm; run a case in SI, or from Python "
            "give film_scale, a*^2/R in m"
        )
    return float(dataset["H"].attrs["si_factor"])


# -- panels -----------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Scene:
    """What the panels draw: the pixels, the film on them, and its colours.  film: the scale of films as shown."""

    window: Window
    seen: Seen
    chart: Chart
    film: Scale
    flow: float


def _limits(dataset: xr.Dataset, window: Window) -> tuple[float, float, float, float]:
    """The edges of a picture, as shown."""
    factor = lateral(dataset).factor
    x, y = window.x * factor, window.y * factor
    return (x[0], x[-1], y[0], y[-1])


def draw_picture(axes: Axes, dataset: xr.Dataset, scene: Scene) -> None:
    """The interferogram."""
    _show(axes, scene.chart.picture(scene.seen.film, scene.seen.density), _limits(dataset, scene.window))
    flow = (
        "" if scene.flow == 0.0 else ", flow \N{RIGHTWARDS ARROW}" if scene.flow > 0 else ", flow \N{LEFTWARDS ARROW}"
    )
    axes.set(
        xlabel=axis_label(dataset, "x"),
        ylabel=axis_label(dataset, "y"),
        aspect="equal",
        title=f"Interferogram{_named(scene.chart.light)}{flow}",
    )
    for axis, pixels in ((axes.xaxis, scene.window.x), (axes.yaxis, scene.window.y)):
        axis.set_major_locator(MaxNLocator(max(1, round(TICKS * len(pixels) / PIXELS)), min_n_ticks=1))


def _named(light: Light) -> str:
    return f" at {light.wavelength * 1e9:.4g} nm" if isinstance(light, Monochromatic) else " in white light"


def _show(axes: Axes, picture: Values, limits: tuple[float, float, float, float]) -> None:
    image = picture[..., 0] if picture.shape[-1] == 1 else picture
    axes.imshow(image, extent=limits, origin="lower", cmap="gray", vmin=0.0, vmax=1.0)


def draw_chart(axes: Axes, dataset: xr.Dataset, scene: Scene) -> None:
    """The film along the mid-line, on the colours that films would have there.  scene: of one row of pixels."""
    window, (film,) = scene.window, scene.seen.film
    top = _top(scene, film)
    colours = scene.chart.shown(np.linspace(0.0, top, PIXELS)[:, None], scene.seen.density)
    left, right, _, _ = _limits(dataset, window)
    factor = scene.film.factor
    _show(axes, colours, (left, right, 0.0, top * factor))
    axes.plot(window.x * lateral(dataset).factor, film * factor, color="white", linewidth=3.0)
    axes.plot(window.x * lateral(dataset).factor, film * factor, color="black", linewidth=1.2)
    axes.set(
        xlabel=axis_label(dataset, "x"),
        ylabel=scene.film.label,
        xlim=(left, right),
        ylim=(0.0, top * factor),
        aspect="auto",
        title="Film along the mid-line, on the chart of films there",
    )


def _top(scene: Scene, film: Values) -> float:
    """The largest film of the chart (m): of some fringes, and of what is inside the contact."""
    inside = np.abs(scene.window.x) < scene.window.x[-1] / ROUND
    return max(1.2 * float(film[inside].max()), ORDERS * scene.chart.light.typical / (2.0 * scene.chart.rig.oil_index))


# -- figures ----------------------------------------------------------------------------------------------------------


def interferogram(
    dataset: xr.Dataset,
    at: At = None,
    light: Light | None = None,
    rig: Rig | None = None,
    film_scale: float | None = None,
) -> Figure:
    """The contact as an experimenter sees it, and the film along its mid-line on the colours of films.

    Parameters
    ----------
    dataset : xarray.Dataset
        A run.
    at : float or str, optional
        The moment of a run in time: a time in t0 or an event.
    light : Light, optional
        `optics.Monochromatic(wavelength, coherence)` in grey, or `optics.White()` in colour; default green light.
    rig : Rig, optional
        Glass, coatings, surface and the oil's index: `optics.Rig(...)`, or `optics.TwoBeams(...)`; default 8 nm of
        chromium on glass, against steel.
    film_scale : float, optional
        a*^2/R in m; a dimensionless run needs it.

    Raises NoFigure, a ValueError, where there is nothing to draw, and for a dimensionless run without a film_scale.
    """
    scaled, dataset = _film_scale(dataset, film_scale), dataset.load()
    frame, flow, what = _moment(dataset, at)
    window = Window.round(dataset, [frame])
    seen = Seen.of(dataset, frame, window, scaled)
    chart = Chart(rig or Rig(), light or Monochromatic(), float(seen.film.max()), float(seen.density.max()))
    scene = Scene(window, seen, chart, _shown_film(dataset, scaled), flow)
    middle = Window(np.linspace(window.x[0], window.x[-1], PIXELS), np.zeros(1))
    line = replace(scene, window=middle, seen=Seen.of(dataset, frame, middle, scaled))
    panels: list[Panel] = [partial(draw_picture, scene=scene), partial(draw_chart, scene=line)]
    return compose(dataset, [panels], [*title(dataset), *what])


def _moment(dataset: xr.Dataset, at: At) -> tuple[int | None, float, list[str]]:
    """The frame, none of a steady contact; the direction of the flow; and what a heading says."""
    if is_steady(dataset):
        steady.check(dataset, at)
        return None, steady.flow(dataset), steady.films(dataset)
    p = profiles_of(dataset, at)
    return p.chosen, entrainment(dataset, p.time), heading(dataset, p)


def _shown_film(dataset: xr.Dataset, film_scale: float) -> Scale:
    """How a film in m is shown: always in nm."""
    symbol = scale(dataset, "H", 1.0).symbol if is_physical(dataset) else "$h$"
    return Scale(1e9, symbol, "nm", "film thickness")


def animation(
    dataset: xr.Dataset, light: Light | None = None, rig: Rig | None = None, film_scale: float | None = None
) -> FuncAnimation:
    """The interferogram of a run in time as an animation: `animation(...).save("impact.gif", writer="pillow")`.

    The parameters are those of `interferogram`.  The picture is as wide as its widest moment needs and equally
    bright throughout.  Of more than 120 maps every second, third, ... is shown.

    Raises NoFigure, a ValueError, for a steady contact, too few maps, and as `interferogram`.
    """
    if is_steady(dataset):
        raise NoFigure("animation: a steady contact does not move; draw its interferogram")
    scaled, dataset = _film_scale(dataset, film_scale), dataset.load()
    count = dataset.sizes["frame"]
    if count < 2:
        raise NoFigure(f"animation: the run has {count} maps, and needs 2 to move; let it run on")
    frames = range(0, count, -(-count // FRAMES))
    window = Window.round(dataset, frames)
    thickest = max(float(_values(dataset, "H", frame).max()) for frame in frames) * scaled
    density = float(stored.density(dataset, np.asarray(dataset["P"].max())))
    chart = Chart(rig or Rig(), light or Monochromatic(), thickest, density)
    return _animated(dataset, frames, window, chart, scaled)


def _animated(
    dataset: xr.Dataset, frames: Sequence[int], window: Window, chart: Chart, film_scale: float
) -> FuncAnimation:
    """The frames one after the other in one pair of axes."""

    def scene(frame: int) -> Scene:
        seen = Seen.of(dataset, frame, window, film_scale)
        return Scene(window, seen, chart, _shown_film(dataset, film_scale), 0.0)

    time, T = scale(dataset, "time", 1.0), np.asarray(dataset["frame"].values)
    figure = compose(dataset, [[partial(draw_picture, scene=scene(frames[0]))]], title(dataset))
    figure.set_dpi(100)
    figure.draw_without_rendering()
    figure.set_layout_engine("none")  # what was laid out once stays
    (axes,) = figure.axes
    (image,) = axes.images

    def update(frame: int) -> list[object]:
        shown = scene(frame)
        picture = chart.picture(shown.seen.film, shown.seen.density)
        image.set_data(picture[..., 0] if picture.shape[-1] == 1 else picture)
        axes.set_title(f"Interferogram{_named(chart.light)}, {time.symbol} = {T[frame] * time.factor:.4g} {time.unit}")
        return []

    return FuncAnimation(figure, update, frames=frames, interval=1000 / PER_SECOND)  # type: ignore[arg-type]
