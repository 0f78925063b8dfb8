"""The account of the film at one time: the budgets of mass and energy, and the friction.

The budgets say what is stored, what flows and what is lost; for the friction see `friction`.

Mass: Reynolds' equation integrated over the grid, with the Poiseuille flux rho q (Newtonian: -eps grad P):

    d/dT [integral of rho H] + outflow - inflow = cavity source

* outflow, inflow: the integrals of rho q.n + U rho H n_x along the edge, where it points outwards and where inwards.
* cavity source: where P = 0 the film grows faster than oil flows in.  The model fills it; a real film cavitates.

Energy: Reynolds' equation times the enthalpy h(P) = integral of dP/rho, integrated over the grid.  The film thickness
H = -Delta + G + D has the gap G (with the roughness) and the deformation D.  The elastic kernel is symmetric, so

    F V = d/dT [E_solids + E_oil] + dissipation - surface power + outside power

* E_solids = 1/2 integral of P D: elastic energy of the solids.  D has the uplift by the oil outside.  The energy that
  its pressure shares with that on the grid, 1/2 uplift times load, comes on top.
* E_oil = integral of (rho h - P) H: elastic energy of the compressed oil.
* dissipation = - integral of rho q.grad h: what the pressure spends on the Poiseuille flow.  For a Newtonian oil it is
  viscous, eps grad P.grad h.  Sliding of the surfaces dissipates too, exactly what it takes to drive it; both are left
  out here, and counted in the power loss of `friction`.  For an oil that thins, sliding and pressure act together: the
  flux is that of `thinning`, and the work of sliding, tau_m.(u1 - u2), is again left out on both sides.
* surface power = - integral of P DG/DT: what the moving surfaces do on the film, by rolling (- U P dG/dX, whose sum is
  the hydrodynamic rolling resistance) and by roughness that moves relative to the flow.  Where the gap closes the film
  takes power from the surfaces, where it opens it gives most of it back.
* outside power: what goes to the oil outside the grid, V times its load less the uplift times the rate of the load on
  the grid, and with the flow through the edge, integral of h rho q.n + U (rho h - P) H n_x.

With the kinetic energy of the ball, inertia V dV/dT = (w - F) V, the work of the applied load w and of the surfaces is
stored, dissipated, or lost to the outside.  Energies are in units F* a^2/R, powers in F* a^2/(R t0).  Mass is in
rho0 a^4/R: in SI a volume, that of the oil at ambient pressure.

The flow through the edge is not taken from the solver's own fluxes, so the budgets can fail.
"""

from collections.abc import Mapping
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
from jax import Array

from ertel.case.case import Case
from ertel.equations import discretise, friction
from ertel.equations.contact import Contact, mass
from ertel.equations.flow import wedge
from ertel.equations.friction import Friction
from ertel.equations.state import GridSolution
from ertel.numerics.integrals import Plane, Space
from ertel.numerics.programs import ANY_SIZE, Program, exportable
from ertel.numerics.stencils import Pair, inside
from ertel.physics.far_field import ContactMotion
from ertel.physics.lubricant import Lubricant

Number = Array | float
MASSES = ("mass", "inflow", "outflow", "cavity_source")
ENERGIES = ("elastic_energy", "oil_energy", "dissipation", "power_from_surfaces", "power_to_surfaces", "outside_power")

INTEGRALS = (*MASSES, *ENERGIES, "load")


class Film(NamedTuple):
    """The film at one time.

    P, H, eps: pressure, film thickness, mobility.  heat: - rho q.grad h at the nodes.  deformation: of the solids.
     growth: D(rho H)/DT + div(Poiseuille flux), the residual of Reynolds' equation, which is not zero where
    P = 0.  U: entrainment.  gap_change: DG/DT.
    """

    P: Array
    H: Array
    eps: Pair
    heat: Array
    deformation: Array
    growth: Array
    U: Number
    gap_change: Number


@exportable
class Account(NamedTuple):
    """The terms of the budgets, and the friction."""

    terms: Mapping[str, Array]
    friction: Friction


class Moment(NamedTuple):
    """What an account needs besides the fields.

    approach: Delta.  U, sliding: of the flow along X, and u1 - u2, in a/t0.  gap_change: DG/DT.  load: what the film
    carries, in F*.  hertz_load: F* in a^2 p_h.
    """

    approach: Number
    U: Number
    sliding: Number
    gap_change: Array
    load: Number
    hertz_load: Number


def account(space: Plane, c: Contact, P: Array, H: Array, m: Moment, change: Array) -> Account:
    """The account of a film on the 2-D grid.  change: D(rho H)/DT."""
    details = c.flow.details(c, P, H, m.sliding, space)
    growth = change - inside(details.gain, c.even)
    film = Film(P, H, details.mobility, details.heat, H + m.approach - c.gap, growth, m.U, m.gap_change)
    found = friction.of_details(space, details, P, H, m.sliding, m.load, m.hertz_load)
    return Account(integrals(space, c.lubricant, film), found)


def integrals(space: Space, oil: Lubricant, film: Film) -> dict[str, Array]:
    """All terms of both budgets on the grid by name, and "load", the double integral of P."""
    P, H, eps, U = film.P, film.H, film.eps, film.U
    mass, enthalpy, compressed = oil.density(P) * H, oil.enthalpy(P), oil.compression(P) * H
    squeezed_out = space.flow_out(eps, P)
    out = squeezed_out + U * space.along_x(mass)
    energy_out = squeezed_out * space.edge(enthalpy) + U * space.along_x(compressed)
    return {
        "mass": space.total(mass),
        "inflow": space.around(jnp.maximum(-out, 0.0)),
        "outflow": space.around(jnp.maximum(out, 0.0)),
        "cavity_source": space.total(jnp.where(P > 0.0, 0.0, film.growth)),
        "elastic_energy": space.total(P * film.deformation) / 2,
        "oil_energy": space.total(compressed),
        "dissipation": space.total(film.heat),
        "power_from_surfaces": space.total(P * jnp.maximum(-film.gap_change, 0.0)),
        "power_to_surfaces": space.total(P * jnp.maximum(film.gap_change, 0.0)),
        "outside_power": space.around(energy_out),
        "load": space.total(P),
    }


class Around(NamedTuple):
    """The oil outside the grid: its load, its uplift of the grid, and the rate of change of the load on the grid."""

    load: float
    uplift: float
    grid_load_rate: float = 0.0


def terms(found: Mapping[str, Any], velocity: float, around: Around, hertz_load: float) -> dict[str, float]:
    """`MASSES` and `ENERGIES` in their units, from `integrals`, with what the oil outside adds."""
    plain = {name: float(value) for name, value in found.items()}
    plain["elastic_energy"] += around.uplift * plain["load"] / 2
    plain["outside_power"] += velocity * around.load - around.uplift * around.grid_load_rate
    return {name: plain[name] / (hertz_load if name in ENERGIES else 1.0) for name in (*MASSES, *ENERGIES)}


def steady(case: Case, s: GridSolution) -> tuple[dict[str, float], Friction]:
    """`MASSES` and `ENERGIES` of a steady contact on one of its grids, and its friction."""
    c, m, scale = discretise.contact_of(case, s.grid), case.motion, case.geometry.hertz_load
    U, load = m.entrainment(0.0), m.load(0.0)
    moment = Moment(s.approach, U, m.sliding(0.0), discretise.gap_change(case, s.grid, 0.0), load, scale)
    found: Account = _steady_program(Plane.of(s.grid), c, s.P, s.H, moment)
    around = discretise.outside_of(case, s.grid).at(ContactMotion(s.approach, 0.0, load, U))
    plain = jax.device_get(found.terms)
    return terms(plain, 0.0, Around(s.outside, around.uplift), scale), found.friction


def _steady(space: Plane, c: Contact, P: Array, H: Array, m: Moment) -> Account:
    return account(space, c, P, H, m, wedge(mass(c, P, H), m.U, c.spacing))


_steady_program = Program(jax.jit(_steady), ANY_SIZE)
