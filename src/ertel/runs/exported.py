"""Exported programs: kept on disk as `jax.export` writes them, so that a later process traces nothing.

JAX's own cache on disk keeps the machine code, but to find an entry it traces the function again in every process,
which takes longer than a solution on most grids.  An exported program is found by the kind of its arguments alone, and
its machine code by JAX.

A file holds the stamp on a line, what `jax.export` writes, and a checksum.  Nothing in it is a pickle.
"""

import hashlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import fields, is_dataclass
from functools import partial
from pathlib import Path
from types import FunctionType
from typing import Any

import jax
import numpy as np
from jax import export, tree

from ertel.numerics.programs import LEVEL, LEVEL_OF_SMALL, Compiled, Program, build, compiled_at, largest
from ertel.runs.files import content_of, delete_drafts, replace, with_checksum, without_checksum

HURRIED = 2 * 513 * 513  # entries of the largest array, up to which a film is solved sooner than its program optimised
KNOWN = ("ertel", "jax", "jaxlib", "numpy", "functools", "builtins")  # the stamp covers the code of these packages


class ExportedPrograms:
    """Programs that are kept in a directory.

    Parameters
    ----------
    directory : Path
        The directory, to which nobody else may write.
    stamp : str
        Everything besides its arguments on which a program depends: source code and versions.  Programs with another
        stamp are exported again.  Constants of a module that are changed at run time are not noticed.
    """

    def __init__(self, directory: Path, stamp: str):
        self.directory, self.stamp = directory, stamp
        self._hurried = 0  # entries up to which programs are compiled in a hurry
        self._later: list[tuple[Path, bytes, Any]] = []  # programs to compile then: file, content, and lowered by JAX

    def build(self, program: Program, arguments: Any) -> Compiled:
        """The compiled program for arguments of this kind: loaded if it is kept, else kept from now on."""
        try:
            file = self._file(program, arguments)
            kept = self._read(file)
            content = kept or _exported(program, arguments)
        except ValueError:  # code from outside ertel, or something that JAX does not export
            return build(program, arguments)
        lowered = _lowered(content)  # also of a new program, so that JAX finds its machine code next time
        level = program.level(arguments)
        in_a_hurry = not kept and level == LEVEL and largest(arguments) <= self._hurried
        compiled = compiled_at(LEVEL_OF_SMALL if in_a_hurry else level, lowered)
        if in_a_hurry:
            self._later.append((file, content, lowered))
        elif not kept:
            self._write(file, content)
        return lambda *arguments: compiled(*tree.leaves(arguments))

    @contextmanager
    def in_a_hurry(self, tell: Callable[[], object] = lambda: None) -> Iterator[None]:
        """In this block new programs are first compiled without optimising them, up to `HURRIED` entries.

        After it they are compiled for later processes.  So one steady film is there sooner.
        tell: called before that.
        """
        self._hurried = HURRIED
        try:
            yield
            if self._later:
                tell()
            with suppress(KeyboardInterrupt):  # the run itself is done
                for file, content, lowered in self._later:
                    compiled_at(LEVEL, lowered)  # JAX keeps the machine code
                    self._write(file, content)
        finally:
            self._hurried = 0
            self._later.clear()

    def _file(self, program: Program, arguments: Any) -> Path:
        """The file of a program.  Raises ValueError where its arguments hold code that the stamp does not cover."""
        name = f"{program.function.__module__}.{program.function.__name__}"
        leaves, structure = tree.flatten(arguments)
        kind = f"{jax.default_backend()} {[str(jax.typeof(leaf)) for leaf in leaves]} {_structure_text(structure)}"
        return self.directory / f"{name}-{hashlib.sha256(kind.encode()).hexdigest()[:32]}"

    def _read(self, file: Path) -> bytes:
        """The kept program; empty where none is kept with this stamp, or it is damaged."""
        with suppress(OSError, ValueError):
            stamp, _, content = without_checksum(content_of(file)).partition(b"\n")
            if stamp == self.stamp.encode():
                return content
        return b""

    def _write(self, file: Path, content: bytes) -> None:
        """Keep a program whose machine code JAX has kept."""
        with suppress(OSError):  # a full disk, ...: it is exported again next time
            delete_drafts(self.directory, 3600.0)
            replace(file, with_checksum(self.stamp.encode() + b"\n" + content))


# -- export -----------------------------------------------------------------------------------------------------------


def _exported(program: Program, arguments: Any) -> bytes:
    """A program in the form of files, as a function of the leaves of its arguments."""
    leaves, structure = tree.flatten(arguments)
    kinds = [jax.typeof(leaf) for leaf in leaves]

    def on_leaves(*leaves: Any) -> Any:
        return program.function(*tree.unflatten(structure, leaves))

    on_leaves.__name__ = program.function.__name__
    return bytes(export.export(jax.jit(on_leaves))(*kinds).serialize())


def _lowered(content: bytes) -> Any:
    """A program from its form in files, for JAX to compile."""
    exported = export.deserialize(bytearray(content))
    if b"lapack" in content:  # JAX loads LAPACK when it lowers a linear solve, but not with an exported program
        jax.jit(jax.lax.linalg.lu).lower(np.eye(2))

    def call(*leaves: Any) -> Any:
        return exported.call(*leaves)

    call.__name__ = f"exported_{exported.fun_name}"
    return jax.jit(call).lower(*exported.in_avals)


# -- names ------------------------------------------------------------------------------------------------------------


def _structure_text(structure: Any) -> str:
    """A tree's classes and static data as text.  Raises ValueError for code that the stamp does not cover."""
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
                raise ValueError(f"{thing.__module__} is not covered by the stamp")
            return f"{thing.__module__}.{thing.__qualname__}"
        case tuple() | list():
            return f"{_text(type(thing))}({', '.join(_text(part) for part in thing)})"
        case partial():
            return f"partial{_text([thing.func, thing.args, sorted(thing.keywords.items())])}"
    if is_dataclass(thing):
        return _text([type(thing), *(getattr(thing, field.name) for field in fields(thing))])
    raise ValueError(f"a {type(thing).__name__} has no text that tells it from others")
