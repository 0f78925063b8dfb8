"""Figure 9, beyond the paper: films of starved impacts and of starved rolling against the oil that is offered.

R is the oil in the centre over that of the flooded contact, an impact's at maximum approach, and r the layer over the
same.  Each kind of contact is compared with R = r/(1 + r^g)^(1/g), `film_formulas.starved_share`.
"""

from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, NullLocator
from pandas import DataFrame
from scipy.optimize import least_squares

from ertel import formulas, parse_case, plots, simulate
from ertel.apps.boundary_layers.plans import Drawn, Moes, Plan, new_figure
from ertel.apps.boundary_layers.ratios import Extrapolated
from ertel.apps.boundary_layers.runs import Results
from ertel.runs.tasks import Task

RATIOS = (0.25, 0.5, 0.7, 1.0, 1.5, 2.0, 4.0)  # r
HALF_WIDTH = 3.0  # a*, of the impacts: the thickest layer leaves the edge dry
MARKERS = "ovD^P*<>"
Curve = Mapping[str, tuple[float, float, float]]  # by kind of contact: g, its standard error, largest deviation of R


def starved_films(kind: str, M: float, L: float, nodes: int) -> tuple[float, ...]:
    """R at each of `RATIOS`, of an impact by the radial method or of steady rolling; RuntimeError where one fails."""
    solver = {"method": "radial", "half_width": HALF_WIDTH} if kind == "impact" else {"method": "steady"}
    data = {"contact": {"kind": kind, "M": M, "L": L}, "solver": {**solver, "nodes": nodes}}

    def oil_in_centre(layer: Mapping[str, float]) -> float:
        case = parse_case({**data, "lubricant": layer})
        result = simulate(case)
        if not result.status.ok:
            raise RuntimeError(f"{kind}, M = {M:g}, L = {L:g}, {layer}: {result.status.value}; {result.status.advice}")
        return float(case.lubricant.density(result.summary["P_c"]) * result.summary["H_c"])

    flooded = oil_in_centre({})
    return tuple(oil_in_centre({"layer": r * flooded}) / flooded for r in RATIOS)


def tasks(plan: Plan) -> list[Task]:
    """The contacts of Fig. 9, each on two grids."""
    return [_task(kind, case, nodes, plan) for kind, case in _contacts(plan) for nodes in plan.starved.grids]


def _contacts(plan: Plan) -> Iterator[tuple[str, Moes]]:
    for kind, cases in plan.starved.contacts.items():
        yield from ((kind, case) for case in cases)


def _task(kind: str, case: Moes, nodes: int, plan: Plan) -> Task:
    M, L = case
    name = f"starved_{kind}_M{M:g}_L{L:g}_{nodes}"
    return Task(name, starved_films, (kind, float(M), float(L), nodes), plan.starved.seconds)


class Mark(NamedTuple):
    """A contact, and its R at each r."""

    kind: str
    case: Moes
    shares: tuple[Extrapolated, ...]


def starved(results: Results, plan: Plan) -> Drawn:
    """Fig. 9."""
    marks = []
    for kind, case in _contacts(plan):
        grids = [results[_task(kind, case, nodes, plan).name] for nodes in plan.starved.grids]
        marks.append(Mark(kind, case, tuple(Extrapolated(*pair) for pair in zip(*grids, strict=True))))
    fits = {kind: _fit([mark for mark in marks if mark.kind == kind]) for kind in plan.starved.contacts}
    coarse, fine = plan.starved.grids
    caption = (
        "Beyond the paper: a starved impact follows a curve like that of starved rolling.  R is the oil in the centre "
        "over that of the flooded contact, r the layer of oil over the same.  Left: all contacts, with "
        "R = r/(1 + r^g)^(1/g) and g fitted to each kind.  Right: their difference.  Values of the finer grid; bars: "
        f"difference of the two grids, of {coarse} and {fine} nodes.  Curve: {formulas.SOURCES['Chevalier et al.']}, "
        "g of circular contacts in the literature: 2 to 5."
    )
    rows = [
        {"contact": kind, "g": f"{g:.2f}", "standard error": f"{error:.2f}", "largest difference": f"{largest:.3f}"}
        for kind, (g, error, largest) in fits.items()
    ]
    table = DataFrame({**_named(mark), **_cells(mark)} for mark in marks)
    data = DataFrame(
        {**_named(mark), "r": r, "R": share.fine, "coarse grid": share.coarse}
        for mark in marks
        for r, share in zip(RATIOS, mark.shares, strict=True)
    )
    tables = {"Exponents of the curve": DataFrame(rows), "R by r (difference of the two grids)": table}
    return Drawn(_draw(marks, fits), caption, {"starved": data}, tables)


def _named(mark: Mark) -> dict[str, str]:
    return {"contact": mark.kind, "M": f"{mark.case[0]:g}", "L": f"{mark.case[1]:g}"}


def _cells(mark: Mark) -> dict[str, str]:
    pairs = zip(RATIOS, mark.shares, strict=True)
    return {f"{r:g}": f"{share.fine:.4f} ({share.fine - share.coarse:+.4f})" for r, share in pairs}


def _fit(marks: list[Mark]) -> tuple[float, float, float]:
    """The exponent that fits best, its standard error, and the largest difference."""
    found = np.array([[share.fine for share in mark.shares] for mark in marks])

    def differences(g: np.ndarray) -> np.ndarray:
        curve = np.array([formulas.starved_share(r, float(g[0])) for r in RATIOS])
        return np.asarray(found - curve).ravel()

    fit = least_squares(differences, 2.5)
    variance = float(np.sum(fit.fun**2)) / (found.size - 1) / float(np.sum(fit.jac**2))
    return float(fit.x[0]), float(np.sqrt(variance)), float(np.abs(fit.fun).max())


def _draw(marks: list[Mark], fits: Curve) -> Figure:
    figure, (left, right) = new_figure(1, 2)
    line = np.geomspace(RATIOS[0] / 1.5, RATIOS[-1] * 1.5)
    for style, (kind, (g, _, _)) in zip(("-", "--"), fits.items(), strict=True):
        curve = [formulas.starved_share(r, g) for r in line]
        left.loglog(line, curve, style, color=plots.GREY, linewidth=0.9, label=f"{kind}: $\\gamma$ = {g:.2f}")
    left.loglog(line, np.minimum(line, 1.0), ":", color="black", linewidth=0.7)
    shades = iter(plots.ORDERED_COLOURS(np.linspace(0.9, 0.1, len(marks))))
    for mark, marker in zip(marks, MARKERS * len(marks), strict=False):
        colour = next(shades) if mark.kind == "impact" else plots.ORANGE
        look: dict[str, Any] = {"marker": marker, "color": colour, "linestyle": "none", "markersize": 5}
        look |= {"markerfacecolor": "white"} if mark.kind == "rolling" else {}
        label = f"{mark.kind}, M = {mark.case[0]:g}, L = {mark.case[1]:g}"
        found, bars = [share.fine for share in mark.shares], [abs(s.fine - s.coarse) for s in mark.shares]
        left.loglog(RATIOS, found, label=label, **look)
        curve = [formulas.starved_share(r, fits[mark.kind][0]) for r in RATIOS]
        right.errorbar(RATIOS, np.subtract(found, curve), bars, capsize=2, elinewidth=0.8, **look)
    right.axhline(0.0, color=plots.GREY, linewidth=0.8)
    right.set(xscale="log", ylabel="$R$ less the curve of its kind", xlabel="$r$")
    left.set(xlabel="$r$, layer over the oil of the flooded film", ylabel="$R$, film over the flooded one")
    for axis in (left.xaxis, left.yaxis, right.xaxis):
        axis.set_minor_locator(NullLocator())
        axis.set_major_formatter("{x:g}")
        axis.set_major_locator(FixedLocator([0.25, 0.5, 1.0, 2.0, 4.0]))
    left.legend(loc="lower right", frameon=False, fontsize="xx-small")
    return figure
