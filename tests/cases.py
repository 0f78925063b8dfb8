"""Small cases and reference data shared by the tests."""

import itertools
import os
import subprocess
import sys
import tomllib
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from copy import deepcopy
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from typer.testing import CliRunner

import ertel
from ertel.apps.cli import app
from ertel.case.case import Case
from ertel.case.conditions import Conditions
from ertel.case.methods import METHODS
from ertel.case.sections import Drive, Solver, Time
from ertel.equations.state import State, Stepper
from ertel.inputs.case_files import parse_case
from ertel.numerics.grid import Extrapolation, extrapolate
from ertel.physics.lubricant import Oil
from ertel.physics.scales import Parameters
from ertel.physics.surfaces import Feature
from ertel.runs import files
from ertel.runs.drive import drive
from ertel.runs.stepping import Step, TransientRun
from ertel.solvers.steady import Rolling

DATA = Path(__file__).parent / "data"
REFUSALS = tomllib.loads((DATA / "refusals.toml").read_text(encoding="utf-8"))
CASES = tomllib.loads((DATA / "cases.toml").read_text(encoding="utf-8"))["cases"]  # digest, plain data
OIL = Oil()  # where the laws do not matter: others on the same grid are programs of their own, five seconds each
ISOVISCOUS = Oil(viscosity="isoviscous", density="incompressible")
BARUS = Oil(viscosity="barus", density="incompressible")
SMALL_IMPACT = """
[contact]
radius = "10 mm"
mass = "32.6726 g"
speed = "0.1 m/s"
E_prime = "226.37 GPa"
[lubricant]
eta0 = "10 mPa*s"
alpha = "22 / GPa"
[solver]
nodes = 33
[time]
tolerance = 0.01
"""  # a case file, whose last section goes on
SMALL: dict[str, Any] = tomllib.loads(SMALL_IMPACT)
BALL = SMALL["contact"]
STEEL = {"E1": "210 GPa", "nu1": 0.3, "E2": "210 GPa", "nu2": 0.3}
BODIES = {"material_1": "steel", "material_2": "glass"}
NAMED = {"oil": "squalane", "temperature": "40 degC"}
SHEET = {"nu40": "68 mm^2/s", "nu100": "8.7 mm^2/s", "density": "880 kg/m^3"}
NUMBERS = {"eta0": "15 mPa*s", "alpha": "18 / GPa"}
OF_STEEL = {"density": "7850 kg/m^3", "heat_capacity": "460 J/(kg*K)", "conductivity": "47 W/(m*K)"}
STEEL_BODIES = {f"{key}_{body}": value for body in (1, 2) for key, value in OF_STEEL.items()}  # of [thermal]
HOT = {"temperature": "40 degC", "conductivity": "0.15 W/(m*K)", "beta": "0.04 / K"} | STEEL_BODIES
RADIAL = {"name": "small", "contact": {"M": 200, "L": 10}, "solver": {"method": "radial", "nodes": 33}}
SHORT_FALL = parse_case({**RADIAL, "time": {"tolerance": 0.01, "until": 0.15}, "output": {"interval": 0.05}})
BARUS_LIMIT = 1e-12  # an L at which Barus' oil is isoviscous to round-off, and needs no compilation of its own


def impact(M: float, L: float, nodes: int, **sections: dict[str, Any]) -> Case:
    """A dimensionless Roelands impact on the 2-D grid; sections are merged over the defaults."""
    source: dict[str, Any] = {"contact": {"kind": "impact", "M": M, "L": L}, "solver": {"nodes": nodes}}
    for name, values in sections.items():
        source[name] = {**source.get(name, {}), **values}
    return parse_case(source)


_OTHERS: dict[str, Any] = {
    **{"nodes": 129, "method": "radial", "half_width_y": 6.0, "until": 2.0, "surface": 2},
    "start": None,  # left out
    "asperities": {"law": "greenwood-tripp", "density": 0.04, "sharpness": 0.1},
    **{"density": "incompressible", "rheology": {"law": "ree-eyring", "tau0": "5000000.0 Pa"}},
}


def _other(key: str, value: Any) -> Any:
    """Another value for a key of a case."""
    if isinstance(value, bool):
        return not value
    if key == "viscosity":
        return {"roelands": "barus", "houpert": "exponential"}[value]
    if value == "solved":  # [thermal] inlet; that of [solver] is a length
        return "none"
    if key in _OTHERS and not str(value).endswith("kg/m^3"):
        return _OTHERS[key]
    number, _, unit = str(value).partition(" ")
    changed = 1.01 * float(number) + 0.001 * (not unit)
    return f"{changed!r} {unit}" if unit else changed


def changed_cases(data: dict[str, Any]) -> Iterator[tuple[str, Case]]:
    """Each key of a case, section.key, with the case that has another value there; what is refused is left out."""
    written = Case.from_data(data).to_data()
    for name in written.keys() - {"schema", "name"}:
        for number in range(len(written[name]) if name == "roughness" else 1):
            data = deepcopy(written)
            table = data[name][number] if name == "roughness" else data[name]
            for key, value in list(table.items()):
                if key not in ("kind", "shape"):
                    table[key] = _other(key, value)
                    with suppress(ValueError):
                        yield f"{name}.{key}", Case.from_data(data)
                    table[key] = value


def free_ball(p: Parameters, oil: Oil, solver: Solver, time: Time | None = None, *features: Feature) -> Case:
    """A dimensionless impact from records."""
    contact = Conditions("impact", lambda_bar=p.lambda_bar, alpha_bar=p.alpha_bar)
    return Case(contact, oil, solver, roughness=features, time=time)


def rolled(
    p: Parameters, oil: Oil, solver: Solver, drive: Drive | None = None, *features: Feature, time: Time | None = None
) -> Case:
    """A dimensionless rolling contact from records."""
    contact = Conditions("rolling", lambda_bar=p.lambda_bar, alpha_bar=p.alpha_bar)
    return Case(contact, oil, solver, drive, features, time)


def steady_solver(nodes: int, **changes: Any) -> Solver:
    """The solver of a steady contact."""
    return replace(METHODS["steady"].defaults, nodes=nodes, **changes)


def march(method: Stepper, step: float, steps: int) -> list[State]:
    """Levels of a fixed-step run, newest first."""
    levels = [method.start()]
    for _ in range(steps):
        levels.insert(0, method.advance(levels[:3], step))
        assert levels[0].status.ok
    return levels


def orders(values: Sequence[Any]) -> np.ndarray:
    """Observed orders from numbers or fields on successive grids (or steps), each twice as fine: of the mean square."""
    changes = [np.sqrt(np.mean(np.square(np.subtract(b, a)))) for a, b in itertools.pairwise(values)]
    return np.log2(np.divide(changes[:-1], changes[1:]))


def steps_of(case: Case, method: Stepper, start: Step | None = None) -> list[Step]:
    """All accepted time steps of a run."""
    seen: list[Step] = []
    drive(TransientRun(case, method), [seen.append], start)
    return seen


def ertel_(*arguments: str, code: int = 0) -> Any:
    """The command line, expected to end with a code."""
    result = CliRunner().invoke(app, list(arguments), catch_exceptions=False)
    assert result.exit_code == code, result.output
    return result


def python(
    *arguments: str, without: tuple[str, ...] = (), cwd: Path | None = None, **variables: str
) -> subprocess.CompletedProcess[str]:
    """A new process of Python that has ended well; no variable in its environment begins with those `without`."""
    kept = {name: value for name, value in os.environ.items() if not name.startswith(without)}
    environment = {**kept, "PYTHONPATH": str(Path(ertel.__path__[0]).parent), **variables}
    command = [sys.executable, *arguments]
    pipes = {"stdin": subprocess.DEVNULL, "capture_output": True}
    done = subprocess.run(command, **pipes, text=True, env=environment, cwd=cwd, timeout=300, check=False)
    assert done.returncode == 0, done.stderr
    return done


LEFT = {files.LOCK} if files.fcntl else set()  # in each directory that was locked


def names(directory: Path) -> set[str]:
    return {path.name for path in directory.iterdir()}


def physics(data: xr.Dataset) -> xr.Dataset:
    """The data without what differs between runs: date, wall time."""
    return data.drop_attrs(deep=False)


def stop_after(items: int) -> Callable[[object], bool]:
    """An observer that asks for a stop after so many items."""
    seen = itertools.count(1)
    return lambda item: next(seen) >= items


def extrapolated(rolling: Rolling, name: str) -> Extrapolation:
    """A quantity of `measure` by Richardson's extrapolation: the error falls with the square of the spacing."""
    return extrapolate(*(s.measure()[name] for s in rolling.solutions[-2:]))
