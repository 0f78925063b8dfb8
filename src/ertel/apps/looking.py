"""Commands that look at runs: `ertel ls` at many, `compare` at two, `show`, `plot` and `export` at one."""

from collections.abc import Mapping, Sequence
from datetime import datetime
from os.path import lexists
from pathlib import Path
from typing import Annotated, Any, Literal

import typer

from ertel.apps.arguments import (
    USUAL,
    Json,
    Measured,
    Moment,
    Overwrite,
    Report,
    RunDirectory,
    figures,
    grouped,
    option,
    path_argument,
    path_option,
)
from ertel.apps.measuring import compare_measured, measurement_in
from ertel.apps.terminal import BAD_INPUT, bad_input, leave, placing, print_json, print_text, say, shown

SIGMA_HELP = 'Rms roughness for the lambda ratio: "20 nm, 60 nm", one for both together, or "Ra 50 nm", times 1.25.'
Along = Annotated[Literal["x", "y"], option("The direction of a profile.")]
FOLDER_HELP = "Folder with runs, also in folders below it; default this one."
Lighting = Literal["mono", "two-beam", "white"]
FRINGES_HELP = "Draw the interference fringes instead: monochromatic, of two beams only, or in white light."
Format = Literal["png", "svg", "pdf", "webp", "gif", "mp4"]
MOVIES = ("webp", "gif", "mp4")
LATEST = 2.5e11  # s, in the year 9892: a file system may say a time that no calendar has


def ls(folder: Annotated[Path | None, path_argument("DIR", FOLDER_HELP)] = None, as_json: Json = False) -> None:
    """List the runs in a folder: case, status, time and key numbers of each."""
    folder = folder or Path.cwd()
    runs = listed(folder)
    if as_json:
        print_json(runs)
    elif not runs:
        say(f"no runs in {shown(folder)}")
    else:
        _print_runs(runs, folder)


def listed(folder: Path) -> list[dict[str, Any]]:
    """The runs in a folder and in those below it as data, in the order of their names; a run directory is itself one.

    status: as in the summary; "running", or "unfinished" where no process is at it; "damaged" of a run that cannot be
    read, which has no name, kind, method and numbers.  done: the share of the run.  written: when it was last changed.
    Raises OSError where the folder cannot be read; a folder below it that cannot be read is left out.
    """
    from ertel.runs.directory import find_runs

    next(folder.iterdir(), None)
    return [_run_as_data(run, folder) for run in sorted(find_runs(folder))]


def _run_as_data(run: Path, folder: Path) -> dict[str, Any]:
    from ertel.case.status import Status
    from ertel.results.numbers import scalars
    from ertel.runs.directory import CASE, PROGRESS, SUMMARY, read_case, read_progress, read_summary, status_of
    from ertel.runs.files import StoreError, reading

    files = [run / name for name in (CASE, PROGRESS, SUMMARY)]
    changed = max((path.lstat().st_mtime for path in files if lexists(path)), default=0.0)
    written = datetime.fromtimestamp(min(max(changed, 0.0), LATEST)).isoformat(timespec="seconds")
    data = {"directory": str(run.relative_to(folder)), "status": "damaged", "done": 0.0, "written": written}
    try:
        case, summary = read_case(run), read_summary(run)
        with reading(run / SUMMARY, ""):
            table = scalars(summary) if summary else {}
    except (StoreError, OSError):
        return {**data, "numbers": {}}
    finished = summary and Status(summary["status"]).ok
    data |= {"status": status_of(run, summary), "done": 1.0 if finished else (read_progress(run) or data)["done"]}
    data |= {"name": case.name, "kind": case.kind, "method": case.solver.method}
    return {**data, "numbers": {name: {"value": each.value, **each.attributes} for name, each in table.items()}}


def _print_runs(every: Sequence[Mapping[str, Any]], folder: Path) -> None:
    """Print the runs, then a row for each study in the place of its runs."""
    from ertel.apps.browser.folder import about_study
    from ertel.apps.tables import print_rows
    from ertel.case.status import Status
    from ertel.results.variables import VARIABLES, in_celsius, name_in_si, stored_in, with_prefix
    from ertel.runs.directory import study_of

    runs: list[Mapping[str, Any]] = []
    studies: dict[Path, list[Mapping[str, Any]]] = {}
    for run in every:
        study = study_of(folder / run["directory"], folder)
        (studies.setdefault(study, []) if study else runs).append(run)
    shown = {about for run in runs for about in stored_in(run["numbers"], lambda variable: variable.shown).values()}
    names = ["M", "L", *(name for name, about in VARIABLES.items() if about in shown)]
    rows = [["run", "case", "status", "written", *names]]
    for run in runs:
        case = f"{run['name'] or run['kind']}, {run['method']}" if "kind" in run else ""
        status = run["status"] if run["done"] >= 1 else f"{run['status']} {run['done']:.0%}"
        numbers = [run["numbers"].get(name_in_si(name)) or run["numbers"].get(name) for name in names]
        texts = [with_prefix(*in_celsius(each["value"], each["units"])) if each else "" for each in numbers]
        rows.append([run["directory"], case, status, _minute(run["written"]), *texts])
    failures = {status.value for status in Status if status.failed}
    for study, of in studies.items():
        failed, last = sum(run["status"] in failures for run in of), max(run["written"] for run in of)
        done = sum(run["done"] >= 1 and run["status"] not in failures for run in of)
        status = f"{done} of {len(of)} runs done{f', {failed} failed' if failed else ''}"
        rows.append([str(study.relative_to(folder)), about_study(study), status, _minute(last), *("" for _ in names)])
    print_rows(rows, left=4)


def _minute(written: str) -> str:
    """A time in ISO 8601 without its seconds, for reading."""
    return written[:16].replace("T", " ")


@grouped
def compare(
    first: RunDirectory,
    second: Annotated[Path, path_argument("DIR|FILE", "Directory of a run, or a file of columns.")],
    given: Measured,
    plot: Annotated[
        Path | None, path_option("Draw both; without FILE into DIR/plots, as compared-NAME.png.", "[FILE]")
    ] = None,
    along: Along = "x",
    as_json: Json = False,
    overwrite: Overwrite = False,
) -> None:
    """Compare two runs: where their cases differ, and their numbers side by side. Or a run with a measurement.

    A file has a measured profile, columns x, y or r and h or p, or a history, columns t and h_c or others; with units,
    as x_um or x (um). A curve, columns mean_speed and h_c, is compared with a study, given by its directory. A column
    intensity has the light of an interferometer along a line; wavelength, layers and index are those of its rig.
    """
    named = plot is not None and plot.name != USUAL
    if plot and not named:
        plot = first / "plots" / f"compared-{second.stem}.png"
    if second.is_file():
        if second.suffix in (".toml", ".json", ".npz"):  # of cases and runs
            leave(BAD_INPUT, f"{shown(second)} is not a file of columns; for a run give its directory")
        with bad_input():
            measurement = measurement_in(second, given, along=along)
        compare_measured(first, measurement, plot, as_json, overwrite, named)
        return
    wrong = [name for name, each in {**vars(given), "along": along != "x"}.items() if each]
    if wrong and second.is_dir():
        leave(BAD_INPUT, f"--{wrong[0]}: only for a measurement, and {shown(second)} is not a file")
    from ertel.results import numbers
    from ertel.runs.store import RunStore

    one, two = RunStore.open(first), RunStore.open(second)
    summaries = [run.summary() or run.summary_so_far() for run in (one, two)]
    names, statuses = [shown(first), shown(second)], [summary["status"] for summary in summaries]
    differing = numbers.differences(one.case.to_data(), two.case.to_data())
    pairs = numbers.pairs(*summaries)
    if as_json:
        print_json({"case": differing, "numbers": pairs})
    else:
        _print_differences(differing, names)
        _print_pairs(pairs, statuses)
    if plot:
        from ertel import plots

        data = [run.dataset() for run in (one, two)]
        short = [run.case.name or run.directory.name for run in (one, two)]
        with bad_input(), placing(plot.parent, overwrite, named, [plot.name]) as place:
            plots.comparison(data, names if short[0] == short[1] else short).savefig(place / plot.name)
        print_text(shown(plot))


def _print_differences(differing: Sequence[Mapping[str, Any]], names: Sequence[str]) -> None:
    from ertel.apps.tables import print_rows
    from ertel.case.records import show

    rows = []
    for each in differing:
        values = ["" if each[run] is None else show(each[run]) for run in ("first", "second")]
        rows.append((each["field"], *values))
    print_rows([("case", *names), *rows, ("", "", "")] if rows else [("The cases are the same.",), ("",)], left=3)


def _print_pairs(pairs: Sequence[Mapping[str, Any]], statuses: Sequence[str]) -> None:
    from ertel.apps.tables import print_rows
    from ertel.results.variables import in_celsius, with_prefix

    rows = [("number", "", "first", "second", "change"), ("status", "", *statuses, "")]
    for pair in pairs:
        about, change = pair["attributes"], pair["change"]
        known = [pair[run] for run in ("first", "second")]
        values = ["" if value is None else with_prefix(*in_celsius(value, about["units"])) for value in known]
        rows.append((about["long_name"], pair["name"], *values, "" if change is None else f"{change:+.2%}"))
    print_rows(rows, left=2)


def show(
    directory: RunDirectory,
    as_json: Json = False,
    sigma: Annotated[str | None, option(SIGMA_HELP, "LENGTHS")] = None,
    about: Annotated[
        bool, typer.Option("--about", help="Print the versions and the machine, and how it ended.")
    ] = False,
) -> None:
    """Print the summary of a run, also of an unfinished one."""
    from ertel.apps import running, tables
    from ertel.apps.about import of_run
    from ertel.runs.store import RunStore

    if sigma is not None and len(sigma.split(",")) > 2:
        leave(BAD_INPUT, f"--sigma {sigma}: must be one length or two, of the two surfaces")
    run = RunStore.open(directory)
    if about:
        print_json(of_run(run)) if as_json else tables.print_names(of_run(run))
        return
    summary = run.summary() or run.summary_so_far()
    running.report(run, summary, Report(as_json), sigma.split(",") if sigma is not None else ())


@grouped
def plot(
    directory: RunDirectory,
    given: Measured,
    what: Annotated[str | None, option("Draw this figure only, such as film.", "NAME", figures)] = None,
    interferogram: Annotated[Lighting | None, option(FRINGES_HELP)] = None,
    measured: Annotated[
        Path | None, path_option("Draw a measured profile too: film, pressure, or light of an interferogram.", "FILE")
    ] = None,
    format_: Annotated[
        Format, option("File format; webp (the smallest), gif and mp4 are movies of a run in time.", name="--format")
    ] = "png",
    rate: Annotated[float | None, option("Frames a second of a movie, 1 to 50; default 12.", min=1.0, max=50.0)] = None,
    columns: Annotated[
        int | None, option("Draw for print, one or two columns wide: 85 or 170 mm.", min=1, max=2)
    ] = None,
    title: Annotated[bool, typer.Option("--title/--no-title", help="Draw headings.")] = True,
    out: Annotated[Path | None, path_option("Directory for the figures; default DIR/plots.")] = None,
    overwrite: Overwrite = False,
) -> None:
    """Draw the figures of a run, or an interferogram of its film. Those at a time show the map next to it.

    An interferogram needs a case in SI. It is that of a steel ball on glass; from Python other media and light sources
    can be chosen, see ertel.optics. A file of --measured is as that of `ertel compare`; it is drawn on the profiles,
    or with --interferogram beside its light.

    --what film --format webp --rate 20 makes a movie of eight seconds, of the film or the pressure. That of an
    interferogram has a frame for each map.
    """
    if format_ in MOVIES and interferogram is None and what not in ("film", "pressure"):
        needed = "--what film, --what pressure or --interferogram mono"
        leave(BAD_INPUT, f"--format {format_}: needs {needed}; no other picture can be a movie")
    if rate is not None and format_ not in MOVIES:
        leave(BAD_INPUT, f"--rate {rate:g}: only for movies; add --format webp")
    if format_ in MOVIES and given.at is not None:
        leave(BAD_INPUT, f"--at {given.at}: a movie shows all times; leave it out, or use --format png")
    if format_ in MOVIES and (columns or not title or measured):
        leave(BAD_INPUT, "--columns, --no-title, --measured: only for pictures; a movie has none, use --format png")
    if given.wavelength is not None and interferogram in (None, "white"):
        leave(BAD_INPUT, f"--wavelength {given.wavelength}: only for --interferogram mono or two-beam")
    if given.coatings and interferogram is None:
        leave(BAD_INPUT, f"--coatings {given.coatings}: only for --interferogram")
    if (given.align or given.column) and measured is None:
        leave(BAD_INPUT, "--align, --column: only for --measured")
    if format_ == "mp4":
        _find_ffmpeg()
    from ertel import plots
    from ertel.inputs.fits import interferometer
    from ertel.plots.movies import PER_SECOND, save_movie
    from ertel.runs.store import RunStore

    data = RunStore.open(directory).dataset()
    sheet: Any = {"columns": columns, "title": title}
    target, pace = out or directory / "plots", rate or PER_SECOND
    with bad_input():
        rig = interferometer(interferogram or "mono", given.wavelength, given.coatings, given.index)
        if measured is not None:
            sheet["measured"] = measurement_in(measured, given, interferogram or "mono")
        overlaid = [each for each in plots.names_of(data) if measured and each in plots.OVERLAID]
        names = [what] if what else overlaid or plots.names_of(data)
        names = [f"interferogram-{interferogram}"] if interferogram else names
        files = [f"{name}.{format_}" for name in names]
        with placing(target, overwrite, out is not None, files) as place:
            for name, file in zip(names, files, strict=True):
                if format_ in MOVIES:
                    seen = interferogram and plots.animation(data, rig.light, rig.rig, rate=pace)
                    save_movie(seen or plots.movie(data, name, pace), place / file, pace)
                elif interferogram:
                    plots.interferogram(data, given.at, rig.light, rig.rig, **sheet).savefig(place / file)
                else:
                    plots.draw(data, name, given.at, **sheet).savefig(place / file)
    for file in files:
        print_text(shown(target / file))


def _find_ffmpeg() -> None:
    """Tell matplotlib where the program is that writes mp4."""
    from matplotlib import rcParams

    try:
        from imageio_ffmpeg import get_ffmpeg_exe
    except ImportError:
        leave(BAD_INPUT, "--format mp4: needs imageio-ffmpeg, pip install 'ertel[movie]'; webp and gif do not")
    rcParams["animation.ffmpeg_path"] = get_ffmpeg_exe()


def export(
    directory: RunDirectory,
    to: Annotated[Literal["csv", "netcdf", "vtk"], option("Tables, NetCDF, or maps for ParaView.")] = "csv",
    what: Annotated[
        Literal["profile", "stress"] | None,
        option("Film, pressure and oil along a line through the centre, or the stresses in the section below it."),
    ] = None,
    at: Moment = None,
    along: Along = "x",
    body: Annotated[int, option("The body of --what stress.", min=1, max=2)] = 1,
    in_si: Annotated[bool, typer.Option("--si", help="Convert to SI; needs a case in SI.")] = False,
    out: Annotated[Path | None, path_option("Directory for the files; default DIR/export.")] = None,
    overwrite: Overwrite = False,
) -> None:
    """Write a run for other programs.

    csv: the scalars over time as history.csv, of a steady contact over its grids as grids.csv. netcdf: the whole run as
    run.nc, NetCDF 3. vtk: the maps as maps_0000.vti, ... with maps.pvd for ParaView; needs the extra ertel[paraview].

    Values are dimensionless, with their factors to SI in the attributes; --si converts them.

    --what profile: profile_x.csv or profile_y.csv, in SI where the case is, with units in the names of the columns.
    Between two maps it is interpolated in time.

    --what stress: stress_x.csv or stress_y.csv with a row for each node of the section through the centre of body 1 or
    2, or stress_x.nc with --to netcdf; otherwise as a profile.
    """
    from ertel.case.status import Status
    from ertel.results.dataset import EXPORTS
    from ertel.results.profiles import write_profile
    from ertel.results.stress import stress, write_stress
    from ertel.results.variables import to_si
    from ertel.runs.store import RunStore

    if what == "profile" and to != "csv":
        leave(BAD_INPUT, f"--to {to}: a profile is written as csv")
    if what == "stress" and to == "vtk":
        leave(BAD_INPUT, f"--to {to}: stresses are written as csv or netcdf")
    if at is not None and not what:
        leave(BAD_INPUT, f"--at {at}: only for --what profile or stress; the other exports have all times")
    if along != "x" and not what:
        leave(BAD_INPUT, f"--along {along}: only for --what profile or stress")
    if body != 1 and what != "stress":
        leave(BAD_INPUT, f"--body {body}: only for --what stress")
    run = RunStore.open(directory)
    data = run.dataset()
    if (status := Status(data.attrs["status"])).failed:
        say(f"ertel: warning: the run failed ({status.value}); the files hold what it computed before that")
    target = out or directory / "export"
    with bad_input(), placing(target, overwrite, may_be_link=out is not None) as place:
        if what == "stress":
            stresses = stress(run.case, data, at, body, along=along)
            say(f"body {body}, along {along}, {stresses.attrs['moment']}")
            paths = [write_stress(stresses, place, to)]
        elif what:
            path, moment = write_profile(data, place, at, along)
            say(f"along {along}, {moment}")
            paths = [path]
        else:
            paths = EXPORTS[to](to_si(data) if in_si else data, place)
    for path in paths:
        print_text(shown(target / path.name))
