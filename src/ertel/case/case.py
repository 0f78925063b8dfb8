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
from typing import Any

from ertel.case import records, rules
from ertel.case.completion import solver_of, with_defaults
from ertel.case.conditions import Conditions
from ertel.case.definition import SECTIONS, Definition
from ertel.case.height_map import NO_MAPS, HeightMap
from ertel.case.reading import Reader, check_keys
from ertel.case.records import ConfigError, with_own_numbers
from ertel.case.sections import Drive, Output, Solver, Thermal, Time
from ertel.physics.lubricant import Oil
from ertel.physics.surfaces import Feature

SCHEMA = 1  # of the layout of case files
READER = Reader()
KEYS = ("schema", "name", "contact", "lubricant", "solver", "motion", "roughness", "time", "output", "thermal")


@dataclass(frozen=True, repr=False, init=False)
class Case(Definition):
    """One contact, ready to be simulated: a definition, completed and checked.

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

    def __init__(
        self,
        contact: Conditions,
        oil: Oil | None = None,
        solver: Solver | None = None,
        drive: Drive | None = None,
        roughness: tuple[Feature, ...] = (),
        time: Time | None = None,
        output: Output | None = None,
        name: str = "",
        thermal: Thermal | None = None,
    ) -> None:
        given = Definition(contact, oil or Oil(), solver or Solver(), drive, roughness, time, output, name, thermal)
        given = with_own_numbers(given)
        rules.check_values(given)
        rules.refuse(given, rules.GIVEN)
        whole = with_defaults(given)
        rules.refuse(whole, rules.COMPLETE)
        super().__init__(**{item.name: getattr(whole, item.name) for item in fields(whole)})
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
        return cls(**vars(replace(definition, solver=solver_of(definition, data.get("solver") or {}))))

    @cached_property
    def digest(self) -> str:
        """Digest of all input that affects a result: 16 hexadecimal digits.  Raises ValueError as `to_data` does."""
        data = self.to_data()
        data.pop("name", None)
        data["lubricant"].pop("reference", None)
        return hashlib.sha256(json.dumps(data, sort_keys=True).encode()).hexdigest()[:16]
