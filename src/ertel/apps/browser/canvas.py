"""A picture in a page, with a slider through the maps of a run."""

from collections.abc import Callable
from typing import Any

from nicegui import background_tasks, ui

from ertel.apps.browser.site import Site
from ertel.apps.browser.wishes import Told, Wish

TALL = ("history", "overview")  # figures of two rows


class Canvas:
    """A picture.  While one is drawn, only the last wish waits; those in between are left out."""

    def __init__(self, site: Site):
        self._site = site
        self._wish: Wish | None = None
        self._shown: Wish | None = None
        self._busy = False
        with ui.element("div").classes("canvas"):
            self._image = ui.element("img").props('alt="picture of the run"').mark("picture")
            self._said = ui.label().classes("said")
            self._waits = ui.linear_progress(show_value=False).props("indeterminate size=2px").classes("waits")
        self._image.set_visibility(False)
        self._waits.set_visibility(False)

    @property
    def shown(self) -> Wish | None:
        """The picture that is shown."""
        return self._shown

    def show(self, wish: Wish) -> None:
        """Show a picture as soon as it is drawn."""
        self._wish = wish
        if not self._busy:
            background_tasks.create(self._draw())

    async def _draw(self) -> None:
        self._busy = True
        self._waits.set_visibility(True)
        try:
            while self._wish is not None and self._wish != self._shown and not self._image.is_deleted:
                await self._draw_one(self._wish)
        finally:
            self._busy = False
            if not self._image.is_deleted:
                self._waits.set_visibility(False)

    async def _draw_one(self, wish: Wish) -> None:
        self._shown = wish
        address, said = "", ""
        try:
            address = await self._site.address(wish)
        except ValueError as error:
            said = str(error)
        if self._image.is_deleted:  # the page was left
            return
        if said:
            self.say(said)
            return
        self._image.props["src"] = address
        self._image.classes(replace="tall" if wish.figure in TALL else "")
        self._said.set_text("")
        self._image.set_visibility(True)

    def say(self, message: str) -> None:
        """Show a message of ertel in place of the picture."""
        self._said.set_text(_sentence(message))
        self._image.set_visibility(False)


def _sentence(text: str) -> str:
    """A message of ertel for a page."""
    text = text.replace("dataset: has", "the run has")
    return f"{text[:1].upper()}{text[1:]}."


class Slider:
    """The moment of a run in time: a slider, a button that plays, and the events.  changed: called when it moves."""

    def __init__(self, changed: Callable[[], Any]):
        self._changed, self._told = changed, Told("", (), (), ())
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
        if not self._told.T:
            return None
        named = [event for event, place in self._told.events.items() if place == self.index]
        return named[0] if named else self._told.T[self.index]

    @property
    def index(self) -> int:
        """The number of the map."""
        return min(int(self._slider.value), max(len(self._told.T) - 1, 0))

    @property
    def at_end(self) -> bool:
        """Whether the last map is shown."""
        return self.index >= len(self._told.T) - 1

    def fill(self, told: Told, index: int) -> None:
        """Take over the maps of a run and show one of them."""
        self._told = told
        self._row.set_visibility(len(told.T) > 1)
        self._slider.props["max"] = max(len(told.T) - 1, 1)
        self._events.clear()
        with self._events:
            for event, place in told.events.items():
                ui.button(event.replace("-", " "), on_click=lambda place=place: self._slider.set_value(place)).props(
                    "flat dense no-caps"
                )
        if self._slider.value == index:
            self._tell()
        self._slider.set_value(index)

    def _moved(self) -> None:
        self._tell()
        self._changed()

    def _tell(self) -> None:
        if self._told.T:
            self._label.set_text(f"{self._told.times[self.index]}  ·  T = {self._told.T[self.index]:.3f}")

    def _toggle(self) -> None:
        self._timer.active = not self._timer.active
        self._play.set_icon("pause" if self._timer.active else "play_arrow")

    def _next(self) -> None:
        self._slider.set_value(0 if self.at_end else self.index + 1)
