"""JAX: that it computes right; its cache, which mends itself, belongs to its user and is filled ahead."""

import json
import os
import subprocess
import warnings
from contextlib import ExitStack
from pathlib import Path

import numpy as np
import pytest
from cases import python
from threadpoolctl import ThreadpoolController, threadpool_limits

import ertel
from ertel.runs import compile
from ertel.runs.workers import one_blas_thread

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


@pytest.mark.parametrize(
    ("version", "wrong"), [("0.10.2", True), ("0.11.0", True), ("0.7.0", False), ("0.10.1", False), ("0.10.20", False)]
)
def test_a_wrong_jax_is_told_once(monkeypatch, version, wrong):
    monkeypatch.setattr(compile, "version", lambda package: version)
    compile.check_jax.cache_clear()
    with warnings.catch_warnings(record=True, action="always") as told:
        compile.check_jax()
        compile.check_jax()
    said = [str(warning.message) for warning in told]
    assert said == [compile.wrong_version(version)] * wrong
    assert all(version in sentence and 'pip install "jax!=0.10.2,!=0.11.0"' in sentence for sentence in said)


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


@pytest.mark.slow
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
    monkeypatch.delenv("JAX_COMPILATION_CACHE_DIR", raising=False)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    found = compile.cache_directory()
    assert found is not None
    return found


CACHE = """
import os, shutil, sys, warnings
import jax
jax.jit(lambda x: x + 1)(1.0)  # JAX decides about its cache here
import numpy as np
import ertel
from ertel.numerics.programs import Program
Program(jax.jit(lambda x: 3.0 * x))(np.ones(3))
print(jax.config.jax_compilation_cache_dir, os.listdir())
os.makedirs(sys.argv[1])
os.chmod(sys.argv[1], 0o777)
with warnings.catch_warnings(record=True) as said:
    warnings.simplefilter("always")
    print(ertel.cache(), jax.config.jax_compilation_cache_dir)
    print(*[f"{each.category.__name__}: {each.message}" for each in said])
    shutil.rmtree("ertel")
    said.clear()
    print(ertel.cache())
Program(jax.jit(lambda x: 2.0 * x))(np.ones(3))
print(jax.config.jax_compilation_cache_dir)
print([f"{each.category.__name__}: {each.message}" for each in said])
"""
STRANGER = 65534


def as_a_user(cache: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    """A process with a cache of its own."""
    return python(*arguments, without=("JAX_COMP", "JAX_PERS"), cwd=cache, XDG_CACHE_HOME=str(cache))


def test_the_cache_is_made_for_its_user_alone_when_he_wishes_it(place, tmp_path):
    """One to which others may write is not used, and said; then it is made anew."""
    before, refused, warned, *made = as_a_user(tmp_path, "-c", CACHE, str(place)).stdout.splitlines()
    assert (before, refused) == ("None []", "None None")
    assert warned.startswith(f"RuntimeWarning: compiled programs are not kept: {place}")
    assert made == [str(place), str(place), "[]"]
    assert list(place.glob("*-cache"))
    assert place.stat().st_mode & 0o777 == place.parent.stat().st_mode & 0o777 == 0o700
    (place / "a-cache").touch(mode=0o666)  # nobody else can reach it
    assert is_safe(place)


def is_safe(directory: Path) -> bool:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        return compile._is_safe(directory)


def is_refused(directory: Path, path: Path) -> bool:
    with pytest.warns(RuntimeWarning, match=f"are not kept: {path} belongs to another user, or others may write to it"):
        return not compile._is_safe(directory)


def test_a_cache_to_which_others_may_write_is_not_used(place):
    place.mkdir(parents=True)
    place.chmod(0o777)
    assert is_refused(place, place)
    place.chmod(0o755)
    (place / "a-cache").touch()
    (place / "a-cache").chmod(0o666)
    assert is_refused(place, place / "a-cache")
    (place / "a-cache").chmod(0o644)
    assert is_safe(place)


@pytest.mark.skipif(os.name == "nt", reason="directories have no rights there")
def test_no_directory_above_a_cache_may_be_renamed_by_others(place, tmp_path, monkeypatch):
    """Up to the home of its user; where all may write, as in /tmp, only owners rename."""
    place.mkdir(parents=True)
    above = place.parents[1]
    above.chmod(0o777)
    assert is_refused(place, above)
    (tmp_path / "link").symlink_to(place)
    assert is_refused(tmp_path / "link", above)
    above.chmod(0o1777)
    assert is_safe(place)
    above.chmod(0o777)
    monkeypatch.setenv("HOME", str(place.parent))
    assert is_safe(place)


@pytest.mark.skipif(os.name == "nt" or os.getuid() != 0, reason="only root gives files away")
@pytest.mark.parametrize("planted", ["", "a-cache"])
def test_a_cache_of_another_user_is_not_used(place, planted):
    place.mkdir(parents=True, mode=0o700)
    (place / planted).touch()
    os.chown(place / planted, STRANGER, STRANGER)
    assert is_refused(place, place / planted)


ROLLING = '[contact]\nkind = "rolling"\nM = 100\nL = 5\n[solver]\nnodes = 17\n'
IMPACT = '[contact]\nM = 20\nL = 5\n[solver]\nmethod = "{}"\nnodes = 17\n[time]\ntolerance = 0.01\nuntil = 0.3\n'
RUN = """
import json, sys
import jax
from pathlib import Path
from ertel.apps.cli import app
events = []
jax.monitoring.register_event_listener(lambda event, **_: events.append(event.rpartition("/")[2]))
jax.monitoring.register_event_duration_secs_listener(
    lambda event, seconds, **more: events.append(f"{event.rpartition('/')[2]} {more.get('fun_name')}")
)
for name in sys.argv[1:]:
    app(["run", name, "--out", name + ".run", "--quiet"], standalone_mode=False)
print(json.dumps(events))
"""


@pytest.mark.parametrize(
    ("cases", "solvers"),
    [
        ({"impact": IMPACT.format("radial")}, {"solve_ring_step"}),
        pytest.param(
            {"rolling": ROLLING, "impact": IMPACT.format("2d")}, {"solve", "solve_step"}, marks=pytest.mark.slow
        ),
    ],
    ids=["radial", "all"],
)
def test_a_run_after_the_warm_up_compiles_nothing_and_traces_no_solver(tmp_path, cases, solvers):
    files = [f"{name}.toml" for name in cases]
    for file, text in zip(files, cases.values(), strict=True):
        (tmp_path / file).write_text(text)
    told = as_a_user(tmp_path, "-m", "ertel", "warm-up", *files).stderr.splitlines()
    assert [line.partition(":")[0].partition("  ")[2] for line in told[: len(cases)]] == list(cases)
    events = json.loads(as_a_user(tmp_path, "-c", RUN, *files).stdout.splitlines()[-1])
    assert "cache_hits" in events and "cache_misses" not in events
    traced = {name for event, _, name in (event.partition(" ") for event in events) if event == "jaxpr_trace_duration"}
    assert {f"exported_{solve}" for solve in solvers} <= traced and not solvers & traced
    loaded = ertel.open(tmp_path / "impact.toml.run").dataset
    plain = ertel.simulate(ertel.load_case(tmp_path / "impact.toml")).dataset
    for name in ("time", "Delta", "V", "F", "P_c", "H_c", "H_min"):
        np.testing.assert_allclose(plain[name], loaded[name], rtol=1e-8)


def test_blas_has_one_thread_until_the_last_block_ends():
    """Also where blocks of two threads overlap and the first one ends first."""
    libraries = ThreadpoolController().select(user_api="blas").lib_controllers

    def threads():
        return {library.num_threads for library in libraries}

    first, second = ExitStack(), ExitStack()
    with threadpool_limits(2, "blas"):
        for block in (first, second):
            block.enter_context(one_blas_thread())
            assert threads() == {1}
        first.close()
        assert threads() == {1}
        second.close()
        assert threads() == {2}
