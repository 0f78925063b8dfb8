"""What the tests of the app share: a made-up run in a directory, and a process that stands for `ertel run`."""

import asyncio
import atexit
import json
import os
import re
import shutil
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from tempfile import mkdtemp
from typing import Any

import numpy as np
from cases import SMALL_IMPACT, ertel_
from made_up import BALL_FALLS, dry_impact
from zarr.storage import LocalStore

import ertel
from ertel.inputs.case_files import parse_case, to_toml
from ertel.runs import arrays
from ertel.runs.files import sealed
from ertel.runs.fit_result import FitPoint, fit_dataset

ROLLING = """
[contact]
kind = "rolling"
radius = "10 mm"
E_prime = "219.7802 GPa"
load = "3.888524 N"
mean_speed = "0.502636 m/s"
[lubricant]
eta0 = "40 mPa*s"
alpha = "22 / GPa"
[solver]
nodes = 65
"""  # of reference/rolling.json, M = 20, L = 10
CASE_FILES = {
    "small.toml": "[contact]\nM = 200\nL = 10\n[solver]\nnodes = 33\n[time]\ntolerance = 0.01\n",
    "ball.toml": SMALL_IMPACT.replace("tolerance = 0.01", "step = 0.01\nuntil = 0.06"),  # six steps
    "steady.toml": ROLLING,
}
STUDY = """
[contact]
M = [20, 40]
L = 5
[solver]
method = "radial"
nodes = 17
[time]
until = 0.02
tolerance = 0.1
"""
CASE = {**BALL_FALLS, "solver": {"method": "radial", "nodes": 41}}
VALUES = {"T": 2.45, "Delta": 1.0, "F": 1.0, "P_c": 1.0, "P_max": 1.0, "H_c": 0.05, "H_min": 0.025}
SUMMARY = {
    "kind": "impact", "method": "radial", "M": 1000.0, "L": 10.0, **VALUES, "restitution": 0.93,
    "status": "converged", "warnings": ["the grid is coarse"], "wall_s": 5.0,
}  # fmt: skip
CHILD = {**os.environ, "PYTHONPATH": str(Path(ertel.__path__[0]).parent)}  # the environment of processes
STANDS_FOR_ERTEL = """
import json, os, pathlib, shutil, sys, time
from ertel.runs import files
from ertel.runs.directory import heeding_stop, is_asked_to_stop
command, first, *rest = sys.argv[1:]
run = pathlib.Path(first if command == "resume" else rest[rest.index("--out") + 1])
goes_on, prepared = run.exists(), pathlib.Path(__file__).with_name("prepared" if command == "run" else "fit")
if command == "run":
    shutil.copytree(prepared, run)
run.mkdir(parents=True, exist_ok=True)

def tell(status, done):
    (run / "progress.json").write_text(json.dumps({"status": status, "T": 1.0, "step": 20, "done": done,
        "seconds": 1.0, "seconds_left": 2.0, "written": "2026-11-22T10:15:03+00:00", "process": os.getpid(),
        **({"message": "point 2 of the search"} if command == "fit" else {})}))

with files.locked(run), heeding_stop(run):
    tell("running", 0.4)
    if command == "fit" and goes_on:
        shutil.copytree(prepared, run, dirs_exist_ok=True)
        tell("converged", 1.0)
        sys.exit()
    if command == "resume":
        shutil.move(run / "later.json", run / "summary.json")
        tell("converged", 1.0)
        sys.exit()
    deadline = time.monotonic() + 20
    while not is_asked_to_stop(run) and time.monotonic() < deadline:
        time.sleep(0.02)
    tell("interrupted", 0.4)
print("ertel: interrupted", file=sys.stderr)
sys.exit(130)
"""


def refused(*arguments: str, code: int = 2) -> str:
    """The one sentence on stderr with which the command line refuses or fails, and nothing on stdout."""
    result = ertel_(*arguments, code=code)
    assert result.stdout == ""
    assert len(result.stderr.splitlines()) == 1, result.stderr
    assert result.stderr.startswith("ertel: ")
    return str(result.stderr)


def given(*settings: str) -> list[str]:
    return [word for setting in settings for word in ("--set", setting)]


def until(there: Callable[[], object], seconds: float = 20.0) -> None:
    deadline = time.monotonic() + seconds
    while not there():
        assert time.monotonic() < deadline
        time.sleep(0.02)


async def shown(there: Callable[[], object]) -> None:
    """Wait in the loop of the app for something to become true."""
    for _ in range(1500):
        if there():
            return
        await asyncio.sleep(0.01)
    raise AssertionError


def all_of(user: Any, marker: str) -> list[Any]:
    from nicegui import ElementFilter  # may not be installed

    with user:
        return list(ElementFilter(marker=marker))


def one(user: Any, marker: str) -> Any:
    (element,) = all_of(user, marker)
    return element


def raising(error: BaseException) -> Callable[..., Any]:
    def fail(*_: object, **__: object) -> Any:
        raise error

    return fail


@cache
def _made() -> Path:
    """A case file and data, written once."""
    place = Path(mkdtemp(prefix="ertel-"))
    atexit.register(shutil.rmtree, place, ignore_errors=True)
    (place / "case.toml").write_text(to_toml(parse_case(CASE)))
    few = dry_impact(CASE, radial=True).isel(frame=slice(None, None, 6))  # files that each test copies
    arrays.write(LocalStore(place / "run.zarr"), few)
    return place


def make_run(directory: Path, finished: bool = True) -> Path:
    """A run along the radius, of which everything is known."""
    shutil.copytree(_made(), directory)
    (directory / ("summary.json" if finished else "later.json")).write_bytes(sealed(SUMMARY))
    return directory


def stand_in(place: Path) -> list[str]:
    """The command of a process that stands for ertel: it copies a prepared run and waits until it is stopped."""
    make_run(place / "prepared", finished=False)
    script = place / "stand_in.py"
    script.write_text(STANDS_FOR_ERTEL)
    return [sys.executable, str(script)]


def make_fit(folder: Path, fit: Path) -> None:
    """The files of a fit in a folder, and its outcome in a directory: two unknowns that the data hardly tell apart."""
    make_run(folder / "runs" / "first")
    shutil.copy(folder / "runs" / "first" / "case.toml", folder / "ball.toml")
    (folder / "film.toml").write_text('case = "ball.toml"\n[unknowns]\n[[measurements]]\nfile = "film.csv"\n')
    make_run(fit / "runs" / "0123456789abcdef")  # as the digest of its case names it
    nothing = np.full((2, 2), np.nan)
    ends = np.array([[0.005, 5e-9], [1.0, 60e-9]])
    jacobian = np.array([[50.0, 50.0], [1.0, -2.0], [30.0, 30.0]])
    found = np.array([0.0976, 22.3e-9])
    point = FitPoint(("eta0", "alpha"), ("Pa*s", "1/Pa"), found, ends, nothing, np.array([0.5, -0.3, 0.9]), jacobian)
    measured = np.array([1e-6, 0.9, 2e-6])
    numbers = {"measurement": np.ones(3), "x": np.full(3, np.nan), "measured": measured, "sigma": 0.01 * measured}
    words = {"x_unit": [""] * 3, "conditions": [""] * 3, "quantity": ["h_c", "restitution", "h_min"]}
    columns = {**numbers, "predicted": measured, **{key: np.array(each, dtype=object) for key, each in words.items()}}
    data = {key: (values, "") for key, values in columns.items()}
    about = {"title": "film", "runs": 9, "best": "runs/0123456789abcdef", "warnings": ["hardly decided"]}
    fit_dataset(point, data, about).to_zarr(fit / "fit.zarr", consolidated=False)
    (fit / "fit.png").write_bytes(b"png")


@contextmanager
def served(folder: Path, *flags: str, **variables: str) -> Iterator[tuple[subprocess.Popen[str], str]]:
    """The app in a folder as a process, and its address with the token."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    environment = {**CHILD, **variables}
    environment.pop("PYTEST_CURRENT_TEST", None)  # NiceGUI asks
    command = [sys.executable, "-m", "ertel", "app", str(folder), "--port", str(port), *flags]
    with subprocess.Popen(command, env=environment, stderr=subprocess.PIPE, text=True) as process:
        assert process.stderr
        message = re.fullmatch(
            r"The app is at (http://127\.0\.0\.1:(\d+)/\S+/\?token=\S+), Ctrl-C closes it\n", process.stderr.readline()
        )
        assert message and int(message[2]) == port
        yield process, message[1]
        process.terminate()
        _, said = process.communicate(timeout=30)
        assert process.returncode == 0 and "Traceback" not in said


def write_progress(run: Path, **content: object) -> None:
    """progress.json as a run has written it."""
    known = {"status": "running", "T": 1.0, "step": 9, "done": 0.5, "seconds": 1.0, "seconds_left": 1.0}
    told = {**known, "written": "2026-11-22T10:15:03+00:00", "process": 1, **content}
    (run / "progress.json").write_text(json.dumps(told))


def is_alive(process: int | str) -> bool:
    """Whether a process has not ended; one that nobody waited for is still listed."""
    try:
        return Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except (FileNotFoundError, ProcessLookupError):
        return False
