"""A scheduler and two worker processes on this machine: what they get, and what becomes of tasks whose worker dies."""

import itertools
import json
import os
import signal
import stat
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

import dask
import psutil
import pytest
from distributed import Security

from ertel.inputs.studies import parse_study
from ertel.runs import cluster, studies
from ertel.runs.cluster import Cluster, NoScheduler
from ertel.runs.directory import read_progress
from ertel.runs.drive import simulate
from ertel.runs.studies import gather, run_directory, run_study
from ertel.runs.workers import Failure, LocalWorker, StopSignal, Task, Workers

HANG = 120  # s: what lives longer is taken for something that never ends
TLS = "ca-file", "client.cert", "client.key"  # of dask's configuration


@pytest.fixture(scope="module")
def two() -> Iterator[Cluster]:
    with cluster.local(2) as workers:
        yield workers


@pytest.fixture(params=["here", "two"])
def workers(request: pytest.FixtureRequest) -> Workers:
    return LocalWorker() if request.param == "here" else request.getfixturevalue("two")


def square(x: float) -> float:
    return x**2


def fails() -> None:
    raise RuntimeError("no film")


def stumbles(log: Path) -> str:
    with log.open("a") as file:
        file.write("!")
    if len(log.read_text()) < 3:
        raise OSError(28, "No space left on device")
    return "done"


def wait_until(there: Callable[[], object]) -> None:
    deadline = time.monotonic() + HANG
    while not there():
        assert time.monotonic() < deadline
        time.sleep(0.05)


def until_stopped(begun: Path, stop: StopSignal) -> str:
    begun.touch()
    wait_until(stop)
    return "stopped"


class Waiting:
    """No wish to stop, in a worker: asked after the third step, it waits until a worker was killed."""

    def __init__(self, directory: Path):
        self.directory, self.asked = directory, itertools.count()

    def __call__(self) -> bool:
        if next(self.asked) == 3:  # asked once before the first step
            (self.directory / f"{os.getpid()} waits").touch()
            wait_until((self.directory / "killed").exists)
        return False


class WaitingSignal(StopSignal):
    """A signal in the directory of a study, whose copies are of the kind above."""

    def __reduce__(self) -> tuple[Any, ...]:
        return Waiting, (self._file.parent,)


def test_every_job_has_its_outcome_and_a_failure_is_a_value(workers):
    tasks = [*(Task(str(x), square, (x,)) for x in (1.0, 2.0, 3.0)), Task("bad", fails)]
    found = dict(workers.outcomes(tasks))
    assert found == {"1.0": 1.0, "2.0": 4.0, "3.0": 9.0, "bad": Failure("RuntimeError: no film")}


def test_a_wish_to_stop_reaches_every_task(workers, tmp_path):
    """Also those that have not begun."""
    stop = StopSignal(tmp_path / "stop", lambda: bool(list(tmp_path.glob("begun*"))))
    tasks = [Task(str(n), until_stopped, (tmp_path / f"begun {n}", stop)) for n in range(4)]
    found = dict(workers.outcomes(tasks, stop))
    assert found == {str(n): "stopped" for n in range(4)}


def test_an_error_of_the_system_is_tried_again_and_others_need_not_wait(two, tmp_path):
    assert dict(two.outcomes([Task("a", stumbles, (tmp_path / "log",))])) == {"a": "done"}


def test_a_study_whose_worker_is_killed_loses_nothing(two, tmp_path, monkeypatch):
    """Signal 9 while a run is computed: another worker continues it, and the numbers are those without the signal.

    The other runs go on, and so does the cluster.
    """
    impacts = {"contact": {"M": [20, 40], "L": 5}, "solver": {"method": "radial", "nodes": 17}}
    study = parse_study({**impacts, "time": {"until": 1.0, "tolerance": 0.01}})
    killed: list[str] = []

    def kill_once() -> bool:
        for case in study.cases if not killed else ():
            said = read_progress(run_directory(tmp_path, case))
            if said and said["status"] == "running" and (tmp_path / f"{said['process']} waits").exists() and not killed:
                killed.append(case.digest)
                os.kill(said["process"], signal.SIGKILL)
                (tmp_path / "killed").touch()
        return False

    monkeypatch.setattr(studies, "StopSignal", WaitingSignal)
    said = run_study(study.cases, tmp_path, two, asked=kill_once)
    assert len(killed) == 1 and said == {case.digest: "converged" for case in study.cases}
    found = gather(study, tmp_path).dataset["H_min_extreme"]
    which = [case.digest for case in study.cases].index(killed[0])
    alone = simulate(study.cases[which]).summary["extremes"]["H_min"]["value"]
    assert found.values[which] == pytest.approx(alone, rel=1e-6)
    assert dict(two.outcomes([Task("after", square, (3.0,))])) == {"after": 9.0}


def test_a_scheduler_with_certificates_needs_those_of_the_configuration(two, tmp_path, monkeypatch, capfd):
    address, nobody = two._client.scheduler.address, "tcp://127.0.0.1:9"

    def certificates(name: str, of: Security | None = None) -> dict[str, str]:
        """A certificate and its key in a file, as dask's configuration names them."""
        if of:
            (tmp_path / name).write_text(of.tls_client_cert + of.tls_client_key)
        return dict.fromkeys([f"distributed.comm.tls.{key}" for key in TLS], str(tmp_path / name))

    with dask.config.set(certificates("ours", two._client.security)), cluster.existing(address) as workers:
        assert dict(workers.outcomes([Task("a", square, (2.0,))])) == {"a": 4.0}
    other = certificates("other", Security.temporary())
    for where, settings, said in (
        (nobody, {}, "no scheduler answers"),
        (address, {}, "needs certificates; name them in distributed.comm.tls in dask's configuration"),
        (address, other, "another authority for its certificates"),
        (address, certificates("nowhere"), "cannot be read"),
        (nobody, {**other, "distributed.comm.require-encryption": True}, "must be tls://"),
    ):
        monkeypatch.setattr(cluster, "ANSWER", 0.2 if where == nobody else HANG)
        refusal = pytest.raises(NoScheduler, match=f"^scheduler = {where}: .*{said}")
        with refusal, dask.config.set(settings), cluster.existing(where):
            pass
    assert capfd.readouterr() == ("", "")


@pytest.fixture
def scheduler(tmp_path) -> Iterator[tuple[subprocess.Popen[bytes], str]]:
    """A scheduler in a process of its own, without workers, and its address."""
    file = tmp_path / "scheduler.json"
    where = ["--host", "127.0.0.1", "--port", "0", "--no-dashboard", "--no-show", "--scheduler-file", str(file)]
    command = [sys.executable, "-m", "distributed.cli.dask_scheduler", *where]
    with subprocess.Popen(command, stderr=subprocess.DEVNULL) as process:
        wait_until(lambda: file.exists() and file.read_text().endswith("}"))
        yield process, json.loads(file.read_text())["address"]
        process.kill()


def test_workers_that_never_come_are_missed_and_a_scheduler_that_is_lost_fails_its_tasks(scheduler, monkeypatch, capfd):
    """A wish to stop ends the waiting for workers; nothing waits for ever, and nothing is said twice.

    The scheduler has no keys: it takes anybody's tasks, and with keys of ours we do not talk to it.
    """
    process, address = scheduler
    tasks, said = [Task(name, max, (1, 2)) for name in "abc"], []
    with cluster.existing(address) as workers:
        with monkeypatch.context() as patch:
            patch.setattr(cluster, "PATIENCE", 0)
            patch.setattr(cluster.warnings, "warn", lambda text, *_, **__: said.append(text))
            assert not workers._has_workers()
            assert dict(workers.outcomes(tasks, lambda: bool(said))) == {}
        assert said == ["the scheduler has no workers: the runs wait until some come"]
        asked = iter([False, False, False])  # then the scheduler is killed; nobody does the tasks
        found = dict(workers.outcomes(tasks, lambda: next(asked, None) is None and process.kill() is None))
    assert found == dict.fromkeys("abc", Failure("the scheduler was lost"))
    assert capfd.readouterr() == ("", "")


INTRUDER = """
import asyncio, json, os, pickle, sys, urllib.request
from concurrent.futures import ThreadPoolExecutor
from http.client import HTTPException
from distributed import Security
from distributed.core import rpc

PAGES = "info/main/workers.html", "info/logs.html", "json/counts.json", "metrics", "health"

async def ask(scheme, port, operation, security):
    arguments = security.get_connection_args("client")
    async with rpc(f"{scheme}://127.0.0.1:{port}", connection_args=arguments, timeout=1) as there:
        wanted = pickle.dumps(os.getuid)
        reply = await asyncio.wait_for(getattr(there, operation)(function=wanted, args=pickle.dumps(()), wait=True), 1)
    return f"{operation} ran as {reply.get('result', reply)}" if reply["status"] == "OK" else str(reply)

def page(port, name):
    try:
        return "page of " + str(len(urllib.request.urlopen(f"http://127.0.0.1:{port}/{name}", timeout=1).read()))
    except (OSError, HTTPException):
        return None

async def attack(ports, own):
    ways = [("tcp", Security()), ("tls", own)]
    asked = [ask(way, p, o, keys) for p in ports for o in ("run", "run_function") for way, keys in ways]
    tried = await asyncio.gather(*asked, return_exceptions=True)
    return [repr(found) for found in tried if not isinstance(found, OSError)]

ports, own = [int(port) for port in sys.argv[1:]], Security.temporary()  # as good as any that were not stolen
with ThreadPoolExecutor(len(ports) * len(PAGES)) as threads:  # all at once: most wait for an answer that never comes
    pages = [found for found in threads.map(page, ports * len(PAGES), sorted(PAGES * len(ports))) if found]
if os.getuid() == 0:
    asyncio.run(attack(ports[:1], own))  # imports everything; another user may not see this Python
    os.setgroups([])
    os.setgid(65534)
    os.setuid(65534)
print(json.dumps(asyncio.run(attack(ports, own)) + pages))
"""


@pytest.mark.skipif(sys.platform != "linux", reason="the sockets of other processes are not listed")
def test_nobody_without_the_keys_gets_in(two, capfd):
    """Another user of the machine, where this one may become another; with plain sockets and with keys of its own."""
    here = psutil.Process()
    processes = [here, *here.children(recursive=True)]
    sockets = [each for process in processes for each in process.net_connections(kind="inet")]
    listening = [each.laddr for each in sockets if each.status == psutil.CONN_LISTEN]
    assert len(listening) >= 2 + 2 * 2  # of the scheduler and its pages; of each worker also its nanny
    assert {each.ip for each in listening} == {"127.0.0.1"}
    command = [sys.executable, "-c", INTRUDER, *(str(each.port) for each in listening)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=HANG, check=True, cwd="/")
    assert json.loads(done.stdout) == []
    assert capfd.readouterr() == ("", "")
    assert dict(two.outcomes([Task("after", square, (3.0,))])) == {"after": 9.0}


def imported_from() -> list[str]:
    return [place for place in sys.path if "dask-scratch-space" in place]


def test_modules_come_from_no_directory_of_other_users(two, monkeypatch, recwarn):
    """By default dask imports from /tmp/dask-scratch-space, which anybody can make before."""
    places = [imported_from(), dict(two.outcomes([Task("a", imported_from)]))["a"]]
    assert all(places)
    for place in [place for each in places for place in each]:
        private = os.stat(place.partition("/dask-scratch-space")[0])
        assert (stat.S_IMODE(private.st_mode), private.st_uid) == (0o700, os.getuid())
    # Another user could take its name.  dask removes it only where it comes first.
    # This second cluster, without workers, says nothing: each would take the same port for its pages.
    before = set(sys.path)
    monkeypatch.setattr(cluster, "cores", lambda: 0)
    with cluster.local():
        monkeypatch.syspath_prepend("/somewhere")
    assert set(sys.path) == {*before, "/somewhere"}
    assert [str(warning.message) for warning in recwarn] == []


# A worker holds the other end of the standard output, which is therefore at its end only when the worker is.

KILLED = """
from ertel.runs.cluster import local
from ertel.runs.workers import Task
from test_cluster import never_ends
if __name__ == "__main__":
    with local(1) as workers:
        list(workers.outcomes([Task("long", never_ends)]))
"""


def never_ends() -> None:
    print("running", flush=True)
    while True:
        time.sleep(1)


@pytest.mark.slow
def test_workers_end_with_a_parent_that_is_killed(tmp_path):
    (tmp_path / "killed.py").write_text(KILLED)
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([str(Path(__file__).parent), *sys.path])}
    command, pipes = [sys.executable, str(tmp_path / "killed.py")], {"stdout": subprocess.PIPE, "text": True}
    with subprocess.Popen(command, **pipes, env=environment, start_new_session=True) as parent:
        assert parent.stdout and parent.stdout.readline() == "running\n"
        parent.send_signal(signal.SIGKILL)
        try:  # what is printed until parent and workers have ended
            assert parent.communicate(timeout=HANG)[0] == ""
        finally:
            with suppress(ProcessLookupError):
                os.killpg(parent.pid, signal.SIGKILL)
    assert parent.returncode == -signal.SIGKILL
