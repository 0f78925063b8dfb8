"""One convolution by JAX against the same by scipy.fft with one worker and with all cores.  Prints a table.

    python benchmarks/fft.py [nodes ...]        (257 513 1025 2049 unless said; one minute)

The whole plane, double precision, zero-padded to twice the nodes, as in `halfspace.TransformKernel`.  "Cores" is
how many threads share the work, (sum of their CPU times)² / sum of squares, which other work on the machine does not
change: near one, an FFT runs on one core; near the number of cores, it uses them.
"""

import math
import os
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

from common import grids, header, row, seconds

COLUMNS = ("nodes", "JAX, s", "JAX cores", "scipy 1 worker, s", "scipy all, s", "scipy all cores", "scipy all / JAX")


def main() -> None:
    cores = len(os.sched_getaffinity(0))
    print(f"{cores} cores", flush=True)
    header(COLUMNS)
    for nodes in grids((257, 513, 1025, 2049)):
        row(*measure(nodes, cores))


def measure(nodes: int, cores: int) -> list[Any]:
    import jax
    import jax.numpy as jnp
    import numpy as np

    from ertel.numerics import halfspace
    from ertel.numerics.grid import Grid

    kernel = halfspace.kernel(Grid.square(nodes, 2.0))
    P = np.zeros((nodes, nodes))
    P[1:-1, 1:-1] = np.random.default_rng(0).random((nodes - 2, nodes - 2))
    on_device, host_kernel = jnp.asarray(P), np.asarray(kernel.spectrum)
    convolve = jax.jit(lambda kernel, P: kernel.displacement(P))
    by_jax = partial(_waited, convolve, kernel, on_device)
    one, all_cores = (partial(displacement, host_kernel, P, workers) for workers in (1, cores))
    np.testing.assert_allclose(np.asarray(by_jax()), all_cores(), rtol=1e-9, atol=1e-12)
    t_jax, t_one, t_all = seconds(by_jax), seconds(one), seconds(all_cores)
    return [f"{nodes}²", t_jax, cores_used(by_jax), t_one, t_all, cores_used(all_cores), t_all / t_jax]


def _waited(work: Callable[..., Any], *arguments: Any) -> Any:
    import jax

    return jax.block_until_ready(work(*arguments))


def displacement(kernel: Any, P: Any, workers: int) -> Any:
    """`halfspace.TransformKernel` on the whole plane by scipy.fft: the same rows transformed, the same kernel."""
    from scipy import fft

    period, nodes = 2 * (kernel.shape[1] - 1), P.shape[0]
    along = fft.rfft(P, n=period, axis=1, workers=workers)
    both = fft.fft(along, n=period, axis=0, workers=workers) * kernel
    wanted = fft.ifft(both, axis=0, overwrite_x=True, workers=workers)[:nodes]
    return fft.irfft(wanted, n=period, axis=1, workers=workers)[:, :nodes]


def cores_used(work: Callable[[], Any], least: float = 0.5) -> float:
    """How many threads share the processor time of a call repeated for at least so many seconds (Linux; else NaN)."""
    start, before = time.perf_counter(), _thread_times()
    while time.perf_counter() - start < least:
        work()
    spent = [now - before.get(thread, 0) for thread, now in _thread_times().items()]
    return sum(spent) ** 2 / sum(t**2 for t in spent) if any(spent) else math.nan


def _thread_times() -> dict[str, int]:
    """Nanoseconds on a processor of each thread of this process."""
    return {path.parent.name: int(path.read_text().split()[0]) for path in Path("/proc/self/task").glob("*/schedstat")}


if __name__ == "__main__":
    main()
