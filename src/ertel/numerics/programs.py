"""Compiled programs: quick to compile, from several threads at once, and kept on disk.

JAX compiles a jitted function once for each kind of arguments.  Its own cache on disk keeps the machine code, but to
find an entry it traces the function again in every process, which takes longer than a solution on most grids.  A
`Program` is found by its arguments alone.
"""

import hashlib
import json
import os
from collections.abc import Callable, Iterator
from concurrent.futures import Future
from contextlib import contextmanager, suppress
from dataclasses import dataclass, fields, is_dataclass
from functools import cache, partial
from importlib import import_module
from pathlib import Path
from threading import Lock
from types import FunctionType
from typing import Any
from uuid import uuid4

import jax
import numpy as np
from jax import tree
from jax.sharding import SingleDeviceSharding

from ertel.numerics.arrays import require_double

# XLA's newer way of joining loops takes half as long again to compile, and level 3 twice as long as level 1; the
# programs are equally fast (measured on 65 to 513 nodes per side).  Level 0: a fifth to compile, two to three times
# as long to run.
LEVEL, LEVEL_OF_SMALL = 1, 0
# of a program that is optimised on no grid: it runs once or twice, and compiles in a fifth of the time
ANY_SIZE = 2**62
HURRIED = 2 * 513 * 513  # entries of the largest array, up to which a film is solved sooner than its program optimised
OPTIONS = {"xla_cpu_use_fusion_emitters": False}
KNOWN = ("ertel", "jax", "jaxlib", "numpy", "functools", "builtins")  # the stamp covers the code of these packages
CHECKSUM = hashlib.sha256().digest_size  # bytes at the beginning of a file

Compiled = Callable[..., Any]

_hurried = 0  # entries up to which programs are compiled in a hurry
_later: list[tuple[Path, Any]] = []  # what is then to be compiled for later processes: its file and the lowered program


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
        require_double()
        leaves, structure = tree.flatten(arguments)
        kind = structure, tuple(leaf.aval if isinstance(leaf, jax.Array) else jax.typeof(leaf) for leaf in leaves)
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
        if place and (kept := _read(place)):
            return kept
        lowered = (_renamed(self.function) if place else self.function).lower(*arguments)
        if place and level == LEVEL and largest <= _hurried:
            _later.append((place, lowered))
            return _compile(lowered, _options(LEVEL_OF_SMALL))
        compiled = _compile(lowered, _options(level))
        if place:
            _write(place, compiled)
        return compiled


@contextmanager
def in_a_hurry() -> Iterator[None]:
    """In this block programs to be kept are first compiled without optimising them, up to `HURRIED` entries.

    After it they are compiled for later processes.  So one steady film is there sooner.
    """
    global _hurried
    _hurried = HURRIED
    try:
        yield
        with suppress(KeyboardInterrupt):  # what this process is for is done
            for place, lowered in _later:
                _write(place, _compile(lowered, _options(LEVEL)))
    finally:
        _hurried = 0
        _later.clear()


def hurried() -> int:
    """The number of programs that are to be compiled for later processes."""
    return len(_later)


def _renamed(function: Any) -> Any:
    """The same function with a name of its own, so that JAX does not find it in its cache; it takes all its arguments.

    What JAX has loaded from its cache cannot be written again: XLA leaves out some of the machine code.
    """

    def renamed(*arguments: Any) -> Any:
        return function(*arguments)

    renamed.__name__ = f"{function.__name__}_{uuid4().hex}"
    return jax.jit(renamed, keep_unused=True)


def _options(level: int) -> dict[str, Any]:
    return {**OPTIONS, "xla_backend_optimization_level": level}


def _compile(lowered: Any, options: dict[str, Any]) -> Compiled:
    """Compile with the options for the CPU, as far as XLA knows them and the user has not set them in XLA_FLAGS."""
    if jax.default_backend() != "cpu":
        return lowered.compile()  # type: ignore[no-any-return]
    chosen = {flag.partition("=")[0].removeprefix("--") for flag in os.environ.get("XLA_FLAGS", "").split()}
    options = {name: value for name, value in options.items() if name not in chosen}
    try:
        return lowered.compile(compiler_options=options)  # type: ignore[no-any-return]
    except jax.errors.JaxRuntimeError as error:
        if "No such compile option" not in str(error):
            raise
        return lowered.compile()  # type: ignore[no-any-return]


# -- on disk ----------------------------------------------------------------------------------------------------------

# A file holds a SHA-256 checksum of what follows; one line of JSON with the stamp and the outline of the results; and
# the machine code as XLA writes it.  Nothing in it is a pickle.

_directory: Path | None = None
_stamp = ""


def keep(directory: Path, stamp: str) -> None:
    """Keep programs in a directory from now on.

    stamp: of everything besides its arguments on which a program depends: source code, versions, processor.  Programs
    with another stamp are compiled again.  Constants of a module that are changed at run time are not noticed.
    """
    global _directory, _stamp
    _directory, _stamp = directory, stamp


def is_own(info: os.stat_result, closed: bool = False) -> bool:
    """Whether a file or directory belongs to this user and nobody else may write to it.

    closed: it lies in a directory that nobody else may enter.
    """
    if not hasattr(os, "getuid"):  # Windows
        return True
    return info.st_uid == os.getuid() and (closed or not info.st_mode & 0o022)


def _place(function: Any, level: int, arguments: Any) -> Path | None:
    """The file of a program; None where none is kept: on other devices, with code from outside ertel, or not wished."""
    if _directory is None or jax.default_backend() != "cpu":
        return None
    name = f"{function.__module__}.{function.__name__}"
    leaves, structure = tree.flatten(arguments)
    try:
        kind = f"{name} {level} {[str(jax.typeof(leaf)) for leaf in leaves]} {_structure_text(structure)}"
    except TypeError:
        return None
    return _directory / f"{name}-{hashlib.sha256(kind.encode()).hexdigest()[:32]}"


def _structure_text(structure: Any) -> str:
    """A tree's classes and static data as text.  Raises TypeError for code that the stamp does not cover."""
    node = structure.node_data()
    if node is None:
        return "*"
    return f"{_text(node[0])} {_text(node[1])} ({', '.join(_structure_text(child) for child in structure.children())})"


def _text(thing: Any) -> str:
    """Static data as text, classes and functions by their names."""
    match thing:
        case None | bool() | int() | float() | str():
            return repr(thing)
        case type() | FunctionType() if "<locals>" not in thing.__qualname__:
            if thing.__module__.partition(".")[0] not in KNOWN:
                raise TypeError(f"{thing.__module__} is not covered by the stamp")
            return f"{thing.__module__}.{thing.__qualname__}"
        case tuple() | list():
            return f"{_text(type(thing))}({', '.join(_text(part) for part in thing)})"
        case partial():
            return f"partial{_text([thing.func, thing.args, sorted(thing.keywords.items())])}"
    if is_dataclass(thing):
        return _text([type(thing), *(getattr(thing, field.name) for field in fields(thing))])
    raise TypeError(f"a {type(thing).__name__} has no text that tells it from others")


@dataclass(frozen=True)
class _Loaded:
    """A program from the disk.  executable: XLA's; example: a tree like that of its results."""

    executable: Any
    example: Any

    def __call__(self, *arguments: Any) -> Any:
        leaves = [leaf if isinstance(leaf, jax.Array) else jax.device_put(leaf) for leaf in tree.leaves(arguments)]
        results = self.executable.execute_sharded(leaves)
        values = [np.asarray(array) for (array,) in results.disassemble_into_single_device_arrays()]
        # as of a jitted function: not bound to this device, or what they enter would be compiled once more
        return tree.unflatten(tree.structure(self.example), jax.device_put(values))


def _read(place: Path) -> Compiled | None:
    """The kept program; None where there is none, it has another stamp, others may write to it, or it is damaged."""
    try:
        with place.open("rb") as file:
            if not is_own(os.fstat(file.fileno())):
                return None
            content = file.read()
        body = content[CHECKSUM:]
        if hashlib.sha256(body).digest() != content[:CHECKSUM]:
            return None
        head, _, code = body.partition(b"\n")
        stamp, outline = json.loads(head)
        if stamp != _stamp:
            return None
        _prepare_lapack()
        device = jax.devices()[0]
        devices = SingleDeviceSharding(device)._internal_device_list
        return _Loaded(device.client.deserialize_executable(code, executable_devices=devices), _example(outline))
    except Exception:  # not there, of another version, ...: it is compiled and written again
        return None


def _write(place: Path, compiled: Any) -> None:
    """Write a program in one stroke; a program that cannot be written is compiled again next time."""
    draft = place.with_name(f".{uuid4().hex}")
    with suppress(Exception):  # a full disk, a program that XLA cannot write, ...
        executable = compiled.runtime_executable()
        code = executable.client.serialize_executable(executable)
        body = json.dumps([_stamp, _outline(compiled.out_info)]).encode() + b"\n" + code
        place.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        draft.touch(0o600, exist_ok=False)
        draft.write_bytes(hashlib.sha256(body).digest() + body)
        draft.replace(place)
    with suppress(OSError):
        draft.unlink(missing_ok=True)


def _outline(results: Any) -> Any:
    """Named tuples, tuples and dicts as JSON; 0 for each array."""
    match results:
        case dict():
            return {"dict": {key: _outline(value) for key, value in results.items()}}
        case tuple():
            return {_text(type(results)): [_outline(value) for value in results]}
    return 0


def _example(outline: Any) -> Any:
    """A tree with this outline.  Raises ValueError for anything but a named tuple of ertel."""
    if not outline:
        return 0
    [(kind, parts)] = outline.items()
    if kind == "dict":
        return {key: _example(part) for key, part in parts.items()}
    if kind == "builtins.tuple":
        return tuple(map(_example, parts))
    module, _, name = kind.rpartition(".")
    record = getattr(import_module(module), name) if module.startswith("ertel.") else None
    if not (isinstance(record, type) and issubclass(record, tuple)):
        raise ValueError(f"{kind}: must be a named tuple of ertel")
    return record(*map(_example, parts))


@cache
def _prepare_lapack() -> None:
    """Load LAPACK.  JAX does so when it lowers a linear solve; a program from the disk is not lowered."""
    jax.jit(jax.lax.linalg.lu).lower(np.eye(2))
