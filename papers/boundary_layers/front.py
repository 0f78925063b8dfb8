"""Figures 1 to 4 of the paper: the dry impact, the speed of the front in a lubricated one, and the film behind it."""

from collections.abc import Callable, Iterator, Mapping
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from pandas import DataFrame

from boundary_layers import theory
from boundary_layers.pages import Drawn, new_figure, side_by_side
from boundary_layers.plans import LOADS, SHOWN_LOAD, L, Plan
from boundary_layers.reduction import FORMED, Values
from ertel import Parameters, fronts, hertz, plots

Curve = tuple[Values, str, str]  # values, colour and style of a line

TOUCH = 1.0  # t0: the ball starts one delta* above the surface
FRONTS: Mapping[theory.FrontDefinition, str] = {
    "film": "minimum film",
    "slope": "steepest pressure",
    "half-hertz": "half the Hertz pressure",
}
LINES = dict(zip(FRONTS, ("-", ":", "--"), strict=True))
COMPARED = np.linspace(0.5, 0.9, 41)  # places where the front's speed is compared with the dry contact's
INNER, OUTER = 0.75, 0.95  # a*: where the film follows the speed of the front
FITTED_ON = np.linspace(INNER, OUTER, 81)


# -- Fig. 1 -----------------------------------------------------------------------------------------------------------


def dry_impact(results: Mapping[str, Any], plan: Plan) -> Drawn:
    """Fig. 1: contact radius of the dry impact and its rate, exact and by the asymptotes; t* fitted to them."""
    T = np.linspace(-hertz.HALF_CONTACT_TIME, hertz.HALF_CONTACT_TIME, 1201)
    exact = hertz.contact_radius(T + hertz.HALF_CONTACT_TIME)
    fitted = theory.fit_half_base(T, exact)
    laws: dict[str, Curve] = {
        "exact": (exact, "black", "-"),
        "Johnson (20)": (theory.johnson_radius(T), plots.BLUE, "--"),
        "parabola (22), t* = 1.35": (theory.parabola_radius(T), plots.ORANGE, "-"),
        f"parabola, t* = {fitted:.3f} fitted": (theory.parabola_radius(T, fitted), plots.GREEN, ":"),
    }
    figure, (left, right) = new_figure(1, 2)
    _draw_laws(left, right, T, laws)
    caption = (
        f"The dry impact lasts {hertz.CONTACT_TIME:.4f} t0 (Johnson's 2.94).  The paper's 2.7 is the full base of its "
        "parabola (22), t* = 1.35 before and after the maximum.  A fit to the exact law where a > a*/2 gives a full "
        f"base of {2 * fitted:.3f}.  The second table gives fits to the front of the lubricated impact, its radius "
        "divided by the largest one, for three definitions of the front."
    )
    errors = {name: np.abs(A - exact)[exact > 0.5].max() for name, (A, *_) in laws.items() if name != "exact"}
    largest = "largest error of a/a* where a > a*/2"
    bases = [
        {"M": str(M), **{f"front by {name}": f"{2 * half_base(run, by):.3f}" for by, name in FRONTS.items()}}
        for M, run in results["radial"].items()
    ]
    tables = {
        "Errors of the laws": DataFrame({"law": name, largest: f"{error:.4f}"} for name, error in errors.items()),
        "Full base fitted to the front": DataFrame(bases),
    }
    data = DataFrame({"T": T, **{name: A for name, (A, *_) in laws.items()}})
    return Drawn(figure, caption, {"radius": data}, tables)


def _draw_laws(left: Axes, right: Axes, T: Values, laws: Mapping[str, Curve]) -> None:
    for name, (A, colour, line) in laws.items():
        with np.errstate(divide="ignore", invalid="ignore"):
            speed = np.where((A > 0.02) & (A < 1.01), np.gradient(A, T), np.nan)
        left.plot(T, A, color=colour, linestyle=line, label=name)
        right.plot(T, speed * theory.HALF_BASE, color=colour, linestyle=line)
    right.plot(T, theory.linear_front_speed(T) * theory.HALF_BASE, color=plots.GREY, linewidth=0.8, label="linear (24)")
    left.set(xlabel="time from the maximum $T$ ($t_0$)", ylabel="$a/a^*$", ylim=(0, 1.05))
    right.set(xlabel="time from the maximum $T$ ($t_0$)", ylabel="$v/v^*$, $v^* = a^*/(1.35\\,t_0)$", ylim=(-3, 3))
    left.legend(loc="lower center", frameon=False, fontsize="small")
    right.legend(loc="upper right", frameon=False, fontsize="small")
    right.text(0.03, 0.03, "colours as on the left", transform=right.transAxes, fontsize="small")


def half_base(run: xr.Dataset, by: theory.FrontDefinition) -> float:
    """t* of the parabola (22), fitted to the front, its place over the last one."""
    front = theory.front(run, by)
    maximum = float(fronts.at_max_approach(run)["frame"])
    return theory.fit_half_base(front.T - maximum, front.A / front.A[-1])


# -- Fig. 2 -----------------------------------------------------------------------------------------------------------

Fronts = Mapping[float, Mapping[theory.FrontDefinition, fronts.Front]]  # M, definition -> front
Speed = Callable[[Values], Values]  # speed of the dry contact's edge (a*/t0) where it is at A (a*)


def front_speed(results: Mapping[str, Any], plan: Plan) -> Drawn:
    """Fig. 2: speed of the front in the lubricated impact for six M, by three definitions of the front."""
    all_fronts: Fronts = {M: {by: theory.front(run, by) for by in FRONTS} for M, run in results["radial"].items()}
    figure, (left, right) = new_figure(1, 2)
    _draw_speed(left, all_fronts, theory.front(results["plane"]))
    draw_share(right, all_fronts, hertz.front_speed)
    caption = (
        f"Speed of the front for M = {LOADS[0]} to {LOADS[-1]}, L = {L:g}, up to maximum approach.  Left: front "
        "defined by the minimum film (solid) and by half the Hertz pressure (dashed).  Right: speed divided by that of "
        "the exact dry law at the same position, by three definitions of the front.  All speeds approach the dry law "
        "as the load rises.  At low M the front is wide, so that the definitions differ, and it stops before it "
        "reaches a*."
    )
    columns = {
        f"{name}, M = {M}, {by}": values
        for M, by_definition in all_fronts.items()
        for by, front in by_definition.items()
        for name, values in front._asdict().items()
    }
    shares = [
        {
            "M": str(M),
            **{f"front by {name}": share_of(by_definition[by], hertz.front_speed) for by, name in FRONTS.items()},
            "last A by minimum film": f"{by_definition['film'].A[-1]:.3f}",
        }
        for M, by_definition in all_fronts.items()
    ]
    tables = {"Speed of the front divided by that of the dry contact, 0.5 < A < 0.9: mean (range)": DataFrame(shares)}
    return Drawn(figure, caption, {"fronts": side_by_side(columns)}, tables)


def _draw_speed(axes: Axes, all_fronts: Fronts, plane: fronts.Front) -> None:
    T = np.linspace(0.01, hertz.HALF_CONTACT_TIME, 600)
    axes.plot(T, hertz.front_speed(hertz.contact_radius(T)), color="black", label="dry, exact")
    linear = theory.linear_front_speed(T - hertz.HALF_CONTACT_TIME)
    axes.plot(T, linear, color=plots.GREY, linestyle=":", label="linear (24), $t^*$ = 1.35")
    for (M, by_definition), colour in zip(all_fronts.items(), shades(len(LOADS)), strict=True):
        labels: Mapping[theory.FrontDefinition, str | None] = {"film": f"$M$ = {M}", "half-hertz": None}
        for by, label in labels.items():
            front = by_definition[by]
            late = front.A > FORMED
            axes.plot(front.T[late] - TOUCH, front.speed[late], LINES[by], color=colour, linewidth=1.0, label=label)
    label = f"$M$ = {SHOWN_LOAD}, 2-D method"
    axes.plot(plane.T - TOUCH, plane.speed, ".", color=plots.GREY, markersize=3, label=label)
    axes.set(xlabel="time from the dry ball's first touch ($t_0$)", ylabel="front speed $dA/dT$ ($a^*/t_0$)")
    axes.set(xlim=(0, 1.5), ylim=(0, 1.4))
    axes.legend(loc="upper right", frameon=False, fontsize="small")


def draw_share(axes: Axes, all_fronts: Fronts, dry: Speed) -> None:
    """The speed of the front over that of the dry contact at the same place."""
    for by_definition, colour in zip(all_fronts.values(), shades(len(all_fronts)), strict=True):
        for by, front in by_definition.items():
            late = front.A > FORMED
            share = front.speed / dry(np.minimum(front.A, 1.0))
            axes.plot(front.A[late], share[late], LINES[by], color=colour, linewidth=1.0)
    for by, name in FRONTS.items():
        axes.plot([], [], LINES[by], color=plots.GREY, label=name)
    axes.axhline(1.0, color="black", linewidth=0.8)
    axes.set(xlabel="position of the front $A$ ($a^*$)", ylabel="speed over that of the dry contact", ylim=(0, 1.1))
    axes.set(xlim=(FORMED, 1.0))
    axes.legend(loc="lower left", frameon=False, fontsize="small")


def share_of(front: fronts.Front, dry: Speed) -> str:
    """The same for 0.5 < A < 0.9, as a cell of a table: mean and range."""
    share = front.speed_at(COMPARED) / dry(COMPARED)
    return f"{np.nanmean(share):.2f} ({np.nanmin(share):.2f} to {np.nanmax(share):.2f})"


def shades(number: int) -> Values:
    """So many colours, from light to dark."""
    return np.asarray(plots.ORDERED_COLOURS(np.linspace(1.0, 0.0, number)))


# -- Fig. 3 -----------------------------------------------------------------------------------------------------------


def film_and_speed(results: Mapping[str, Any], plan: Plan) -> Drawn:
    """Fig. 3: film at maximum impact for one M, by both methods, and C v^0.67."""
    radial = results["radial"][SHOWN_LOAD]
    plane = fronts.at_max_approach(results["plane"])["H"].sel(Y=0.0, method="nearest")
    X, H = _profile(radial)
    dry = theory.parabola_front_speed(np.where((X > 0) & (X < 1), X, np.nan))
    computed, by_parabola = (fitted_power(X, H, speed) for speed in (theory.front(radial).speed_at(X), dry))
    fitted: dict[str, Curve] = {
        "$C v^{0.67}$, $v$ of the computed front": (computed, plots.ORANGE, "--"),
        "$C v^{0.67}$, $v$ of the parabola (23)": (by_parabola, plots.BLUE, "--"),
    }
    figure, (axes,) = new_figure(1, 1)
    draw_both_sides(axes, X, (H, "black", "-"), "computed, radial method")
    axes.plot(plane["X"], plane, ".", color=plots.GREY, markersize=4, label="computed, 2-D method")
    for name, curve in fitted.items():
        draw_both_sides(axes, X, curve, name)
    axes.set(xlim=(-1.2, 1.2), ylim=(0, 1.5 * float(H[0])), xlabel="$X$ ($a^*$)", ylabel="film $H$ ($a^{*2}/R$)")
    axes.legend(loc="lower center", frameon=False, fontsize="small")
    centre = float(plane.sel(X=0.0, method="nearest"))
    caption = (
        f"Film at maximum impact, M = {SHOWN_LOAD}, L = {L:g}, and C v^0.67 with C fitted on {INNER} < X < {OUTER}.  "
        "The bell in the centre formed before there was a front.  Central film by the radial and by the 2-D method: "
        f"H(0) = {H[0]:.5f} and {centre:.5f} ({centre / H[0] - 1:+.2%})."
    )
    data = DataFrame({"X": X, "H": H, **{name: values for name, (values, *_) in fitted.items()}})
    return Drawn(figure, caption, {"film": data})


def draw_both_sides(axes: Axes, X: Values, curve: Curve, label: str) -> None:
    """A curve over X >= 0 and its mirror image."""
    H, colour, line = curve
    axes.plot(np.r_[-X[::-1], X], np.r_[H[::-1], H], color=colour, linestyle=line, label=label)


def _profile(run: xr.Dataset) -> tuple[Values, Values]:
    """Distance X from the centre and film H, at maximum approach."""
    last = fronts.at_max_approach(run)
    return np.asarray(last["r"].values), np.asarray(last["H"].values)


def fitted_power(X: Values, H: Values, speed: Values) -> Values:
    """C v^0.67 with C fitted on the range of the paper."""
    near = (X > INNER) & (X < OUTER) & np.isfinite(speed) & (speed > 0)
    C = theory.fit_power(theory.Trace(X[near], H[near], speed[near]))
    return np.asarray(C * speed**theory.SPEED_EXPONENT)


# -- Fig. 4 -----------------------------------------------------------------------------------------------------------


def film_predicted(results: Mapping[str, Any], plan: Plan) -> Drawn:
    """Fig. 4: film behind the front for six M, C v^0.67, and the film that a steady formula predicts."""
    impacts = results["radial"]
    figure, panels = new_figure(2, 3)
    columns: dict[str, Values] = {}
    for (M, run), axes in zip(impacts.items(), panels, strict=True):
        columns |= {f"{name}, M = {M}": values for name, values in _draw_film(axes, M, run).items()}
    panels[0].legend(loc="lower left", frameon=False, fontsize="small")
    for axes in panels[3:]:
        axes.set_xlabel("$X$ ($a^*$)")
    for axes in panels[::3]:
        axes.set_ylabel("film $H$ ($a^{*2}/R$)")
    caption = (
        f"Computed film (enlarged), C v^0.67 with C fitted on {INNER} < X < {OUTER}, and the central film of "
        "Nijenbanning, Venner and Moes at the local parameters, without a fit: at (lambda_bar v, alpha_bar), and with "
        "the Hertz contact of that moment, at (lambda_bar v/A^4, alpha_bar A) and times A^2.  Here v is the speed of "
        "the front defined by the minimum film.  The table gives deviations on the same range, as far as the front "
        "came, by the definition of the front.  The formula holds for Barus' law and an incompressible oil, the runs "
        "have Roelands' law and a compressible oil."
    )
    rows = DataFrame([row for M, run in impacts.items() for row in _deviations(M, run)])
    tables = {"Deviation from the computed film: root mean square (mean)": rows}
    return Drawn(figure, caption, {"film": side_by_side(columns)}, tables)


def _draw_film(axes: Axes, M: int, run: xr.Dataset) -> dict[str, Values]:
    """Draw the panel of one M and return its data."""
    r, H = _profile(run)
    near = (r > 0.6) & (r < 1.02)
    p, speed = Parameters.from_moes(M, L), theory.front(run).speed_at(r[near])
    curves: dict[str, Curve] = {
        "$C v^{0.67}$": (fitted_power(r[near], H[near], speed), plots.ORANGE, "-"),
        "formula at $\\bar\\lambda v$": (_predicted(p, speed, np.ones_like(speed)), plots.BLUE, "--"),
        "formula, local Hertz": (_predicted(p, speed, r[near]), plots.GREEN, "-."),
    }
    axes.plot(r[near], H[near], color="black", label="computed")
    for name, (film, colour, line) in curves.items():
        axes.plot(r[near], film, color=colour, linestyle=line, label=name)
    axes.set(xlim=(0.65, 1.0), ylim=(0, 1.05 * float(np.interp(0.65, r, H))), title=f"$M$ = {M}")
    return {**{name: film for name, (film, *_) in curves.items()}, "X": r[near], "H": H[near], "speed": speed}


def _predicted(p: Parameters, speed: Values, A: Values) -> Values:
    """The film of the formula where the speed of the front is known, nan elsewhere."""
    curve = np.full_like(speed, np.nan)
    moves = np.isfinite(speed) & (speed > 0)
    curve[moves] = theory.film_from_speed(p, speed[moves], A[moves])
    return curve


def _deviations(M: int, run: xr.Dataset) -> Iterator[dict[str, str]]:
    """Rows of the table: deviation of C v^0.67 and of the formula from the film, for each speed of the front."""
    p, H = Parameters.from_moes(M, L), np.interp(FITTED_ON, *_profile(run))
    traces = {
        **{name: theory.film_behind_front(run, theory.front(run, by), FITTED_ON) for by, name in FRONTS.items()},
        "none: exact dry law": theory.Trace(FITTED_ON, H, hertz.front_speed(FITTED_ON)),
        "none: parabola (23)": theory.Trace(FITTED_ON, H, theory.parabola_front_speed(FITTED_ON)),
    }
    for name, trace in traces.items():
        if len(trace.X) < 3:
            continue
        C = theory.fit_power(trace)
        films = {
            "C v^0.67": C * trace.speed**theory.SPEED_EXPONENT,
            "formula": theory.film_from_speed(p, trace.speed),
            "formula, local Hertz": theory.film_from_speed(p, trace.speed, trace.X),
        }
        deviations = {title: theory.deviation(film, trace.H) for title, film in films.items()}
        cells = {title: f"{off.rms:.1%} ({off.mean:+.1%})" for title, off in deviations.items()}
        yield {"M": str(M), "front": name, "C": f"{C:.5f}", **cells, "X up to": f"{trace.X[-1]:.2f}"}
