"""Key values of a solution on the plane: film thicknesses, pressures, load, and where the extremes lie."""

from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from ertel.numerics.grid import Even, Grid
from ertel.numerics.precision import require_double
from ertel.numerics.symmetry import extended, total

TIE = 1e-6  # relative difference of two extremes that mirror each other


def measure(grid: Grid, P: Array, H: Array) -> dict[str, float]:
    """The key values of a film of shape `grid.shape`, dimensionless.

    H_c, P_c: at (0, 0).  H_min: the minimum where P > 0, at (X_min, Y_min).  P_max: at (X_P_max, Y_P_max); P_fall: how
    much lower the mean of the four next nodes is, as a share of it.  load: integral of P.  Of two extremes that mirror
    each other about an axis, the one on its positive side is named.
    """
    require_double()
    row, column = (int(np.abs(axis).argmin()) for axis in (grid.kept_y, grid.kept_x))
    found = _measure(P, H, grid.kept_y, grid.kept_x, row, column, grid.even)
    H_c, H_min, thin, P_c, P_max, high, fall, load = np.asarray(found).tolist()
    X_min, Y_min = _place(grid, int(thin))
    X_P_max, Y_P_max = _place(grid, int(high))
    films = {"H_c": H_c, "H_min": H_min, "X_min": X_min, "Y_min": Y_min}
    peak = {"P_max": P_max, "X_P_max": X_P_max, "Y_P_max": Y_P_max, "P_fall": fall}
    return {**films, "P_c": P_c, **peak, "load": load * grid.spacing**2}


def _place(grid: Grid, index: int) -> tuple[float, float]:
    i, j = divmod(index, grid.shape[1])
    return float(grid.kept_x[j]), float(grid.kept_y[i])


@partial(jax.jit, static_argnames="even")
def _measure(P: Array, H: Array, y: Array, x: Array, row: int, column: int, even: Even) -> Array:
    pressed = jnp.where((P > 0.0) | (P.max() <= 0.0), H, jnp.inf)
    H_min, P_max = pressed.min(), P.max()
    negative = TIE * ((y < 0)[:, None].astype(P.dtype) + (x < 0))
    thin, high = jnp.argmin(pressed + jnp.abs(H_min) * negative), jnp.argmax(P - P_max * negative)
    p = extended(P, even)
    around = (p[:-2, 1:-1] + p[2:, 1:-1] + p[1:-1, :-2] + p[1:-1, 2:]) / 4
    fall = jnp.where(P_max > 0, 1 - around.ravel()[high] / P_max, 0.0)
    places = (place.astype(P.dtype) for place in (thin, high))
    return jnp.stack([H[row, column], H_min, next(places), P[row, column], P_max, next(places), fall, total(P, even)])
