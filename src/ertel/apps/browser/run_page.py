"""The page of a run: its status, its numbers, its pictures with a slider, and what can be downloaded."""

import json
from collections.abc import Callable
from pathlib import Path
from time import monotonic

from nicegui import ui

from ertel.apps.browser.elements import Canvas, Slider, sentence, show_card, show_notes
from ertel.apps.browser.folder import summary_of
from ertel.apps.browser.pictures import INTERFEROGRAM, LIGHTS, PlotRequest, RunInfo, stamp_of
from ertel.apps.browser.processes import Phase, RunStatus
from ertel.apps.browser.site import LABELS, Site, address_of
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
COMPILING = (
    "Starting, then compiling: once per machine and grid size, usually 10 to 60 s. "
    "Later runs on this grid begin after a few seconds."
)


def run_page(site: Site, name: str = "") -> None:
    """The page of a run."""
    try:
        path = site.find(name)
    except ValueError as error:
        ui.label(f"{error}.").classes("alert")  # begins with a name
        return
    RunPage(site, path)


class RunPage:
    """The elements of the page, renewed each second."""

    def __init__(self, site: Site, path: Path):
        self.site, self.path = site, path
        self.name = site.folder.name_of(path)
        self._info = RunInfo()
        self._stamp, self._drawn = 0, 0.0
        self._status = site.processes.status(path)
        self._head()
        self._numbers = ui.element("div").classes("numbers")
        with ui.element("div").classes("card pictures"):
            with ui.row().classes("tools"):
                self._tabs = ui.tabs(on_change=self._show)
                self._tabs.props("no-caps dense inline-label align=left narrow-indicator")
                ui.space()
                self._light = ui.select(LIGHTS, value="mono", on_change=self._show).mark("light")
                self._light.props("dense borderless options-dense")
                self._light.bind_visibility_from(self._tabs, "value", value=INTERFEROGRAM)
            self._canvas = Canvas(site.plots)
            self._slider = Slider(self._show)
        self._notes = ui.element("div").classes("notes")
        self._show_status()
        ui.timer(1.0, self._look)

    # -- built once ---------------------------------------------------------------------------------------------------

    def _head(self) -> None:
        processes = self.site.processes
        with ui.row().classes("head"):
            with ui.element("div"):
                ui.label(self.path.name).classes("title")
                self._under = ui.label().classes("under")
            ui.space()
            self._chip = ui.element("div").classes("chip")
            self._stop = ui.button("Stop", icon="stop", on_click=lambda: self._order(processes.stop)).mark("stop")
            self._stop.props("outline no-caps color=accent")
            resume = ui.button("Resume", icon="play_arrow", on_click=lambda: self._order(processes.resume))
            self._resume = resume.props("unelevated no-caps").mark("resume")
            self._downloads()
        with ui.element("div").classes("card progress") as self._going:
            self._bar = ui.linear_progress(value=0.0, show_value=False).props("size=6px rounded")
            self._message = ui.label().classes("news")

    def _downloads(self) -> None:
        with ui.button(icon="download").props("flat round aria-label='Download'").mark("download"):
            ui.tooltip("Download")
            with ui.menu():
                ui.menu_item("Case file (TOML)", self._download_case).mark("download-case")
                ui.menu_item("Summary (JSON)", self._download_summary)
                for kind in ("png", "svg", "pdf"):
                    item = ui.menu_item(f"This picture ({kind.upper()})", lambda kind=kind: self._download(kind))
                    item.mark(f"download-{kind}")
        new, compare = address_of("/new", case=f"{self.name}/{CASE}"), address_of("/compare", a=self.name)
        with ui.button(icon="more_vert").props("flat round aria-label='More'"), ui.menu():
            ui.menu_item("New case from this one", lambda: ui.navigate.to(new))
            ui.menu_item("Compare with another run", lambda: ui.navigate.to(compare))

    # -- asked for ----------------------------------------------------------------------------------------------------

    def _order(self, order: Callable[[Path], None]) -> None:
        """Stop or resume the run."""
        try:
            order(self.path)
        except (ValueError, OSError) as error:
            ui.notify(str(error))
        self._renew()

    async def _download(self, kind: str) -> None:
        request = self._request(kind, dots=200)
        try:
            content = await self.site.plots.draw(request)
        except ValueError as error:
            ui.notify(str(error))
            return
        ui.download.content(content, f"{self.path.name}-{request.figure}.{kind}")

    def _download_case(self) -> None:
        try:
            ui.download.content(content_of(self.path / CASE), f"{self.path.name}.toml")
        except FileNotFoundError:
            ui.notify("The case file is written when the run begins.")
        except OSError as error:
            ui.notify(f"The case file cannot be read: {reason_of(error)}.")

    def _download_summary(self) -> None:
        summary = summary_of(self.path)
        if summary is None:
            ui.notify("The summary is written when the run ends.")
        else:
            ui.download.content(json.dumps(summary, indent=2).encode(), f"{self.path.name}-summary.json")

    # -- renewed ------------------------------------------------------------------------------------------------------

    async def _look(self) -> None:
        """Look for new data; a run that goes on is drawn now and then."""
        self._renew()
        stamp, now, is_active = stamp_of(self.path), monotonic(), self._status.phase.is_active
        if stamp == self._stamp or (self._info.figures and is_active and now - self._drawn < LIVE):
            return
        message = ""
        try:
            info = await self.site.plots.info(self.path)
        except ValueError as error:  # between two writes, or damaged; the next look tells
            message = str(error)
        if self._numbers.is_deleted:  # the page was left
            return
        if not message:
            self._stamp, self._drawn = stamp, now
            self._take_over(info)
        elif not (self._info.figures or is_active):
            self._stamp = stamp
            self._canvas.say(message)

    def _take_over(self, info: RunInfo) -> None:
        """Show new data, at the moment that was chosen.

        Where that was the last one before, the page follows the run: to its new last moment, and at its end to maximum
        approach.
        """
        follows = not self._info.figures or self._slider.at_end
        if self._info.figures != info.figures:
            self._fill_tabs(info)
        last = max(len(info.T) - 1, 0)
        best = last if self._status.phase.is_active else info.events.get("max-approach", last)
        self._info = info
        self._slider.fill(info, best if follows else self._slider.index)
        self._under.set_text(info.title if info.title != self.path.name else self.name)
        self._fill_numbers()
        self._show()

    def _fill_tabs(self, info: RunInfo) -> None:
        self._tabs.clear()
        with self._tabs:
            for figure in info.figures:
                label, icon = TABS[figure]
                ui.tab(figure, label, icon).mark(f"tab-{figure}")
        if self._tabs.value not in info.figures:
            self._tabs.set_value(info.figures[0])

    def _show(self) -> None:
        """Show the picture that is chosen."""
        if self._info.figures and self._tabs.value:
            self._canvas.show(self._request())

    def _request(self, kind: str = "png", dots: int = 130) -> PlotRequest:
        light = self._light.value if self._tabs.value == INTERFEROGRAM else "mono"
        figure = self._tabs.value or "overview"
        return PlotRequest(self.path, figure, self._slider.at, light, kind, dots, self._stamp)

    def _renew(self) -> None:
        status = self.site.processes.status(self.path)
        if status != self._status:
            self._status = status
            self._show_status()

    def _show_status(self) -> None:
        status, phase = self._status, self._status.phase
        word, icon = LABELS[phase]
        self._chip.classes(replace=f"chip {phase.value}").clear()
        with self._chip:
            ui.icon(icon)
            ui.label(word).mark("phase")
        self._stop.set_visibility(phase.is_active)
        self._stop.set_text("Stop now" if phase is Phase.STOPPING else "Stop")
        self._resume.set_visibility(not phase.is_active and phase is not Phase.FINISHED)
        self._going.set_visibility(phase is not Phase.FINISHED)
        waits = phase is Phase.COMPILING
        self._bar.props(add="indeterminate" if waits else "", remove="" if waits else "indeterminate")
        self._bar.set_value(status.done)
        self._message.set_text(message_of(status))
        self._fill_numbers()

    def _fill_numbers(self) -> None:
        """The key numbers of the summary, or the last values of a run that goes on."""
        summary = summary_of(self.path)
        numbers = key_numbers(summary) if summary else []
        cards = [(n.long_name, n.symbol, n.text, n.text_in_si, n.text_of_error) for n in numbers]
        if not cards and self._info.T:  # those of the first grids of a steady contact mean nothing
            cards = [(*texts, "", "") for texts in self._info.latest]
        self._numbers.clear()
        with self._numbers:
            for card in cards:
                show_card(*card)
        self._notes.clear()
        with self._notes:
            show_notes((summary or {}).get("warnings", []))


def message_of(status: RunStatus) -> str:
    """The status of a run in a sentence."""
    progress = status.progress or {}
    match status.phase:
        case Phase.COMPILING:
            return COMPILING + (f" It began {status.seconds:.0f} s ago." if status.seconds else "")
        case Phase.STOPPING:
            return "Stopping: the current step or grid is finished first, then it can be resumed."
        case Phase.FAILED | Phase.DAMAGED:
            return sentence(status.message).removesuffix(".")
    place = f"grid {progress.get('step', 0)}, the coarse ones first"
    if progress.get("T") is not None:
        place = f"T = {progress['T']:.3f}, step {progress['step']}"
    if status.phase is Phase.INTERRUPTED:
        return f"Interrupted at {place}; it can be resumed." if progress else "Interrupted before its first step."
    seconds_left = progress.get("seconds_left")
    left = "" if seconds_left is None else f", about {_duration(seconds_left)} left"
    return f"{status.done:.0%} · {place} · {_duration(progress.get('seconds', 0.0))}{left}"


def _duration(seconds: float) -> str:
    return f"{seconds:.0f} s" if seconds < 90 else f"{seconds / 60:.0f} min"
