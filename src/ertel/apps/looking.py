"""`ertel ls`, `ertel compare` and `ertel export`: many runs, two, or one for other programs."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from ertel.apps.arguments import Json, RunDirectory, path_argument, path_option, run_directories
from ertel.apps.terminal import bad_input, print_json, print_path, say, shown

if TYPE_CHECKING:
    from ertel.results.numbers import Pair
    from ertel.runs.listing import Listed


def ls(
    folder: Annotated[
        Path | None,
        path_argument("[DIR]", "Folder with runs, also in folders below it; default this one.", run_directories),
    ] = None,
    as_json: Json = False,
) -> None:
    """List the runs in a folder: case, status, time and key numbers of each."""
    from ertel.runs.listing import listed

    folder = folder or Path.cwd()
    with bad_input():
        found = listed(folder)
    if as_json:
        print_json([_as_data(run, folder) for run in found])
    elif not found:
        say(f"no runs in {shown(folder)}")
    else:
        _print_runs(found, folder)


def _as_data(run: "Listed", folder: Path) -> dict[str, Any]:
    case = run.case
    about = {"name": case.name, "kind": case.kind, "method": case.solver.method} if case else {}
    numbers = {name: {"value": number.value, **number.attributes} for name, number in run.numbers.items()}
    place = {"directory": _below(run.directory, folder), "status": run.status, "done": run.done}
    return {**place, "written": run.written.isoformat(timespec="seconds"), **about, "numbers": numbers}


def _below(directory: Path, folder: Path) -> str:
    return str(directory.relative_to(folder))


def _print_runs(runs: "Sequence[Listed]", folder: Path) -> None:
    from ertel.results.numbers import SHOWN
    from ertel.results.variables import name_in_si

    names = [name for name in SHOWN if any(name in run.numbers or name_in_si(name) in run.numbers for run in runs)]
    about = [(f"{run.case.name or run.case.kind}, {run.case.solver.method}" if run.case else "") for run in runs]
    columns = [
        ["run", *(_below(run.directory, folder) for run in runs)],
        ["case", *about],
        ["status", *(run.status if run.done >= 1 else f"{run.status} {run.done:.0%}" for run in runs)],
        ["written", *(f"{run.written:%Y-%m-%d %H:%M}" for run in runs)],
    ]
    columns += [[name, *(_number(run, name, name_in_si(name)) for run in runs)] for name in ("M", "L", *names)]
    _print_lines(columns, 4)


def _print_lines(columns: Sequence[Sequence[str]], left: int) -> None:
    from ertel.apps import tables
    from ertel.results.report import aligned

    out = tables.console()
    for line in aligned(columns, left):
        out.print(line)


def _number(run: "Listed", name: str, name_in_si: str) -> str:
    number = run.numbers.get(name_in_si) or run.numbers.get(name)
    return "" if number is None else _with_unit(number.value, number.attributes["units"])


def _with_unit(value: float, unit: str) -> str:
    from ertel.results.variables import with_prefix

    return with_prefix(value, unit)


def compare(
    first: RunDirectory,
    second: RunDirectory,
    plot: Annotated[
        Path | None, path_option("Draw film and pressure of both into a file, such as both.png.", "FILE")
    ] = None,
    as_json: Json = False,
) -> None:
    """Compare two runs: where their cases differ, and their numbers side by side."""
    from ertel.apps import running
    from ertel.results import numbers

    with running.opened(first) as one, running.opened(second) as two:
        summaries = [run.summary() or run.summary_so_far() for run in (one, two)]
        data = [run.dataset() for run in (one, two)] if plot else []
    cases = [run.case for run in (one, two)]
    differing = numbers.differences(*cases)
    pairs = numbers.pairs(*summaries)
    if as_json:
        rows = [{**pair._asdict(), "change": pair.change} for pair in pairs]
        print_json({"case": [difference._asdict() for difference in differing], "numbers": rows})
    else:
        _print_differences(differing, [shown(first), shown(second)])
        _print_pairs(pairs, [summary["status"] for summary in summaries])
    if plot:
        _draw(data, [shown(first), shown(second)], plot)


def _print_differences(differing: Sequence[Any], names: Sequence[str]) -> None:
    from ertel.case.records import show

    rows = [(field, *("" if value is None else show(value) for value in values)) for field, *values in differing]
    rows = [("case", *names), *rows] if rows else [("The cases are the same.",)]
    _print_lines([*zip(*[*rows, [""] * len(rows[0])], strict=True)], 3)


def _print_pairs(pairs: "Sequence[Pair]", statuses: Sequence[str]) -> None:
    rows = [("number", "", "first", "second", "change"), ("status", "", *statuses, ""), *map(_cells, pairs)]
    _print_lines([*zip(*rows, strict=True)], 2)


def _cells(pair: "Pair") -> tuple[str, ...]:
    unit = pair.attributes["units"]
    first, second = ("" if value is None else _with_unit(value, unit) for value in (pair.first, pair.second))
    change = "" if pair.change is None else f"{pair.change:+.2%}"
    return pair.attributes["long_name"], pair.name, first, second, change


def _draw(data: Sequence[Any], names: Sequence[str], path: Path) -> None:
    from ertel import plots

    with bad_input():
        figure = plots.comparison(data, names)
        figure.savefig(path)
    print_path(path)


def export(
    directory: RunDirectory,
    to: Annotated[
        Literal["netcdf", "csv", "vtk"],
        typer.Option("--to", help="NetCDF, tables of the scalars, or maps for ParaView."),
    ],
    in_si: Annotated[bool, typer.Option("--si", help="Convert to SI; needs a case in SI.")] = False,
    out: Annotated[Path | None, path_option("Directory for the files; default DIR/export.")] = None,
) -> None:
    """Write a run for other programs.

    netcdf: the whole run as run.nc, NetCDF 3. csv: the scalars over time as history.csv, of a steady contact over its
    grids as grids.csv. vtk: the maps as maps_0000.vti, ... with maps.pvd for ParaView; needs the extra ertel[paraview].

    Values are dimensionless, with their factors to SI in the attributes; --si converts them.
    """
    from ertel.apps import running
    from ertel.results import export as exports
    from ertel.results.variables import to_si

    with running.opened(directory) as run:
        data = run.dataset()
    target = out or directory / "export"
    with bad_input():
        shown_data = to_si(data) if in_si else data
        target.mkdir(parents=True, exist_ok=True)
        paths = exports.EXPORTS[to](shown_data, target)
    for path in paths:
        print_path(path)
