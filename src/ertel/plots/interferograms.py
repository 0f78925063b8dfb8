"""Interferograms: a run as a microscope above coated glass shows it, as a picture and as an animation.

The film and the density of the oil are interpolated from the grid to the pixels of the picture, so that fringes finer
than the grid are drawn as they are.  Where the gap is not full, the light crosses the oil and then air.

Beside the picture is the film along the mid-line on the colour chart: the colour that every film thickness would have
there, with the oil as dense as it is there, and with as much oil where the gap is not full.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Literal, Unpack

import numpy as np
import xarray as xr
from matplotlib.animation import FuncAnimation
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from ertel.optics import Chart, Interferometer, Light, Monochromatic, Rig, White
from ertel.plots.drawing import ORANGE, NoFigure, Panel, Scale, Sheet, SheetOptions, Values, compose
from ertel.plots.fields import draw_edge_of_oil, flow_in
from ertel.plots.measurements import Overlay, draw_light, draw_measured, measured_view
from ertel.plots.movies import PER_SECOND, animated, in_motion
from ertel.plots.view import View, field, require_maps
from ertel.results.alignment import INTENSITY
from ertel.results.profiles import At

PIXELS = 480  # along the longer side of a picture
ROUND = 1.7  # how far round the contact the picture reaches, in its half widths
FADED = 2e-6  # m: the film from which on white light has no colours
ORDERS = 4.5  # fringes of the film that the colour chart shows, at least
FRAMES = 120  # of an animation, at most
LIGHTS: Mapping[str, type[Light]] = {"mono": Monochromatic, "white": White}
TICKS = 6  # along the longer side of a picture


def pixels_around(views: Sequence[View]) -> tuple[Values, Values]:
    """The pixels round the contact, x and y in a*, as wide as all moments of a run need."""
    view = views[0]
    side = max(each.largest("X", _side) for each in views)
    x, top = view.x, float(view.dataset["r" if view.is_radial else "Y"].values[-1])
    x0, x1, y1 = max(-side, float(x[0])), min(side, float(x[-1])), min(side * view.stretch, top)
    spacing = max(x1 - x0, 2.0 * y1) / PIXELS
    columns, rows = (max(round(length / spacing), 2) for length in (x1 - x0, 2 * y1))
    return np.linspace(x0, x1, columns), np.linspace(-y1, y1, rows)


def _side(view: View) -> float:
    """The distance from the centre up to which one moment is shown along x."""
    profile = view.midline("P") if view.is_radial else view.values("P").max(axis=0)
    return view.extent(view.x, profile, ROUND)


def seen_on(view: View, pixels: tuple[Values, Values], film_scale: float) -> xr.Dataset:
    """The film (m), rho/rho0 of the oil and void, the part of the film that is air (m), on pixels x and y (a*), (Y, X).

    film_scale: a*^2/R in m.
    """
    H = np.maximum(_on_pixels(view, "H", *pixels, smooth=True), 0.0)
    P = np.maximum(_on_pixels(view, "P", *pixels, smooth=False), 0.0)
    if "P_asperity" in view.dataset:
        P = np.maximum(P - _on_pixels(view, "P_asperity", *pixels, smooth=False), 0.0)
    void = np.minimum(_on_pixels(view, "void", *pixels, smooth=False), H)
    values = {"film": H * film_scale, "density": view.case.lubricant.density(P), "void": void * film_scale}
    return xr.Dataset({name: field(*pixels, each) for name, each in values.items()})


def _edges(view: View, seen: xr.Dataset) -> tuple[float, float, float, float]:
    """The edges of the pixels, as shown: left, right, lower and upper."""
    up, along = (seen[name].values * view.across.factor for name in seen["film"].dims)
    return along[0], along[-1], up[0], up[-1]


def _on_pixels(view: View, name: str, x: Values, y: Values, smooth: bool) -> Values:
    """A field on the pixels: by cubic splines, or linear where it has edges."""
    from scipy.interpolate import CubicSpline, RectBivariateSpline  # here: other pictures do without it

    values, data = view.values(name), view.dataset
    if not view.is_radial:
        order = 3 if smooth else 1
        spline = RectBivariateSpline(data["Y"].values, data["X"].values, values, kx=order, ky=order)
        return np.asarray(spline(y, x))
    r, pixels = np.asarray(data["r"].values), np.hypot(y[:, None], x[None, :])
    if smooth:  # the film is even in r; beyond the grid, in the corners, it goes on
        return np.asarray(CubicSpline(r, values, bc_type=((1, 0.0), "not-a-knot"))(pixels))
    return np.interp(pixels, r, values)


# -- panels -----------------------------------------------------------------------------------------------------------


def draw_interferogram(axes: Axes, view: View, seen: xr.Dataset, chart: Chart) -> None:
    """The interferogram of film and oil on the pixels, with a line where the gap stops being full.

    That of a contact that is long along y is turned by a quarter, as maps are.
    """
    seen = seen.transpose("X", "Y") if view.is_turned else seen
    film, density, void = (seen[name] for name in ("film", "density", "void"))
    _show(axes, chart.picture(film.values, density.values, void.values), _edges(view, seen))
    up, along = (str(name).lower() for name in film.dims)
    axes.set(xlabel=view.axis_label(along), ylabel=view.axis_label(up), aspect="equal")
    if view.is_turned:
        axes.invert_yaxis()
    light = chart.light
    words = f"at {light.wavelength * 1e9:.4g} nm" if isinstance(light, Monochromatic) else "in white light"
    axes.set_title(", ".join(part for part in (f"Interferogram {words}", flow_in(view)) if part))
    for axis, pixels in zip((axes.yaxis, axes.xaxis), film.shape, strict=True):
        axis.set_major_locator(MaxNLocator(max(1, round(TICKS * pixels / PIXELS)), min_n_ticks=1))
    draw_edge_of_oil(axes, view, film, void)
    if isinstance(light, White) and float(film.min()) > FADED:
        axes.text(0.5, 0.03, "no colours here, try mono", transform=axes.transAxes, ha="center", fontsize="small")


def _show(axes: Axes, picture: Values, limits: tuple[float, float, float, float]) -> None:
    """Draw a picture in grey, (y, x, 1), or in colour."""
    axes.imshow(picture, extent=limits, origin="lower", cmap="gray", vmin=0.0, vmax=1.0)


def draw_chart(axes: Axes, view: View, seen: xr.Dataset, chart: Chart) -> None:
    """The film along the mid-line, on the colours that films would have there.  seen: one row of pixels."""
    x, (film,), (void,) = (seen[name].values for name in ("X", "film", "void"))
    inside = np.abs(x) < x[-1] / ROUND
    top = max(1.2 * float(film[inside].max()), ORDERS * chart.light.typical / (2.0 * chart.rig.oil_index))
    nm = Scale(1e9, view.scale("H").symbol if view.in_si else "$h$", "nm", "film thickness")
    left, right, *_ = _edges(view, seen)
    films = np.linspace(0.0, top, PIXELS)[:, None]
    voids = np.where(void > 0.0, np.maximum(films - (film - void), 0.0), 0.0)
    colours = chart.shown(films, seen["density"].values, void=voids)
    _show(axes, colours, (left, right, 0.0, top * nm.factor))
    for colour, width in (("white", 3.0), ("black", 1.2)):
        axes.plot(x * view.across.factor, film * nm.factor, color=colour, linewidth=width)
    stored = replace(nm, factor=nm.factor * view.dataset["H"].attrs.get("si_factor", 1.0))
    draw_measured(axes, view, "H", stored, color=ORANGE)
    axes.set(xlabel=view.axis_label("x"), ylabel=nm.label, xlim=(left, right), ylim=(0.0, top * nm.factor))
    axes.set(aspect="auto", title="Film along the mid-line, on the chart of films there")


# -- figures ----------------------------------------------------------------------------------------------------------


def interferogram(
    dataset: xr.Dataset,
    at: At = None,
    light: Light | Literal["mono", "white"] | None = None,
    rig: Rig | None = None,
    film_scale: float | None = None,
    measured: Overlay = None,
    **sheet: Unpack[SheetOptions],
) -> Figure:
    """The contact as an experimenter sees it, and the film along its mid-line on the colours of films.

    Where the gap is not full, the oil is a layer on the glass and the rest is air; a line shows where that begins.

    Parameters
    ----------
    dataset : xarray.Dataset
        A run.
    at : float or str, optional
        The moment of a run in time: a time in t0 or an event.
    light : Light, optional
        `optics.Monochromatic(wavelength, coherence)` in grey, or `optics.White()` in colour; default green light,
        "mono".  "white" is daylight.
    rig : Rig, optional
        Glass, coatings, surface and the oil's index: `optics.Rig(...)`, or `optics.TwoBeams(...)`; default 8 nm of
        chromium on glass, against steel.
    film_scale : float, optional
        a*^2/R in m; a dimensionless run needs it.
    measured : Measurement or several of them, optional
        Measured profiles: a film is drawn on the chart, an intensity beside the computed one.  One without optics is
        that of this light and rig.
    **sheet
        Axes or a size, and whether there is a title: ax, figsize, columns, title, see `Sheet`.

    Raises
    ------
    NoFigure
        There is nothing to draw; a dimensionless run without a film_scale; a light that is none.
    """
    interferometer = Interferometer(rig or Rig(), _light(light))
    view = measured_view(dataset, at, measured, ("h", INTENSITY), interferometer)
    return interferogram_of(view, Sheet(**sheet), interferometer, film_scale)


def interferogram_of(
    view: View, sheet: Sheet, interferometer: Interferometer | None = None, film_scale: float | None = None
) -> Figure:
    """The interferogram of a view, see `interferogram`."""
    require_maps(view.dataset, "interferogram")
    scaled = _film_scale(view.dataset, film_scale)
    interferometer = interferometer or Interferometer(Rig(), _light(None))
    pixels = pixels_around([view])
    middle = np.linspace(pixels[0][0], pixels[0][-1], PIXELS), np.zeros(1)
    seen = seen_on(view, pixels, scaled)
    chart = Chart(interferometer.rig, interferometer.light, float(seen["film"].max()), float(seen["density"].max()))
    row = seen_on(view, middle, scaled)
    panels: list[Panel[View]] = [
        partial(draw_interferogram, seen=seen, chart=chart),
        partial(draw_chart, seen=row, chart=chart),
    ]
    if any(each.measurement.quantity == INTENSITY for each in view.measured):
        panels.append(draw_light)
    return compose(view, [panels], [*view.title, *view.outcome], sheet)


def _light(given: Light | str | None) -> Light:
    """The light that is given by its name, or itself."""
    if given is None or (isinstance(given, str) and given in LIGHTS):
        return LIGHTS[given or "mono"]()
    if isinstance(given, str) or Light not in type(given).__mro__:
        raise NoFigure(
            f"light = {given!r}: must be {', '.join(LIGHTS)} or a light of ertel.optics, such as Monochromatic(633e-9)"
        )
    return given


def _film_scale(dataset: xr.Dataset, given: float | None) -> float:
    """a*^2/R in m."""
    if given is not None:
        if not 0.0 < given < 1.0:
            raise NoFigure(f"film_scale = {given:g}: must be above 0 and below 1 m; it is a*^2/R in metres")
        return given
    if not View(dataset).in_si:
        raise NoFigure(
            "interferogram: the run is dimensionless, and light needs a film in nm; run a case in SI, or from Python "
            "give film_scale, a*^2/R in m"
        )
    return float(dataset["H"].attrs["si_factor"])


def animation(
    dataset: xr.Dataset,
    light: Light | Literal["mono", "white"] | None = None,
    rig: Rig | None = None,
    film_scale: float | None = None,
    rate: float = PER_SECOND,
) -> FuncAnimation:
    """The interferogram of a run in time as an animation: `animation(...).save("impact.gif", writer="pillow")`.

    The parameters are those of `interferogram`, and the rate in frames a second.  The picture is as wide as its widest
    moment needs and equally bright throughout.  Of more than 120 maps every second, third, ... is shown.

    Raises
    ------
    NoFigure
        A steady contact, too few maps, and as `interferogram`.
    """
    scaled, dataset = _film_scale(dataset, film_scale), in_motion(dataset)
    count = dataset.sizes["frame"]
    views = {frame: View(dataset, frame) for frame in range(0, count, -(-count // FRAMES))}
    pixels = pixels_around(list(views.values()))
    thickest = max(float(view.values("H").max()) for view in views.values()) * scaled
    densest = float(views[0].case.lubricant.density(dataset["P"].values.max()))
    chart = Chart(rig or Rig(), _light(light), thickest, densest)

    def draw(axes: Axes, frame: int) -> str:
        view = views[frame]
        draw_interferogram(axes, view, seen_on(view, pixels, scaled), chart)
        return view.clock

    return animated(draw, list(views), views[0].title, rate)
