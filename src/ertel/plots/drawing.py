"""The common parts of all pictures: colours, units and their prefixes, and figures that are made of panels.

A run of a physical case is drawn in SI with fitting prefixes, a dimensionless one in units a*, a*^2/R, p_h*, t0 (of a
rolling contact, whose scales are those of its load, without the star).
The colours can be told apart by everybody (Okabe and Ito; for ordered values, maps whose lightness is ordered).
"""

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from io import BytesIO
from typing import Any, Literal, TypedDict, TypeVar

import numpy as np
import xarray as xr
from matplotlib import colormaps, rc_context, rcParams
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure
from matplotlib.font_manager import get_font_names
from matplotlib.ticker import LogLocator, NullFormatter
from numpy.typing import NDArray

from ertel.physics.temperature_laws import ZERO_CELSIUS
from ertel.results.figures import MADE_BY
from ertel.results.variables import KELVIN, prefixed, unit_of

Values = NDArray[np.float64]
Subject = TypeVar("Subject")
Panel = Callable[[Axes, Subject], object]

BLUE, ORANGE, GREEN, PURPLE, GREY = "#0072B2", "#D55E00", "#009E73", "#CC2F8E", "#777777"
ORDERED_COLOURS = LinearSegmentedColormap.from_list("ordered", colormaps["viridis"](np.linspace(0.0, 0.88, 256)))
GREEK = "Delta|delta|^mu|^tau|^sigma"
COLUMN = 85.0 / 25.4  # inches: a column of a journal
IN_PRINT: Any = {  # letters of 7 to 9 pt, "small" ones of 7.1 pt
    "font.size": 8.5, "axes.titlesize": 8.5, "axes.labelsize": 8.5, "figure.titlesize": 8.5, "axes.linewidth": 0.6,
    "xtick.labelsize": 7.5, "ytick.labelsize": 7.5, "legend.fontsize": 7.5, "lines.linewidth": 1.2,
    "xtick.major.width": 0.6, "ytick.major.width": 0.6, "legend.borderpad": 0.3,
}  # fmt: skip
EASTERN = {
    "Noto Sans CJK JP", "Noto Sans CJK SC", "Source Han Sans SC", "WenQuanYi Zen Hei", "IPAexGothic", "NanumGothic",
    "Microsoft YaHei", "Yu Gothic", "Malgun Gothic", "PingFang SC", "Hiragino Sans", "Apple SD Gothic Neo",
}  # fmt: skip
EMBEDDED: Any = {"pdf.fonttype": 42, "ps.fonttype": 42}  # as TrueType, which journals ask for
MARKED = {"png": "Software", "svg": "Creator", "pdf": "Creator"}  # where such a file says what drew it
LONGEST_TITLE = 30  # letters of a panel's title in print, before it takes a second line
MOST_HEIGHT = 0.8  # of a panel, as a share of its width
FLAT = 0.5  # height over width of a map from which its colour bar lies below it


def families(*names: str) -> list[str]:
    """Families of fonts, and those here that have characters which these lack, such as of a Chinese name."""
    return [*names, *sorted(EASTERN & set(get_font_names()))]


class NoFigure(ValueError):
    """A run does not have such a figure or such a moment, or there is nothing to draw yet."""


@dataclass(frozen=True)
class Scale:
    """The factor and the label under which a variable is shown.

    unit: "" of a plain number.  zero: the value that is shown as zero, of times and temperatures.
    """

    factor: float
    symbol: str
    unit: str
    long_name: str
    zero: float = 0.0

    def shown(self, values: Any) -> Any:
        """Values as they are shown: times from t = 0, temperatures in degC."""
        return (values - self.zero) * self.factor

    @classmethod
    def of(cls, variable: xr.DataArray, largest: float = 1.0, kind: str = "") -> "Scale":
        """The scale of a variable: in SI with the prefix that fits `largest`, as stored, or in dimensionless units.

        variable: with the attribute si_factor or without, or in SI already; a plain number, called as it is, where its
        attributes say nothing else.  kind: "rolling" or "impact", for the names of dimensionless units.
        """
        name = str(variable.name)
        about = {"symbol": name, "long_name": name, "units": "1", **variable.attrs}
        symbol, long_name = mathtext(about.get("si_name", about["symbol"])), about["long_name"]
        unit, factor = about.get("si_units", about["units"]), about.get("si_factor", 1.0)
        if unit == "1":
            base = "" if "si_units" in about else about.get("in_units_of", "")
            base = unit_of(kind, base) if kind else base
            return cls(factor, symbol, unit_text(base), long_name)
        if unit == KELVIN:
            return cls(factor, symbol, "°C", long_name, ZERO_CELSIUS)
        one, shown = prefixed(unit, largest * factor)
        return cls(factor / one, symbol, shown, long_name, about.get("si_zero", 0.0))

    @property
    def label(self) -> str:
        """Name, symbol and unit, for an axis."""
        return " ".join(part for part in (self.long_name, self.symbol, self.in_brackets) if part)

    @property
    def in_brackets(self) -> str:
        """The unit in brackets, if there is one."""
        return f"({self.unit})" if self.unit else ""


def unit_text(unit: str) -> str:
    """A dimensionless unit: a*^2/R as $a^{*2}/R$."""
    text = re.sub(r"(?<!{)\*", "^*", re.sub(r"\*\^(\d)", r"^{*\1}", unit))
    text = text.replace("t0", "t_0").replace(" ", r"\, ")
    return f"${text}$" if unit else ""


def mathtext(symbol: str) -> str:
    """H_min as $H_\\mathrm{min}$, Delta as a Greek letter."""
    base, _, index = re.sub(GREEK, r"\\\g<0>", symbol).partition("_")
    return f"${base}_\\mathrm{{{index.replace('_', ', ')}}}$" if index else f"${base}$"


def plain_ticks(axis: Axis) -> None:
    """Name the ticks of a logarithmic axis by plain numbers 1, 2, 5, 10, ..."""
    axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    axis.set_major_formatter("{x:g}")
    axis.set_minor_formatter(NullFormatter())


class SheetOptions(TypedDict, total=False):
    """The keywords of all pictures, see `Sheet`."""

    ax: Axes | Sequence[Axes] | None
    figsize: tuple[float, float] | None
    columns: Literal[1, 2] | None
    title: bool


@dataclass(frozen=True)
class Sheet:
    """The place and the size of a picture.

    A figure of a given size is for print: its letters have 7 to 9 pt at this size, its panels stand below each other
    where they would be narrower than a column, and files with dots have 300 of them an inch.

    Parameters
    ----------
    ax : Axes or sequence of Axes, optional
        Draw into these axes of a figure of your own, one for each panel, row by row.  Sizes and letters are its own.
    figsize : (float, float), optional
        Width and height in inches.
    columns : 1 or 2, optional
        The width in columns of a journal, of 85 mm: 85 or 170 mm; as high as it needs.
    title : bool
        False for a picture without heading and titles of panels.

    Raises
    ------
    NoFigure
        More than one of ax, figsize and columns; other numbers.
    """

    ax: Axes | Sequence[Axes] | None = None
    figsize: tuple[float, float] | None = None
    columns: Literal[1, 2] | None = None
    title: bool = True

    def __post_init__(self) -> None:
        if sum(each is not None for each in (self.ax, self.figsize, self.columns)) > 1:
            raise NoFigure("ax, figsize, columns: give one of them; each says how large the picture is")
        if self.columns not in (None, 1, 2):
            raise NoFigure(f"columns = {self.columns!r}: must be 1 or 2, for 85 or 170 mm")
        if self.figsize is not None and not (
            np.shape(self.figsize) == (2,)
            and all(isinstance(side, int | float | np.number) and 1.0 <= side < 60.0 for side in self.figsize)
        ):
            raise NoFigure(f"figsize = {self.figsize!r}: must be width and height in inches, from 1 to 60")

    @property
    def width(self) -> float | None:
        """The width in inches, if one is given."""
        return self.columns * COLUMN if self.columns else self.figsize and self.figsize[0]

    def own_axes(self, panels: int) -> list[Axes]:
        """The given axes.  Raises NoFigure where there are more or fewer than panels."""
        given = [each for each in np.ravel(np.asarray(self.ax, dtype=object)) if isinstance(each, Axes)]
        if len(given) != panels or np.size(np.asarray(self.ax, dtype=object)) != panels:
            raise NoFigure(f"ax: this picture has {panels} panels and needs as many axes")
        return given


class Picture(Figure):
    """A Figure that a notebook shows without pyplot, and whose files have letters that can be searched."""

    def savefig(self, fname: Any, **options: Any) -> None:
        """Save the figure as matplotlib does; PDF and PostScript hold Type 42 fonts, SVG has letters as paths.

        PNG, SVG and PDF say that ertel drew them.
        """
        if key := MARKED.get(str(options.get("format") or fname).rpartition(".")[2].lower()):
            options["metadata"] = {key: MADE_BY, **(options.get("metadata") or {})}
        with rc_context(EMBEDDED):
            super().savefig(fname, **options)

    def _repr_png_(self) -> bytes:
        png = BytesIO()
        self.savefig(png, format="png")
        return png.getvalue()


def compose(
    subject: Subject, rows: Sequence[Sequence[Panel[Subject]]], heading: Sequence[str], sheet: Sheet | None = None
) -> Figure:
    """A figure of rows of panels, each called with its axes and the subject; all rows have the same length.

    heading: a name and its properties, on as many lines as they take.  sheet: axes or a size; by default 5 inches for
    each panel of a row, for the screen.
    """
    sheet = sheet or Sheet()
    if sheet.ax is not None:
        panels = [panel for row in rows for panel in row]
        places = sheet.own_axes(len(panels))
        for draw, axes in zip(panels, places, strict=True):
            draw(axes, subject)
            axes.set_title(axes.get_title() if sheet.title else "")
        return places[0].get_figure(root=True)  # type: ignore[return-value]
    with rc_context({**(IN_PRINT if sheet.width else {}), "font.family": families(*rcParams["font.family"])}):
        return _composed(subject, _arranged(rows, sheet.width), heading if sheet.title else [], sheet)


def _arranged(rows: Sequence[Sequence[Panel[Subject]]], width: float | None) -> Sequence[Sequence[Panel[Subject]]]:
    """The rows, or their panels column by column in rows that are short enough for the width."""
    many = max(1, round((width or np.inf) / COLUMN)) if width else len(rows[0])
    if len(rows[0]) <= many:
        return rows
    panels = [panel for column in zip(*rows, strict=True) for panel in column]
    return [panels[start : start + many] for start in range(0, len(panels), many)]


def _composed(
    subject: Subject, rows: Sequence[Sequence[Panel[Subject]]], heading: Sequence[str], sheet: Sheet
) -> Figure:
    """A figure of its own, whose rows are as high as their maps."""
    many = len(rows[0])
    width = sheet.width or max(5.0 * many, 6.0)
    figure = Picture(figsize=(width, width), layout="constrained", dpi=300 if sheet.width else 150)
    pads = {"w_pad": 0.03, "h_pad": 0.03} if sheet.width else {"w_pad": 0.12, "h_pad": 0.1}
    figure.get_layout_engine().set(**pads)  # type: ignore[union-attr]
    places = figure.subplots(len(rows), many, squeeze=False)
    for panels, line in zip(rows, places, strict=True):
        for draw, axes in zip(panels, line, strict=False):
            draw(axes, subject)
        for spare in line[len(panels) :]:
            spare.remove()
    for axes in figure.axes:
        title = axes.get_title() if sheet.title else ""
        axes.set_title(re.sub(r"(?<!\\), ", ",\n", title) if sheet.width and len(title) > LONGEST_TITLE else title)
        axes.tick_params(labelsize=rcParams["xtick.labelsize"], width=rcParams["xtick.major.width"])  # later ticks, too
        if legend := axes.get_legend():
            legend.set_in_layout(False)  # or a wide one makes the axes narrower, and again
    text = _wrapped(heading, round((12 if sheet.width else 10) * width)) if heading else ""
    figure.suptitle(text, fontsize="medium")
    heights = [
        max(_height(axes, width / many) for axes in line[: len(row)]) for row, line in zip(rows, places, strict=True)
    ]
    places[0][0].get_gridspec().set_height_ratios(heights)
    figure.set_size_inches(sheet.figsize or (width, sum(heights) + 0.4 * bool(text) + 0.15 * text.count("\n")))
    if sheet.width:
        for _ in range(2):  # the first layout does not know all ticks
            figure.draw_without_rendering()
    return figure


def share_limits(figures: Sequence[Figure]) -> None:
    """Give panels that stand at the same place in figures of one kind the same limits, where their units are equal."""
    panels = [[axes for axes in figure.axes if axes.get_label() != "<colorbar>"] for figure in figures]
    for same in zip(*panels, strict=False):
        for name, label in (("x", Axes.get_xlabel), ("y", Axes.get_ylabel)):
            limits = np.array([getattr(axes, f"get_{name}lim")() for axes in same])
            if len({label(axes) for axes in same}) == 1:
                widest = limits.min(), limits.max()
                for axes, (first, last) in zip(same, limits, strict=True):
                    getattr(axes, f"set_{name}lim")(widest if first < last else widest[::-1])


def _height(axes: Axes, width: float) -> float:
    """The height of a panel in inches: of a map as high as its data, with its axis, title and colour bar."""
    if axes.get_aspect() == "auto":
        return MOST_HEIGHT * width
    letter: float = rcParams["font.size"] / 72.0
    shape = axes.get_data_ratio() * float(axes.get_aspect())
    beside, around = (6.0, 11.0) if shape < FLAT else (13.0, 6.5)  # letters: labels and colour bar, below or beside
    return min(MOST_HEIGHT * width, shape * (width - beside * letter) + around * letter)


def _wrapped(parts: Sequence[str], width: int) -> str:
    """Parts side by side, on a new line where one would be longer than `width` characters."""
    first, *rest = parts
    lines = [f"{first}: " if rest else first]
    for number, part in enumerate(rest, 1):
        text = part + (",  " if number < len(rest) else "")
        seen = len(re.sub(r"\\mathrm|[${}_^\\]", "", lines[-1] + text))
        lines = [*lines, text] if seen > width else [*lines[:-1], lines[-1] + text]
    return "\n".join(line.rstrip() for line in lines)
