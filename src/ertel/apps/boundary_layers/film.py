"""Figures 3 and 4 of the paper: the film at maximum impact, and what predicts it from the speed of the front."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from pandas import DataFrame

from ertel import Parameters, fronts, hertz, plots
from ertel.apps.boundary_layers.page import Drawn, side_by_side
from ertel.apps.boundary_layers.plans import SHOWN_LOAD, L, Plan
from ertel.apps.boundary_layers.smooth import NAMES, Results, Values, new_figure, plane_name, radial_name, radial_runs

INNER, OUTER = 0.75, 0.95  # a*: where the film follows the speed of the front
FITTED_ON = np.linspace(INNER, OUTER, 81)


class Profile(NamedTuple):
    """Film H over the distance X from the centre, at maximum approach."""

    X: Values
    H: Values


class Curve(NamedTuple):
    """A film H, and how it is drawn."""

    H: Values
    colour: str
    line: str


def film_and_speed(results: Results, plan: Plan) -> Drawn:
    """Fig. 3: film at maximum impact for one M, by both methods, and C v^0.67."""
    radial = results[radial_name(SHOWN_LOAD, L, plan)]
    plane = fronts.at_max_approach(results[plane_name(plan)])["H"].sel(Y=0.0, method="nearest")
    X, H = _profile(radial)
    dry = hertz.parabola_front_speed_at(np.where((X > 0) & (X < 1), X, np.nan))
    curves = {
        "$C v^{0.67}$, $v$ of the computed front": Curve(
            _fitted(X, H, fronts.front(radial).speed_at(X)), plots.ORANGE, "--"
        ),
        "$C v^{0.67}$, $v$ of the parabola (23)": Curve(_fitted(X, H, dry), plots.BLUE, "--"),
    }
    figure, (axes,) = new_figure(1, 1)
    _draw_both_sides(axes, X, Curve(H, "black", "-"), "computed, radial method")
    axes.plot(plane["X"], plane, ".", color=plots.GREY, markersize=4, label="computed, 2-D method")
    for name, curve in curves.items():
        _draw_both_sides(axes, X, curve, name)
    axes.set(xlim=(-1.2, 1.2), ylim=(0, 1.5 * float(H[0])), xlabel="$X$ ($a^*$)", ylabel="film $H$ ($a^{*2}/R$)")
    axes.legend(loc="lower center", frameon=False, fontsize="small")
    centre = float(plane.sel(X=0.0, method="nearest"))
    caption = (
        f"Film at maximum impact, M = {SHOWN_LOAD}, L = {L:g}, and C v^0.67 with C fitted on {INNER} < X < {OUTER}.  "
        "The bell in the centre formed before there was a front.  Central film by the radial and by the 2-D method: "
        f"H(0) = {H[0]:.5f} and {centre:.5f} ({centre / H[0] - 1:+.2%})."
    )
    data = DataFrame({"X": X, "H": H, **{name: curve.H for name, curve in curves.items()}})
    return Drawn(figure, caption, {"film": data})


def _draw_both_sides(axes: Axes, X: Values, curve: Curve, label: str) -> None:
    x, H = np.r_[-X[::-1], X], np.r_[curve.H[::-1], curve.H]
    axes.plot(x, H, color=curve.colour, linestyle=curve.line, label=label)


def film_predicted(results: Results, plan: Plan) -> Drawn:
    """Fig. 4: film behind the front for six M, C v^0.67, and the film that a steady formula predicts."""
    runs = radial_runs(results, plan)
    figure, panels = new_figure(2, 3)
    columns: dict[str, Values] = {}
    for (M, run), axes in zip(runs.items(), panels, strict=True):
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
    rows = DataFrame([row for M, run in runs.items() for row in _deviations(M, run)])
    tables = {"Deviation from the computed film: root mean square (mean)": rows}
    return Drawn(figure, caption, {"film": side_by_side(columns)}, tables)


def _draw_film(axes: Axes, M: int, run: xr.Dataset) -> dict[str, Values]:
    """Draw the panel of one M; its data."""
    r, H = _profile(run)
    near = (r > 0.6) & (r < 1.02)
    p, speed = Parameters.from_moes(M, L), fronts.front(run).speed_at(r[near])
    curves = {
        "$C v^{0.67}$": Curve(_fitted(r[near], H[near], speed), plots.ORANGE, "-"),
        "formula at $\\bar\\lambda v$": Curve(_predicted(p, speed, np.ones_like(speed)), plots.BLUE, "--"),
        "formula, local Hertz": Curve(_predicted(p, speed, r[near]), plots.GREEN, "-."),
    }
    axes.plot(r[near], H[near], color="black", label="computed")
    for name, curve in curves.items():
        axes.plot(r[near], curve.H, color=curve.colour, linestyle=curve.line, label=name)
    axes.set(xlim=(0.65, 1.0), ylim=(0, 1.05 * float(np.interp(0.65, r, H))), title=f"$M$ = {M}")
    return {**{name: curve.H for name, curve in curves.items()}, "X": r[near], "H": H[near], "speed": speed}


def _deviations(M: int, run: xr.Dataset) -> Iterator[dict[str, str]]:
    """Rows of the table: deviation of C v^0.67 and of the formula from the film, for each speed of the front."""
    p = Parameters.from_moes(M, L)
    for name, trace in _traces(run).items():
        if len(trace.X) < 3:
            continue
        C = fronts.fit_power(trace)
        yield {
            "M": str(M),
            "front": name,
            "C": f"{C:.5f}",
            "C v^0.67": _deviation(C * trace.speed**fronts.SPEED_EXPONENT, trace),
            "formula": _deviation(fronts.film_from_speed(p, trace.speed), trace),
            "formula, local Hertz": _deviation(fronts.film_from_speed(p, trace.speed, trace.X), trace),
            "X up to": f"{trace.X[-1]:.2f}",
        }


def _traces(run: xr.Dataset) -> dict[str, fronts.Trace]:
    """The film and the speed of the front, by three definitions of the front and two laws of the dry contact."""
    H = np.interp(FITTED_ON, *_profile(run))
    return {
        **{name: fronts.film_behind_front(run, fronts.front(run, by), FITTED_ON) for by, name in NAMES.items()},
        "none: exact dry law": fronts.Trace(FITTED_ON, H, hertz.front_speed(FITTED_ON)),
        "none: parabola (23)": fronts.Trace(FITTED_ON, H, hertz.parabola_front_speed_at(FITTED_ON)),
    }


def _deviation(film: Values, trace: fronts.Trace) -> str:
    found = fronts.deviation(film, trace.H)
    return f"{found.rms:.1%} ({found.mean:+.1%})"


def _profile(run: xr.Dataset) -> Profile:
    last = fronts.at_max_approach(run)
    return Profile(np.asarray(last["r"].values), np.asarray(last["H"].values))


def _fitted(X: Values, H: Values, speed: Values) -> Values:
    """C v^0.67 with C fitted on the range of the paper."""
    near = (X > INNER) & (X < OUTER) & np.isfinite(speed) & (speed > 0)
    C = fronts.fit_power(fronts.Trace(X[near], H[near], speed[near]))
    return np.asarray(C * speed**fronts.SPEED_EXPONENT)


def _predicted(p: Parameters, speed: Values, A: Values) -> Values:
    """The film of the formula where the speed of the front is known, nan elsewhere."""
    curve = np.full_like(speed, np.nan)
    known = np.isfinite(speed) & (speed > 0)
    curve[known] = fronts.film_from_speed(p, speed[known], A[known])
    return curve
