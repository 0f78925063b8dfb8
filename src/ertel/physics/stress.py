"""Stresses in an elastic half space under pressure and shear stress on its surface, wave by wave.

The body lies at z > 0, with x and y along its surface.  The surface carries a pressure p and a shear stress (q_x, q_y),
the force per area on this body.  Stresses are positive in tension, the pressure in compression.  Under loads that are
waves exp(i (k_x x + k_y y)) all stresses are such waves, and fall as exp(-kz) with k = |(k_x, k_y)|.  Let c = k_x/k and
s = k_y/k, let p, q_x, q_y stand for the loads times exp(-kz), q_l = c q_x + s q_y for the shear stress along the wave,
q_t = c q_y - s q_x for that across it, and w for p - i q_l:

    xx = -(c^2 (1 - kz) + 2 nu s^2) w + i c^2 q_l - 2 i c s q_t        zz = -p - kz w
    yy = -(s^2 (1 - kz) + 2 nu c^2) w + i s^2 q_l + 2 i c s q_t        xz = -q_x + i c kz w
    xy = -c s (1 - 2 nu - kz) w + i c s q_l + i (c^2 - s^2) q_t        yz = -q_y + i s kz w

They are in equilibrium, compatible, have zz = -p and (xz, yz) = -q at z = 0, and vanish far below.  The mean of a load
on a plane has no direction: c^2 and s^2 are 1/2 there, their mean over all directions, and c = s = 0.  A line load has
k_y = 0, so c^2 = 1 and yy = nu (xx + zz), plane strain.

Sources: Johnson KL. Contact Mechanics. Cambridge 1985, sections 2.2 and 3.2 (the stresses by forces, of which these
are the Fourier transforms).  The method: Liu SB, Wang Q. J Tribol 2002;124:36-45.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[Any]


class Stresses(NamedTuple):
    """The six components of the stress, in the unit of the loads; tension is positive."""

    xx: Array
    yy: Array
    zz: Array
    xy: Array
    xz: Array
    yz: Array


def stress_waves(k: tuple[Array, Array], depth: float, p: Array, q_x: ArrayLike, q_y: ArrayLike, nu: float) -> Stresses:
    """The amplitudes of the stresses at a depth, from those of the loads at the surface.

    k: wave numbers along x and y that broadcast, over the unit of the depth.  One row, k_y of shape (1, 1), is a line
    load.  nu: Poisson's ratio.
    """
    k_x, k_y = k
    length = np.hypot(k_x, k_y)
    c, s = (each / np.where(length > 0.0, length, 1.0) for each in k)
    cc, cs = np.where(length > 0.0, c * c, 1.0 if k_y.size == 1 else 0.5), c * s
    ss, kz = 1.0 - cc, length * depth
    fall = np.exp(-kz)
    p, q_x, q_y = (fall * each for each in (p, q_x, q_y))
    along, across = 1j * (c * q_x + s * q_y), 1j * (c * q_y - s * q_x)
    w = p - along
    return Stresses(
        xx=cc * along - (cc * (1.0 - kz) + 2.0 * nu * ss) * w - 2.0 * cs * across,
        yy=ss * along - (ss * (1.0 - kz) + 2.0 * nu * cc) * w + 2.0 * cs * across,
        zz=-p - kz * w,
        xy=cs * along - cs * (1.0 - 2.0 * nu - kz) * w + (cc - ss) * across,
        xz=1j * c * kz * w - q_x,
        yz=1j * s * kz * w - q_y,
    )


def von_mises(stress: Stresses) -> Array:
    """The von Mises stress, sqrt(3 J_2)."""
    return np.sqrt(3.0 * _second_invariant(stress))


def tresca(stress: Stresses) -> Array:
    """The largest shear stress of all planes, half the difference of the largest and the smallest principal stress.

    It is sqrt(J_2) sin(theta + pi/3) with Lode's angle, cos(3 theta) = (3 sqrt(3)/2) J_3/J_2^(3/2), from 0 to pi/3.
    """
    x, y, z, xy, xz, yz = _less_mean(stress)
    J_2 = _second_invariant(stress)
    J_3 = x * (y * z - yz * yz) - xy * (xy * z - yz * xz) + xz * (xy * yz - y * xz)
    cosine = 1.5 * np.sqrt(3.0) * J_3 / np.maximum(J_2**1.5, np.finfo(float).tiny)
    theta = np.arccos(np.clip(cosine, -1.0, 1.0)) / 3.0
    return np.sqrt(J_2) * np.sin(theta + np.pi / 3.0)


def _less_mean(stress: Stresses) -> Stresses:
    mean = (stress.xx + stress.yy + stress.zz) / 3.0
    return stress._replace(xx=stress.xx - mean, yy=stress.yy - mean, zz=stress.zz - mean)


def _second_invariant(stress: Stresses) -> Array:
    x, y, z, xy, xz, yz = _less_mean(stress)
    return (x * x + y * y + z * z) / 2.0 + xy * xy + xz * xz + yz * yz
