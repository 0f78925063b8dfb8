"""The definition of a case: its sections and what follows from them, its nodes, and estimates without a run.

Whether it makes sense, `rules` says.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from math import floor, inf, log2, sqrt
from typing import Any, NamedTuple

import numpy as np

from ertel.case.conditions import Conditions, Kind
from ertel.case.height_map import HeightMap
from ertel.case.methods import METHODS, Method
from ertel.case.records import ConfigError, named, scaled, scaled_all, show, with_unit
from ertel.case.sections import START_APPROACH, Drive, Output, Schedule, Solver, Thermal, Time
from ertel.numerics.grid import NO_SYMMETRY, Grid, Symmetry
from ertel.physics import film_formulas, hertz, surfaces
from ertel.physics.far_field import ContactMotion, squeezed_film
from ertel.physics.film_formulas import IMPACT_EXPONENT, starved_share
from ertel.physics.geometry import CIRCLE, Geometry
from ertel.physics.line_films import expected_line_film
from ertel.physics.line_scales import LineParameters
from ertel.physics.lubricant import ALPHA, Lubricant, Oil
from ertel.physics.motion import FREE_BALL, STEADY_ROLLING, Motion, Track, constant, reversed_sign
from ertel.physics.scales import Parameters, Scales
from ertel.physics.surfaces import Feature
from ertel.physics.units import marks

CELLS_SHOWN, CELLS_OF_DETAIL = 16.0, 8.0  # least number in the contact's half width, in the finest detail of a surface
LARGEST_NEWTONIAN_STRESS = 6e6  # Pa: the stress at which squalane begins to thin (Liu et al. 2023, see the library)
_PLACES = np.polynomial.legendre.leggauss(64)


class Section(NamedTuple):
    """A section of a case file: the field of a case that holds it, its record, and what it is about."""

    field: str
    record: Any
    text: str


SECTIONS: Mapping[str, Section] = {
    "contact": Section("contact", Conditions, "the two bodies and their operating conditions"),
    "lubricant": Section("oil", Oil, "the oil: its name, or its data"),
    "solver": Section("solver", Solver, "grid and tolerance"),
    "motion": Section("drive", Drive, "load and speed as functions of time"),
    "time": Section("time", Time, "start, end and steps of a run in time"),
    "output": Section("output", Output, "which maps are kept, besides those at maximum approach and at the end"),
    "thermal": Section("thermal", Thermal, "rolling: temperatures of a steady contact in SI, empty if all is named"),
}


@dataclass(frozen=True, repr=False)
class Definition:
    """The fields of a `Case`, which describes them; not checked yet."""

    contact: Conditions
    oil: Oil = field(default_factory=Oil)
    solver: Solver = field(default_factory=Solver)
    drive: Drive | None = None
    roughness: tuple[Feature, ...] = ()
    time: Time | None = None
    output: Output | None = None
    name: str = field(default="", compare=False)
    thermal: Thermal | None = None

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


# -- nodes ------------------------------------------------------------------------------------------------------------


def grid_of(case: Definition) -> Grid:
    """The grid of a case on the plane; the inlet is on the upstream side at T = 0."""
    s = case.solver
    centre = 0.0 if s.inlet is None else s.half_width - s.inlet
    upstream_is_left = case.motion.entrainment(0.0) >= 0
    centre_x = centre if upstream_is_left else -centre
    return Grid(s.nodes, case.method.space.across(s), case.spacing, centre_x, even=_symmetry(case, centre_x))


def _symmetry(case: Definition, centre_x: float) -> Symmetry:
    """The axes about which a case is symmetric; the flow is along X."""
    in_y, in_x = (a and b for a, b in zip(surfaces.even(case.features), case.geometry.even, strict=True))
    in_y = in_y and (case.track is None or case.track.is_even)
    return Symmetry(in_y, in_x and not case.motion.flows and centre_x == 0) if case.solver.fold else NO_SYMMETRY


def coarsenings(case: Definition, spacing: float, most: int) -> int:
    """The number of times, at most `most`, that a grid can be coarsened and still show contact and roughness.

    Once more where a meniscus passes node after node: then half as many cells show the contact.
    """
    shown = CELLS_SHOWN if case.layer is None else CELLS_SHOWN / 2
    finest = min((getattr(f.shape, "size", 0.0) for f in case.features), default=inf)
    widest = min(case.geometry.smaller / shown, finest / CELLS_OF_DETAIL)
    return min(most, max(0, floor(log2(widest / spacing) + 1e-9))) if widest > 0 else 0


# -- estimates for layers of oil --------------------------------------------------------------------------------------


def starvation(case: Definition) -> tuple[float, float]:
    """r, the oil of the layers over that of the flooded film, and the share of that film which is expected.

    Of an impact at maximum approach.  Infinite and 1 for a full gap.
    """
    if case.layer is None:
        return inf, 1.0
    flooded = sum(case.parameters.impact_films) / 2 if case.starts_apart else case.film_scale
    r = case.layer / (float(case.lubricant.density(1.0)) * flooded)
    return r, share_of(case, r)


def share_of(case: Definition, r: float) -> float:
    """The share of the flooded film on a layer of oil that is r times as thick."""
    if case.starts_apart:
        return starved_share(r, IMPACT_EXPONENT)
    return min(r, 1.0) if case.geometry.is_line else starved_share(r)  # nothing leaks out of a line to the sides


def wet_radius(layer: float) -> float:
    """The radius (a) up to which a layer (a^2/R) is wet by a ball at maximum approach, at most.

    The oil that the ball displaces fills the dry gap around the contact.  In the computed impacts it is 6 to 13 %
    smaller: the film holds oil back.  Early, where the ball is rigid, it is 2 sqrt(layer - H_0).
    """
    r = np.linspace(0.0, 2.0 * sqrt(layer + 1.0), 1001)[1:]
    mean_gap = 2.0 * np.cumsum(hertz.gap(r) * r) * r[0] / r**2
    return float(np.interp(layer, mean_gap, r))


# -- estimates of a physical contact --------------------------------------------------------------------------------


def film_estimate(case: Definition) -> float:
    """The expected central film thickness (m), an impact's by its scale; infinite for a dimensionless case."""
    return case.film_scale * starvation(case)[1] * case.scales.film if case.scales else inf


def largest_pressure(case: Definition) -> float:
    """The maximum Hertz pressure (Pa) at the largest load, an impact's without oil; zero for a dimensionless case."""
    if case.scales is None:
        return 0.0
    load = 1.0 if case.starts_apart else case.motion.load.range(inf)[1]
    return case.scales.p_h * case.geometry.grown(load)


def newtonian_stress(case: Definition) -> float:
    """The mean shear stress (Pa) that sliding gives a Newtonian oil; zero without sliding and for a dimensionless case.

    eta u_s/h with the film of a formula, and the mean over the contact of the viscosity at the Hertz pressure:

        2 integral from 0 to 1 of eta(p_h s) s ds,      p = p_h s at the radius sqrt(1 - s^2)

    Along a line it is the integral from 0 to 1 of eta(p_h sqrt(1 - x^2)) dx.
    """
    sliding = abs(case.motion.slide_to_roll) * max(map(abs, case.motion.entrainment.range(inf)))
    if case.scales is None or case.oil.eta0 is None or not sliding:
        return 0.0
    z, weight = _PLACES
    s, share = (1.0 + z) / 2.0, (1.0 + z) / 2.0
    if case.geometry.is_line:
        s, share = np.sqrt(1.0 - s**2), np.full_like(s, 0.5)
    with np.errstate(over="ignore", divide="ignore", invalid="ignore"):
        growth = float(np.sum(weight * share * case.oil.viscosity_law.viscosity(largest_pressure(case) * s)))
    stress = growth * case.oil.eta0 * sliding * case.scales.front_speed / film_estimate(case)
    return stress if stress >= 0.0 else inf  # beyond the pole of a modulus law
