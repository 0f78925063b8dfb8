"""Figures 1 to 4 of the paper: the dry impact, the front of the lubricated one, the film that it leaves behind."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ertel.apps.boundary_layers.page import Drawn, Table
from ertel.inputs.case_files import parse_case
from ertel.physics import hertz
from ertel.physics.scales import Parameters
from ertel.results import fronts
from ertel.results.fronts import FrontDefinition, Trace, Values
from ertel.results.plots.drawing import BLUE, GREEN, GREY, ORANGE, ORDERED_COLOURS
from ertel.runs.drive import simulate
from ertel.runs.sweep import Task

LOADS = (200, 500, 1000, 2000, 5000, 10000)  # M of Fig. 2
L = 10.0
SHOWN = 1000  # M of Fig. 3, and of the run by the 2-D method
DEFINITIONS: tuple[FrontDefinition, ...] = ("film", "slope", "half-hertz")
NAMES = {"film": "least film", "slope": "steepest pressure", "half-hertz": "half of Hertz' pressure"}
INNER, OUTER = 0.75, 0.95  # where the film follows the front's speed
INTERVAL = 0.01  # t0 between maps
FORMED = 0.4  # a*: before, there is a bell of pressure rather than a contact with a front
TOUCH = 1.0  # t0: the ball starts one delta* apart


def smooth_impact(M: float, L: float, solver: Mapping[str, Any], interval: float) -> xr.Dataset:
    """A smooth impact up to maximum approach.  Raises RuntimeError where it gave up."""
    source = {"contact": {"M": M, "L": L}, "solver": dict(solver), "output": {"interval": interval}}
    result = simulate(parse_case(source))
    if not result.status.ok:
        raise RuntimeError(f"M = {M}, L = {L}: {result.status.value}; {result.status.advice}")
    return result.dataset


def radial_task(M: float, L: float, quick: bool) -> Task:
    """A smooth impact by the radial method."""
    nodes, seconds = (301, 4.0) if quick else (801, 20.0)
    solver = {"method": "radial", "nodes": nodes, "half_width": 4.0}
    return Task(f"smooth_M{M:g}_L{L:g}_{nodes}", smooth_impact, (float(M), float(L), solver, INTERVAL), seconds)


def radial_tasks(quick: bool) -> list[Task]:
    """The impacts of Fig. 2 by the radial method."""
    return [radial_task(M, L, quick) for M in LOADS]


def two_dimensional_task(quick: bool) -> Task:
    """One of them by the 2-D method."""
    nodes, half_width, seconds = (129, 1.5, 20.0) if quick else (385, 2.0, 150.0)
    solver = {"nodes": nodes, "half_width": half_width}
    return Task(f"smooth_2d_M{SHOWN}_{nodes}", smooth_impact, (SHOWN, L, solver, 10.0), seconds)


def all_tasks(quick: bool) -> list[Task]:
    """The impacts of Fig. 2, and the one by the 2-D method last."""
    return [*radial_tasks(quick), two_dimensional_task(quick)]


# -- Fig. 1 -----------------------------------------------------------------------------------------------------------


def dry_impact(runs: Sequence[xr.Dataset], quick: bool) -> Drawn:
    """Fig. 1: contact radius and its rate in the dry impact, exact and by the asymptotes, with t* fitted to our own."""
    T = np.linspace(-hertz.HALF_CONTACT_TIME, hertz.HALF_CONTACT_TIME, 1201)
    exact = hertz.contact_radius(T + hertz.HALF_CONTACT_TIME)
    fitted = fronts.fit_half_base(T, exact)
    bases = [[str(M), *(f"{2 * _half_base(run, by):.3f}" for by in DEFINITIONS)] for M, run in _by_load(runs)]
    laws: dict[str, tuple[Values, str, str]] = {
        "exact": (exact, "black", "-"),
        "Johnson (20)": (hertz.johnson_radius(T), BLUE, "--"),
        "parabola (22), t* = 1.35": (hertz.parabola_radius(T), ORANGE, "-"),
        f"parabola, t* = {fitted:.3f} fitted": (hertz.parabola_radius(T, fitted), GREEN, ":"),
    }
    figure, (left, right) = new_figure(1, 2)
    rows = []
    for name, (A, colour, style) in laws.items():
        with np.errstate(divide="ignore", invalid="ignore"):
            speed = np.where((A > 0.02) & (A < 1.01), np.gradient(A, T), np.nan)
        left.plot(T, A, color=colour, linestyle=style, label=name)
        right.plot(T, speed * hertz.HALF_BASE, color=colour, linestyle=style)
        if name != "exact":
            rows.append([name, f"{np.abs(A - exact)[exact > 0.5].max():.4f}"])
    right.plot(T, hertz.linear_front_speed(T) * hertz.HALF_BASE, color=GREY, linewidth=0.8, label="linear (24)")
    left.set(xlabel="time from the maximum $T$ ($t_0$)", ylabel="$a/a^*$", ylim=(0, 1.05))
    right.set(xlabel="time from the maximum $T$ ($t_0$)", ylabel="$v/v^*$, $v^* = a^*/(1.35\\,t_0)$", ylim=(-3, 3))
    left.legend(loc="lower center", frameon=False, fontsize="small")
    right.legend(loc="upper right", frameon=False, fontsize="small")
    right.text(0.03, 0.03, "colours as on the left", transform=right.transAxes, fontsize="small")
    caption = (
        f"The dry impact lasts {hertz.CONTACT_TIME:.4f} t0 (Johnson's 2.94).  The paper's 2.7 is the full base of its "
        f"parabola (22), t* = 1.35 to either side of the maximum: fitted to the exact law where a > a*/2 the full base "
        f"is {2 * fitted:.3f}, fitted to the front of the lubricated impact it is as tabled, by the definition of the "
        "front (radius as a share of the largest)."
    )
    columns = {"T": T, **{name: A for name, (A, _, _) in laws.items()}}
    tables = [
        Table(["law", "largest error of a/a* where a > a*/2"], rows),
        Table(["M", *(f"full base, front by {NAMES[by]}" for by in DEFINITIONS)], bases),
    ]
    return Drawn(figure, caption, {"radius": columns}, tables)


def _half_base(run: xr.Dataset, by: FrontDefinition) -> float:
    front = fronts.front(run, by)
    maximum = float(fronts.at_max_approach(run)["frame"])
    return fronts.fit_half_base(front.T - maximum, front.A / front.A[-1])


# -- Fig. 2 -----------------------------------------------------------------------------------------------------------


def front_speed(runs: Sequence[xr.Dataset], quick: bool) -> Drawn:
    """Fig. 2: the front's speed in the lubricated impact for six M, by three definitions of the front."""
    figure, (left, right) = new_figure(1, 2)
    T = np.linspace(0.01, hertz.HALF_CONTACT_TIME, 600)
    left.plot(T, hertz.front_speed(hertz.contact_radius(T)), color="black", label="dry, exact")
    linear = hertz.linear_front_speed(T - hertz.HALF_CONTACT_TIME)
    left.plot(T, linear, color=GREY, linestyle=":", label="linear (24), $t^*$ = 1.35")
    columns: dict[str, Values] = {}
    rows, X = [], np.linspace(0.5, 0.9, 41)
    for (M, run), colour in zip(_by_load(runs), _shades(), strict=True):
        row = [str(M)]
        for by, style in zip(DEFINITIONS, ("-", ":", "--"), strict=True):
            front = fronts.front(run, by)
            label = f"$M$ = {M}" if by == "film" else None
            late = front.A > FORMED
            if by != "slope":
                T, speed = front.T[late] - TOUCH, front.speed[late]
                left.plot(T, speed, color=colour, linestyle=style, linewidth=1.0, label=label)
            ratio = front.speed / hertz.front_speed(np.minimum(front.A, 1.0))
            right.plot(front.A[late], ratio[late], color=colour, linestyle=style, linewidth=1.0)
            share = front.speed_at(X) / hertz.front_speed(X)
            row.append(f"{np.nanmean(share):.2f} ({np.nanmin(share):.2f} to {np.nanmax(share):.2f})")
            for name, values in zip(("T", "A", "speed"), front, strict=True):
                columns[f"{name}, M = {M}, {by}"] = values
        rows.append([*row, f"{fronts.front(run).A[-1]:.3f}"])
    for by, style in zip(DEFINITIONS, ("-", ":", "--"), strict=True):
        right.plot([], [], color=GREY, linestyle=style, label=NAMES[by])
    plane = fronts.front(runs[-1])
    left.plot(plane.T - TOUCH, plane.speed, ".", color=GREY, markersize=3, label=f"$M$ = {SHOWN}, 2-D method")
    left.set(xlabel="time from the dry ball's first touch ($t_0$)", ylabel="front speed $dA/dT$ ($a^*/t_0$)")
    left.set(xlim=(0, 1.5), ylim=(0, 1.4))
    right.axhline(1.0, color="black", linewidth=0.8)
    right.set(xlabel="position of the front $A$ ($a^*$)", ylabel="speed over that of the dry contact", ylim=(0, 1.1))
    right.set(xlim=(FORMED, 1.0))
    for axes in (left, right):
        axes.legend(loc="upper right" if axes is left else "lower left", frameon=False, fontsize="small")
    caption = (
        f"Front speed for M = {LOADS[0]} to {LOADS[-1]}, L = {L:g}, up to maximum approach; left: solid by the place "
        "of the least film, dashed by half of Hertz' pressure; right: as a share of the exact dry law at the same "
        "position, by three definitions.  The higher the load, the closer all come to the dry law; at low M the "
        "definitions differ, as the front is wide, and it stops short of a*."
    )
    head = ["M", *(f"mean share of the dry speed, 0.5 < A < 0.9: {NAMES[by]}" for by in DEFINITIONS)]
    return Drawn(figure, caption, {"fronts": columns}, [Table([*head, "last A by least film"], rows)])


# -- Fig. 3 and 4 -----------------------------------------------------------------------------------------------------


def film_and_speed(runs: Sequence[xr.Dataset], quick: bool) -> Drawn:
    """Fig. 3: the film at maximum impact for one M, by both methods, and C v^0.67."""
    radial, two_dimensional = runs[LOADS.index(SHOWN)], runs[-1]
    figure, (axes,) = new_figure(1, 1)
    X, H = _profile(radial)
    axes.plot(np.r_[-X[::-1], X], np.r_[H[::-1], H], color="black", label="computed, radial method")
    plane = fronts.at_max_approach(two_dimensional)["H"].sel(Y=0.0, method="nearest")
    axes.plot(plane["X"], plane, ".", color=GREY, markersize=4, label="computed, 2-D method")
    columns = {"X": X, "H": H}
    for name, speed, colour in (
        ("$C v^{0.67}$, $v$ of the computed front", fronts.front(radial).speed_at(X), ORANGE),
        (
            "$C v^{0.67}$, $v$ of the parabola (23)",
            hertz.parabola_front_speed_at(np.where((X > 0) & (X < 1), X, np.nan)),
            BLUE,
        ),
    ):
        curve = _fitted(X, H, speed)
        columns[name] = curve
        axes.plot(np.r_[-X[::-1], X], np.r_[curve[::-1], curve], color=colour, linestyle="--", label=name)
    axes.set(xlim=(-1.2, 1.2), ylim=(0, 1.5 * float(H[0])), xlabel="$X$ ($a^*$)", ylabel="film $H$ ($a^{*2}/R$)")
    axes.legend(loc="lower center", frameon=False, fontsize="small")
    centre = float(plane.sel(X=0.0, method="nearest"))
    caption = (
        f"Film at maximum impact, M = {SHOWN}, L = {L:g}, and C v^0.67 with C fitted on {INNER} < X < {OUTER}.  The "
        "central bell is not that of a moving front.  Radial and 2-D method: "
        f"H(0) = {H[0]:.5f} and {centre:.5f} ({centre / H[0] - 1:+.2%})."
    )
    return Drawn(figure, caption, {"film": columns}, [])


def film_predicted(runs: Sequence[xr.Dataset], quick: bool) -> Drawn:
    """Fig. 4: zoom on the film behind the front for six M, C v^0.67, and the film that a steady formula predicts."""
    figure, panels = new_figure(2, 3)
    rows, columns = [], {}
    fitted_on = np.linspace(INNER, OUTER, 81)
    for (M, run), axes in zip(_by_load(runs), panels, strict=True):
        r, H = _profile(run)
        near = (r > 0.6) & (r < 1.02)
        axes.plot(r[near], H[near], color="black", label="computed")
        front, p = fronts.front(run), Parameters.from_moes(M, L)
        speed = front.speed_at(r[near])
        curves = {
            "$C v^{0.67}$": (_fitted(r[near], H[near], speed), ORANGE, "-"),
            "formula at $\\bar\\lambda v$": (_predicted(p, speed, np.ones_like(speed)), BLUE, "--"),
            "formula, local Hertz": (_predicted(p, speed, r[near]), GREEN, "-."),
        }
        for name, (curve, colour, style) in curves.items():
            axes.plot(r[near], curve, color=colour, linestyle=style, label=name)
            columns[f"{name}, M = {M}"] = curve
        columns |= {f"X, M = {M}": r[near], f"H, M = {M}": H[near], f"speed, M = {M}": speed}
        axes.set(xlim=(0.65, 1.0), ylim=(0, 1.05 * float(np.interp(0.65, r, H))), title=f"$M$ = {M}")
        rows += _deviations(M, run, fitted_on)
    panels[0].legend(loc="lower left", frameon=False, fontsize="small")
    for axes in panels[3:]:
        axes.set_xlabel("$X$ ($a^*$)")
    for axes in panels[::3]:
        axes.set_ylabel("film $H$ ($a^{*2}/R$)")
    caption = (
        f"Zoom.  Computed film, C v^0.67 with C fitted on {INNER} < X < {OUTER} and, with nothing fitted, the central "
        "film of Nijenbanning, Venner and Moes at the local parameters: plain (lambda_bar v, alpha_bar), and with the "
        "Hertz contact of that moment (lambda_bar v/A^4, alpha_bar A, times A^2); v of the place of the least film.  "
        "The table gives root mean square (and mean) deviations on that range, as far as the front came, by the "
        "definition of the front; the formula is for Barus' law, the runs have Roelands' and a compressible oil."
    )
    head = ["M", "front", "C", "C v^0.67", "formula, plain", "formula, local Hertz", "X up to"]
    return Drawn(figure, caption, {"film": columns}, [Table(head, rows)])


def _deviations(M: float, run: xr.Dataset, X: Values) -> list[list[str]]:
    """The table's rows: how far the film is from C v^0.67 and from the formula, for each kind of speed."""
    r, H = _profile(run)
    traces = {NAMES[by]: fronts.film_behind_front(run, fronts.front(run, by), X) for by in DEFINITIONS}
    traces["none: exact dry law"] = Trace(X, np.interp(X, r, H), hertz.front_speed(X))
    traces["none: parabola (23)"] = Trace(X, np.interp(X, r, H), hertz.parabola_front_speed_at(X))
    p, rows = Parameters.from_moes(M, L), []
    for name, trace in traces.items():
        if len(trace.X) < 3:
            continue
        C = fronts.fit_power(trace)
        found = [
            fronts.deviation(curve, trace.H)
            for curve in (
                C * trace.speed**fronts.SPEED_EXPONENT,
                fronts.film_from_speed(p, trace.speed),
                fronts.film_from_speed(p, trace.speed, trace.X),
            )
        ]
        cells = [f"{d.rms:.1%} ({d.mean:+.1%})" for d in found]
        rows.append([str(M), name, f"{C:.5f}", *cells, f"{trace.X[-1]:.2f}"])
    return rows


def _by_load(runs: Sequence[xr.Dataset]) -> list[tuple[int, xr.Dataset]]:
    """M and its run by the radial method."""
    return list(zip(LOADS, runs, strict=False))


def _profile(run: xr.Dataset) -> tuple[Values, Values]:
    last = fronts.at_max_approach(run)
    return np.asarray(last["r"].values), np.asarray(last["H"].values)


def _fitted(X: Values, H: Values, speed: Values) -> Values:
    """C v^0.67 with C fitted where the paper fits it."""
    near = (X > INNER) & (X < OUTER) & np.isfinite(speed) & (speed > 0)
    C = fronts.fit_power(Trace(X[near], H[near], speed[near]))
    return np.asarray(C * speed**fronts.SPEED_EXPONENT)


def _predicted(p: Parameters, speed: Values, A: Values) -> Values:
    curve = np.full_like(speed, np.nan)
    known = np.isfinite(speed) & (speed > 0)
    curve[known] = fronts.film_from_speed(p, speed[known], A[known])
    return curve


def _shades() -> Values:
    return ORDERED_COLOURS(np.linspace(1.0, 0.0, len(LOADS)))


def new_figure(rows: int, columns: int) -> tuple[Figure, list[Axes]]:
    """A figure with panels, row by row."""
    figure = Figure(figsize=(max(4.8 * columns, 7.0), 3.8 * rows), layout="constrained")
    return figure, list(figure.subplots(rows, columns, squeeze=False).ravel())
