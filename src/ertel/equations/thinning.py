"""The flow of an oil that thins under shear, on the 2-D grid.

The flux by the pressure gradient is that of `shear`, which says its error.  With stresses in units of p_h a/R it is

    flux = - eps G,    G = 12 Q/H,    Q from    gradient = H grad P,    sliding = lambda_bar eta_bar U S/(12 H)

with the slide-to-roll ratio S.  Without thinning G = grad P.  The flux through the face between two nodes takes the
mean of their mobilities eps, as for a Newtonian oil (`stencils.diffusion`), so both have the same discretisation.  G is
that of the mean P and H of the two nodes, and of their mean fluidity with the weights that it has in eps: where sliding
thins the oil by powers of ten, the flux is almost the same for any viscosity, and the two must cancel.  The slope of P
across the face is their difference, the slope along the face is the mean of the central differences at the two nodes.
"""

from dataclasses import dataclass, replace
from typing import NamedTuple

import jax
import jax.numpy as jnp
from jax import Array
from jax.tree_util import register_dataclass

from ertel.equations.across import Tensor
from ertel.equations.contact import Contact, Details, Mobilities, PressureFlow, mobility, opened
from ertel.equations.shear import NODES, Shear, secant_mobility, shear
from ertel.numerics.integrals import Plane
from ertel.numerics.stencils import Pair, central_slopes, divergence, extended, node_slopes, to_x_faces, to_y_faces
from ertel.physics.fluidity import Fluidity, limited_stress

ROUGHLY = 4  # nodes across the film for the preconditioner
LARGEST_FACTOR = 1e9  # of a mobility by thinning, in the preconditioner, which computes in single precision


@register_dataclass
@dataclass(frozen=True)
class ThinningFlow(PressureFlow):
    """The flow by the pressure gradient of an oil with a law of shear thinning.

    law: registered as a pytree (`contact.traceable`).  p_h, unit: one unit of pressure and one of shear stress,
    p_h a/R, in Pa.  sliding: U S, the difference of the surfaces' speeds along X in a/t0; its sign has no influence.
    """

    law: Fluidity
    p_h: Array | float
    unit: Array | float
    sliding: Array | float

    def gain(self, contact: Contact, P: Array, H: Array) -> Array:
        """- div(Poiseuille flux), shape (n, n)."""
        faces = _faces(contact, P, H)
        flow, _ = self._shear(contact, faces.P, faces.film, faces.viscosity, faces.slope)
        return divergence(*faces.fluxes(self._force(flow, faces.film))) / contact.spacing

    def details(self, contact: Contact, P: Array, H: Array, sliding: Array | float, plane: Plane) -> Details:
        """The flow at every node when the surfaces slide by U S: all faces and nodes in one line, in one iteration."""
        faces = _faces(contact, P, H)
        n, slope = faces.P.size, node_slopes(P, contact.spacing, contact.even).reshape(2, -1)
        film = jnp.concatenate([faces.film, H.ravel()])
        viscosity = jnp.concatenate([faces.viscosity, contact.lubricant.viscosity(P).ravel()])
        all_P, slope = jnp.concatenate([faces.P, P.ravel()]), jnp.concatenate([faces.slope, slope], axis=1)
        whole, gradient = replace(self, sliding=sliding)._shear(contact, all_P, film, viscosity, slope)
        in_X, in_Y = faces.fluxes(self._force(whole, film)[:, :n])
        stress, gradient = (field[:, n:].reshape(2, *P.shape) for field in (whole.stress, gradient))
        return Details(
            limited_stress(self.law, stress, self.p_h * P) / self.unit,
            plane.across_faces(in_X[:, 1:-1], in_Y[1:-1], contact.lubricant.enthalpy(P)),
            divergence(in_X, in_Y) / contact.spacing,
            self._secant(contact, P, H, stress, gradient),
        )

    def mobilities(self, contact: Contact, P: Array, H: Array, points: int = ROUGHLY) -> Mobilities:
        """The mobilities at the nodes for the preconditioner: what couples X and Y is left out."""
        slope = jax.lax.stop_gradient(node_slopes(P, contact.spacing, contact.even))
        flow, gradient = self._shear(contact, P, H, contact.lubricant.viscosity(P), slope, points)
        secant = self._secant(contact, P, H, flow.stress, gradient, points)
        return Mobilities(secant, _thinned(mobility(contact, P, H), flow.by_gradient))

    def _secant(
        self, contact: Contact, P: Array, H: Array, stress: Array, gradient: Array, points: int = NODES
    ) -> Pair:
        """The mobilities at the nodes from the flow across the film there."""
        factor = secant_mobility(self.law, self.p_h * P, stress, gradient, points)
        return _thinned(mobility(contact, P, H), factor)

    def _force(self, flow: Shear, film: Array) -> Array:
        """G, shape (2, ...), from the flow across a film of the thickness given."""
        return 12.0 * flow.flux / (opened(film) * self.unit)

    def _shear(
        self, contact: Contact, P: Array, film: Array, viscosity: Array, slope: Array, points: int = NODES
    ) -> tuple[Shear, Array]:
        """The flow across the film, and H grad P in Pa."""
        H = opened(film)
        gradient = H * slope * self.unit
        along_x = contact.lambda_bar * viscosity * self.sliding / (12.0 * H) * self.unit
        return shear(self.law, self.p_h * P, jnp.stack([along_x, jnp.zeros_like(along_x)]), gradient, points), gradient


class _Faces(NamedTuple):
    """The faces around the nodes, those across X before those across Y, in one line of length m.

    One program for both kinds takes half as long to compile.  P, film, viscosity: shape (m,); slope: grad P, shape
    (2, m).  eps: the mean mobility without thinning, shapes (n, n + 1) and (n + 1, n).
    """

    P: Array
    film: Array
    viscosity: Array
    slope: Array
    eps: tuple[Array, Array]

    def fluxes(self, force: Array) -> tuple[Array, Array]:
        """Minus the flux, of the shapes of eps, from G, shape (2, m)."""
        eps_x, eps_y = self.eps
        return eps_x * force[0, : eps_x.size].reshape(eps_x.shape), eps_y * force[1, eps_x.size :].reshape(eps_y.shape)


def _faces(contact: Contact, P: Array, H: Array) -> _Faces:
    p = extended(P, contact.even)
    eps = extended(mobility(contact, P, H), contact.even, "edge")
    film = extended(jnp.maximum(H, 0.0), contact.even, "edge")
    slope_x, slope_y = central_slopes(p, contact.spacing)
    across_x = (p[1:-1, 1:] - p[1:-1, :-1]) / contact.spacing
    across_y = (p[1:, 1:-1] - p[:-1, 1:-1]) / contact.spacing
    slope = jnp.stack([_line(across_x, to_y_faces(slope_x)), _line(to_x_faces(slope_y), across_y)])
    conductance = contact.lubricant.density(p) * film**3  # the mobility is that over viscosity
    mean_P, mean_film, mean_conductance, mean_eps = (
        _line(to_x_faces(f), to_y_faces(f)) for f in (p, film, conductance, eps)
    )
    flows = mean_eps > 0.0
    viscosity = jnp.where(flows, mean_conductance, 1.0) / jnp.where(flows, contact.lambda_bar * mean_eps, 1.0)
    return _Faces(mean_P, mean_film, viscosity, slope, (to_x_faces(eps), to_y_faces(eps)))


def _thinned(eps: Array, by_gradient: Tensor) -> Pair:
    """The mobilities along X and along Y from the tensor of `shear`; eps: that without thinning."""
    along_x, _, along_y = by_gradient
    return Pair(*(eps * jnp.minimum(12.0 * part, LARGEST_FACTOR) for part in (along_x, along_y)))


def _line(on_x_faces: Array, on_y_faces: Array) -> Array:
    """The values on all faces, one after the other."""
    return jnp.concatenate([on_x_faces.ravel(), on_y_faces.ravel()])
