"""The small runs that are disturbed, and their solves, which are computed once and then answered from memory.

A fault test is about files, and it needs many short-lived processes.  Compiling or even starting JAX in each of them
would take all the time.  So one process computes each run once and remembers every solve by the bytes of its problem;
its children by fork answer from this memory.  A resumed run that asks for any other problem than the undisturbed run
did is not the same run to the bit, and ends with `Different`.
"""

import gc
import hashlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import jax
import numpy as np
from typer.testing import CliRunner

from ertel.apps.cli import app
from ertel.case.case import Case
from ertel.inputs.case_files import load_case
from ertel.inputs.studies import convergence_series, load_study
from ertel.numerics.programs import Program
from ertel.results.summary import comparisons
from ertel.runs import workers
from ertel.runs.drive import drive, run_of
from ertel.runs.engine import Engine
from ertel.runs.fit import store_fit
from ertel.runs.fit_problem import load_fit_problem
from ertel.runs.store import RunStore, compute, open_run

jax.config.update("jax_enable_x64", True)  # ertel itself asks for it in its public functions alone

ROLLING = '[contact]\nkind = "rolling"\nM = 20\nL = 5\n'
STEEL = (
    '[contact]\nkind = "rolling"\nradius = "10 mm"\nload = "0.5 N"\nmean_speed = "0.5 m/s"\nslide_to_roll = 0.1\n'
    'material_1 = "steel"\nmaterial_2 = "steel"\n'
)
OIL = '[lubricant]\neta0 = "40 mPa*s"\nalpha = "20 / GPa"\n'
EYRING = 'rheology = { law = "ree-eyring", tau0 = "5 MPa" }\n'
ASPERITIES = (
    '[surfaces]\nsigma = "30 nm"\nboundary_friction = 0.12\n'
    'asperities = { law = "persson", longest = "20 um", shortest = "1 um", hurst = 0.8 }\n'
)
SQUALANE = '[lubricant]\noil = "squalane"\ntemperature = "40 degC"\n'
CARREAU = 'rheology = { law = "carreau", G = "6 MPa", n = 0.42 }\n'
RADIAL = '[contact]\nM = 20\nL = 5\n[solver]\nmethod = "radial"\nnodes = 33\n[time]\nuntil = 0.05\n'
TWO_GRIDS = "[solver]\nnodes = 65\n"
IN_TIME = '[solver]\nmethod = "transient"\nnodes = 33\n[time]\nuntil = 0.1\nstep = 0.025\n'
WAVES = '[[roughness]]\nshape = "waviness"\namplitude = 0.01\nwavelength_x = 1.0\nwavelength_y = 1.0\n'
HEIGHTS = '[[roughness]]\nshape = "measured"\nfile = "heights.npy"\nunit = "nm"\ndetrend = "none"\nlength_x = "60 um"\n'
MAPS = "[output]\ninterval = 0.02\n"
CASES = {
    "radial": RADIAL + MAPS,
    "error": RADIAL + MAPS,
    "2d": RADIAL.replace("radial", "2d") + MAPS,
    "rolling": ROLLING + IN_TIME + MAPS + WAVES,
    "steady": ROLLING + TWO_GRIDS,
    "ellipse": f'{ROLLING}radius_ratio = 2.0\nentrainment_angle = "30 deg"\n{TWO_GRIDS}',
    "thinning": STEEL + OIL + EYRING + TWO_GRIDS,
    "thinning in time": STEEL + OIL + EYRING + IN_TIME + MAPS,
    # One grid: JAX copies arrays of more than some 100 kB in threads, which a child by fork does not have
    "thermal": f"{STEEL}{SQUALANE}{CARREAU}[thermal]\n[solver]\nnodes = 33\n",
    "measured": STEEL + OIL + IN_TIME + MAPS + HEIGHTS,
    "starved": f"{ROLLING}[solver]\nnodes = 33\n[lubricant]\nlayer = 0.05\n",
    "layer": RADIAL + MAPS + "[lubricant]\nlayer = 0.05\n",
    "track": ROLLING + IN_TIME + MAPS + "[lubricant]\nlayer = 0.05\n",
    "touching": STEEL + OIL + ASPERITIES + TWO_GRIDS,
    "touching in time": STEEL + OIL + ASPERITIES + IN_TIME + MAPS,
    "line": f"[contact]\nM = 10\nL = 5\nradius_ratio = 0\nlength_ratio = 10\n{TWO_GRIDS}[time]\nuntil = 0.05\n{MAPS}",
    "converge": RADIAL.replace("33", "65") + MAPS,
    "study": RADIAL.replace("M = 20", "M = [20, 25]") + MAPS,
    "fit": 'case = "ball.toml"\n[unknowns]\n"lubricant.eta0" = { bounds = ["40 mPa*s", "60 mPa*s"] }\n'
    '[[measurements]]\nfile = "film.csv"\nat = "end"\nsigma = "0.1 um"\n',
}
BALL = (  # of the fit
    '[contact]\nradius = "10 mm"\ndrop_height = "10 mm"\nmaterial_1 = "steel"\nmaterial_2 = "glass"\n'
    '[lubricant]\neta0 = "50 mPa*s"\nalpha = "15 / GPa"\n[solver]\nmethod = "radial"\nnodes = 33\n'
    "[time]\nuntil = 0.05\n" + MAPS
)
FILM = "x_um,h_um\n0,14.9\n114,15.6\n229,18.0\n"  # about that of the ball, so that the search ends soon
STUDIES = {"study": "sweep", "converge": "converge", "fit": "fit"}  # their commands
FLAGS = {"error": ("--quiet", "--error"), **dict.fromkeys(STUDIES, ("--quiet", "--jobs", "1"))}
FLAGS["fit"] += ("--keep", "all")  # a fit that deletes its runs does them again when it is asked again
NAMES = [*CASES]


@dataclass(frozen=True)
class Kind:
    """A kind of run.  case: its case file; flags: of `ertel run` and `ertel resume`, or of `ertel sweep`."""

    name: str
    case: Path
    flags: tuple[str, ...] = ("--quiet",)

    @property
    def is_study(self) -> bool:
        """Whether it is a study of several runs, whose directory has them in `runs`."""
        return self.name in STUDIES

    def command(self, run: Path) -> list[str]:
        """What begins the run in a directory, or goes on with it."""
        if self.is_study:
            return [STUDIES[self.name], str(self.case), "--out", str(run), *self.flags]
        return [*(["resume", str(run)] if run.exists() else ["run", str(self.case), "--out", str(run)]), *self.flags]

    def cases(self) -> Sequence[Case]:
        """The cases that it computes; of a fit the first one."""
        if self.name == "converge":
            return convergence_series(load_case(self.case)).cases
        if self.name == "fit":
            return [load_case(self.case.with_name("ball.toml"))]
        return load_study(self.case).cases if self.is_study else [load_case(self.case)]


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
    """The chosen kinds of run, their case files in a directory; "error" estimates the error of a radial impact."""
    np.save(directory / "heights.npy", 50.0 * np.sin(np.arange(256.0).reshape(16, 16)))
    (directory / "ball.toml").write_text(BALL, encoding="utf-8")
    (directory / "film.csv").write_text(FILM, encoding="utf-8")
    found = {}
    for name in names:
        case = directory / f"{name.replace(' ', '-')}.toml"
        case.write_text(CASES[name], encoding="utf-8")
        found[name] = Kind(name, case, FLAGS.get(name, ("--quiet",)))
    return found


def flush_every(seconds: float) -> None:
    """How often runs are written, here and in the children."""
    RunStore.flush_interval = seconds


def record(chosen: dict[str, Kind]) -> None:
    """Run everything once, also in two parts, and remember all solves."""
    jax.config.update("jax_cpu_enable_async_dispatch", False)  # a child by fork has not the threads of its parent
    programs: dict[Program, Remembered] = {}
    compiled_of = Program.ready

    def ready(program: Program, *arguments: Any) -> Remembered:
        return programs.setdefault(program, Remembered(lambda *given: compiled_of(program, *given)(*given)))

    Program.ready = ready  # type: ignore[method-assign, assignment]
    workers.check_fork = lambda: None  # the children compute nothing for which JAX needs its threads
    with TemporaryDirectory() as scratch:
        for kind in chosen.values():
            for number, case in enumerate(kind.cases()):
                _compute(case, Path(scratch) / f"{kind.name}-{number}", "--error" in kind.flags)
            if kind.name == "fit":
                store_fit(load_fit_problem(kind.case), Path(scratch) / kind.name, Engine(jobs=1))
    Remembered.recording = False
    gc.collect()
    gc.freeze()  # or each child would look through all of it, and so copy it


def _compute(case: Case, directory: Path, with_error: bool) -> None:
    course = run_of(case)
    store = RunStore.create(directory, course.case, course)
    compute(store, [lambda item: True])
    compute(RunStore.open(directory))
    open_run(directory)
    CliRunner().invoke(app, ["show", str(directory)])  # imports what commands need
    for other in comparisons(case).values() if with_error else ():
        drive(run_of(other))
