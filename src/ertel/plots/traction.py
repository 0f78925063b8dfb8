"""The picture of a traction curve: Dataset of `results.traction_curve` -> matplotlib Figure."""

from collections.abc import Mapping
from functools import partial

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from ertel.plots.drawing import (
    BLUE,
    GREEN,
    GREY,
    ORANGE,
    PURPLE,
    UNITS,
    NoFigure,
    Panel,
    Scale,
    compose,
    mathtext,
)
from ertel.plots.view import case_of
from ertel.results.curve_points import largest_of, shown_name
from ertel.results.variables import PREFIXES, exponent, unit_of, with_prefix

PANELS: Mapping[str, Mapping[str, str]] = {  # title: variables with their colours
    "Traction": {"mu_sliding": BLUE, "mu_rolling": ORANGE},
    "Film": {"H_c": BLUE, "H_min": ORANGE},
    "Power loss": {"power_loss": GREEN},
    "Maximum shear stress": {"tau_max": PURPLE},
}
WARM_PANELS: Mapping[str, Mapping[str, str]] = {  # with a section [thermal]
    **PANELS,
    "Traction": {"mu_sliding": BLUE, "mu_isothermal": GREY, "mu_rolling": ORANGE},
    "Temperature": {"T_film_max": PURPLE, "T_1_max": BLUE, "T_2_max": ORANGE},
    "Inlet factor": {"phi_T": GREEN},
}


def figure(dataset: xr.Dataset) -> Figure:
    """Traction coefficient, film thickness, power loss and shear stress along a traction curve.

    Raises NoFigure where there are no points yet.
    """
    if not dataset.sizes[dataset.attrs["varies"]]:
        raise NoFigure("dataset: has no points yet, there is nothing to draw")
    shown = WARM_PANELS if "phi_T" in dataset else PANELS
    panels: list[Panel[xr.Dataset]] = [partial(_draw, title=title, names=names) for title, names in shown.items()]
    half = len(panels) // 2
    return compose(dataset, [panels[:half], panels[half:]], _heading(dataset))


def _draw(axes: Axes, dataset: xr.Dataset, title: str, names: Mapping[str, str]) -> None:
    """Some variables of one unit over what varies."""
    along = dataset[dataset.attrs["varies"]]
    x = along.values
    found = {colour: dataset[shown_name("R_m" in dataset.attrs, name)] for name, colour in names.items()}
    largest = max(largest_of(values) for values in found.values())
    for colour, values in found.items():
        z = _scale(dataset, values, largest)
        axes.plot(x, values * z.factor, "o-", color=colour, markersize=3.5, label=z.long_name)
    if title != "Temperature":
        axes.axhline(0.0, color="black", linewidth=0.5)
    if has_equal_ratios(x):
        axes.set_xscale("log")
    else:
        axes.xaxis.set_major_locator(MaxNLocator(6))
    of_x = _scale(dataset, along, 1.0)
    axes.set(xlabel=of_x.label, ylabel=f"{title.lower()} ({z.unit})" if z.unit else title.lower(), title=title)
    if len(found) > 1:
        axes.legend(frameon=False, fontsize="small")


def _scale(dataset: xr.Dataset, values: xr.DataArray, largest: float) -> Scale:
    """How a variable is shown: in SI with a prefix that fits, or in the units of the case."""
    about = values.attrs
    symbol = mathtext(about["symbol"])
    if about["units"] == "1":
        unit = unit_of(dataset.attrs["kind"], about.get("in_units_of", ""))
        return Scale(1.0, symbol, UNITS.get(unit, unit), about["long_name"])
    power = 0 if "/" in about["units"] or about["units"] == "K" else exponent(largest)
    return Scale(10.0**-power, symbol, PREFIXES[power] + about["units"], about["long_name"])


def has_equal_ratios(x: np.ndarray) -> bool:
    """Whether the values were spaced by equal ratios."""
    if len(x) < 3 or not (x > 0).all():
        return False
    steps = np.diff(np.log(x))
    return bool(np.allclose(steps, steps[0]))


def _heading(dataset: xr.Dataset) -> list[str]:
    """The name of the case, then its conditions apart from what varies."""
    a, varies = dataset.attrs, dataset.attrs["varies"]
    name = str(a["title"]).partition(", M = ")[0].replace("_", " ")
    said = [f"{name[:1].upper()}{name[1:]}"]
    if "R_m" in a:
        said.append(f"$R$ = {with_prefix(a['R_m'], 'm')}")
        for axis, symbol, key, unit in (("mean_speed", "$u_m$", "u_m_m_per_s", "m/s"), ("load", "$F$", "F_N", "N")):
            if varies != axis:
                said.append(f"{symbol} = {with_prefix(a[key], unit)}")
        if varies != "load":
            said.append(f"$p_h$ = {with_prefix(a['p_h_Pa'], 'Pa')}")
    if varies != "slide_to_roll":
        said.append(f"slide-to-roll {case_of(dataset).motion.slide_to_roll:.3g}")
    else:
        said += [f"$M$ = {a['M']:.4g}", f"$L$ = {a['L']:.3g}"]
    return said
