"""The tangent-linear step: how a time step on the 2-D grid answers a small change of the surfaces.

The step solves r(P, H(P, Delta), past) = 0 on the free nodes.  Its derivative is one linear system with the Jacobian of
the solved step, the exact one (automatic differentiation of `contact.residual`), and the same preconditioner.
"""

from collections.abc import Sequence
from functools import partial

import jax
import jax.numpy as jnp
from jax import Array

from ertel.model import contact
from ertel.model.approach import ClosureLine, NewtonsLaw
from ertel.model.contact import Contact, Rate
from ertel.model.state import Level
from ertel.numerics import bdf, newton
from ertel.numerics.multigrid import Elasticity
from ertel.physics.motion import constant
from ertel.solvers import nonlinear
from ertel.solvers.nonlinear import Preconditioner, Problem
from ertel.solvers.transient import Transient2D

REDUCTION, LIMIT = 1e-6, 40  # of the linear solve


def start(shape: Array) -> Level:
    """The change at T = 0: the surfaces as they differ, the ball where it was."""
    return Level(0.0, 0.0, 0.0, jnp.zeros_like(shape), -shape)


def advance(method: Transient2D, smooth: Sequence[Level], changes: Sequence[Level], shape: Array) -> tuple[Level, int]:
    """The change of the newest level of `smooth`, and the Krylov iterations it took.

    smooth: the levels of the run, newest first.  changes: of the levels before, newest first, fields per unit of the
    parameter.  shape: height of the roughness per unit of the parameter at that time, shape (n, n), in a^2/R.
    Raises ValueError where the load is balanced without inertia.
    """
    motion, new = method.case.motion, smooth[0]
    if not motion.inertia > 0:
        raise ValueError(f"motion.inertia = {motion.inertia}: must be above zero for a tangent-linear run")
    times = [level.T for level in smooth[:3]]
    rates = bdf.derivative_weights(times)
    law = NewtonsLaw(motion.inertia, constant(0.0))  # the applied load does not change
    approaches = [level.approach for level in changes]
    line = law.line(new.T, rates, approaches, [level.velocity for level in changes])
    before = len(times) - 1
    dP, dH, approach, krylov = _advance(
        method.contact,
        method.elastic,
        new,
        *(jnp.stack([getattr(level, name) for level in smooth[1 : before + 1]]) for name in ("P", "H")),
        *(jnp.stack([getattr(level, name) for level in changes[:before]]) for name in ("P", "H")),
        rates,
        line,
        motion.entrainment(new.T),
        shape,
        preconditioner=method.preconditioner,
    )
    velocity = law.velocity(new.T, rates, float(approach), approaches)
    return Level(new.T, float(approach), velocity, dP, dH), int(krylov)


@partial(jax.jit, static_argnames="preconditioner")
def _advance(
    c: Contact,
    elastic: tuple[Elasticity, ...],
    new: Level,
    P_old: Array,
    H_old: Array,
    dP_old: Array,
    dH_old: Array,
    rates: Array,
    line: ClosureLine,
    entrainment: float,
    shape: Array,
    *,
    preconditioner: Preconditioner,
) -> tuple[Array, Array, Array, Array]:
    turned = partial(nonlinear.along_the_flow, entrainment)
    P, H, P_old, H_old, dP_old, dH_old, shape = map(turned, (new.P, new.H, P_old, H_old, dP_old, dH_old, shape))
    U = jnp.abs(entrainment)
    free = jnp.where(P > 0.0, 1.0, 0.0)
    _, mass_change = jax.jvp(partial(contact.mass, c), (P_old, H_old), (dP_old, dH_old))
    past = jnp.tensordot(rates[1:], mass_change, axes=1)

    def residual(P: Array, H: Array, past: Array) -> Array:
        return contact.residual(c, P, H, Rate(rates[0], past), U)

    _, change_of_r = jax.linearize(residual, P, H, jnp.zeros_like(P))
    problem = Problem(Rate(rates[0], 0.0), U, line, 1.0, 1.0)
    closed = nonlinear.eliminated(c, problem, P, 0.0)
    inverse = preconditioner(c, elastic, P, H, free, problem)
    known = -line.value / line.approach_weight - shape  # the part of dH that no pressure makes
    (dP, krylov) = newton.gcr(
        lambda d: free * change_of_r(d, closed.film_change(d), jnp.zeros_like(d)),
        lambda k, r: inverse(r),
        -free * change_of_r(jnp.zeros_like(P), known, past),
        REDUCTION,
        LIMIT,
    )
    approach = (line.value - line.load_weight * contact.load(c, dP)) / line.approach_weight
    return turned(dP), turned(closed.film_change(dP) + known), approach, krylov
