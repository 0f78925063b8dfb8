"""Panels of the stresses in a body: lines of equal von Mises stress in the section y = 0, and stresses over the depth.

A case without dimensions does not know the shear stress of its film in units of p_h: the panels are then those of the
pressure alone, and say so.  They are computed when they are drawn.
"""

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import xarray as xr
from matplotlib.axes import Axes

from ertel.plots.drawing import BLUE, FLAT, GREEN, ORANGE, Scale
from ertel.plots.fields import ARROWS, levels
from ertel.plots.view import View
from ertel.results.stress import stress

OVER_DEPTH = {"von_mises": BLUE, "shear": ORANGE, "sigma_xz": GREEN}
MARK: Any = {"marker": "+", "color": BLUE, "markersize": 10, "markeredgewidth": 1.5}  # of the largest von Mises stress


def rows(view: View, body: int = 1) -> Sequence[Sequence[Callable[[Axes, View], None]]]:
    """The panels of a body at the moment of a view."""
    frame = view.dataset if view.frame is None else view.dataset.isel(frame=[view.frame])
    data = stress(view.case, frame, None if view.frame is None else view.time, body)
    return [[partial(_draw_section, data=data), partial(_draw_over_depth, data=data)]]


def _scales(data: xr.Dataset, view: View) -> tuple[xr.DataArray, Scale, Scale]:
    """The von Mises stress, (depth, place), and the scales of lengths and stresses."""
    mises, kind = data["von_mises"], view.dataset.attrs["kind"]
    depth = data[mises.dims[0]]
    return mises, Scale.of(depth, float(depth.max()), kind), Scale.of(mises, float(mises.max()), kind)


def _draw_section(axes: Axes, view: View, data: xr.Dataset) -> None:
    """Draw the von Mises stress below the surface with lines at equal steps, and the place of the largest one."""
    mises, length, unit = _scales(data, view)
    z, x = (mises[name].values * length.factor for name in mises.dims)
    deep, place = (int(each) for each in mises.argmax(mises.dims).values())
    steps, shown = levels(float(mises.max()) * unit.factor), mises.values * unit.factor
    filled = axes.contourf(x, z, shown, levels=steps, cmap="YlOrRd")
    axes.contour(x, z, shown, levels=steps[1:], colors="black", linewidths=0.4, alpha=0.6)
    axes.plot(x[place], z[deep], **MARK)
    side = view.extent(view.x, view.midline("P")) * view.across.factor
    label = f"depth in body {data.attrs['body']} ({length.unit})"
    axes.set(xlim=(max(-side, x[0]), min(side, x[-1])), ylim=(z[-1], 0.0), aspect="equal", ylabel=label)
    loads = "" if view.in_si else " by the pressure alone"
    axes.set(xlabel=view.axis_label("x"), title=f"Von Mises stress{loads}, a line every {steps[1]:.3g} {unit.unit}")
    bar = "bottom" if axes.get_data_ratio() < 2.0 * FLAT else "right"
    axes.figure.colorbar(filled, ax=axes, label=f"von Mises stress {unit.in_brackets}", location=bar)
    if view.flow:
        axes.text(0.02, 0.03, f"flow {ARROWS[0][int(view.flow < 0)]}", transform=axes.transAxes, fontsize="small")


def _draw_over_depth(axes: Axes, view: View, data: xr.Dataset) -> None:
    """Draw the stresses over the depth at the place x of the largest von Mises stress."""
    mises, length, unit = _scales(data, view)
    deep, place = (int(each) for each in mises.argmax(mises.dims).values())
    z, x = (mises[name].values * length.factor for name in mises.dims)
    for name, colour in OVER_DEPTH.items():
        axes.plot(data[name].values[:, place] * unit.factor, z, color=colour, label=data[name].attrs["long_name"])
    axes.plot(float(mises[deep, place]) * unit.factor, z[deep], **MARK)
    axes.axvline(0.0, color="black", linewidth=0.5)
    title = f"Over the depth at ${'x' if view.in_si else 'X'}$ = {x[place]:.3g} {length.unit}"
    axes.set(xlabel=f"stress {unit.in_brackets}", ylabel=f"depth ({length.unit})", ylim=(z[-1], 0.0), title=title)
    axes.legend(loc="lower right", fontsize="small", framealpha=0.85)
