"""The command line.  Reads, shows progress, prints and chooses exit codes; the work is done elsewhere.

Exit codes: 0 done; 1 gave up, what was computed is kept; 2 wrong input, nothing written; 130 interrupted, resumable.
"""

import json
import os
import signal
import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from enum import StrEnum
from pathlib import Path
from types import FrameType
from typing import TYPE_CHECKING, Annotated, Any, NoReturn, TypeAlias

import typer
from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn
from rich.table import Table

if TYPE_CHECKING:  # the rest of ertel comes when it is needed, so that --help answers at once
    from ertel.case import Case
    from ertel.level import Method
    from ertel.simulation import Step
    from ertel.store import RunStore

GAVE_UP, BAD_INPUT, INTERRUPTED = 1, 2, 130

app = typer.Typer(
    help="Elastohydrodynamic lubrication of point contacts: a ball hits an oiled surface.",
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
Estimate = Annotated[bool, typer.Option("--error", help="Also run on the half grid and estimate the error.")]


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
        from ertel.config import load_case
        from ertel.simulation import method_of
        from ertel.store import RunStore, unused_directory

        case = load_case(case_file, set_ or [])
        coarse = _half_grid(case) if error else None
        method = method_of(case)
        store = RunStore.create(out or unused_directory(case), case, method.coordinates)
    _run(store, coarse, as_json, quiet, method)


@app.command()
def resume(directory: Directory, as_json: Json = False, error: Estimate = False, quiet: Quiet = False) -> None:
    """Go on with a run that was interrupted."""
    with _bad_input():
        from ertel.store import RunStore

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
        from ertel.store import RunStore

        store = RunStore.open(directory)
        summary = store.summary() or store.summary_so_far()
    _report(store, summary, as_json, quiet=False)


@app.command()
def plot(
    directory: Directory,
    format_: Annotated[Format, typer.Option("--format", help="Kind of picture.")] = Format.png,
    out: Annotated[Path | None, typer.Option(help="Where to; DIR/plots by default.", show_default=False)] = None,
) -> None:
    """Draw a run: an overview, maps, profiles, histories."""
    with _bad_input():
        from ertel import plotting
        from ertel.store import RunStore

        data = RunStore.open(directory).dataset()
        target = out or directory / "plots"
        figures = {name: draw(data) for name, draw in plotting.FIGURES.items()}
        target.mkdir(parents=True, exist_ok=True)
        for name, figure in figures.items():
            figure.savefig(target / f"{name}.{format_.value}")
            print(target / f"{name}.{format_.value}")


def _flag(name: str, kind: str) -> Any:
    return typer.Option(f"--{name}", show_default=False, metavar=kind)


Number: TypeAlias = float | None
Quantity: TypeAlias = str | None


@app.command()
def params(
    M: Annotated[Number, _flag("M", "NUMBER")] = None,
    L: Annotated[Number, _flag("L", "NUMBER")] = None,
    lambda_bar: Annotated[Number, _flag("lambda-bar", "NUMBER")] = None,
    alpha_bar: Annotated[Number, _flag("alpha-bar", "NUMBER")] = None,
    radius: Annotated[Quantity, _flag("radius", "QUANTITY")] = None,
    radius_1: Annotated[Quantity, _flag("radius-1", "QUANTITY")] = None,
    radius_2: Annotated[Quantity, _flag("radius-2", "QUANTITY")] = None,
    mass: Annotated[Quantity, _flag("mass", "QUANTITY")] = None,
    ball_density: Annotated[Quantity, _flag("ball-density", "QUANTITY")] = None,
    speed: Annotated[Quantity, _flag("speed", "QUANTITY")] = None,
    drop_height: Annotated[Quantity, _flag("drop-height", "QUANTITY")] = None,
    E_prime: Annotated[Quantity, _flag("E-prime", "QUANTITY")] = None,
    E1: Annotated[Quantity, _flag("E1", "QUANTITY")] = None,
    nu1: Annotated[Number, _flag("nu1", "NUMBER")] = None,
    E2: Annotated[Quantity, _flag("E2", "QUANTITY")] = None,
    nu2: Annotated[Number, _flag("nu2", "NUMBER")] = None,
    eta0: Annotated[Quantity, _flag("eta0", "QUANTITY")] = None,
    alpha: Annotated[Quantity, _flag("alpha", "QUANTITY")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON and nothing else.")] = False,
) -> None:
    """All parameters of an impact from any consistent set.

    Either --M and --L, or --lambda-bar and --alpha-bar, or quantities such as "10 mm": --radius or --radius-1 and
    --radius-2, --mass or --ball-density, --speed or --drop-height, --E-prime or --E1 --nu1 --E2 --nu2, --eta0, --alpha.
    """
    given = {key: value for key, value in locals().items() if key != "as_json" and value is not None}
    oil: dict[str, object] = {key: given.pop(key) for key in ("eta0", "alpha") if key in given}
    with _bad_input():
        from ertel.config import parse_case
        from ertel.dataset import parameter_summary

        oil |= {"viscosity": "isoviscous" if 0 in (L, alpha_bar) else "barus", "density": "incompressible"}
        content = parameter_summary(parse_case({"contact": given, "lubricant": oil}))
    if as_json:
        print(json.dumps(content, indent=2))
    else:
        _print_parameters(content)


# -- a run and its end ------------------------------------------------------------------------------------------------


class _Stopped(Exception):
    """The user asked to stop while the half grid was running."""


def _run(store: "RunStore", coarse: "Case | None", as_json: bool, quiet: bool, method: "Method | None" = None) -> None:
    """Run what is stored, from where it stands to its end, and report."""
    from ertel import analysis, compiling
    from ertel.store import run

    compiling.keep_on_disk()
    try:
        with _interruptible() as stop, _progress(quiet) as bars:
            half = _half_grid_summary(coarse, _watch(bars, coarse, "half grid", stop)) if coarse else None
            summary = run(store, _watch(bars, store.case, store.case.name, stop), method)
        if half and summary["status"] == "converged":
            summary["error_estimate"] = analysis.error_estimate(summary, half)
            store.finish(summary)
    except _Stopped:
        _leave(INTERRUPTED, f"interrupted before the first step; go on with: ertel resume {store.directory}")
    except OSError as error:
        _leave(
            GAVE_UP, f"cannot write to {store.directory}, {_reason(error)}; go on with: ertel resume {store.directory}"
        )
    _report(store, summary, as_json, quiet)
    _conclude(store, summary)


def _half_grid(case: "Case") -> "Case":
    from ertel.config import check_case

    return check_case(case.on_half_grid())


def _half_grid_summary(coarse: "Case", watch: "Callable[[Step], bool]") -> Mapping[str, Any]:
    from ertel.simulation import simulate

    def on_step(step: "Step") -> None:
        if not watch(step):
            raise _Stopped

    return simulate(coarse, on_step).summary


def _conclude(store: "RunStore", summary: Mapping[str, Any]) -> None:
    """The exit code that a run's status asks for, and a sentence on stderr where it did not come to its end."""
    from ertel.status import Status

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
    """Ctrl-C is heard after the step under way; a second one ends at once, and even then the run can be resumed."""
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


def _watch(bars: Progress, case: "Case", label: str, stop: Callable[[], bool]) -> "Callable[[Step], bool]":
    """A callback that shows each step in a new bar and says whether to go on."""
    from ertel.simulation import progress_fraction

    bar = bars.add_task(label, total=1.0, news="compiling")

    def watch(step: "Step") -> bool:
        if step.record:
            record, counts = step.record, step.state.counts
            work = f"{counts.steps} steps, {counts.newton_iterations} Newton, {counts.krylov_iterations} Krylov"
            news = f"T {record['T']:.3f}  Δ {record['Delta']:+.4f}  H_c {record['H_c']:.5f}  {work}"
            bars.update(bar, completed=progress_fraction(case, record), news=news)
        return not stop()

    return watch


# -- what is printed --------------------------------------------------------------------------------------------------


def _report(store: "RunStore", summary: Mapping[str, Any], as_json: bool, quiet: bool) -> None:
    from ertel.store import to_json

    if as_json:
        sys.stdout.write(to_json(summary))
    elif not quiet:
        _print_summary(store, summary)


def _print_summary(store: "RunStore", summary: Mapping[str, Any]) -> None:
    case = store.case
    console = Console(highlight=False, markup=False, soft_wrap=True)
    parameters = f"M = {summary['M']:.5g}, L = {summary['L']:.4g}"
    grid = f"{case.solver.method}, {case.solver.nodes} nodes to {case.solver.half_width:g} a*"
    console.print(f"{case.name or case.kind}: {parameters} ({grid}): {summary['status']}", style="bold")
    if summary["max_approach"]:
        console.print(_table_at_maximum(case, summary))
    else:
        console.print("Maximum approach was not reached.")
    if summary["restitution"] is not None:
        console.print(f"Coefficient of restitution {summary['restitution']:.4f}")
    work = "{steps} steps, {newton_iterations} Newton and {krylov_iterations} Krylov iterations, {wall_s:.1f} s"
    console.print(work.format_map(summary))
    for warning in summary["warnings"]:
        console.print(f"Warning: {warning}", style="yellow")
    console.print(f"Stored in {store.directory}; pictures: ertel plot {store.directory}")


def _table_at_maximum(case: "Case", summary: Mapping[str, Any]) -> Table:
    """Values at maximum approach: dimensionless, in SI and with their error where there are such."""
    from ertel.dataset import AT_MAXIMUM, VARIABLES, with_prefix

    errors = {"Delta" if key == "Delta_max" else key: e for key, e in (summary.get("error_estimate") or {}).items()}
    table = Table("at maximum approach", "", box=None, pad_edge=False)
    for heading in ["value", *(["in SI"] if case.scales else []), *(["error", "extrapolated"] if errors else [])]:
        table.add_column(heading, justify="right", no_wrap=True)
    for key in AT_MAXIMUM:
        variable, value = VARIABLES["time" if key == "T" else key], summary["max_approach"][key]
        cells = [variable.long_name, key, f"{value:.5g}"]
        if case.scales:
            cells.append(with_prefix(value * getattr(case.scales, variable.scale), variable.si_units))
        if key in errors:
            share = f"{errors[key]['error'] / abs(value):.2%}" if value else "-"
            cells += [share, f"{errors[key]['extrapolated']:.5g}"]
        table.add_row(*cells)
    return table


def _print_parameters(content: Mapping[str, Any]) -> None:
    table = Table("parameter", "value", box=None, pad_edge=False)
    for name, value in {**content, **content.get("si", {})}.items():
        if name != "si":
            table.add_row(name, f"{value:.6g}")
    Console(highlight=False, markup=False, soft_wrap=True).print(table)
