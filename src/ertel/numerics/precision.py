"""Double precision inside ertel, whatever JAX is set to elsewhere in the process.

JAX computes in single precision unless it is told otherwise, and that setting belongs to the user.  So every public
function that computes does it in JAX's own block for double precision, which holds for one thread::

    @double_precision()
    def simulate(case): ...
"""

from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module
from typing import Any

import jax
import jax.numpy as jnp

# JAX before 0.8 has it elsewhere
_enable_x64: Any = jax.enable_x64 if hasattr(jax, "enable_x64") else import_module("jax.experimental").enable_x64


@contextmanager
def double_precision() -> Iterator[None]:
    """Let JAX compute in double precision in this block, and in this thread only; also a decorator."""
    with _enable_x64(True):
        yield


def require_double() -> None:
    """Raise RuntimeError where JAX would silently round to single precision."""
    if jnp.result_type(float) != jnp.float64:
        raise RuntimeError(
            "JAX computes in single precision here, and ertel needs double: call this in a block "
            "`with ertel.numerics.precision.double_precision():`, or set JAX_ENABLE_X64=1"
        )
