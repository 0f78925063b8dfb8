"""Independent tasks, and who does them: this process one after the other, or the processes of a cluster.

    for name, outcome in LocalWorker().outcomes([Task("a", function, (1, 2))]):
        ...

A task is a function with its arguments.  One that raises has a `Failure` as its outcome: the others go on.
"""

import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from threading import Lock
from typing import Any, Protocol

Condition = Callable[[], bool]


def never() -> bool:
    """Return False: never stop."""
    return False


@dataclass(frozen=True)
class Task:
    """One run of a function with its arguments.  name: unique among the tasks."""

    name: str
    function: Callable[..., Any]
    arguments: tuple[Any, ...] = ()


@dataclass(frozen=True)
class Failure:
    """A task that raised an exception, and its message."""

    reason: str

    @classmethod
    def of(cls, error: BaseException) -> "Failure":
        """The failure that an exception is."""
        return cls(f"{type(error).__name__}: {error}")


class StopSignal:
    """A request to stop that was made in this process; a file shares it with all workers.

    A copy in another process, as pickle makes it, looks for the file only.
    """

    def __init__(self, file: Path, asked: Condition = never):
        self._file, self._asked = file, asked

    def __call__(self) -> bool:
        if self._asked():
            with suppress(OSError):
                self._file.touch()
            return True
        return self._file.is_file()

    def __reduce__(self) -> tuple[Any, ...]:
        return StopSignal, (self._file,)


class Workers(Protocol):
    """The interface of all that do tasks."""

    def outcomes(self, tasks: Sequence[Task], should_stop: Condition = never) -> Iterator[tuple[str, Any]]:
        """Do all tasks: name and outcome of each as soon as it is there, in any order.

        should_stop: is asked again and again, so that tasks with the same `StopSignal` hear of it and end.
        """
        ...


class LocalWorker:
    """This process: one task after the other, each with all cores."""

    def outcomes(self, tasks: Sequence[Task], should_stop: Condition = never) -> Iterator[tuple[str, Any]]:
        """See `Workers`; a task asks its `StopSignal` itself."""
        for task in tasks:
            try:
                outcome = task.function(*task.arguments)
            except Exception as error:
                outcome = Failure.of(error)
            yield task.name, outcome


def cores() -> int:
    """The number of cores that this process may use."""
    if hasattr(os, "sched_getaffinity"):  # not on macOS and Windows
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


# -- threads ----------------------------------------------------------------------------------------------------------
#
# Linear solves on the CPU are done by the BLAS of SciPy, which would take a thread a core.  In matrices as small as
# ertel's its threads wait for each other, most of all where other programs are busy.

_lock, _blocks, _limit = Lock(), 0, None


@contextmanager
def one_blas_thread() -> Iterator[None]:
    """Let the libraries of BLAS in this process compute with one thread in this block; also a decorator.

    The last block that ends, of all threads, sets back what was there before the first.
    """
    global _blocks, _limit
    import scipy.linalg  # noqa: F401 - as JAX does at the first linear solve: a library that comes later has no limit
    from threadpoolctl import threadpool_limits

    with _lock:
        _limit = _limit or threadpool_limits(1, "blas")
        _blocks += 1
    try:
        yield
    finally:
        with _lock:
            _blocks -= 1
            if not _blocks:
                _limit.restore_original_limits()
                _limit = None


# -- forks ------------------------------------------------------------------------------------------------------------

_computing: int | None = None  # the process that has computed first


class Forked(RuntimeError):
    """This process is a copy of one that has computed, in which JAX would wait for ever."""


def check_fork() -> None:
    """Raise Forked where this process is a copy of one that has computed before.

    JAX waits there for threads that only the parent has.
    """
    global _computing
    if _computing is None:
        _computing = os.getpid()
    if _computing != os.getpid():
        instead = 'start processes with multiprocessing.get_context("spawn"), or run the cases with ertel.sweep'
        raise Forked(f"this process was forked from one in which JAX runs, and would hang; {instead}")
