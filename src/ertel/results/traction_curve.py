"""A traction curve: the friction of a steady contact against the slide-to-roll ratio, the speed or the load."""

from collections.abc import Iterator
from dataclasses import dataclass
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any

import xarray as xr

from ertel.case.case import Case
from ertel.results.columns import column, with_units
from ertel.results.curve_points import AXES, SHOWN, SHOWN_WARM, shown_name
from ertel.results.report import aligned, html_image, html_row

if TYPE_CHECKING:  # matplotlib is imported when there is something to draw
    from matplotlib.figure import Figure

HEADS = {  # of a table, where names are long
    **{"mu_sliding": "mu", "mu_rolling": "mu_r", "power_loss": "loss"},
    **{"mu_isothermal": "mu_iso", "T_film_max": "T_film"},
}
WARM = (
    "mu, loss, films and stress include heat (inlet shear heating, flash temperature); mu_iso and mu_r are isothermal"
)


@dataclass(frozen=True, repr=False, eq=False)
class TractionCurve:
    """A traction curve.

    Parameters
    ----------
    case : Case
        The case with whose conditions the points were computed, apart from what varies.
    dataset : xarray.Dataset
        Over slide_to_roll, mean_speed (m/s) or load (N).  The traction coefficient of sliding mu_sliding, the rolling
        resistance mu_rolling of each surface, the power loss, the central and the minimum film thickness, the maximum
        shear stress in the middle of the film, the maximum pressure, status and work of each point; nan where the film
        did not converge.  In SI under SI names (h_c for H_c) where the case is physical.  With a section [thermal] all
        but mu_rolling and p_max is of the warm film; mu_isothermal is without heat, phi_T the inlet factor in h_c and
        h_min, T_1_max, T_2_max, T_film_max (K) the highest temperatures.
    said : tuple of str
        Warnings of the points, and which points they are about; `warnings` has those of the whole curve too.
    complete : bool
        Whether all points are computed.
    directory : Path, optional
        Where the curve is stored.
    """

    case: Case
    dataset: xr.Dataset
    said: tuple[str, ...] = ()
    complete: bool = True
    directory: Path | None = None

    @property
    def axis(self) -> str:
        """What varies: slide_to_roll, mean_speed or load."""
        return str(self.dataset.attrs["varies"])

    @property
    def failed(self) -> list[float]:
        """Where along the axis the film did not converge."""
        found: list[float] = self.dataset[self.axis].values[self.dataset["status"].values != "converged"].tolist()
        return found

    def plot(self) -> "Figure":
        """The curve: traction coefficient and rolling resistance, films, power loss and shear stress."""
        from ertel.plots import traction

        return traction.figure(self.dataset)

    def to_csv(self, path: str | Path) -> None:
        """Write the points as a CSV file; the names of its columns end with the unit, h_c_m, power_loss_W."""
        with_units(self.dataset).to_dataframe().to_csv(path)

    def as_data(self) -> dict[str, Any]:
        """The curve as plain data for JSON; names in SI end with the unit, and what is missing is None."""
        rows = with_units(self.dataset).to_dataframe().reset_index().to_dict("records")
        points = [{name: None if value != value else value for name, value in row.items()} for row in rows]
        about = {name: self.dataset.attrs[name] for name in ("title", "kind", "M", "L", "varies", "film")}
        return {**about, "points": points, "warnings": self.warnings, "complete": self.complete}

    def table(self) -> tuple[list[str], list[list[str]]]:
        """The heading and the rows of a table to read, with units that fit."""
        physical = self.case.scales is not None
        found = [column(AXES[self.axis].symbol, self.dataset[self.axis])]
        for name in SHOWN if self.case.thermal is None else (*SHOWN, *SHOWN_WARM):
            shown = shown_name(physical, name)
            found.append(column(HEADS.get(name, shown), self.dataset[shown]))
        if self.failed:
            found.append(["status", *self.dataset["status"].values.tolist()])
        heads, *rows = (list(cells) for cells in zip(*found, strict=True))
        return heads, rows

    def table_lines(self) -> Iterator[str]:
        """The same as lines of text."""
        heads, rows = self.table()
        yield from aligned(list(zip(heads, *rows, strict=True)))

    @property
    def remarks(self) -> list[str]:
        """What is to be said of the curve: how the film was computed, units, and warnings."""
        said = [f"film: {self.dataset.attrs['film']}"]
        if not self.case.scales:
            said.append("mu is in units a/R, films in a^2/R, stresses in p_h a/R: the case is dimensionless")
        if self.case.thermal:
            said.append(WARM)
        return [*said, *(f"warning: {warning}" for warning in self.warnings)]

    @property
    def warnings(self) -> list[str]:
        """Warnings about the oil, the grid and the domain, with the points that they are about."""
        return list(self.said)

    def __repr__(self) -> str:
        lines = (*self.table_lines(), *self.remarks)
        return "\n".join([f"TractionCurve: {self.heading}", *(f"  {line}" for line in lines)])

    @property
    def heading(self) -> str:
        """What the curve is of."""
        name = self.case.name or self.case.kind
        number = self.dataset.sizes[self.axis]
        ended = "" if self.complete else ", not complete"
        return f"{name}, {number} points over the {AXES[self.axis].long_name}{ended}"

    def _repr_html_(self) -> str:
        heads, rows = self.table()
        table = f"<table>{html_row('th', heads)}{''.join(html_row('td', cells) for cells in rows)}</table>"
        remarks = "".join(f"<div>{escape(line)}</div>" for line in self.remarks)
        picture = html_image(self.plot(), "traction curve") if rows else ""
        return f"<div><b>{escape(self.heading)}</b>{table}{remarks}</div>{picture}"
