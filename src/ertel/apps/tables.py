"""The tables that the command line prints, and the same as data."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict
from itertools import chain
from typing import TYPE_CHECKING, Any

from ertel.apps.terminal import capital, print_text
from ertel.case.records import ConfigError, printable, show
from ertel.inputs import materials, oils
from ertel.physics.materials import Material, NamedOil, Sourced, celsius
from ertel.physics.units import Unit, marks
from ertel.results.figures import is_line
from ertel.results.numbers import Number, aligned, duration, moment, more_lines, nodes_in_words, numbers, values_of
from ertel.results.parameters import domain, formula_films, parameter_summary, rheology_of, values_in_si
from ertel.results.variables import FILMS, in_celsius, with_prefix

if TYPE_CHECKING:
    from ertel.case.case import Case
    from ertel.physics.film_formulas import FormulaFilm

NOTHING: Mapping[str, Number] = {}
WARM, HOT = 313.15, 373.15  # K, the temperatures of data sheets
CAPTION = "(eta0 in mPa s, alpha in 1/GPa, at 40 and 100 degC; ertel oils NAME: all data, with source and range)"
TITLES = {"shear": "shear thinning", "limiting_stress": "limiting stress"}


def print_rows(rows: Sequence[Sequence[str]], left: int = 1) -> None:
    """Rows of texts below each other, the first columns aligned to the left, the others to the right."""
    in_lines = [map(printable, row) for row in rows]  # a name with a line break in it is still one row
    for line in aligned(list(zip(*in_lines, strict=True)), left):
        print_text(line)


def print_names(content: Mapping[str, str]) -> None:
    """Names and their values, one per line."""
    print_rows(list(content.items()), left=2)


def print_parameters(content: Mapping[str, Any]) -> None:
    """The parameters of a case, then its scales in SI."""
    values = {name: value for name, value in {**content, **content.get("si", {})}.items() if name != "si"}
    body = "cylinder" if is_line(content) else "ball"
    titles = {name: f"{name} (a rigid {body}'s)" if name.startswith("trapped_film") else name for name in values}
    print_names({"parameter": "value", **{titles[name]: f"{value:.6g}" for name, value in values.items()}})


def needs(content: Mapping[str, Any]) -> dict[str, str]:
    """Oil, grid, memory and time of an outlook in words."""
    grid, memory, time = content["grid"], content["memory"], content["time"]
    about = {**content["parameters"], "method": content["method"]}
    size = nodes_in_words(about, grid["nodes"], grid["nodes_across"])
    in_si = f" = {with_prefix(grid['spacing_m'], 'm')}" if "spacing_m" in grid else ""
    there = f" of {memory['available'] / 1e9:.3g} GB" if memory["available"] else ""
    steps = f", {time['steps']} time steps" if time["steps"] else ""
    starved, layers = content["starvation"], {}
    if starved:
        layers["layers of oil"] = f"r = {starved['r']:.3g}, about {starved['share']:.0%} of the flooded film"
    if "wet_radius" in starved:
        layers["wet radius"] = f"at most {starved['wet_radius']:.3g} a at maximum approach"
    start, rough = content["start"], content["Lambda"]
    if rough:
        over = f"the expected film over the rms roughness that is not on the grid, {with_prefix(rough['sigma_m'], 'm')}"
        layers["Lambda"] = f"{rough['expected']:.2g}, {over}"
    if start:
        layers["first film"] = f"{start['film']:.4g} a*^2/R, under {start['load']:.2g} F*"
    return {
        "rheology": content["rheology"],
        **({"regime": content["regime"]} if content["regime"] else {}),
        **layers,
        **{f"roughness[{number}]": _rough(rough) for number, rough in enumerate(content["roughness"], 1)},
        "grid": f"{size}, spacing {grid['spacing']:.3g} a{in_si}",
        "pressure sweep": f"{grid['sweep']:.3g} a long, {grid['cells_in_sweep']:.1f} cells (about 10 needed)",
        "memory": f"about {memory['needed'] / 1e9:.2g} GB{there}",
        "time": f"roughly {duration(time['seconds'])}{steps}",
    }


def _rough(rough: Mapping[str, Any]) -> str:
    """Size and heights of a roughness in words, in SI where they have it."""

    def shown(name: str, unit: str) -> str:
        return with_prefix(rough[f"{name}_m"], "m") if f"{name}_m" in rough else f"{rough[name]:.3g} {unit}"

    heights = [shown(name, "a^2/R") for name in ("rms", "lowest", "highest")]
    there = "rms {} on the grid at the start, from {} to {}".format(*heights)
    return f"{rough['shape']}, finest detail {shown('size', 'a')}, {there}"


# -- a run ------------------------------------------------------------------------------------------------------------


def print_summary(case: "Case", summary: Mapping[str, Any], verdict: str = "", stored: str = "") -> None:
    """The outcome of a run; below it the same in one line, and where it is stored."""
    parameters = f"M = {summary['M']:.5g}, L = {summary['L']:.4g}"
    grid = f"{case.method.in_words}, {domain(case)}"
    print_text(f"{case.name or case.kind}: {parameters} ({grid}): {summary['status']}", bold=True)
    if case.scales:
        print_text(f"Rheology: {rheology_of(case)}")
    _print_values(case, summary)
    steps = f"{summary['steps']} steps, " if "steps" in summary else ""
    work = "{newton_iterations} Newton and {krylov_iterations} Krylov iterations, {wall_s:.1f} s"
    print_text(steps + work.format_map(summary))
    for warning in summary["warnings"]:
        print_text(f"Warning: {warning}", fg="yellow")
    if verdict:
        print_text(capital(verdict), bold=True)
    if stored:
        print_text(stored)


def _print_values(case: "Case", summary: Mapping[str, Any]) -> None:
    """Values with their errors, restitution, what holds of the whole run, and the film formulas at that moment.

    With a section [thermal] film and traction are the warm ones; those without heat follow in a line.
    """
    table = numbers(summary)
    computed = {name: table[name] for name in values_of(summary)}
    if computed:
        heading = "at the last time" if "T" in summary and summary["kind"] == "rolling" else moment(summary)
        values = {name: table.get(f"{name}_warm", number) for name, number in computed.items()}
        print_rows(value_rows(heading, list(values.values())), left=2)
    else:
        print_text(f"{moment(summary).capitalize()}.")
    estimate = summary.get("error_estimate") or {}
    for part in sorted({parts["dominant"] for parts in estimate.values()}):
        names = ", ".join(name for name, parts in estimate.items() if parts["dominant"] == part)
        print_text(f"The largest error is that of the {part} in {names}.")
    if estimate:
        print_text("Each error is the change that is expected if grid, time steps and domain are refined without end.")
    whole = [number for number in table.values() if number.about.of_impact]
    if whole:
        print_text()
        print_rows(value_rows("of the whole impact", whole), left=2)
    for line in more_lines(summary):
        print_text(capital(line))
    T = computed["T"].value if "T" in computed else 0.0
    formulas = formula_films(case, *case.motion.moment(T)) if computed else ()
    if formulas:
        print_text()
        print_films(case, formulas, computed)


def value_rows(heading: str, values: Sequence[Number]) -> list[list[str]]:
    """Numbers with their value in SI, its error and the value on the grid, also in SI, as far as these are known."""
    in_si = ["in SI"] if any(each.factor is not None for each in values) else []
    estimated = ["error", "on the grid", *in_si] if any(each.error is not None for each in values) else []
    rows = [[heading, "", "value", *in_si, *estimated]]
    for each in values:
        value = _with_si(each, each.value, in_si) if each.known else ["not known", *("" for _ in in_si)]
        row = [each.about.long_name, each.name, *value]
        if each.error is not None and each.on_grid is not None:
            row += [f"{each.error / abs(each.value):.2%}" if each.value and each.known else "-"]
            row += _with_si(each, each.on_grid, in_si)
        rows.append(row + [""] * (len(rows[0]) - len(row)))
    return rows


def _with_si(number: Number, value: float, in_si: Sequence[str]) -> list[str]:
    """A value in the unit of a number, and in SI if that is shown."""
    unit = number.about.si_units or number.unit
    return [f"{value:.5g}", *(with_prefix(number.to_si(value), unit) for _ in in_si)]


# -- film formulas ----------------------------------------------------------------------------------------------------


def print_films(case: "Case", films: "Sequence[FormulaFilm]", computed: Mapping[str, Number] = NOTHING) -> None:
    """The films by the formulas, beside the computed ones if there are some."""
    print_rows(film_rows(case, films, computed))
    print_text("(in brackets: the contact is outside the range of the formula)")
    if case.layer is not None:
        print_text("(starved: on the layers of oil, Chevalier et al. 1998; the others: flooded)")


def film_rows(case: "Case", films: "Sequence[FormulaFilm]", computed: Mapping[str, Number]) -> list[list[str]]:
    """Film thicknesses by the formulas, with their deviation from a computed film thickness if there is one.

    computed: H_c and H_min; the deviation is from their extrapolated value where there is one.  A formula that is not
    made for such a contact is in brackets.  Flooded films have no deviation beside layers of oil.  All formulas are
    without heat.
    """
    both = [computed[name] for name in FILMS] if computed else []
    title = "computed" if case.thermal is None or case.thermal.is_solved else "computed, without heat"

    def row(name: str, films: Iterable[float | None], notes: Iterable[str]) -> list[str]:
        """The films in a row; a note follows each where there is something to compare with."""
        texts = [_film(case, film) for film in films]
        return [name, *chain.from_iterable(zip(texts, notes, strict=True))] if computed else [name, *texts]

    rows = [["film", "central", "deviation", "minimum", "deviation"] if computed else ["film", "central", "minimum"]]
    if computed:
        known = [n.value if n.known else None for n in both]
        rows.append(row(title, known, [n.text_of_error and f"+-{n.text_of_error}" for n in both]))
    if any(each.error is not None for each in both):
        rows.append(row(f"{title}, on the grid", [each.on_grid for each in both], ["", ""]))
    for f in films:
        name = f.name if f.inside else f"({f.name})"
        both_films = f.central, f.minimum
        is_alike = case.layer is None or f.name.endswith("starved")  # a flooded film says little of a starved one
        rows.append(row(name, both_films, map(_deviation, both_films, both) if is_alike else ["", ""]))
    return rows


def _film(case: "Case", film: float | None) -> str:
    if film is None:
        return ""
    return with_prefix(film * case.scales.film, "m") if case.scales else f"{film:.4g}"


def _deviation(film: float | None, computed: Number) -> str:
    return f"{film / computed.value - 1:+.1%}" if film is not None and computed.value and computed.known else ""


def print_formulas(case: "Case") -> None:
    """The parameters and scales of a case, and the films by the formulas at T = 0."""
    print_parameters(parameter_summary(case))
    if films := formula_films(case, *case.motion.moment(0.0)):
        print_text()
        print_films(case, films)


def films_as_data(case: "Case") -> list[dict[str, Any]]:
    """The films by the formulas at T = 0, with sources and ranges, as data for JSON."""
    rows = [film._asdict() for film in formula_films(case, *case.motion.moment(0.0))]
    if case.scales:
        for row in rows:
            row["si"] = values_in_si({"H_c": row["central"], "H_min": row["minimum"]}, case.scales)
    return rows


# -- oils and materials -----------------------------------------------------------------------------------------------


def oil_or_material(name: str) -> NamedOil | Material:
    """The oil or the material of a name.  Raises ConfigError for a name that is not there."""
    if name in oils.names():
        return oils.get(name)
    if name in materials.names():
        return materials.get(name)
    raise ConfigError(f"NAME = {show(name)}: allowed: {', '.join((*oils.names(), *materials.names()))}")


def print_library() -> None:
    """The oils at 40 and 100 degC, and the materials."""
    rows = [["oil", "eta0 at 40", "at 100", "alpha at 40", "at 100", "valid"]]
    for name in oils.names():
        oil = oils.get(name)
        coldest, hottest = oil.temperatures
        there = [T if coldest <= T <= hottest else None for T in (WARM, HOT)]
        viscosities = [f"{1e3 * oil.viscosity_at(T):.3g}" if T else "-" for T in there]
        alphas = [f"{1e9 * (oil.pressure_laws_at(T).alpha or 0.0):.3g}" if T else "-" for T in there]
        rows.append([name, *viscosities, *alphas, _range(*oil.temperatures)])
    print_rows(rows)
    print(f"{CAPTION}\n")
    rows = [["material", "E", "nu", "density"]]
    for name in materials.names():
        body = materials.get(name).elasticity.data
        rows.append([name, f"{body.E / 1e9:.3g} GPa", f"{body.nu:g}", f"{body.density:g} kg/m^3"])
    print_rows(rows)


def print_entry(entry: NamedOil | Material) -> None:
    """All data of an oil or a material, each part with its range, its source and a note."""
    print_text(f"{entry.name}: {entry.text}", bold=True)
    for title, part in _parts(entry):
        print_text(f"\n{title}, {_range(part.coldest, part.hottest)}: {part.data.title}")
        marks_of = marks(type(part.data))
        for name, value in asdict(part.data).items():
            if value is not None:
                mark = marks_of.get(name)
                text = with_prefix(*in_celsius(value, mark.unit)) if isinstance(mark, Unit) else f"{value:g}"
                print_text(f"  {name} = {text}")
        print_text(f"  source: {part.source}")
        if part.note:
            print_text(f"  note: {' '.join(part.note.split())}")


def entry_as_data(entry: NamedOil | Material) -> dict[str, Any]:
    """All data of an oil or a material in SI, for JSON."""
    content: dict[str, Any] = {"name": entry.name, "text": entry.text}
    for title, part in _parts(entry):
        about = {name: value for name, value in vars(part).items() if name != "data"}
        content[title] = {"law": part.data.title, **asdict(part.data), **about}
    return content


def library_as_data() -> dict[str, list[dict[str, Any]]]:
    """All oils and materials in SI, for JSON."""
    libraries: dict[str, Any] = {"oils": oils, "materials": materials}
    return {kind: [entry_as_data(library.get(name)) for name in library.names()] for kind, library in libraries.items()}


def _parts(entry: NamedOil | Material) -> Iterator[tuple[str, Sourced[Any]]]:
    for name, part in vars(entry).items():
        if isinstance(part, Sourced):
            yield TITLES.get(name, name), part


def _range(coldest: float, hottest: float) -> str:
    if coldest == hottest:
        return celsius(coldest)
    return f"{celsius(coldest).removesuffix(' degC')} to {celsius(hottest)}"
