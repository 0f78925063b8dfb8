"""What is run for the figures, coarse (`QUICK`) or at full resolution (`FULL`), and what is drawn of it.

This module imports no matplotlib: every process that computes runs imports it.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Literal

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from pandas import DataFrame

LOADS = (200, 500, 1000, 2000, 5000, 10000)  # M of Figs. 1, 2 and 4
L = 10.0  # of Figs. 1 to 4
SHOWN_LOAD = 1000  # M of Fig. 3, and of the run by the 2-D method

Definition = Literal["film", "slope", "half-hertz"]  # of the front, see ertel.fronts.front
FRONTS: Mapping[Definition, str] = {
    "film": "minimum film",
    "slope": "steepest pressure",
    "half-hertz": "half the Hertz pressure",
}
FORMED = 0.4  # a*: at smaller radii there is a bell of pressure and no front yet

Moes = tuple[float, float]  # M, L
Wavelengths = tuple[float, ...]  # in units a* (impact) or a (rolling)


@dataclass(frozen=True)
class SmoothPlan:
    """Smooth impacts: nodes and expected seconds by the radial and by the 2-D method, half width (a*) of the latter."""

    radial_nodes: int
    radial_seconds: float
    plane_nodes: int
    plane_half_width: float
    plane_seconds: float


@dataclass(frozen=True)
class WavesPlan:
    """Isotropic waviness, Figs. 5 and 6.

    impacts, rolling: wavelengths for each M, L.  grids, rolling_grids, twin_grids: nodes per side, coarse and fine, of
    the impacts, of rolling and of the twins.  twins: M, L, wavelength and X of each `rolling_twin`, where X is the
    place of a wave.  marched: M, L, wavelength and nodes of a rolling contact that is computed by time steps too.
    shown: M, L of Fig. 5 and of the checks.
    """

    impacts: Mapping[Moes, Wavelengths]
    grids: tuple[int, int]
    rolling: Mapping[Moes, Wavelengths]
    rolling_grids: tuple[int, int]
    twins: tuple[tuple[float, float, float, float], ...]
    twin_grids: tuple[int, int]
    marched: tuple[float, float, float, int]
    shown: Moes = (1000, 10)


@dataclass(frozen=True)
class BeyondPlan:
    """Other waves and other lubricants, Figs. 7 and 8.

    shaped, oils: wavelengths for each M, L of the impacts of Fig. 7 and of Fig. 8.  soft: wavelengths for each M of
    the impacts with the isoviscous oil, L = 0.  rolling: M, L, wavelength.  Grids: nodes per side, coarse and fine.
    """

    shaped: Mapping[Moes, Wavelengths]
    oils: Mapping[Moes, Wavelengths]
    soft: Mapping[float, Wavelengths]
    grids: tuple[int, int]
    rolling: tuple[tuple[float, float, float], ...]
    rolling_grids: tuple[int, int]


@dataclass(frozen=True)
class StarvedPlan:
    """Contacts on layers of oil, Fig. 9: M and L by "impact" and "rolling"; nodes of both grids, expected seconds."""

    contacts: Mapping[str, tuple[Moes, ...]]
    grids: tuple[int, int]
    seconds: float


@dataclass(frozen=True)
class Plan:
    """The runs of all figures."""

    resolution: str
    smooth: SmoothPlan
    waves: WavesPlan
    beyond: BeyondPlan
    starved: StarvedPlan


QUICK = Plan(
    "quick: coarse grids",
    SmoothPlan(radial_nodes=301, radial_seconds=4.0, plane_nodes=129, plane_half_width=1.5, plane_seconds=20.0),
    WavesPlan(
        impacts={(200, 10): (0.25, 0.4), (1000, 10): (0.25, 0.4, 0.6), (1000, 5): (0.25, 0.5)},
        grids=(97, 193),
        rolling={(200, 10): (0.5, 1.0), (1000, 10): (0.5,)},
        rolling_grids=(129, 257),
        twins=((1000, 10, 0.4, 0.73), (1000, 10, 0.6, 0.5)),
        twin_grids=(129, 257),
        marched=(1000, 10, 0.5, 129),
    ),
    BeyondPlan(
        shaped={(1000, 10): (0.25, 0.4)},
        oils={(1000, 5): (0.4,)},
        soft={200: (0.2,)},
        grids=(97, 193),
        rolling=((200, 10, 1.0), (1000, 10, 1.0)),
        rolling_grids=(65, 129),
    ),
    StarvedPlan(
        contacts={"impact": ((200, 10), (1000, 10)), "rolling": ((50, 10), (200, 10))},
        grids=(65, 129),
        seconds=20.0,
    ),
)
FULL = Plan(
    "full resolution",
    SmoothPlan(radial_nodes=801, radial_seconds=20.0, plane_nodes=385, plane_half_width=2.0, plane_seconds=150.0),
    WavesPlan(
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
        rolling={
            (100, 10): (0.4, 0.8),
            (100, 20): (0.25,),
            (200, 10): (0.25, 0.5, 0.75, 1.0),
            (500, 10): (0.3, 0.6),
            (1000, 5): (0.5,),
            (1000, 10): (0.3, 0.5, 0.75, 1.0),
            (1000, 20): (0.4,),
            (2000, 10): (0.25, 0.5),
        },
        rolling_grids=(513, 1025),
        twins=(
            (100, 10, 0.4, 0.5),
            (200, 10, 0.4, 0.6),
            (500, 10, 0.3, 0.66),
            (500, 10, 0.5, 0.4),
            (500, 10, 0.5, 0.66),
            (1000, 5, 0.5, 0.67),
            (1000, 10, 0.25, 0.83),
            (1000, 10, 0.4, 0.53),
            (1000, 10, 0.4, 0.73),
            (1000, 10, 0.6, 0.5),
            (1000, 20, 0.5, 0.7),
            (2000, 10, 0.4, 0.7),
            (2000, 10, 0.5, 0.67),
        ),
        twin_grids=(257, 513),
        marched=(1000, 10, 0.5, 257),
    ),
    BeyondPlan(
        shaped={(200, 10): (0.3, 0.5), (1000, 10): (0.25, 0.4), (1000, 5): (0.25, 0.5)},
        oils={(500, 10): (0.3, 0.5), (1000, 5): (0.25, 0.5)},
        soft={100: (0.15, 0.3), 500: (0.15, 0.3)},
        grids=(193, 385),
        rolling=((200, 10, 0.5), (200, 10, 1.0), (1000, 10, 0.5), (1000, 10, 1.0)),
        rolling_grids=(257, 513),
    ),
    StarvedPlan(
        contacts={
            "impact": ((100, 10), (200, 5), (200, 10), (200, 20), (1000, 10), (2000, 10)),
            "rolling": ((50, 10), (200, 5), (200, 10), (200, 20)),
        },
        grids=(129, 257),
        seconds=60.0,
    ),
)


def impact_seconds(impacts: int, nodes: int) -> float:
    """Expected duration of impacts in lockstep: the start, and 18 s for each on 513 nodes (measured, one core)."""
    return 5.0 + impacts * 18.0 * (nodes / 513) ** 2


def rolling_seconds(waves: int, nodes: int) -> float:
    """Expected duration of a rolling contact and its response to some waves (measured on 513 nodes, one core)."""
    return 5.0 + (4.0 + 3.0 * waves) * (nodes / 513) ** 2


def marching_seconds(nodes: int) -> float:
    """Expected duration of a rolling contact in time: 190 s on 513 nodes, 1/8 of it on half as many (one core)."""
    return 5.0 + 190.0 * (nodes / 513) ** 3


# -- what is drawn -----------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Drawn:
    """A figure with what belongs to it.

    data: the numbers behind the figure, written as CSV; file name without its beginning and end -> table.  tables:
    numbers to read on the page; heading -> table, whose cells are texts.
    """

    figure: "Figure"
    caption: str
    data: Mapping[str, "DataFrame"] = field(default_factory=dict)
    tables: Mapping[str, "DataFrame"] = field(default_factory=dict)


def new_figure(rows: int, columns: int) -> tuple["Figure", list["Axes"]]:
    """A figure with panels, row by row."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(max(4.8 * columns, 7.0), 3.8 * rows), layout="constrained")
    return figure, list(figure.subplots(rows, columns, squeeze=False).ravel())
