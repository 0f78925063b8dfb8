"""Compiling ahead: what it covers, what it leaves to a run, and what is told meanwhile."""

import json
import subprocess
from pathlib import Path
from types import SimpleNamespace

import pytest
from cases import ertel_, python

import ertel
from ertel.runs.batch import usual_cases
from ertel.runs.drive import watch

ROLLING = '[contact]\nkind = "rolling"\nM = 100\nL = 5\n[solver]\nnodes = 17\n'
IMPACT = (
    '[contact]\nM = 20\nL = 5\n[solver]\nmethod = "2d"\nnodes = 17\n[time]\ntolerance = 0.01\nuntil = "max-approach"\n'
)
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


def as_a_user(cache: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    """A process with optimised programs and a cache of its own."""
    return python(*arguments, without=("JAX_COMP", "JAX_PERS", "XLA_"), cwd=cache, XDG_CACHE_HOME=str(cache))


def test_a_run_after_the_warm_up_compiles_nothing_and_traces_no_solver(tmp_path):
    for name, text in (("rolling.toml", ROLLING), ("impact.toml", IMPACT)):
        (tmp_path / name).write_text(text)
    told = as_a_user(tmp_path, "-m", "ertel", "warm-up", "rolling.toml", "impact.toml").stderr.splitlines()
    assert [line.partition(":")[0] for line in told[:2]] == ["1/2  rolling", "2/2  impact"]
    events = json.loads(as_a_user(tmp_path, "-c", RUN, "rolling.toml", "impact.toml").stdout.splitlines()[-1])
    assert "cache_hits" in events
    assert "cache_misses" not in events
    traced = {name for event, _, name in (event.partition(" ") for event in events) if event == "jaxpr_trace_duration"}
    assert {"exported_solve", "exported_solve_step"} <= traced and not {"solve", "solve_step"} & traced
    optimised = ertel.open(tmp_path / "impact.toml.run").summary["max_approach"]
    plain = ertel.simulate(ertel.load_case(tmp_path / "impact.toml"))
    assert plain.summary["max_approach"] == pytest.approx(optimised, rel=1e-8)


def test_the_usual_grids_are_those_of_the_documents():
    cases = list(usual_cases())
    assert [(case.kind, case.solver.method, case.solver.nodes) for case in cases] == [
        ("rolling", "steady", 257),
        ("impact", "2d", 129),
        ("impact", "2d", 257),
        ("impact", "radial", 401),
    ]


def test_a_change_without_a_case_is_refused():
    done = ertel_("warm-up", "--set", "solver.nodes=33", code=2)
    assert done.stderr == "ertel: --set solver.nodes=33: needs a case file; without one the usual grids are compiled\n"


def test_the_progress_bar_says_what_takes_the_time(monkeypatch):
    said = []
    bars = SimpleNamespace(add_task=lambda name, total, message: said.append((name, message)))
    watch(bars, SimpleNamespace(case=SimpleNamespace(name="ball", kind="impact")))
    assert said == [("ball", "compiling (once per machine and grid size)")]


PYTHON_USER = """
import os
import jax
jax.jit(lambda x: x + 1)(1.0)  # JAX decides about its cache here
import numpy as np
import ertel
from ertel.numerics.programs import Program
ertel.simulate(ertel.impact(M=20, L=5, method="radial", nodes=17, until=0.02))
print(jax.config.jax_compilation_cache_dir, os.listdir())
ertel.cache()
Program(jax.jit(lambda x: 2.0 * x))(np.ones(3))
print(jax.config.jax_compilation_cache_dir)
"""


def test_python_users_keep_nothing_on_disk_until_they_wish_it(tmp_path):
    before, directory = as_a_user(tmp_path, "-c", PYTHON_USER).stdout.splitlines()
    assert before == "None []"
    assert Path(directory).is_relative_to(tmp_path / "ertel")
    assert list(Path(directory).glob("*-cache"))


def test_the_cache_of_python_users_may_be_in_a_directory_of_their_choice(tmp_path):
    own = str(tmp_path / "own")
    chosen = f'import jax; jax.config.update("jax_compilation_cache_dir", {own!r}); import ertel; ertel.cache()'
    code = f"{chosen}; print(jax.config.jax_compilation_cache_dir)"
    assert as_a_user(tmp_path, "-c", code).stdout.strip() == own
