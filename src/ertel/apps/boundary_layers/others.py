"""Beyond the paper: Fig. 7, waves of other shapes in impact and rolling, and Fig. 8, impacts with other lubricants."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from math import inf

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import ArrayLike
from pandas import DataFrame

from ertel import amplitude_reduction, plots
from ertel.apps.boundary_layers import ratios, runs
from ertel.apps.boundary_layers.page import Drawn, new_figure
from ertel.apps.boundary_layers.plans import Moes, Plan, Wavelengths
from ertel.apps.boundary_layers.ratios import Extrapolated, Grids, Mark, Values
from ertel.apps.boundary_layers.runs import OILS, SOFT, USUAL, Results
from ertel.runs.tasks import Task

CURVES: Mapping[str, Callable[[ArrayLike], Values]] = {
    "(15), isotropic": amplitude_reduction.ratio_left,
    "line contact": amplitude_reduction.in_line_contact,
    "(15), longitudinal": lambda nabla2: amplitude_reduction.ratio_left(nabla2, inf),
}
OF_SHAPES = {"transverse": ("o", plots.BLUE), "rings": ("D", plots.GREEN), "longitudinal": ("^", plots.ORANGE)}
OF_OILS = dict(zip(OILS, (("o", "black"), ("s", plots.BLUE), ("D", plots.GREEN), ("^", plots.ORANGE)), strict=True))


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
            yield ratios.rolling_mark(kind, (M, L), wavelength, ratio)


def other_waves(results: Results, plan: Plan) -> Drawn:
    """Fig. 7: A_d/A_i of transverse, longitudinal and ring waviness, in impact (left) and rolling (right)."""
    impacts, rolled = list(impacts_on_shapes(results, plan)), list(rolling_over_shapes(results, plan))
    grids, rolling = plan.beyond.grids, plan.beyond.rolling_grids
    figure, panels = new_figure(1, 2)
    for axes, marks, title in zip(panels, (impacts, rolled), ("impact", "rolling"), strict=True):
        ratios.draw_curves(axes)
        ratios.draw_fit(axes, CURVES["(15), longitudinal"](ratios.RANGE), ":", "(15) of $e\\nabla_2$, longitudinal")
        ratios.draw_marks(axes, marks, OF_SHAPES)
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
        "Impact": ratios.marks_table("waves", impacts),
        "Rolling": ratios.marks_table("waves", rolled),
        "A_d/A_i minus the curve: mean, root mean square": _scatter_table(impacts, rolled),
    }
    return Drawn(figure, caption, {"impact": ratios.marks_data(impacts), "rolling": ratios.marks_data(rolled)}, tables)


def _scatter_table(impacts: Sequence[Mark], rolled: Sequence[Mark]) -> DataFrame:
    rows = []
    for kind in OF_SHAPES:
        own = [mark for mark in impacts if mark.kind == kind]
        rolling = [mark for mark in rolled if mark.kind == kind]
        rows.append({"parameter": f"impact, {kind}, local nabla2", **_about(own, [m.local for m in own])})
        rows.append({"parameter": f"impact, {kind}, momentary Hertz contact", **_about(own, [m.hertz for m in own])})
        if rolling:
            rows.append({"parameter": f"rolling, {kind}", **_about(rolling, [m.local for m in rolling])})
    return DataFrame(rows)


def _about(marks: Sequence[Mark], nabla2: Sequence[float]) -> dict[str, str]:
    return {name: ratios.scatter(marks, curve(nabla2)) for name, curve in CURVES.items()}


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
    tables = {"Other oils": ratios.marks_table("oil", marks), f"Compared with {USUAL}": _pairs_table(pairs)}
    return Drawn(_draw_oils(marks, pairs), caption, {"oils": ratios.marks_data(marks)}, tables)


def _draw_oils(marks: Sequence[Mark], pairs: Sequence[Pair]) -> Figure:
    figure, (left, right) = new_figure(1, 2)
    ratios.draw_curves(left)
    ratios.draw_marks(left, marks, OF_OILS)
    left.set_xlabel("local $\\nabla_2$; isoviscous: $\\Lambda$ over the local trapped film")
    left.legend(loc="lower left", frameon=False, fontsize="x-small")
    for oil, (marker, colour) in OF_OILS.items():
        own = [(usual.ratio.limit, mark.ratio.limit) for usual, mark in pairs if mark.kind == oil]
        if own:
            right.plot(*zip(*own, strict=True), marker, color=colour, label=oil)
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
