"""Commands that need no run: `ertel params`, `film`, `new`, `schema`, `check` and `oils`."""

import json
from pathlib import Path
from textwrap import wrap
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from ertel.apps.arguments import CaseFile, Json, OptionalCase, Set, path_argument
from ertel.apps.terminal import BAD_INPUT, bad_input, in_shell, leave, print_json, print_path, shown

if TYPE_CHECKING:
    from ertel.case.case import Case

WIDTH = 100


def params(case_file: OptionalCase = None, set_: Set = None, as_json: Json = False) -> None:
    """Print all parameters of a contact.

    Give a case file, or the contact alone: --set contact.M=1000 --set contact.L=10, or quantities such as
    --set "contact.radius=10 mm". Without a file the contact is an impact unless --set contact.kind=rolling, and its oil
    follows the Barus law. A message names what is missing; ertel run --help-keys explains all keys.
    """
    from ertel.results.parameters import parameter_summary

    case = _case_asked_for(case_file, set_, "impact")
    content = parameter_summary(case)
    if as_json:
        print_json(content)
    else:
        from ertel.apps import tables

        tables.print_parameters(content)


def film(case_file: OptionalCase = None, set_: Set = None, as_json: Json = False) -> None:
    """Compare the film thickness formulas for a rolling contact.

    Give a case file, or the contact alone: --set contact.M=200 --set contact.L=10, see ertel params.
    """
    from ertel.apps import tables
    from ertel.results.parameters import formula_films

    case = _case_asked_for(case_file, set_, "rolling")
    if case.starts_apart:
        leave(BAD_INPUT, f'contact.kind = "{case.kind}": must be "rolling" for the film formulas')
    films = formula_films(case, case.motion.load(0.0), case.motion.entrainment(0.0))
    if as_json:
        print_json(tables.films_as_data(case, films))
    else:
        tables.print_films(case, films)
        tables.print_sources(films)


def _case_asked_for(case_file: Path | None, settings: list[str] | None, kind: str) -> "Case":
    """The same as `_case_given`, also of a contact that is too light for a run: the formulas know it."""
    from ertel.case.records import ConfigError
    from ertel.case.rules import TooLight

    try:
        return _case_given(case_file, settings, kind)
    except ConfigError as error:
        if not isinstance(error.__cause__, TooLight):
            raise
        case: Case = error.__cause__.case
        return case


def _case_given(case_file: Path | None, settings: list[str] | None, kind: str) -> "Case":
    """The case of a file, or of settings alone, whose oil follows Barus and is incompressible unless they say more."""
    from ertel.inputs.case_files import apply_overrides, load_case, parse_case

    if case_file:
        return load_case(case_file, settings or [])
    data = apply_overrides({"contact": {"kind": kind}, "lubricant": {}}, settings or [])
    contact, oil = data["contact"], data["lubricant"]
    if isinstance(contact, dict) and isinstance(oil, dict) and "oil" not in oil:
        isoviscous = 0 in (contact.get("L"), contact.get("alpha_bar"))
        data["lubricant"] = {"viscosity": "isoviscous" if isoviscous else "barus", "density": "incompressible", **oil}
    return parse_case(data)


def on_track_of(directory: Path | None) -> list[str]:
    """The setting that takes the oil which an earlier run leaves behind; none without a run."""
    if directory is None:
        return []
    from ertel.runs.store import open_run

    with bad_input():
        return [f"lubricant.layer={json.dumps(open_run(directory).track)}"]


def new(
    kind: Annotated[Literal["impact", "rolling"], typer.Argument(help="Kind of contact.")],
    file: Annotated[Path | None, path_argument("FILE", "New case file; default KIND.toml.")] = None,
) -> None:
    """Write a new case file that runs, with all keys and their meanings.

    Beside it the file ertel.schema.json is written, unless it is there: from it editors with TOML support show meanings
    and complete keys.
    """
    from ertel.inputs.templates import SCHEMA_FILE, json_schema_text, template

    path = file or Path(f"{kind}.toml").absolute()
    path.parent.mkdir(parents=True, exist_ok=True)
    if not _write_new(path, template(kind, in_shell(path))):
        leave(BAD_INPUT, f"{shown(path)} exists already and is left as it is; give another FILE")
    print_path(path)
    schema = path.with_name(SCHEMA_FILE)
    if _write_new(schema, json_schema_text()):
        print_path(schema)


def _write_new(path: Path, text: str) -> bool:
    """Write a file; False if it is there already."""
    try:
        with path.open("x", encoding="utf-8") as file:
            file.write(text)
    except FileExistsError:
        return False
    return True


def schema(
    as_table: Annotated[bool, typer.Option("--table", help="Print the table of all keys, in Markdown.")] = False,
) -> None:
    """Print the JSON schema of case files, for editors and checkers.

    With ertel schema > ertel.schema.json and the line #:schema ./ertel.schema.json at the head of a case file editors
    show what keys mean, complete them, and mark what is wrong. Units are known to it in their usual spellings only.
    """
    from ertel.inputs.layout import places
    from ertel.inputs.templates import json_schema_text, table

    print(table(places()) if as_table else json_schema_text(), end="")


def print_keys(requested: bool) -> None:
    """Print all keys with their meanings, and end; the callback of --help-keys."""
    if not requested:
        return
    from ertel.inputs.layout import places

    for title, text, keys in places():
        print(f"\n{title}  {text}" if title != "(top)" else "Keys of case files")
        for key in keys:
            print(f"  {key.title}")
            for line in wrap(key.meaning.text, WIDTH):
                print(f"      {line}")
    raise typer.Exit


def check(case_file: CaseFile, set_: Set = None, as_json: Json = False) -> None:
    """Check a case without running it: parameters, scales, film formulas, grid, memory, time, warnings.

    The time is a rough estimate for one or two cores, within a factor of three.
    """
    from ertel.inputs.case_files import load_case
    from ertel.runs.outlook import outlook

    case = load_case(case_file, set_ or [])
    content = outlook(case)
    if as_json:
        print_json(content)
        return
    from ertel.apps import tables
    from ertel.results.parameters import formula_films

    out = tables.console()
    out.print(f"{case.name or case.kind}: {case.kind}, {case.solver.method}", style="bold")
    tables.print_parameters(content["parameters"])
    formulas = formula_films(case, case.motion.load(0.0), case.motion.entrainment(0.0))
    if formulas:
        out.print()
        tables.print_films(case, formulas)
    out.print()
    tables.print_names(tables.needs(content))
    for warning in content["warnings"]:
        out.print(f"Warning: {warning}", style="yellow")


def oils(
    name: Annotated[str | None, typer.Argument(metavar="NAME", help="An oil or a material.")] = None,
    as_json: Json = False,
) -> None:
    """Print the oils and materials that case files know by name, or all data of one with their sources."""
    from ertel.apps import tables

    entry = tables.oil_or_material(name) if name else None
    if as_json:
        print_json(tables.entry_as_data(entry) if entry else tables.library_as_data())
    elif entry:
        tables.print_entry(entry)
    else:
        tables.print_library()
