"""The question of a fit: a case, its unknowns, and the data with the conditions under which they were measured."""

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from ertel.case.case import Case
from ertel.case.reading import check_keys
from ertel.case.records import ConfigError, show
from ertel.inputs.case_files import CaseLike, written
from ertel.inputs.fits import (
    RIG,
    Settings,
    Unknown,
    WrittenCase,
    interferometer,
    laws_of,
    load_fit,
    parse_unknowns,
    with_settings,
)
from ertel.results.alignment import CONDITIONS, QUANTITIES, START, si_unit, with_start
from ertel.results.measurements import NUMBER, READ, Measurement
from ertel.runs.fit_result import Values

COLUMNS = {  # of the data: what they are
    "measurement": "number of the measurement, from 1",
    "quantity": "SI name",
    "conditions": "what differs from the case",
    "measured_unit": "SI unit",
    "x_unit": "SI unit of x",
    "varies": "condition that varies along a curve",
    "x": "place or time",
    "measured": "measured value",
    "sigma": "standard deviation",
}
Given = Measurement | tuple[Measurement, Settings]


@dataclass(frozen=True)
class FitProblem:
    """The unknowns to be found, and the data.

    conditions: each different set of values in which measurements differ from the case.  under: the case under each of
    them.  data: measurements with the numbers of their conditions, of a curve one for each of its values.  law:
    the name of that of viscosity, where the same question is asked under several; others: that under the others.
    """

    case: Case
    unknowns: tuple[Unknown, ...]
    conditions: tuple[Settings, ...]
    under: tuple[Case, ...]
    data: tuple[tuple[Measurement, tuple[int, ...]], ...]
    law: str = ""
    others: Mapping[str, "FitProblem"] = field(default_factory=dict)

    @property
    def aligned(self) -> int:
        """The number of values that the alignment takes from the data; the clocks of a set of conditions are one."""
        pairs = enumerate(self.data)
        return len({(name, n if name == START else i) for i, (each, n) in pairs for name in each.align})

    def on_clocks(self, results: Sequence[Any]) -> list[tuple[Measurement, Any]]:
        """The data with known starts of their clocks, and with their run, of those under each set of conditions.

        A curve has a list of runs.
        """
        known = dict(enumerate(self.data))
        for number, result in enumerate(results):
            group = {i: each for i, (each, n) in enumerate(self.data) if n == (number,) and START in each.align}
            starts = with_start(list(group.values()), result) if group else []
            known |= {i: (each, (number,)) for i, each in zip(group, starts, strict=True)}
        runs = ((each, [results[n] for n in numbers]) for each, numbers in known.values())
        return [(each, found if each.kind == "curve" else found[0]) for each, found in runs]

    @property
    def names(self) -> tuple[str, ...]:
        """The short names of the unknowns: the last part of their paths, all of it where two are alike."""
        short = [unknown.field.rpartition(".")[2] for unknown in self.unknowns]
        pairs = zip(short, self.unknowns, strict=True)
        return tuple(name if short.count(name) == 1 else unknown.field for name, unknown in pairs)

    def at(self, values: Values) -> dict[str, Any]:
        """The values of the unknowns, in SI, by their paths."""
        return {u.field: u.in_case(value) for u, value in zip(self.unknowns, values, strict=True)}

    def cases(self, values: Values) -> list[Case]:
        """The case of each set of conditions with these values of the unknowns.  Raises ConfigError."""
        return [with_settings(case, self.at(values)) for case in self.under]

    def columns(self) -> dict[str, tuple[Any, str]]:
        """The data one after the other: name -> values, and what they are."""
        rows = []
        for number, (each, indices) in enumerate(self.data, 1):
            settings = [item for item in self.conditions[indices[0]].items() if item[0] != _varied(each, self.case)]
            conditions = ", ".join(f"{path.rpartition('.')[2]} = {value}" for path, value in settings)
            units = si_unit(each.quantity), "" if each.x is None else si_unit(each.axis)
            varies = each.axis if each.kind == "curve" else ""
            x = np.nan if each.x is None else each.x
            for values in np.broadcast(x, each.values, np.asarray(each.sigma)):
                rows.append((number, each.quantity, conditions, *units, varies, *map(float, values)))
        columns = {}
        for (name, text), values in zip(COLUMNS.items(), zip(*rows, strict=True), strict=True):
            columns[name] = np.array(values, dtype=object if isinstance(values[0], str) else None), text
        return columns


def load_fit_problem(path: str | Path, overrides: Sequence[str] = ()) -> FitProblem:
    """The problem in the file of a fit, see `inputs.fits`.  Raises ConfigError."""
    case, tables, unknowns, laws = load_fit(path, overrides)
    given: list[Given] = [(_measurement(place, table, Path(path).parent), table["set"]) for place, table in tables]
    return fit_problem(case, given, unknowns, laws)


def _measurement(place: str, table: Mapping[str, Any], folder: Path) -> Measurement:
    """The measurement that a table of a file in a folder describes.  Raises ConfigError, naming the place."""
    content = {name: value for name, value in table.items() if name not in ("set", "file")}
    file = str(table.get("file", ""))
    check_keys(content, (*READ, *RIG, *QUANTITIES, *CONDITIONS) if file else NUMBER, place)
    try:
        if not file:
            return Measurement.number(**content)
        rig = {name: content.pop(name) for name in RIG if name in content and name != "index"}
        if wrong := [name for name, value in rig.items() if not isinstance(value, str)]:
            raise ValueError(f"{wrong[0]} = {show(rig[wrong[0]])}: must be a text")
        if not isinstance(content.get("index", 1.0), float | int):
            raise ValueError(f"index = {show(content['index'])}: must be a number")
        return Measurement.read(folder / file, **content, optics=interferometer(**rig, index=content.get("index")))
    except TypeError as error:
        raise ConfigError(f"{place} = {show(table)}: must have a file, or quantity, value and sigma") from error
    except ValueError as error:
        raise ConfigError(f"{place}: {error}") from error


def fit_problem(
    case: CaseLike | WrittenCase, measurements: Measurement | Sequence[Given], unknowns: Any, laws: Any = ()
) -> FitProblem:
    """The problem that a user poses.  Raises ConfigError, naming the argument."""
    source = case if isinstance(case, WrittenCase) else WrittenCase.of(case)
    if laws:
        cases = {law: source.with_law(law) for law in laws_of(laws)}
        asked = {law: fit_problem(each, measurements, unknowns) for law, each in cases.items()}
        first, *rest = asked
        return replace(asked[first], law=first, others={law: asked[law] for law in rest})
    found = parse_unknowns(unknowns, source.case)
    conditions: list[Settings] = []
    data = []
    given = [measurements] if isinstance(measurements, Measurement) else measurements
    if not isinstance(given, list | tuple):
        raise ConfigError(f"measurements = {written(measurements)}: must be a Measurement, or a list of them")
    for number, item in enumerate(given, 1):
        each, settings = item if isinstance(item, tuple) and len(item) == 2 else (item, {})
        if not (isinstance(each, Measurement) and isinstance(settings, Mapping)):
            allowed = "must be a Measurement, or a pair of one and its conditions by path"
            raise ConfigError(f"measurements[{number}] = {written(item)}: {allowed}")
        place = f"measurements[{number}], {each.name}"
        if each.sigma is None:
            raise ConfigError(f"{place}: sigma = None: must be given: a fit weighs the data by their sigma")
        if both := {unknown.field for unknown in found} & {*settings, _varied(each, source.case)}:
            raise ConfigError(f"{place}: {min(both)} is an unknown and cannot be a condition")
        numbers = []
        for under in _settings(each, dict(settings), source.case):
            if under not in conditions:
                _check_heard(source, under, found, place)
                conditions.append(under)
            numbers.append(conditions.index(under))
        data.append((each, tuple(numbers)))
    size = sum(len(each.values) - len(each.align) for each, _ in data) + sum(u.prior is not None for u in found)
    if size < len(found):
        raise ConfigError(f"unknowns: {len(found)} unknowns, but only {size} data (with priors); measure more")
    there = tuple(source.under(settings) for settings in conditions)
    problem = FitProblem(source.case, found, tuple(conditions), there, tuple(data))
    problem.cases(np.array([unknown.start for unknown in found]))  # raises where a path does not fit the case
    return problem


def _varied(measurement: Measurement, case: Case) -> str:
    """The path of the field of a case that varies along a curve; "" of other measurements."""
    name = "mean_speed" if measurement.along == "speed" and case.kind == "rolling" else measurement.along
    return CONDITIONS[name][0] if measurement.kind == "curve" else ""


def _settings(measurement: Measurement, settings: Settings, case: Case) -> list[Settings]:
    """The conditions of a measurement; of a curve one for each of its values."""
    path = _varied(measurement, case)
    if not path:
        return [settings]
    unit = {"1": ""}.get(si_unit(measurement.along), f" {si_unit(measurement.along)}")
    values = np.asarray(measurement.x).tolist()
    return [{**settings, path: f"{value!r}{unit}" if unit else value} for value in values]


def _check_heard(source: WrittenCase, settings: Settings, unknowns: Sequence[Unknown], place: str) -> None:
    """Raise ConfigError for a condition that is not the value of the case, and leaves the case as it is.

    That is a name which the case's own numbers, or the unknowns, replace.
    """
    start = {unknown.field: unknown.in_case(unknown.start) for unknown in unknowns}
    for path, value in settings.items():
        rest = {other: settings[other] for other in settings if other != path}
        with suppress(ConfigError):  # of a case that needs it, or is refused with it: its check reports that
            with_it, without = (with_settings(source.under(each), start).digest for each in (settings, rest))
            if with_it == without and not source.has(path, value):
                break
    else:
        return
    allowed = "changes nothing in the case, where numbers or unknowns replace it; leave those out, or it"
    raise ConfigError(f"{place}: {path} = {written(value)}: {allowed}")


def under_the_law(problem: FitProblem) -> str:
    """A sentence on the law of viscosity under which alpha is found; empty where alpha is not an unknown."""
    if not any(unknown.field == "lubricant.alpha" for unknown in problem.unknowns):
        return ""
    law = problem.case.to_data()["lubricant"]["viscosity"]
    name = law if isinstance(law, str) else law["law"]
    other = ", which is 22 to 25 % too high for an oil that follows Barus'" if name == "roelands" else ""
    advice = 'fit laws = ["roelands", "barus"], at a second speed'
    return f"alpha is that of the {name} law{other}; chi square does not tell: {advice}"
