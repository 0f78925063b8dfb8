"""Fits: the numbers of a case, an oil or a load, that explain what was measured.

    measured = [ertel.Measurement.number("restitution", 0.87, sigma=0.01)]
    ertel.fit("ball.toml", measured, {"lubricant.eta0": ("5 mPa*s", "1 Pa*s")}, "fits/ball")

Least squares in the logarithms of the unknowns (`scipy.optimize.least_squares`).  A point of the search is one run, and
one more for each unknown, whose logarithm is then larger by `STEP`; these are independent of each other and go to the
workers of `studies` at once.  STEP: a derivative by a difference has an error of the curvature, half of STEP where the
number goes as a power of the unknown, and of the noise of the time steps over STEP: with 0.01, in impacts by the radial
method, 0.5 % and 0.03 % (contact times on 33 rings: 2 %), see `validation/fit/validate.py noise`.

Each run is a run directory, runs/DIGEST of its case, as in a study.  The search has no randomness: the same call takes
the same path, finds the runs that are done, and goes on where it was.  progress.json records the progress.
"""

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any, Literal

import numpy as np

from ertel.case.case import Case
from ertel.case.status import Status
from ertel.inputs.case_files import CaseLike
from ertel.inputs.fits import with_settings
from ertel.results.alignment import Comparison
from ertel.results.measurements import Measurement
from ertel.results.study_table import grouped
from ertel.results.summary import ORDERS
from ertel.runs import studies
from ertel.runs.compile import check_jax
from ertel.runs.directory import CASE, RUNS, read_progress, write_progress
from ertel.runs.drive import warn
from ertel.runs.engine import Engine
from ertel.runs.files import Damaged, StoreError
from ertel.runs.fit_problem import FitProblem, Given, fit_problem, under_the_law
from ertel.runs.fit_result import FitPoint, FitResult, Values, amount, fit_dataset, with_laws
from ertel.runs.result import Result
from ertel.runs.store import RunStore, prune
from ertel.runs.workers import Condition, Failure, Workers, never

NAME = "fit"  # of the files with the outcome
STEP = 0.01  # of a logarithm, for derivatives
FINE_STEP = 1e-3  # the same, where the standard errors are smaller than STEP
NEAR = 1e-3  # a step of the search that is smaller, in the logarithms, is the last one; with FINE_STEP less
FLAT = 0.01  # a change of chi square that does not matter
MOST_POINTS = 40  # of a search

Keep = Literal["best", "all"]
Runner = Callable[[Sequence[Case]], Sequence[Result | Failure]]


class FitError(RuntimeError):
    """A fit cannot begin or go on, because a run that it needs has failed or is damaged; or it was asked to stop."""


class StoppedFit(FitError):
    """A fit was asked to stop before it was done."""


def fit(
    case: CaseLike,
    measurements: Measurement | Sequence[Given],
    unknowns: Mapping[str, Any],
    directory: str | Path | None = None,
    *,
    laws: Sequence[str] = (),
    keep: Keep = "best",
    jobs: int | None = 1,
    scheduler: str | None = None,
    progress: bool = False,
) -> FitResult:
    """Find the numbers of a case that explain what was measured.

    Parameters
    ----------
    case : Case, str, Path or mapping
        The contact as far as it is known.  Its grid stays as it is.
    measurements : Measurement or sequence
        What was measured, each with its standard deviation.  One that was taken under other conditions is a pair of the
        measurement and their values by path: `(measurement, {"contact.speed": "0.2 m/s"})`.
    unknowns : mapping
        Paths of numbers above zero in the case, as --set names them ("lubricant.eta0", "contact.radius"), each with its
        bounds, `("5 mPa*s", "1 Pa*s")`, or with `{"bounds": ..., "prior": (value, sigma)}`.  The search starts at the
        prior, otherwise at the value of the case, otherwise between the bounds.
    directory : str or Path, optional
        Of the fit: a new or empty one, or that of an earlier fit, whose runs are used again as far as they are the
        same, so that a fit that was killed goes on.  Left out, no run is kept.
    keep : "best" or "all"
        The runs that stay in it when the fit is done: those with the values that were found, or all.
    laws : sequence of str, optional
        Two or more laws of viscosity, ("roelands", "barus"): a fit under each, and whether the data tell them apart.
        The result is that of the first one.
    jobs, scheduler
        Who does the runs, as in `sweep`.  A point of the search takes one run and one for each unknown, side by side;
        as many again for each further set of conditions.
    progress : bool
        Whether to show progress bars.

    Returns
    -------
    FitResult
        It shows itself as a table: values, standard errors, correlation, and which products of the unknowns the data
        fix.  The noise has the error of the grid in it, from runs on half the grid, and so have the standard errors.
        `case`, `values`, `standard_errors`, `dataset`, `plot()`, `to_csv(path)`.

    Raises
    ------
    ConfigError
        A path, bounds, a prior or a measurement is not allowed, or there are more unknowns than data; the message names
        it.
    FitError
        The run with the first values failed, the files of a run are damaged, or a file `stop` asked the fit to stop;
        the message names the run.
    StoreError
        Another process is working on the fit, or the directory holds other files.

    Warns
    -----
    UserWarning
        The data do not decide an unknown, one ends at its bound, or the case does not explain the data.
    """
    check_jax()
    engine = Engine(jobs, scheduler)
    problem = fit_problem(case, measurements, unknowns, laws)
    do = partial(store_fit, problem, engine=engine, progress=progress, keep=keep)
    result = studies.in_directory(directory, NAME, do)
    warn(result.warnings, frames=1)
    return result


# -- the search -------------------------------------------------------------------------------------------------------


class Search:
    """The least squares of a problem.

    runner: gives the results of cases in their order.  note: called before a point is computed.
    """

    def __init__(self, problem: FitProblem, runner: Runner, note: Callable[["Search"], object]):
        self.problem, self._runner, self._note = problem, runner, note
        self.columns = problem.columns()
        self.measured, self.sigma = self.columns["measured"][0], self.columns["sigma"][0]
        self.grid, self.grid_in_words = np.zeros_like(self.sigma), ""  # its error in each datum, part of the noise
        self.runs: set[str] = set()  # digests of their cases
        self.warnings: dict[str, Sequence[str]] = {}  # of the runs, by these digests
        self.compared: dict[str, dict[int, Comparison]] = {}  # aligned measurements, by the digest of the first case
        self._failures: list[str] = []
        self._step = STEP
        self.points: dict[bytes, FitPoint] = {}

    def solve(self) -> tuple[FitPoint, bool]:
        """The point where the search ends, and whether it has converged.  Raises FitError where it cannot begin."""
        from scipy.optimize import least_squares  # slow to import

        start, lower, upper = np.array([(u.start, u.lower, u.upper) for u in self.problem.unknowns]).T
        self._check_runs("begin", start)

        def point(u: Values) -> FitPoint:
            """Here one is added to the logarithms, so that scipy's xtol is a relative change of values."""
            return self.at(start * np.exp(u - 1.0))

        search = partial(
            least_squares,
            lambda u: point(u).rows[0],
            jac=lambda u: point(u).rows[1],
            bounds=(np.log(lower / start) + 1.0, np.log(upper / start) + 1.0),
            ftol=FLAT / len(self.measured),
            gtol=None,
            max_nfev=MOST_POINTS,
        )
        self._add_grid(start)
        found = search(np.ones_like(start), xtol=NEAR)
        self._add_grid(start * np.exp(found.x - 1.0))
        finest = float(np.sqrt(np.diag(point(found.x).covariance)).min())
        self._step = FINE_STEP if finest < STEP else STEP
        if found.status > 0 and (finest < STEP or self.grid.any()):  # curvature counts, or the noise is new
            self._check_runs("go on with smaller steps", point(found.x).values)
            found = search(found.x, xtol=NEAR * min(finest / STEP, 1.0))
        return point(found.x), found.status > 0

    def _add_grid(self, values: Values) -> None:
        """Take the error of the grid with these values, as `--error` estimates it, as a part of the noise."""
        fine = self.at(values).residuals * self.sigma + self.measured
        half = self._predicted(values[None], Case.on_half_grid)[0]
        if not np.isfinite(half).all():
            why = (self._failures or ["a number is not finite"])[-1]
            self.grid_in_words = self.grid_in_words or f"the error of the grid is not in the noise: {why}"
            return
        orders = np.array([ORDERS.get(name, 2.0) for name in self.columns["quantity"][0]])
        self.grid, before, given = (half - fine) / (2.0**orders - 1.0), self.sigma, self.columns["sigma"][0]
        self.sigma, share = np.hypot(given, self.grid), np.sort(np.abs(self.grid) / given)
        self.points = {key: p.with_noise(before / self.sigma, self.grid / self.sigma) for key, p in self.points.items()}
        usual, most = share[len(share) // 2], share[-1]
        self.grid_in_words = f"the error of the grid is in the noise: {usual:.2g} sigma as a rule, {most:.2g} at most"

    def _check_runs(self, what: str, values: Values) -> None:
        """Raise FitError where a search cannot do this, because a run with these values, or next to them, failed."""
        if not np.isfinite(self.at(values).residuals).all():
            pairs = zip(self.problem.unknowns, values, strict=True)
            where = ", ".join(f"{u.field} = {amount(value, u.unit)}" for u, value in pairs)
            why = (self._failures or ["its numbers are not finite"])[-1]
            raise FitError(f"the fit cannot {what}: a run at {where}, or next to it, failed: {why}")

    def at(self, values: Values) -> FitPoint:
        """The point with these values; its residuals are nan where a run failed, from which the search steps back."""
        key = np.append(values, self._step).tobytes()
        if key not in self.points:
            self._note(self)
            self.points[key] = self._computed(values)
        return self.points[key]

    def _computed(self, values: Values) -> FitPoint:
        unknowns, size = self.problem.unknowns, len(values)
        bounds = np.array([(u.lower, u.upper) for u in unknowns]).T
        steps = self._step * np.where(values * np.exp(self._step) <= bounds[1], 1.0, -1.0)
        predicted = self._predicted(values * np.exp(np.vstack([np.zeros(size), np.diag(steps)])))
        return FitPoint(
            self.problem.names,
            tuple(unknown.unit for unknown in unknowns),
            values,
            bounds,
            np.array([unknown.prior or (np.nan, np.nan) for unknown in unknowns]).T,
            (predicted[0] - self.measured) / self.sigma,
            ((predicted[1:] - predicted[0]) / steps[:, None] / self.sigma).T,
            self.problem.aligned,
            self.grid / self.sigma,
        )

    def _predicted(self, places: Values, of: Callable[[Case], Case] = lambda case: case) -> Values:
        """The predictions with the values of each row, by these cases or others made of them; nan where one failed."""
        try:
            groups = [[of(case) for case in self.problem.cases(values)] for values in places]
            cases = [case for group in groups for case in group]
            self.runs |= {case.digest for case in cases}
            outcomes: Sequence[Any] = self._runner(cases)
            for failure in [outcome for outcome in outcomes if isinstance(outcome, Failure)]:
                raise ValueError(failure.reason)
            self.warnings |= {case.digest: run.warnings for case, run in zip(cases, outcomes, strict=True)}
            size = len(self.problem.conditions)
            results = [outcomes[first : first + size] for first in range(0, len(outcomes), size)]
            clocked = [self.problem.on_clocks(found) for found in results]
            self.compared[cases[0].digest] = {
                number: each.compared(run)
                for number, (each, run) in enumerate(clocked[0], 1)
                if each.align or each.start
            }
            return np.array([np.concatenate([each.predicted(run) for each, run in data]) for data in clocked])
        except ValueError as error:  # also of a case that is not allowed, and of a run that does not reach the data
            self._failures.append(str(error))
            return np.full((len(places), len(self.measured)), np.nan)


def solve_fit(problem: FitProblem, runner: Runner, note: Callable[[Search], object] = lambda _: None) -> FitResult:
    """The result of a fit.  runner, note: see `Search`.  Raises FitError."""
    others = {law: solve_fit(other, runner, note) for law, other in problem.others.items()}
    search = Search(problem, runner, note)
    solution, converged = search.solve()
    unfinished = [] if converged else [f"the search has not converged after {MOST_POINTS} points; start nearer"]
    predicted = solution.residuals * search.sigma + search.measured
    best = problem.cases(solution.values)
    of_runs = grouped(((case.digest, each) for case in best for each in search.warnings[case.digest]), "run")
    compared = search.compared[best[0].digest]
    doubts = [warning for each in compared.values() for warning in each.warnings]
    about = {
        "title": problem.case.name or problem.case.kind,
        "runs": len(search.runs),
        "best": f"{RUNS}/{best[0].digest}",
        "kept": [case.digest for case in best],
        "under": under_the_law(problem),
        "grid": search.grid_in_words,
        "aligned": "; ".join(f"measurement {number}, {each.in_words}" for number, each in compared.items()),
        "warnings": [*unfinished, *solution.warnings, *doubts, *of_runs],
    }
    aligned = [compared[n].aligned if n in compared else "" for n in search.columns["measurement"][0]]
    columns = {
        **search.columns,
        "aligned": (np.array(aligned, dtype=object), "what the alignment took off"),
        "grid_error": (search.grid, "error of the grid, in SI, a part of the noise"),
        "predicted": (predicted, "in SI"),
    }
    case = with_settings(problem.case, problem.at(solution.values))
    found = FitResult(fit_dataset(solution, columns, about), case=case)
    return with_laws({problem.law: found, **others}) if others else found


# -- its runs ---------------------------------------------------------------------------------------------------------


def store_fit(
    problem: FitProblem,
    directory: Path,
    engine: Engine,
    asked: Condition = never,
    progress: bool = False,
    keep: Keep = "best",
) -> FitResult:
    """Solve a problem with the runs in a directory, and write the outcome there.

    asked: whether to stop, see `studies.run_study`.  keep: see `fit`.  Raises FitError, StoreError.
    """
    with engine.workers(len(problem.conditions) * (1 + len(problem.unknowns))) as workers, studies.alone(directory):
        note = partial(_note_progress, directory, time.monotonic())
        result = solve_fit(problem, partial(_stored_runs, directory, workers, asked, progress), note)
        result = replace(result, directory=directory)
        studies.write_study(result, directory, NAME)
        so_far = read_progress(directory) or {}
        write_progress(directory, **{**so_far, "status": Status.CONVERGED.value, "done": 1.0})
        if keep == "best":
            prune(directory, result.dataset.attrs["kept"])
    return result


def _note_progress(directory: Path, started: float, search: Search) -> None:
    """Write how far a search is, with the best point so far."""
    message = f"point {len(search.points) + 1} of the search, {len(search.runs)} runs done"
    points = [point for point in search.points.values() if np.isfinite(point.residuals).all()]
    if points:
        best = min(points, key=lambda point: point.chi_square)
        off = (best.chi_square / len(best.rows[0])) ** 0.5
        texts = zip(best.names, best.values, best.units, strict=True)
        values = ", ".join(f"{name} = {amount(value, unit)}" for name, value, unit in texts)
        message += f", residuals {off:.2g} times their sigma at {values}"
    so_far = {"status": Status.RUNNING.value, "T": None, "step": len(search.points), "done": 0.0, "message": message}
    write_progress(directory, **so_far, seconds=round(time.monotonic() - started, 1), seconds_left=None)


def _stored_runs(
    directory: Path, workers: Workers, asked: Condition, progress: bool, cases: Sequence[Case]
) -> list[Result | Failure]:
    """The results of cases in their order, from their runs in a directory.  Raises StoppedFit."""
    each = {case.digest: case for case in cases}
    statuses = studies.run_study(list(each.values()), directory, workers, asked=asked, progress=progress)
    outcomes = {digest: _outcome(directory, case, statuses.get(digest, "")) for digest, case in each.items()}
    return [outcomes[case.digest] for case in cases]


def _outcome(directory: Path, case: Case, status: str) -> Result | Failure:
    place = studies.run_directory(directory, case)
    if status.startswith(studies.FAILED):
        kind, _, why = status.removeprefix(studies.FAILED).partition(": ")
        if kind in (StoreError.__name__, Damaged.__name__):  # no answer of the model, from which a search steps back
            raise FitError(f"{why}; delete {place}, and the same call computes the run again")
        return Failure(f"{place}: {status.removeprefix(studies.FAILED)}")
    if status == Status.INTERRUPTED.value or not (place / CASE).exists():
        raise StoppedFit(f"{directory}: the fit was asked to stop; the same call goes on")
    result = RunStore.open(place).result()
    return result if result.status.ok else Failure(f"{place}: {result.status.value}; {result.status.advice}")
