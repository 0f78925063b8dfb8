"""The isothermal flow of an oil that thins under shear, in two dimensions.

Across a thin film the shear stress is linear, tau = tau_m + zeta grad p with zeta from -h/2 to h/2.  The oil's law
gives the shear rate du/dz = (phi/eta) tau.  From the velocities of the surfaces follow two equations for the stress
tau_m in the middle of the film, and then the flux (Yang P, Wen S. J Tribol 1990;112:631-636, where eta and rho are
uniform across the film).  With g = h grad p and s = eta (u1 - u2)/h, both in Pa, and zeta in units of h:

    integral of phi tau dzeta = s                            (sliding)
    volume flux = u_m h - (h^2/eta) Q,     Q = integral of zeta phi tau dzeta           Newtonian: tau_m = s, Q = g/12

Surface 1 is the upper one, at z = h/2.  phi = phi(|tau|) contains both components: sliding thins the oil for the flow
in all directions, and so does the pressure gradient in pure rolling.

The equations are exact for a film of uniform eta and rho.  The flux of their solution here has the error of the sums
below: up to 1e-5 for Eyring's law.  It is largest in pure rolling where the gradient, h |grad p|, is more than ten
times the stress of the law: 6e-4 for Carreau's and Carreau and Yasuda's with n = 0.3 to 0.5, and 3e-3 for a limited law
where the stress at the walls just comes to the limit.  Nothing is claimed where it exceeds eight times the limit.

* The integrals are sums over NODES nodes.  With the sums S_k of zeta^k phi they are S_0 tau_m + S_1 g and S_1 tau_m +
  S_2 g.  The nodes lie in pairs, so that a Newtonian oil gets exactly S_1 = 0.
* tau_m comes from Newton's iteration in a variable in which the equations are nearly linear: Eyring's asinh.
* Where the oil hardly thins, a series of two terms stands for phi, and the sums are exact integrals of it.  It is
  checked against the law at every point: phi has an error of `SERIES_ERROR`.  This holds at about 90 % of the points.
* The derivative is that of an implicit function, from the moments A, C, D = integrals of (1, zeta, zeta^2) d(phi
  tau)/dtau:  A dtau_m = ds - C dg,  dQ = C dtau_m + D dg.  These are symmetric, and D - C A^-1 C is positive definite.

What is given and returned has the shape (2, ...): along X and along Y, then the shape of the fields.
"""

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
from jax import Array, tree
from jax.custom_derivatives import SymbolicZero

from ertel.equations import across
from ertel.equations.across import Moments, Series, Tensor, Vector, dot, length
from ertel.numerics.programs import in_blocks
from ertel.physics.fluidity import Fluidity

NODES = 8  # across the film, even
TOLERANCE = 1e-7  # of the last change of tau_m in units of the stress at the walls; the error is about its square
CLOSE = 1e-3  # a change after which the next one is the last
LIMIT = 40  # of Newton iterations


class ShearedFilm(NamedTuple):
    """The quantities on which the flow depends: law, pressure, sliding and gradient, as in `shear`."""

    law: Fluidity
    pressure: Array
    sliding: Vector
    gradient: Vector


class Shear(NamedTuple):
    """The flow across the film.

    stress: tau_m, shape (2, ...), in Pa.  flux: Q, shape (2, ...), in Pa; the volume flux is u_m h - (h^2/eta) Q.
    by_gradient: dQ/dg at constant sliding, positive definite.  iterations: Newton iterations that were needed, the
    largest of all nodes; 0 where the series is enough.
    """

    stress: Array
    flux: Array
    by_gradient: Tensor
    iterations: Array


def shear(law: Fluidity, pressure: Array, sliding: Array, gradient: Array, points: int = NODES) -> Shear:
    """The mid-plane stress and the flux, by a number of nodes across the film.

    pressure: in Pa, shape (...).  sliding: s = eta (u1 - u2)/h in Pa, the mid-plane stress of a Newtonian oil, shape
    (2, ...).  gradient: g = h grad p in Pa, shape (2, ...).  All finite; differentiable (forward and reverse) in all of
    them and in the numbers of the law, which must be a JAX pytree (`contact.traceable`).
    """
    film = ShearedFilm(law, pressure, Vector(*sliding), Vector(*gradient))
    solution = solved_film(film, points)
    stress, flux = (jnp.stack([of.x, of.y]) for of in attached(film, solution))
    return Shear(stress, flux, solution.by_gradient, jnp.max(solution.iterations))


def solved_film(film: ShearedFilm, points: int = NODES, guess: Vector | None = None) -> "SolvedFilm":
    """The flow across a film and its derivatives, all held when they are differentiated (see `attached`).

    guess: of the stress in the middle, which saves iterations.
    """
    law, p, s, g = jax.lax.stop_gradient(film)
    series, change = _with_change(lambda p: across.series_of(law, p, s, g), p)
    simple = _of_series(series, change, s, g)
    return in_blocks(partial(_solved, law, points), ~series.holds, simple, p, s, g, jax.lax.stop_gradient(guess))


# -- where the oil hardly thins ---------------------------------------------------------------------------------------


def _of_series(series: Series, change: Series, sliding: Vector, gradient: Vector) -> "SolvedFilm":
    """The solution by the series: two iterations from the stress of a Newtonian oil.  change: by the pressure."""
    t = sliding
    for _ in range(2):
        m = across.series_moments(series, across.integrals_of_stress(t, gradient), t, gradient)
        t = t + divided(m.A, sliding - _flow(m.s, t, gradient)[0])
    of_stress = across.integrals_of_stress(t, gradient)
    m, by_pressure = across.series_moments(series, of_stress, t, gradient), across.series_sums(change, of_stress)
    return _solution(m, by_pressure, t, gradient, jnp.zeros(series.holds.shape, jnp.int32))


# -- the stress in the middle -----------------------------------------------------------------------------------------


class _Iterate(NamedTuple):
    """The best tau_m so far, the change to try next, and the size of the residual there, at every node.

    left: above one where the iteration is not yet done.
    """

    stress: Vector
    change: Vector
    residual: Array
    left: Array
    iterations: Array


def _solved(
    law: Fluidity, points: int, pressure: Array, sliding: Vector, gradient: Vector, guess: Vector | None
) -> "SolvedFilm":
    """The solution, with the number of iterations, the same at each point."""
    resting = _resting(law, points, pressure, gradient)
    aim, _ = _bent(law, pressure, sliding / resting)
    nodes = across.gauss_nodes(law, points, pressure, aim, gradient)

    def moments(t: Vector) -> Moments:
        return across.moments_by_nodes(law, pressure, t, gradient, nodes)

    t, iterations = middle_stress(law, pressure, sliding, gradient, resting, moments, guess)
    count = jnp.full(pressure.shape, iterations)
    _, by_pressure = _with_change(lambda p: across.sums_by_nodes(law, p, t, gradient, nodes), pressure)
    return _solution(moments(t), by_pressure, t, gradient, count)


def middle_stress(
    law: Fluidity,
    pressure: Array,
    sliding: Vector,
    gradient: Vector,
    resting: Array,
    moments: Callable[[Vector], Moments],
    guess: Vector | None = None,
) -> tuple[Vector, Array]:
    """tau_m and the number of iterations.  moments: of the film with this tau_m.  resting: its fluidity F, see below.

    With the fluidity F of the film without sliding, measured along the gradient, and psi(v) = stress(|v|) v/|v|, the
    equation is psi(sliding(tau_m)/F) = psi(s/F).  For Eyring's law and sliding along the gradient its left side is
    tau_m itself.  In other directions F is the largest fluidity of the resting film; the first guess, psi(s/F),
    is then rather too small than too large.
    """
    aim, _ = _bent(law, pressure, sliding / resting)

    def unsolved(it: _Iterate) -> Array:
        return (it.left > 1.0) & (it.iterations < LIMIT)

    def improve(it: _Iterate) -> _Iterate:
        """Try the change; where it does not reduce the residual, try half of it next."""
        t = it.stress + it.change
        m = moments(t)
        now, unbent = _bent(law, pressure, _flow(m.s, t, gradient)[0] / resting)
        residual = length(aim - now)
        better = residual < it.residual
        either = partial(jnp.where, better)
        change = tree.map(either, divided(m.A, resting * unbent(aim - now)), 0.5 * it.change)
        stress = tree.map(either, t, it.stress)
        wall = jnp.maximum(length(stress) + length(gradient), across.NO_STRESS)
        tried = jnp.where(better & (it.iterations > 0), length(it.change), jnp.inf)
        left = jnp.max(jnp.minimum(length(change) / TOLERANCE, tried / CLOSE) / wall)
        return _Iterate(stress, change, jnp.where(better, residual, it.residual), left, it.iterations + 1)

    far = jnp.full_like(pressure, jnp.inf)
    first = _Iterate(guess or aim, 0.0 * aim, far, jnp.max(far), jnp.zeros((), jnp.int32))
    last = jax.lax.while_loop(unsolved, improve, first)
    return last.stress + last.change, last.iterations


def _resting(law: Fluidity, points: int, pressure: Array, gradient: Vector) -> Array:
    """The integral of d(phi tau)/dtau along the gradient, without sliding: (sinh Sigma)/Sigma for Eyring's law."""
    z, weight = across.gauss(points, pressure.ndim)
    size = 0.5 * z * length(gradient)
    phi, slope = across.with_slope(law, pressure, size)
    return jnp.sum(weight * (phi + slope * size**2), axis=0)


def _bent(law: Fluidity, pressure: Array, v: Vector) -> tuple[Vector, Any]:
    """psi(v) = stress(|v|) v/|v|, and the map from a change of psi to the change of v."""
    size = length(v)
    stress, slope = jax.jvp(lambda x: law.stress(x, pressure), (size,), (jnp.ones_like(size),))
    axis = v / size

    def unbent(change: Vector) -> Vector:
        along = dot(axis, change) * axis
        return along / slope + (change - along) * (size / stress)

    return stress * axis, unbent


# -- its derivative ---------------------------------------------------------------------------------------------------


class SolvedFilm(NamedTuple):
    """tau_m, Q and the iterations; A, the rows of C A^-1, and D - C A^-1 C; the derivatives by the pressure."""

    stress: Vector
    flux: Vector
    iterations: Array
    A: Tensor
    by_sliding: tuple[Vector, Vector]
    by_gradient: Tensor
    by_pressure: tuple[Vector, Vector]


def _solution(m: Moments, by_pressure: Sequence[Array], t: Vector, g: Vector, iterations: Array) -> SolvedFilm:
    """by_pressure: the changes of S_0, S_1 and S_2 for the middle stress t."""
    (_, flux), (slid, extra) = _flow(m.s, t, g), _flow(by_pressure, t, g)
    of_x, of_y = Vector(*m.C[:2]), Vector(*m.C[1:])
    by_sliding = divided(m.A, of_x), divided(m.A, of_y)
    xx, yy = m.D[0] - dot(by_sliding[0], of_x), m.D[2] - dot(by_sliding[1], of_y)
    by_gradient = xx, m.D[1] - dot(by_sliding[0], of_y), yy
    stress_and_flux = divided(m.A, -1.0 * slid), extra - product(by_sliding, slid)
    return SolvedFilm(t, flux, iterations, m.A, by_sliding, by_gradient, by_pressure=stress_and_flux)


def _flow(s: Sequence[Array], t: Vector, g: Vector) -> tuple[Vector, Vector]:
    """The sliding and the flux of a given middle stress, from S_0, S_1 and S_2."""
    return s[0] * t + s[1] * g, s[1] * t + s[2] * g


def _with_change(function: Callable[[Array], Any], pressure: Array) -> Any:
    """Its value and its derivative by the pressure."""
    return jax.jvp(function, (pressure,), (jnp.ones_like(pressure),))


@jax.custom_jvp
def attached(film: ShearedFilm, solution: SolvedFilm) -> tuple[Vector, Vector]:
    """tau_m and Q of the solution for this film; they change with the film when they are differentiated."""
    return solution.stress, solution.flux


@partial(attached.defjvp, symbolic_zeros=True)
def _change(primals: Any, tangents: Any) -> Any:
    (law, pressure, _, gradient), solution = primals
    (d_law, dp, ds, dg), _ = tangents
    ds, dg, dp = tree.map(_given, (ds, dg, dp), is_leaf=_is_zero)
    stress_by_pressure, flux_by_pressure = solution.by_pressure
    slid, extra = _by_law(law, d_law, pressure, gradient, solution.stress)
    missing = ds - slid
    of_x, of_y = solution.by_sliding
    xx, xy, yy = solution.by_gradient
    d_stress = divided(solution.A, missing) - (of_x * dg.x + of_y * dg.y) + stress_by_pressure * dp
    d_flux = product((of_x, of_y), missing) + product((Vector(xx, xy), Vector(xy, yy)), dg)
    d_flux = d_flux + flux_by_pressure * dp + extra
    return (solution.stress, solution.flux), (d_stress, d_flux)


def _by_law(law: Fluidity, change: Any, pressure: Array, gradient: Vector, t: Vector) -> Any:
    """The change of the sliding and of the flux of a given middle stress, from what changes of the law's numbers."""
    numbers, structure = tree.flatten(law)
    changes = enumerate(tree.leaves(change, is_leaf=_is_zero))
    moving = {k: number for k, number in changes if not _is_zero(number)}
    if not moving:
        return (Vector(jnp.zeros(()), jnp.zeros(())),) * 2
    nodes = across.gauss_nodes(law, NODES, pressure, t, gradient)

    def flow(moved: dict[int, Array]) -> tuple[Vector, Vector]:
        values = [moved.get(k, number) for k, number in enumerate(numbers)]
        return _flow(across.sums_by_nodes(tree.unflatten(structure, values), pressure, t, gradient, nodes), t, gradient)

    return jax.jvp(flow, ({k: numbers[k] for k in moving},), (moving,))[1]


def _is_zero(tangent: Any) -> bool:
    return isinstance(tangent, SymbolicZero)


def _given(tangent: Any) -> Any:
    return jnp.zeros(tangent.shape, tangent.dtype) if _is_zero(tangent) else tangent


# -- products with tensors and matrices -------------------------------------------------------------------------------


def divided(tensor: Tensor, a: Vector) -> Vector:
    """The vector whose product with the symmetric tensor is a."""
    xx, xy, yy = tensor
    determinant = xx * yy - xy**2
    return Vector(yy * a.x - xy * a.y, xx * a.y - xy * a.x) / determinant


def product(rows: tuple[Vector, Vector], a: Vector) -> Vector:
    """The product of a matrix and a vector."""
    return Vector(dot(rows[0], a), dot(rows[1], a))
