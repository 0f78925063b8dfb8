"""The numbers of all runs of a study: as a Dataset over what varies, a table, a CSV file and a figure."""

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import xarray as xr

from ertel.results.numbers import SHOWN, Scalar
from ertel.results.report import aligned, column, html_image, html_row, largest_of, with_units
from ertel.results.variables import name_in_si
from ertel.version import installed_version

if TYPE_CHECKING:  # matplotlib is imported when there is something to draw
    from matplotlib.figure import Figure

MISSING = "missing"  # the status of a run that has not begun
RUNNING, UNFINISHED = "running", "unfinished"  # that a process computes, and that was killed
DONE, TO_DO = "converged", ("interrupted", RUNNING, UNFINISHED, MISSING)
MOST_ROWS = 100  # of a table to read


class StudyRun(NamedTuple):
    """One run of a study.

    numbers: by name, empty where there are none yet.  warnings: of the run.  status: as in the summary, or `MISSING`,
    `RUNNING`, `UNFINISHED`, or why it failed.  directory: relative to that of the study.
    """

    numbers: Mapping[str, Scalar]
    warnings: Sequence[str]
    status: str
    directory: str


def study_dataset(
    mode: str,
    shape: Sequence[int],
    coordinates: Mapping[str, tuple[Sequence[Any], Mapping[str, str]]],
    runs: Sequence[StudyRun],
    attributes: Mapping[str, Any],
) -> xr.Dataset:
    """The numbers of all runs over what varies.

    Parameters
    ----------
    mode : str
        "product": one dimension for each coordinate; "zip": one dimension, run, with all coordinates along it.
    shape : sequence of int
        The numbers of values along the dimensions.
    coordinates : mapping
        Name -> values and attributes.
    runs : sequence of StudyRun
        In C order of the shape.
    attributes : mapping
        Of the Dataset: title and kind at least.

    Returns
    -------
    xarray.Dataset
        The numbers of the runs, nan where a run has none; the number of warnings, status and directory of each run.
        A number with the name of a coordinate is left out.
    """
    dims = tuple(coordinates) if mode == "product" else ("run",)
    along = {key: ((key,) if mode == "product" else dims, _values(v), dict(a)) for key, (v, a) in coordinates.items()}
    found: dict[str, Any] = {}
    for number, run in enumerate(runs):
        for key, scalar in run.numbers.items():
            if key not in coordinates:
                if key not in found:
                    found[key] = dims, np.full(shape, np.nan), dict(scalar.attributes)
                found[key][1].flat[number] = scalar.value
    warnings = [len(run.warnings) for run in runs]
    found["warnings"] = dims, np.reshape(warnings, shape), {"long_name": "number of warnings of the run"}
    for key, texts, about in (
        ("status", [run.status for run in runs], "how the run ended"),
        ("directory", [run.directory for run in runs], "run directory"),
    ):
        found[key] = dims, np.array(texts, dtype=object).reshape(shape), {"long_name": about}
    date = datetime.now(UTC).isoformat(timespec="seconds")
    heading = {"source": f"ertel {installed_version()}", "date_created": date, "mode": mode}
    return xr.Dataset(found, along, {**heading, **attributes})


def _values(values: Sequence[Any]) -> Any:
    """Numbers as an array of them; texts as objects, which Zarr has a type for that lasts."""
    return np.array(values, dtype=object if isinstance(values[0], str) else float)


@dataclass(frozen=True, repr=False, eq=False)
class StudyResult:
    """The runs of a study.

    Parameters
    ----------
    dataset : xarray.Dataset
        Their numbers over what varies, see `study_dataset`.
    directory : Path, optional
        Of the study.
    """

    dataset: xr.Dataset
    directory: Path | None = None

    @property
    def heading(self) -> str:
        """The title of the table."""
        return str(self.dataset.attrs["title"])

    @property
    def failed(self) -> list[Any]:
        """The run directories, relative to that of the study, of runs that failed."""
        return [run["directory"] for run in self.rows() if run["status"] not in (DONE, *TO_DO)]

    @property
    def complete(self) -> bool:
        """True if every run was done, or failed."""
        return not any(run["status"] in TO_DO for run in self.rows())

    def rows(self) -> list[dict[str, Any]]:
        """The runs as plain data for JSON; names in SI end with the unit, and what is missing is None."""
        rows = _flat(with_units(self.dataset)).to_dataframe().to_dict("records")
        return [{str(name): None if value != value else value for name, value in row.items()} for row in rows]

    def as_data(self) -> dict[str, Any]:
        """The study as plain data for JSON."""
        return {"title": self.heading, "runs": self.rows()}

    def to_csv(self, path: str | Path) -> None:
        """Write the runs as a CSV file; the names of its columns end with the unit, h_c_m."""
        _flat(with_units(self.dataset)).to_dataframe().to_csv(path, index=False)

    def plot(self) -> "Figure":
        """The key numbers over what varies."""
        from ertel.plots import studies

        return studies.figure(self.dataset)

    def table(self) -> list[list[str]]:
        """The columns of a table to read, each with its heading first."""
        flat = _flat(self.dataset).isel(each=slice(MOST_ROWS))
        found = [column(str(name), flat[name]) for name in self.dataset.coords]
        numbers = dict.fromkeys(each for name in SHOWN for each in (name, name_in_si(name)) if each in flat)
        found += [column(name, flat[name]) for name in numbers if largest_of(flat[name]) > 0]
        found += [column("warnings", flat["warnings"])] if flat["warnings"].any() else []
        return [*found, column("status", flat["status"]), column("directory", flat["directory"])]

    @property
    def remarks(self) -> list[str]:
        """Lines below the table: how many runs there are, how they ended, and how many have warnings."""
        counts = Counter(str(status).partition(":")[0] for status in self.dataset["status"].values.flat)
        runs = sum(counts.values())
        said = f"{runs} runs: " + ", ".join(f"{number} {status}" for status, number in counts.most_common())
        warn = int((self.dataset["warnings"] > 0).sum())
        said += f"; {warn} with warnings" if warn else ""
        return [said, *([f"the first {MOST_ROWS} are shown"] if runs > MOST_ROWS else [])]

    def table_lines(self) -> Iterator[str]:
        """The table as lines of text."""
        yield from aligned(self.table())

    def __repr__(self) -> str:
        lines = (*self.table_lines(), *self.remarks)
        return "\n".join([f"{type(self).__name__}: {self.heading}", *(f"  {line}" for line in lines)])

    def _repr_html_(self) -> str:
        heads, *rows = (list(cells) for cells in zip(*self.table(), strict=True))
        table = f"<table>{html_row('th', heads)}{''.join(html_row('td', cells) for cells in rows)}</table>"
        remarks = "".join(f"<div>{escape(line)}</div>" for line in self.remarks)
        try:
            picture = html_image(self.plot(), self.heading)
        except ValueError:  # there is nothing to draw yet
            picture = ""
        return f"<div><b>{escape(self.heading)}</b>{table}{remarks}</div>{picture}"


def _flat(dataset: xr.Dataset) -> xr.Dataset:
    """The runs one after the other, with what varies before the numbers."""
    flat = dataset.stack(each=list(dataset.dims), create_index=False).reset_coords()
    first = [name for name in dataset.coords if name in flat]
    return flat[[*first, *(name for name in dataset.data_vars if name in flat)]]
