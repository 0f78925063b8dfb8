"""Arguments and flags that several commands have."""

from pathlib import Path
from typing import Annotated

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
