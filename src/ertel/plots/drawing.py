"""The common parts of all pictures: colours, units and their prefixes, and figures that are made of panels.

A run of a physical case is drawn in SI with fitting prefixes, a dimensionless one in units a*, a*^2/R, p_h*, t0 (of a
rolling contact, whose scales are those of its load, without the star).
The colours can be told apart by everybody (Okabe and Ito; for ordered values, maps whose lightness is ordered).
"""

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from io import BytesIO
from typing import TypeVar

import numpy as np
import xarray as xr
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from ertel.results.variables import PREFIXES, exponent, unit_of

Values = NDArray[np.float64]
Subject = TypeVar("Subject")
Panel = Callable[[Axes, Subject], None]

BLUE, ORANGE, GREEN, PURPLE, GREY = "#0072B2", "#D55E00", "#009E73", "#CC2F8E", "#777777"
ORDERED_COLOURS = LinearSegmentedColormap.from_list("ordered", colormaps["viridis"](np.linspace(0.0, 0.88, 256)))
UNITS = {
    "a*": "$a^*$", "a*^2/R": "$a^{*2}/R$", "p_h*": "$p_h^*$", "F*": "$F^*$", "a*/t0": "$a^*/t_0$", "t0": "$t_0$",
    "a": "$a$", "a^2/R": "$a^2/R$", "p_h": "$p_h$", "F": "$F$", "u_m": "$u_m$",
    "a*/R": "$a^*/R$", "p_h* a*/R": r"$p_h^*\, a^*/R$", "p_h* a*^2/(R t0)": r"$p_h^*\, a^{*2}/(R t_0)$",
    "a/R": "$a/R$", "p_h a/R": r"$p_h\, a/R$", "p_h u_m a/R": r"$p_h\, u_m\, a/R$",
    "F* a*^2/(R t0)": r"$F^* a^{*2}/(R\,t_0)$", "F u_m a/R": r"$F u_m\, a/R$",
}  # fmt: skip
PER_AREA = {"W/m2": (1e-6, "W/mm²")}  # SI units that are shown in another one
GREEK = "Delta|delta|^mu|^tau"


class NoFigure(ValueError):
    """A run does not have such a figure or such a moment, or there is nothing to draw yet."""


@dataclass(frozen=True)
class Scale:
    """The factor and the label under which a variable is shown.  unit: "" of a plain number."""

    factor: float
    symbol: str
    unit: str
    long_name: str

    @classmethod
    def of(cls, variable: xr.DataArray, largest: float = 1.0, kind: str = "") -> "Scale":
        """The scale of a variable: in SI with the prefix that fits, or in dimensionless units.

        Parameters
        ----------
        variable : xarray.DataArray
            Dimensionless with the attribute si_factor or without, or in SI already.
        largest : float
            The value, as stored, that the prefix fits.  Compound units and temperatures have no prefix.
        kind : str
            "rolling" or "impact", for the names of dimensionless units.
        """
        about = variable.attrs
        symbol, long_name = mathtext(about.get("si_name", about["symbol"])), about["long_name"]
        unit, factor = about.get("si_units", about["units"]), about.get("si_factor", 1.0)
        if unit == "1":
            base = "" if "si_units" in about else about.get("in_units_of", "")
            base = unit_of(kind, base) if kind else base
            return cls(factor, symbol, UNITS.get(base, base), long_name)
        power = 0 if "/" in unit or unit == "K" else exponent(abs(largest) * factor)
        share, shown = PER_AREA.get(unit, (10.0**-power, PREFIXES[power] + unit))
        return cls(factor * share, symbol, shown, long_name)

    @property
    def label(self) -> str:
        """Name, symbol and unit, for an axis."""
        return " ".join(part for part in (self.long_name, self.symbol, self.in_brackets) if part)

    @property
    def in_brackets(self) -> str:
        """The unit in brackets, if there is one."""
        return f"({self.unit})" if self.unit else ""


def mathtext(symbol: str) -> str:
    """H_min as $H_\\mathrm{min}$, Delta as a Greek letter."""
    base, _, index = re.sub(GREEK, r"\\\g<0>", symbol).partition("_")
    return f"${base}_\\mathrm{{{index}}}$" if index else f"${base}$"


def levels(top: float, steps: int = 10) -> Values:
    """Equal steps of a round number from zero to `top` or a little above."""
    return np.asarray(MaxNLocator(steps).tick_values(0.0, top))


class Picture(Figure):
    """A Figure that a notebook shows without pyplot."""

    def _repr_png_(self) -> bytes:
        png = BytesIO()
        self.savefig(png, format="png")
        return png.getvalue()


def compose(subject: Subject, rows: Sequence[Sequence[Panel[Subject]]], heading: Sequence[str]) -> Figure:
    """A figure of rows of panels.

    Parameters
    ----------
    subject : object
        Every panel is called with its axes and with this.
    rows : sequence of sequences of panels
        All rows have the same length.
    heading : sequence of str
        A name and its properties, on as many lines as they take.
    """
    width = max(5.0 * len(rows[0]), 6.0)
    figure = Picture(figsize=(width, width / len(rows[0]) * 0.8 * len(rows) + 0.4), layout="constrained", dpi=150)
    figure.get_layout_engine().set(w_pad=0.12, h_pad=0.1)  # type: ignore[union-attr, call-arg]
    for panels, line in zip(rows, figure.subplots(len(rows), len(rows[0]), squeeze=False), strict=True):
        for draw, axes in zip(panels, line, strict=True):
            draw(axes, subject)
    figure.suptitle(_wrapped(heading, round(10 * width)), fontsize="medium")
    return figure


def _wrapped(parts: Sequence[str], width: int) -> str:
    """Parts side by side, on a new line where one would be longer than `width` characters."""
    first, *rest = parts
    lines = [f"{first}: "]
    for number, part in enumerate(rest, 1):
        text = part + (",  " if number < len(rest) else "")
        seen = len(re.sub(r"\\mathrm|[${}_^\\]", "", lines[-1] + text))
        lines = [*lines, text] if seen > width else [*lines[:-1], lines[-1] + text]
    return "\n".join(line.rstrip() for line in lines)
