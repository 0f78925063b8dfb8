"""Pictures of a steady rolling contact and of the grids that it was solved on: Dataset -> matplotlib Figure."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from itertools import pairwise
from math import isfinite

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, MaxNLocator

from ertel.numerics.grid import Extrapolation, extrapolate
from ertel.plots import stored
from ertel.plots.drawing import (
    BLUE,
    GREY,
    ORANGE,
    ORDERED_COLOURS,
    At,
    Figures,
    NoFigure,
    Panel,
    Values,
    axis_label,
    compose,
    draw_film,
    draw_flow,
    draw_pressure,
    lateral,
    map_of,
    named,
    scale,
    side_of,
    stretch,
    title,
)
from ertel.plots.friction import draw_loss, draw_stress, said, slides
from ertel.plots.roughness import draw_band, draw_contours, set_height
from ertel.results.variables import FRICTION

# -- error bars --------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Estimate:
    """A value on every grid, its estimated errors (NaN on the coarsest), and the value extrapolated from the finest."""

    values: Values
    errors: Values
    extrapolated: float


def estimate_of(dataset: xr.Dataset, name: str) -> Estimate:
    """Error estimates on every grid, see `equations.state.Rolling.extrapolate`: the error is of second order."""
    values = np.asarray(dataset[name].values)
    found = [Extrapolation(values[0], np.nan, np.nan), *(extrapolate(*pair) for pair in pairwise(values))]
    return Estimate(values, np.array([e.error for e in found]), float(found[-1].extrapolated))


def _with_error(dataset: xr.Dataset, name: str) -> str:
    """A film on the finest grid as h_c = 146 ± 10 nm: as many digits as the error deserves."""
    film = estimate_of(dataset, name)
    z = scale(dataset, name, float(film.values[-1]))
    value, error = film.values[-1] * z.factor, film.errors[-1] * z.factor
    if not (isfinite(error) and error > 0):
        return f"{z.symbol} = {value:.4g} {z.unit}"
    digits = max(0, 1 - int(np.floor(np.log10(error))))
    return f"{z.symbol} = {value:.{digits}f} ± {error:.{digits}f} {z.unit}"


# -- panels ----------------------------------------------------------------------------------------------------------


def draw_horseshoe(axes: Axes, dataset: xr.Dataset) -> None:
    """Film thickness of a steady contact, with contour lines at equal steps as an interferometer shows them."""
    H = float(dataset["H_c"].values[-1])
    draw_film(axes, dataset, map_of(dataset, "H"), side_of(dataset), 1.75 * H, lines=16)
    draw_contours(axes, dataset, 0.0)
    draw_flow(axes, flow(dataset))


def draw_spike(axes: Axes, dataset: xr.Dataset) -> None:
    """Pressure of a steady contact with its spike."""
    draw_pressure(axes, dataset, map_of(dataset, "P"), side_of(dataset))
    draw_contours(axes, dataset, 0.0)
    draw_flow(axes, flow(dataset))


def draw_stress_map(axes: Axes, dataset: xr.Dataset) -> None:
    """Shear stress of a steady contact, with contour lines at equal steps."""
    draw_stress(axes, dataset)
    draw_flow(axes, flow(dataset))


def draw_loss_map(axes: Axes, dataset: xr.Dataset) -> None:
    """Power loss per area of a steady contact, with contour lines at equal steps."""
    draw_loss(axes, dataset)
    draw_flow(axes, flow(dataset))


def _dry_pressure(dataset: xr.Dataset, X: Values, Y: Values) -> Values:
    """Hertz' pressure under the load of the contact."""
    geometry = stored.geometry(dataset)
    return np.asarray(geometry.dry_pressure(float(dataset["load"].values[-1]) / geometry.hertz_load, X, Y))


def _nodes(dataset: xr.Dataset, along: int) -> str:
    """The nodes of a grid: 65², or 65 x 97."""
    X, Y = dataset.sizes["X"], dataset.sizes["Y"]
    return f"{along}²" if X == Y else f"{along} x {round((along - 1) * (Y - 1) / (X - 1)) + 1}"


def flow(dataset: xr.Dataset) -> float:
    """+1 where the oil goes to the right: pressure reaches far upstream, and ends soon behind the contact."""
    X = dataset["X"].values
    return -float(np.sign(np.mean(X[(dataset["P"].values > 0).any(axis=0)])))


def draw_midline(axes: Axes, dataset: xr.Dataset, along: str) -> None:
    """Film and pressure through the centre along "x" (with the flow) or "y" (across it), with Hertz' pressure."""
    section = dataset[["H", "P"]].sel({"Y" if along == "x" else "X": 0.0}, method="nearest")
    x = np.asarray(section[along.upper()].values)
    H, P = section["H"].values, section["P"].values
    across, h = lateral(dataset), scale(dataset, "H", float(dataset["H_c"].values[-1]))
    p, right = scale(dataset, "P", float(P.max())), axes.twinx()
    dry = _dry_pressure(dataset, *((x, 0 * x) if along == "x" else (0 * x, x)))
    right.plot(x * across.factor, dry * p.factor, color=GREY, linewidth=0.8, linestyle="--")
    right.plot(x * across.factor, P * p.factor, color=ORANGE)
    axes.plot(x * across.factor, H * h.factor, color=BLUE)
    side = side_of(dataset) * (1.0 if along == "x" else stretch(dataset)) * across.factor
    axes.set(xlim=(-side, min(side, x[-1] * across.factor)), xlabel=axis_label(dataset, along))
    top = 1.1 * max(float(P.max()), float(dry.max())) * p.factor
    rough = draw_band(axes, dataset, 0.0, x, 4.0 * float(dataset["H_c"].values[-1]) * h.factor, along)
    set_height(right, top, rough)
    for scaled, z, colour in ((axes, h, BLUE), (right, p, ORANGE)):
        scaled.set_ylabel(z.label, color=colour)
        scaled.tick_params(axis="y", colors=colour)
    axes.xaxis.set_major_locator(MaxNLocator(7, steps=[1, 2, 5, 10]))
    axes.set_title(f"Through the centre, {'along' if along == 'x' else 'across'} the flow (dashed: Hertz)")


def draw_convergence(axes: Axes, dataset: xr.Dataset) -> None:
    """The maximum residual against Newton's iterations, on every grid."""
    grids = dataset["grid"].values
    for nodes, colour, history in zip(grids, _shades(len(grids)), dataset["history"].values, strict=True):
        known = history[np.isfinite(history)]
        axes.semilogy(
            np.arange(len(known)), known, "o-", color=colour, markersize=3.5, label=_nodes(dataset, int(nodes))
        )
    tolerance = stored.tolerance(dataset)
    axes.axhline(tolerance, color="black", linewidth=0.8, linestyle=":", label="tolerance")
    axes.set(xlabel="Newton iteration", ylabel="maximum residual", title="Convergence on each grid")
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    axes.yaxis.set_major_locator(LogLocator(numticks=8))
    axes.legend(loc="upper right", frameon=False, fontsize="small", title="nodes", title_fontsize="small")


def _shades(number: int) -> Values:
    return ORDERED_COLOURS(np.linspace(0.9, 0.0, number))


def draw_grids(axes: Axes, dataset: xr.Dataset) -> None:
    """The films on every grid with their estimated errors, and extrapolated to no spacing at all."""
    grids = [int(nodes) for nodes in dataset["grid"].values]
    z, place = scale(dataset, "H_c", float(dataset["H_c"].values[-1])), np.arange(len(grids) + 1)
    top = 0.0
    for name, colour, marker in (("H_c", BLUE, "o"), ("H_min", ORANGE, "s")):
        film = estimate_of(dataset, name)
        shown, errors = film.values * z.factor, film.errors * z.factor
        label = named(dataset, name)
        axes.errorbar(place[:-1], shown, errors, color=colour, marker=marker, markersize=4.0, capsize=4.0, label=label)
        axes.plot(place[-1:], [film.extrapolated * z.factor], marker, color=colour, markerfacecolor="white")
        axes.axhline(film.extrapolated * z.factor, color=colour, linewidth=0.8, linestyle="--")
        top = max(top, float(np.nanmax([*film.values, film.extrapolated])) * z.factor)
    axes.set_xticks(place, [*(_nodes(dataset, nodes) for nodes in grids), "∞"])
    axes.set(xlabel="nodes (∞: extrapolated)", ylabel=f"film thickness ({z.unit})", ylim=(0.0, 1.4 * top))
    axes.set_title("Film on each grid with its error estimate")
    axes.legend(loc="upper left", frameon=False, fontsize="small")


# -- figures ---------------------------------------------------------------------------------------------------------


def overview(dataset: xr.Dataset, at: At = None) -> Figure:
    """The steady contact on one page: maps, sections, convergence, and what the grid does to the film."""
    above: list[Panel] = [draw_horseshoe, partial(draw_midline, along="x"), draw_grids]
    return _of(dataset, at, [above, [draw_spike, partial(draw_midline, along="y"), draw_convergence]])


def film(dataset: xr.Dataset, at: At = None) -> Figure:
    """Film thickness over the surface: the horseshoe."""
    return _of(dataset, at, [[draw_horseshoe]])


def pressure(dataset: xr.Dataset, at: At = None) -> Figure:
    """Pressure over the surface with its spike."""
    return _of(dataset, at, [[draw_spike]])


def maps(dataset: xr.Dataset, at: At = None) -> Figure:
    """Film thickness and pressure over the surface."""
    return _of(dataset, at, [[draw_horseshoe, draw_spike]])


def midlines(dataset: xr.Dataset, at: At = None) -> Figure:
    """Film and pressure through the centre, along the flow and across it."""
    return _of(dataset, at, [[partial(draw_midline, along="x"), partial(draw_midline, along="y")]])


def convergence(dataset: xr.Dataset, at: At = None) -> Figure:
    """How Newton's iteration converged on every grid, and the film with the grid."""
    return _of(dataset, at, [[draw_convergence, draw_grids]])


def friction(dataset: xr.Dataset, at: At = None) -> Figure:
    """Shear stress, where the surfaces slide, and power loss over the surface."""
    panels: list[Panel] = [draw_stress_map, draw_loss_map] if slides(dataset) else [draw_loss_map]
    return _of(dataset, at, [panels], _coefficients)


def _coefficients(dataset: xr.Dataset) -> list[str]:
    return said(dataset, {name: float(dataset[name][-1]) for name in FRICTION})


def films(dataset: xr.Dataset) -> list[str]:
    """The films with their errors, for a heading."""
    return [_with_error(dataset, name) for name in ("H_c", "H_min")]


def check(dataset: xr.Dataset, at: At) -> None:
    """Raise NoFigure where there is nothing to draw yet, and for a moment: a steady contact has none."""
    if at is not None:
        raise NoFigure(f"at = {at!r}: a steady contact has no moments to choose from; leave it out")
    if not dataset.sizes["grid"]:
        raise NoFigure("dataset: has no solution yet, there is nothing to draw")


def _of(
    dataset: xr.Dataset, at: At, rows: list[list[Panel]], outcome: Callable[[xr.Dataset], list[str]] = films
) -> Figure:
    """A figure; outcome: what its heading says of the solution."""
    check(dataset, at)
    dataset = dataset.load()
    return compose(dataset, rows, [*title(dataset), *outcome(dataset)])


STEADY_FIGURES: Figures = {
    "overview": overview,
    "film": film,
    "pressure": pressure,
    "midlines": midlines,
    "convergence": convergence,
    "friction": friction,
}
MORE_STEADY_FIGURES: Figures = {"maps": maps}  # film and pressure in one, for a notebook
