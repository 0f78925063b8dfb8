"""The tables that the command line prints, and the same as data."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from rich.console import Console
from rich.table import Table

from ertel.apps.terminal import printable
from ertel.results.numbers import errors_of, moment, values_of
from ertel.results.parameters import domain, rheology_of
from ertel.results.report import more_lines

if TYPE_CHECKING:
    from ertel.case.case import Case
    from ertel.physics.film_formulas import FormulaFilm


Errors = Mapping[str, tuple[float, float]]  # estimated error and extrapolated value, by name
NO_ERRORS: Errors = {}


class PlainConsole(Console):
    """A console that shows control characters in texts as escapes."""

    def print(self, *objects: Any, **options: Any) -> None:
        """Print as rich does."""
        super().print(*(printable(item) if isinstance(item, str) else item for item in objects), **options)


def console() -> Console:
    """The console for tables: stdout, without markup."""
    return PlainConsole(highlight=False, markup=False, soft_wrap=True)


# -- a run ------------------------------------------------------------------------------------------------------------


def print_summary(out: Console, case: "Case", summary: Mapping[str, Any]) -> None:
    """The outcome of a run."""
    parameters = f"M = {summary['M']:.5g}, L = {summary['L']:.4g}"
    grid = f"{case.solver.method}, {domain(case)}"
    out.print(f"{case.name or case.kind}: {parameters} ({grid}): {summary['status']}", style="bold")
    if case.scales:
        out.print(f"Rheology: {rheology_of(case)}")
    _print_values(out, case, summary)
    steps = f"{summary['steps']} steps, " if "steps" in summary else ""
    work = "{newton_iterations} Newton and {krylov_iterations} Krylov iterations, {wall_s:.1f} s"
    out.print(steps + work.format_map(summary))
    for warning in summary["warnings"]:
        out.print(f"Warning: {warning}", style="yellow")


def _print_values(out: Console, case: "Case", summary: Mapping[str, Any]) -> None:
    """Values with their errors, restitution, what holds of the whole run, and the film formulas at that moment."""
    values, errors = values_of(summary), errors_of(summary)
    if values:
        heading = "at the last time" if "T" in summary else moment(summary)
        out.print(value_table(case, heading, values, errors))
    else:
        out.print(f"{moment(summary).capitalize()}.")
    estimate = summary.get("error_estimate") or {}
    if estimate:
        said = ", ".join(f"of {name} that of the {parts['dominant']}" for name, parts in estimate.items())
        out.print(f"The largest error is {said}.")
    if summary.get("restitution") is not None:
        out.print(f"Coefficient of restitution {summary['restitution']:.4f}")
    for line in more_lines(summary):
        out.print(f"{line[0].upper()}{line[1:]}")
    if values:
        _print_formulas(out, case, values, errors)


def _print_formulas(out: Console, case: "Case", values: Mapping[str, float], errors: Errors) -> None:
    """The film formulas next to the computed films, where the formulas have a meaning."""
    from ertel.results.parameters import films
    from ertel.results.variables import FILMS

    T = values.get("T", 0.0)
    found = films(case, case.motion.load(T), case.motion.entrainment(T))
    if not found:
        return
    out.print()
    out.print(film_table(case, found, {name: values[name] for name in FILMS}, errors))


def value_table(case: "Case", heading: str, values: Mapping[str, float], errors: Errors) -> Table:
    """Dimensionless values, with their value in SI, error and extrapolated value, also in SI, if these are known."""
    table = Table(heading, "", box=None, pad_edge=False)
    in_si = ["in SI"] if case.scales else []
    for column in ["value", *in_si, *(["error", "extrapolated", *in_si] if errors else [])]:
        table.add_column(column, justify="right", no_wrap=True)
    for key, value in values.items():
        table.add_row(*_value_cells(case, key, value, errors.get(key)))
    return table


def _value_cells(case: "Case", key: str, value: float, error: tuple[float, float] | None) -> list[str]:
    from ertel.results.variables import VARIABLES, with_prefix

    variable = VARIABLES["time" if key == "T" else key]
    cells = [variable.long_name, key, f"{value:.5g}"]
    if case.scales:
        cells.append(with_prefix(value * variable.factor(case.scales), variable.si_units))
    if error:
        cells += [f"{error[0] / abs(value):.2%}" if value else "-", f"{error[1]:.5g}"]
        if case.scales:
            cells.append(with_prefix(error[1] * variable.factor(case.scales), variable.si_units))
    return cells


# -- film formulas ----------------------------------------------------------------------------------------------------


def film_table(
    case: "Case", found: "Sequence[FormulaFilm]", computed: Mapping[str, float], errors: Errors = NO_ERRORS
) -> Table:
    """Film thicknesses by the formulas, with their deviation from a computed film thickness if there is one.

    computed: as it was computed.  errors: of the computed film; the deviation is then from the extrapolated one.  A
    formula that is not made for such a contact is in brackets.
    """
    caption = "(in brackets: the contact is outside the range of the formula)"
    table = Table("film", box=None, pad_edge=False, caption=caption)
    table.columns[0].no_wrap = True
    for column in ("central", "deviation", "minimum", "deviation") if computed else ("central", "minimum"):
        table.add_column(column, justify="right", no_wrap=True)
    if computed:
        pairs = [_with_error(case, name, value, errors) for name, value in computed.items()]
        table.add_row("computed", *(cell for pair in pairs for cell in pair))
    if errors:
        computed = {name: errors[name][1] if name in errors else value for name, value in computed.items()}
        table.add_row("computed, extrapolated", _film(case, computed["H_c"]), "", _film(case, computed["H_min"]))
    for f in found:
        cells = [_film(case, f.central), _film(case, f.minimum)]
        if computed:
            cells.insert(1, _deviation(f.central, computed["H_c"]))
            cells.append(_deviation(f.minimum, computed["H_min"]))
        table.add_row(f.name if f.inside is not False else f"({f.name})", *cells)
    return table


def _with_error(case: "Case", name: str, value: float, errors: Errors) -> list[str]:
    """A computed film, and its error in the column of the deviations."""
    return [_film(case, value), f"+-{errors[name][0] / abs(value):.1%}" if name in errors and value else ""]


def _film(case: "Case", film: float | None) -> str:
    from ertel.results.variables import with_prefix

    if film is None:
        return ""
    return with_prefix(film * case.scales.film, "m") if case.scales else f"{film:.4g}"


def _deviation(film: float | None, computed: float) -> str:
    return f"{film / computed - 1:+.1%}" if film is not None and computed else ""


def print_sources(out: Console, found: "Sequence[FormulaFilm]") -> None:
    """Sources and ranges of the formulas."""
    sources: dict[str, list[str]] = {}
    for f in found:
        sources.setdefault(f.source, []).append(f"{f.name}: {f.valid}")
    for source, formulas in sources.items():
        out.print(f"\n{source}", *(f"  {line}" for line in formulas), sep="\n")


def films_as_data(case: "Case", found: "Sequence[FormulaFilm]") -> dict[str, Any]:
    """The parameters of a case and its film thicknesses by the formulas, as data for JSON."""
    from ertel.results.parameters import parameter_summary
    from ertel.results.variables import in_si

    rows = [film._asdict() for film in found]
    if case.scales:
        for row in rows:
            values = {"H_c": row["central"], "H_min": row["minimum"]}
            row["si"] = in_si(values, case.scales)
    return {**parameter_summary(case), "films": rows}


# -- names and values -------------------------------------------------------------------------------------------------


def print_parameters(out: Console, content: Mapping[str, Any]) -> None:
    """The parameters of a case, then its scales in SI."""
    table = Table("parameter", "value", box=None, pad_edge=False)
    for name, value in {**content, **content.get("si", {})}.items():
        if name != "si":
            table.add_row(f"{name} (a rigid ball's)" if name.startswith("trapped_film") else name, f"{value:.6g}")
    out.print(table)


def print_names(out: Console, content: Mapping[str, str]) -> None:
    """Names and their values, one per line."""
    width = max(map(len, content)) + 2
    for name, text in content.items():
        out.print(f"{name:{width}}{text}")
