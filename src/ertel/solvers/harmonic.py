"""The response of a steady rolling contact to waves that pass through it: one complex system in place of time steps.

Roughness r = Re[shape exp(i omega T)] of small height changes P, H and Delta by Re[P' exp(i omega T)] and so on:

    D m' - div(eps' grad P + eps grad P') = 0     where P > 0, elsewhere P' = 0
    H' = - Delta' + K P' - shape
    - omega^2 inertia Delta' + F' = 0

Where the film ends, P and its gradient vanish, so that a small motion of its end has no effect of first order.
D m = dm/dT + U dm/dX is that of backward differences along the flow (`flow`) with steps of one cell, U dT = h:

    D m = U (3 m(X) - 4 q m(X - h) + q^2 m(X - 2 h))/(2 h),    q = exp(- i omega h/U)

This is the upstream slope of m without the phase of waves that ride with the oil, so these are carried without loss.
Time steps of this length lead to the same film once it is periodic; at omega = 0 D is the wedge of the steady film.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
from jax import Array, tree
from jax.tree_util import register_dataclass

from ertel.case.case import Case
from ertel.equations import contact, discretise
from ertel.equations.approach import ClosureLine, balanced
from ertel.equations.contact import Contact
from ertel.equations.flow import Rate, steady_rate
from ertel.numerics import multigrid
from ertel.numerics.arrays import require_double
from ertel.numerics.grid import Symmetry
from ertel.numerics.line_smoother import LineSmoother, line_smoother
from ertel.numerics.multigrid import Coefficients, Elasticity
from ertel.numerics.newton import gcr
from ertel.numerics.stencils import Pair, curvature, inside, upstream_slope
from ertel.solvers import nonlinear
from ertel.solvers.preconditioner import PRECISION
from ertel.solvers.steady import GridSolution

NODES_PER_WAVE = 4  # a coarse grid that has fewer is for long waves alone
REDUCTION, LIMIT = 1e-6, 60  # of the linear solve, which mostly takes 13 to 20 iterations; each keeps two fields

Number = Array | float


class Wave(NamedTuple):
    """Roughness Re[shape exp(i frequency T)]; frequency >= 0 in 1/t0, shape in a^2/R, complex, of the grid's shape."""

    frequency: float
    shape: Array


class Response(NamedTuple):
    """P', H' (complex, of the grid's shape) and Delta'; whether the solve converged; its iterations and convolutions.

    A convolution of a complex field counts as two.
    """

    P: Array
    H: Array
    approach: complex
    converged: bool
    krylov: int
    convolutions: float


class Change(NamedTuple):
    """The change of the mass and of the mobility with P or H."""

    mass: Array
    eps: Pair


@register_dataclass
@dataclass(frozen=True)
class LinearFilm:
    """Reynolds' equation, linearised about a steady film, for changes that oscillate in time.

    The mobility is that of the nodes.  For a Newtonian oil this is exact; one that thins has more, see `_exact`.
    eps: for a change of the gradient.  by_P, by_H: derivatives of mass and mobility.  free: 1 where P > 0.  riding:
    exp(- i omega X/U), shape (n,), X downstream.
    """

    P: Array
    eps: Pair
    by_P: Change
    by_H: Change
    free: Array
    riding: Array
    entrainment: Number
    spacing: Number
    even: Symmetry = field(metadata={"static": True})

    def residual(self, dP: Array, dH: Array) -> Array:
        """The change of the residual on the free nodes by complex changes of P and H."""
        mass, eps = self.change(dP, dH)
        by_film = contact.balance(mass, eps, self.P, Rate(0.0, self.rate(mass)), self.spacing, self.even)
        by_pressure = contact.balance(jnp.zeros_like(mass), self.eps, dP, Rate(0.0, 0.0), self.spacing, self.even)
        return self.free * (by_film + by_pressure)

    def change(self, dP: Array, dH: Array) -> Change:
        """The change of mass and mobility."""
        found: Change = tree.map(lambda p, h: p * dP + h * dH, self.by_P, self.by_H)
        return found

    def rate(self, mass: Array) -> Array:
        """The rate of change of the mass following the flow."""
        return self.riding * self.entrainment * upstream_slope(mass * jnp.conj(self.riding), self.spacing)


@register_dataclass
@dataclass(frozen=True)
class _Problem:
    """The steady P and H, what closes the system, and the wave."""

    contact: Contact
    elastic: tuple[Elasticity, ...]
    P: Array
    H: Array
    line: ClosureLine
    entrainment: Number
    frequency: Number
    shape: Array


def respond(case: Case, film: GridSolution, wave: Wave) -> Response:
    """The response of the steady film of a case to a wave, to first order in its height."""
    require_double()
    motion = case.motion
    line = balanced(0.0, case.geometry.hertz_load)._replace(approach_weight=-motion.inertia * wave.frequency**2)
    c = discretise.smooth_contact(case, film.grid)
    elastic = multigrid.elasticities(film.grid, case.geometry.compliance, PRECISION)
    problem = _Problem(c, elastic, film.P, film.H, line, motion.entrainment(0.0), wave.frequency, wave.shape)
    dP, dH, approach, iterations = _solve(problem)
    k, converged = int(iterations), bool((iterations < LIMIT) & jnp.isfinite(approach))
    return Response(dP, dH, complex(approach), converged, k, 2 * nonlinear.convolutions(film.grid, 0, k))


@jax.jit
def _solve(p: _Problem) -> tuple[Array, Array, Array, Array]:
    """P', H', Delta' and the number of Krylov iterations."""
    turned = partial(nonlinear.along_the_flow, steady_rate(p.entrainment))
    speed, shape = jnp.abs(p.entrainment), turned(p.shape)
    film = linear_film(p.contact, turned(p.P), turned(p.H), speed, p.frequency)
    residual = _exact(p.contact, film, turned(p.H))
    inverse = partial(multigrid.precondition, _levels(film, p.elastic, p.frequency))
    weight = nonlinear.LOAD_WEIGHT / p.contact.spacing
    zero, one = jnp.zeros_like(shape), jnp.ones((), shape.dtype)

    def system(d: tuple[Array, Array]) -> tuple[Array, Array]:
        e, s = d
        misfit = p.line.approach_weight * s + p.line.load_weight * contact.load(p.contact, e)
        return residual(e, contact.deformation(p.contact, e) - s), weight * misfit

    lifted = residual(zero, jnp.ones_like(shape))

    def direction(k: Array, r: tuple[Array, Array]) -> tuple[Array, Array]:
        """Search direction k: first a change of Delta with the pressure's response, then changes of P alone."""
        return inverse(jnp.where(k == 0, lifted, r[0])), jnp.where(k == 0, one, 0.0)

    by_the_wave = residual(zero, shape), 0.0 * one
    (dP, approach), iterations = gcr(system, direction, by_the_wave, REDUCTION, LIMIT)
    dH = contact.deformation(p.contact, dP) - approach - shape
    return turned(dP), turned(dH), approach, iterations


def linear_film(c: Contact, P: Array, H: Array, speed: Number, frequency: Number) -> LinearFilm:
    """The linearisation about a steady film with X downstream."""

    def laws(P: Array, H: Array) -> tuple[Change, Pair]:
        found = contact.mobilities(c, P, H)
        return Change(contact.mass(c, P, H), found.secant), found.tangent

    one, zero = jnp.ones_like(P), jnp.zeros_like(P)
    _, change, eps = jax.linearize(laws, P, H, has_aux=True)
    by_P, by_H = change(one, zero), change(zero, one)
    riding = jnp.exp(-1j * frequency / speed * c.spacing * jnp.arange(P.shape[1]))
    free = inside(jnp.where(P > 0.0, 1.0, 0.0), c.even)
    return LinearFilm(P, eps, by_P, by_H, free, riding, speed, c.spacing, c.even)


def _exact(c: Contact, film: LinearFilm, H: Array) -> Callable[[Array, Array], Array]:
    """The change of the residual on the free nodes with the exact derivative of the flux, of every oil."""
    _, gain = jax.linearize(partial(c.flow.gain, c), film.P, H)

    def residual(dP: Array, dH: Array) -> Array:
        parts = jax.vmap(gain)(*(jnp.stack([d.real, d.imag]) for d in (dP, dH)))
        return film.free * inside(film.rate(film.change(dP, dH).mass) - (parts[0] + 1j * parts[1]), film.even)

    return residual


def _levels(film: LinearFilm, elastic: tuple[Elasticity, ...], frequency: Number) -> tuple[multigrid.GridLevel, ...]:
    """The V-cycle's grids, on the finest grid the operator with the mobility of the nodes."""
    precision = elastic[0].spectrum.dtype

    def single(values: Any) -> Array:
        return jnp.asarray(values, multigrid.in_precision(precision, values))

    film, omega = tree.map(single, film), single(frequency)

    def smoother(e: Elasticity, c: Coefficients) -> LineSmoother:
        """Carries the waves where the grid holds those that ride with the oil; elsewhere long waves alone."""
        turn = omega * e.spacing / film.entrainment
        holds = turn <= 2 * jnp.pi / NODES_PER_WAVE
        phase, rate = jnp.where(holds, jnp.exp(-1j * turn), 1.0), jnp.where(holds, 0.0, 1j * omega)
        return line_smoother(e, c, rate, film.entrainment, phase)

    steepening = -0.5 * curvature(film.by_P.eps, film.P, film.even) / film.spacing**2  # see `preconditioner.levels`
    finest = Coefficients(film.eps, film.by_H.mass, film.by_P.mass, film.free, steepening)
    return multigrid.hierarchy(elastic, finest, smoother, film.residual)
