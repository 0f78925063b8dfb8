"""Two runs side by side, at the same time."""

from pathlib import Path

from nicegui import ui

from ertel.apps.browser.elements import Canvas, pretty, show_line
from ertel.apps.browser.folder import summary_of
from ertel.apps.browser.pictures import INTERFEROGRAM, PlotRequest, RunInfo, stamp_of
from ertel.apps.browser.run_page import TABS
from ertel.apps.browser.site import Site
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
        self._begun = False
        with ui.row().classes("head"):
            ui.label("Two runs side by side").classes("title")
            ui.space()
            self._figure = ui.toggle({**NARROW, **WIDE}, value="film", on_change=self._show).classes("choice")
            self._figure.props("no-caps unelevated dense")
        with ui.element("div").classes("card moment-card") as self._when, ui.row().classes("moment"):
            ui.icon("schedule")
            self._slider = ui.slider(min=0, max=STEPS, value=STEPS, on_change=self._show).mark("slider")
            self._label = ui.label().classes("time")
        with ui.element("div").classes("pair") as self._pair:
            self._sides = [_Side(self, names, name) for name in chosen]

    def show(self) -> None:
        """Show both pictures; begin at maximum approach, where one of the runs has it."""
        known = [side.info for side in self._sides if side.info]
        maxima = [info.T[info.events["max-approach"]] for info in known if "max-approach" in info.events]
        if len(known) == len(self._sides) and maxima and not self._begun:
            self._begun = True
            self._slider.set_value(round(STEPS * maxima[0] / self._end))
        self._show()

    @property
    def _end(self) -> float:
        """The T at which the slider ends; 0 for two steady contacts."""
        return max((side.info.T[-1] for side in self._sides if side.info and side.info.T), default=0.0)

    def _show(self) -> None:
        T = self._end * self._slider.value / STEPS if self._end else None
        self._when.set_visibility(T is not None)
        self._label.set_text("" if T is None else f"T = {T:.3f}")
        self._pair.classes(replace="pair wide" if self._figure.value in WIDE else "pair")
        for side in self._sides:
            side.show(self._figure.value, T)


class _Side:
    """One of the runs: its name, its numbers, its picture.  info: None until it is read."""

    def __init__(self, page: Comparison, names: list[str], chosen: str):
        self._page = page
        self._run: Path | None = None
        self.info: RunInfo | None = None
        with ui.element("div").classes("card side"):
            self._name = ui.select(names, value=chosen, on_change=self._choose).props("dense outlined")
            self._numbers = ui.element("div").classes("lines")
            self._canvas = Canvas(page.site.plots)
        ui.timer(0.05, self._choose, once=True)

    async def _choose(self) -> None:
        """Take over the run that was chosen."""
        try:
            run = self._page.site.folder.run(self._name.value)
            info = await self._page.site.plots.info(run)
        except ValueError as error:
            ui.notify(str(error))
            return
        if self._numbers.is_deleted:  # the page was left
            return
        self._run, self.info = run, info
        summary = summary_of(run)
        self._numbers.clear()
        with self._numbers:
            for number in key_numbers(summary) if summary else []:
                show_line(number.long_name, number.text_in_si or pretty(number.text))
        self._page.show()

    def show(self, figure: str, T: float | None) -> None:
        """Show a figure, at the map next to a time."""
        if self._run is None or self.info is None:
            return
        at = None if T is None else min(self.info.T, key=lambda t: abs(t - T), default=None)
        name = "midlines" if figure == "profiles" and not self.info.T else figure
        self._canvas.show(PlotRequest(self._run, name, at, stamp=stamp_of(self._run)))
