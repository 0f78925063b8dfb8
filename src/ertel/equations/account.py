"""The account of the film at one time: the balances of mass and energy, and the friction.

The balances
------------
They say what is stored, what flows and what is lost.

Mass: the Reynolds equation integrated over the cells of the nodes within the edge, which end halfway to it, with the
Poiseuille flux rho q (Newtonian: -eps grad P) and the oil m that is there, rho H less the void of a cavity:

    d/dT [integral of m] + outflow - inflow = cavity source

* outflow, inflow: the sums of rho q.n + U m n_x over the outermost faces of these cells, where it points outwards and
  where inwards.
* A source of oil in the surfaces (`PressureFlow.source`) counts as inflow, a leak as outflow.
* cavity source: the oil that a cavity would make as it grows.  A check: it is zero, because the cavity keeps its void.

Energy: the Reynolds equation times the enthalpy h(P) = integral of dP/rho, integrated over the grid.  The film
thickness H = -Delta + G + D has the gap G (with the roughness) and the deformation D.  The elastic kernel is
symmetric, so

    F V = d/dT [E_solids + E_oil + E_asperities] + dissipation - surface power + outside power

* E_solids = 1/2 integral of P D: elastic energy of the solids.  D has the uplift by the oil outside.  The energy that
  its pressure shares with that on the grid, 1/2 uplift times load, comes on top.
* E_oil = integral of (rho h - P) H: elastic energy of the compressed oil.
* dissipation = - integral of rho q.grad h: what the pressure spends on the Poiseuille flow.  For a Newtonian oil it is
  viscous, eps grad P.grad h.  Sliding of the surfaces dissipates too, exactly what it takes to drive it; both are left
  out here, and counted in the power loss of the friction.  For an oil that thins, sliding and pressure act together:
  the flux is that of `thinning`, and the work of sliding, tau_m.(u1 - u2), is again left out on both sides.
* surface power = - integral of P DG/DT: what the moving surfaces do on the film, by rolling (- U P dG/dX, whose sum is
  the hydrodynamic rolling resistance) and by roughness that moves relative to the flow.  Where the gap closes the film
  takes power from the surfaces, where it opens it gives most of it back.
* E_asperities = integral of the integral of P_c from H to infinity, where asperities touch.  Their pressure P_c and
  that of the oil P_f together are P (`touch`): the oil's terms have P_f, those of the solids P.
* outside power: what goes to the oil outside the grid, V times its load less the uplift times the rate of the load on
  the grid, and with the flow through the edge, integral of h rho q.n + U (rho h - P) H n_x; and
  with oil that leaks into the surfaces, h of its mass.

With the kinetic energy of the ball, inertia V dV/dT = (w - F) V, the work of the applied load w and of the surfaces is
stored, dissipated, or lost to the outside.  Energies are in units F* a^2/R, powers in F* a^2/(R t0).  Mass is in
rho0 a^4/R: in SI a volume, that of the oil at ambient pressure.

The balance of mass is that of the discrete equation: what flows through a face is what the law of the equation gives
there, and between two nodes it leaves one cell and enters the other.  So it closes to the tolerance of the solver, and
it fails where the equation is not solved, or where oil comes or goes otherwise than by these terms, as in a shift of
the oil that does not keep its sum.  An error of the grid it does not show.  That of energy does: there the flow through
the edge is not taken from the solver's fluxes.

The friction
------------
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

Where asperities touch, they add the stress mu_c P_c against the sliding, with a coefficient mu_c that is given.

In a steady contact the power loss is what the surfaces spend, sliding speed times sliding force and rolling speed
times the resistance of both, less the energy that flows out through the edge of the grid.
"""

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from ertel.case.status import Status
from ertel.equations.contact import Contact, Details
from ertel.equations.outside import Surroundings
from ertel.equations.state import State, StepNumbers, StepSolution, Work, own_pressure, unpacked
from ertel.equations.touch import Asperities
from ertel.numerics.integrals import Plane, Space
from ertel.numerics.programs import ANY_SIZE, Program, exportable
from ertel.numerics.stencils import FloatLike, Pair, divergence, inside
from ertel.physics.lubricant import Lubricant

# -- friction ----------------------------------------------------------------------------------------------------------


@exportable
class Friction(NamedTuple):
    """The friction of a film.

    stress: tau_m along X and Y at the nodes, in p_h a/R, zero where P = 0; shape (2, n_y, n_x).  Along Y it is odd
    about an axis Y = 0 about which the film is even.  loss: power loss per area at the nodes, in p_h a^2/(R t0), shape
    (n_y, n_x); a node without pressure next to the film has its half of the flow between them.  sliding: the force of
    surface 1 on surface 2 over the load, in a/R, along X and Y, shape (2,); times a/R it is the traction coefficient.
    rolling: the resistance of each surface over the load, in the same unit, shape (2,).  power: the double integral of
    the loss, in F* a^2/(R t0).  boundary: the part of sliding along X that asperities have, None where none touch.
    """

    stress: Array
    loss: Array
    sliding: Array
    rolling: Array
    power: Array
    boundary: Array | None = None


class Touch(NamedTuple):
    """The pressure that asperities carry, shape (n, n), and their law."""

    P: Array
    asperities: Asperities


def friction(
    plane: Plane,
    contact: Contact,
    P: Array,
    H: Array,
    sliding: FloatLike,
    load: FloatLike,
    hertz_load: FloatLike,
    P_asperity: Array | None = None,
) -> Friction:
    """The friction of a film; traceable by JAX.  P: of the oil; P_asperity: of asperities, where they touch.

    sliding: U S = u1 - u2 along X, in a/t0.  It need not be the sliding at which the film was computed.  load: what the
    film carries, in F*; without a load the coefficients are zero.  hertz_load: F* in units of a^2 p_h.
    """
    details = contact.flow.details(contact, P, H, sliding, plane)
    return friction_of_details(plane, details, P, H, sliding, load, hertz_load, touch_of(contact, P_asperity))


def touch_of(contact: Contact, P_asperity: Array | None) -> Touch | None:
    """The solid contact, if there is any."""
    return None if P_asperity is None or contact.asperities is None else Touch(P_asperity, contact.asperities)


def friction_of_details(
    plane: Plane,
    details: Details,
    P: Array,
    H: Array,
    sliding: FloatLike,
    load: FloatLike,
    hertz_load: FloatLike,
    touch: Touch | None = None,
) -> Friction:
    """The friction from the details of the flow; the other arguments are those of `friction`."""
    stress, boundary = jnp.where(P > 0.0, details.stress, 0.0), None
    if touch is not None:
        boundary = jnp.sign(sliding) * touch.asperities.friction * touch.P
        stress = stress.at[0].add(boundary)
    loss = details.heat + sliding * stress[0]
    force, resistance = shear_force(plane, stress), 0.5 * plane.push(H, P)
    carries = jnp.asarray(load) > 0.0
    per_load = jnp.where(carries, 1.0 / (jnp.where(carries, load, 1.0) * hertz_load), 0.0)
    share = None if boundary is None else per_load * plane.total(boundary)
    return Friction(stress, loss, per_load * force, per_load * resistance, plane.total(loss) / hertz_load, share)


def shear_force(plane: Plane, stress: Array) -> Array:
    """The double integral of the stress, shape (2,); along Y it is odd about an axis Y = 0."""
    return jnp.stack([plane.total(stress[0]), jnp.zeros(()) if plane.even.y else plane.total(stress[1])])


def numbers_of(friction: Friction) -> dict[str, Array]:
    """The numbers of a friction by name: forces over the load in a/R, the power loss in F* a^2/(R t0)."""
    sliding = friction.sliding
    others = {"mu_rolling": friction.rolling[0], "power_loss": friction.power}
    boundary = {}
    if friction.boundary is not None:
        boundary = {"mu_boundary": friction.boundary, "mu_oil": sliding[0] - friction.boundary}
    return {"mu_sliding": sliding[0], "mu_sliding_y": sliding[1], **boundary, **others}


def coefficients(friction: Friction) -> dict[str, float]:
    """The same on the host."""
    return {name: float(number) for name, number in numbers_of(jax.device_get(friction)).items()}


def whole_maps(whole: Callable[..., Any], level: Mapping[str, Any], friction: Friction) -> dict[str, np.ndarray]:
    """Pressure, film, oil, stress and power loss on the whole plane, by name.  whole: as `Stepper.whole`.

    level: the fields P, H and mass.  A void has ambient pressure, so the oil beside it has its ambient density.
    """
    P, H = level["P"], level["H"]
    tau_x, tau_y = np.asarray(friction.stress)
    oil = np.where(np.asarray(own_pressure(level)) > 0.0, H, level["mass"])
    solid = {name: level[name] for name in ("P_asperity",) if name in level}
    fields = {"P": P, **solid, "H": H, "oil": oil, "tau_x": tau_x, "tau_y": tau_y, "loss": friction.loss}
    return {name: np.asarray(whole(field, odd=name == "tau_y")) for name, field in fields.items()}


friction_program = Program(jax.jit(friction), ANY_SIZE)


# -- the balances ------------------------------------------------------------------------------------------------------


class Film(NamedTuple):
    """The film at one time.

    P, H, eps: pressure of the oil, film thickness, mobility.  mass: of the oil within the edge.  leaving: what flows
    out of there, at each face.  heat: - rho q.grad h at the nodes.  deformation: of the solids.  growth: the rate of
    the oil + div(Poiseuille flux) - source, which vanishes.  U: entrainment.  gap_change: DG/DT.  touch: None where no
    asperities touch.
    """

    P: Array
    H: Array
    mass: Array
    leaving: Array
    eps: Pair
    heat: Array
    deformation: Array
    growth: Array
    U: FloatLike
    gap_change: FloatLike
    touch: Touch | None = None


class Moment(NamedTuple):
    """The numbers that an account needs besides the fields.

    approach: Delta.  U, sliding: of the flow along X, and u1 - u2, in a/t0.  gap_change: DG/DT.  load: what the film
    carries, in F*.  hertz_load: F* in a^2 p_h.
    """

    approach: FloatLike
    U: FloatLike
    sliding: FloatLike
    gap_change: Array
    load: FloatLike
    hertz_load: FloatLike


def account(
    space: Plane,
    c: Contact,
    P: Array,
    H: Array,
    m: Moment,
    oil: Array,
    change: Array,
    through: Array | None = None,
    P_asperity: Array | None = None,
) -> tuple[dict[str, Array], Friction]:
    """The terms of the account of a film on the 2-D grid by name, and its friction.

    P: of the oil; P_asperity: of asperities, where they touch.  oil: what is there, as mass.  change: the rate of the
    oil, following the flow.  through: what the flow takes through the faces across X, None where the oil stays.
    """
    details = c.flow.details(c, P, H, m.sliding, space)
    source, (in_x, in_y) = c.flow.source(c, P, H), details.fluxes
    gain, deformed = divergence(in_x, in_y) / c.spacing + source, H + m.approach - c.gap
    growth, touch = inside(change - gain, c.even), touch_of(c, P_asperity)
    leaving = space.leaving(-in_x if through is None else through - in_x, -in_y)
    oil_within = space.inner(oil), leaving, details.mobility, details.heat
    film = Film(P, H, *oil_within, deformed, growth, m.U, m.gap_change, touch)
    forces = friction_of_details(space, details, P, H, m.sliding, m.load, m.hertz_load, touch)
    terms = account_terms(space, c.lubricant, film, forces, m.hertz_load)
    terms |= {} if touch is None else touch_terms(space, touch, H, m.load, m.hertz_load)
    if isinstance(source, Array):  # not the plain zero of surfaces without one
        source = inside(source, c.even)
        terms["inflow"] += space.total(jnp.maximum(source, 0.0))
        terms["outflow"] += space.total(jnp.maximum(-source, 0.0))
        terms["outside_power"] -= space.total(source * c.lubricant.enthalpy(P)) / m.hertz_load
    return terms, forces


def account_terms(
    space: Space, oil: Lubricant, film: Film, friction: Friction, hertz_load: FloatLike
) -> dict[str, Array]:
    """The terms of the balances on the grid by name, "load", the double integral of P, and the numbers of the friction.

    hertz_load: F* in a^2 p_h.
    """
    P, H, eps, U, touch = film.P, film.H, film.eps, film.U, film.touch
    whole = P if touch is None else P + touch.P
    enthalpy, compressed, squeezed_out = oil.enthalpy(P), oil.compression(P) * H, space.flow_out(eps, P)
    energy_out = squeezed_out * space.edge(enthalpy) + U * space.along_x(compressed)
    return {
        "mass": film.mass,
        "inflow": jnp.maximum(-film.leaving, 0.0).sum(),
        "outflow": jnp.maximum(film.leaving, 0.0).sum(),
        "cavity_source": space.total(jnp.where(P > 0.0, 0.0, film.growth)),
        "elastic_energy": space.total(whole * film.deformation) / 2 / hertz_load,
        "oil_energy": space.total(compressed) / hertz_load,
        "dissipation": space.total(film.heat) / hertz_load,
        "power_from_surfaces": space.total(whole * jnp.maximum(-film.gap_change, 0.0)) / hertz_load,
        "power_to_surfaces": space.total(whole * jnp.maximum(film.gap_change, 0.0)) / hertz_load,
        "outside_power": space.around(energy_out) / hertz_load,
        "load": space.total(whole),
        **numbers_of(friction),
    }


def touch_terms(space: Space, touch: Touch, H: Array, load: FloatLike, hertz_load: FloatLike) -> dict[str, Array]:
    """The numbers of solid contact by name: its share of the load (in F*), area, pressure and energy."""
    law = touch.asperities
    carried, area = space.total(touch.P), {} if law.area is None else {"contact_area": space.total(law.touching(H))}
    share = carried / jnp.maximum(jnp.asarray(load) * hertz_load, jnp.finfo(H.dtype).tiny)
    energy = space.total(law.stored(H)) / hertz_load
    return {"asperity_share": share, "P_asperity_max": touch.P.max(), **area, "asperity_energy": energy}


def with_outside(
    terms: Mapping[str, Any], velocity: Any, around: Surroundings, hertz_load: FloatLike, load_rate: FloatLike = 0.0
) -> dict[str, Any]:
    """The numbers of the account by name, with what the oil outside adds; traceable by JAX.

    terms: from `account_terms`.  load_rate: the rate of change of the load on the grid.
    """
    numbers = dict(terms)
    load = numbers.pop("load")
    numbers["elastic_energy"] += around.uplift * load / 2 / hertz_load
    numbers["outside_power"] += (velocity * around.load - around.uplift * load_rate) / hertz_load
    return numbers


# -- a step in time ----------------------------------------------------------------------------------------------------


def new_level(T: float, solution: StepSolution) -> State:
    """The state after a step; its record has the numbers of the film by name."""
    record = unpacked(solution.numbers)
    n = StepNumbers(*(record.pop(name) for name in StepNumbers._fields))
    status = Status.CONVERGED if n.converged else Status.NEWTON_STALLED  # stalled too if NaN
    work = Work(int(n.newton), int(n.krylov))
    numbers = n.outside, n.load, n.error, n.around
    return State(T, n.approach, n.velocity, solution.fields, status, work, *numbers, record)
