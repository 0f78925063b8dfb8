"""A case: the definition of what is solved.  It checks itself, converts itself to plain data, and has a digest.

A `Case` holds the input, in SI or dimensionless.  The solvers use the properties that follow from it: `parameters`,
`scales`, `lubricant`, `motion`, `features`, `schedule`.  All are dimensionless except the scales.
"""

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from functools import cached_property
from html import escape
from math import inf
from typing import Any

from ertel.case import records, rules, sections
from ertel.case.definition import SECTIONS, Definition
from ertel.case.height_map import NO_MAPS, HeightMap
from ertel.case.methods import of_kind
from ertel.case.reading import Reader, check_keys
from ertel.case.records import ConfigError
from ertel.case.sections import Output, Solver, Time
from ertel.physics.units import plain

SCHEMA = 1  # of the layout of case files
READER = Reader()
KEYS = ("schema", "name", "contact", "lubricant", "solver", "motion", "roughness", "time", "output", "thermal")


@dataclass(frozen=True, repr=False)
class Case(Definition):
    """One contact, ready to be simulated.

    Amounts are numbers in the units of the case, or quantities in SI.

    Parameters
    ----------
    contact : Conditions
        The operating conditions.
    oil : Oil
        The lubricant.
    solver : Solver
        Method, grid and tolerance.
    drive : Drive, optional
        Load and entrainment as functions of time; left out: the default of an impact or of rolling.
    roughness : tuple of Feature
        What stands on the surfaces.
    time : Time, optional
        The steps of a run in time; None for a steady case.
    output : Output, optional
        What is kept of a run in time; None for a steady case.
    name : str
        The name, not part of equality or digest.
    thermal : Thermal, optional
        What the temperatures of a steady contact depend on; None if they are not wanted.

    Raises
    ------
    ValueError
        The input is not valid; the message names the field, its value and what is allowed.

    Examples
    --------
    >>> case = Case.from_data({"contact": {"M": 1000, "L": 10}, "solver": {"method": "radial"}})
    >>> round(case.parameters.alpha_bar, 2)
    36.44
    >>> Case.from_data(case.to_data()) == case
    True
    """

    def __post_init__(self) -> None:
        for item in fields(self):
            object.__setattr__(self, item.name, records.with_own_numbers(getattr(self, item.name)))
        for name, section in SECTIONS.items():
            if (record := getattr(self, section.field)) is not None:
                records.checked(record, name)
        rules.refuse(self, rules.GIVEN)
        for number, feature in enumerate(self.roughness, 1):
            records.checked(feature.shape, f"roughness[{number}]")
        self._complete()
        rules.refuse(self, rules.COMPLETE)
        self.lubricant  # noqa: B018  # raises if its data give no law

    def __repr__(self) -> str:
        title, data = self._described
        return "\n".join([f"Case: {title}", *(f"  {name:<10} {content}" for name, content in records.described(data))])

    def _repr_html_(self) -> str:
        title, data = self._described
        rows = (f"<tr><th>{escape(name)}</th><td>{escape(text)}</td></tr>" for name, text in records.described(data))
        return f"<div>Case: {escape(title)}<table>{''.join(rows)}</table></div>"

    @property
    def _described(self) -> tuple[str, dict[str, Any]]:
        """A title, and the sections; the fields themselves where a law cannot be written."""
        p, name = self.parameters, f"{self.name}, " if self.name else ""
        title = f"{name}{self.kind} ({self.solver.method}), M = {p.M:.4g}, L = {p.L:.4g}"
        try:
            return title, self.to_data()
        except ValueError:
            return title, {f.name: repr(getattr(self, f.name)) for f in fields(self) if getattr(self, f.name)}

    def _complete(self) -> None:
        """Fill in defaults, so that the record defines the case completely."""
        if not self.contact.is_physical:
            object.__setattr__(self, "oil", self.oil.completed())
        if self.solver.inlet == self.solver.half_width:
            object.__setattr__(self, "solver", replace(self.solver, inlet=None))
        solver = self.method.space.completed(self.solver, self.geometry)
        object.__setattr__(self, "solver", records.checked(solver, "solver"))
        if not self.is_steady:
            given = self.time or Time()
            layer = self.track.extremes[1] if self.track else 0.0
            above = min(sections.START_APPROACH, -layer) if self.starts_apart else None
            start = above if given.start_approach is None else given.start_approach
            until = self.method.end if given.until is None else given.until
            object.__setattr__(self, "time", replace(given, start_approach=start, until=until))
            object.__setattr__(self, "output", self.output or Output())

    def on_half_grid(self) -> "Case":
        """The same case with twice the grid spacing, for the discretisation error estimate."""
        return replace(self, solver=replace(self.solver, nodes=(self.solver.nodes - 1) // 2 + 1))

    # -- as plain data ------------------------------------------------------------------------------------------------

    def to_data(self) -> dict[str, Any]:
        """The case as plain data with the sections and keys of a case file; it reads back as exactly the same case.

        Raises ValueError for a law or a shape that has no registered name.
        """
        solver = self.solver
        if solver.inlet is None and not self.starts_apart:
            solver = replace(solver, inlet=solver.half_width)  # a centred grid is not the default of rolling
        shapes = enumerate(self.roughness, 1)
        roughness = [records.named(f"roughness[{n}]", records.feature_data, shape) for n, shape in shapes]
        data: dict[str, Any] = {
            "schema": SCHEMA,
            "name": self.name,
            "contact": records.data_of(self.contact),
            "lubricant": records.named("lubricant", records.oil_data, self.oil),
            "solver": records.data_of(solver),
            "motion": self.drive and records.data_of(self.drive),
            "roughness": roughness,
            "time": self.time and records.data_of(self.time),
            "output": self.output and records.data_of(self.output),
            "thermal": self.thermal and records.data_of(self.thermal),
        }
        return {name: section for name, section in data.items() if section not in (None, [], "")}

    @classmethod
    def from_data(
        cls, data: Mapping[str, Any], maps: Mapping[str, HeightMap] = NO_MAPS, reader: Reader = READER
    ) -> "Case":
        """The case from plain data, with defaults filled in.

        Parameters
        ----------
        data : mapping
            The sections and keys of a case file; quantities as the reader takes them.
        maps : mapping
            Measured heights by their names in the data, as the property `maps`.
        reader : Reader
            By default one that takes SI units only: "0.01 m", or a number.  `inputs` has one for all units.

        Raises
        ------
        ValueError
            At the first error, naming the field, its value and what is allowed.
        """
        check_keys(data, KEYS, elsewhere=reader.full_names)
        schema = data.get("schema", SCHEMA)
        if type(schema) is not int or schema != SCHEMA:
            raise ConfigError(f"schema = {records.show(schema)}: allowed: {SCHEMA}")
        roughness = data.get("roughness", [])
        if not isinstance(roughness, list):
            raise ConfigError(f"roughness = {records.show(roughness)}: must be an array of tables, [[roughness]]")
        reader = replace(reader, maps=maps)
        data = {"contact": {}} | {name: section for name, section in data.items() if section is not None}
        sections = ((name, section) for name, section in SECTIONS.items() if name in data)
        given: dict[str, Any] = {each.field: reader.record(each.record, data[name], name) for name, each in sections}
        given["roughness"] = tuple(reader.feature(table, f"roughness[{i}]") for i, table in enumerate(roughness, 1))
        definition = Definition(name=data.get("name", ""), **given)
        given["solver"] = _completed(definition, data.get("solver") or {})
        return cls(name=definition.name, **given)

    @cached_property
    def digest(self) -> str:
        """Digest of all input that affects a result: 16 hexadecimal digits.  Raises ValueError as `to_data` does."""
        data = self.to_data()
        data.pop("name", None)
        data["lubricant"].pop("reference", None)
        return hashlib.sha256(json.dumps(data, sort_keys=True).encode()).hexdigest()[:16]


def _completed(case: Definition, written: Mapping[str, Any]) -> Solver:
    """The solver with what is not written filled in, an inlet of its default's share of the half width."""
    written = {key: getattr(case.solver, key) for key, value in written.items() if value is not None}
    case = replace(case, solver=Solver(written.get("method") or of_kind(case.kind)[0].name))
    rules.refuse(case, [rules.method_suits])
    method, half_width, inlet = case.method, case.method.defaults.half_width, case.method.defaults.inlet
    if inlet and not case.is_steady and _reverses(case):
        half_width, inlet = inlet, None  # either side is the upstream one for a while
    if "half_width" not in written:
        rules.refuse(case, [rules.oil_is_complete])
        p = case.parameters
        wide = method.widening.of(half_width, p.as_ball.M if case.starts_apart else p.M_BH)
        half_width, inlet = wide, inlet and inlet * wide / half_width
    default = method.space.suited(replace(method.defaults, half_width=half_width, inlet=inlet), case.geometry)
    # not default.inlet itself, which may differ in the last bit and so in the digest
    inlet = default.inlet and default.inlet * written.get("half_width", default.half_width) / default.half_width
    return replace(default, **{"inlet": inlet, **written})


def _reverses(case: Definition) -> bool:
    """Whether the entrainment speed changes sign during a run in time."""
    if case.drive is None or case.drive.entrainment is None:
        return False
    until = records.scaled(case.time or Time(), case.scales, "time").until
    end = case.method.end if until is None else until
    least, most = case.motion.entrainment.range(inf if isinstance(end, str) or end is None else plain(end))
    return least < 0 < most
