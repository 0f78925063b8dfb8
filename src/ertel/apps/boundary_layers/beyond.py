"""Beyond the paper: waves of other shapes, and other lubricants.

Figure 7 has transverse, longitudinal and ring waviness in impact and in rolling, figure 8 isotropic waviness in impacts
with other laws for the oil.  Everything else is as in Fig. 6.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from math import inf
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from numpy.typing import ArrayLike

from ertel.apps.boundary_layers.front import new_figure
from ertel.apps.boundary_layers.page import Drawn, Table
from ertel.apps.boundary_layers.reduction import RATIO_HEAD, draw_curves, ratio_cells, scatter
from ertel.apps.boundary_layers.waves import (
    HEIGHT,
    Extrapolated,
    impact_case,
    impact_seconds,
    rolling_seconds,
    wavy_rolling,
)
from ertel.inputs.case_files import parse_case
from ertel.physics import amplitude_reduction
from ertel.physics.scales import Parameters
from ertel.physics.surfaces import Feature, RingWaviness, Shape, Waviness
from ertel.results import fronts, waves
from ertel.results.fronts import Front, Values
from ertel.results.plots.drawing import BLUE, GREEN, GREY, ORANGE
from ertel.runs.drive import simulate
from ertel.runs.response import respond
from ertel.runs.sweep import Task

Case = tuple[float, float]  # M, L
SHAPES: Mapping[str, Callable[[float, float], Shape]] = {  # of A_i and the wavelength
    "isotropic": lambda height, wavelength: Waviness(height, wavelength, wavelength),
    "transverse": lambda height, wavelength: Waviness(height, wavelength),
    "rings": lambda height, wavelength: RingWaviness(height, wavelength),
}
USUAL, SOFT = "Roelands, compressible", "isoviscous"
OILS: Mapping[str, Mapping[str, str]] = {  # a case file's [lubricant]
    USUAL: {},
    "Roelands, incompressible": {"density": "incompressible"},
    "Barus, incompressible": {"viscosity": "barus", "density": "incompressible"},
    SOFT: {"viscosity": "isoviscous", "density": "incompressible"},
}


@dataclass(frozen=True)
class Plan:
    """What is run.  Wavelengths of (M, L) of impacts; M, L, wavelength of rolling; nodes a side, coarse and fine.

    soft: wavelengths of M with the isoviscous oil, L = 0.
    """

    shaped: Mapping[Case, tuple[float, ...]]
    oils: Mapping[Case, tuple[float, ...]]
    soft: Mapping[float, tuple[float, ...]]
    grids: tuple[int, int]
    rolling: tuple[tuple[float, float, float], ...]
    rolling_grids: tuple[int, int]


QUICK = Plan(
    shaped={(1000, 10): (0.25, 0.4)},
    oils={(1000, 5): (0.4,)},
    soft={200: (0.2,)},
    grids=(97, 193),
    rolling=((200, 10, 1.0), (1000, 10, 1.0)),
    rolling_grids=(65, 129),
)
FULL = Plan(
    shaped={(200, 10): (0.3, 0.5), (1000, 10): (0.25, 0.4), (1000, 5): (0.25, 0.5)},
    oils={(500, 10): (0.3, 0.5), (1000, 5): (0.25, 0.5)},
    soft={100: (0.15, 0.3), 500: (0.15, 0.3)},
    grids=(193, 385),
    rolling=((200, 10, 0.5), (200, 10, 1.0), (1000, 10, 0.5), (1000, 10, 1.0)),
    rolling_grids=(129, 257),
)


def plan(quick: bool) -> Plan:
    """What is run, coarse or not."""
    return QUICK if quick else FULL


# -- runs -------------------------------------------------------------------------------------------------------------


def shaped_impact(M: float, L: float, shapes: Sequence[tuple[str, float]], nodes: int, oil: str = USUAL) -> xr.Dataset:
    """H(X), dH/A_i (wave, X) along Y = 0 at maximum approach, and the place of the least film in time.

    shapes: key of `SHAPES` and wavelength (a*) of each; A_i is that of Fig. 6.  oil: of `OILS`.  `along` (wave, X)
    is what is left of transverse waves where the front ran along their ridges, see `waves.ridge_amplitude`; nan for
    the other shapes.  Raises RuntimeError where a run gave up.
    """
    case = impact_case(M, L, nodes, OILS[oil])
    height = HEIGHT * case.parameters.trapped_film
    data = respond(case, [[Feature(SHAPES[shape](height, wavelength))] for shape, wavelength in shapes])
    if data.attrs["status"] != "converged":
        raise RuntimeError(f"M = {M}, L = {L}, {oil}, {nodes} nodes: {data.attrs['status']}")
    X, Y = data["X"].values, data["Y"].values
    along = [
        waves.ridge_amplitude(X, Y, dH / height, wavelength, X) if shape == "transverse" else np.full(len(X), np.nan)
        for (shape, wavelength), dH in zip(shapes, data["dH"].values, strict=True)
    ]
    line = data[["H", "dH", "X_min", "P_max"]].drop_vars("roughness").sel(Y=0.0, method="nearest")
    return line.assign(dH=line["dH"] / height, along=(("wave", "X"), np.stack(along))).drop_attrs().load()


def ridged_rolling(M: float, L: float, wavelength: float, nodes: int) -> float:
    """A_d/A_i of longitudinal ridges under rolling: half of what crest and trough next to the centre differ in dH.

    Such ridges do not change where their surface goes, so that the contact is steady.  Raises RuntimeError where a run
    gave up.
    """
    solver = {"method": "steady", "nodes": nodes, "half_width": 1.75, "inlet": 2.25}
    smooth = parse_case({"contact": {"kind": "rolling", "M": M, "L": L}, "solver": solver})
    height = HEIGHT * smooth.film_scale
    ridges = replace(smooth, roughness=(Feature(Waviness(height, inf, wavelength)),))
    films = []
    for case in (smooth, ridges):
        result = simulate(case)
        if not result.status.ok:
            raise RuntimeError(f"rolling, M = {M}, L = {L}, ridges {wavelength}: {result.status.value}")
        films.append(result.dataset["H"].squeeze().sel(X=0.0, method="nearest").drop_vars("X"))
    across = (films[1] - films[0]).interp(Y=[0.0, wavelength / 2], method="cubic").values
    return float(abs(across[1] - across[0])) / (2 * height)


def shape_tasks(quick: bool) -> list[Task]:
    """What Fig. 7 takes: impacts on both grids, then rolling on both grids over transverse and over long ridges."""
    p = plan(quick)
    tasks = []
    for case, wavelengths in p.shaped.items():
        waves = tuple((shape, w) for w in wavelengths for shape in ("transverse", "rings"))
        tasks += _impacts(p, "shapes", case, waves, USUAL)
    for M, L, wavelength in p.rolling:
        for nodes in p.rolling_grids:
            case_name = f"M{M:g}_L{L:g}_{wavelength:g}_{nodes}"
            tasks.append(
                Task(f"transverse_{case_name}", wavy_rolling, (M, L, wavelength, nodes, inf), rolling_seconds(nodes))
            )
            tasks.append(Task(f"ridges_{case_name}", ridged_rolling, (M, L, wavelength, nodes), rolling_seconds(nodes)))
    return tasks


def oil_tasks(quick: bool) -> list[Task]:
    """What Fig. 8 takes: the impacts with every oil but the isoviscous one, then those with that."""
    p, tasks = plan(quick), []
    for case, oil, wavelengths in _oiled(p):
        tasks += _impacts(p, oil.replace(", ", "_"), case, tuple(("isotropic", w) for w in wavelengths), oil)
    return tasks


def _oiled(p: Plan) -> Iterator[tuple[Case, str, tuple[float, ...]]]:
    for case, wavelengths in p.oils.items():
        for oil in OILS:
            if oil != SOFT:
                yield case, oil, wavelengths
    for M, wavelengths in p.soft.items():
        yield (M, 0), SOFT, wavelengths


def _impacts(p: Plan, name: str, case: Case, waves: tuple[tuple[str, float], ...], oil: str) -> list[Task]:
    M, L = case
    return [
        Task(
            f"{name}_M{M:g}_L{L:g}_{nodes}",
            shaped_impact,
            (M, L, waves, nodes, oil),
            impact_seconds(len(waves) + 1, nodes),
        )
        for nodes in p.grids
    ]


# -- what the runs say ------------------------------------------------------------------------------------------------


class Mark(NamedTuple):
    """A_d/A_i of one kind of waves or oil; nabla2 of its own place, with the Hertz contact then, and global.

    Without piezoviscosity nabla2 is infinite; in its place stands what it is otherwise: wavelength over trapped film.
    """

    kind: str
    M: float
    L: float
    wavelength: float
    X: float
    ratio: Extrapolated
    local: float
    hertz: float
    everywhere: float


def over_film(p: Parameters, wavelength: float, speed: float = 1.0, A: float = 1.0) -> float:
    """Wavelength over trapped film for the speed and radius (a*) of the front: nabla2 where alpha_bar is above 0.4.

    nabla2 = wavelength/sqrt(L/M), and sqrt(L/M) is the film at which a rigid ball stops; an isoviscous oil's is
    0.3135 sqrt(lambda_bar).
    """
    return wavelength / A / Parameters(p.lambda_bar * speed / A**4, p.alpha_bar * A).trapped_film


def _mark(kind: str, case: Case, wavelength: float, X: float, ratio: Extrapolated, front: Front) -> Mark:
    p, speed = Parameters.from_moes(*case), float(front.speed_at(X))
    places = over_film(p, wavelength, speed), over_film(p, wavelength, speed, X), over_film(p, wavelength)
    return Mark(kind, *case, wavelength, X, ratio, *places)


def last_waves(case: Case, kind: str, wavelength: float, number: int, grids: Sequence[xr.Dataset]) -> Mark:
    """The last complete wave inside the contact, on both grids."""
    front = fronts.front(grids[1])
    edge = float(front.A[-1])
    coarse, fine = (waves.last_wave(grid["X"].values, grid["dH"][number].values, edge) for grid in grids)
    return _mark(kind, case, wavelength, fine.X, Extrapolated(coarse.amplitude, fine.amplitude), front)


def ridges_at(case: Case, wavelength: float, X: float, number: int, grids: Sequence[xr.Dataset]) -> Mark:
    """The longitudinal waves at X, which are transverse ones where the front runs along their ridges."""
    ratio = Extrapolated(*(float(np.interp(X, grid["X"], grid["along"][number])) for grid in grids))
    return _mark("longitudinal", case, wavelength, X, ratio, fronts.front(grids[1]))


def shaped_marks(p: Plan, results: Sequence[xr.Dataset]) -> Iterator[Mark]:
    """The impacts of Fig. 7, from the first results of `shape_tasks`."""
    for (case, wavelengths), *grids in zip(p.shaped.items(), results[::2], results[1::2], strict=True):
        for number, wavelength in enumerate(wavelengths):
            across = last_waves(case, "transverse", wavelength, 2 * number, grids)
            yield across
            yield last_waves(case, "rings", wavelength, 2 * number + 1, grids)
            yield ridges_at(case, wavelength, across.X, 2 * number, grids)


def rolled_marks(p: Plan, results: Sequence[Any]) -> Iterator[Mark]:
    """The rolling contacts of Fig. 7, from the last results of `shape_tasks`."""
    four = zip(*[iter(results)] * 4, strict=True)  # transverse and longitudinal on the coarse, then on the fine grid
    for (M, L, wavelength), (coarse, ridges, fine, fine_ridges) in zip(p.rolling, four, strict=True):
        nabla2 = Parameters.from_moes(M, L).nabla2(wavelength)
        for kind, pair in {"transverse": (coarse[0], fine[0]), "longitudinal": (ridges, fine_ridges)}.items():
            yield Mark(kind, M, L, wavelength, 0.0, Extrapolated(*pair), nabla2, nabla2, nabla2)


def oil_marks(p: Plan, results: Sequence[xr.Dataset]) -> Iterator[Mark]:
    """The dots of Fig. 8, from the results of `oil_tasks`."""
    for (case, oil, wavelengths), *grids in zip(_oiled(p), results[::2], results[1::2], strict=True):
        for number, wavelength in enumerate(wavelengths):
            yield last_waves(case, oil, wavelength, number, grids)


# -- Fig. 7 -----------------------------------------------------------------------------------------------------------

STYLES = {"transverse": ("o", BLUE), "rings": ("D", GREEN), "longitudinal": ("^", ORANGE)}
OIL_STYLES = dict(zip(OILS, (("o", "black"), ("s", BLUE), ("D", GREEN), ("^", ORANGE)), strict=True))
CURVES: Mapping[str, Callable[[ArrayLike], Values]] = {
    "(15), isotropic": amplitude_reduction.ratio_left,
    "line contact": amplitude_reduction.in_line_contact,
    "(15), longitudinal": lambda nabla2: amplitude_reduction.ratio_left(nabla2, inf),
}


def other_waves(results: Sequence[Any], quick: bool) -> Drawn:
    """Fig. 7: A_d/A_i of transverse, longitudinal and ring waviness, in impact (left) and rolling (right)."""
    p = plan(quick)
    impacts = list(shaped_marks(p, results[: 2 * len(p.shaped)]))
    rolled = list(rolled_marks(p, results[2 * len(p.shaped) :]))
    figure, panels = new_figure(1, 2)
    n = np.geomspace(0.3, 30, 200)
    for axes, marks in zip(panels, (impacts, rolled), strict=True):
        draw_curves(axes)
        long = CURVES["(15), longitudinal"](n)
        axes.plot(n, long, color=ORANGE, linewidth=1.0, linestyle=":", label="(15) of $e\\nabla_2$, longitudinal")
        _draw_marks(axes, marks, STYLES)
    panels[0].set(xlabel="local $\\nabla_2$", title="impact")
    panels[1].set(xlabel="$\\nabla_2$", title="rolling")
    panels[0].legend(loc="lower left", frameon=False, fontsize="x-small")
    caption = (
        "Beyond the paper: waves of other shapes, as in Fig. 6.  Impact: cos(2 pi X/Lambda) along Y = 0 is "
        "transverse to the motion of the front, along X = 0 its ridges lie along it (longitudinal; half of what "
        "crest and trough differ by at the same radius, there where the last transverse wave is); cos(2 pi r/Lambda) "
        "makes rings, their crests parallel to the front.  Rolling: transverse once periodic; longitudinal is "
        "steady.  Curves: (15), which is for isotropic and transverse waves alike; with e nabla2 in place of nabla2, "
        f"for longitudinal ones; and that of transverse waves in a line contact.  Grids of {p.grids[0]} and "
        f"{p.grids[1]} nodes a side, rolling {p.rolling_grids[0]} and {p.rolling_grids[1]}; extrapolation and bars as "
        "in Fig. 6."
    )
    tables = [_marks_table("impact", impacts), _marks_table("rolling", rolled), _shapes_table(impacts, rolled)]
    return Drawn(figure, caption, {"impact": _columns(impacts), "rolling": _columns(rolled)}, tables)


def _draw_marks(axes: Axes, marks: Sequence[Mark], styles: Mapping[str, tuple[str, str]]) -> None:
    for kind, (marker, colour) in styles.items():
        own = [mark for mark in marks if mark.kind == kind]
        place, limit = [mark.local for mark in own], [mark.ratio.limit for mark in own]
        bar = [mark.ratio.error for mark in own]
        if own:
            axes.errorbar(place, limit, bar, fmt=marker, color=colour, mfc="none", capsize=2, label=kind)


def _columns(marks: Sequence[Mark]) -> dict[str, Values]:
    names = ("M", "L", "wavelength", "X", "local", "hertz", "everywhere")
    columns = {name: np.array([float(getattr(mark, name)) for mark in marks]) for name in names}
    kinds = list(dict.fromkeys(mark.kind for mark in marks))
    columns[f"kind ({', '.join(kinds)})"] = np.array([float(kinds.index(mark.kind)) for mark in marks])
    return columns | {
        name: np.array([getattr(mark.ratio, name) for mark in marks]) for name in ("coarse", "fine", "limit", "error")
    }


def _marks_table(title: str, marks: Sequence[Mark]) -> Table:
    head = [title, "M", "L", "wavelength", "X", *RATIO_HEAD, "nabla2 local", "with Hertz then", "global"]
    rows = []
    for m in marks:
        case = [m.kind, f"{m.M:g}", f"{m.L:g}", f"{m.wavelength:g}", f"{m.X:.3f}"]
        rows.append([*case, *ratio_cells(m.ratio), *(f"{n:.2f}" for n in (m.local, m.hertz, m.everywhere))])
    return Table(head, rows)


def _shapes_table(impacts: Sequence[Mark], rolled: Sequence[Mark]) -> Table:
    rows = []
    for kind in STYLES:
        own = [mark for mark in impacts if mark.kind == kind]
        rows.append([f"impact, {kind}, local nabla2", *_about(own, [mark.local for mark in own])])
        rows.append([f"impact, {kind}, with the Hertz contact then", *_about(own, [mark.hertz for mark in own])])
        rolling = [mark for mark in rolled if mark.kind == kind]
        if rolling:
            rows.append([f"rolling, {kind}", *_about(rolling, [mark.local for mark in rolling])])
    return Table(["A_d/A_i less the curve: mean, root mean square", *CURVES], rows)


def _about(marks: Sequence[Mark], nabla2: Sequence[float]) -> list[str]:
    found = [scatter([mark.ratio.limit for mark in marks], curve(nabla2)) for curve in CURVES.values()]
    return [f"{s.mean:+.3f}, {s.rms:.3f}" for s in found]


# -- Fig. 8 -----------------------------------------------------------------------------------------------------------


def other_oils(results: Sequence[xr.Dataset], quick: bool) -> Drawn:
    """Fig. 8: A_d/A_i of isotropic waviness in impacts with other oils; right: against that with the usual oil."""
    p = plan(quick)
    marks = list(oil_marks(p, results))
    figure, (left, right) = new_figure(1, 2)
    draw_curves(left)
    _draw_marks(left, marks, OIL_STYLES)
    left.set_xlabel("local $\\nabla_2$; isoviscous: $\\Lambda$ over the local trapped film")
    left.legend(loc="lower left", frameon=False, fontsize="x-small")
    pairs = list(_moved(marks))
    for oil, (marker, colour) in OIL_STYLES.items():
        own = [(usual.ratio.limit, mark.ratio.limit) for usual, mark in pairs if mark.kind == oil]
        if own:
            right.plot(*zip(*own, strict=True), marker, color=colour, label=oil)
    right.plot([0, 1], [0, 1], color=GREY, linewidth=0.8)
    right.set(xlim=(0, 1), ylim=(0, 1), xlabel=f"$A_d/A_i$, {USUAL}", ylabel="$A_d/A_i$, same $M, L, \\Lambda$")
    right.legend(loc="upper left", frameon=False, fontsize="x-small")
    caption = (
        "Beyond the paper: other lubricants in the impacts of Fig. 6, isotropic waviness at the same M, L and "
        "wavelength; right: A_d/A_i against that of Roelands' law with Dowson and Higginson's density.  An "
        "isoviscous oil has L = 0 and no nabla2; as nabla2 is the wavelength over sqrt(L/M), the film at which a "
        "rigid ball stops, the place of sqrt(L/M) is taken by the film that elasticity alone traps, 0.3135 "
        f"sqrt(lambda_bar).  Curve (15) is not meant for it.  Grids of {p.grids[0]} and {p.grids[1]} nodes a side; "
        "extrapolation and bars as in Fig. 6."
    )
    return Drawn(figure, caption, {"oils": _columns(marks)}, [_marks_table("oil", marks), _moved_table(pairs)])


def _moved(marks: Sequence[Mark]) -> Iterator[tuple[Mark, Mark]]:
    """The usual oil's mark and another's, at the same M, L and wavelength."""
    for usual in (mark for mark in marks if mark.kind == USUAL):
        for mark in marks:
            if mark.kind != USUAL and mark[1:4] == usual[1:4]:
                yield usual, mark


def _moved_table(pairs: Sequence[tuple[Mark, Mark]]) -> Table:
    head = ["moved by", "M", "L", "wavelength", f"A_d/A_i, {USUAL}", "by this oil", "difference"]
    rows = []
    for usual, mark in pairs:
        case = [f"{value:g}" for value in (mark.M, mark.L, mark.wavelength)]
        values = usual.ratio.limit, mark.ratio.limit
        rows.append([mark.kind, *case, *(f"{v:.3f}" for v in values), f"{values[1] - values[0]:+.3f}"])
    return Table(head, rows)
