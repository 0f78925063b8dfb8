"""The radii of curvature of the two bodies: the ways to give them, and the reduced radii along x and y."""

from math import inf
from typing import Protocol

from ertel.physics import materials
from ertel.physics.geometry import LARGEST_RATIO, LEAST_RATIO
from ertel.physics.units import Bounds

Keys = tuple[str, ...]
ALONG_X, ALONG_Y = ("radius_x_1", "radius_x_2"), ("radius_y_1", "radius_y_2")
PAIRS: Keys = (*ALONG_X, *ALONG_Y)  # a radius that is left out is that of a plane
WAYS: tuple[Keys, ...] = (("radius",), ("radius_1", "radius_2"), ("radius_x", "radius_y"), PAIRS)
TEXT = "radius (or radius_1 and radius_2; radius_x and radius_y; radius_x_1, radius_y_1, radius_x_2, radius_y_2)"
RATIO = Bounds(ge=LEAST_RATIO, le=LARGEST_RATIO)


class Given(Protocol):
    """Operating conditions with radii in m; what is not given is None."""

    @property
    def given(self) -> Keys: ...

    @property
    def is_ball(self) -> bool: ...

    def entry(self, key: str) -> str: ...


def reduced(contact: Given) -> tuple[float, float]:
    """The reduced radii (m) of a physical contact along x and along y."""
    if contact.is_ball:
        R = materials.reduced_radius(
            _of(contact, "radius") or _of(contact, "radius_1"), _of(contact, "radius_2") or inf
        )
        return R, R
    if "radius_x" in contact.given:
        return _of(contact, "radius_x"), _of(contact, "radius_y")
    return _of_pair(contact, ALONG_X), _of_pair(contact, ALONG_Y)


def _of_pair(contact: Given, keys: Keys) -> float:
    first, second = (_of(contact, key) or inf for key in keys)
    return materials.conforming_radius(first, second)


def _of(contact: Given, key: str) -> float:
    """A radius; zero if it is not given."""
    return getattr(contact, key) or 0.0


def check(contact: Given) -> None:
    """Raise ValueError unless the bodies touch at a point, in an ellipse that is not too long."""
    for keys in (ALONG_X, ALONG_Y) if any(key in contact.given for key in PAIRS) else ():
        _check_pair(contact, keys)
    R_x, R_y = reduced(contact)
    if not LEAST_RATIO <= R_x / R_y <= LARGEST_RATIO:
        raise ValueError(
            f"contact: the reduced radii {R_x:g} m along x and {R_y:g} m along y have the ratio {R_x / R_y:g}; "
            "allowed: from 1/100 to 100"
        )
    if not contact.is_ball and "ball_density" in contact.given:
        raise ValueError(f"{contact.entry('ball_density')}: the moving body is not a ball; give contact.mass")


def _check_pair(contact: Given, keys: Keys) -> None:
    """The curvatures of both bodies must add up to more than zero."""
    zero = next((key for key in keys if key in contact.given and _of(contact, key) == 0), None)
    if zero:
        raise ValueError(f"{contact.entry(zero)}: must not be zero; leave it out for a plane")
    if 0 < _of_pair(contact, keys) < inf:
        return
    given = " and ".join(contact.entry(key) for key in keys if key in contact.given)
    raise ValueError(
        f"{given or f'contact.{keys[0]}: missing'}: the curvatures 1/{keys[0]} + 1/{keys[1]} must add up to more than "
        "zero, otherwise the bodies do not form a point contact"
    )
