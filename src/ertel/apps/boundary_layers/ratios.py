"""Amplitude ratios A_d/A_i, each at its place with the parameter nabla2, and how they are drawn and tabled."""

from collections.abc import Iterable, Mapping, Sequence
from typing import NamedTuple

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from numpy.typing import ArrayLike, NDArray
from pandas import DataFrame

from ertel import Parameters, amplitude_reduction, fronts, plots, waves
from ertel.apps.boundary_layers.plans import Moes
from ertel.apps.boundary_layers.runs import HEIGHT, wave_name

Values = NDArray[np.float64]
LINE_CONTACT = {
    "line contact (1997)": amplitude_reduction.LINE_1997,
    "line contact (later fit)": amplitude_reduction.LINE_REFIT,
}
RANGE = np.geomspace(0.3, 30, 200)  # nabla2 of the curves


class Extrapolated(NamedTuple):
    """A value on two grids, the fine one with half the spacing."""

    coarse: float
    fine: float

    @property
    def limit(self) -> float:
        """The limit of a method of second order (Richardson)."""
        return self.fine + (self.fine - self.coarse) / 3

    @property
    def error(self) -> float:
        """The error bar: distance between this limit and that of a method of first order."""
        return 2 / 3 * abs(self.fine - self.coarse)

    def columns(self) -> dict[str, float]:
        """Columns of a data file."""
        return {"coarse": self.coarse, "fine": self.fine, "limit": self.limit, "error": self.error}

    def cells(self) -> dict[str, str]:
        """Cells of a table."""
        return {"A_d/A_i coarse": f"{self.coarse:.3f}", "fine": f"{self.fine:.3f}", "extrapolated": self.text()}

    def text(self) -> str:
        """The limit with its error bar."""
        return f"{self.limit:.3f} ± {self.error:.3f}"


class Mark(NamedTuple):
    """A_d/A_i for one kind of waves, oil or run, at X.

    local: nabla2 of this place, by the speed of the front.  hertz: the same with the Hertz contact of the moment when
    the front passed.  everywhere: the global nabla2.  In rolling they are one.  Without piezoviscosity nabla2 is
    infinite; wavelength over trapped film takes its place, see `over_film`.
    """

    kind: str
    M: float
    L: float
    wavelength: float
    X: float
    ratio: Extrapolated
    local: float
    hertz: float
    everywhere: float

    @property
    def case(self) -> tuple[float, float, float]:
        """M, L and wavelength."""
        return self.M, self.L, self.wavelength

    def cells(self) -> dict[str, str]:
        """The first cells of a row."""
        return {"M": f"{self.M:g}", "L": f"{self.L:g}", "wavelength": f"{self.wavelength:g}"}

    def cells_of_place(self) -> dict[str, str]:
        """The cells of a wave in an impact."""
        return {
            **self.cells(),
            "X": f"{self.X:.3f}",
            **self.ratio.cells(),
            "nabla2 local": f"{self.local:.2f}",
            "momentary Hertz contact": f"{self.hertz:.2f}",
            "global": f"{self.everywhere:.2f}",
        }


def over_film(p: Parameters, wavelength: float, speed: float = 1.0, A: float = 1.0) -> float:
    """Wavelength over trapped film for the speed and radius (a*) of the front; equal to nabla2 if alpha_bar > 0.4.

    nabla2 = wavelength/sqrt(L/M), and sqrt(L/M) is the film at which a rigid ball stops; that of an isoviscous oil is
    0.3135 sqrt(lambda_bar).
    """
    return wavelength / A / Parameters(p.lambda_bar * speed / A**4, p.alpha_bar * A).trapped_film


def impact_mark(kind: str, case: Moes, wavelength: float, X: float, ratio: Extrapolated, front: fronts.Front) -> Mark:
    """The mark of a wave at X in an impact."""
    p, speed = Parameters.from_moes(*case), float(front.speed_at(X))
    if not speed > 0.0:
        return Mark(kind, *case, wavelength, X, ratio, np.nan, np.nan, over_film(p, wavelength))
    local, hertz = over_film(p, wavelength, speed), over_film(p, wavelength, speed, X)
    return Mark(kind, *case, wavelength, X, ratio, local, hertz, over_film(p, wavelength))


def rolling_mark(kind: str, case: Moes, wavelength: float, ratio: Extrapolated) -> Mark:
    """The mark of waves in a rolling contact."""
    nabla2 = Parameters.from_moes(*case).nabla2(wavelength)
    return Mark(kind, *case, wavelength, 0.0, ratio, nabla2, nabla2, nabla2)


class Grids(NamedTuple):
    """The results of an impact on both grids."""

    coarse: xr.Dataset
    fine: xr.Dataset

    def responses(self, shape: str, wavelength: float) -> list[tuple[Values, Values]]:
        """X and dH/A_i of one wave on the coarse and on the fine grid."""
        found = [grid.sel(wave=wave_name(shape, HEIGHT, wavelength)) for grid in self]
        return [(response["X"].values, response["dH"].values) for response in found]

    def last_wave(self, kind: str, case: Moes, shape: str, wavelength: float) -> Mark:
        """The mark of the last complete wave inside the contact."""
        front = fronts.front(self.fine)
        edge = float(front.A[-1])
        coarse, fine = (waves.last_wave(X, dH, edge) for X, dH in self.responses(shape, wavelength))
        return impact_mark(kind, case, wavelength, fine.X, Extrapolated(coarse.amplitude, fine.amplitude), front)

    def ridges_at(self, case: Moes, wavelength: float, X: float) -> Mark:
        """The mark of longitudinal waves at X: transverse waves where the front runs along their ridges."""
        name = wave_name("transverse", HEIGHT, wavelength)
        ratio = Extrapolated(*(float(np.interp(X, grid["X"], grid["along"].sel(wave=name))) for grid in self))
        return impact_mark("longitudinal", case, wavelength, X, ratio, fronts.front(self.fine))


# -- pictures and tables ----------------------------------------------------------------------------------------------


def draw_curves(axes: Axes) -> None:
    """Eq. (15) and the curves of the line contact, for nabla2 = 0.4 to 20."""
    axes.semilogx(RANGE, amplitude_reduction.ratio_left(RANGE), color="black", label="(15), isotropic")
    for (name, coefficients), style in zip(LINE_CONTACT.items(), ("--", ":"), strict=True):
        line_contact = amplitude_reduction.in_line_contact(RANGE, coefficients)
        axes.semilogx(RANGE, line_contact, color=plots.GREY, linestyle=style, label=f"transverse, {name}")
    axes.set(ylim=(0, 1.1), xlim=(0.4, 20), ylabel="$A_d/A_i$")
    axes.set_xticks([0.5, 1, 2, 5, 10, 20], ["0.5", "1", "2", "5", "10", "20"])


def draw_fit(axes: Axes, ratio: Values, style: str, label: str) -> None:
    """Draw another curve over `RANGE`."""
    axes.plot(RANGE, ratio, color=plots.ORANGE, linewidth=1.0, linestyle=style, label=label)


def draw_marks(axes: Axes, marks: Sequence[Mark], styles: Mapping[str, tuple[str, str]]) -> None:
    """Marks with error bars.  styles: kind -> marker, colour."""
    for kind, (marker, colour) in styles.items():
        own = [mark for mark in marks if mark.kind == kind]
        place, limit = [mark.local for mark in own], [mark.ratio.limit for mark in own]
        bar = [mark.ratio.error for mark in own]
        if own:
            axes.errorbar(place, limit, bar, fmt=marker, color=colour, mfc="none", capsize=2, label=kind)


def marks_data(marks: Iterable[Mark]) -> DataFrame:
    """The marks as a data file."""
    names = ("M", "L", "wavelength", "X", "local", "hertz", "everywhere", "kind")
    return DataFrame({**{name: getattr(mark, name) for name in names}, **mark.ratio.columns()} for mark in marks)


def marks_table(heading: str, marks: Iterable[Mark]) -> DataFrame:
    """The marks as a table.  heading: of its first column, the kind."""
    return DataFrame({heading: mark.kind, **mark.cells_of_place()} for mark in marks)


def scatter(marks: Sequence[Mark], curve: ArrayLike) -> str:
    """Deviation of marks from the values of a curve, (n,): mean and root mean square, as a cell of a table."""
    off = np.array([mark.ratio.limit for mark in marks]) - np.asarray(curve)
    return f"{off.mean():+.3f}, {np.sqrt(np.mean(off**2)):.3f}"
