"""The lubricated contact: film thickness and residual of Reynolds' equation, for impact and rolling.

    D(rho H)/DT + div(Poiseuille flux) = source   where P > 0
                                      >= source   where P = 0

The source is the oil that comes through the surfaces, zero unless a flow has one (`PressureFlow.source`).  The
Poiseuille flux of a Newtonian oil is -eps grad P, so that between tight surfaces

    D(rho H)/DT - d/dX(eps dP/dX) - d/dY(eps dP/dY) = 0,    eps = rho H^3 / (eta lambda_bar)

D/DT = d/dT + U d/dX is the rate of change following the mean flow (`flow`): squeeze and wedge are one term.  Impact has
U = 0 (eq. 1) and rolling has U = 1.  Otherwise they differ only in the scales and in the equation for Delta.
All quantities are dimensionless: X = x/a, H = h R/a^2, P = p/p_h, T = t/t0.  Fields have shape (n, n), index [Y, X].

Where asperities touch they carry a part of the pressure, P = P_f + P_c(H) (`touch`).  The total pressure P deforms the
bodies and carries the load.  The functions of the oil here (`mass`, `mobility`, `residual`, `steady_oil`, `oil_there`)
take its own pressure P_f in place of P.

In a warm film the oil that moves with the surfaces is c rho H, and the mobility is theta eps, with the factors of
`warm`.
"""

from collections.abc import Callable
from dataclasses import dataclass, field, fields, is_dataclass, replace
from functools import cache, partial
from typing import Any, NamedTuple, TypeVar

import jax
import jax.numpy as jnp
from jax import Array
from jax.tree_util import register_dataclass

from ertel.equations.flow import OilContent, Rate, downstream, flow_aligned, upstream_of, void_downstream
from ertel.equations.touch import Asperities
from ertel.numerics import halfspace
from ertel.numerics.grid import NO_SYMMETRY, Grid, Symmetry
from ertel.numerics.integrals import Plane
from ertel.numerics.stencils import FloatLike, Pair, diffusion, face_fluxes, inside, integral
from ertel.physics.geometry import Geometry
from ertel.physics.lubricant import Lubricant


class Mobilities(NamedTuple):
    """Along X and along Y: flux per unit pressure gradient, and change of the flux per unit change of the gradient.

    The two are the same unless the gradient thins the oil.
    """

    secant: Pair
    tangent: Pair


class Details(NamedTuple):
    """The flow of the oil at the nodes, for the budgets and the friction.

    stress: tau_m in the middle of the film along X and along Y, in units of p_h a/R, shape (2, n, n).  heat: what the
    pressure spends on the flow, - flux . grad of the enthalpy, in units of p_h a^2/(R t0), shape (n, n); each face
    between two nodes gives half to either.  fluxes: as from `PressureFlow`.  mobility: the tangent one of its
    mobilities.  It serves on the edge of a grid, where the gradient is small and the secant one nearly the same.
    """

    stress: Array
    heat: Array
    fluxes: tuple[Array, Array]
    mobility: Pair


@register_dataclass
@dataclass(frozen=True)
class PressureFlow:
    """The flow of a Newtonian oil by the pressure gradient: its mobility is the same in all directions.

    An oil that thins has the same methods, each its own (`thinning`).
    """

    def at(self, contact: "Contact", P: Array, H: Array) -> "PressureFlow":
        """This flow with what takes long to find in the film, so that the other methods need not find it again."""
        return self

    def turned(self, turn: Callable[[Any], Any]) -> "PressureFlow":
        """This flow with its fields turned, as `flow.flow_aligned` does; one without fields stays as it is."""
        return self

    def dragged(self, mass: Array) -> Array:
        """The oil that moves with the surfaces at their mean speed, of a full gap."""
        return mass

    def fluxes(self, contact: "Contact", P: Array, H: Array) -> tuple[Array, Array]:
        """Minus the Poiseuille flux through the faces across X, shape (n, n + 1), and across Y, shape (n + 1, n)."""
        in_x, in_y = face_fluxes(Pair(mobility(contact, P, H)), P, contact.even)
        return in_x / contact.spacing, in_y / contact.spacing

    def gain(self, contact: "Contact", P: Array, H: Array) -> Array:
        """- div(Poiseuille flux): what the flow brings to each node; without meaning on the edge.  Shape (n, n)."""
        return diffusion(Pair(mobility(contact, P, H)), P, contact.even) / contact.spacing**2

    def source(self, contact: "Contact", P: Array, H: Array) -> FloatLike:
        """The oil that comes to each node through the surfaces, as mass per area and time: none, unless overridden."""
        return 0.0

    def supply(self, contact: "Contact", P: Array, H: Array) -> Array:
        """All oil that comes to each node: by the pressure gradient and through the surfaces.  Shape (n, n)."""
        return self.gain(contact, P, H) + self.source(contact, P, H)

    def mobilities(self, contact: "Contact", P: Array, H: Array) -> Mobilities:
        """The mobilities at the nodes; the gradient itself is held when they are differentiated."""
        eps = Pair(mobility(contact, P, H))
        return Mobilities(eps, eps)

    def details(self, contact: "Contact", P: Array, H: Array, sliding: FloatLike, plane: Plane) -> Details:
        """The flow at every node when the surfaces slide by U S along X, which may differ from that of the film."""
        oil, eps = contact.lubricant, Pair(mobility(contact, P, H))
        along_x = contact.lambda_bar * oil.viscosity(P) * sliding / (12.0 * opened(H))
        heat = plane.of_slopes(eps, P, oil.enthalpy(P))
        return Details(jnp.stack([along_x, jnp.zeros_like(along_x)]), heat, self.fluxes(contact, P, H), eps)


def opened(H: Array) -> Array:
    """H > 0; any value where the surfaces overlap, because nothing flows there."""
    return jnp.where(H > 0.0, H, 1.0)


NEWTONIAN_FLOW = PressureFlow()


@register_dataclass
@dataclass(frozen=True)
class Contact:
    """Two surfaces and the oil between them.

    gap: undeformed gap minus roughness, shape (n, n).  kernel: from `halfspace.kernel`.  flow: how the pressure
    gradient drives the oil.  even: the axes about which fields are even and stored on one side (`stencils`).
    asperities: None where none touch.
    """

    gap: Array
    kernel: halfspace.Kernel
    spacing: float
    lambda_bar: float
    lubricant: Lubricant
    even: Symmetry = field(default=NO_SYMMETRY, metadata={"static": True})
    flow: PressureFlow = NEWTONIAN_FLOW
    asperities: Asperities | None = None


def bare_contact(geometry: Geometry, grid: Grid, lambda_bar: float, lubricant: Lubricant) -> Contact:
    """Two smooth bodies of a geometry."""
    gap = jax.device_put(geometry.gap(grid.kept_x[None, :], grid.kept_y[:, None]))
    kernel = halfspace.kernel(grid, geometry.compliance, reach=geometry.reach)
    return Contact(gap, kernel, grid.spacing, lambda_bar, traceable(lubricant), grid.even)


def film_thickness(contact: Contact, P: Array, approach: Array | float) -> Array:
    """H, eq. (3): - approach + undeformed gap + elastic deformation."""
    return -approach + contact.gap + deformation(contact, P)


def deformation(contact: Contact, P: Array) -> Array:
    """The geometry's compliance times the double integral of P/distance, eq. (3); of a line contact see `geometry`."""
    return contact.kernel.displacement(P)


def pressure_load(contact: Contact, P: Array) -> Array:
    """Double integral of P; of a line contact, the integral along X."""
    return integral(P, contact.spacing, contact.even)


def mass(contact: Contact, P: Array, H: Array) -> Array:
    """rho H; of a warm film, which is steady, what moves with the surfaces at their mean speed (`warm`)."""
    return contact.flow.dragged(contact.lubricant.density(P) * H)


def mobility(contact: Contact, P: Array, H: Array) -> Array:
    """eps = rho H^3/(eta lambda_bar), without thinning."""
    return contact.lubricant.mobility(P, H, contact.lambda_bar)


def residual(contact: Contact, P: Array, H: Array, rate: Rate) -> Array:
    """Reynolds' equation, eq. (1): rate of change following the flow + div(Poiseuille flux) - source; zero on the edge.

    Where P = 0 it is the rate at which a void grows.  In a starved film the flow also brings void from upstream.
    """
    r = _of_a_full_gap(contact, P, H, rate)
    if rate.layer is not None and rate.wedge is not None:
        void = _void(contact, P, H, rate, r)
        r = r + rate.wedge / contact.spacing * upstream_of(void)
    return inside(r, contact.even)


def steady_oil(contact: Contact, P: Array, H: Array, rate: Rate) -> OilContent:
    """The oil in a steady film; for either sign of U.

    In a cavity the oil is what passes, or where that would fill the gap, what the void leaves of it.
    """
    assert rate.wedge is not None
    turned, entrainment, speed = partial(flow_aligned, rate), rate.wedge, jnp.abs(rate.wedge)
    P, H, contact = turned(P), turned(H), replace(contact, flow=contact.flow.turned(turned))
    rate = rate._replace(wedge=speed, held=turned(rate.held))
    full, kinked, r = mass(contact, P, H), rate.kinked(P), _of_a_full_gap(contact, P, H, rate)
    void = _void(contact, P, H, rate, r)
    passing = jnp.where(P > 0.0, full, downstream(full, kinked) - void)
    oil = jnp.where(passing < full, passing, full - void)  # void = 0 where P > 0
    oil, full, void = map(turned, (oil, full, void))
    return OilContent(oil, full, void, entrainment, turned(kinked))


def oil_there(contact: Contact, P: Array, H: Array, residual: Array, rate: Rate) -> Array:
    """The oil that is there after a step, as mass: rho H less what the residual leaves over, shape (n, n).

    This oil obeys Reynolds' equation exactly at every node.  Where P > 0 the rest is what Newton's iteration left; the
    next step corrects it.  Where P = 0 it is the void of the cavity, which the next step hands on.  On a dry edge the
    oil moves with the flow alone.
    """
    full = mass(contact, P, H)
    dry = jnp.where(P > 0.0, 0.0, jnp.maximum(rate.of(full, contact.spacing), 0.0))
    return full - (residual + dry - inside(dry, contact.even)) / rate.new


def _of_a_full_gap(contact: Contact, P: Array, H: Array, rate: Rate) -> Array:
    """The residual of a gap that is full of oil; on the edge only the rate of change following the flow."""
    change = rate.of(mass(contact, P, H), contact.spacing, rate.kinked(P))
    return change - inside(contact.flow.supply(contact, P, H), contact.even)


def _void(contact: Contact, P: Array, H: Array, rate: Rate, r: Array) -> Array:
    """The void of a steady film, of which X points downstream."""
    assert rate.wedge is not None
    first: FloatLike = 0.0
    if (kinked := rate.kinked(P)) is not None:
        full = downstream(mass(contact, P, H)[:, :2], kinked[:, :2])
        first = (full[:, :1] - jnp.asarray(rate.layer))[:, 0]
    return void_downstream(P, r, first, rate.wedge, contact.spacing)


# -- oil laws as JAX pytrees; the laws themselves do not depend on JAX ------------------------------------------------

Record = TypeVar("Record")


def traceable(record: Record) -> Record:
    """The same oil or law, registered as a JAX pytree with the laws inside it; their fields are arrays or numbers."""
    for part in fields(record):  # type: ignore[arg-type]
        value = getattr(record, part.name)
        if is_dataclass(value):
            traceable(value)
    kind: Any = type(record)
    _register(kind)
    return record


@cache
def _register(record: Any) -> None:
    try:
        register_dataclass(record)
    except ValueError as error:
        if "already registered" not in str(error).lower() and "duplicate" not in str(error).lower():
            raise
