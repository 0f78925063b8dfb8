"""Compiled programs: quick to compile, from several threads at once, and kept on disk.

JAX compiles a jitted function once for each kind of arguments.  Its own cache on disk keeps the machine code, but to
find an entry it traces the function again in every process, which takes longer than a solution on most grids.  A
`Program` is found by its arguments alone.
"""

import hashlib
import io
import pickle
from collections.abc import Callable
from concurrent.futures import Future
from contextlib import suppress
from functools import cache
from pathlib import Path
from threading import Lock
from types import FunctionType
from typing import Any
from uuid import uuid4

import jax
import jax.numpy as jnp
import numpy as np
from jax import tree
from jax.experimental import serialize_executable

# XLA's newer way of joining loops takes half as long again to compile, and level 3 twice as long as level 1; the
# programs are equally fast (measured on 65 to 513 nodes per side).  Level 0: a fifth to compile, two to three times
# as long to run.
LEVEL, LEVEL_OF_SMALL = 1, 0
OPTIONS = {"xla_cpu_use_fusion_emitters": False}
KNOWN = ("ertel", "jax", "jaxlib", "numpy", "functools", "builtins", "collections", "copyreg")  # code of these packages

Compiled = Callable[..., Any]


class Program:
    """A jitted function, compiled for each kind of arguments: structure, shapes and types.

    small: with at most this number of entries in each array, the program is compiled without optimisation, because it
    runs for less time than it takes to optimise it.
    """

    def __init__(self, function: Any, small: int = 0):
        self.function, self.small = function, small
        self._compiled: dict[Any, Future[Compiled]] = {}
        self._lock = Lock()

    def __call__(self, *arguments: Any) -> Any:
        return self.ready(*arguments)(*arguments)

    def ready(self, *arguments: Any) -> Compiled:
        """What is compiled for these arguments; only their kind matters.  Threads that ask for the same share it."""
        leaves, structure = tree.flatten(arguments)
        kind = structure, tuple(jax.typeof(leaf) for leaf in leaves)
        with self._lock:
            known = self._compiled.get(kind)
            program = self._compiled.setdefault(kind, Future())
        if known is None:
            try:
                program.set_result(self._make(arguments))
            except BaseException as error:
                del self._compiled[kind]
                program.set_exception(error)
        return program.result()

    def _make(self, arguments: Any) -> Compiled:
        largest = max((np.size(leaf) for leaf in tree.leaves(arguments)), default=0)
        level = LEVEL_OF_SMALL if largest <= self.small else LEVEL
        place = _place(self.function, level, arguments)
        if place and (kept := _read(place, arguments)):
            return kept
        function = _renamed(self.function) if place else self.function
        compiled = _compile(function.lower(*arguments), {**OPTIONS, "xla_backend_optimization_level": level})
        if place:
            _write(place, compiled)
        return compiled


def _renamed(function: Any) -> Any:
    """The same function with a name of its own, so that JAX does not find it in its cache.

    What JAX has loaded from its cache cannot be written again: XLA leaves out some of the machine code.
    """

    def renamed(*arguments: Any) -> Any:
        return function(*arguments)

    renamed.__name__ = f"{function.__name__}_{uuid4().hex}"
    return jax.jit(renamed)


def _compile(lowered: Any, options: dict[str, Any]) -> Compiled:
    """Compile with the options for the CPU, as far as this version of XLA knows them."""
    if jax.default_backend() != "cpu":
        return lowered.compile()  # type: ignore[no-any-return]
    try:
        return lowered.compile(compiler_options=options)  # type: ignore[no-any-return]
    except jax.errors.JaxRuntimeError as error:
        if "No such compile option" not in str(error):
            raise
        return lowered.compile()  # type: ignore[no-any-return]


# -- on disk ----------------------------------------------------------------------------------------------------------

_directory: Path | None = None
_stamp = ""


def keep(directory: Path, stamp: str) -> None:
    """Keep programs in a directory from now on.

    stamp: of everything besides its arguments on which a program depends: source code, versions, processor.  Programs
    with another stamp are compiled again.  Constants of a module that are changed at run time are not noticed.
    """
    global _directory, _stamp
    _directory, _stamp = directory, stamp


def _place(function: Any, level: int, arguments: Any) -> Path | None:
    """The file of a program; None where none is kept: on other devices, with code from outside ertel, or not wished."""
    if _directory is None or jax.default_backend() != "cpu":
        return None
    text = io.BytesIO()
    pickler = _ByReference(text)
    pickler.fast = True  # equal objects give equal text, whether they are one object or two
    try:
        pickler.dump(tree.map(lambda leaf: str(jax.typeof(leaf)), arguments))
    except (pickle.PicklingError, AttributeError, TypeError, ValueError):
        return None
    name = f"{function.__module__}.{function.__name__}"
    digest = hashlib.sha256(f"{name} {level} ".encode() + text.getvalue()).hexdigest()
    return _directory / f"{name}-{digest[:32]}"


class _ByReference(pickle.Pickler):
    """Writes classes and functions by their names, which is enough for code that the stamp covers; refuses others."""

    def reducer_override(self, thing: Any) -> Any:
        if isinstance(thing, type | FunctionType) and thing.__module__.partition(".")[0] not in KNOWN:
            raise pickle.PicklingError(f"{thing.__module__} is not covered by the stamp")
        return NotImplemented


def _read(place: Path, arguments: Any) -> Compiled | None:
    """The kept program; None where there is none, it has another stamp, or it cannot be read."""
    try:
        with place.open("rb") as file:
            stamp, code, example = pickle.load(file)
        if stamp != _stamp:
            return None
        _prepare_lapack()
        structures = tree.structure((arguments, {})), tree.structure(example)
        program: Compiled = serialize_executable.deserialize_and_load(code, *structures)
        return program
    except Exception:  # cut short, of another version, ...: it is compiled and written again
        return None


def _write(place: Path, compiled: Any) -> None:
    """Write a program in one stroke; a program that cannot be written is compiled again next time."""
    draft = place.with_name(f".{uuid4().hex}")
    with suppress(Exception):  # a full disk, a program that XLA cannot write, ...
        code, _, structure = serialize_executable.serialize(compiled)
        example = tree.unflatten(structure, [0] * structure.num_leaves)
        place.parent.mkdir(parents=True, exist_ok=True)
        draft.write_bytes(pickle.dumps((_stamp, code, example)))
        draft.replace(place)
    with suppress(OSError):
        draft.unlink(missing_ok=True)


@cache
def _prepare_lapack() -> None:
    """Load LAPACK.  JAX does so when it lowers a linear solve; a program from the disk is not lowered."""
    jax.jit(jnp.linalg.inv).lower(np.eye(2))
