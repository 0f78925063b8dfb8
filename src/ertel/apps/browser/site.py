"""What all pages share: the folder, its processes, the pictures; the frame around each page with the list of runs."""

import asyncio
from collections.abc import Callable
from dataclasses import dataclass, field
from importlib.resources import files
from pathlib import Path
from typing import Any
from urllib.parse import quote

from fastapi import Response
from nicegui import app, ui

from ertel.apps.browser.folder import Folder, in_unicode
from ertel.apps.browser.pictures import Artist
from ertel.apps.browser.processes import Phase, Processes, Standing
from ertel.apps.browser.records import summary_of
from ertel.apps.browser.wishes import Wish

PICTURES = "/pictures"
CHECKS = 2  # processes of `ertel check` at a time, of some 300 MB each
SECONDS = 2.0  # between two looks at the folder
TYPES = {"png": "image/png", "svg": "image/svg+xml", "pdf": "application/pdf"}
LOGO = (
    '<svg class="logo" viewBox="0 0 40 40" aria-hidden="true"><circle cx="20" cy="15" r="11"/>'
    '<path d="M3 31 H13 Q20 25.5 27 31 H37"/><path class="thin" d="M3 36 H37"/></svg>'
)
SAID = {
    Phase.COMPILING: ("compiling", "hourglass_top"),
    Phase.RUNNING: ("running", "play_circle"),
    Phase.STOPPING: ("stopping", "pause_circle"),
    Phase.FINISHED: ("finished", "check_circle"),
    Phase.INTERRUPTED: ("interrupted", "pause_circle"),
    Phase.FAILED: ("failed", "error"),
    Phase.DAMAGED: ("cannot be read", "broken_image"),
}


@dataclass(frozen=True)
class Entry:
    """A run in the list.  about: kind, M and L, if they are known."""

    name: str
    path: Path
    standing: Standing
    about: str = ""


@dataclass
class Site:
    """The app: one folder, for all pages."""

    folder: Folder
    processes: Processes
    artist: Artist
    checks: asyncio.Semaphore = field(default_factory=lambda: asyncio.Semaphore(CHECKS))
    _addresses: dict[str, Wish] = field(default_factory=dict)

    # -- pictures -----------------------------------------------------------------------------------------------------

    def serve(self) -> None:
        """Answer requests for pictures."""
        app.get(PICTURES + "/{key}")(self.picture)

    async def picture(self, key: str) -> Response:
        """A picture that a page was given the address of."""
        wish = self._addresses.get(key)
        if wish is None:
            return Response("no such picture", 404)
        try:
            content = await self.artist.draw(wish)
        except ValueError as error:
            return Response(str(error), 404)
        return Response(content, media_type=TYPES[wish.kind], headers={"Cache-Control": "max-age=600"})

    async def address(self, wish: Wish) -> str:
        """The address of a picture, which is drawn when this returns.  Raises ValueError where it cannot be."""
        await self.artist.draw(wish)
        key = format(hash(wish) & (2**64 - 1), "016x")
        self._addresses[key] = wish
        while len(self._addresses) > 500:
            del self._addresses[next(iter(self._addresses))]
        return f"{PICTURES}/{key}"

    # -- runs ---------------------------------------------------------------------------------------------------------

    def entries(self) -> list[Entry]:
        """The runs of the folder, those that go on first, then the latest."""
        paths = dict.fromkeys([*self.processes.ours(), *self.folder.runs()])
        found = [Entry(self.folder.name_of(path), path, self.processes.standing(path), _about(path)) for path in paths]
        return sorted(found, key=lambda entry: not entry.standing.phase.is_active)

    def find(self, name: str) -> Path:
        """The directory of a run, which may not be there yet if it was just started.  Raises ValueError."""
        path = self.folder.inside(name)
        return path if self.processes.knows(path) else self.folder.run(name)


def _about(run: Path) -> str:
    summary = summary_of(run)
    return f"{summary['kind']}, M {summary['M']:.4g}, L {summary['L']:.3g}" if summary else ""


def address_of(page: str, **values: str) -> str:
    """The address of a page of the app."""
    return page + ("?" + "&".join(f"{key}={quote(value, safe='')}" for key, value in values.items()) if values else "")


# -- the frame --------------------------------------------------------------------------------------------------------


def frame(site: Site, pages: dict[str, Callable[..., Any]]) -> None:
    """The page: a bar above, the list of runs at the left, and one of the pages."""
    ui.colors(primary="#0b5673", secondary="#3f7d94", accent="#d55e00", positive="#1b7f5c", negative="#b3261e")
    ui.add_css((files(__package__) / "style.css").read_text(encoding="utf-8"))
    with ui.left_drawer(value=None, bordered=False).props("width=284 breakpoint=1000").classes("runs") as drawer:
        _list(site)
    with ui.header(elevated=False).classes("bar"):
        ui.button(icon="menu", on_click=drawer.toggle).props("flat round dense aria-label='Show or hide the runs'")
        with ui.link(target="/").classes("brand"):
            ui.html(LOGO, sanitize=False)
            ui.label("ertel")
        where = in_unicode(str(site.folder.root))
        ui.label(_shortened(site.folder.root)).classes("where").tooltip(f"The folder of this app: {where}")
        ui.space()
        ui.button("New case", icon="add", on_click=lambda: ui.navigate.to("/new")).props("unelevated no-caps").mark(
            "new"
        )
        ui.button("Compare", icon="vertical_split", on_click=lambda: ui.navigate.to("/compare")).props("flat no-caps")
        ui.button(icon="power_settings_new", on_click=lambda: _closing(site)).props(
            "flat round dense aria-label='Close the app'"
        ).mark("close").tooltip("Close the app")
    ui.sub_pages(pages, data={"site": site}).classes("page")


def _shortened(path: Path) -> str:
    """A path with ~ for the home directory, its beginning left out where it is long."""
    text = f"~/{path.relative_to(Path.home())}" if path.is_relative_to(Path.home()) else str(path)
    text = in_unicode(text)
    return text if len(text) < 44 else f"…{text[-42:]}"


def _list(site: Site) -> None:
    """The list of runs, which is renewed when something changes."""
    known: list[Entry] = []

    @ui.refreshable
    def rows() -> None:
        ui.label("Runs").classes("eyebrow")
        if not known:
            ui.label("None yet in this folder. Start with a new case.").classes("hint")
        for entry in known:
            _row(entry)

    def look() -> None:
        found = site.entries()
        if found != known:
            known[:] = found
            rows.refresh()

    known[:] = site.entries()
    rows()
    ui.timer(SECONDS, look)


def _row(entry: Entry) -> None:
    word, icon = SAID[entry.standing.phase]
    phase = entry.standing.phase
    with ui.link(target=address_of("/run", name=entry.name)).classes(f"run {phase.value}"):
        ui.icon(icon).classes("state")
        with ui.element("div").classes("text"):
            ui.label(in_unicode(entry.path.name)).classes("name").tooltip(entry.name)
            share = f"{word} {entry.standing.done:.0%}" if phase in (Phase.RUNNING, Phase.INTERRUPTED) else word
            ui.label(f"{share} · {entry.about}" if entry.about else share).classes("more")


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

    with ui.dialog(value=True) as dialog, ui.card().classes("dialog"):
        ui.label("Close the app?").classes("title")
        if going:
            names = ", ".join(site.folder.name_of(run) for run in going)
            ui.label(f"Still running: {names}. Runs go on without the app; open it again to watch them.")
        else:
            ui.label("No run that was started here goes on.")
        with ui.row().classes("actions"):
            ui.button("Cancel", on_click=dialog.close).props("flat no-caps")
            if going:
                ui.button("Stop the runs and close", on_click=lambda: close(True)).props("outline no-caps")
            ui.button("Close", on_click=lambda: close(False)).props("unelevated no-caps")
