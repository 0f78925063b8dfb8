"""The small runs that are disturbed, and their solves, which are computed once and then answered from memory.

A fault test is about files, and it needs many short-lived processes.  Compiling or even starting JAX in each of them
would take all the time.  So one process computes each run once and remembers every solve by the bytes of its problem;
its children by fork answer from this memory.  A resumed run that asks for any other problem than the undisturbed run
did is not the same run to the bit, and ends with `Different`.
"""

import hashlib
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import jax
import numpy as np
from typer.testing import CliRunner

from ertel.apps.cli import app
from ertel.inputs.case_files import load_case
from ertel.numerics.programs import Program
from ertel.runs import arrays
from ertel.runs.courses import course_of
from ertel.runs.drive import drive
from ertel.runs.store import RunStore, compute, open_run
from ertel.solvers import radial

jax.config.update("jax_enable_x64", True)  # ertel itself asks for it in its public functions alone

WAVES = '[[roughness]]\nshape = "waviness"\namplitude = 0.01\nwavelength_x = 1.0\nwavelength_y = 1.0\n'
MAPS = "[output]\ninterval = 0.02\n"
CASES = {
    "radial": '[contact]\nM = 20\nL = 5\n[solver]\nmethod = "radial"\nnodes = 33\n[time]\nuntil = 0.05\n' + MAPS,
    "2d": '[contact]\nM = 20\nL = 5\n[solver]\nmethod = "2d"\nnodes = 33\n[time]\nuntil = 0.05\n' + MAPS,
    "rolling": '[contact]\nkind = "rolling"\nM = 20\nL = 5\n[solver]\nmethod = "transient"\nnodes = 33\n'
    "[time]\nuntil = 0.1\nstep = 0.025\n" + MAPS + WAVES,
    "steady": '[contact]\nkind = "rolling"\nM = 20\nL = 5\n[solver]\nnodes = 65\n',
}


@dataclass(frozen=True)
class Kind:
    """A kind of run.  case: its case file; flags: of `ertel run` and `ertel resume`."""

    name: str
    case: Path
    flags: tuple[str, ...] = ("--quiet",)


class Different(Exception):
    """A solve that the undisturbed run did not ask for."""


class Remembered:
    """A function of arrays whose results are remembered.  recording: whether it computes what it does not know."""

    recording = True

    def __init__(self, function: Callable[..., Any]):
        self.function = function
        self.known: dict[str, Any] = {}

    def __call__(self, *arguments: Any) -> Any:
        key = _digest(arguments)
        if key not in self.known:
            if not self.recording:
                raise Different("the run asks for a solve that the undisturbed run did not ask for")
            self.known[key] = jax.block_until_ready(self.function(*arguments))
        return self.known[key]


def _digest(arguments: Any) -> str:
    digest = hashlib.sha256()
    for leaf in jax.tree.leaves(arguments):
        values = np.asarray(leaf)
        digest.update(f"{values.dtype}{values.shape}".encode() + values.tobytes())
    return digest.hexdigest()


def kinds(directory: Path, names: list[str]) -> dict[str, Kind]:
    """The chosen kinds of run; "error" is the radial impact with the estimate of its error."""
    found = {}
    for name in names:
        case = directory / f"{name}.toml"
        case.write_text(CASES["radial" if name == "error" else name], encoding="utf-8")
        found[name] = Kind(name, case, ("--quiet", "--error") if name == "error" else ("--quiet",))
    return found


NAMES = [*CASES, "error"]


def flush_every(seconds: float) -> None:
    """How often runs in time are written, here and in the children."""
    arrays.AppendedData.flush_interval = seconds


def record(chosen: dict[str, Kind]) -> None:
    """Run everything once, also in two parts, and remember all solves."""
    jax.config.update("jax_cpu_enable_async_dispatch", False)  # a child by fork has not the threads of its parent
    radial.solve = Remembered(radial.solve)
    programs: dict[Program, Remembered] = {}
    compute_it = Program.__call__

    def remembered(program: Program, *arguments: Any) -> Any:
        return programs.setdefault(program, Remembered(partial(compute_it, program)))(*arguments)

    Program.__call__ = remembered  # type: ignore[method-assign, assignment]
    with TemporaryDirectory() as scratch:
        for kind in chosen.values():
            course = course_of(load_case(kind.case))
            store = RunStore.create(Path(scratch) / kind.name, course.case, course)
            compute(store, [lambda item: True])
            compute(RunStore.open(store.directory))
            open_run(store.directory)
            CliRunner().invoke(app, ["show", str(store.directory)])  # imports what commands need
            for other in course.comparisons.values() if "--error" in kind.flags else ():
                drive(other)
    Remembered.recording = False
    Program.ready = lambda program, *arguments: None  # type: ignore[method-assign, assignment]
