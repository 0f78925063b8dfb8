"""`ertel report`: a run, a study or a fit on one page of A4, with its case, its picture, its numbers and its warnings.

The texts are those of the tables and of the notebook, and the picture is the overview of a run, or that of a study: the
page computes nothing, and a new number appears on it by its `Variable`.
"""

import json
from collections.abc import Collection, Iterator, Sequence
from io import BytesIO
from pathlib import Path
from textwrap import wrap
from typing import Any, NamedTuple

import numpy as np
from matplotlib.figure import Figure
from matplotlib.image import imread

from ertel import plots
from ertel.apps.terminal import capital
from ertel.case.case import Case
from ertel.case.records import show
from ertel.case.status import Status
from ertel.inputs.quantities import split
from ertel.physics import units
from ertel.plots.drawing import NoFigure, Picture, families
from ertel.results.numbers import aligned, differences, moment, more_lines, numbers, values_of
from ertel.results.variables import in_celsius, with_prefix
from ertel.runs.directory import is_run, read_case
from ertel.runs.files import StoreError
from ertel.runs.fit_result import KINDS, open_study
from ertel.runs.result import Result, verdict
from ertel.runs.store import RunStore

PAPER = (8.27, 11.69)  # inches, A4
MARGIN = 0.55
LETTER = 6.4  # pt, of the texts; each letter is 0.602 of it wide
LINE = 1.32 * LETTER / 72.0  # inches
COLUMNS = int((PAPER[0] - 2 * MARGIN) * 72.0 / (0.602 * LETTER))  # letters across the page
HALF = COLUMNS // 2 - 2
WIDEST = 60  # letters of a heading in its full size
MOST_LINES, MOST_NOTES, MOST_OF_CASE = 38, 24, 20
SI_UNITS = {mark.unit for mark in vars(units).values() if isinstance(mark, units.Unit)}  # other texts are names
LEFT_OUT = ("solver.", "time.", "output.", "schema", "contact.kind")  # of the case: how it is computed, and names


class Page(NamedTuple):
    """The parts of a page: texts, in one or two columns, a picture, and what is to be noted."""

    heading: str
    outcome: str
    columns: Sequence[Sequence[str]]
    picture: Figure | None
    notes: Sequence[str]
    source: str


def require_content(directory: Path) -> None:
    """Raise StoreError for a directory without a run or a study."""
    if not is_run(directory) and not any((directory / f"{name}.zarr").exists() for name in KINDS):
        raise StoreError(f"{directory} is not the directory of a run, a study or a fit")


def page_of(directory: Path) -> Page:
    """The page of the run or of the study in a directory.  Raises StoreError."""
    return _of_run(directory) if is_run(directory) else _of_study(directory)


def _of_run(directory: Path) -> Page:
    run = RunStore.open(directory)
    summary, case, data = run.summary() or run.summary_so_far(), run.case, run.dataset()
    status = Status(summary["status"])
    line = (
        verdict(Result(case, data, summary, status)) if status.ok else f"{status.value}; {status.advice}".rstrip("; ")
    )
    table = numbers(summary)
    chosen = [table.get(f"{name}_warm", table[name]) for name in values_of(summary) if name in table]
    chosen += [number for number in table.values() if number.about.of_impact]
    rows = [(each.about.long_name, each.text_in_si or each.text, each.text_of_error) for each in chosen]
    named = [[name, value, f"± {error}" if error else ""] for name, value, error in rows]
    computed = [moment(summary), *(aligned([*zip(*named, strict=True)], left=1) if named else [])]
    method = f"{case.contact.kind}, {case.method.in_words}: {status.value}"
    notes = [*more_lines(summary), *(f"warning: {each}" for each in summary["warnings"])]
    try:  # of a film below zero everything would be upside down
        gone = status is Status.FILM_VANISHED and case.is_steady
        picture = None if gone else plots.draw(data, "overview", columns=2, title=False)
    except NoFigure:
        picture = None
    versions, begun = json.loads(data.attrs["versions"]), data.attrs["date_created"]
    source = f"ertel {versions['ertel']}, jax {versions['jax']}; case {case.digest}, begun {begun}"
    heading = f"{case.name or case.kind}: M = {summary['M']:.4g}, L = {summary['L']:.4g}"
    lines = ["case", *_case_lines(case)]
    rest = ["", "case, continued", *lines[MOST_OF_CASE:]] if lines[MOST_OF_CASE:] else []
    columns = [lines[:MOST_OF_CASE], [*computed, "", method, *rest]]
    return Page(heading, capital(line), columns, picture, notes, source)


def _of_study(directory: Path) -> Page:
    result = open_study(directory)
    data = result.dataset
    try:
        picture = result.plot(title=False, **({"figsize": (6.7, 6.0)} if "best" in data.attrs else {"columns": 2}))
    except NoFigure:
        picture = None
    first = "" if "best" in data.attrs else str(data["directory"].values.flat[0]) if "directory" in data else ""
    is_inside = (directory / first).resolve().is_relative_to(directory.resolve())
    there = is_inside and is_run(directory / first)
    case = getattr(result, "case", None) or (read_case(directory / first) if there else None)
    varied = {str(axis.attrs.get("field", axis.name)) for axis in data.coords.values()}
    varied |= {f"contact.{name}" for name in varied if "." not in name}  # the axis of a traction curve
    rows = _cut([*aligned(result.table())], MOST_LINES)
    lines = [
        f"as in the first run, but for {', '.join(sorted(name for name in varied if '.' in name))}"
        if first
        else "with the values of the fit"
    ]
    lines += _case_lines(case, varied if first else ()) if case else []
    half = -(-len(lines) // 2)
    table = ["", *(_short(line, COLUMNS) for line in rows)]
    source = f"{data.attrs.get('source', '')}, {data.attrs.get('date_created', '')}".strip(", ")
    columns = [lines[:half] + table, lines[half:]] if case else [table]
    return Page(result.heading, "", columns, picture, result.remarks, source)


def _case_lines(case: Case, varied: Collection[str] = ()) -> list[str]:
    """The keys of a case and their values, with fitting prefixes."""
    written = [(each["field"], each["first"]) for each in differences(case.to_data(), {})]
    kept = [each for each in written if each[1] is not None and each[0] not in varied]
    rows = [(key, _value(value)) for key, value in kept if not key.startswith(LEFT_OUT)]
    return [_short(line, HALF - 2) for line in aligned([*zip(*rows, strict=True)], left=2)]


def _short(line: str, most: int) -> str:
    return line if len(line) <= most else f"{line[: most - 1]}…"


def _value(value: Any) -> str:
    number, unit = split(value)
    if unit not in SI_UNITS:
        return value if isinstance(value, str) else show(value)
    return with_prefix(*in_celsius(float(number), unit))


def drawn(page: Page) -> Figure:
    """The page as a figure."""
    figure = Picture(figsize=PAPER, dpi=200)
    top = PAPER[1] - MARGIN

    def write(lines: Sequence[str], height: float, left: float = MARGIN, **look: Any) -> float:
        options: dict[str, Any] = {"fontsize": LETTER, "linespacing": 1.3, "va": "top", **look}
        options["family"] = families(options.get("family", "monospace"))
        text = "\n".join(lines).replace("$", r"\$")
        figure.text(left / PAPER[0], height / PAPER[1], text, **options)
        return height - LINE * len(lines)

    size = 12.0 * min(1.0, WIDEST / len(page.heading))
    write([page.heading], top, family="sans-serif", fontsize=size, weight="bold")
    top -= 0.28
    if page.outcome:
        write([page.outcome], top, family="sans-serif", fontsize=9)
        top -= 0.25
    places = (MARGIN, MARGIN + (HALF + 2) * 0.602 * LETTER / 72.0)
    shown = [[*_cut(lines, MOST_LINES + 4)] for lines in page.columns]
    top = min([write(lines, top, left) for lines, left in zip(shown, places, strict=False) if lines] or [top]) - 0.1
    notes = [line for note in page.notes for line in wrap(capital(note), COLUMNS, subsequent_indent="  ")]
    notes = [*_cut(notes, MOST_NOTES)]
    bottom = MARGIN + LINE * (len(notes) + 1.5)
    write(notes, bottom)
    write([page.source], MARGIN, color="#555555")
    if page.picture is not None:
        _place(figure, page.picture, bottom + 0.1, top)
    return figure


def _cut(lines: Sequence[str], most: int) -> Iterator[str]:
    yield from lines if len(lines) <= most else [*lines[: most - 1], f"... and {len(lines) - most + 1} more lines"]


def _place(figure: Figure, picture: Figure, bottom: float, top: float) -> None:
    """Put a picture, as large as fits, between two heights in inches."""
    content = BytesIO()
    picture.savefig(content, format="png", dpi=300)
    content.seek(0)
    image = np.asarray(imread(content))
    scale = min((PAPER[0] - 2 * MARGIN) / image.shape[1], max(top - bottom, 1.0) / image.shape[0])
    width, height = scale * image.shape[1], scale * image.shape[0]
    place = ((PAPER[0] - width) / 2, top - height, width, height)
    axes = figure.add_axes(tuple(np.array(place) / np.tile(PAPER, 2)))
    axes.imshow(image, aspect="auto")
    axes.axis("off")
