"""Functions that are run side by side, with results in order that are kept on disk::

    tasks = [Task(f"M{M}", run, (M,)) for M in (200, 500, 1000)]
    with Engine(jobs=2).workers(len(tasks)) as workers:
        results = run_tasks(tasks, workers, Path("runs"))

Results that are kept are plain data, so that reading them runs no code and a damaged file is noticed.  A failure is a
value.

Plain data: None, truth values, numbers, texts, lists, dicts with texts as keys, NumPy arrays of numbers or texts, and
Datasets of these.  Tuples are written as lists.  A file is JSON and its checksum (`files.with_checksum`).
"""

import base64
import hashlib
import json
import logging
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from numbers import Integral
from pathlib import Path
from tempfile import TemporaryFile
from typing import Any

import numpy as np
import xarray as xr

from ertel.case.records import ConfigError, show
from ertel.runs.files import content_of, reading, replace, with_checksum, without_checksum
from ertel.runs.workers import Failure as Failure
from ertel.runs.workers import LocalWorker, Workers, cores
from ertel.runs.workers import Task as Task
from ertel.version import installed_version, own_sources

ARRAY, DATASET = "NumPy array", "xarray Dataset"  # the keys of tables in JSON that stand for one
OnDone = Callable[[Task, Any], object]
_log = logging.getLogger(__name__)


def run_tasks(
    tasks: Sequence[Task], workers: Workers, directory: Path | None = None, on_done: OnDone = lambda task, result: None
) -> list[Any]:
    """Run all tasks that have no kept result.

    Parameters
    ----------
    tasks : sequence of Task
        Their names must differ.
    workers : Workers
        They run the tasks: `workers.LocalWorker()` is this process, `Engine` gives others.
    directory : Path, optional
        The directory in which results are kept.  A kept result is used again, so that what was interrupted goes on
        where it was.  It must come from the same function, arguments, version and source code of ertel.  The source
        code of functions outside ertel is not compared.  Arguments and results must be plain data, see
        `ertel.tasks`; a tuple comes back as a list.
    on_done : callable
        Is called with each task and its result as soon as it is there.

    Returns
    -------
    list
        The results in the order of the tasks, a `Failure` for each run that raised an exception.

    Raises
    ------
    ValueError
        Two tasks have the same name.
    TypeError
        Arguments or a result that must be kept are not plain data.
    OSError
        A result cannot be written; those before it are kept.
    """
    by_name = {task.name: task for task in tasks}
    if len(by_name) < len(tasks):
        raise ValueError(f"tasks = {[task.name for task in tasks]}: their names must differ")
    if directory:
        directory.mkdir(parents=True, exist_ok=True)
        TemporaryFile(dir=directory).close()  # raises before anything is computed where results cannot be kept
    results = kept(tasks, directory)
    for name, result in results.items():
        on_done(by_name[name], result)
    for name, result in workers.outcomes([task for task in tasks if task.name not in results]):
        results[name] = result
        if directory and not isinstance(result, Failure):
            _keep(directory, by_name[name], result)
        on_done(by_name[name], result)
    return [results[task.name] for task in tasks]


def kept(tasks: Iterable[Task], directory: Path | None) -> dict[str, Any]:
    """Task name -> kept result, for the tasks that have a valid one."""
    results = {}
    for task in tasks if directory else ():
        file, present = _file(directory, task), _stamp(task)
        try:
            with reading(file, "delete it"):
                stamp, result = json.loads(without_checksum(content_of(file)), object_hook=_decoded)
        except FileNotFoundError:
            continue
        except (ValueError, OSError) as error:  # damaged, or written by another version
            _log.warning("the kept result of %s cannot be read and is computed again: %s", task.name, error)
            continue
        if stamp == present:
            results[task.name] = result
    return results


def _keep(directory: Path, task: Task, result: object) -> None:
    file = _file(directory, task)
    try:
        replace(file, with_checksum(_json([_stamp(task), result])))
    except TypeError as error:
        raise TypeError(f"result of task {task.name}: {error}") from error
    except OSError as error:
        raise OSError(error.errno, error.strerror, str(file)) from error


def _file(directory: Path | None, task: Task) -> Path:
    return (directory or Path()) / f"{task.name}.result"


def _stamp(task: Task) -> str:
    """A digest of what a kept result depends on.  Raises TypeError where the arguments are not plain data."""
    function = task.function.__module__, task.function.__qualname__
    try:
        return hashlib.sha256(_json([installed_version(), own_sources(), *function, task.arguments])).hexdigest()
    except TypeError as error:
        raise TypeError(f"arguments of task {task.name}: {error}") from error


# -- who does them ----------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Engine:
    """The processes that do the runs.

    jobs: processes of this machine, None for one for each core; 1 is this process.  scheduler, scheduler_file: the
    address of a scheduler that runs, or the file that it wrote; its workers do them.  tls: for a scheduler at tls://,
    a PEM file with a certificate, its key and the certificate of the authority.
    """

    jobs: int | None = None
    scheduler: str | None = None
    scheduler_file: str | Path | None = None
    tls: str | Path | None = None

    def __post_init__(self) -> None:
        if self.scheduler and self.scheduler_file:
            raise ConfigError(f"scheduler = {show(self.scheduler)}: give it, or scheduler_file, not both")
        if self.tls and not (self.scheduler or self.scheduler_file):
            raise ConfigError(f"tls = {self.tls}: only with scheduler or scheduler_file; local processes have own keys")
        if self.jobs is not None and not (isinstance(self.jobs, Integral) and self.jobs >= 1):
            raise ConfigError(f"jobs = {show(self.jobs)}: must be one or more, a whole number")

    @property
    def processes(self) -> int:
        """The number of processes of this machine."""
        return self.jobs or cores()

    @contextmanager
    def workers(self, runs: int) -> Iterator[Workers]:
        """The workers for so many runs, and no more processes than these.  Raises NoScheduler."""
        elsewhere = self.scheduler or self.scheduler_file
        jobs = min(self.processes, runs)
        if runs == 0 or (jobs == 1 and not elsewhere):
            yield LocalWorker()
            return
        from ertel.runs import cluster  # imports dask

        where = self.scheduler, self.scheduler_file, self.tls
        with cluster.existing(*where) if elsewhere else cluster.local(jobs) as workers:
            yield workers


# -- plain data -------------------------------------------------------------------------------------------------------


def _json(content: Any) -> bytes:
    """Plain data as JSON.  Raises TypeError where the content is not plain data."""
    return json.dumps(_encoded(content)).encode()


def _encoded(content: Any) -> Any:
    """Content as JSON has it."""
    match content:
        case None | bool() | int() | float() | str():
            return content
        case np.generic():
            return _encoded(content.item())
        case np.ndarray() if content.dtype.kind in "biufcU":
            values = base64.b64encode(content.tobytes()).decode()
            return {ARRAY: values, "type": content.dtype.str, "shape": content.shape}
        case list() | tuple():
            return [_encoded(value) for value in content]
        case dict() if all(isinstance(key, str) for key in content):
            return {key: _encoded(value) for key, value in content.items()}
        case xr.Dataset():
            return {DATASET: _encoded(content.to_dict(data="array"))}
    raise TypeError(f"a {type(content).__name__} cannot be kept: use numbers, texts, lists, dicts, arrays, Datasets")


def _decoded(table: dict[str, Any]) -> Any:
    """An array or a Dataset in the place of the table that stands for it."""
    if ARRAY in table:
        return np.frombuffer(base64.b64decode(table[ARRAY]), table["type"]).reshape(table["shape"]).copy()
    return xr.Dataset.from_dict(table[DATASET]) if DATASET in table else table
