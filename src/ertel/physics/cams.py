"""The contact of a cam and its flat-faced follower: radius, speeds and load, as the motion of a case.

The lift y is a function of the angle theta of the cam, y' and y'' are its derivatives, r_0 is the radius of the base
circle and omega the speed of the cam.  The contact lies y' beside the axis of the follower.  The normal of a flat face
keeps its direction, so that the surface of the cam passes the contact with omega times its radius of curvature:

    R = r_0 + y + y''      u_1 = omega R      u_2 = omega y''      u_1 - u_2 = omega (r_0 + y)

The mean speed omega (r_0 + y + 2 y'')/2 changes its sign on both flanks of the nose, where y'' is negative.

Source: Dowson D, Harrison P, Taylor CM. The lubrication of automotive cams and followers. Leeds-Lyon Symp 1985:305.
"""

from dataclasses import dataclass
from inspect import signature
from typing import Annotated, Any, ClassVar

import numpy as np

from ertel.physics import units
from ertel.physics.gears import Passage, points_of
from ertel.physics.motion import Polyline
from ertel.physics.units import Mark, Meaning, Unit, explained, fields_in_si

LIFT = Unit("m", "5 mm", signed=True)
FEWEST, SAMPLES = 6, 401  # points of a table of lift, and of the signals


@dataclass(frozen=True)
class Lift(Polyline):
    """The lift of a follower over the angle of the cam."""

    NAMES: ClassVar[tuple[str, str]] = ("angle", "lift")
    MARKS: ClassVar[tuple[Mark, Mark]] = (units.ANGLE, LIFT)


@explained
@dataclass(frozen=True)
class Cam:
    """A cam with a flat-faced follower, in [motion]: radii, load and speeds of the contact follow from it."""

    lift: Annotated[
        Lift,
        Meaning(
            "lift over the angle of the cam, [[angle, lift], ...], six points or more with enough digits, because the "
            "curvature is their second derivative; a spline of the fifth order passes through them",
            [["-60 deg", "0 mm"], ["0 deg", "8 mm"], ["60 deg", "0 mm"]],
        ),
    ]
    base_radius: Annotated[float, units.LENGTH, Meaning("radius of the base circle", "18 mm")]
    speed: Annotated[float, units.ROTATION, Meaning("speed of the cam")]
    width: Annotated[float, units.LENGTH, Meaning("width of the cam, the length of the contact", "14 mm")]
    preload: Annotated[float, units.LOAD, Meaning("force of the spring at zero lift; the whole load without stiffness")]
    stiffness: Annotated[float | None, units.STIFFNESS, Meaning("stiffness of the spring; left out: 0")] = None
    mass: Annotated[float | None, units.MASS, Meaning("mass that moves with the follower; left out: 0")] = None
    crown_radius: Annotated[
        float | None, units.LENGTH, Meaning("reduced radius across a crowned cam; left out: a line contact", "0.5 m")
    ] = None

    @property
    def passage(self) -> Passage:
        """The contact from the first angle of the table to the last; the reference is the moment of the highest lift.

        Raises ValueError for a table that is too short, a cam that is concave or pointed (R <= 0), and a follower that
        leaves the cam.
        """
        from scipy.interpolate import make_interp_spline

        angle, height = np.array(self.lift.points, dtype=float).T
        if len(angle) < FEWEST:
            raise ValueError(f"lift: has {len(angle)} points; must be {FEWEST} or more")
        theta = np.radians(np.linspace(angle[0], angle[-1], SAMPLES))
        spline = make_interp_spline(np.radians(angle), height, k=5)
        y, y_2, omega = spline(theta), spline(theta, 2), self.speed
        radius = self.base_radius + y + y_2
        load = self.preload + (self.stiffness or 0.0) * y + (self.mass or 0.0) * omega**2 * y_2
        for name, values in {"base_radius: R": radius, "preload: the load": load}.items():
            if not values.min() > 0.0:
                where = f"at {np.degrees(theta[np.argmin(values)]):.3g} deg"
                raise ValueError(f"{name} falls to {values.min():.3g} {where}; must be above zero")
        speeds, time, at = (omega * radius, omega * y_2), (theta - theta[0]) / omega, int(np.argmax(y))
        return Passage(time, radius, np.full_like(y, np.inf), *speeds, load, self.width, at, self.crown_radius)


def flat_tappet(lift: Any, **given: Any) -> Passage:
    """The contact of a cam and a flat-faced follower from the first angle of a table of lift to the last.

    Parameters
    ----------
    lift : sequence
        Points (angle, lift) with rising angles: numbers in degrees and m, or texts with a unit.
    **given
        The other data of a `Cam`: numbers in SI, or texts with a unit.

    Returns
    -------
    Passage
        As of `ertel.gears.involute`.

    Raises
    ------
    ValueError
        A value is not allowed, the cam is concave or pointed somewhere, or the follower leaves the cam.

    Examples
    --------
    >>> eccentric = [(angle, 0.005 * (1 - np.cos(np.radians(angle)))) for angle in range(-90, 91, 5)]
    >>> cam = flat_tappet(lift=eccentric, base_radius=0.02, speed=100.0, width=0.014, preload=200.0)
    >>> bool(np.allclose(cam.radius, 0.025))  # a circle of 25 mm
    True
    """
    return Cam(**fields_in_si(Cam, {**given, "lift": points_of(Lift, lift)})).passage


flat_tappet.__signature__ = signature(Cam)  # type: ignore[attr-defined]
