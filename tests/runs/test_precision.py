"""Double precision whatever the process has set, one thread of BLAS, and nothing changed; a fork says so."""

import json
import os
import warnings
from functools import partial

import jax
import numpy as np
import pytest
from cases import python

import ertel
from ertel.numerics.programs import double_precision
from ertel.solvers import steady
from ertel.solvers.radial import RadialImpact
from ertel.solvers.transient import Transient2D


def test_each_method_refuses_single_precision() -> None:
    """On grids of no other test: what is compiled already would do."""
    fall = ertel.impact(M=20, L=5, nodes=17, half_width=4.2)
    along_r = ertel.impact(M=20, L=5, nodes=35, method="radial")
    with double_precision():
        method, other = Transient2D(fall), RadialImpact(along_r)
        start, first = method.start(), other.start()
    asked = [
        partial(steady.steady_film, ertel.rolling(M=20, L=5, nodes=17)),
        partial(Transient2D, fall),
        partial(method.advance, [start], 0.01),
        partial(method.measure, start),
        partial(method.friction, start),
        partial(RadialImpact, along_r),
        partial(other.advance, [first], 0.01),
    ]
    with jax.enable_x64(False):
        for work in asked:
            with pytest.raises(RuntimeError, match="single precision"):
                work()


RUNS = """
import warnings
from dataclasses import dataclass

import jax.numpy as jnp
import ertel

warnings.simplefilter("ignore", UserWarning)  # coarse grids


@ertel.viscosity_laws.register("of JAX alone")
@dataclass(frozen=True)
class OfJax:
    slope: float

    def viscosity(self, p):
        return jnp.exp(self.slope * p)


def final(case):
    return ertel.simulate(case).dataset.H.values.ravel()[-289:].tolist()


ball = {"radius": 0.01, "ball_density": 7850, "speed": 0.01, "E_prime": 2.2e11}
oil = ertel.Oil(0.02, 2e-8, viscosity=OfJax(2e-8))
radial = ertel.impact(**ball, oil=oil, method="radial", nodes=33, until=0.5, time_tolerance=0.05)
FOUND = {"radial": lambda: final(radial), "steady": lambda: final(ertel.rolling(M=20, L=5, nodes=17))}
"""

IN_A_PROCESS = f"""
SWITCHES = {{"jax_debug_nans": True, "jax_disable_jit": True, "jax_numpy_dtype_promotion": "strict",
            "jax_transfer_guard": "disallow"}}
import json
import os
import sys
import warnings

import jax
import scipy.linalg, scipy.sparse, scipy.special, zarr  # each adds a filter for warnings when it is imported
from threadpoolctl import ThreadpoolController

blas = ThreadpoolController().select(user_api="blas")
blas.limit(limits=2)
for name, value in SWITCHES.items():  # of a user who looks for an error of his own
    jax.config.update(name, value)
set_before, told_before = dict(jax.config.values), dict(os.environ)
{RUNS}
filters = list(warnings.filters)
import ertel.runs.store, ertel.runs.traction  # all that computes
from ertel.numerics.programs import Program
call, threads = Program.__call__, set()


def watched(program, *arguments):
    threads.update(library.num_threads for library in blas.lib_controllers)
    return call(program, *arguments)


Program.__call__ = watched
found = {{name: run() for name, run in FOUND.items()}}
said = {{
    "jax": [name for name in set_before if set_before[name] != jax.config.values[name]],
    "environment": [name for name in os.environ if told_before.get(name) != os.environ[name]],
    "filters": filters != list(warnings.filters),
    "x64": jax.config.jax_enable_x64,
    "threads": [sorted(threads), sorted({{library.num_threads for library in blas.lib_controllers}})],
}}
sys.stdout.write(json.dumps([said, found]))
"""


@pytest.mark.slow
def test_a_run_is_that_of_double_precision_and_changes_no_setting_of_the_process():
    """To round-off: single precision would leave 1e-7 at best."""
    said, found = json.loads(python("-c", IN_A_PROCESS, without=("JAX_ENABLE_X64",)).stdout)
    threads = [[1], [2]]  # of the libraries of BLAS, in runs and after
    assert said == {"jax": [], "environment": [], "filters": False, "x64": False, "threads": threads}
    names = {"__name__": __name__}
    with warnings.catch_warnings():
        exec(RUNS, names)
        for name, run in names["FOUND"].items():
            expected = np.array(run())
            assert np.abs(np.array(found[name]) - expected).max() < 1e-12 * np.abs(expected).max()


FORKS = """
import os, sys, warnings
import ertel

warnings.simplefilter("ignore")
impact = ertel.impact(M=20, L=5, method="radial", nodes=17, until=0.02, time_tolerance=0.1)
rolling = ertel.rolling(M=20, L=5, nodes=17)
DO = {
    "simulate": lambda: print(ertel.simulate(impact).status.value),
    "traction": lambda: ertel.traction(rolling, slide_to_roll=[0.1]),
    "respond": lambda: ertel.respond(ertel.impact(M=20, L=5, nodes=17), [[]]),
    "respond_in_rolling": lambda: ertel.respond_in_rolling(rolling, [[]]),
}

def forked(name):
    sys.stdout.flush()
    child = os.fork()
    if child:
        return os.waitpid(child, 0)
    try:
        DO[name]()
    except RuntimeError as error:
        print(name, error)
    sys.stdout.flush()
    os._exit(0)

forked("simulate")
DO["simulate"]()
for name in DO:
    forked(name)
"""


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(os, "fork"), reason="no fork here")
def test_a_fork_of_a_process_that_has_computed_says_so():
    """JAX would hang there.  A fork before computes."""
    first, second, *others = python("-c", FORKS).stdout.splitlines()
    assert first == second == "converged"
    words = [line.partition(" this process was forked from one in which JAX runs, and would hang") for line in others]
    assert [name for name, found, _ in words if found] == ["simulate", "traction", "respond", "respond_in_rolling"]
    assert all('get_context("spawn")' in advice and "ertel.sweep" in advice for *_, advice in words)
