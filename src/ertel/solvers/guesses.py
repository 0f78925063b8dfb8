"""First guesses of a steady film: of the dry contact, of rigid bodies, and from a coarser grid."""

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array
from numpy.typing import NDArray

from ertel.case.case import Case
from ertel.case.estimates import starvation
from ertel.equations import contact, discretise
from ertel.equations.contact import Contact
from ertel.numerics import multigrid, stencils
from ertel.numerics.grid import Grid
from ertel.numerics.programs import ANY_SIZE, Program
from ertel.numerics.stencils import FloatLike, integral
from ertel.physics.far_field import ContactMotion
from ertel.physics.geometry import Geometry

Floats = NDArray[np.float64]

THICK = 3.0  # film in units of the dry approach, from which the first guess is that of rigid bodies
LEAST_LIFT = 1e-9  # a^2/R


def motion_of(case: Case, approach: float) -> ContactMotion:
    """The motion of the steady contact, for the oil outside."""
    m = case.motion
    return ContactMotion(approach, 0.0, m.load(0.0), m.entrainment(0.0), curvature=m.curvature(0.0))


def dry_guess(geometry: Geometry, grid: Grid, load: float) -> tuple[Floats, float]:
    """Pressure and approach of the dry contact under a load in units F*; the pressure is scaled to carry it exactly."""
    P = geometry.dry_pressure(load, grid.kept_x[None, :], grid.kept_y[:, None])
    needed = load * geometry.hertz_load / grid.spacing ** (1 if grid.nodes_y == 1 else 2)
    return P * (needed / stencils.unfolded(P, grid.even).sum()), geometry.dry_approach(load)


def rough_guess(case: Case, grid: Grid, c: Contact) -> tuple[Floats, float, Any]:
    """Pressure, approach and pressure of the oil of the first guess on the coarsest grid.

    They are those of the dry contact, or of rigid bodies where the film is far thicker than that.  Asperities carry
    what they would carry of the dry contact, without oil or with half the expected film.

    A line has the expected film below the dry pressure.  Without it no oil passes the contact, and none leaks to the
    sides either: Newton's iteration would push the surfaces through one another, where eps is zero and P goes astray.
    """
    outside, bend, load = discretise.outside_of(case, grid), case.motion.curvature(0.0), case.motion.load(0.0)
    film = case.film_scale * starvation(case)[1]
    if film > THICK * bend * case.geometry.dry_approach(load / bend):
        P = outside.at_first(motion_of(case, -film))
        return P, -film, P
    P, approach = dry_guess(case.geometry, grid, load / bend)
    P, approach = bend * P, bend * approach
    whole = P + outside.guess(motion_of(case, approach))
    below = film if grid.nodes_y == 1 else 0.0
    if c.asperities is None:
        return whole, approach - below, whole
    lift, H = lifted(c, P, approach, load * case.geometry.hertz_load, max(below, 0.5 * film))
    return whole, approach - float(lift), np.maximum(whole - np.asarray(c.asperities.pressure(H)), 0.0)


def _lifted_by_asperities(
    c: Contact, P: Array, approach: FloatLike, load: FloatLike, least: FloatLike
) -> tuple[Array, Array]:
    """By how much asperities alone would lift the bodies to carry a load, at least by so much; and H then."""
    asperities, H = c.asperities, contact.film_thickness(c, P, approach)
    assert asperities is not None

    def halve(_: int, ends: tuple[Array, Array]) -> tuple[Array, Array]:
        low, high = ends
        middle = 0.5 * (low + high)
        too_low = integral(asperities.pressure(jnp.maximum(H, 0.0) + jnp.exp(middle)), c.spacing, c.even) > load
        return jnp.where(too_low, middle, low), jnp.where(too_low, high, middle)

    low, _ = jax.lax.fori_loop(0, 50, halve, (jnp.log(LEAST_LIFT), jnp.log(10.0)))
    lift = jnp.maximum(jnp.exp(low), least)
    return lift, jnp.maximum(H, 0.0) + lift


def _unbalanced(c: Contact, P: Array, approach: FloatLike, P_f: Array) -> Array:
    """The load by which the oil and asperities do not make up P, over that of P."""
    assert c.asperities is not None
    rest = P - P_f - c.asperities.pressure(contact.film_thickness(c, P, approach))
    return integral(jnp.minimum(jnp.abs(rest), 1.0), c.spacing, c.even) / integral(P, c.spacing, c.even)


lifted = Program(jax.jit(_lifted_by_asperities), ANY_SIZE)
unbalanced = Program(jax.jit(_unbalanced), ANY_SIZE)


def _from_coarse(c: Contact, coarse: Array, starved: Array) -> Array:
    """Pressure on the finer grid; starved: only where it is above zero at all nodes around.

    Newton's iteration moves a meniscus upstream in fewer steps than it takes to correct one that lies too far upstream.
    """
    coarse = stencils.unfolded(coarse, c.even)
    full = multigrid.prolong(jnp.where(coarse > 0.0, 1.0, 0.0)) == 1.0
    # linear interpolation has steps in the slope, which cause a large residual in the inlet
    P = jnp.where(full | ~starved, multigrid.prolong_smooth(coarse), 0.0)
    return stencils.inside(stencils.folded(jnp.maximum(P, 0.0), c.even), c.even)


refined = Program(jax.jit(_from_coarse), ANY_SIZE)
