"""Figures beyond the paper: Figs. 7 and 8, waves of other shapes and other lubricants, and Fig. 9, starved films.

Fig. 9 compares starved impacts and starved rolling with the oil that is offered.  R is the oil in the centre over that
of the flooded contact, an impact's at maximum approach, and r the layer over the same.  Each kind of contact is
compared with R = r/(1 + r^g)^(1/g), `film_formulas.starved_share`.
"""

from collections.abc import Iterator, Mapping
from functools import partial
from math import inf
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, NullLocator
from pandas import DataFrame
from scipy.optimize import least_squares

from boundary_layers import reduction, theory
from boundary_layers.pages import Drawn, new_figure, texts
from boundary_layers.plans import Plan
from boundary_layers.runs import HEIGHT, LAYERS, OILS, USUAL, wave_name
from ertel import amplitude_reduction, formulas, plots

CURVES: Mapping[str, reduction.Curve] = {
    "(15), isotropic": amplitude_reduction.ratio_left,
    "line contact": theory.in_line_contact,
    "(15), longitudinal": partial(amplitude_reduction.ratio_left, ratio=inf),
}
OF_SHAPES = {"transverse": ("o", plots.BLUE), "rings": ("D", plots.GREEN), "longitudinal": ("^", plots.ORANGE)}
OF_OILS = dict(zip(OILS, (("o", "black"), ("s", plots.BLUE), ("D", plots.GREEN), ("^", plots.ORANGE)), strict=True))


def _draw_marks(axes: Axes, marks: DataFrame, styles: Mapping[str, tuple[str, str]]) -> None:
    """Marks with error bars.  styles: kind -> marker, colour."""
    reduction.draw_curves(axes)
    for kind, (marker, colour) in styles.items():
        drawn = marks[marks["kind"] == kind]
        if len(drawn):
            look: dict[str, Any] = {"fmt": marker, "color": colour, "mfc": "none", "capsize": 2, "label": kind}
            axes.errorbar(drawn["local"], drawn["limit"], drawn["error"], **look)


# -- Fig. 7 -----------------------------------------------------------------------------------------------------------


def impacts_on_shapes(results: reduction.Results, plan: Plan) -> Iterator[reduction.Mark]:
    """The ratios in impacts; those of longitudinal waves are of transverse waves where the front runs along them."""
    for case, grids in results["impacts"].items():
        for wavelength in plan.shaped[case]:
            across = reduction.last_wave("transverse", case, "transverse", wavelength, grids)
            yield across
            yield reduction.last_wave("rings", case, "rings", wavelength, grids)
            X, name = across["X"], wave_name("transverse", HEIGHT, wavelength)
            along = [float(np.interp(X, grid["X"], grid["along"].sel(wave=name))) for grid in grids]
            yield reduction.mark("longitudinal", case, wavelength, along, X, theory.front(grids[-1]))


def other_waves(results: reduction.Results, plan: Plan) -> Drawn:
    """Fig. 7: A_d/A_i of transverse, longitudinal and ring waviness, in impact (left) and rolling (right)."""
    impacts = DataFrame(impacts_on_shapes(results, plan))
    rolled = DataFrame(
        reduction.mark(kind, (M, L), wavelength, [float(np.ravel(value)[0]) for value in values])
        for (kind, M, L, wavelength), values in results["rolling"].items()
    )
    grids, rolling = plan.beyond_grids, plan.straight_grids
    figure, panels = new_figure(1, 2)
    for axes, marks, title in zip(panels, (impacts, rolled), ("impact", "rolling"), strict=True):
        _draw_marks(axes, marks, OF_SHAPES)
        reduction.draw_fit(axes, CURVES["(15), longitudinal"], ":", "(15) of $e\\nabla_2$, longitudinal")
        axes.set(xlabel="local $\\nabla_2$" if title == "impact" else "$\\nabla_2$", title=title)
    panels[0].legend(loc="lower left", frameon=False, fontsize="x-small")
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
        "Impact": texts(impacts, {"waves": "{kind}", **reduction.PLACE}),
        "Rolling": texts(rolled, {"waves": "{kind}", **reduction.PLACE}),
        "A_d/A_i minus the curve: mean, root mean square": DataFrame(_scatter_rows(impacts, rolled)),
    }
    return Drawn(figure, caption, {"impact": impacts, "rolling": rolled}, tables)


def _scatter_rows(impacts: DataFrame, rolled: DataFrame) -> Iterator[dict[str, str]]:
    for kind in OF_SHAPES:
        hit, rolling = (marks[marks["kind"] == kind] for marks in (impacts, rolled))
        yield {"parameter": f"impact, {kind}, local nabla2", **reduction.scatter_cells(hit, "local", CURVES)}
        yield {"parameter": f"impact, {kind}, momentary Hertz contact", **reduction.scatter_cells(hit, "hertz", CURVES)}
        if len(rolling):
            yield {"parameter": f"rolling, {kind}", **reduction.scatter_cells(rolling, "local", CURVES)}


# -- Fig. 8 -----------------------------------------------------------------------------------------------------------


def other_oils(results: Mapping[Any, Any], plan: Plan) -> Drawn:
    """Fig. 8: A_d/A_i of isotropic waviness in impacts with other oils; right: compared with the usual oil."""
    marks = DataFrame(
        reduction.last_wave(oil, case, "isotropic", wavelength, grids)
        for (oil, case, wavelengths), grids in results.items()
        for wavelength in wavelengths
    )
    usual, others = marks[marks["kind"] == USUAL], marks[marks["kind"] != USUAL]
    pairs = usual.merge(others, on=["M", "L", "wavelength"], suffixes=("_usual", ""))
    pairs["difference"] = pairs["limit"] - pairs["limit_usual"]
    grids = plan.beyond_grids
    caption = (
        "Beyond the paper: other lubricants in the impacts of Fig. 6, isotropic waviness.  Right: A_d/A_i against that "
        "with Roelands' law and Dowson and Higginson's density, at the same M, L and wavelength.  For an isoviscous "
        "oil L = 0 and nabla2 is infinite.  As nabla2 is the wavelength divided by sqrt(L/M), the film at which a "
        "rigid ball stops, the abscissa is then the wavelength divided by the film that elasticity alone traps, 0.3135 "
        f"sqrt(lambda_bar); curve (15) does not hold there.  Grids of {grids[0]} and {grids[1]} nodes per side; "
        "extrapolation and error bars as in Fig. 6."
    )
    cells = {
        "oil": "{kind}",
        **reduction.WAVE,
        f"A_d/A_i, {USUAL}": "{limit_usual:.3f}",
        "A_d/A_i, this oil": "{limit:.3f}",
        "difference": "{difference:+.3f}",
    }
    tables = {
        "Other oils": texts(marks, {"oil": "{kind}", **reduction.PLACE}),
        f"Compared with {USUAL}": texts(pairs, cells),
    }
    return Drawn(_draw_oils(marks, pairs), caption, {"oils": marks}, tables)


def _draw_oils(marks: DataFrame, pairs: DataFrame) -> Figure:
    figure, (left, right) = new_figure(1, 2)
    _draw_marks(left, marks, OF_OILS)
    left.set_xlabel("local $\\nabla_2$; isoviscous: $\\Lambda$ over the local trapped film")
    left.legend(loc="lower left", frameon=False, fontsize="x-small")
    for oil, (marker, colour) in OF_OILS.items():
        of_oil = pairs[pairs["kind"] == oil]
        if len(of_oil):
            right.plot(of_oil["limit_usual"], of_oil["limit"], marker, color=colour, label=oil)
    right.plot([0, 1], [0, 1], color=plots.GREY, linewidth=0.8)
    right.set(xlim=(0, 1), ylim=(0, 1), xlabel=f"$A_d/A_i$, {USUAL}", ylabel="$A_d/A_i$, same $M, L, \\Lambda$")
    right.legend(loc="upper left", frameon=False, fontsize="x-small")
    return figure


# -- Fig. 9 -----------------------------------------------------------------------------------------------------------


def starved(results: Mapping[Any, Any], plan: Plan) -> Drawn:
    """Fig. 9."""
    shares = DataFrame(
        {"contact": kind, "M": M, "L": L, "r": r, "R": fine, "coarse grid": coarse, "change": fine - coarse}
        for (kind, M, L), grids in results.items()
        for r, coarse, fine in zip(LAYERS, *grids, strict=True)
    )
    fits = DataFrame({"contact": kind, **_fit(shares[shares["contact"] == kind])} for kind in plan.starved)
    coarse, fine = plan.starved_grids
    caption = (
        "Beyond the paper: a starved impact follows a curve like that of starved rolling.  R is the oil in the centre "
        "over that of the flooded contact, r the layer of oil over the same.  Left: all contacts, with "
        "R = r/(1 + r^g)^(1/g) and g fitted to each kind.  Right: their difference.  Values of the finer grid; bars: "
        f"difference of the two grids, of {coarse} and {fine} nodes.  Curve: {formulas.SOURCES['Chevalier et al.']}, "
        "g of circular contacts in the literature: 2 to 5."
    )
    of_fit = {"contact": "{contact}", "g": "{g:.2f}", "standard error": "{error:.2f}"}
    named = {"contact": "{contact}", "M": "{M:g}", "L": "{L:g}"}
    cells = texts(shares, {**named, "r": "{r:g}", "R": "{R:.4f} ({change:+.4f})"})
    by_r = [
        dict([*zip(named, contact, strict=True), *zip(of_contact["r"], of_contact["R"], strict=True)])
        for contact, of_contact in cells.groupby(list(named), sort=False)
    ]
    tables = {
        "Exponents of the curve": texts(fits, {**of_fit, "largest difference": "{largest:.3f}"}),
        "R by r (difference of the two grids)": DataFrame(by_r),
    }
    figure = _draw_starved(shares, dict(zip(fits["contact"], fits["g"], strict=True)))
    return Drawn(figure, caption, {"starved": shares.drop(columns="change")}, tables)


def _fit(shares: DataFrame) -> dict[str, float]:
    """The exponent that fits best, its standard error, and the largest difference."""

    def differences(g: np.ndarray) -> np.ndarray:
        return np.asarray(shares["R"] - [formulas.starved_share(r, float(g[0])) for r in shares["r"]])

    fit = least_squares(differences, 2.5)
    variance = float(np.sum(fit.fun**2)) / (len(shares) - 1) / float(np.sum(fit.jac**2))
    return {"g": float(fit.x[0]), "error": float(np.sqrt(variance)), "largest": float(np.abs(fit.fun).max())}


def _draw_starved(shares: DataFrame, exponents: Mapping[str, float]) -> Figure:
    figure, (left, right) = new_figure(1, 2)
    line = np.geomspace(LAYERS[0] / 1.5, LAYERS[-1] * 1.5)
    for style, (kind, g) in zip(("-", "--"), exponents.items(), strict=True):
        curve = [formulas.starved_share(r, g) for r in line]
        left.loglog(line, curve, style, color=plots.GREY, linewidth=0.9, label=f"{kind}: $\\gamma$ = {g:.2f}")
    left.loglog(line, np.minimum(line, 1.0), ":", color="black", linewidth=0.7)
    contacts = shares.groupby(["contact", "M", "L"], sort=False)
    shades = iter(plots.ORDERED_COLOURS(np.linspace(0.9, 0.1, len(contacts))))
    for ((kind, M, L), drawn), marker in zip(contacts, reduction.MARKERS * len(contacts), strict=False):
        colour = next(shades) if kind == "impact" else plots.ORANGE
        look: dict[str, Any] = {"marker": marker, "color": colour, "linestyle": "none", "markersize": 5}
        look |= {"markerfacecolor": "white"} if kind == "rolling" else {}
        left.loglog(drawn["r"], drawn["R"], label=f"{kind}, M = {M:g}, L = {L:g}", **look)
        off = drawn["R"] - [formulas.starved_share(r, exponents[kind]) for r in drawn["r"]]
        right.errorbar(drawn["r"], off, drawn["change"].abs(), capsize=2, elinewidth=0.8, **look)
    right.axhline(0.0, color=plots.GREY, linewidth=0.8)
    right.set(xscale="log", ylabel="$R$ less the curve of its kind", xlabel="$r$")
    left.set(xlabel="$r$, layer over the oil of the flooded film", ylabel="$R$, film over the flooded one")
    for axis in (left.xaxis, left.yaxis, right.xaxis):
        axis.set_minor_locator(NullLocator())
        axis.set_major_formatter("{x:g}")
        axis.set_major_locator(FixedLocator([0.25, 0.5, 1.0, 2.0, 4.0]))
    left.legend(loc="lower right", frameon=False, fontsize="xx-small")
    return figure
