"""Traction curves: the friction of a steady contact at several slide-to-roll ratios, speeds or loads.

    curve = traction(case, slide_to_roll="0:0.5:15")

Each point is the steady contact of the case with one value replaced.  A curve over the speed or the load needs the film
of every point.  Over the slide-to-roll ratio the film of a Newtonian oil is the same at all points, so it is solved
once; an oil that thins has another film at each, and is solved for each unless the user wants one film.

A curve is a study whose runs are these films, see `studies`: in its directory they are in runs/DIGEST, beside
traction.zarr, traction.csv and traction.png.  The points follow from the films.  Without a directory they are in a
temporary one.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal, get_args

import numpy as np

from ertel.case.case import Case
from ertel.case.conditions import Conditions
from ertel.case.estimates import newtonian_stress
from ertel.case.records import ConfigError, show, with_unit
from ertel.case.sections import Drive
from ertel.case.status import Status
from ertel.inputs.case_files import CaseLike, as_case
from ertel.inputs.quantities import Given, parse_values
from ertel.numerics.programs import double_precision
from ertel.physics.units import marks
from ertel.results.dataset import provenance
from ertel.results.friction import film_over_roughness, touch_warnings
from ertel.results.study_table import DONE, StudyRun, grouped, study_dataset
from ertel.results.summary import steady_values
from ertel.runs import studies
from ertel.runs.compile import check_jax
from ertel.runs.drive import GridStep, warn
from ertel.runs.outlook import beyond
from ertel.runs.store import RunStore
from ertel.runs.study_result import CURVE_AXES, TractionCurve, point_numbers
from ertel.runs.workers import Condition, LocalWorker, check_fork, never
from ertel.solvers.steady import Rolling

NAME = "traction"  # of the files with the points

FilmChoice = Literal["each", "once"]


def traction(
    case: CaseLike,
    *,
    slide_to_roll: Given | None = None,
    mean_speed: Given | None = None,
    load: Given | None = None,
    film: FilmChoice | None = None,
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
        The directory in which the curve is stored, as a study is (see `ertel.sweep`): a new or empty one, or that of
        an earlier curve, whose films are used again as far as they are the same.  What is missing or unfinished is
        done.  The table and the picture are those of the last curve.
    progress : bool
        Whether to show a progress bar; in a file, a line a minute.

    Returns
    -------
    TractionCurve
        It shows itself as a table; `dataset`, `plot()`, `to_csv(path)`.

    Raises
    ------
    ConfigError
        A value is not allowed; the message names the argument, its value and what is allowed.
    StoreError
        Another process computes the curve, or the directory holds other files.

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
    warn(beyond(max(curve.cases, key=newtonian_stress)), frames=1)
    do = curve_in if directory is None else store_curve
    return studies.in_directory(directory, NAME, lambda place: do(curve, place, progress))


def stribeck(
    case: CaseLike,
    mean_speed: Given = "0.001:10:25",
    *,
    directory: str | Path | None = None,
    progress: bool = False,
) -> TractionCurve:
    """The Stribeck curve of a steady contact whose asperities touch: its traction curve over the mean speed.

    Parameters
    ----------
    case : Case, str, Path or mapping
        A steady rolling contact in SI that slides, with a law of asperities, `surfaces`.
    mean_speed : str or sequence
        First, last and number of speeds (m/s, or with a unit) with equal ratios between them; or values.
    directory, progress
        As for `traction`.

    Returns
    -------
    TractionCurve
        Its `dataset` has the traction coefficient with the parts of the oil and of the asperities, `mu_oil` and
        `mu_boundary`, the share of the load that asperities carry, and the film over the roughness, `Lambda`.

    Raises
    ------
    ConfigError, StoreError
        As `traction`; or no asperities touch in the case.
    """
    case = as_case(case)
    require_touch(case)
    return traction(case, mean_speed=in_ratios(mean_speed), directory=directory, progress=progress)


def require_touch(case: Case) -> None:
    """Raise ConfigError for a case without asperities that touch, or without sliding."""
    if not case.motion.slides:
        raise ConfigError("contact.slide_to_roll: missing or zero, a Stribeck curve needs surfaces that slide")
    if not case.touches:
        raise ConfigError("surfaces.asperities: missing, a Stribeck curve needs a law of the asperities that touch")


def in_ratios(speeds: Given, name: str = "mean_speed") -> tuple[float, ...]:
    """Mean speeds (m/s), of a range FIRST:LAST:NUMBER with equal ratios, as logarithmic axes need.

    name: of the argument.  Raises ConfigError, see `parse_values`.
    """
    equal = f"{speeds}:log" if isinstance(speeds, str) and speeds.count(":") == 2 else speeds
    return parse_values(name, equal, marks(Conditions)["mean_speed"])


# -- the curve --------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Curve:
    """The definition of a traction curve: case, axis and its values in SI, the case of each point, and the film.

    film: "each", solved for each point, or "once", that of the smallest slide-to-roll ratio for all points.
    """

    case: Case
    axis: str
    values: tuple[float, ...]
    cases: tuple[Case, ...]
    film: FilmChoice

    @property
    def films(self) -> tuple[Case, ...]:
        """The case of the film of each point."""
        if self.film == "each":
            return self.cases
        return (self.cases[int(np.argmin(np.abs(self.values)))],) * len(self.cases)

    @property
    def film_in_words(self) -> str:
        """The way in which the film was computed."""
        if self.film == "each":
            return "solved for each point"
        one = f"solved once, at S = {min(self.values, key=abs):g}"
        return f"{one}: that of a Newtonian oil is the same at all points" if self.case.oil.is_newtonian else one


def curve_of(case: Case, given: Mapping[str, Given | None], film: str | None = None) -> Curve:
    """The curve that a user asks for.

    given: by the name of the axis, exactly one of them.  Raises ConfigError, naming the argument.
    """
    if not case.is_steady:
        use = 'use contact.kind = "rolling" and solver.method = "steady"'
        raise ConfigError(f'solver.method = "{case.solver.method}": a traction curve is of a steady contact; {use}')
    axes = {name: values for name, values in given.items() if values is not None}
    if len(axes) != 1:
        raise ConfigError(f"give exactly one of {', '.join(CURVE_AXES)}; got {' and '.join(axes) or 'none'}")
    [(axis, values)] = axes.items()
    if axis != "slide_to_roll" and not case.scales:
        raise ConfigError(f"{axis} = {show(values)}: a dimensionless case has none; give the contact in SI")
    _check_factors(case, axis)
    in_si = parse_values(axis, values, mark := marks(Conditions)[axis])
    cases = []
    for value in in_si:
        try:
            cases.append(_at(case, axis, value))
        except ConfigError as error:
            grid = "; all points have the grid of the case, so give it there" if "solver." in str(error) else ""
            raise ConfigError(f"at {axis} = {show(with_unit(value, mark))}: {error}{grid}") from error
    return Curve(case, axis, in_si, tuple(cases), _film(case, axis, film))


def _film(case: Case, axis: str, film: str | None) -> FilmChoice:
    if film not in (None, *get_args(FilmChoice)):
        raise ConfigError(f"film = {show(film)}: allowed: {', '.join(get_args(FilmChoice))}")
    if axis != "slide_to_roll":
        if film == "once":
            raise ConfigError(f'film = "once": the film depends on {axis}; leave it out, or use film = "each"')
        return "each"
    if case.thermal and case.thermal.is_solved:
        if film == "once":
            raise ConfigError(
                'film = "once": the film changes with its heat; leave it out, or use thermal.inlet = "gupta"'
            )
        return "each"
    return film or ("once" if case.oil.is_newtonian else "each")  # type: ignore[return-value]


def _check_factors(case: Case, axis: str) -> None:
    """Speed and load of a case may have a constant factor in [motion], which would change the axis."""
    key, factor = "load", case.motion.load(0.0)
    if axis == "mean_speed":
        key, factor = "entrainment", abs(case.motion.entrainment(0.0))
    if axis != "slide_to_roll" and factor != 1.0:
        raise ConfigError(f"motion.{key} = {factor:g}: multiplies the {axis} of a curve; leave it out of the case")


def _at(case: Case, axis: str, value: float) -> Case:
    """The case of a point."""
    if axis == "load":
        return replace(case, contact=replace(case.contact, load=value))
    if not case.contact.is_physical:
        return replace(case, drive=replace(case.drive or Drive(), slide_to_roll=value))
    mean = value if axis == "mean_speed" else case.contact.speeds.mean
    sliding = value if axis == "slide_to_roll" else case.contact.speeds.slide_to_roll
    contact = replace(case.contact, mean_speed=mean, slide_to_roll=sliding, speed_1=None, speed_2=None)
    return replace(case, contact=contact)


# -- its points -------------------------------------------------------------------------------------------------------


def store_curve(curve: Curve, directory: Path, progress: bool = False, asked: Condition = never) -> TractionCurve:
    """The curve so far, see `curve_in`, which is also written in its directory.  Raises StoreError."""
    with studies.alone(directory):
        result = curve_in(curve, directory, progress, asked)
        studies.write_study(result, directory, NAME)
    return result


@double_precision()
def curve_in(curve: Curve, directory: Path, progress: bool = False, asked: Condition = never) -> TractionCurve:
    """The curve so far, after the films that a directory lacks have been computed, up to a stop.

    asked: whether to stop, see `studies.run_study`.
    """
    check_fork()
    statuses = studies.run_study(curve.films, directory, LocalWorker(), asked=asked, progress=progress)
    points, present = [], None
    for case, film_case in zip(curve.cases, curve.films, strict=True):
        fresh = film_case is not present  # one film may serve all points
        if fresh:
            run, present = studies.study_run(film_case, directory, statuses), film_case
            film = RunStore.open(directory / run.directory).item() if run.status == DONE else None
        if film is None:
            points.append(run._replace(numbers={}))
        else:
            points.append(_measured(case, film, fresh, run.directory))
    axis = {curve.axis: (curve.values, CURVE_AXES[curve.axis])}
    values = (f"{curve.axis} = {value:.4g}" for value in curve.values)
    said = ((value, each) for value, point in zip(values, points, strict=True) for each in point.warnings)
    warnings = grouped(said, "point")
    about = {"varies": curve.axis, "film": curve.film_in_words, "warnings": warnings}
    data = study_dataset("product", axis, points, {**provenance(curve.case), **about})
    return TractionCurve(data, directory, case=curve.case)


def _measured(case: Case, film: GridStep, fresh: bool, directory: str) -> StudyRun:
    """The friction of a film in a case, which may slide in another way than that of the film.

    fresh: whether the film was solved for this point, so that its work counts here.  directory: of the film's run.
    """
    solution, scales, speed = replace(film.solutions[-1], case=case), case.scales, case.contact.speeds.mean
    values, _, warnings = steady_values(case, (*film.solutions[:-1], solution))
    warnings = [*beyond(case, (values["H_min"] or 0.0) * scales.film if scales else None), *warnings]
    heat = solution.heat if film.status.ok else None
    if not film.status.ok or (heat and not heat.converged):
        status = Status.NEWTON_STALLED if film.status.ok else film.status
        return StudyRun({}, warnings, status.value, directory)
    of_film = {
        **film_over_roughness(case, values),
        **({"Hersey": (case.oil.eta0 or 0.0) * speed / (scales.p_h * scales.a)} if scales and speed else {}),
        **_of_surfaces(values["mu_rolling"], values["mu_sliding"], solution.account.friction.stress),
        "newton_iterations": fresh * sum(s.newton for s in film.solutions),
        "krylov_iterations": fresh * sum(s.krylov for s in film.solutions),
        "convolutions": fresh * Rolling(film.solutions).convolutions,
    }
    if heat and "mu_sliding_warm" in values:  # the film itself is without heat
        warm = _of_surfaces(values["mu_rolling"], values["mu_sliding_warm"], heat.stress)
        of_film |= {f"{name}_warm": value for name, value in warm.items()}
        of_film["mu_sliding_y_warm"] = float(heat.sliding[1]) * scales.a_over_R  # type: ignore[union-attr]
    warnings += touch_warnings(case, values)
    return StudyRun(point_numbers(case, values | of_film), warnings, film.status.value, directory)


def _of_surfaces(rolling: float, sliding: float, stress: Any) -> dict[str, float]:
    """The friction coefficient of each surface, and the maximum shear stress."""
    largest = float(np.hypot(*np.asarray(stress)).max())
    return {"mu_1": rolling + sliding, "mu_2": rolling - sliding, "tau_max": largest}
