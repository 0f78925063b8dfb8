"""Dowson and Higginson's classics: films and pressure spikes of line contacts over speed and G, and a spike on grids.

    python validation/contacts/classics.py

writes `classics.md` and its pictures, in some three minutes.  Dowson and Higginson drew pressures and films for several
U at one W and G (Elasto-hydrodynamic lubrication. Pergamon; 1966).  W = 3e-5 and G = 5000 are values of theirs: a
contact of p_h = 0.5 GPa in steel.  M = W/sqrt(2 U), L = G (2 U)^(1/4), with the mean speed in U; h/R = H 8 W/pi.
"""

import sys
import warnings
from collections.abc import Iterator, Sequence
from math import nan, pi, sqrt
from pathlib import Path
from typing import NamedTuple

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

import ertel
from ertel import formulas, parse_case, plots
from ertel.physics.scales import HamrockDowson

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from common import BARUS, table

HERE = Path(__file__).parent
Values = NDArray[np.float64]
OILS = {"Roelands, compressible": {}, "Barus, incompressible": BARUS}
W, G = 3e-5, 5000.0
SPEEDS = (1e-13, 3e-13, 1e-12, 3e-12, 1e-11, 3e-11, 1e-10)  # U
USUAL = 1e-11  # U where G varies
MATERIALS = (1000.0, 2000.0, 3000.0, 4000.0, 5000.0, 6000.0)  # G
NODES = 1025
SMALL = {"half_width": 1.75, "inlet": 2.25}  # b, of the grid above M = 15, where the inlets are short
GRIDS = (129, 257, 513, 1025, 2049)
SPIKES = (
    (20.0, 10.0, "Roelands, compressible"),
    (10.0, 10.0, "Roelands, compressible"),
    (20.0, 11.0, "Barus, incompressible"),
)
HEAD = f"""# Dowson and Higginson's classics

The film and the pressure of a line contact over the speed U and the material G, and the pressure spike on five grids.
`classics.py` writes this page. W = {W:g}, so that p_h = 0.5 GPa in steel; {NODES} nodes. Films are extrapolated, spikes
are those of the grid; the width is that at half of the rise over the trough before.

The minimum film goes as U^0.70, as in Dowson and Higginson's formula, which is within 4 % of it from G = 2000 on with
both oils. It goes as G^0.59 to G^0.62 at the upper end, and more slowly towards the isoviscous contact, where the
formula is not meant to hold: at G = 1000 it is 11 % below the film. With U the spike rises and moves from the outlet
to the middle; with G it rises and hardly moves. Barus' law makes it narrower and higher, 2.6 p_h for 1.2 p_h at U =
1e-11. At the highest speeds the pressure rises to the spike without a trough before it.
"""
SPIKES_TEXT = """## The spike on grids

The films are of second order on these grids, see [line contacts](line.md); the spike is not. It is narrower than two
cells up to 513 nodes. With Roelands' law its place is known to a cell; its height still grows by 0.05 from 1025 to
2049 nodes (the observed order is -0.1 to 0.6, so it cannot be extrapolated), and its width falls. With Barus' law the
height grows by 0.13 to 0.29 from grid to grid, and there is no sign of a limit. An independent program whose nodes
crowd at the outlet has 0.82 at X = 0.898 (M = 20, L = 10) and 1.05 at 0.818 (M = 10, L = 10); with Barus' law 2.4 at
0.860, still rising on cells of 0.0025.
"""


class Spike(NamedTuple):
    """A pressure spike: height (p_h), place and width (b), the width at half of the rise over the trough before it."""

    height: float
    place: float
    width: float


def line(M: float, L: float, oil: str, nodes: int, **domain: float) -> ertel.Result:
    """Steady rolling."""
    contact = {"kind": "rolling", "M": M, "L": L, "radius_ratio": 0}
    return ertel.simulate(
        parse_case({"contact": contact, "lubricant": OILS[oil], "solver": {"nodes": nodes, **domain}})
    )


def spike_of(X: Values, P: Values) -> Spike:
    """The highest node beyond a trough of P in X > 0, or the highest of all where it is above the dry maximum.

    nan where there is neither.
    """
    inside = X > 0
    X, P = X[inside], P[inside]
    troughs = np.flatnonzero((P[1:-1] < P[:-2]) & (P[1:-1] <= P[2:]) & (P[2:] > 0)) + 1
    if not len(troughs) and P.max() < 1.0:
        return Spike(nan, nan, nan)
    first = int(troughs[0]) if len(troughs) else 0
    i = first + int(np.argmax(P[first:]))
    half = (P[i] + P[:i].min()) / 2
    before = i - int(np.argmax(P[i::-1] < half))
    after = i + int(np.argmax(P[i:] < half))
    start = np.interp(half, P[[before, before + 1]], X[[before, before + 1]])
    end = np.interp(half, P[[after, after - 1]], X[[after, after - 1]])
    return Spike(float(P[i]), float(X[i]), float(end - start))


# -- films over speed and G -------------------------------------------------------------------------------------------


def films(oil: str, contacts: Sequence[tuple[float, float]]) -> tuple[str, list[xr.Dataset]]:
    """The table of contacts U, G, and their solutions."""
    done: list[xr.Dataset] = []
    head = [
        "U",
        "G",
        "M",
        "L",
        "h_c/R",
        "h_min/R",
        "Dowson-Higginson, h_min/R",
        "off",
        "spike p/p_h",
        "at x/b",
        "width, b",
    ]
    return table(head, (_film(U, G, oil, done) for U, G in contacts)), done


def _film(U: float, G: float, oil: str, done: list[xr.Dataset]) -> list[str]:
    M, L, unit = W / sqrt(2 * U), G * (2 * U) ** 0.25, 8 * W / pi
    labels = [f"{U:.3g}", f"{G:g}", f"{M:.3g}", f"{L:.3g}"]
    result = line(M, L, oil, NODES, **(SMALL if M > 15 else {}))
    if not result.status.ok:
        return [*labels, result.status.value, *[""] * 6]
    data = result.dataset
    central, minimum = (unit * (v[-1] + (v[-1] - v[-2]) / 3) for v in (data["H_c"].values, data["H_min"].values))
    done.append(data.assign_attrs(U=U, G=G, h_min=float(minimum)))
    expected = formulas.dowson_higginson_minimum(HamrockDowson(U, G, W))
    spike = spike_of(data["X"].values, data["P"].values.squeeze())
    cells = [f"{each:.3g}" for each in (central, minimum, expected)]
    of_spike = ["none", "", ""] if np.isnan(spike.height) else [f"{each:.3f}" for each in spike]
    return [*labels, *cells, f"{expected / minimum - 1:+.1%}", *of_spike]


def exponents(over: str, done: Sequence[xr.Dataset]) -> str:
    """The slopes of ln h_min between the ends, and at both ends."""
    x, h = np.log([each.attrs[over] for each in done]), np.log([each.attrs["h_min"] for each in done])
    slopes = np.diff(h) / np.diff(x)
    whole = (h[-1] - h[0]) / (x[-1] - x[0])
    ends = f"{slopes[0]:.2f} at its lower, {slopes[-1]:.2f} at its upper end"
    return f"h_min goes as {over}^{whole:.2f} over the whole range ({ends})"


def picture(by_speed: Sequence[xr.Dataset], by_material: Sequence[xr.Dataset]) -> Figure:
    """Pressures above and films below, over speed on the left and over G on the right."""
    figure = Figure(figsize=(9.6, 6.4), layout="constrained")
    panels = figure.subplots(2, 2, sharex=True)
    for (top, bottom), name, done in zip(panels.T, ("U", "G"), (by_speed, by_material), strict=True):
        for data, colour in zip(done, plots.ORDERED_COLOURS(np.linspace(1.0, 0.0, len(done))), strict=True):
            X, P, H = (np.squeeze(data[each].values) for each in ("X", "P", "H"))
            top.plot(X, P, color=colour, label=f"${name}$ = {data.attrs[name]:g}")
            bottom.plot(X, H / H[np.abs(X).argmin()], color=colour)
        X = np.linspace(-1, 1, 401)
        top.plot(X, np.sqrt(1 - X**2), color="black", linestyle=":", label="dry")
        top.set(xlim=(-2, 1.5), ylim=(0, None), ylabel="$p/p_h$")
        bottom.set(ylim=(0, 2), xlabel="$x/b$", ylabel="$h/h_c$")
        top.legend(loc="upper left", frameon=False, fontsize="small")
    panels[0][0].set_title(f"W = {W:g}, G = {G:g}")
    panels[0][1].set_title(f"W = {W:g}, U = {USUAL:g}")
    return figure


# -- a spike on grids -------------------------------------------------------------------------------------------------


def spikes() -> tuple[str, Figure]:
    """The table of spikes on grids, and their picture."""
    figure = Figure(figsize=(4.2 * len(SPIKES), 3.6), layout="constrained")
    head = ["M, L", "oil", "nodes", "spacing, b", "height p/p_h", "at x/b", "width, b", "cells in it"]
    head += ["order of the height", "of the place"]
    panels = figure.subplots(1, len(SPIKES))
    text = table(head, (row for each, axes in zip(SPIKES, panels, strict=True) for row in _on_grids(*each, axes)))
    return text, figure


def _on_grids(M: float, L: float, oil: str, axes: Axes) -> Iterator[list[str]]:
    found: list[Spike] = []
    for nodes, colour in zip(GRIDS, plots.ORDERED_COLOURS(np.linspace(0.0, 1.0, len(GRIDS))), strict=True):
        data = line(M, L, oil, nodes).dataset
        X, P = data["X"].values, data["P"].values.squeeze()
        found.append(spike_of(X, P))
        axes.plot(X, P, ".-" if nodes < 1025 else "-", color=colour, markersize=3, linewidth=1, label=f"{nodes} nodes")
        s, spacing = found[-1], X[1] - X[0]
        numbers = [f"{s.height:.4f}", f"{s.place:.4f}", f"{s.width:.4f}", f"{s.width / spacing:.1f}"]
        cells = numbers if s.height == s.height else ["none", "", "", ""]
        orders = [_order([each[k] for each in found]) for k in (0, 1)]
        yield [f"{M:g}, {L:g}", oil, str(nodes), f"{spacing:.5f}", *cells, *orders]
    place = found[-1].place
    axes.set(xlim=(place - 0.15, place + 0.15), ylim=(0, 1.15 * found[-1].height), xlabel="$x/b$", ylabel="$p/p_h$")
    axes.set_title(f"{oil.partition(',')[0]}, M = {M:g}, L = {L:g}")
    axes.legend(loc="lower left", frameon=False, fontsize="small")


def _order(values: Sequence[float]) -> str:
    """The order by which the last three values converge on grids that halve their spacing; a dash where they do not."""
    if len(values) < 3 or not np.isfinite(values[-3:]).all():
        return ""
    first, second = np.diff(values[-3:])
    return f"{np.log2(first / second):.1f}" if first * second > 0 else "-"


def main() -> None:
    ertel.cache()
    warnings.simplefilter("ignore")
    parts = [HEAD]
    for oil in OILS:
        by_speed, speeds = films(oil, [(U, G) for U in SPEEDS])
        by_material, materials = films(oil, [(USUAL, each) for each in MATERIALS])
        parts += [f"## Over speed and G: {oil}\n", by_speed, f"{exponents('U', speeds)}.\n"]
        parts += [by_material, f"{exponents('G', materials)}.\n"]
        name = f"classics_{oil.partition(',')[0].lower()}.png"
        picture(speeds, materials).savefig(HERE / name, dpi=110)
        parts += [f"![Pressure and film over U and G, {oil}]({name})\n"]
    text, figure = spikes()
    figure.savefig(HERE / "spikes.png", dpi=110)
    parts += [SPIKES_TEXT, text, "![The spike on five grids](spikes.png)\n"]
    (HERE / "classics.md").write_text("\n".join(parts), encoding="utf-8")


if __name__ == "__main__":
    main()
