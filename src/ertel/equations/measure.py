"""Key values of a solution on the plane: film thicknesses, pressures, load, and where the extremes lie."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array
from jax.tree_util import register_dataclass

from ertel.numerics.grid import Grid, Symmetry
from ertel.numerics.programs import ANY_SIZE, Program
from ertel.numerics.stencils import extended, total

TIE = 1e-6  # relative difference of two extremes that mirror each other


def measure(grid: Grid, P: Array, H: Array) -> dict[str, float]:
    """The key values of a film of shape `grid.shape`, dimensionless.

    H_c, P_c: at (0, 0).  H_min: the minimum where P > 0, at (X_min, Y_min).  P_max: at (X_P_max, Y_P_max); P_fall: how
    much lower the mean of the four next nodes is, as a share of it.  load: integral of P.  Of two extremes that mirror
    each other about an axis, the one on its positive side is named.
    """
    return named_numbers(grid, np.asarray(_numbers(Axes.of(grid), P, H)).tolist())


def named_numbers(grid: Grid, numbers: Sequence[float]) -> dict[str, float]:
    """The key values from `numbers`."""
    H_c, H_min, thin, P_c, P_max, high, fall, load = numbers
    X_min, Y_min = _place(grid, int(thin))
    X_P_max, Y_P_max = _place(grid, int(high))
    films = {"H_c": H_c, "H_min": H_min, "X_min": X_min, "Y_min": Y_min}
    peak = {"P_max": P_max, "X_P_max": X_P_max, "Y_P_max": Y_P_max, "P_fall": fall}
    return {**films, "P_c": P_c, **peak, "load": load * grid.spacing**2}


def _place(grid: Grid, index: int) -> tuple[float, float]:
    i, j = divmod(index, grid.shape[1])
    return float(grid.kept_x[j]), float(grid.kept_y[i])


@register_dataclass
@dataclass(frozen=True)
class Axes:
    """The kept nodes of a grid, y of shape (n_y, 1) and x of shape (n_x,), and the number of the node at the centre."""

    y: Array
    x: Array
    centre: int
    even: Symmetry = field(metadata={"static": True})

    @classmethod
    def of(cls, grid: Grid) -> "Axes":
        row, column = (int(np.abs(axis).argmin()) for axis in (grid.kept_y, grid.kept_x))
        y, x = jax.device_put((grid.kept_y[:, None], grid.kept_x))
        return cls(y, x, row * grid.shape[1] + column, grid.even)


def extreme_numbers(axes: Axes, P: Array, H: Array) -> Array:
    """The key values in one array, from which `named` makes them; traceable by JAX."""
    pressed = jnp.where((P > 0.0) | (P.max() <= 0.0), H, jnp.inf)
    H_min, P_max = pressed.min(), P.max()
    negative = TIE * ((axes.y < 0).astype(P.dtype) + (axes.x < 0))
    thin, high = jnp.argmin(pressed + jnp.abs(H_min) * negative), jnp.argmax(P - P_max * negative)
    p = extended(P, axes.even)
    around = (p[:-2, 1:-1] + p[2:, 1:-1] + p[1:-1, :-2] + p[1:-1, 2:]) / 4
    fall = jnp.where(P_max > 0, 1 - around.ravel()[high] / P_max, 0.0)
    H_c, P_c = H.ravel()[axes.centre], P.ravel()[axes.centre]
    found = H_c, H_min, thin, P_c, P_max, high, fall, total(P, axes.even)
    return jnp.stack([number.astype(P.dtype) for number in found])


_numbers = Program(jax.jit(extreme_numbers), ANY_SIZE)
