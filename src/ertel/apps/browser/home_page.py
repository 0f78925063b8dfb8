"""The first page: what one can do here, and the latest runs."""

from nicegui import ui

from ertel.apps.browser.processes import Phase
from ertel.apps.browser.site import Site, address_of


def home_page(site: Site) -> None:
    """The first page."""
    with ui.element("div").classes("welcome"):
        ui.label("Impact and rolling of lubricated point contacts").classes("title")
        ui.label(
            "Describe a contact, run it, and watch film and pressure form. Each run is a process of its own and an "
            "ordinary directory in this folder: it goes on when this page or the app is closed, and ertel on the "
            "command line reads it too."
        ).classes("lead")
        with ui.element("div").classes("offers"):
            _offer("add_circle", "New case", "A form, or a case file", "/new")
            for file in site.folder.case_files()[:4]:
                _offer("description", file.stem, "Case file in this folder", address_of("/new", case=file.name))
            runs = [entry for entry in site.entries() if entry.standing.phase is not Phase.DAMAGED]
            for entry in runs[:4]:
                _offer(
                    "blur_circular",
                    entry.path.name,
                    entry.about or "Run in this folder",
                    address_of("/run", name=entry.name),
                )
            if len(runs) > 1:
                _offer("vertical_split", "Compare", "Two runs side by side", "/compare")


def _offer(icon: str, title: str, text: str, target: str) -> None:
    with ui.link(target=target).classes("card offer"):
        ui.icon(icon)
        ui.label(title).classes("name")
        ui.label(text).classes("more")
