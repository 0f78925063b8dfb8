"""Programs: compiled once for each kind of arguments, shared by threads, with options that XLA and the user allow.

Blocks of points: the same values as all points at once.
"""

from concurrent.futures import ThreadPoolExecutor
from functools import partial
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from jax import Array
from numpy.testing import assert_array_equal

from ertel.numerics import programs
from ertel.numerics.programs import BLOCK, Program, in_blocks

X = np.array([[2.0, 1.0], [0.0, 4.0]])
traced: list[str] = []


@jax.jit
def scaled(factor, x):
    traced.append("scaled")
    return {"x": factor * x}, jnp.linalg.inv(x)


@pytest.fixture(autouse=True)
def nothing_traced(monkeypatch):
    monkeypatch.setattr(programs, "_build", programs.build)  # other tests of this process may keep programs
    traced.clear()
    scaled.clear_cache()


def assert_right(answer, factor=3.0):
    assert np.allclose(answer[0]["x"], factor * X, rtol=1e-15)
    assert np.allclose(answer[1] @ X, np.eye(2), atol=1e-15)


def test_a_program_computes_what_its_function_computes_and_is_traced_once_per_kind():
    program = Program(scaled)
    for factor in (3.0, 5.0):
        assert_right(program(factor, X), factor)
    assert traced == ["scaled"]
    program(3.0, X.astype("float32"))
    assert len(traced) == 2


def test_threads_share_a_program():
    program = Program(scaled)
    with ThreadPoolExecutor(4) as pool:
        made = list(pool.map(lambda _: program.ready(3.0, X), range(8)))
    assert all(each is made[0] for each in made)
    assert traced == ["scaled"]


def test_an_error_reaches_all_and_is_not_remembered():
    program = Program(scaled)
    for _ in range(2):
        with pytest.raises(ValueError, match="must have shape"):
            program(3.0, X[0])  # not a matrix
    assert len(traced) == 2


def test_flags_that_the_user_set_are_left_as_they_are(monkeypatch):
    class Lowered:
        def compile(self, compiler_options):
            return compiler_options

    monkeypatch.setattr(jax, "default_backend", lambda: "cpu")
    monkeypatch.setattr(programs, "OPTIONS", {"xla_one": 1, "xla_two": 2})
    monkeypatch.setenv("XLA_FLAGS", "--xla_one=3 --xla_backend_optimization_level=2")
    assert programs.compiled_at(1, Lowered()) == {"xla_two": 2}


def test_an_option_that_xla_does_not_know_is_left_out(monkeypatch):
    monkeypatch.setattr(programs, "OPTIONS", {"xla_cpu_no_such_option": True})
    assert_right(Program(scaled)(3.0, X))


def test_small_programs_are_close_to_the_optimised_ones(monkeypatch):
    monkeypatch.delenv("XLA_FLAGS", raising=False)
    plain, optimised = Program(scaled, small=X.size)(3.0, X), Program(scaled)(3.0, X)
    for a, b in zip(jax.tree.leaves(plain), jax.tree.leaves(optimised), strict=True):
        assert np.allclose(a, b, rtol=1e-15)


# -- blocks ------------------------------------------------------------------------------------------------------------

SHAPE = (3, BLOCK - 50)  # no whole number of blocks


def turned(number: Array, vector: Array) -> dict[str, Array]:
    return {"vector": vector[::-1] * number, "number": number + vector[0], "steps": jnp.full(number.shape, 1)}


@partial(jax.jit, static_argnames="with_changes")
def both_ways(chosen: Array, fields: tuple[Array, ...], changes: tuple[Array, ...], with_changes: bool) -> Any:
    """What blocks and all points at once give, or their changes in several directions."""

    def others(number: Array, vector: Array) -> dict[str, Array]:
        return {"vector": 2.0 * vector, "number": number, "steps": jnp.zeros(SHAPE, int)}

    def in_parts(*fields: Array) -> dict[str, Array]:
        return in_blocks(turned, chosen, others(*fields), *fields)

    def at_once(*fields: Array) -> dict[str, Array]:
        return jax.tree.map(partial(jnp.where, chosen), turned(*fields), others(*fields))

    def given(f: Any) -> Any:
        return jax.vmap(lambda *change: jax.jvp(f, fields, change)[1])(*changes) if with_changes else f(*fields)

    return given(in_parts), given(at_once)


@pytest.mark.parametrize("share", [0.0, 0.1, 0.7, 1.0])
def test_blocks_give_what_all_points_give(share: float) -> None:
    """At the points chosen, and what is given at the others; forward and in several directions at once."""
    draw = np.random.default_rng(0)

    def whole(*shape: int) -> np.ndarray:
        """Numbers whose products and sums are exact, whether a program rounds after the product or not."""
        return draw.integers(-1000, 1000, shape).astype(float)

    fields, changes = (whole(*SHAPE), whole(2, *SHAPE)), (whole(2, *SHAPE), whole(2, 2, *SHAPE))
    for with_changes in (False, True):
        found, expected = both_ways(draw.uniform(size=SHAPE) < share, fields, changes, with_changes=with_changes)
        assert found.keys() == expected.keys()
        for name, values in expected.items():
            assert_array_equal(found[name], values)


def test_an_iteration_ends_where_its_block_has_converged() -> None:
    def halvings(number: Array) -> Array:
        _, count = jax.lax.while_loop(
            lambda state: jnp.max(state[0]) > 1.0, lambda state: (state[0] / 2.0, state[1] + 1), (number, 0)
        )
        return jnp.full(number.shape, count)

    number = np.ones(2 * BLOCK)
    number[-1] = 8.0
    found = jax.jit(lambda number: in_blocks(halvings, number > 0.0, jnp.zeros(number.shape, int), number))(number)
    expected = np.repeat([0, 3] if jax.default_backend() == "cpu" else [3, 3], BLOCK)
    assert_array_equal(found, expected)
