"""Figures 1 and 2 of the paper: the dry impact, and the speed of the front in the lubricated impact."""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from pandas import DataFrame

from ertel import fronts, hertz, plots
from ertel.apps.boundary_layers.page import Drawn, side_by_side
from ertel.apps.boundary_layers.plans import LOADS, SHOWN_LOAD, L, Plan
from ertel.apps.boundary_layers.smooth import (
    FORMED,
    NAMES,
    Definition,
    Results,
    Values,
    new_figure,
    plane_name,
    radial_runs,
)

TOUCH = 1.0  # t0: the ball starts one delta* above the surface
LINES: Mapping[Definition, str] = {"film": "-", "slope": ":", "half-hertz": "--"}
COMPARED = np.linspace(0.5, 0.9, 41)  # places where the front's speed is compared with the dry contact's


# -- Fig. 1 -----------------------------------------------------------------------------------------------------------


class Law(NamedTuple):
    """Contact radius A (a*) of the dry impact over time, and how it is drawn."""

    A: Values
    colour: str
    line: str


def dry_impact(results: Results, plan: Plan) -> Drawn:
    """Fig. 1: contact radius of the dry impact and its rate, exact and by the asymptotes; t* fitted to them."""
    T = np.linspace(-hertz.HALF_CONTACT_TIME, hertz.HALF_CONTACT_TIME, 1201)
    exact = hertz.contact_radius(T + hertz.HALF_CONTACT_TIME)
    fitted = fronts.fit_half_base(T, exact)
    laws = {
        "exact": Law(exact, "black", "-"),
        "Johnson (20)": Law(hertz.johnson_radius(T), plots.BLUE, "--"),
        "parabola (22), t* = 1.35": Law(hertz.parabola_radius(T), plots.ORANGE, "-"),
        f"parabola, t* = {fitted:.3f} fitted": Law(hertz.parabola_radius(T, fitted), plots.GREEN, ":"),
    }
    figure, (left, right) = new_figure(1, 2)
    _draw_laws(left, right, T, laws)
    caption = (
        f"The dry impact lasts {hertz.CONTACT_TIME:.4f} t0 (Johnson's 2.94).  The paper's 2.7 is the full base of its "
        "parabola (22), t* = 1.35 before and after the maximum.  A fit to the exact law where a > a*/2 gives a full "
        f"base of {2 * fitted:.3f}.  The second table gives fits to the front of the lubricated impact, its radius "
        "divided by the largest one, for three definitions of the front."
    )
    tables = {"Errors of the laws": _errors(laws, exact), "Full base fitted to the front": _bases(results, plan)}
    data = DataFrame({"T": T, **{name: law.A for name, law in laws.items()}})
    return Drawn(figure, caption, {"radius": data}, tables)


def _draw_laws(left: Axes, right: Axes, T: Values, laws: Mapping[str, Law]) -> None:
    for name, (A, colour, line) in laws.items():
        with np.errstate(divide="ignore", invalid="ignore"):
            speed = np.where((A > 0.02) & (A < 1.01), np.gradient(A, T), np.nan)
        left.plot(T, A, color=colour, linestyle=line, label=name)
        right.plot(T, speed * hertz.HALF_BASE, color=colour, linestyle=line)
    right.plot(T, hertz.linear_front_speed(T) * hertz.HALF_BASE, color=plots.GREY, linewidth=0.8, label="linear (24)")
    left.set(xlabel="time from the maximum $T$ ($t_0$)", ylabel="$a/a^*$", ylim=(0, 1.05))
    right.set(xlabel="time from the maximum $T$ ($t_0$)", ylabel="$v/v^*$, $v^* = a^*/(1.35\\,t_0)$", ylim=(-3, 3))
    left.legend(loc="lower center", frameon=False, fontsize="small")
    right.legend(loc="upper right", frameon=False, fontsize="small")
    right.text(0.03, 0.03, "colours as on the left", transform=right.transAxes, fontsize="small")


def _errors(laws: Mapping[str, Law], exact: Values) -> DataFrame:
    errors = {name: np.abs(law.A - exact)[exact > 0.5].max() for name, law in laws.items() if name != "exact"}
    largest = "largest error of a/a* where a > a*/2"
    return DataFrame([{"law": name, largest: f"{error:.4f}"} for name, error in errors.items()])


def _bases(results: Results, plan: Plan) -> DataFrame:
    return DataFrame(
        {"M": str(M), **{f"front by {name}": f"{2 * _half_base(run, by):.3f}" for by, name in NAMES.items()}}
        for M, run in radial_runs(results, plan).items()
    )


def _half_base(run: xr.Dataset, by: Definition) -> float:
    front = fronts.front(run, by)
    maximum = float(fronts.at_max_approach(run)["frame"])
    return fronts.fit_half_base(front.T - maximum, front.A / front.A[-1])


# -- Fig. 2 -----------------------------------------------------------------------------------------------------------

Found = Mapping[int, Mapping[Definition, fronts.Front]]  # M, definition -> front


def front_speed(results: Results, plan: Plan) -> Drawn:
    """Fig. 2: speed of the front in the lubricated impact for six M, by three definitions of the front."""
    found: Found = {M: {by: fronts.front(run, by) for by in NAMES} for M, run in radial_runs(results, plan).items()}
    figure, (left, right) = new_figure(1, 2)
    _draw_speed(left, found, fronts.front(results[plane_name(plan)]))
    _draw_share(right, found)
    caption = (
        f"Speed of the front for M = {LOADS[0]} to {LOADS[-1]}, L = {L:g}, up to maximum approach.  Left: front "
        "defined by the minimum film (solid) and by half the Hertz pressure (dashed).  Right: speed divided by that of "
        "the exact dry law at the same position, by three definitions of the front.  All speeds approach the dry law "
        "as the load rises.  At low M the front is wide, so that the definitions differ, and it stops before it "
        "reaches a*."
    )
    columns = {
        f"{name}, M = {M}, {by}": values
        for M, by_definition in found.items()
        for by, front in by_definition.items()
        for name, values in front._asdict().items()
    }
    tables = {"Speed of the front divided by that of the dry contact, 0.5 < A < 0.9: mean (range)": _shares(found)}
    return Drawn(figure, caption, {"fronts": side_by_side(columns)}, tables)


def _draw_speed(axes: Axes, found: Found, plane: fronts.Front) -> None:
    T = np.linspace(0.01, hertz.HALF_CONTACT_TIME, 600)
    axes.plot(T, hertz.front_speed(hertz.contact_radius(T)), color="black", label="dry, exact")
    linear = hertz.linear_front_speed(T - hertz.HALF_CONTACT_TIME)
    axes.plot(T, linear, color=plots.GREY, linestyle=":", label="linear (24), $t^*$ = 1.35")
    for (M, by_definition), colour in zip(found.items(), _shades(), strict=True):
        for by in ("film", "half-hertz"):
            front = by_definition[by]
            late = front.A > FORMED
            label = f"$M$ = {M}" if by == "film" else None
            axes.plot(front.T[late] - TOUCH, front.speed[late], LINES[by], color=colour, linewidth=1.0, label=label)
    axes.plot(
        plane.T - TOUCH, plane.speed, ".", color=plots.GREY, markersize=3, label=f"$M$ = {SHOWN_LOAD}, 2-D method"
    )
    axes.set(xlabel="time from the dry ball's first touch ($t_0$)", ylabel="front speed $dA/dT$ ($a^*/t_0$)")
    axes.set(xlim=(0, 1.5), ylim=(0, 1.4))
    axes.legend(loc="upper right", frameon=False, fontsize="small")


def _draw_share(axes: Axes, found: Found) -> None:
    for by_definition, colour in zip(found.values(), _shades(), strict=True):
        for by, front in by_definition.items():
            late = front.A > FORMED
            share = front.speed / hertz.front_speed(np.minimum(front.A, 1.0))
            axes.plot(front.A[late], share[late], LINES[by], color=colour, linewidth=1.0)
    for by, name in NAMES.items():
        axes.plot([], [], LINES[by], color=plots.GREY, label=name)
    axes.axhline(1.0, color="black", linewidth=0.8)
    axes.set(xlabel="position of the front $A$ ($a^*$)", ylabel="speed over that of the dry contact", ylim=(0, 1.1))
    axes.set(xlim=(FORMED, 1.0))
    axes.legend(loc="lower left", frameon=False, fontsize="small")


def _shares(found: Found) -> DataFrame:
    return DataFrame(
        {
            "M": str(M),
            **{f"front by {name}": _share(by_definition[by]) for by, name in NAMES.items()},
            "last A by minimum film": f"{by_definition['film'].A[-1]:.3f}",
        }
        for M, by_definition in found.items()
    )


def _share(front: fronts.Front) -> str:
    share = front.speed_at(COMPARED) / hertz.front_speed(COMPARED)
    return f"{np.nanmean(share):.2f} ({np.nanmin(share):.2f} to {np.nanmax(share):.2f})"


def _shades() -> Values:
    return np.asarray(plots.ORDERED_COLOURS(np.linspace(1.0, 0.0, len(LOADS))))
