"""JAX as ertel uses it: in double precision, in programs that are compiled once, and points in blocks.

JAX computes in single precision unless it is told otherwise, and that setting belongs to the user.  So every public
function that computes does it in JAX's own block for double precision, which holds for one thread::

    @double_precision()
    def simulate(case): ...

A program is a jitted function, compiled once for each kind of arguments, also from several threads at once.  It is
compiled here and now, unless `build_with` names another builder, such as one that keeps programs on disk
(`ertel.runs.exported`).
"""

import os
from collections.abc import Callable, Iterator
from concurrent.futures import Future
from contextlib import ExitStack, contextmanager
from importlib import import_module
from threading import Lock
from typing import Any, TypeVar

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array, export, lax, tree

BLOCK = 256  # points; 128 to 512 are equally fast, all at once takes twice the time
# XLA's newer way of joining loops takes half as long again to compile, and level 3 twice as long as level 1; the
# programs are equally fast (measured on 65 to 513 nodes per side).  Level 0: a fifth to compile, two to three times
# as long to run.
LEVEL, LEVEL_OF_SMALL = 1, 0
# of a program that is optimised on no grid: it runs once or twice, and compiles in a fifth of the time
ANY_SIZE = 2**62
OPTIONS = {"xla_cpu_use_fusion_emitters": False}

Compiled = Callable[..., Any]
Record = TypeVar("Record")

# JAX before 0.8 has it elsewhere
_enable_x64: Any = jax.enable_x64 if hasattr(jax, "enable_x64") else import_module("jax.experimental").enable_x64


@contextmanager
def double_precision() -> Iterator[None]:
    """Let JAX compute in double precision in this block, and in this thread only; also a decorator.

    Its switches for debugging are off there: programs are compiled ahead, and a step that fails may have nan.
    """
    with ExitStack() as stack:
        for scope in (_enable_x64(True), jax.disable_jit(False), jax.debug_nans(False), jax.transfer_guard("allow")):
            stack.enter_context(scope)
        stack.enter_context(jax.numpy_dtype_promotion("standard"))
        yield


def require_double() -> None:
    """Raise RuntimeError where JAX would silently round to single precision."""
    if jnp.result_type(float) != jnp.float64:
        raise RuntimeError(
            "JAX computes in single precision here, and ertel needs double: call this in a block "
            "`with ertel.numerics.programs.double_precision():`, or set JAX_ENABLE_X64=1"
        )


# -- programs ----------------------------------------------------------------------------------------------------------


def exportable(record: type[Record]) -> type[Record]:
    """Let JAX write programs that return this named tuple; a decorator of its class."""
    export.register_namedtuple_serialization(record, serialized_name=f"{record.__module__}.{record.__qualname__}")
    return record


class Program:
    """A jitted function, compiled for each kind of arguments: structure, shapes and types.

    Parameters
    ----------
    function : callable
        The jitted function.  Its arguments are positional; named tuples in its results are `exportable`.
    small : int
        With at most this number of entries in each array the program is compiled without optimisation, because it
        runs for less time than it takes to optimise it.
    """

    def __init__(self, function: Any, small: int = 0):
        self.function, self.small = function, small
        self._compiled: dict[Any, Future[Compiled]] = {}
        self._lock = Lock()

    def __call__(self, *arguments: Any) -> Any:
        return self.ready(*arguments)(*arguments)

    def ready(self, *arguments: Any) -> Compiled:
        """The compiled function for arguments of this kind.  Threads that ask for the same one share it."""
        leaves, structure = tree.flatten(arguments)
        kind = structure, tuple(leaf.aval if isinstance(leaf, jax.Array) else jax.typeof(leaf) for leaf in leaves)
        with self._lock:
            is_new = kind not in self._compiled
            compiled = self._compiled.setdefault(kind, Future())
        if is_new:
            try:
                require_double()
                compiled.set_result(_build(self, arguments))
            except BaseException as error:
                del self._compiled[kind]
                compiled.set_exception(error)
        return compiled.result()

    def level(self, arguments: Any) -> int:
        """The level of optimisation for arguments of this kind."""
        return LEVEL_OF_SMALL if largest(arguments) <= self.small else LEVEL


def largest(arguments: Any) -> int:
    """The number of entries of the largest array."""
    return max((np.size(leaf) for leaf in tree.leaves(arguments)), default=0)


def build(program: Program, arguments: Any) -> Compiled:
    """Compile a program here and now."""
    return compiled_at(program.level(arguments), program.function.lower(*arguments))


def compiled_at(level: int, lowered: Any) -> Compiled:
    """Compile with the options for the CPU, as far as XLA knows them and the user has not set them in XLA_FLAGS."""
    if jax.default_backend() != "cpu":
        return lowered.compile()
    chosen = {flag.partition("=")[0].removeprefix("--") for flag in os.environ.get("XLA_FLAGS", "").split()}
    options = {**OPTIONS, "xla_backend_optimization_level": level}
    options = {name: value for name, value in options.items() if name not in chosen}
    try:
        return lowered.compile(compiler_options=options)
    except jax.errors.JaxRuntimeError as error:
        if "No such compile option" not in str(error):
            raise
        return lowered.compile()


_build: Callable[[Program, Any], Compiled] = build


def build_with(builder: Callable[[Program, Any], Compiled]) -> None:
    """Let all programs of this process be built in this way from now on."""
    global _build
    _build = builder


# -- points that are all treated alike --------------------------------------------------------------------------------


def in_blocks(function: Callable[..., Any], chosen: Array, others: Any, *fields: Any) -> Any:
    """At the points chosen what a function gives that treats all points alike, elsewhere what `others` has.

    On a CPU the points chosen are gathered and computed `BLOCK` at a time: many arrays for each point then stay in the
    cache, an iteration ends where its block has converged, and the other points cost nothing.  chosen: bool, of the
    shape of the points, the last axes of every array in the fields, in `others` and in what the function gives.
    """

    def where(values: Array, other: Array) -> Array:
        return jnp.where(chosen, values, other)

    points = chosen.size
    if points <= BLOCK or jax.default_backend() != "cpu":
        return tree.map(where, function(*fields), others)
    blocks = -(-points // BLOCK)
    places = jnp.nonzero(chosen.ravel(), size=blocks * BLOCK, fill_value=0)[0].reshape(blocks, BLOCK)
    count = jnp.cumsum(chosen.ravel())
    fields = tree.map(lambda field: field.reshape(*field.shape[: field.ndim - chosen.ndim], -1), fields)

    def block(number: Array, line: Any) -> Any:
        """The line of points chosen, with those of one more block."""
        new = function(*tree.map(lambda field: field[..., places[number]], fields))
        return tree.map(lambda old, part: lax.dynamic_update_slice_in_dim(old, part, number * BLOCK, -1), line, new)

    def back(line: Array, other: Array) -> Array:
        return where(line[..., jnp.maximum(count - 1, 0)].reshape(other.shape), other)

    def empty(other: Array) -> Array:
        return jnp.zeros((*other.shape[: other.ndim - chosen.ndim], blocks * BLOCK), other.dtype)

    line = lax.fori_loop(0, -(-count[-1] // BLOCK), block, tree.map(empty, others))
    return tree.map(back, line, others)
