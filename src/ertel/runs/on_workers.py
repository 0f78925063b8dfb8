"""What happens on the workers of dask.distributed: their start, and a job with its wire.  See `cluster`."""

import os
import signal
import sys
import time
import warnings
from collections.abc import Callable
from math import inf
from typing import Any

from distributed import Event, Worker, WorkerPlugin, get_worker

from ertel.runs.compile import ENTRY_WARNINGS, chosen_cache
from ertel.runs.workers import Failure, News
from ertel.version import own_sources

ASK = 0.5  # s between questions of a job whether it should stop: each goes to the scheduler and back
SETTINGS = {"NPROC": "1", "XLA_PYTHON_CLIENT_PREALLOCATE": "false"}  # they share the memory of a GPU
ENDING = [getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name)]


class Start(WorkerPlugin):
    """What a worker does before its first job.  deaf: whether signals are left to the parent.

    A worker keeps programs on disk as the process does that asks for the jobs.
    """

    def __init__(self, deaf: bool = False):
        self.deaf, self.flags, self.keep = deaf, os.environ.get("XLA_FLAGS"), chosen_cache()

    def setup(self, worker: Worker) -> None:
        """Prepare the process, in its main thread."""
        for number in ENDING if self.deaf else ():
            signal.signal(number, signal.SIG_IGN)
        if "jax" not in sys.modules:  # which reads them when it starts
            os.environ.update(SETTINGS if self.flags is None else {**SETTINGS, "XLA_FLAGS": self.flags})
        if self.keep:
            for beginning in ENTRY_WARNINGS:
                warnings.filterwarnings("ignore", message=beginning)
            self.keep()


def performed(function: Callable[..., Any], arguments: tuple[Any, ...], key: str, topic: str, sources: str) -> Any:
    """The outcome of a job, on a worker.  Errors of the system are raised, so that the job is tried again."""
    if own_sources() != sources:
        return Failure("the worker has another version of ertel; install the same one everywhere")
    from ertel.numerics.arrays import double_precision  # imports JAX, which reads SETTINGS

    try:
        with double_precision():
            return function(_Wire(key, topic), *arguments)
    except (OSError, MemoryError):
        raise
    except Exception as error:
        return Failure.of(error)


class _Wire:
    """The `Wire` of a job on a worker."""

    def __init__(self, key: str, topic: str):
        self._key, self._topic, self._worker = key, topic, get_worker()
        self._stop = Event(topic)
        self._asked = -inf

    def tell(self, news: News) -> None:
        self._worker.log_event(self._topic, (self._key, dict(news)))

    def stopped(self) -> bool:
        if time.monotonic() - self._asked < ASK:
            return False
        self._asked = time.monotonic()
        return bool(self._stop.is_set())
