"""The page of a study: its file, its progress, and in the end the table and the picture of its runs, or of a fit."""

from html import escape
from pathlib import Path

from nicegui import ui

from ertel.apps.browser.folder import kind_of
from ertel.apps.browser.form import require_inside
from ertel.apps.browser.pictures import stamp_of
from ertel.apps.browser.processes import Phase
from ertel.apps.browser.site import Site, WatchedPage, address_of, sentence
from ertel.inputs.case_files import read_text, read_toml


def study_report(study: Path, kind: str, stamp: int) -> tuple[str, str]:
    """The table, the remarks and the picture of a study in HTML; and the run with the values of a fit, or "".

    For the process that draws.  stamp: of the data, see `stamp_of`.  Raises ValueError where they cannot be read.
    """
    from ertel.runs.fit_result import open_study

    result = open_study(study)
    try:
        return result._repr_html_(), str(result.dataset.attrs.get("best", ""))
    except Exception as error:  # of matplotlib
        raise ValueError(f"the outcome of this study cannot be shown ({error}); start it again") from error


class StudyPage(WatchedPage):
    """The page of a study, renewed each second."""

    def __init__(self, site: Site, name: str = ""):
        self._report, self._best, self._is_read = "", "", False
        try:
            path = site.folder.inside(name)
            if path not in site.folder.studies():
                raise ValueError(f"{name} is not a study, and there is no file with [unknowns] or [sweep] for it")
            self._file = site.folder.file_of(path)
            text = read_text(self._file, self._file.name) if self._file else ""
        except ValueError as error:
            ui.label(f"{error}.").classes("alert")  # begins with a name
            return
        words = {Phase.NEW: "Start", Phase.FINISHED: "Start again"}
        super().__init__(site, path, words if self._file else dict.fromkeys(Phase, ""))  # or its command starts it
        self._top = self.show_head(site.folder.name_of(path))
        self.show_progress()
        self._show_outcome()
        if text:
            with ui.expansion(f"{path.name}.toml", value=not path.exists()).classes("fold card"):
                ui.label(text).classes("listing").mark("listing")
        ui.timer(1.0, self._look)

    async def _look(self) -> None:
        """Show what has changed; the outcome is read when there is one and no process works on the study."""
        changed, kind = self.renew(), kind_of(self.path)
        if (is_read := bool(kind) and not self.status.phase.is_active) and not self._is_read:
            try:
                asked = study_report, self.path, kind, stamp_of(self.path, f"{kind}.zarr")
                self._report, self._best = await self.site.worker.result_of(*asked)
            except ValueError as error:
                self._report, self._best = escape(sentence(str(error))), ""
        if (changed or is_read is not self._is_read) and not self._top.is_deleted:  # the page was not left
            self._is_read = is_read
            self._show_outcome.refresh()

    def start(self) -> None:
        """Start the study, or go on with it, where all its files are in the folder."""
        folder = self.site.folder
        if self._file:
            data = read_toml(self._file)
            require_inside(data, folder, folder.root)
            if "case" in data:
                case = folder.inside(str(data["case"]))
                require_inside(read_toml(case), folder, case.parent)
        super().start()

    @ui.refreshable_method
    def _show_outcome(self) -> None:
        """The outcome as it is in notebooks, where texts are escaped, and the way to the best run."""
        if self._report and not self.status.phase.is_active:
            with ui.element("div").classes("card outcome"):
                ui.html(self._report, sanitize=False).mark("outcome")
                if self._best:
                    run = address_of("/run", name=f"{self.site.folder.name_of(self.path)}/{self._best}")
                    ui.link("The run with these values", run).classes("more").mark("best")
