"""The result of a study, as users hold it: a Dataset over what varies, a table, a CSV file and a figure.

A traction curve is a study: the friction of a steady contact against the slide-to-roll ratio, the speed or the load.
That of a physical case is in SI; that of a dimensionless case is in the units of the case, and its traction
coefficients are multiples of a/R, a number that such a case does not have.
"""

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, replace
from html import escape
from math import isnan
from pathlib import Path
from typing import TYPE_CHECKING, Any, Unpack

import xarray as xr

from ertel.case.case import Case
from ertel.results.alignment import Comparison
from ertel.results.convergence import ORDER, SEEN, Limit, limits_of
from ertel.results.dataset import with_units
from ertel.results.measurements import Measurement
from ertel.results.numbers import Number, aligned, html_columns, html_image, number
from ertel.results.study_table import DONE, MOST_ROWS, TO_DO, counted, flat, table_columns
from ertel.results.variables import THICKNESS, names_where, prefixed

if TYPE_CHECKING:  # matplotlib is imported when there is something to draw
    from matplotlib.figure import Figure

    from ertel.plots.drawing import SheetOptions


@dataclass(frozen=True, repr=False, eq=False)
class StudyResult:
    """The runs of a study.

    Parameters
    ----------
    dataset : xarray.Dataset
        Their numbers over what varies, see `results.study_table.study_dataset`.
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
    def warnings(self) -> list[str]:
        """The warnings, with the runs that they are about."""
        return list(self.dataset.attrs.get("warnings", []))

    @property
    def failed(self) -> list[Any]:
        """The run directories, relative to that of the study, of runs that failed."""
        return self._of_failed("directory")

    def _of_failed(self, name: str) -> list[Any]:
        ended = ~self.dataset["status"].isin([DONE, *TO_DO])
        return self.dataset[name].values[ended].tolist()

    @property
    def complete(self) -> bool:
        """True if every run was done, or failed."""
        return not self.dataset["status"].isin(TO_DO).any()

    def rows(self) -> list[dict[str, Any]]:
        """The runs as plain data for JSON; names in SI end with the unit, and what is missing is None."""
        rows = self._frame().to_dict("records")
        return [{str(name): None if value != value else value for name, value in row.items()} for row in rows]

    def _frame(self) -> Any:
        """The runs as a table, a row each."""
        return flat(with_units(self.dataset)).to_dataframe()

    def as_data(self) -> dict[str, Any]:
        """The study as plain data for JSON."""
        return {"title": self.heading, "runs": self.rows(), "warnings": self.warnings}

    def to_csv(self, path: str | Path) -> None:
        """Write the runs as a CSV file; the names of its columns end with the unit, h_c_m."""
        self._frame().to_csv(path, index=False)

    def plot(self, **sheet: "Unpack[SheetOptions]") -> "Figure":
        """The key numbers over what varies; of a traction curve friction, films, power loss and shear stress.

        Of a convergence series the distances from the limits; of a fit data, fitted curves and residuals.

        sheet: ax, figsize, columns, title, see `ertel.plots.Sheet`.
        """
        from ertel.plots import studies

        return studies.figure(self.dataset, **sheet)

    def compare(self, measurement: Measurement) -> Comparison:
        """The runs beside a measured curve, over what varies; see `Measurement`, kind "curve"."""
        if not isinstance(measurement, Measurement) or measurement.kind != "curve":
            raise TypeError(f"measurement = {measurement!r}: must be a Measurement of the kind curve")
        return measurement.compared(self)

    def table(self) -> list[list[str]]:
        """The columns of a table to read, each with its heading first."""
        return table_columns(self.dataset)

    @property
    def remarks(self) -> list[str]:
        """Lines below the table: how many runs there are, how they ended, how many have warnings, and each of these."""
        counts = Counter(str(status).partition(":")[0] for status in self.dataset["status"].values.flat)
        runs = sum(counts.values())
        ended = ", ".join(f"{number} {status}" for status, number in counts.most_common())
        summary = f"{counted(runs, 'run')}: {ended}"
        warn = int((self.dataset["warnings"] > 0).sum())
        summary += f"; {warn} with warnings" if warn else ""
        shown = [f"the first {MOST_ROWS} are shown"] if runs > MOST_ROWS else []
        return [summary, *shown, *(f"warning: {each}" for each in self.warnings)]

    def __repr__(self) -> str:
        lines = (*aligned(self.table()), *self.remarks)
        return "\n".join([f"{type(self).__name__}: {self.heading}", *(f"  {line}" for line in lines)])

    @property
    def html(self) -> str:
        """The heading, the table and the remarks in HTML."""
        remarks = "".join(f"<div>{escape(line)}</div>" for line in self.remarks)
        return f"<div><b>{escape(self.heading)}</b>{html_columns(self.table())}{remarks}</div>"

    def _repr_html_(self) -> str:
        return self.html + html_image(self.plot, self.heading)


# -- convergence series -----------------------------------------------------------------------------------------------

EXPLAINED = (
    "second order is assumed; where it is not seen the value is that of the finest grid, and the error the largest "
    "difference between grids, thrice where they do not fall; faster: the error that the grid before lets expect"
)


@dataclass(frozen=True, repr=False, eq=False)
class ConvergenceResult(StudyResult):
    """A convergence series: the numbers of a case on several grids, coarsest first, and their limits."""

    @property
    def limits(self) -> dict[str, Limit]:
        """Observed order, extrapolated value, its error and whether second order is seen, by number, SI where it is."""
        return limits_of(self.dataset)

    def as_data(self) -> dict[str, Any]:
        """The series as plain data for JSON."""
        limits = {name: each._asdict() for name, each in self.limits.items()}
        for each in limits.values():
            each["order"] = None if isnan(each["order"]) else each["order"]
        return {**super().as_data(), "assumed_order": ORDER, "limits": limits}

    def table(self) -> list[list[str]]:
        """The columns of a table to read: a row for each number, a column for each grid, then the limit."""
        axes = self.dataset.coords.values()
        rows = [[str(axis.name), *(f"{each:.4g}" for each in axis.values), *[""] * 4] for axis in axes]
        rows[0][-4:] = ["order", "second order", "value", "error"]
        for name, one in self.limits.items():
            variable = self.dataset[name]
            scale, unit = prefixed(variable.attrs["units"], one.value)
            *shown, last = [f"{value / scale:.5g}" for value in (*variable.values, one.value)]
            order = "-" if isnan(one.order) else f"{one.order:.2f}"
            seen = "seen" if one.seen else "faster" if one.order > SEEN[1] else "not seen"
            rows.append([f"{name} ({unit})" if unit else name, *shown, order, seen, last, f"{one.error / scale:.2g}"])
        return [list(column) for column in zip(*rows, strict=True)]

    @property
    def remarks(self) -> list[str]:
        """Lines below the table: what the errors are, then those of a study."""
        return [EXPLAINED, *super().remarks]


# -- traction curves --------------------------------------------------------------------------------------------------


CURVE_AXES = {  # fields of [contact] that vary along a curve, with the attributes of its coordinate
    "slide_to_roll": {"long_name": "slide-to-roll ratio", "symbol": "S", "units": "1"},
    "mean_speed": {"long_name": "mean speed", "symbol": "u_m", "units": "m/s"},
    "load": {"long_name": "load", "symbol": "F", "units": "N"},
}
WARM = "numbers with _warm have the heat of the inlet and of the contact; all others are isothermal"


def point_numbers(case: Case, values: Mapping[str, float]) -> dict[str, Number]:
    """The numbers of a point from dimensionless values by name; in SI under SI names where the case is physical."""
    found = {}
    there = names_where(lambda variable: not (case.geometry.is_line and variable.is_across))
    for name in (name for name in there if name in values):
        one = number(case.kind, case.scales, name, values[name]).in_si
        about = replace(one.about, long_name=one.about.long_name + ", on the grid" * (one.about.panel == THICKNESS))
        found[one.name] = one._replace(about=about)
    return found


@dataclass(frozen=True, repr=False, eq=False, kw_only=True)
class TractionCurve(StudyResult):
    """A traction curve.

    Parameters
    ----------
    case : Case
        The case with whose conditions the points were computed, apart from what varies.
    dataset : xarray.Dataset
        Over slide_to_roll, mean_speed (m/s) or load (N).  The traction coefficient of sliding mu_sliding, the rolling
        resistance mu_rolling of each surface, the power loss, the central and the minimum film thickness (on the grid,
        not extrapolated), the maximum shear stress in the middle of the film, the maximum pressure, status and work of
        each point; nan where the film did not converge.  In SI under SI names (h_c for H_c) where the case is physical.
        With a section [thermal] T_1_max, T_2_max and T_film_max (K), the highest temperatures.  With a formula of the
        inlet the others are without heat, and those with heat beside them: mu_sliding_warm, h_c_warm, ..., phi_T.
    directory : Path, optional
        Where the curve is stored.
    """

    case: Case

    @property
    def axis(self) -> str:
        """The quantity that varies: slide_to_roll, mean_speed or load."""
        return str(self.dataset.attrs["varies"])

    @property
    def failed(self) -> list[float]:
        """The values at which the film did not converge."""
        return self._of_failed(self.axis)

    def as_data(self) -> dict[str, Any]:
        """The curve as plain data for JSON; names in SI end with the unit, and what is missing is None."""
        about = {name: self.dataset.attrs[name] for name in ("title", "kind", "M", "L", "varies", "film")}
        return {**about, "points": self.rows(), "warnings": self.warnings, "complete": self.complete}

    @property
    def remarks(self) -> list[str]:
        """Lines below the table: how the film was computed, units, and warnings."""
        remarks = [f"film: {self.dataset.attrs['film']}"]
        if not self.case.scales:
            remarks.append(
                "coefficients are in units a/R, films in a^2/R, stresses in p_h a/R: the case is dimensionless"
            )
        if self.case.thermal and not self.case.thermal.is_solved:
            remarks.append(WARM)
        return [*remarks, *(f"warning: {warning}" for warning in self.warnings)]

    @property
    def heading(self) -> str:
        """The title of the table."""
        name = self.case.name or self.case.kind
        done = int((~self.dataset["status"].isin(TO_DO)).sum())
        ended = "" if self.complete else ", not complete"
        return f"{name}, {done} points over the {self.dataset[self.axis].attrs['long_name']}{ended}"
