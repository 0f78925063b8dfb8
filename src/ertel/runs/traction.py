"""Traction curves: the friction of a steady contact at several slide-to-roll ratios, speeds or loads.

curve = traction(case, slide_to_roll="0:0.5:15")
"""

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ertel.case.case import Case
from ertel.case.derived import newtonian_stress
from ertel.case.status import Status
from ertel.equations.account import coefficients, steady_friction
from ertel.inputs.case_files import CaseLike, as_case
from ertel.inputs.ranges import Given
from ertel.numerics.arrays import double_precision
from ertel.results import diagnostics
from ertel.results.curve_points import WORK, Point, assemble, point
from ertel.results.steady import thermal_warnings
from ertel.results.traction_curve import TractionCurve
from ertel.results.variables import with_coefficients
from ertel.runs import workers
from ertel.runs.compile import check_jax
from ertel.runs.courses import GridStep, SteadyRun
from ertel.runs.curves import Curve, Film, curve_of
from ertel.runs.drive import Observer, bars, drive, warn
from ertel.runs.outlook import beyond
from ertel.runs.traction_store import CurveStore
from ertel.solvers.heat import Heated, heated
from ertel.solvers.steady import Rolling

NUMBER = re.compile(r"(?<!surface )\b\d[\d.]*(e[+-]?\d+)?")  # in a warning, but not that of a surface

ObserversOf = Callable[[int, SteadyRun], Sequence[Observer]]  # of the film for a point, by the number of the point


@double_precision()
def run(
    curve: Curve,
    store: CurveStore | None = None,
    observers_of: ObserversOf = lambda number, course: (),
    stop: Callable[[object], bool] = lambda item: False,
) -> TractionCurve:
    """Compute the points that are not there yet, up to a stop; the curve so far, which the store also has.

    observers_of: see every grid of the film of a point.  stop: is asked after every grid and every point.
    """
    if store is None:
        return _found(curve, list(_computed(curve, 0, observers_of, stop)))
    with store.alone():
        before = len(store.points)
        for new in _computed(curve, before, observers_of, stop):
            store.keep(new)
        found = _found(curve, store.points, store.directory)
        if len(store.points) > before or not store.drawn:
            store.draw(found)
    return found


def _computed(curve: Curve, done: int, observers_of: ObserversOf, stop: Callable[[object], bool]) -> Iterator[Point]:
    """The points of a curve from number `done` on, up to a stop."""
    workers.check_fork()
    film: GridStep | None = None
    for number in range(done, len(curve.values)):
        fresh = film is None or curve.film == "each"
        if film is None or fresh:
            course = SteadyRun(curve.cases[number if curve.film == "each" else curve.of_film])
            film = drive(course, [*observers_of(number, course), stop])
            if film.status is Status.INTERRUPTED:
                return
        new = _measured(curve.cases[number], film, fresh)
        yield new
        if stop(new):
            return


def _measured(case: Case, film: GridStep, fresh: bool) -> Point:
    """The friction of a film in a case, which may slide in another way than that of the film.

    fresh: whether the film was solved for this point, so that its work counts here.
    """
    grids = Rolling(film.solutions)
    found = steady_friction(case, grids.finest)
    numbers = with_coefficients(coefficients(found), case.scales)
    sliding, rolling = numbers["mu_sliding"], numbers["mu_rolling"]
    work = sum(s.newton for s in film.solutions), sum(s.krylov for s in film.solutions), grids.convolutions
    values = {
        **grids.finest.measure(),
        **numbers,
        "mu_1": rolling + sliding,
        "mu_2": rolling - sliding,
        "tau_max": float(np.hypot(*np.asarray(found.stress)).max()),
        **dict(zip(WORK, work if fresh else (0, 0, 0.0), strict=True)),
    }
    said, status = [*beyond(case), *diagnostics.steady_warnings(case, film.solutions)], film.status
    if case.thermal is not None and film.status.ok:
        warm = heated(case, grids.finest.P, grids.finest.H, grid=grids.finest.grid)
        values |= _warm_values(case, values, warm)
        said += thermal_warnings(case, warm)
        status = film.status if warm.converged else Status.NEWTON_STALLED
    if status.ok:
        said += diagnostics.friction_warnings(case, values["mu_sliding"])
    return point(case, values, status, said)


def _warm_values(case: Case, cold: Mapping[str, float], warm: Heated) -> dict[str, float]:
    """What heat changes: the film by its inlet factor, the traction, and of the power loss the part of sliding."""
    unit = case.scales.a_over_R if case.scales else 1.0
    sliding, factor = float(warm.sliding[0]) * unit, warm.inlet.factor
    less = (cold["mu_sliding"] - sliding) / unit * case.motion.load(0.0) * case.motion.sliding(0.0)
    temperatures = {f"{name}_max": float(np.max(getattr(warm, name))) for name in ("T_1", "T_2", "T_film")}
    return {
        "mu_isothermal": cold["mu_sliding"],
        "mu_sliding": sliding,
        "mu_sliding_y": float(warm.sliding[1]) * unit,
        "mu_1": cold["mu_rolling"] + sliding,
        "mu_2": cold["mu_rolling"] - sliding,
        "power_loss": cold["power_loss"] - less,
        "H_c": factor * cold["H_c"],
        "H_min": factor * cold["H_min"],
        "tau_max": float(np.hypot(*np.asarray(warm.stress)).max()),
        "phi_T": factor,
        **temperatures,
    }


def _found(curve: Curve, points: Sequence[Point], directory: Path | None = None) -> TractionCurve:
    """The curve of the points so far."""
    dataset = assemble(curve.case, curve.axis, curve.values, points, curve.film_in_words)
    return TractionCurve(curve.case, dataset, _grouped(curve, points), len(points) == len(curve.values), directory)


def _grouped(curve: Curve, points: Sequence[Point]) -> tuple[str, ...]:
    """The warnings of all points: of those that differ in their numbers only the first, and at how many points."""
    alike: dict[str, list[str]] = {}
    for value, each in zip(curve.values, points, strict=False):
        for sentence in each["warnings"]:
            alike.setdefault(NUMBER.sub("#", sentence), []).append(f"{curve.axis} = {value:.4g}: {sentence}")
    more = " (and the same at {} other points)".format
    return tuple(first + (more(len(others)) if others else "") for first, *others in alike.values())


def traction(
    case: CaseLike,
    *,
    slide_to_roll: Given | None = None,
    mean_speed: Given | None = None,
    load: Given | None = None,
    film: Film | None = None,
    directory: str | Path | None = None,
    progress: bool = False,
) -> TractionCurve:
    """The traction curve of a steady contact, over the slide-to-roll ratio, the mean speed or the load.

    Parameters
    ----------
    case : Case, str, Path or mapping
        A steady rolling contact; its other values hold for all points.
    slide_to_roll, mean_speed, load : str or sequence
        One of them: a range such as "0:0.5:15" (first, last, number of values; with ":log" at the end equal ratios), or
        values.  mean_speed (m/s, or texts with a unit) and load (N) need a case in SI.
    film : "each" or "once"
        Over the slide-to-roll ratio: whether the film is solved for each point, or once, at the smallest slide-to-roll
        ratio.  For a Newtonian oil once is exact and the default.  An oil that thins has a thinner film where it
        slides, so each is the default; once takes the work of one point and leaves that out.
    directory : str or Path
        Where the curve is stored: made if it is not there.  A curve that was interrupted goes on.
    progress : bool
        Whether to show a progress bar.

    Returns
    -------
    TractionCurve
        It shows itself as a table; `dataset`, `plot()`, `to_csv(path)`.

    Raises
    ------
    ConfigError
        A value is not allowed; the message names the argument, its value and what is allowed.
    StoreError
        The directory holds something else.

    Warns
    -----
    UserWarning
        The case with the largest shear stress is outside the range of the model; before the run.

    Examples
    --------
    >>> import ertel
    >>> case = ertel.load_case("examples/squalane.toml")  # doctest: +SKIP
    >>> ertel.traction(case, slide_to_roll="0:0.5:15").plot()  # doctest: +SKIP
    """
    check_jax()
    curve = curve_of(as_case(case), {"slide_to_roll": slide_to_roll, "mean_speed": mean_speed, "load": load}, film)
    store = CurveStore.of(Path(directory), curve) if directory else None
    warn(beyond(max(curve.cases, key=newtonian_stress)), frames=1)
    with bars(progress) as shown:
        return run(curve, store, watched(shown, curve))


def watched(progress: Any, curve: Curve) -> ObserversOf:
    """Observers that show the points in one bar."""
    bar = progress.add_task(
        curve.case.name or curve.case.kind, total=len(curve.values), news="compiling (once per machine and grid size)"
    )

    def observers_of(number: int, course: SteadyRun) -> list[Observer]:
        where = f"{number + 1}/{len(curve.values)}  {curve.axis} = {curve.values[number]:.4g}"

        def show(item: GridStep) -> None:
            progress.update(bar, completed=number + course.fraction(item), news=f"{where}  {course.message(item)}")

        return [show]

    return observers_of
