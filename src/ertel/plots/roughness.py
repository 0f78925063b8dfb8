"""Where the roughness is: contour lines over a map, a band at the bottom of a profile."""

from collections.abc import Mapping
from typing import Literal

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from ertel.plots.drawing import PURPLE, Values, lateral, scale
from ertel.plots.stored import roughness_height

MINUS = "\N{MINUS SIGN}"
BAND = 0.14  # height of the band at the bottom of a profile, as a share of what lies above
FOOT = BAND / (1.0 + BAND)  # the same as a share of all
BAND_NODES = 1001  # along the band
NODES = 301  # along the side of a map, for smooth contour lines
STYLES: Mapping[float, Literal["-", ":"]] = {1.0: "-", -1.0: ":"}  # of the lines round hills and round valleys


def draw_contours(axes: Axes, dataset: xr.Dataset, T: float) -> None:
    """Thin lines at half the height of the roughness, solid round hills and dotted round valleys; none if smooth."""
    across = lateral(dataset)
    (left, right), (low, high) = axes.get_xlim(), axes.get_ylim()
    x, y = np.linspace(left, right, NODES), np.linspace(low, high, NODES)
    height = roughness_height(dataset, T, x[None, :] / across.factor, y[:, None] / across.factor)
    half = float(np.abs(height).max()) / 2
    if half == 0.0:
        return
    z, lines = scale(dataset, "H", half), []
    for sign, style in STYLES.items():
        if (sign * height).max() > half:
            axes.contour(x, y, height, levels=[sign * half], colors=PURPLE, linewidths=1.0, linestyles=style)
            label = f"roughness {sign * half * z.factor:+.3g} {z.unit}".replace("-", MINUS)
            lines.append(Line2D([], [], color=PURPLE, linewidth=1.0, linestyle=style, label=label))
    if lines:
        axes.legend(handles=lines, loc="lower left", fontsize="small", framealpha=0.85, handlelength=1.5)


def draw_band(axes: Axes, dataset: xr.Dataset, T: float, x: Values, top: float, along: str = "x") -> bool:
    """Show the roughness through the centre below a profile that reaches up to `top`; whether there is any.

    x: the positions of the profile (a*) along "x" or "y".  The heights fill a band below zero, with their range.
    """
    place = np.linspace(x[0], x[-1], BAND_NODES)
    zero = np.zeros_like(place)
    height = roughness_height(dataset, T, *((place, zero) if along == "x" else (zero, place)))
    low, high = float(height.min()), float(height.max())
    rough = low < 0.0 or high > 0.0
    set_height(axes, top, rough)
    if not rough:
        return False
    share = (height - low) / (high - low) if high > low else np.ones_like(height)
    x, shown = place * lateral(dataset).factor, FOOT * (0.1 + 0.85 * share)  # in shares of the height of the axes
    axes.fill_between(x, 0.0, shown, transform=axes.get_xaxis_transform(), color=PURPLE, alpha=0.4, linewidth=0.0)
    text = _range(dataset, low, high)
    axes.text(0.5, FOOT / 2, text, transform=axes.transAxes, fontsize="small", ha="center", va="center")
    axes.axhline(0.0, color="black", linewidth=0.5)
    return True


def set_height(axes: Axes, top: float, rough: bool) -> None:
    """Limits of a profile from zero to `top`, with room below for the roughness where there is any."""
    axes.set_ylim(0.0, top)
    if rough:
        ticks = [tick for tick in axes.get_yticks() if 0.0 <= tick <= top]
        axes.set_yticks(ticks)
        axes.set_ylim(-BAND * top, top)


def _range(dataset: xr.Dataset, low: float, high: float) -> str:
    z = scale(dataset, "H", max(abs(low), abs(high)))
    bounds = [f"{round(bound * z.factor, 4):.3g}".replace("-", MINUS) for bound in sorted({low, high})]
    return f"roughness {' to '.join(bounds)} {z.unit}"
