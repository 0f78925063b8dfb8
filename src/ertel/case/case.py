"""A case: the definition of what is solved.  It checks itself, converts itself to plain data, and has a digest.

A `Case` holds the input, in SI or dimensionless.  The solvers use the properties that follow from it: `parameters`,
`scales`, `lubricant`, `motion`, `features`, `schedule`.  All are dimensionless except the scales.
"""

import hashlib
import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from math import inf
from typing import Any, TypeVar

from ertel.case import rules
from ertel.case.conditions import Conditions, Kind
from ertel.case.height_map import NO_MAPS, HeightMap
from ertel.case.reading import Reader, check_key
from ertel.case.records import (
    checked,
    data_of,
    described,
    described_in_html,
    feature_data,
    named,
    oil_data,
    scaled,
    scaled_all,
    show,
    with_own_numbers,
)
from ertel.case.sections import (
    CENTRED_HALF_WIDTH,
    ENDS,
    METHODS,
    SOLVERS,
    START_APPROACH,
    Drive,
    Output,
    Schedule,
    Solver,
    Stop,
    Thermal,
    Time,
    half_width_at,
    half_width_y,
    suited,
)
from ertel.physics import film_formulas, surfaces
from ertel.physics.geometry import CIRCLE, Geometry
from ertel.physics.lubricant import ALPHA, Lubricant, Oil
from ertel.physics.motion import FREE_BALL, STEADY_ROLLING, Motion, Track, constant, reversed_sign
from ertel.physics.scales import Parameters, Scales
from ertel.physics.surfaces import Feature
from ertel.physics.units import plain

SCHEMA = 1  # of the layout of case files
USUAL_OIL, USUAL_SOLVER = Oil(), SOLVERS["2d"]
READER = Reader()
T = TypeVar("T")


@dataclass(frozen=True, repr=False)
class Case:
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

    contact: Conditions
    oil: Oil = USUAL_OIL
    solver: Solver = USUAL_SOLVER
    drive: Drive | None = None
    roughness: tuple[Feature, ...] = ()
    time: Time | None = None
    output: Output | None = None
    name: str = field(default="", compare=False)
    thermal: Thermal | None = None

    def __post_init__(self) -> None:
        for item in fields(self):
            object.__setattr__(self, item.name, with_own_numbers(getattr(self, item.name)))
        rules.check_name(self.name)
        checked(self.solver, "solver")
        rules.check_reference(self.oil)
        rules.check_method(self.kind, self.solver)
        rules.check_fields(self.drive, self.time, self.output, self.roughness)
        self._complete()
        self._check()

    def __repr__(self) -> str:
        return described(*self._described)

    def _repr_html_(self) -> str:
        return described_in_html(*self._described)

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
        if self.solver.method != "radial":
            across = half_width_y(self.solver, self.geometry)
            object.__setattr__(self, "solver", checked(replace(self.solver, half_width_y=across), "solver"))
        if not self.is_steady:
            given = self.time or Time()
            above = min(START_APPROACH, -self.track.extremes[1] if self.track else 0.0) if self.starts_apart else None
            start = above if given.start_approach is None else given.start_approach
            until = ENDS[self.kind] if given.until is None else given.until
            object.__setattr__(self, "time", replace(given, start_approach=start, until=until))
            object.__setattr__(self, "output", self.output or Output())

    def _check(self) -> None:
        """Raise ValueError if the case is not valid."""
        rules.check_oil(self.oil, self.scales)
        rules.check_rheology(self.oil, self.scales, self.solver)
        rules.check_scales(self.scales, self.parameters)
        rules.check_pressure_scale(self.oil, self.scales, self.parameters)
        rules.check_time(self.kind, self.solver, self.time, self.output)
        rules.check_drive(self.kind, self.contact, self.drive)
        rules.check_geometry(self.solver, self.contact, self.motion)
        rules.check_grid(self.solver, self.geometry)
        rules.check_layer(self.oil, self.track, self.solver, self.geometry, self.motion, self.features)
        until: Stop | float = inf
        if self.time and self.output:
            until = self.schedule.until
            rules.check_schedule(self.time, self.output, self.solver, self.schedule)
        rules.check_motion(self.kind, self.solver, self.motion, until)
        if not self.starts_apart:
            rules.check_outside(self.solver, self.parameters, self.geometry, self.motion)
        rules.check_roughness(self.solver, self.motion, self.features)
        if self.thermal:
            rules.check_thermal(checked(self.thermal, "thermal"), self.oil, self.scales, self.solver, self.motion)
        self.lubricant  # noqa: B018  # raises if its data give no law

    # -- what follows -------------------------------------------------------------------------------------------------

    @property
    def kind(self) -> Kind:
        """ "impact" or "rolling"."""
        return self.contact.kind

    @property
    def is_steady(self) -> bool:
        """Whether nothing changes in time."""
        return self.solver.method == "steady"

    @property
    def starts_apart(self) -> bool:
        """Whether the bodies are separated at T = 0, as in an impact; rolling starts from its steady film."""
        return self.kind == "impact"

    @property
    def is_axisymmetric(self) -> bool:
        """Whether the contact is the same in all directions: no entrainment, and no roughness that has a direction."""
        return self.geometry is CIRCLE and not self.motion.flows and surfaces.axisymmetric(self.features)

    @cached_property
    def scales(self) -> Scales | None:
        """The SI value of one unit of each dimensionless quantity; None for a dimensionless case."""
        return self.contact.scales

    @property
    def geometry(self) -> Geometry:
        """The undeformed gap and the constants of the dry contact."""
        return self.contact.geometry

    @cached_property
    def parameters(self) -> Parameters:
        """lambda_bar, alpha_bar and the ratio of the radii."""
        return self.contact.parameters(self.oil)

    @cached_property
    def lubricant(self) -> Lubricant:
        """The laws of the oil as functions of P = p/p_h."""
        p_h = self.scales.p_h if self.scales else self.parameters.alpha_bar / (self.oil.alpha or ALPHA)
        return named("lubricant", self.oil.under, p_h or 1.0)

    @cached_property
    def motion(self) -> Motion:
        """Load, entrainment, sliding and inertia, from the conditions and the drive together."""
        usual = FREE_BALL if self.starts_apart else STEADY_ROLLING
        drive = scaled(self.drive or Drive(), self.scales, "motion")
        mean, slide = self.contact.speeds
        load, entrainment = drive.load or usual.load, drive.entrainment or usual.entrainment
        if self.scales and mean is not None:
            if self.starts_apart:
                entrainment = drive.entrainment or constant(mean / self.scales.front_speed)
            elif mean < 0:
                entrainment = reversed_sign(entrainment)
        return Motion(load, entrainment, self._inertia(drive), slide or drive.slide_to_roll or 0.0)

    def _inertia(self, drive: Drive) -> float:
        if self.starts_apart:
            return self.geometry.free_inertia
        s = self.scales
        return self.contact.ball_mass * s.film / (s.load * s.t0**2) if s else drive.inertia or 0.0

    @cached_property
    def features(self) -> tuple[Feature, ...]:
        """The roughness in the units of the case."""
        return scaled_all(self.roughness, self.scales, "roughness")

    @property
    def maps(self) -> dict[str, HeightMap]:
        """The measured heights that belong to the case, by the names of their files in its plain data."""
        values = [value for feature in self.roughness for value in vars(feature.shape).values()]
        return {value.name: value for value in values if isinstance(value, HeightMap)}

    @cached_property
    def schedule(self) -> Schedule:
        """Start, end, steps and maps in units t0.  Raises ValueError for a steady case, which has none."""
        if self.time is None or self.output is None:
            raise ValueError(f'solver.method = "{self.solver.method}": a steady contact has no time')
        time, output = scaled(self.time, self.scales, "time"), scaled(self.output, self.scales, "output")
        until, step = time.until, time.step
        return Schedule(
            start_approach=START_APPROACH if time.start_approach is None else time.start_approach,
            until=until if isinstance(until, str) else plain(until or 0.0),
            tolerance=time.tolerance,
            step=None if step is None else plain(step),
            interval=plain(output.interval),
        )

    @cached_property
    def track(self) -> Track | None:
        """The oil per area that the surfaces bring along, (u1 h1 + u2 h2)/u_m, in a^2/R; None if the gap is full."""
        slide_to_roll = 0.0 if self.starts_apart else self.motion.slide_to_roll
        return scaled(self.oil, self.scales, "lubricant").track(slide_to_roll)

    @property
    def layer(self) -> float | None:
        """The oil per area in the middle of the track, in a^2/R; None if the gap is full."""
        return None if self.track is None else self.track(0.0)

    @property
    def film_scale(self) -> float:
        """The expected film thickness in a^2/R: the scale of the trapped film (impact) or a formula (rolling)."""
        p = self.parameters
        return p.trapped_film if self.starts_apart else film_formulas.expected_film(p, self.contact.angle)

    def on_half_grid(self) -> "Case":
        """The same case with twice the grid spacing, for the discretisation error estimate."""
        return replace(self, solver=replace(self.solver, nodes=(self.solver.nodes - 1) // 2 + 1))

    # -- as plain data ------------------------------------------------------------------------------------------------

    def to_data(self) -> dict[str, Any]:
        """The case as plain data with the sections and keys of a case file; it reads back as exactly the same case.

        Raises ValueError for a law or a shape that has no registered name.
        """
        sections: dict[str, Any] = {
            "schema": SCHEMA,
            "name": self.name,
            "contact": data_of(self.contact),
            "lubricant": named("lubricant", oil_data, self.oil),
            "solver": self._solver_data(),
            "motion": self.drive and data_of(self.drive),
            "roughness": [
                named(f"roughness[{i}]", feature_data, feature) for i, feature in enumerate(self.roughness, 1)
            ],
            "time": self.time and data_of(self.time),
            "output": self.output and data_of(self.output),
            "thermal": self.thermal and data_of(self.thermal),
        }
        return {name: section for name, section in sections.items() if section not in (None, [], "")}

    def _solver_data(self) -> dict[str, Any]:
        """The section [solver]; a centred grid is written explicitly, because it is not the default of rolling."""
        centred = self.solver.inlet is None and not self.starts_apart
        return data_of(replace(self.solver, inlet=self.solver.half_width) if centred else self.solver)

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
        for name in data:
            check_key(name, data[name], SECTIONS)
        schema = data.get("schema", SCHEMA)
        if type(schema) is not int or schema != SCHEMA:
            raise ValueError(f"schema = {show(schema)}: allowed: {SCHEMA}")
        reader = replace(reader, maps=maps)

        def section(name: str, record: Callable[..., T]) -> T | None:
            return None if data.get(name) is None else reader.record(record, data[name], name)

        contact, oil = section("contact", Conditions) or Conditions(), section("lubricant", Oil) or USUAL_OIL
        solver = section("solver", Solver) or USUAL_SOLVER
        drive, time = section("motion", Drive), section("time", Time)
        roughness = data.get("roughness", [])
        if not isinstance(roughness, list):
            raise ValueError(f"roughness = {show(roughness)}: must be an array of tables, [[roughness]]")
        return cls(
            contact=contact,
            oil=oil,
            solver=_completed(solver, data.get("solver") or {}, contact, oil, drive, time),
            drive=drive,
            roughness=tuple(reader.feature(table, f"roughness[{i}]") for i, table in enumerate(roughness, 1)),
            time=time,
            output=section("output", Output),
            thermal=section("thermal", Thermal),
            name=data.get("name", ""),
        )

    @cached_property
    def digest(self) -> str:
        """Digest of all input that affects a result: 16 hexadecimal digits.  Raises ValueError as `to_data` does."""
        data = self.to_data()
        data.pop("name", None)
        data["lubricant"].pop("reference", None)
        return hashlib.sha256(json.dumps(data, sort_keys=True).encode()).hexdigest()[:16]


SECTIONS = ("schema", "name", "contact", "lubricant", "solver", "motion", "time", "output", "thermal", "roughness")


def _completed(
    given: Solver, written: Mapping[str, Any], contact: Conditions, oil: Oil, drive: Drive | None, time: Time | None
) -> Solver:
    """The solver with what is not written filled in, an inlet of its default's share of the half width."""
    written = {key: getattr(given, key) for key, value in written.items() if value is not None}
    method = written.get("method") or METHODS[contact.kind][0]
    rules.check_method(contact.kind, Solver(method=method))
    default = SOLVERS[method]
    half_width, inlet = default.half_width, default.inlet
    if method == "transient" and drive and rules.reverses(contact, drive, time):
        half_width, inlet = CENTRED_HALF_WIDTH, None
    if "half_width" not in written:
        rules.check_oil(oil, contact.scales)
        p = contact.parameters(oil)
        wide = half_width_at(contact.kind, half_width, p.as_ball.M if contact.kind == "impact" else p.M_BH)
        half_width, inlet = wide, inlet and inlet * wide / half_width
    default = replace(default, half_width=half_width, inlet=inlet)
    if method != "radial":
        default = suited(default, contact.geometry)
    # not default.inlet itself, which may differ in the last bit and so in the digest
    inlet = default.inlet and default.inlet * written.get("half_width", default.half_width) / default.half_width
    return replace(default, **{"inlet": inlet, **written})
