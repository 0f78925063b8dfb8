"""The time error of a film: how far it is from its prediction."""

import jax.numpy as jnp
from jax import Array

from ertel.numerics import multigrid
from ertel.numerics.grid import Symmetry
from ertel.numerics.stencils import total

THIN = 0.1  # of the film scale: below this the time error of a film is not taken relative to itself


def film_error(film: Array, predicted: Array, P: Array, thin: Array | float, even: Symmetry, coarsenings: int) -> Array:
    """Relative difference of two films, root mean square over the load that P carries; `thin`: see `THIN`.

    It is taken on a coarser grid: a pressure spike of a few cells that moves has an error at every node that it
    passes, which does not grow into the film and would make the number of steps that of the nodes.
    """
    for _ in range(coarsenings):
        film, predicted, P = (multigrid.restrict(field, even) for field in (film, predicted, P))
    relative = (film - predicted) / (jnp.abs(film) + thin)
    return jnp.sqrt(total(P * relative**2, even) / jnp.maximum(total(P, even), jnp.finfo(P.dtype).tiny))
