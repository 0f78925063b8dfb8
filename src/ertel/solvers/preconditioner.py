"""Approximate inverses of the Jacobian: a V-cycle in single precision, with one of two smoothers."""

from collections.abc import Callable
from functools import partial
from typing import Any

import jax
import jax.numpy as jnp
from jax import Array, tree

from ertel.equations import contact
from ertel.equations.contact import Contact
from ertel.equations.flow import Rate
from ertel.numerics import multigrid, newton, stencils
from ertel.numerics.line_smoother import line_smoother
from ertel.numerics.multigrid import Elasticity
from ertel.numerics.stencils import Pair
from ertel.solvers.nonlinear import Problem

PRECISION = "float32"


def point_preconditioner(problem: Problem, P: Array, H: Array, free: Array) -> newton.Map:
    """V-cycle with the point smoother, for a rate without a wedge: every step in time."""
    return partial(multigrid.precondition, levels(problem, P, H, free, problem.rate.new, multigrid.point_smoother))


def line_preconditioner(problem: Problem, P: Array, H: Array, free: Array) -> newton.Map:
    """V-cycle with the line smoother along the direction of entrainment, for a film with a wedge."""
    smoother = partial(line_smoother, rate=problem.rate.new, drift=_drift(problem))
    return partial(multigrid.precondition, levels(problem, P, H, free, 1.0, smoother))


def _drift(problem: Problem) -> Array | float:
    return 0.0 if problem.rate.wedge is None else problem.rate.wedge


def levels(
    problem: Problem,
    P: Array,
    H: Array,
    free: Array,
    rate: Array | float,
    smoother: Callable[[Elasticity, multigrid.Coefficients], multigrid.Smoother],
) -> tuple[multigrid.GridLevel, ...]:
    """The V-cycle's grids for the Jacobian, on the finest grid the exact one.

    rate: of the mass, where the smoother adds none of its own.
    """
    c, elastic = problem.contact, problem.elastic
    # in double precision: of a thick oil the viscosity is beyond single, its inverse and their derivatives are not
    mass, eps, by_P, by_H = _laws(c, P, H)
    # where the pressure is curved, as at the foot of a spike, the diagonal is larger by half, or more than doubled
    steepening = -0.5 * stencils.curvature(by_P[1], P, c.even) / c.spacing**2

    # linear in P and in eps: a change of P drives a flux by the tangent mobility, and the changes of the secant
    # mobility act on the gradient itself
    def balance(mass: Array, eps: Pair, P: Array) -> Array:
        return contact.balance(mass, eps, P, Rate(new, 0.0, wedge), spacing, c.even)

    def jacobian(e: Array, Ke: Array) -> Array:
        dmass, deps = tree.map(lambda p, h: p * e + h * Ke, by_P, by_H)
        return change(dmass, deps, e)

    single = partial(jnp.asarray, dtype=elastic[0].spectrum.dtype)
    fields = (mass, eps, by_P, by_H, P, steepening, stencils.inside(free, c.even))
    mass, eps, by_P, by_H, P, steepening, free = tree.map(single, fields)
    rate, new, wedge, spacing = tree.map(single, (rate, problem.rate.new, problem.rate.wedge, c.spacing))
    _, change = jax.linearize(balance, mass, eps, P)
    finest = multigrid.Coefficients(eps, rate * by_H[0], rate * by_P[0], free, steepening)
    return multigrid.hierarchy(elastic, finest, smoother, jacobian)


_Changes = tuple[Array, Pair]  # of the mass and of the mobility


def _laws(c: Contact, P: Array, H: Array) -> tuple[Array, Pair, _Changes, _Changes]:
    """The mass, the tangent mobility, and the derivatives of the mass and of the secant mobility by P and by H."""

    def laws(P: Array, H: Array) -> tuple[tuple[Array, Pair], Pair]:
        found = contact.mobilities(c, P, H)
        return (contact.mass(c, P, H), found.secant), found.tangent

    def change(dP: Array, dH: Array) -> Any:
        return jax.jvp(laws, (P, H), (dP, dH), has_aux=True)

    # both derivatives at once: they share most of the work
    one, zero = jnp.ones_like(P), jnp.zeros_like(P)
    both = jnp.stack([one, zero]), jnp.stack([zero, one])
    (mass, _), by, eps = jax.vmap(change, out_axes=(None, 0, None))(*both)
    by_P, by_H = (tree.map(lambda field, k=k: field[k], by) for k in range(2))
    return mass, eps, by_P, by_H
