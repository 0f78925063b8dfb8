"""Studies: a case in which several values stand for one, and the cases that follow from it.

    [contact]
    M = [100, 300, 1000]
    L = "5:20:4"

    [sweep]
    mode = "product"

A list, or a range FIRST:LAST:NUMBER (see `quantities`), in the place of any value makes this value vary.  With mode
"product" every value is combined with every other, with "zip" the first values of all belong together, then the second
ones, ...

A few keys may have a list as their plain value: those of [motion], whose points [T, value] are one signal, and
lubricant.layer, whose points [y, thickness] are one track.  A list of such lists makes these vary.  Tables
(of an oscillation, of a law, of a data sheet, of a shape) do not vary as a whole unless they stand in a list; each
value in them may.
"""

from collections.abc import Hashable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from itertools import product
from math import prod
from pathlib import Path
from typing import Any, Literal

from ertel.case.case import Case
from ertel.case.records import ConfigError, field_name, points_in, refusing, show
from ertel.case.sections import FEWEST_NODES, SECTIONS
from ertel.inputs.case_files import case_data, in_the_case, parse_case, path_of, put
from ertel.inputs.layout import READER, Key, section, shape_place
from ertel.inputs.quantities import Range, parse_quantity, plain_data, split
from ertel.physics.motion import Signal
from ertel.physics.registry import SHAPES
from ertel.physics.units import Unit

SWEEP = "sweep"
TEXT = "reference"  # of an oil: any text, and no range
MOST_RUNS = 10_000

Place = tuple[str | int, ...]  # of a value in a case: section, key, ... ; ("roughness", 0, "amplitude")


@dataclass(frozen=True)
class Sweep:
    """The section [sweep]: how the values of several axes go together."""

    mode: Literal["product", "zip"] = "product"


@dataclass(frozen=True)
class Axis:
    """One value that varies.  values: as they are written."""

    place: Place
    values: tuple[Any, ...]

    @property
    def field(self) -> str:
        """The value as messages and --set call it: contact.M."""
        return field_name(self.place)


@dataclass(frozen=True)
class Study:
    """The cases of a study, in the order of its axes: of a product the last axis varies fastest.

    data: the case with its first values, as plain data.  purpose: "convergence" for a `convergence_series`; the files
    with its numbers have this name.
    """

    name: str
    mode: str
    axes: tuple[Axis, ...]
    cases: tuple[Case, ...]
    data: Mapping[str, Any]
    purpose: Literal["sweep", "convergence"] = "sweep"


def load_study(path: str | Path, overrides: Sequence[str] = ()) -> Study:
    """The study in a TOML file, with overrides such as "contact.M=[100, 200]" applied.

    Raises ConfigError if the file cannot be read, or a case of it is not valid.
    """
    path = path_of("study", path, "a case file, or a mapping")
    return parse_study(case_data(path, overrides), path.parent)


def parse_study(data: Mapping[str, Any], folder: str | Path = ".") -> Study:
    """The study in plain data.

    folder: that in which files lie that the data name.  Raises ConfigError, naming the field, its value and what is
    allowed.

    Examples
    --------
    >>> study = parse_study({"contact": {"M": [100, 300], "L": 10}, "solver": {"method": "radial"}})
    >>> [case.contact.M for case in study.cases]
    [100.0, 300.0]
    """
    data = plain_data(data)
    mode = READER.record(Sweep, data.get(SWEEP, {}), SWEEP).mode
    plain = {key: value for key, value in data.items() if key != SWEEP}
    axes = tuple(_axes(plain))
    for axis in axes if mode == "product" else ():
        if len({_hashable(value) for value in axis.values}) < len(axis.values):
            raise ConfigError(f"{axis.field} = {show(list(axis.values))}: the values must differ from each other")
    if not axes:
        parse_case(plain, folder)  # a misspelled section or range is named first
        several = 'give a list, or a range such as "5:20:4", for the value that varies'
        raise ConfigError(f"the study has one case only: {several}")
    cases = tuple(_case(plain, axes, values, folder) for values in _combinations(axes, mode))
    for axis in axes:
        put(plain, axis.place, axis.values[0])
    return Study(cases[0].name or cases[0].kind, mode, axes, cases, plain)


# -- what varies ------------------------------------------------------------------------------------------------------


def _axes(data: Mapping[str, Any]) -> Iterator[Axis]:
    """The values of a case that vary, in the order of the file."""
    for name, table in data.items():
        if name == "roughness" and isinstance(table, list):
            for number, shape in enumerate(table):
                yield from _axes_in(shape, (name, number), data)
        elif name in SECTIONS:
            yield from _axes_in(table, (name,), data)


def _axes_in(table: Any, place: Place, data: Mapping[str, Any]) -> Iterator[Axis]:
    for key, value in table.items() if isinstance(table, Mapping) else ():
        here = (*place, key)
        if isinstance(value, list) and not (_has_points(here, data) and all(map(_is_point, value))):
            if not value:
                raise ConfigError(f"{field_name(here)} = []: must have one value or more")
            yield Axis(here, tuple(value))
        elif isinstance(value, str) and key != TEXT and all(split(end)[0] for end in value.partition(":")[::2]):
            with refusing(field_name(here), value):
                yield Axis(here, _values(Range.read(value)))
        else:
            yield from _axes_in(value, here, data)


def _has_points(place: Place, data: Mapping[str, Any]) -> bool:
    """Whether points may be the plain value of a key: those of a signal or a track."""
    options = key.options if (key := _key(place, data)) else ()
    return place[-1] == "smooth" or Signal in options or points_in(options) is not None


def _is_point(point: Any) -> bool:
    """Whether an item of a list is a point of one signal, [T, value], or of one track, [y, thickness]."""
    return isinstance(point, list) and not any(isinstance(part, list) for part in point)


def _hashable(value: Any) -> Any:
    """A key that is equal for equal values, so that a set finds it at once."""
    if isinstance(value, Mapping):
        return dict, frozenset((key, _hashable(item)) for key, item in value.items())
    if isinstance(value, list):
        return list, *map(_hashable, value)
    return value if isinstance(value, Hashable) else id(value)  # invalid: the check of the case reports it


def _values(given: Range) -> tuple[Any, ...]:
    """The values of a range, written like its ends."""
    unit, other = given.units
    if unit != other:
        raise ValueError("both ends must have the same unit")
    values = given.between(*map(float, given.ends))
    if unit:
        return tuple(f"{value!r} {unit}" for value in values)
    whole = all(end.lstrip("+-").isdecimal() for end in given.ends) and all(value.is_integer() for value in values)
    return tuple(map(int, values)) if whole else values


# -- the cases --------------------------------------------------------------------------------------------------------


def _combinations(axes: Sequence[Axis], mode: str) -> Iterator[tuple[Any, ...]]:
    """The values of each case, one of each axis."""
    numbers = {axis.field: len(axis.values) for axis in axes}
    if mode == "zip" and len(set(numbers.values())) > 1:
        lengths = ", ".join(f"{field} {number}" for field, number in numbers.items())
        raise ConfigError(f'{SWEEP}.mode = "zip": all must have equally many values; there are of {lengths}')
    runs = prod(numbers.values()) if mode == "product" else len(axes[0].values)
    if runs > MOST_RUNS:
        raise ConfigError(f"the study has {runs} cases; must be at most {MOST_RUNS}")
    lists = [axis.values for axis in axes]
    return product(*lists) if mode == "product" else zip(*lists, strict=True)


def _case(data: dict[str, Any], axes: Sequence[Axis], values: Sequence[Any], folder: str | Path) -> Case:
    """The case with these values, put into the data themselves: a copy for each would hold all values of all axes."""
    for axis, value in zip(axes, values, strict=True):
        put(data, axis.place, value)
    with in_the_case({axis.field: value for axis, value in zip(axes, values, strict=True)}):
        return parse_case(data, folder)


# -- a convergence series ----------------------------------------------------------------------------------------------

SERIES = ("grid", "time")  # what is refined
FEWEST_GRIDS, MOST_GRIDS = 3, 6  # an order needs three


def convergence_series(case: Case, grids: int = FEWEST_GRIDS, along: str = "grid") -> Study:
    """The study whose cases show the order of convergence of a case, coarsest first.

    grids: how many cases.  along: "grid", the last case has the grid of the given one, each the double spacing of the
    next, and in time the double steps; or "time", the steps alone.  The steps of the given case are those of the first:
    larger ones are not in the range where an order is seen.  Raises ConfigError, naming the argument or the field.
    """
    if along not in SERIES:
        raise ConfigError(f"along = {show(along)}: allowed: {', '.join(SERIES)}")
    if not isinstance(grids, int) or not FEWEST_GRIDS <= grids <= MOST_GRIDS:
        raise ConfigError(f"grids = {show(grids)}: must be a whole number from {FEWEST_GRIDS} to {MOST_GRIDS}")
    if along == "time" and case.time is None:
        raise ConfigError('along = "time": a steady contact has no time steps; use along = "grid"')
    cells, coarsening = case.solver.nodes - 1, 2 ** (grids - 1)
    if along == "grid" and (cells % coarsening or cells // coarsening + 1 < FEWEST_NODES):
        coarsest = max(cells // coarsening, FEWEST_NODES - 1)
        allowed = " or ".join(str(coarsening * each + 1) for each in (coarsest, coarsest + 1))
        none = f"has no {grids} grids of {FEWEST_NODES} nodes or more, each the half of the next"
        use = f"use solver.nodes = {allowed}, or another number of grids"
        raise ConfigError(f"solver.nodes = {cells + 1}: {none}; {use}")
    cases = [case] * grids
    for number in reversed(range(grids - 1)) if along == "grid" else ():
        cases[number] = cases[number + 1].on_half_grid()
    if case.time is not None:
        cases = [replace(each, time=case.time.with_steps(0.5**number)) for number, each in enumerate(cases)]
    tables = [each.to_data() for each in cases]
    axes = []
    for section_name, key in (("solver", "nodes"), ("time", "tolerance"), ("time", "step")):
        values = tuple((table.get(section_name) or {}).get(key) for table in tables)
        if len(set(values)) > 1:
            axes.append(Axis((section_name, key), values))
    return Study(case.name or case.kind, "zip", tuple(axes), tuple(cases), tables[0], "convergence")


# -- the coordinates of its numbers -----------------------------------------------------------------------------------

Coordinate = tuple[list[float] | list[str], dict[str, str]]  # values, and attributes: long_name, field, units


def coordinates(study: Study) -> dict[str, Coordinate]:
    """The values along each axis by its name: the last part of its key, more of it where two are alike.

    Anything else than a number, such as a law or the name of an oil, is a text.
    """
    short = [str(axis.place[-1]) for axis in study.axes]
    by_name = {}
    for axis, name in zip(study.axes, short, strict=True):
        whole = [str(part + 1) if isinstance(part, int) else part for part in axis.place]  # tables count from one
        unique = name if short.count(name) == 1 else "_".join(whole)
        by_name[unique] = _coordinate(axis, _key(axis.place, study.data))
    return by_name


def _coordinate(axis: Axis, key: Key | None) -> Coordinate:
    mark = key and key.mark
    about = {"long_name": key.meaning.text if key else str(axis.place[-1]), "field": axis.field}
    if all(isinstance(value, int | float) for value in axis.values):
        about |= {"units": "1"}
        if isinstance(mark, Unit) and mark.scale:
            about |= {"in_units_of": mark.own}
        return [float(value) for value in axis.values], about
    if isinstance(mark, Unit) and all(isinstance(value, str) for value in axis.values):
        with suppress(ValueError):  # an event in the place of a time
            return [parse_quantity(value, mark.in_si) for value in axis.values], {**about, "units": mark.unit}
    return [value if isinstance(value, str) else show(value) for value in axis.values], about


def _key(place: Place, data: Mapping[str, Any]) -> Key | None:
    """The key of a case file at a place; None where there is none."""
    name, *inner = place
    table = data[str(name)]
    if name == "roughness":
        table = table[inner.pop(0)]
        shape = table.get("shape")
        keys = shape_place(shape).keys if isinstance(shape, str) and shape in SHAPES else ()
    else:
        keys = section(str(name)).keys
    for part in inner[:-1]:
        table = table[part]
        keys = next((key.keys_in(table) for key in keys if key.name == part), ())
    return next((key for key in keys if key.name == inner[-1]), None)
