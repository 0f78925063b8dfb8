"""The processes that do the runs of a study: this one, others of this machine, or the workers of a scheduler.

with Engine(jobs=2).workers(len(tasks)) as workers:
    for name, outcome in workers.outcomes(tasks):
        ...
"""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from numbers import Integral

from ertel.case.records import ConfigError, show
from ertel.runs.workers import LocalWorker, Workers, cores


@dataclass(frozen=True)
class Engine:
    """The processes that do the runs.

    Parameters
    ----------
    jobs : int, optional
        Processes of this machine, by default one for each core; 1 is this process.
    scheduler : str, optional
        The address of a running scheduler: its workers do the runs.

    Raises
    ------
    ConfigError
        jobs is not a positive whole number.
    """

    jobs: int | None = None
    scheduler: str | None = None

    def __post_init__(self) -> None:
        if self.jobs is not None and not (isinstance(self.jobs, Integral) and self.jobs >= 1):
            raise ConfigError(f"jobs = {show(self.jobs)}: must be one or more, a whole number")

    @property
    def processes(self) -> int:
        """The number of processes of this machine."""
        return self.jobs or cores()

    @contextmanager
    def workers(self, runs: int) -> Iterator[Workers]:
        """The workers for so many runs, and no more processes than these.  Raises NoScheduler."""
        jobs = min(self.processes, runs)
        if runs == 0 or (jobs == 1 and not self.scheduler):
            yield LocalWorker()
            return
        from ertel.runs import cluster  # imports dask

        with cluster.existing(self.scheduler) if self.scheduler else cluster.local(jobs) as workers:
            yield workers
