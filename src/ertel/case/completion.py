"""The constructor of a case: it fills in the values that are left out, and looks at the rules.

These are the solver by the method and the contact, the oil, the end of a run.  So a case says all that is solved, and a
stored run does not change with the defaults.
"""

from collections.abc import Collection
from dataclasses import fields, replace
from math import inf
from typing import Any

from ertel.case import records, rules
from ertel.case.case import Case, completions
from ertel.case.height_map import Measured
from ertel.case.methods import of_kind
from ertel.case.sections import START_APPROACH, Output, Solver, Time
from ertel.case.touching import touching_gap
from ertel.physics import surfaces
from ertel.physics.asperities import MeasuredWaves
from ertel.physics.surfaces import Feature
from ertel.physics.units import Quantity, plain


def complete(case: Case, written: Collection[str] | None) -> None:
    """Complete and check a case that is being made; the only time when its fields change.

    written: the keys of its solver that count; None: all.  Raises ValueError for the first rule that it breaks.
    """
    if written is not None:
        _put(case, solver=_solver(case, written))
    _put(case, **{item.name: records.with_own_numbers(getattr(case, item.name)) for item in fields(case)})
    rules.check_values(case)
    rules.refuse(case, rules.GIVEN)
    _put(case, **_defaults(case))
    rules.refuse(case, rules.COMPLETE)
    case.lubricant  # noqa: B018  # raises if its data give no law


completions.append(complete)


def _put(case: Case, **values: Any) -> None:
    """Set fields of a case, and forget what followed from the earlier ones."""
    kept = {item.name: getattr(case, item.name) for item in fields(case)}
    vars(case).clear()
    vars(case).update(kept | values)


def _solver(case: Case, written: Collection[str]) -> Solver:
    """The solver with defaults for the keys that are not written; the inlet scales with the half width."""
    given = {key: getattr(case.solver, key) for key in written}
    _put(case, solver=Solver(given.get("method") or of_kind(case.kind)[0].name))
    rules.refuse(case, [rules.method_suits])
    method, half_width, inlet = case.method, case.method.defaults.half_width, case.method.defaults.inlet
    if inlet and not case.is_steady and _reverses(case):
        half_width, inlet = inlet, None  # either side is the upstream one for a while
    if "half_width" not in given:
        rules.refuse(case, [rules.oil_is_complete])
        p = case.parameters
        wide = method.widening.of(half_width, p.as_ball.M if case.starts_apart else p.M_BH)
        half_width, inlet = wide, inlet and inlet * wide / half_width
    default = method.space.suited(replace(method.defaults, half_width=half_width, inlet=inlet), case.geometry)
    # not default.inlet itself, which may differ in the last bit and so in the digest
    inlet = default.inlet and default.inlet * given.get("half_width", default.half_width) / default.half_width
    return replace(default, **{"inlet": inlet, **given})


def _reverses(case: Case) -> bool:
    """Whether the entrainment speed changes sign during a run in time."""
    if case.drive is None or case.drive.entrainment is None:
        return False
    until = records.scaled(case.time or Time(), case.scales, "time").until
    end = case.method.end if until is None else until
    least, most = case.motion.entrainment.range(inf if isinstance(end, str) or end is None else plain(end))
    return least < 0 < most


def _parted(feature: Feature, shortest: Quantity) -> Feature:
    """A feature, if it is a map without a cutoff with the shortest wave that the grid resolves."""
    shape = feature.shape
    if not isinstance(shape, Measured) or shape.cutoff is not None:
        return feature
    return replace(feature, shape=replace(shape, cutoff=shortest))


def _defaults(case: Case) -> dict[str, Any]:
    """The defaults of a case: the data of a dimensionless oil, the half width along y, time and output."""
    oil = case.oil if case.contact.is_physical else case.oil.completed()
    solver = case.solver
    if solver.inlet == solver.half_width:
        solver = replace(solver, inlet=None)  # a centred grid is written in one way
    solver = records.checked(case.method.space.completed(solver, case.geometry), "solver")
    found: dict[str, Any] = {"oil": oil, "solver": solver, "thermal": case.thermal and case.thermal.completed()}
    if case.scales and isinstance(case.surfaces and case.surfaces.asperities, MeasuredWaves):
        shortest = Quantity(surfaces.CELLS_IN_WAVE * case.spacing * case.scales.a, "m")
        found["roughness"] = tuple(_parted(feature, shortest) for feature in case.roughness)
        _put(case, **found)
    if case.is_steady:
        return found
    given = case.time or Time()
    layer = case.track.extremes[1] if case.track else 0.0
    above = min(START_APPROACH, -layer, -touching_gap(case)) if case.starts_apart else None
    start = above if given.start_approach is None else given.start_approach
    until = case.method.end if given.until is None else given.until
    time = replace(given, start_approach=start, until=until)
    return {**found, "time": time, "output": case.output or Output()}
