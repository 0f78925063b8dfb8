"""The figures of a run as files."""

import inspect
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

import xarray as xr

from ertel import plots
from ertel.apps.terminal import BAD_INPUT, leave, print_path


def write_figures(data: xr.Dataset, what: str | None, at: str | None, target: Path, kind: str) -> None:
    """Draw the figures of a run, then write them into a directory and print their names.

    what: the name of one figure, None for all.  at: the moment, a time or the name of an event.  kind: png, svg or pdf.
    """
    try:
        draws = {what: plots.figure_of(data, what)} if what else plots.figures_of(data)
        figures = {name: draw(data, **options) for name, draw, options in _at(draws, at)}
    except plots.NoFigure as error:
        leave(BAD_INPUT, str(error))
    target.mkdir(parents=True, exist_ok=True)
    for name, figure in figures.items():
        path = target / f"{name}.{kind}"
        figure.savefig(path)
        print_path(path)


def _at(draws: Mapping[str, Callable[..., Any]], at: str | None) -> Iterator[tuple[str, Callable[..., Any], Any]]:
    """Each figure with its options: figures of a single time get `at`, a time or the name of an event."""
    moment = {name: "at" in inspect.signature(draw).parameters for name, draw in draws.items()}
    if at is not None and not any(moment.values()):
        raise plots.NoFigure(f"--at {at}: the figures of this run do not show a single moment; leave it out")
    for name, draw in draws.items():
        yield name, draw, {"at": time_or_event(at)} if at is not None and moment[name] else {}


def time_or_event(text: str) -> float | str:
    """A moment as a user writes it: a time, or the name of an event."""
    try:
        return float(text)
    except ValueError:
        return text
