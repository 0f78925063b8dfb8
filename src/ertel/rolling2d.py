"""Steady rolling on the 2-D grid: `contact`'s residual without squeeze, the load balanced, coarse grid first."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple

import jax
import jax.numpy as jnp
from jax import Array

from ertel import contact, halfspace, lines, multigrid, newton
from ertel.closure import HERTZ_LOAD, ClosureLine
from ertel.contact import Contact, Rate
from ertel.grid import Grid
from ertel.multigrid import Elasticity

PRECONDITIONER_PRECISION = "float32"
SHIFT = 0.25  # rate of squeeze, over the spacing, in the preconditioner: small errors would grow downstream without


@partial(jax.jit, static_argnames="options")
def solve_level(
    c: Contact,
    elastic: tuple[Elasticity, ...],
    P: Array,
    approach: Array | float,
    load: Array | float,
    entrainment: Array | float,
    tolerance: float,
    shift: float = SHIFT,
    options: newton.Options = newton.Options(newton_limit=40, krylov_limit=30),
) -> newton.Solution:
    def residual(P: Array, H: Array) -> Array:
        return contact.residual(c, P, H, Rate(0.0, 0.0), entrainment)

    def film_change(dP: Array) -> Array:
        return halfspace.displacement(c.kernel, dP)

    def preconditioner(P: Array, H: Array, free: Array) -> newton.Map:
        return _preconditioner(c, elastic, P, H, free, entrainment, shift)

    def misfit(P: Array) -> Array:
        return contact.load(c, P) - load

    H = contact.film_thickness(c, P, approach)
    balance = newton.Border(approach, -1.0, misfit, 1.0 / c.spacing)
    return newton.solve(residual, film_change, preconditioner, P, H, tolerance, options, balance)


def _preconditioner(
    c: Contact,
    elastic: tuple[Elasticity, ...],
    P: Array,
    H: Array,
    free: Array,
    entrainment: Array | float,
    shift: float,
) -> newton.Map:
    density, slope = jax.jvp(c.lubricant.density, (P,), (jnp.ones_like(P),))
    precision = elastic[0].spectrum.dtype
    finest = multigrid.Coefficients(contact.mobility(c, P, H), density, slope * H, contact.inside(free))

    def downstream(f: Array) -> Array:
        return jnp.where(entrainment >= 0, f, f[:, ::-1])

    def smoother(e: Elasticity, c: multigrid.Coefficients) -> lines.Lines:
        speed = jnp.abs(entrainment)
        return lines.lines(e, c, shift * speed / e.spacing, speed)

    levels = multigrid.hierarchy(
        elastic, multigrid.Coefficients(*(downstream(f).astype(precision) for f in finest)), smoother
    )

    def precondition(r: Array) -> Array:
        size = jnp.maximum(jnp.linalg.norm(r), jnp.finfo(r.dtype).tiny)
        e = multigrid.v_cycle(levels, downstream(r / size).astype(precision))
        return downstream(e).astype(r.dtype) * size

    return precondition
