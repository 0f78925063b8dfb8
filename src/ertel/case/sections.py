"""The sections solver, time, output, motion, surfaces and thermal of a case.  All defaults of ertel are here."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from math import hypot
from typing import Annotated, Any, Literal, NamedTuple

from ertel.case.conditions import Conditions, Given
from ertel.physics import thermal, units
from ertel.physics.asperities import AsperityLaw, ExponentialTouch, MeasuredWaves
from ertel.physics.lubricant import Oil
from ertel.physics.motion import Signal
from ertel.physics.units import Amount, Bounds, Meaning, explained

Stop = Literal["max-approach", "rebound"]
Start = Literal["undeformed"]
FEWEST_NODES, MOST_NODES, WIDEST_HALF_WIDTH = 17, 4097, 1000.0
NODES = Bounds(ge=FEWEST_NODES, le=MOST_NODES, whole=True)
HALF_WIDTH = Bounds(gt=0, le=WIDEST_HALF_WIDTH)


@explained
@dataclass(frozen=True)
class Solver:
    """Grid and tolerance; all lengths in units a (impact: a*).

    The tolerance of a time step is a film thickness in units of the expected film thickness (`Case.film_scale`), and
    20 time.tolerance at most.  The residual left by one step is corrected in the next, so it does not add up.  For a
    steady contact it is the residual of the Reynolds equation; 0.03 takes less than half the work and leaves at most
    about a tenth of the grid's own error in H_c and H_min.  The defaults are those of the method (`methods.METHODS`);
    they follow the size of an ellipse.
    """

    method: Annotated[
        str,
        Meaning("an impact is computed on a square grid (2d) or along the radius (radial), rolling steady or in time"),
    ] = "2d"
    nodes: Annotated[
        int, NODES, Meaning("nodes per side of the grid, 2^k c + 1 with a small c, or along the radius")
    ] = 257
    half_width: Annotated[
        float,
        HALF_WIDTH,
        Meaning("half width of the grid along x, in a; wider by default for M < 100 (rolling: M < 5)"),
    ] = 2.0
    inlet: Annotated[
        Given,
        Bounds(gt=0),
        Meaning("from the contact's centre to the upstream edge, in a; reversing flow and impact: half_width", 4.5),
    ] = None
    tolerance: Annotated[
        float,
        units.SHARE,
        Meaning(
            "in time: a film thickness over the expected one; steady: the residual, where 0.03 leaves a tenth of the "
            "grid's own error for less than half the work"
        ),
    ] = 1e-3
    fold: Annotated[bool, Meaning("whether a symmetric case is computed on a half or a quarter of the plane")] = True
    half_width_y: Annotated[
        Given, HALF_WIDTH, Meaning("half_width along y; left out: the edge is as far from the contact as along x", 3.0)
    ] = None


@explained
@dataclass(frozen=True)
class Time:
    """Start, end and steps of a run in time; amounts are in t0 or quantities.

    The local error of a step is that of Delta, of dDelta/dT, and of the film relative to itself.  The error of a run
    falls with its power 2/3; the default gives about 0.1 % in H_c.  A fixed step has no error control; it is shortened
    only to end on the points of a signal and at the end.
    """

    start_approach: Annotated[
        Given,
        Bounds(lt=0),
        Meaning("impact: approach Delta at the start, below zero: apart; left out: above the layer of oil, too", -1.0),
    ] = None
    start: Annotated[
        Start | None,
        Meaning("impact: bodies without deformation and oil without pressure; left out: as if from far", "undeformed"),
    ] = None
    until: Annotated[
        Stop | Amount | None,
        units.DURATION,
        Meaning("the end: a time, or in an impact max-approach or rebound", "max-approach"),
    ] = None
    tolerance: Annotated[float, units.SHARE, Meaning("error allowed in a time step, relative")] = 5e-5
    step: Annotated[Amount | None, units.DURATION, Meaning("a fixed time step, in place of tolerance", 0.01)] = None

    def with_steps(self, factor: float) -> "Time":
        """The same with steps that are larger by a factor; of those of a tolerance the size goes as its cube root."""
        if self.step is None:
            return replace(self, tolerance=self.tolerance * factor**3)
        return replace(self, step=self.step * factor)


START_APPROACH = -1.0


@explained
@dataclass(frozen=True)
class Output:
    """The film and pressure maps that are kept, besides those at maximum approach and at the end."""

    interval: Annotated[Amount, units.DURATION, Meaning("time between the film and pressure maps that are kept")] = 0.1


@explained
@dataclass(frozen=True)
class Drive:
    """Load, speeds and curvature as functions of time: the section [motion].  None: the default of the kind of contact.

    A signal is a number, points [T, value] with straight lines between them, of which each ends a time step, a table
    `smooth` of many points with a smooth curve through them (`physics.motion.Smooth`), or an oscillation.
    """

    load: Annotated[
        Signal | None,
        Meaning("applied load w(T), in F* (impact, left out: 0) or in the static load (rolling, left out: 1)", 1.0),
    ] = None
    entrainment: Annotated[
        Signal | None,
        Meaning(
            "mean speed U(T), in a/t0 (impact, left out: 0) or u_m (rolling, left out: 1)", [[0, 1], [1, 1], [5, -1]]
        ),
    ] = None
    slide_to_roll: Annotated[
        Signal | Given,
        units.FINITE,
        Meaning("(u1 - u2)/U(T), a number only in a contact without dimensions; left out: 0", 0.1),
    ] = None
    sliding: Annotated[
        Signal | None,
        Meaning(
            "rolling: u1 - u2 in u_m, in place of slide_to_roll where U(T) passes through zero", [[0, 0.1], [5, 1]]
        ),
    ] = None
    curvature: Annotated[
        Signal | None,
        Meaning(
            "rolling in time: R/R(T), above zero, with R of [contact]; of an ellipse both radii change; left out: 1",
            [[0, 1], [5, 1.2]],
        ),
    ] = None
    inertia: Annotated[
        Given,
        units.NOT_NEGATIVE,
        Meaning("inertia of the ball in a rolling contact without dimensions; left out: 0", 0.5),
    ] = None


class Schedule(NamedTuple):
    """`Time` and `Output` in units t0."""

    start_approach: float
    until: Stop | float
    tolerance: float
    step: float | None
    interval: float
    start: Start | None
    contact_time: float  # of the dry impact

    @property
    def duration(self) -> float:
        """T at the end of the run; of an event about, as if the impact were dry."""
        match self.until:
            case "max-approach":
                return self.contact_time / 2 - self.start_approach
            case "rebound":
                return self.contact_time - 2 * self.start_approach
            case until:
                return until


# -- asperities -------------------------------------------------------------------------------------------------------


@explained
@dataclass(frozen=True)
class Surfaces:
    """The roughness that no grid resolves, as numbers: with a law of asperities the surfaces touch where oil is thin.

    Waves that stand in [[roughness]] are in the gap itself and must not be counted here again.
    """

    sigma: Annotated[
        Given,
        units.ROUGHNESS,
        Meaning(
            'rms roughness, one value for both surfaces together, or sigma_1 and sigma_2; "Ra 40 nm" is 1.25 Ra, that '
            "of Gaussian heights",
            "50 nm",
        ),
    ] = None
    sigma_1: Annotated[Given, units.ROUGHNESS, Meaning("rms roughness of surface 1", "50 nm")] = None
    sigma_2: Annotated[Given, units.ROUGHNESS, Meaning("rms roughness of surface 2", "10 nm")] = None
    asperities: Annotated[
        AsperityLaw | None,
        Meaning(
            "law of the asperities that touch; left out: they do not touch",
            {"law": "persson", "longest": "50 um", "shortest": "1 um"},
        ),
    ] = None
    boundary_friction: Annotated[
        Given, units.NOT_NEGATIVE, Meaning("friction coefficient where they touch; left out: 0.12", 0.12)
    ] = None
    hardness: Annotated[
        Given,
        units.STRESS,
        Meaning("of the softer body: asperities carry no more; left out: that of the named materials", "7 GPa"),
    ] = None

    def __post_init__(self) -> None:
        if self.sigma is not None and self.sigma != self.rms:
            raise ValueError(f"sigma = {self.sigma:g} m: goes without sigma_1 and sigma_2; give one or the others")
        if self.asperities is None:
            for key in ("boundary_friction", "hardness"):
                if getattr(self, key) is not None:
                    raise ValueError(f"{key} = {getattr(self, key):g}: goes with asperities, which is missing")
        elif self.rms is None and not isinstance(self.asperities, ExponentialTouch | MeasuredWaves):
            raise ValueError('sigma: missing, the law of the asperities needs it, for example "50 nm"')

    @property
    def rms(self) -> float | None:
        """The rms roughness of both surfaces together (m), None where none is given."""
        if self.sigma_1 is None and self.sigma_2 is None:
            return self.sigma
        return hypot(self.sigma_1 or 0.0, self.sigma_2 or 0.0)

    @property
    def friction(self) -> float:
        """The friction coefficient where asperities touch."""
        return BOUNDARY_FRICTION if self.boundary_friction is None else self.boundary_friction


BOUNDARY_FRICTION = 0.12  # of steel in mineral oil

# -- temperatures -----------------------------------------------------------------------------------------------------


@explained
@dataclass(frozen=True)
class Thermal:
    """Data for the temperatures of a contact in SI: temperatures (K), data of the oil and of both bodies.

    How warm a machine gets is not known to a contact.  The named laws are in `physics.thermal`: WARM_VISCOSITIES, how
    the viscosity falls with the temperature under pressure, and INLET_FACTORS, by which formula inlet shear heating
    reduces the film.
    """

    temperature: Annotated[
        float,
        units.TEMPERATURE,
        Meaning("of the oil in the inlet, for which eta0 and alpha hold; left out: that in [lubricant]"),
    ]
    conductivity: Annotated[
        float, units.CONDUCTIVITY, Meaning("thermal conductivity of the oil; left out: that of the named oil")
    ]
    beta: Annotated[
        float,
        units.EXPANSION,
        Meaning("-d ln(eta)/dT of the oil at ambient pressure; left out: that of the named oil", "0.035 / K"),
    ]
    density_1: Annotated[
        float, units.DENSITY, Meaning("density of body 1; left out, as the next two: that of material_1")
    ]
    heat_capacity_1: Annotated[float, units.HEAT_CAPACITY, Meaning("heat capacity of body 1", "460 J/(kg*K)")]
    conductivity_1: Annotated[float, units.CONDUCTIVITY, Meaning("thermal conductivity of body 1", "46 W/(m*K)")]
    density_2: Annotated[
        float, units.DENSITY, Meaning("density of body 2; left out, as the next two: that of material_2")
    ]
    heat_capacity_2: Annotated[float, units.HEAT_CAPACITY, Meaning("heat capacity of body 2", "460 J/(kg*K)")]
    conductivity_2: Annotated[float, units.CONDUCTIVITY, Meaning("thermal conductivity of body 2", "46 W/(m*K)")]
    temperature_1: Annotated[
        Given, units.TEMPERATURE, Meaning("of body 1 far below its surface; left out: that of the oil", "60 degC")
    ] = None
    temperature_2: Annotated[
        Given, units.TEMPERATURE, Meaning("of body 2 far below its surface; left out: that of the oil", "60 degC")
    ] = None
    viscosity: Annotated[
        thermal.ViscosityName,
        Meaning("how it falls with the temperature: more under pressure, or equally at all pressures"),
    ] = "houpert"
    density: Annotated[
        float,
        units.DENSITY,
        Meaning("of the oil in the inlet; left out: that of the named oil, or 870 kg/m^3", "870 kg/m^3"),
    ] = 870.0
    heat_capacity: Annotated[
        float,
        units.HEAT_CAPACITY,
        Meaning("of the oil; left out: that of the named oil, or 2000 J/(kg*K)", "2000 J/(kg*K)"),
    ] = 2000.0
    expansion: Annotated[
        float,
        units.EXPANSION,
        Meaning("thermal expansion of the oil; left out: that of the named oil, or 0.00065 / K", "0.00065 / K"),
    ] = 6.5e-4
    inlet: Annotated[
        thermal.InletName,
        Meaning(
            "film with heat: solved, or the isothermal one thinner by a formula of inlet shear heating, which is quick"
        ),
    ] = "solved"

    def completed(self) -> "Thermal":
        """The same with the temperature of the oil for a body whose own is left out."""
        first, second = (T or self.temperature for T in (self.temperature_1, self.temperature_2))
        return replace(self, temperature_1=first, temperature_2=second)

    @property
    def bodies(self) -> tuple[thermal.Solid, thermal.Solid]:
        """The thermal data of both bodies."""
        first = thermal.Solid(self.density_1, self.heat_capacity_1, self.conductivity_1)
        return first, thermal.Solid(self.density_2, self.heat_capacity_2, self.conductivity_2)

    @property
    def warmer(self) -> tuple[float, float]:
        """By how much the bodies are warmer than the oil in the inlet (K)."""
        T = self.temperature
        return (self.temperature_1 or T) - T, (self.temperature_2 or T) - T

    @property
    def is_solved(self) -> bool:
        """Whether the film is solved with its heat."""
        return self.inlet == "solved"

    def viscosity_of(self, eta0: float) -> thermal.WarmViscosity:
        """The law of the warm oil's viscosity.  Raises ValueError for an eta0 (Pa s) for which it has no meaning."""
        return thermal.WARM_VISCOSITIES[self.viscosity].of(eta0, self.beta, self.temperature)

    def inlet_of(self, eta0: float, p_h_over_E: float, mean_speed: float, slide_to_roll: float) -> "Inlet":
        """Inlet shear heating; eta0 in Pa s, mean_speed in m/s."""
        L_t = thermal.thermal_loading(eta0, self.beta, mean_speed, self.conductivity)
        factor = thermal.INLET_FACTORS[self.inlet].formula(L_t, abs(slide_to_roll), p_h_over_E)
        return Inlet(L_t, factor)


class Inlet(NamedTuple):
    """Thermal loading L_t of the inlet, and phi_T, by which the film is thinner."""

    L_t: float
    factor: float


# -- all of them ------------------------------------------------------------------------------------------------------


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
    "surfaces": Section("surfaces", Surfaces, "roughness as numbers, and the asperities that touch"),
    "thermal": Section("thermal", Thermal, "rolling: temperatures of a steady contact in SI, empty if all is named"),
}
