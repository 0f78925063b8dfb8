"""`ertel ls`, `ertel compare` and `ertel export`: many runs, two, or one for other programs."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from ertel.apps.arguments import Json, RunDirectory, path_argument, path_option, run_directories
from ertel.apps.terminal import bad_input, print_json, print_path, say, shown

if TYPE_CHECKING:
    from ertel.results.numbers import Compared, Difference
    from ertel.runs.directory import Listed


def ls(
    folder: Annotated[
        Path | None,
        path_argument("[DIR]", "Folder with runs, also in folders below it; default this one.", run_directories),
    ] = None,
    as_json: Json = False,
) -> None:
    """List the runs in a folder: case, status, time and key numbers of each."""
    from ertel.runs.directory import listed

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
    case, directory = run.case, str(run.directory.relative_to(folder))
    state = {"directory": directory, "status": run.status, "done": run.done}
    about = {"name": case.name, "kind": case.kind, "method": case.solver.method} if case else {}
    numbers = {name: {"value": number.value, **number.attributes} for name, number in run.numbers.items()}
    return {**state, "written": run.written.isoformat(timespec="seconds"), **about, "numbers": numbers}


def _print_runs(runs: "Sequence[Listed]", folder: Path) -> None:
    from ertel.apps.tables import print_rows
    from ertel.results.numbers import SHOWN
    from ertel.results.variables import name_in_si

    known = {name for run in runs for name in run.numbers}
    names = ["M", "L", *(name for name in SHOWN if known & {name, name_in_si(name)})]
    print_rows([("run", "case", "status", "written", *names), *(_row(run, folder, names) for run in runs)], left=4)


def _row(run: "Listed", folder: Path, names: Sequence[str]) -> list[str]:
    """A run in the list, with its numbers of these names."""
    from ertel.results.variables import name_in_si, with_prefix

    case = f"{run.case.name or run.case.kind}, {run.case.solver.method}" if run.case else ""
    status = run.status if run.done >= 1 else f"{run.status} {run.done:.0%}"
    numbers = [run.numbers.get(name_in_si(name)) or run.numbers.get(name) for name in names]
    texts = [with_prefix(number.value, number.attributes["units"]) if number else "" for number in numbers]
    return [str(run.directory.relative_to(folder)), case, status, f"{run.written:%Y-%m-%d %H:%M}", *texts]


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
    names, statuses = [shown(first), shown(second)], [summary["status"] for summary in summaries]
    differing = numbers.differences(one.case, two.case)
    pairs = numbers.pairs(*summaries)
    if as_json:
        rows = [{**pair._asdict(), "change": pair.change} for pair in pairs]
        print_json({"case": [difference._asdict() for difference in differing], "numbers": rows})
    else:
        _print_differences(differing, names)
        _print_pairs(pairs, statuses)
    if plot:
        from ertel import plots

        with bad_input():
            plots.comparison(data, names).savefig(plot)
        print_path(plot)


def _print_differences(differing: "Sequence[Difference]", names: Sequence[str]) -> None:
    from ertel.apps.tables import print_rows
    from ertel.case.records import show

    rows = [(field, *("" if value is None else show(value) for value in values)) for field, *values in differing]
    print_rows([("case", *names), *rows, ("", "", "")] if rows else [("The cases are the same.",), ("",)], left=3)


def _print_pairs(pairs: "Sequence[Compared]", statuses: Sequence[str]) -> None:
    from ertel.apps.tables import print_rows
    from ertel.results.variables import with_prefix

    rows = [("number", "", "first", "second", "change"), ("status", "", *statuses, "")]
    for pair in pairs:
        unit = pair.attributes["units"]
        values = ["" if value is None else with_prefix(value, unit) for value in (pair.first, pair.second)]
        change = "" if pair.change is None else f"{pair.change:+.2%}"
        rows.append((pair.attributes["long_name"], pair.name, *values, change))
    print_rows(rows, left=2)


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
