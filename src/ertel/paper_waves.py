"""Figures 5 and 6 of the paper: what an impact leaves of waviness, and what a rolling contact leaves of it."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from math import ceil
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from ertel import analysis, formulas, hertz
from ertel.analysis import Values, Wave
from ertel.config import parse_case
from ertel.drawing import BLUE, GREY, ORANGE, ORDERED_COLOURS
from ertel.page import Drawn, Table
from ertel.paper_front import NAMES, new_figure, radial_task
from ertel.response import respond
from ertel.roughness import Feature, Waviness
from ertel.scales import Parameters
from ertel.simulation import simulate
from ertel.sweep import Task

HEIGHT = 0.01  # A_i in units of the trapped film sqrt(L/M): small
CHECKED = (0.005, 0.02, 0.05)  # other heights, to show that A_d/A_i does not depend on it
HALF_WIDTH, START = 1.5, -0.5  # of the waves' grid (a*), and Delta_0
SHOWN = (1000, 10)  # M, L of Fig. 5 and of the check


@dataclass(frozen=True)
class Plan:
    """What is run.  impacts: wavelengths of (M, L); grids: nodes per side, coarse and fine, likewise for rolling."""

    impacts: Mapping[tuple[float, float], tuple[float, ...]]
    grids: tuple[int, int]
    rolling: tuple[tuple[float, float, float], ...]  # M, L, wavelength
    rolling_grids: tuple[int, int]
    seconds: float  # of one impact on the fine grid
    rolling_seconds: float


QUICK = Plan(
    impacts={(200, 10): (0.25, 0.4), (1000, 10): (0.25, 0.4, 0.6), (1000, 5): (0.25, 0.5)},
    grids=(97, 193),
    rolling=((200, 10, 0.5), (200, 10, 1.0), (1000, 10, 0.5)),
    rolling_grids=(65, 129),
    seconds=15.0,
    rolling_seconds=60.0,
)
FULL = Plan(
    impacts={
        (100, 10): (0.12, 0.25, 0.4),
        (500, 10): (0.15, 0.3, 0.5),
        (1000, 5): (0.25, 0.5),
        (1000, 10): (0.15, 0.25, 0.4, 0.6),
        (1000, 20): (0.15, 0.25, 0.5),
        (2000, 10): (0.2, 0.4, 0.5),
    },
    grids=(385, 769),
    rolling=tuple(
        [(100, 10, wave) for wave in (0.2, 0.4)]
        + [(200, 10, wave) for wave in (0.25, 0.5, 0.75, 1.0)]
        + [(1000, 10, wave) for wave in (0.3, 0.5, 0.75, 1.0)]
    ),
    rolling_grids=(257, 513),
    seconds=300.0,
    rolling_seconds=900.0,
)


def plan(quick: bool) -> Plan:
    """What is run, coarse or not."""
    return QUICK if quick else FULL


# -- runs -------------------------------------------------------------------------------------------------------------


def wavy_impact(
    M: float, L: float, waves: Sequence[tuple[float, float]], nodes: int, linear: bool = False
) -> xr.Dataset:
    """H(X), and dH/A_i and the waves' shape (wave, X) along Y = 0 at maximum approach.

    waves: height A_i in units of the trapped film, and wavelength (a*), of each.  Raises RuntimeError where a run gave
    up.
    """
    solver = {"nodes": nodes, "half_width": HALF_WIDTH, "tolerance": 1e-4}
    case = parse_case({"contact": {"M": M, "L": L}, "solver": solver, "time": {"start_approach": START}})
    heights = [share * case.parameters.trapped_film for share, _ in waves]
    shapes = [Waviness(A, wave, wave) for A, (_, wave) in zip(heights, waves, strict=True)]
    data = respond(case, [[Feature(shape)] for shape in shapes], linear)
    if data.attrs["status"] != "converged":
        raise RuntimeError(f"M = {M}, L = {L}, {nodes} nodes: {data.attrs['status']}")
    line = data[["H", "dH"]].assign(shape=data["roughness"]).drop_vars("roughness").sel(Y=0.0, method="nearest")
    scale = xr.DataArray(heights, dims="wave")
    return line.assign(dH=line["dH"] / scale, shape=line["shape"] / scale).drop_attrs().load()


def wavy_rolling(M: float, L: float, wavelength: float, nodes: int) -> tuple[float, float]:
    """A_d/A_i at the centre of a rolling contact, and how much it still changes from a period to the next.

    The waves roll in behind a front that starts upstream of the contact; counted are the last two periods before they
    have filled it and one period more.
    """
    start, length = -1.5, 2.0 * 1.5
    until = -start + 1.0 + 3 * wavelength
    source = {
        "contact": {"kind": "rolling", "M": M, "L": L},
        "solver": {"method": "transient", "nodes": nodes, "half_width": 1.75, "inlet": 2.25, "tolerance": 1e-4},
        "time": {"until": until, "step": wavelength / ceil(wavelength / (length / nodes))},
        "output": {"interval": until},
    }
    case = parse_case(source)
    height = HEIGHT * case.film_scale
    wave = Waviness(height, wavelength, wavelength, front=start, ramp=wavelength)
    result = simulate(replace(case, roughness=(Feature(wave),)))
    if not result.status.ok:
        raise RuntimeError(f"rolling, M = {M}, L = {L}, wavelength {wavelength}: {result.status.value}")
    T, H = result.dataset["time"].values, result.dataset["H_c"].values
    last, before = (_half_range(T, H, until - n * wavelength, wavelength) / height for n in (0, 1))
    return last, abs(last - before)


def _half_range(T: Values, H: Values, end: float, period: float) -> float:
    during = H[(T > end - period * (1 + 1e-9)) & (T <= end * (1 + 1e-9))]
    return float(during.max() - during.min()) / 2


def impact_tasks(quick: bool) -> list[Task]:
    """For every (M, L): the front by the radial method, the waves on the coarse and on the fine grid."""
    p, tasks = plan(quick), []
    for (M, L), waves in p.impacts.items():
        tasks.append(radial_task(M, L, quick))
        for nodes in p.grids:
            seconds = p.seconds * (len(waves) + 1) * (nodes / p.grids[1]) ** 2
            name = f"waves_M{M:g}_L{L:g}_{nodes}"
            tasks.append(Task(name, wavy_impact, (M, L, tuple((HEIGHT, w) for w in waves), nodes), seconds))
    return tasks


def check_task(quick: bool, linear: bool) -> Task:
    """One wavelength with other heights; or its tangent-linear response."""
    p = plan(quick)
    heights, nodes = (HEIGHT,) if linear else CHECKED, p.grids[0]
    waves = tuple((height, p.impacts[SHOWN][0]) for height in heights)
    name = f"waves_{'linear' if linear else 'heights'}_{nodes}"
    return Task(name, wavy_impact, (*SHOWN, waves, nodes, linear), 2 * p.seconds)


def rolling_tasks(quick: bool) -> list[Task]:
    """Every rolling contact on both grids."""
    p = plan(quick)
    return [
        Task(
            f"rolling_M{M:g}_L{L:g}_{wave:g}_{nodes}",
            wavy_rolling,
            (M, L, wave, nodes),
            p.rolling_seconds * (nodes / p.rolling_grids[1]) ** 3,
        )
        for M, L, wave in p.rolling
        for nodes in p.rolling_grids
    ]


def all_tasks(quick: bool) -> list[Task]:
    """What Fig. 6 takes."""
    return [*impact_tasks(quick), check_task(quick, False), check_task(quick, True), *rolling_tasks(quick)]


# -- what the runs say ------------------------------------------------------------------------------------------------


class Dot(NamedTuple):
    """One dot of Fig. 6: A_d/A_i on both grids and extrapolated; nabla2 by three speeds of the front, and global."""

    M: float
    L: float
    wavelength: float
    X: float
    coarse: float
    fine: float
    limit: float
    local: Sequence[float]  # speed by the least film, half of Hertz' pressure, the dry law
    everywhere: float


def dots(plan: Plan, results: Sequence[xr.Dataset]) -> Iterator[Dot]:
    """The dots, from the results of `impact_tasks`."""
    triples = zip(*[iter(results)] * 3, strict=False)
    for ((M, L), wavelengths), (smooth, *grids) in zip(plan.impacts.items(), triples, strict=False):
        p = Parameters.from_moes(M, L)
        by_film, by_pressure = analysis.front(smooth), analysis.front(smooth, "half-hertz")
        for number, wavelength in enumerate(wavelengths):
            coarse, fine = (_last_wave(grid, number, float(by_film.A[-1])) for grid in grids)
            speeds = (f(fine.X) for f in (by_film.speed_at, by_pressure.speed_at, hertz.front_speed))
            local = [float(analysis.local_nabla2(p, wavelength, speed)) for speed in speeds]
            limit = fine.amplitude + (fine.amplitude - coarse.amplitude) / 3
            amplitudes = coarse.amplitude, fine.amplitude, limit
            yield Dot(M, L, wavelength, fine.X, *amplitudes, local, p.nabla2(wavelength))


def _last_wave(data: xr.Dataset, number: int, edge: float) -> Wave:
    return analysis.last_wave(data["X"].values, data["dH"][number].values, edge)


class Scatter(NamedTuple):
    """Of dots about a curve, in A_d/A_i: mean and root mean square."""

    mean: float
    rms: float


def scatter(values: Sequence[float], curve: Values) -> Scatter:
    """How dots lie about a curve."""
    off = np.asarray(values) - curve
    return Scatter(float(off.mean()), float(np.sqrt(np.mean(off**2))))


# -- Fig. 5 -----------------------------------------------------------------------------------------------------------


def deformed_waves(results: Sequence[xr.Dataset], quick: bool) -> Drawn:
    """Fig. 5: dH(X, 0)/A_i at maximum impact, inside and outside the contact."""
    p = plan(quick)
    place = 3 * list(p.impacts).index(SHOWN)
    smooth, _, fine = results[place : place + 3]
    edge, X = float(analysis.front(smooth).A[-1]), fine["X"].values
    wavelengths = p.impacts[SHOWN]
    figure, panels = new_figure(len(wavelengths), 1)
    figure.set_size_inches(8.0, 2.4 * len(wavelengths))
    rows, columns = [], {"X": X, "H": fine["H"].values}
    for number, (wavelength, axes) in enumerate(zip(wavelengths, panels, strict=True)):
        dH, shape = fine["dH"][number].values, fine["shape"][number].values
        axes.plot(X, -shape, color=GREY, linewidth=0.7, linestyle=":", label="undeformed: $-\\mathcal{R}/A_i$")
        axes.plot(X, dH, color=BLUE, label="$dH/A_i$")
        wave = _last_wave(fine, number, edge)
        axes.axvspan(wave.start, wave.end, color=ORANGE, alpha=0.2, label="last complete wave")
        for side in (-edge, edge):
            axes.axvline(side, color="black", linewidth=0.7)
        axes.set(xlim=(-HALF_WIDTH, HALF_WIDTH), ylim=(-1.15, 1.15), ylabel=f"$\\Lambda$ = {wavelength:g}")
        columns[f"dH/A_i, wavelength {wavelength:g}"] = dH
        rows.append([f"{wavelength:g}", f"{wave.X:.3f}", f"{wave.amplitude:.3f}"])
    panels[0].legend(loc="lower left", frameon=True, fontsize="x-small", ncols=3)
    panels[-1].set_xlabel("$X$ ($a^*$)")
    M, L = SHOWN
    caption = (
        f"dH(X, 0) over A_i at maximum impact, M = {M}, L = {L}, roughness A_i cos(2 pi X/Lambda) cos(2 pi Y/Lambda) "
        f"(a crest of metal at the centre), A_i = {HEIGHT} sqrt(L/M), {p.grids[1]} nodes a side.  The vertical lines "
        "are where the film is least.  The deformation grows outwards and with the wavelength, and the waves are "
        "shifted outwards; beyond the contact the surface keeps its waves."
    )
    head = ["wavelength (a*)", "place of the last wave X", "A_d/A_i on this grid"]
    return Drawn(figure, caption, {"dH": columns}, [Table(head, rows)])


# -- Fig. 6 -----------------------------------------------------------------------------------------------------------


def reduction(results: Sequence[Any], quick: bool) -> Drawn:
    """Fig. 6: A_d/A_i of impact and of rolling against nabla2, local and global, over the curve (15)."""
    p = plan(quick)
    found = list(dots(p, results[: 3 * len(p.impacts)]))
    heights, linear = results[3 * len(p.impacts) : 3 * len(p.impacts) + 2]
    rolled = list(_rolled(p, results[3 * len(p.impacts) + 2 :]))
    figure, (left, right) = new_figure(1, 2)
    for axes in (left, right):
        _draw_curves(axes)
    _draw_dots(left, found, [dot.local[0] for dot in found], errors=True)
    _draw_dots(right, found, [dot.everywhere for dot in found], errors=False)
    for axes in (left, right):
        values = np.array([[n, fine, limit] for n, _, fine, limit, _, _ in rolled])
        axes.errorbar(
            values[:, 0],
            values[:, 2],
            np.abs(values[:, 2] - values[:, 1]),
            fmt="s",
            color="black",
            markerfacecolor="white",
            label="rolling",
            capsize=2,
        )
    left.set_xlabel("local $\\nabla_2$")
    right.set_xlabel("global $\\nabla_2$ (rolling: its own)")
    left.legend(loc="lower left", frameon=False, fontsize="x-small")
    tables = [
        _dots_table(found),
        _scatter_table(found, rolled),
        _rolling_table(p, rolled),
        _check_table(quick, heights, linear),
    ]
    caption = (
        "Amplitude reduction.  Dots: the last complete wave inside the contact at maximum impact, extrapolated from "
        f"grids of {p.grids[0]} and {p.grids[1]} nodes a side, the bar is what was extrapolated; horizontally the "
        "range of three speeds of the front (least film, half of Hertz' pressure, exact dry law) at that place.  "
        "Squares: rolling over the same waviness, at the contact's centre, once periodic.  Line: eq. (15); dashed: the "
        "curve of transverse waviness in a line contact."
    )
    columns = {
        name: np.array([getattr(dot, name) for dot in found])
        for name in ("M", "L", "wavelength", "X", "coarse", "fine", "limit", "everywhere")
    }
    columns |= {f"local, {name}": np.array([d.local[i] for d in found]) for i, name in enumerate(SPEEDS)}
    data = {"impact": columns, "rolling": dict(zip(ROLLED, np.array(rolled).T, strict=True))}
    return Drawn(figure, caption, data, tables)


SPEEDS = (NAMES["film"], NAMES["half-hertz"], "dry law")
ROLLED = ("nabla2", "coarse", "fine", "limit", "change over the last period", "wavelength")


def _rolled(plan: Plan, results: Sequence[tuple[float, float]]) -> Iterator[tuple[float, ...]]:
    for (M, L, wavelength), coarse, fine in zip(plan.rolling, results[::2], results[1::2], strict=True):
        nabla2 = Parameters.from_moes(M, L).nabla2(wavelength)
        yield nabla2, coarse[0], fine[0], fine[0] + (fine[0] - coarse[0]) / 3, fine[1], wavelength


def _draw_curves(axes: Axes) -> None:
    n = np.geomspace(0.3, 30, 200)
    axes.semilogx(n, formulas.amplitude_reduction(n), color="black", label="(15), isotropic")
    axes.semilogx(n, formulas.amplitude_reduction_line(n), color=GREY, linestyle="--", label="line contact, transverse")
    axes.set(ylim=(0, 1.05), xlim=(0.4, 20), ylabel="$A_d/A_i$")
    axes.set_xticks([0.5, 1, 2, 5, 10, 20], ["0.5", "1", "2", "5", "10", "20"])


def _draw_dots(axes: Axes, found: Sequence[Dot], nabla2: Sequence[float], errors: bool) -> None:
    cases = list(dict.fromkeys((dot.M, dot.L) for dot in found))
    shades = ORDERED_COLOURS(np.linspace(0.95, 0.0, len(cases)))
    for case, colour, marker in zip(cases, shades, "ovD^P*<>", strict=False):
        own = [(n, dot) for n, dot in zip(nabla2, found, strict=True) if (dot.M, dot.L) == case]
        limit = np.array([dot.limit for _, dot in own])
        place = np.array([n for n, _ in own])
        across = np.array([(n - min(dot.local), max(dot.local) - n) for n, dot in own]).T if errors else None
        bar = np.abs(limit - [dot.fine for _, dot in own])
        label = f"impact, M = {case[0]:g}, L = {case[1]:g}"
        axes.errorbar(place, limit, bar, across, fmt=marker, color=colour, label=label, capsize=2, elinewidth=0.8)


def _dots_table(found: Sequence[Dot]) -> Table:
    head = ["M", "L", "wavelength", "X", "A_d/A_i coarse", "fine", "extrapolated", "nabla2 local", "global", "(15)"]
    rows = []
    for d in found:
        curve = float(formulas.amplitude_reduction(d.local[0]))
        numbers = [f"{value:.3f}" for value in (d.X, d.coarse, d.fine, d.limit)]
        rows.append(
            [
                f"{d.M:g}",
                f"{d.L:g}",
                f"{d.wavelength:g}",
                *numbers,
                f"{d.local[0]:.2f}",
                f"{d.everywhere:.2f}",
                f"{curve:.3f}",
            ]
        )
    return Table(head, rows)


def _scatter_table(found: Sequence[Dot], rolled: Sequence[tuple[float, ...]]) -> Table:
    values = [dot.limit for dot in found]
    kinds = {f"impact, local nabla2, speed by {name}": [d.local[i] for d in found] for i, name in enumerate(SPEEDS)}
    kinds["impact, global nabla2"] = [d.everywhere for d in found]
    rows = []
    for name, n in kinds.items():
        rows.append([name, *_about(values, n)])
    rows.append(["rolling", *_about([row[3] for row in rolled], [row[0] for row in rolled])])
    return Table(["A_d/A_i less the curve: mean, root mean square", "isotropic (15)", "line contact"], rows)


def _about(values: Sequence[float], nabla2: Sequence[float]) -> list[str]:
    curves = formulas.amplitude_reduction(nabla2), formulas.amplitude_reduction_line(nabla2)
    return [f"{s.mean:+.3f}, {s.rms:.3f}" for s in (scatter(values, curve) for curve in curves)]


def _rolling_table(plan: Plan, rolled: Sequence[tuple[float, ...]]) -> Table:
    head = [
        "rolling: M",
        "L",
        "wavelength",
        "nabla2",
        "A_d/A_i coarse",
        "fine",
        "extrapolated",
        "(15)",
        "still changing",
    ]
    rows = []
    for (M, L, wavelength), (n, coarse, fine, limit, change, _) in zip(plan.rolling, rolled, strict=True):
        numbers = [f"{value:.3f}" for value in (coarse, fine, limit, float(formulas.amplitude_reduction(n)), change)]
        rows.append([f"{M:g}", f"{L:g}", f"{wavelength:g}", f"{n:.2f}", *numbers])
    return Table(head, rows)


def _check_table(quick: bool, heights: xr.Dataset, linear: xr.Dataset) -> Table:
    """That A_d/A_i does not depend on A_i."""
    rows = [["0: tangent-linear", f"{_last_wave(linear, 0, 1.0).amplitude:.4f}"]]
    for number, height in enumerate(CHECKED):
        rows.append([f"{height:g}", f"{_last_wave(heights, number, 1.0).amplitude:.4f}"])
    M, L = SHOWN
    wavelength, nodes = plan(quick).impacts[SHOWN][0], plan(quick).grids[0]
    return Table([f"A_i / sqrt(L/M), M = {M}, L = {L}, wavelength {wavelength:g}, {nodes} nodes", "A_d/A_i"], rows)
