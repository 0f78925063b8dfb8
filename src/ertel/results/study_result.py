"""The numbers of all runs of a study: as a Dataset over what varies, a table, a CSV file and a figure.

A traction curve is a study: the friction of a steady contact against the slide-to-roll ratio, the speed or the load.
That of a physical case is in SI; that of a dimensionless case is in the units of the case, and its traction
coefficients are multiples of a/R, a number that such a case does not have.
"""

import re
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from html import escape
from math import isnan, nan
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, Unpack

import numpy as np
import xarray as xr

from ertel.case.case import Case
from ertel.results.convergence import ORDER, SEEN, Limit, limits_of
from ertel.results.dataset import largest_of, with_units
from ertel.results.numbers import SHOWN, Scalar, aligned, html_columns, html_image, shown_of
from ertel.results.variables import FILMS, in_celsius, name_in_si, prefixed, value_in_si, variable_attributes
from ertel.version import installed_version

if TYPE_CHECKING:  # matplotlib is imported when there is something to draw
    from matplotlib.figure import Figure

    from ertel.plots.drawing import SheetOptions

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

    numbers: Mapping[str, Scalar]
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
    heading = {"source": f"ertel {installed_version()}", "date_created": date, "mode": mode}
    return xr.Dataset(variables, along, {**heading, **attributes})


def grouped(warnings: Iterable[tuple[str, str]], other: str) -> list[str]:
    """Warnings with the places where they arise; of those that differ in their numbers only the first, with a count.

    other: where they arise, in the singular, "run".
    """
    alike: dict[str, list[str]] = {}
    for place, sentence in warnings:
        alike.setdefault(NUMBER.sub("#", sentence), []).append(f"{place}: {sentence}")

    def more(count: int) -> str:
        return f" (and {count} other {other}{'s' if count > 1 else ''})" if count else ""

    return [first + more(len(rest)) for first, *rest in alike.values()]


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
        return _flat(with_units(self.dataset)).to_dataframe()

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

    def table(self) -> list[list[str]]:
        """The columns of a table to read, each with its heading first."""
        flat = _flat(self.dataset).isel(each=slice(MOST_ROWS))
        columns = [column(str(name), flat[name]) for name in self.dataset.coords]
        numbers = dict.fromkeys(
            each for name in shown_of(SHOWN, flat) for each in (name, name_in_si(name)) if each in flat
        )
        columns += [column(name, flat[name]) for name in numbers if largest_of(flat[name]) > 0]
        names = ("warnings", "status", "directory") if flat["warnings"].any() else ("status", "directory")
        return columns + [column(name, flat[name]) for name in names]

    @property
    def remarks(self) -> list[str]:
        """Lines below the table: how many runs there are, how they ended, how many have warnings, and each of these."""
        counts = Counter(str(status).partition(":")[0] for status in self.dataset["status"].values.flat)
        runs = sum(counts.values())
        summary = f"{runs} runs: " + ", ".join(f"{number} {status}" for status, number in counts.most_common())
        warn = int((self.dataset["warnings"] > 0).sum())
        summary += f"; {warn} with warnings" if warn else ""
        shown = [f"the first {MOST_ROWS} are shown"] if runs > MOST_ROWS else []
        return [summary, *shown, *(f"warning: {each}" for each in self.warnings)]

    def __repr__(self) -> str:
        lines = (*aligned(self.table()), *self.remarks)
        return "\n".join([f"{type(self).__name__}: {self.heading}", *(f"  {line}" for line in lines)])

    def _repr_html_(self) -> str:
        table = html_columns(self.table())
        remarks = "".join(f"<div>{escape(line)}</div>" for line in self.remarks)
        picture = html_image(self.plot, self.heading)
        return f"<div><b>{escape(self.heading)}</b>{table}{remarks}</div>{picture}"


def _flat(dataset: xr.Dataset) -> xr.Dataset:
    """The runs one after the other, with what varies before the numbers."""
    flat = dataset.stack(each=list(dataset.dims), create_index=False).reset_coords()
    first = [name for name in dataset.coords if name in flat]
    return flat[[*first, *(name for name in dataset.data_vars if name in flat)]]


# -- columns -----------------------------------------------------------------------------------------------------------


def column(head: str, values: xr.DataArray) -> list[str]:
    """A heading with the unit, and the values in it, with a prefix that fits the largest; texts as they are."""
    if values.dtype.kind in "UOT":
        return [head, *(str(value) for value in values.values)]
    values, unit = in_celsius(values, values.attrs.get("units", "1"))
    one, name = prefixed(unit, largest_of(values))
    shown = ["-" if np.isnan(value) else f"{value:.4g}" for value in values.values / one]
    return [f"{head} ({name})" if name else head, *shown]


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
CURVE_WORK = ("newton_iterations", "krylov_iterations", "convolutions")
CURVE_SHOWN = {  # in a table, with a shorter heading where there is one
    "mu_sliding": "mu", "mu_rolling": "mu_r", "mu_1": "", "power_loss": "loss", "H_c": "", "H_min": "", "tau_max": "",
}  # fmt: skip
WARM_SHOWN = {"mu_isothermal": "mu_iso", "T_film_max": "T_film"}  # with a section [thermal]
CURVE_NUMBERS = (*CURVE_SHOWN, "mu_2", "mu_sliding_y", "P_max", *CURVE_WORK)
WARM_NUMBERS = (*WARM_SHOWN, "T_1_max", "T_2_max", "phi_T")
WARM = (
    "mu, loss, films and stress include heat (inlet shear heating, flash temperature); mu_iso and mu_r are isothermal"
)


def point_scalars(case: Case, values: Mapping[str, float]) -> dict[str, Scalar]:
    """The numbers of a point from dimensionless values by name; nan where there is none.

    Those of a physical case are in SI under SI names (h_c for H_c), by the scales of the point itself.
    """
    scalars = {}
    for name in CURVE_NUMBERS if case.thermal is None else (*CURVE_NUMBERS, *WARM_NUMBERS):
        value, attributes = values.get(name, nan), variable_attributes(name, case.scales)
        attributes["long_name"] += ", on the grid" * (name in FILMS)
        if "si_factor" in attributes:
            name, value, attributes = value_in_si(value, attributes)
        scalars[name] = Scalar(value, attributes)
    return scalars


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
        With a section [thermal] all but mu_rolling and p_max is of the warm film; mu_isothermal is without heat, phi_T
        the inlet factor in h_c and h_min, T_1_max, T_2_max, T_film_max (K) the highest temperatures.
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

    def table(self) -> list[list[str]]:
        """The columns of a table to read, each with its heading first, with units that fit."""
        along = self.dataset[self.axis]
        columns = [column(along.attrs["symbol"], along)]
        for name, head in (CURVE_SHOWN if self.case.thermal is None else CURVE_SHOWN | WARM_SHOWN).items():
            stored = name if name in self.dataset else name_in_si(name)
            columns.append(column(head or stored + " on the grid" * (name in FILMS), self.dataset[stored]))
        status = self.dataset["status"]
        return columns if (status == DONE).all() else [*columns, column("status", status)]

    @property
    def remarks(self) -> list[str]:
        """Lines below the table: how the film was computed, units, and warnings."""
        remarks = [f"film: {self.dataset.attrs['film']}"]
        if not self.case.scales:
            remarks.append("mu is in units a/R, films in a^2/R, stresses in p_h a/R: the case is dimensionless")
        if self.case.thermal:
            remarks.append(WARM)
        return [*remarks, *(f"warning: {warning}" for warning in self.warnings)]

    @property
    def heading(self) -> str:
        """The title of the table."""
        name = self.case.name or self.case.kind
        done = int((~self.dataset["status"].isin(TO_DO)).sum())
        ended = "" if self.complete else ", not complete"
        return f"{name}, {done} points over the {self.dataset[self.axis].attrs['long_name']}{ended}"
