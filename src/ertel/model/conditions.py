"""The operating conditions of a contact: which input is complete, and the scales that follow from it.

The contact is given in one of three ways: by Moes' M and L, by the paper's lambda_bar and alpha_bar, or by physical
input in SI.  Each physical quantity must be given in exactly one of the allowed ways.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields
from functools import cached_property
from math import isclose
from typing import Annotated, Any, Literal, NamedTuple, TypeVar

from ertel.model import radii
from ertel.model.records import checked, show
from ertel.physics import bodies, scales
from ertel.physics.geometry import Geometry, geometry
from ertel.physics.lubricant import Oil
from ertel.physics.scales import Parameters, Scales
from ertel.physics.units import (
    ABOVE_ZERO,
    ANGLE,
    DENSITY,
    FINITE,
    LENGTH,
    LOAD,
    MASS,
    NOT_NEGATIVE,
    RADIUS,
    SPEED,
    STRESS,
    VELOCITY,
    Bounds,
    Unit,
    marks,
)

T = TypeVar("T")
Kind = Literal["impact", "rolling"]
KINDS: tuple[Kind, ...] = ("impact", "rolling")
POISSON = Bounds(gt=-1, le=0.5)

HALF_TURN = 180.0  # degrees
ROUND_OFF = 1e-12  # by which the radii of a circular contact may differ

Keys = tuple[str, ...]
MOES: Keys = ("M", "L")
BARS: Keys = ("lambda_bar", "alpha_bar")
BALL = (("mass",), ("ball_density",))
FALL = (("speed",), ("drop_height",))
TRACK = (("mean_speed",), ("speed_1", "speed_2"))
ELASTICITY = (("E_prime",), ("E1", "nu1", "E2", "nu2"))
NEEDED: Mapping[Kind, tuple[tuple[Keys, ...], ...]] = {
    "impact": (radii.WAYS, BALL, FALL, ELASTICITY),
    "rolling": (radii.WAYS, (("load",),), TRACK, ELASTICITY),
}
OPTIONAL: Mapping[Kind, Keys] = {
    "impact": ("mean_speed", "slide_to_roll"),
    "rolling": ("mass", "ball_density", "slide_to_roll"),
}
PHYSICAL: Mapping[Kind, Keys] = {
    kind: (*(key for group in groups for keys in group for key in keys), *OPTIONAL[kind])
    for kind, groups in NEEDED.items()
}
PHYSICAL_TEXT: Mapping[Kind, str] = {
    "impact": f"{radii.TEXT}, mass or ball_density, speed or drop_height, E_prime or E1, nu1, E2, nu2",
    "rolling": f"{radii.TEXT}, load, mean_speed or speed_1 and speed_2, E_prime or E1, nu1, E2, nu2",
}
FOREIGN: Mapping[Kind, Mapping[str, str]] = {  # keys of the other kind, and what to use instead
    "impact": {
        "load": "its load follows from mass and speed; a load that is applied to the ball is motion.load",
        "speed_1": "a track that moves under the ball has contact.mean_speed and contact.slide_to_roll",
        "speed_2": "a track that moves under the ball has contact.mean_speed and contact.slide_to_roll",
    },
    "rolling": {
        "speed": "its surfaces have contact.mean_speed, or contact.speed_1 and contact.speed_2",
        "drop_height": "its surfaces have contact.mean_speed, or contact.speed_1 and contact.speed_2",
    },
}


class Speeds(NamedTuple):
    """Mean speed (m/s) of the surfaces along x and slide-to-roll ratio (u1 - u2)/u_m; None if not given."""

    mean: float | None
    slide_to_roll: float | None


@dataclass(frozen=True, repr=False)
class Conditions:
    """The two bodies and their operating conditions: the section [contact] of a case file.  Quantities are in SI.

    Parameters
    ----------
    kind : "impact" or "rolling"
    M, L : float
        Moes' load and lubricant parameters; or
    lambda_bar, alpha_bar : float
        the paper's parameters, eqs. (8), (12); or physical input:
    radius_ratio : float
        R_x/R_y of a dimensionless elliptical contact, from 1/100 to 100; 1 if left out.
    radius, radius_1, radius_2 : float
        Radius (m) of a ball on a plane, or the radii of two balls; in an impact the first one moves.
    radius_x, radius_y : float
        Reduced radii (m) of an elliptical contact along its principal axes x and y.
    radius_x_1, radius_y_1, radius_x_2, radius_y_2 : float
        Principal radii (m) of both bodies along the same axes: negative where concave, left out where plane.
    entrainment_angle : float
        From the axis x to the direction of entrainment, in degrees, -180 to 180; 0 if left out.
    E_prime, E1, nu1, E2, nu2 : float
        Reduced modulus (Pa), or Young's moduli (Pa) and Poisson's ratios.
    mass, ball_density : float
        Mass (kg) or density (kg/m^3) of the moving ball.  Rolling: for its inertia, none if left out.
    speed, drop_height : float
        Impact: speed at first touch (m/s), or drop height from rest (m).
    load : float
        Rolling: static load (N).
    mean_speed, slide_to_roll, speed_1, speed_2 : float
        Speeds of the surfaces along x (m/s) and (u1 - u2)/u_m.  Impact: the track moves under the ball.

    Raises ValueError, naming the field, its value and what is allowed, if the input is incomplete or contradictory.
    """

    kind: Kind = "impact"
    M: Annotated[float | None, ABOVE_ZERO] = None
    L: Annotated[float | None, NOT_NEGATIVE] = None
    lambda_bar: Annotated[float | None, ABOVE_ZERO] = None
    alpha_bar: Annotated[float | None, NOT_NEGATIVE] = None
    radius_ratio: Annotated[float | None, radii.RATIO] = None
    radius: Annotated[float | None, LENGTH] = None
    radius_1: Annotated[float | None, LENGTH] = None
    radius_2: Annotated[float | None, LENGTH] = None
    radius_x: Annotated[float | None, LENGTH] = None
    radius_y: Annotated[float | None, LENGTH] = None
    radius_x_1: Annotated[float | None, RADIUS] = None
    radius_y_1: Annotated[float | None, RADIUS] = None
    radius_x_2: Annotated[float | None, RADIUS] = None
    radius_y_2: Annotated[float | None, RADIUS] = None
    entrainment_angle: Annotated[float | None, ANGLE] = None
    mass: Annotated[float | None, MASS] = None
    ball_density: Annotated[float | None, DENSITY] = None
    speed: Annotated[float | None, SPEED] = None
    drop_height: Annotated[float | None, LENGTH] = None
    load: Annotated[float | None, LOAD] = None
    speed_1: Annotated[float | None, VELOCITY] = None
    speed_2: Annotated[float | None, VELOCITY] = None
    mean_speed: Annotated[float | None, VELOCITY] = None
    slide_to_roll: Annotated[float | None, FINITE] = None
    E_prime: Annotated[float | None, STRESS] = None
    E1: Annotated[float | None, STRESS] = None
    nu1: Annotated[float | None, POISSON] = None
    E2: Annotated[float | None, STRESS] = None
    nu2: Annotated[float | None, POISSON] = None

    def __post_init__(self) -> None:
        if self.kind not in KINDS:
            raise ValueError(f"contact.kind = {show(self.kind)}: allowed: 'impact' or 'rolling'")
        checked(self, "contact")
        if self.entrainment_angle is not None and not abs(self.entrainment_angle) <= HALF_TURN:
            raise ValueError(f"{self.entry('entrainment_angle')}: must be from -180 deg to 180 deg")
        route = self._route()
        if route in (MOES, BARS):
            return
        for alternatives in NEEDED[self.kind]:
            keys = self._only_one(alternatives)
            if keys != radii.PAIRS:
                self._complete(keys)
        radii.check(self)
        self._check_speeds()

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
        return self._route() not in (MOES, BARS)

    def entry(self, key: str) -> str:
        """A field as it is written in messages: contact.radius = "0.01 m"."""
        value, mark = getattr(self, key), marks(type(self)).get(key)
        return f"contact.{key} = {show(f'{value!r} {mark.unit}' if isinstance(mark, Unit) else value)}"

    def _route(self) -> Keys:
        """MOES, BARS or PHYSICAL: the one way in which the contact is given."""
        for key, instead in FOREIGN[self.kind].items():
            if key in self.given:
                article = "an impact" if self.kind == "impact" else "a rolling contact"
                raise ValueError(f'{self.entry(key)}: not for {article} (contact.kind = "{self.kind}"): {instead}')
        if self.radius_ratio is not None and any(key in self.given for key in PHYSICAL[self.kind]):
            raise ValueError(
                f"{self.entry('radius_ratio')}: belongs to dimensionless cases; give radius_x and radius_y"
            )
        if "slide_to_roll" in self.given and any(key in self.given for key in (*MOES, *BARS)):
            raise ValueError(f"{self.entry('slide_to_roll')}: in a dimensionless case write motion.slide_to_roll")
        return self._only_one((MOES, BARS, PHYSICAL[self.kind]), PHYSICAL_TEXT[self.kind])

    def _only_one(self, alternatives: Sequence[Keys], last: str = "") -> Keys:
        """The one alternative that is given, at least in part.  last: text for the last alternative in messages."""
        present = [keys for keys in alternatives if any(key in self.given for key in keys)]
        texts = [" and ".join(keys) for keys in alternatives]
        allowed = "; or ".join([*texts[:-1], last or texts[-1]])
        if not present:
            raise ValueError(f"contact.{alternatives[0][0]}: missing; allowed: {allowed}")
        if len(present) > 1:
            pair = [self.entry(next(key for key in keys if key in self.given)) for keys in present[:2]]
            raise ValueError(f"{' and '.join(pair)} are given together; allowed: {allowed}")
        return present[0]

    def _complete(self, keys: Keys) -> None:
        missing = [key for key in keys if key not in self.given]
        if missing:
            present = next(key for key in keys if key in self.given)
            raise ValueError(f"contact.{missing[0]}: missing; {self.entry(present)} needs " + " and ".join(keys))

    def _check_speeds(self) -> None:
        both = self.speed_1 is not None and self.speed_2 is not None
        if both and self.slide_to_roll is not None:
            raise ValueError(
                f"{self.entry('slide_to_roll')}: follows from speed_1 and speed_2; allowed with mean_speed only"
            )
        if both and self.speeds.mean == 0:
            pair = f"{self.entry('speed_1')} and {self.entry('speed_2')}"
            raise ValueError(f"{pair}: their mean must not be zero, it carries the oil into the contact")
        if not both and self.mean_speed is None and self.slide_to_roll is not None:
            raise ValueError(f"{self.entry('slide_to_roll')}: needs contact.mean_speed")
        if self.kind == "rolling" and self.mean_speed == 0:
            raise ValueError(f"{self.entry('mean_speed')}: must not be zero, it carries the oil into the contact")

    # -- what follows -------------------------------------------------------------------------------------------------

    @cached_property
    def scales(self) -> Scales | None:
        """The SI value of one unit of each dimensionless quantity; None for a dimensionless contact."""
        if not self.is_physical:
            return None
        R, _ = radii.reduced(self)
        E_prime = self.E_prime or _following(bodies.reduced_modulus, self.E1, self.nu1, self.E2, self.nu2)
        if self.kind == "rolling":
            return _following(scales.rolling_scales, R, self.load, abs(self.speeds.mean or 0.0), E_prime, self.ratio)
        speed = self.speed or _following(bodies.drop_speed, self.drop_height)
        return _following(scales.impact_scales, R, self.ball_mass, speed, E_prime, self.ratio)

    @property
    def is_ball(self) -> bool:
        """Whether the bodies are balls, or a ball and a plane."""
        return self.radius is not None or self.radius_1 is not None

    @property
    def ratio(self) -> float:
        """R_x/R_y."""
        if not self.is_physical:
            return self.radius_ratio or 1.0
        R_x, R_y = radii.reduced(self)
        return 1.0 if isclose(R_x, R_y, rel_tol=ROUND_OFF) else R_x / R_y

    @property
    def angle(self) -> float:
        """From the axis x to the direction of entrainment, in degrees."""
        return self.entrainment_angle or 0.0

    @cached_property
    def geometry(self) -> Geometry:
        """The undeformed gap and the constants of the dry contact."""
        return geometry(self.ratio, self.angle)

    @property
    def ball_mass(self) -> float:
        """Mass of the ball (kg), zero if it is not given."""
        if not any(key in self.given for keys in BALL for key in keys):
            return 0.0
        self._only_one(BALL)
        return self.mass or _following(bodies.sphere_mass, self.radius or self.radius_1, self.ball_density)

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
        first, second = route = self._route()
        value = getattr(self, second)
        if oil.is_isoviscous and value:
            raise ValueError(f'{self.entry(second)}: must be 0 or left out with lubricant.viscosity = "isoviscous"')
        if not (oil.is_isoviscous and first in self.given):
            self._complete(route)
        make = Parameters.from_moes if route is MOES else Parameters
        return _following(make, getattr(self, first), value or 0.0, self.ratio)


def _following(law: Callable[..., T], *values: Any) -> T:
    """What follows by a law from values that are allowed one by one, but may be too far apart together."""
    try:
        return law(*values)
    except ArithmeticError as error:
        raise ValueError("contact: its values together are too large or too small; check their units") from error
    except ValueError as error:
        raise ValueError(f"contact: its values together give {error}; check their units") from error
