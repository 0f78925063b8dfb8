"""The numbers of a run as one table, which repr, notebooks, `ertel ls`, `ertel compare`, studies and the app print.

It is made from the summary of the run, as `results.summary` writes it and as summary.json has it, also that of earlier
versions.  Below it are the outcome as text and as HTML for a notebook.  This module imports neither JAX nor xarray.
"""

from base64 import b64encode
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from html import escape
from io import BytesIO
from math import floor, isfinite, log10
from typing import Any, NamedTuple

from ertel.case.methods import METHODS
from ertel.case.status import Status
from ertel.physics.line_scales import LineScales
from ertel.physics.scales import Scales
from ertel.physics.temperature_laws import ZERO_CELSIUS
from ertel.results.figures import is_line
from ertel.results.parameters import geometry_of
from ertel.results.variables import (
    COEFFICIENT,
    FILMS,
    KELVIN,
    THICKNESS,
    TOUCH,
    VARIABLES,
    Variable,
    along_a_line,
    in_celsius,
    names_where,
    stored_in,
    unit_of,
    with_prefix,
)

Outcome = Mapping[str, Any]  # of a run, as `results.summary` and `summary.json` have it

ERRORS = [f"{name}_{ending}" for ending in ("error", "extrapolated") for name in FILMS]
UNKNOWN = 0.5  # error of a film over its value, above which the film is not known
IN_SI = (KELVIN, "s")  # units of numbers that are in SI in the summary itself
FREE = ("name", "reference")  # keys of a case that change no result


class Number(NamedTuple):
    """A number of the outcome of a run, as all texts and tables show it.

    value, error, on_grid: in `unit`, "1" for a plain number.  The value is the extrapolated one where the error of the
    discretisation was estimated, the error is its bar, and on_grid the value on the grid, as in the maps.  factor: what
    1 is in SI, None where that is not known or the same.  zero: T at t = 0.
    """

    name: str
    about: Variable
    value: float
    unit: str = "1"
    factor: float | None = None
    zero: float = 0.0
    error: float | None = None
    on_grid: float | None = None

    def to_si(self, value: float) -> float:
        """A value of this number in SI; as it is where that is not known."""
        return value if self.factor is None else (value - self.zero) * self.factor

    @property
    def known(self) -> bool:
        """Whether the error leaves something of a film."""
        return self.error is None or self.about.panel != THICKNESS or self.error <= UNKNOWN * self.value

    @property
    def in_si(self) -> "Number":
        """The same in SI under its name there; itself where SI is not known, or the same."""
        if self.factor is None:
            return self
        error = None if self.error is None else self.error * self.factor
        on_grid = None if self.on_grid is None else self.to_si(self.on_grid)
        value, about = float(self.to_si(self.value)), self.about
        return Number(about.si_name, about, value, about.si_units, error=error, on_grid=on_grid)

    @property
    def text(self) -> str:
        """The value in its unit."""
        if not self.known:
            return "not known"
        if self.name == "restitution":
            return f"{self.value:.4f}"
        if self.unit in (*IN_SI, self.about.si_units):
            return with_prefix(*in_celsius(self.value, self.unit))
        return f"{self.value:.4g}" if self.unit == "1" else f"{self.value:.4g} {self.unit}"

    @property
    def text_in_si(self) -> str:
        """The value in SI; empty where it is not known, or the same."""
        return "" if self.factor is None or self.about.si_units == "1" or not self.known else self.in_si.text

    @property
    def text_of_error(self) -> str:
        """The error over the value; empty where it is not known, or the value is not."""
        return f"{self.error / abs(self.value):.1%}" if self.error is not None and self.value and self.known else ""

    @property
    def full_text(self) -> str:
        """The value in SI and in its unit, as far as they are known."""
        return f"{self.text_in_si} ({self.text})" if self.text_in_si else self.text

    @property
    def attributes(self) -> dict[str, str]:
        """The attributes of a variable that holds such numbers: long_name, units (SI, or "1") and in_units_of."""
        plain = self.unit in ("1", *IN_SI, self.about.si_units)
        units = {"units": self.unit} if plain else {"units": "1", "in_units_of": self.unit}
        return {"long_name": self.about.long_name, **units}


def numbers(summary: Outcome) -> dict[str, Number]:
    """The numbers of a summary by name, in the order of `VARIABLES`.

    The values of an impact hold at maximum approach, those of rolling at the last time, or steadily; before, there are
    none.
    """
    given = {**summary, "wall_time": summary.get("wall_s")}
    given |= {f"{name}_extreme": one["value"] for name, one in summary.get("extremes", {}).items()}
    known = values_of(summary)
    if wrong := [name for name, value in known.items() if value is None and VARIABLES[name].shown]:
        raise ValueError(f"{wrong[0]} is not a number")
    there = names_where(lambda variable: known or not variable.at_moment)
    values = {name: given[name] for name in there if given.get(name) is not None}
    scales, errors = scales_in(summary), errors_of(summary)
    for name in [name for name in errors if f"{name}_warm" in values]:  # by the factor that makes the film thinner
        warm = values[f"{name}_warm"]
        errors[f"{name}_warm"] = warm / values[name] * errors[name][0], warm / values[name] * errors[name][1]
    found = {}
    for name, value in values.items():
        error, best, on_grid = (*errors[name], value) if name in errors else (None, value, None)
        one = number(summary["kind"], scales, name, best, error, on_grid)
        found[name] = one._replace(unit=along_a_line(one.unit)) if is_line(summary) else one
    return {**found, **({"T": found["T"]._replace(zero=summary.get(TOUCH) or 0.0)} if "T" in found else {})}


def number(kind: str, scales: Scales | None, name: str, value: float, *errors: float | None) -> Number:
    """A number by its name in `VARIABLES`, in a contact of this kind, with these scales."""
    about, factor = VARIABLES[name], None
    unit = unit_of(kind, about.unit)
    if scales and about.scale:
        factor = about.factor(scales)
        unit = "1" if about.scale == COEFFICIENT else unit
    return Number(name, about, value, unit, factor, 0.0, *errors)


def values_of(summary: Outcome) -> dict[str, float]:
    """The values of a run at its moment by name; empty where there are none."""
    chosen = names_where(lambda variable: variable.at_moment) if summary["H_c"] is not None else ()
    return {name: summary[name] for name in chosen if name in summary}


def errors_of(summary: Outcome) -> dict[str, tuple[float, float]]:
    """Discretisation error and extrapolated value by name, where they were estimated."""
    films = [name for name in FILMS if summary.get(f"{name}_error") is not None]
    errors = {name: (summary[f"{name}_error"], summary[f"{name}_extrapolated"]) for name in films}
    estimates = (summary.get("error_estimate") or {}).items()
    return errors | {name: (estimate["error"], estimate["extrapolated"]) for name, estimate in estimates}


def scales_in(summary: Outcome) -> Scales | None:
    """The scales of the case, None of a dimensionless one."""
    si = summary.get("si")
    if si is None:
        return None
    hertz, scales = geometry_of(summary).hertz, LineScales if is_line(summary) else Scales
    return scales(si["R_m"], si["E_prime_Pa"], si["a_m"], si["p_h_Pa"], si["t0_s"], hertz)


def moment(summary: Outcome) -> str:
    """The time at which the values hold, or the reason why there are none."""
    known = summary["H_c"] is not None
    if not summary.get("steps", 1):
        return "no step was taken"
    if Status(summary["status"]).failed and not known:
        return f"no result: {summary['status']}"
    if summary["kind"] == "impact":
        return "at maximum approach" if known else "maximum approach was not reached"
    if not known:
        return "no result"
    if "T" in summary:
        return f"at T = {summary['T']:.4g}"
    return f"on {nodes_in_words(summary, summary['nodes'], summary.get('nodes_y', summary['nodes']))}"


def nodes_in_words(about: Outcome, nodes: int, across: int) -> str:
    """The grid in words: 257 x 257 nodes, 513 nodes along x.  about: method and radius_ratio of the contact."""
    return METHODS[about["method"]].of(geometry_of(about)).space.in_words(nodes, across)


def key_numbers(summary: Outcome) -> list[Number]:
    """The numbers that are shown of a run, but those that are zero; those with heat where they are known."""
    table = numbers(summary) if values_of(summary) else {}
    return [table[name] for name in stored_in(table, lambda variable: variable.shown) if table[name].value]


def plus_minus(value: float, error: float) -> str:
    """A value with its error, 146 ± 10: as many digits as the error deserves; alone where the error is not known."""
    if not (isfinite(error) and error > 0):
        return f"{value:.4g}"
    digits = max(0, 1 - floor(log10(error)))
    return f"{value:.{digits}f} ± {error:.{digits}f}"


# -- tables of many runs ----------------------------------------------------------------------------------------------


def duration(seconds: float) -> str:
    """A rough duration in words."""
    if seconds < 90:
        return f"{seconds:.0f} s"
    return f"{seconds / 60:.0f} min" if seconds < 5400 else f"{seconds / 3600:.1f} h"


def scalars(summary: Outcome, in_si: bool = True) -> dict[str, Number]:
    """The numbers of a summary by name, one for each column; in SI under SI names (h_c for H_c) if `in_si` and known.

    H_c is the extrapolated value where there is one; then H_c_error is its bar and H_c_on_grid the value on the grid.
    A film that is not known is left out.  In SI the names are h_c, h_c_error, h_c_on_grid.
    """
    table: dict[str, Number] = {}
    for each in numbers(summary).values():
        one = each.in_si if in_si else each
        long_name = one.about.long_name
        table |= {one.name: one} if one.known else {}
        for ending, value, text in (
            ("error", one.error, f"estimated error of the {long_name}"),
            ("on_grid", one.on_grid, f"{long_name}, on the grid"),
        ):
            if value is not None:
                name, about = f"{one.name}_{ending}", replace(one.about, long_name=text)
                table[name] = Number(name, about, value, one.unit)
    return table


def differences(first: Any, second: Any) -> list[dict[str, Any]]:
    """The keys that differ of two cases as plain data, names and references apart: `field`, `first` and `second`.

    first, second: its values, None where it is not there.
    """
    one, two = dict(_values_by_place(first)), dict(_values_by_place(second))
    return [
        {"field": key, "first": one.get(key), "second": two.get(key)}
        for key in {**one, **two}
        if one.get(key) != two.get(key)
    ]


def _values_by_place(data: Any, place: str = "") -> Iterator[tuple[str, Any]]:
    """Every value with its place: contact.speed, roughness[1].amplitude."""
    if isinstance(data, Mapping):
        for key in (key for key in data if key not in FREE):
            yield from _values_by_place(data[key], f"{place}.{key}".removeprefix("."))
    elif isinstance(data, list) and data and all(isinstance(item, Mapping) for item in data):
        for position, item in enumerate(data, 1):
            yield from _values_by_place(item, f"{place}[{position}]")
    else:
        yield place, data


def pairs(first: Outcome, second: Outcome) -> list[dict[str, Any]]:
    """The numbers of two runs from their summaries; in SI where both cases are.

    Each has name, first, second, attributes and change, second/first - 1; what is not known is None.
    """
    in_si = "si" in first and "si" in second
    one, two = (scalars(summary, in_si) for summary in (first, second))
    rows = []
    for name in {**one, **two}:
        attributes = (one.get(name) or two[name]).attributes
        a, b = (table[name].value if name in table else None for table in (one, two))
        change = None if a is None or b is None or a == 0 else b / a - 1
        rows.append({"name": name, "first": a, "second": b, "attributes": attributes, "change": change})
    return rows


# -- as text -----------------------------------------------------------------------------------------------------------

DOTS_PER_INCH = 80  # of a picture in a notebook


def lines(summary: Outcome) -> Iterator[str]:
    """A summary in a few lines of text, indented."""
    yield f"  {_conditions(summary)}"
    yield f"  {moment(summary)}"
    shown = key_numbers(summary)
    named = [f"{n.about.long_name} {n.about.symbol}" for n in shown]
    values = [n.full_text + (f" ± {n.text_of_error}" if n.text_of_error else "") for n in shown]
    yield from (f"    {line}" for line in aligned([named, values], left=2))
    yield from (f"  {line}" for line in more_lines(summary))
    for warning in summary["warnings"]:
        yield f"  warning: {warning}"


def _conditions(summary: Outcome) -> str:
    how = METHODS[summary["method"]].of(geometry_of(summary)).in_words
    return f"{summary['kind']} ({how}), M = {summary['M']:.4g}, L = {summary['L']:.4g}"


def more_lines(summary: Outcome) -> Iterator[str]:
    """The rest of a summary, besides its key numbers, a line each: extremes, temperatures, stresses, balances."""
    yield from _extreme_lines(summary)
    yield from _thermal_lines(summary)
    yield from _stress_line(summary)
    shares = ((name, terms["imbalance"]) for name, terms in summary.get("budgets", {}).items())
    if shown := ", ".join(f"{name} {share:.2%}" for name, share in shares if share is not None):
        yield f"imbalance: {shown}"


def _extreme_lines(summary: Outcome) -> Iterator[str]:
    """The extremes of a run in time, one a line: value, time, place, and a note on the value."""
    table, scales = numbers(summary), scales_in(summary)
    for name, one in summary.get("extremes", {}).items():
        extreme = table[f"{name}_extreme"]
        T, *place = (number(summary["kind"], scales, key, one[key]) for key in ("T", "X", "Y") if key in one)
        T = T._replace(zero=summary.get(TOUCH) or 0.0)
        if scales:
            parts = [f"t = {T.text_in_si} (T = {T.value:.4g})", *(f"{n.about.si_name} = {n.text_in_si}" for n in place)]
        else:
            parts = [f"T = {T.text}", *(f"{n.name} = {n.value:.3g}" for n in place)]
        where = ", ".join(parts) if scales else f"{', '.join(parts)} {place[0].unit}"
        note = f"; {one['note']}" if one["note"] else ""
        yield f"{extreme.about.long_name} {name}: {extreme.full_text} at {where}{note}"


def _thermal_lines(summary: Outcome) -> Iterator[str]:
    """Film, traction and temperatures with the heat of the contact, a line each; none without a section [thermal]."""
    table = numbers(summary)
    if "phi_T" in table:
        cold = ", ".join(f"{n.about.symbol} {n.full_text}" for n in table.values() if f"{n.name}_warm" in summary)
        yield f"without heat: {cold} (phi_T = {summary['phi_T']:.4g}, L_t = {summary['L_t']:.3g})"
    if "T_max" in table:
        warm = {name: f"{n.value - ZERO_CELSIUS:.1f} degC" for name, n in table.items() if n.about.unit == KELVIN}
        oil = f"{warm['T_max']} at {_place(table, 'T_max')}, zeta = {table['zeta_T_max'].text}"
        yield f"highest temperatures: surface 1 {warm['T_1_max']}, surface 2 {warm['T_2_max']}, oil {oil}"
        yield f"mean across the film: highest {warm['T_film_max']}, over the contact {warm['T_film_mean']}"
    if (heat := summary.get("thermal", {}).get("heat_W", {})) and None not in heat.values():
        watts = [with_prefix(heat[name], "W") for name in ("released", "into_body_1", "into_body_2", "with_the_oil")]
        yield "heat in the film {}; into body 1 {}, into body 2 {}, with the oil {}".format(*watts)


def _place(table: Mapping[str, Number], of: str) -> str:
    """The place of a largest value, "x = 12 µm, y = 0 m"."""
    return ", ".join(f"{axis.lower()} = {n.text_in_si or n.text}" for axis in "XY" if (n := table.get(f"{axis}_{of}")))


def _stress_line(summary: Outcome) -> Iterator[str]:
    """The largest stresses in body 1 and where they are, in one line; none of a run that has not finished."""
    table = numbers(summary)
    if "von_mises_max" not in table:
        return
    shown = {name: each.text_in_si or each.text for name, each in table.items()}
    ratio = f", {shown['yield_ratio']} of the yield stress of hardened steel, a guess" if "yield_ratio" in table else ""
    where = f"{shown['Z_von_mises']} deep at {_place(table, 'von_mises')}"
    shear = f"largest shear stress {shown['shear_max']}, {shown['Z_shear']} deep"
    when = " at maximum approach" * (summary["kind"] == "impact")
    yield f"largest von Mises stress in body 1{when}: {shown['von_mises_max']}{ratio}, {where}; {shear}"


def aligned(columns: Sequence[Sequence[str]], left: int = 0) -> Iterator[str]:
    """Columns side by side as lines; the first `left` of them begin at the left, the others end at the right."""
    widths = [max(map(len, column), default=0) for column in columns]
    for cells in zip(*columns, strict=True):
        padded = [
            cell.ljust(width) if position < left else cell.rjust(width)
            for position, (cell, width) in enumerate(zip(cells, widths, strict=True))
        ]
        yield "  ".join(padded).rstrip()


def html_columns(columns: Sequence[Sequence[str]]) -> str:
    """Columns, each with its heading first, as an HTML table."""
    table = ""
    for number, cells in enumerate(zip(*columns, strict=True)):
        tag = "td" if number else "th"
        table += f"<tr>{''.join(f'<{tag}>{escape(cell)}</{tag}>' for cell in cells)}</tr>"
    return f"<table>{table}</table>"


def html_image(draw: Callable[[], Any], name: str) -> str:
    """A figure as an image that the page contains; empty where there is nothing to draw yet."""
    try:
        figure = draw()
    except ValueError:
        return ""
    png = BytesIO()
    figure.savefig(png, format="png", dpi=DOTS_PER_INCH)
    return f'<img alt="{escape(name)}" src="data:image/png;base64,{b64encode(png.getvalue()).decode()}">'
