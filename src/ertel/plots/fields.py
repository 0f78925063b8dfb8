"""Panels that show a variable over the surface: film thickness, pressure, shear stress and power loss."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Literal

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import Normalize
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator

from ertel.plots.drawing import PURPLE, Scale, Values, levels
from ertel.plots.view import Field, View

MINUS = "\N{MINUS SIGN}"
LONG = 2.0  # ratio of the sides from which a map is long
SEEN = 0.1  # of the largest power loss: less does not count where a map ends
NODES = 301  # along the side of a map, for smooth contour lines of the roughness
STYLES: Mapping[float, Literal["-", ":"]] = {1.0: "-", -1.0: ":"}  # of the lines round hills and round valleys


def draw_film_map(axes: Axes, view: View) -> None:
    """Film thickness, with contour lines at equal steps as an interferometer shows them."""
    if view.frame is None:
        top, lines = 1.75 * float(view.dataset["H_c"].values[-1]), 16
    else:
        top, lines = 1.5 * view.film_inside(), 10
    z = view.scale("H", top / 2)
    _draw_map(axes, view, view.map("H"), z, levels(top * z.factor, lines), "Film thickness", "YlGnBu_r", "P")
    _draw_roughness(axes, view)


def draw_pressure_map(axes: Axes, view: View) -> None:
    """Pressure, with contour lines at equal steps."""
    field = view.map("P")
    top = max(float(field.values.max()), 0.01)  # p_h*: something to divide where the contact carries nothing
    z = view.scale("P", top)
    _draw_map(axes, view, field, z, levels(top * z.factor), "Pressure", "YlOrRd", "P")
    _draw_roughness(axes, view)


def draw_stress_map(axes: Axes, view: View) -> None:
    """Size of the shear stress in the middle of the film, with contour lines at equal steps."""
    along_x, along_y = view.map("tau_x"), view.map("tau_y")
    field = replace(along_x, values=np.hypot(along_x.values, along_y.values))
    top = max(float(field.values.max()), 1e-9)  # something to divide where there is no friction
    z = replace(view.scale("tau_x", top), symbol=r"$\tau_\mathrm{m}$", long_name="shear stress")
    _draw_map(axes, view, field, z, levels(top * z.factor), "Shear stress", "BuPu", "loss")


def draw_loss_map(axes: Axes, view: View) -> None:
    """Power loss per area, with contour lines at equal steps."""
    field = view.map("loss")
    top = max(float(field.values.max()), 1e-9)
    z = replace(view.scale("loss", top), symbol="")
    _draw_map(axes, view, field, z, levels(top * z.factor), "Power loss", "YlOrBr", "loss")


def _draw_map(
    axes: Axes, view: View, field: Field, z: Scale, steps: Values, heading: str, colours: str, shown_where: str
) -> None:
    """Draw a field with contour lines at `steps` (as shown), and the direction of the flow.

    Along x the map ends where `shown_where`, "P" or "loss", does; along y it reaches as far as suits the shape of the
    contact.  Values above the highest step have its colour.
    """
    across, stretch = view.across.factor, view.stretch
    side = _side(view, shown_where)
    columns, rows = np.abs(field.x) <= side, np.abs(field.y) <= side * stretch
    x, y, shown = field.x[columns] * across, field.y[rows] * across, field.values[np.ix_(rows, columns)] * z.factor
    limits = Normalize(0.0, steps[-1])
    image = axes.pcolormesh(x, y, shown, cmap=colours, norm=limits, shading="gouraud", rasterized=True)
    if shown.min() < steps[-1] and shown.max() > steps[1]:
        axes.contour(x, y, shown, levels=steps[1:], colors="black", linewidths=0.4, alpha=0.6)
    axes.set(xlabel=view.axis_label("x"), ylabel=view.axis_label("y"), aspect="equal")
    if max(stretch, 1 / stretch) > LONG:
        short = axes.xaxis if stretch > 1 else axes.yaxis
        short.set_major_locator(MaxNLocator(1, min_n_ticks=1))
    extend = "max" if shown.max() > steps[-1] else "neither"
    axes.figure.colorbar(image, ax=axes, label=z.label, extend=extend)
    space = "\n" if stretch > LONG else " "
    axes.set_title(f"{heading},{space}a line every {steps[1]:.3g} {z.unit}")
    _draw_flow(axes, view.flow)


def _side(view: View, name: str) -> float:
    """The distance from the centre up to which a map is shown along x."""
    field = view.map(name)
    profile = field.values.max(axis=0)
    if name == "loss":
        profile = np.where(profile > SEEN * profile.max(), profile, 0.0)
    return view.extent(field.x, profile)


def _draw_flow(axes: Axes, direction: float) -> None:
    """Draw an arrow the way the surfaces carry the oil; none where they stand still."""
    if direction == 0.0:
        return
    start, end = (0.04, 0.2) if direction > 0 else (0.2, 0.04)
    arrow = {"arrowstyle": "-|>", "color": "black", "linewidth": 1.5, "shrinkA": 0, "shrinkB": 0}
    place = {"xycoords": "axes fraction", "textcoords": "axes fraction"}
    axes.annotate("", (end, 0.91), (start, 0.91), arrowprops=arrow, **place)  # type: ignore[arg-type]
    axes.text(0.12, 0.94, "flow", transform=axes.transAxes, ha="center", fontsize="small")


def _draw_roughness(axes: Axes, view: View) -> None:
    """Draw lines at half the height of the roughness, solid round hills and dotted round valleys; none if smooth."""
    across = view.across.factor
    (left, right), (low, high) = axes.get_xlim(), axes.get_ylim()
    x, y = np.linspace(left, right, NODES), np.linspace(low, high, NODES)
    height = view.roughness(x[None, :] / across, y[:, None] / across)
    half = float(np.abs(height).max()) / 2
    if half == 0.0:
        return
    z, lines = view.scale("H", half), []
    for sign, style in STYLES.items():
        if (sign * height).max() > half:
            axes.contour(x, y, height, levels=[sign * half], colors=PURPLE, linewidths=1.0, linestyles=style)
            label = f"roughness {sign * half * z.factor:+.3g} {z.unit}".replace("-", MINUS)
            lines.append(Line2D([], [], color=PURPLE, linewidth=1.0, linestyle=style, label=label))
    if lines:
        axes.legend(handles=lines, loc="lower left", fontsize="small", framealpha=0.85, handlelength=1.5)
