"""Arguments and flags that several commands have."""

from pathlib import Path
from typing import Annotated, Any

import typer

from ertel.apps.paths import local_path

CaseFile = Annotated[
    Path, typer.Argument(parser=local_path, metavar="CASE.toml", help="Case file; see examples/.", show_default=False)
]
RunDirectory = Annotated[
    Path, typer.Argument(parser=local_path, metavar="DIR", help="Directory of a run.", show_default=False)
]
Json = Annotated[bool, typer.Option("--json", help="Print JSON and nothing else.")]
Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="Show no progress bar and no summary.")]
Estimate = Annotated[
    bool,
    typer.Option("--error", help="Run also on the half grid, in smaller steps and on a wider domain: the error."),
]
Set = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="KEY=VALUE", help="Replace a value of the case, e.g. solver.nodes=129."),
]


def directory_option(text: str) -> Any:
    """An option for a directory."""
    return typer.Option(parser=local_path, metavar="DIR", help=text, show_default=False)


def values_option(example: str, text: str) -> Any:
    """An option for what varies along a curve."""
    return typer.Option(metavar="VALUES", help=f"{text} Such as {example}.", show_default=False)
