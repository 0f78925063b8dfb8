"""The command line.  Reads, shows progress, prints and chooses exit codes; the work is done elsewhere.

Exit codes: 0 done; 1 gave up, what was computed is kept; 2 wrong input, nothing written; 130 interrupted, resumable.
"""

import inspect
import json
import os
import signal
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from enum import StrEnum
from pathlib import Path
from types import FrameType
from typing import TYPE_CHECKING, Annotated, Any, NoReturn

import typer
from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn
from rich.table import Table

if TYPE_CHECKING:  # the rest of ertel comes when it is needed, so that --help answers at once
    from ertel.model.case import Case
    from ertel.model.state import GridSolution, Method
    from ertel.physics.film_formulas import Film
    from ertel.runs.drive import Step
    from ertel.runs.store import RunStore

    Watch = Callable[[Step | GridSolution], bool]

GAVE_UP, BAD_INPUT, INTERRUPTED = 1, 2, 130

app = typer.Typer(
    help="Elastohydrodynamic lubrication of point contacts: a ball hits an oiled surface, or rolls and slides on it.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)


class Format(StrEnum):
    """What `ertel plot` writes."""

    png = "png"
    svg = "svg"
    pdf = "pdf"


CaseFile = Annotated[Path, typer.Argument(metavar="CASE.toml", help="The case, see examples/.", show_default=False)]
Directory = Annotated[Path, typer.Argument(metavar="DIR", help="The directory of a run.", show_default=False)]
Json = Annotated[bool, typer.Option("--json", help="Print the summary as JSON and nothing else.")]
Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="No progress bar and no summary.")]
Estimate = Annotated[
    bool, typer.Option("--error", help="Also run on the half grid for an error estimate (a steady case has one).")
]


def main() -> None:
    """The entry point `ertel`."""
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # the small dense solves lose more than they gain by threads
    app()


@app.callback(invoke_without_command=True)
def _options(version: Annotated[bool, typer.Option("--version", help="Print the version.")] = False) -> None:
    if version:
        import ertel

        print(f"ertel {ertel.__version__}")
        raise typer.Exit


# -- commands ---------------------------------------------------------------------------------------------------------


@app.command()
def run(
    case_file: CaseFile,
    out: Annotated[
        Path | None, typer.Option(help="Directory to make; runs/NAME by default.", show_default=False)
    ] = None,
    set_: Annotated[list[str] | None, typer.Option("--set", metavar="KEY=VALUE", help="solver.nodes=129, ...")] = None,
    as_json: Json = False,
    error: Estimate = False,
    quiet: Quiet = False,
) -> None:
    """Run a case and store it."""
    with _bad_input():
        from ertel.inputs.case_files import load_case
        from ertel.runs.drive import method_of
        from ertel.runs.store import RunStore, unused_directory

        case = load_case(case_file, set_ or [])
        coarse = _half_grid(case) if error else None
        method = None if case.solver.method == "steady" else method_of(case)
        store = RunStore.create(out or unused_directory(case), case, method)
    _run(store, coarse, as_json, quiet, method)


@app.command()
def resume(directory: Directory, as_json: Json = False, error: Estimate = False, quiet: Quiet = False) -> None:
    """Go on with a run that was interrupted."""
    with _bad_input():
        from ertel.runs.store import RunStore

        store = RunStore.open(directory)
        coarse = _half_grid(store.case) if error else None
    summary = store.summary()
    if summary and summary["status"] == "converged":
        _report(store, summary, as_json, quiet)
    else:
        _run(store, coarse, as_json, quiet)


@app.command()
def show(directory: Directory, as_json: Json = False) -> None:
    """Print the summary of a run."""
    with _bad_input():
        from ertel.runs.store import RunStore

        store = RunStore.open(directory)
        summary = store.summary() or store.summary_so_far()
    _report(store, summary, as_json, quiet=False)


@app.command()
def plot(
    directory: Directory,
    format_: Annotated[Format, typer.Option("--format", help="Kind of picture.")] = Format.png,
    out: Annotated[Path | None, typer.Option(help="Where to; DIR/plots by default.", show_default=False)] = None,
) -> None:
    """Draw a run: an overview, maps, profiles, histories; of a steady one film, pressure, mid-lines, convergence."""
    with _bad_input():
        from ertel.results.plots import figures_of
        from ertel.runs.store import RunStore

        data = RunStore.open(directory).dataset()
        target = out or directory / "plots"
        figures = {name: draw(data) for name, draw in figures_of(data).items()}
        target.mkdir(parents=True, exist_ok=True)
        for name, figure in figures.items():
            figure.savefig(target / f"{name}.{format_.value}")
            print(target / f"{name}.{format_.value}")


# the keys of [contact], and two of [lubricant], as flags
NUMBERS = ("M", "L", "lambda_bar", "alpha_bar", "slide_to_roll", "nu1", "nu2")
FLAGS = (
    *("kind", "M", "L", "lambda_bar", "alpha_bar", "radius", "radius_1", "radius_2", "mass", "ball_density"),
    *("speed", "drop_height", "load", "speed_1", "speed_2", "mean_speed", "slide_to_roll"),
    *("E_prime", "E1", "nu1", "E2", "nu2", "eta0", "alpha"),
)


def _with_flags(command: Callable[..., None]) -> Callable[..., None]:
    """A command with FLAGS before its own options; it gets those that were given as its first argument."""

    def with_flags(**values: Any) -> None:
        given = {name: values.pop(name) for name in FLAGS}
        command({name: value for name, value in given.items() if value is not None}, **values)

    parameters: list[inspect.Parameter] = [
        inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, default=None, annotation=_flag(name)) for name in FLAGS
    ]
    own = list(inspect.signature(command).parameters.values())[1:]
    by_name = [parameter.replace(kind=inspect.Parameter.KEYWORD_ONLY) for parameter in own]
    with_flags.__signature__ = inspect.Signature([*parameters, *by_name])  # type: ignore[attr-defined]
    with_flags.__annotations__ = {p.name: p.annotation for p in (*parameters, *by_name)}
    with_flags.__name__, with_flags.__doc__ = command.__name__, command.__doc__
    return with_flags


def _flag(name: str) -> Any:
    kind = float if name in NUMBERS else str
    metavar = "impact|rolling" if name == "kind" else "NUMBER" if name in NUMBERS else "QUANTITY"
    return Annotated[kind | None, typer.Option(f"--{name.replace('_', '-')}", show_default=False, metavar=metavar)]


def _case_of_flags(given: Mapping[str, object]) -> "Case":
    from ertel.inputs.case_files import parse_case

    contact = dict(given)
    oil: dict[str, object] = {key: contact.pop(key) for key in ("eta0", "alpha") if key in contact}
    isoviscous = 0 in (given.get("L"), given.get("alpha_bar"))
    oil |= {"viscosity": "isoviscous" if isoviscous else "barus", "density": "incompressible"}
    return parse_case({"contact": contact, "lubricant": oil})


@app.command()
@_with_flags
def params(given: Mapping[str, object], as_json: Json = False) -> None:
    """All parameters of an impact, or with --kind rolling of a rolling contact, from any consistent set.

    Either --M and --L, or --lambda-bar and --alpha-bar, or quantities such as "10 mm": --radius or --radius-1 and
    --radius-2, --E-prime or --E1 --nu1 --E2 --nu2, --eta0, --alpha; of an impact --mass or --ball-density, --speed or
    --drop-height; of rolling --load, --mean-speed (and --slide-to-roll) or --speed-1 and --speed-2.
    """
    with _bad_input():
        from ertel.results.parameters import parameter_summary

        content = parameter_summary(_case_of_flags(given))
    if as_json:
        print(json.dumps(content, indent=2))
    else:
        _print_parameters(content)


@app.command()
@_with_flags
def film(
    given: Mapping[str, object],
    case_file: Annotated[
        Path | None, typer.Argument(metavar="[CASE.toml]", help="A rolling case, or flags.", show_default=False)
    ] = None,
    as_json: Json = False,
) -> None:
    """What every film thickness formula says of a rolling contact, side by side.

    Of a case file, or of --M and --L, --lambda-bar and --alpha-bar, or quantities as in ertel params.
    """
    with _bad_input():
        from ertel.inputs.case_files import load_case
        from ertel.results.summary import films

        if case_file and given:
            raise ValueError(f"{case_file} and --{next(iter(given)).replace('_', '-')} are given together; take one")
        case = load_case(case_file) if case_file else _case_of_flags({"kind": "rolling", **given})
        if case.kind != "rolling":
            raise ValueError(f'contact.kind = "{case.kind}": the film formulas are for "rolling"')
        found = films(case, case.motion.load(0.0), case.motion.entrainment(0.0))
    if as_json:
        print(json.dumps(_films_as_data(case, found), indent=2))
    else:
        console = _console()
        console.print(_film_table(case, found, {}))
        _print_sources(console, found)


def _films_as_data(case: "Case", found: "Sequence[Film]") -> dict[str, Any]:
    from ertel.results.parameters import parameter_summary
    from ertel.results.variables import in_si

    rows = [film._asdict() for film in found]
    if case.scales:
        for row in rows:
            values = {"H_c": row["central"], "H_min": row["minimum"]}
            row["si"] = in_si(values, case.scales)
    return {**parameter_summary(case), "films": rows}


@app.command()
def paper(
    figure: Annotated[str, typer.Argument(metavar="all|fig1|fig2|...", help="What to reproduce.")] = "all",
    quick: Annotated[bool, typer.Option("--quick", help="Coarse grids: seven minutes on a core.")] = False,
    out: Annotated[Path, typer.Option(help="Where to; what is there is not computed again.")] = Path("paper"),
    jobs: Annotated[int | None, typer.Option(help="Processes; one per core by default.", min=1)] = None,
    quiet: Quiet = False,
) -> None:
    """Reproduce the figures of the paper, with their data, on one page.  Goes on where it was interrupted."""
    from ertel.apps.boundary_layers import figures
    from ertel.runs.sweep import processes

    jobs = jobs or os.cpu_count() or 1
    with _bad_input():
        names = figures.names_of(figure)
        out.mkdir(parents=True, exist_ok=True)
    runs, done, seconds = figures.expected(names, quick, out, jobs)
    if not quiet:
        print(f"{runs} runs, {done} of them done; about {max(seconds / 60, 1):.0f} min", file=sys.stderr)
    try:
        with _progress(quiet) as bars, processes(jobs) as executor:
            bar = bars.add_task("runs", total=runs, news="")
            page, missing = figures.make(
                names, quick, out, executor, lambda task, _: bars.update(bar, advance=1, news=task.name)
            )
    except KeyboardInterrupt:
        _leave(INTERRUPTED, "interrupted; the same command goes on from here")
    print(page)
    if missing:
        _leave(GAVE_UP, "; ".join(f"{name} was not made: {reason}" for name, reason in missing.items()))


# -- a run and its end ------------------------------------------------------------------------------------------------


class _Stopped(Exception):
    """The user asked to stop while the half grid was running."""


def _run(store: "RunStore", coarse: "Case | None", as_json: bool, quiet: bool, method: "Method | None" = None) -> None:
    """Run what is stored, from where it stands to its end, and report."""
    from ertel.results.summary import with_error
    from ertel.runs import compiling
    from ertel.runs.store import run

    compiling.keep_on_disk()
    try:
        with _interruptible() as stop, _progress(quiet) as bars:
            half = _half_grid_summary(coarse, _watch(bars, coarse, "half grid", stop)) if coarse else None
            summary = run(store, _watch(bars, store.case, store.case.name, stop), method)
        if half and half["status"] == summary["status"] == "converged":
            summary = with_error(store.case, summary, half)
            store.finish(summary)
    except _Stopped:
        _leave(INTERRUPTED, f"interrupted before the first step; go on with: ertel resume {store.directory}")
    except OSError as error:
        _leave(
            GAVE_UP, f"cannot write to {store.directory}, {_reason(error)}; go on with: ertel resume {store.directory}"
        )
    _report(store, summary, as_json, quiet)
    _conclude(store, summary)


def _half_grid(case: "Case") -> "Case | None":
    """The case for an error estimate, None where the run has one of its own."""
    from ertel.inputs.case_files import check_case

    return None if case.solver.method == "steady" else check_case(case.on_half_grid())


def _half_grid_summary(coarse: "Case", watch: "Watch") -> Mapping[str, Any]:
    from ertel.runs.drive import simulate

    def on_step(step: "Step") -> None:
        if not watch(step):
            raise _Stopped

    return simulate(coarse, on_step).summary


def _conclude(store: "RunStore", summary: Mapping[str, Any]) -> None:
    """The exit code that a run's status asks for, and a sentence on stderr where it did not come to its end."""
    from ertel.model.status import Status

    status = Status(summary["status"])
    if status is Status.INTERRUPTED:
        _leave(INTERRUPTED, f"interrupted; go on with: ertel resume {store.directory}")
    if not status.ok:
        _leave(GAVE_UP, f"gave up: {status.value}; {status.advice}.  What was computed is in {store.directory}")


def _leave(code: int, message: str) -> NoReturn:
    print(f"ertel: {message}", file=sys.stderr)
    raise typer.Exit(code)


def _reason(error: OSError) -> str:
    return (error.strerror or str(error)).lower()


@contextmanager
def _bad_input() -> Iterator[None]:
    """What goes wrong in here is the input's fault."""
    try:
        yield
    except ValueError as error:
        _leave(BAD_INPUT, str(error))
    except OSError as error:
        _leave(BAD_INPUT, f"{error.filename or 'output'}: {_reason(error)}")


@contextmanager
def _interruptible() -> Iterator[Callable[[], bool]]:
    """Ctrl-C is heard after the step, or the grid, under way; a second one ends at once, and the run can be resumed."""
    asked = False

    def on_interrupt(number: int, frame: FrameType | None) -> None:
        nonlocal asked
        if asked:
            raise KeyboardInterrupt
        asked = True

    before = signal.signal(signal.SIGINT, on_interrupt)
    try:
        yield lambda: asked
    finally:
        signal.signal(signal.SIGINT, before)


# -- progress ---------------------------------------------------------------------------------------------------------


def _progress(quiet: bool) -> Progress:
    console = Console(stderr=True)
    label, news = (TextColumn(text, markup=False) for text in ("{task.description}", "{task.fields[news]}"))
    return Progress(
        label, BarColumn(24), news, TimeElapsedColumn(), console=console, disable=quiet or not console.is_terminal
    )


def _watch(bars: Progress, case: "Case", label: str, stop: Callable[[], bool]) -> "Watch":
    """A callback that shows each step, or grid, in a new bar and says whether to go on."""
    bar = bars.add_task(label, total=1.0, news="compiling")
    news = _grid_news if case.solver.method == "steady" else _step_news

    def watch(item: Any) -> bool:
        fraction, text = news(case, item)
        if text:
            bars.update(bar, completed=fraction, news=text)
        return not stop()

    return watch


def _step_news(case: "Case", step: "Step") -> tuple[float, str]:
    """How much is done, and what to say of it."""
    from ertel.runs.drive import progress_fraction

    if not step.record:
        return 1.0, ""
    record, counts = step.record, step.state.counts
    work = f"{counts.steps} steps, {counts.newton_iterations} Newton, {counts.krylov_iterations} Krylov"
    news = f"T {record['T']:.3f}  Δ {record['Delta']:+.4f}  H_c {record['H_c']:.5f}  {work}"
    return progress_fraction(case, record), news


def _grid_news(case: "Case", solution: "GridSolution") -> tuple[float, str]:
    H_c, nodes = solution.measure()["H_c"], solution.grid.nodes
    work = f"{solution.newton} Newton, {solution.krylov} Krylov"
    news = f"{nodes} x {nodes}  residual {solution.residual:.1e}  H_c {H_c:.5f}  {work}"
    return (nodes / case.solver.nodes) ** 2, news


# -- what is printed --------------------------------------------------------------------------------------------------


def _report(store: "RunStore", summary: Mapping[str, Any], as_json: bool, quiet: bool) -> None:
    from ertel.runs.store import to_json

    if as_json:
        sys.stdout.write(to_json(summary))
    elif not quiet:
        _print_summary(store, summary)


def _console() -> Console:
    return Console(highlight=False, markup=False, soft_wrap=True)


def _print_summary(store: "RunStore", summary: Mapping[str, Any]) -> None:
    case = store.case
    console = _console()
    parameters = f"M = {summary['M']:.5g}, L = {summary['L']:.4g}"
    console.print(f"{case.name or case.kind}: {parameters} ({_grid(case)}): {summary['status']}", style="bold")
    if case.kind == "rolling":
        _print_rolling(console, case, summary)
    elif summary["max_approach"]:
        console.print(_value_table(case, "at maximum approach", summary["max_approach"], _impact_errors(summary)))
    else:
        console.print("Maximum approach was not reached.")
    if summary.get("restitution") is not None:
        console.print(f"Coefficient of restitution {summary['restitution']:.4f}")
    steps = f"{summary['steps']} steps, " if "steps" in summary else ""
    work = "{newton_iterations} Newton and {krylov_iterations} Krylov iterations, {wall_s:.1f} s"
    console.print(steps + work.format_map(summary))
    for warning in summary["warnings"]:
        console.print(f"Warning: {warning}", style="yellow")
    console.print(f"Stored in {store.directory}; pictures: ertel plot {store.directory}")


def _grid(case: "Case") -> str:
    s = case.solver
    if case.kind == "impact":
        return f"{s.method}, {s.nodes} nodes to {s.half_width:g} a*"
    inlet = s.inlet or s.half_width
    return f"{s.method}, {s.nodes} nodes, {inlet:g} a upstream to {2 * s.half_width - inlet:g} a downstream"


def _print_rolling(console: Console, case: "Case", summary: Mapping[str, Any]) -> None:
    """Values, errors, and the formulas beside them, all at the load and the speed of the moment."""
    from ertel.results.summary import films
    from ertel.results.variables import FILMS, MEASURED

    steady, T = summary["method"] == "steady", summary.get("T", 0.0)
    if summary["H_c"] is None:
        console.print("No step was taken.")
        return
    if steady:
        values, heading = {key: summary[key] for key in MEASURED}, f"on {summary['nodes']} x {summary['nodes']} nodes"
    else:
        values, heading = {key: summary[key] for key in ("T", *MEASURED)}, "at the last time"
    known = [name for name in FILMS if summary[f"{name}_error"] is not None]
    errors = {name: (summary[f"{name}_error"], summary[f"{name}_extrapolated"]) for name in known}
    console.print(_value_table(case, heading, values, errors))
    found = films(case, case.motion.load(T), case.motion.entrainment(T))
    computed = {name: summary[f"{name}_extrapolated"] if name in known else summary[name] for name in FILMS}
    if found:
        console.print()
        console.print(_film_table(case, found, computed, "computed, extrapolated" if known else "computed"))


def _impact_errors(summary: Mapping[str, Any]) -> dict[str, tuple[float, float]]:
    estimate = summary.get("error_estimate") or {}
    return {"Delta" if key == "Delta_max" else key: (e["error"], e["extrapolated"]) for key, e in estimate.items()}


def _value_table(
    case: "Case", heading: str, values: Mapping[str, float], errors: Mapping[str, tuple[float, float]]
) -> Table:
    """Values: dimensionless, in SI and with their error and extrapolated where there are such."""
    from ertel.results.variables import VARIABLES, with_prefix

    table = Table(heading, "", box=None, pad_edge=False)
    for column in ["value", *(["in SI"] if case.scales else []), *(["error", "extrapolated"] if errors else [])]:
        table.add_column(column, justify="right", no_wrap=True)
    for key, value in values.items():
        variable = VARIABLES["time" if key == "T" else key]
        cells = [variable.long_name, key, f"{value:.5g}"]
        if case.scales:
            cells.append(with_prefix(value * variable.factor(case.scales), variable.si_units))
        if key in errors:
            error, extrapolated = errors[key]
            cells += [f"{error / abs(value):.2%}" if value else "-", f"{extrapolated:.5g}"]
        table.add_row(*cells)
    return table


def _film_table(
    case: "Case", found: "Sequence[Film]", computed: Mapping[str, float], computed_by: str = "computed"
) -> Table:
    """The formulas, in brackets where they are not for such a contact, and how far they are from a computed film."""
    from ertel.results.variables import with_prefix

    def text(film: float | None) -> str:
        if film is None:
            return ""
        return with_prefix(film * case.scales.film, "m") if case.scales else f"{film:.4g}"

    def deviation(film: float | None, name: str) -> str:
        return f"{film / computed[name] - 1:+.1%}" if film is not None and computed.get(name) else ""

    table = Table("film", box=None, pad_edge=False, caption="(in brackets: a formula for other contacts)")
    table.columns[0].no_wrap = True
    for column in ("central", "deviates", "minimum", "deviates") if computed else ("central", "minimum"):
        table.add_column(column, justify="right", no_wrap=True)
    if computed:
        table.add_row(computed_by, text(computed["H_c"]), "", text(computed["H_min"]))
    for f in found:
        cells = [text(f.central), deviation(f.central, "H_c"), text(f.minimum), deviation(f.minimum, "H_min")]
        table.add_row(f.name if f.inside is not False else f"({f.name})", *(cells if computed else cells[::2]))
    return table


def _print_sources(console: Console, found: "Sequence[Film]") -> None:
    sources: dict[str, list[str]] = {}
    for f in found:
        sources.setdefault(f.source, []).append(f"{f.name}: {f.valid}")
    for source, formulas in sources.items():
        console.print(f"\n{source}", *(f"  {line}" for line in formulas), sep="\n")


def _print_parameters(content: Mapping[str, Any]) -> None:
    table = Table("parameter", "value", box=None, pad_edge=False)
    for name, value in {**content, **content.get("si", {})}.items():
        if name != "si":
            table.add_row(name, f"{value:.6g}")
    _console().print(table)
