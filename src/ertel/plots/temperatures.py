"""Panels of the temperatures in a steady film at y = 0: across the film, in its own shape, and along its surfaces.

The film across which the temperature is drawn is that of the Dataset.  It is shown where the oil has pressure, up to a
gap of some central films: the inlet's wedge is much higher than the film.
"""

from typing import Any

import numpy as np
from matplotlib.axes import Axes

from ertel.plots.drawing import BLUE, GREEN, ORANGE
from ertel.plots.fields import ARROWS
from ertel.plots.view import NOTHING, View

HIGHEST, BELOW = 3.0, 0.3  # central films: the largest gap that is shown, and so much of body 2
BODIES = "0.85"  # their colour


def draw_across(axes: Axes, view: View) -> None:
    """Draw the temperature of the oil between its surfaces."""
    T, loaded, x = view.scale("T_across"), _loaded(view), view.x * view.across.factor
    central = view.largest("H", _central)
    z = view.scale("H", central)
    film, unit = view.midline("H") * z.factor, central * z.factor
    up = np.outer(view.dataset["zeta"].values + 0.5, film[loaded])
    places = np.broadcast_to(x[loaded], up.shape)
    oil = axes.pcolormesh(
        places, up, T.shown(view.values("T_across"))[:, loaded], cmap="inferno", shading="gouraud", rasterized=True
    )
    coldest = -view.largest("T_across", lambda each: -float(each.values("T_across").min()))
    oil.set_clim(T.shown(coldest), T.shown(view.largest("T_across")))
    axes.figure.colorbar(oil, ax=axes, label=f"temperature {T.in_brackets}")
    axes.set_facecolor(BODIES)
    axes.fill_between(x, film, facecolor="white", edgecolor="black", linewidth=1.2, zorder=-1)
    _end(axes, view, "across", ylim=(-BELOW * unit, HIGHEST * unit), ylabel=f"$z$ ({z.unit})")
    for height, text in ((0.9, f"body 1, flow {ARROWS[0][int(view.flow < 0)]}"), (0.045, "body 2")):
        axes.text(0.5, height, text, transform=axes.transAxes, ha="center", va="center", fontsize="small")


def draw_along(axes: Axes, view: View) -> None:
    """Draw the temperatures of both surfaces, and of the middle of the film."""
    scale, x = view.scale("T_across"), view.x * view.across.factor
    T = scale.shown(view.values("T_across"))
    for row, name, colour in ((-1, "surface 1", BLUE), (0, "surface 2", GREEN), (len(T) // 2, "middle", ORANGE)):
        axes.plot(x, T[row], color=colour, label=name)
    _end(axes, view, "along", ylabel=f"temperature {scale.in_brackets}")
    axes.legend(fontsize="small", framealpha=0.85)


def _end(axes: Axes, view: View, how: str, **settings: Any) -> None:
    """End a panel where the film does, with a tenth more at either side."""
    shown = view.x[_loaded(view) & (view.midline("H") < HIGHEST * _central(view))] * view.across.factor
    side, title = 0.1 * np.ptp(shown), f"Temperature {how} the film at $y$ = 0"
    axes.set(xlim=(shown[0] - side, shown[-1] + side), xlabel=view.axis_label("x"), title=title, **settings)


def _central(view: View) -> float:
    return float(view.dataset["H_c"].values[-1])


def _loaded(view: View) -> Any:
    """The places where the oil has pressure, a mask over X."""
    return view.midline("P") > NOTHING * view.midline("P").max()
