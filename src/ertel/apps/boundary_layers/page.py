"""Figures with captions, tables and data on one HTML page that opens without a network."""

import base64
import io
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from html import escape
from importlib.resources import files
from pathlib import Path
from string import Template

from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import ArrayLike
from pandas import DataFrame, Series, option_context

PAGE = files("ertel.apps.boundary_layers") / "page.html"
SECTION = Template("""<section>
<h2>$heading</h2>
$content
</section>""")
FIGURE = Template("""<figure>
<img alt="$heading" src="$picture"/>
<figcaption>$caption</figcaption>
</figure>
$tables
$data""")


@dataclass(frozen=True)
class Drawn:
    """A figure with what belongs to it.

    data: the numbers behind the figure, written as CSV; file name without its beginning and end -> table.  tables:
    numbers to read on the page; heading -> table, whose cells are texts.
    """

    figure: Figure
    caption: str
    data: Mapping[str, DataFrame] = field(default_factory=dict)
    tables: Mapping[str, DataFrame] = field(default_factory=dict)


def new_figure(rows: int, columns: int) -> tuple[Figure, list[Axes]]:
    """A figure with panels, row by row."""
    figure = Figure(figsize=(max(4.8 * columns, 7.0), 3.8 * rows), layout="constrained")
    return figure, list(figure.subplots(rows, columns, squeeze=False).ravel())


def save(drawn: Drawn, name: str, heading: str, directory: Path) -> str:
    """Write NAME.svg, NAME.png and the data as NAME_PART.csv; the figure as a section of the page.

    Picture and data are embedded in the section.
    """
    directory.mkdir(parents=True, exist_ok=True)
    image = io.BytesIO()
    with rc_context({"svg.hashsalt": name}):  # the same figure gives the same file
        drawn.figure.savefig(image, format="svg", metadata={"Date": None})
    (directory / f"{name}.svg").write_bytes(image.getvalue())
    drawn.figure.savefig(directory / f"{name}.png", dpi=150)
    links = []
    for part, table in drawn.data.items():
        file, content = f"{name}_{part}.csv", to_csv(table).encode()
        (directory / file).write_bytes(content)
        links.append(f'<a download="{escape(file)}" href="{_embedded("text/csv", content)}">{escape(file)}</a>')
    figure = FIGURE.substitute(
        heading=escape(heading),
        picture=_embedded("image/svg+xml", image.getvalue()),
        caption=escape(drawn.caption),
        tables="\n".join(f"<h3>{escape(title)}</h3>\n{to_html(table)}" for title, table in drawn.tables.items()),
        data=f"<p>Data:\n{', '.join(links)}\n</p>" if links else "",
    )
    return section(heading, figure)


def section(heading: str, content: str) -> str:
    """A section of the page.  content: HTML."""
    return SECTION.substitute(heading=escape(heading), content=content)


def failed(heading: str, reason: str) -> str:
    """The section of a figure that could not be made."""
    return section(heading, f'<p class="failed">Not made: {escape(reason)}</p>')


def side_by_side(columns: Mapping[str, ArrayLike]) -> DataFrame:
    """A table of columns that may differ in length."""
    return DataFrame({name: Series(values) for name, values in columns.items()})


def to_csv(table: DataFrame) -> str:
    """A table as CSV with nine digits; an empty cell is an unknown value."""
    return str(table.to_csv(index=False, float_format="%.9g", lineterminator="\n"))


def to_html(table: DataFrame) -> str:
    """A table as HTML, its texts escaped and not cut off."""
    with option_context("display.max_colwidth", None):
        return str(table.to_html(index=False, border=0, justify="unset"))


def page(title: str, remarks: Sequence[str], sections: Sequence[str]) -> str:
    """The HTML page.  sections: HTML."""
    paragraphs = "\n".join(f"<p>{escape(remark)}</p>" for remark in remarks)
    template = Template(PAGE.read_text(encoding="utf-8"))
    return template.substitute(title=escape(title), remarks=paragraphs, sections="\n".join(sections))


def _embedded(kind: str, content: bytes) -> str:
    return f"data:{kind};base64,{base64.b64encode(content).decode()}"
