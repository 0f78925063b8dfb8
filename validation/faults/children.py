"""Commands of ertel in children by fork: with a fault, watched from outside, and judged by what they leave."""

import csv
import errno
import faulthandler
import hashlib
import io
import json
import os
import resource
import select
import signal
import sys
import tempfile
import time
import traceback
import warnings
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import xarray as xr

from ertel.__main__ import main
from ertel.runs.store import RunStore, open_run
from ertel.runs.studies import RUNS

KILLED = 137
IDLE, WORK = 120.0, 900.0  # s: a child that waits for anything but a processor so long, or works so long, hangs
GLANCE = 1.0  # s between two looks at a child
CHANGES = {"os.rename", "os.remove", "os.mkdir", "os.rmdir", "os.truncate", "os.link", "os.symlink"}
WRITING = os.O_WRONLY | os.O_RDWR | os.O_CREAT | os.O_TRUNC
OWN = {
    "wall_s",
    "wall_time",
    "wall_time_s",
    "compilations",
    "date_created",
}  # what differs between two runs of the same case

Act = Callable[[str, str, int], None]  # of event, path and flags


@dataclass
class Fault:
    """What happens from the n-th change of files inside a directory on; n = 0: nothing.

    act: is called before the n-th change, and also before each later one if it lasts.
    limit: bytes that no file may exceed (RLIMIT_FSIZE), 0 for none.
    """

    act: Act | None = None
    n: int = 0
    lasts: bool = False
    limit: int = 0


def die(event: str, path: str, flags: int) -> None:
    """End the process before the operation."""
    os._exit(KILLED)


def die_torn(event: str, path: str, flags: int) -> None:
    """End the process after a file was opened and emptied, before anything was written to it."""
    if event == "open" and flags & (os.O_TRUNC | os.O_EXCL) and not os.path.isdir(path):
        os.close(os.open(path, os.O_WRONLY | os.O_CREAT | (flags & (os.O_TRUNC | os.O_EXCL))))
    os._exit(KILLED)


def terminate(event: str, path: str, flags: int) -> None:
    """Ask the process to end, as a batch system does."""
    os.kill(os.getpid(), signal.SIGTERM)


def disk_full(event: str, path: str, flags: int) -> None:
    """Refuse to write or to make anything."""
    if event in ("open", "os.mkdir"):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), path)


@dataclass
class Ended:
    """How a command ended.  code: its exit code, negative for a signal; text: what it printed; said: on stderr.

    operations: changes of files.  flushed: steps or grids in the last complete flush of each run directory.  resumed:
    those from which a resume went on.
    found: the `fingerprint` of what it left, if asked for.
    """

    code: int = 0
    text: str = ""
    said: str = ""
    operations: int = 0
    flushed: dict[str, int] = field(default_factory=dict)
    resumed: dict[str, int] = field(default_factory=dict)
    found: dict[str, str] = field(default_factory=dict)
    failure: str = ""

    @property
    def traceback(self) -> bool:
        """Whether it ended with a traceback, shown or written to a file."""
        return "Traceback (most recent call last)" in self.said or "internal error" in self.said

    @property
    def one_sentence(self) -> bool:
        """Whether stderr has exactly one message of ertel."""
        lines = [line for line in self.said.splitlines() if line.strip()]
        return len(lines) == 1 and lines[0].startswith("ertel: ")


def command(
    arguments: Sequence[str],
    inside: Path,
    fault: Fault | None = None,
    judge: Path | None = None,
    killed_after: float = 0,
) -> Ended:
    """Run a command in a child.

    inside: the directory whose changes count.  judge: the run whose fingerprint is wanted afterwards.  killed_after:
    seconds after which the child is killed, 0 for never.
    """
    return in_child(lambda tell: run_watched(tell, arguments, inside, fault or Fault(), judge), killed_after)[0]


def in_child(work: Callable[[Callable[..., None]], None], killed_after: float = 0) -> list[Ended]:
    """Do some work in a child by fork: what it told about its commands, at least about one."""
    read, write = os.pipe()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # JAX warns of forks: the children let it do nothing that needs its threads
        pid = os.fork()
    if not pid:
        os.close(read)
        _work_and_exit(work, write)
    os.close(write)
    told = _collect(read, pid, killed_after)
    return told


def _work_and_exit(work: Callable[[Callable[..., None]], None], write: int) -> None:
    def tell(**what: Any) -> None:
        os.write(write, json.dumps(what).encode() + b"\n")

    faulthandler.register(signal.SIGUSR1, sys.__stderr__ or 2)
    code = 0
    try:
        work(tell)
    except BaseException as error:
        tell(failure="".join(traceback.format_exception(error)))
        code = 70
    finally:
        os._exit(code)


def _collect(read: int, pid: int, killed_after: float) -> list[Ended]:
    """Read what a child tells until it ends; kill it when it is time, or where it hangs."""
    text, end, hung, patience = b"", time.monotonic() + killed_after, False, Patience(pid)
    while True:
        wait = max(end - time.monotonic(), 0.0) if killed_after else GLANCE
        if select.select([read], [], [], wait)[0]:
            if not (part := os.read(read, 1 << 20)):
                break
            text += part
        elif killed_after or patience.is_over():
            hung = not killed_after
            if hung:
                os.kill(pid, signal.SIGUSR1)  # it prints where its threads wait
                time.sleep(GLANCE)
            os.kill(pid, signal.SIGKILL)
            killed_after = 0.0
    os.close(read)
    code = os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1])
    ended = _told(text.decode())
    if code:
        ended[-1].code = code
    ended[-1].failure += f"hung: {patience.words}" if hung else ""
    return ended


class Patience:
    """Time that a process has used, so that one that hangs is told from one that a busy machine keeps waiting.

    Linux counts what each thread has run and what it has waited for a processor (/proc/PID/task/*/schedstat).  The rest
    of the time it was idle: it waited for a lock, a pipe, another process or the disk.
    """

    def __init__(self, pid: int):
        self.pid, self.looked, self.wanted, self.ran, self.idle = pid, time.monotonic(), 0.0, 0.0, 0.0

    def is_over(self) -> bool:
        """Look at the process: whether it has been idle or at work for too long."""
        now, (ran, waited) = time.monotonic(), _times(self.pid)
        passed, wanted = now - self.looked, ran + waited - self.wanted
        self.idle = 0.0 if wanted > passed / 10 else self.idle + passed
        self.looked, self.wanted, self.ran = now, ran + waited, ran
        return self.idle > IDLE or self.ran > WORK

    @property
    def words(self) -> str:
        """Why it is over."""
        return f"idle for {self.idle:.0f} s, {self.ran:.1f} s of a processor"


def _times(pid: int) -> tuple[float, float]:
    """Seconds that the threads of a process have run, and that they have waited for a processor."""
    ran = waited = 0.0
    for task in Path(f"/proc/{pid}/task").glob("*/schedstat"):
        with suppress(OSError):  # a thread that has just ended
            numbers = task.read_text().split()
            ran, waited = ran + 1e-9 * int(numbers[0]), waited + 1e-9 * int(numbers[1])
    return ran, waited


def _told(text: str) -> list[Ended]:
    """What a child told: a new entry after each command that ended."""
    ended = [Ended()]
    for line in text.splitlines():
        what = json.loads(line)
        for key, value in what.items():
            known = getattr(ended[-1], key)
            setattr(ended[-1], key, {**known, **value} if isinstance(value, dict) else value)
        if "text" in what:
            ended.append(Ended())
    return ended[:-1] if len(ended) > 1 else ended


# -- inside the child -------------------------------------------------------------------------------------------------


def run_watched(
    tell: Callable[..., None], arguments: Sequence[str], inside: Path, fault: Fault, judge: Path | None = None
) -> None:
    """Run a command with a fault and tell how it ended."""
    _tell_of_flushes(tell)
    changes = _watch(inside, fault)
    if fault.limit:
        resource.setrlimit(resource.RLIMIT_FSIZE, (fault.limit, resource.RLIM_INFINITY))
    code, text, said = called(arguments)
    found = {**fingerprint(judge), **gathered(judge)} if judge and code == 0 else {}
    tell(operations=changes[0], found=found)
    tell(code=code, said=said, text=text)


def _tell_of_flushes(tell: Callable[..., None]) -> None:
    flush, resume = RunStore.flush, RunStore.resume

    def told_flush(self: RunStore) -> None:
        item = self._item
        flush(self)
        if item is not None:
            tell(flushed={self.directory.name: _progress(item)})

    def told_resume(self: RunStore) -> Any:
        item = resume(self)
        tell(resumed={self.directory.name: 0 if item is None else _progress(item)})
        return item

    RunStore.flush, RunStore.resume = told_flush, told_resume  # type: ignore[method-assign]


def _progress(item: Any) -> int:
    """Steps or grids."""
    return len(item.solutions) if hasattr(item, "solutions") else int(item.state.counts.steps)


def _watch(inside: Path, fault: Fault) -> list[int]:
    """Count the changes of files inside a directory, and act when it is time."""
    seen, root, busy = [0], f"{inside}/", [False]

    def hook(event: str, arguments: tuple[Any, ...]) -> None:
        if busy[0] or not (event in CHANGES or event == "open"):
            return
        path, flags = str(arguments[0]), int(arguments[2] or 0) if event == "open" else 0
        if event == "open" and not flags & WRITING:
            return
        if not os.path.isabs(path):
            path = os.path.join(_folder_of(event, arguments), path)
        if not path.startswith(root):
            return
        seen[0] += 1
        if fault.act and (seen[0] == fault.n or (fault.lasts and seen[0] > fault.n)):
            busy[0] = True
            try:
                fault.act(event, path, flags)
            finally:
                busy[0] = False

    sys.addaudithook(hook)
    return seen


def _folder_of(event: str, arguments: tuple[Any, ...]) -> str:
    """The directory of a relative path: that of its dir_fd, or the present one."""
    number = {"os.remove": 1, "os.rmdir": 1, "os.mkdir": 2, "os.rename": 2}.get(event)
    fd = arguments[number] if number else -1
    return os.readlink(f"/proc/self/fd/{fd}") if isinstance(fd, int) and fd >= 0 else os.getcwd()


def called(arguments: Sequence[str]) -> tuple[int, str, str]:
    """Exit code, standard output and standard error of a command in this process."""
    sys.argv, code = ["ertel", *arguments], 0
    with _caught() as out, _caught() as err:
        before, sys.stdout, sys.stderr = (sys.stdout, sys.stderr), out, err
        try:
            main()
        except SystemExit as end:
            code = end.code if isinstance(end.code, int) else 0 if end.code is None else 1
        except BaseException:
            traceback.print_exc()
            code = 1
        finally:
            sys.stdout, sys.stderr = before
        return code, _content(out), _content(err)


def _caught() -> Any:
    return tempfile.TemporaryFile("w+", encoding="utf-8")


def _content(file: io.TextIOWrapper) -> str:
    file.flush()
    file.seek(0)
    return file.read()


def fingerprint(directory: Path) -> dict[str, str]:
    """A digest of each variable, of all attributes and of the summary of a run, without what is never the same.

    Of a study: those of all its runs.
    """
    if (directory / RUNS).exists():
        every = {run.name: fingerprint(run) for run in sorted((directory / RUNS).iterdir()) if run.name[0] != "."}
        return {f"{run}, {name}": digest for run, found in every.items() for name, digest in found.items()}
    result = open_run(directory)
    return {**_digests(result.dataset), "summary": _digest(_text(plain(result.summary)))}


def gathered(directory: Path) -> dict[str, str]:
    """A digest of what a study wrote of all its runs, which is written again when it goes on; nothing of a run."""
    if not (directory / RUNS).exists():
        return {}
    name = next(directory.glob("[!.]*.zarr")).stem
    with xr.open_zarr(directory / f"{name}.zarr", chunks=None, consolidated=False) as data:
        numbers = data.drop_vars(OWN, errors="ignore").load()
    table = csv.DictReader((directory / f"{name}.csv").open())
    rows = sorted(key for row in table for key in row.items() if key[0] not in OWN)
    return {**_digests(numbers), "table": _digest(_text(rows)), "picture": str((directory / f"{name}.png").exists())}


def _digests(data: xr.Dataset) -> dict[str, str]:
    parts = {str(name): _bytes(variable.values) for name, variable in data.variables.items()}
    parts |= {f"{name} is": f"{v.dtype}{v.shape}{v.dims}{v.attrs}".encode() for name, v in data.variables.items()}
    parts["attributes"] = _text({k: v for k, v in data.attrs.items() if k not in OWN})
    return {name: _digest(part) for name, part in parts.items()}


def _bytes(values: Any) -> bytes:
    return _text(values.tolist()) if values.dtype.kind == "O" else bytes(values.tobytes())


def _digest(part: bytes) -> str:
    return hashlib.sha256(part).hexdigest()[:16]


def _text(content: Any) -> bytes:
    return json.dumps(content, sort_keys=True, default=str).encode()


def plain(content: Any) -> Any:
    """A summary without what is never the same."""
    if isinstance(content, dict):
        return {key: plain(value) for key, value in content.items() if key not in OWN}
    return [plain(each) for each in content] if isinstance(content, list | tuple) else content
