"""Programs: compiled once for each kind of arguments, shared by threads, with options that XLA and the user allow."""

from concurrent.futures import ThreadPoolExecutor

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from ertel.numerics import programs
from ertel.numerics.programs import Program

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
