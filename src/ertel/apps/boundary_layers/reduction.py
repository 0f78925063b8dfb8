"""Figure 6 of the paper: amplitude reduction in impact and in rolling, and which parameter brings them together."""

from collections.abc import Callable, Iterator, Sequence
from functools import partial
from itertools import islice
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from ertel.apps.boundary_layers.front import FORMED, NAMES, new_figure
from ertel.apps.boundary_layers.page import Drawn, Table
from ertel.apps.boundary_layers.waves import (
    CHECKED,
    SHORTER,
    SHOWN,
    STEPPED,
    Dot,
    Extrapolated,
    Plan,
    check_tasks,
    dots,
    half,
    impact_tasks,
    last_wave,
    plan,
    rolling_tasks,
    twin_tasks,
)
from ertel.physics import amplitude_reduction
from ertel.physics.scales import Parameters
from ertel.results import waves
from ertel.results.fronts import Values
from ertel.results.plots.drawing import BLUE, GREY, ORANGE, ORDERED_COLOURS
from ertel.results.waves import Reduction
from ertel.runs.sweep import Task

PARTS: Sequence[Callable[[bool], list[Task]]] = (impact_tasks, check_tasks, rolling_tasks, twin_tasks)
SPEEDS = (NAMES["film"], NAMES["half-hertz"], "dry law")
LEAST_ERROR = 0.01  # of a ratio, in the fit: no dot is better than that


def all_tasks(quick: bool) -> list[Task]:
    """What Fig. 6 takes."""
    return [task for part in PARTS for task in part(quick)]


class Rolled(NamedTuple):
    """A rolling contact's square; change: of A_d/A_i from a period to the next, on the fine grid."""

    M: float
    L: float
    wavelength: float
    nodes: int  # of the fine grid
    nabla2: float
    ratio: Extrapolated
    change: float


class Twin(NamedTuple):
    """An impact's wave at X, and rolling in the place of its front as it passed there."""

    M: float
    L: float
    wavelength: float
    X: float
    nabla2: float
    impact: Extrapolated
    rolling: Extrapolated


def reduction(results: Sequence[Any], quick: bool) -> Drawn:
    """Fig. 6: A_d/A_i of impact and of rolling against nabla2, local and global, over the curve (15)."""
    p, rest = plan(quick), iter(results)
    impacts, checks, rolling, twinned = (list(islice(rest, len(part(quick)))) for part in PARTS)
    waves = list(dots(p, impacts))
    rolled, found = list(rolled_over(p, rolling)), [dot for dot in waves if dot.last]
    own, twins = curve_of(rolled), list(_twins(p, waves, twinned))
    figure, (left, middle, right) = new_figure(1, 3)
    for axes in (left, middle, right):
        draw_curves(axes)
        n = np.geomspace(0.3, 30, 200)
        axes.plot(n, own.ratio(n), color=ORANGE, linewidth=1.0, linestyle=":", label="fitted to the squares")
        _draw_rolled(axes, rolled)
    draw_dots(left, found, [dot.local[0] for dot in found], ranges=True)
    draw_dots(middle, found, [dot.everywhere for dot in found])
    draw_dots(right, found, [dot.hertz for dot in found])
    inner = [dot for dot in waves if not dot.last and dot.X > FORMED]
    further = [dot.hertz for dot in inner], [dot.ratio.limit for dot in inner]
    crosses = [twin.nabla2 for twin in twins], [twin.rolling.limit for twin in twins]
    handles = right.plot(*further, ".", color=GREY, markersize=3, label="impact, waves further in")
    handles += right.plot(*crosses, "x", color=BLUE, label="rolling in the place of the front")
    left.set_xlabel("local $\\nabla_2$, $\\bar\\lambda v$")
    middle.set_xlabel("global $\\nabla_2$ (rolling: its own)")
    right.set_xlabel("local $\\nabla_2$ with the Hertz contact then")
    left.legend(loc="lower left", frameon=False, fontsize="xx-small")
    right.legend(handles=handles, loc="lower left", frameon=False, fontsize="x-small")
    caption = (
        "Amplitude reduction.  Dots: the last complete wave inside the contact at maximum impact, extrapolated from "
        f"grids of {p.grids[0]} and {p.grids[1]} nodes a side as for a method of second order; the bar reaches to "
        "where first order would have it.  Horizontally, on the left, the range of three speeds of the front (least "
        "film, half of Hertz' pressure, exact dry law) at that place.  Squares: rolling over the same waviness, at the "
        "contact's centre, once periodic, on the grids in the table.  Line: eq. (15); "
        f"dashed: the curve of transverse waviness in a line contact; dotted: {_text(own)}, fitted to the squares.  "
        "Right: nabla2 with radius and pressure of the Hertz contact at the moment when the front passed, lambda_bar "
        "v/A^4, alpha_bar A, wavelength/A; crosses: rolling at just those parameters."
    )
    tables = [
        _dots_table(found),
        _scatter_table(found, inner, rolled, own),
        _twins_table(twins),
        _rolling_table(rolled),
        *_check_tables(quick, impacts, checks, rolling),
    ]
    return Drawn(figure, caption, {"impact": _columns(waves), "rolling": _rolled_columns(rolled)}, tables)


def rolled_over(plan: Plan, results: Sequence[tuple[float, float]]) -> Iterator[Rolled]:
    """The squares, from the results of `rolling_tasks`."""
    for (M, L, wavelength, nodes), coarse, fine in zip(plan.rolling, results[::2], results[1::2], strict=True):
        nabla2 = Parameters.from_moes(M, L).nabla2(wavelength)
        yield Rolled(M, L, wavelength, nodes, nabla2, Extrapolated(coarse[0], fine[0]), fine[1])


def curve_of(rolled: Sequence[Rolled]) -> Reduction:
    """The curve of the form of (15) through the squares, each by the weight of its bar."""
    errors = [max(r.ratio.error, LEAST_ERROR) for r in rolled]
    return waves.fit_reduction([r.nabla2 for r in rolled], [r.ratio.limit for r in rolled], errors)


def _twins(plan: Plan, waves: Sequence[Dot], results: Sequence[tuple[float, float, float]]) -> Iterator[Twin]:
    for (M, L, wavelength, X), coarse, fine in zip(plan.twins, results[::2], results[1::2], strict=True):
        own = [dot for dot in waves if (dot.M, dot.L, dot.wavelength) == (M, L, wavelength)]
        nearest = min(own, key=lambda dot: abs(dot.X - X))
        yield Twin(M, L, wavelength, nearest.X, fine[0], nearest.ratio, Extrapolated(coarse[1], fine[1]))


# -- what is drawn -----------------------------------------------------------------------------------------------------


def draw_curves(axes: Axes) -> None:
    """Eq. (15) and the line contact's curve, over nabla2 = 0.4 to 20."""
    n = np.geomspace(0.3, 30, 200)
    axes.semilogx(n, amplitude_reduction.ratio_left(n), color="black", label="(15), isotropic")
    axes.semilogx(
        n, amplitude_reduction.in_line_contact(n), color=GREY, linestyle="--", label="line contact, transverse"
    )
    axes.set(ylim=(0, 1.1), xlim=(0.4, 20), ylabel="$A_d/A_i$")
    axes.set_xticks([0.5, 1, 2, 5, 10, 20], ["0.5", "1", "2", "5", "10", "20"])


def draw_dots(axes: Axes, found: Sequence[Dot], nabla2: Sequence[float], ranges: bool = False) -> None:
    """Dots with their bars, a colour and a marker for each (M, L); ranges: of the three local nabla2 too."""
    cases = list(dict.fromkeys((dot.M, dot.L) for dot in found))
    shades = ORDERED_COLOURS(np.linspace(0.95, 0.0, len(cases)))
    for case, colour, marker in zip(cases, shades, "ovD^P*<>", strict=False):
        own = [(n, dot) for n, dot in zip(nabla2, found, strict=True) if (dot.M, dot.L) == case]
        limit, place = [dot.ratio.limit for _, dot in own], [n for n, _ in own]
        across = np.array([(n - min(dot.local), max(dot.local) - n) for n, dot in own]).T if ranges else None
        bar = [dot.ratio.error for _, dot in own]
        label = f"impact, M = {case[0]:g}, L = {case[1]:g}"
        axes.errorbar(place, limit, bar, across, fmt=marker, color=colour, label=label, capsize=2, elinewidth=0.8)


def _draw_rolled(axes: Axes, rolled: Sequence[Rolled]) -> None:
    place, limit = [r.nabla2 for r in rolled], [r.ratio.limit for r in rolled]
    bar = [r.ratio.error for r in rolled]
    axes.errorbar(place, limit, bar, fmt="s", color="black", markerfacecolor="white", capsize=2, label="rolling")


def _columns(waves: Sequence[Dot]) -> dict[str, Values]:
    names = ("M", "L", "wavelength", "X", "last", "everywhere", "hertz")
    columns = {name: np.array([float(getattr(dot, name)) for dot in waves]) for name in names}
    columns |= {
        name: np.array([getattr(d.ratio, name) for d in waves]) for name in ("coarse", "fine", "limit", "error")
    }
    return columns | {f"local, {name}": np.array([d.local[i] for d in waves]) for i, name in enumerate(SPEEDS)}


def _rolled_columns(rolled: Sequence[Rolled]) -> dict[str, Values]:
    names = ("M", "L", "wavelength", "nabla2", "change")
    columns = {name: np.array([getattr(r, name) for r in rolled]) for name in names}
    return columns | {
        name: np.array([getattr(r.ratio, name) for r in rolled]) for name in ("coarse", "fine", "limit", "error")
    }


# -- numbers to read ---------------------------------------------------------------------------------------------------


def _text(curve: Reduction) -> str:
    return f"1/(1 + {curve.linear:.3f} nabla2 + {curve.quadratic:.4f} nabla2^2)"


def ratio_cells(ratio: Extrapolated) -> list[str]:
    """Coarse, fine, and extrapolated with its bar."""
    return [f"{ratio.coarse:.3f}", f"{ratio.fine:.3f}", f"{ratio.limit:.3f} ± {ratio.error:.3f}"]


RATIO_HEAD = ["A_d/A_i coarse", "fine", "extrapolated"]


def _dots_table(found: Sequence[Dot]) -> Table:
    head = ["M", "L", "wavelength", "X", *RATIO_HEAD, "nabla2 local", "with Hertz then", "global", "(15) of local"]
    rows = []
    for d in found:
        curve = float(amplitude_reduction.ratio_left(d.local[0]))
        numbers = [f"{n:.2f}" for n in (d.local[0], d.hertz, d.everywhere)]
        case = [f"{d.M:g}", f"{d.L:g}", f"{d.wavelength:g}", f"{d.X:.3f}"]
        rows.append([*case, *ratio_cells(d.ratio), *numbers, f"{curve:.3f}"])
    return Table(head, rows)


class Scatter(NamedTuple):
    """Of dots about a curve, in A_d/A_i: mean and root mean square."""

    mean: float
    rms: float


def scatter(values: Sequence[float], curve: Values) -> Scatter:
    """How dots lie about a curve."""
    off = np.asarray(values) - curve
    return Scatter(float(off.mean()), float(np.sqrt(np.mean(off**2))))


def _scatter_table(found: Sequence[Dot], inner: Sequence[Dot], rolled: Sequence[Rolled], own: Reduction) -> Table:
    """How impact and rolling lie about the curves, for each parameter that may bring them together."""
    rows = []
    kinds: dict[str, Callable[[Dot], float]] = {
        f"local nabla2, speed by {name}": partial(_local, i) for i, name in enumerate(SPEEDS)
    }
    kinds |= {"local nabla2, Hertz contact then": lambda dot: dot.hertz, "global nabla2": lambda dot: dot.everywhere}
    for name, chosen in {"last waves": found, f"waves further in, X > {FORMED:g}": inner}.items():
        known = [dot for dot in chosen if np.isfinite(dot.local).all()]
        for kind, nabla2 in kinds.items() if known else ():
            values = [dot.ratio.limit for dot in known]
            rows.append([f"impact, {name} ({len(known)}), {kind}", *_about(values, [nabla2(d) for d in known], own)])
    rows.append(["rolling", *_about([r.ratio.limit for r in rolled], [r.nabla2 for r in rolled], own)])
    head = ["A_d/A_i less the curve: mean, root mean square", "isotropic (15)", "line contact", "fitted to rolling"]
    return Table(head, rows)


def _local(speed: int, dot: Dot) -> float:
    return dot.local[speed]


def _about(values: Sequence[float], nabla2: Sequence[float], own: Reduction) -> list[str]:
    curves = (
        amplitude_reduction.ratio_left(nabla2),
        amplitude_reduction.in_line_contact(nabla2),
        own.ratio(nabla2),
    )
    return [f"{s.mean:+.3f}, {s.rms:.3f}" for s in (scatter(values, curve) for curve in curves)]


def _twins_table(twins: Sequence[Twin]) -> Table:
    head = ["twins: M", "L", "wavelength", "X", "nabla2", "impact at X", "rolling in its place", "impact less rolling"]
    rows = []
    for t in twins:
        numbers = [f"{t.M:g}", f"{t.L:g}", f"{t.wavelength:g}", f"{t.X:.3f}", f"{t.nabla2:.2f}"]
        ratios = [f"{ratio.limit:.3f} ± {ratio.error:.3f}" for ratio in (t.impact, t.rolling)]
        rows.append([*numbers, *ratios, f"{t.impact.limit - t.rolling.limit:+.3f}"])
    s = scatter([t.impact.limit for t in twins], np.array([t.rolling.limit for t in twins]))
    rows.append(["mean, root mean square", *[""] * 6, f"{s.mean:+.3f}, {s.rms:.3f}"])
    return Table(head, rows)


def _rolling_table(rolled: Sequence[Rolled]) -> Table:
    head = ["rolling: M", "L", "wavelength", "nodes", "nabla2", *RATIO_HEAD, "(15)", "still changing"]
    rows = []
    for r in rolled:
        case = [f"{r.M:g}", f"{r.L:g}", f"{r.wavelength:g}", f"{half(r.nodes)}, {r.nodes}", f"{r.nabla2:.2f}"]
        curve = float(amplitude_reduction.ratio_left(r.nabla2))
        rows.append([*case, *ratio_cells(r.ratio), f"{curve:.3f}", f"{r.change:.3f}"])
    return Table(head, rows)


def _check_tables(
    quick: bool, impacts: Sequence[xr.Dataset], checks: Sequence[Any], rolling: Sequence[tuple[float, float]]
) -> list[Table]:
    """That A_d/A_i does not depend on A_i, and how little on the time steps."""
    p, (heights, linear, shorter, rolled) = plan(quick), checks
    shown = f"M = {SHOWN[0]:g}, L = {SHOWN[1]:g}"
    wavelengths, nodes = p.impacts[SHOWN], p.grids[0]
    rows = [["0: tangent-linear", f"{last_wave(linear, 0, 1.0).amplitude:.4f}"]]
    for number, height in enumerate(CHECKED):
        rows.append([f"{height:g}", f"{last_wave(heights, number, 1.0).amplitude:.4f}"])
    by_height = Table([f"A_i / sqrt(L/M), {shown}, wavelength {wavelengths[0]:g}, {nodes} nodes", "A_d/A_i"], rows)
    usual, steps = impacts[3 * list(p.impacts).index(SHOWN) + 1], []
    for number, wavelength in enumerate(wavelengths):
        pair = [last_wave(run, number, 1.0).amplitude for run in (usual, shorter)]
        steps.append([f"impact, {shown}, wavelength {wavelength:g}, {nodes} nodes", *_pair(*pair)])
    M, L, wavelength, nodes = p.rolling[STEPPED]
    name = f"rolling, M = {M:g}, L = {L:g}, wavelength {wavelength:g}, {half(nodes)} nodes"
    steps.append([name, *_pair(rolling[::2][STEPPED][0], rolled[0])])
    return [by_height, Table(["time steps", "A_d/A_i, usual", f"{SHORTER} times as many"], steps)]


def _pair(usual: float, shorter: float) -> list[str]:
    return [f"{usual:.4f}", f"{shorter:.4f}"]
