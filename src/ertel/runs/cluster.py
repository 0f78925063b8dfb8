"""Jobs on the processes of dask.distributed: of this machine, or of a cluster that is there already.

    with local(2) as workers:
        for key, outcome in workers.outcomes(jobs):
            ...

This module and `on_workers` are the only ones that know dask.

Each worker process has one thread.  NPROC=1 keeps the pool of XLA's threads to one too, so that as many runs as there
are cores do not fight for them.  XLA_FLAGS are those of this process, because JAX's cache of compiled programs keeps
programs of other flags apart.  A worker that dies is replaced, and its job begins again on another one.

Whoever reaches a scheduler, a worker or its nanny of dask has it run any function.  So `local` makes a key of its own,
without which none of them talks to anybody, and keeps their files where no other user can write.
"""

import logging
import sys
import time
import warnings
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager, suppress
from math import inf
from pathlib import Path
from queue import Empty, SimpleQueue
from tempfile import TemporaryDirectory
from typing import Any
from uuid import uuid4

import dask
from distributed import Client, Event, Future, KilledWorker, LocalCluster, Security
from distributed.comm.core import FatalCommClosedError
from distributed.utils import json_load_robust, silence_logging_cmgr

from ertel.case.records import ConfigError
from ertel.runs.on_workers import SETTINGS, Start, performed
from ertel.runs.workers import READY, Asked, Failure, Hear, Job, cores, deaf, never
from ertel.version import own_sources

Inbox = SimpleQueue[tuple[str, Any]]  # of keys with news, or with None when the job is done
RETRIES = 2  # of a job that raised an error of the system, on this worker or another one
LOOK = 0.2  # s between looks for a wish to stop, here
ANSWER = 20  # s in which a scheduler must answer
PATIENCE = 10  # s without any worker, after which this is said
RUNNING = "running"  # the status of a client that has its scheduler
LOST = Failure("the scheduler was lost")
LOCAL: dict[str, Any] = {
    "distributed.scheduler.worker-ttl": None,  # compiled code may keep a worker from a sign of life for long
    "distributed.worker.multiprocessing-method": "spawn",  # JAX fears forks
    "distributed.scheduler.http.routes": [],  # its pages take no key, and show jobs and logs to everybody
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
        yield stack.enter_context(_connected(cluster.scheduler_address, Start(deaf=True), security))


@contextmanager
def _private_directory() -> Iterator[str]:
    """A directory of this user alone.  dask has modules imported from its directories, by default in /tmp."""
    with TemporaryDirectory(prefix="ertel-", ignore_cleanup_errors=True) as directory:
        try:
            yield directory
        finally:  # dask forgets some, and another user may take the name when it is free
            sys.path[:] = [place for place in sys.path if not place.startswith(directory)]


@contextmanager
def existing(address: str | None = None, file: Path | None = None, tls: Path | None = None) -> Iterator["Cluster"]:
    """The workers of a scheduler that runs, by its address or the file that it wrote; they stay.

    They need this version of ertel, and the directories of the jobs under the same names.  tls: a PEM file with a
    certificate, its key and the certificate of the authority, for a scheduler at tls://; None: dask's configuration.
    Raises NoScheduler.
    """
    where = f"scheduler = {address}" if address else f"scheduler_file = {file}"
    security = _keys(tls) if tls else None
    found = address or _address_in(file or Path())
    if tls and "://" not in found:
        found = f"tls://{found}"
    _check_encryption(where, found, security)
    with ExitStack() as stack:
        try:
            cluster = stack.enter_context(_connected(found, Start(), security))
        except FatalCommClosedError as error:
            raise NoScheduler(f"{where}: the scheduler has another authority for its certificates") from error
        except (OSError, ValueError) as error:
            raise NoScheduler(
                f"{where}: no scheduler answers there within {ANSWER} s; see to it that it runs"
            ) from error
        yield cluster


def _keys(tls: Path) -> Security:
    """The keys in a PEM file.  Raises NoScheduler."""
    file = str(tls)
    security = Security(require_encryption=True, tls_ca_file=file, tls_client_cert=file, tls_client_key=file)
    try:
        security.get_connection_args("client")
    except OSError as error:  # also of OpenSSL
        raise NoScheduler(
            f"tls = {tls}: must be a PEM file with a certificate, its key and the certificate of the authority"
        ) from error
    return security


def _check_encryption(where: str, address: str, given: Security | None) -> None:
    """Raise NoScheduler unless there are keys for an address that needs them, and the other way round."""
    security = given or Security()  # of dask's configuration
    if address.startswith("tls://"):
        keys = security.get_tls_config_for_role("client")
        if not keys["cert"] and not dask.config.get("distributed.client.security-loader"):
            raise NoScheduler(f"{where}: {address} needs certificates; give tls, a PEM file")
    elif security.require_encryption:
        raise NoScheduler(f"{where}: {address} is not encrypted; with tls it must be tls://HOST:PORT")


def _address_in(file: Path) -> str:
    """The address in the file of a scheduler, which may start just before.  Raises NoScheduler."""
    try:
        return str(json_load_robust(file, timeout=ANSWER)["address"])
    except (OSError, LookupError, TypeError) as error:
        what = "is not JSON with an address" if file.exists() else "no such file"
        raise NoScheduler(f"scheduler_file = {file}: {what}; give the one that the scheduler wrote") from error


@contextmanager
def _connected(address: str, start: Start, security: Security | None) -> Iterator["Cluster"]:
    quiet = silence_logging_cmgr(logging.CRITICAL)
    with quiet, Client(address, timeout=ANSWER, set_as_default=False, security=security) as client:
        name = f"ertel-{uuid4().hex[:8]}"
        client.register_plugin(start, name=name)
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

    def outcomes(self, jobs: Sequence[Job], hear: Hear = deaf, asked: Asked = never) -> Iterator[tuple[str, Any]]:
        """See `Workers`.  Of jobs that need the same programs one goes ahead, so that not all compile the same.

        Warns where no worker comes; jobs that none has when all are told to stop have no outcome.
        """
        topic, inbox = f"ertel-{uuid4().hex}", Inbox()
        stop = Event(topic, client=self._client)
        line, left, patience = _Line(jobs), {job.key for job in jobs}, _Patience(self._has_workers)
        futures: dict[str, Future[Any]] = {}
        self._client.subscribe_topic(topic, lambda event: inbox.put((*event[1],)))
        try:
            while left and not self._is_lost:
                for job in line.ready():
                    futures[job.key] = self._submit(job, topic, inbox)
                if asked():
                    with suppress(OSError):  # the scheduler is lost, see above
                        stop.set()
                        if not self._has_workers():
                            return
                try:
                    key, news = inbox.get(timeout=LOOK)
                except Empty:
                    patience.look()
                    continue
                if news is None:
                    left.remove(key)
                    line.release(key)
                    yield key, self._outcome(futures.pop(key))
                elif key in left:
                    hear(key, news)
                    if news.get(READY):
                        line.release(key)
            yield from ((key, LOST) for key in left)
        finally:
            if not self._is_lost:
                self._client.unsubscribe_topic(topic)
                self._client.cancel(list(futures.values()))

    def _outcome(self, future: Future[Any]) -> Any:
        try:
            return future.result()
        except KilledWorker:
            return Failure("its process was killed again and again, perhaps for want of memory")
        except Exception as error:
            return LOST if self._is_lost else Failure.of(error)

    @property
    def _is_lost(self) -> bool:
        return self._client.status != RUNNING

    def _has_workers(self) -> bool:
        with suppress(OSError):  # the scheduler is lost, see above
            return bool(self._client.nthreads())
        return True

    def _submit(self, job: Job, topic: str, inbox: Inbox) -> Future[Any]:
        content = job.function, job.arguments, job.key, topic, own_sources()
        key = f"{topic}-{job.key}"  # of this call only: another study on the same scheduler may hold the same case
        future = self._client.submit(performed, *content, key=key, retries=RETRIES, pure=False)
        future.add_done_callback(lambda _: inbox.put((job.key, None)))
        return future


class _Patience:
    """Warns once when there was no worker for some seconds."""

    def __init__(self, has_workers: Callable[[], bool]):
        self._has_workers, self._next = has_workers, time.monotonic() + PATIENCE

    def look(self) -> None:
        """Look whether there are workers, at intervals, until this was said."""
        if time.monotonic() < self._next:
            return
        alone = not self._has_workers()
        self._next = inf if alone else time.monotonic() + PATIENCE
        if alone:
            warnings.warn("the scheduler has no workers: the runs wait until some come", RuntimeWarning, stacklevel=2)


class _Line:
    """Jobs in their order, of which those that need the same programs wait for the first of them."""

    def __init__(self, jobs: Sequence[Job]):
        self._program = {job.key: job.program for job in jobs}
        self._behind: dict[str, list[Job]] = {}
        self._ready: list[Job] = []
        for job in jobs:
            if job.program in self._behind:
                self._behind[job.program].append(job)
            else:
                self._ready.append(job)
                if job.program:
                    self._behind[job.program] = []

    def ready(self) -> list[Job]:
        """The jobs that may begin now, each once."""
        found, self._ready = self._ready, []
        return found

    def release(self, key: str) -> None:
        """Let all go on that wait for a job."""
        self._ready += self._behind.get(self._program[key], [])
        self._behind[self._program[key]] = []
