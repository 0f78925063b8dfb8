"""A measurement over the profile or the history that a run has in its place, and their difference below."""

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from ertel.plots.drawing import BLUE, GREY, ORANGE, NoFigure, Picture, Scale
from ertel.plots.view import View
from ertel.results.measurements import Comparison

ROOM = 0.15  # of the measured range, shown beside it
HEIGHTS = (3.0, 1.0)  # of the values and of their difference


def measured(dataset: xr.Dataset, comparison: Comparison) -> Figure:
    """A measured profile or history over that of the run, aligned, and measured less computed below.

    Parameters
    ----------
    dataset : xarray.Dataset
        The run, for the heading.
    comparison : Comparison
        Of `result.compare(measurement)`.

    Returns
    -------
    Figure
        Its title has the rms difference.

    Raises
    ------
    NoFigure
        The measurement is one number.
    """
    line, measurement = comparison.line, comparison.measurement
    if line is None:
        raise NoFigure(f"{measurement.name}: is one number; a picture needs a profile or a history")
    there, x, sigma = line[measurement.axis], comparison.x, measurement.sigma
    room = ROOM * float(np.ptp(x))
    shown = (there >= x.min() - room) & (there <= x.max() + room)
    computed = line[shown].values if shown.any() else comparison.computed
    top = float(max(computed.max(), comparison.measured.max()))
    along, z = Scale.of(there, float(np.abs(x).max())), Scale.of(line, top / 2)
    dz = Scale.of(line, float(np.abs(comparison.difference).max()))
    figure = Picture(figsize=(6.0, 5.4), layout="constrained", dpi=150)
    above, below = figure.subplots(2, 1, sharex=True, height_ratios=HEIGHTS)
    above.plot(there * along.factor, line * z.factor, color=BLUE, label="computed")
    points = {"color": ORANGE, "linestyle": "none", "marker": ".", "markersize": 4.0}
    bars = None if sigma is None else np.broadcast_to(sigma, x.shape)
    above.errorbar(
        x * along.factor, comparison.measured * z.factor, None if bars is None else bars * z.factor,
        **points, elinewidth=0.6, label=f"measured, {measurement.name}",
    )  # fmt: skip
    below.plot(x * along.factor, comparison.difference * dz.factor, **points)
    below.axhline(0.0, color=GREY, linewidth=0.8)
    above.set(ylim=(min(0.0, 1.05 * float(comparison.measured.min()) * z.factor), 1.1 * top * z.factor), ylabel=z.label)
    place = f"${measurement.axis}$ {along.in_brackets}"
    below.set(
        xlim=((x.min() - room) * along.factor, (x.max() + room) * along.factor),
        xlabel=place,
        ylabel=f"difference {dz.in_brackets}",
    )
    above.legend(frameon=False, fontsize="small")
    name, *_ = View(dataset).title
    heading = f"{name}, {comparison.where}" if comparison.where else name
    figure.suptitle(f"{heading}\n{comparison.text}", fontsize="medium")
    return figure
