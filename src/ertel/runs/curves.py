"""What a traction curve is of: the case, what varies and its values, and whether the film is solved for each point.

Each point is the steady contact of the case with one value replaced.  A curve over the speed or the load needs the film
of every point.  Over the slide-to-roll ratio the film of a Newtonian oil is the same at all points, so it is solved
once; an oil that thins has another film at each, and is solved for each unless the user wants one film.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Literal, get_args

import numpy as np

from ertel.case.case import Case
from ertel.case.records import ConfigError, show
from ertel.case.sections import Drive
from ertel.inputs.ranges import Given, parse_values
from ertel.results.curve_points import AXES

Film = Literal["each", "once"]


@dataclass(frozen=True)
class Curve:
    """What a traction curve is of: the case, what varies and its values in SI, and the film.

    film: "each", solved for each point, or "once", that of the smallest slide-to-roll ratio for all points.
    """

    case: Case
    axis: str
    values: tuple[float, ...]
    film: Film

    @cached_property
    def cases(self) -> tuple[Case, ...]:
        """The case of each point.  Raises ConfigError for a value that the case does not allow."""
        try:
            return tuple(AT[self.axis](self.case, value) for value in self.values)
        except ValueError as error:
            raise ConfigError(str(error)) from error

    @property
    def film_in_words(self) -> str:
        """How the film was computed."""
        if self.film == "each":
            return "solved for each point"
        one = f"solved once, at S = {self.values[self.of_film]:g}"
        return f"{one}: that of a Newtonian oil is the same at all points" if self.case.oil.is_newtonian else one

    @property
    def of_film(self) -> int:
        """The number of the point whose film serves all, where it is solved once."""
        return int(np.argmin(np.abs(self.values)))


def curve_of(case: Case, given: Mapping[str, Given | None], film: str | None = None) -> Curve:
    """The curve that a user asks for.

    given: by the name of the axis, exactly one of them.  Raises ConfigError, naming the argument.
    """
    _check_steady(case)
    wanted = {name: values for name, values in given.items() if values is not None}
    if len(wanted) != 1:
        said = " and ".join(wanted) or "none"
        raise ConfigError(f"give exactly one of {', '.join(AXES)}; got {said}")
    [(axis, values)] = wanted.items()
    if axis != "slide_to_roll" and not case.scales:
        raise ConfigError(f"{axis} = {show(values)}: a dimensionless case has none; give the contact in SI")
    check_factors(case, axis)
    curve = Curve(case, axis, parse_values(axis, values, AXES[axis].mark), _film(case, axis, film))
    curve.cases  # noqa: B018  # raises where a value is not allowed
    return curve


def _check_steady(case: Case) -> None:
    if not case.is_steady:
        raise ConfigError(
            f'solver.method = "{case.solver.method}": a traction curve is of a steady contact; use contact.kind = '
            '"rolling" and solver.method = "steady"'
        )


def _film(case: Case, axis: str, film: str | None) -> Film:
    if film not in (None, *get_args(Film)):
        raise ConfigError(f"film = {show(film)}: allowed: {', '.join(get_args(Film))}")
    if axis != "slide_to_roll":
        if film == "once":
            raise ConfigError(f'film = "once": the film depends on {axis}; leave it out, or use film = "each"')
        return "each"
    return film or ("once" if case.oil.is_newtonian else "each")  # type: ignore[return-value]


# -- the case of a point ----------------------------------------------------------------------------------------------


def check_factors(case: Case, axis: str) -> None:
    """Speed and load of a case may have a constant factor in [motion], which would change the axis."""
    for of, key, factor in (
        ("load", "load", case.motion.load(0.0)),
        ("mean_speed", "entrainment", abs(case.motion.entrainment(0.0))),
    ):
        if axis == of and factor != 1.0:
            raise ConfigError(f"motion.{key} = {factor:g}: multiplies the {of} of a curve; leave it out of the case")


def _with_slide_to_roll(case: Case, value: float) -> Case:
    if case.contact.is_physical:
        return _with_speeds(case, case.contact.speeds.mean, value)
    return replace(case, drive=replace(case.drive or Drive(), slide_to_roll=value))


def _with_mean_speed(case: Case, value: float) -> Case:
    return _with_speeds(case, value, case.contact.speeds.slide_to_roll)


def _with_speeds(case: Case, mean: float | None, slide_to_roll: float | None) -> Case:
    contact = replace(case.contact, mean_speed=mean, slide_to_roll=slide_to_roll, speed_1=None, speed_2=None)
    return replace(case, contact=contact)


def _with_load(case: Case, value: float) -> Case:
    return replace(case, contact=replace(case.contact, load=value))


AT: Mapping[str, Callable[[Case, float], Case]] = {
    "slide_to_roll": _with_slide_to_roll,
    "mean_speed": _with_mean_speed,
    "load": _with_load,
}
