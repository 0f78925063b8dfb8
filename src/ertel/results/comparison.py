"""Two runs side by side: where their cases differ, and how much their numbers do."""

from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

from ertel.case.case import Case
from ertel.results.scalars import Scalar, scalars

FREE = ("name", "reference")  # keys that change no result
MISSING = "-"


class Difference(NamedTuple):
    """A key of the cases that differs.  first, second: its values, None where it is not there."""

    field: str
    first: Any
    second: Any


class Pair(NamedTuple):
    """A number of both runs, with its name, what it is and its unit."""

    name: str
    first: float | None
    second: float | None
    attributes: Mapping[str, str]

    @property
    def change(self) -> float | None:
        """second/first - 1; None where one is not there or the first is zero."""
        if self.first is None or self.second is None or self.first == 0:
            return None
        return self.second / self.first - 1


def differences(first: Case, second: Case) -> list[Difference]:
    """The keys of two cases that differ, names and references apart."""
    one, two = (dict(_flat(case.to_data())) for case in (first, second))
    keys = [*one, *(key for key in two if key not in one)]
    return [Difference(key, one.get(key), two.get(key)) for key in keys if one.get(key) != two.get(key)]


def _flat(data: Any, place: str = "") -> Iterator[tuple[str, Any]]:
    """Every value with its place: contact.speed, roughness[1].amplitude."""
    if isinstance(data, Mapping):
        for key, value in data.items():
            if key not in FREE:
                yield from _flat(value, f"{place}.{key}".removeprefix("."))
    elif isinstance(data, list) and data and all(isinstance(item, Mapping) for item in data):
        for number, item in enumerate(data, 1):
            yield from _flat(item, f"{place}[{number}]")
    else:
        yield place, data


def pairs(first: tuple[Case, Mapping[str, Any]], second: tuple[Case, Mapping[str, Any]]) -> list[Pair]:
    """The numbers of two runs, each given by its case and its summary; in SI where both cases are."""
    in_si = first[0].scales is not None and second[0].scales is not None
    one, two = (scalars(summary, case.scales if in_si else None) for case, summary in (first, second))
    names = [*one, *(name for name in two if name not in one)]
    return [Pair(name, _value(one.get(name)), _value(two.get(name)), _about(one, two, name)) for name in names]


def _value(scalar: Scalar | None) -> float | None:
    return None if scalar is None else scalar.value


def _about(one: Mapping[str, Scalar], two: Mapping[str, Scalar], name: str) -> Mapping[str, str]:
    return (one.get(name) or two[name]).attributes
