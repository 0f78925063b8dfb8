"""A run as an xarray Dataset: scalars over time and fields over frames, or a steady contact over its grids."""

from collections.abc import Mapping, Sequence
from typing import Any, Protocol

import numpy as np
import xarray as xr

from ertel.case.case import Case
from ertel.case.grids import grid_of
from ertel.equations import account
from ertel.equations.friction import Friction, coefficients
from ertel.equations.state import GridSolution
from ertel.physics.scales import Scales
from ertel.results.height_maps import variables_of
from ertel.results.provenance import provenance
from ertel.results.temperatures import temperature_maps
from ertel.results.variables import (
    AXES,
    BUDGET,
    EVENTS,
    FIELDS,
    FRICTION,
    MEASURED,
    SCALARS,
    variable_attributes,
    with_coefficients,
)


class Frame(Protocol):
    """The fields of a run at one time."""

    @property
    def T(self) -> float: ...
    @property
    def fields(self) -> Mapping[str, Any]: ...
    @property
    def event(self) -> str: ...


def columns(records: Sequence[Mapping[str, float]], scales: Scales | None) -> dict[str, np.ndarray]:
    """Step records as arrays by variable name, T as `time`; coefficients as `with_coefficients` says."""
    names = {"time": "T", **{name: name for name in SCALARS}}
    found = {name: np.array([record[key] for record in records], dtype=float) for name, key in names.items()}
    return with_coefficients(found, scales)


def maps(frames: Sequence[Frame]) -> dict[str, np.ndarray]:
    """Frames as arrays by variable name, stacked along the first axis."""
    return {
        "frame": np.array([frame.T for frame in frames], dtype=float),
        "event": np.array([EVENTS.index(frame.event) for frame in frames], dtype=np.int8),
        **{name: np.array([frame.fields[name] for frame in frames], dtype=float) for name in FIELDS},
    }


def dimensions(name: str, coordinates: Mapping[str, Any]) -> tuple[str, ...]:
    """Dimensions of a variable of a run in time; the space axes are those of `coordinates`, in order."""
    if name in FIELDS:
        return ("frame", *coordinates)
    return (name,) if name in AXES else ("frame",) if name == "event" else ("time",)


def assemble(
    case: Case,
    records: Sequence[Mapping[str, float]],
    frames: Sequence[Frame],
    coordinates: Mapping[str, Any],
    attributes: Mapping[str, object] | None = None,
) -> xr.Dataset:
    """The run as a Dataset: scalars over `time` (every step), maps over `frame` and the space axes.

    Parameters
    ----------
    case : Case
        The case of the run; its provenance is stored in the attributes.
    records : sequence of mappings
        The scalars of every accepted step, by variable name and "T", dimensionless.
    frames : sequence of Frame
        The maps that were kept.
    coordinates : mapping
        Axes of the maps in order, in a*: Y and X, or r.
    attributes : mapping, optional
        More attributes of the Dataset.
    """
    space = {name: np.asarray(axis) for name, axis in coordinates.items()}
    stacks = maps(frames)
    for name in FIELDS:  # no maps at all still have their shape
        stacks[name] = stacks[name].reshape(len(frames), *(len(axis) for axis in space.values()))
    arrays = {**columns(records, case.scales), **stacks, **space}
    variables = {
        name: (dimensions(name, coordinates), values, variable_attributes(name, case.scales))
        for name, values in arrays.items()
    }
    axes = {name: variables.pop(name) for name in AXES if name in variables}
    return xr.Dataset({**variables, **variables_of(case)}, axes, {**provenance(case), **(attributes or {})})


def assemble_steady(
    case: Case,
    solutions: Sequence[GridSolution],
    attributes: Mapping[str, object] | None = None,
) -> xr.Dataset:
    """The steady contact as a Dataset: fields on the finest grid, scalars and residuals over `grid`.

    grid: nodes a side, coarsest first.  convolutions: in units of one on that grid.  attributes: as in `assemble`.
    With a section [thermal] there are `variables.TEMPERATURES` too.
    """
    finest = solutions[-1].grid if solutions else grid_of(case)
    nothing = np.full((len(finest.y), len(finest.x)), np.nan)
    last = solutions[-1] if solutions else None
    accounts = [account.steady(case, s) for s in solutions]
    found = whole_maps(last, last.P, last.H, accounts[-1][1]) if last else dict.fromkeys(FIELDS, nothing)
    found |= temperature_maps(case, last, nothing)
    history = _histories(solutions)
    of_grids = [
        with_coefficients({**s.measure(), **terms, **coefficients(friction), **_work(s)}, case.scales)
        for s, (terms, friction) in zip(solutions, accounts, strict=True)
    ]
    names = (*MEASURED, *BUDGET, *FRICTION, "residual", "newton_iterations", "krylov_iterations", "convolutions")
    arrays: dict[str, tuple[tuple[str, ...], Any]] = {
        **{name: (("Y", "X"), values) for name, values in found.items()},
        **{name: (("grid",), np.array([row[name] for row in of_grids], dtype=float)) for name in names},
        "history": (("grid", "iteration"), history),
    }
    axes = {"Y": finest.y, "X": finest.x, "grid": np.array([s.grid.nodes for s in solutions], dtype=np.int64)}
    coordinates = {**axes, "iteration": np.arange(history.shape[1])}
    variables = {
        name: (dims, values, variable_attributes(name, case.scales)) for name, (dims, values) in arrays.items()
    }
    return xr.Dataset(
        {**variables, **variables_of(case)},
        {name: ((name,), values, variable_attributes(name, case.scales)) for name, values in coordinates.items()},
        {**provenance(case), **(attributes or {})},
    )


class _Whole(Protocol):
    """What unfolds a field."""

    def whole(self, field: Any, odd: bool = False) -> Any: ...


def whole_maps(method: _Whole, P: Any, H: Any, friction: Friction) -> dict[str, np.ndarray]:
    """All `FIELDS` on the whole plane, from a film and its friction."""
    tau_x, tau_y = np.asarray(friction.stress)
    fields = {"P": P, "H": H, "tau_x": tau_x, "tau_y": tau_y, "loss": friction.loss}
    return {name: np.asarray(method.whole(field, odd=name == "tau_y")) for name, field in fields.items()}


def _histories(solutions: Sequence[GridSolution]) -> np.ndarray:
    """The residuals on every grid (grid, iteration), nan after the last iteration."""
    longest = max((len(s.history) for s in solutions), default=0)
    history = np.full((len(solutions), longest), np.nan)
    for row, s in zip(history, solutions, strict=True):
        row[: len(s.history)] = s.history
    return history


def _work(s: GridSolution) -> dict[str, float]:
    counts = {"newton_iterations": s.newton, "krylov_iterations": s.krylov, "convolutions": s.convolutions}
    return {"residual": s.residual, **counts}
