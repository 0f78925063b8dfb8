"""Processes of their own: double precision and one thread of BLAS, nothing changed for the process; after a fork."""

import json
import os
import warnings
from functools import cache

import numpy as np
import pytest
from cases import python

pytestmark = pytest.mark.slow  # processes that compile

RUNS = """
import warnings
from dataclasses import dataclass

import jax.numpy as jnp
import ertel

warnings.simplefilter("ignore", UserWarning)  # coarse grids


@ertel.viscosity_laws.register("of JAX alone")
@dataclass(frozen=True)
class OfJax:
    '''A law that a user wrote with the functions of JAX.'''

    slope: float

    def viscosity(self, p):
        return jnp.exp(self.slope * p)


IMPACT = {"M": 20, "L": 5, "nodes": 17, "half_width": 4.0, "time_tolerance": 0.05, "until": "max-approach"}
ROLLING = {"M": 20, "L": 5, "nodes": 17}


def final(result):
    return result.dataset.H.values.ravel()[-289:].tolist()


ball = {"radius": 0.01, "ball_density": 7850, "speed": 0.01, "E_prime": 2.2e11}
oil = ertel.Oil(0.02, 2e-8, viscosity=OfJax(2e-8))
radial = ertel.impact(**ball, oil=oil, method="radial", nodes=33, until=0.5, time_tolerance=0.05)
FOUND = {
    "radial": lambda: final(ertel.simulate(radial)),
    "steady": lambda: final(ertel.simulate(ertel.rolling(**ROLLING))),
}


def refused():
    from ertel.numerics.programs import double_precision
    from ertel.solvers import steady
    from ertel.solvers.radial import RadialImpact
    from ertel.solvers.transient import Transient2D

    fall, roll = ertel.impact(**IMPACT), ertel.rolling(**ROLLING)
    with double_precision():
        method, other = Transient2D(fall), RadialImpact(radial)
        start, first = method.start(), other.start()
    asked = [
        (steady.steady_film, roll), (Transient2D, fall), (RadialImpact, radial), (method.measure, start),
        (method.advance, [start], 0.01), (other.advance, [first], 0.01), (method.friction, start),
    ]
    said = []
    for work, *arguments in asked:
        try:
            work(*arguments)
            said.append(False)
        except RuntimeError as error:
            said.append("single precision" in str(error))
    return said
"""

IN_A_PROCESS = """
import json
SWITCHES = {{"jax_debug_nans": True, "jax_disable_jit": True, "jax_numpy_dtype_promotion": "strict",
            "jax_transfer_guard": "disallow"}}
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
{runs}
filters = list(warnings.filters)
import ertel.runs.store, ertel.runs.traction  # all that computes
from ertel.numerics.programs import Program
call, threads = Program.__call__, set()


def watched(program, *arguments):
    threads.update(library.num_threads for library in blas.lib_controllers)
    return call(program, *arguments)


Program.__call__ = watched
found = {{name: FOUND[name]() for name in {names}}}
Program.__call__ = call
found["refused"] = refused()
said = {{
    "jax": [name for name in set_before if set_before[name] != jax.config.values[name]],
    "environment": [name for name in os.environ if told_before.get(name) != os.environ[name]],
    "filters": filters != list(warnings.filters),
    "x64": jax.config.jax_enable_x64,
    "threads": [sorted(threads), [library.num_threads for library in blas.lib_controllers]],
}}
sys.stdout.write(json.dumps([said, found]))
"""
QUICK = ("radial", "steady")  # all methods are run by the same function, and each refuses single precision


@cache
def alone() -> tuple[dict, dict]:
    """What a process of its own has changed, and what it computes, in single precision but for ertel."""
    said, found = json.loads(
        python("-c", IN_A_PROCESS.format(runs=RUNS, names=QUICK), without=("JAX_ENABLE_X64",)).stdout
    )
    return said, found


def test_no_setting_of_the_process_is_changed_and_single_precision_is_refused():
    said = alone()[0]
    in_runs, after = said.pop("threads")
    assert said == {"jax": [], "environment": [], "filters": False, "x64": False}
    assert in_runs == [1] and set(after) == {2}  # of the libraries of BLAS
    # By each of the methods, where nothing set double precision before.
    assert alone()[1]["refused"] == [True] * 7


@cache
def here() -> dict:
    found = {"__name__": __name__}
    exec(RUNS, found)
    return found["FOUND"]


@pytest.mark.parametrize("name", QUICK)
def test_a_run_is_that_of_double_precision(name):
    """To round-off: single precision would leave 1e-7 at best."""
    with warnings.catch_warnings():
        expected = np.array(here()[name]())
    assert np.abs(np.array(alone()[1][name]) - expected).max() < 1e-12 * np.abs(expected).max()


FORKS = """
import os, sys, warnings
import ertel

warnings.simplefilter("ignore")
SMALL = {"solver": {"method": "radial", "nodes": 17}, "time": {"until": 0.02, "tolerance": 0.1}}
impact = ertel.parse_case({"contact": {"M": 20, "L": 5}, **SMALL})
rolling = ertel.parse_case({"contact": {"kind": "rolling", "M": 20, "L": 5}, "solver": {"nodes": 17}})
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


@pytest.mark.skipif(not hasattr(os, "fork"), reason="no fork here")
def test_a_fork_of_a_process_that_has_computed_says_so():
    """JAX would hang there.  A fork before computes."""
    first, second, *others = python("-c", FORKS).stdout.splitlines()
    assert first == second == "converged"
    said = "this process was forked from one in which JAX runs, and would hang; start processes with multiprocessing"
    expected = [f"{name} {said}" for name in ("simulate", "traction", "respond", "respond_in_rolling")]
    assert [line.partition(".get_context")[0] for line in others] == expected
    assert all(line.endswith('("spawn"), or run the cases with ertel.sweep') for line in others)
