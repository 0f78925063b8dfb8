"""Exported programs: loaded from the disk without tracing, and exported again where that is not safe."""

from dataclasses import dataclass

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from jax.tree_util import register_dataclass

from ertel.numerics import programs
from ertel.numerics.programs import Program
from ertel.runs import exported
from ertel.runs.exported import ExportedPrograms

X = np.array([[2.0, 1.0], [0.0, 4.0]])
traced: list[str] = []


@register_dataclass
@dataclass(frozen=True)
class Outside:
    spacing: float


@jax.jit
def scaled(record, x):
    traced.append("scaled")
    return {"x": getattr(record, "spacing", record) * x}, jnp.linalg.inv(x)


class Process:
    """A new process at each call: it knows no program and no tracing."""

    def __init__(self, directory):
        self.directory = directory
        self.exports = ExportedPrograms(directory, "one")

    def __call__(self, *arguments):
        scaled.clear_cache()
        return self.exports.build(Program(scaled), arguments)(*arguments)

    def files(self):
        return list(self.directory.iterdir())


@pytest.fixture
def process(tmp_path):
    traced.clear()
    return Process(tmp_path)


def assert_right(answer):
    assert np.allclose(answer[0]["x"], 3.0 * X, rtol=1e-15)
    assert np.allclose(answer[1] @ X, np.eye(2), atol=1e-15)


def test_a_kept_program_is_not_traced_again(process):
    first, again = process(3.0, X), process(3.0, X)
    assert traced == ["scaled"]
    assert all(np.array_equal(a, b) for a, b in zip(jax.tree.leaves(first), jax.tree.leaves(again), strict=True))
    assert_right(again)


def test_another_stamp_or_a_damaged_file_is_exported_again(process):
    process(3.0, X)
    process.exports.stamp = "two"
    assert_right(process(3.0, X))
    assert len(traced) == 2
    (file,) = process.files()
    whole = file.read_bytes()
    assert process.exports._read(file)
    file.write_bytes(whole[:1000])
    assert not process.exports._read(file)
    for place in np.linspace(0, len(whole) - 1, 20).astype(int):
        file.write_bytes(whole[:place] + bytes([whole[place] ^ 16]) + whole[place + 1 :])
        assert not process.exports._read(file), f"byte {place} of {len(whole)}"
    for _ in range(2):
        assert_right(process(3.0, X))
        assert len(traced) == 3


def test_code_from_outside_is_not_kept_because_its_changes_go_unnoticed(process):
    assert_right(process(Outside(3.0), X))
    assert process.files() == []


def test_a_program_compiled_in_a_hurry_is_kept_optimised(process, monkeypatch):
    levels, told, compiled_at = [], [], exported.compiled_at

    def note(level, lowered):
        levels.append(level)
        return compiled_at(level, lowered)

    monkeypatch.setattr(exported, "compiled_at", note)
    with process.exports.in_a_hurry(lambda: told.append(len(levels))):
        assert_right(process(3.0, X))
        assert (levels, process.files()) == ([programs.LEVEL_OF_SMALL], [])
    assert (levels, told) == ([programs.LEVEL_OF_SMALL, programs.LEVEL], [1])
    with process.exports.in_a_hurry(lambda: told.append(len(levels))):
        assert_right(process(3.0, X))
    assert levels[2:] == [programs.LEVEL] and told == [1] and traced == ["scaled"]
