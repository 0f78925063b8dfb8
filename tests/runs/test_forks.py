"""Processes that are forked after a computation, in a process of their own: pytest itself has many threads."""

import os

import pytest
from cases import python

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
