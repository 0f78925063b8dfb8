"""The first page, and that of a new case: a form or the text of a case file, beside it the answer of ertel to it."""

import asyncio
from collections.abc import Sequence
from itertools import groupby
from pathlib import Path
from typing import Any, get_args

import tomli_w
from nicegui import ui

from ertel.apps.browser import form
from ertel.apps.browser.folder import OF_COLUMNS, command_in
from ertel.apps.browser.form import FOLDED, FURTHER, Form, decides
from ertel.apps.browser.site import Site, address_of, show_line, show_notes, told
from ertel.apps.tables import needs
from ertel.case.conditions import Kind
from ertel.case.reading import decoded
from ertel.case.rules import plain_name
from ertel.inputs.case_files import parse_toml, read_text
from ertel.inputs.templates import about, template
from ertel.results.variables import with_prefix
from ertel.runs.directory import CASE, RUNS

LARGEST_UPLOAD = 200_000  # bytes, each a character of a message, which has at most 1 MB
UPLOAD = f"""({{target}}) => {{
    const [f] = target.files, text = b => Array.from(new Uint8Array(b), c => String.fromCharCode(c)).join('');
    f.size > {LARGEST_UPLOAD} ? emit(f.name, null) : f.arrayBuffer().then(b => emit(f.name, text(b)));
}}"""
EXAMPLES = {f"{line}{kind}": (kind, bool(line)) for line in ("", "line-") for kind in get_args(Kind)}  # new case files
PAUSE = 0.5  # seconds after the last change before ertel is asked
SHOWN_SCALES = {  # of `parameter_summary`: key, label, unit
    "a_m": ("half width a of the Hertz contact", "m"),
    "p_h_Pa": ("Hertz pressure", "Pa"),
    "delta_m": ("Hertz approach", "m"),
    "F_N": ("load", "N"),
    "contact_time_s": ("dry contact time", "s"),
    "trapped_film_m": ("film at which a rigid body stops", "m"),
    "h_c_least_m": ("central film, at least about", "m"),
    "h_c_most_m": ("central film, at most about", "m"),
}


# -- the first page ---------------------------------------------------------------------------------------------------


def home_page(site: Site) -> None:
    """The first page: a choice of what can be done here; runs and studies are in the list beside it."""
    with ui.element("div").classes("welcome"):
        ui.label("Impact and rolling of lubricated point and line contacts").classes("title")
        text = "Describe a contact, run it, and watch film and pressure form. Runs go on when the app is closed."
        ui.label(text).classes("lead")
        with ui.element("div").classes("offers"):
            _offer("add_circle", "New case", "A form, or a case file", "/new")
            with _offer("upload_file", "Add a file", "A case, a study, a fit, or what was measured"):
                endings = ",".join((".toml", *OF_COLUMNS))
                chosen = ui.element("input").props(f"type=file accept={endings}").mark("upload")
                chosen.on("change", lambda event: take(site, *event.args), js_handler=UPLOAD)
            for file in site.folder.case_files()[:4]:
                _offer("description", file.stem, "Case file in this folder", address_of("/new", case=file.name))
        ui.label("Start from an example").classes("eyebrow")
        with ui.element("div").classes("offers"):
            for name, (kind, is_line) in EXAMPLES.items():
                _offer("science", about(kind, is_line), "An example", address_of("/new", example=name))


def _offer(icon: str, title: str, text: str, target: str = "") -> ui.element:
    with (ui.link(target=target) if target else ui.element("label")).classes("card offer") as card:
        ui.icon(icon)
        ui.label(title).classes("name")
        ui.label(text).classes("more")
    return card


def take(site: Site, name: str, content: str | None) -> None:
    """Put a file that the user chose into the folder, where nothing is overwritten, and go to its page.

    content: a character for each byte.  Neither is trusted: the name becomes a plain one, and what is too long, is not
    a text, or has no ending that is known, is refused.
    """
    with told():
        ending = Path(name).suffix.lower()
        if ending not in (".toml", *OF_COLUMNS):
            raise ValueError(f"{name}: must be a case, a study or a fit, .toml, or columns, {', '.join(OF_COLUMNS)}")
        if not isinstance(content, str) or len(content) > LARGEST_UPLOAD:
            raise ValueError(f"{name}: must be a text of at most {LARGEST_UPLOAD // 1000} kB; copy it into the folder")
        try:
            text = decoded(data := content.encode("latin-1"))
        except ValueError as error:
            raise ValueError(f"{name}: {error}") from error
        plain = plain_name(name[: -len(ending)])
        if ending != ".toml":
            file, _ = site.folder.write(plain or "measured", data, ending=ending)
            ui.navigate.to(address_of("/measured", file=file.name))
            return
        command, name = command_in(parse_toml(text, name)), plain or "case"
        file, study = site.folder.write(name, text.encode(), f"{command}s" if command else RUNS)
        study_name = site.folder.name_of(study)
        ui.navigate.to(address_of("/study", name=study_name) if command else address_of("/new", case=file.name))


# -- a new case --------------------------------------------------------------------------------------------------------


class NewCase:
    """The page: form and text, of which the tab that is open tells which counts.

    case: a case file in the folder to begin from.  example: one of `EXAMPLES`, the same.
    """

    def __init__(self, site: Site, case: str = "", example: str = ""):
        self.site, self.form, self._client = site, Form(), ui.context.client
        self._inputs: dict[str, Any] = {}
        self._folds: dict[str, Any] = {}
        self._asked: asyncio.Task[None] | None = None
        self._data: dict[str, Any] = {}
        with ui.row().classes("head"):
            ui.label("New case").classes("title")
        with ui.element("div").classes("new-case"):
            with ui.element("div").classes("left"):
                self._tabs = ui.tabs().props("no-caps dense align=left")
                with self._tabs:
                    ui.tab("form", "Form")
                    ui.tab("text", "Case file").mark("tab-text")
                self._fields = ui.element("div").classes("fields")
                self._text = ui.textarea(on_change=self._changed).props("outlined autogrow spellcheck=false")
                self._text.classes("code").mark("text")
            with ui.element("div").classes("right"):
                self._answer = ui.element("div").classes("card answer")
                with ui.element("div").classes("card launch"):
                    self._name = ui.input("Name of the run").props("outlined dense stack-label").mark("name")
                    self._run = ui.button("Run", icon="play_arrow", on_click=self._start)
                    self._run.props("unelevated").mark("run")
        self._fields.bind_visibility_from(self._tabs, "value", value="form")
        self._text.bind_visibility_from(self._tabs, "value", value="text")
        self._build()
        self._tabs.on_value_change(self._turned)
        with told():
            self._begin_from(case, example)
        self._is_ahead = not self._text.value  # whether the form has changed since the text was made or read
        self._tabs.set_value("form")

    def _begin_from(self, case: str, example: str) -> None:
        if example in EXAMPLES:
            kind, is_line = EXAMPLES[example]
            self._name.set_value(example)
            self._text.set_value(template(kind, f"{example}.toml", is_line))
        elif case:
            path = self.site.folder.inside(case)
            text = read_text(path, path.name)
            data = parse_toml(text, path.name)
            here = form.relocated(data, path.parent, self.site.folder.root)
            self._text.set_value(text if here == data else tomli_w.dumps(here))
            self._name.set_value(path.parent.name if path.name == CASE else path.stem)

    # -- the form -----------------------------------------------------------------------------------------------------

    def _build(self) -> None:
        """The fields that belong to what is chosen."""
        shown = self.form.shown()
        self._inputs = {}
        self._fields.clear()
        with self._fields:
            with ui.element("div").classes("card choices"):
                for name in ("contact.kind", "given"):
                    toggle = ui.toggle(dict(self.form.options(name)), value=self.form.values[name]).mark(name)
                    self._watch(name, toggle.props("no-caps unelevated spread"))
            for title, names in groupby([name for name in shown if shown[name].group], lambda name: shown[name].group):
                self._group(title, list(names))

    def _group(self, title: str, names: Sequence[str]) -> None:
        """A card with fields; some are folded while nothing is given in them."""
        with ui.element("div").classes("card group"):
            if title in (*FOLDED, FURTHER):
                is_used = title != FURTHER and any(self.form.values[name] for name in names)
                place: Any = ui.expansion(title, value=is_used).props("dense").classes("fold").mark(f"fold-{title}")
                self._folds[title] = place
            else:
                ui.label(title).classes("eyebrow")
                place = ui.element("div")
            with place, ui.element("div").classes("grid"):
                for name in names:
                    self._inputs[name] = self._field(name)

    def _field(self, name: str) -> Any:
        about, value, options = self.form.shown()[name], self.form.values[name], dict(self.form.options(name))
        if options:
            field: Any = ui.select(options, label=about.label, value=value).props("options-dense")
        else:
            field = ui.input(about.label, value=value, placeholder=self.form.hint(name)).props("stack-label")
        if about.help:
            with field:
                ui.tooltip(about.help).props("max-width=320px delay=500 anchor='top middle' self='bottom middle'")
        return self._watch(name, field.props("outlined dense hide-bottom-space").mark(name))

    def _watch(self, name: str, field: Any) -> Any:
        return field.on_value_change(lambda event: self._set(name, event.value))

    def _set(self, name: str, value: Any) -> None:
        """Take over a value; the form is built again where other fields depend on it."""
        self.form.choose(name, value or "")
        self._is_ahead = True
        if decides(name):
            self._build()
        self._changed()

    # -- the answer ---------------------------------------------------------------------------------------------------

    def _turned(self) -> None:
        """The form or the text was opened: it takes over what the other one has; what has no fields stays a text."""
        with told():
            if self._tabs.value == "text" and self._is_ahead:
                self._text.set_value(tomli_w.dumps(self.form.data()))
                self._is_ahead = False
            elif self._tabs.value == "form" and not self._is_ahead:
                try:
                    self.form = Form.of(parse_toml(self._text.value, "the text"))
                    self._build()
                except ValueError:
                    self._tabs.set_value("text")
                    raise
        self._changed()

    def _changed(self) -> None:
        """Ask ertel again, a moment after the last change."""
        if self._asked:
            self._asked.cancel()
        self._run.disable()
        self._asked = asyncio.create_task(self._ask())

    async def _ask(self) -> None:
        await self._client.connected()
        await asyncio.sleep(PAUSE)
        if not self._client.has_socket_connection:  # the page was left
            return
        message = None
        try:
            data = parse_toml(self._text.value, "the text") if self._tabs.value == "text" else self.form.data()
            outlook = await self.site.worker.result_of(form.outlook_of, data, self.site.folder)
        except ValueError as error:
            message = str(error)
        if self._answer.is_deleted:
            return
        self._mark(message if self._tabs.value == "form" else None)
        self._answer.clear()
        with self._answer:
            if message:
                _verdict("Not a case yet", "error_outline", "wrong")
                ui.label(f"{message}.").classes("fault").mark("fault")
            else:
                _show_outlook(outlook)
                self._data = data
                self._name.props["placeholder"] = outlook["name"] or outlook["kind"]
                self._run.enable()

    def _mark(self, message: str | None) -> None:
        """Show a message at the field that it names, which may be folded, or take it away."""
        wrong = self.form.field_of(message) if message else None
        for name, field in self._inputs.items():
            field.error = (message or "").partition(": ")[2] if name == wrong else None
        if wrong and (fold := self._folds.get(self.form.shown()[wrong].group)):
            fold.set_value(True)

    def _start(self) -> None:
        """Write the case file, run it, and go to its page."""
        if self._asked:
            self._asked.cancel()
        name = plain_name((self._name.value or "").strip()) or self._name.props["placeholder"]
        with told(f"cannot write to {self.site.folder.root}: "):
            path = self.site.processes.start(name, tomli_w.dumps({**self._data, "name": name}))
            ui.navigate.to(address_of("/run", name=self.site.folder.name_of(path)))


# -- the answer of ertel -----------------------------------------------------------------------------------------------


def _show_outlook(outlook: dict[str, Any]) -> None:
    """The whole answer of `ertel check`."""
    _verdict("Ready to run", "check_circle", "right-one").mark("ready")
    parameters, scales = outlook["parameters"], outlook["parameters"].get("si", {})
    with ui.row().classes("moes"):
        for symbol in ("M", "L"):
            with ui.element("div"):
                ui.label(symbol).classes("symbol")
                ui.label(f"{parameters[symbol]:.4g}").classes("value").mark(f"value-{symbol}")
    for key, (label, unit) in SHOWN_SCALES.items():
        if key in scales:
            show_line(label, with_prefix(scales[key], unit))
    ui.separator()
    for name, value in needs(outlook).items():
        show_line(name, value)
    films = [film for film in outlook["films"] if film["central"] is not None and film["inside"]]
    if films:
        ui.label("Central film by the formulas").classes("eyebrow")
    for film in films:
        in_si = scales and with_prefix(film["central"] * scales["a_m"] ** 2 / scales["R_m"], "m")
        show_line(film["name"], in_si or f"{film['central']:.4g} a²/R")
    show_notes(outlook["warnings"])


def _verdict(text: str, icon: str, kind: str) -> ui.label:
    with ui.row().classes(f"verdict {kind}"):
        ui.icon(icon)
        return ui.label(text)
