"""What a study found: the numbers of all its runs as a Dataset, a table, a CSV file and a figure."""

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any

import xarray as xr

from ertel.results.columns import column, with_units
from ertel.results.curve_points import largest_of
from ertel.results.numbers import SHOWN
from ertel.results.report import aligned, html_image, html_row
from ertel.results.study_runs import MISSING, RUNNING, UNFINISHED
from ertel.results.variables import name_in_si

if TYPE_CHECKING:  # matplotlib is imported when there is something to draw
    from matplotlib.figure import Figure

MOST_ROWS = 100  # of a table to read
DONE, TO_DO = "converged", ("interrupted", RUNNING, UNFINISHED, MISSING)


@dataclass(frozen=True, repr=False, eq=False)
class StudyResult:
    """The runs of a study.

    Parameters
    ----------
    dataset : xarray.Dataset
        The numbers of the runs over what varies.
    directory : Path, optional
        The directory of the study.
    """

    dataset: xr.Dataset
    directory: Path | None = None

    @property
    def failed(self) -> list[str]:
        """The run directories, relative to that of the study, of runs that failed."""
        return [run["directory"] for run in self.rows() if run["status"] not in (DONE, *TO_DO)]

    @property
    def complete(self) -> bool:
        """Whether every run was done, or failed."""
        return not any(run["status"] in TO_DO for run in self.rows())

    def rows(self) -> list[dict[str, Any]]:
        """The runs as plain data for JSON; names in SI end with the unit, and what is missing is None."""
        rows = self._flat(with_units(self.dataset)).to_dataframe().to_dict("records")
        return [{str(name): None if value != value else value for name, value in row.items()} for row in rows]

    def to_csv(self, path: str | Path) -> None:
        """Write the runs as a CSV file; the names of its columns end with the unit, h_c_m."""
        self._flat(with_units(self.dataset)).to_dataframe().to_csv(path, index=False)

    def plot(self) -> "Figure":
        """The key numbers over what varies."""
        from ertel.plots import studies

        return studies.figure(self.dataset)

    @staticmethod
    def _flat(dataset: xr.Dataset) -> xr.Dataset:
        """The runs one after the other, with what varies before the numbers."""
        flat = dataset.stack(each=list(dataset.dims), create_index=False).reset_coords()
        first = [name for name in dataset.coords if name in flat]
        return flat[[*first, *(name for name in dataset.data_vars if name in flat)]]

    def table(self) -> list[list[str]]:
        """The columns of a table to read, each with its heading first."""
        flat = self._flat(self.dataset).isel(each=slice(MOST_ROWS))
        found = [column(str(name), flat[name]) for name in self.dataset.coords]
        numbers = dict.fromkeys(each for name in SHOWN for each in (name, name_in_si(name)) if each in flat)
        found += [column(name, flat[name]) for name in numbers if largest_of(flat[name]) > 0]
        found += [column("warnings", flat["warnings"])] if flat["warnings"].any() else []
        return [*found, column("status", flat["status"]), column("directory", flat["directory"])]

    @property
    def remarks(self) -> list[str]:
        """What is to be said of the study: how many runs there are, how they ended, and how many have warnings."""
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
        return "\n".join([f"StudyResult: {self.dataset.attrs['title']}", *(f"  {line}" for line in lines)])

    def _repr_html_(self) -> str:
        heads, *rows = (list(cells) for cells in zip(*self.table(), strict=True))
        table = f"<table>{html_row('th', heads)}{''.join(html_row('td', cells) for cells in rows)}</table>"
        remarks = "".join(f"<div>{escape(line)}</div>" for line in self.remarks)
        return f"<div><b>{escape(self.dataset.attrs['title'])}</b>{table}{remarks}</div>{self._picture()}"

    def _picture(self) -> str:
        """The figure as an HTML image; empty where there is nothing to draw yet."""
        try:
            return html_image(self.plot(), "study")
        except ValueError:
            return ""
