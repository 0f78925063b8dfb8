"""Figs. 1 to 4 of the paper for cylinders: the dry impact, the speed of the front and the film behind it.

M and L are those of a line contact, lengths are in half widths b*, films in b*^2/R, times in b*^2/(R v0).
"""

from collections.abc import Mapping
from math import pi
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import ArrayLike
from pandas import DataFrame

from boundary_layers import front, theory
from boundary_layers.front import FITTED_ON, FRONTS, INNER, LINES, OUTER, Curve
from boundary_layers.line_runs import line_case
from boundary_layers.pages import Drawn, new_figure, side_by_side
from boundary_layers.plans import LINE_L, SHOWN_LINE, Plan
from boundary_layers.reduction import FORMED, Values
from ertel import fronts, plots

LENGTHS = (20.0, 100.0, 1000.0)  # of the contact in half widths, in Fig. 1; elsewhere it is 100
TOUCH = 1.0  # t0: the cylinder starts one b*^2/R above the surface
SPEED, SIZE = 0.7, -0.26  # exponents of Dowson and Higginson's film: U^0.7, and W^-0.13 with W as A^2


# -- Fig. 1 -----------------------------------------------------------------------------------------------------------


def dry_impact(length: float) -> tuple[Values, Values]:
    """Time from the maximum (t0) and half width A (b*) of the dry impact, until then, from its front speed."""
    speed = line_case("impact", 100.0, LINE_L, length=length).geometry.hertz.front_speed
    s = np.linspace(0.0, 1.0, 2001)  # A = 1 - s^2 takes the root out of the speed at the end
    middle = (s[1:] + s[:-1]) / 2
    steps = [2 * each / speed(1 - each**2) for each in middle] * np.diff(s)
    return -np.r_[0.0, np.cumsum(steps)][::-1], (1 - s**2)[::-1]


def dry_cylinders(results: Mapping[float, xr.Dataset], plan: Plan) -> Drawn:
    """Fig. 1: the half width of the dry contact and its rate, for three lengths, and the laws of the paper."""
    impacts = {length: dry_impact(length) for length in LENGTHS}
    caption = (
        "The dry impact of a cylinder, up to its maximum.  The approach of a cylinder depends on its length, Lambda "
        "b*: delta = kappa b*^2/R with kappa = 1/4 + ln(2 Lambda)/2.  The duration therefore grows with the length, "
        "but the law is nearly the same over the duration: the contact is close to a linear spring, a/a* = sqrt(cos), "
        "Johnson's (20), which is an approximation for a ball and the limit of long cylinders.  The parabola (22) is "
        "fitted where a > a*/2.  The second table gives its full base fitted to the front of the lubricated impact, "
        "over the duration of the dry one, for three definitions of the front."
    )
    duration = -2 * impacts[100.0][0][0]
    bases = [
        {
            "M": str(M),
            **{f"front by {name}": f"{2 * front.half_base(run, by) / duration:.3f}" for by, name in FRONTS.items()},
        }
        for M, run in results.items()
    ]
    tables = {
        "The dry impact": DataFrame(_of_length(length, *each) for length, each in impacts.items()),
        "Full base fitted to the front, over the duration": DataFrame(bases),
    }
    columns = {
        f"{name}, length {length:g}": values
        for length, each in impacts.items()
        for name, values in zip("TA", each, strict=True)
    }
    return Drawn(_draw_dry_impacts(impacts), caption, {"half_width": side_by_side(columns)}, tables)


def _of_length(length: float, T: Values, A: Values) -> dict[str, str]:
    """A row of the table."""
    duration, kappa = -2 * T[0], 0.25 + np.log(2 * length) / 2
    cells = {
        "duration (t0)": duration,
        "over kappa": duration / kappa,
        "full base of (22), over the duration": 2 * theory.fit_half_base(T, A) / duration,
        "largest error of (20)": np.abs(_spring(2 * T / duration) - A)[A > 0.5].max(),
    }
    return {"length (b*)": f"{length:g}", **{name: f"{value:.4f}" for name, value in cells.items()}}


def _spring(T: Values) -> Values:
    """Johnson's (20), T in half of the duration."""
    return np.asarray(np.sqrt(np.cos(pi * T / 2)))


def _draw_dry_impacts(impacts: Mapping[float, tuple[Values, Values]]) -> Figure:
    figure, (left, right) = new_figure(1, 2)
    for (length, (T, A)), colour in zip(impacts.items(), front.shades(len(impacts)), strict=True):
        _draw_dry(left, right, T / -T[0], A, {"color": colour, "label": f"exact, $\\Lambda$ = {length:g}"})
    limit, base = np.linspace(-1.0, 0.0, 401), theory.fit_half_base(T / -T[0], A)
    parabola = np.sqrt(np.maximum(1 - (limit / base) ** 2, 0.0))
    laws = {"spring, (20)": (_spring(limit), "black", ":"), "parabola (22), fitted": (parabola, plots.ORANGE, "--")}
    for label, (values, colour, line) in laws.items():
        _draw_dry(left, right, limit, values, {"color": colour, "linestyle": line, "label": label})
    left.set(xlabel="time from the maximum, over half of the duration", ylabel="half width $A$ ($b^*$)", ylim=(0, 1.05))
    right.set(xlabel="time from the maximum, over half of the duration", ylabel="$dA/dT$, times half of the duration")
    right.set(ylim=(0, 4))
    left.legend(loc="lower center", frameon=False, fontsize="small")
    return figure


def _draw_dry(left: Axes, right: Axes, T: Values, A: Values, look: Mapping[str, Any]) -> None:
    with np.errstate(divide="ignore", invalid="ignore"):
        speed = np.where(A > 0.02, np.gradient(A, T), np.nan)
    left.plot(T, A, **look)
    right.plot(T, speed, **look)


# -- Fig. 2 -----------------------------------------------------------------------------------------------------------


def dry_speed(A: ArrayLike) -> Values:
    """The speed dA/dT of the edge of the dry contact where it is at A, of any shape; zero from A = 1 on."""
    speed = line_case("impact", 100.0, LINE_L).geometry.hertz.front_speed
    return np.asarray(np.vectorize(speed, otypes=[float])(np.minimum(A, 1.0)))


def front_speed(results: Mapping[float, xr.Dataset], plan: Plan) -> Drawn:
    """Fig. 2: the speed of the front by three definitions, and of the dry contact."""
    every = {M: {by: theory.front(run, by) for by in FRONTS} for M, run in results.items()}
    figure, (left, right) = new_figure(1, 2)
    _draw_speed(left, every)
    front.draw_share(right, every, dry_speed)
    right.set_xlabel("position of the front $A$ ($b^*$)")
    caption = (
        f"Speed of the front of a cylinder for M = {min(results):g} to {max(results):g}, L = {LINE_L:g}, length 100 "
        "b*, up to maximum approach.  Left: front defined by the minimum film (solid) and by half the Hertz pressure "
        "(dashed).  Right: speed divided by that of the dry law at the same place, by three definitions of the front."
    )
    columns = {
        f"{name}, M = {M}, {by}": values
        for M, by_definition in every.items()
        for by, each in by_definition.items()
        for name, values in each._asdict().items()
    }
    shares = [
        {
            "M": str(M),
            **{f"front by {name}": front.share_of(by_definition[by], dry_speed) for by, name in FRONTS.items()},
            "last A by minimum film": f"{by_definition['film'].A[-1]:.3f}",
        }
        for M, by_definition in every.items()
    ]
    title = "Speed of the front divided by that of the dry contact, 0.5 < A < 0.9: mean (range)"
    return Drawn(figure, caption, {"fronts": side_by_side(columns)}, {title: DataFrame(shares)})


def _draw_speed(axes: Axes, every: front.Fronts) -> None:
    T, A = dry_impact(100.0)
    axes.plot((T - T[0])[1:], dry_speed(A[1:]), color="black", label="dry, exact")
    for (M, by_definition), colour in zip(every.items(), front.shades(len(every)), strict=True):
        labels: Mapping[theory.FrontDefinition, str | None] = {"film": f"$M$ = {M}", "half-hertz": None}
        for by, label in labels.items():
            each = by_definition[by]
            late = each.A > FORMED
            axes.plot(each.T[late] - TOUCH, each.speed[late], LINES[by], color=colour, linewidth=1.0, label=label)
    axes.set(xlabel="time from the dry cylinder's first touch ($t_0$)", ylabel="front speed $dA/dT$ ($b^*/t_0$)")
    axes.set(xlim=(0, -T[0]), ylim=(0, 0.6))
    axes.legend(loc="upper right", frameon=False, fontsize="small")


# -- Figs. 3 and 4 ----------------------------------------------------------------------------------------------------


def profile(run: xr.Dataset, name: str = "H") -> tuple[Values, Values]:
    """Distance X from the centre and a field, at maximum approach."""
    last = fronts.at_max_approach(run)
    half = last.isel(X=last["X"].values >= 0)
    return np.asarray(half["X"].values), np.asarray(half[name].values)


def _dry_speed_inside(X: Values) -> Values:
    inside = (X > 0.05) & (X < 1)
    return np.where(inside, dry_speed(np.where(inside, X, 0.5)), np.nan)


def _fitted_with_size(X: Values, H: Values, speed: Values) -> Values:
    """C v^0.7 A^-0.26 with C fitted on the range of the paper."""
    near = (X > INNER) & (X < OUTER) & np.isfinite(speed) & (speed > 0)
    shape = np.where(X > 0, speed, np.nan) ** SPEED * np.where(X > 0, X, np.nan) ** SIZE
    return np.asarray(np.exp(np.mean(np.log(H[near] / shape[near]))) * shape)


def film_and_speed(results: Mapping[float, xr.Dataset], plan: Plan) -> Drawn:
    """Fig. 3: the film at maximum impact for one M, and what the speed of the front makes of it."""
    run = results[SHOWN_LINE]
    X, H = profile(run)
    speed, dry = theory.front(run).speed_at(X), _dry_speed_inside(X)
    fitted: dict[str, Curve] = {
        "$C v^{0.67}$, $v$ of the computed front": (front.fitted_power(X, H, speed), plots.ORANGE, "--"),
        "$C v^{0.67}$, $v$ of the dry contact": (front.fitted_power(X, H, dry), plots.BLUE, "--"),
        "$C v^{0.7} A^{-0.26}$, $v$ of the dry contact": (_fitted_with_size(X, H, dry), plots.GREEN, "-."),
    }
    figure, (axes,) = new_figure(1, 1)
    front.draw_both_sides(axes, X, (H, "black", "-"), "computed")
    for name, curve in fitted.items():
        front.draw_both_sides(axes, X, curve, name)
    axes.set(xlim=(-1.2, 1.2), ylim=(0, 1.5 * float(H[0])), xlabel="$X$ ($b^*$)", ylabel="film $H$ ($b^{*2}/R$)")
    axes.legend(loc="upper center", frameon=False, fontsize="small")
    caption = (
        f"Film of a cylinder at maximum impact, M = {SHOWN_LINE}, L = {LINE_L:g}, and C v^0.67 with C fitted on "
        f"{INNER} < X < {OUTER}.  C v^0.7 A^-0.26 is Dowson and Higginson's formula in the speed and the load at that "
        f"time.  H(0) = {H[0]:.5f}."
    )
    data = DataFrame({"X": X, "H": H, **{name: values for name, (values, *_) in fitted.items()}})
    return Drawn(figure, caption, {"film": data})


def film_predicted(results: Mapping[float, xr.Dataset], plan: Plan) -> Drawn:
    """Fig. 4: the film behind the front for each M, and what formulas make of the dry contact's speed."""
    figure, panels = new_figure(2, 2)
    columns: dict[str, Values] = {}
    for (M, run), axes in zip(results.items(), panels, strict=False):
        columns |= {f"{name}, M = {M}": values for name, values in _draw_film(axes, M, run).items()}
    for axes in panels[len(results) :]:
        axes.set_axis_off()
    panels[0].legend(loc="lower left", frameon=False, fontsize="small")
    for axes in panels[::2]:
        axes.set_ylabel("film $H$ ($b^{*2}/R$)")
    for axes in panels[:4]:
        axes.set_xlabel("$X$ ($b^*$)")
    caption = (
        f"Computed film (enlarged), C v^0.67 and C v^0.7 A^-0.26 with C fitted on {INNER} < X < {OUTER}, and the "
        "central film of Moes at the parameters of the dry contact at that time, without a fit: at lambda_bar v/A^4, "
        "alpha_bar A, times A^2.  v is the speed of the dry contact in all of them.  Moes' fit is for Barus' law and "
        "an incompressible oil; the oil is that of Roelands, and compressible.  The table gives deviations on the "
        "same range."
    )
    rows = DataFrame(_deviations(M, run) for M, run in results.items())
    tables = {"Deviation from the computed film: root mean square (mean)": rows}
    return Drawn(figure, caption, {"film": side_by_side(columns)}, tables)


def _laws(M: float, X: Values, H: Values) -> dict[str, Values]:
    """The film by each law, from the speed of the dry contact."""
    speed = _dry_speed_inside(X)
    p, known = line_case("impact", M, LINE_L).parameters, np.isfinite(speed)
    moes = np.full_like(speed, np.nan)
    moes[known] = theory.film_from_speed(p, speed[known], X[known])
    return {
        "C v^0.67": front.fitted_power(X, H, speed),
        "C v^0.7 A^-0.26": _fitted_with_size(X, H, speed),
        "Moes, local Hertz": moes,
    }


def _draw_film(axes: Axes, M: float, run: xr.Dataset) -> dict[str, Values]:
    X, H = profile(run)
    near = (X > 0.4) & (X < 1.02)
    axes.plot(X[near], H[near], color="black", label="computed")
    laws = {name: film[near] for name, film in _laws(M, X, H).items()}
    looks = ((plots.ORANGE, "-"), (plots.GREEN, "-."), (plots.BLUE, "--"))
    for (name, film), (colour, line) in zip(laws.items(), looks, strict=True):
        axes.plot(X[near], film, color=colour, linestyle=line, label=name)
    axes.set(xlim=(0.5, 1.0), ylim=(0, 1.1 * float(np.interp(0.5, X, H))), title=f"$M$ = {M}")
    return {"X": X[near], "H": H[near], **laws}


def _deviations(M: float, run: xr.Dataset) -> dict[str, str]:
    X, H = FITTED_ON, np.interp(FITTED_ON, *profile(run))
    off = {name: theory.deviation(film, H) for name, film in _laws(M, X, H).items()}
    slope = np.polyfit(np.log(dry_speed(X)), np.log(H), 1)[0]
    cells = {name: f"{each.rms:.1%} ({each.mean:+.1%})" for name, each in off.items()}
    return {"M": str(M), **cells, "exponent of v alone": f"{slope:.2f}"}
