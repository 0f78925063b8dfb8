"""`ertel paper`: the figures of the paper, with their data, on one page."""

from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ertel.apps import process
from ertel.apps.arguments import Jobs, Quiet, Scheduler, SchedulerFile, Tls
from ertel.apps.terminal import FAILED, bad_input, leave, local_path, print_path, reason_of, say, shown

if TYPE_CHECKING:
    from ertel.runs.tasks import Engine


def paper(
    figure: Annotated[str, typer.Argument(metavar="all|fig1|fig2|...", help="Figure to reproduce.")] = "all",
    quick: Annotated[bool, typer.Option("--quick", help="Use coarse grids: seven minutes on one core.")] = False,
    out: Annotated[
        Path,
        typer.Option(
            parser=local_path, metavar="DIR", help="Directory for the page; results kept in it are used again."
        ),
    ] = Path("paper"),
    jobs: Jobs = None,
    scheduler: Scheduler = None,
    scheduler_file: SchedulerFile = None,
    tls: Tls = None,
    quiet: Quiet = False,
) -> None:
    """Reproduce the figures of the paper, with their data, on one page.

    After an interruption the same command continues.
    """
    from ertel.apps.boundary_layers import figures
    from ertel.runs.tasks import Engine

    with bad_input():
        names = figures.names_of(figure)
        out.mkdir(parents=True, exist_ok=True)
    try:
        page, missing = _make_page(names, quick, out, Engine(jobs, scheduler, scheduler_file, tls), quiet)
    except process.Interrupted as error:
        leave(error.code, "interrupted; the same command continues")
    except OSError as error:
        leave(FAILED, f"cannot write to {shown(out)}: {reason_of(error)}; the same command continues")
    print_path(page)
    if missing:
        leave(FAILED, "; ".join(f"{name} failed: {reason}" for name, reason in missing.items()))


def _make_page(names: list[str], quick: bool, out: Path, engine: "Engine", quiet: bool) -> tuple[Path, dict[str, str]]:
    """Run what is missing and write the page: its path, and why figures are missing."""
    from ertel.apps.boundary_layers import figures
    from ertel.runs.compile import prepare_jax
    from ertel.runs.drive import bars

    prepare_jax()  # or no run can begin
    runs, done, seconds = figures.expected(names, quick, out, engine.processes)
    if not quiet:
        say(f"{runs} runs, {done} of them done; about {max(seconds / 60, 1):.0f} min")
    with bars(not quiet) as progress, ExitStack() as stack:
        with process.deferred():
            workers = stack.enter_context(engine.workers(runs - done))
        bar = progress.add_task("runs", total=runs, message="")

        def on_done(task: Any, _: object) -> None:
            progress.update(bar, advance=1, message=task.name)

        return figures.make(names, quick, out, workers, on_done)
