"""Arguments and flags that several commands have, with what the tab key completes."""

import inspect
from collections.abc import Callable
from dataclasses import dataclass, fields, is_dataclass
from functools import wraps
from pathlib import Path
from typing import Annotated, Any

import typer
from typer.core import TyperCommand

from ertel.apps.terminal import local_path

# -- completion: these functions run at each press of the tab key and import little; shells complete paths -------------


def settings(incomplete: str) -> list[str]:
    """section.key= for the keys of case files that begin so."""
    from ertel.case.sections import SECTIONS
    from ertel.inputs.layout import section

    keys = [f"{name}.{key.name}=" for name in SECTIONS for key in section(name).keys]
    return [key for key in keys if key.startswith(incomplete)]


def figures(incomplete: str) -> list[str]:
    """Names of figures that begin so."""
    from ertel.results.figures import FIGURES_IN_TIME, FIGURES_STEADY

    return [name for name in dict.fromkeys(FIGURES_IN_TIME + FIGURES_STEADY) if name.startswith(incomplete)]


# -- a flag without its value -----------------------------------------------------------------------------------------

USUAL = "-"  # the file of a picture at its usual place


class PlotCommand(TyperCommand):
    """A command whose --plot may stand without a file: the picture is then at its usual place."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Read the arguments, with `USUAL` after a --plot that the next flag or the end follows."""
        whole = []
        for word, following in zip(args, [*args[1:], USUAL], strict=True):
            whole += [word, USUAL] if word == "--plot" and following.startswith("-") else [word]
        return super().parse_args(ctx, whole)


# -- arguments and flags ----------------------------------------------------------------------------------------------


def path_argument(metavar: str, text: str) -> Any:
    """An argument that is a file or a directory."""
    return typer.Argument(parser=local_path, metavar=metavar, help=text, show_default=False)


def option(text: str, metavar: str | None = None, completes: Any = None, name: str = "", **more: Any) -> Any:
    """An option that takes a value.  name: of the option, if it differs from the parameter."""
    return typer.Option(*([name] if name else []), metavar=metavar, help=text, autocompletion=completes, **more)


def path_option(text: str, metavar: str = "DIR") -> Any:
    """An option that is a directory or a file."""
    return option(text, metavar, parser=local_path)


def values_option(quantity: str, example: str) -> Any:
    """An option for the quantity that varies along a curve."""
    return option(f"Values of the {quantity}, for example {example}.", "VALUES")


CaseFile = Annotated[Path, path_argument("CASE.toml", "Case file; see examples/.")]
Moment = Annotated[str | None, option('A time, "60 us" from touch, a number in t0, max-approach or end.', "TIME|EVENT")]
RunDirectory = Annotated[Path, path_argument("DIR", "Directory of a run.")]
SET_HELP = "Replace a value of the case, e.g. solver.nodes=129."
Set = Annotated[list[str] | None, option(SET_HELP, "KEY=VALUE", settings, "--set")]
Overwrite = Annotated[bool, typer.Option("--overwrite", help="Replace files that ertel did not write, too.")]
Json = Annotated[bool, typer.Option("--json", help="Print JSON and nothing else.")]
Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="Show no progress and no summary.")]

# -- options that belong together -------------------------------------------------------------------------------------


def grouped(command: Callable[..., None]) -> Callable[..., None]:
    """A command for typer: the fields of every parameter that is a dataclass are options of their own."""
    signature = inspect.signature(command)
    groups: dict[str, Any] = {
        name: each.annotation for name, each in signature.parameters.items() if is_dataclass(each.annotation)
    }
    named = inspect.Parameter.KEYWORD_ONLY
    parameters = [each.replace(kind=named) for name, each in signature.parameters.items() if name not in groups]
    for group in groups.values():
        parameters += [inspect.Parameter(f.name, named, default=f.default, annotation=f.type) for f in fields(group)]

    @wraps(command)
    def called(**given: Any) -> None:
        made = {name: group(**{f.name: given.pop(f.name) for f in fields(group)}) for name, group in groups.items()}
        command(**given, **made)

    called.__signature__ = signature.replace(parameters=parameters)  # type: ignore[attr-defined]
    return called


@dataclass(frozen=True)
class Report:
    """The form in which a command reports what it has done."""

    as_json: Json = False
    quiet: Quiet = False


ERROR_HELP = "Estimate the error by runs on the half grid, in smaller steps and on a wider domain."
FLUSH_HELP = "Least time between two writes; default 5 s, and each grid of a steady run. A killed run loses this much."


@dataclass(frozen=True)
class RunOptions(Report):
    """The options of a run: its report, whether its error is estimated, and seconds between flushes."""

    error: Annotated[bool, typer.Option("--error", help=ERROR_HELP)] = False
    flush: Annotated[float | None, option(FLUSH_HELP, "SECONDS", min=0.0)] = None


JOBS_HELP = "Number of processes; default one per core. 1: this process, with all cores."
SCHEDULER_HELP = (
    "Use the workers of a running dask scheduler. Who reaches it can run programs as you, except at tls://."
)


@dataclass(frozen=True)
class EngineOptions:
    """The processes that do the runs of a study, see `runs.engine.Engine`."""

    jobs: Annotated[int | None, option(JOBS_HELP, min=1)] = None
    scheduler: Annotated[str | None, option(SCHEDULER_HELP, "ADDRESS")] = None


ALIGN_HELP = "Unknown of a measurement: start of its clock, centre, offset, tilt, factor of a curve, index of the oil."
COLUMN_HELP = 'Unit of a column, its name in the header, or both: x=um, "x=Radius [um]", h=Film=nm.'
INDEX_HELP = "Index of the oil; also that with which a film was computed."


@dataclass(frozen=True)
class Measured:
    """The way in which a measurement is read and compared with a run, and the rig of its light."""

    at: Moment = None
    align: Annotated[str | None, option(ALIGN_HELP, "NAMES")] = None
    column: Annotated[list[str] | None, option(COLUMN_HELP, "NAME=COLUMN", name="--column")] = None
    wavelength: Annotated[str | None, option("Wavelength of the light; default 532 nm.", "LENGTH")] = None
    coatings: Annotated[str | None, option('Layers, "chromium 8 nm, silica 200 nm"; default the first.', "LAYERS")] = (
        None
    )
    index: Annotated[float | None, option(INDEX_HELP, "NUMBER")] = None
