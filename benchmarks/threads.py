"""What a second core costs a run from Python, where no variable limits the threads of linear algebra.

    python benchmarks/threads.py [repeats]          (5 unless said, in each of 3 processes)

`ertel.simulate` in processes that may use one core or two, alone and beside a process that is always busy.  Without a
limit, OpenBLAS takes a thread a core for matrices of a hundred rows, and its threads wait for each other.  A second
core should cost at most a tenth.  Processor time and voluntary context switches say more than seconds on a machine
that others use, too.
"""

import os
import resource
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager

from common import child, grids, header, impact, row

VARIABLES = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "OPENBLAS_CORETYPE", "NPROC")
CONTACTS = {"2d": 129, "radial": 201}
ENDLESS = "while True: pass"


def measured(method: str, nodes: int, cores: int, repeats: int) -> list[float]:
    """The least wall time, processor time and switches of half an impact, compiled before, on so many cores."""
    os.sched_setaffinity(0, sorted(os.sched_getaffinity(0))[:cores])
    import ertel

    ertel.cache()
    case = impact(1000, nodes, solver={"method": method}, time={"until": 1.5})
    ertel.simulate(case)
    runs = []
    for _ in range(repeats):
        before, begin = used(), time.perf_counter()
        ertel.simulate(case)
        cpu, switches = (now - then for now, then in zip(used(), before, strict=True))
        runs.append((time.perf_counter() - begin, cpu, switches))
    return [min(column) for column in zip(*runs, strict=True)]


def used() -> tuple[float, int]:
    """Processor time of this process so far, and its voluntary context switches."""
    usage = resource.getrusage(resource.RUSAGE_SELF)
    return usage.ru_utime + usage.ru_stime, usage.ru_nvcsw


@contextmanager
def neighbour(busy: bool) -> Iterator[None]:
    """A process beside this block that does nothing, without a pause."""
    process = subprocess.Popen([sys.executable, "-c", ENDLESS if busy else ""])
    try:
        yield
    finally:
        process.kill()
        process.wait()


def main() -> None:
    repeats = grids((5,))[0]
    cores = sorted(os.sched_getaffinity(0))[:2]
    if len(cores) < 2:
        raise SystemExit("one core: nothing to compare")
    os.sched_setaffinity(0, cores)  # also of the neighbour
    for name in VARIABLES:
        os.environ.pop(name, None)
    header(["method", "nodes", "beside", "cores", "wall, s", "CPU, s", "switches", "CPU over one core", "wall over it"])
    for method, nodes in CONTACTS.items():
        for busy in (False, True):
            with neighbour(busy):
                calls = [f"measured({method!r}, {nodes}, {number}, {repeats})" for number in (1, 2)]
                rounds = [[child("threads", call) for call in calls] for _ in range(3)]  # in turns
            found = [[min(column) for column in zip(*runs, strict=True)] for runs in zip(*rounds, strict=True)]
            for number, (wall, cpu, switches) in enumerate(found, 1):
                ratios = cpu / found[0][1], wall / found[0][0]
                row(method, nodes, "a busy one" if busy else "none", number, wall, cpu, int(switches), *ratios)


if __name__ == "__main__":
    main()
