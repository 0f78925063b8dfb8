"""The page of a fit: its file, its progress, and in the end what `ertel fit` prints and draws."""

from base64 import b64encode
from pathlib import Path
from typing import Any, ClassVar

from nicegui import ui

from ertel.apps.browser.folder import Folder
from ertel.apps.browser.form import with_files
from ertel.apps.browser.processes import Phase
from ertel.apps.browser.site import Site, WatchedPage, address_of, sentence, show_notes
from ertel.inputs.case_files import read_text, read_toml
from ertel.runs.directory import read_case
from ertel.runs.files import content_of

DATA, PICTURE = "fit.zarr", "fit.png"
WARNING = "warning: "  # how a remark begins that is one


def fit_report(fit: Path) -> dict[str, Any]:
    """The outcome of a fit in the words of `ertel fit`: best, columns, remarks.  For the process that draws.

    best: the run with the values.  Raises ValueError where it cannot be read.
    """
    import xarray as xr

    from ertel.results.fit_result import FitResult

    try:
        data = xr.open_zarr(fit / DATA, chunks=None, consolidated=False).load()
        result = FitResult(dataset=data, directory=fit, case=read_case(fit / data.attrs["best"]))
        return {"best": str(data.attrs["best"]), "columns": result.table(), "remarks": result.remarks}
    except Exception as error:  # of zarr, its codecs, the system
        raise ValueError(f"the outcome of this fit cannot be read ({error}); start it again") from error


def require_inside(folder: Folder, file: Path) -> None:
    """Refuse a fit that names a case, a height map or a measurement outside of the folder.  Raises ValueError."""
    data: dict[str, Any] = read_toml(file)
    tables = data.get("measurements")
    for table in (data, *(tables if isinstance(tables, list) else ())):
        for key in ("case", "file"):
            if isinstance(table, dict) and isinstance(table.get(key), str):
                folder.inside(table[key])
    case = folder.inside(str(data.get("case")))
    for table, key in with_files(read_toml(case)):
        folder.inside(str(case.parent / table[key]))


class FitPage(WatchedPage):
    """The page of a fit, renewed each second."""

    words: ClassVar = {Phase.NEW: "Start", Phase.FINISHED: "Start again"}

    def __init__(self, site: Site, name: str = ""):
        self._report = dict[str, Any]()
        try:
            path, self.file = site.folder.fit(name)
            text = read_text(self.file, self.file.name)
        except ValueError as error:
            ui.label(f"{error}.").classes("alert")  # begins with a name
            return
        super().__init__(site, path)
        with ui.row().classes("head"):
            ui.label(self.path.name).classes("title")
            ui.space()
            self.show_phase()
        self.show_progress()
        self._show_outcome()
        is_new = self.status.phase is Phase.NEW
        with ui.element("div").classes("card"):
            self._fold = ui.expansion(self.file.name, value=is_new).classes("fold")
        with self._fold:
            ui.label(text).classes("listing").mark("listing")
        ui.timer(0.05, self._read, once=True)
        ui.timer(1.0, self._renew)

    async def _renew(self) -> None:
        was_active = self.status.phase.is_active
        if self.renew():
            self._show_outcome.refresh()
        if was_active and not self.status.phase.is_active:
            await self._read()

    async def _read(self) -> None:
        """Show the outcome, where there is one."""
        if not (self.path / DATA).exists():
            return
        try:
            self._report = await self.site.worker.result_of(fit_report, self.path)
        except ValueError as error:
            self._report = {"remarks": [f"{WARNING}{error}"]}
        if not self._fold.is_deleted:  # the page was not left
            self._show_outcome.refresh()

    def start(self) -> None:
        """Start the fit, or go on with it, where all its files are in the folder."""
        require_inside(self.site.folder, self.file)
        super().start()

    @ui.refreshable_method
    def _show_outcome(self) -> None:
        """The values with what follows from them."""
        remarks = self._report.get("remarks", ())
        if "columns" in self._report and not self.status.phase.is_active:
            with ui.element("div").classes("card outcome"):
                names, *rows = zip(*self._report["columns"], strict=True)
                ui.table(rows=[dict(zip(names, row, strict=True)) for row in rows]).props("flat dense").mark("values")
                for remark in remarks:
                    if not remark.startswith(WARNING):
                        ui.label(sentence(remark))
                if (self.path / PICTURE).exists():
                    picture = b64encode(content_of(self.path / PICTURE)).decode()
                    ui.element("img").props["src"] = f"data:image/png;base64,{picture}"
                run = f"{self.site.folder.name_of(self.path)}/{self._report['best']}"
                ui.link("The run with these values", address_of("/run", name=run)).classes("more").mark("best")
        show_notes([remark.removeprefix(WARNING) for remark in remarks if remark.startswith(WARNING)])
