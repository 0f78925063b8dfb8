"""The operating conditions of a contact: which input is complete, and the scales that follow from it.

The contact is given in one of three ways: by Moes' M and L, by the paper's lambda_bar and alpha_bar, or by physical
input in SI.  Each physical quantity must be given in exactly one of the allowed ways.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, fields
from functools import cached_property
from itertools import chain
from math import inf, isclose
from typing import Annotated, Any, Literal, NamedTuple, TypeVar

from ertel.case.records import ConfigError, checked, show, with_unit
from ertel.physics import line_scales, materials, scales, units
from ertel.physics.dry_contact import LARGEST_RATIO, LEAST_RATIO, DryContact, dry_contact
from ertel.physics.geometry import Geometry, geometry
from ertel.physics.line_scales import LineParameters
from ertel.physics.lubricant import Oil
from ertel.physics.scales import Parameters, Scales
from ertel.physics.units import Bounds, Meaning, explained, marks

T = TypeVar("T")
Kind = Literal["impact", "rolling"]
POISSON = Bounds(gt=-1, le=0.5)
REDUCED = units.LENGTH.between(1e-6, 100.0)
BODY = units.LENGTH.between(1e-6, 1e5)  # one of two may be nearly flat
FALL = units.LENGTH.between(1e-12, 1e5)
MOES_M = Bounds(gt=0, least=1e-6, most=1e10)
MOES_L = Bounds(ge=0, most=1e4)

Given = float | None  # of a field that may be left out
ROUND_OFF = 1e-12  # by which the radii of a circular contact may differ

Keys = tuple[str, ...]
ALONG_X, ALONG_Y = ("radius_x_1", "radius_x_2"), ("radius_y_1", "radius_y_2")
PAIRS: Keys = (*ALONG_X, *ALONG_Y)  # a radius that is left out is that of a plane
RADII: tuple[Keys, ...] = (("radius",), ("radius_1", "radius_2"), ("radius_x", "radius_y"), PAIRS)
RATIO = Bounds(ge=0, le=LARGEST_RATIO)
LENGTH_RATIO = Bounds(ge=5, le=1e6)
DEFAULT_LENGTH_RATIO = 100.0
MOES: Keys = ("M", "L")
BARS: Keys = ("lambda_bar", "alpha_bar")
BALL = (("mass",), ("ball_density",))
OF_CYLINDERS: Mapping[tuple[Keys, ...], tuple[Keys, ...]] = {  # in place of the alternatives of balls
    RADII: (("radius",), ("radius_1", "radius_2"), ALONG_X),
    BALL: (("mass",),),
}
LACKED_BY_CYLINDERS: Mapping[str, str] = {  # and what to do
    **dict.fromkeys(
        (*ALONG_Y, "radius_y"), "a line contact has no radius along y; leave it out, or leave length out for an ellipse"
    ),
    "radius_x": "the reduced radius of a line contact is radius",
    "entrainment_angle": "the axes of a line contact lie across the flow; leave it out",
    "ball_density": "the moving body is not a ball; give contact.mass",
}
DROP = (("speed",), ("drop_height",))
TRACK = (("mean_speed",), ("speed_1", "speed_2"))
ELASTICITY = (("E_prime",), ("E1", "nu1", "E2", "nu2"))
NEEDED: Mapping[Kind, tuple[tuple[Keys, ...], ...]] = {
    "impact": (RADII, BALL, DROP, ELASTICITY),
    "rolling": (RADII, (("load",),), TRACK, ELASTICITY),
}
OPTIONAL: Mapping[Kind, Keys] = {
    "impact": ("length", "mean_speed", "slide_to_roll"),
    "rolling": ("length", "mass", "ball_density", "slide_to_roll"),
}
PHYSICAL: Mapping[Kind, Keys] = {
    kind: (*(key for group in groups for keys in group for key in keys), *OPTIONAL[kind])
    for kind, groups in NEEDED.items()
}
FOREIGN: Mapping[Kind, Mapping[str, str]] = {  # keys of the other kind, and what to use instead
    "impact": {
        "load": "its load follows from mass and speed; a load that is applied to the ball is motion.load",
        **dict.fromkeys(
            ("speed_1", "speed_2"), "a track that moves under the ball has contact.mean_speed and contact.slide_to_roll"
        ),
    },
    "rolling": dict.fromkeys(
        ("speed", "drop_height"), "its surfaces have contact.mean_speed, or contact.speed_1 and contact.speed_2"
    ),
}


class Speeds(NamedTuple):
    """Mean speed (m/s) of the surfaces along x and slide-to-roll ratio (u1 - u2)/u_m; None if not given."""

    mean: float | None
    slide_to_roll: float | None


@explained
@dataclass(frozen=True, repr=False)
class Conditions:
    """The two bodies and their operating conditions: the section [contact] of a case file.  Quantities are in SI.

    A contact is given by M and L, by lambda_bar and alpha_bar (eqs. 8, 12), or in SI; what is not given is None.

    Raises ValueError, naming the field, its value and what is allowed, if the input is incomplete or contradictory.
    """

    kind: Annotated[Kind, Meaning("a ball hits an oiled surface, or rolls and slides on it")] = "impact"
    M: Annotated[Given, MOES_M, Meaning("Moes' load parameter, for a contact without dimensions", 1000)] = None
    L: Annotated[Given, MOES_L, Meaning("Moes' lubricant parameter; goes with M", 10)] = None
    lambda_bar: Annotated[Given, units.ABOVE_ZERO, Meaning("dimensionless viscosity, in place of M", 1.1e-3)] = None
    alpha_bar: Annotated[
        Given, units.NOT_NEGATIVE, Meaning("dimensionless pressure-viscosity index; goes with lambda_bar", 36.4)
    ] = None
    radius_ratio: Annotated[
        Given, RATIO, Meaning("R_x/R_y of an elliptical contact without dimensions, 0: a line; left out: a circle", 0.2)
    ] = None
    length_ratio: Annotated[
        Given,
        LENGTH_RATIO,
        Meaning(
            "length of a line contact (radius_ratio = 0) over its half width; it matters only to the approach", 100
        ),
    ] = None
    radius: Annotated[Given, REDUCED, Meaning("radius of a ball on a plane, or reduced radius")] = None
    radius_1: Annotated[
        Given, BODY, Meaning("radius of the first of two balls, the one that moves in an impact; goes with radius_2")
    ] = None
    radius_2: Annotated[Given, BODY, Meaning("radius of the second ball", "15 mm")] = None
    radius_x: Annotated[
        Given, REDUCED, Meaning("reduced radius of an elliptical contact along its axis x; goes with radius_y")
    ] = None
    radius_y: Annotated[Given, REDUCED, Meaning("reduced radius along its axis y", "40 mm")] = None
    radius_x_1: Annotated[
        Given, units.RADIUS, Meaning("radius of body 1 along x; negative: concave, left out: plane", "6 mm")
    ] = None
    radius_y_1: Annotated[Given, units.RADIUS, Meaning("radius of body 1 along y, as radius_x_1", "6 mm")] = None
    radius_x_2: Annotated[Given, units.RADIUS, Meaning("radius of body 2 along x, as radius_x_1", "20 mm")] = None
    radius_y_2: Annotated[Given, units.RADIUS, Meaning("radius of body 2 along y, as radius_x_1", "-6.24 mm")] = None
    length: Annotated[
        Given, REDUCED, Meaning("length of a line contact: of cylinders with parallel axes across the flow", "10 mm")
    ] = None
    entrainment_angle: Annotated[
        Given,
        units.ANGLE.between(0.0, 180.0),
        Meaning("from the axis x of the ellipse to the direction of entrainment, -180 to 180 deg; left out: 0"),
    ] = None
    mass: Annotated[
        Given, units.MASS, Meaning("mass of the moving ball; rolling: for its inertia in time, left out: none")
    ] = None
    ball_density: Annotated[Given, units.DENSITY, Meaning("density of the moving ball, in place of its mass")] = None
    speed: Annotated[Given, units.SPEED, Meaning("impact: speed of the ball at first touch")] = None
    drop_height: Annotated[
        Given, FALL, Meaning("impact: height from which the ball falls, in place of speed", "0.5 mm")
    ] = None
    load: Annotated[Given, units.LOAD, Meaning("rolling: the static load")] = None
    speed_1: Annotated[
        Given, units.VELOCITY, Meaning("rolling: speed of surface 1 along x; goes with speed_2, in place of mean_speed")
    ] = None
    speed_2: Annotated[Given, units.VELOCITY, Meaning("rolling: speed of surface 2 along x")] = None
    mean_speed: Annotated[
        Given,
        units.VELOCITY,
        Meaning("mean of the speeds of both surfaces along x; impact: of a track that moves, left out: at rest"),
    ] = None
    slide_to_roll: Annotated[
        Given,
        units.FINITE,
        Meaning("difference of the speeds over their mean, (u1 - u2)/u_m; goes with mean_speed, left out: 0", 0.1),
    ] = None
    E_prime: Annotated[
        Given, units.MODULUS, Meaning("reduced modulus, 2/E' = (1 - nu1^2)/E1 + (1 - nu2^2)/E2", "226 GPa")
    ] = None
    E1: Annotated[Given, units.MODULUS, Meaning("Young's modulus of body 1; with nu1, E2, nu2 in place of E_prime")] = (
        None
    )
    nu1: Annotated[Given, POISSON, Meaning("Poisson's ratio of body 1", 0.3)] = None
    E2: Annotated[Given, units.MODULUS, Meaning("Young's modulus of body 2")] = None
    nu2: Annotated[Given, POISSON, Meaning("Poisson's ratio of body 2", 0.3)] = None

    def __post_init__(self) -> None:
        checked(self, "contact")
        for place, complaint in self._not_of_lines():
            raise ConfigError(f"{place}: {complaint}")
        for alternatives in NEEDED[self.kind] if self.is_physical else ():
            keys = self._only_one(OF_CYLINDERS.get(alternatives, alternatives) if self.is_line else alternatives)
            if keys not in (PAIRS, ALONG_X):
                self._complete(keys)
        for place, complaint in chain(self._wrong_radii(), self._wrong_speeds()) if self.is_physical else ():
            raise ConfigError(f"{place}: {complaint}")

    def __repr__(self) -> str:
        """Only what is given."""
        given = ", ".join(f"{name}={getattr(self, name)!r}" for name in ("kind", *self.given))
        return f"Conditions({given})"

    # -- which keys ---------------------------------------------------------------------------------------------------

    @cached_property
    def given(self) -> Keys:
        """The fields that are given, apart from the kind."""
        return tuple(f.name for f in fields(self) if f.name != "kind" and getattr(self, f.name) is not None)

    @property
    def is_physical(self) -> bool:
        """Whether the contact is given in SI, so that results are available in SI."""
        return self._route not in (MOES, BARS)

    def entry(self, key: str) -> str:
        """A field as it is written in messages: contact.radius = "0.01 m"."""
        return f"contact.{key} = {show(with_unit(getattr(self, key), marks(type(self)).get(key)))}"

    @cached_property
    def _route(self) -> Keys:
        """MOES, BARS or PHYSICAL: the one way in which the contact is given."""
        for key, instead in FOREIGN[self.kind].items():
            if key in self.given:
                article = "an impact" if self.kind == "impact" else "a rolling contact"
                raise ConfigError(f'{self.entry(key)}: not for {article} (contact.kind = "{self.kind}"): {instead}')
        if self.radius_ratio is not None and any(key in self.given for key in PHYSICAL[self.kind]):
            instead = "give radius_x and radius_y" if self.radius_ratio else "give length"
            raise ConfigError(f"{self.entry('radius_ratio')}: belongs to dimensionless cases; {instead}")
        if "slide_to_roll" in self.given and any(key in self.given for key in (*MOES, *BARS)):
            raise ConfigError(f"{self.entry('slide_to_roll')}: in a dimensionless case write motion.slide_to_roll")
        needed = [" or ".join(" and ".join(keys) for keys in alternatives) for alternatives in NEEDED[self.kind]]
        physical = ", ".join(f"({text})" if " or " in text else text for text in needed)
        return self._only_one((MOES, BARS, PHYSICAL[self.kind]), physical)

    def _only_one(self, alternatives: Sequence[Keys], last: str = "") -> Keys:
        """The one alternative that is given, at least in part.  last: text for the last alternative in messages."""
        present = [keys for keys in alternatives if any(key in self.given for key in keys)]
        texts = [" and ".join(keys) for keys in alternatives]
        allowed = "; or ".join([*texts[:-1], last or texts[-1]])
        if not present:
            raise ConfigError(f"contact.{alternatives[0][0]}: missing; allowed: {allowed}")
        if len(present) > 1:
            pair = [self.entry(next(key for key in keys if key in self.given)) for keys in present[:2]]
            raise ConfigError(f"{' and '.join(pair)} are given together; allowed: {allowed}")
        return present[0]

    def _complete(self, keys: Keys) -> None:
        missing = [key for key in keys if key not in self.given]
        if missing:
            present = next(key for key in keys if key in self.given)
            raise ConfigError(f"contact.{missing[0]}: missing; {self.entry(present)} needs " + " and ".join(keys))

    def _not_of_lines(self) -> Iterator[tuple[str, str]]:
        """The keys that cylinders do not have, and those that only they have."""
        if self.radius_ratio and self.radius_ratio < LEAST_RATIO:
            yield self.entry("radius_ratio"), "allowed: 1/100 to 100, or 0 for a line contact"
        if self.length_ratio is not None and self.radius_ratio != 0:
            yield self.entry("length_ratio"), "belongs to a line contact without dimensions; give radius_ratio = 0"
        for key in self.given if self.is_line else ():
            if key in LACKED_BY_CYLINDERS:
                yield self.entry(key), LACKED_BY_CYLINDERS[key]

    def _wrong_radii(self) -> Iterator[tuple[str, str]]:
        """The bodies must touch at a point or along a line, in an ellipse that is not too long."""
        R_x, R_y = self._radii
        along = ((ALONG_X, R_x),) if self.is_line else ((ALONG_X, R_x), (ALONG_Y, R_y))
        for keys, R in along if any(key in self.given for key in PAIRS) else ():
            given = [key for key in keys if key in self.given]
            for zero in [key for key in given if not getattr(self, key)]:
                yield self.entry(zero), "must not be zero; leave it out for a plane"
            if not 0 < R < inf:
                kind = "line" if self.is_line else "point"
                sum_is_positive = f"the curvatures 1/{keys[0]} + 1/{keys[1]} must add up to more than zero"
                place = " and ".join(map(self.entry, given)) or f"contact.{keys[0]}: missing"
                yield place, f"{sum_is_positive}, otherwise the bodies do not form a {kind} contact"
        if not self.is_line and not LEAST_RATIO <= R_x / R_y <= LARGEST_RATIO:
            ratio = f"the reduced radii {R_x:g} m along x and {R_y:g} m along y have the ratio {R_x / R_y:g}"
            yield "contact", f"{ratio}; allowed: from 1/100 to 100"
        if not self.is_ball and self.ball_density is not None:
            yield self.entry("ball_density"), LACKED_BY_CYLINDERS["ball_density"]

    def _wrong_speeds(self) -> Iterator[tuple[str, str]]:
        """A slide-to-roll ratio goes with a mean speed, which is not zero: it carries the oil into the contact."""
        both, sliding = "speed_1" in self.given and "speed_2" in self.given, "slide_to_roll" in self.given
        if both and sliding:
            yield self.entry("slide_to_roll"), "follows from speed_1 and speed_2; allowed with mean_speed only"
        if both and self.speeds.mean == 0:
            pair = f"{self.entry('speed_1')} and {self.entry('speed_2')}"
            yield pair, "their mean must not be zero, it carries the oil into the contact"
        if sliding and not both and self.mean_speed is None:
            yield self.entry("slide_to_roll"), "needs contact.mean_speed"
        if self.kind == "rolling" and self.mean_speed == 0:
            yield self.entry("mean_speed"), "must not be zero, it carries the oil into the contact"

    # -- what follows -------------------------------------------------------------------------------------------------

    @cached_property
    def scales(self) -> Scales | None:
        """The SI value of one unit of each dimensionless quantity; None for a dimensionless contact."""
        if not self.is_physical:
            return None
        R, _ = self._radii
        E_prime = self.E_prime or _following(materials.reduced_modulus, self.E1, self.nu1, self.E2, self.nu2)
        shape = self.length if self.is_line else self.ratio
        law: Callable[..., Scales]
        if self.kind == "rolling":
            law = line_scales.line_rolling_scales if self.is_line else scales.rolling_scales
            return _following(law, R, self.load, abs(self.speeds.mean or 0.0), E_prime, shape)
        law = line_scales.line_impact_scales if self.is_line else scales.impact_scales
        speed = self.speed or _following(materials.drop_speed, self.drop_height)
        return _following(law, R, self.ball_mass, speed, E_prime, shape)

    @property
    def _radii(self) -> tuple[float, float]:
        """The reduced radii (m) of a physical contact along x and along y; a missing radius means a plane."""
        if self.is_ball:
            R = materials.reduced_radius(self.radius or self.radius_1 or inf, self.radius_2 or inf)
            return R, R
        if self.radius_x is not None:
            return self.radius_x, self.radius_y or 0.0
        along_x = materials.reduced_radius(self.radius_x_1 or inf, self.radius_x_2 or inf)
        return along_x, materials.reduced_radius(self.radius_y_1 or inf, self.radius_y_2 or inf)

    @property
    def is_ball(self) -> bool:
        """Whether the bodies are balls, or a ball and a plane."""
        return self.radius is not None or self.radius_1 is not None

    @cached_property
    def is_line(self) -> bool:
        """Whether the bodies are cylinders that touch along a line."""
        return self.radius_ratio == 0 or self.length is not None

    @property
    def ratio(self) -> float:
        """R_x/R_y; 0 of a line contact."""
        if self.is_line:
            return 0.0
        if not self.is_physical:
            return self.radius_ratio or 1.0
        R_x, R_y = self._radii
        return 1.0 if isclose(R_x, R_y, rel_tol=ROUND_OFF) else R_x / R_y

    @property
    def angle(self) -> float:
        """From the axis x to the direction of entrainment, in degrees."""
        return self.entrainment_angle or 0.0

    @cached_property
    def geometry(self) -> Geometry:
        """The undeformed gap and the constants of the dry contact."""
        return geometry(self.ratio, self.angle, self._hertz.reach)

    @property
    def _hertz(self) -> DryContact:
        """The constants of the dry contact."""
        return self.scales.hertz if self.scales else dry_contact(self.ratio, self.length_ratio or DEFAULT_LENGTH_RATIO)

    @property
    def ball_mass(self) -> float:
        """Mass of the ball (kg), zero if it is not given."""
        if not any(key in self.given for keys in BALL for key in keys):
            return 0.0
        self._only_one(BALL)
        return self.mass or _following(materials.sphere_mass, self.radius or self.radius_1, self.ball_density)

    @property
    def speeds(self) -> Speeds:
        """The speeds of the surfaces along x."""
        if self.speed_1 is not None and self.speed_2 is not None:
            mean, difference = (self.speed_1 + self.speed_2) / 2, self.speed_1 - self.speed_2
            return Speeds(mean, difference / mean if mean else None)
        if self.mean_speed is None:
            return Speeds(None, None)
        return Speeds(self.mean_speed, self.slide_to_roll or 0.0)

    def parameters(self, oil: Oil) -> Parameters:
        """lambda_bar and alpha_bar; alpha_bar is zero if the viscosity does not depend on pressure."""
        if self.scales:
            return _following(scales.parameters, self.scales, oil.eta0, 0.0 if oil.is_isoviscous else oil.alpha)
        first, second = route = self._route
        value = getattr(self, second)
        if oil.is_isoviscous and value:
            raise ConfigError(f'{self.entry(second)}: must be 0 or left out with lubricant.viscosity = "isoviscous"')
        if not (oil.is_isoviscous and first in self.given):
            self._complete(route)
        kind = LineParameters if self.is_line else Parameters
        return _following(kind.from_moes if route is MOES else kind, getattr(self, first), value or 0.0, self._hertz)


def _following(law: Callable[..., T], *values: Any) -> T:
    """The result of a law for values that are allowed one by one, but may be too far apart together."""
    try:
        return law(*values)
    except ArithmeticError as error:
        raise ConfigError("contact: its values together are too large or too small; check their units") from error
    except ValueError as error:
        raise ConfigError(f"contact: its values together give {error}; check their units") from error
