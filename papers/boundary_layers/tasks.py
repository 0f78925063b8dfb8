"""The runs of the figures: functions that are run side by side, and whose results are kept on disk.

Results that are kept are plain data, so that reading them runs no code: None, truth values, numbers, texts, lists,
tables with texts as keys, NumPy arrays of numbers or texts, and Datasets of these.  Tuples come back as lists.
"""

import base64
import hashlib
import json
import logging
import multiprocessing
import os
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from tempfile import TemporaryFile
from typing import Any

import numpy as np
import xarray as xr

import ertel

ARRAY, DATASET = "NumPy array", "xarray Dataset"  # the keys of tables in JSON that stand for one
_log = logging.getLogger(__name__)


@dataclass(frozen=True)
class Task:
    """One run of a function.

    name: unique among the tasks, and the name of the file that keeps the result.  seconds: the expected duration.
    """

    name: str
    function: Callable[..., Any]
    arguments: tuple[Any, ...] = ()
    seconds: float = 0.0


@dataclass(frozen=True)
class Failure:
    """A run that raised an exception, with its message."""

    reason: str


def run_tasks(
    tasks: Sequence[Task],
    directory: Path,
    jobs: int = 1,
    on_done: Callable[[Task, Any], object] = lambda task, result: None,
) -> dict[str, Any]:
    """Run the tasks that have no kept result, on so many processes; return the results by name.

    A run that raises gives a `Failure`, and the others continue.  on_done is called with each task and its result.

    Raises
    ------
    OSError
        A result cannot be written; the earlier ones are kept.
    """
    directory.mkdir(parents=True, exist_ok=True)
    TemporaryFile(dir=directory).close()  # raises before anything is computed where results cannot be kept
    results = kept(tasks, directory)
    for task in tasks:
        if task.name in results:
            on_done(task, results[task.name])
    for task, result in _outcomes([task for task in tasks if task.name not in results], jobs):
        results[task.name] = result
        if not isinstance(result, Failure):
            _keep(directory, task, result)
        on_done(task, result)
    return results


def kept(tasks: Iterable[Task], directory: Path) -> dict[str, Any]:
    """The kept results by name, of the same function, arguments and source code."""
    results = {}
    for task in tasks:
        file = directory / f"{task.name}.result"
        try:
            checksum, _, body = file.read_bytes().partition(b"\n")
            if checksum != _checksum(body):
                raise ValueError("its checksum does not agree")
            stamp, result = json.loads(body, object_hook=_decoded)
        except FileNotFoundError:
            continue
        except (TypeError, ValueError, OSError) as error:
            _log.warning("%s cannot be read, its run is repeated: %s", file, error)
            continue
        if stamp == _stamp(task):
            results[task.name] = result
    return results


def _outcomes(tasks: Sequence[Task], jobs: int) -> Iterator[tuple[Task, Any]]:
    """Run the tasks, in this process for one job."""
    if jobs == 1 or len(tasks) < 2:
        yield from ((task, _performed(task.function, task.arguments)) for task in tasks)
        return
    spawn = multiprocessing.get_context("spawn")  # JAX does not survive a fork
    with ProcessPoolExecutor(min(jobs, len(tasks)), spawn, ertel.cache) as pool:
        running = {pool.submit(_performed, task.function, task.arguments): task for task in tasks}
        try:
            for future in as_completed(running):
                yield running[future], future.result()
        finally:
            pool.shutdown(wait=False, cancel_futures=True)


def _performed(function: Callable[..., Any], arguments: tuple[Any, ...]) -> Any:
    """The result of a run, or its `Failure`."""
    try:
        return function(*arguments)
    except Exception as error:
        return Failure(f"{type(error).__name__}: {error}")


def _keep(directory: Path, task: Task, result: object) -> None:
    """Write a result in one step, so that an interruption leaves no half file."""
    body = json.dumps(_encoded([_stamp(task), result])).encode()
    partial = directory / f"{task.name}.partial"
    partial.write_bytes(_checksum(body) + b"\n" + body)
    os.replace(partial, directory / f"{task.name}.result")


def _checksum(body: bytes) -> bytes:
    return hashlib.sha256(body).hexdigest().encode()


def _stamp(task: Task) -> str:
    """A digest of what a result depends on: function, arguments, and the source code of ertel and of the runs."""
    function = task.function.__module__, task.function.__qualname__
    content = json.dumps(_encoded([*function, task.arguments, _sources()]))
    return hashlib.sha256(content.encode()).hexdigest()


@cache
def _sources() -> str:
    """A digest of the source code of ertel and of the runs."""
    files = [*sorted(Path(ertel.__file__).parent.rglob("*.py")), *sorted(Path(__file__).parent.glob("*runs.py"))]
    return hashlib.sha256(b"".join(file.read_bytes() for file in files)).hexdigest()


# -- plain data -------------------------------------------------------------------------------------------------------


def _encoded(content: Any) -> Any:
    """Content as JSON has it.  Raises TypeError where it is not plain data."""
    match content:
        case None | bool() | int() | float() | str():
            return content
        case np.generic():
            return content.item()
        case np.ndarray() if content.dtype.kind in "biufU":
            values = base64.b64encode(content.tobytes()).decode()
            return {ARRAY: values, "type": content.dtype.str, "shape": content.shape}
        case list() | tuple():
            return [_encoded(value) for value in content]
        case dict():
            return {str(key): _encoded(value) for key, value in content.items()}
        case xr.Dataset():
            return {DATASET: _encoded(content.to_dict(data="array"))}
    raise TypeError(f"a {type(content).__name__} cannot be kept: use numbers, texts, lists, dicts, arrays, Datasets")


def _decoded(table: dict[str, Any]) -> Any:
    """An array or a Dataset in the place of the table that stands for it."""
    if ARRAY in table:
        return np.frombuffer(base64.b64decode(table[ARRAY]), table["type"]).reshape(table["shape"]).copy()
    return xr.Dataset.from_dict(table[DATASET]) if DATASET in table else table
