"""How long a run takes, roughly: from counts of time steps and measured seconds for each node.

Measured on one to two cores with `benchmarks/steps.py`, `scaling.py` and `time_error.py`, Newtonian oils.  Another
machine, a hard case or a busy hour changes it by a factor of three.

Steps: 178 to maximum approach (M = 1000), 259 and 417 to the rebound (M = 100, 1000), 295 while a cavity passes: 52 to
84 for each t0 at a tolerance of 5e-5, 77 in place of 178 at 1e-3.
"""

from math import isfinite, prod

from ertel.case.case import Case
from ertel.case.grids import grid_of
from ertel.case.sections import Time

STEPS = 75.0  # for each t0, at the default tolerance
STEPS_POWER = 0.3  # with which the steps grow with 1/tolerance
STEPS_OF_A_PERIOD = 16.0
SECONDS_A_STEP = 2e-3, 1e-6  # of a step, and for each node that is kept
SECONDS_A_RADIAL_STEP = 2e-3, 1.7e-7  # and for each pair of nodes along the radius
SECONDS_STEADY = 1.3e-5  # for each node that is kept, with the coarser grids
TIMES_OF_THINNING = 2.0, 6.0  # what a steady film and a step of an oil that thins take, times a Newtonian one
SECONDS_TO_START = 5.0  # with compiled programs from the cache; some fifteen more where there are none


def steps(case: Case) -> int:
    """The number of time steps of a run, roughly; 0 of a steady contact."""
    if case.is_steady:
        return 0
    time = case.schedule
    if time.step:
        return round(time.duration / time.step)
    wanted = STEPS * time.duration * (Time().tolerance / time.tolerance) ** STEPS_POWER
    period = case.motion.shortest_period
    return int(max(wanted, STEPS_OF_A_PERIOD * time.duration / period if isfinite(period) else 0.0))


def seconds(case: Case) -> float:
    """The seconds that a run takes, roughly, with compiled programs from the cache."""
    nodes = case.solver.nodes
    if case.solver.method == "radial":
        start, each = SECONDS_A_RADIAL_STEP
        return SECONDS_TO_START + steps(case) * (start + each * nodes**2)
    kept = prod(grid_of(case).shape)
    film = 0.0 if case.starts_apart else SECONDS_STEADY * kept
    start, each = SECONDS_A_STEP
    more, slower = (1.0, 1.0) if case.oil.is_newtonian else TIMES_OF_THINNING
    return SECONDS_TO_START + more * film + slower * steps(case) * (start + each * kept)
