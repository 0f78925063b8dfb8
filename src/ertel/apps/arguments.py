"""Arguments and flags that several commands have."""

from pathlib import Path
from typing import Annotated, Any

import typer

from ertel.apps import completion
from ertel.apps.paths import local_path


def _file(metavar: str, text: str) -> Any:
    return typer.Argument(
        parser=local_path, metavar=metavar, help=text, autocompletion=completion.case_files, show_default=False
    )


CaseFile = Annotated[Path, _file("CASE.toml", "Case file; see examples/.")]
StudyFile = Annotated[Path, _file("SWEEP.toml", "Case file with lists or ranges of values.")]


def _run_directory(metavar: str) -> Any:
    return typer.Argument(
        parser=local_path,
        metavar=metavar,
        help="Directory of a run.",
        autocompletion=completion.run_directories,
        show_default=False,
    )


RunDirectory = Annotated[Path, _run_directory("DIR")]
OptionalRun = Annotated[Path | None, _run_directory("[DIR]")]
Json = Annotated[bool, typer.Option("--json", help="Print JSON and nothing else.")]
Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="Show no progress bar and no summary.")]
Estimate = Annotated[
    bool,
    typer.Option("--error", help="Run also on the half grid, in smaller steps and on a wider domain: the error."),
]
Flush = Annotated[
    float | None,
    typer.Option(
        min=0.0,
        metavar="SECONDS",
        help="Write at least so far apart; default 5 s, and each grid of a steady run. A killed run loses this much.",
        show_default=False,
    ),
]
Jobs = Annotated[
    int | None,
    typer.Option(
        min=1,
        help="Number of processes; default one per core. 1: this process, with all cores.",
        show_default=False,
    ),
]
Scheduler = Annotated[
    str | None,
    typer.Option(
        metavar="ADDRESS",
        help="Use the workers of a dask scheduler that runs. Who reaches it can run programs as you.",
        show_default=False,
    ),
]
SchedulerFile = Annotated[
    Path | None,
    typer.Option(
        parser=local_path, metavar="FILE", help="The same, by the file that the scheduler wrote.", show_default=False
    ),
]
Tls = Annotated[
    Path | None,
    typer.Option(
        parser=local_path,
        metavar="FILE",
        help="PEM file with certificate, key and authority, for a scheduler at tls://.",
        show_default=False,
    ),
]
Set = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        metavar="KEY=VALUE",
        help="Replace a value of the case, e.g. solver.nodes=129.",
        autocompletion=completion.settings,
    ),
]


def directory_option(text: str) -> Any:
    """An option for a directory."""
    return typer.Option(parser=local_path, metavar="DIR", help=text, show_default=False)


def values_option(example: str, text: str) -> Any:
    """An option for what varies along a curve."""
    return typer.Option(metavar="VALUES", help=f"{text} Such as {example}.", show_default=False)
