"""The numbers of all runs of a study as a Dataset over what varies, and the columns of its table."""

import re
from collections.abc import Iterable, Mapping, Sequence
from datetime import UTC, datetime
from math import nan
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from ertel.results.dataset import largest_of
from ertel.results.numbers import Number
from ertel.results.variables import in_celsius, prefixed, stored_in
from ertel.version import installed_version

MISSING = "missing"  # the status of a run that has not begun
RUNNING, UNFINISHED = "running", "unfinished"  # that a process computes, and that was killed
DONE, TO_DO = "converged", ("interrupted", RUNNING, UNFINISHED, MISSING)
NUMBER = re.compile(r"(?<!surface )\b\d[\d.]*(e[+-]?\d+)?")  # in a warning, but not that of a surface
MOST_ROWS = 100  # of a table to read


class StudyRun(NamedTuple):
    """One run of a study.

    numbers: by name, empty where there are none yet.  warnings: of the run.  status: as in the summary, or `MISSING`,
    `RUNNING`, `UNFINISHED`, or why it failed.  directory: relative to that of the study.
    """

    numbers: Mapping[str, Number]
    warnings: Sequence[str]
    status: str
    directory: str


def study_dataset(
    mode: str,
    coordinates: Mapping[str, tuple[Sequence[Any], Mapping[str, str]]],
    runs: Sequence[StudyRun],
    attributes: Mapping[str, Any],
) -> xr.Dataset:
    """The numbers of all runs over what varies.

    mode: "product", one dimension for each coordinate, or "zip", one dimension, run, with all coordinates along it.
    coordinates: name -> values and attributes.  runs: in C order of the dimensions.  attributes: title and kind at
    least.  The numbers are nan where a run has none, with the number of warnings, status and directory of each run; a
    number with the name of a coordinate is left out.
    """
    product = mode == "product"
    dims = tuple(coordinates) if product else ("run",)
    shape = [len(coordinates[name][0]) for name in dims] if product else [len(runs)]
    along = {key: ((key,) if product else dims, _values(v), dict(a)) for key, (v, a) in coordinates.items()}
    variables: dict[str, Any] = {}
    for key in dict.fromkeys(key for run in runs for key in run.numbers if key not in coordinates):
        known = [run.numbers.get(key) for run in runs]
        found = [nan if number is None else number.value for number in known]
        variables[key] = dims, np.reshape(found, shape), dict(next(filter(None, known)).attributes)
    for key, values, about in (
        ("warnings", [len(run.warnings) for run in runs], "number of warnings of the run"),
        ("status", _values([run.status for run in runs]), "how the run ended"),
        ("directory", _values([run.directory for run in runs]), "run directory"),
    ):
        variables[key] = dims, np.reshape(values, shape), {"long_name": about}
    date = datetime.now(UTC).isoformat(timespec="seconds")
    made = {"source": f"ertel {installed_version()}", "date_created": date}
    heading = {**made, "mode": mode, "over": ", ".join(coordinates)}
    return xr.Dataset(variables, along, {**heading, **attributes})


def grouped(warnings: Iterable[tuple[str, str]], other: str) -> list[str]:
    """Warnings with the places where they arise; of those that differ in their numbers only the first, with a count.

    other: where they arise, in the singular, "run".
    """
    alike: dict[str, list[str]] = {}
    for place, sentence in warnings:
        alike.setdefault(NUMBER.sub("#", sentence), []).append(f"{place}: {sentence}")

    def more(count: int) -> str:
        return f" (and {counted(count, f'other {other}')})" if count else ""

    return [first + more(len(rest)) for first, *rest in alike.values()]


def counted(number: int, name: str) -> str:
    """A number of things with their name: 1 run, 2 runs."""
    return f"{number} {name}" if number == 1 else f"{number} {name}s"


def _values(values: Sequence[Any]) -> Any:
    """Numbers as an array of them; texts as objects, which Zarr has a type for that lasts."""
    return np.array(values, dtype=object if isinstance(values[0], str) else float)


def flat(dataset: xr.Dataset) -> xr.Dataset:
    """The runs one after the other, with what varies before the numbers."""
    one = dataset.stack(each=list(dataset.dims), create_index=False).reset_coords()
    first = [name for name in dataset.coords if name in one]
    return one[[*first, *(name for name in dataset.data_vars if name in one)]]


def table_columns(dataset: xr.Dataset) -> list[list[str]]:
    """The columns of a table to read, each with its heading first: what varies, the numbers that are shown, status."""
    runs = flat(dataset).isel(each=slice(MOST_ROWS))
    numbers = [name for name in stored_in(runs, lambda variable: variable.shown) if largest_of(runs[name]) > 0]
    about = ("warnings", "status", "directory") if runs["warnings"].any() else ("status", "directory")
    return [_column(str(name), runs[name]) for name in (*dataset.coords, *numbers, *about)]


def _column(head: str, values: xr.DataArray) -> list[str]:
    """A heading with the unit, and the values in it, with a prefix that fits the largest; texts as they are."""
    if values.dtype.kind in "UOT":
        return [head, *(str(value) for value in values.values)]
    values, unit = in_celsius(values, values.attrs.get("units", "1"))
    one, name = prefixed(unit, largest_of(values))
    shown = ["-" if np.isnan(value) else f"{value:.4g}" for value in values.values / one]
    return [f"{head} ({name})" if name else head, *shown]
