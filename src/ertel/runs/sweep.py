"""Parameter studies: the runs of a case in which several values stand for one.

ertel.sweep("speeds.toml", "sweeps/speeds", jobs=2)
"""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from numbers import Integral
from pathlib import Path
from typing import Any

from ertel.case.records import show
from ertel.inputs.messages import ConfigError
from ertel.inputs.studies import load_study, parse_study
from ertel.results.study_result import StudyResult
from ertel.runs.compile import check_jax
from ertel.runs.drive import bars
from ertel.runs.studies import alone, gather, left_of, run_study, write
from ertel.runs.workers import Here, News, Workers, cores


@dataclass(frozen=True)
class Engine:
    """Who does the runs.

    jobs: processes of this machine, None for one for each core; 1 is this process.  scheduler, scheduler_file: the
    address of a scheduler that runs, or the file that it wrote; its workers do them.  tls: for a scheduler at tls://,
    a PEM file with a certificate, its key and the certificate of the authority.
    """

    jobs: int | None = None
    scheduler: str | None = None
    scheduler_file: Path | None = None
    tls: Path | None = None

    def __post_init__(self) -> None:
        if self.scheduler and self.scheduler_file:
            raise ConfigError(f"scheduler = {show(self.scheduler)}: give it, or scheduler_file, not both")
        if self.tls and not (self.scheduler or self.scheduler_file):
            raise ConfigError(f"tls = {self.tls}: only with scheduler or scheduler_file; local processes have own keys")
        if self.jobs is not None and not (isinstance(self.jobs, Integral) and self.jobs >= 1):
            raise ConfigError(f"jobs = {show(self.jobs)}: must be one or more, a whole number")

    @property
    def processes(self) -> int:
        """The number of processes of this machine."""
        return self.jobs or cores()

    @contextmanager
    def workers(self, runs: int) -> Iterator[Workers]:
        """Those who do so many runs: no more processes than these.  Raises NoScheduler."""
        elsewhere = self.scheduler or self.scheduler_file
        jobs = min(self.processes, runs)
        if runs == 0 or (jobs == 1 and not elsewhere):
            yield Here()
            return
        from ertel.runs import cluster  # imports dask

        there = self.scheduler, self.scheduler_file, self.tls
        with cluster.existing(*there) if elsewhere else cluster.local(jobs) as found:
            yield found


def sweep(
    study: str | Path | Mapping[str, Any],
    directory: str | Path,
    *,
    overrides: Sequence[str] = (),
    jobs: int | None = 1,
    scheduler: str | None = None,
    scheduler_file: str | Path | None = None,
    tls: str | Path | None = None,
    progress: bool = False,
) -> StudyResult:
    """Run all cases of a parameter study that are not there yet, and gather their numbers.

    Parameters
    ----------
    study : str, Path or mapping
        A case file, or plain data of the same layout, in which a list or { from, to, number, spacing } may stand for
        any value; [sweep] mode is "product" or "zip".  See `ertel.inputs.studies`.
    directory : str or Path
        Of the study: made if it is not there.  Its runs are ordinary run directories, runs/DIGEST of the case.  What
        is missing or unfinished is done, and nothing else is remembered.
    overrides : sequence of str
        Values of the case, "contact.M=[100, 200]".
    jobs : int
        Number of processes on this machine, with one thread each; None: one for each core.  1: this process, with all
        cores.  A script that asks for more must begin its work below `if __name__ == "__main__":`, because they
        import it.
    scheduler, scheduler_file : str or Path
        Address of a scheduler of dask.distributed that runs, or the file that it wrote: its workers do the runs.
        Whoever reaches the scheduler can run programs as you.
    tls : str or Path
        For a scheduler at tls://: a PEM file with a certificate, its key and the certificate of the authority.  Without
        it the configuration of dask holds.
    progress : bool
        Whether to show a progress bar.

    Returns
    -------
    StudyResult
        It shows itself as a table; `dataset`, `plot()`, `to_csv(path)`.  They are also in the directory.  A run that
        failed is a row with its reason.

    Raises ConfigError, naming the field, its value and what is allowed; StoreError where another process is at it.
    """
    check_jax()
    file, keys = (None if path is None else Path(path) for path in (scheduler_file, tls))
    engine = Engine(jobs, scheduler, file, keys)
    found = parse_study(study) if isinstance(study, Mapping) else load_study(study, overrides)
    place = Path(directory).absolute()
    left = len(left_of(found, place))
    with engine.workers(left) as workers, alone(place), bars(progress) as shown:
        watched = Watched(shown, left)
        said = run_study(found, place, workers, hear=watched.hear, on_done=watched.done)
        result = gather(found, place, said)
        write(result, place)
    return result


class Watched:
    """A bar for all runs, and one for each that is computed now."""

    def __init__(self, progress: Any, runs: int):
        self._progress = progress
        self._all = progress.add_task("runs", total=runs, news="")
        self._bars: dict[str, Any] = {}

    def hear(self, key: str, news: News) -> None:
        """Show the news of a run."""
        if key not in self._bars:
            self._bars[key] = self._progress.add_task(key[:8], total=1.0, news="")
        self._progress.update(self._bars[key], completed=news["done"], news=news["text"])

    def done(self, key: str, status: str) -> None:
        """Count a run that is done."""
        self._progress.update(self._all, advance=1, news=f"{key[:8]} {status}"[:60])
        if key in self._bars:
            self._progress.remove_task(self._bars.pop(key))
