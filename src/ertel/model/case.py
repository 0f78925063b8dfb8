"""A case: what is solved.  Plain frozen records, dimensionless; `scales` turns results back into SI.

All defaults of ertel live here.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Literal

from ertel.physics import film_formulas
from ertel.physics.lubricant import Lubricant
from ertel.physics.motion import FREE_BALL, Motion
from ertel.physics.scales import Parameters, Scales
from ertel.physics.surfaces import Feature

Kind = Literal["impact", "rolling"]
Method = Literal["2d", "radial", "steady", "transient"]
Stop = Literal["max-approach", "rebound"]

METHODS: Mapping[Kind, tuple[Method, ...]] = {"impact": ("2d", "radial"), "rolling": ("steady", "transient")}


@dataclass(frozen=True)
class Solver:
    """Grid and tolerance; all lengths in units a (impact: a*).

    nodes: nodes per side (2^k c + 1) or along the radius (radial: 0 to half_width).  half_width: from the middle of the
    grid to its edge.  inlet: from the contact's centre to the edge upstream, None: half_width, so a centred grid.
    fold: where a case is symmetric compute on a half or a quarter of the plane.
    tolerance: of the discrete equations.  In a time step as a film thickness, in units of the film that is expected
    (`Case.film_scale`); steady, as the residual of Reynolds' equation itself (0.1 takes less than half the work, and
    leaves about a tenth of the grid's own error in H_c and H_min or less: enough for a sweep).
    """

    method: Method = "2d"
    nodes: int = 257
    half_width: float = 2.0
    inlet: float | None = None
    tolerance: float = 1e-3
    fold: bool = True


SOLVERS: Mapping[Method, Solver] = {  # the defaults
    "2d": Solver(),
    "radial": Solver("radial"),
    "steady": Solver("steady", half_width=3.0, inlet=4.5, tolerance=1e-8),
    "transient": Solver("transient", half_width=3.0, inlet=4.5),
}


@dataclass(frozen=True)
class Time:
    """Time in units t0.

    start_approach: of an impact, Delta at T = 0, negative = apart, in units delta*.  until: an event (of an impact), or
    a time in t0.  tolerance: local error allowed a step, relative (the default leaves about 0.1 % in H_c).
    step: a fixed step instead, without error control.
    """

    start_approach: float = -1.0
    until: Stop | float = "max-approach"
    tolerance: float = 5e-5
    step: float | None = None


ROLLING_UNTIL = 6.0  # t0, the default: the surfaces roll through a domain of the default length


@dataclass(frozen=True)
class Output:
    """Film and pressure maps are kept every `interval` (in t0), at maximum approach and at the end."""

    interval: float = 0.1


@dataclass(frozen=True)
class Case:
    """One contact, ready to be simulated.

    scales is None for a dimensionless case.  source is the validated input as plain data (for provenance).
    """

    parameters: Parameters
    lubricant: Lubricant
    solver: Solver = Solver()
    time: Time = Time()
    output: Output = Output()
    scales: Scales | None = None
    kind: Kind = "impact"
    motion: Motion = FREE_BALL
    roughness: tuple[Feature, ...] = ()
    name: str = ""
    source: dict[str, object] = field(default_factory=dict, compare=False)

    @property
    def film_scale(self) -> float:
        """The film to be expected, in a^2/R: that which the impact traps, or that of a rolling contact's formula."""
        p = self.parameters
        return p.trapped_film if self.kind == "impact" else film_formulas.nijenbanning_venner_moes(p.M, p.L)

    def on_half_grid(self) -> "Case":
        """The same case with twice the spacing: for the discretisation error estimate."""
        return replace(self, solver=replace(self.solver, nodes=(self.solver.nodes - 1) // 2 + 1))
