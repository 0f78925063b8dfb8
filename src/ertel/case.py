"""A case: what is solved.  Plain frozen records, dimensionless; `scales` turns results back into SI.

All defaults of ertel live here.
"""

from dataclasses import dataclass, field, replace
from typing import Literal

from ertel.lubricant import Lubricant
from ertel.scales import Parameters, Scales

Method = Literal["2d", "radial"]
Stop = Literal["max-approach", "rebound"]


@dataclass(frozen=True)
class Solver:
    """Grid and tolerance.

    nodes: nodes per side (2d: 2^k c + 1, half_width to both sides of the centre) or along the radius (radial: 0 to
    half_width).  half_width: in units a*.  tolerance: of the discrete equations at each step, as a film thickness in
    units of the trapped film sqrt(L/M).
    """

    method: Method = "2d"
    nodes: int = 257
    half_width: float = 2.0
    tolerance: float = 1e-3


@dataclass(frozen=True)
class Time:
    """Time in units t0.

    start_approach: Delta at T = 0, negative = apart, in units delta*.  until: an event, or a time in t0.
    tolerance: local error allowed a step, relative (the default leaves about 0.1 % in H_c).
    step: a fixed step instead, without error control.
    """

    start_approach: float = -1.0
    until: Stop | float = "max-approach"
    tolerance: float = 5e-5
    step: float | None = None


@dataclass(frozen=True)
class Output:
    """Film and pressure maps are kept every `interval` (in t0), at maximum approach and at the end."""

    interval: float = 0.1


@dataclass(frozen=True)
class Case:
    """One impact, ready to be simulated.

    scales is None for a dimensionless case.  source is the validated input as plain data (for provenance).
    """

    parameters: Parameters
    lubricant: Lubricant
    solver: Solver = Solver()
    time: Time = Time()
    output: Output = Output()
    scales: Scales | None = None
    kind: Literal["impact"] = "impact"
    name: str = ""
    source: dict[str, object] = field(default_factory=dict, compare=False)

    def on_half_grid(self) -> "Case":
        """The same case with twice the spacing: for the discretisation error estimate."""
        return replace(self, solver=replace(self.solver, nodes=(self.solver.nodes - 1) // 2 + 1))
