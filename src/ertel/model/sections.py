"""The sections solver, time, output and motion of a case.  All defaults of ertel are here."""

from collections.abc import Mapping
from dataclasses import dataclass
from math import ceil
from typing import Annotated, Literal, NamedTuple

from ertel.model.conditions import Kind
from ertel.physics import hertz
from ertel.physics.motion import Signal
from ertel.physics.units import DURATION, FINITE, NOT_NEGATIVE, SHARE, Amount, Bounds

Method = Literal["2d", "radial", "steady", "transient"]
Stop = Literal["max-approach", "rebound"]
STOPS: tuple[Stop, ...] = ("max-approach", "rebound")
METHODS: Mapping[Kind, tuple[Method, ...]] = {"impact": ("2d", "radial"), "rolling": ("steady", "transient")}
ROLLING_UNTIL = 6.0  # t0: the surfaces roll through a domain of the default length
CENTRED_HALF_WIDTH = 4.5  # half width of a grid for reversing flow


@dataclass(frozen=True)
class Solver:
    """Grid and tolerance; all lengths in units a (impact: a*).

    nodes: nodes per side (2^k c + 1) or along the radius (radial: 0 to half_width).  half_width: from the middle of the
    grid to its edge along x; the default of an impact widens below M = 100, see `half_width_at`.  half_width_y: the
    same along y, where the spacing is the same; None: half_width.  inlet: distance from the contact's centre to the
    upstream edge; None: half_width (centred grid).  For an ellipse the defaults follow its size, see `extents`.
    fold: compute on a half or a quarter of the plane if the case is symmetric.
    tolerance: tolerance of the discrete equations.  In a time step it is a film thickness in units of the expected film
    thickness (`Case.film_scale`), and 20 time.tolerance at most.  What a step leaves over, the next step makes good, so
    it does not add up.  For a steady contact it is the residual of Reynolds' equation; 0.03 takes less than
    half the work and leaves at most about a tenth of the grid's own error in H_c and H_min, enough for a sweep.
    """

    method: Method = "2d"
    nodes: Annotated[int, Bounds(gt=0, le=4097, whole=True)] = 257
    half_width: Annotated[float, Bounds(gt=0, le=1000)] = 2.0
    inlet: Annotated[float | None, Bounds(gt=0)] = None
    tolerance: Annotated[float, SHARE] = 1e-3
    fold: bool = True
    half_width_y: Annotated[float | None, Bounds(gt=0, le=1000)] = None


SOLVERS: Mapping[Method, Solver] = {  # the defaults
    "2d": Solver(),
    "radial": Solver("radial", half_width=4.0),  # graded: the outer half costs few nodes
    "steady": Solver("steady", half_width=3.0, inlet=4.5, tolerance=1e-8),
    "transient": Solver("transient", half_width=3.0, inlet=4.5),
}


WIDE_BELOW, WIDEST = 100.0, 4.0  # M below which the default domain of an impact widens, and its largest factor


def half_width_at(half_width: float, M: float) -> float:
    """The default half width of an impact: wide for a low load, where the oil far away carries much of it.

    That share goes as lambda_bar/half_width^2, and lambda_bar as M^(-4/3).  Up to the widest, Delta and the load are
    within 0.2 % of a far wider domain.
    """
    factor: float = min(max(1.0, (WIDE_BELOW / M) ** (2 / 3)), WIDEST)
    return ceil(4 * half_width * factor - 1e-6) / 4  # M = 100 itself, free of round-off


@dataclass(frozen=True)
class Time:
    """Start, end and steps of a run in time; amounts are in t0 or quantities.

    start_approach: Delta of an impact at T = 0, in units delta*; negative: surfaces separated.  until: an event of an
    impact, or a time.  tolerance: allowed local error of a step: of Delta, of dDelta/dT, and of the film relative to
    itself.  The error of a run falls with its power 2/3; the default gives about 0.1 % in H_c.  step: a fixed step,
    without error control; it is shortened only to end on the points of a signal and at the end.
    """

    start_approach: Annotated[float | None, Bounds(ge=-1000, lt=0)] = None
    until: Annotated[Stop | Amount | None, DURATION] = None
    tolerance: Annotated[float, SHARE] = 5e-5
    step: Annotated[Amount | None, DURATION] = None


START_APPROACH = -1.0
ENDS: Mapping[Kind, Stop | float] = {"impact": "max-approach", "rolling": ROLLING_UNTIL}


@dataclass(frozen=True)
class Output:
    """Film and pressure maps are kept every `interval`, at maximum approach and at the end."""

    interval: Annotated[Amount, DURATION] = 0.1


@dataclass(frozen=True)
class Drive:
    """Load and entrainment as functions of time: the section [motion].  None: the default of an impact or of rolling.

    load: w(T) in F* or in the static load.  entrainment: U(T) in a/t0 or u_m.  slide_to_roll, inertia: only for a
    dimensionless case.
    """

    load: Signal | None = None
    entrainment: Signal | None = None
    slide_to_roll: Annotated[float | None, FINITE] = None
    inertia: Annotated[float | None, NOT_NEGATIVE] = None


class Schedule(NamedTuple):
    """`Time` and `Output` in units t0."""

    start_approach: float
    until: Stop | float
    tolerance: float
    step: float | None
    interval: float

    @property
    def duration(self) -> float:
        """T at the end of the run; of an event about, as if the impact were dry."""
        match self.until:
            case "max-approach":
                return hertz.HALF_CONTACT_TIME - self.start_approach
            case "rebound":
                return hertz.CONTACT_TIME - 2 * self.start_approach
            case until:
                return until
