"""Programs: jitted functions, compiled once for each kind of arguments, also from several threads at once.

A program is compiled here and now, unless `build_with` names another builder, such as one that keeps programs on disk
(`ertel.runs.exported`).
"""

import os
from collections.abc import Callable
from concurrent.futures import Future
from threading import Lock
from typing import Any, TypeVar

import jax
import numpy as np
from jax import export, tree

from ertel.numerics.arrays import require_double

# XLA's newer way of joining loops takes half as long again to compile, and level 3 twice as long as level 1; the
# programs are equally fast (measured on 65 to 513 nodes per side).  Level 0: a fifth to compile, two to three times
# as long to run.
LEVEL, LEVEL_OF_SMALL = 1, 0
# of a program that is optimised on no grid: it runs once or twice, and compiles in a fifth of the time
ANY_SIZE = 2**62
OPTIONS = {"xla_cpu_use_fusion_emitters": False}

Compiled = Callable[..., Any]
Record = TypeVar("Record")


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
        require_double()
        leaves, structure = tree.flatten(arguments)
        kind = structure, tuple(leaf.aval if isinstance(leaf, jax.Array) else jax.typeof(leaf) for leaf in leaves)
        with self._lock:
            known = self._compiled.get(kind)
            compiled = self._compiled.setdefault(kind, Future())
        if known is None:
            try:
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
        return lowered.compile()  # type: ignore[no-any-return]
    chosen = {flag.partition("=")[0].removeprefix("--") for flag in os.environ.get("XLA_FLAGS", "").split()}
    options = {**OPTIONS, "xla_backend_optimization_level": level}
    options = {name: value for name, value in options.items() if name not in chosen}
    try:
        return lowered.compile(compiler_options=options)  # type: ignore[no-any-return]
    except jax.errors.JaxRuntimeError as error:
        if "No such compile option" not in str(error):
            raise
        return lowered.compile()  # type: ignore[no-any-return]


_build: Callable[[Program, Any], Compiled] = build


def build_with(builder: Callable[[Program, Any], Compiled]) -> None:
    """Let all programs of this process be built in this way from now on."""
    global _build
    _build = builder
