"""Key values of a solution on the plane: film thicknesses, pressures, load, position of the minimum film thickness."""

from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from ertel.numerics.grid import Even, Grid
from ertel.numerics.symmetry import total


def measure(grid: Grid, P: Array, H: Array) -> dict[str, float]:
    """H_c and P_c at (0, 0), P_max, H_min (the minimum where P > 0) and its position, load = integral of P."""
    row, column = (int(np.abs(axis).argmin()) for axis in (grid.kept_y, grid.kept_x))
    H_c, P_c, P_max, load, H_min, where = (float(v) for v in _measure(P, H, row, column, grid.even))
    i, j = divmod(int(where), grid.shape[1])
    films = {"H_c": H_c, "H_min": H_min, "X_min": float(grid.kept_x[j]), "Y_min": abs(float(grid.kept_y[i]))}
    return {**films, "P_c": P_c, "P_max": P_max, "load": load * grid.spacing**2}


@partial(jax.jit, static_argnames="even")
def _measure(P: Array, H: Array, row: int, column: int, even: Even) -> Array:
    pressed = jnp.where((P > 0.0) | (P.max() <= 0.0), H, jnp.inf)
    least = jnp.argmin(pressed)
    return jnp.stack([H[row, column], P[row, column], P.max(), total(P, even), pressed.min(), least.astype(P.dtype)])
