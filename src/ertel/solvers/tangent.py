"""The tangent-linear step: the response of a time step on the 2-D grid to a small change of the surfaces.

The step solves r(P, H(P, Delta), past) = 0 on the free nodes.  Its derivative is one linear system with the Jacobian of
the solved step, the exact one (automatic differentiation of `contact.residual`), and the same preconditioner.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial

import jax
import jax.numpy as jnp
from jax import Array
from jax.tree_util import register_dataclass

from ertel.case.status import Status
from ertel.equations import contact
from ertel.equations.approach import ClosureLine, NewtonsLaw
from ertel.equations.contact import Contact
from ertel.equations.flow import Flow, Rate, rate_in_time
from ertel.equations.state import State, Work
from ertel.numerics import bdf
from ertel.numerics.arrays import require_double
from ertel.numerics.bdf import Weights
from ertel.numerics.multigrid import Elasticity
from ertel.numerics.newton import gcr
from ertel.physics.motion import constant
from ertel.solvers import nonlinear
from ertel.solvers.nonlinear import Problem
from ertel.solvers.preconditioner import point_preconditioner
from ertel.solvers.transient import FALLING, Transient2D, stacked

REDUCTION, LIMIT = 1e-6, 40  # of the linear solve


@register_dataclass
@dataclass(frozen=True)
class TangentProblem:
    """The linear system of one step.

    fields: of the solved step.  past, change: fields of the levels before, newest first, and their changes, each of
    shape (1 or 2, n, n).  rates: weights of the time derivative.  flow: as in `StepProblem`.  shape: as in `advance`.
    """

    contact: Contact
    elastic: tuple[Elasticity, ...]
    fields: Mapping[str, Array]
    past: Mapping[str, Array]
    change: Mapping[str, Array]
    rates: Weights
    line: ClosureLine
    flow: Flow | None
    shape: Array


def start(shape: Array) -> State:
    """The change at T = 0: only the surfaces change, not the position of the ball."""
    return State(0.0, 0.0, 0.0, {"P": jnp.zeros_like(shape), "H": -shape})


def advance(method: Transient2D, smooth: Sequence[State], changes: Sequence[State], shape: Array) -> State:
    """The change of the newest level of `smooth`.

    smooth: the levels of the run, newest first.  changes: of the levels before, newest first, fields per unit of the
    parameter.  shape: height of the roughness per unit of the parameter at that time, shape (n, n), in a^2/R.
    Raises ValueError where the load is balanced without inertia.
    """
    require_double()
    motion, new = method.case.motion, smooth[0]
    if not motion.inertia > 0:
        raise ValueError(f"motion.inertia = {motion.inertia}: must be above zero for a tangent-linear run")
    times = [level.T for level in smooth[:3]]
    rates = bdf.derivative_weights(times)
    law = NewtonsLaw(motion.inertia, constant(0.0), method.geometry.hertz_load)  # the applied load does not change
    approaches = [level.approach for level in changes]
    line = law.line(new.T, rates, approaches, [level.velocity for level in changes])
    before = len(times) - 1
    problem = TangentProblem(
        method.contact_at(new.T),
        method.setting.elastic,
        new.fields,
        stacked(smooth[1 : before + 1]),
        stacked(changes[:before]),
        rates,
        line,
        method.flow(new.T, times[1:]),
        shape,
    )
    fields, approach, iterations = solve(problem)
    velocity = law.velocity(new.T, rates, float(approach), approaches)
    status = Status.CONVERGED if int(iterations) < LIMIT else Status.NEWTON_STALLED
    return State(new.T, float(approach), velocity, fields, status, Work(krylov=int(iterations)))


@jax.jit
def solve(p: TangentProblem) -> tuple[dict[str, Array], Array, Array]:
    """The changes of the fields and of the approach, and the number of Krylov iterations."""
    c, line, old, change = p.contact, p.line, p.past, p.change
    P, H = p.fields["P"], p.fields["H"]
    free = jnp.where(P > 0.0, 1.0, 0.0)
    _, mass_change = jax.jvp(partial(contact.mass, c), (old["P"], old["H"]), (change["P"], change["H"]))
    # the mass of the start does not change with the roughness
    flow = p.flow and p.flow._replace(start=jnp.zeros_like(P))
    new, past, _ = rate_in_time(p.rates, mass_change, flow, c.spacing)

    def residual(P: Array, H: Array, past: Array) -> Array:
        return contact.residual(c, P, H, Rate(new, past))

    _, change_of_r = jax.linearize(residual, P, H, jnp.zeros_like(P))
    problem = Problem(
        c, p.elastic, Rate(new, past), line, 1.0, 1.0, nonlinear.eliminated, point_preconditioner, FALLING
    )
    closed = nonlinear.eliminated(problem, P, 0.0)
    inverse = point_preconditioner(problem, P, H, free)
    known = -line.value / line.approach_weight - p.shape  # the part of dH that no pressure makes
    dP, iterations = gcr(
        lambda d: free * change_of_r(d, closed.film_change(d), jnp.zeros_like(d)),
        lambda k, r: inverse(r),
        -free * change_of_r(jnp.zeros_like(P), known, past),
        REDUCTION,
        LIMIT,
    )
    approach = (line.value - line.load_weight * contact.load(c, dP)) / line.approach_weight
    return {"P": dP, "H": closed.film_change(dP) + known}, approach, iterations
