"""Figs. 5 and 6 of the paper for cylinders, waves, and Fig. 7, the film that the front of an impact leaves."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.figure import Figure
from pandas import DataFrame
from scipy.interpolate import CubicSpline

from boundary_layers import front, reduction, theory, waves
from boundary_layers.line_runs import HIGH, SHAPE, line_case
from boundary_layers.lines import SPEED, dry_speed, profile
from boundary_layers.pages import Drawn, new_figure, texts
from boundary_layers.plans import SHOWN_LINE, Moes, Plan
from boundary_layers.reduction import FORMED
from boundary_layers.runs import HEIGHT, USUAL
from ertel import plots

Contact = tuple[float, float, str]  # M, L, oil

CURVES: Mapping[str, waves.Reduction] = {
    "the curve of 1997": waves.Reduction(*theory.LINE_1997),
    "the later fit": waves.Reduction(*theory.LINE_REFIT),
}
RANGE = np.geomspace(0.3, 30.0, 200)  # nabla1 of the curves


# -- Figs. 5 and 6 ----------------------------------------------------------------------------------------------------


def deformed_waves(results: Mapping[Moes, Sequence[xr.Dataset]], plan: Plan) -> Drawn:
    """Fig. 5: dH/A_i of transverse waves at maximum impact."""
    M, L = next(case for case in plan.lines.waves if case[0] == SHOWN_LINE)
    _, fine = results[M, L]
    edge, nodes = float(theory.front(fine).A[-1]), plan.lines.impact_grids[1]
    caption = (
        f"dH(X)/A_i of a cylinder at maximum impact, M = {M:g}, L = {L:g}, waves A_i cos(2 pi X/Lambda) across the "
        f"motion of the front with a crest at the centre, A_i = {HEIGHT} of the trapped film, {nodes} nodes.  The "
        "vertical lines mark the minimum film.  Isotropic waves vary along the cylinder and have no line contact."
    )
    return reduction.drawn_waves(fine, SHAPE, plan.lines.waves[M, L], edge, caption, f"{nodes} nodes", "b")


def _marks(results: Mapping[str, Any], plan: Plan) -> Iterator[dict[str, Any]]:
    """A row for each wave inside the impact, with rolling at the same place where that is within the places."""
    for case, grids in results["waves"].items():
        p, places = line_case("impact", *case).parameters, plan.lines.wave_places
        edge = float(theory.front(grids[-1]).A[-1])
        rolled = np.array([results["rolling"][case][A] for A in places])  # (place, grid, wavelength)
        for number, wavelength in enumerate(plan.lines.waves[case]):
            inside = [waves.waves(*reduction.response(grid, SHAPE, wavelength), edge) for grid in grids]
            pairs = list(zip(*(on_a_grid[::-1] for on_a_grid in inside), strict=False))  # from the edge inwards
            for coarse, fine in reversed(pairs):
                X, speed = fine.X, float(dry_speed(fine.X))
                row = {"M": case[0], "L": case[1], "wavelength": wavelength, "X": X}
                row |= reduction.extrapolated(coarse.amplitude, fine.amplitude)
                row |= {"everywhere": p.nabla2(wavelength), "last": int(fine is pairs[0][1])}
                row |= {"local": float(waves.local_nabla2(p, wavelength, speed))}
                row |= {"hertz": float(waves.local_nabla2(p, wavelength, speed, X))}
                by_grid = (
                    CubicSpline(places, rolled[:, :, number])(X) if places[0] <= X <= places[-1] else (np.nan, np.nan)
                )
                yield row | {f"rolling_{name}": value for name, value in reduction.extrapolated(*by_grid).items()}


def waves_reduced(results: Mapping[str, Any], plan: Plan) -> Drawn:
    """Fig. 6: A_d/A_i in impacts, and in rolling with the speed, size and pressure of the front."""
    marks = DataFrame(_marks(results, plan))
    marks = marks[marks["X"] > FORMED]
    twins = marks[np.isfinite(marks["rolling_limit"])]
    off = twins["limit"] - twins["rolling_limit"]
    caption = (
        "Amplitude reduction of transverse waves under a cylinder.  Dots: complete waves of the impact at maximum "
        f"approach, X > {FORMED:g}, extrapolated from grids of {plan.lines.impact_grids[0]} and "
        f"{plan.lines.impact_grids[1]} nodes; the error bar reaches to the limit of a method of first order.  Left: "
        "the paper's local parameter, lambda_bar times the speed v of the front, here that of the dry contact; nabla1 "
        "= 1.2151 (Lambda/b)/sqrt(alpha_bar lambda_bar).  Right: half width and pressure are those of the dry contact "
        "when the front passed too, lambda_bar v/A^4, alpha_bar A, Lambda/A.  Crosses: rolling at exactly these "
        "parameters, to first order in the height of the waves, at each dot.  Lines: 1/(1 + 0.17 n + 0.03 n^2) of "
        "1997 (dashed) and a later fit, 1/(1 + 0.125 n + 0.04 n^2) (dotted).  The paper's (15) is for isotropic "
        "waves, which a line contact does not have."
    )
    by_curve = {name: curve.ratio(twins["hertz"]) for name, curve in CURVES.items()}
    cells = {
        **reduction.WAVE,
        "X": "{X:.3f}",
        "nabla1, momentary Hertz contact": "{hertz:.2f}",
        "impact": "{limit:.3f} ± {error:.3f}",
        "rolling": "{rolling_limit:.3f} ± {rolling_error:.3f}",
        "impact minus rolling": "{off:+.3f}",
        "curve of 1997": "{by_curve:.3f}",
    }
    deviations = [
        {"": "impact minus rolling at the parameters of the front", "mean, root mean square": reduction.scatter(off)},
        *(
            {"": f"{kind} minus {name}", "mean, root mean square": reduction.scatter(twins[column] - curve)}
            for kind, column in (("impact", "limit"), ("rolling", "rolling_limit"))
            for name, curve in by_curve.items()
        ),
        *(
            {"": f"impact minus {name}, the paper's local nabla1",
             "mean, root mean square": reduction.scatter(twins["limit"] - curve.ratio(twins["local"]))}
            for name, curve in CURVES.items()
        ),
    ]  # fmt: skip
    tables = {
        "Impact and rolling at the parameters of the front": texts(
            twins.assign(off=off, by_curve=by_curve["the curve of 1997"]), cells
        ),
        f"The same {len(twins)} waves": DataFrame(deviations),
    }
    return Drawn(_draw_marks(marks, twins), caption, {"waves": marks}, tables)


def _draw_marks(marks: DataFrame, twins: DataFrame) -> Figure:
    figure, panels = new_figure(1, 2)
    groups = marks.groupby(["M", "L"], sort=False)
    for axes, parameter in zip(panels, ("local", "hertz"), strict=True):
        for (name, curve), style in zip(CURVES.items(), ("--", ":"), strict=True):
            axes.semilogx(RANGE, curve.ratio(RANGE), color=plots.GREY, linestyle=style, label=name)
        for ((M, L), dots), colour, marker in zip(
            groups, front.shades(len(groups) + 1)[1:], reduction.MARKERS, strict=False
        ):
            look: dict[str, Any] = {"fmt": marker, "color": colour, "capsize": 2, "elinewidth": 0.8, "markersize": 4}
            axes.errorbar(
                dots[parameter], dots["limit"], dots["error"], label=f"impact, $M$ = {M:g}, $L$ = {L:g}", **look
            )
        axes.set(ylim=(0, 1.1), xlim=(0.4, 30), ylabel="$A_d/A_i$")
        axes.set_xticks([0.5, 1, 2, 5, 10, 20], ["0.5", "1", "2", "5", "10", "20"])
    panels[1].plot(
        twins["hertz"], twins["rolling_limit"], "x", color=plots.ORANGE, label="rolling, parameters of the front"
    )
    panels[0].set_xlabel("local $\\nabla_1$, $\\bar\\lambda v$")
    panels[1].set_xlabel("local $\\nabla_1$ with the momentary Hertz contact")
    panels[1].legend(loc="lower left", frameon=False, fontsize="small")
    return figure


# -- Fig. 7 -----------------------------------------------------------------------------------------------------------


def film_left(results: Mapping[str, Any], plan: Plan) -> Drawn:
    """Fig. 7: the oil that the front leaves, over the oil that rolling leaves at the parameters of the front."""
    rows = DataFrame(_left(results, plan))
    figure, (left, right) = new_figure(1, 2)
    contacts = list(results["impacts"])
    usual = [contact for contact in contacts if contact[2] == USUAL]
    colours = dict(zip(usual, front.shades(len(usual)), strict=True))
    others = iter((plots.ORANGE, "black"))
    for contact in contacts:
        of_contact = rows[rows["contact"] == _name(contact)]
        colour = colours[contact] if contact in colours else next(others)
        if contact in colours:
            X, oil = profile(results["impacts"][contact][-1], "left")
            left.semilogy(X, oil, color=colour, label=f"impact, $M$ = {contact[0]:g}")
            left.plot(of_contact["X"], of_contact["rolling"], "o", color=colour, markerfacecolor="none")
        style = "o-" if contact in colours else "s--"
        bars = of_contact["error"] / of_contact["rolling"]
        right.errorbar(
            of_contact["X"], of_contact["ratio"], bars, fmt=style, color=colour, capsize=2, label=_name(contact)
        )
    left.set(xlim=(0, 1.1), xlabel="$X$ ($b^*$)", ylabel="$\\bar\\rho H$ ($b^{*2}/R$)")
    left.plot([], [], "o", color="black", markerfacecolor="none", label="steady rolling at the front's speed")
    left.legend(loc="lower left", frameon=False, fontsize="small")
    right.axhline(1.0, color="black", linewidth=0.8)
    right.set(xlabel="$X$ ($b^*$)", ylabel="impact over rolling", ylim=(0.8, 2.6))
    right.legend(loc="upper left", frameon=False, fontsize="x-small", ncols=2)
    tables = {
        "Oil left by the impact over that of rolling at the speed of the dry front": _by_place(rows, "ratio", "error"),
        "The same, with the speed of the computed front, by half the Hertz pressure, if the film goes as v^0.7":
            _by_place(rows, "ratio, computed front"),
    }  # fmt: skip
    caption = (
        "Beyond the paper: the oil that the front of an impact leaves at X is that of steady rolling at the front, "
        "rho H(X) = A^2 q(lambda_bar v/A^4, alpha_bar A), with A = X, the speed v = dA/dT of the dry impact and the "
        "flow q of the steady line contact.  No constant is fitted.  Left: oil at maximum approach, and rolling.  "
        f"Right: their ratio; the impact is extrapolated as in Fig. 6, from {plan.lines.impact_grids[0]} and "
        f"{plan.lines.impact_grids[1]} nodes, twice as many cells above M = {HIGH:g}.  The law holds for piezoviscous "
        "oils at high loads.  At M = 20 the front is slower than the dry one and stops before it reaches b*.  In an "
        "isoviscous oil nothing holds the oil where the front left it, and the law fails."
    )
    return Drawn(figure, caption, {"left": rows}, tables)


def _name(contact: Contact) -> str:
    M, L, oil = contact
    return f"M = {M:g}, L = {L:g}, {'Roelands' if oil == USUAL else oil.partition(',')[0]}"


def _left(results: Mapping[str, Any], plan: Plan) -> Iterator[dict[str, Any]]:
    places = np.array(plan.lines.law_places)
    for contact, grids in results["impacts"].items():
        rolled = np.array(results["rolled"][contact])
        coarse, fine = (CubicSpline(*profile(grid, "left"))(places) for grid in grids)
        speed = theory.front(grids[-1], "half-hertz").speed_at(places)
        found = reduction.extrapolated(coarse, fine)
        ratio = found["limit"] / rolled
        columns = {"X": places, "rolling": rolled, **found, "ratio": ratio}
        columns["ratio, computed front"] = ratio * (dry_speed(places) / speed) ** SPEED
        for row in DataFrame(columns).to_dict("records"):
            yield {"contact": _name(contact), **row}


def _by_place(rows: DataFrame, name: str, error: str = "") -> DataFrame:
    """A row for each contact, a column for each place."""

    def cells(of_contact: DataFrame) -> Iterator[str]:
        for row in of_contact.to_dict("records"):
            yield f"{row[name]:.3f}" + (f" ± {row[error] / row['rolling']:.3f}" if error else "")

    return DataFrame(
        {"contact": contact, **dict(zip((f"X = {X:g}" for X in each["X"]), cells(each), strict=True))}
        for contact, each in rows.groupby("contact", sort=False)
    )
