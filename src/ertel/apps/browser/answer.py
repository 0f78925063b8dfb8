"""The answer of ertel to a case before it is run: at once whether it is one, after two seconds all of `ertel check`.

The first is asked here; the second needs JAX and is a process of its own, which ends when the case changes again.  A
case with measured surfaces is left to the second: what reads their files is large.
"""

import asyncio
import json
import os
from asyncio.subprocess import DEVNULL, PIPE
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import tomli_w
from nicegui import ui

from ertel.apps.browser.elements import show_line, show_notes
from ertel.apps.browser.folder import Folder
from ertel.apps.browser.processes import ERTEL, messages_in
from ertel.apps.terminal import rough_time
from ertel.inputs.case_files import parse_case
from ertel.results.parameters import parameter_summary
from ertel.results.variables import with_prefix

SCALES = {  # of `parameter_summary`: key, label, unit
    "a_m": ("Hertz radius a", "m"),
    "p_h_Pa": ("Hertz pressure", "Pa"),
    "delta_m": ("Hertz approach", "m"),
    "F_N": ("load", "N"),
    "contact_time_s": ("dry contact time", "s"),
    "trapped_film_m": ("film at which a rigid ball stops", "m"),
    "h_c_least_m": ("central film, at least about", "m"),
    "h_c_most_m": ("central film, at most about", "m"),
}


# -- asked ------------------------------------------------------------------------------------------------------------


def at_once(data: Mapping[str, Any], folder: Folder) -> dict[str, Any] | None:
    """The parameters of the case in plain data, see `parameter_summary`; None where its files must be read first.

    Raises ConfigError with ertel's message, and Outside for files outside the folder.
    """
    files = [folder.inside(table["file"]) for table in _with_files(data)]
    return None if files else parameter_summary(parse_case(data))


async def outlook(data: Mapping[str, Any], folder: Folder) -> dict[str, Any]:
    """The answer of `ertel check --json` to a case.  Raises ValueError with its message where it refuses the case.

    The process ends when the task that waits for it is cancelled.
    """
    text = tomli_w.dumps(moved(data, folder.root))
    with TemporaryDirectory(prefix="ertel-") as place:
        file = Path(place) / "case.toml"
        file.write_text(text, encoding="utf-8")
        command = (*ERTEL, "check", str(file), "--json")
        process = await asyncio.create_subprocess_exec(
            *command, stdin=DEVNULL, stdout=PIPE, stderr=PIPE, env={**os.environ, "JAX_PLATFORMS": "cpu"}
        )
        try:
            answer, errors = await process.communicate()
        except asyncio.CancelledError:
            with suppress(ProcessLookupError):
                process.kill()
            await process.wait()
            raise
    if process.returncode:
        raise ValueError((messages_in(errors) or ["failed"])[0])
    found: dict[str, Any] = json.loads(answer)
    return found


def moved(data: Mapping[str, Any], before: Path, now: Path | None = None) -> dict[str, Any]:
    """The plain data of a case whose files were named relative to one folder: now relative to another, or absolute."""
    if not _with_files(data):
        return dict(data)
    tables = [dict(table) if isinstance(table, dict) else table for table in data["roughness"]]
    for table in _with_files({"roughness": tables}):
        path = os.path.realpath(before / table["file"])
        table["file"] = os.path.relpath(path, now) if now else path
    return {**data, "roughness": tables}


def _with_files(data: Mapping[str, Any]) -> list[dict[str, Any]]:
    """The tables of a case that name a file."""
    tables = data.get("roughness", [])
    found = tables if isinstance(tables, list) else []
    return [table for table in found if isinstance(table, dict) and isinstance(table.get("file"), str)]


# -- shown ------------------------------------------------------------------------------------------------------------


def show_fault(place: ui.element, message: str) -> None:
    """Show a message that refuses a case."""
    with _cleared(place):
        _verdict("Not a case yet", "error_outline", "wrong")
        ui.label(f"{message}.").classes("fault").mark("fault")


def show_waiting(place: ui.element, parameters: dict[str, Any] | None) -> None:
    """Say that a case is one, with what follows at once, while the rest is computed; None: its files are read first."""
    with _cleared(place):
        if parameters:
            _parameters(parameters)
        with ui.row().classes("line waiting"):
            ui.spinner(size="sm")
            ui.label("grid, memory, time and warnings …" if parameters else "reading the files of the case …")


def show_outlook(place: ui.element, found: dict[str, Any]) -> None:
    """Show the whole answer of `ertel check`."""
    with _cleared(place):
        _parameters(found["parameters"])
        ui.separator()
        grid, time = found["grid"], found["time"]
        nodes = f"{grid['nodes']} x {grid['nodes_across']}" if grid["nodes_across"] > 1 else f"{grid['nodes']}, radial"
        steps = f", {time['steps']} steps" if time["steps"] else ""
        show_line("nodes", nodes)
        show_line("cells in the pressure sweep", f"{grid['cells_in_sweep']:.1f}, 10 needed")
        show_line("memory", f"about {found['memory']['needed'] / 1e9:.2g} GB")
        show_line("time", f"roughly {rough_time(time['seconds'])}{steps}")
        _films(found)
        show_notes(found["warnings"])


@contextmanager
def _cleared(place: ui.element) -> Iterator[None]:
    """New content in place of the old."""
    place.clear()
    with place:
        yield


def _verdict(text: str, icon: str, kind: str) -> ui.label:
    with ui.row().classes(f"verdict {kind}"):
        ui.icon(icon)
        return ui.label(text)


def _parameters(found: dict[str, Any]) -> None:
    _verdict("Ready to run", "check_circle", "right-one").mark("ready")
    with ui.row().classes("moes"):
        for symbol in ("M", "L"):
            with ui.element("div"):
                ui.label(symbol).classes("symbol")
                ui.label(f"{found[symbol]:.4g}").classes("value").mark(f"value-{symbol}")
    scales = found.get("si", {})
    for key, (label, unit) in SCALES.items():
        if key in scales:
            show_line(label, with_prefix(scales[key], unit))


def _films(found: dict[str, Any]) -> None:
    """The films by the formulas that hold here."""
    films = [film for film in found["films"] if film["central"] is not None and film["inside"]]
    if films:
        ui.label("Central film by the formulas").classes("eyebrow")
    scales = found["parameters"].get("si")
    for film in films:
        in_si = scales and with_prefix(film["central"] * scales["a_m"] ** 2 / scales["R_m"], "m")
        show_line(film["name"], in_si or f"{film['central']:.4g} a²/R")
