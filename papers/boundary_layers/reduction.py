"""Amplitude ratios A_d/A_i of waves: Fig. 5, waves in an impact, and Fig. 6, impact and rolling.

The ratios of a figure are a table with a row for each wave, see `mark`: it is drawn, written as CSV, and read on
the page as texts.

The checks of Fig. 6: A_d/A_i does not depend on the height of the waves, and hardly on the time steps.  In rolling it
is computed without time steps; time steps over waves of finite height lead to the same value.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import ArrayLike, NDArray
from pandas import DataFrame, concat

from boundary_layers import runs, theory, waves
from boundary_layers.pages import Drawn, new_figure, texts
from boundary_layers.plans import Moes, Plan
from boundary_layers.runs import HEIGHT, wave_name
from ertel import Parameters, amplitude_reduction, fronts, hertz, plots

Values = NDArray[np.float64]
Curve = Callable[[ArrayLike], Values]  # A_d/A_i of nabla2
Mark = dict[str, Any]  # a row of a table of ratios
Results = Mapping[str, Any]  # of the runs of a figure


LINE_CONTACT: Mapping[str, Curve] = {
    "line contact (1997)": theory.in_line_contact,
    "line contact (later fit)": partial(theory.in_line_contact, coefficients=theory.LINE_REFIT),
}
RANGE = np.geomspace(0.3, 30, 200)  # nabla2 of the curves
FORMED = 0.4  # a*: at smaller radii there is a bell of pressure and no front yet
SPEEDS = ["local", "local, half the Hertz pressure", "local, dry law"]  # nabla2 by the speeds of the front
PARAMETERS: Mapping[str, str] = {
    "local nabla2, speed by minimum film": SPEEDS[0],
    "local nabla2, speed by half the Hertz pressure": SPEEDS[1],
    "local nabla2, speed by dry law": SPEEDS[2],
    "local nabla2, momentary Hertz contact": "hertz",
    "global nabla2": "everywhere",
}
SMALLEST_ERROR = 0.01  # of a ratio, in the fit: no ratio counts as more accurate
EDGE = 1.0  # a*: of the contact, in the checks
MARKERS = "ovD^P*<>"

# the cells of tables on the page
WAVE = {"M": "{M:g}", "L": "{L:g}", "wavelength": "{wavelength:g}"}
RATIO = {"A_d/A_i coarse": "{coarse:.3f}", "fine": "{fine:.3f}", "extrapolated": "{limit:.3f} ± {error:.3f}"}
PLACE = {
    **WAVE,
    "X": "{X:.3f}",
    **RATIO,
    "nabla2 local": "{local:.2f}",
    "momentary Hertz contact": "{hertz:.2f}",
    "global": "{everywhere:.2f}",
}


# -- marks ------------------------------------------------------------------------------------------------------------


def extrapolated(coarse: float, fine: float) -> dict[str, float]:
    """A value on two grids, the fine one with half the spacing, and its limit by a method of second order (Richardson).

    error: the error bar, the distance between this limit and that of a method of first order.
    """
    return {"coarse": coarse, "fine": fine, "limit": fine + (fine - coarse) / 3, "error": 2 / 3 * abs(fine - coarse)}


def over_film(p: Parameters, wavelength: float, speed: float = 1.0, A: float = 1.0) -> float:
    """Wavelength over trapped film for the speed and radius (a*) of the front; equal to nabla2 if alpha_bar > 0.4.

    nabla2 = wavelength/sqrt(L/M), and sqrt(L/M) is the film at which a rigid ball stops; that of an isoviscous oil is
    0.3135 sqrt(lambda_bar).
    """
    return wavelength / A / Parameters(p.lambda_bar * speed / A**4, p.alpha_bar * A).trapped_film


def mark(
    kind: str, case: Moes, wavelength: float, ratio: Sequence[float], X: float = 0.0, front: fronts.Front | None = None
) -> Mark:
    """A_d/A_i of a wave on both grids and extrapolated, for one kind of waves, oil or run.  front: of an impact.

    local: nabla2 of this place, by the speed of the front.  hertz: the same with the Hertz contact of the moment when
    the front passed.  everywhere: the global nabla2.  In rolling they are one.  Without piezoviscosity nabla2 is
    infinite; wavelength over trapped film takes its place, see `over_film`.
    """
    p = Parameters.from_moes(*case)
    local = momentary = everywhere = over_film(p, wavelength)
    if front is not None:
        speed = float(front.speed_at(X))
        local, momentary = (over_film(p, wavelength, speed, A) if speed > 0.0 else np.nan for A in (1.0, X))
    wave = {"M": case[0], "L": case[1], "wavelength": wavelength, "X": X}
    nabla2 = {"local": local, "hertz": momentary, "everywhere": everywhere}
    return {**wave, **nabla2, "kind": kind, **extrapolated(*ratio)}


def response(run: xr.Dataset, shape: str, wavelength: float, height: float = HEIGHT) -> tuple[Values, Values]:
    """X and dH/A_i of one wave in an impact."""
    line = run.sel(wave=wave_name(shape, height, wavelength))
    return line["X"].values, line["dH"].values


def last_wave(kind: str, case: Moes, shape: str, wavelength: float, grids: Sequence[xr.Dataset]) -> Mark:
    """The mark of the last complete wave inside the contact.  grids: the impact on both."""
    front = theory.front(grids[-1])
    coarse, fine = (waves.last_wave(*response(grid, shape, wavelength), float(front.A[-1])) for grid in grids)
    return mark(kind, case, wavelength, (coarse.amplitude, fine.amplitude), fine.X, front)


def draw_curves(axes: Axes) -> None:
    """Eq. (15) and the curves of the line contact, for nabla2 = 0.4 to 20."""
    axes.semilogx(RANGE, amplitude_reduction.ratio_left(RANGE), color="black", label="(15), isotropic")
    for (name, curve), style in zip(LINE_CONTACT.items(), ("--", ":"), strict=True):
        axes.semilogx(RANGE, curve(RANGE), color=plots.GREY, linestyle=style, label=f"transverse, {name}")
    axes.set(ylim=(0, 1.1), xlim=(0.4, 20), ylabel="$A_d/A_i$")
    axes.set_xticks([0.5, 1, 2, 5, 10, 20], ["0.5", "1", "2", "5", "10", "20"])


def draw_fit(axes: Axes, curve: Curve, style: str, label: str) -> None:
    """Draw another curve."""
    axes.plot(RANGE, curve(RANGE), color=plots.ORANGE, linewidth=1.0, linestyle=style, label=label)


def scatter(off: ArrayLike) -> str:
    """Mean and root mean square of deviations, as a cell of a table."""
    off = np.asarray(off)
    return f"{off.mean():+.3f}, {np.sqrt(np.mean(off**2)):.3f}"


def scatter_cells(marks: DataFrame, parameter: str, curves: Mapping[str, Curve]) -> dict[str, str]:
    """Deviation of marks from each of some curves, as cells of a table.  parameter: the column with nabla2."""
    return {name: scatter(marks["limit"] - curve(marks[parameter])) for name, curve in curves.items()}


# -- Fig. 5 -----------------------------------------------------------------------------------------------------------


def deformed_waves(results: Results, plan: Plan) -> Drawn:
    """Fig. 5: dH(X, 0)/A_i at maximum impact, inside and outside the contact."""
    (M, L), nodes = plan.shown, plan.impact_grids[1]
    wavelengths = plan.impacts[M, L]
    _, fine = results["waves"][M, L]
    edge = float(theory.front(results["smooth"][M, L]).A[-1])
    caption = (
        f"dH(X, 0)/A_i at maximum impact, M = {M:g}, L = {L:g}, roughness A_i cos(2 pi X/Lambda) cos(2 pi Y/Lambda) "
        f"with a crest at the centre, A_i = {HEIGHT} sqrt(L/M), {nodes} nodes per side.  The vertical lines mark the "
        "minimum film.  The deformation of the waves rises with their distance from the centre and with their "
        "wavelength, and the waves are shifted outwards.  Outside the contact they keep their amplitude."
    )
    return drawn_waves(fine, "isotropic", wavelengths, edge, caption, f"{nodes} nodes per side")


def drawn_waves(
    run: xr.Dataset, shape: str, wavelengths: Sequence[float], edge: float, caption: str, grid: str, unit: str = "a"
) -> Drawn:
    """dH/A_i of an impact along X, a panel for each wavelength.  edge: of the contact (unit*), a* or b*."""
    figure, panels = new_figure(len(wavelengths), 1)
    figure.set_size_inches(8.0, 2.4 * len(wavelengths))
    columns, rows = {"X": run["X"].values, "H": run["H"].values}, []
    for wavelength, axes in zip(wavelengths, panels, strict=True):
        X, dH = response(run, shape, wavelength)
        wave = waves.last_wave(X, dH, edge)
        undeformed = -run["shape"].sel(wave=wave_name(shape, HEIGHT, wavelength))
        label = "undeformed: $-\\mathcal{R}/A_i$"
        axes.plot(X, undeformed, color=plots.GREY, linewidth=0.7, linestyle=":", label=label)
        axes.plot(X, dH, color=plots.BLUE, label="$dH/A_i$")
        axes.axvspan(wave.start, wave.end, color=plots.ORANGE, alpha=0.2, label="last complete wave")
        for side in (-edge, edge):
            axes.axvline(side, color="black", linewidth=0.7)
        axes.set(xlim=(-runs.HALF_WIDTH, runs.HALF_WIDTH), ylim=(-1.15, 1.15), ylabel=f"$\\Lambda$ = {wavelength:g}")
        columns[f"dH/A_i, wavelength {wavelength:g}"] = dH
        rows.append({"wavelength": wavelength, **wave._asdict()})
    panels[0].legend(loc="lower left", frameon=True, fontsize="x-small", ncols=3)
    panels[-1].set_xlabel(f"$X$ (${unit}^*$)")
    cells = {f"wavelength ({unit}*)": "{wavelength:g}", "X": "{X:.3f}", "A_d/A_i": "{amplitude:.3f}"}
    tables = {f"Last complete waves, {grid}": texts(DataFrame(rows), cells)}
    return Drawn(figure, caption, {"dH": DataFrame(columns)}, tables)


# -- Fig. 6 -----------------------------------------------------------------------------------------------------------


def _impacts(results: Results, plan: Plan) -> Iterator[Mark]:
    """Each complete wave inside the contact, from the centre outwards, with nabla2 by other speeds of the front."""
    for case, grids in results["waves"].items():
        p, run = Parameters.from_moes(*case), results["smooth"][case]
        front, by_pressure = theory.front(run), theory.front(run, "half-hertz")
        for wavelength in plan.impacts[case]:
            inside = [waves.waves(*response(grid, "isotropic", wavelength), float(front.A[-1])) for grid in grids]
            pairs = list(zip(*(on_a_grid[::-1] for on_a_grid in inside), strict=False))  # from the edge inwards
            for number, (coarse, fine) in reversed(list(enumerate(pairs))):
                wave = mark("impact", case, wavelength, (coarse.amplitude, fine.amplitude), fine.X, front)
                speeds = by_pressure.speed_at(fine.X), hertz.front_speed(fine.X)
                others = [float(waves.local_nabla2(p, wavelength, speed)) for speed in speeds]
                yield {**wave, "last": int(number == 0), **dict(zip(SPEEDS[1:], others, strict=True))}


def _rolled(results: Results, plan: Plan) -> Iterator[Mark]:
    """The rolling contacts."""
    for case, grids in results["rolling"].items():
        for wavelength, *ratio in zip(plan.rolling[case], *grids, strict=True):
            yield mark("rolling", case, wavelength, ratio)


def _twins(impacts: DataFrame, results: Results, plan: Plan) -> Iterator[Mark]:
    """The rolling twins, each with the wave of the impact that is nearest to its place."""
    for (M, L, wavelength, X), ((_, coarse), (nabla2, fine)) in results["twins"].items():
        of_case = impacts[(impacts["M"] == M) & (impacts["L"] == L) & (impacts["wavelength"] == wavelength)]
        nearest = of_case.loc[(of_case["X"] - X).abs().idxmin()].to_dict()
        rolling = {f"rolling_{name}": value for name, value in extrapolated(coarse, fine).items()}
        yield {**nearest, "nabla2": nabla2, **rolling, "off": nearest["limit"] - rolling["rolling_limit"]}


def reduction(results: Results, plan: Plan) -> Drawn:
    """Fig. 6: A_d/A_i of impact and of rolling against the local and the global nabla2, and the curve (15)."""
    impacts, rolled = DataFrame(_impacts(results, plan)), DataFrame(_rolled(results, plan))
    twins = DataFrame(_twins(impacts, results, plan))
    fitted = waves.fit_reduction(rolled["local"], rolled["limit"], np.maximum(rolled["error"], SMALLEST_ERROR))
    caption = (
        "Amplitude reduction.  Dots: last complete wave inside the contact at maximum impact, extrapolated from grids "
        f"of {plan.impact_grids[0]} and {plan.impact_grids[1]} nodes per side for a method of second order; the error "
        "bar reaches to the limit of a method of first order.  Horizontal bars on the left: range of nabla2 for three "
        "speeds of the front at that place (front defined by the minimum film, by half the Hertz pressure, and exact "
        "dry law).  Squares: rolling over the same waviness, at the centre of the contact, to first order in its "
        f"height, extrapolated from {plan.rolling_grids[0]} and {plan.rolling_grids[1]} nodes per side.  "
        "Solid line: eq. (15).  "
        "Grey: transverse waviness in a line contact, 1/(1 + 0.17 n + 0.03 n^2) of 1997 (dashed) and a later fit, "
        "1/(1 + 0.125 n + 0.04 n^2) (dotted), n = 0.608 nabla2.  "
        f"Dash-dotted: 1/(1 + {fitted.linear:.3f} nabla2 + {fitted.quadratic:.4f} nabla2^2), fitted to the squares.  "
        "Right: nabla2 with radius and pressure of the Hertz "
        "contact at the moment when the front passed, lambda_bar v/A^4, alpha_bar A, wavelength/A.  Crosses: rolling "
        "at exactly these parameters."
    )
    last, inner = impacts[impacts["last"] == 1], impacts[(impacts["last"] == 0) & (impacts["X"] > FORMED)]
    by_15 = amplitude_reduction.ratio_left
    tables = {
        "Impact: last complete waves": texts(
            last.assign(by_15=by_15(last["local"])), {**PLACE, "(15) of local": "{by_15:.3f}"}
        ),
        "A_d/A_i minus the curve: mean, root mean square": _scatter_table(last, inner, rolled, fitted),
        "Rolling at the parameters of the front": _twins_table(twins),
        "Rolling": texts(
            rolled.assign(by_15=by_15(rolled["local"])),
            {**WAVE, "nabla2": "{local:.2f}", **RATIO, "(15)": "{by_15:.3f}"},
        ),
        **_checks(results, plan),
    }
    numbers = ["coarse", "fine", "limit", "error"]
    named = impacts.rename(columns={"local": "local, minimum film"})
    waves_data = named[
        ["M", "L", "wavelength", "X", "last", "everywhere", "hertz", *numbers, "local, minimum film", *SPEEDS[1:]]
    ]
    rolling_data = rolled.rename(columns={"local": "nabla2"})[["M", "L", "wavelength", "nabla2", *numbers]]
    figure = _draw(last, inner, rolled, twins, fitted)
    return Drawn(figure, caption, {"impact": waves_data, "rolling": rolling_data}, tables)


def _draw(last: DataFrame, inner: DataFrame, rolled: DataFrame, twins: DataFrame, fitted: waves.Reduction) -> Figure:
    figure, (left, middle, right) = new_figure(1, 3)
    squares: dict[str, Any] = {
        "fmt": "s",
        "color": "black",
        "markerfacecolor": "white",
        "capsize": 2,
        "label": "rolling",
    }
    for axes, parameter in ((left, "local"), (middle, "everywhere"), (right, "hertz")):
        draw_curves(axes)
        draw_fit(axes, fitted.ratio, "-.", "fitted to the squares")
        axes.errorbar(rolled["local"], rolled["limit"], rolled["error"], **squares)
        _draw_dots(axes, last, parameter)
    handles = right.plot(
        inner["hertz"], inner["limit"], ".", color=plots.GREY, markersize=3, label="impact, waves further in"
    )
    handles += right.plot(
        twins["nabla2"], twins["rolling_limit"], "x", color=plots.BLUE, label="rolling, parameters of the front"
    )
    left.set_xlabel("local $\\nabla_2$, $\\bar\\lambda v$")
    middle.set_xlabel("global $\\nabla_2$ (rolling: its own)")
    right.set_xlabel("local $\\nabla_2$ with the momentary Hertz contact")
    left.legend(loc="lower left", frameon=False, fontsize="xx-small")
    right.legend(handles=handles, loc="lower left", frameon=False, fontsize="x-small")
    return figure


def _draw_dots(axes: Axes, dots: DataFrame, parameter: str) -> None:
    """Draw dots with error bars, one colour and marker for each M, L; over "local" with bars for the three speeds."""
    groups = dots.groupby(["M", "L"], sort=False)
    shades = plots.ORDERED_COLOURS(np.linspace(0.95, 0.0, len(groups)))
    for ((M, L), of_case), colour, marker in zip(groups, shades, MARKERS, strict=False):
        place, speeds = of_case[parameter], of_case[SPEEDS]
        across = [place - speeds.min(axis=1), speeds.max(axis=1) - place] if parameter == "local" else None
        label = f"impact, M = {M:g}, L = {L:g}"
        axes.errorbar(
            place, of_case["limit"], of_case["error"], across,
            fmt=marker, color=colour, label=label, capsize=2, elinewidth=0.8,
        )  # fmt: skip


def _scatter_table(last: DataFrame, inner: DataFrame, rolled: DataFrame, fitted: waves.Reduction) -> DataFrame:
    """Deviation of impact and rolling from the curves, for each parameter."""
    curves = {"isotropic (15)": amplitude_reduction.ratio_left, **LINE_CONTACT, "fitted to rolling": fitted.ratio}
    rows = []
    for name, chosen in {"last waves": last, f"waves further in, X > {FORMED:g}": inner}.items():
        dots = chosen[np.isfinite(chosen[SPEEDS]).all(axis=1)]
        for kind, parameter in PARAMETERS.items() if len(dots) else ():
            cells = scatter_cells(dots, parameter, curves)
            rows.append({"parameter": f"impact, {name} ({len(dots)}), {kind}", **cells})
    return DataFrame([*rows, {"parameter": "rolling", **scatter_cells(rolled, "local", curves)}])


def _twins_table(twins: DataFrame) -> DataFrame:
    cells = {
        **WAVE,
        "X": "{X:.3f}",
        "nabla2": "{nabla2:.2f}",
        "impact at X": "{limit:.3f} ± {error:.3f}",
        "rolling": "{rolling_limit:.3f} ± {rolling_error:.3f}",
        "impact minus rolling": "{off:+.3f}",
    }
    total = DataFrame([{"M": "mean, root mean square", "impact minus rolling": scatter(twins["off"])}])
    return concat([texts(twins, cells), total]).fillna("")


# -- checks -----------------------------------------------------------------------------------------------------------


def _checks(results: Results, plan: Plan) -> dict[str, DataFrame]:
    """Title -> table of each check."""
    done = {name: run for name, [run] in results["checks"].items()}
    (M, L), nodes = plan.shown, plan.impact_grids[0]
    shortest = plan.impacts[M, L][0]
    by_height = {"0: tangent-linear": _last_ratio(done["linear"], shortest)}
    by_height |= {f"{height:g}": _last_ratio(done["heights"], shortest, height) for height in runs.CHECKED}
    usual = results["waves"][M, L][0]
    steps = [
        {
            "run": f"impact, M = {M:g}, L = {L:g}, wavelength {wavelength:g}, {nodes} nodes",
            "A_d/A_i, usual steps": f"{_last_ratio(usual, wavelength):.4f}",
            f"{runs.SHORTER} times as many": f"{_last_ratio(done['steps'], wavelength):.4f}",
        }
        for wavelength in plan.impacts[M, L]
    ]
    rolling = "M = {:g}, L = {:g}, wavelength {:g}, {} nodes".format(*plan.marched)
    [without_steps], by_steps = done["not marched"], f"time steps of one cell, A_i = {HEIGHT:g} of the film scale"
    computed = {"without time steps, to first order": without_steps, by_steps: done["marched"]}
    return {
        f"Height of the waves: M = {M:g}, L = {L:g}, wavelength {shortest:g}, {nodes} nodes": DataFrame(
            {"A_i / sqrt(L/M)": height, "A_d/A_i": f"{ratio:.4f}"} for height, ratio in by_height.items()
        ),
        "Time steps": DataFrame(steps),
        "Rolling with and without time steps": DataFrame(
            {"rolling": rolling, "computed": how, "A_d/A_i": f"{ratio:.4f}"} for how, ratio in computed.items()
        ),
    }


def _last_ratio(run: xr.Dataset, wavelength: float, height: float = HEIGHT) -> float:
    return waves.last_wave(*response(run, "isotropic", wavelength, height), EDGE).amplitude
