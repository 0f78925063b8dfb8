"""Waviness in impact and in rolling: the runs of Figs. 5 and 6 and what they leave of the waves; Fig. 5.

How much a value may still change with the grid is stated in one way everywhere, see `Extrapolated`.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from math import ceil
from typing import Any, NamedTuple

import xarray as xr

from ertel.apps.boundary_layers.front import new_figure, radial_task, smooth_impact
from ertel.apps.boundary_layers.page import Drawn, Table
from ertel.inputs.case_files import parse_case
from ertel.model.case import Case
from ertel.model.sections import Time
from ertel.physics import hertz
from ertel.physics.scales import Parameters
from ertel.physics.surfaces import Feature, Waviness
from ertel.results import fronts, waves
from ertel.results.fronts import Front, Values
from ertel.results.plots.drawing import BLUE, GREY, ORANGE
from ertel.results.waves import Wave
from ertel.runs.drive import simulate
from ertel.runs.response import respond
from ertel.runs.sweep import Task

HEIGHT = 0.01  # A_i in units of the trapped film sqrt(L/M): small
CHECKED = (0.005, 0.02, 0.05)  # other heights, to show that A_d/A_i does not depend on it
HALF_WIDTH, START = 1.5, -0.5  # of the waves' grid (a*), and Delta_0
SHOWN = (1000, 10)  # M, L of Fig. 5 and of the checks
STEPPED = -1  # of the rolling contacts, the one that is checked
SHORTER = 2  # time steps, when checked; their local error is of third order


@dataclass(frozen=True)
class Plan:
    """What is run.  impacts: wavelengths of (M, L); grids: nodes per side, coarse and fine.

    rolling: M, L, wavelength, and nodes per side of the fine grid.  twins: M, L, wavelength and X of the
    `rolling_twin`s, X the place of a wave; their grids.
    """

    impacts: Mapping[tuple[float, float], tuple[float, ...]]
    grids: tuple[int, int]
    rolling: tuple[tuple[float, float, float, int], ...]
    twins: tuple[tuple[float, float, float, float], ...]
    twin_grids: tuple[int, int]


QUICK = Plan(
    impacts={(200, 10): (0.25, 0.4), (1000, 10): (0.25, 0.4, 0.6), (1000, 5): (0.25, 0.5)},
    grids=(97, 193),
    rolling=((200, 10, 0.5, 129), (200, 10, 1.0, 129), (1000, 10, 0.5, 129)),
    twins=((1000, 10, 0.4, 0.73), (1000, 10, 0.6, 0.5)),
    twin_grids=(65, 129),
)
FULL = Plan(
    impacts={
        (100, 10): (0.12, 0.25, 0.4),
        (200, 10): (0.25, 0.4),
        (500, 10): (0.15, 0.3, 0.5),
        (1000, 5): (0.25, 0.5),
        (1000, 10): (0.15, 0.25, 0.4, 0.6),
        (1000, 20): (0.15, 0.25, 0.5),
        (2000, 5): (0.4,),
        (2000, 10): (0.2, 0.4, 0.5),
    },
    grids=(257, 513),
    rolling=(
        (100, 20, 0.25, 513),
        (100, 10, 0.4, 513),
        (200, 10, 0.25, 513),
        (200, 10, 0.5, 513),
        (200, 10, 0.75, 257),
        (200, 10, 1.0, 257),
        (1000, 10, 0.3, 513),
        (1000, 10, 0.5, 513),
        (1000, 10, 0.75, 257),
        (1000, 10, 1.0, 257),
    ),
    twins=(
        (500, 10, 0.5, 0.4),
        (500, 10, 0.5, 0.66),
        (1000, 5, 0.5, 0.67),
        (1000, 10, 0.4, 0.53),
        (1000, 10, 0.4, 0.73),
        (1000, 10, 0.6, 0.5),
        (2000, 10, 0.5, 0.67),
    ),
    twin_grids=(129, 257),
)


def impact_seconds(impacts: int, nodes: int) -> float:
    """What impacts in lockstep take: start and compilation, and 18 s each on 513 nodes (measured, one core)."""
    return 5.0 + impacts * 18.0 * (nodes / 513) ** 2


def rolling_seconds(nodes: int) -> float:
    """What a rolling contact takes: 330 s on 513 nodes, an eighth of it on half as many (measured, one core)."""
    return 5.0 + 330.0 * (nodes / 513) ** 3


def half(nodes: int) -> int:
    """Nodes of the grid with twice the spacing."""
    return (nodes + 1) // 2


def plan(quick: bool) -> Plan:
    """What is run, coarse or not."""
    return QUICK if quick else FULL


# -- runs -------------------------------------------------------------------------------------------------------------


def impact_case(M: float, L: float, nodes: int, oil: Mapping[str, str] | None = None, finer: float = 1.0) -> Case:
    """The smooth impact under the waves.  oil: a case file's [lubricant]; finer: divides the tolerance in time."""
    solver = {"nodes": nodes, "half_width": HALF_WIDTH, "tolerance": 1e-4}
    time = {"start_approach": START, "tolerance": Time.tolerance / finer}
    return parse_case({"contact": {"M": M, "L": L}, "lubricant": oil or {}, "solver": solver, "time": time})


def wavy_impact(
    M: float,
    L: float,
    waves: Sequence[tuple[float, float]],
    nodes: int,
    linear: bool = False,
    finer: float = 1.0,
) -> xr.Dataset:
    """H(X), and dH/A_i and the waves' shape (wave, X) along Y = 0 at maximum approach.

    waves: height A_i in units of the trapped film, and wavelength (a*), of each.  finer: see `impact_case`.  Raises
    RuntimeError where a run gave up.
    """
    case = impact_case(M, L, nodes, finer=finer)
    heights = [share * case.parameters.trapped_film for share, _ in waves]
    shapes = [Waviness(A, wave, wave) for A, (_, wave) in zip(heights, waves, strict=True)]
    data = respond(case, [[Feature(shape)] for shape in shapes], linear)
    if data.attrs["status"] != "converged":
        raise RuntimeError(f"M = {M}, L = {L}, {nodes} nodes: {data.attrs['status']}")
    line = data[["H", "dH"]].assign(shape=data["roughness"]).drop_vars("roughness").sel(Y=0.0, method="nearest")
    scale = xr.DataArray(heights, dims="wave")
    return line.assign(dH=line["dH"] / scale, shape=line["shape"] / scale).drop_attrs().load()


def wavy_rolling(
    M: float, L: float, wavelength: float, nodes: int, across: float | None = None, finer: int = 1
) -> tuple[float, float]:
    """A_d/A_i at the centre of a rolling contact, and how much it still changes from a period to the next.

    The waves roll in behind a front that starts upstream of the contact; counted are the last two periods before they
    have filled it and one period more.  across: the wavelength along Y, infinite for transverse waves; the same as
    along X unless given.  finer: time steps for each that is usual.
    """
    start, length = -1.5, 2.0 * 1.5
    until = -start + 1.0 + 3 * wavelength
    steps = finer * ceil(wavelength / (length / nodes))
    source = {
        "contact": {"kind": "rolling", "M": M, "L": L},
        "solver": {"method": "transient", "nodes": nodes, "half_width": 1.75, "inlet": 2.25, "tolerance": 1e-4},
        "time": {"until": until, "step": wavelength / steps},
        "output": {"interval": until},
    }
    case = parse_case(source)
    height = HEIGHT * case.film_scale
    wave = Waviness(height, wavelength, across or wavelength, front=start, ramp=wavelength)
    result = simulate(replace(case, roughness=(Feature(wave),)))
    if not result.status.ok:
        raise RuntimeError(f"rolling, M = {M}, L = {L}, wavelength {wavelength}: {result.status.value}")
    T, H = result.dataset["time"].values, result.dataset["H_c"].values
    last, before = (_half_range(T, H, until - n * wavelength, wavelength) / height for n in (0, 1))
    return last, abs(last - before)


def _half_range(T: Values, H: Values, end: float, period: float) -> float:
    during = H[(T > end - period * (1 + 1e-9)) & (T <= end * (1 + 1e-9))]
    return float(during.max() - during.min()) / 2


def rolling_twin(M: float, L: float, wavelength: float, X: float, nodes: int) -> tuple[float, float, float]:
    """Rolling in the place of an impact's front as it passes X: its nabla2, and what `wavy_rolling` tells.

    Its surfaces run with the front's speed v, its Hertz contact is the one that the impact has then, of radius X:
    lambda_bar v/X^4, alpha_bar X, wavelength/X.
    """
    solver = {"method": "radial", "nodes": 401, "half_width": 4.0}
    speed = float(fronts.front(smooth_impact(M, L, solver, 10.0)).speed_at(X))
    p = Parameters.from_moes(M, L)
    local = Parameters(p.lambda_bar * speed / X**4, p.alpha_bar * X)
    return local.nabla2(wavelength / X), *wavy_rolling(local.M, local.L, wavelength / X, nodes)


def impact_tasks(quick: bool) -> list[Task]:
    """For every (M, L): the front by the radial method, the waves on the coarse and on the fine grid."""
    p, tasks = plan(quick), []
    for (M, L), wavelengths in p.impacts.items():
        tasks.append(radial_task(M, L, quick))
        for nodes in p.grids:
            seconds = impact_seconds(len(wavelengths) + 1, nodes)
            name = f"waves_M{M:g}_L{L:g}_{nodes}"
            tasks.append(Task(name, wavy_impact, (M, L, tuple((HEIGHT, w) for w in wavelengths), nodes), seconds))
    return tasks


def check_tasks(quick: bool) -> list[Task]:
    """On the coarse grid: other heights of the waves, their tangent-linear response, and time steps half as long."""
    p = plan(quick)
    nodes, waves = p.grids[0], [(HEIGHT, wave) for wave in p.impacts[SHOWN]]
    others, (M, L, wavelength, fine) = tuple((height, waves[0][1]) for height in CHECKED), p.rolling[STEPPED]
    runs: list[tuple[str, tuple[Any, ...]]] = [
        ("heights", (others, nodes, False)),
        ("linear", ((waves[0],), nodes, True)),
        ("steps", (tuple(waves), nodes, False, SHORTER**3)),
    ]
    tasks = [
        Task(f"waves_{name}_{nodes}", wavy_impact, (*SHOWN, *arguments), impact_seconds(len(arguments[0]) + 1, nodes))
        for name, arguments in runs
    ]
    arguments = M, L, wavelength, half(fine), None, SHORTER
    return [*tasks, Task(f"rolling_steps_{half(fine)}", wavy_rolling, arguments, SHORTER * rolling_seconds(half(fine)))]


def rolling_tasks(quick: bool) -> list[Task]:
    """Every rolling contact on both grids."""
    return [
        Task(f"rolling_M{M:g}_L{L:g}_{wave:g}_{nodes}", wavy_rolling, (M, L, wave, nodes), rolling_seconds(nodes))
        for M, L, wave, fine in plan(quick).rolling
        for nodes in (half(fine), fine)
    ]


def twin_tasks(quick: bool) -> list[Task]:
    """Rolling in the place of an impact's front, on both grids."""
    p = plan(quick)
    return [
        Task(
            f"twin_M{M:g}_L{L:g}_{wave:g}_at_{X:g}_{nodes}",
            rolling_twin,
            (M, L, wave, X, nodes),
            10.0 + rolling_seconds(nodes),
        )
        for M, L, wave, X in p.twins
        for nodes in p.twin_grids
    ]


# -- what the runs say ------------------------------------------------------------------------------------------------


class Extrapolated(NamedTuple):
    """A value on two grids, the fine one with half the spacing."""

    coarse: float
    fine: float

    @property
    def limit(self) -> float:
        """Without the error of a method of second order (Richardson)."""
        return self.fine + (self.fine - self.coarse) / 3

    @property
    def error(self) -> float:
        """The bar: from the limit as far as where a method of first order would have it."""
        return 2 / 3 * abs(self.fine - self.coarse)


class Dot(NamedTuple):
    """One wave in an impact: A_d/A_i at X; nabla2 by three speeds of the front, with the Hertz contact then, global."""

    M: float
    L: float
    wavelength: float
    X: float
    ratio: Extrapolated
    local: Sequence[float]  # speed by the least film, half of Hertz' pressure, the dry law
    hertz: float
    everywhere: float
    last: bool  # of its waves, the one nearest the edge


def dots(plan: Plan, results: Sequence[xr.Dataset]) -> Iterator[Dot]:
    """Every complete wave inside the contact, from the results of `impact_tasks`; Fig. 6 has the last ones."""
    triples = zip(*[iter(results)] * 3, strict=False)
    for ((M, L), wavelengths), (smooth, *grids) in zip(plan.impacts.items(), triples, strict=False):
        both = fronts.front(smooth), fronts.front(smooth, "half-hertz")
        for number, wavelength in enumerate(wavelengths):
            coarse, fine = (_waves(grid, number, float(both[0].A[-1])) for grid in grids)
            pairs = list(zip(coarse[::-1], fine[::-1], strict=False))  # from the edge inwards
            for pair in pairs[::-1]:
                yield _dot(M, L, wavelength, pair, both, pair is pairs[0])


def _dot(M: float, L: float, wavelength: float, pair: tuple[Wave, Wave], both: Sequence[Front], last: bool) -> Dot:
    p, X = Parameters.from_moes(M, L), pair[1].X
    speeds = [float(f(X)) for f in (*(front.speed_at for front in both), hertz.front_speed)]
    local = [float(waves.local_nabla2(p, wavelength, speed)) for speed in speeds]
    then = float(waves.local_nabla2(p, wavelength, speeds[0], X))
    ratio = Extrapolated(*(wave.amplitude for wave in pair))
    return Dot(M, L, wavelength, X, ratio, local, then, p.nabla2(wavelength), last)


def _waves(data: xr.Dataset, number: int, edge: float) -> list[Wave]:
    return waves.waves(data["X"].values, data["dH"][number].values, edge)


def last_wave(data: xr.Dataset, number: int, edge: float) -> Wave:
    """The last complete wave of the wave's number inside the edge, see `waves.last_wave`."""
    return waves.last_wave(data["X"].values, data["dH"][number].values, edge)


# -- Fig. 5 -----------------------------------------------------------------------------------------------------------


def deformed_waves(results: Sequence[xr.Dataset], quick: bool) -> Drawn:
    """Fig. 5: dH(X, 0)/A_i at maximum impact, inside and outside the contact."""
    p = plan(quick)
    place = 3 * list(p.impacts).index(SHOWN)
    smooth, _, fine = results[place : place + 3]
    edge, X = float(fronts.front(smooth).A[-1]), fine["X"].values
    wavelengths = p.impacts[SHOWN]
    figure, panels = new_figure(len(wavelengths), 1)
    figure.set_size_inches(8.0, 2.4 * len(wavelengths))
    rows, columns = [], {"X": X, "H": fine["H"].values}
    for number, (wavelength, axes) in enumerate(zip(wavelengths, panels, strict=True)):
        dH, shape = fine["dH"][number].values, fine["shape"][number].values
        axes.plot(X, -shape, color=GREY, linewidth=0.7, linestyle=":", label="undeformed: $-\\mathcal{R}/A_i$")
        axes.plot(X, dH, color=BLUE, label="$dH/A_i$")
        wave = last_wave(fine, number, edge)
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
