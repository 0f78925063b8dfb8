"""A case: the definition of what is solved.  It checks itself, converts itself to plain data, and has a digest.

A `Case` holds the input, in SI or dimensionless.  The solvers use the properties that follow from it: `parameters`,
`scales`, `lubricant`, `motion`, `features`, `schedule`.  All are dimensionless except the scales.
"""

import hashlib
import json
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import InitVar, dataclass, field, fields, replace
from functools import cached_property
from typing import Any

import numpy as np

from ertel.case import records
from ertel.case.conditions import Conditions, Kind
from ertel.case.height_map import NO_MAPS, HeightMap, Measured
from ertel.case.methods import METHODS, Method
from ertel.case.reading import Reader, check_keys
from ertel.case.records import ConfigError, named, scaled, scaled_all, show, with_unit
from ertel.case.sections import SECTIONS, START_APPROACH, Drive, Output, Schedule, Solver, Surfaces, Thermal, Time
from ertel.physics import film_formulas, surfaces
from ertel.physics.asperities import FEWEST, GapCurve, MeasuredWaves, Spectrum
from ertel.physics.far_field import ContactMotion, squeezed_film
from ertel.physics.geometry import CIRCLE, Geometry
from ertel.physics.line_films import expected_line_film
from ertel.physics.line_scales import LineParameters
from ertel.physics.lubricant import ALPHA, Lubricant, Oil
from ertel.physics.motion import FREE_BALL, STEADY_ROLLING, Motion, SlidingRatio, Track, constant, reversed_sign
from ertel.physics.scales import Parameters, Scales
from ertel.physics.surfaces import Feature
from ertel.physics.units import marks, plain

MEASURED = 'surfaces.asperities.law = "measured"'
SCHEMA = 1  # of the layout of case files
READER = Reader()
KEYS = ("schema", "name", *SECTIONS, "roughness")


# What completes and checks a case in its constructor: `completion`, which knows the rules, puts its function here.
completions: list[Callable[["Case", Collection[str] | None], None]] = []


@dataclass(frozen=True, repr=False)
class Case:
    """One contact, ready to be simulated: completed and checked.

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
    surfaces : Surfaces, optional
        Roughness as numbers, and the law of the asperities that touch; None for smooth surfaces.
    written : collection of str, optional
        The keys of the solver that count, where the others follow from the method and the contact; left out: all.

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
    oil: Oil = field(default_factory=Oil)
    solver: Solver = field(default_factory=Solver)
    drive: Drive | None = None
    roughness: tuple[Feature, ...] = ()
    time: Time | None = None
    output: Output | None = None
    name: str = field(default="", compare=False)
    thermal: Thermal | None = None
    surfaces: Surfaces | None = None
    written: InitVar[Collection[str] | None] = None

    def __post_init__(self, written: Collection[str] | None) -> None:
        [complete] = completions
        complete(self, written)

    def __repr__(self) -> str:
        p, name = self.parameters, f"{self.name}, " if self.name else ""
        title = f"{name}{self.kind} ({self.method.in_words}), M = {p.M:.4g}, L = {p.L:.4g}"
        try:
            data = self.to_data()
        except ValueError:  # of a law that cannot be written
            data = {f.name: repr(getattr(self, f.name)) for f in fields(self) if getattr(self, f.name)}
        return "\n".join([f"Case: {title}", *(f"  {name:<10} {content}" for name, content in records.described(data))])

    def on_half_grid(self) -> "Case":
        """The same case with twice the grid spacing, for the discretisation error estimate."""
        return replace(self, solver=replace(self.solver, nodes=(self.solver.nodes - 1) // 2 + 1))

    # -- what follows -------------------------------------------------------------------------------------------------

    def entry(self, place: str) -> str:
        """A field as messages have it, time.until = 5.0; the place as it is where there is no such value."""
        name, _, key = place.partition(".")
        record = getattr(self, SECTIONS[name].field) if name in SECTIONS else None
        value = getattr(record, key or "-", None)
        return place if value is None else f"{place} = {show(with_unit(value, marks(type(record)).get(key)))}"

    @property
    def kind(self) -> Kind:
        """ "impact" or "rolling"."""
        return self.contact.kind

    @property
    def method(self) -> Method:
        """The record of its method."""
        return METHODS[self.solver.method].of(self.geometry)

    @property
    def is_steady(self) -> bool:
        """Whether nothing changes in time."""
        return self.method.is_steady

    @property
    def spacing(self) -> float:
        """The spacing of its grid in a; of a radial grid at the position where the front is judged."""
        return self.method.space.spacing(self.solver)

    @property
    def starts_apart(self) -> bool:
        """Whether the bodies are separated at T = 0, as in an impact; rolling starts from its steady film."""
        return self.kind == "impact"

    @property
    def touches(self) -> bool:
        """Whether asperities may carry a part of the load."""
        return self.surfaces is not None and self.surfaces.asperities is not None

    @cached_property
    def asperities(self) -> GapCurve | None:
        """The law of the asperities that touch, in SI and without a hardness; None where none touch."""
        given, scales = self.surfaces, self.scales
        if given is None or given.asperities is None or scales is None:
            return None
        waves = () if self.lost_waves is None else (self.lost_waves,)
        return given.asperities.curve(self.sigma or 0.0, scales.E_prime / 2, *waves)

    @property
    def sigma(self) -> float | None:
        """The rms roughness of both surfaces together (m) that is not in the gap; None where it is not given."""
        given = self.surfaces.rms if self.surfaces else None
        return self.lost_waves.rms if given is None and self.lost_waves else given

    @cached_property
    def lost_waves(self) -> Spectrum | None:
        """The waves of the measured maps that are a law in place of the gap; None without such a law.

        They are those below the cutoff of the map, and those that the grid does not show.
        """
        law, scales = self.surfaces and self.surfaces.asperities, self.scales
        if not isinstance(law, MeasuredWaves) or scales is None:
            return None
        maps = [feature.shape for feature in self.features if isinstance(feature.shape, Measured)]
        if not maps or self.geometry.is_line:
            raise ConfigError(f"{MEASURED}: needs a measured map in [[roughness]]; a profile will not do")
        cuts = [max(plain(each.cutoff or 0.0), surfaces.CELLS_KEPT * self.spacing) for each in maps]
        parts = [each.lost_waves(cut) for each, cut in zip(maps, cuts, strict=True)]
        q, variance = (np.concatenate(part) for part in zip(*parts, strict=True))
        known = q * (law.shortest or 0.0) <= 2 * np.pi * scales.a
        waves = Spectrum.of(q[known] / scales.a, variance[known] * scales.film**2)
        if waves.q.size < FEWEST:
            raise ConfigError(f"{MEASURED}: cutoff and shortest leave it no waves of the map; give a longer cutoff")
        return waves

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
        load, entrainment, sliding = drive.load or usual.load, drive.entrainment or usual.entrainment, drive.sliding
        if self.scales and mean is not None:
            if self.starts_apart:
                entrainment = drive.entrainment or constant(mean / self.scales.front_speed)
            elif mean < 0:
                entrainment, sliding = reversed_sign(entrainment), sliding and reversed_sign(sliding)
        if ratio := slide or drive.slide_to_roll:
            sliding = SlidingRatio(constant(ratio) if isinstance(ratio, int | float) else ratio, entrainment)
        others = sliding or usual.sliding, drive.curvature or usual.curvature
        return Motion(load, entrainment, self._inertia(drive), *others)

    def _inertia(self, drive: Drive) -> float:
        if self.starts_apart:
            return self.geometry.hertz.inertia
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
            raise ConfigError(f"{self.entry('solver.method')}: a steady contact has no time")
        given = replace(self.time, start_approach=self.time.start_approach or START_APPROACH)
        time, output = scaled(given, self.scales, "time"), scaled(self.output, self.scales, "output")
        return Schedule(**vars(time), **vars(output), contact_time=self.geometry.hertz.contact_time)

    @property
    def first_motion(self) -> ContactMotion:
        """The motion that makes the first pressure of an impact: that of a ball from far; undeformed bodies rest."""
        given = self.schedule
        rest = ContactMotion(given.start_approach, 0.0, 0.0, 0.0)
        return rest if given.start else rest._replace(velocity=1.0, entrainment=self.motion.entrainment(0.0))

    @property
    def first_film(self) -> tuple[float, float]:
        """Central film (a^2/R) and load (F*) with which an impact starts."""
        full = 0.0 if self.layer else self.parameters.lambda_bar  # no pressure before the ball is in its layer
        return squeezed_film(self.first_motion, full, self.geometry)

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
        if self.starts_apart:
            return p.trapped_film
        if isinstance(p, LineParameters):
            return expected_line_film(p)
        return film_formulas.expected_film(p, self.contact.angle)

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
        data: dict[str, Any] = {"schema": SCHEMA, "name": self.name, "roughness": roughness}
        data |= {"lubricant": records.named("lubricant", records.oil_data, self.oil), "solver": records.data_of(solver)}
        given = {name: getattr(self, section.field) for name, section in SECTIONS.items() if name not in data}
        data |= {name: records.data_of(record) for name, record in given.items() if record is not None}
        return {name: data[name] for name in KEYS if data.get(name) not in (None, [], "")}

    @classmethod
    def from_data(
        cls,
        data: Mapping[str, Any],
        maps: Mapping[str, HeightMap] = NO_MAPS,
        reader: Reader = READER,
        features: Sequence[Feature] = (),
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
        features : sequence of Feature
            Further roughness.

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
        read = (reader.feature(table, f"roughness[{i}]") for i, table in enumerate(roughness, 1))
        given["roughness"] = (*read, *features)
        written = [key for key, value in data.get("solver", {}).items() if value is not None]
        return cls(name=data.get("name", ""), written=written, **given)

    @cached_property
    def digest(self) -> str:
        """Digest of all input that affects a result: 16 hexadecimal digits.  Raises ValueError as `to_data` does."""
        data = self.to_data()
        data.pop("name", None)
        data["lubricant"].pop("reference", None)
        return hashlib.sha256(json.dumps(data, sort_keys=True).encode()).hexdigest()[:16]
