"""The picture of a fit: what was measured with the fitted curves, and the residuals below."""

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ertel.plots.drawing import BLUE, ORANGE, Picture, Scale
from ertel.results.dataset import largest_of
from ertel.results.measurements import QUANTITIES
from ertel.results.variables import Variable

MOST_CURVES = 5  # side by side; further ones are left out
MANY = 4  # numbers whose names stand upright


def figure(dataset: xr.Dataset) -> Figure:
    """The data with their fitted curves, and below the residuals in standard deviations.

    dataset: see `results.fit_result.fit_dataset`.  Each profile and each history has a column; all numbers share one.
    """
    indices, is_number = dataset["measurement"].values, np.isnan(dataset["x"].values)
    parts = [dataset.isel(datum=indices == index) for index in np.unique(indices[~is_number])[:MOST_CURVES]]
    numbers = [dataset.isel(datum=is_number)] if is_number.any() else []
    count = len(parts) + len(numbers)
    picture = Picture(figsize=(max(4.2 * count, 6.0), 5.2), layout="constrained", dpi=150)
    axes = picture.subplots(2, count, squeeze=False, sharex="col", height_ratios=(3, 1.2))
    for pair, part in zip(axes.T, [*parts, *numbers], strict=True):
        draw = _numbers if np.isnan(part["x"]).all() else _curve
        x = draw(pair[0], pair[1], part)
        pair[1].plot(x, part["residual"], "o", color=BLUE, markersize=3.5)
        pair[1].axhline(0.0, color=ORANGE)
        pair[1].axhspan(-2.0, 2.0, color=ORANGE, alpha=0.15, linewidth=0)
        reach = max(3.0, 1.15 * largest_of(part["residual"]))
        pair[1].set_ylim(-reach, reach)
    axes[1, 0].set_ylabel(r"residual ($\sigma$)")
    heading = [str(dataset.attrs["title"]).replace("_", " "), *dataset.attrs["found"]]
    picture.suptitle("\n".join(heading), fontsize="medium")
    return picture


def _curve(upper: Axes, lower: Axes, part: xr.Dataset) -> np.ndarray:
    """A profile or a history; its abscissae."""
    variable, x_unit = QUANTITIES[str(part["quantity"].values[0])], str(part["x_unit"].values[0])
    y = _scale(variable, part["measured"], variable.si_units or "1")
    along = _scale(Variable("time" if x_unit == "s" else "place", "t" if x_unit == "s" else "x"), part["x"], x_unit)
    x, measured, sigma = (part[k].values * s.factor for k, s in (("x", along), ("measured", y), ("sigma", y)))
    upper.errorbar(x, measured, sigma, fmt="o", color=BLUE, markersize=3, linewidth=0.7, label="measured")
    upper.plot(x, part["predicted"] * y.factor, color=ORANGE, label="fit", zorder=3)
    upper.set(ylabel=y.label, title=str(part["conditions"].values[0]))
    upper.legend(frameon=False, fontsize="small")
    lower.set_xlabel(along.label)
    return np.asarray(x)


def _scale(variable: Variable, values: xr.DataArray, unit: str) -> Scale:
    about = {"symbol": variable.si_name or variable.symbol, "long_name": variable.long_name, "units": unit}
    return Scale.of(values.assign_attrs(about), largest_of(values))


def _numbers(upper: Axes, lower: Axes, part: xr.Dataset) -> np.ndarray:
    """Numbers, each over the one that is fitted; their places."""
    places = np.arange(part.sizes["datum"])
    measured, sigma, predicted = (part[key].values for key in ("measured", "sigma", "predicted"))
    upper.errorbar(
        places, measured / predicted, sigma / np.abs(predicted), fmt="o", color=BLUE, capsize=2, markersize=4
    )
    upper.axhline(1.0, color=ORANGE)
    upper.set(ylabel="measured / fit", title="numbers", xlim=(-0.6, len(places) - 0.4))
    pairs = zip(part["quantity"].values, part["conditions"].values, strict=True)
    labels = [f"{quantity}\n{conditions}".strip().replace("_", " ") for quantity, conditions in pairs]
    lower.set_xticks(places, labels, rotation=90 if len(places) > MANY else 0, fontsize="x-small")
    return places
