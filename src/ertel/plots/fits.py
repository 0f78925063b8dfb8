"""The picture of a fit: what was measured with the fitted curves, and the residuals below."""

from functools import partial
from typing import Unpack

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ertel.plots.drawing import BLUE, ORANGE, Panel, Scale, Sheet, SheetOptions, compose
from ertel.results.dataset import largest_of
from ertel.results.measurements import QUANTITIES
from ertel.results.variables import Variable

MOST_CURVES = 5  # side by side; further ones are left out
MANY = 3  # numbers whose names stand upright
POINTS = {"fmt": "o", "color": BLUE, "markersize": 3.0, "linewidth": 0.7}


def figure(dataset: xr.Dataset, **options: Unpack[SheetOptions]) -> Figure:
    """The data with their fitted curves, and below the residuals in standard deviations.

    dataset: see `results.fit_result.fit_dataset`.  Each profile and each history has a column; all numbers share one.
    options: ax, figsize, columns, title, see `Sheet`.
    """
    indices, is_number = dataset["measurement"].values, np.isnan(dataset["x"].values)
    parts = [dataset.isel(datum=indices == index) for index in np.unique(indices[~is_number])[:MOST_CURVES]]
    parts += [dataset.isel(datum=is_number)] if is_number.any() else []
    data: list[Panel[xr.Dataset]] = [partial(_draw, part=part) for part in parts]
    residuals: list[Panel[xr.Dataset]] = [partial(_draw_residuals, part=part) for part in parts]
    heading = [str(dataset.attrs["title"]).replace("_", " "), *dataset.attrs["found"]]
    return compose(dataset, [data, residuals], heading, Sheet(**options))


def _draw(axes: Axes, dataset: xr.Dataset, part: xr.Dataset) -> None:
    """A profile or a history with the fitted curve, or numbers, each over the one that is fitted."""
    x = _abscissa(axes, part)
    measured, sigma, predicted = (part[key].values for key in ("measured", "sigma", "predicted"))
    if np.isnan(part["x"]).all():
        axes.errorbar(x, measured / predicted, sigma / np.abs(predicted), **POINTS)  # type: ignore[arg-type]
        axes.axhline(1.0, color=ORANGE)
        axes.set(ylabel="measured / fit")
        return
    variable = QUANTITIES[str(part["quantity"].values[0])]
    y = _scale(variable, part["measured"], variable.si_units or "1")
    axes.errorbar(x, measured * y.factor, sigma * y.factor, label="measured", **POINTS)  # type: ignore[arg-type]
    axes.plot(x, predicted * y.factor, color=ORANGE, label="fit", zorder=3)
    axes.set(ylabel=y.label, title=str(part["conditions"].values[0]))
    axes.legend(frameon=False, fontsize="small")


def _draw_residuals(axes: Axes, dataset: xr.Dataset, part: xr.Dataset) -> None:
    """The residuals, zero, and two standard deviations to both sides."""
    axes.plot(_abscissa(axes, part), part["residual"], "o", color=BLUE, markersize=3.0)
    axes.axhline(0.0, color=ORANGE)
    axes.axhspan(-2.0, 2.0, color=ORANGE, alpha=0.15, linewidth=0)
    reach = max(3.0, 1.15 * largest_of(part["residual"]))
    axes.set(ylabel=r"residual ($\sigma$)", ylim=(-reach, reach))


def _abscissa(axes: Axes, part: xr.Dataset) -> np.ndarray:
    """The places or times of a measurement, or places for the names of numbers, at labelled axes."""
    unit = str(part["x_unit"].values[0])
    if unit:
        name = Variable("time", "t") if unit == "s" else Variable("place", "x")
        scale = _scale(name, part["x"], unit)
        axes.set_xlabel(scale.label)
        return np.asarray(part["x"].values * scale.factor)
    places = np.arange(part.sizes["datum"])
    pairs = zip(part["quantity"].values, part["conditions"].values, strict=True)
    labels = [f"{quantity}\n{conditions}".strip().replace("_", " ") for quantity, conditions in pairs]
    axes.set_xticks(places, labels, rotation=90 if len(places) > MANY else 0, fontsize="small")
    axes.set_xlim(-0.6, len(places) - 0.4)
    return places


def _scale(variable: Variable, values: xr.DataArray, unit: str) -> Scale:
    about = {"symbol": variable.si_name or variable.symbol, "long_name": variable.long_name, "units": unit}
    return Scale.of(values.assign_attrs(about), largest_of(values))
