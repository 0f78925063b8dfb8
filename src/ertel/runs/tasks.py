"""Functions that are run side by side, with results in order that are kept on disk::

    tasks = [Task(f"M{M}", run, (M,)) for M in (200, 500, 1000)]
    with Engine(jobs=2).workers(len(tasks)) as workers:
        results = run_tasks(tasks, workers, Path("runs"))

Results that are kept are plain data, so that reading them runs no code and a damaged file is noticed.  A failure is a
value.

Plain data: None, truth values, numbers, texts, lists, dicts with texts as keys, NumPy arrays of numbers or texts, and
Datasets of these.  Tuples are written as lists.  A file is an npz archive and its checksum (`files.with_checksum`).  In
the archive "text" is JSON in which each list, dict, array and Dataset is named as such; the arrays are "0", "1", ...
"""

import hashlib
import io
import json
import logging
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from numbers import Integral
from pathlib import Path
from tempfile import TemporaryFile
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from ertel.case.records import ConfigError, show
from ertel.runs.files import reading, replace, with_checksum, without_checksum
from ertel.runs.workers import Failure as Failure
from ertel.runs.workers import LocalWorker, Workers, cores
from ertel.runs.workers import Task as Task
from ertel.version import installed_version, own_sources

_log = logging.getLogger(__name__)


def run_tasks(
    tasks: Sequence[Task],
    workers: Workers,
    directory: Path | None = None,
    on_done: Callable[[Task, Any], object] = lambda task, result: None,
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
        present = _stamp(task)
        try:
            stamp, result = read_plain(_file(directory, task))
        except FileNotFoundError:
            continue
        except (ValueError, LookupError, OSError) as error:  # damaged, or written by another version
            _log.warning("the kept result of %s cannot be read and is computed again: %s", task.name, error)
            continue
        if stamp == present:
            results[task.name] = result
    return results


def _keep(directory: Path, task: Task, result: object) -> None:
    try:
        write_plain(_file(directory, task), [_stamp(task), result])
    except TypeError as error:
        raise TypeError(f"result of task {task.name}: {error}") from error


def _file(directory: Path | None, task: Task) -> Path:
    return (directory or Path()) / f"{task.name}.result"


def _stamp(task: Task) -> str:
    """A digest of what a kept result depends on.  Raises TypeError where the arguments are not plain data."""
    function = task.function.__module__, task.function.__qualname__
    try:
        return digest([installed_version(), own_sources(), *function, task.arguments])
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
    scheduler_file: Path | None = None
    tls: Path | None = None

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


# -- plain data in files ----------------------------------------------------------------------------------------------


def write_plain(path: Path, content: Any) -> None:
    """Write plain data atomically.

    Raises TypeError where the content is not plain data, OSError with the name of the file where it cannot be written.
    """
    archive = with_checksum(_archive(content))
    try:
        replace(path, archive)
    except OSError as error:
        raise OSError(error.errno, error.strerror, str(path)) from error


def read_plain(path: Path) -> Any:
    """The content that was written.  Raises Damaged where the file is damaged, OSError where it cannot be read."""
    content = path.read_bytes()
    with (
        reading(path, "delete it"),
        np.load(io.BytesIO(without_checksum(content)), allow_pickle=False) as archive,
    ):
        return _decoded(json.loads(archive["text"].item()), archive)


def digest(content: Any) -> str:
    """SHA-256 (hexadecimal) of plain data.  Raises TypeError where the content is not plain data."""
    return hashlib.sha256(_archive(content)).hexdigest()


def _archive(content: Any) -> bytes:
    """The npz archive; equal content gives equal bytes, because NumPy writes no dates."""
    arrays: list[NDArray[Any]] = []
    text, archive = json.dumps(_encoded(content, arrays)), io.BytesIO()
    np.savez(archive, allow_pickle=False, text=np.array(text), **{str(i): array for i, array in enumerate(arrays)})
    return archive.getvalue()


def _encoded(content: Any, arrays: list[NDArray[Any]]) -> Any:
    """Content as JSON has it; its arrays are added to the list."""
    match content:
        case None | bool() | int() | float() | str():
            return content
        case np.generic():
            return _encoded(content.item(), arrays)
        case np.ndarray() if content.dtype.kind in "biufcU":
            arrays.append(content)
            return {"array": len(arrays) - 1}
        case list() | tuple():
            return {"list": [_encoded(value, arrays) for value in content]}
        case dict() if all(isinstance(key, str) for key in content):
            return {"dict": {key: _encoded(value, arrays) for key, value in content.items()}}
        case xr.Dataset():
            return {"dataset": _encoded(content.to_dict(data="array"), arrays)}
    raise TypeError(f"a {type(content).__name__} cannot be kept: use numbers, texts, lists, dicts, arrays, Datasets")


def _decoded(content: Any, arrays: Mapping[str, NDArray[Any]]) -> Any:
    if not isinstance(content, Mapping):
        return content
    [(kind, value)] = content.items()
    match kind:
        case "array":
            return arrays[str(value)]
        case "list":
            return [_decoded(each, arrays) for each in value]
        case "dict":
            return {key: _decoded(each, arrays) for key, each in value.items()}
        case "dataset":
            return xr.Dataset.from_dict(_decoded(value, arrays))
    raise ValueError(f"{kind}: must be array, list, dict or dataset")
