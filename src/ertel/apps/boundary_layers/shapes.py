"""Beyond the paper, figure 7: transverse, longitudinal and ring waviness in impact and in rolling."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from math import inf

import numpy as np
import xarray as xr
from matplotlib.figure import Figure
from numpy.typing import ArrayLike
from pandas import DataFrame

from ertel import Case, Parameters, amplitude_reduction, parse_case, plots, simulate
from ertel.apps.boundary_layers.beyond import (
    Grids,
    Mark,
    draw_marks,
    last_waves,
    marks_data,
    marks_table,
    ridges_at,
    shaped_name,
    shaped_tasks,
)
from ertel.apps.boundary_layers.dots import Extrapolated, scatter
from ertel.apps.boundary_layers.page import Drawn
from ertel.apps.boundary_layers.plans import Plan, rolling_seconds
from ertel.apps.boundary_layers.reduction import draw_curves
from ertel.apps.boundary_layers.smooth import Results, Values, new_figure
from ertel.apps.boundary_layers.waves import HEIGHT, rolling_response
from ertel.runs.tasks import Task

STYLES = {"transverse": ("o", plots.BLUE), "rings": ("D", plots.GREEN), "longitudinal": ("^", plots.ORANGE)}
CURVES: Mapping[str, Callable[[ArrayLike], Values]] = {
    "(15), isotropic": amplitude_reduction.ratio_left,
    "line contact": amplitude_reduction.in_line_contact,
    "(15), longitudinal": lambda nabla2: amplitude_reduction.ratio_left(nabla2, inf),
}

# -- runs -------------------------------------------------------------------------------------------------------------


def ridged_rolling(M: float, L: float, wavelength: float, nodes: int) -> float:
    """A_d/A_i of longitudinal ridges under rolling: half the difference in dH between the central crest and a trough.

    Such ridges do not change along their direction of motion, so that the contact is steady.  Raises RuntimeError where
    a run fails.
    """
    solver = {"method": "steady", "nodes": nodes, "half_width": 1.75, "inlet": 2.25}
    source = {"contact": {"kind": "rolling", "M": M, "L": L}, "solver": solver}
    smooth = parse_case(source)
    height = HEIGHT * smooth.film_scale
    ridges = {"shape": "waviness", "amplitude": height, "wavelength_y": wavelength}
    change = _film_across(parse_case({**source, "roughness": [ridges]})) - _film_across(smooth)
    crest, trough = change.interp(Y=[0.0, wavelength / 2], method="cubic").values
    return float(abs(trough - crest)) / (2 * height)


def _film_across(case: Case) -> xr.DataArray:
    """The steady film along X = 0."""
    result = simulate(case)
    if not result.status.ok:
        p = case.parameters
        raise RuntimeError(f"rolling over ridges, M = {p.M:g}, L = {p.L:g}: {result.status.value}")
    return result.dataset["H"].squeeze().sel(X=0.0, method="nearest").drop_vars("X")


def transverse_name(M: float, L: float, wavelength: float, nodes: int) -> str:
    """Name of the task that is a `rolling_response` to transverse waves."""
    return f"transverse_M{M:g}_L{L:g}_{wavelength:g}_{nodes}"


def ridges_name(M: float, L: float, wavelength: float, nodes: int) -> str:
    """Name of the task that is a `ridged_rolling`."""
    return f"ridges_M{M:g}_L{L:g}_{wavelength:g}_{nodes}"


def tasks(plan: Plan) -> list[Task]:
    """The runs of Fig. 7."""
    found = []
    for case, wavelengths in plan.beyond.shaped.items():
        shapes = [(shape, wavelength) for wavelength in wavelengths for shape in ("transverse", "rings")]
        found += shaped_tasks("shapes", case, shapes, plan.beyond.grids)
    for rolling in plan.beyond.rolling:
        for nodes in plan.beyond.rolling_grids:
            M, L, wavelength = rolling
            seconds = rolling_seconds(1, nodes)
            transverse = M, L, (wavelength,), nodes, inf
            found.append(Task(transverse_name(*rolling, nodes), rolling_response, transverse, seconds))
            found.append(Task(ridges_name(*rolling, nodes), ridged_rolling, (*rolling, nodes), seconds))
    return found


# -- ratios -----------------------------------------------------------------------------------------------------------


def shaped_marks(results: Results, plan: Plan) -> Iterator[Mark]:
    """The impacts."""
    for case, wavelengths in plan.beyond.shaped.items():
        grids = Grids(*(results[shaped_name("shapes", *case, nodes)] for nodes in plan.beyond.grids))
        for wavelength in wavelengths:
            across = last_waves("transverse", case, "transverse", wavelength, grids)
            yield across
            yield last_waves("rings", case, "rings", wavelength, grids)
            yield ridges_at(case, wavelength, across.X, grids)


def rolled_marks(results: Results, plan: Plan) -> Iterator[Mark]:
    """The rolling contacts."""
    for M, L, wavelength in plan.beyond.rolling:
        nabla2 = Parameters.from_moes(M, L).nabla2(wavelength)
        across = [results[transverse_name(M, L, wavelength, nodes)] for nodes in plan.beyond.rolling_grids]
        along = [results[ridges_name(M, L, wavelength, nodes)] for nodes in plan.beyond.rolling_grids]
        ratios = {"transverse": Extrapolated(*(ratio for (ratio,) in across)), "longitudinal": Extrapolated(*along)}
        for kind, ratio in ratios.items():
            yield Mark(kind, M, L, wavelength, 0.0, ratio, nabla2, nabla2, nabla2)


# -- Fig. 7 -----------------------------------------------------------------------------------------------------------


def other_waves(results: Results, plan: Plan) -> Drawn:
    """Fig. 7: A_d/A_i of transverse, longitudinal and ring waviness, in impact (left) and rolling (right)."""
    impacts, rolled = list(shaped_marks(results, plan)), list(rolled_marks(results, plan))
    grids, rolling = plan.beyond.grids, plan.beyond.rolling_grids
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
    data = {"impact": marks_data(impacts), "rolling": marks_data(rolled)}
    return Drawn(_draw(impacts, rolled), caption, data, tables)


def _draw(impacts: Sequence[Mark], rolled: Sequence[Mark]) -> Figure:
    figure, (left, right) = new_figure(1, 2)
    n = np.geomspace(0.3, 30, 200)
    longitudinal = CURVES["(15), longitudinal"](n)
    for axes, marks in {left: impacts, right: rolled}.items():
        draw_curves(axes)
        axes.plot(
            n,
            longitudinal,
            color=plots.ORANGE,
            linewidth=1.0,
            linestyle=":",
            label="(15) of $e\\nabla_2$, longitudinal",
        )
        draw_marks(axes, marks, STYLES)
    left.set(xlabel="local $\\nabla_2$", title="impact")
    right.set(xlabel="$\\nabla_2$", title="rolling")
    left.legend(loc="lower left", frameon=False, fontsize="x-small")
    return figure


def _scatter_table(impacts: Sequence[Mark], rolled: Sequence[Mark]) -> DataFrame:
    rows = []
    for kind in STYLES:
        own = [mark for mark in impacts if mark.kind == kind]
        rolling = [mark for mark in rolled if mark.kind == kind]
        rows.append({"parameter": f"impact, {kind}, local nabla2", **_about(own, [m.local for m in own])})
        rows.append({"parameter": f"impact, {kind}, momentary Hertz contact", **_about(own, [m.hertz for m in own])})
        if rolling:
            rows.append({"parameter": f"rolling, {kind}", **_about(rolling, [m.local for m in rolling])})
    return DataFrame(rows)


def _about(marks: Sequence[Mark], nabla2: Sequence[float]) -> dict[str, str]:
    ratios = [mark.ratio.limit for mark in marks]
    return {name: scatter(ratios, curve(nabla2)).text() for name, curve in CURVES.items()}
