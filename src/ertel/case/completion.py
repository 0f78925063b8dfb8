"""What is left out of a case, filled in: its solver by the method and the contact, its oil, the end of its run.

So a case says all that is solved, and a stored run does not change with the defaults.
"""

from collections.abc import Mapping
from dataclasses import replace
from math import inf
from typing import Any

from ertel.case import records, rules
from ertel.case.definition import Definition
from ertel.case.methods import of_kind
from ertel.case.sections import START_APPROACH, Output, Solver, Time
from ertel.physics.units import plain


def with_defaults(case: Definition) -> Definition:
    """The same with its defaults: the data of a dimensionless oil, the half width along y, time and output."""
    oil = case.oil if case.contact.is_physical else case.oil.completed()
    solver = case.solver
    if solver.inlet == solver.half_width:
        solver = replace(solver, inlet=None)  # a centred grid is written in one way
    solver = records.checked(case.method.space.completed(solver, case.geometry), "solver")
    thermal = case.thermal and case.thermal.completed()
    if case.is_steady:
        return replace(case, oil=oil, solver=solver, thermal=thermal)
    given = case.time or Time()
    layer = case.track.extremes[1] if case.track else 0.0
    above = min(START_APPROACH, -layer) if case.starts_apart else None
    start = above if given.start_approach is None else given.start_approach
    until = case.method.end if given.until is None else given.until
    time = replace(given, start_approach=start, until=until)
    return replace(case, oil=oil, solver=solver, thermal=thermal, time=time, output=case.output or Output())


def solver_of(case: Definition, written: Mapping[str, Any]) -> Solver:
    """The solver with what is not written filled in, an inlet of its default's share of the half width.

    written: the section [solver], of which only the keys count.
    """
    given = {key: getattr(case.solver, key) for key, value in written.items() if value is not None}
    case = replace(case, solver=Solver(given.get("method") or of_kind(case.kind)[0].name))
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


def _reverses(case: Definition) -> bool:
    """Whether the entrainment speed changes sign during a run in time."""
    if case.drive is None or case.drive.entrainment is None:
        return False
    until = records.scaled(case.time or Time(), case.scales, "time").until
    end = case.method.end if until is None else until
    least, most = case.motion.entrainment.range(inf if isinstance(end, str) or end is None else plain(end))
    return least < 0 < most
