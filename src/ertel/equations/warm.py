"""The flow of a film whose temperature is known: two factors in Reynolds' equation, both 1 in a cold film.

    the oil that moves with the surfaces    c rho H
    the flux by the pressure gradient       theta times that of the film at the inlet's temperature

with c and theta of `columns`, theta along X and along Y.  They are held while Newton's iteration solves for the film,
and found again in its new columns (`solvers.heat`).
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

from jax import Array, tree
from jax.tree_util import register_dataclass

from ertel.equations.contact import NEWTONIAN_FLOW, Contact, Details, Mobilities, PressureFlow
from ertel.numerics.integrals import Plane
from ertel.numerics.stencils import FloatLike, Pair, divergence, extended, node_slopes, to_x_faces, to_y_faces


@register_dataclass
@dataclass(frozen=True)
class WarmFlow(PressureFlow):
    """A flow with the factors of a warm film.

    cold: the flow at the inlet's temperature.  share: c.  theta: of the mobility along X and along Y.  stress: tau_m in
    the middle of the film, in p_h a/R, shape (2, n, n).  entrainment: U.
    """

    share: Array
    theta: Pair
    stress: Array
    entrainment: FloatLike
    cold: PressureFlow = NEWTONIAN_FLOW

    def at(self, contact: Contact, P: Array, H: Array) -> "WarmFlow":
        return replace(self, cold=self.cold.at(contact, P, H))

    def turned(self, turn: Callable[[Any], Any]) -> "WarmFlow":
        share, theta, stress = turn(self.share), Pair(*map(turn, self.theta)), turn(self.stress)
        return replace(self, share=share, theta=theta, stress=stress, cold=self.cold.turned(turn))

    def dragged(self, mass: Array) -> Array:
        return self.share * mass

    def fluxes(self, contact: Contact, P: Array, H: Array) -> tuple[Array, Array]:
        theta = tree.map(partial(extended, even=contact.even, beyond="edge"), self.theta)
        in_x, in_y = self.cold.fluxes(contact, P, H)
        return to_x_faces(theta.x) * in_x, to_y_faces(theta.y) * in_y

    def gain(self, contact: Contact, P: Array, H: Array) -> Array:
        return divergence(*self.fluxes(contact, P, H)) / contact.spacing

    def mobilities(self, contact: Contact, P: Array, H: Array) -> Mobilities:
        cold = self.cold.mobilities(contact, P, H)
        secant, tangent = (Pair(self.theta.x * eps.x, self.theta.y * eps.y) for eps in cold)
        return Mobilities(secant, tangent)

    def details(self, contact: Contact, P: Array, H: Array, sliding: FloatLike, plane: Plane) -> Details:
        """The flow at every node; the stress is that of the sliding for which it was found."""
        in_x, in_y = self.fluxes(contact, P, H)
        heat = plane.across_faces(in_x[:, 1:-1], in_y[1:-1], contact.lubricant.enthalpy(P))
        # the oil that the surfaces drag along beyond u_m h flows against the pressure, or with it, as well
        heat += (1.0 - self.share) * self.entrainment * H * node_slopes(P, contact.spacing, contact.even)[0]
        return Details(self.stress, heat, (in_x, in_y), self.mobilities(contact, P, H).tangent)
