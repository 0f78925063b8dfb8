"""The pages of runs: of one, with its status, numbers, pictures and downloads, and of two side by side."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from time import monotonic

from nicegui import ui

from ertel.apps.browser.canvas import Canvas, Slider
from ertel.apps.browser.folder import summary_of
from ertel.apps.browser.pictures import CHOICES, FIGURES, INTERFEROGRAM, PlotRequest, RunInfo, stamp_of
from ertel.apps.browser.processes import Phase
from ertel.apps.browser.site import (
    Site,
    WatchedPage,
    address_of,
    question,
    sentence,
    show_line,
    show_notes,
    show_number,
    told,
)
from ertel.case.methods import METHODS
from ertel.case.status import Status
from ertel.results.numbers import key_numbers, more_lines
from ertel.runs.directory import CASE, SUMMARY, study_of
from ertel.runs.files import content_of

LIVE = 3.0  # seconds between two live pictures, at least
NARROW = {"film": "Film", "pressure": "Pressure"}  # figures of one panel, that stand beside each other
WIDE = {name: FIGURES[name][0] for name in ("profiles", "history", "friction", INTERFEROGRAM)}  # one above the other


class RunPage(WatchedPage):
    """The page of a run, renewed each second."""

    def __init__(self, site: Site, name: str = ""):
        try:
            super().__init__(site, site.find(name), {Phase.FINISHED: ""})
        except ValueError as error:
            ui.label(f"{error}.").classes("alert")  # begins with a name
            return
        self._info = RunInfo()
        self._stamp, self._drawn, self._is_there = 0, 0.0, self.path.exists()
        self._under = self.show_head("")
        if study := study_of(self.path, site.folder.root):
            name = site.folder.name_of(study)
            ui.link(f"A run of {name}", address_of("/study", name=name)).classes("more")
        self.show_progress()
        with ui.element("div").classes("numbers"):
            self._show_numbers()
        with ui.element("div").classes("card pictures"):
            with ui.row().classes("tools"):
                self._tabs = ui.tabs(on_change=self._show)
                self._tabs.props("no-caps dense inline-label align=left narrow-indicator")
                ui.space()
                self._choices = {figure: ui.select(dict(of), value=next(iter(of))) for figure, of in CHOICES.items()}
                for figure, choice in self._choices.items():
                    choice.props("dense borderless options-dense").mark(f"choice-{figure}").on_value_change(self._show)
            self._canvas = Canvas(site.worker)
            self._slider = Slider(self._show)
        with ui.element("div").classes("notes"):
            self._show_warnings()
        ui.timer(1.0, self._look)

    def show_more(self) -> None:
        """Show the downloads, then the menu of what else can be done."""
        with ui.button(icon="download").props("flat round aria-label='Download'").mark("download"):
            ui.tooltip("Download")
            with ui.menu():
                ui.menu_item("Case file (TOML)", lambda: self._download_file(CASE, ".toml")).mark("download-case")
                ui.menu_item("Summary (JSON)", lambda: self._download_file(SUMMARY, "-summary.json"))
                for kind in ("png", "svg", "pdf"):
                    item = ui.menu_item(f"This picture ({kind.upper()})", lambda kind=kind: self._download(kind))
                    item.mark(f"download-{kind}")
        super().show_more()

    def show_items(self) -> None:
        """Show what can be begun from this run."""
        new, compare = address_of("/new", case=f"{self.name}/{CASE}"), address_of("/compare", a=self.name)
        ui.menu_item("New case from this one", lambda: ui.navigate.to(new))
        ui.menu_item("Compare with another run", lambda: ui.navigate.to(compare))
        method = METHODS.get((summary_of(self.path) or {}).get("method", ""))
        if method and method.is_steady:
            ui.menu_item("Traction curve", self._ask_for_curve).mark("traction")

    # -- asked for ----------------------------------------------------------------------------------------------------

    async def _download(self, kind: str) -> None:
        request = self._request(kind, dots=200)
        with told():
            picture = await self.site.worker.draw(request)
            ui.download.content(picture.content, f"{self.path.name}-{request.figure}.{request.kind}")

    def _download_file(self, name: str, ending: str) -> None:
        with told(f"{name} cannot be read; it is written when the run begins or ends: "):
            ui.download.content(content_of(self.path / name), f"{self.path.name}{ending}")

    def _ask_for_curve(self) -> None:
        """Ask for slide-to-roll ratios, and start a traction curve over them."""

        def start() -> None:
            dialog.close()
            with told():
                place = self.site.processes.trace(self.path, ratios.value)
                ui.navigate.to(address_of("/study", name=self.site.folder.name_of(place)))

        with question("Traction curve", "Slide-to-roll ratios: FIRST:LAST:NUMBER, or values with commas.") as dialog:
            ratios = ui.input(value="0:0.2:9").props("outlined dense").mark("ratios")
            ui.button("Start", on_click=start).props("unelevated").mark("start-curve")

    # -- renewed ------------------------------------------------------------------------------------------------------

    async def _look(self) -> None:
        """Look for new data; a run that goes on is drawn now and then.  The page of a run that was deleted ends."""
        was_there, self._is_there = self._is_there, self.path.exists()
        if was_there and not self._is_there:
            ui.navigate.to("/")
            return
        if self.renew():
            self._show_numbers.refresh()
            self._show_warnings.refresh()
        stamp, now, is_active = stamp_of(self.path), monotonic(), self.status.phase.is_active
        if stamp == self._stamp or (self._info.figures and is_active and now - self._drawn < LIVE):
            return
        try:
            info = await self.site.worker.info(self.path)
        except ValueError as error:  # between two writes, or damaged; the next look tells
            if not (self._info.figures or is_active or self._under.is_deleted):
                self._stamp = stamp
                self._canvas.say(str(error))
            return
        if not self._under.is_deleted:  # the page was not left
            self._stamp, self._drawn = stamp, now
            self._take_over(info)

    def _take_over(self, info: RunInfo) -> None:
        """Show new data, at the moment that was chosen.

        Where that was the last one before, the page follows the run: to its new last moment, and at its end to maximum
        approach.
        """
        follows = not self._info.figures or self._slider.at_end
        if self._info.figures != info.figures:
            self._fill_tabs(info)
        last = max(len(info.T) - 1, 0)
        best = last if self.status.phase.is_active else info.events.get("max-approach", last)
        self._info = info
        self._slider.fill(info, best if follows else self._slider.index)
        self._under.set_text(info.title if info.title != self.path.name else self.name)
        self._show_numbers.refresh()
        self._show()

    def _fill_tabs(self, info: RunInfo) -> None:
        self._tabs.clear()
        with self._tabs:
            for figure in info.figures:
                label, icon = FIGURES[figure]
                ui.tab(figure, label, icon).mark(f"tab-{figure}")
        if self._tabs.value not in info.figures:
            self._tabs.set_value(info.figures[0])

    def _show(self) -> None:
        """Show the picture that is chosen."""
        if self._info.figures and self._tabs.value:
            for figure, choice in self._choices.items():
                choice.set_visibility(figure == self._tabs.value and (figure == INTERFEROGRAM or len(self._info.T) > 1))
            request = self._request()
            ahead = () if request.is_movie else self._slider.ahead
            self._canvas.show(request, [replace(request, at=self._slider.at(map_)) for map_ in ahead])

    def _request(self, kind: str = "png", dots: int = 130) -> PlotRequest:
        figure = self._tabs.value or "overview"
        choice = self._choices[figure].value if figure in CHOICES else ""
        request = PlotRequest(self.path, figure, self._slider.at(self._slider.index), choice, kind, dots, self._stamp)
        return replace(request, at=None, kind="webp", dots=0) if request.is_movie else request

    @ui.refreshable_method
    def _show_numbers(self) -> None:
        """The key numbers of the summary, or the last values of a run that goes on."""
        summary = summary_of(self.path)
        numbers = key_numbers(summary) if summary else []
        failed = summary and Status(summary["status"]).failed
        if not numbers and self._info.T and not failed:  # those of the first grids of a steady contact mean nothing
            numbers = list(self._info.latest)
        for number in numbers:
            show_number(number)

    @ui.refreshable_method
    def _show_warnings(self) -> None:
        """The rest of the summary in sentences, temperatures and stresses among them, and the warnings."""
        summary = summary_of(self.path)
        for line in more_lines(summary) if summary else ():
            ui.label(sentence(line)).classes("more")
        show_notes(summary["warnings"] if summary else [])


# -- two runs ----------------------------------------------------------------------------------------------------------


class Comparison:
    """The page of two runs side by side: one figure, one time."""

    def __init__(self, site: Site, a: str = "", b: str = ""):
        self.site = site
        names = [entry.name for entry in site.entries()]
        if not names:
            ui.label("There is no run in this folder yet.").classes("alert")
            return
        first = a if a in names else names[0]
        second = b if b in names else next((name for name in names if name != first), first)
        with ui.row().classes("head"):
            ui.label("Two runs side by side").classes("title")
            ui.space()
            self._figure = ui.toggle({**NARROW, **WIDE}, value="film", on_change=self._show).classes("choice")
            self._figure.props("no-caps unelevated dense")
        with ui.element("div").classes("card moment-card") as self._when:
            self._slider = Slider(self._show)
        with ui.element("div").classes("pair") as self._pair:
            self._sides = [_Side(self, names, name) for name in (first, second)]

    def begin(self) -> None:
        """Take over the times of both runs, when both are known: at maximum approach first, then at the time chosen."""
        known = [side.info for side in self._sides if side.info]
        if len(known) == len(self._sides):
            chosen, T = self._slider.T(self._slider.index), sorted({t for info in known for t in info.T})
            # an event that both have is that of the first run
            events = {event: T.index(info.T[map_]) for info in reversed(known) for event, map_ in info.events.items()}
            index = events.get("max-approach", max(len(T) - 1, 0))
            if chosen is not None and T:
                index = T.index(min(T, key=lambda t: abs(t - chosen)))
            self._when.set_visibility(bool(T))
            self._slider.fill(RunInfo(T=tuple(T), events=events), index)
        self._show()

    def _show(self) -> None:
        self._pair.classes(replace="pair wide" if self._figure.value in WIDE else "pair")
        times = [self._slider.T(map_) for map_ in (self._slider.index, *self._slider.ahead)]
        pairs = [_on_equal_scales(*(side.request(self._figure.value, T) for side in self._sides)) for T in times]
        for side, (first, *ahead) in zip(self._sides, zip(*pairs, strict=True), strict=True):
            if first:
                side.canvas.show(first, [request for request in ahead if request])


def _on_equal_scales(one: PlotRequest | None, two: PlotRequest | None) -> Sequence[PlotRequest | None]:
    """The requests of both sides, with equal scales where both show the same figure."""
    if one is None or two is None or one.figure != two.figure:
        return one, two
    return replace(one, beside=two), replace(two, beside=one)


class _Side:
    """One of the runs: its name, its numbers, its picture.  info: None until it is read."""

    def __init__(self, page: Comparison, names: list[str], chosen: str):
        self._page = page
        self._run: Path | None = None
        self.info: RunInfo | None = None
        with ui.element("div").classes("card side"):
            self._name = ui.select(names, value=chosen, on_change=self._choose).props("dense outlined")
            self._numbers = ui.element("div").classes("lines")
            self.canvas = Canvas(page.site.worker)
        ui.timer(0.05, self._choose, once=True)

    async def _choose(self) -> None:
        """Take over the run that was chosen."""
        with told():
            run = self._page.site.folder.run(self._name.value)
            info = await self._page.site.worker.info(run)
            if not self._numbers.is_deleted:  # the page was not left
                self._show(run, info)

    def _show(self, run: Path, info: RunInfo) -> None:
        self._run, self.info = run, info
        summary = summary_of(run)
        self._numbers.clear()
        with self._numbers:
            for number in key_numbers(summary) if summary else []:
                show_line(number.about.long_name, number.text_in_si or number.text)
        self._page.begin()

    def request(self, figure: str, T: float | None) -> PlotRequest | None:
        """The request for a figure, at the map next to a time; None until the run is read."""
        if self._run is None or self.info is None:
            return None
        at = None if T is None else min(self.info.T, key=lambda t: abs(t - T), default=None)
        if figure in NARROW and "maps" not in self.info.figures:  # of a line contact
            figure = "profiles"
        name = "midlines" if figure == "profiles" and not self.info.T else figure
        return PlotRequest(self._run, name, at, stamp=stamp_of(self._run))
