"""Panels of the temperatures in a steady film at y = 0: across the film, in its own shape, and along its surfaces.

The film across which the temperature is drawn is that of the Dataset.  It is shown where the oil has pressure, up to a
gap of some central films: the inlet's wedge is much higher than the film.
"""

from collections.abc import Callable, Sequence

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from ertel.plots.drawing import BLUE, GREEN, ORANGE, WRITTEN, Values
from ertel.plots.fields import ARROWS
from ertel.plots.view import NOTHING, View
from ertel.results.variables import in_celsius

HIGHEST = 3.0  # central films: the largest gap that is shown
BELOW = 0.3  # central films: as much is shown of body 2
BODY = "0.85"  # its colour
LINES = ((-1, "surface 1", BLUE), (0, "surface 2", GREEN))  # place across the film


def rows(view: View) -> Sequence[Sequence[Callable[[Axes, View], None]]]:
    """The panels of a steady contact."""
    return [[_draw_across, _draw_along]]


def _temperature(view: View) -> tuple[Values, str]:
    """The temperature as it is shown, shape (heights, X), and its unit."""
    T = view.dataset["T_across"]
    values, unit = in_celsius(T.values, T.attrs["units"])
    return values, WRITTEN[unit][1]


def _central(view: View) -> float:
    return float(view.dataset["H_c"].values[-1])


def _loaded(view: View) -> NDArray[np.bool_]:
    P = view.midline("P")
    return P > NOTHING * P.max()


def _limit(axes: Axes, view: View) -> None:
    """Show what has oil under pressure and no large gap."""
    near = view.x[_loaded(view) & (view.midline("H") < HIGHEST * _central(view))]
    side = 0.1 * (near[-1] - near[0])
    limits = (near[0] - side) * view.across.factor, (near[-1] + side) * view.across.factor
    axes.set(xlim=limits, xlabel=view.axis_label("x"))


def _draw_across(axes: Axes, view: View) -> None:
    """Draw the temperature of the oil between its surfaces."""
    (T, unit), oil = _temperature(view), _loaded(view)
    z = view.scale("H", view.largest("H", _central))
    x, film, top = view.x * view.across.factor, view.midline("H") * z.factor, view.largest("H", _central) * z.factor
    hottest = view.largest("T_across", lambda each: float(_temperature(each)[0].max()))
    coldest = -view.largest("T_across", lambda each: -float(_temperature(each)[0].min()))
    up = (view.dataset["zeta"].values[:, None] + 0.5) * film
    places = np.broadcast_to(x, up.shape)
    drawn = axes.pcolormesh(places[:, oil], up[:, oil], T[:, oil], cmap="inferno", shading="gouraud", rasterized=True)
    drawn.set_clim(coldest, hottest)
    axes.figure.colorbar(drawn, ax=axes, label=f"temperature ({unit})")
    axes.fill_between(x, film, film.max(), color=BODY, linewidth=0.0)
    axes.axhspan(-BELOW * top, 0.0, color=BODY, linewidth=0.0)
    axes.plot(x, film, color="black", linewidth=0.8)
    axes.axhline(0.0, color="black", linewidth=0.8)
    _limit(axes, view)
    title = "Temperature across the film at $y$ = 0"
    axes.set(ylim=(-BELOW * top, HIGHEST * top), ylabel=f"$z$ ({z.unit})", title=title)
    for height, text in ((0.9, f"body 1, flow {ARROWS[0][int(view.flow < 0)]}"), (0.045, "body 2")):
        axes.text(0.5, height, text, transform=axes.transAxes, ha="center", va="center", fontsize="small")


def _draw_along(axes: Axes, view: View) -> None:
    """Draw the temperatures of both surfaces and of the middle of the film."""
    (T, unit), x = _temperature(view), view.x * view.across.factor
    for place, name, colour in LINES:
        axes.plot(x, T[place], color=colour, label=name)
    axes.plot(x, np.where(_loaded(view), T[len(T) // 2], np.nan), color=ORANGE, label="middle of the film")
    _limit(axes, view)
    axes.set(ylabel=f"temperature ({unit})", title="Temperature along the film at $y$ = 0")
    axes.legend(loc="lower center", fontsize="small", framealpha=0.85)
