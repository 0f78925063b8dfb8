"""A picture of a run on a page, with film and pressure under the pointer, and the slider over its moments."""

import asyncio
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import replace
from typing import Any, Literal

from nicegui import background_tasks, ui

from ertel.apps.browser.pictures import PlotRequest, Readout, RunInfo, Worker
from ertel.apps.browser.site import sentence
from ertel.results.variables import with_prefix

AHEAD = 3  # pictures that are drawn before the slider is moved to them
PLACE = "(event) => emit(event.offsetX / event.target.clientWidth, event.offsetY / event.target.clientHeight)"
TALL = ("history", "overview")  # figures of two rows


class Canvas:
    """A picture, with the film and pressure under the pointer.

    While one is drawn, the one before is pale and only the last request waits; those in between are left out.  Then
    come the pictures that may be wanted next.
    """

    def __init__(self, worker: Worker):
        self._worker = worker
        self._wanted: PlotRequest | None = None
        self._shown: PlotRequest | None = None
        self._ahead: list[PlotRequest] = []
        self._readout: Readout | None = None
        self._words = ""
        self._drawing: asyncio.Task[None] | None = None
        with ui.element("div").classes("canvas"):
            self._image = ui.element("img").props('alt="picture of the run"').mark("picture")
            self._image.on("pointermove", lambda event: self._read(*event.args), throttle=0.05, js_handler=PLACE)
            self._image.on("pointerleave", lambda: self._read(-1.0, -1.0))
            self._message = ui.label().classes("said")
            self._waits = ui.linear_progress(show_value=False).props("indeterminate size=2px").classes("waits")
        self._under_pointer: ui.label = ui.label().classes("readout").mark("readout")
        self._image.set_visibility(False)
        self._waits.set_visibility(False)
        self._columns: Literal[1] | None = None
        ui.on("narrow", self._become_narrow)
        ui.run_javascript("if (innerWidth < 600) emitEvent('narrow')")  # as that of a phone

    def _become_narrow(self) -> None:
        self._columns = 1
        if self._wanted:
            self.show(self._wanted, self._ahead)

    def show(self, request: PlotRequest, ahead: Sequence[PlotRequest] = ()) -> None:
        """Show a picture as soon as it is drawn, then draw others ahead."""
        self._wanted, *self._ahead = (replace(each, columns=self._columns) for each in (request, *ahead))
        if self._drawing is None or self._drawing.done():
            self._drawing = background_tasks.create(self._draw())

    async def _draw(self) -> None:
        while not self._image.is_deleted:  # the page was not left
            if self._wanted is not None and self._wanted != self._shown:
                await self._draw_wanted(self._wanted)
            elif self._ahead:
                with suppress(ValueError):  # said when it is wanted
                    await self._worker.draw(self._ahead.pop(0))
            else:
                return

    async def _draw_wanted(self, request: PlotRequest) -> None:
        self._shown, message = request, ""
        self._waits.set_visibility(True)
        self._image.classes("old")
        try:
            _, self._readout, self._words = await self._worker.draw(request)
        except ValueError as error:
            message = str(error)
        if self._image.is_deleted:
            return
        if not message:
            self._image.props["src"] = request.address
            self._image.classes(replace="tall" if request.figure in TALL else "")
        self.say(message)
        self._read(-1.0, -1.0)
        self._waits.set_visibility(False)

    def _read(self, across: float, down: float) -> None:
        """Show what is at a place of the picture, or the words to it."""
        self._under_pointer.set_text(self._readout.at(across, down) if self._readout else self._words)

    def say(self, message: str) -> None:
        """Show a message of ertel in place of the picture; an empty one shows the picture."""
        self._message.set_text(sentence(message.replace("dataset: has", "the run has")))
        self._image.set_visibility(not message)


class Slider:
    """The moment of a run in time: a slider, a button that plays, and the events.  changed: called when it moves."""

    def __init__(self, changed: Callable[[], Any]):
        self._changed, self._info = changed, RunInfo()
        self._before, self._way = 0, 1
        with ui.row().classes("moment") as self._row:
            self._play = ui.button(icon="play_arrow", on_click=self._toggle).props("flat round dense").mark("play")
            self._play.props("aria-label='Play'")
            self._slider = ui.slider(min=0, max=1, step=1, value=0, on_change=self._moved).mark("slider")
            self._slider.props("aria-label='Time'")
            self._label = ui.label().classes("time")
            self._events = ui.row().classes("events")
        self._row.set_visibility(False)
        self._timer = ui.timer(0.8, self._next, active=False)

    def at(self, index: int) -> float | str | None:
        """The moment of a map: the name of an event, or its time; None of a steady contact."""
        named = [event for event, map_ in self._info.events.items() if map_ == index]
        return named[0] if named else self.T(index)

    def T(self, index: int) -> float | None:
        """The time of a map; None of a steady contact."""
        return self._info.T[index] if self._info.T else None

    @property
    def index(self) -> int:
        """The number of the map."""
        return min(int(self._slider.value), max(len(self._info.T) - 1, 0))

    @property
    def ahead(self) -> Sequence[int]:
        """The numbers of the maps that come next, the way that the slider was moved."""
        last = len(self._info.T) - 1
        places = (self.index + self._way * step for step in range(1, AHEAD + 1))
        return [place for place in places if 0 <= place <= last]

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
                button.props("flat dense")
        self._slider.set_value(index)
        self._label_time()

    def _label_time(self) -> None:
        if (T := self.T(self.index)) is not None:
            in_seconds = f"{with_prefix((T - self._info.zero) * self._info.t0, 's')}  ·  " if self._info.t0 else ""
            self._label.set_text(f"{in_seconds}T = {T:.3f}")

    def _moved(self) -> None:
        self._way, self._before = (1 if self.index >= self._before else -1), self.index
        self._label_time()
        self._changed()

    def _toggle(self) -> None:
        self._timer.active = not self._timer.active
        self._play.set_icon("pause" if self._timer.active else "play_arrow")

    def _next(self) -> None:
        self._slider.set_value(0 if self.at_end else self.index + 1)
