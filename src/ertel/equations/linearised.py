"""The derivatives of the laws and of the residual about a film, once for the preconditioner and for the responses.

A change of P and of the film thickness H changes the mass m = rho H and the mobility, and so the residual, by

    rate(m') - div(eps' grad P + eps grad P')

Linear in P and in eps: a change of the gradient drives a flux by the tangent mobility, and the changes of the secant
mobility act on the gradient itself.  The mobility is that of the nodes.  For a Newtonian oil this is exact; an oil that
thins has more, see `flux_change`.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
from jax import Array, tree
from jax.tree_util import register_dataclass

from ertel.equations import contact
from ertel.equations.contact import Contact
from ertel.numerics.grid import Symmetry
from ertel.numerics.multigrid import in_precision
from ertel.numerics.stencils import FloatLike, Pair, curvature, divergence, face_fluxes, inside


class Change(NamedTuple):
    """The change of the mass and of the secant mobility."""

    mass: Array
    eps: Pair


@register_dataclass
@dataclass(frozen=True)
class LinearFilm:
    """Reynolds' equation, linearised about a film.

    eps: the tangent mobility.  by_P, by_H: derivatives of mass and secant mobility.  steepening: what the change of
    eps with P adds to the diagonal of the operator.  Where the pressure is curved, as at the foot of a spike, the
    diagonal is larger by half, or more than doubled.
    """

    P: Array
    eps: Pair
    by_P: Change
    by_H: Change
    steepening: Array
    spacing: FloatLike
    even: Symmetry = field(metadata={"static": True})

    def change(self, dP: Array, dH: Array) -> Change:
        """The change of mass and mobility by real or complex changes of P and H."""
        return tree.map(lambda p, h: p * dP + h * dH, self.by_P, self.by_H)

    def residual(self, dP: Array, dH: Array, rate: Callable[[Array], Array]) -> Array:
        """The change of the residual by changes of P and H, zero on the edge.  rate: that of the change of the mass."""
        change = self.change(dP, dH)
        by_film, by_pressure = face_fluxes(change.eps, self.P, self.even), face_fluxes(self.eps, dP, self.even)
        gain = divergence(*(film + pressure for film, pressure in zip(by_film, by_pressure, strict=True)))
        return inside(rate(change.mass) - gain / self.spacing**2, self.even)

    def in_precision(self, precision: Any) -> "LinearFilm":
        """The same in a real floating-point type."""
        return tree.map(lambda values: jnp.asarray(values, in_precision(precision, values)), self)


def linear_film(c: Contact, P: Array, H: Array) -> LinearFilm:
    """The linearisation about the film with P and H, both of the grid's shape.

    In double precision: of a thick oil the viscosity is beyond single, its inverse and their derivatives are not.
    """

    def laws(P: Array, H: Array) -> tuple[Change, Pair]:
        mobility = c.flow.mobilities(c, P, H)
        return Change(contact.mass(c, P, H), mobility.secant), mobility.tangent

    def change(dP: Array, dH: Array) -> Any:
        return jax.jvp(laws, (P, H), (dP, dH), has_aux=True)

    # both derivatives at once: they share most of the work
    one, zero = jnp.ones_like(P), jnp.zeros_like(P)
    both = jnp.stack([one, zero]), jnp.stack([zero, one])
    _, by, eps = jax.vmap(change, out_axes=(None, 0, None))(*both)
    by_P, by_H = (tree.map(lambda field, k=k: field[k], by) for k in range(2))
    steepening = -0.5 * curvature(by_P.eps, P, c.even) / c.spacing**2
    return LinearFilm(P, eps, by_P, by_H, steepening, c.spacing, c.even)


def flux_change(c: Contact, P: Array, H: Array) -> Callable[[Array, Array], Array]:
    """The exact derivative of - div(Poiseuille flux), of every oil, for complex changes of P and H."""
    _, gain = jax.linearize(partial(c.flow.supply, c), P, H)

    def change(dP: Array, dH: Array) -> Array:
        parts = jax.vmap(gain)(*(jnp.stack([d.real, d.imag]) for d in (dP, dH)))
        return parts[0] + 1j * parts[1]

    return change
