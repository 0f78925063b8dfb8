"""The flow of an oil that thins under shear, on the 2-D grid.

The flux by the pressure gradient is exact (`shear`).  With stresses in units of p_h a/R it is

    flux = - eps G,    G = 12 Q/H,    Q from    gradient = H grad P,    sliding = lambda_bar eta_bar U S/(12 H)

with the slide-to-roll ratio S.  Without thinning G = grad P.  The flux through the face between two nodes takes the
mean of their mobilities eps, as for a Newtonian oil (`stencils.diffusion`), so both have the same discretisation.  G is
that of the mean P and H of the two nodes.  The slope of P across the face is their difference, the slope along the face
is the mean of the central differences at the two nodes.
"""

from dataclasses import dataclass, replace

import jax
import jax.numpy as jnp
from jax import Array
from jax.tree_util import register_dataclass

from ertel.model.contact import NEWTONIAN_FLOW, Contact, Drag, opened
from ertel.model.shear import Shear, secant_mobility, shear
from ertel.numerics.integrals import Plane
from ertel.numerics.stencils import Pair, central_slopes, to_x_faces, to_y_faces
from ertel.numerics.symmetry import extended
from ertel.physics.fluidity import Fluidity

Number = Array | float
LARGEST_FACTOR = 1e9  # of a mobility by thinning, in the preconditioner, which computes in single precision


@register_dataclass
@dataclass(frozen=True)
class ThinningFlow:
    """The Poiseuille flow of a law of shear thinning: a `contact.PressureFlow`.

    law: registered as a pytree (`pytrees.traceable_law`).  p_h, unit: one unit of pressure and one of shear stress,
    p_h a/R, in Pa.  sliding: U S, the difference of the surfaces' speeds along X in a/t0; its sign has no influence.
    """

    law: Fluidity
    p_h: Number
    unit: Number
    sliding: Number

    def gain(self, contact: Contact, P: Array, H: Array) -> Array:
        """- div(Poiseuille flux), shape (n, n)."""
        in_X, in_Y = self._faces(contact, P, H)
        total: Array = ((in_X[:, 1:] - in_X[:, :-1]) + (in_Y[1:, :] - in_Y[:-1, :])) / contact.spacing
        return total

    def drag(self, contact: Contact, P: Array, H: Array, sliding: Number, plane: Plane) -> Drag:
        """The mid-plane stress and the heat of the pressure flow when the surfaces slide by U S."""
        flow = replace(self, sliding=sliding)
        in_X, in_Y = flow._faces(contact, P, H)
        heat = plane.across_faces(in_X[:, 1:-1], in_Y[1:-1], contact.lubricant.enthalpy(P))
        found, _ = flow._shear(contact, P, H, _slope(contact, P))
        return Drag(found.stress / self.unit, heat)

    def _faces(self, contact: Contact, P: Array, H: Array) -> tuple[Array, Array]:
        """Minus the flux through all faces around the nodes, shapes (n, n + 1) and (n + 1, n)."""
        p = extended(P, contact.even)
        eps = extended(NEWTONIAN_FLOW.mobility(contact, P, H).x, contact.even, "edge")
        film = extended(jnp.maximum(H, 0.0), contact.even, "edge")
        slope_x, slope_y = central_slopes(p, contact.spacing)
        across_x = (p[1:-1, 1:] - p[1:-1, :-1]) / contact.spacing
        across_y = (p[1:, 1:-1] - p[:-1, 1:-1]) / contact.spacing
        slope = jnp.stack([_line(across_x, to_y_faces(slope_x)), _line(to_x_faces(slope_y), across_y)])
        mean_P, mean_film = (_line(to_x_faces(f), to_y_faces(f)) for f in (p, film))
        G = self._driven(contact, mean_P, mean_film, slope)
        G_x, G_y = G[0, : across_x.size].reshape(across_x.shape), G[1, across_x.size :].reshape(across_y.shape)
        return to_x_faces(eps) * G_x, to_y_faces(eps) * G_y

    def mobility(self, contact: Contact, P: Array, H: Array) -> Pair:
        """The mobilities at the nodes for the preconditioner: what couples X and Y is left out."""
        slope = jax.lax.stop_gradient(_slope(contact, P))
        found, gradient = self._shear(contact, P, H, slope)
        factor = secant_mobility(self.law, self.p_h * P, found, gradient)
        eps = NEWTONIAN_FLOW.mobility(contact, P, H).x
        return Pair(*(eps * jnp.minimum(part, LARGEST_FACTOR) for part in (factor.xx, factor.yy)))

    def _driven(self, contact: Contact, P: Array, film: Array, slope: Array) -> Array:
        """G, shape (2, ...), from the slopes of P, shape (2, ...), where the film has the thickness given."""
        found, _ = self._shear(contact, P, film, slope)
        return 12.0 * found.flux / (opened(film) * self.unit)

    def _shear(self, contact: Contact, P: Array, film: Array, slope: Array) -> tuple[Shear, Array]:
        """The flow across the film, and H grad P in Pa."""
        H = opened(film)
        gradient = H * slope * self.unit
        along_x = contact.lambda_bar * contact.lubricant.viscosity(P) * self.sliding / (12.0 * H) * self.unit
        return shear(self.law, self.p_h * P, jnp.stack([along_x, jnp.zeros_like(along_x)]), gradient), gradient


def _slope(contact: Contact, P: Array) -> Array:
    """grad P at the nodes by central differences, shape (2, n, n)."""
    slopes = central_slopes(extended(P, contact.even), contact.spacing)
    return jnp.stack([slope[1:-1, 1:-1] for slope in slopes])


def _line(on_x_faces: Array, on_y_faces: Array) -> Array:
    """The values on all faces, one after the other: one program for both kinds takes half as long to compile."""
    return jnp.concatenate([on_x_faces.ravel(), on_y_faces.ravel()])
