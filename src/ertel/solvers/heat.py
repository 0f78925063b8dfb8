"""Temperatures of a steady contact and the traction of its warm film, to the depth that practice uses.

The film's shape and pressure are those of the isothermal contact.  Three things are added to them:

* the inlet.  Its shear heating makes the film thinner by the factor phi_T everywhere (`physics.thermal`).
* the heat of sliding, tau_m.(u1 - u2) per area.  The film conducts it to the surfaces, which get warm as they pass
  through the contact (`physics.thermal`) or, at rest, in all directions; the mean temperature of the film lies above
  theirs.  The heat of the pressure flow is left out: it arises in the inlet, where it is that of
  phi_T, and the oil carries it along.
* the viscosity at the film's mean temperature, from which the stress tau_m follows.

Heat is conducted across the film only, with one temperature for the viscosity (Nahme R. Ing Arch 1940;11:191-209 has
one that varies across the film).  A surface below the Peclet number `thermal.AT_REST` counts as one at rest.

The balance of heat
-------------------
The film releases the heat q(T_f) per area, tau_m.(u1 - u2), which falls as the film gets warmer.  It conducts the heat
to both surfaces, and they warm up as the heat flows into them.  With the resistance r = h/k of the film

    q_1 = q/2 + c,   q_2 = q/2 - c,   r c = T_2 - T_1                      (conduction across the film, `thermal`)
    T_i = T_b,i + K_i q_i                                                  (flash temperature of each surface)
    T_f = (T_1 + T_2)/2 + r q/12                                           (mean over the film)
    q = q(T_f)

K_i is linear, of any kind: a moving surface, one at rest, or none at all (walls that stay cold).  Newton's iteration
solves for q and c at all nodes together, with `gcr` for its linear equations, which need nothing but K_1 and K_2.

There is exactly one solution.  Take the difference d of two, and sums over all nodes.  The released heat falls with
the temperature, so the sum of dq dT_f is not above zero.  The surfaces store heat and never give back more than they
took, so that the sums of dq_i K_i dq_i are not below zero.  By the equations, dq dT_f is the sum of dq_1 K_1 dq_1,
dq_2 K_2 dq_2, r dc^2 and r dq^2/12.  Therefore dq = 0.  What is known as two branches near the traction's maximum is
one of two things: an iteration T <- T(q(T)) that jumps to and fro, or two speeds of sliding with the same traction.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from math import isinf, pi
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array
from jax.tree_util import register_dataclass

from ertel.case.case import Case
from ertel.case.estimates import grid_of, share_of, starvation
from ertel.case.sections import Inlet
from ertel.equations.account import shear_force
from ertel.equations.contact import opened, traceable
from ertel.equations.shear import shear
from ertel.numerics import halfspace
from ertel.numerics.grid import Grid, Symmetry
from ertel.numerics.integrals import Plane
from ertel.numerics.newton import gcr
from ertel.numerics.programs import ANY_SIZE, Program, exportable
from ertel.numerics.stencils import inside, node_slopes
from ertel.physics.fluidity import Fluidity, limited_stress
from ertel.physics.geometry import Geometry
from ertel.physics.lubricant import Lubricant
from ertel.physics.thermal import AT_REST, Floats, Solid, WarmViscosity, peclet_number, response

TOLERANCE = 1e-6  # of the last change of T_f over its largest rise; the error is about its square
LIMIT = 100  # of Newton iterations; each makes a film that is far too stiff e times less so
REDUCTION = 1e-2  # of the residual of the linear equations
KRYLOV_LIMIT = 40


class Heated(NamedTuple):
    """The temperatures of a contact and the friction of its warm film.

    inlet: L_t and phi_T, on layers of oil the factor of `_of_layer`.  film: phi_T H in a^2/R, of the film's shape
    (n_y, n_x), as are all maps.  T_1, T_2, T_film: temperatures of the surfaces and mean temperature of the film, in K;
    where P = 0 T_film is the mean of the surfaces.
    heat: of sliding per area, in W/m^2.  stress: tau_m along X and Y in p_h a/R, zero where P = 0, shape (2, n_y, n_x).
    sliding: its force over the load along X and Y, in a/R, shape (2,); times a/R it is the traction coefficient.
    peclet: numbers of both surfaces.  iterations: of Newton's method; applications: how often the temperatures of both
    surfaces were computed from their heat, a convolution each; converged: whether the temperatures are found.
    """

    inlet: Inlet
    film: Array
    T_1: Floats
    T_2: Floats
    T_film: Floats
    heat: Floats
    stress: Array
    sliding: Array
    peclet: tuple[float, ...]
    iterations: int
    applications: int
    converged: bool


@register_dataclass
@dataclass(frozen=True)
class _Film:
    """The film without its temperature.  P: of the oil, in p_h.  H: phi_T h in m.  speed: u1 - u2 in m/s.

    spacing: in m.  boundary: the stress of asperities along X, in Pa.
    """

    law: Fluidity
    warm: WarmViscosity
    oil: Lubricant
    eta0: float
    p_h: float
    P: Array
    H: Array
    speed: float
    spacing: float
    boundary: Array | float
    even: Symmetry = field(metadata={"static": True})

    def stress(self, warmer: Array) -> Array:
        """tau_m in Pa along X and Y in a film that is so much warmer (K) than the inlet; zero where P = 0."""
        log_ratio = jnp.log(self.oil.viscosity(self.P))
        viscosity = self.eta0 * jnp.exp(log_ratio + self.warm.change(log_ratio, warmer))
        gradient = self.p_h * self.H * node_slopes(self.P, self.spacing, self.even)
        sliding = viscosity * self.speed / self.H
        pressure = self.p_h * self.P
        sheared = shear(self.law, pressure, jnp.stack([sliding, jnp.zeros_like(sliding)]), gradient)
        stress = jnp.where(self.P > 0.0, limited_stress(self.law, sheared.stress, pressure), 0.0)
        return stress.at[0].add(self.boundary)

    def __call__(self, warmer: Array) -> tuple[Array, Array]:
        """The heat tau_m.(u1 - u2) in W/m^2, and its derivative by the temperature at the node."""
        stress, slope = jax.jvp(self.stress, (warmer,), (jnp.ones_like(warmer),))
        return self.speed * stress[0], self.speed * slope[0]


_stress_program = Program(jax.jit(_Film.stress), ANY_SIZE)


def heated(
    case: Case, P: Any, H: Any, heat: Floats | None = None, grid: Grid | None = None, P_asperity: Any = 0.0
) -> Heated:
    """The temperatures of a steady contact in SI; raises ValueError if it has no section [thermal].

    P, H: pressure of the oil and isothermal film on the grid, that of the case unless another is given.  P_asperity:
    the pressure of asperities, which make heat of their own.  heat: of sliding per
    area (W/m^2), from which the iteration starts, none if it is left out.
    """
    thermal, s, eta0 = case.thermal, case.scales, case.oil.eta0
    if thermal is None or s is None or eta0 is None:
        raise ValueError("thermal: the case has no such section, and so no data for temperatures")
    S, mean, grid = case.motion.slide_to_roll, case.motion.entrainment(0.0) * s.front_speed, grid or grid_of(case)
    size, pressure = case.geometry.grown(case.motion.load(0.0))  # the contact, by a load that [motion] changes
    half_width = s.a * case.geometry.extent[0] * size
    inlet = _of_layer(case, thermal.inlet(eta0, s.p_h * pressure / s.E_prime, mean, S))
    film = opened(inlet.factor * jnp.asarray(H))
    sheared = _sheared(case, grid, thermal.viscosity_of(eta0), P, film, S * mean)
    if case.surfaces and case.touches:
        along_x = case.surfaces.friction * np.sign(S * mean)
        sheared = replace(sheared, boundary=along_x * s.p_h * jnp.asarray(P_asperity))
    moving = list(zip(thermal.bodies, (mean * (1.0 + 0.5 * S), mean * (1.0 - 0.5 * S)), strict=True))
    peclet = tuple(peclet_number(body, speed, half_width) for body, speed in moving)
    at = s.a, grid, case.geometry
    rises = [_rise(body, speed, number, *at) for (body, speed), number in zip(moving, peclet, strict=True)]
    warm = warmed(sheared, rises, np.asarray(sheared.H) / thermal.conductivity, thermal.warmer, heat)
    stress = _stress_program(sheared, warm.film) / s.shear_stress
    return Heated(
        inlet=inlet,
        film=film,
        T_1=thermal.temperature + warm.surface_1,
        T_2=thermal.temperature + warm.surface_2,
        T_film=thermal.temperature + warm.film,
        heat=warm.x[0],
        stress=stress,
        sliding=shear_force(Plane.of(grid), stress) / (case.motion.load(0.0) * case.geometry.hertz_load),
        peclet=peclet,
        iterations=int(warm.iterations),
        applications=int(warm.applications),
        converged=bool(warm.converged),
    )


def _of_layer(case: Case, inlet: Inlet) -> Inlet:
    """The inlet with the factor of a film on layers of oil: heat thins what a flooded inlet lets pass, not the layer.

    With the share R(r) of the flooded film on a layer r times as thick (`estimates.share_of`), the warm film is phi_T
    R(r/phi_T) times the cold flooded one: phi_T of that on much oil, all of the layer on little.
    """
    r, share = starvation(case)
    if isinf(r):
        return inlet
    return inlet._replace(factor=inlet.factor * share_of(case, r / inlet.factor) / share)


def _sheared(case: Case, grid: Grid, warm: WarmViscosity, P: Any, film: Array, speed: float) -> _Film:
    s, eta0 = case.scales, case.oil.eta0
    assert s is not None and eta0 is not None  # `heated`
    law, warm, oil = traceable(case.oil.fluidity_law), traceable(warm), traceable(case.lubricant)
    return _Film(law, warm, oil, eta0, s.p_h, jnp.asarray(P), film * s.film, speed, grid.spacing * s.a, 0.0, grid.even)


def _rise(body: Solid, speed: float, peclet: float, a: float, grid: Grid, geometry: Geometry) -> "Rise":
    if peclet >= AT_REST:
        return Moving(response(body, speed, grid.shape[1], grid.spacing * a))
    # a source of the length l on a line heats its middle by ln(l/x)/(pi k), which is the sum of 1/(2 pi k r)
    resistance = a / ((1.0 if geometry.is_line else 2.0) * pi * body.conductivity)
    return Resting(halfspace.spectrum(grid, resistance, reach=geometry.reach), grid.even)


# -- the balance of heat -----------------------------------------------------------------------------------------------


class Moving(NamedTuple):
    """K_i of a surface that passes through the contact.  response: from `thermal.response`."""

    response: Any

    def __call__(self, heat: Any) -> Any:
        """The temperature rise (K) from the heat flux into the surface (W/m^2)."""
        return heat @ self.response.T


@register_dataclass
@dataclass(frozen=True)
class Resting:
    """K_i of a surface at rest.  kernel: of the half space, with 1/(2 pi k) as its compliance."""

    kernel: Array
    even: Symmetry = field(metadata={"static": True})

    def __call__(self, heat: Any) -> Any:
        """The temperature rise (K) from the heat flux into the surface (W/m^2)."""
        return halfspace.surface_displacement(self.kernel, inside(jnp.asarray(heat), self.even), self.even)


Rise = Moving | Resting


@exportable
class Warmed(NamedTuple):
    """Temperatures and the work to find them.

    x: q and c in W/m^2.  surface_1, surface_2, film: T_1, T_2, T_f in K.  iterations: of Newton's method.
    applications: how often K_1 and K_2 were applied.
    """

    x: Any
    surface_1: Any
    surface_2: Any
    film: Any
    iterations: Any
    applications: Any
    converged: Any


def warmed(
    release: Callable[[Any], tuple[Any, Any]],
    rises: Sequence[Rise],
    resistance: Floats,
    bodies: Sequence[float] = (0.0, 0.0),
    heat: Floats | None = None,
) -> Warmed:
    """The temperatures of the film and of both surfaces.

    release: q (W/m^2) and dq/dT_f <= 0 at T_f; traceable by JAX, and a pytree.  rises: K_1 and K_2, linear.
    resistance: r = h/k of the film, m^2 K/W, above zero, of any shape.  bodies: T_b,1 and T_b,2, in the scale in which
    `release` takes T_f.  heat: q from which the iteration starts; a film that releases none if it is left out.
    """
    q = np.zeros_like(resistance) if heat is None else heat
    return jax.device_get(_program(_Balance(release, tuple(rises), resistance, tuple(bodies)), q))


class _Balance(NamedTuple):
    """The equations for x = (q, c), see `warmed`."""

    release: Any
    rises: Sequence[Rise]
    resistance: Any
    bodies: Sequence[Any]

    def rise(self, x: Array) -> tuple[Array, Array, Array]:
        """The rise of the temperatures of both surfaces and of the film by the heat."""
        rise_1, rise_2 = self.rises[0](0.5 * x[0] + x[1]), self.rises[1](0.5 * x[0] - x[1])
        return rise_1, rise_2, 0.5 * (rise_1 + rise_2) + self.resistance * x[0] / 12.0

    def temperatures(self, x: Array) -> tuple[Array, Array, Array]:
        """T_1, T_2 and T_f."""
        (body_1, body_2), (rise_1, rise_2, film) = self.bodies, self.rise(x)
        return body_1 + rise_1, body_2 + rise_2, 0.5 * (body_1 + body_2) + film

    def newton_change(self, w: Warmed, coldest: Array) -> tuple[Array, Array]:
        """The change of x, and how often K_1 and K_2 were applied for it.

        Each equation is divided by about the diagonal of its own derivative.
        """
        # no film gets colder than both bodies, but an iterate may, and the viscosity of very cold oil is not a number
        release, slope = self.release(jnp.maximum(w.film, coldest))
        ones = jnp.ones_like(self.resistance)
        # the most that they resist, under heat everywhere upstream
        surfaces = self.rises[0](ones) + self.rises[1](ones)
        along, across = 1.0 - slope * (0.25 * surfaces + self.resistance / 12.0), self.resistance + surfaces
        wrong = (w.x[0] - release) / along, (self.resistance * w.x[1] + w.surface_1 - w.surface_2) / across

        def derivative(d: Array) -> Array:
            rise_1, rise_2, film = self.rise(d)
            return jnp.stack([(d[0] - slope * film) / along, (self.resistance * d[1] + rise_1 - rise_2) / across])

        return gcr(derivative, lambda k, r: r, -jnp.stack(wrong), REDUCTION, KRYLOV_LIMIT)


def _solved(balance: _Balance, q: Array) -> Warmed:
    """Newton's iteration from the heat q."""
    coldest = jnp.minimum(*balance.bodies)

    def is_unsolved(w: Warmed) -> Array:
        return ~w.converged & (w.iterations < LIMIT) & jnp.all(jnp.isfinite(w.film))

    def improve(w: Warmed) -> Warmed:
        change, applications = balance.newton_change(w, coldest)
        T_1, T_2, film = balance.temperatures(w.x + change)
        rise = jnp.maximum(jnp.max(jnp.abs(film - coldest)), 1e-300)
        converged = jnp.max(jnp.abs(film - w.film)) <= TOLERANCE * rise
        done = w.applications + applications + 1
        return Warmed(w.x + change, T_1, T_2, film, w.iterations + 1, done, converged)

    x = jnp.stack([q, jnp.zeros_like(q)])
    zero = jnp.zeros((), jnp.int32)
    start = Warmed(x, *balance.temperatures(x), zero, zero + 2, zero > 0)
    return jax.lax.while_loop(is_unsolved, improve, start)


_program = Program(jax.jit(_solved), ANY_SIZE)
