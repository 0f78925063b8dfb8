"""Compiled programs: one for each kind of arguments, shared by threads, and loaded from the disk without tracing."""

import os
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from jax.tree_util import register_dataclass

from ertel.numerics import programs
from ertel.numerics.grid import Symmetry
from ertel.numerics.multigrid import Elasticity
from ertel.numerics.programs import Program

traced: list[str] = []


@register_dataclass
@dataclass(frozen=True)
class Outside:
    """A record that is not of ertel."""

    spacing: float


@jax.jit
def scaled(record, x):
    traced.append("scaled")
    return {"x": getattr(record, "spacing", record) * x}, jnp.linalg.inv(x)


@pytest.fixture(autouse=True)
def nothing_traced(monkeypatch):
    monkeypatch.setattr(programs, "_directory", None)  # other tests of this process may keep programs
    traced.clear()
    scaled.clear_cache()


@pytest.fixture
def kept(tmp_path, monkeypatch):
    """A directory in which programs are kept, with the stamp "one"."""
    monkeypatch.setattr(programs, "_directory", None)
    monkeypatch.setattr(programs, "_stamp", "")
    programs.keep(tmp_path, "one")
    return tmp_path


X = np.array([[2.0, 1.0], [0.0, 4.0]])


def new_process():
    """A new process knows no program and no tracing."""
    scaled.clear_cache()
    return Program(scaled)


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
            program(3.0, X[0])  # no matrix
    assert len(traced) == 2


def test_a_kept_program_is_not_traced_again(kept):
    first = new_process()(3.0, X)
    again = new_process()(3.0, X)
    assert traced == ["scaled"]
    assert all(np.array_equal(a, b) for a, b in zip(jax.tree.leaves(first), jax.tree.leaves(again), strict=True))
    assert_right(again)


def test_a_program_is_made_again_for_another_stamp_and_for_a_file_cut_short(kept):
    new_process()(3.0, X)
    programs.keep(kept, "two")
    assert_right(new_process()(3.0, X))
    assert len(traced) == 2
    (file,) = kept.iterdir()
    file.write_bytes(file.read_bytes()[:1000])
    assert_right(new_process()(3.0, X))
    assert len(traced) == 3
    assert_right(new_process()(3.0, X))
    assert len(traced) == 3


def test_a_program_with_a_flipped_bit_is_compiled_again(kept):
    new_process()(3.0, X)
    (file,) = kept.iterdir()
    whole = file.read_bytes()
    places = np.linspace(0, len(whole) - 1, 20).astype(int)
    for place in places:
        file.write_bytes(whole[:place] + bytes([whole[place] ^ 16]) + whole[place + 1 :])
        assert programs._read(file) is None, f"byte {place} of {len(whole)}"
    file.write_bytes(whole)
    assert_right(programs._read(file)(3.0, X))


def test_a_program_that_others_may_have_written_is_not_loaded(kept):
    """Somebody else's file, or one that anybody may change, is compiled again and replaced by the user's own."""
    new_process()(3.0, X)
    (file,) = kept.iterdir()
    assert file.stat().st_mode & 0o777 == 0o600
    file.chmod(0o620)
    assert programs._read(file) is None
    file.chmod(0o600)
    assert programs._read(file) is not None
    if os.getuid() == 0:  # others cannot give files away
        os.chown(file, 65534, 65534)
        assert programs._read(file) is None
        assert_right(new_process()(3.0, X))
        assert len(traced) == 2
        assert file.stat().st_uid == 0


def test_a_kept_program_runs_no_other_code(kept):
    """What it names is looked up in ertel alone."""
    for kind in ("os.system", "ertel.runs.store.run"):
        with pytest.raises(ValueError, match="must be a named tuple of ertel"):
            programs._example({kind: [0]})


def test_static_data_and_types_of_numbers_have_programs_of_their_own(kept):
    record = Elasticity(X, 3.0, X)
    for factor in (record, replace(record, even=Symmetry(y=True)), 3.0, np.float64(3.0)):
        assert_right(new_process()(factor, X))
    assert len(list(kept.iterdir())) == len(traced) == 4


def test_code_from_outside_is_not_kept_because_its_changes_go_unnoticed(kept):
    new_process()(Outside(3.0), X)
    assert list(kept.iterdir()) == []


def test_a_directory_that_cannot_be_written_does_no_harm(kept):
    (kept / "file").write_text("")
    programs.keep(kept / "file" / "below", "one")
    assert_right(new_process()(3.0, X))


def test_a_program_compiled_in_a_hurry_is_kept_optimised(kept, monkeypatch):
    compiled, compile_ = [], programs._compile

    def note(lowered, options):
        compiled.append(options["xla_backend_optimization_level"])
        return compile_(lowered, options)

    monkeypatch.setattr(programs, "_compile", note)
    with programs.in_a_hurry():
        assert_right(new_process()(3.0, X))
        assert (programs.hurried(), compiled, list(kept.iterdir())) == (1, [programs.LEVEL_OF_SMALL], [])
    assert (programs.hurried(), compiled) == (0, [programs.LEVEL_OF_SMALL, programs.LEVEL])
    assert_right(new_process()(3.0, X))
    assert len(compiled) == 2 and traced == ["scaled"]


def test_a_failure_leaves_nothing_to_compile_and_no_hurry(kept):
    with pytest.raises(KeyError), programs.in_a_hurry():
        new_process()(3.0, X)
        raise KeyError
    assert programs.hurried() == programs._hurried == 0 and not list(kept.iterdir())


def test_flags_that_the_user_set_are_left_as_they_are(monkeypatch):
    class Lowered:
        def compile(self, compiler_options):
            return compiler_options

    monkeypatch.setattr(jax, "default_backend", lambda: "cpu")
    monkeypatch.setenv("XLA_FLAGS", "--xla_one=3 --xla_other")
    assert programs._compile(Lowered(), {"xla_one": 1, "xla_two": 2}) == {"xla_two": 2}


def test_an_option_that_xla_does_not_know_is_left_out(monkeypatch):
    monkeypatch.setattr(programs, "OPTIONS", {"xla_cpu_no_such_option": True})
    assert_right(Program(scaled)(3.0, X))


def test_small_programs_are_close_to_the_optimised_ones(monkeypatch):
    monkeypatch.delenv("XLA_FLAGS", raising=False)
    plain, optimised = Program(scaled, small=X.size)(3.0, X), Program(scaled)(3.0, X)
    for a, b in zip(jax.tree.leaves(plain), jax.tree.leaves(optimised), strict=True):
        assert np.allclose(a, b, rtol=1e-15)
