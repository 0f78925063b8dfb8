"""The pages of a study and of a measurement.

A study has its file, its progress, and in the end the table and the picture of its runs, or of a fit.  A measurement
stands beside a run, or a curve beside a study.
"""

import re
from dataclasses import fields
from html import escape
from pathlib import Path
from typing import Any

from nicegui import ui

from ertel.apps.arguments import Measured
from ertel.apps.browser.canvas import Canvas
from ertel.apps.browser.form import require_inside
from ertel.apps.browser.pictures import STUDY, PlotRequest, stamp_of
from ertel.apps.browser.processes import Phase
from ertel.apps.browser.site import Site, WatchedPage, address_of, sentence, told
from ertel.inputs.case_files import read_text, read_toml
from ertel.runs.directory import is_run, kind_of

EXAMPLES = {  # in the fields of what is known of a measurement
    "at": "such as 60 us, or end", "align": "such as centre, tilt", "column": "such as x=um; h=nm",
    "wavelength": "such as 532 nm", "coatings": "such as chromium 8 nm", "index": "such as 1.48",
}  # fmt: skip
RUN = re.compile(r"<tr><td>(.*?)</td>(.*?)<td>(runs/[0-9a-f]{16})</td></tr>")  # a row of the table of a study


def study_report(study: Path, kind: str, stamp: int) -> tuple[str, str]:
    """The table and the remarks of a study in HTML; and the run with the values of a fit, or "".

    For the process that draws.  stamp: of the data, see `stamp_of`.  Raises ValueError where they cannot be read.
    """
    from ertel.runs.fit_result import open_study

    result = open_study(study)
    return result.html, str(result.dataset.attrs.get("best", ""))


class StudyPage(WatchedPage):
    """The page of a study, renewed each second."""

    def __init__(self, site: Site, name: str = ""):
        self._report, self._best, self._is_read = "", "", False
        self._root = ui.context.client.request.scope.get("root_path", "")
        try:
            path = site.folder.inside(name)
            if path not in site.folder.studies() and not site.processes.knows(path):
                raise ValueError(f"{name} is not a study, and there is no file with [unknowns] or [sweep] for it")
            self._file = site.folder.file_of(path)
            text = read_text(self._file, self._file.name) if self._file else ""
        except ValueError as error:
            ui.label(f"{error}.").classes("alert")  # begins with a name
            return
        words = {Phase.NEW: "Start", Phase.FINISHED: "Start again"}
        super().__init__(site, path, words if self._file else dict.fromkeys(Phase, ""))  # or its command starts it
        self._top = self.show_head(self.name)
        self.show_progress()
        self._show_outcome()
        self._picture = ui.element("div").classes("card pictures")
        with self._picture:
            self._canvas = Canvas(site.worker)
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
            self._picture.set_visibility(is_read)
            if is_read:
                self._canvas.show(PlotRequest(self.path, STUDY, stamp=stamp_of(self.path, f"{kind}.zarr"), dots=100))

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
        """The outcome as it is in notebooks, where texts are escaped, with links to its runs and to the best one."""
        if self._report and not self.status.phase.is_active:
            with ui.element("div").classes("card outcome"):
                ui.html(RUN.sub(self._row, self._report), sanitize=False).mark("outcome")
                if self._best and is_run(self.path / self._best):
                    run = address_of("/run", name=f"{self.name}/{self._best}")
                    ui.link("The run with these values", run).classes("more").mark("best")
                elif self._best:
                    ui.label("The run with these values was deleted.").classes("more")

    def _row(self, row: re.Match[str]) -> str:
        """A row with a link to its run, or with the word that this was deleted."""
        value, cells, run = row.groups()
        if not is_run(self.path / run):
            return f"<tr><td>{value}</td>{cells}<td>deleted</td></tr>"
        link = f'<a href="{escape(self._root + address_of("/run", name=f"{self.name}/{run}"))}">'
        return f"<tr><td>{link}{value}</a></td>{cells}<td>{link}{run[:13]}</a></td></tr>"


class MeasuredPage:
    """The page of a measurement beside a run or a study: what is known of it is asked for as `ertel compare` does."""

    def __init__(self, site: Site, file: str = "", run: str = ""):
        self.site, self._asked = site, ""
        files = [path.name for path in site.folder.measurements()]
        runs = [entry.name for entry in (*site.entries(), *site.studies())]
        if not (files and runs):
            what = "run to compare it with" if files else "file of columns (CSV) in this folder"
            ui.label(f"There is no {what} yet.").classes("alert")
            return
        if file and file not in files:
            ui.label(f"{file!r} is not a file of columns (CSV) in this folder.").classes("alert")
        with ui.row().classes("head"):
            ui.label("A measurement beside a run").classes("title")
        with ui.element("div").classes("card grid"):
            self._file = ui.select(files, label="File", value=file if file in files else files[0]).mark("file")
            runs += [run] if run and run not in runs else []  # a run of a study
            self._run = ui.select(runs, label="Run or study", value=run or runs[0]).mark("run")
            self._along = ui.select(["x", "y"], label="Along", value="x")
            self._given = {each.name: self._field(each) for each in fields(Measured)}
        for field in (self._file, self._run, self._along, *self._given.values()):
            field.props("outlined dense options-dense stack-label").on_value_change(self._show)
        with ui.element("div").classes("card pictures"):
            self._canvas = Canvas(site.worker)
        self._show()

    def _field(self, each: Any) -> ui.input:
        """The field of an option of the command, with its help."""
        about = each.type.__metadata__[0]
        field = ui.input(each.name.capitalize(), placeholder=EXAMPLES[each.name]).mark(f"given-{each.name}")
        with field:
            ui.tooltip(about.help).props("max-width=320px delay=500")
        return field.props("debounce=600")

    def _show(self) -> None:
        with told():
            folder = self.site.folder
            texts = {name: field.value.strip() for name, field in self._given.items() if field.value.strip()}
            columns = tuple(each.strip() for each in texts.pop("column", "").split(";") if each.strip())
            given: Any = {**texts, "column": columns, "index": _number("index", texts.get("index"))}
            file, run = folder.inside(self._file.value), folder.inside(self._run.value)
            measured = file, self._along.value, Measured(**given)
            stamp = stamp_of(run) or stamp_of(run, f"{kind_of(run)}.zarr")
            self._canvas.show(PlotRequest(run, "measured", stamp=stamp + file.stat().st_mtime_ns, measured=measured))


def _number(name: str, text: str | None) -> float | None:
    """The number in a field; None where it is empty.  Raises ValueError, with the name of the field."""
    try:
        return float(text) if text else None
    except ValueError as error:
        raise ValueError(f"{name} = {text!r}: must be a number") from error
