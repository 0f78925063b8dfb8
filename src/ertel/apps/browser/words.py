"""What pages say of a run: its key numbers as cards, and how it stands in a sentence."""

from html import escape

from nicegui import ui

from ertel.apps.browser.processes import Phase, Standing

COMPILING = (
    "Starting, then compiling: once per machine and grid size, usually 10 to 60 s. "
    "Later runs on this grid begin after a few seconds."
)


def show_number(label: str, symbol: str, text: str, text_in_si: str = "", text_of_error: str = "") -> None:
    """A key number as a card."""
    more = [pretty(text)] if text_in_si else []
    more += [f"± {text_of_error}"] if text_of_error else []
    with ui.element("div").classes("number"):
        ui.label(label).classes("what")
        with ui.row().classes("known"):
            ui.label(text_in_si or pretty(text)).classes("value")
            ui.html(_symbol(symbol), sanitize=False).classes("symbol")
        ui.label("  ".join(more)).classes("also")


def _symbol(name: str) -> str:
    """A symbol in HTML, H_c with its index below; nothing where a variable is named by a word."""
    base, _, index = name.partition("_")
    if len(base) > 2 and base != "Delta":
        return ""
    base = {"mu": "µ", "Delta": "Δ"}.get(base, base)
    return f"{escape(base)}<sub>{escape(index)}</sub>"


def pretty(text: str) -> str:
    """Units with their powers raised."""
    return text.replace("^2", "²").replace("t0", "t₀")


def news(standing: Standing) -> str:
    """How a run stands, in a sentence."""
    p = standing.progress or {}
    match standing.phase:
        case Phase.COMPILING:
            waited = f" It began {standing.seconds:.0f} s ago." if standing.seconds else ""
            return COMPILING + waited
        case Phase.STOPPING:
            return "Stopping: the current step or grid is finished first, then it can be resumed."
        case Phase.FAILED | Phase.DAMAGED:
            return f"{standing.message[:1].upper()}{standing.message[1:]}"
    where = (
        f"T = {p['T']:.3f}, step {p['step']}"
        if p.get("T") is not None
        else f"grid {p.get('step', 0)}, the coarse ones first"
    )
    if standing.phase is Phase.INTERRUPTED:
        return f"Interrupted at {where}; it can be resumed." if p else "Interrupted before its first step."
    left = p.get("seconds_left")
    return f"{standing.done:.0%} · {where} · {_duration(p.get('seconds', 0.0))}" + (
        f", about {_duration(left)} left" if left is not None else ""
    )


def _duration(seconds: float) -> str:
    return f"{seconds:.0f} s" if seconds < 90 else f"{seconds / 60:.0f} min"
