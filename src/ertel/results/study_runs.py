"""The runs of a study as one Dataset over what varies."""

from collections.abc import Mapping, Sequence
from datetime import UTC, datetime
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from ertel.case.case import Case
from ertel.results.numbers import scalars
from ertel.version import installed_version

MISSING = "missing"  # the status of a run that has not begun
RUNNING, UNFINISHED = "running", "unfinished"  # that a process is at, and that was killed


class StudyRun(NamedTuple):
    """One run of a study.

    summary: None where there is none yet.  status: as in the summary, or `MISSING`, `RUNNING`, `UNFINISHED`, or why it
    failed.  directory: relative to that of the study.
    """

    case: Case
    summary: Mapping[str, Any] | None
    status: str
    directory: str


def assemble(
    name: str,
    mode: str,
    shape: Sequence[int],
    coordinates: Mapping[str, tuple[Sequence[Any], Mapping[str, str]]],
    runs: Sequence[StudyRun],
) -> xr.Dataset:
    """The numbers of all runs over what varies.

    Parameters
    ----------
    name : str
        Of the study.
    mode : str
        "product": one dimension for each coordinate; "zip": one dimension, run, with all coordinates along it.
    shape : sequence of int
        The numbers of values along the dimensions.
    coordinates : mapping
        Name -> values and attributes.
    runs : sequence of StudyRun
        In C order of the shape.

    Returns
    -------
    xarray.Dataset
        The `scalars` of the runs, nan where a run has none; the number of warnings, status and directory of each run.
        A number with the name of a coordinate is left out.
    """
    dims = tuple(coordinates) if mode == "product" else ("run",)
    along = {key: ((key,) if mode == "product" else dims, _values(v), dict(a)) for key, (v, a) in coordinates.items()}
    found: dict[str, Any] = {}
    for number, run in enumerate(runs):
        for key, scalar in (scalars(run.summary) if run.summary else {}).items():
            if key not in coordinates:
                if key not in found:
                    found[key] = dims, np.full(shape, np.nan), dict(scalar.attributes)
                found[key][1].flat[number] = scalar.value
    warnings = [len((run.summary or {}).get("warnings", ())) for run in runs]
    found["warnings"] = dims, np.reshape(warnings, shape), {"long_name": "number of warnings of the run"}
    for key, texts, about in (
        ("status", [run.status for run in runs], "how the run ended"),
        ("directory", [run.directory for run in runs], "run directory"),
    ):
        found[key] = dims, np.array(texts, dtype=object).reshape(shape), {"long_name": about}
    attributes = {
        "title": name,
        "source": f"ertel {installed_version()}",
        "date_created": datetime.now(UTC).isoformat(timespec="seconds"),
        "kind": runs[0].case.kind,
        "mode": mode,
    }
    return xr.Dataset(found, along, attributes)


def _values(values: Sequence[Any]) -> Any:
    """Numbers as an array of them; texts as objects, which Zarr has a type for that lasts."""
    return np.array(values, dtype=object if isinstance(values[0], str) else float)
