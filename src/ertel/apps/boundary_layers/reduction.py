"""Figures 5 and 6 of the paper: waves in an impact, and amplitude reduction in impact and in rolling.

The checks of Fig. 6: A_d/A_i does not depend on the height of the waves, and hardly on the time steps.  In rolling it
is computed without time steps; time steps over waves of finite height lead to the same value.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from pandas import DataFrame

from ertel import Parameters, amplitude_reduction, fronts, hertz, plots, waves
from ertel.apps.boundary_layers import ratios, runs
from ertel.apps.boundary_layers.plans import FORMED, FRONTS, Drawn, Moes, Plan, new_figure
from ertel.apps.boundary_layers.ratios import Extrapolated, Grids, Mark, scatter_cells
from ertel.apps.boundary_layers.runs import HEIGHT, Results
from ertel.runs.tasks import Task

FILM, HALF_HERTZ, DRY = FRONTS["film"], FRONTS["half-hertz"], "dry law"  # the speeds of the front
SMALLEST_ERROR = 0.01  # of a ratio, in the fit: no ratio counts as more accurate
EDGE = 1.0  # a*: of the contact, in the checks


def tasks(plan: Plan) -> list[Task]:
    """The runs of Fig. 6."""
    twins = [runs.twin_task(twin, nodes) for twin in plan.waves.twins for nodes in plan.waves.twin_grids]
    return [*runs.waves_tasks(plan), *runs.check_tasks(plan).values(), *runs.rolling_tasks(plan), *twins]


# -- Fig. 5 -----------------------------------------------------------------------------------------------------------


def deformed_waves(results: Results, plan: Plan) -> Drawn:
    """Fig. 5: dH(X, 0)/A_i at maximum impact, inside and outside the contact."""
    (M, L), nodes = plan.waves.shown, plan.waves.grids[1]
    wavelengths = plan.waves.impacts[M, L]
    fine = results[runs.waves_task(plan, (M, L), nodes).name]
    edge = float(fronts.front(results[runs.radial_task(M, L, plan).name]).A[-1])
    figure, panels = new_figure(len(wavelengths), 1)
    figure.set_size_inches(8.0, 2.4 * len(wavelengths))
    columns, rows = {"X": fine["X"].values, "H": fine["H"].values}, []
    for wavelength, axes in zip(wavelengths, panels, strict=True):
        response = fine.sel(wave=runs.wave_name("isotropic", HEIGHT, wavelength))
        wave = waves.last_wave(response["X"].values, response["dH"].values, edge)
        _draw_waves(axes, response, wave, edge)
        axes.set_ylabel(f"$\\Lambda$ = {wavelength:g}")
        columns[f"dH/A_i, wavelength {wavelength:g}"] = response["dH"].values
        rows.append({"wavelength (a*)": f"{wavelength:g}", "X": f"{wave.X:.3f}", "A_d/A_i": f"{wave.amplitude:.3f}"})
    panels[0].legend(loc="lower left", frameon=True, fontsize="x-small", ncols=3)
    panels[-1].set_xlabel("$X$ ($a^*$)")
    caption = (
        f"dH(X, 0)/A_i at maximum impact, M = {M:g}, L = {L:g}, roughness A_i cos(2 pi X/Lambda) cos(2 pi Y/Lambda) "
        f"with a crest at the centre, A_i = {HEIGHT} sqrt(L/M), {nodes} nodes per side.  The vertical lines mark the "
        "minimum film.  The deformation of the waves rises with their distance from the centre and with their "
        "wavelength, and the waves are shifted outwards.  Outside the contact they keep their amplitude."
    )
    tables = {f"Last complete waves, {nodes} nodes per side": DataFrame(rows)}
    return Drawn(figure, caption, {"dH": DataFrame(columns)}, tables)


def _draw_waves(axes: Axes, response: xr.Dataset, wave: waves.Wave, edge: float) -> None:
    X, shape = response["X"].values, -response["shape"].values
    axes.plot(X, shape, color=plots.GREY, linewidth=0.7, linestyle=":", label="undeformed: $-\\mathcal{R}/A_i$")
    axes.plot(X, response["dH"].values, color=plots.BLUE, label="$dH/A_i$")
    axes.axvspan(wave.start, wave.end, color=plots.ORANGE, alpha=0.2, label="last complete wave")
    for side in (-edge, edge):
        axes.axvline(side, color="black", linewidth=0.7)
    axes.set(xlim=(-runs.HALF_WIDTH, runs.HALF_WIDTH), ylim=(-1.15, 1.15))


# -- Fig. 6 -----------------------------------------------------------------------------------------------------------


class Dot(NamedTuple):
    """One wave in an impact.  local: nabla2 by the speed of the front, for FILM, HALF_HERTZ and DRY."""

    mark: Mark
    local: Mapping[str, float]
    last: bool


class Twin(NamedTuple):
    """An impact's wave, and rolling at the parameters of the front as it passed there."""

    impact: Mark
    nabla2: float
    rolling: Extrapolated


@dataclass(frozen=True)
class Ratios:
    """The content of Fig. 6.  fitted: the curve of the form of (15) through the rolling contacts."""

    impacts: list[Dot]
    rolled: list[Mark]
    twins: list[Twin]
    fitted: waves.Reduction

    @property
    def last(self) -> list[Dot]:
        """The last complete waves."""
        return [dot for dot in self.impacts if dot.last]

    @property
    def inner(self) -> list[Dot]:
        """The waves further in, as far as there was a front."""
        return [dot for dot in self.impacts if not dot.last and dot.mark.X > FORMED]


def find_ratios(results: Results, plan: Plan) -> Ratios:
    """The ratios of impacts, of rolling contacts and of the rolling twins."""
    impacts = [dot for case in plan.waves.impacts for dot in _dots(results, plan, case)]
    rolled = list(_rolled(results, plan))
    errors = [max(mark.ratio.error, SMALLEST_ERROR) for mark in rolled]
    fitted = waves.fit_reduction([mark.local for mark in rolled], [mark.ratio.limit for mark in rolled], errors)
    return Ratios(impacts, rolled, list(_twins([dot.mark for dot in impacts], results, plan)), fitted)


def _dots(results: Results, plan: Plan, case: Moes) -> Iterator[Dot]:
    """Each complete wave inside the contact, from the centre outwards."""
    smooth = results[runs.radial_task(*case, plan).name]
    front, by_pressure = fronts.front(smooth), fronts.front(smooth, "half-hertz")
    grids = Grids(*(results[runs.waves_task(plan, case, nodes).name] for nodes in plan.waves.grids))
    p = Parameters.from_moes(*case)
    for wavelength in plan.waves.impacts[case]:
        inside = [waves.waves(X, dH, float(front.A[-1])) for X, dH in grids.responses("isotropic", wavelength)]
        pairs = list(zip(*(on_a_grid[::-1] for on_a_grid in inside), strict=False))  # from the edge inwards
        for number, (coarse, fine) in reversed(list(enumerate(pairs))):
            ratio = Extrapolated(coarse.amplitude, fine.amplitude)
            mark = ratios.impact_mark("impact", case, wavelength, fine.X, ratio, front)
            speeds = {HALF_HERTZ: by_pressure.speed_at(fine.X), DRY: hertz.front_speed(fine.X)}
            others = {name: float(waves.local_nabla2(p, wavelength, speed)) for name, speed in speeds.items()}
            yield Dot(mark, {FILM: mark.local, **others}, last=number == 0)


def _rolled(results: Results, plan: Plan) -> Iterator[Mark]:
    """The rolling contacts."""
    for case, wavelengths in plan.waves.rolling.items():
        grids = [results[runs.rolling_task(plan, case, nodes).name] for nodes in plan.waves.rolling_grids]
        for wavelength, coarse, fine in zip(wavelengths, *grids, strict=True):
            yield ratios.rolling_mark("rolling", case, wavelength, Extrapolated(coarse, fine))


def _twins(impacts: Sequence[Mark], results: Results, plan: Plan) -> Iterator[Twin]:
    """The rolling twins, each with the wave of the impact that is nearest to its place."""
    for twin in plan.waves.twins:
        *case, X = twin
        nearest = min((mark for mark in impacts if mark.case == tuple(case)), key=lambda mark: abs(mark.X - X))
        (_, coarse), (nabla2, fine) = (results[runs.twin_task(twin, nodes).name] for nodes in plan.waves.twin_grids)
        yield Twin(nearest, nabla2, Extrapolated(coarse, fine))


def reduction(results: Results, plan: Plan) -> Drawn:
    """Fig. 6: A_d/A_i of impact and of rolling against the local and the global nabla2, and the curve (15)."""
    content = find_ratios(results, plan)
    fitted = f"1/(1 + {content.fitted.linear:.3f} nabla2 + {content.fitted.quadratic:.4f} nabla2^2)"
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
        f"Dash-dotted: {fitted}, fitted to the squares.  Right: nabla2 with radius and pressure of the Hertz "
        "contact at the moment when the front passed, lambda_bar v/A^4, alpha_bar A, wavelength/A.  Crosses: rolling "
        "at exactly these parameters."
    )
    tables = {
        "Impact: last complete waves": DataFrame(
            {**dot.mark.cells_of_place(), "(15) of local": _by_15(dot.mark.local)} for dot in content.last
        ),
        "A_d/A_i minus the curve: mean, root mean square": _scatter_table(content),
        "Rolling at the parameters of the front": _twins_table(content.twins),
        "Rolling": DataFrame(
            {**m.cells(), "nabla2": f"{m.local:.2f}", **m.ratio.cells(), "(15)": _by_15(m.local)}
            for m in content.rolled
        ),
        **_checks(results, plan),
    }
    return Drawn(_draw(content), caption, {"impact": _impact_data(content), "rolling": _rolling_data(content)}, tables)


def _draw(content: Ratios) -> Figure:
    figure, (left, middle, right) = new_figure(1, 3)
    rolled = [mark.local for mark in content.rolled], [mark.ratio.limit for mark in content.rolled]
    bars = [mark.ratio.error for mark in content.rolled]
    for axes in (left, middle, right):
        ratios.draw_curves(axes)
        ratios.draw_fit(axes, content.fitted.ratio(ratios.RANGE), "-.", "fitted to the squares")
        axes.errorbar(*rolled, bars, fmt="s", color="black", markerfacecolor="white", capsize=2, label="rolling")
    _draw_dots(left, content.last, lambda dot: dot.mark.local, ranges=True)
    _draw_dots(middle, content.last, lambda dot: dot.mark.everywhere)
    _draw_dots(right, content.last, lambda dot: dot.mark.hertz)
    further = [dot.mark.hertz for dot in content.inner], [dot.mark.ratio.limit for dot in content.inner]
    crosses = [twin.nabla2 for twin in content.twins], [twin.rolling.limit for twin in content.twins]
    handles = right.plot(*further, ".", color=plots.GREY, markersize=3, label="impact, waves further in")
    handles += right.plot(*crosses, "x", color=plots.BLUE, label="rolling, parameters of the front")
    left.set_xlabel("local $\\nabla_2$, $\\bar\\lambda v$")
    middle.set_xlabel("global $\\nabla_2$ (rolling: its own)")
    right.set_xlabel("local $\\nabla_2$ with the momentary Hertz contact")
    left.legend(loc="lower left", frameon=False, fontsize="xx-small")
    right.legend(handles=handles, loc="lower left", frameon=False, fontsize="x-small")
    return figure


def _draw_dots(axes: Axes, dots: Sequence[Dot], nabla2: Callable[[Dot], float], ranges: bool = False) -> None:
    """Draw dots with error bars, one colour and marker for each (M, L); ranges: with horizontal bars for the speeds."""
    cases = list(dict.fromkeys(dot.mark.case[:2] for dot in dots))
    shades = plots.ORDERED_COLOURS(np.linspace(0.95, 0.0, len(cases)))
    for case, colour, marker in zip(cases, shades, "ovD^P*<>", strict=False):
        of_case = [dot for dot in dots if dot.mark.case[:2] == case]
        place, limit = [nabla2(dot) for dot in of_case], [dot.mark.ratio.limit for dot in of_case]
        bar, label = [dot.mark.ratio.error for dot in of_case], "impact, M = {:g}, L = {:g}"
        ends = [
            (x - min(dot.local.values()), max(dot.local.values()) - x) for x, dot in zip(place, of_case, strict=True)
        ]
        across = np.array(ends).T if ranges else None
        axes.errorbar(
            place, limit, bar, across, fmt=marker, color=colour, label=label.format(*case), capsize=2, elinewidth=0.8
        )


def _by_15(nabla2: float) -> str:
    return f"{float(amplitude_reduction.ratio_left(nabla2)):.3f}"


def _impact_data(content: Ratios) -> DataFrame:
    return DataFrame(
        {
            **{name: getattr(dot.mark, name) for name in ("M", "L", "wavelength", "X")},
            "last": int(dot.last),
            "everywhere": dot.mark.everywhere,
            "hertz": dot.mark.hertz,
            **dot.mark.ratio.columns(),
            **{f"local, {name}": nabla2 for name, nabla2 in dot.local.items()},
        }
        for dot in content.impacts
    )


def _rolling_data(content: Ratios) -> DataFrame:
    return DataFrame(
        {"M": m.M, "L": m.L, "wavelength": m.wavelength, "nabla2": m.local, **m.ratio.columns()} for m in content.rolled
    )


PARAMETERS: Mapping[str, Callable[[Dot], float]] = {
    f"local nabla2, speed by {FILM}": lambda dot: dot.local[FILM],
    f"local nabla2, speed by {HALF_HERTZ}": lambda dot: dot.local[HALF_HERTZ],
    f"local nabla2, speed by {DRY}": lambda dot: dot.local[DRY],
    "local nabla2, momentary Hertz contact": lambda dot: dot.mark.hertz,
    "global nabla2": lambda dot: dot.mark.everywhere,
}


def _scatter_table(content: Ratios) -> DataFrame:
    """Deviation of impact and rolling from the curves, for each parameter."""
    isotropic = amplitude_reduction.ratio_left
    curves = {"isotropic (15)": isotropic, **ratios.LINE_CONTACT, "fitted to rolling": content.fitted.ratio}
    rows = []
    for name, chosen in {"last waves": content.last, f"waves further in, X > {FORMED:g}": content.inner}.items():
        dots = [dot for dot in chosen if np.isfinite(list(dot.local.values())).all()]
        for kind, nabla2 in PARAMETERS.items() if dots else ():
            cells = scatter_cells([dot.mark for dot in dots], [nabla2(dot) for dot in dots], curves)
            rows.append({"parameter": f"impact, {name} ({len(dots)}), {kind}", **cells})
    cells = scatter_cells(content.rolled, [mark.local for mark in content.rolled], curves)
    return DataFrame([*rows, {"parameter": "rolling", **cells}])


def _twins_table(twins: Sequence[Twin]) -> DataFrame:
    rows = [
        {
            **twin.impact.cells(),
            "X": f"{twin.impact.X:.3f}",
            "nabla2": f"{twin.nabla2:.2f}",
            "impact at X": twin.impact.ratio.text(),
            "rolling": twin.rolling.text(),
            "impact minus rolling": f"{twin.impact.ratio.limit - twin.rolling.limit:+.3f}",
        }
        for twin in twins
    ]
    off = ratios.scatter([twin.impact for twin in twins], [twin.rolling.limit for twin in twins])
    total = {"M": "mean, root mean square", "impact minus rolling": off}
    return DataFrame([*rows, total]).fillna("")


# -- checks -----------------------------------------------------------------------------------------------------------


def _checks(results: Results, plan: Plan) -> dict[str, DataFrame]:
    """Title -> table of each check."""
    done = {name: results[task.name] for name, task in runs.check_tasks(plan).items()}
    (M, L), nodes = plan.waves.shown, plan.waves.grids[0]
    shortest = plan.waves.impacts[M, L][0]
    by_height = {"0: tangent-linear": _last_ratio(done["linear"], HEIGHT, shortest)}
    by_height |= {f"{height:g}": _last_ratio(done["heights"], height, shortest) for height in runs.CHECKED}
    usual = results[runs.waves_task(plan, (M, L), nodes).name]
    steps = [
        {
            "run": f"impact, M = {M:g}, L = {L:g}, wavelength {wavelength:g}, {nodes} nodes",
            "A_d/A_i, usual steps": f"{_last_ratio(usual, HEIGHT, wavelength):.4f}",
            f"{runs.SHORTER} times as many": f"{_last_ratio(done['steps'], HEIGHT, wavelength):.4f}",
        }
        for wavelength in plan.waves.impacts[M, L]
    ]
    return {
        f"Height of the waves: M = {M:g}, L = {L:g}, wavelength {shortest:g}, {nodes} nodes": DataFrame(
            {"A_i / sqrt(L/M)": height, "A_d/A_i": f"{ratio:.4f}"} for height, ratio in by_height.items()
        ),
        "Time steps": DataFrame(steps),
        "Rolling with and without time steps": _by_marching(results, done["marched"], plan),
    }


def _last_ratio(run: xr.Dataset, height: float, wavelength: float) -> float:
    response = run.sel(wave=runs.wave_name("isotropic", height, wavelength))
    return waves.last_wave(response["X"].values, response["dH"].values, EDGE).amplitude


def _by_marching(results: Results, marched: float, plan: Plan) -> DataFrame:
    M, L, wavelength, nodes = plan.waves.marched
    wavelengths = runs.rolled_wavelengths(plan, (M, L), nodes)
    linear = results[runs.rolling_task(plan, (M, L), nodes).name][wavelengths.index(wavelength)]
    run = f"M = {M:g}, L = {L:g}, wavelength {wavelength:g}, {nodes} nodes"
    steps = f"time steps of one cell, A_i = {HEIGHT:g} of the film scale"
    computed = {"without time steps, to first order": linear, steps: marched}
    return DataFrame({"rolling": run, "computed": how, "A_d/A_i": f"{ratio:.4f}"} for how, ratio in computed.items())
