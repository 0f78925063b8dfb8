"""Friction: shear stress and power loss of the film, and what both surfaces feel of it.

Across the film the shear stress is linear, tau = tau_m + zeta grad p, with zeta from -h/2 at surface 2 to h/2 at
surface 1.

* Sliding: the stress tau_m in the middle of the film.  Its integral is the force of surface 1 on surface 2, which is
  along X where surface 1 is the faster one.  It brakes surface 1 and drives surface 2.
* Rolling: the rest, +- (1/2) h grad p at the surfaces, pulls both of them in the same direction.  The resistance of
  each is (1/2) double integral of H dP/dX over the grid, positive where it is against motion along X.  It grows with
  the logarithm of the length of the inlet (Biboulet and Houpert 2010 take P = 0 on its edge).
* Loss: the oil heats by the integral of tau.du/dz across the film, per area

      loss = tau_m.(u1 - u2) - q.grad p        in a Newtonian oil  eta (u1 - u2)^2/h + h^3 (grad p)^2/(12 eta)

  with the volume flux q by the pressure gradient.  Compression takes up power too, but gives it back.

Where P = 0 the oil does not fill the gap, and no stress is counted: friction is that of the pressurised film.

In a steady contact the power loss is what the surfaces spend, sliding speed times sliding force and rolling speed
times the resistance of both, less the energy that flows out through the edge of the grid.
"""

from typing import NamedTuple

import jax
import jax.numpy as jnp
from jax import Array

from ertel.case.case import Case
from ertel.equations import discretise
from ertel.equations.contact import Contact, Details
from ertel.equations.state import GridSolution
from ertel.numerics.integrals import Plane
from ertel.numerics.programs import ANY_SIZE, Program, exportable

Number = Array | float
NUMBERS = ("mu_sliding", "mu_sliding_y", "mu_rolling", "power_loss")


@exportable
class Friction(NamedTuple):
    """The friction of a film.

    stress: tau_m along X and Y at the nodes, in p_h a/R, zero where P = 0; shape (2, n_y, n_x).  Along Y it is odd
    about an axis Y = 0 about which the film is even.  loss: power loss per area at the nodes, in p_h a^2/(R t0), shape
    (n_y, n_x); a node without pressure next to the film has its half of the flow between them.  sliding: the force of
    surface 1 on surface 2 over the load, in a/R, along X and Y, shape (2,); times a/R it is the traction coefficient.
    rolling: the resistance of each surface over the load, in the same unit, shape (2,).  power: the double integral of
    the loss, in F* a^2/(R t0).
    """

    stress: Array
    loss: Array
    sliding: Array
    rolling: Array
    power: Array


def friction(
    plane: Plane, contact: Contact, P: Array, H: Array, sliding: Number, load: Number, hertz_load: Number
) -> Friction:
    """The friction of a film; traceable by JAX.

    Parameters
    ----------
    plane : Plane
        The grid.
    contact : Contact
        The surfaces and the oil.
    P, H : Array
        Pressure and film, shape (n_y, n_x).
    sliding : number
        U S = u1 - u2 along X, in a/t0.  It need not be the sliding at which the film was computed.
    load : number
        The load that the film carries, in F*.  Without a load the coefficients are zero.
    hertz_load : number
        F* in units of a^2 p_h (`Geometry.hertz_load`).
    """
    details = contact.flow.details(contact, P, H, sliding, plane)
    return of_details(plane, details, P, H, sliding, load, hertz_load)


def of_details(
    plane: Plane, details: Details, P: Array, H: Array, sliding: Number, load: Number, hertz_load: Number
) -> Friction:
    """The friction from the details of the flow; the other arguments are those of `friction`."""
    stress = jnp.where(P > 0.0, details.stress, 0.0)
    loss = details.heat + sliding * stress[0]
    along_y = 0.0 if plane.even.y else plane.total(stress[1])
    force, resistance = jnp.stack([plane.total(stress[0]), along_y]), 0.5 * plane.push(H, P)
    carries = jnp.asarray(load) > 0.0
    share = jnp.where(carries, 1.0 / (jnp.where(carries, load, 1.0) * hertz_load), 0.0)
    return Friction(stress, loss, share * force, share * resistance, plane.total(loss) / hertz_load)


def numbers(found: Friction) -> tuple[Array, ...]:
    """The numbers of `NUMBERS`: forces over the load in a/R, the power loss in F* a^2/(R t0)."""
    return found.sliding[0], found.sliding[1], found.rolling[0], found.power


def coefficients(found: Friction) -> dict[str, float]:
    """The numbers of `NUMBERS` by name."""
    return dict(zip(NUMBERS, map(float, numbers(jax.device_get(found))), strict=True))


def steady(case: Case, s: GridSolution) -> Friction:
    """The friction of a steady contact on one of its grids; its maps have the shape of the grid."""
    c, motion, scale = discretise.contact_of(case, s.grid), case.motion, case.geometry.hertz_load
    return of_film(Plane.of(s.grid), c, s.P, s.H, motion.sliding(0.0), motion.load(0.0), scale)


def of_film(
    plane: Plane, contact: Contact, P: Array, H: Array, sliding: Number, load: Number, hertz_load: Number
) -> Friction:
    """The same as `friction`, compiled."""
    found: Friction = _program(plane, contact, *jax.device_put((P, H)), sliding, load, hertz_load)
    return found


_program = Program(jax.jit(friction), ANY_SIZE)
