"""Independent runs in parallel on any Executor.  Results are in order and stored on disk; a failure is a value.

    tasks = [Task(f"M{M}", run, (M,)) for M in (200, 500, 1000)]
    with processes(2) as executor:
        results = sweep(tasks, executor, Path("runs"))

Any `concurrent.futures.Executor` will do, for example that of dask.distributed: Client.get_executor().
Results that are kept are plain data, see `ertel.runs.plain`.
"""

import logging
import multiprocessing
import os
import signal
import threading
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import Executor, Future, ProcessPoolExecutor, as_completed
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryFile
from typing import Any

from ertel.runs import plain
from ertel.version import installed_version, own_sources

_log = logging.getLogger(__name__)


@dataclass(frozen=True)
class Task:
    """One run: function(*arguments).  Function and arguments are pickled to reach another process.

    name: names the file that keeps the result, unique in a sweep.  seconds: expected duration.
    """

    name: str
    function: Callable[..., Any]
    arguments: tuple[Any, ...] = ()
    seconds: float = 0.0


@dataclass(frozen=True)
class Failure:
    """A run that raised an exception, and its message."""

    reason: str


@contextmanager
def processes(jobs: int) -> Iterator[Executor]:
    """Worker processes with one thread each, which share the memory of a GPU.  An error ends them at once."""
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # read when a worker starts: many small dense solves
    os.environ.setdefault("XLA_PYTHON_CLIENT_PREALLOCATE", "false")
    context, others = multiprocessing.get_context("spawn"), set(multiprocessing.active_children())  # JAX fears forks
    complain = threading.excepthook
    with ProcessPoolExecutor(jobs, mp_context=context, initializer=_start_worker) as pool:
        try:
            yield pool
        except BaseException:
            threading.excepthook = lambda _: None  # the pool's thread stumbles over tasks that were cancelled
            for worker in set(multiprocessing.active_children()) - others:
                worker.terminate()
            pool.shutdown()
            raise
        finally:
            threading.excepthook = complain


def _start_worker() -> None:
    from ertel.runs import compiling

    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent decides
    threading.Thread(target=_end_with_parent, daemon=True).start()
    compiling.start_at_once()


def _end_with_parent() -> None:
    """End this worker when its parent was killed: nobody would collect the result."""
    parent = multiprocessing.parent_process()
    if parent:
        parent.join()
        os._exit(1)


def sweep(
    tasks: Sequence[Task],
    executor: Executor,
    directory: Path | None = None,
    on_done: Callable[[Task, Any], object] = lambda task, result: None,
) -> list[Any]:
    """Run all tasks that have no kept result.

    Parameters
    ----------
    tasks : sequence of Task
        Their names must differ.
    executor : concurrent.futures.Executor
        Runs the tasks.
    directory : Path, optional
        Where results are kept.  A kept result is used again, so that an interrupted sweep goes on where it was.  It
        must come from the same function, arguments, version and source code of ertel.  The source code of functions
        outside ertel is not compared.  Arguments and results must be plain data, see `ertel.runs.plain`; a tuple comes
        back as a list.
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
        _require_writable(directory)
    found = kept(tasks, directory)
    for name, result in found.items():
        on_done(by_name[name], result)
    futures = {executor.submit(task.function, *task.arguments): task for task in tasks if task.name not in found}
    try:
        for future in as_completed(futures):
            task, result = futures[future], _outcome(future)
            found[task.name] = result
            if directory and not isinstance(result, Failure):
                _keep(directory, task, result)
            on_done(task, result)
    finally:
        for future in futures:
            future.cancel()  # after an interrupt, the tasks that have not begun
    return [found[task.name] for task in tasks]


def kept(tasks: Iterable[Task], directory: Path | None) -> dict[str, Any]:
    """Task name -> kept result, for the tasks that have a valid one."""
    found = {}
    for task in tasks if directory else ():
        wanted = _stamp(task)
        try:
            stamp, result = plain.read(_file(directory, task))
        except FileNotFoundError:
            continue
        except (ValueError, LookupError, OSError) as error:  # damaged, or written by another version
            _log.warning("the kept result of %s cannot be read and is computed again: %s", task.name, error)
            continue
        if stamp == wanted:
            found[task.name] = result
    return found


def _require_writable(directory: Path) -> None:
    """Raise OSError before anything is computed where results cannot be kept."""
    directory.mkdir(parents=True, exist_ok=True)
    TemporaryFile(dir=directory).close()


def _keep(directory: Path, task: Task, result: object) -> None:
    try:
        plain.write(_file(directory, task), [_stamp(task), result])
    except TypeError as error:
        raise TypeError(f"result of task {task.name}: {error}") from error


def _file(directory: Path | None, task: Task) -> Path:
    return (directory or Path()) / f"{task.name}.result"


def _stamp(task: Task) -> str:
    """A digest of what a kept result depends on.  Raises TypeError where the arguments are not plain data."""
    function = task.function.__module__, task.function.__qualname__
    try:
        return plain.digest([installed_version(), own_sources(), *function, task.arguments])
    except TypeError as error:
        raise TypeError(f"arguments of task {task.name}: {error}") from error


def _outcome(future: Future[Any]) -> Any:
    try:
        return future.result()
    except Exception as error:
        return Failure(f"{type(error).__name__}: {error}")
