"""Temperatures of a steady contact and the traction of its warm film, to the depth that practice uses.

The film's shape and pressure are those of the isothermal contact.  Three things are added to them:

* the inlet.  Its shear heating makes the film thinner by the factor phi_T everywhere (`physics.thermal`).
* the heat of sliding, tau_m.(u1 - u2) per area.  The film conducts it to the surfaces, which get warm as they pass
  through the contact (`physics.flash`) or, at rest, in all directions; the mean temperature of the film lies above
  theirs (`physics.warming`).  The heat of the pressure flow is left out: it arises in the inlet, where it is that of
  phi_T, and the oil carries it along.
* the viscosity at the film's mean temperature, from which the stress tau_m follows.

Heat is conducted across the film only, with one temperature for the viscosity (Nahme R. Ing Arch 1940;11:191-209 has
one that varies across the film).  A surface below the Peclet number `flash.AT_REST` counts as one at rest.
"""

from dataclasses import dataclass, field
from math import cbrt, pi
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array
from jax.tree_util import register_dataclass

from ertel.case.case import Case
from ertel.case.grids import grid_of
from ertel.case.thermal import Inlet
from ertel.equations.contact import opened, traceable, traceable_law
from ertel.equations.shear import shear
from ertel.equations.state import GridSolution
from ertel.numerics import halfspace
from ertel.numerics.grid import Grid, Symmetry
from ertel.numerics.integrals import Plane
from ertel.numerics.programs import ANY_SIZE, Program
from ertel.numerics.stencils import central_slopes, extended, inside
from ertel.physics import flash
from ertel.physics.fluidity import Fluidity, limited_stress
from ertel.physics.lubricant import Lubricant
from ertel.physics.thermal import Exponential, Houpert, Solid, WarmViscosity
from ertel.physics.warming import Real, Rise, warmed

for _law in (Houpert, Exponential):
    register_dataclass(_law)


class Heated(NamedTuple):
    """The temperatures of a contact and the friction of its warm film.

    inlet: L_t and phi_T.  film: phi_T H in a^2/R, of the film's shape (n_y, n_x), as are all maps.  T_1, T_2, T_film:
    temperatures of the surfaces and mean temperature of the film, in K; where P = 0 T_film is the mean of the surfaces.
    heat: of sliding per area, in W/m^2.  stress: tau_m along X and Y in p_h a/R, zero where P = 0, shape (2, n_y, n_x).
    sliding: its force over the load along X and Y, in a/R, shape (2,); times a/R it is the traction coefficient.
    peclet: numbers of both surfaces.  iterations: of Newton's method; applications: how often the temperatures of both
    surfaces were computed from their heat, a convolution each; converged: whether the temperatures are found.
    """

    inlet: Inlet
    film: Array
    T_1: Real
    T_2: Real
    T_film: Real
    heat: Real
    stress: Array
    sliding: Array
    peclet: tuple[float, ...]
    iterations: int
    applications: int
    converged: bool


@register_dataclass
@dataclass(frozen=True)
class _Film:
    """The film without its temperature.  P: in p_h.  H: phi_T h in m.  speed: u1 - u2 in m/s.  spacing: in m."""

    law: Fluidity
    warm: WarmViscosity
    oil: Lubricant
    eta0: float
    p_h: float
    P: Array
    H: Array
    speed: float
    spacing: float
    even: Symmetry = field(metadata={"static": True})

    def stress(self, warmer: Array) -> Array:
        """tau_m in Pa along X and Y in a film that is so much warmer (K) than the inlet; zero where P = 0."""
        log_ratio = jnp.log(self.oil.viscosity(self.P))
        viscosity = self.eta0 * jnp.exp(log_ratio + self.warm.change(log_ratio, warmer))
        slopes = central_slopes(extended(self.P, self.even), self.spacing)
        gradient = self.p_h * self.H * jnp.stack([slope[1:-1, 1:-1] for slope in slopes])
        sliding = viscosity * self.speed / self.H
        pressure = self.p_h * self.P
        found = shear(self.law, pressure, jnp.stack([sliding, jnp.zeros_like(sliding)]), gradient)
        return jnp.where(self.P > 0.0, limited_stress(self.law, found.stress, pressure), 0.0)

    def heat(self, warmer: Real) -> tuple[Real, Real]:
        """tau_m.(u1 - u2) in W/m^2, and its derivative by the temperature."""
        stress, slope = _program(self, warmer)
        return np.asarray(stress[0]) * self.speed, np.asarray(slope[0]) * self.speed


def _stress_and_slope(film: _Film, warmer: Array) -> tuple[Array, Array]:
    """tau_m, and its derivative by the temperature at the node."""
    return jax.jvp(film.stress, (warmer,), (jnp.ones_like(warmer),))


_program = Program(jax.jit(_stress_and_slope), ANY_SIZE)


def of_solution(case: Case, s: GridSolution) -> Heated:
    """The temperatures of a steady contact with the section [thermal], on one of its grids."""
    return heated(case, s.P, s.H, grid=s.grid)


def heated(
    case: Case, P: Any, H: Any, slide_to_roll: float | None = None, heat: Real | None = None, grid: Grid | None = None
) -> Heated:
    """The temperatures of a steady contact with the section [thermal].

    Parameters
    ----------
    case : Case
        The case, in SI.
    P, H : array
        Pressure and isothermal film on the case's grid, shape (n_y, n_x) as stored.
    slide_to_roll : float, optional
        Another one than the case's.
    heat : array, optional
        Heat of sliding per area (W/m^2) from which the iteration starts; none if it is left out.  There is one
        solution, wherever it starts, see `physics.warming`.
    grid : Grid, optional
        That of P and H, if it is not the case's.

    Raises ValueError if the case has no section [thermal].
    """
    thermal, s, eta0 = case.thermal, case.scales, case.oil.eta0
    if thermal is None or s is None or eta0 is None:
        raise ValueError("thermal: the case has no such section, and so no data for temperatures")
    S = case.motion.slide_to_roll if slide_to_roll is None else slide_to_roll
    mean, grid = case.motion.entrainment(0.0) * s.front_speed, grid or grid_of(case)
    grown = cbrt(case.motion.load(0.0))  # the contact, by a load that [motion] changes
    half_width = s.a * case.geometry.extent[0] * grown
    inlet = thermal.inlet(eta0, s.p_h * grown / s.E_prime, mean, S)
    film = opened(inlet.factor * jnp.asarray(H))
    sheared = _sheared(case, grid, thermal.viscosity_of(eta0), P, film, S * mean)
    moving = list(zip(thermal.bodies, (mean * (1.0 + 0.5 * S), mean * (1.0 - 0.5 * S)), strict=True))
    peclet = tuple(flash.peclet_number(body, speed, half_width) for body, speed in moving)
    rises = [_rise(body, speed, number, s.a, grid) for (body, speed), number in zip(moving, peclet, strict=True)]
    found = warmed(sheared.heat, rises, np.asarray(sheared.H) / thermal.conductivity, thermal.warmer, heat)
    stress = _program(sheared, found.film)[0] / s.shear_stress
    return Heated(
        inlet=inlet,
        film=film,
        T_1=thermal.temperature + found.surface_1,
        T_2=thermal.temperature + found.surface_2,
        T_film=thermal.temperature + found.film,
        heat=found.heat,
        stress=stress,
        sliding=_force(grid, stress) / (case.motion.load(0.0) * case.geometry.hertz_load),
        peclet=peclet,
        iterations=found.iterations,
        applications=found.applications,
        converged=found.converged,
    )


def _sheared(case: Case, grid: Grid, warm: WarmViscosity, P: Any, film: Array, speed: float) -> _Film:
    s, eta0 = case.scales, case.oil.eta0
    assert s is not None and eta0 is not None  # `heated`
    law, oil = traceable_law(case.oil.fluidity_law), traceable(case.lubricant)
    return _Film(law, warm, oil, eta0, s.p_h, jnp.asarray(P), film * s.film, speed, grid.spacing * s.a, grid.even)


def _force(grid: Grid, stress: Array) -> Array:
    """The double integral of the stress, shape (2,); along Y it is odd about an axis Y = 0."""
    plane = Plane.of(grid)
    return jnp.stack([plane.total(stress[0]), jnp.zeros(()) if grid.even.y else plane.total(stress[1])])


def _rise(body: Solid, speed: float, peclet: float, a: float, grid: Grid) -> Rise:
    """How warm a surface gets by the heat that flows into it: as it passes through the contact, or at rest."""
    if peclet >= flash.AT_REST:
        response = flash.response(body, speed, grid.shape[1], grid.spacing * a)
        return lambda heat: np.asarray(heat @ response.T)
    kernel = halfspace.spectrum(grid, a / (2.0 * pi * body.conductivity))
    return lambda heat: np.asarray(
        halfspace.surface_displacement(kernel, inside(jnp.asarray(heat), grid.even), grid.even)
    )
