"""JAX: that it computes right, that its cache mends itself, and that nobody needs it to learn its version."""

import os
import subprocess
import sys
import warnings
from pathlib import Path

import pytest

import ertel
from ertel.runs import compiling

SOURCE = str(Path(ertel.__path__[0]).parent)


WRONG_SUMS = """
import jax
import jax.numpy as jnp
import numpy as np
rows, matrix = np.arange(60_000.0).reshape(-1, 3), np.eye(3)
sums = jax.jit(jax.vmap(lambda row: jnp.sum(matrix @ row)))(rows)
print(np.sum(sums != rows.sum(axis=1)))
"""


def test_jax_computes_right():
    """JAX issue 39103: from row 16384 on, jaxlib 0.10.2 gives the sums of other rows.

    In a process that compiles as a user's does, without the flags of the tests.
    """
    command = [sys.executable, "-c", WRONG_SUMS]
    plain = {name: value for name, value in environment().items() if name != "XLA_FLAGS"}
    done = subprocess.run(command, capture_output=True, text=True, check=True, env=plain)
    assert done.stdout == "0\n", f'this JAX computes wrongly: pip install "{compiling.REQUIREMENT}"'


# -- versions ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("version", ["0.10.2", "0.11.0"])
def test_wrong_versions(version):
    said = compiling.wrong_version(version)
    assert version in said
    assert 'pip install "jax!=0.10.2,!=0.11.0"' in said


@pytest.mark.parametrize("version", ["0.7.0", "0.10.1", "0.10.20", "0.11.1"])
def test_right_versions(version):
    assert compiling.wrong_version(version) == ""


@pytest.fixture
def wrong_jax(monkeypatch):
    """As if a JAX that computes wrongly were installed."""
    monkeypatch.setattr(compiling, "version", lambda package: "0.10.2")
    monkeypatch.setattr(compiling, "_told", False)


def test_a_wrong_jax_is_told_once(wrong_jax):
    with pytest.warns(RuntimeWarning, match=r"JAX 0\.10\.2 computes wrongly"):
        compiling.check_jax()
    with warnings.catch_warnings(action="error"):
        compiling.check_jax()


def test_a_wrong_jax_is_told_to_whom_one_says(wrong_jax):
    told: list[str] = []
    with warnings.catch_warnings(action="error"):
        compiling.check_jax(told.append)
        compiling.check_jax()
    assert told == [compiling.wrong_version("0.10.2")]


def test_a_right_jax_is_not_mentioned(monkeypatch):
    monkeypatch.setattr(compiling, "version", lambda package: "0.10.1")
    with warnings.catch_warnings(action="error"):
        compiling.check_jax()


def test_the_version_is_known_without_jax():
    code = "import sys; from ertel.runs import compiling; compiling.cache_directory(); print('jax' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, env=environment())
    assert done.stdout.strip() == "False"


# -- the cache --------------------------------------------------------------------------------------------------------

PROGRAM = """
from ertel.runs import compiling
compiling.keep_on_disk()
import jax
hits = []
jax.monitoring.register_event_listener(lambda event, **_: hits.append(event) if event.endswith("cache_hits") else None)
print(jax.jit(lambda x: 2 * x + 1)(3), len(hits))
"""


def environment(**more: str) -> dict[str, str]:
    return {**os.environ, "PYTHONPATH": SOURCE, "TF_CPP_MIN_LOG_LEVEL": "3", **more}


def in_a_process(directory: Path) -> tuple[str, str, str]:
    """What a new process computes, how many programs it finds in the cache, and what it says on stderr."""
    more = {"JAX_COMPILATION_CACHE_DIR": str(directory), "JAX_PERSISTENT_CACHE_MIN_COMPILE_TIME_SECS": "0"}
    command = [sys.executable, "-W", "always", "-c", PROGRAM]
    done = subprocess.run(command, capture_output=True, text=True, check=True, env=environment(**more))
    answer, hits = done.stdout.split()
    return answer, hits, done.stderr


def test_an_entry_cut_short_is_replaced_in_silence(tmp_path):
    assert in_a_process(tmp_path) == ("7", "0", "")
    whole = {path.name: path.stat().st_size for path in tmp_path.glob("*-cache")}
    assert whole
    for path in tmp_path.glob("*-cache"):
        path.write_bytes(path.read_bytes()[:100])
    assert in_a_process(tmp_path) == ("7", "0", "")
    assert {path.name for path in tmp_path.glob("*-cache")} == set(whole)
    assert all(path.stat().st_size > 100 for path in tmp_path.glob("*-cache"))
    assert in_a_process(tmp_path) == ("7", str(len(whole)), "")


def test_the_cache_has_a_folder_per_processor_and_version(monkeypatch, tmp_path):
    monkeypatch.delenv("JAX_COMPILATION_CACHE_DIR", raising=False)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    first = compiling.cache_directory()
    assert first.parent == tmp_path / "ertel" / "jax"
    assert first == compiling.cache_directory()
    monkeypatch.setattr(compiling, "version", lambda package: "0.0.0")
    assert compiling.cache_directory() != first
    monkeypatch.setattr(compiling, "_processor", lambda: "other")
    assert compiling.cache_directory().name == "other-jaxlib-0.0.0"


def test_a_cache_that_the_user_chose_is_taken(monkeypatch, tmp_path):
    monkeypatch.setenv("JAX_COMPILATION_CACHE_DIR", str(tmp_path))
    assert compiling.cache_directory() == tmp_path
