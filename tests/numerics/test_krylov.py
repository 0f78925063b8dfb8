import itertools

import jax.numpy as jnp
import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from jax import Array

from ertel.numerics import krylov


def residual_itself(k: Array, r: Array) -> Array:
    return r


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 10**6))
def test_gcr_solves_unsymmetric_systems(seed: int) -> None:
    rng = np.random.default_rng(seed)
    A = jnp.asarray(np.eye(36) + 0.3 * rng.standard_normal((36, 36)) / 6)
    b = jnp.asarray(rng.standard_normal((6, 6)))
    x, k = krylov.gcr(lambda v: (A @ v.ravel()).reshape(6, 6), residual_itself, b, 1e-10, 36)
    assert float(jnp.linalg.norm((A @ x.ravel()).reshape(6, 6) - b)) <= 1.1e-10 * float(jnp.linalg.norm(b))
    assert 1 <= int(k) <= 36


def test_gcr_stops_at_its_limit_and_never_makes_it_worse() -> None:
    A = jnp.asarray(np.diag(np.linspace(1, 1000, 36)))
    b = jnp.ones((6, 6))

    def apply(v: Array) -> Array:
        return (A @ v.ravel()).reshape(6, 6)

    sizes = [float(jnp.linalg.norm(b - apply(krylov.gcr(apply, residual_itself, b, 1e-12, k)[0]))) for k in range(1, 7)]
    assert all(later <= earlier for earlier, later in itertools.pairwise(sizes))


def test_gcr_with_the_exact_inverse_takes_one_iteration() -> None:
    b = jnp.asarray(np.random.default_rng(0).standard_normal((6, 6)))
    x, k = krylov.gcr(lambda v: 3 * v, lambda k, r: r / 3, b, 1e-10, 9)
    assert int(k) == 1
    np.testing.assert_allclose(np.asarray(x), np.asarray(b) / 3, rtol=1e-12)
