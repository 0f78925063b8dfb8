"""The numbers of the figures' runs, coarse (`QUICK`) or at full resolution (`FULL`)."""

from collections.abc import Mapping
from dataclasses import dataclass

Moes = tuple[float, float]  # M, L
Wavelengths = tuple[float, ...]  # in units a* (impact) or a (rolling)
Grids = tuple[int, int]  # nodes per side, coarse and fine

LOADS = (200, 500, 1000, 2000, 5000, 10000)  # M of Figs. 1, 2 and 4
SHOWN_LOAD = 1000  # M of Fig. 3, and of the run by the 2-D method
L = 10.0  # of Figs. 1 to 4

SHOWN_LINE = 150  # M of Figs. 3 and 5 for cylinders
LINE_L = 10.0  # of Figs. 1 to 4 for cylinders


@dataclass(frozen=True)
class LinePlan:
    """The runs of the figures for cylinders.

    loads: M of Figs. 1, 2, 4 and 7.  impact_grids: nodes of the impacts, of more cells above M = `line_runs.HIGH`.
    rolling_grids: nodes of the rolling contacts.  waves: wavelengths (b*) for each M, L of Figs. 5 and 6.
    wave_places, law_places: places of the front (b*) with whose parameters the contacts of Figs. 6 and 7 roll.
    """

    loads: tuple[int, ...]
    impact_grids: Grids
    rolling_grids: Grids
    waves: Mapping[Moes, Wavelengths]
    wave_places: tuple[float, ...] = (0.5, 0.6, 0.7, 0.8, 0.9)
    law_places: tuple[float, ...] = (0.5, 0.6, 0.7, 0.8, 0.85, 0.9)


@dataclass(frozen=True)
class Plan:
    """The runs of all figures.

    Smooth impacts, Figs. 1 to 4: the nodes and expected seconds of a radial run, and those of the 2-D run with its
    half width (a*).

    Isotropic waviness, Figs. 5 and 6.  impacts, rolling: wavelengths for each M, L.  twins: M, L, wavelength and X of
    each `rolling_twin`, where X is the place of a wave.  marched: M, L, wavelength and nodes of a rolling contact that
    is computed by time steps too.  shown: M, L of Fig. 5 and of the checks.

    Other waves and oils, Figs. 7 and 8.  shaped, oils: wavelengths for each M, L of the impacts of Fig. 7 and of
    Fig. 8.  soft: those for each M with the isoviscous oil, L = 0.  straight: M, L and wavelength of the rolling
    contacts.

    Contacts on layers of oil, Fig. 9.  starved: M and L by "impact" and "rolling".

    lines: those of cylinders.
    """

    resolution: str
    radial_nodes: int
    radial_seconds: float
    plane_nodes: int
    plane_half_width: float
    plane_seconds: float
    impacts: Mapping[Moes, Wavelengths]
    impact_grids: Grids
    rolling: Mapping[Moes, Wavelengths]
    rolling_grids: Grids
    twins: tuple[tuple[float, float, float, float], ...]
    twin_grids: Grids
    marched: tuple[float, float, float, int]
    shaped: Mapping[Moes, Wavelengths]
    oils: Mapping[Moes, Wavelengths]
    soft: Mapping[float, Wavelengths]
    beyond_grids: Grids
    straight: tuple[tuple[float, float, float], ...]
    straight_grids: Grids
    starved: Mapping[str, tuple[Moes, ...]]
    starved_grids: Grids
    starved_seconds: float
    lines: LinePlan
    shown: Moes = (1000, 10)


QUICK = Plan(
    resolution="quick: coarse grids",
    radial_nodes=301,
    radial_seconds=4.0,
    plane_nodes=129,
    plane_half_width=1.5,
    plane_seconds=20.0,
    impacts={(200, 10): (0.25, 0.4), (1000, 10): (0.25, 0.4, 0.6), (1000, 5): (0.25, 0.5)},
    impact_grids=(97, 193),
    rolling={(200, 10): (0.5, 1.0), (1000, 10): (0.5,)},
    rolling_grids=(129, 257),
    twins=((1000, 10, 0.4, 0.73), (1000, 10, 0.6, 0.5)),
    twin_grids=(129, 257),
    marched=(1000, 10, 0.5, 129),
    shaped={(1000, 10): (0.25, 0.4)},
    oils={(1000, 5): (0.4,)},
    soft={200: (0.2,)},
    beyond_grids=(97, 193),
    straight=((200, 10, 1.0), (1000, 10, 1.0)),
    straight_grids=(65, 129),
    starved={"impact": ((200, 10), (1000, 10)), "rolling": ((50, 10), (200, 10))},
    starved_grids=(65, 129),
    starved_seconds=20.0,
    lines=LinePlan((20, 60, 150), (257, 513), (257, 513), {(150, 10): (0.2, 0.4)}),
)
FULL = Plan(
    resolution="full resolution",
    radial_nodes=801,
    radial_seconds=20.0,
    plane_nodes=385,
    plane_half_width=2.0,
    plane_seconds=150.0,
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
    impact_grids=(257, 513),
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
    shaped={(200, 10): (0.3, 0.5), (1000, 10): (0.25, 0.4), (1000, 5): (0.25, 0.5)},
    oils={(500, 10): (0.3, 0.5), (1000, 5): (0.25, 0.5)},
    soft={100: (0.15, 0.3), 500: (0.15, 0.3)},
    beyond_grids=(193, 385),
    straight=((200, 10, 0.5), (200, 10, 1.0), (1000, 10, 0.5), (1000, 10, 1.0)),
    straight_grids=(257, 513),
    starved={
        "impact": ((100, 10), (200, 5), (200, 10), (200, 20), (1000, 10), (2000, 10)),
        "rolling": ((50, 10), (200, 5), (200, 10), (200, 20)),
    },
    starved_grids=(129, 257),
    starved_seconds=60.0,
    lines=LinePlan(
        (20, 60, 150, 400),
        (513, 1025),
        (513, 1025),
        {(60, 10): (0.2, 0.4), (150, 10): (0.1, 0.2, 0.4)},
    ),
)
