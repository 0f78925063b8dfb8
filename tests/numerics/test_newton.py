import itertools
from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from jax import Array

from ertel.numerics import newton
from ertel.numerics.newton import gcr


def system(residual: Callable[[Array, Array], Array], scale: float = 1.0, **others: Any) -> newton.NewtonKrylov:
    """The equations with H = P, preconditioned by a number."""
    parts = {"partner_change": lambda d: d, "tolerance": 1e-9, **others}
    return newton.NewtonKrylov(
        lambda P, H, _: residual(P, H),
        preconditioner=lambda P, H, free, whole, _: newton.Inverse(lambda r: r / scale),
        **parts,
    )


def diffused(P: Array) -> Array:
    p = jnp.pad(P[1:-1, 1:-1], 1)
    return jnp.pad(4 * p[1:-1, 1:-1] - p[:-2, 1:-1] - p[2:, 1:-1] - p[1:-1, :-2] - p[1:-1, 2:], 1)


def excess(P: Array, H: Array, force: Array) -> Array:
    """-P'' - force with a little of a cubic, in two dimensions; H = 2 + P stands for the partner."""
    return diffused(P) + 0.1 * (H - 2) ** 3 - jnp.pad(force[1:-1, 1:-1], 1)


@jax.jit
def obstacle(force: Array, P: Array) -> newton.Solution:
    """The excess >= 0, P >= 0."""
    options = newton.Options(krylov_limit=60, krylov_reduction=1e-4, largest_change=10.0)
    return system(lambda P, H: excess(P, H, force), 4.0, options=options).solve(P, 2 + P)


@settings(max_examples=10, deadline=None)
@given(st.integers(0, 10**6))
def test_the_solution_is_complementary(seed: int) -> None:
    force = np.random.default_rng(seed).standard_normal((17, 17))
    s = obstacle(force, np.zeros((17, 17)))
    P, r = np.asarray(s.P), np.asarray(excess(s.P, s.H, jnp.asarray(force)))
    assert bool(s.converged)
    assert P[1:-1, 1:-1].min() >= 0 and r.min() > -1e-8
    assert np.abs(r[P > 0]).max() < 1e-8
    np.testing.assert_allclose(np.asarray(s.H), 2 + P, atol=1e-12)


def test_one_iteration_is_done_even_from_the_solution() -> None:
    force = np.ones((9, 9))
    first = obstacle(force, np.zeros((9, 9)))
    again = obstacle(force, np.asarray(first.P))
    assert int(again.newton) == 1
    np.testing.assert_allclose(np.asarray(again.P), np.asarray(first.P), atol=1e-10)


def test_failure_is_a_value() -> None:
    """No preconditioner, one Krylov iteration, one Newton iteration: it cannot converge, and says so."""
    one = jnp.ones((5, 5))
    s = system(lambda P, H: jnp.exp(H) - 40.0, options=newton.Options(newton_limit=1, krylov_limit=1)).solve(one, one)
    assert not bool(s.converged)
    assert float(s.residual) > 1


@pytest.mark.parametrize("change", [0.1, 0.3])
def test_the_step_limit_holds(change: float) -> None:
    options = newton.Options(newton_limit=3, largest_change=change)
    s = system(lambda P, H: P - 5.0, options=options).solve(jnp.zeros((5, 5)), jnp.ones((5, 5)))
    np.testing.assert_allclose(np.asarray(s.P), 3 * change, rtol=1e-12)


def test_a_border_carries_a_number_with_its_own_equation() -> None:
    """P + H = 3 with H = 2 P - s everywhere and sum(P) = 50: P = 2, s = 3."""
    border = newton.Border(0.0, -1.0, lambda P, s: jnp.sum(P) - 50.0, 1e-9, 0.1)
    options = newton.Options(krylov_reduction=1e-12, largest_change=10.0)
    equations = system(lambda P, H: P + H - 3.0, 3.0, partner_change=lambda d: 2 * d, options=options, border=border)
    s = equations.solve(jnp.ones((5, 5)), 2 * jnp.ones((5, 5)))
    assert bool(s.converged)
    np.testing.assert_allclose(np.asarray(s.P), 2.0, rtol=1e-10)
    assert float(s.s) == pytest.approx(3.0, rel=1e-10)
    assert int(s.krylov) <= 3


@pytest.mark.parametrize(
    ("gain", "size", "forcing"), [(0.9, 1e6, newton.LOOSEST), (0.1, 1e6, 0.01), (1e-4, 1e6, 1e-3), (1e-4, 3.0, 0.1)]
)
def test_forcing_follows_the_gain_of_newtons_iteration(gain: float, size: float, forcing: float) -> None:
    """Loose while little is gained, the square of the gain later, and not far beyond the tolerance."""
    found = newton._forcing(newton.Options(krylov_reduction=1e-3), jnp.asarray(gain), jnp.asarray(size))
    assert float(found) == pytest.approx(forcing)


def test_an_iteration_evaluates_the_residual_twice() -> None:
    """Once with its derivative, and once at the new iterate: that of an oil that thins is dear."""
    trace = jax.make_jaxpr(lambda P: system(lambda P, H: jnp.sinh(P) + H).solve(P, P).left)(jnp.ones((3, 3)))
    assert str(trace).count("= sinh") == 2


# -- generalised conjugate residuals ----------------------------------------------------------------------------------


def residual_itself(k: Array, r: Array) -> Array:
    return r


@jax.jit
def solved_by_gcr(A: Array, b: Array) -> tuple[Array, Array]:
    return gcr(lambda v: (A @ v.ravel()).reshape(6, 6), residual_itself, b, 1e-10, 36)


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 10**6))
def test_gcr_solves_unsymmetric_systems(seed: int) -> None:
    rng = np.random.default_rng(seed)
    A, b = np.eye(36) + 0.3 * rng.standard_normal((36, 36)) / 6, rng.standard_normal((6, 6))
    x, k = solved_by_gcr(A, b)
    assert np.linalg.norm((A @ np.ravel(x)).reshape(6, 6) - b) <= 1.1e-10 * np.linalg.norm(b)
    assert 1 <= int(k) <= 36


def test_gcr_stops_at_its_limit_and_never_makes_it_worse() -> None:
    A = jnp.asarray(np.diag(np.linspace(1, 1000, 36)))
    b = jnp.ones((6, 6))

    def apply(v: Array) -> Array:
        return (A @ v.ravel()).reshape(6, 6)

    sizes = [float(jnp.linalg.norm(b - apply(gcr(apply, residual_itself, b, 1e-12, k)[0]))) for k in range(1, 7)]
    assert all(later <= earlier for earlier, later in itertools.pairwise(sizes))


def test_gcr_where_nothing_can_change() -> None:
    """No node is free: the change is zero, and a number."""
    x, k = gcr(lambda v: 0 * v, residual_itself, jnp.ones((6, 6)), 0.1, 3)
    assert int(k) == 3
    np.testing.assert_array_equal(x, 0.0)


def test_gcr_with_the_exact_inverse_takes_one_iteration() -> None:
    b = jnp.asarray(np.random.default_rng(0).standard_normal((6, 6)))
    x, k = gcr(lambda v: 3 * v, lambda k, r: r / 3, b, 1e-10, 9)
    assert int(k) == 1
    np.testing.assert_allclose(np.asarray(x), np.asarray(b) / 3, rtol=1e-12)


class Springs:
    """C(H) = exp(-H/0.1), everywhere but on the first node, which is an edge."""

    def pressure(self, H: Array) -> Array:
        return jnp.exp(-H / 0.1)

    def tangent(self, P: Array, H: Array) -> newton.Tangent:
        return newton.Tangent(self.pressure(H), self.pressure(H) / 0.1)

    def held(self, P: Array, H: Array, free: Array) -> Array:
        return jnp.where(jnp.arange(H.size) == 0, 0.0, 1.0 - free)


def test_a_part_that_depends_on_the_partner():
    """H = 0.2 + P - s; where Q is free its equation is Q = 0.3, elsewhere P = C; on the edge P = s."""
    wanted = jnp.array([0.0, 0.3, 0.3, -0.1, -0.1])
    inner = jnp.array([0.0, 1.0, 1.0, 1.0, 1.0])
    border = newton.Border(-0.5, -1.0, lambda P, s: s - 0.4, 1e-9, 1.0, jnp.array([1.0, 0.0, 0.0, 0.0, 0.0]))
    equations = newton.NewtonKrylov(
        lambda Q, H, _: inner * (Q - wanted),
        partner_change=lambda d: d,
        preconditioner=lambda Q, H, free, P, _: newton.Inverse(lambda r: inner * r / (1 + 5 * free)),
        tolerance=1e-9,
        border=border,
        part=Springs(),
    )
    P = jnp.array([0.0, 0.5, 0.5, 0.5, 0.5])
    s = equations.solve(P, 0.2 + P + 0.5, jnp.zeros(5))
    assert s.converged and s.s == pytest.approx(0.4)
    assert np.allclose(s.H, 0.2 + s.P - 0.4, atol=1e-9)
    carried = np.exp(-np.asarray(s.H) / 0.1)
    assert np.allclose(s.Q[1:], [0.3, 0.3, 0.0, 0.0], atol=1e-8) and np.allclose(s.P - s.Q, carried, atol=1e-8)
    assert s.P[0] == pytest.approx(0.9)  # it was zero for a while, and so was Q
