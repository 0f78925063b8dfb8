"""Two runs side by side, at the same time."""

from pathlib import Path

from nicegui import ui

from ertel.apps.browser.canvas import Canvas
from ertel.apps.browser.records import summary_of
from ertel.apps.browser.run_page import TABS
from ertel.apps.browser.site import Site
from ertel.apps.browser.wishes import INTERFEROGRAM, Told, Wish, stamp_of
from ertel.apps.browser.words import pretty
from ertel.results.numbers import key_numbers

STEPS = 200  # of the slider
NARROW = {"film": "Film", "pressure": "Pressure"}  # figures of one panel, that stand beside each other
WIDE = {name: TABS[name][0] for name in ("profiles", "history", "friction", INTERFEROGRAM)}  # one above the other


def compare_page(site: Site, a: str = "", b: str = "") -> None:
    """Two runs side by side."""
    names = [entry.name for entry in site.entries()]
    if not names:
        ui.label("There is no run in this folder yet.").classes("alert")
        return
    first = a if a in names else names[0]
    others = [name for name in names if name != first]
    Comparison(site, names, [first, b if b in names else (others or [first])[0]])


class Comparison:
    """Two runs, one figure, one time."""

    def __init__(self, site: Site, names: list[str], chosen: list[str]):
        self.site = site
        self._told: list[Told | None] = [None, None]
        self._begun = False
        with ui.row().classes("head"):
            ui.label("Two runs side by side").classes("title")
            ui.space()
            self._figure = ui.toggle({**NARROW, **WIDE}, value="film", on_change=self._show).props(
                "no-caps unelevated dense"
            )
            self._figure.classes("choice")
        with ui.element("div").classes("card moment-card") as self._when, ui.row().classes("moment"):
            ui.icon("schedule")
            self._slider = ui.slider(min=0, max=STEPS, value=STEPS, on_change=self._show).mark("slider")
            self._label = ui.label().classes("time")
        with ui.element("div").classes("pair") as self._pair:
            sides = [self._side(number, names, name) for number, name in enumerate(chosen)]
        self._names, self._numbers, self._canvases = (list(parts) for parts in zip(*sides, strict=True))
        for number in (0, 1):
            ui.timer(0.05, lambda number=number: self._choose(number), once=True)

    def _side(self, number: int, names: list[str], chosen: str) -> tuple[ui.select, ui.element, Canvas]:
        with ui.element("div").classes("card side"):
            name = ui.select(names, value=chosen, on_change=lambda: self._choose(number)).props("dense outlined")
            numbers = ui.element("div").classes("lines")
            return name, numbers, Canvas(self.site)

    async def _choose(self, number: int) -> None:
        """Take over a run that was chosen."""
        try:
            path = self.site.folder.run(self._names[number].value)
            self._told[number] = await self.site.artist.tell(path)
        except ValueError as error:
            ui.notify(str(error))
            return
        if self._label.is_deleted:  # the page was left
            return
        self._begin()
        summary = summary_of(path)
        self._numbers[number].clear()
        with self._numbers[number]:
            for found in key_numbers(summary) if summary else []:
                with ui.row().classes("line"):
                    ui.label(found.long_name)
                    ui.space()
                    ui.label(found.text_in_si or pretty(found.text)).classes("value")
        self._show()

    def _begin(self) -> None:
        """Begin at maximum approach, where one of the runs has it."""
        known = [told for told in self._told if told is not None]
        maxima = [told.T[told.events["max-approach"]] for told in known if "max-approach" in told.events]
        if len(known) == len(self._told) and maxima and not self._begun:
            self._begun = True
            self._slider.set_value(round(STEPS * maxima[0] / self._end))

    @property
    def _end(self) -> float:
        """The T at which the slider ends; 0 for two steady contacts."""
        return max((told.T[-1] for told in self._told if told and told.T), default=0.0)

    def _show(self) -> None:
        T = self._end * self._slider.value / STEPS if self._end else None
        self._when.set_visibility(T is not None)
        self._label.set_text("" if T is None else f"T = {T:.3f}")
        self._pair.classes(replace="pair wide" if self._figure.value in WIDE else "pair")
        for told, name, canvas in zip(self._told, self._names, self._canvases, strict=True):
            if told is not None:
                canvas.show(self._wish(told, self.site.folder.run(name.value), T))

    def _wish(self, told: Told, run: Path, T: float | None) -> Wish:
        """The picture of one run, at the map next to a time."""
        at = None if not told.T or T is None else min(told.T, key=lambda t: abs(t - T))
        is_midline_of_steady = self._figure.value == "profiles" and not told.T
        return Wish(run, "midlines" if is_midline_of_steady else self._figure.value, at, stamp=stamp_of(run))
