"""Amplitude ratios A_d/A_i, each at its place with the parameter nabla2, and how they are drawn and tabled.

Two figures beyond the paper show nothing else: Fig. 7, waves of other shapes in impact and rolling, and Fig. 8, impacts
with other lubricants.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import partial
from math import inf
from typing import NamedTuple

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import ArrayLike, NDArray
from pandas import DataFrame

from ertel import Parameters, amplitude_reduction, fronts, plots, waves
from ertel.apps.boundary_layers import runs
from ertel.apps.boundary_layers.plans import Drawn, Moes, Plan, Wavelengths, new_figure
from ertel.apps.boundary_layers.runs import HEIGHT, OILS, SOFT, USUAL, Results, wave_name
from ertel.runs.tasks import Task

Values = NDArray[np.float64]
Curve = Callable[[ArrayLike], Values]  # A_d/A_i of nabla2
LINE_CONTACT: Mapping[str, Curve] = {
    "line contact (1997)": amplitude_reduction.in_line_contact,
    "line contact (later fit)": partial(
        amplitude_reduction.in_line_contact, coefficients=amplitude_reduction.LINE_REFIT
    ),
}
CURVES: Mapping[str, Curve] = {
    "(15), isotropic": amplitude_reduction.ratio_left,
    "line contact": amplitude_reduction.in_line_contact,
    "(15), longitudinal": lambda nabla2: amplitude_reduction.ratio_left(nabla2, inf),
}
OF_SHAPES = {"transverse": ("o", plots.BLUE), "rings": ("D", plots.GREEN), "longitudinal": ("^", plots.ORANGE)}
OF_OILS = dict(zip(OILS, (("o", "black"), ("s", plots.BLUE), ("D", plots.GREEN), ("^", plots.ORANGE)), strict=True))
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
    local, hertz = np.nan, np.nan
    if speed > 0.0:
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
        responses = [grid.sel(wave=wave_name(shape, HEIGHT, wavelength)) for grid in self]
        return [(response["X"].values, response["dH"].values) for response in responses]

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
    for (name, curve), style in zip(LINE_CONTACT.items(), ("--", ":"), strict=True):
        axes.semilogx(RANGE, curve(RANGE), color=plots.GREY, linestyle=style, label=f"transverse, {name}")
    axes.set(ylim=(0, 1.1), xlim=(0.4, 20), ylabel="$A_d/A_i$")
    axes.set_xticks([0.5, 1, 2, 5, 10, 20], ["0.5", "1", "2", "5", "10", "20"])


def draw_fit(axes: Axes, ratio: Values, style: str, label: str) -> None:
    """Draw another curve over `RANGE`."""
    axes.plot(RANGE, ratio, color=plots.ORANGE, linewidth=1.0, linestyle=style, label=label)


def draw_marks(axes: Axes, marks: Sequence[Mark], styles: Mapping[str, tuple[str, str]]) -> None:
    """Marks with error bars.  styles: kind -> marker, colour."""
    for kind, (marker, colour) in styles.items():
        drawn = [mark for mark in marks if mark.kind == kind]
        place, limit = [mark.local for mark in drawn], [mark.ratio.limit for mark in drawn]
        bar = [mark.ratio.error for mark in drawn]
        if drawn:
            axes.errorbar(place, limit, bar, fmt=marker, color=colour, mfc="none", capsize=2, label=kind)


def marks_data(marks: Iterable[Mark]) -> DataFrame:
    """The marks as a data file."""
    names = ("M", "L", "wavelength", "X", "local", "hertz", "everywhere", "kind")
    return DataFrame({**{name: getattr(mark, name) for name in names}, **mark.ratio.columns()} for mark in marks)


def marks_table(heading: str, marks: Iterable[Mark]) -> DataFrame:
    """The marks as a table.  heading: of its first column, the kind."""
    return DataFrame({heading: mark.kind, **mark.cells_of_place()} for mark in marks)


def scatter(marks: Sequence[Mark], values: ArrayLike) -> str:
    """Deviation of marks from values of a curve, (n,): mean and root mean square, as a cell of a table."""
    off = np.array([mark.ratio.limit for mark in marks]) - np.asarray(values)
    return f"{off.mean():+.3f}, {np.sqrt(np.mean(off**2)):.3f}"


def scatter_cells(marks: Sequence[Mark], nabla2: Sequence[float], curves: Mapping[str, Curve]) -> dict[str, str]:
    """Deviation of marks from each of some curves, as cells of a table.  nabla2: of each mark."""
    return {name: scatter(marks, curve(nabla2)) for name, curve in curves.items()}


# -- Fig. 7 -----------------------------------------------------------------------------------------------------------


def shape_tasks(plan: Plan) -> list[Task]:
    """The runs of Fig. 7."""
    impacts = [runs.shapes_task(plan, case, nodes) for case in plan.beyond.shaped for nodes in plan.beyond.grids]
    return impacts + [
        runs.straight_task(kind, rolling, nodes)
        for rolling in plan.beyond.rolling
        for nodes in plan.beyond.rolling_grids
        for kind in ("transverse", "longitudinal")
    ]


def impacts_on_shapes(results: Results, plan: Plan) -> Iterator[Mark]:
    """The ratios in impacts."""
    for case, wavelengths in plan.beyond.shaped.items():
        grids = Grids(*(results[runs.shapes_task(plan, case, nodes).name] for nodes in plan.beyond.grids))
        for wavelength in wavelengths:
            across = grids.last_wave("transverse", case, "transverse", wavelength)
            yield across
            yield grids.last_wave("rings", case, "rings", wavelength)
            yield grids.ridges_at(case, wavelength, across.X)


def rolling_over_shapes(results: Results, plan: Plan) -> Iterator[Mark]:
    """The ratios in rolling."""
    for rolling in plan.beyond.rolling:
        M, L, wavelength = rolling
        for kind in ("transverse", "longitudinal"):
            values = [results[runs.straight_task(kind, rolling, nodes).name] for nodes in plan.beyond.rolling_grids]
            ratio = Extrapolated(*(float(np.ravel(value)[0]) for value in values))
            yield rolling_mark(kind, (M, L), wavelength, ratio)


def other_waves(results: Results, plan: Plan) -> Drawn:
    """Fig. 7: A_d/A_i of transverse, longitudinal and ring waviness, in impact (left) and rolling (right)."""
    impacts, rolled = list(impacts_on_shapes(results, plan)), list(rolling_over_shapes(results, plan))
    grids, rolling = plan.beyond.grids, plan.beyond.rolling_grids
    figure, panels = new_figure(1, 2)
    for axes, marks, title in zip(panels, (impacts, rolled), ("impact", "rolling"), strict=True):
        draw_curves(axes)
        draw_fit(axes, CURVES["(15), longitudinal"](RANGE), ":", "(15) of $e\\nabla_2$, longitudinal")
        draw_marks(axes, marks, OF_SHAPES)
        axes.set(xlabel="local $\\nabla_2$" if title == "impact" else "$\\nabla_2$", title=title)
    panels[0].legend(loc="lower left", frameon=False, fontsize="x-small")
    caption = (
        "Beyond the paper: waves of other shapes, as in Fig. 6.  Left, impact: the waves cos(2 pi X/Lambda) are "
        "transverse to the motion of the front along Y = 0.  Along X = 0 the front runs along their ridges, so that "
        "they are longitudinal; their amplitude is half the difference between crest and trough at the same radius, "
        "at the place of the last transverse wave.  The waves cos(2 pi r/Lambda) are rings with their crests parallel "
        "to the front.  Right, rolling: over transverse waves to first order in their height, over longitudinal "
        "waves steady.  Curves: (15), for isotropic and for transverse waves; (15) with e nabla2 instead of nabla2, "
        "for longitudinal waves; and the curve of transverse waves in a line contact.  Impact on "
        f"{grids[0]} and {grids[1]} nodes per side, rolling on {rolling[0]} and {rolling[1]}; extrapolation and error "
        "bars as in Fig. 6."
    )
    tables = {
        "Impact": marks_table("waves", impacts),
        "Rolling": marks_table("waves", rolled),
        "A_d/A_i minus the curve: mean, root mean square": _scatter_table(impacts, rolled),
    }
    return Drawn(figure, caption, {"impact": marks_data(impacts), "rolling": marks_data(rolled)}, tables)


def _scatter_table(impacts: Sequence[Mark], rolled: Sequence[Mark]) -> DataFrame:
    rows = []
    for kind in OF_SHAPES:
        hit = [mark for mark in impacts if mark.kind == kind]
        rolling = [mark for mark in rolled if mark.kind == kind]
        local, hertz = [mark.local for mark in hit], [mark.hertz for mark in hit]
        rows.append({"parameter": f"impact, {kind}, local nabla2", **scatter_cells(hit, local, CURVES)})
        rows.append({"parameter": f"impact, {kind}, momentary Hertz contact", **scatter_cells(hit, hertz, CURVES)})
        if rolling:
            cells = scatter_cells(rolling, [mark.local for mark in rolling], CURVES)
            rows.append({"parameter": f"rolling, {kind}", **cells})
    return DataFrame(rows)


# -- Fig. 8 -----------------------------------------------------------------------------------------------------------

Pair = tuple[Mark, Mark]  # with the usual oil and with another, at the same M, L and wavelength


def _oiled(plan: Plan) -> Iterator[tuple[Moes, str, Wavelengths]]:
    """M and L, oil and wavelengths of each impact; the isoviscous oil has L = 0."""
    for case, wavelengths in plan.beyond.oils.items():
        for oil in OILS:
            if oil != SOFT:
                yield case, oil, wavelengths
    for M, wavelengths in plan.beyond.soft.items():
        yield (M, 0), SOFT, wavelengths


def oil_tasks(plan: Plan) -> list[Task]:
    """The runs of Fig. 8."""
    return [runs.oil_task(*impact, nodes) for impact in _oiled(plan) for nodes in plan.beyond.grids]


def other_oils(results: Results, plan: Plan) -> Drawn:
    """Fig. 8: A_d/A_i of isotropic waviness in impacts with other oils; right: compared with the usual oil."""
    marks = []
    for case, oil, wavelengths in _oiled(plan):
        both = Grids(*(results[runs.oil_task(case, oil, wavelengths, nodes).name] for nodes in plan.beyond.grids))
        marks += [both.last_wave(oil, case, "isotropic", wavelength) for wavelength in wavelengths]
    usual = [mark for mark in marks if mark.kind == USUAL]
    pairs = [(one, mark) for one in usual for mark in marks if mark.kind != USUAL and mark.case == one.case]
    grids = plan.beyond.grids
    caption = (
        "Beyond the paper: other lubricants in the impacts of Fig. 6, isotropic waviness.  Right: A_d/A_i against that "
        "with Roelands' law and Dowson and Higginson's density, at the same M, L and wavelength.  For an isoviscous "
        "oil L = 0 and nabla2 is infinite.  As nabla2 is the wavelength divided by sqrt(L/M), the film at which a "
        "rigid ball stops, the abscissa is then the wavelength divided by the film that elasticity alone traps, 0.3135 "
        f"sqrt(lambda_bar); curve (15) does not hold there.  Grids of {grids[0]} and {grids[1]} nodes per side; "
        "extrapolation and error bars as in Fig. 6."
    )
    tables = {"Other oils": marks_table("oil", marks), f"Compared with {USUAL}": _pairs_table(pairs)}
    return Drawn(_draw_oils(marks, pairs), caption, {"oils": marks_data(marks)}, tables)


def _draw_oils(marks: Sequence[Mark], pairs: Sequence[Pair]) -> Figure:
    figure, (left, right) = new_figure(1, 2)
    draw_curves(left)
    draw_marks(left, marks, OF_OILS)
    left.set_xlabel("local $\\nabla_2$; isoviscous: $\\Lambda$ over the local trapped film")
    left.legend(loc="lower left", frameon=False, fontsize="x-small")
    for oil, (marker, colour) in OF_OILS.items():
        points = [(usual.ratio.limit, mark.ratio.limit) for usual, mark in pairs if mark.kind == oil]
        if points:
            right.plot(*zip(*points, strict=True), marker, color=colour, label=oil)
    right.plot([0, 1], [0, 1], color=plots.GREY, linewidth=0.8)
    right.set(xlim=(0, 1), ylim=(0, 1), xlabel=f"$A_d/A_i$, {USUAL}", ylabel="$A_d/A_i$, same $M, L, \\Lambda$")
    right.legend(loc="upper left", frameon=False, fontsize="x-small")
    return figure


def _pairs_table(pairs: Sequence[Pair]) -> DataFrame:
    return DataFrame(
        {
            "oil": mark.kind,
            **mark.cells(),
            f"A_d/A_i, {USUAL}": f"{usual.ratio.limit:.3f}",
            "A_d/A_i, this oil": f"{mark.ratio.limit:.3f}",
            "difference": f"{mark.ratio.limit - usual.ratio.limit:+.3f}",
        }
        for usual, mark in pairs
    )
