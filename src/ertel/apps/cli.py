"""The command line.  It reads arguments, prints, and chooses exit codes; the work is done elsewhere.

Commands import what they need inside, so that `ertel --help` and `ertel params` answer at once.

Exit codes: 0 done; 1 failed, results so far are kept; 2 wrong input, nothing written; 130 interrupted, can be resumed
(143 by SIGTERM, 129 by SIGHUP).
"""

import os
from collections.abc import Mapping
from enum import StrEnum
from pathlib import Path
from typing import Annotated, Any

import typer

from ertel.apps import interrupts, output
from ertel.apps.exits import FAILED, bad_input, leave, reason_of
from ertel.apps.faults import Commands
from ertel.apps.flags import case_of_flags, flag_of, with_flags
from ertel.apps.paths import local_path, shown

app = typer.Typer(
    cls=Commands,
    help="Elastohydrodynamic lubrication of point contacts: a ball hits an oiled surface, or rolls and slides on it.",
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)


class Format(StrEnum):
    """What `ertel plot` writes."""

    png = "png"
    svg = "svg"
    pdf = "pdf"


CaseFile = Annotated[
    Path, typer.Argument(parser=local_path, metavar="CASE.toml", help="Case file; see examples/.", show_default=False)
]
RunDirectory = Annotated[
    Path, typer.Argument(parser=local_path, metavar="DIR", help="Directory of a run.", show_default=False)
]
Json = Annotated[bool, typer.Option("--json", help="Print JSON and nothing else.")]
Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="Show no progress bar and no summary.")]
Set = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="KEY=VALUE", help="Replace a value of the case, e.g. solver.nodes=129."),
]
Estimate = Annotated[
    bool,
    typer.Option("--error", help="Run also on the half grid, in smaller steps and on a wider domain: the error."),
]


def _directory(text: str) -> Any:
    """An option for a directory."""
    return typer.Option(parser=local_path, metavar="DIR", help=text, show_default=False)


def _along(example: str, text: str) -> Any:
    """An option for what varies along a curve."""
    return typer.Option(metavar="VALUES", help=f"{text} Such as {example}.", show_default=False)


def main() -> None:
    """The entry point `ertel`."""
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # the small dense solves lose more than they gain by threads
    with output.never_failing():
        app()


@app.callback(invoke_without_command=True)
def _options(
    ctx: typer.Context, version: Annotated[bool, typer.Option("--version", help="Print the version.")] = False
) -> None:
    if version:
        import ertel

        print(f"ertel {ertel.__version__}")
        raise typer.Exit
    if ctx.invoked_subcommand is None:
        print(ctx.get_help())


# -- runs -------------------------------------------------------------------------------------------------------------


@app.command()
def run(
    case_file: CaseFile,
    out: Annotated[Path | None, _directory("New directory for the run; default runs/NAME.")] = None,
    set_: Set = None,
    as_json: Json = False,
    error: Estimate = False,
    quiet: Quiet = False,
) -> None:
    """Run a case and store the results."""
    from ertel.apps import running
    from ertel.inputs.case_files import load_case

    with bad_input():
        case = load_case(case_file, set_ or [])
    running.run(case, out, running.Wishes(as_json, error, quiet))


@app.command()
def resume(directory: RunDirectory, as_json: Json = False, error: Estimate = False, quiet: Quiet = False) -> None:
    """Continue a run that was interrupted."""
    from ertel.apps import running

    running.resume(directory, running.Wishes(as_json, error, quiet))


@app.command()
def traction(
    case_file: CaseFile,
    slide_to_roll: Annotated[str | None, _along("0:0.5:15", "The slide-to-roll ratio varies.")] = None,
    mean_speed: Annotated[str | None, _along("0.1 m/s:10 m/s:12:log", "The mean speed varies.")] = None,
    load: Annotated[str | None, _along("10 N:100 N:5", "The load varies.")] = None,
    film: Annotated[
        str | None, typer.Option(metavar="each|once", help="Solve the film at each point, or once.", show_default=False)
    ] = None,
    set_: Set = None,
    out: Annotated[Path | None, _directory("New directory for the curve; default traction/NAME.")] = None,
    as_json: Json = False,
    quiet: Quiet = False,
) -> None:
    """Compute a traction curve: the friction of a steady contact against slide-to-roll ratio, speed or load.

    Give one of them: FIRST:LAST:NUMBER with equal steps, FIRST:LAST:NUMBER:log with equal ratios, or values with commas
    between them. Without a unit a speed is in m/s and a load in N.

    The film of a Newtonian oil does not depend on the slide-to-roll ratio and is solved once. That of an oil that thins
    is solved at each point; --film once takes the one of the smallest slide-to-roll ratio, in the time of one point.

    After an interruption the same command continues.
    """
    from ertel.apps.traction import traction
    from ertel.inputs.case_files import load_case

    with bad_input():
        case = load_case(case_file, set_ or [])
    given = {"slide_to_roll": slide_to_roll, "mean_speed": mean_speed, "load": load}
    traction(case, given, film, out, as_json, quiet)


@app.command("warm-up")
def warm_up(
    case_files: Annotated[
        list[Path] | None,
        typer.Argument(
            parser=local_path,
            metavar="[CASE.toml]...",
            help="Case files; default the usual grids.",
            show_default=False,
        ),
    ] = None,
    set_: Annotated[
        list[str] | None,
        typer.Option("--set", metavar="KEY=VALUE", help="Replace a value of each case, e.g. solver.nodes=129."),
    ] = None,
) -> None:
    """Compile ahead what runs need, once per machine: then they start at once.

    Without case files: steady rolling on up to 257 nodes per side, impact on 129 and 257 nodes per side and on 401
    nodes along the radius, with a Roelands oil. With case files: their grids, oil laws and kinds of run. Other values
    of a case may differ later. The programs serve all machines of this processor type that share the home directory,
    or the directory XDG_CACHE_HOME.
    """
    from ertel.apps import running
    from ertel.inputs.case_files import load_case
    from ertel.runs.warm_up import usual_cases

    with bad_input():
        if set_ and not case_files:
            raise ValueError(f"--set {set_[0]}: needs a case file; without one the usual grids are compiled")
        cases = [load_case(path, set_ or []) for path in case_files or []] or list(usual_cases())
    running.warm_up_all(cases)


@app.command()
def show(directory: RunDirectory, as_json: Json = False) -> None:
    """Print the summary of a run."""
    from ertel.apps import running

    running.show(directory, as_json)


@app.command()
def plot(
    directory: RunDirectory,
    at: Annotated[
        str | None,
        typer.Option(
            metavar="TIME|EVENT", help="Draw the contact at a time T, or at max-approach or end.", show_default=False
        ),
    ] = None,
    format_: Annotated[Format, typer.Option("--format", help="File format.")] = Format.png,
    out: Annotated[Path | None, _directory("Directory for the figures; default DIR/plots.")] = None,
) -> None:
    """Draw the figures of a run."""
    from ertel.apps import plotting, running

    with running.opened(directory) as run:
        plotting.write_figures(run.dataset(), at, out or directory / "plots", format_.value)


# -- answers at once --------------------------------------------------------------------------------------------------


@app.command()
@with_flags
def params(given: Mapping[str, object], as_json: Json = False) -> None:
    """Print all parameters of a contact.

    The contact is an impact; choose rolling with --kind rolling. Give --M and --L, or --lambda-bar and --alpha-bar,
    or quantities with units such as "10 mm".

    Quantities of every contact: --radius (or --radius-1 and --radius-2), --E-prime (or --E1 --nu1 --E2 --nu2), --eta0
    and --alpha. An impact also needs --mass or --ball-density, and --speed or --drop-height. A rolling contact also
    needs --load, and --mean-speed (with --slide-to-roll if it slides) or --speed-1 and --speed-2.
    """
    from ertel.results.parameters import parameter_summary

    with bad_input():
        case = case_of_flags(given)
    content = parameter_summary(case)
    if as_json:
        output.print_json(content)
    else:
        from ertel.apps import tables

        tables.print_parameters(tables.console(), content)


@app.command()
@with_flags
def film(
    given: Mapping[str, object],
    case_file: Annotated[
        Path | None,
        typer.Argument(
            parser=local_path, metavar="[CASE.toml]", help="Case file of a rolling contact.", show_default=False
        ),
    ] = None,
    as_json: Json = False,
) -> None:
    """Compare the film thickness formulas for a rolling contact.

    Give a case file or flags. The flags are those of ertel params.
    """
    from ertel.apps import tables
    from ertel.inputs.case_files import load_case
    from ertel.results.summary import films

    with bad_input():
        if case_file and given:
            raise ValueError(
                f"{shown(case_file)} and {flag_of(next(iter(given)))} are given together; give only one of them"
            )
        case = load_case(case_file) if case_file else case_of_flags({"kind": "rolling", **given})
        if case.starts_apart:
            raise ValueError(f'contact.kind = "{case.kind}": must be "rolling" for the film formulas')
    found = films(case, case.motion.load(0.0), case.motion.entrainment(0.0))
    if as_json:
        output.print_json(tables.films_as_data(case, found))
    else:
        console = tables.console()
        console.print(tables.film_table(case, found, {}))
        tables.print_sources(console, found)


@app.command()
def oils(
    name: Annotated[
        str | None, typer.Argument(metavar="[NAME]", help="An oil or a material.", show_default=False)
    ] = None,
    as_json: Json = False,
) -> None:
    """Print the oils and materials that case files know by name, or all data of one with their sources."""
    from ertel.apps import oils, tables

    with bad_input():
        entry = oils.find(name) if name else None
    if as_json:
        output.print_json(oils.as_data(entry) if entry else oils.library_data())
    elif entry:
        oils.print_entry(tables.console(), entry)
    else:
        oils.print_library(tables.console())


@app.command()
def about() -> None:
    """Print versions, devices and how to cite ertel."""
    from ertel.apps import tables
    from ertel.apps.about import about

    tables.print_names(tables.console(), about())


# -- the paper --------------------------------------------------------------------------------------------------------


@app.command()
def paper(
    figure: Annotated[str, typer.Argument(metavar="all|fig1|fig2|...", help="Figure to reproduce.")] = "all",
    quick: Annotated[bool, typer.Option("--quick", help="Use coarse grids: seven minutes on one core.")] = False,
    out: Annotated[
        Path,
        typer.Option(
            parser=local_path, metavar="DIR", help="Directory for the page; results kept in it are used again."
        ),
    ] = Path("paper"),
    jobs: Annotated[int | None, typer.Option(help="Number of processes; default one per core.", min=1)] = None,
    quiet: Quiet = False,
) -> None:
    """Reproduce the figures of the paper, with their data, on one page.

    After an interruption the same command continues.
    """
    from ertel.apps.boundary_layers import figures

    jobs = jobs or os.cpu_count() or 1
    with bad_input():
        names = figures.names_of(figure)
        out.mkdir(parents=True, exist_ok=True)
    try:
        page, missing = _make_page(names, quick, out, jobs, quiet)
    except interrupts.Interrupted as error:
        leave(error.code, "interrupted; the same command continues")
    except OSError as error:
        leave(FAILED, f"cannot write to {shown(out)}: {reason_of(error)}; the same command continues")
    print(output.printable(shown(page)))
    if missing:
        leave(FAILED, "; ".join(f"{name} failed: {reason}" for name, reason in missing.items()))


def _make_page(names: list[str], quick: bool, out: Path, jobs: int, quiet: bool) -> tuple[Path, dict[str, str]]:
    """Run what is missing and write the page: its path, and why figures are missing."""
    from ertel.apps.boundary_layers import figures
    from ertel.runs import compiling
    from ertel.runs.progress import bars
    from ertel.runs.sweep import processes

    compiling.check_jax()
    runs, done, seconds = figures.expected(names, quick, out, jobs)
    if not quiet:
        output.say(f"{runs} runs, {done} of them done; about {max(seconds / 60, 1):.0f} min")
    with bars(not quiet) as progress, processes(jobs) as executor:
        compiling.devices()  # or no run can begin
        bar = progress.add_task("runs", total=runs, news="")

        def on_done(task: Any, _: object) -> None:
            progress.update(bar, advance=1, news=task.name)

        return figures.make(names, quick, out, executor, on_done)
