"""What is said and shown of an impact, and what of a rolling contact: the one place where the two are told apart.

`KINDS[case.kind]`, or the attribute or key "kind" of a Dataset or a summary, gives the record that knows.  Whether a
run is steady or in time is told by what it holds, see `is_steady`.  This module imports neither JAX nor xarray.
"""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

from ertel.case.status import Status
from ertel.physics import hertz
from ertel.physics.scales import Parameters, Scales
from ertel.results.variables import FILMS, FRICTION, MEASURED

if TYPE_CHECKING:  # these bring JAX or xarray with them
    import xarray as xr

    from ertel.case.sections import Solver

Outcome = Mapping[str, Any]  # of a run, as `results.summary` and `summary.json` have it
Errors = Mapping[str, tuple[float, float]]  # estimated error and extrapolated value, by name


def is_steady(dataset: "xr.Dataset") -> bool:
    """Whether a Dataset holds a steady contact, on its grids, and not a run in time."""
    return "grid" in dataset.dims


class Condition(NamedTuple):
    """An operating condition of a physical case, for a heading: its symbol, its attribute of the Dataset, its unit."""

    symbol: str
    attribute: str
    unit: str


class Kind(ABC):
    """What is said and shown of a contact of one kind.

    units: its names of the units of `VARIABLES`, where they differ.  conditions: what a heading says of a physical
    case.  names_sliding: whether a heading says the slide-to-roll ratio.
    """

    units: Mapping[str, str] = {}
    conditions: tuple[Condition, ...]
    names_sliding = False

    def unit(self, name: str) -> str:
        """A unit of `VARIABLES` by its name in such a contact."""
        return self.units.get(name, name)

    @abstractmethod
    def domain(self, solver: "Solver") -> str:
        """How far the grid reaches, in words."""

    # -- what is known before a run -----------------------------------------------------------------------------------

    def parameters(self, p: Parameters) -> dict[str, float]:
        """The parameters that only such a contact has."""
        return {}

    @abstractmethod
    def speed(self, scales: Scales) -> dict[str, float]:
        """The speed scale under its name with the unit."""

    def si(self, p: Parameters, scales: Scales) -> dict[str, float]:
        """The quantities in SI that only such a contact has."""
        return {}

    # -- what a summary says ------------------------------------------------------------------------------------------

    @abstractmethod
    def values(self, summary: Outcome) -> dict[str, float]:
        """The measured values; empty where there are none yet."""

    @abstractmethod
    def values_in_si(self, summary: Outcome) -> Mapping[str, float]:
        """The measured values in SI, by their SI names; empty for a dimensionless case."""

    @abstractmethod
    def errors(self, summary: Outcome) -> Errors:
        """The discretisation errors, where they were estimated."""

    @abstractmethod
    def moment(self, summary: Outcome) -> str:
        """When the values hold, or why there are none."""

    def heading(self, summary: Outcome) -> str:
        """When the values hold, above a table that says the time."""
        return self.moment(summary)


def _across(solver: "Solver") -> str:
    """How far the grid reaches across the flow, where that differs."""
    return "" if solver.half_width_y is None else f", {solver.half_width_y:.4g} a across"


class Impact(Kind):
    """The impact of a ball: its scales are those of the dry impact, its values those at maximum approach."""

    conditions = (Condition("$v_0$", "v0_m_per_s", "m/s"), Condition("$p_h^*$", "p_h_Pa", "Pa"))

    def domain(self, solver: "Solver") -> str:
        return f"{solver.nodes} nodes to {solver.half_width:.4g} a*{_across(solver)}"

    def parameters(self, p: Parameters) -> dict[str, float]:
        return {"stokes": p.stokes, "trapped_film": p.trapped_film}

    def speed(self, scales: Scales) -> dict[str, float]:
        return {"v0_m_per_s": scales.speed}

    def si(self, p: Parameters, scales: Scales) -> dict[str, float]:
        film, contact_time = p.trapped_film * scales.film, hertz.CONTACT_TIME * p.ellipse.approach * scales.t0
        least, most = (share * scales.film for share in p.impact_films)
        expected = {"h_c_least_m": least, "h_c_most_m": most}
        return {"contact_time_s": contact_time, "mass_kg": scales.ball_mass, "trapped_film_m": film, **expected}

    def values(self, summary: Outcome) -> dict[str, float]:
        return dict(summary["max_approach"] or {})

    def values_in_si(self, summary: Outcome) -> Mapping[str, float]:
        return summary.get("si", {}).get("max_approach") or {}

    def errors(self, summary: Outcome) -> Errors:
        estimate = summary.get("error_estimate") or {}
        return {"Delta" if key == "Delta_max" else key: (e["error"], e["extrapolated"]) for key, e in estimate.items()}

    def moment(self, summary: Outcome) -> str:
        if summary["max_approach"]:
            return "at maximum approach"
        gone = summary["status"] == Status.FILM_VANISHED.value
        return "no result, the film vanishes before" if gone else "maximum approach was not reached"


class Rolling(Kind):
    """A rolling contact: its scales are those of the static contact, its values those of the end, or steady."""

    units: Mapping[str, str] = {
        "a*": "a", "a*^2/R": "a^2/R", "p_h*": "p_h", "F*": "F", "a*/t0": "u_m", "a*/R": "a/R", "p_h* a*/R": "p_h a/R",
        "p_h* a*^2/(R t0)": "p_h u_m a/R", "F* a*^2/(R t0)": "F u_m a/R", "F* a*^2/R": "F a^2/R",
    }  # fmt: skip
    conditions = (
        Condition("$u_m$", "u_m_m_per_s", "m/s"),
        Condition("$F$", "F_N", "N"),
        Condition("$p_h$", "p_h_Pa", "Pa"),
    )
    names_sliding = True

    def domain(self, solver: "Solver") -> str:
        inlet = solver.inlet or solver.half_width
        outlet = 2 * solver.half_width - inlet
        return f"{solver.nodes} nodes, {inlet:.4g} a upstream to {outlet:.4g} a downstream{_across(solver)}"

    def speed(self, scales: Scales) -> dict[str, float]:
        return {"u_m_m_per_s": scales.front_speed}

    def values(self, summary: Outcome) -> dict[str, float]:
        names = ("T", *MEASURED, *FRICTION) if summary["H_c"] is not None else ()
        return {name: summary[name] for name in names if name in summary}

    def values_in_si(self, summary: Outcome) -> Mapping[str, float]:
        found: Mapping[str, float] = summary.get("si", {})
        return found

    def errors(self, summary: Outcome) -> Errors:
        known = [name for name in FILMS if summary[f"{name}_error"] is not None]
        return {name: (summary[f"{name}_error"], summary[f"{name}_extrapolated"]) for name in known}

    def moment(self, summary: Outcome) -> str:
        if summary["H_c"] is None:
            gone = "T" not in summary or summary["status"] == Status.FILM_VANISHED.value
            return "no result" if gone else "no step was taken"
        if "T" in summary:
            return f"at T = {summary['T']:.4g}"
        nodes = summary["nodes"]
        return f"on {nodes} x {summary.get('nodes_y', nodes)} nodes"

    def heading(self, summary: Outcome) -> str:
        return "at the last time" if "T" in summary else self.moment(summary)


IMPACT, ROLLING = Impact(), Rolling()
KINDS: Mapping[str, Kind] = {"impact": IMPACT, "rolling": ROLLING}


def as_now(summary: Outcome) -> dict[str, Any]:
    """The summary of a stored run; earlier versions had the coefficients of friction in units a/R and under `si`."""
    reached, si = summary.get("max_approach"), summary.get("si", {})
    if reached:
        return {**summary, "max_approach": _with_coefficients(reached, si.get("max_approach") or {})}
    return _with_coefficients(summary, si)


def _with_coefficients(values: Outcome, si: Mapping[str, float]) -> dict[str, Any]:
    return {**values, **{name: si[name] for name in FRICTION if name in values and name in si}}
