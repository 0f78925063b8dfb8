"""The contact of two gear teeth along the line of action: radii, speeds and load, as the motion of a case.

Spur gears with involute teeth and external meshing.  At a distance s from the pitch point, positive in the direction in
which the contact moves,

    R_1 = r_1 sin(phi) + s      u_1 = omega_1 R_1
    R_2 = r_2 sin(phi) - s      u_2 = omega_2 R_2

with the pitch radii r = m z/2, the pressure angle phi, and s = omega_1 r_b1 t + constant with the base radius
r_b = r cos(phi).  The surfaces roll without sliding at the pitch point.  A tooth is in contact between the two circles
of the tips.  The force along the line of action is torque/r_b1.

Source: Johnson KL. Contact Mechanics. Cambridge 1985; ISO 21771:2007 for the geometry.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from inspect import signature
from math import inf
from typing import Annotated, Any, ClassVar, TypeVar

import numpy as np

from ertel.physics import units
from ertel.physics.motion import Floats, Polyline
from ertel.physics.surfaces import smooth_step
from ertel.physics.units import Bounds, Mark, Meaning, Quantity, explained, fields_in_si, in_si

Record = TypeVar("Record")
Line = TypeVar("Line", bound=Polyline)
TEETH, SAMPLES = Bounds(ge=5, le=10_000, whole=True), 201
RAMP = 0.05  # of the base pitch, to both sides of the places where the number of teeth in contact changes


@dataclass(frozen=True)
class Passage:
    """A rolling contact whose radii, speeds and load change in time, in SI: of two teeth, or of a cam and its tappet.

    Parameters
    ----------
    time : array
        Times in s, rising from zero.
    radius_1, radius_2 : array
        Radii of curvature of the bodies along the direction of rolling (m); infinite: a plane.
    speed_1, speed_2 : array
        Speeds of the surfaces relative to the place of the contact (m/s).
    load : array
        Force on the contact (N).
    length : float
        Length of the contact across the direction of rolling (m).
    reference : int
        The moment at which the static load and the radii of the case are taken; its mean speed is the mean over time.
    crown_radius : float, optional
        Reduced radius across (m), of an elliptical contact; None for a line contact.
    """

    time: Floats
    radius_1: Floats
    radius_2: Floats
    speed_1: Floats
    speed_2: Floats
    load: Floats
    length: float
    reference: int
    crown_radius: float | None = None

    @property
    def radius(self) -> Floats:
        """The reduced radius along the direction of rolling (m)."""
        return 1.0 / (1.0 / self.radius_1 + 1.0 / self.radius_2)

    @property
    def mean_speed(self) -> Floats:
        """The mean speed of the surfaces (m/s)."""
        return (self.speed_1 + self.speed_2) / 2.0

    @property
    def sections(self) -> dict[str, dict[str, Any]]:
        """The sections of a case file that follow from it; [contact] without the elasticity."""
        at, mean = self.reference, float(np.abs(self.mean_speed).mean())
        sizes = {"radius_x_1": self.radius_1[at], "radius_x_2": self.radius_2[at], "length": self.length}
        if self.crown_radius is not None:
            sizes = {"radius_x": self.radius[at], "radius_y": self.crown_radius}
        contact = {key: Quantity(size, "m") for key, size in sizes.items() if size < inf}
        contact |= {"load": Quantity(self.load[at], "N"), "mean_speed": Quantity(mean, "m/s")}
        times = [str(Quantity(time, "s")) for time in self.time]
        values = {
            "load": self.load / self.load[at],
            "entrainment": self.mean_speed / mean,
            "sliding": (self.speed_1 - self.speed_2) / mean,
            "curvature": self.radius[at] / self.radius,
        }
        return {
            "contact": {"kind": "rolling"} | {key: str(size) for key, size in contact.items()},
            "motion": {key: {"smooth": [*zip(times, each.tolist(), strict=True)]} for key, each in values.items()},
            "solver": {"method": "transient"},
            "time": {"until": times[-1]},
        }

    @property
    def keywords(self) -> dict[str, Any]:
        """The keywords of `ertel.rolling` that follow from it; elasticity, oil and grid are still to be given."""
        contact, motion, solver, time = self.sections.values()
        return {**{key: value for key, value in contact.items() if key != "kind"}, "motion": motion, **solver, **time}


def points_of(kind: type[Line], points: Any) -> Line:
    """A polyline of a kind from its points in SI, or with texts with a unit."""
    found = []
    if not isinstance(points, Sequence | np.ndarray) or isinstance(points, str):
        raise ValueError(f"{kind.__name__.lower()} = {points!r:.60}: must be points [{', '.join(kind.NAMES)}]")
    for number, point in enumerate(points, 1):
        try:
            if isinstance(point, str) or len(point) != len(kind.MARKS):
                raise ValueError(f"must be [{', '.join(kind.NAMES)}]")
            found.append(tuple(map(in_si, point, kind.MARKS)))
        except (TypeError, ValueError) as error:
            raise ValueError(f"{kind.__name__.lower()}[{number}] = {point!r:.60}: {error}") from error
    return kind(tuple(found))  # type: ignore[arg-type]


# -- gears -------------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Sharing(Polyline):
    """The share of the load that a pair of teeth carries along its path of contact, from 0 to 1."""

    NAMES: ClassVar[tuple[str, str]] = ("place", "share")
    MARKS: ClassVar[tuple[Mark, Mark]] = (Bounds(ge=0, le=1), Bounds(gt=0, le=1))


@explained
@dataclass(frozen=True)
class Gear:
    """A pair of spur gears, in [motion]: radii, load and speeds of the contact follow from it."""

    teeth_1: Annotated[int, TEETH, Meaning("number of teeth of the driving gear", 20)]
    teeth_2: Annotated[int, TEETH, Meaning("number of teeth of the driven gear", 30)]
    module: Annotated[float, units.LENGTH, Meaning("module: diameter of the pitch circle over the number of teeth")]
    speed: Annotated[float, units.ROTATION, Meaning("speed of the driving gear")]
    torque: Annotated[float, units.TORQUE, Meaning("torque on the driving gear")]
    face_width: Annotated[float, units.LENGTH, Meaning("width of the teeth, the length of the contact", "20 mm")]
    pressure_angle: Annotated[float, units.ANGLE.between(5.0, 45.0), Meaning("pressure angle", "20 deg")] = 20.0
    addendum: Annotated[float, units.ABOVE_ZERO, Meaning("height of the teeth above the pitch circle, in modules")] = (
        1.0
    )
    sharing: Annotated[
        Sharing | None,
        Meaning(
            "share of the load along the path of contact, [[place, share], ...] with places from 0 to 1; left out: 1 "
            "where one pair of teeth is in contact, 1/2 where two are, with smooth ramps of a tenth of the base pitch",
            [[0, 0.4], [0.3, 1], [0.7, 1], [1, 0.4]],
        ),
    ] = None
    crown_radius: Annotated[
        float | None, units.LENGTH, Meaning("reduced radius across crowned teeth; left out: a line contact", "0.5 m")
    ] = None

    @property
    def passage(self) -> Passage:
        """The contact of two teeth from the first touch to the last; the reference is the pitch point.

        Raises ValueError for teeth that do not mesh, and for a contact ratio above two without the sharing of the load.
        """
        teeth, phi = np.array([self.teeth_1, self.teeth_2]), np.radians(self.pressure_angle)
        pitch = teeth * self.module / 2.0
        base, tip, middle = pitch * np.cos(phi), pitch + self.addendum * self.module, pitch * np.sin(phi)
        last, first = np.sqrt(tip**2 - base**2) - middle  # at the tips of gear 1 and of gear 2
        s = np.linspace(-first, last, SAMPLES)
        radii = middle[0] + s, middle[1] - s
        if min(radii[0][0], radii[1][-1]) <= 0.0:
            instead = "take more teeth, a smaller addendum or a larger pressure_angle"
            raise ValueError(f"teeth_1 = {self.teeth_1:g}: the path of contact reaches a base circle; {instead}")
        share = self._share((s - s[0]) / (first + last), (first + last) / (np.pi * self.module * np.cos(phi)))
        speeds = self.speed * radii[0], self.speed * teeth[0] / teeth[1] * radii[1]
        load, time = self.torque / base[0] * share, (s - s[0]) / (self.speed * base[0])
        at = int(np.argmin(np.abs(s)))
        return Passage(time, *radii, *speeds, load, self.face_width, at, self.crown_radius)

    def _share(self, place: Floats, contact_ratio: float) -> Floats:
        """The share of the load at places from 0 to 1 along the path of contact."""
        if self.sharing is not None:
            return self.sharing.at(place)
        if not 1.0 <= contact_ratio <= 2.0:
            raise ValueError(f"addendum: gives a contact ratio of {contact_ratio:.3g}; from 1 to 2, or give sharing")
        pitches = contact_ratio * np.stack([place, 1.0 - place]) - (contact_ratio - 1.0)  # since two pairs touched
        alone = smooth_step(pitches / (2.0 * RAMP) + 0.5)
        return np.asarray(0.5 + 0.5 * alone[0] * alone[1])


def involute(sharing: Any = None, **given: Any) -> Passage:
    """The contact of a pair of involute teeth from the first touch to the last.

    Parameters
    ----------
    sharing : sequence, optional
        Points (place, share) of the load along the path of contact.
    **given
        The other data of a `Gear`: numbers in SI (pressure_angle in degrees), or texts with a unit.

    Returns
    -------
    Passage
        Radii, speeds and load in time; its `keywords` are those of `ertel.rolling`.

    Raises
    ------
    ValueError
        A value is not allowed, or the teeth do not mesh.

    Examples
    --------
    >>> mesh = involute(teeth_1=20, teeth_2=20, module=4e-3, speed=157.0, torque=100.0, face_width=0.02)
    >>> round(1e3 * float(mesh.radius[mesh.reference]), 2)  # r sin(phi)/2
    6.84
    """
    points = None if sharing is None else points_of(Sharing, sharing)
    return Gear(**fields_in_si(Gear, {**given, "sharing": points})).passage


involute.__signature__ = signature(Gear)  # type: ignore[attr-defined]
