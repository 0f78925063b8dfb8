"""The command line.  It reads arguments, prints, and chooses exit codes; the work is done elsewhere.

Commands import what they need inside, so that `ertel --help` answers at once.

Exit codes: 0 done; 1 failed, results so far are kept; 2 wrong input, nothing written; 130 interrupted, can be resumed
(143 by SIGTERM, 129 by SIGHUP).
"""

import gc
import logging
import os
import sys
from pathlib import Path
from typing import Annotated, Literal

import typer

from ertel.apps import cases, looking, measuring, process
from ertel.apps.arguments import (
    CaseFile,
    EngineOptions,
    PlotCommand,
    Report,
    RunDirectory,
    RunOptions,
    Set,
    grouped,
    option,
    path_argument,
    path_option,
    values_option,
)
from ertel.apps.terminal import BAD_INPUT, bad_input, in_shell, leave, say

PRUNE_HELP = "Delete the runs that the study no longer has; what ertel did not write stays."
PART_HELP = "Do the I-th of N parts only, such as one task of a job array; the command without it gathers."
app = typer.Typer(
    cls=process.Commands,
    help="Elastohydrodynamic lubrication: a ball or a roller hits an oiled surface, or rolls and slides on it.",
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)


def main() -> None:
    """The entry point `ertel`."""
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # the small dense solves lose more than they gain by threads
    os.environ["JAX_ENABLE_X64"] = "1"  # for all that a command computes, also in the processes that it starts
    os.environ["MPLBACKEND"] = "agg"  # Jupyter names one of its own to all that it starts, which may not be there
    os.environ.setdefault("TF_CPP_MIN_LOG_LEVEL", "3")  # or XLA calls code that it compiled itself an error
    sys.modules["dask.array"] = None  # type: ignore[assignment]  # or xarray imports it, for arrays that ertel never makes
    logging.getLogger("matplotlib").setLevel(logging.ERROR)  # of fonts; its warnings say the same
    process.keep_freed_memory()
    with process.safe_streams():
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
@grouped
def run(
    case_file: CaseFile,
    options: RunOptions,
    out: Annotated[Path | None, path_option("New directory for the run; default runs/NAME.")] = None,
    set_: Set = None,
    after: Annotated[
        Path | None, path_option("Rolling: the run whose track this one follows; what it leaves behind is the layer.")
    ] = None,
    help_keys: Annotated[
        bool,
        typer.Option("--help-keys", is_eager=True, callback=cases.print_keys, help="Print all keys of case files."),
    ] = False,
) -> None:
    """Run a case and store the results."""
    gc.set_threshold(100_000)  # JAX makes many objects that stay, and looking through them takes time
    from ertel.inputs.case_files import load_case
    from ertel.runs.compile import jax_prepared

    case = load_case(case_file, [*(set_ or []), *cases.on_track_of(after)])

    def before_compiling() -> None:
        if not options.quiet:
            say("The run is done; compiling faster programs for later runs, which Ctrl-C ends")

    with jax_prepared(case, before_compiling):
        from ertel.apps import running  # while programs are loaded

        running.run(case, out, options)


@app.command()
@grouped
def resume(directory: RunDirectory, options: RunOptions) -> None:
    """Continue an interrupted run.

    Of a finished run the summary is printed; with --error its error is estimated. No step is computed twice.
    """
    from ertel.apps import running

    running.resume(directory, options)


@app.command()
@grouped
def traction(
    case_file: CaseFile,
    report: Report,
    slide_to_roll: Annotated[str | None, values_option("slide-to-roll ratio", "0:0.5:15")] = None,
    mean_speed: Annotated[str | None, values_option("mean speed", "0.1 m/s:10 m/s:12:log")] = None,
    load: Annotated[str | None, values_option("load", "10 N:100 N:5")] = None,
    film: Annotated[str | None, option("Solve the film at each point, or once.", "each|once")] = None,
    set_: Set = None,
    out: Annotated[Path | None, path_option("Directory of the curve; default traction/NAME.")] = None,
) -> None:
    """Compute a traction curve: the friction of a steady contact against slide-to-roll ratio, speed or load.

    Give one of them: FIRST:LAST:NUMBER with equal steps, FIRST:LAST:NUMBER:log with equal ratios, or values with commas
    between them. Without a unit a speed is in m/s and a load in N.

    The film of a Newtonian oil does not depend on the slide-to-roll ratio and is solved once. That of an oil that thins
    is solved at each point; --film once takes the one of the smallest slide-to-roll ratio, in the time of one point.

    DIR is a new or empty directory, or that of an earlier curve. Films that it holds are used again, the table and the
    picture are those of this curve. After an interruption the same command continues.
    """
    from ertel.apps import studies
    from ertel.inputs.case_files import load_case

    case = load_case(case_file, set_ or [])
    given = {"slide_to_roll": slide_to_roll, "mean_speed": mean_speed, "load": load}
    name = case.name or case.kind
    studies.traction(case, given, film, out or Path("traction").absolute() / name, report)


@app.command()
@grouped
def stribeck(
    case_file: CaseFile,
    report: Report,
    speed: Annotated[str, values_option("mean speed", "0.001 m/s:10 m/s:25")] = "0.001:10:25",
    set_: Set = None,
    out: Annotated[Path | None, path_option("Directory of the curve; default stribeck/NAME.")] = None,
) -> None:
    """Compute a Stribeck curve: friction against speed, of a steady contact whose asperities touch.

    Speeds are FIRST:LAST:NUMBER with equal ratios, or values with commas between them; without a unit in m/s.

    The case needs a law of asperities, surfaces.asperities. DIR is as for a traction curve.
    """
    from ertel.apps import studies
    from ertel.inputs.case_files import load_case
    from ertel.runs.traction import in_ratios, require_touch

    case = load_case(case_file, set_ or [])
    require_touch(case)
    given = {"mean_speed": in_ratios(speed, "--speed")}
    studies.traction(case, given, None, out or Path("stribeck").absolute() / (case.name or case.kind), report)


@app.command()
@grouped
def sweep(
    study_file: Annotated[Path, path_argument("SWEEP.toml", "Case file with lists or ranges of values.")],
    engine: EngineOptions,
    report: Report,
    out: Annotated[Path | None, path_option("Directory of the study; default sweeps/NAME.")] = None,
    set_: Set = None,
    part: Annotated[str | None, option(PART_HELP, "I/N")] = None,
    prune: Annotated[bool, typer.Option("--prune", help=PRUNE_HELP)] = False,
) -> None:
    """Run a parameter study: all combinations of the values in a case file that are lists or ranges.

    The file is a case file in which a list, or a range FIRST:LAST:NUMBER, "1:10:4" (with :log at the end equal ratios),
    may stand for any value. The section [sweep] has mode = "product" (all combinations, the default) or mode = "zip"
    (the first values belong together, then the second ones). --set takes such values too: --set contact.M=100:400:4.

    Each run is an ordinary run directory, DIR/runs/DIGEST of its case. What is missing or unfinished is done: a study
    can be stopped, killed, edited and started again with the same command.
    """
    from ertel.apps import studies
    from ertel.inputs.studies import load_study

    chosen = studies.part_of(part)
    study = load_study(study_file, set_ or [])
    place = out or Path("sweeps").absolute() / study.name
    studies.sweep(study, place, studies.Engine(**vars(engine)), chosen, report, prune)


@app.command()
@grouped
def converge(
    case_file: CaseFile,
    engine: EngineOptions,
    report: Report,
    grids: Annotated[int, option("Number of grids, 3 to 6; the finest is that of the case.")] = 3,
    along: Annotated[Literal["grid", "time"], option("Refine grid and time steps, or time steps alone.")] = "grid",
    out: Annotated[Path | None, path_option("Directory of the series; default convergence/NAME.")] = None,
    set_: Set = None,
) -> None:
    """Run a case on several grids: the observed order of its numbers, extrapolated values and errors.

    Each grid has the double spacing of the next. In time the steps are halved, too, from grid to grid; the coarsest has
    those of the case. Where second order is not seen nothing is extrapolated, and the error is wide. The domain is that
    of the case; its part of the error is that of ertel run --error.

    Each run is an ordinary run directory, DIR/runs/DIGEST of its case. After an interruption the same command
    continues.
    """
    from ertel.apps import studies
    from ertel.inputs.case_files import load_case
    from ertel.inputs.studies import convergence_series

    series = convergence_series(load_case(case_file, set_ or []), grids, along)
    place = out or Path("convergence").absolute() / series.name
    studies.sweep(series, place, studies.Engine(**vars(engine)), studies.part_of(None), report)


@app.command()
@grouped
def fit(
    fit_file: Annotated[Path, path_argument("FIT.toml", "Case, unknowns and measurements; see examples/fits.")],
    engine: EngineOptions,
    report: Report,
    out: Annotated[Path | None, path_option("Directory of the fit; default fits/NAME.")] = None,
    set_: Set = None,
    keep: Annotated[Literal["best", "all"], option("The runs that stay when the fit is done.")] = "best",
) -> None:
    """Find the numbers of a case that explain what was measured: of an oil, a load, a speed, a layer.

    The file names a case, the unknowns with their bounds, and the measurements with their standard deviations; see
    examples/fits. Printed are the values with their standard errors, their correlation, and which products of the
    unknowns the data fix, and how well.

    Each run is an ordinary run directory, DIR/runs/DIGEST of its case. After an interruption the same command
    continues. When the fit is done the runs with the values that were found stay, and the others are deleted; with
    --keep all a fit with other data or bounds uses them again as far as they are the same.
    """
    from ertel.apps import studies
    from ertel.runs.fit_problem import load_fit_problem

    problem = load_fit_problem(fit_file, set_ or [])
    place = out or Path("fits").absolute() / fit_file.stem
    studies.fit(problem, place, studies.Engine(**vars(engine)), report, keep)


@app.command("warm-up")
def warm_up(
    files: Annotated[list[Path], path_argument("CASE.toml", "Case files.")],
    set_: Set = None,
) -> None:
    """Compile ahead what runs need, once per machine: then they start at once.

    They depend on grid, oil law and kind of run; other values of a case may differ later. The programs serve all
    machines of this processor type that share the home directory, or the directory XDG_CACHE_HOME.
    """
    from ertel.apps import running
    from ertel.inputs.case_files import load_case

    running.warm_up_all([load_case(path, set_ or []) for path in files])


for command in (
    *(looking.show, looking.plot, looking.ls, looking.compare, looking.export),
    *(measuring.report, measuring.fringes),
    *(cases.new, cases.check, cases.oils),
):
    app.command(cls=PlotCommand if command is looking.compare else None)(command)


# -- ertel itself -----------------------------------------------------------------------------------------------------


@app.command()
def about(
    cite: Annotated[bool, typer.Option("--cite", help="Print BibTeX entries of ertel and of the paper.")] = False,
) -> None:
    """Print versions, devices and how to cite ertel; ertel show --about prints those of a run."""
    from ertel.apps import about, tables

    if cite:
        print(about.bibtex(), end="")
    else:
        tables.print_names(about.about())


@app.command("app")
def browse(
    folder: Annotated[Path, path_argument("DIR", "Folder with case files and runs; default here.")] = Path(),
    port: Annotated[int, typer.Option(min=1024, max=65535, help="Port on this machine.")] = 8642,
    browser: Annotated[bool, typer.Option("--browser/--no-browser", help="Open the app in the browser.")] = True,
) -> None:
    """Describe, run and watch cases in a browser on this machine.

    The app reads and writes in DIR only. It answers only the browser that opens its address, which carries a token:
    whoever has the address can use the app. Each run is a process of its own that goes on
    when the app is closed; its Close button can stop the runs, too. Ctrl-C closes the app.
    """
    hidden = {"aiohttp", "requests", "tornado"} - {*sys.modules}  # 15 MB, which NiceGUI would import
    sys.modules.update(dict.fromkeys(hidden))  # type: ignore[arg-type]
    try:
        from ertel.apps.browser import server
    except ModuleNotFoundError as error:
        if error.name != "nicegui":
            raise
        leave(BAD_INPUT, "the app needs NiceGUI: pip install 'ertel[app]'")
    finally:
        for name in hidden:
            del sys.modules[name]  # whoever reads measured surfaces needs requests
    with bad_input():
        going = server.serve(
            folder.absolute(), port, browser, lambda address: say(f"The app is at {address}, Ctrl-C closes it")
        )
    for name in going:
        say(f"{in_shell(folder.absolute() / name)} goes on without the app; to watch it open the app again")
