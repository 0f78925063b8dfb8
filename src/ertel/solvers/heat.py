"""The temperatures of a steady film and, in turn, the film that it becomes: rounds of two equations.

The energy equation (`equations.energy`) gives the temperatures in a film.  They give the share c and the mobility theta
of each column (`equations.columns`), with which Reynolds' equation gives another film (`equations.warm`), and so on
until the film stays.

* The energy equation takes the flow as given that the pressure drives through a column, not its gradient: where the oil
  gets thinner, the gradient falls with 1/theta.  At a given gradient the heat of an inlet would grow with its
  temperature without end.
* The next c and theta are those of the last rounds together that leave the least change (Anderson DG. J ACM
  1965;12:547-560), measured by the oil that flows.
* No round changes a temperature by more than `LARGEST_CHANGE`: the first ones have the heat of a cold film, which may
  be thousands of kelvins.

With a formula of the inlet, phi_T (`physics.thermal`), there are no rounds.  The temperatures are then those of the
isothermal film, thinner by phi_T everywhere.

A surface below the Peclet number `thermal.AT_REST` counts as one at rest.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from math import inf, isinf, pi
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
from ertel.equations.across import Vector
from ertel.equations.columns import WarmColumns
from ertel.equations.contact import opened, traceable
from ertel.equations.energy import Energy, sweeps_of
from ertel.equations.flow import flow_aligned, steady_rate
from ertel.numerics import halfspace
from ertel.numerics.grid import Grid
from ertel.numerics.integrals import Plane
from ertel.numerics.lobatto import Lobatto
from ertel.numerics.newton import gcr
from ertel.numerics.programs import Program, exportable
from ertel.numerics.stencils import inside, node_slopes
from ertel.physics.fluidity import limited_stress
from ertel.physics.geometry import Geometry
from ertel.physics.line_scales import LineScales
from ertel.physics.thermal import AT_REST, AT_REST_ON_A_LINE, Floats, Solid, peclet_number, response

POINTS = 7  # across the film
TOLERANCE = 1e-5  # of the last change of T, over its largest rise
LIMIT = 60  # of changes of the temperatures of a film that stays
IN_A_ROUND = 2  # changes of the temperatures
LARGEST_CHANGE = 100.0  # K, of a temperature in a round
REDUCTION = 1e-2  # of the residual of the linear equations
KRYLOV_LIMIT = 40
ROUNDS, DEPTH = 40, 4  # at most; of them together
AGREED, AS_A_GUESS = 3e-5, 3e-4  # a change of H_c and of H_min in the last round, over H_c; on coarser grids
LOOSE = 1e3  # tolerances, of the residual of a film within the rounds
LEAST_RISE = 1e-3  # K
FIRST_STEP = 0.6  # of the change of c and ln theta


class Heated(NamedTuple):
    """The temperatures of a contact and the friction of its warm film.

    inlet: L_t and phi_T, which is 1 where the film is solved with its heat, and on layers of oil the factor of
    `_of_layer`.  film: H in a^2/R.  Maps have its shape (n_y, n_x).
    T_1, T_2, T_film: temperatures of the surfaces and the mean across the film, K.  T: above that of the inlet at the
    points across the film from surface 2 to surface 1, shape (POINTS, n_y, n_x).
    stress: tau_m along X and Y in p_h a/R, zero where P = 0, shape (2, n_y, n_x); boundary: the part of asperities,
    along X.  sliding: its force over the load along X and Y, in a/R, shape (2,).
    share, theta: c, and theta along X and along Y, of these temperatures.  weight: of their changes, see `Rounds`.
    balance: the heat of the film, what flows into body 1 and into body 2, and what the oil takes along, in W.
    peclet: numbers of both surfaces.  iterations: changes of the temperatures.  converged: whether they are found.
    """

    inlet: Inlet
    film: Array
    T_1: Floats
    T_2: Floats
    T_film: Floats
    T: Floats
    stress: Array
    boundary: Array
    sliding: Array
    share: Array
    theta: Array
    weight: Array
    balance: tuple[float, ...]
    peclet: tuple[float, ...]
    iterations: int
    converged: bool


def heated(
    case: Case,
    P: Any,
    H: Any,
    grid: Grid | None = None,
    P_asperity: Any = None,
    factors: "WarmFactors | None" = None,
    limit: int = LIMIT,
) -> Heated:
    """The temperatures of a steady contact in SI; raises ValueError if it has no section [thermal].

    P, H: pressure of the oil and film on the grid, that of the case unless another is given; the isothermal film where
    a formula makes it thinner.  P_asperity: the pressure of asperities, which make heat of their own.  factors: with
    which the film was solved, none of an isothermal film; their temperatures change by `LARGEST_CHANGE` at most.
    limit: of the changes of the temperatures.
    """
    thermal, s, eta0 = case.thermal, case.scales, case.oil.eta0
    if thermal is None or s is None or eta0 is None:
        raise ValueError("thermal: the case has no such section, and so no data for temperatures")
    grid, mean = grid or grid_of(case), case.motion.entrainment(0.0) * s.front_speed
    size, pressure = case.geometry.grown(case.motion.load(0.0))  # the contact, by a load that [motion] changes
    slides = case.motion.slide_to_roll
    inlet = _of_layer(case, thermal.inlet_of(eta0, s.p_h * pressure / s.E_prime, mean, slides))
    speeds = abs(mean) * (1.0 + 0.5 * slides), abs(mean) * (1.0 - 0.5 * slides)
    half_width = s.a * case.geometry.extent[0] * size
    peclet = tuple(peclet_number(body, speed, half_width) for body, speed in zip(thermal.bodies, speeds, strict=True))

    turned = partial(flow_aligned, steady_rate(mean))  # X points downstream
    P, film = jnp.asarray(P), opened(inlet.factor * jnp.asarray(H))
    boundary = 0.0 if P_asperity is None or case.surfaces is None else case.surfaces.friction * s.p_h * P_asperity
    solid = jnp.broadcast_to(abs(slides * mean) * jnp.asarray(boundary, float), grid.shape)
    energy = _energy(case, grid, turned(P), turned(film), speeds, peclet, turned(solid))
    _, theta, T = (turned(jnp.asarray(each)) for each in factors or WarmFactors.of_cold(grid))
    found = _program(energy, T, theta, inf if factors is None else LARGEST_CHANGE, limit)

    plane, area = Plane.of(grid), s.a * (s.length if isinstance(s, LineScales) else s.a)
    balance = [float(plane.total(part)) * area for part in (found.heat, *found.into[::-1], found.carried)]
    found = found._replace(
        **{name: turned(getattr(found, name)) for name in ("T", "stress", "share", "theta", "weight")}
    )
    stress = found.stress * jnp.array([np.sign(mean), 1.0])[:, None, None]
    stress = jnp.where(P > 0.0, limited_stress(energy.columns.law, stress, s.p_h * P), 0.0)
    of_asperities = jnp.broadcast_to(np.sign(slides * mean) * jnp.asarray(boundary) / s.shear_stress, grid.shape)
    stress = (stress / s.shear_stress).at[0].add(of_asperities)
    T = np.asarray(found.T)
    return Heated(
        inlet=inlet,
        film=film,
        T_1=thermal.temperature + T[-1],
        T_2=thermal.temperature + T[0],
        T_film=thermal.temperature + np.asarray(energy.columns.across.integral(found.T)),
        T=T,
        stress=stress,
        boundary=of_asperities,
        sliding=shear_force(plane, stress) / (case.motion.load(0.0) * case.geometry.hertz_load),
        share=found.share,
        theta=found.theta,
        weight=found.weight,
        balance=tuple(balance),
        peclet=peclet,
        iterations=int(found.iterations),
        converged=bool(found.change <= TOLERANCE),
    )


def _of_layer(case: Case, inlet: Inlet) -> Inlet:
    """The inlet with the factor of a film on layers of oil: heat thins what a flooded inlet lets pass, not the layer.

    With the share R(r) of the flooded film on a layer r times as thick (`estimates.share_of`), the warm film is phi_T
    R(r/phi_T) times the cold flooded one: phi_T of that on much oil, all of the layer on little.
    """
    if inlet.factor == 1.0:
        return inlet
    r, share = starvation(case)
    if isinf(r):
        return inlet
    return inlet._replace(factor=inlet.factor * share_of(case, r / inlet.factor) / share)


def _energy(
    case: Case, grid: Grid, P: Array, film: Array, speeds: tuple[float, float], peclet: Sequence[float], solid: Any
) -> Energy:
    """The energy equation of a film, of which X points downstream.  film: in a^2/R."""
    thermal, s, eta0 = case.thermal, case.scales, case.oil.eta0
    assert thermal is not None and s is not None and eta0 is not None  # `heated`
    oil, spacing, h = traceable(case.lubricant), grid.spacing * s.a, _of_oil(P, film) * s.film
    laws = traceable(case.oil.fluidity_law), traceable(thermal.viscosity_of(eta0))
    ratio = jnp.log(oil.viscosity(P))
    gradient = Vector(*(s.p_h * h * node_slopes(P, spacing, grid.even)))
    columns = WarmColumns(*laws, s.p_h * P, h, eta0 * jnp.exp(ratio), ratio, gradient, *speeds, Lobatto.of(POINTS))
    rises = [_rise(*each, s.a, grid, case.geometry) for each in zip(thermal.bodies, speeds, peclet, strict=True)]
    return Energy(
        columns,
        thermal.density * thermal.heat_capacity * oil.density(P),
        thermal.conductivity,
        thermal.expansion,
        thermal.temperature,
        thermal.warmer[::-1],
        (rises[1], rises[0]),
        solid,
        spacing,
        grid.even,
    )


def _of_oil(P: Array, film: Array) -> Array:
    """The film of oil: in a cavity what came out of the last full gap upstream."""
    columns = jnp.arange(P.shape[1])
    last = jnp.maximum.accumulate(jnp.where(P > 0.0, columns, 0), axis=1)
    return jnp.where(P > 0.0, film, jnp.minimum(film, jnp.take_along_axis(film, last, axis=1)))


# -- how warm a surface gets -------------------------------------------------------------------------------------------


def _rise(body: Solid, speed: float, peclet: float, a: float, grid: Grid, geometry: Geometry) -> "Rise":
    if peclet >= (AT_REST_ON_A_LINE if geometry.is_line else AT_REST):
        return Moving(jnp.asarray(response(body, speed, grid.shape[1], grid.spacing * a)))
    # a source of the length l on a line heats its middle by ln(l/x)/(pi k), which is the sum of 1/(2 pi k r)
    resistance = a / ((1.0 if geometry.is_line else 2.0) * pi * body.conductivity)
    return Resting(halfspace.kernel(grid, resistance, reach=geometry.reach), grid.shape)


@register_dataclass
@dataclass(frozen=True)
class Moving:
    """K_i of a surface that passes through the contact.  response: from `thermal.response`."""

    response: Array

    def __call__(self, heat: Array) -> Array:
        """The temperature rise (K) from the heat flux into the surface (W/m^2)."""
        return heat @ self.response.T

    def split(self) -> tuple[Array, Array, Array]:
        """K of a node by itself, and by the number of nodes from one upstream and downstream, for a `ColumnSweep`."""
        return self.response[0, 0], self.response[:, 0], self.response[0]


@register_dataclass
@dataclass(frozen=True)
class Resting:
    """K_i of a surface at rest.  kernel: of the half space, with 1/(2 pi k) as its compliance."""

    kernel: halfspace.Kernel
    shape: tuple[int, int] = field(metadata={"static": True})

    def __call__(self, heat: Array) -> Array:
        """The temperature rise (K) from the heat flux into the surface (W/m^2)."""
        return self.kernel.displacement(inside(jnp.asarray(heat), self.kernel.even))

    def split(self) -> tuple[Array, Array, Array]:
        """As of `Moving`; a sweep counts all heat as the node's own, the most that it can be."""
        nothing = jnp.zeros(self.shape[1])
        return self(jnp.ones(self.shape)), nothing, nothing


Rise = Moving | Resting


# -- the temperatures of a film ----------------------------------------------------------------------------------------


@exportable
class _Found(NamedTuple):
    """The temperatures, and what follows from them, with X pointing downstream; see `Heated`.

    stress: t in Pa.  heat, into: W/m^2, the latter of surface 2 and of surface 1.  carried: with the oil, W/m^2.
    weight: how much a change of c and of theta along X and Y changes the oil that passes, over u_m h, shape (3, n_y,
    n_x).  change: the last one over the largest rise.
    """

    T: Array
    stress: Array
    share: Array
    theta: Array
    heat: Array
    into: tuple[Array, Array]
    carried: Array
    weight: Array
    iterations: Array
    change: Array


def _temperatures(energy: Energy, T: Array, held: Array, largest: Any, limit: Any) -> _Found:
    """Changes of the temperatures T until they stay, see `heated`."""
    across, start, c = energy.columns.across, T, energy.columns
    cold = c.mobility(jnp.zeros_like(T))

    def eased(theta: Array) -> Energy:
        """The equation with the gradient that drives the same flow as `held` does."""
        x, y = jnp.minimum(1.0, held / theta)
        return replace(energy, columns=replace(c, gradient=Vector(x * c.gradient.x, y * c.gradient.y)))

    def unsolved(state: Any) -> Array:
        T, change, n = state
        return (change > TOLERANCE) & (n < limit) & jnp.all(jnp.isfinite(T))

    def improve(state: Any) -> Any:
        T, _, n = state
        now = eased(c.mobility(T) / cold)
        m, warmer = jax.jvp(now.columns.motion, (T,), (jnp.ones_like(T),))
        softer = jnp.minimum(warmer.heat, 0.0)
        (size, sweeps), change = sweeps_of(now, m, softer), partial(now.change, m=m, softer=softer)

        def direction(_: Array, r: Array) -> Array:
            d = jnp.zeros_like(r)
            for sweep in sweeps:
                for back in (False, True):
                    d = d + sweep(r * size - change(d), back)
            return d

        d, _ = gcr(lambda d: change(d) / size, direction, -now.residual(T, m) / size, REDUCTION, KRYLOV_LIMIT)
        rise = jnp.maximum(jnp.max(jnp.abs(T + d)), LEAST_RISE)
        return T + d, jnp.max(jnp.abs(d)) / rise, n + 1

    T, change, n = jax.lax.while_loop(unsolved, improve, (T, jnp.asarray(jnp.inf), jnp.zeros((), jnp.int32)))
    most = jnp.max(jnp.abs(T - start))
    T = start + (T - start) * jnp.minimum(1.0, largest / jnp.maximum(most, LEAST_RISE))
    theta = c.mobility(T) / cold
    now = eased(theta)
    m, film = now.columns.motion(T), c.film
    driven = [c.film * jnp.abs(g) / (6.0 * c.viscosity * (c.u_1 + c.u_2)) for g in (c.gradient.x, c.gradient.y)]
    return _Found(
        T=T,
        stress=jnp.stack([m.stress.x, m.stress.y]),
        share=c.share(T),
        theta=theta,
        heat=film * across.integral(m.heat + energy.expansion * (energy.inlet + T) * now.compression(m)) + energy.solid,
        into=now.fluxes(T, m),
        carried=film * across.integral(now.carried(T, m)),
        weight=jnp.minimum(jnp.stack([jnp.where(c.pressure > 0.0, 1.0, 0.0), *driven]), 1.0),
        iterations=n,
        change=jnp.where(most > largest, jnp.inf, change),
    )


SMALL = POINTS * 40 * 65  # entries of T on a grid that is solved in less time than its program is optimised
_program = Program(jax.jit(_temperatures), SMALL)


# -- rounds ------------------------------------------------------------------------------------------------------------


class WarmFactors(NamedTuple):
    """c and theta of a warm film, theta along X and along Y, and T of `Heated`, from which they follow."""

    share: Any
    theta: Any
    T: Any

    @classmethod
    def of_cold(cls, grid: Grid) -> "WarmFactors":
        """Those of a film without heat."""
        return cls(np.ones(grid.shape), np.ones((2, *grid.shape)), np.zeros((POINTS, *grid.shape)))

    def finer(self) -> "WarmFactors":
        """On the grid that has a node between each two of this one, by straight lines."""
        return WarmFactors(*(_finer(_finer(each, -1), -2) for each in self))


def _finer(field: Any, axis: int) -> Any:
    field = np.moveaxis(np.asarray(field), axis, 0)
    if len(field) == 1:
        return np.moveaxis(field, 0, axis)
    finer = np.repeat(field, 2, axis=0)[:-1]
    finer[1::2] = 0.5 * (field[1:] + field[:-1])
    return np.moveaxis(finer, 0, axis)


class Rounds:
    """Anderson's iteration for c and ln theta, in which a change counts by what it does to the oil that passes."""

    def __init__(self, factors: WarmFactors):
        self.at = np.concatenate([factors.share[None], np.log(factors.theta)])
        self.past: list[tuple[Floats, Floats]] = []

    def next(self, found: Heated) -> WarmFactors:
        """The factors with which to go on."""
        weight = np.asarray(found.weight)
        new = np.concatenate([np.asarray(found.share)[None], np.log(found.theta)])
        step = new - self.at
        self.past = [*self.past, (self.at, step)][-DEPTH:]
        if len(self.past) == 1:
            self.at = self.at + FIRST_STEP * step
        else:
            ways, steps = ([now - before for before in earlier] for *earlier, now in zip(*self.past, strict=True))
            matrix = np.stack([(weight * each).ravel() for each in steps], axis=1)
            shares = np.linalg.lstsq(matrix, (weight * step).ravel(), rcond=1e-8)[0]
            less = [share * (way + each) for share, way, each in zip(shares, ways, steps, strict=True)]
            self.at = self.at + step - sum(less)
        return WarmFactors(self.at[0], np.exp(self.at[1:]), found.T)
