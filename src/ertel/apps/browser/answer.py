"""What ertel says of a case, beside the form: a fault, or what follows from it."""

from typing import Any

from nicegui import ui

from ertel.results.variables import with_prefix

SCALES = {  # of `parameter_summary`: key, label, unit
    "a_m": ("Hertz' radius a", "m"),
    "p_h_Pa": ("Hertz' pressure", "Pa"),
    "delta_m": ("Hertz' approach", "m"),
    "F_N": ("load", "N"),
    "contact_time_s": ("dry contact time", "s"),
    "trapped_film_m": ("film at which a rigid ball stops", "m"),
    "h_c_least_m": ("central film, at least about", "m"),
    "h_c_most_m": ("central film, at most about", "m"),
}


def show_fault(place: ui.element, message: str) -> None:
    """Say what is wrong."""
    place.clear()
    with place:
        with ui.row().classes("verdict wrong"):
            ui.icon("error_outline")
            ui.label("Not a case yet")
        ui.label(f"{message}.").classes("fault").mark("fault")


def show_waiting(place: ui.element, parameters: dict[str, Any] | None) -> None:
    """Say that a case is one, with what follows at once, while the rest is computed; None: its files are read first."""
    place.clear()
    with place:
        if parameters:
            _parameters(parameters)
        with ui.row().classes("line waiting"):
            ui.spinner(size="sm")
            ui.label("grid, memory, time and warnings …" if parameters else "reading the files of the case …")


def show_answer(place: ui.element, found: dict[str, Any]) -> None:
    """Say all that `ertel check` says."""
    place.clear()
    with place:
        _parameters(found["parameters"])
        ui.separator()
        grid, memory, time = found["grid"], found["memory"], found["time"]
        nodes = f"{grid['nodes']} x {grid['nodes_across']}" if grid["nodes_across"] > 1 else f"{grid['nodes']}, radial"
        _line("nodes", nodes)
        _line("cells in the pressure sweep", f"{grid['cells_in_sweep']:.1f}, 10 needed")
        _line("memory", f"about {memory['needed'] / 1e9:.2g} GB")
        steps = f", {time['steps']} steps" if time["steps"] else ""
        _line("time", f"roughly {_said(time['seconds'])}{steps}")
        _films(found)
        for sentence in found["warnings"]:
            with ui.row().classes("note"):
                ui.icon("info")
                ui.label(f"{sentence[:1].upper()}{sentence[1:]}.")


def _parameters(found: dict[str, Any]) -> None:
    with ui.row().classes("verdict right-one"):
        ui.icon("check_circle")
        ui.label("Ready to run").mark("ready")
    with ui.row().classes("moes"):
        for symbol in ("M", "L"):
            with ui.element("div"):
                ui.label(symbol).classes("symbol")
                ui.label(f"{found[symbol]:.4g}").classes("value").mark(f"value-{symbol}")
    scales = found.get("si", {})
    for key, (label, unit) in SCALES.items():
        if key in scales:
            _line(label, with_prefix(scales[key], unit))


def _films(found: dict[str, Any]) -> None:
    """The films by the formulas that hold here."""
    films = [film for film in found["films"] if film["central"] is not None and film["inside"]]
    if not films:
        return
    ui.label("Central film by the formulas").classes("eyebrow")
    scales = found["parameters"].get("si")
    for film in films:
        in_si = scales and with_prefix(film["central"] * scales["a_m"] ** 2 / scales["R_m"], "m")
        _line(film["name"], in_si or f"{film['central']:.4g} a²/R")


def _line(label: str, value: str) -> None:
    with ui.row().classes("line"):
        ui.label(label)
        ui.space()
        ui.label(value).classes("value")


def _said(seconds: float) -> str:
    if seconds < 60:
        return f"{max(seconds, 5):.0f} s"
    return f"{seconds / 60:.0f} min" if seconds < 5400 else f"{seconds / 3600:.1f} h"
