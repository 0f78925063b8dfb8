"""The parts that all pages share: the app, the frame with the list of runs and studies, and elements of pages."""

import os
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from html import escape
from pathlib import Path
from typing import Any
from urllib.parse import quote, urlencode

from fastapi import Response
from nicegui import app, ui

from ertel.apps.browser.folder import Folder, about_study, in_unicode, summary_of
from ertel.apps.browser.pictures import PICTURES, Worker
from ertel.apps.browser.processes import Phase, Processes, RunStatus
from ertel.apps.terminal import capital, reason_of
from ertel.results.numbers import Number
from ertel.runs.directory import RUNS, study_of

LOOKS = {"As the system": None, "Light": False, "Dark": True}
LOOK = "ertel-look"  # the cookie in which the browser keeps one of them
SECONDS = 2.0  # between two looks at the folder
LOGO = (
    '<svg class="logo" xmlns="http://www.w3.org/2000/svg" viewBox="0 0 40 40" aria-hidden="true" fill="none" '
    'stroke="#0b5673" stroke-width="3"><circle cx="20" cy="15" r="11"/><path d="M3 31 H13 Q20 25.5 27 31 H37"/>'
    '<path class="thin" d="M3 36 H37"/></svg>'
)
EMPTY = '<div class="hint">None yet in this folder. Start with a new case.</div>'
DELETE = "(event) => { const row = event.target.closest('[data-run]'); if (row) emit(row.dataset.run) }"

ui.button.default_props("no-caps")


@dataclass(frozen=True)
class Entry:
    """A run or a study in the list.  about: kind, M and L, if they are known."""

    name: str
    path: Path
    status: RunStatus
    about: str = ""
    page: str = "/run"

    @property
    def address(self) -> str:
        """The address of its page."""
        return address_of(self.page, name=self.name)


@dataclass
class Site:
    """The app: one folder, for all pages."""

    folder: Folder
    processes: Processes
    worker: Worker

    def serve_pictures(self) -> None:
        """Answer requests for the pictures that pages were given the addresses of."""

        @app.get(f"/{PICTURES}/{{name}}")
        def picture(name: str) -> Response:
            found = self.worker.kept.get(f"{PICTURES}/{name}")
            if found is None:
                return Response("no such picture", 404)
            kind = f"image/{name.rpartition('.')[2]}"
            return Response(found.content, media_type=kind, headers={"Cache-Control": "max-age=600"})

    def entries(self) -> list[Entry]:
        """The runs of the folder, those that go on first, then the latest."""
        ours = [path for path in self.processes.ours() if path.parent.name == RUNS]
        paths = dict.fromkeys([*ours, *self.folder.runs()])
        found = [Entry(self.folder.name_of(path), path, self.processes.status(path), _about(path)) for path in paths]
        return sorted(found, key=lambda entry: not entry.status.phase.is_active)

    def studies(self) -> list[Entry]:
        """The studies of the folder, by name."""
        named = {path: self.folder.name_of(path) for path in self.folder.studies()}
        status = self.processes.status
        return [Entry(name, path, status(path), about_study(path), "/study") for path, name in named.items()]

    def find(self, name: str) -> Path:
        """The directory of a run, which may not be there yet if it was just started.  Raises ValueError."""
        path = self.folder.inside(name)
        return path if self.processes.knows(path) else self.folder.run(name)

    def rows(self, root: str) -> str:
        """The list in HTML, the same text for all pages: the runs, then the studies, each of them for all of its runs.

        root: of the addresses of pages.
        """
        runs = [entry for entry in self.entries() if not study_of(entry.path, self.folder.root)]
        return sys.intern("".join(_row(entry, root) for entry in (*runs, *self.studies())) or EMPTY)

    def ask_about(self, key: str) -> None:
        """Ask whether a run or a study in the list is to be deleted.  key: see `_row`."""
        path = Path(os.fsdecode(bytes.fromhex(key)))
        if path in [entry.path for entry in (*self.entries(), *self.studies())]:
            self.ask_to_delete(path)

    def ask_to_delete(self, run: Path) -> None:
        """Ask whether a run, or the study that it belongs to, is to be deleted, and delete it."""

        def delete(place: Path) -> None:
            dialog.close()
            with told(f"{self.folder.name_of(place)} cannot be deleted: "):
                self.processes.delete(place)

        name, study = self.folder.name_of(run), study_of(run, self.folder.root)
        what = "Its data are removed from the disk for good. Case files outside of its directory stay."
        with question(f"Delete {name}?", what) as dialog:
            if study:
                text = f"Delete the study {self.folder.name_of(study)} with all its runs"
                ui.button(text, on_click=lambda: delete(study)).props("outline color=negative").mark("delete-study")
            ui.button("Delete", on_click=lambda: delete(run)).props("unelevated color=negative").mark("delete-it")


def _about(run: Path) -> str:
    summary = summary_of(run)
    return f"{summary['kind']}, M {summary['M']:.4g}, L {summary['L']:.3g}" if summary else ""


def address_of(page: str, **values: str) -> str:
    """The address of a page of the app."""
    return f"{page}?{urlencode(values, quote_via=quote)}"


# -- the frame --------------------------------------------------------------------------------------------------------


def frame(site: Site, pages: dict[str, Callable[..., Any]]) -> None:
    """The page: a bar above, the list of runs at the left, and one of the pages."""
    ui.colors(primary="#0b5673", secondary="#3f7d94", accent="#d55e00", positive="#1b7f5c", negative="#b3261e")
    ui.add_css(Path(__file__).with_name("style.css"))
    # it opens by itself where there is room and says so; value=None would ask a page that may have been closed
    drawer = ui.left_drawer(value=False, bordered=False).props("width=284 breakpoint=1000 show-if-above")
    with drawer.classes("runs"):
        _list(site)
    mode = ui.dark_mode(LOOKS.get(ui.context.client.request.cookies.get(LOOK, "")))

    def look(text: str) -> None:
        mode.set_value(LOOKS[text])
        ui.run_javascript(f"document.cookie = '{LOOK}={text}; path=/; max-age=31536000; samesite=strict'")

    with ui.header(elevated=False).classes("bar"):
        ui.button(icon="menu", on_click=drawer.toggle).props("flat round dense aria-label='Show or hide the runs'")
        with ui.link(target="/").classes("brand"):
            ui.html(LOGO, sanitize=False)
            ui.label("ertel")
        root, home = in_unicode(str(site.folder.root)), f"{Path.home()}/"
        ui.label(f"~/{root.removeprefix(home)}" if root.startswith(home) else root).classes("where").tooltip(
            f"The folder of this app: {root}"
        )
        ui.space()
        ui.button("New case", icon="add", on_click=lambda: ui.navigate.to("/new")).props("unelevated").mark("new")
        ui.button("Compare", icon="vertical_split", on_click=lambda: ui.navigate.to("/compare")).props("flat")
        with ui.button(icon="contrast").props("flat round dense aria-label='Light or dark'").mark("looks"), ui.menu():
            for text in LOOKS:
                ui.menu_item(text, partial(look, text)).mark(text)
        close = ui.button(icon="power_settings_new", on_click=lambda: _closing(site)).tooltip("Close the app")
        close.props("flat round dense aria-label='Close the app'").mark("close")
    ui.sub_pages(pages, data={"site": site}).classes("page")


def _list(site: Site) -> None:
    """The list of runs, which is renewed when something changes: one element, as there may be hundreds of rows."""
    root = ui.context.client.request.scope.get("root_path", "")

    def look() -> None:
        if (rows := site.rows(root)) != listed.content:
            listed.set_content(rows)

    ui.label("Runs").classes("eyebrow")
    listed = ui.html(site.rows(root), sanitize=False).classes("entries").mark("runs")
    listed.on("click", lambda event: site.ask_about(str(event.args)), js_handler=DELETE)
    ui.timer(SECONDS, look)


def _row(entry: Entry, root: str) -> str:
    """A run or a study in the list, in HTML.  root: of the addresses of pages.

    The key in data-run is the path in digits.  Two names that are not UTF-8 may be the same on pages.
    """
    phase, about = entry.status.phase, entry.about
    is_part = phase in (Phase.RUNNING, Phase.INTERRUPTED) and entry.status.done
    share = f"{phase.word} {entry.status.done:.0%}" if is_part else phase.word
    address, hint, name = (escape(text) for text in (root + entry.address, entry.name, in_unicode(entry.path.name)))
    text = f'<div class="name">{name}</div><div class="more">{escape(f"{share} · {about}" if about else share)}</div>'
    link = f'<a class="run {phase.name.lower()}" href="{address}" title="{hint}">{_icon(phase.icon, "state")}'
    delete = ""
    if entry.path.exists() and not phase.is_active:
        key = os.fsencode(entry.path).hex()
        delete = f'<button type="button" data-run="{key}" aria-label="Delete">{_icon("delete_outline")}</button>'
    return f'<div class="entry">{link}<div class="text">{text}</div></a>{delete}</div>'


def _icon(name: str, kind: str = "") -> str:
    return f'<i class="q-icon notranslate material-icons {kind}" aria-hidden="true">{name}</i>'


def _closing(site: Site) -> None:
    """Ask what becomes of the runs, and close the app."""
    going = site.processes.ours()

    def close(stop: bool) -> None:
        for run in going if stop else []:
            site.processes.stop(run)
        dialog.clear()
        with dialog, ui.card().classes("dialog"):
            ui.label("The app is closed. You can close this page.")
        app.shutdown()

    text = "No run that was started here goes on."
    if going:
        names = ", ".join(site.folder.name_of(run) for run in going)
        text = f"Still running: {names}. Runs go on without the app; open it again to watch them."
    with question("Close the app?", text) as dialog:
        if going:
            ui.button("Stop the runs and close", on_click=lambda: close(True)).props("outline")
        ui.button("Close", on_click=lambda: close(False)).props("unelevated")


@contextmanager
def question(title: str, text: str) -> Iterator[ui.dialog]:
    """Open a dialog with a question; its block makes the answers beside "Cancel"."""
    with ui.dialog(value=True) as dialog, ui.card().classes("dialog"):
        ui.label(title).classes("title")
        ui.label(text)
        with ui.row().classes("actions"):
            ui.button("Cancel", on_click=dialog.close).props("flat")
            yield dialog


# -- a run or a study that is watched ---------------------------------------------------------------------------------


class WatchedPage:
    """The parts that the pages of a run and of a study share: its phase, what can be done in it, and its progress.

    words: of the button that starts or resumes it, in some phases; there is none where it is empty.
    """

    def __init__(self, site: Site, path: Path, words: Mapping[Phase, str]):
        self.site, self.path, self.name, self._words = site, path, site.folder.name_of(path), words
        self.status = site.processes.status(path)

    def show_head(self, under: str) -> ui.label:
        """Show its name, what is told below it, its phase and what else can be done."""
        with ui.row().classes("head"):
            with ui.element("div"):
                ui.label(in_unicode(self.path.name)).classes("title")
                line = ui.label(under).classes("under")
            ui.space()
            self.show_phase()
            self.show_more()
        return line

    def show_more(self) -> None:
        """Show the menu of what else can be done."""
        compare = address_of("/measured", run=self.name)
        with ui.button(icon="more_vert").props("flat round aria-label='More'"), ui.menu():
            self.show_items()
            ui.menu_item("Compare with a measurement", lambda: ui.navigate.to(compare))
            ui.menu_item("Delete", lambda: self.site.ask_to_delete(self.path)).mark("delete")

    def show_items(self) -> None:
        """Show the entries of the menu that only this page has."""

    def renew(self) -> bool:
        """Show what has changed; whether anything has."""
        before, self.status = self.status, self.site.processes.status(self.path)
        if self.status.phase is not before.phase:
            self.show_phase.refresh()
        if self.status != before:
            self.show_progress.refresh()
        return self.status != before

    def start(self) -> None:
        """Start or resume it."""
        self.site.processes.resume(self.path)

    def _order(self, order: Callable[[], None]) -> None:
        with told():
            order()
        self.renew()

    @ui.refreshable_method
    def show_phase(self) -> None:
        """The phase, and what can be done in it."""
        phase = self.status.phase
        with ui.element("div").classes(f"chip {phase.name.lower()}"):
            ui.icon(phase.icon)
            ui.label(phase.word).mark("phase")
        if phase.is_active:
            word, order = "Stop now" if phase is Phase.STOPPING else "Stop", self.site.processes.stop
            stop = ui.button(word, icon="stop", on_click=lambda: self._order(partial(order, self.path)))
            stop.props("outline color=accent").mark("stop")
        elif word := self._words.get(phase, "Resume"):
            start = ui.button(word, icon="play_arrow", on_click=lambda: self._order(self.start))
            start.props("unelevated").mark("start")

    @ui.refreshable_method
    def show_progress(self) -> None:
        """The progress, until it is finished."""
        status = self.status
        if status.phase not in (Phase.NEW, Phase.FINISHED):
            with ui.element("div").classes("card progress"):
                bar = ui.linear_progress(value=status.done, show_value=False).props("size=6px rounded")
                if status.phase is Phase.COMPILING or (status.phase.is_active and not status.done):
                    bar.props("indeterminate")
                ui.label(status.text).classes("news")


# -- numbers and sentences --------------------------------------------------------------------------------------------


def show_number(number: Number) -> None:
    """A key number as a card."""
    more = [pretty(number.text)] if number.text_in_si else []
    more += [f"± {number.text_of_error}"] if number.text_of_error else []
    with ui.element("div").classes("number"):
        ui.label(number.about.long_name).classes("what")
        with ui.row().classes("known"):
            ui.label(number.text_in_si or pretty(number.text)).classes("value")
            ui.html(_symbol(number.about.symbol), sanitize=False).classes("symbol")
        ui.label("  ".join(more)).classes("also")


def show_line(label: str, value: str) -> None:
    """A name and its value on a line."""
    with ui.row().classes("line"):
        ui.label(label)
        ui.space()
        ui.label(pretty(value)).classes("value")


def show_notes(warnings: Sequence[str]) -> None:
    """Warnings of ertel."""
    for warning in warnings:
        with ui.row().classes("note"):
            ui.icon("info")
            ui.label(sentence(warning))


@contextmanager
def told(what: str = "") -> Iterator[None]:
    """Tell the user of an error in this block.  what: the beginning, where the system refuses something."""
    try:
        yield
    except OSError as error:
        ui.notify(f"{what}{reason_of(error)}")
    except ValueError as error:
        ui.notify(str(error))


def sentence(text: str) -> str:
    """A message of ertel as a sentence."""
    return f"{capital(text)}." if text else ""


def _symbol(name: str) -> str:
    """A symbol in HTML, H_c with its index below; nothing where a variable is named by a word."""
    base, _, index = name.partition("_")
    if len(base) > 2 and base != "Delta":
        return ""
    base = {"mu": "µ", "Delta": "Δ"}.get(base, base)
    return f"{escape(base)}<sub>{escape(index.replace('_', ' '))}</sub>"


def pretty(text: str) -> str:
    """Units with their powers raised."""
    return text.replace("^2", "²").replace("t0", "t₀")
