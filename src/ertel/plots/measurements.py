"""Pictures of measurements: on the profiles of a run, beside a run, or with the curves that were fitted."""

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from typing import Any, Unpack

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ertel.optics import Interferometer
from ertel.plots.drawing import BLUE, ORANGE, NoFigure, Panel, Scale, Sheet, SheetOptions, Values, compose
from ertel.plots.view import View
from ertel.results.alignment import INTENSITY, QUANTITIES, Comparison, with_start
from ertel.results.dataset import largest_of
from ertel.results.measurements import Measurement
from ertel.results.profiles import At
from ertel.results.variables import Variable

ROOM = 0.15  # of the measured range, shown beside it
MOST_CURVES = 5  # side by side; further ones are left out
MANY = 3  # numbers whose names stand upright
Curve = tuple[Values, Values]  # x and y
POINTS: dict[str, Any] = {"fmt": "o", "color": BLUE, "markersize": 3.0, "linewidth": 0.7}


def _draw_values(axes: Axes, points: Curve, sigma: Values | None, curve: Curve, names: tuple[str, str]) -> None:
    """Points with error bars and the curve that is computed, and their names."""
    axes.errorbar(*points, yerr=sigma, label=names[0], **POINTS)
    axes.plot(*curve, color=ORANGE, label=names[1], zorder=3)
    axes.legend(frameon=False, fontsize="small")


def _draw_difference(axes: Axes, x: Values, difference: Values, label: str) -> None:
    axes.plot(x, difference, "o", color=BLUE, markersize=3.0)
    axes.axhline(0.0, color=ORANGE)
    axes.set(ylabel=label)


# -- on the profiles of a run -----------------------------------------------------------------------------------------

Overlay = Measurement | Sequence[Measurement] | None


def measured_view(
    dataset: xr.Dataset, at: At, given: Overlay, shown: Sequence[str] = ("h", "p"), optics: Interferometer | None = None
) -> View:
    """The view of a run at a moment, with measured profiles.

    at: where it is not given, that of the measurements, which without one of their own are of the moment of the view.
    shown: the quantities that the picture shows.  optics: of intensities without one of their own.  Raises NoFigure
    where a measurement is not a profile of these, ValueError where the run does not reach as far, TypeError for
    anything else.
    """
    several: list[Any] = list(given) if isinstance(given, list | tuple) else [] if given is None else [given]
    for each in several:
        if not isinstance(each, Measurement):
            raise TypeError(f"measured = {each!r}: must be a Measurement, or a list of them")
        if each.kind != "profile" or each.quantity not in shown:
            what = f"{each.name} is a {each.kind} of {each.quantity}"
            raise NoFigure(f"measured: {what}; this picture shows profiles of {' and '.join(shown)}")
    run = View(dataset)
    several = [with_start([each], run)[0] if "start" in each.align else each for each in several]
    view = View.of(dataset, next((each.moment for each in several if each.at is not None), None) if at is None else at)
    own = {"at": None if view.frame is None else view.time, "optics": optics}
    missing = [{name: value for name, value in own.items() if getattr(each, name) is None} for each in several]
    filled = [replace(each, **more) for each, more in zip(several, missing, strict=True)]
    return replace(view, measured=tuple(each.compared(view) for each in filled))


def draw_measured(axes: Axes, view: View, name: str, z: Scale, along: str = "x", color: str = BLUE) -> None:
    """Draw the measured values of H or P along x or y.  z: of these, as they are stored."""
    for each in view.measured:
        measurement = each.measurement
        if measurement.quantity == name.lower() and (view.is_radial or measurement.along == along):
            factor = z.factor / view.dataset[name].attrs["si_factor"]
            look = {**POINTS, "color": color, "label": f"measured, {measurement.name}"}
            bars = None if each.sigma is None else each.sigma * factor
            axes.errorbar(_across(view, each.x), each.measured * factor, bars, zorder=4, **look)


def _across(view: View, x: Values) -> Values:
    """Places in m, as shown."""
    return x * view.across.factor / view.dataset["r" if view.is_radial else "X"].attrs["si_factor"]


def draw_light(axes: Axes, view: View) -> None:
    """The computed intensity of light along a line, and the measured one."""
    found = next(each for each in view.measured if each.measurement.quantity == INTENSITY)
    along, line = found.measurement.along, found.line
    assert line is not None
    line = line.sel({along: slice(found.x.min(), found.x.max())})
    points, curve = (_across(view, found.x), found.measured), (_across(view, line[along].values), line.values)
    _draw_values(axes, points, found.sigma, curve, (f"measured, {found.measurement.name}", "computed"))
    axes.set(xlabel=view.axis_label(along), ylabel="intensity, as measured", title="Light along the line")


# -- beside a run -----------------------------------------------------------------------------------------------------


def measured(dataset: xr.Dataset, comparison: Comparison, **sheet: Unpack[SheetOptions]) -> Figure:
    """A measured profile or history over that of the run, aligned, and measured less computed beside it.

    Parameters
    ----------
    dataset : xarray.Dataset
        The run or the study, for the heading.
    comparison : Comparison
        Of `result.compare(measurement)`.
    **sheet
        Two axes or a size, and whether there is a title: ax, figsize, columns, title, see `Sheet`.

    Returns
    -------
    Figure
        Its title has the rms difference.

    Raises
    ------
    NoFigure
        The measurement is one number.
    TypeError
        Anything else than a comparison.
    """
    if not isinstance(comparison, Comparison):
        raise TypeError(f"comparison = {comparison!r}: must be that of result.compare(measurement)")
    line, measurement = comparison.line, comparison.measurement
    if line is None:
        raise NoFigure(f"{measurement.name}: is one number; a picture needs a profile or a history")
    is_curve = measurement.kind == "curve"
    axis = measurement.axis.replace("_", " ") if is_curve else f"${measurement.axis}$"
    along = Scale.of(line[measurement.axis], float(np.abs(comparison.x).max()))
    x, there = along.shown(comparison.x), along.shown(line[measurement.axis].values)
    room = ROOM * float(np.ptp(x))
    low, high = float(x.min()) - room, float(x.max()) + room
    shown = line.values[(there >= low) & (there <= high)]
    top = float(np.concatenate([shown, comparison.computed, comparison.measured]).max())
    z, dz = (Scale.of(line, largest) for largest in (top / 2, float(np.abs(comparison.difference).max())))
    place: dict[str, Any] = {"xlim": (low, high), "xlabel": f"{axis} {along.in_brackets}".rstrip()}

    def draw_values(axes: Axes, _: Comparison) -> None:
        bars = None if comparison.sigma is None else comparison.sigma * z.factor
        points, curve = (x, z.shown(comparison.measured)), (there, z.shown(line.values))
        _draw_values(axes, points, bars, curve, (f"measured, {measurement.name}", "computed"))
        bottom = min(0.0, 1.05 * float(points[1].min()))
        axes.set(ylim=(bottom, 1.1 * z.shown(top)), ylabel=z.label, **place)

    def draw_difference(axes: Axes, _: Comparison) -> None:
        _draw_difference(axes, x, comparison.difference * dz.factor, f"difference {dz.in_brackets}")
        axes.set(**place)

    title = str(dataset.attrs["title"]).replace("_", " ") if is_curve else View(dataset).title[0]
    heading = [part for part in (title, comparison.where, comparison.text, comparison.aligned) if part]
    return compose(comparison, [[draw_values, draw_difference]], heading, Sheet(**sheet))


# -- fits -------------------------------------------------------------------------------------------------------------


def fit_figure(dataset: xr.Dataset, sheet: Sheet) -> Figure:
    """The data with their fitted curves, and below the residuals in standard deviations.

    dataset: see `runs.fit_result.fit_dataset`.  Each profile and each history has a column; all numbers share one.
    """
    indices, is_number = dataset["measurement"].values, np.isnan(dataset["x"].values)
    parts = [dataset.isel(datum=indices == index) for index in np.unique(indices[~is_number])[:MOST_CURVES]]
    parts += [dataset.isel(datum=is_number)] if is_number.any() else []
    data: list[Panel[xr.Dataset]] = [partial(_draw_fitted, part=part) for part in parts]
    residuals: list[Panel[xr.Dataset]] = [partial(_draw_residuals, part=part) for part in parts]
    heading = [str(dataset.attrs["title"]).replace("_", " "), *dataset.attrs["found"]]
    return compose(dataset, [data, residuals], heading, sheet)


def _draw_fitted(axes: Axes, dataset: xr.Dataset, part: xr.Dataset) -> None:
    """A profile or a history with the fitted curve, or numbers, each over the one that is fitted."""
    x = _abscissa(axes, part)
    measured, sigma, predicted = (part[key].values for key in ("measured", "sigma", "predicted"))
    if np.isnan(part["x"]).all():
        axes.errorbar(x, measured / predicted, sigma / np.abs(predicted), **POINTS)
        axes.axhline(1.0, color=ORANGE)
        axes.set(ylabel="measured / fit")
        return
    variable = QUANTITIES[str(part["quantity"].values[0])]
    y = _scale(variable, part["measured"], variable.si_units or "1")
    _draw_values(axes, (x, y.shown(measured)), sigma * y.factor, (x, y.shown(predicted)), ("measured", "fit"))
    about = [str(part[name].values[0]) for name in ("conditions", "aligned") if name in part]
    axes.set(ylabel=y.label, title="\n".join(filter(None, about)))


def _draw_residuals(axes: Axes, dataset: xr.Dataset, part: xr.Dataset) -> None:
    """The residuals, and two standard deviations to both sides."""
    _draw_difference(axes, _abscissa(axes, part), part["residual"].values, r"residual ($\sigma$)")
    axes.axhspan(-2.0, 2.0, color=ORANGE, alpha=0.15, linewidth=0)
    reach = max(3.0, 1.15 * largest_of(part["residual"]))
    axes.set(ylim=(-reach, reach))


def _abscissa(axes: Axes, part: xr.Dataset) -> np.ndarray:
    """The places or times of a measurement, or places for the names of numbers, at labelled axes."""
    unit = str(part["x_unit"].values[0])
    if unit:
        name = Variable("time", "t") if unit == "s" else Variable("place", "x")
        scale = _scale(name, part["x"], unit)
        varies = str(part["varies"].values[0]).replace("_", " ") if "varies" in part else ""
        axes.set_xlabel(f"{varies} {scale.in_brackets}" if varies else scale.label)
        return np.asarray(scale.shown(part["x"].values))
    places = np.arange(part.sizes["datum"])
    pairs = zip(part["quantity"].values, part["conditions"].values, strict=True)
    labels = [f"{quantity}\n{conditions}".strip().replace("_", " ") for quantity, conditions in pairs]
    axes.set_xticks(places, labels, rotation=90 if len(places) > MANY else 0, fontsize="small")
    axes.set_xlim(-0.6, len(places) - 0.4)
    return places


def _scale(variable: Variable, values: xr.DataArray, unit: str) -> Scale:
    about = {"symbol": variable.si_name or variable.symbol, "long_name": variable.long_name, "units": unit}
    return Scale.of(values.assign_attrs(about), largest_of(values))
