"""Elements that pages share: a picture, a slider through the maps of a run, numbers and notes."""

import asyncio
from collections.abc import Callable, Sequence
from html import escape
from typing import Any

from nicegui import background_tasks, ui

from ertel.apps.browser.pictures import PlotRequest, PlotWorker, RunInfo

TALL = ("history", "overview")  # figures of two rows


class Canvas:
    """A picture.  While one is drawn, only the last request waits; those in between are left out."""

    def __init__(self, plots: PlotWorker):
        self._plots = plots
        self._wanted: PlotRequest | None = None
        self._shown: PlotRequest | None = None
        self._drawing: asyncio.Task[None] | None = None
        with ui.element("div").classes("canvas"):
            self._image = ui.element("img").props('alt="picture of the run"').mark("picture")
            self._message = ui.label().classes("said")
            self._waits = ui.linear_progress(show_value=False).props("indeterminate size=2px").classes("waits")
        self._image.set_visibility(False)
        self._waits.set_visibility(False)

    def show(self, request: PlotRequest) -> None:
        """Show a picture as soon as it is drawn."""
        self._wanted = request
        if self._drawing is None or self._drawing.done():
            self._drawing = background_tasks.create(self._draw())

    async def _draw(self) -> None:
        self._waits.set_visibility(True)
        while self._wanted is not None and self._wanted != self._shown:
            request = self._shown = self._wanted
            source, message = "", ""
            try:
                source = await self._plots.address(request)
            except ValueError as error:
                message = str(error)
            if self._image.is_deleted:  # the page was left
                return
            if source:
                self._image.props["src"] = source
                self._image.classes(replace="tall" if request.figure in TALL else "")
            self.say(message)
        self._waits.set_visibility(False)

    def say(self, message: str) -> None:
        """Show a message of ertel in place of the picture; an empty one shows the picture."""
        self._message.set_text(sentence(message.replace("dataset: has", "the run has")))
        self._image.set_visibility(not message)


class Slider:
    """The moment of a run in time: a slider, a button that plays, and the events.  changed: called when it moves."""

    def __init__(self, changed: Callable[[], Any]):
        self._changed, self._info = changed, RunInfo()
        with ui.row().classes("moment") as self._row:
            self._play = ui.button(icon="play_arrow", on_click=self._toggle).props("flat round dense").mark("play")
            self._play.props("aria-label='Play'")
            self._slider = ui.slider(min=0, max=1, step=1, value=0, on_change=self._moved).mark("slider")
            self._slider.props("aria-label='Time'")
            self._label = ui.label().classes("time")
            self._events = ui.row().classes("events")
        self._row.set_visibility(False)
        self._timer = ui.timer(0.8, self._next, active=False)

    @property
    def at(self) -> float | str | None:
        """The moment: the name of an event, or the time of the map; None of a steady contact."""
        if not self._info.T:
            return None
        named = [event for event, index in self._info.events.items() if index == self.index]
        return named[0] if named else self._info.T[self.index]

    @property
    def index(self) -> int:
        """The number of the map."""
        return min(int(self._slider.value), max(len(self._info.T) - 1, 0))

    @property
    def at_end(self) -> bool:
        """True if the last map is shown."""
        return self.index >= len(self._info.T) - 1

    def fill(self, info: RunInfo, index: int) -> None:
        """Take over the maps of a run and show one of them."""
        self._info = info
        self._row.set_visibility(len(info.T) > 1)
        self._slider.props["max"] = max(len(info.T) - 1, 1)
        self._events.clear()
        with self._events:
            for event, map_ in info.events.items():
                button = ui.button(event.replace("-", " "), on_click=lambda map_=map_: self._slider.set_value(map_))
                button.props("flat dense no-caps")
        self._slider.set_value(index)
        self._label_time()

    def _label_time(self) -> None:
        if self._info.T:
            self._label.set_text(f"{self._info.times[self.index]}  ·  T = {self._info.T[self.index]:.3f}")

    def _moved(self) -> None:
        self._label_time()
        self._changed()

    def _toggle(self) -> None:
        self._timer.active = not self._timer.active
        self._play.set_icon("pause" if self._timer.active else "play_arrow")

    def _next(self) -> None:
        self._slider.set_value(0 if self.at_end else self.index + 1)


# -- numbers and sentences --------------------------------------------------------------------------------------------


def show_card(label: str, symbol: str, text: str, text_in_si: str = "", text_of_error: str = "") -> None:
    """A key number as a card."""
    more = [pretty(text)] if text_in_si else []
    more += [f"± {text_of_error}"] if text_of_error else []
    with ui.element("div").classes("number"):
        ui.label(label).classes("what")
        with ui.row().classes("known"):
            ui.label(text_in_si or pretty(text)).classes("value")
            ui.html(_symbol(symbol), sanitize=False).classes("symbol")
        ui.label("  ".join(more)).classes("also")


def show_line(label: str, value: str) -> None:
    """A name and its value on a line."""
    with ui.row().classes("line"):
        ui.label(label)
        ui.space()
        ui.label(value).classes("value")


def show_notes(warnings: Sequence[str]) -> None:
    """Warnings of ertel."""
    for warning in warnings:
        with ui.row().classes("note"):
            ui.icon("info")
            ui.label(sentence(warning))


def sentence(text: str) -> str:
    """A message of ertel as a sentence."""
    return f"{text[0].upper()}{text[1:]}." if text else ""


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
