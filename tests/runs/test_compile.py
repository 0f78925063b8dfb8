"""JAX: that it computes right, that its cache mends itself, and that nobody needs it to learn its version."""

import os
import warnings
from pathlib import Path

import pytest
from cases import python

from ertel.runs import compile

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
    said = python("-c", WRONG_SUMS, without=("XLA_FLAGS",)).stdout
    assert said == "0\n", f'this JAX computes wrongly: pip install "{compile.REQUIREMENT}"'


# -- versions ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("version", "wrong"), [("0.10.2", True), ("0.11.0", True), ("0.7.0", False), ("0.10.1", False), ("0.10.20", False)]
)
def test_a_wrong_jax_is_told_once(monkeypatch, version, wrong):
    monkeypatch.setattr(compile, "version", lambda package: version)
    compile.check_jax.cache_clear()
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        compile.check_jax()
        compile.check_jax()
    assert [str(warning.message) for warning in told] == ([compile.wrong_version(version)] if wrong else [])
    assert not wrong or (
        version in str(told[0].message) and 'pip install "jax!=0.10.2,!=0.11.0"' in str(told[0].message)
    )


def test_the_version_is_known_without_jax():
    code = "import sys; from ertel.runs import compile; compile.cache_directory(); print('jax' in sys.modules)"
    assert python("-c", code).stdout == "False\n"


# -- the cache --------------------------------------------------------------------------------------------------------

COMMAND = """
from ertel.runs import compile
from ertel.apps.process import warnings_as_sentences
with warnings_as_sentences():
    compile.prepare_jax()
    import jax
    hits = []
    jax.monitoring.register_event_listener(
        lambda event, **_: hits.append(event) if event.endswith("cache_hits") else None
    )
    print(jax.jit(lambda x: 2 * x + 1)(3), len(hits))
"""


def in_a_process(directory: Path) -> tuple[str, str, str]:
    """What a new command computes, how many programs it finds in the cache, and what it says on stderr."""
    more = {"JAX_COMPILATION_CACHE_DIR": str(directory), "JAX_PERSISTENT_CACHE_MIN_COMPILE_TIME_SECS": "0"}
    done = python("-W", "always", "-c", COMMAND, TF_CPP_MIN_LOG_LEVEL="3", **more)
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


@pytest.fixture
def place(monkeypatch, tmp_path):
    """The directory in which ertel keeps programs below `tmp_path`."""
    monkeypatch.delenv("JAX_COMPILATION_CACHE_DIR", raising=False)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    found = compile.cache_directory()
    assert found is not None
    return found


def test_the_cache_has_a_folder_per_processor_and_version(place, monkeypatch, tmp_path):
    assert place.parent == tmp_path / "ertel" / "jax"
    assert place == compile.cache_directory()
    monkeypatch.setattr(compile, "version", lambda package: "0.0.0")
    assert compile.cache_directory() != place
    monkeypatch.setattr(compile, "_processor", lambda: "other")
    assert compile.cache_directory().name == "other-jaxlib-0.0.0"
    monkeypatch.setenv("JAX_COMPILATION_CACHE_DIR", str(tmp_path))  # chosen by the user
    assert compile.cache_directory() == tmp_path


# -- who may write to the cache ---------------------------------------------------------------------------------------

CACHE = """
import warnings
import ertel
with warnings.catch_warnings(record=True) as said:
    warnings.simplefilter("always")
    directory = ertel.cache()
import jax
print(directory)
print(jax.config.jax_compilation_cache_dir)
print([f"{each.category.__name__}: {each.message}" for each in said])
"""
STRANGER = 65534


def cache_below(home: Path) -> list[str]:
    """What `ertel.cache()` returns, the directory that JAX then has, and the warnings; XDG_CACHE_HOME is `home`."""
    return python("-c", CACHE, without=("JAX_COMPILATION_CACHE",), XDG_CACHE_HOME=str(home)).stdout.splitlines()


def test_the_cache_is_made_for_its_user_alone(place, tmp_path):
    assert cache_below(tmp_path) == [str(place), str(place), "[]"]
    assert place.stat().st_mode & 0o777 == place.parent.stat().st_mode & 0o777 == 0o700
    (place / "a-cache").touch(mode=0o666)  # nobody else can reach it
    assert is_safe(place)


def is_safe(directory: Path) -> bool:
    """Whether programs may be kept in a directory, in silence."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        return compile._is_safe(directory)


def is_refused(directory: Path, path: Path) -> bool:
    """Whether nothing is kept in a directory because of this file or directory."""
    with pytest.warns(RuntimeWarning, match=f"are not kept: {path} belongs to another user, or others may write to it"):
        return not compile._is_safe(directory)


def test_a_cache_to_which_others_may_write_is_not_used(place, tmp_path):
    place.mkdir(parents=True)
    place.chmod(0o777)
    assert is_refused(place, place)
    directory, of_jax, warned = cache_below(tmp_path)
    assert directory == of_jax == "None" and f"RuntimeWarning: compiled programs are not kept: {place}" in warned
    place.chmod(0o755)
    (place / "a-cache").touch()
    (place / "a-cache").chmod(0o666)
    assert is_refused(place, place / "a-cache")
    (place / "a-cache").chmod(0o644)
    assert is_safe(place)


@pytest.mark.skipif(os.name == "nt" or os.getuid() != 0, reason="only root gives files away")
@pytest.mark.parametrize("planted", ["", "a-cache"])
def test_a_cache_of_another_user_is_not_used(place, planted):
    place.mkdir(parents=True, mode=0o700)
    (place / planted).touch()
    os.chown(place / planted, STRANGER, STRANGER)
    assert is_refused(place, place / planted)


def test_commands_say_that_a_cache_is_not_used(tmp_path):
    """Also a directory that JAX was told to use."""
    tmp_path.chmod(0o777)
    answer, _, said = in_a_process(tmp_path)
    assert answer == "7"
    assert said.startswith(f"ertel: warning: compiled programs are not kept: {tmp_path} belongs to another user, or")
    assert said.count("\n") == 1
    assert list(tmp_path.glob("*-cache")) == list((tmp_path / "ertel").iterdir()) == []
