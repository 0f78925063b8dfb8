"""The methods: one record each.  Everybody who must know what a method is like reads it here.

Rules read what it supports; defaults, new cases, the form in the browser and the outlook read the rest.  The class that
carries a method out is in `ertel.solvers.SOLVERS`, under the same name.  A new method is one record here, one class
there, and a class in `spaces` if its nodes lie neither on a plane nor along a radius.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from math import ceil
from typing import Any, NamedTuple

from ertel.case.conditions import Kind
from ertel.case.sections import Solver, Stop
from ertel.case.spaces import AlongTheRadius, AlongX, OnThePlane
from ertel.physics.geometry import Geometry


class Supports(NamedTuple):
    """The abilities of a method beyond a smooth and circular contact with a Newtonian oil and a uniform layer.

    motion: a load and an entrainment.  thinning: an oil that thins under shear.  track: a layer that varies across the
    track.  touch: asperities that touch.  thermal: the section [thermal].
    """

    ellipse: bool = True
    motion: bool = True
    thinning: bool = True
    track: bool = True
    roughness: bool = True
    touch: bool = True
    thermal: bool = False


ALL_BUT_HEAT = Supports()


class Cost(NamedTuple):
    """The memory and time of a run, roughly; measured, see `benchmarks`.

    arrays: number of arrays of all nodes in memory.  step: seconds of a time step, and for each node that is kept.
    film: seconds of a steady film, with the coarser grids, for each node that is kept.  is_dense: whether the arrays
    are matrices of nodes by nodes.
    """

    arrays: int
    step: tuple[float, float] = (0.0, 0.0)
    film: float = 0.0
    is_dense: bool = False


class Widening(NamedTuple):
    """The default domain is wider by (below/M)^exponent where M is below that value, and by the widest at most.

    lambda_bar goes as M^(-4/3), and the load that the oil far away carries as lambda_bar/half_width^2 in an impact, as
    lambda_bar/half_width in rolling.  Up to the widest, Delta and the load of an impact are within 0.2 % of a far wider
    domain, and the oil outside a rolling contact carries 23 % of the load at most.
    """

    below: float
    exponent: float
    widest: float

    def of(self, half_width: float, M: float) -> float:
        """The default half width: wide for a low load, where the oil far away carries much of it."""
        factor: float = min(max(1.0, (self.below / M) ** self.exponent), self.widest)
        return ceil(4 * half_width * factor - 1e-6) / 4  # M = 100 itself, free of round-off


@dataclass(frozen=True)
class Method:
    """A method of computing a contact.

    Parameters
    ----------
    name : str
        The value of solver.method.
    kind : str
        The kind of contact that it computes; the first method of a kind is its default.
    title : str
        What it is called in the app.
    space : AlongX
        Where its nodes lie.
    defaults : Solver
        The default of the section [solver], for a circular contact with M above `widening.below`.
    widening : Widening
        By how much the default domain is wider at a low load.
    cost : Cost
        What it takes.
    new_nodes : int
        The nodes of a new case, which answers within a minute.
    end : Stop or float, optional
        The default end of a run (t0); None for a steady contact, which has no time.
    supports : Supports
        What it can compute.
    on_a_line : Method, optional
        The same for line contacts, as far as it differs; None if it has no such form.
    """

    name: str
    kind: Kind
    title: str
    space: AlongX
    defaults: Solver
    widening: Widening
    cost: Cost
    new_nodes: int
    end: Stop | float | None = None
    supports: Supports = ALL_BUT_HEAT
    on_a_line: "Method | None" = None

    def of(self, geometry: Geometry) -> "Method":
        """The record for a geometry: for a line contact it has one axis."""
        return self.on_a_line if geometry.is_line and self.on_a_line else self

    @property
    def is_steady(self) -> bool:
        """Whether nothing changes in time."""
        return self.end is None

    @property
    def axes(self) -> tuple[str, ...]:
        """The axes of its maps, in order."""
        return self.space.axes

    @property
    def in_words(self) -> str:
        """The method as it is shown: its name; that of a line contact, where "2d" is the name of one row, in words."""
        return f"line contact, {self.title}" if self.axes == ("X",) else self.name


METHODS: dict[str, Method] = {}


def with_a_line(method: Method, widening: Widening, cost: Cost, **other: Any) -> Method:
    """The method with its form for line contacts: one row of nodes, which is solved directly."""
    defaults = replace(method.defaults, nodes=LINE_NODES, half_width=3.0)
    supports = method.supports._replace(track=False)
    changed = {"space": AlongX(), "defaults": defaults, "supports": supports, "new_nodes": LINE_NODES, **other}
    return replace(method, on_a_line=replace(method, widening=widening, cost=cost, **changed))


def register(method: Method) -> Method:
    """Add a method.  Raises ValueError where another one has its name."""
    if METHODS.setdefault(method.name, method) is not method:
        raise ValueError(f'name = "{method.name}": another method has it; choose another')
    return method


def of_kind(kind: Kind, suits: Callable[[Method], bool] = lambda method: True) -> list[Method]:
    """The methods of a kind of contact that suit; the default one comes first."""
    return [method for method in METHODS.values() if method.kind == kind and suits(method)]


def as_written(methods: list[Method]) -> str:
    """Some methods as they are written in a case: solver.method = "2d" or "radial"."""
    names = " or ".join(f'"{method.name}"' for method in methods)
    return f"solver.method = {names}"


# Arrays: the peak of the process on 129 to 1025 nodes a side, within 15 % from 257 on.  The compiled program of an
# impact alone needs 87 arrays of the nodes that are computed (22 of the plane, when a quarter of it is computed), that
# of steady rolling 115 (57 of the plane); a run of rolling contains the steady film: `benchmarks/scaling.py`.
STEP = (2e-3, 1e-6)
FILM = 1.3e-5
AT_IMPACT, IN_ROLLING = Widening(100.0, 2 / 3, 4.0), Widening(5.0, 4 / 3, 200.0)
# the oil outside a line contact carries as lambda_bar/half_width^3 in an impact, as lambda_bar/half_width^2 in rolling
LINE_IMPACT, LINE_ROLLING = Widening(10.0, 2 / 3, 4.0), Widening(5.0, 1.0, 50.0)
LINE_NODES = 513
ROW = Cost(12, (4e-3, 1e-7), 2e-6, is_dense=True)  # its matrix is factorised in every Newton iteration
ROLLING_UNTIL = 6.0  # t0: the surfaces roll through a domain of the default length for M >= 5

IN_2D = Method(
    "2d", "impact", "plane: minutes", OnThePlane(), Solver(), AT_IMPACT, Cost(150, STEP), 129, "max-approach"
)
register(with_a_line(IN_2D, LINE_IMPACT, ROW, title="in time"))
register(
    Method(
        "radial",
        "impact",
        "radial: seconds",
        AlongTheRadius(),
        Solver("radial", half_width=4.0),  # graded: the outer half costs few nodes
        AT_IMPACT,
        Cost(80, (2e-3, 1.7e-7), is_dense=True),
        401,
        "max-approach",
        Supports(ellipse=False, motion=False, thinning=False, track=False, roughness=False, touch=False),
    )
)
STEADY = Method(
    "steady",
    "rolling",
    "steady",
    OnThePlane(),
    Solver("steady", half_width=3.0, inlet=4.5, tolerance=1e-8),
    IN_ROLLING,
    Cost(210, film=FILM),
    257,
    supports=Supports(thermal=True),
)
TRANSIENT = Method(
    "transient",
    "rolling",
    "in time",
    OnThePlane(),
    Solver("transient", half_width=3.0, inlet=4.5),
    IN_ROLLING,
    Cost(210, STEP, FILM),
    129,
    ROLLING_UNTIL,
)
register(with_a_line(STEADY, LINE_ROLLING, ROW))
register(with_a_line(TRANSIENT, LINE_ROLLING, ROW))
NEW: Mapping[Kind, Method] = {"impact": METHODS["radial"], "rolling": METHODS["steady"]}  # with which a new case begins
