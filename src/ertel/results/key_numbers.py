"""The key numbers of a summary, as text and as a table in a notebook.  Imports neither JAX nor xarray."""

from collections.abc import Iterator, Mapping
from html import escape
from typing import Any, NamedTuple

from ertel.results.kinds import KINDS, Errors, Kind
from ertel.results.variables import VARIABLES, with_prefix

KEY = ("H_c", "H_min", "P_max")
HEAD = ("quantity", "symbol", "value", "in SI", "error")


class Number(NamedTuple):
    """A key number as text; si and error are empty if they are not known."""

    label: str
    symbol: str
    value: str
    si: str = ""
    error: str = ""


class Summary(dict[str, Any]):
    """A summary: a plain dict with all results; its text shows only the key numbers."""

    def __repr__(self) -> str:
        return "\n".join([f"Summary: {self['status']}", *lines(self)])

    def _repr_html_(self) -> str:
        return html_table(self)


def key_numbers(summary: Mapping[str, Any]) -> list[Number]:
    """Film thickness, maximum pressure and restitution of a run, of an impact at maximum approach; empty without them.

    summary : as `results.summary` and `summary.json` have it.
    """
    kind = KINDS[summary["kind"]]
    values, si, errors = kind.values(summary), kind.values_in_si(summary), kind.errors(summary)
    if not values:
        return []
    numbers = [_number(name, values[name], kind, si, errors) for name in KEY]
    if summary.get("restitution") is not None:
        numbers.append(Number("coefficient of restitution", "e", f"{summary['restitution']:.4f}"))
    return numbers


def _number(name: str, value: float, kind: Kind, si: Mapping[str, float], errors: Errors) -> Number:
    variable = VARIABLES[name]
    in_si = si.get(f"{variable.si_name}_{variable.si_units}")
    error, _ = errors.get(name, (None, None))
    return Number(
        variable.long_name,
        name,
        f"{value:.4g} {kind.unit(variable.unit)}",
        "" if in_si is None else with_prefix(in_si, variable.si_units),
        f"{error / abs(value):.1%}" if error is not None and value else "",
    )


def lines(summary: Mapping[str, Any]) -> Iterator[str]:
    """A summary in a few lines of text, indented."""
    yield f"  {summary['kind']} ({summary['method']}), M = {summary['M']:.4g}, L = {summary['L']:.4g}"
    yield f"  {KINDS[summary['kind']].moment(summary)}"
    numbers = key_numbers(summary)
    wide = max((len(number.label) + len(number.symbol) for number in numbers), default=0)
    for n in numbers:
        known = f"{n.si} ({n.value})" if n.si else n.value
        name = f"{n.label} {n.symbol}".ljust(wide + 1)
        yield f"    {name}  {known}" + (f", error {n.error}" if n.error else "")
    for warning in summary["warnings"]:
        yield f"  warning: {warning}"


def html_table(summary: Mapping[str, Any], heading: str = "") -> str:
    """The key numbers as an HTML table with what is known of them, and the warnings below."""
    numbers = key_numbers(summary)
    used = [column for column, texts in enumerate(zip(*numbers, strict=True)) if any(texts)]
    conditions = f"{summary['kind']} ({summary['method']}), M = {summary['M']:.4g}, L = {summary['L']:.4g}"
    moment = KINDS[summary["kind"]].moment(summary)
    parts = [f"{heading}{escape(conditions)}: {escape(summary['status'])}; {escape(moment)}"]
    if numbers:
        rows = [_html_row("td", [number[column] for column in used]) for number in numbers]
        parts.append(f"<table>{_html_row('th', [HEAD[column] for column in used])}{''.join(rows)}</table>")
    parts += [f"<div>Warning: {escape(warning)}</div>" for warning in summary["warnings"]]
    return f"<div>{''.join(parts)}</div>"


def _html_row(tag: str, cells: list[str]) -> str:
    return f"<tr>{''.join(f'<{tag}>{escape(cell)}</{tag}>' for cell in cells)}</tr>"
