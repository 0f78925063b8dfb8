"""The flow of an oil that thins under shear, on the 2-D grid.

The flux by the pressure gradient is that of `shear`, which says its error.  With stresses in units of p_h a/R it is

    flux = - eps G,    G = 12 Q/H,    Q from    gradient = H grad P,    sliding = lambda_bar eta_bar U S/(12 H)

with the slide-to-roll ratio S.  Without thinning G = grad P.  The flux through the face between two nodes takes the
mean of their mobilities eps, as for a Newtonian oil (`stencils.diffusion`), so both have the same discretisation.  G is
that of the mean P and H of the two nodes, and of their mean fluidity with the weights that it has in eps: where sliding
thins the oil by powers of ten, the flux is almost the same for any viscosity, and the two must cancel.  The slope of P
across the face is their difference, the slope along the face is the mean of the central differences at the two nodes.

Q takes long to find.  It is found once for each film (`ThinningFlow.at`), at all faces and nodes: the residual and its
derivative take it at the faces, the preconditioner and the account at the nodes too.
"""

from dataclasses import dataclass, replace
from typing import NamedTuple

import jax
import jax.numpy as jnp
from jax import Array, tree
from jax.tree_util import register_dataclass

from ertel.equations.across import Vector, dot
from ertel.equations.contact import Contact, Details, Mobilities, PressureFlow, mobility, opened
from ertel.equations.shear import ShearedFilm, SolvedFilm, attached, solved_film
from ertel.numerics.integrals import Plane
from ertel.numerics.stencils import (
    Pair,
    central_slopes,
    continued,
    divergence,
    extended,
    node_slopes,
    to_x_faces,
    to_y_faces,
)
from ertel.physics.fluidity import Fluidity, limited_stress

LARGEST_FACTOR = 1e9  # of a mobility by thinning, in the preconditioner, which computes in single precision


class Sheared(NamedTuple):
    """The flow across a film at the faces around the nodes (`_faces`), and at the nodes, both in one line."""

    faces: SolvedFilm
    nodes: SolvedFilm


@register_dataclass
@dataclass(frozen=True)
class ThinningFlow(PressureFlow):
    """The flow by the pressure gradient of an oil with a law of shear thinning.

    law: registered as a pytree (`contact.traceable`).  p_h, unit: one unit of pressure and one of shear stress,
    p_h a/R, in Pa.  sliding: U S, the difference of the surfaces' speeds along X in a/t0; its sign has no influence.
    sheared: the flow across the film, None where the methods are to find it.
    """

    law: Fluidity
    p_h: Array | float
    unit: Array | float
    sliding: Array | float
    sheared: Sheared | None = None

    def at(self, contact: Contact, P: Array, H: Array) -> "ThinningFlow":
        """This flow with the flow across the film; the search starts from the stored stress, if there is one."""
        return replace(self, sheared=self._solved(contact, P, H))

    def gain(self, contact: Contact, P: Array, H: Array) -> Array:
        """- div(Poiseuille flux), shape (n, n)."""
        return divergence(*self.fluxes(contact, P, H)) / contact.spacing

    def fluxes(self, contact: Contact, P: Array, H: Array) -> tuple[Array, Array]:
        return self._fluxes(contact, P, H, self.sheared or self._solved(contact, P, H))

    def details(self, contact: Contact, P: Array, H: Array, sliding: Array | float, plane: Plane) -> Details:
        """The flow at every node when the surfaces slide by U S; `sheared`, where it is given, is of that sliding."""
        flow = replace(self, sliding=sliding)
        sheared = self.sheared or flow._solved(contact, P, H)
        (in_X, in_Y), nodes = flow._fluxes(contact, P, H, sheared), sheared.nodes
        stress = jnp.stack([along.reshape(P.shape) for along in (nodes.stress.x, nodes.stress.y)])
        return Details(
            limited_stress(self.law, stress, self.p_h * P) / self.unit,
            plane.across_faces(in_X[:, 1:-1], in_Y[1:-1], contact.lubricant.enthalpy(P)),
            (in_X, in_Y),
            _tangent(mobility(contact, P, H), nodes),
        )

    def mobilities(self, contact: Contact, P: Array, H: Array) -> Mobilities:
        """The mobilities at the nodes for the preconditioner: what couples X and Y is left out.

        The secant one is that along the gradient, in all directions.
        """
        nodes = (self.sheared or self._solved(contact, P, H)).nodes
        points, eps = _nodes(contact, P, H), mobility(contact, P, H)
        slope = jax.lax.stop_gradient(points.slope)
        along, square = dot(self._force(contact, points._replace(slope=slope), nodes), slope), dot(slope, slope)
        factor = jnp.where(square > 0.0, along / jnp.where(square > 0.0, square, 1.0), 1.0).reshape(P.shape)
        return Mobilities(Pair(eps * jnp.minimum(factor, LARGEST_FACTOR)), _tangent(eps, nodes))

    def _solved(self, contact: Contact, P: Array, H: Array) -> Sheared:
        """The flow across the film at all faces and nodes, in one iteration."""
        faces, nodes = _faces(contact, P, H)[0], _nodes(contact, P, H)
        points = tree.map(lambda *parts: jnp.concatenate(parts), faces, nodes)
        known = self.sheared and tree.map(lambda *parts: jnp.concatenate(parts), *(of.stress for of in self.sheared))
        found, m = solved_film(self._film(contact, points), guess=known), faces.P.size
        return Sheared(tree.map(lambda field: field[:m], found), tree.map(lambda field: field[m:], found))

    def _fluxes(self, contact: Contact, P: Array, H: Array, sheared: Sheared) -> tuple[Array, Array]:
        """Minus the flux through the faces across X, shape (n, n + 1), and across Y, shape (n + 1, n)."""
        points, (eps_x, eps_y) = _faces(contact, P, H)
        force = self._force(contact, points, sheared.faces)
        return eps_x * force.x[: eps_x.size].reshape(eps_x.shape), eps_y * force.y[eps_x.size :].reshape(eps_y.shape)

    def _force(self, contact: Contact, points: "_Points", solution: SolvedFilm) -> Vector:
        """G from the flow across the film."""
        _, flux = attached(self._film(contact, points), solution)
        return flux * (12.0 / (opened(points.film) * self.unit))

    def _film(self, contact: Contact, points: "_Points") -> ShearedFilm:
        """The quantities on which the flow depends, in Pa."""
        H = opened(points.film)
        along_x = contact.lambda_bar * points.viscosity * self.sliding / (12.0 * H) * self.unit
        sliding = Vector(along_x, jnp.zeros_like(along_x))
        return ShearedFilm(self.law, self.p_h * points.P, sliding, points.slope * (H * self.unit))


class _Points(NamedTuple):
    """P, H, the viscosity and grad P in points of one line."""

    P: Array
    film: Array
    viscosity: Array
    slope: Vector


def _nodes(contact: Contact, P: Array, H: Array) -> _Points:
    slope = Vector(*node_slopes(P, contact.spacing, contact.even))
    return tree.map(jnp.ravel, _Points(P, H, contact.lubricant.viscosity(P), slope))


def _faces(contact: Contact, P: Array, H: Array) -> tuple[_Points, tuple[Array, Array]]:
    """The faces around the nodes, those across X before those across Y, and the mean mobility there without thinning.

    One program for both kinds takes half as long to compile.  The mobilities have the shapes (n, n + 1) and (n + 1, n).
    """
    p = extended(P, contact.even)
    eps = extended(mobility(contact, P, H), contact.even, "edge")
    film = extended(jnp.maximum(H, 0.0), contact.even, "edge")
    slope_x, slope_y = central_slopes(continued(P, contact.even), contact.spacing)
    across_x = (p[1:-1, 1:] - p[1:-1, :-1]) / contact.spacing
    across_y = (p[1:, 1:-1] - p[:-1, 1:-1]) / contact.spacing
    slope = Vector(_line(across_x, to_y_faces(slope_x)), _line(to_x_faces(slope_y), across_y))
    conductance = contact.lubricant.density(p) * film**3  # the mobility is that over viscosity
    mean_P, mean_film, mean_conductance, mean_eps = (
        _line(to_x_faces(f), to_y_faces(f)) for f in (p, film, conductance, eps)
    )
    flows = mean_eps > 0.0
    viscosity = jnp.where(flows, mean_conductance, 1.0) / jnp.where(flows, contact.lambda_bar * mean_eps, 1.0)
    return _Points(mean_P, mean_film, viscosity, slope), (to_x_faces(eps), to_y_faces(eps))


def _tangent(eps: Array, nodes: SolvedFilm) -> Pair:
    """The mobilities along X and along Y for a change of the gradient; eps: that without thinning."""
    along_x, _, along_y = nodes.by_gradient
    return Pair(*(eps * jnp.minimum(12.0 * part.reshape(eps.shape), LARGEST_FACTOR) for part in (along_x, along_y)))


def _line(on_x_faces: Array, on_y_faces: Array) -> Array:
    """The values on all faces, one after the other."""
    return jnp.concatenate([on_x_faces.ravel(), on_y_faces.ravel()])
