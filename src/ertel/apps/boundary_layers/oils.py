"""Beyond the paper, figure 8: isotropic waviness in impacts with other lubricants."""

from collections.abc import Iterator, Sequence

from matplotlib.figure import Figure
from pandas import DataFrame

from ertel import plots
from ertel.apps.boundary_layers.beyond import (
    OILS,
    SOFT,
    USUAL,
    Grids,
    Mark,
    draw_marks,
    last_waves,
    marks_data,
    marks_table,
    shaped_name,
    shaped_tasks,
)
from ertel.apps.boundary_layers.page import Drawn
from ertel.apps.boundary_layers.plans import Moes, Plan, Wavelengths
from ertel.apps.boundary_layers.reduction import case_cells, draw_curves
from ertel.apps.boundary_layers.smooth import Results, new_figure
from ertel.runs.tasks import Task

STYLES = dict(zip(OILS, (("o", "black"), ("s", plots.BLUE), ("D", plots.GREEN), ("^", plots.ORANGE)), strict=True))
Pair = tuple[Mark, Mark]  # with the usual oil and with another, at the same M, L and wavelength


def oiled(plan: Plan) -> Iterator[tuple[Moes, str, Wavelengths]]:
    """M and L, oil and wavelengths of each impact; the isoviscous oil has L = 0."""
    for case, wavelengths in plan.beyond.oils.items():
        for oil in OILS:
            if oil != SOFT:
                yield case, oil, wavelengths
    for M, wavelengths in plan.beyond.soft.items():
        yield (M, 0), SOFT, wavelengths


def tasks(plan: Plan) -> list[Task]:
    """The runs of Fig. 8."""
    return [
        task
        for case, oil, wavelengths in oiled(plan)
        for task in shaped_tasks(oil, case, [("isotropic", w) for w in wavelengths], plan.beyond.grids, oil)
    ]


def oil_marks(results: Results, plan: Plan) -> Iterator[Mark]:
    """The ratios A_d/A_i with each oil."""
    for case, oil, wavelengths in oiled(plan):
        grids = Grids(*(results[shaped_name(oil, *case, nodes)] for nodes in plan.beyond.grids))
        for wavelength in wavelengths:
            yield last_waves(oil, case, "isotropic", wavelength, grids)


def other_oils(results: Results, plan: Plan) -> Drawn:
    """Fig. 8: A_d/A_i of isotropic waviness in impacts with other oils; right: compared with the usual oil."""
    marks = list(oil_marks(results, plan))
    pairs, grids = list(_pairs(marks)), plan.beyond.grids
    caption = (
        "Beyond the paper: other lubricants in the impacts of Fig. 6, isotropic waviness.  Right: A_d/A_i against that "
        "with Roelands' law and Dowson and Higginson's density, at the same M, L and wavelength.  For an isoviscous "
        "oil L = 0 and nabla2 is infinite.  As nabla2 is the wavelength divided by sqrt(L/M), the film at which a "
        "rigid ball stops, the abscissa is then the wavelength divided by the film that elasticity alone traps, 0.3135 "
        f"sqrt(lambda_bar); curve (15) does not hold there.  Grids of {grids[0]} and {grids[1]} nodes per side; "
        "extrapolation and error bars as in Fig. 6."
    )
    tables = {"Other oils": marks_table("oil", marks), f"Compared with {USUAL}": _pairs_table(pairs)}
    return Drawn(_draw(marks, pairs), caption, {"oils": marks_data(marks)}, tables)


def _draw(marks: Sequence[Mark], pairs: Sequence[Pair]) -> Figure:
    figure, (left, right) = new_figure(1, 2)
    draw_curves(left)
    draw_marks(left, marks, STYLES)
    left.set_xlabel("local $\\nabla_2$; isoviscous: $\\Lambda$ over the local trapped film")
    left.legend(loc="lower left", frameon=False, fontsize="x-small")
    for oil, (marker, colour) in STYLES.items():
        own = [(usual.ratio.limit, mark.ratio.limit) for usual, mark in pairs if mark.kind == oil]
        if own:
            right.plot(*zip(*own, strict=True), marker, color=colour, label=oil)
    right.plot([0, 1], [0, 1], color=plots.GREY, linewidth=0.8)
    right.set(xlim=(0, 1), ylim=(0, 1), xlabel=f"$A_d/A_i$, {USUAL}", ylabel="$A_d/A_i$, same $M, L, \\Lambda$")
    right.legend(loc="upper left", frameon=False, fontsize="x-small")
    return figure


def _pairs(marks: Sequence[Mark]) -> Iterator[Pair]:
    for usual in (mark for mark in marks if mark.kind == USUAL):
        for mark in marks:
            if mark.kind != USUAL and mark.case == usual.case:
                yield usual, mark


def _pairs_table(pairs: Sequence[Pair]) -> DataFrame:
    return DataFrame(
        {
            "oil": mark.kind,
            **case_cells(*mark.case),
            f"A_d/A_i, {USUAL}": f"{usual.ratio.limit:.3f}",
            "A_d/A_i, this oil": f"{mark.ratio.limit:.3f}",
            "difference": f"{mark.ratio.limit - usual.ratio.limit:+.3f}",
        }
        for usual, mark in pairs
    )
