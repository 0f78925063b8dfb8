"""The page of a run: how it stands, its numbers, its pictures with a slider, and what can be downloaded."""

import json
from pathlib import Path
from time import monotonic

from nicegui import ui

from ertel.apps.browser.canvas import Canvas, Slider
from ertel.apps.browser.processes import Phase, Standing
from ertel.apps.browser.records import summary_of
from ertel.apps.browser.site import SAID, Site, address_of
from ertel.apps.browser.wishes import INTERFEROGRAM, LIGHTS, Told, Wish, stamp_of
from ertel.apps.browser.words import news, show_number
from ertel.apps.terminal import reason_of
from ertel.results.numbers import key_numbers
from ertel.runs.directory import CASE
from ertel.runs.files import content_of

TABS = {
    "maps": ("Film and pressure", "blur_circular"),
    "profiles": ("Mid-line", "show_chart"),
    "midlines": ("Mid-lines", "show_chart"),
    "history": ("Motion", "timeline"),
    "front": ("Front", "open_in_full"),
    "friction": ("Friction", "local_fire_department"),
    INTERFEROGRAM: ("Interferogram", "lens_blur"),
    "convergence": ("Grids", "grid_on"),
    "overview": ("Overview", "dashboard"),
}
LIVE = 3.0  # seconds between two live pictures, at least


def run_page(site: Site, name: str = "") -> None:
    """The page of a run."""
    try:
        path = site.find(name)
    except ValueError as error:
        ui.label(f"{error}.").classes("alert")  # begins with a name
        return
    RunPage(site, path)


class RunPage:
    """What the page shows now, renewed each second."""

    def __init__(self, site: Site, path: Path):
        self.site, self.path = site, path
        self.name = site.folder.name_of(path)
        self._told: Told | None = None
        self._stamp, self._drawn = 0, 0.0
        self._standing = site.processes.standing(path)
        self._head()
        self._numbers = ui.element("div").classes("numbers")
        with ui.element("div").classes("card pictures"):
            with ui.row().classes("tools"):
                self._tabs = ui.tabs(on_change=self._show).props(
                    "no-caps dense inline-label align=left narrow-indicator"
                )
                ui.space()
                self._light = ui.select(LIGHTS, value="mono", on_change=self._show).props("dense borderless")
                self._light.props("options-dense").mark("light")
                self._light.set_visibility(False)
            self._canvas = Canvas(site)
            self._slider = Slider(self._show)
        self._notes = ui.element("div").classes("notes")
        self._stand(self._standing)
        ui.timer(1.0, self._look)

    # -- built once ---------------------------------------------------------------------------------------------------

    def _head(self) -> None:
        with ui.row().classes("head"):
            with ui.element("div"):
                ui.label(self.path.name).classes("title")
                self._under = ui.label().classes("under")
            ui.space()
            self._chip = ui.element("div").classes("chip")
            self._stop = ui.button("Stop", icon="stop", on_click=self._stopped).props("outline no-caps color=accent")
            self._resume = ui.button("Resume", icon="play_arrow", on_click=self._resumed).props("unelevated no-caps")
            self._stop.mark("stop"), self._resume.mark("resume")
            self._downloads()
        with ui.element("div").classes("card progress") as self._going:
            self._bar = ui.linear_progress(value=0.0, show_value=False).props("size=6px rounded")
            self._news = ui.label().classes("news")

    def _downloads(self) -> None:
        with ui.button(icon="download").props("flat round aria-label='Download'").mark("download"):
            ui.tooltip("Download")
            with ui.menu():
                ui.menu_item("Case file (TOML)", self._download_case).mark("download-case")
                ui.menu_item("Summary (JSON)", self._download_summary)
                for kind in ("png", "svg", "pdf"):
                    item = ui.menu_item(f"This picture ({kind.upper()})", lambda kind=kind: self._download(kind))
                    item.mark(f"download-{kind}")
        with ui.button(icon="more_vert").props("flat round aria-label='More'"), ui.menu():
            ui.menu_item(
                "New case from this one", lambda: ui.navigate.to(address_of("/new", case=f"{self.name}/{CASE}"))
            )
            ui.menu_item("Compare with another run", lambda: ui.navigate.to(address_of("/compare", a=self.name)))

    # -- asked for ----------------------------------------------------------------------------------------------------

    def _stopped(self) -> None:
        try:
            self.site.processes.stop(self.path)
        except (ValueError, OSError) as error:
            ui.notify(str(error))
        self._renew()

    def _resumed(self) -> None:
        try:
            self.site.processes.resume(self.path)
        except (ValueError, OSError) as error:
            ui.notify(str(error))
        self._renew()

    async def _download(self, kind: str) -> None:
        wish = self._wish(kind, dots=200)
        try:
            content = await self.site.artist.draw(wish)
        except ValueError as error:
            ui.notify(str(error))
            return
        ui.download.content(content, f"{self.path.name}-{wish.figure}.{kind}")

    def _download_case(self) -> None:
        try:
            content = content_of(self.path / CASE)
        except FileNotFoundError:
            ui.notify("The case file is written when the run begins.")
            return
        except OSError as error:
            ui.notify(f"The case file cannot be read: {reason_of(error)}.")
            return
        ui.download.content(content, f"{self.path.name}.toml")

    def _download_summary(self) -> None:
        summary = summary_of(self.path)
        if summary is None:
            ui.notify("The summary is written when the run ends.")
            return
        ui.download.content(json.dumps(summary, indent=2).encode(), f"{self.path.name}-summary.json")

    # -- renewed ------------------------------------------------------------------------------------------------------

    async def _look(self) -> None:
        self._renew()
        stamp, now = stamp_of(self.path), monotonic()
        if stamp == self._stamp or (self._told and self._standing.phase.is_active and now - self._drawn < LIVE):
            return
        try:
            told = await self.site.artist.tell(self.path)
        except ValueError as error:  # between two writes, or damaged; the next look tells
            if not (self._told or self._standing.phase.is_active or self._numbers.is_deleted):
                self._stamp = stamp
                self._canvas.say(str(error))
            return
        if self._numbers.is_deleted:  # the page was left
            return
        self._stamp, self._drawn = stamp, now
        self._take_over(told)

    def _take_over(self, told: Told) -> None:
        """Show what is new, at the moment that was chosen.

        Where that was the last one before, the page follows the run: to its new last moment, and at its end to maximum
        approach.
        """
        follows = self._told is None or self._slider.at_end
        if self._told is None or self._told.figures != told.figures:
            self._fill_tabs(told)
        active = self._standing.phase.is_active
        last = max(len(told.T) - 1, 0)
        best = last if active else told.events.get("max-approach", last)
        self._told = told
        self._slider.fill(told, best if follows else self._slider.index)
        self._under.set_text(told.title if told.title != self.path.name else self.name)
        self._fill_numbers()
        self._show()

    def _fill_tabs(self, told: Told) -> None:
        self._tabs.clear()
        with self._tabs:
            for figure in told.figures:
                label, icon = TABS[figure]
                ui.tab(figure, label, icon).mark(f"tab-{figure}")
        if self._tabs.value not in told.figures:
            self._tabs.set_value(told.figures[0])

    def _show(self) -> None:
        if self._told is None:
            return
        self._light.set_visibility(self._tabs.value == INTERFEROGRAM)
        if self._tabs.value:
            self._canvas.show(self._wish())

    def _wish(self, kind: str = "png", dots: int = 130) -> Wish:
        light = self._light.value if self._tabs.value == INTERFEROGRAM else "mono"
        figure = self._tabs.value or "overview"
        return Wish(self.path, figure, self._slider.at, light, kind, dots, self._stamp)

    def _renew(self) -> None:
        standing = self.site.processes.standing(self.path)
        if standing != self._standing:
            self._stand(standing)

    def _stand(self, standing: Standing) -> None:
        """Show how the run stands."""
        self._standing = standing
        word, icon = SAID[standing.phase]
        self._chip.classes(replace=f"chip {standing.phase.value}").clear()
        with self._chip:
            ui.icon(icon)
            ui.label(word).mark("phase")
        active = standing.phase.is_active
        self._stop.set_visibility(active)
        self._stop.set_text("Stop now" if standing.phase is Phase.STOPPING else "Stop")
        self._resume.set_visibility(not active and standing.phase is not Phase.FINISHED)
        self._going.set_visibility(standing.phase is not Phase.FINISHED)
        waits = standing.phase is Phase.COMPILING
        self._bar.props(add="indeterminate" if waits else "", remove="" if waits else "indeterminate")
        self._bar.set_value(standing.done)
        self._news.set_text(news(standing))
        self._fill_numbers()

    def _fill_numbers(self) -> None:
        """The key numbers of the summary, or the last values of a run that goes on."""
        summary = summary_of(self.path)
        numbers = key_numbers(summary) if summary else []
        cards = [(n.long_name, n.symbol, n.text, n.text_in_si, n.text_of_error) for n in numbers]
        if not cards and self._told and self._told.T:  # those of the first grids of a steady contact mean nothing
            cards = [(*texts, "", "") for texts in self._told.news]
        self._numbers.clear()
        with self._numbers:
            for card in cards:
                show_number(*card)
        self._notes.clear()
        with self._notes:
            for sentence in (summary or {}).get("warnings", []):
                with ui.row().classes("note"):
                    ui.icon("info")
                    ui.label(f"{sentence[:1].upper()}{sentence[1:]}.")
