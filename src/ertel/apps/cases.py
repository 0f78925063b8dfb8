"""Commands that need no run: `ertel check`, `new` and `oils`."""

import json
from pathlib import Path
from textwrap import wrap
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from ertel.apps.arguments import Json, Set, path_argument
from ertel.apps.terminal import BAD_INPUT, bad_input, in_shell, leave, print_json, print_text, shown

if TYPE_CHECKING:
    from ertel.case.case import Case

WIDTH = 100


def _case_given(case_file: Path | None, settings: list[str] | None) -> "Case":
    """The case of a file, or of settings alone, whose oil follows Barus and is incompressible unless they say more."""
    from ertel.inputs.case_files import apply_overrides, load_case, parse_case

    if case_file:
        return load_case(case_file, settings or [])
    data = apply_overrides({"contact": {}, "lubricant": {}}, settings or [])
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


def print_schema(requested: bool) -> None:
    """Print the JSON schema of case files, and end; the callback of --schema."""
    if requested:
        from ertel.inputs.templates import json_schema_text

        print(json_schema_text(), end="")
        raise typer.Exit


def new(
    kind: Annotated[Literal["impact", "rolling"], typer.Argument(help="Kind of contact.")],
    file: Annotated[Path | None, path_argument("FILE", "New case file; default KIND.toml.")] = None,
    line: Annotated[bool, typer.Option("--line", help="Of a line contact: a roller in place of a ball.")] = False,
    schema: Annotated[
        bool,
        typer.Option("--schema", is_eager=True, callback=print_schema, help="Print the JSON schema of case files."),
    ] = False,
) -> None:
    """Write a new case file that runs, with all keys and their meanings.

    Beside it the file ertel.schema.json is written, unless it is there: from it editors with TOML support show meanings
    and complete keys, and mark what is wrong. Units are checked by ertel check alone.
    """
    from ertel.inputs.templates import SCHEMA_FILE, json_schema_text, template

    path = file or Path(f"{kind}.toml").absolute()
    path.parent.mkdir(parents=True, exist_ok=True)
    if not _write_new(path, template(kind, in_shell(path), line)):
        leave(BAD_INPUT, f"{shown(path)} exists already and is left as it is; give another FILE")
    print_text(shown(path))
    beside = path.with_name(SCHEMA_FILE)
    if _write_new(beside, json_schema_text()):
        print_text(shown(beside))


def _write_new(path: Path, text: str) -> bool:
    """Write a file; False if it is there already."""
    try:
        with path.open("x", encoding="utf-8") as file:
            file.write(text)
    except FileExistsError:
        return False
    return True


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


def check(
    case_file: Annotated[
        Path | None, path_argument("CASE.toml", "Case file; without one --set gives the contact.")
    ] = None,
    set_: Set = None,
    as_json: Json = False,
) -> None:
    """Check a case without running it: parameters, scales, film formulas, grid, memory, time, warnings.

    Give a case file, or the contact alone: --set contact.M=1000 --set contact.L=10, or quantities such as
    --set "contact.radius=10 mm". Without a file the contact is an impact unless --set contact.kind=rolling, and its oil
    follows the Barus law. A message names what is missing; ertel run --help-keys explains all keys.

    The time is a rough estimate for one or two cores, within a factor of three.
    """
    from ertel.apps import tables
    from ertel.case.records import ConfigError
    from ertel.case.rules import AT_FORMULAS, TooLight
    from ertel.results.parameters import parameter_summary
    from ertel.runs.outlook import outlook

    try:
        case = _case_given(case_file, set_)
    except ConfigError as error:
        if not isinstance(error.__cause__, TooLight):
            raise
        light = error.__cause__.case  # for a run; the formulas know such contacts
        if as_json:
            print_json({**parameter_summary(light), "films": tables.films_as_data(light)})
        else:
            tables.print_formulas(light)
        raise ConfigError(str(error).removesuffix(AT_FORMULAS)) from error
    content = outlook(case)
    if as_json:
        print_json({**content, "films": tables.films_as_data(case)})
        return
    print_text(f"{case.name or case.kind}: {case.kind}, {case.solver.method}", bold=True)
    tables.print_formulas(case)
    print_text()
    tables.print_names(tables.needs(content))
    for warning in content["warnings"]:
        print_text(f"Warning: {warning}", fg="yellow")


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
