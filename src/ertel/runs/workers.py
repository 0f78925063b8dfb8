"""Independent jobs, and who does them: this process one after the other, or the processes of a cluster.

    for key, outcome in Here().outcomes([Job("a", function, (1, 2))]):
        ...

A job is a function with plain arguments.  Its first argument is a `Wire`, by which it tells news and hears a wish to
stop.  A job that raises has a `Failure` as its outcome: the others go on.
"""

import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol

News = Mapping[str, Any]  # what a job tells while it is done, as plain data
Hear = Callable[[str, News], object]  # takes the key of a job and its news
Asked = Callable[[], bool]  # whether all should stop
READY = "ready"  # a key of news: the programs of the job are compiled


class Wire(Protocol):
    """What connects a job to those who wait for it."""

    def tell(self, news: News) -> None:
        """Tell news; they may be lost."""
        ...

    def stopped(self) -> bool:
        """Whether the job should end as soon as it can, and so that it can be continued."""
        ...


class Job(NamedTuple):
    """One job: function(wire, *arguments).

    key: differs from that of every other job.  program: jobs of the same one need the same compiled programs; "" for
    one that shares none.
    """

    key: str
    function: Callable[..., Any]
    arguments: tuple[Any, ...] = ()
    program: str = ""


@dataclass(frozen=True)
class Failure:
    """A job that raised an exception, and its message."""

    reason: str

    @classmethod
    def of(cls, error: BaseException) -> "Failure":
        """The failure that an exception is."""
        return cls(f"{type(error).__name__}: {error}")


class Workers(Protocol):
    """Those who do jobs."""

    def outcomes(self, jobs: Sequence[Job], hear: Hear, asked: Asked) -> Iterator[tuple[str, Any]]:
        """Do all jobs: key and outcome of each as soon as it is there, in any order.

        hear: sees the news of the jobs.  asked: is asked again and again; after true the jobs are told to stop.
        """
        ...


def deaf(key: str, news: News) -> None:
    """Hears nothing."""


def never() -> bool:
    """Asks for no stop."""
    return False


class Here:
    """This process: one job after the other, each with all cores."""

    def outcomes(self, jobs: Sequence[Job], hear: Hear = deaf, asked: Asked = never) -> Iterator[tuple[str, Any]]:
        """See `Workers`."""
        for job in jobs:
            yield job.key, _attempted(job, _Direct(job.key, hear, asked))


class _Direct(NamedTuple):
    """A `Wire` inside of one process."""

    key: str
    hear: Hear
    asked: Asked

    def tell(self, news: News) -> None:
        self.hear(self.key, news)

    def stopped(self) -> bool:
        return self.asked()


def _attempted(job: Job, wire: Wire) -> Any:
    try:
        return job.function(wire, *job.arguments)
    except Exception as error:
        return Failure.of(error)


def cores() -> int:
    """The number of cores that this process may use."""
    if hasattr(os, "sched_getaffinity"):  # not on macOS and Windows
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1
