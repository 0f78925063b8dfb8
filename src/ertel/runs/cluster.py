"""Tasks on the processes of dask.distributed: of this machine, or of a cluster that is there already.

    with local(2) as workers:
        for name, outcome in workers.outcomes(tasks):
            ...

This module is the only one that knows dask.

Each worker process has one thread.  NPROC=1 keeps the pool of XLA's threads to one too, so that as many runs as there
are cores do not fight for them.  XLA_FLAGS are those of this process, because JAX's cache of compiled programs keeps
programs of other flags apart.  A worker that dies is replaced, and its task begins again on another one.

Whoever reaches a scheduler, a worker or its nanny of dask has it run any function.  So `local` makes a key of its own,
without which none of them talks to anybody, and keeps their files where no other user can write.
"""

import logging
import os
import signal
import sys
import time
import warnings
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager, suppress
from math import inf
from tempfile import TemporaryDirectory
from typing import Any
from uuid import uuid4

import dask
from distributed import Client, Future, KilledWorker, LocalCluster, Security, Worker, WorkerPlugin, as_completed
from distributed.comm.core import FatalCommClosedError
from distributed.utils import silence_logging_cmgr

from ertel.case.records import ConfigError
from ertel.runs import compile
from ertel.runs.compile import ENTRY_WARNINGS
from ertel.runs.workers import Condition, Failure, Task, cores, never
from ertel.version import own_sources

RETRIES = 2  # of a task that raised an error of the system, on this worker or another one
LOOK = 0.1  # s between looks at the tasks
ANSWER = 20  # s in which a scheduler must answer
PATIENCE = 10  # s without any worker, after which this is said
RUNNING = "running"  # the status of a client that has its scheduler
LOST = Failure("the scheduler was lost")
CERTIFICATES = "distributed.comm.tls in dask's configuration"
NO_WORKERS = "the scheduler has no workers: the runs wait until some come"
SETTINGS = {"NPROC": "1", "XLA_PYTHON_CLIENT_PREALLOCATE": "false"}  # workers share the memory of a GPU
ENDING = [getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name)]
LOCAL: dict[str, Any] = {
    "distributed.scheduler.worker-ttl": None,  # compiled code may keep a worker from a sign of life for long
    "distributed.worker.multiprocessing-method": "spawn",  # JAX fears forks
    "distributed.scheduler.http.routes": [],  # its pages take no key, and show tasks and logs to everybody
    "distributed.worker.http.routes": [],
}


class NoScheduler(ConfigError):
    """No scheduler answers at an address."""


# -- clusters ---------------------------------------------------------------------------------------------------------


@contextmanager
def local(jobs: int | None = None) -> Iterator["Cluster"]:
    """Worker processes on this machine, which end with this block and with this process.

    jobs: their number, by default one for each core.
    """
    with ExitStack() as stack:
        settings = {**LOCAL, "temporary-directory": stack.enter_context(_private_directory())}
        stack.enter_context(dask.config.set(settings))
        security = Security.temporary()  # a key that is known to these processes only
        cluster = stack.enter_context(
            LocalCluster(
                n_workers=jobs or cores(),
                threads_per_worker=1,
                processes=True,
                memory_limit=0,
                security=security,
                dashboard_address="127.0.0.1:0",  # any free port: None would take 8787, and complain of a second study
                scheduler_kwargs={"dashboard": False},
                silence_logs=logging.CRITICAL,
                env=SETTINGS,
            )
        )
        yield stack.enter_context(_connected(cluster.scheduler_address, security, ignore_signals=True))


@contextmanager
def _private_directory() -> Iterator[str]:
    """A directory of this user alone.  dask has modules imported from its directories, by default in /tmp."""
    with TemporaryDirectory(prefix="ertel-", ignore_cleanup_errors=True) as directory:
        try:
            yield directory
        finally:  # dask forgets some, and another user may take the name when it is free
            sys.path[:] = [place for place in sys.path if not place.startswith(directory)]


@contextmanager
def existing(address: str) -> Iterator["Cluster"]:
    """The workers of a scheduler that runs; they stay.

    They need this version of ertel, and the directories of the runs under the same names.  The certificates for a
    scheduler at tls:// are those of dask's configuration.  Raises NoScheduler.
    """
    where = f"scheduler = {address}"
    _check_encryption(where, address)
    with ExitStack() as stack:
        try:
            cluster = stack.enter_context(_connected(address, security=None))
        except FatalCommClosedError as error:
            raise NoScheduler(f"{where}: the scheduler has another authority for its certificates") from error
        except (OSError, ValueError) as error:
            none = f"no scheduler answers there within {ANSWER} s; make sure that it runs"
            raise NoScheduler(f"{where}: {none}") from error
        yield cluster


def _check_encryption(where: str, address: str) -> None:
    """Raise NoScheduler unless dask's configuration has certificates for an address that needs them."""
    security = Security()
    try:
        security.get_connection_args("client")
    except OSError as error:  # also of OpenSSL
        raise NoScheduler(f"{where}: {CERTIFICATES} names files that cannot be read: {error}") from error
    if address.startswith("tls://"):
        keys = security.get_tls_config_for_role("client")
        if not keys["cert"] and not dask.config.get("distributed.client.security-loader"):
            raise NoScheduler(f"{where}: needs certificates; name them in {CERTIFICATES}")
    elif security.require_encryption:
        raise NoScheduler(f"{where}: must be tls://HOST:PORT, because dask's configuration requires encryption")


@contextmanager
def _connected(address: str, security: Security | None, ignore_signals: bool = False) -> Iterator["Cluster"]:
    quiet = silence_logging_cmgr(logging.CRITICAL)
    with quiet, Client(address, timeout=ANSWER, set_as_default=False, security=security) as client:
        name = f"ertel-{uuid4().hex[:8]}"
        client.register_plugin(Start(ignore_signals), name=name)
        try:
            yield Cluster(client)
        finally:
            if client.status == RUNNING:
                client.unregister_worker_plugin(name)


# -- this side --------------------------------------------------------------------------------------------------------


class Cluster:
    """The workers of a scheduler, see `workers.Workers`."""

    def __init__(self, client: Client):
        self._client = client

    def outcomes(self, tasks: Sequence[Task], should_stop: Condition = never) -> Iterator[tuple[str, Any]]:
        """See `Workers`.

        Warns where no worker comes.  A stop requested meanwhile ends the wait: waiting tasks yield nothing.
        """
        left, call, patience = {task.name for task in tasks}, uuid4().hex, time.monotonic() + PATIENCE
        names: dict[Future[Any], str] = {}
        try:
            for task in tasks:
                content = performed, task.function, task.arguments, own_sources()
                key = f"ertel-{call}-{task.name}"  # another study may hold the same case on this scheduler
                names[self._client.submit(*content, key=key, retries=RETRIES, pure=False)] = task.name
            done = as_completed(names, loop=self._client.loop)
            while left and not self._is_lost:
                if should_stop() and not self._has_workers():
                    return
                ended = done.next_batch(block=False)
                for future in ended:
                    left.remove(names[future])
                    yield names[future], self._outcome(future)
                if not ended:
                    time.sleep(LOOK)
                if time.monotonic() > patience:
                    patience = time.monotonic() + PATIENCE if self._has_workers() else inf
                    if patience == inf:  # once
                        warnings.warn(NO_WORKERS, RuntimeWarning, stacklevel=2)
            yield from ((name, LOST) for name in left)
        finally:
            if not self._is_lost:
                self._client.cancel(list(names))

    def _outcome(self, future: Future[Any]) -> Any:
        try:
            return future.result()
        except KilledWorker:
            return Failure("its process was killed again and again (out of memory?)")
        except Exception as error:
            return LOST if self._is_lost else Failure.of(error)

    @property
    def _is_lost(self) -> bool:
        return self._client.status != RUNNING

    def _has_workers(self) -> bool:
        with suppress(OSError):  # the scheduler is lost, see above
            return bool(self._client.nthreads())
        return True


# -- on the workers ---------------------------------------------------------------------------------------------------


class Start(WorkerPlugin):
    """The preparation of a worker before its first task.  ignore_signals: whether signals are left to the parent.

    A worker keeps programs on disk as the process does that asks for the tasks.
    """

    def __init__(self, ignore_signals: bool):
        self.ignore_signals, self.flags, self.keep = ignore_signals, os.environ.get("XLA_FLAGS"), compile.chosen

    def setup(self, worker: Worker) -> None:
        """Prepare the process, in its main thread."""
        for number in ENDING if self.ignore_signals else ():
            signal.signal(number, signal.SIG_IGN)
        if "jax" not in sys.modules:  # which reads them when it starts
            os.environ.update(SETTINGS if self.flags is None else {**SETTINGS, "XLA_FLAGS": self.flags})
        if self.keep:
            for beginning in ENTRY_WARNINGS:
                warnings.filterwarnings("ignore", message=beginning)
            self.keep()


def performed(function: Callable[..., Any], arguments: tuple[Any, ...], sources: str) -> Any:
    """The outcome of a task, on a worker.  Errors of the system are raised, so that the task is tried again."""
    if own_sources() != sources:
        return Failure("the worker has another version of ertel; install the same one everywhere")
    from ertel.numerics.programs import double_precision  # imports JAX, which reads SETTINGS

    try:
        with double_precision():
            return function(*arguments)
    except (OSError, MemoryError):
        raise
    except Exception as error:
        return Failure.of(error)
