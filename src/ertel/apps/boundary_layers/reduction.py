"""Figure 6 of the paper: amplitude reduction in impact and in rolling, and the parameter that brings them together."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from pandas import DataFrame

from ertel import amplitude_reduction, plots, waves
from ertel.apps.boundary_layers import checks
from ertel.apps.boundary_layers.dots import (
    DRY,
    FILM,
    HALF_HERTZ,
    Dot,
    Rolled,
    Twin,
    curve_of,
    dots,
    rolled_over,
    scatter,
    twins_of,
)
from ertel.apps.boundary_layers.page import Drawn
from ertel.apps.boundary_layers.plans import Plan
from ertel.apps.boundary_layers.smooth import FORMED, Results, new_figure
from ertel.apps.boundary_layers.waves import check_tasks, impact_tasks, rolling_tasks, twin_tasks
from ertel.runs.tasks import Task

LINE_CONTACT = {
    "line contact (1997)": amplitude_reduction.LINE_1997,
    "line contact (later fit)": amplitude_reduction.LINE_REFIT,
}


def tasks(plan: Plan) -> list[Task]:
    """The runs of Fig. 6."""
    return [*impact_tasks(plan), *check_tasks(plan), *rolling_tasks(plan), *twin_tasks(plan)]


@dataclass(frozen=True)
class Found:
    """All that Fig. 6 shows.  own: the curve of the form of (15) through the rolling contacts."""

    impacts: list[Dot]
    rolled: list[Rolled]
    twins: list[Twin]
    own: waves.Reduction

    @property
    def last(self) -> list[Dot]:
        """The last complete waves."""
        return [dot for dot in self.impacts if dot.last]

    @property
    def inner(self) -> list[Dot]:
        """The waves further in, as far as there was a front."""
        return [dot for dot in self.impacts if not dot.last and dot.X > FORMED]


def reduction(results: Results, plan: Plan) -> Drawn:
    """Fig. 6: A_d/A_i of impact and of rolling against the local and the global nabla2, and the curve (15)."""
    impacts, rolled = list(dots(results, plan)), list(rolled_over(results, plan))
    found = Found(impacts, rolled, list(twins_of(impacts, results, plan)), curve_of(rolled))
    caption = (
        "Amplitude reduction.  Dots: last complete wave inside the contact at maximum impact, extrapolated from grids "
        f"of {plan.waves.grids[0]} and {plan.waves.grids[1]} nodes per side for a method of second order; the error "
        "bar reaches to the limit of a method of first order.  Horizontal bars on the left: range of nabla2 for three "
        f"speeds of the front at that place (front defined by the {FILM}, by {HALF_HERTZ}, and exact dry law).  "
        "Squares: rolling over the same waviness, at the centre of the contact, to first order in its height, "
        f"extrapolated from {plan.waves.rolling_grids[0]} and {plan.waves.rolling_grids[1]} nodes per side.  "
        "Solid line: eq. (15).  "
        "Grey: transverse waviness in a line contact, 1/(1 + 0.17 n + 0.03 n^2) of 1997 (dashed) and a later fit, "
        "1/(1 + 0.125 n + 0.04 n^2) (dotted), n = 0.608 nabla2.  "
        f"Dash-dotted: {_text(found.own)}, fitted to the squares.  Right: nabla2 with radius and pressure of the Hertz "
        "contact at the moment when the front passed, lambda_bar v/A^4, alpha_bar A, wavelength/A.  Crosses: rolling "
        "at exactly these parameters."
    )
    tables = {
        "Impact: last complete waves": _dots_table(found.last),
        "A_d/A_i minus the curve: mean, root mean square": _scatter_table(found),
        "Rolling at the parameters of the front": _twins_table(found.twins),
        "Rolling": _rolling_table(found.rolled),
        **checks.tables(results, plan),
    }
    data = {"impact": _impact_data(impacts), "rolling": _rolling_data(rolled)}
    return Drawn(_draw(found), caption, data, tables)


# -- the figure -------------------------------------------------------------------------------------------------------


def _draw(found: Found) -> Figure:
    figure, (left, middle, right) = new_figure(1, 3)
    for axes in (left, middle, right):
        draw_curves(axes)
        n = np.geomspace(0.3, 30, 200)
        axes.plot(
            n, found.own.ratio(n), color=plots.ORANGE, linewidth=1.0, linestyle="-.", label="fitted to the squares"
        )
        _draw_rolled(axes, found.rolled)
    ranges = [(min(dot.local.values()), max(dot.local.values())) for dot in found.last]
    _draw_dots(left, found.last, [dot.local[FILM] for dot in found.last], ranges)
    _draw_dots(middle, found.last, [dot.everywhere for dot in found.last])
    _draw_dots(right, found.last, [dot.hertz for dot in found.last])
    further = [dot.hertz for dot in found.inner], [dot.ratio.limit for dot in found.inner]
    crosses = [twin.nabla2 for twin in found.twins], [twin.rolling.limit for twin in found.twins]
    handles = right.plot(*further, ".", color=plots.GREY, markersize=3, label="impact, waves further in")
    handles += right.plot(*crosses, "x", color=plots.BLUE, label="rolling, parameters of the front")
    left.set_xlabel("local $\\nabla_2$, $\\bar\\lambda v$")
    middle.set_xlabel("global $\\nabla_2$ (rolling: its own)")
    right.set_xlabel("local $\\nabla_2$ with the momentary Hertz contact")
    left.legend(loc="lower left", frameon=False, fontsize="xx-small")
    right.legend(handles=handles, loc="lower left", frameon=False, fontsize="x-small")
    return figure


def draw_curves(axes: Axes) -> None:
    """Eq. (15) and the curves of the line contact, for nabla2 = 0.4 to 20."""
    n = np.geomspace(0.3, 30, 200)
    axes.semilogx(n, amplitude_reduction.ratio_left(n), color="black", label="(15), isotropic")
    for (name, coefficients), style in zip(LINE_CONTACT.items(), ("--", ":"), strict=True):
        line_contact = amplitude_reduction.in_line_contact(n, coefficients)
        axes.semilogx(n, line_contact, color=plots.GREY, linestyle=style, label=f"transverse, {name}")
    axes.set(ylim=(0, 1.1), xlim=(0.4, 20), ylabel="$A_d/A_i$")
    axes.set_xticks([0.5, 1, 2, 5, 10, 20], ["0.5", "1", "2", "5", "10", "20"])


def _draw_dots(
    axes: Axes, found: Sequence[Dot], nabla2: Sequence[float], ranges: Sequence[tuple[float, float]] = ()
) -> None:
    """Dots with error bars, one colour and marker for each (M, L); horizontal bars where ranges of nabla2 are given."""
    cases = list(dict.fromkeys((dot.M, dot.L) for dot in found))
    shades = plots.ORDERED_COLOURS(np.linspace(0.95, 0.0, len(cases)))
    for (M, L), colour, marker in zip(cases, shades, "ovD^P*<>", strict=False):
        own = [i for i, dot in enumerate(found) if (dot.M, dot.L) == (M, L)]
        place, ratios = [nabla2[i] for i in own], [found[i].ratio for i in own]
        limit, bar = [ratio.limit for ratio in ratios], [ratio.error for ratio in ratios]
        across = np.array([(nabla2[i] - ranges[i][0], ranges[i][1] - nabla2[i]) for i in own]).T if ranges else None
        label = f"impact, M = {M:g}, L = {L:g}"
        axes.errorbar(place, limit, bar, across, fmt=marker, color=colour, label=label, capsize=2, elinewidth=0.8)


def _draw_rolled(axes: Axes, rolled: Sequence[Rolled]) -> None:
    place, limit = [r.nabla2 for r in rolled], [r.ratio.limit for r in rolled]
    bar = [r.ratio.error for r in rolled]
    axes.errorbar(place, limit, bar, fmt="s", color="black", markerfacecolor="white", capsize=2, label="rolling")


# -- data -------------------------------------------------------------------------------------------------------------


def _impact_data(impacts: Sequence[Dot]) -> DataFrame:
    return DataFrame(
        {
            **{name: getattr(dot, name) for name in ("M", "L", "wavelength", "X")},
            "last": int(dot.last),
            "everywhere": dot.everywhere,
            "hertz": dot.hertz,
            **dot.ratio.columns(),
            **{f"local, {name}": nabla2 for name, nabla2 in dot.local.items()},
        }
        for dot in impacts
    )


def _rolling_data(rolled: Sequence[Rolled]) -> DataFrame:
    names = ("M", "L", "wavelength", "nabla2")
    return DataFrame({**{name: getattr(r, name) for name in names}, **r.ratio.columns()} for r in rolled)


# -- tables -----------------------------------------------------------------------------------------------------------


def _text(curve: waves.Reduction) -> str:
    return f"1/(1 + {curve.linear:.3f} nabla2 + {curve.quadratic:.4f} nabla2^2)"


def case_cells(M: float, L: float, wavelength: float) -> dict[str, str]:
    """The first cells of a row."""
    return {"M": f"{M:g}", "L": f"{L:g}", "wavelength": f"{wavelength:g}"}


def _dots_table(found: Sequence[Dot]) -> DataFrame:
    return DataFrame(
        {
            **case_cells(dot.M, dot.L, dot.wavelength),
            "X": f"{dot.X:.3f}",
            **dot.ratio.cells(),
            "nabla2 local": f"{dot.local[FILM]:.2f}",
            "momentary Hertz contact": f"{dot.hertz:.2f}",
            "global": f"{dot.everywhere:.2f}",
            "(15) of local": f"{float(amplitude_reduction.ratio_left(dot.local[FILM])):.3f}",
        }
        for dot in found
    )


PARAMETERS: Mapping[str, Callable[[Dot], float]] = {
    f"local nabla2, speed by {FILM}": lambda dot: dot.local[FILM],
    f"local nabla2, speed by {HALF_HERTZ}": lambda dot: dot.local[HALF_HERTZ],
    f"local nabla2, speed by {DRY}": lambda dot: dot.local[DRY],
    "local nabla2, momentary Hertz contact": lambda dot: dot.hertz,
    "global nabla2": lambda dot: dot.everywhere,
}


def _scatter_table(found: Found) -> DataFrame:
    """Deviation of impact and rolling from the curves, for each parameter."""
    rows = []
    for name, chosen in {"last waves": found.last, f"waves further in, X > {FORMED:g}": found.inner}.items():
        known = [dot for dot in chosen if np.isfinite(list(dot.local.values())).all()]
        for kind, nabla2 in PARAMETERS.items() if known else ():
            cells = _about([dot.ratio.limit for dot in known], [nabla2(dot) for dot in known], found.own)
            rows.append({"parameter": f"impact, {name} ({len(known)}), {kind}", **cells})
    cells = _about([r.ratio.limit for r in found.rolled], [r.nabla2 for r in found.rolled], found.own)
    return DataFrame([*rows, {"parameter": "rolling", **cells}])


def _about(values: Sequence[float], nabla2: Sequence[float], own: waves.Reduction) -> dict[str, str]:
    curves = {
        "isotropic (15)": amplitude_reduction.ratio_left(nabla2),
        **{name: amplitude_reduction.in_line_contact(nabla2, c) for name, c in LINE_CONTACT.items()},
        "fitted to rolling": own.ratio(nabla2),
    }
    return {name: scatter(values, curve).text() for name, curve in curves.items()}


def _twins_table(twins: Sequence[Twin]) -> DataFrame:
    rows = [
        {
            **case_cells(twin.M, twin.L, twin.wavelength),
            "X": f"{twin.X:.3f}",
            "nabla2": f"{twin.nabla2:.2f}",
            "impact at X": twin.impact.text(),
            "rolling": twin.rolling.text(),
            "impact minus rolling": f"{twin.impact.limit - twin.rolling.limit:+.3f}",
        }
        for twin in twins
    ]
    off = scatter([twin.impact.limit for twin in twins], np.array([twin.rolling.limit for twin in twins]))
    total = {"M": "mean, root mean square", "impact minus rolling": off.text()}
    return DataFrame([*rows, total]).fillna("")


def _rolling_table(rolled: Sequence[Rolled]) -> DataFrame:
    return DataFrame(
        {
            **case_cells(r.M, r.L, r.wavelength),
            "nabla2": f"{r.nabla2:.2f}",
            **r.ratio.cells(),
            "(15)": f"{float(amplitude_reduction.ratio_left(r.nabla2)):.3f}",
        }
        for r in rolled
    )
