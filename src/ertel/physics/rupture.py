"""The oil film far from a rolling contact: where it ruptures behind the contact, and how this changes its pressure.

Far out the gap is H = r^2 g(t) + C with the angle t around the contact, and P = lambda_bar f/H^2 with

    f = V/(2 (1 + D)) - U (c x/(3 + 2 D) + s D y/(2 + 3 D))

solves Reynolds' equation of a gap that is full all around (`Geometry.far_flow`).  Behind the contact f is negative; the
oil ruptures there, along rays on which P = dP/dn = 0.  With F = P r^3/lambda_bar the pressure in front of these rays is

    F = f/(r g^2) + F_0,   (g^3 F_0')' - 9 g^3 F_0 = 0,

the solution of a complementarity problem, F >= 0.  It depends on V/(U r), which changes slowly with r and is taken as a
constant.  The constant C adds k F_1 with k = C/r^2,

    (g^3 F_1')' - 5 g^3 F_1 = -3 ((g^2 F_0')' - 3 g^2 F_0).

In rolling in time V changes, but a cavity does not fill or empty at once, and a film that ends elsewhere outside the
grid would make oil or lose it.  So the rays stay where V = 0 puts them, and a small V adds V F_V/r to F,

    (g^3 F_V')' - 8 g^3 F_V = -1,   F_V = 0 on the rays.

This is the derivative of the solution of the complementarity problem by V at V = 0: the pressure of the film that the
rays would sweep is of second order.

For a circle and V = 0 the rays lie 18.4 degrees downstream of the middle, tan(t_c) = -3 tanh(3 t_c) from the direction
upstream, and F_0 = (4/5) U A cosh(3 t) with A = 0.002164.
"""

from functools import lru_cache
from math import pi
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_banded

Floats = NDArray[np.float64]
ANGLES = 720  # around the contact
COARSEST = 45  # angles on which the wet region is found first
SPEEDS = np.linspace(-1.25, 1.0, 37)  # of V/(U r), over that with which the gap is just full; zero is one of them
LIMIT = 50  # of iterations of the wet region; some ten are needed


class Rupture(NamedTuple):
    """Corrections of f/(U r) by the rupture, on a table of V/(U r) and of the angle, both in equal steps.

    first, in_k: F_0 g^2 and the factor of k in F g^2, shape (speeds, angles + 1).  full: V/(U r) from which the gap is
    full all around.  in_V: F_V g^2 where V = 0 puts the rays, shape (angles + 1,).
    """

    full: float
    first: Floats
    in_k: Floats
    in_V: Floats

    def correction(self, ratio: Floats, angle: Floats, k: Floats) -> Floats:
        """Return what is added to f/(U r); ratio: V/(U r), angle: from the axis x, k: C/r^2; arrays of one shape."""
        spread = SPEEDS[1] - SPEEDS[0]
        i, u = _place((np.clip(ratio / self.full, SPEEDS[0], SPEEDS[-1]) - SPEEDS[0]) / spread, len(SPEEDS) - 1)
        j, v = _place(angle % (2 * pi) / (2 * pi) * ANGLES, ANGLES)

        def between(table: Floats) -> Floats:
            low, high = ((1 - v) * table[row, j] + v * table[row, j + 1] for row in (i, i + 1))
            return (1 - u) * low + u * high

        return np.where(ratio < self.full, between(self.first) + k * between(self.in_k), 0.0)

    def squeezed(self, flow: Floats, velocity: Floats, angle: Floats) -> Floats:
        """The flow f >= 0 of V = 0 with a small V, to first order; above zero in the same places."""
        change = velocity * np.interp(angle % (2 * pi), np.linspace(0.0, 2 * pi, ANGLES + 1), self.in_V)
        return flow + np.where(change < 0.0, change * flow / (flow - np.minimum(change, 0.0) + 1e-300), change)


def _place(position: Floats, cells: int) -> tuple[NDArray[np.int64], Floats]:
    """The cell of a table and the place in it, from 0 to 1."""
    cell = np.minimum(position.astype(int), cells - 1)
    return cell, position - cell


@lru_cache
def rupture(radius_ratio: float, c: float, s: float) -> Rupture:
    """The table for D = R_x/R_y and a direction of entrainment with cosine c and sine s from the axis x."""
    D, t = radius_ratio, 2 * pi / ANGLES * np.arange(ANGLES)
    g = (np.cos(t) ** 2 + D * np.sin(t) ** 2) / 2
    wedge = c * np.cos(t) / (3 + 2 * D) + s * D * np.sin(t) / (2 + 3 * D)
    full = 2 * (1 + D) * float(np.max(wedge))
    sets = [_corrections(g, ratio * full / (2 * (1 + D)) - wedge) for ratio in SPEEDS]
    first, in_k, in_V = (np.append(table, table[:, :1], axis=1) for table in map(np.stack, zip(*sets, strict=True)))
    return Rupture(full, first, in_k, in_V[np.searchsorted(SPEEDS, 0.0)])


def _corrections(g: Floats, f: Floats) -> tuple[Floats, Floats, Floats]:
    """F_0 g^2, the factor of k and F_V g^2, at all angles; f: over U r."""
    if f.min() >= 0.0:
        return 0.0 * f, 0.0 * f, 0.0 * f
    turn = -int(np.argmin(f / g**2))  # a dry ray comes first
    g, f = np.roll(g, turn), np.roll(f, turn)
    F, wet = _pressure(g, f)
    F_0 = F - f / g**2
    by_C = 3.0 * _product(_bands(g**2, 3.0), F_0)
    F_1 = _solve(_bands(g**3, 5.0), -by_C, np.where(wet, 0.0, 2 * f / g**3), wet)
    in_k = np.where(wet, g**2 * F_1 + 2 * g * F_0, 0.0)
    in_V = g**2 * _solve(_bands(g**3, 8.0), np.ones_like(f), np.zeros_like(f), wet)
    return np.roll(F_0 * g**2, -turn), np.roll(in_k, -turn), np.roll(in_V, -turn)


def _pressure(g: Floats, f: Floats) -> tuple[Floats, NDArray[np.bool_]]:
    """F, and where it is positive; first on every fourth angle, because the wet region moves by an angle at a time."""
    wet = np.repeat(_pressure(g[::4], f[::4])[1], 4) if len(g) > COARSEST else f > 0.0
    stiff, full = _bands(g**3, 9.0), f / g**2
    source = _product(stiff, full)  # the gap that is full all around solves this exactly
    for _ in range(LIMIT):
        wet[0] = False
        F = _solve(stiff, source, np.zeros_like(f), wet)
        before, wet = wet, np.where(wet, F > 0.0, _product(stiff, F) < source)
        if np.array_equal(before, wet):
            break
    return F, before


def _bands(weight: Floats, decay: float) -> Floats:
    """-(w F')' + decay w F by central differences around the circle, as three bands of a matrix."""
    after = (weight + np.roll(weight, -1)) / 2 * (len(weight) / (2 * pi)) ** 2
    before = np.roll(after, 1)
    return np.stack([-before, before + after + decay * weight, -after])


def _product(bands: Floats, F: Floats) -> Floats:
    before, middle, after = bands
    return before * np.roll(F, 1) + middle * F + after * np.roll(F, -1)


def _solve(bands: Floats, source: Floats, known: Floats, wet: NDArray[np.bool_]) -> Floats:
    """F in the wet region, with the known values elsewhere; the first node is dry."""
    before, middle, after = np.where(wet, bands, np.array([[0.0], [1.0], [0.0]]))
    matrix = np.stack([np.roll(after, 1), middle, np.roll(before, -1)])
    right = np.where(wet, source, known)
    right[-1] -= after[-1] * right[0]
    return np.asarray(solve_banded((1, 1), matrix, right))
