"""The key numbers of a summary, as text and as a table in a notebook.  Imports neither JAX nor xarray."""

from collections.abc import Iterator, Mapping
from html import escape
from typing import Any, NamedTuple

from ertel.physics.temperature_laws import ZERO_CELSIUS
from ertel.results import html
from ertel.results.kinds import KINDS, Errors, Kind
from ertel.results.variables import FRICTION, VARIABLES, key_in_si, with_prefix

KEY = ("H_c", "H_min", "P_max")
EXTREMES = {"H_min": "thinnest film of the run", "P_max": "highest pressure of the run"}
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
    """Film thickness, maximum pressure, friction and restitution of a run; empty without them.

    Those of an impact hold at maximum approach.  A coefficient of friction is named where it is not zero.
    summary : as `results.summary` and `summary.json` have it.
    """
    kind = KINDS[summary["kind"]]
    values, si, errors = kind.values(summary), kind.values_in_si(summary), kind.errors(summary)
    if not values:
        return []
    names = (*KEY, *(name for name in FRICTION if values.get(name)))
    numbers = [_number(name, values[name], kind, si, errors) for name in names]
    if summary.get("restitution") is not None:
        numbers.append(Number("coefficient of restitution", "e", f"{summary['restitution']:.4f}"))
    return numbers


def _number(name: str, value: float, kind: Kind, si: Mapping[str, float], errors: Errors) -> Number:
    variable = VARIABLES[name]
    in_si = si.get(key_in_si(variable))
    error, _ = errors.get(name, (None, None))
    plain = in_si is not None and variable.si_units == "1"  # a coefficient: one number
    return Number(
        variable.long_name,
        name,
        f"{value:.4g}" if plain else f"{value:.4g} {kind.unit(variable.unit)}",
        "" if in_si is None or plain else with_prefix(in_si, variable.si_units),
        f"{error / abs(value):.1%}" if error is not None and value else "",
    )


def extreme_lines(summary: Mapping[str, Any]) -> Iterator[str]:
    """The extremes of a run in time, one a line: value, time, place, and what is to be said of it."""
    kind = KINDS[summary["kind"]]
    in_si = summary.get("si", {}).get("extremes", {})
    for name, one in summary.get("extremes", {}).items():
        si = in_si.get(name, {})
        n = _number(name, one["value"], kind, si, {})
        known = f"{n.si} ({n.value})" if n.si else n.value
        note = f"; {one['note']}" if one["note"] else ""
        yield f"{EXTREMES[name]} {name}: {known} at {_where(one, si, kind.unit('a*'))}{note}"


def budget_lines(summary: Mapping[str, Any]) -> Iterator[str]:
    """The imbalance of every budget, in one line; none where there are no budgets yet."""
    known = {name: terms["imbalance"] for name, terms in summary.get("budgets", {}).items()}
    said = ", ".join(f"{name} {share:.2%}" for name, share in known.items() if share is not None)
    if said:
        yield f"imbalance of the budgets: {said}"


def thermal_lines(summary: Mapping[str, Any]) -> Iterator[str]:
    """Film, traction and temperatures with the heat of the contact, a line each; none without a section [thermal]."""
    known = summary.get("thermal")
    if not known:
        return
    films = f"central {with_prefix(known['h_c_m'], 'm')}, minimum {with_prefix(known['h_min_m'], 'm')}"
    yield f"film with inlet shear heating: {films} (phi_T = {known['phi_T']:.4g}, L_t = {known['L_t']:.3g})"
    yield f"traction coefficient of the warm film: {known['mu_sliding']:.4g}"
    surfaces, film = (
        [known[f"{name}_K"] - ZERO_CELSIUS for name in names]
        for names in (("T_1_max", "T_2_max"), ("T_film_max", "T_film_mean"))
    )
    hottest = f"surface 1 {surfaces[0]:.1f} degC, surface 2 {surfaces[1]:.1f} degC, film {film[0]:.1f} degC"
    yield f"highest temperatures: {hottest}; mean of the film {film[1]:.1f} degC"


def more_lines(summary: Mapping[str, Any]) -> Iterator[str]:
    """What a summary has besides its key numbers, a line each: extremes, temperatures, budgets."""
    yield from extreme_lines(summary)
    yield from thermal_lines(summary)
    yield from budget_lines(summary)


def _where(one: Mapping[str, Any], si: Mapping[str, float], unit: str) -> str:
    """Time and place of an extreme."""
    if si:
        t, x, y = with_prefix(si["t_s"], "s"), with_prefix(si["x_m"], "m"), with_prefix(si["y_m"], "m")
        return f"t = {t} (T = {one['T']:.4g}), x = {x}, y = {y}"
    return f"T = {one['T']:.4g} t0, X = {one['X']:.3g}, Y = {one['Y']:.3g} {unit}"


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
    yield from (f"  {line}" for line in more_lines(summary))
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
        rows = [html.row("td", [number[column] for column in used]) for number in numbers]
        parts.append(f"<table>{html.row('th', [HEAD[column] for column in used])}{''.join(rows)}</table>")
    parts += [
        f"<div>{escape(line)}</div>"
        for line in (*extreme_lines(summary), *thermal_lines(summary), *budget_lines(summary))
    ]
    parts += [f"<div>Warning: {escape(warning)}</div>" for warning in summary["warnings"]]
    return f"<div>{''.join(parts)}</div>"
