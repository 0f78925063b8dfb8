"""The outcome of a run as text and as HTML for a notebook.  Imports neither JAX nor xarray."""

from base64 import b64encode
from collections.abc import Iterator, Sequence
from html import escape
from io import BytesIO
from typing import TYPE_CHECKING

import numpy as np

from ertel.physics.temperature_laws import ZERO_CELSIUS
from ertel.results.numbers import Outcome, key_numbers, moment, number, numbers, scales_in
from ertel.results.variables import PREFIXES, exponent, with_prefix

if TYPE_CHECKING:  # they are imported when there is something to draw or to read
    import xarray as xr
    from matplotlib.figure import Figure

HEAD = ("quantity", "symbol", "value", "in SI", "error")
DOTS_PER_INCH = 80  # of a picture in a notebook


def lines(summary: Outcome) -> Iterator[str]:
    """A summary in a few lines of text, indented."""
    yield f"  {_conditions(summary)}"
    yield f"  {moment(summary)}"
    shown = key_numbers(summary)
    wide = max((len(n.long_name) + len(n.symbol) for n in shown), default=0)
    for n in shown:
        name = f"{n.long_name} {n.symbol}".ljust(wide + 1)
        error = f", error {n.text_of_error}" if n.text_of_error else ""
        yield f"    {name}  {n.full_text}{error}"
    yield from (f"  {line}" for line in more_lines(summary))
    for warning in summary["warnings"]:
        yield f"  warning: {warning}"


def _conditions(summary: Outcome) -> str:
    return f"{summary['kind']} ({summary['method']}), M = {summary['M']:.4g}, L = {summary['L']:.4g}"


def more_lines(summary: Outcome) -> Iterator[str]:
    """The rest of a summary, besides its key numbers, a line each: extremes, temperatures, balances."""
    yield from extreme_lines(summary)
    yield from thermal_lines(summary)
    yield from balance_lines(summary)


def extreme_lines(summary: Outcome) -> Iterator[str]:
    """The extremes of a run in time, one a line: value, time, place, and a note on the value."""
    table, scales = numbers(summary), scales_in(summary)
    for name, one in summary.get("extremes", {}).items():
        extreme = table[f"{name}_extreme"]
        T, X, Y = (number(summary["kind"], scales, key, one[key]) for key in ("T", "X", "Y"))
        if scales:
            where = f"t = {T.text_in_si} (T = {T.value:.4g}), x = {X.text_in_si}, y = {Y.text_in_si}"
        else:
            where = f"T = {T.text}, X = {X.value:.3g}, Y = {Y.value:.3g} {Y.unit}"
        note = f"; {one['note']}" if one["note"] else ""
        yield f"{extreme.long_name} {name}: {extreme.full_text} at {where}{note}"


def thermal_lines(summary: Outcome) -> Iterator[str]:
    """Film, traction and temperatures with the heat of the contact, a line each; none without a section [thermal]."""
    thermal = summary.get("thermal")
    if not thermal:
        return
    films = f"central {with_prefix(thermal['h_c_m'], 'm')}, minimum {with_prefix(thermal['h_min_m'], 'm')}"
    yield f"film with inlet shear heating: {films} (phi_T = {thermal['phi_T']:.4g}, L_t = {thermal['L_t']:.3g})"
    yield f"traction coefficient of the warm film: {thermal['mu_sliding']:.4g}"
    names = ("T_1_max", "T_2_max", "T_film_max", "T_film_mean")
    surface_1, surface_2, film, mean = (f"{thermal[f'{name}_K'] - ZERO_CELSIUS:.1f} degC" for name in names)
    yield f"highest temperatures: surface 1 {surface_1}, surface 2 {surface_2}, film {film}; mean of the film {mean}"


def balance_lines(summary: Outcome) -> Iterator[str]:
    """The imbalance of every balance, in one line; none where there are none yet."""
    imbalances = {name: terms["imbalance"] for name, terms in summary.get("budgets", {}).items()}
    shown = ", ".join(f"{name} {share:.2%}" for name, share in imbalances.items() if share is not None)
    if shown:
        yield f"imbalance: {shown}"


def html_table(summary: Outcome, heading: str = "") -> str:
    """The key numbers as an HTML table with the columns that are known, and the warnings below."""
    parts = [f"{heading}{escape(_conditions(summary))}: {escape(summary['status'])}; {escape(moment(summary))}"]
    rows = [(n.long_name, n.symbol, n.text, n.text_in_si, n.text_of_error) for n in key_numbers(summary)]
    columns = [column for column in zip(HEAD, *rows, strict=True) if any(column[1:])]
    if columns:
        head, *body = zip(*columns, strict=True)
        parts.append(f"<table>{html_row('th', head)}{''.join(html_row('td', cells) for cells in body)}</table>")
    parts += [f"<div>{escape(line)}</div>" for line in more_lines(summary)]
    parts += [f"<div>Warning: {escape(warning)}</div>" for warning in summary["warnings"]]
    return f"<div>{''.join(parts)}</div>"


# -- parts ------------------------------------------------------------------------------------------------------------


def aligned(columns: Sequence[Sequence[str]], left: int = 0) -> Iterator[str]:
    """Columns side by side as lines; the first `left` of them begin at the left, the others end at the right."""
    widths = [max(map(len, column)) for column in columns]
    for cells in zip(*columns, strict=True):
        padded = [
            cell.ljust(width) if position < left else cell.rjust(width)
            for position, (cell, width) in enumerate(zip(cells, widths, strict=True))
        ]
        yield "  ".join(padded).rstrip()


def html_row(tag: str, cells: Sequence[str]) -> str:
    """A row of an HTML table.  tag: "td", or "th" for a heading."""
    return f"<tr>{''.join(f'<{tag}>{escape(cell)}</{tag}>' for cell in cells)}</tr>"


def html_image(figure: "Figure", name: str) -> str:
    """A figure as an image that the page contains."""
    png = BytesIO()
    figure.savefig(png, format="png", dpi=DOTS_PER_INCH)
    return f'<img alt="{escape(name)}" src="data:image/png;base64,{b64encode(png.getvalue()).decode()}">'


# -- columns of Datasets ----------------------------------------------------------------------------------------------


def with_units(dataset: "xr.Dataset") -> "xr.Dataset":
    """The dataset with the unit at the end of every name in SI: h_c_m, mean_speed_m_per_s."""
    units = {str(name): str(v.attrs.get("units", "1")) for name, v in dataset.variables.items()}
    spelled = {name: unit.replace("/", "_per_").replace("*", "_") for name, unit in units.items() if unit != "1"}
    return dataset.rename({name: f"{name}_{unit}" for name, unit in spelled.items()})


def column(head: str, values: "xr.DataArray") -> list[str]:
    """A heading with the unit, and the values in it, with a prefix that fits the largest; texts as they are."""
    if values.dtype.kind in "UOT":
        return [head, *(str(value) for value in values.values)]
    unit = values.attrs.get("units", "1")
    power = 0 if "/" in unit or unit in ("1", "K", "Pa*s") else exponent(largest_of(values))
    shown = ["-" if np.isnan(value) else f"{value:.4g}" for value in values.values / 10**power]
    return [head if unit == "1" else f"{head} ({PREFIXES[power]}{unit})", *shown]


def largest_of(values: "xr.DataArray") -> float:
    """The largest size of the values that are there."""
    return float(np.abs(np.nan_to_num(values.values)).max(initial=0.0))
