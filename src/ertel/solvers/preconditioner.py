"""Approximate inverses of the Jacobian: a V-cycle in single precision, with one of two smoothers.

* Steps in time have no derivative along X: a change at a node stays near it, and nodes are relaxed one by one.
* A steady film has the wedge U dm/dX: a change travels downstream, and all nodes of a line along X are solved together.

On the finest grid the V-cycle has the Jacobian itself, from `equations.linearised`.  Single precision is enough,
because the Krylov iteration keeps its residual in double precision (`newton.gcr`).
"""

from collections.abc import Callable
from functools import partial

import jax
import jax.numpy as jnp
from jax import Array, tree

from ertel.equations.flow import Rate
from ertel.equations.linearised import linear_film
from ertel.numerics import multigrid, newton, stencils
from ertel.numerics.line_smoother import line_smoother
from ertel.numerics.multigrid import DeformationOperator
from ertel.solvers.nonlinear import Problem

PRECISION = "float32"


def point_preconditioner(problem: Problem, P: Array, H: Array, free: Array) -> newton.Map:
    """V-cycle with the point smoother, for a rate without a wedge: every step in time."""
    return partial(
        multigrid.precondition, multigrid_levels(problem, P, H, free, problem.rate.new, multigrid.point_smoother)
    )


def line_preconditioner(problem: Problem, P: Array, H: Array, free: Array) -> newton.Map:
    """V-cycle with the line smoother along the direction of entrainment, for a film with a wedge."""
    drift = 0.0 if problem.rate.wedge is None else problem.rate.wedge
    smoother = partial(line_smoother, rate=problem.rate.new, drift=drift)
    return partial(multigrid.precondition, multigrid_levels(problem, P, H, free, 1.0, smoother))


def multigrid_levels(
    problem: Problem,
    P: Array,
    H: Array,
    free: Array,
    rate: Array | float,
    smoother: Callable[[DeformationOperator, multigrid.Coefficients], multigrid.Smoother],
) -> tuple[multigrid.GridLevel, ...]:
    """The V-cycle's grids for the Jacobian, on the finest grid the exact one.

    rate: of the mass, where the smoother adds none of its own.
    """
    precision, c = problem.elastic[0].spectrum.dtype, problem.contact
    film = linear_film(c, P, H).in_precision(precision)
    single = partial(jnp.asarray, dtype=precision)
    free = single(stencils.inside(free, c.even))
    rate, new, wedge = tree.map(single, (rate, problem.rate.new, problem.rate.wedge))
    zero, in_time = jnp.zeros_like(film.P), Rate(new, 0.0, wedge)
    # what does not depend on the change is computed once
    _, jacobian = jax.linearize(lambda e, Ke: film.residual(e, Ke, lambda m: in_time.of(m, film.spacing)), zero, zero)
    finest = multigrid.Coefficients(film.eps, rate * film.by_H.mass, rate * film.by_P.mass, free, film.steepening)
    return multigrid.hierarchy(problem.elastic, finest, smoother, jacobian)
