"""Independent runs side by side: given to any Executor, collected in order, kept on disk, failures as values.

    tasks = [Task(f"M{M}", run, (M,)) for M in (200, 500, 1000)]
    with processes(2) as executor:
        results = sweep(tasks, executor, Path("runs"))

Any `concurrent.futures.Executor` will do, so dask.distributed can take the place of the processes:
Client.get_executor().  What is kept is pickled: use only a directory of your own.
"""

import logging
import multiprocessing
import os
import pickle
import signal
import threading
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import Executor, Future, ProcessPoolExecutor, as_completed
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import ertel

_log = logging.getLogger(__name__)


@dataclass(frozen=True)
class Task:
    """One run: function(*arguments), both of which travel to another process.

    name: of the file that keeps the result, unique in a sweep.  seconds: what it is expected to take.
    """

    name: str
    function: Callable[..., Any]
    arguments: tuple[Any, ...] = ()
    seconds: float = 0.0


@dataclass(frozen=True)
class Failure:
    """A run that ended with an exception, in words."""

    reason: str


@contextmanager
def processes(jobs: int) -> Iterator[Executor]:
    """Worker processes that leave cores and graphics memory to each other; an interrupt ends them at once."""
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # read when a worker starts: many small dense solves
    os.environ.setdefault("XLA_PYTHON_CLIENT_PREALLOCATE", "false")
    context, others = multiprocessing.get_context("spawn"), set(multiprocessing.active_children())  # JAX fears forks
    with ProcessPoolExecutor(jobs, mp_context=context, initializer=_start_worker) as pool:
        try:
            yield pool
        except BaseException:
            for worker in set(multiprocessing.active_children()) - others:
                worker.terminate()
            raise


def _start_worker() -> None:
    from ertel.runs import compiling

    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent decides
    threading.Thread(target=_end_with_parent, daemon=True).start()
    compiling.keep_on_disk()


def _end_with_parent() -> None:
    """A parent that was killed collects no result: do not compute on for nobody."""
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
    """The results of all tasks in their order, a `Failure` where a run raised.

    directory: where results are kept; what is there is not run again, so that an interrupted sweep goes on where it
    stood.  A result counts only for the same function, arguments and version of ertel.  on_done sees each task with
    its result, as they come.
    """
    by_name = {task.name: task for task in tasks}
    if len(by_name) < len(tasks):
        raise ValueError(f"tasks = {[task.name for task in tasks]}: their names must differ")
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
            future.cancel()  # after an interrupt: what has not begun
    return [found[task.name] for task in tasks]


def kept(tasks: Iterable[Task], directory: Path | None) -> dict[str, Any]:
    """The results that are on disk, by name."""
    found = {}
    for task in tasks if directory else ():
        try:
            stamp, result = pickle.loads(_file(directory, task).read_bytes())
        except FileNotFoundError:
            continue
        except Exception as error:  # a file of another version of anything
            _log.warning("%s cannot be read and is done again: %s", task.name, error)
            continue
        if stamp == _stamp(task):
            found[task.name] = result
    return found


def _keep(directory: Path, task: Task, result: object) -> None:
    directory.mkdir(parents=True, exist_ok=True)
    fresh = _file(directory, task).with_suffix(".new")
    fresh.write_bytes(pickle.dumps((_stamp(task), result)))
    fresh.replace(_file(directory, task))  # whole or not at all


def _file(directory: Path | None, task: Task) -> Path:
    return (directory or Path()) / f"{task.name}.pickle"


def _stamp(task: Task) -> tuple[object, ...]:
    return ertel.__version__, task.function.__module__, task.function.__qualname__, task.arguments


def _outcome(future: Future[Any]) -> Any:
    try:
        return future.result()
    except Exception as error:
        return Failure(f"{type(error).__name__}: {error}")
