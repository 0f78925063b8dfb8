"""Operations of the programs of a step and of a steady film, as compiled for a GPU, which need not be there.

    python -m pip install jax-cuda12-plugin==VERSION jax-cuda12-pjrt==VERSION nvidia-cuda-nvcc-cu12   (that of jax)
    python benchmarks/kernels.py [nodes ...]        (129 1025 unless said; ten minutes)

Up to 1025² nodes a GPU spends most of a step in launching small kernels, so their number is its cost.  XLA compiles for
an H100 from its description alone, without choosing among algorithms by trial.  Every fusion, product, transform and
call counts as one; a transform may be several kernels.  "Once" counts those outside Newton's iteration, the next
columns those of one Newton iteration and of one Krylov iteration.  Memory is that of arguments and scratch, in fields
as kept in double precision.  Convolutions by transforms alone, and by products where `numerics.halfspace` has them on a
GPU.  Ends with one sentence without the plugin.
"""

import os
import re
from collections import Counter, defaultdict
from collections.abc import Iterator, Mapping
from typing import Any
from unittest import mock

from common import grids, header, impact, rolling, row

NODES = (129, 1025)
os.environ.setdefault("XLA_FLAGS", "--xla_gpu_autotune_level=0 --xla_gpu_enable_triton_gemm=false")
os.environ.setdefault("JAX_PLATFORMS", "cpu")
os.environ.setdefault("TF_CPP_MIN_LOG_LEVEL", "3")
H100 = """
platform_name: "CUDA"  device_description_str: "NVIDIA H100"
dnn_version_info { major: 9 }  runtime_version { major: 12 }
gpu_device_info {
  cuda_compute_capability { major: 9 }  core_count: 132  fpus_per_core: 128  clock_rate_ghz: 1.98  threads_per_warp: 32
  threads_per_block_limit: 1024  threads_per_core_limit: 2048
  registers_per_core_limit: 65536  registers_per_block_limit: 65536
  shared_memory_per_block: 49152  shared_memory_per_core: 233472  shared_memory_per_block_optin: 232448
  block_dim_limit_x: 2147483647  block_dim_limit_y: 65535  block_dim_limit_z: 65535
  memory_bandwidth: 3352320000000  l2_cache_size: 52428800  device_memory_size: 84942979072
}
"""
COLUMNS = ("nodes", "convolutions", "once", "each Newton", "each Krylov", "of these transforms", "products", "fields")
NO_KERNEL = ("parameter", "get-tuple-element", "tuple", "bitcast", "constant")  # no work of their own


def main() -> None:
    from jax.experimental.topologies import get_topology_desc

    try:
        device = get_topology_desc("h100", "cuda", target_config=H100, topology="1x1x1").devices[0]
    except Exception as error:  # of several kinds, as JAX finds no plugin or no compiler
        print(f"Skipped: JAX cannot compile for a GPU here ({type(error).__name__}).")
        return
    from ertel.numerics import halfspace

    for title, program in (("Impact, one step", step), ("Steady rolling, the finest grid", film)):
        print(f"{title}\n")
        header(COLUMNS)
        for nodes in grids(NODES):
            for name, most in (("transforms", 0), ("products", halfspace.PRODUCTS_ELSEWHERE)):
                with mock.patch.object(halfspace, "PRODUCTS", {"cpu": most}):
                    function, arguments, size = program(nodes)
                compiled = compiled_for(device, function, arguments)
                found, memory = operations(compiled.as_text()), compiled.memory_analysis()
                fields = (memory.temp_size_in_bytes + memory.argument_size_in_bytes) / (8 * size)
                inner = found[2]
                kinds = inner["fft"], sum(count for kind, count in inner.items() if "matmul" in kind or "gemm" in kind)
                row(f"{nodes}²", name, *(found[depth].total() for depth in range(3)), *kinds, fields)
        print()


def step(nodes: int) -> tuple[Any, Any, int]:
    """The function of a step, its arguments and the number of nodes that are kept."""
    from ertel.solvers.transient import Transient2D, solve_step

    method = Transient2D(impact(1000, nodes))
    return solve_step, (method.problem([method.start()], 0.005),), method.contact.gap.size


def film(nodes: int) -> tuple[Any, Any, int]:
    """The same of a steady film on the finest grid."""
    import numpy as np

    from ertel.equations import discretise
    from ertel.solvers import nonlinear, steady

    case = rolling(1000, nodes)
    grid = steady.grids_of(case)[0]
    problem = steady.problem_of(case, grid, discretise.contact_of(case, grid), 0.0)
    return nonlinear.solve, (problem, np.zeros(grid.shape), 0.0), problem.contact.gap.size


def compiled_for(device: Any, function: Any, arguments: Any) -> Any:
    import jax

    there = jax.sharding.SingleDeviceSharding(device)
    leaves, structure = jax.tree.flatten(arguments)
    kinds = [jax.ShapeDtypeStruct(jax.numpy.shape(leaf), jax.numpy.result_type(leaf)) for leaf in leaves]
    on_leaves = jax.jit(
        lambda *leaves: function(*jax.tree.unflatten(structure, leaves)), in_shardings=there, out_shardings=there
    )
    return on_leaves.lower(*kinds).compile()


def operations(text: str) -> Mapping[int, Counter[str]]:
    """The operations of a compiled program by their names and the number of loops around them."""
    parts: dict[str, list[tuple[str, str]]] = {}
    start = ""
    for line in text.splitlines():
        if opened := re.match(r"(ENTRY )?%?([\w.\-]+) .*\{$", line):
            lines = parts.setdefault(opened[2], [])
            start = opened[2] if opened[1] else start
        elif found := re.match(r"\s+(?:ROOT )?%?[\w.\-]+ = (?:\(.*?\)|\S+) ([a-z\-]+)\((.*)$", line):
            lines.append((found[1], found[2]))
    counts: dict[int, Counter[str]] = defaultdict(Counter)
    for depth, kind, rest in _walked(parts, start, 0):
        target = re.search(r'custom_call_target="([^"]*)"', rest)
        counts[depth][target[1] if target else kind] += 1
    return counts


def _walked(parts: Mapping[str, list[tuple[str, str]]], name: str, depth: int) -> Iterator[tuple[int, str, str]]:
    """The operations that a part of a program runs, also in the parts that it calls."""
    for kind, rest in parts[name]:
        called = re.findall(r"(?:body|condition|to_apply|calls|\w+_computation)=%?([\w.\-]+)", rest)
        called += re.findall(r"%?([\w.\-]+)", (re.search(r"branch_computations=\{([^}]*)\}", rest) or ("", ""))[1])
        if kind in ("while", "conditional", "call"):
            for other in called:
                yield from _walked(parts, other, depth + (kind == "while"))
        elif kind not in NO_KERNEL:
            yield depth, kind, rest


if __name__ == "__main__":
    main()
