"""A figure with its numbers: the picture, CSV files and its section of the page."""

import base64
import io
from collections.abc import Mapping
from dataclasses import dataclass, field
from html import escape
from pathlib import Path

from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import ArrayLike
from pandas import DataFrame, Series, option_context


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


def texts(rows: DataFrame, cells: Mapping[str, str]) -> DataFrame:
    """Numbers as texts.  cells: heading -> the format of a cell with the names of columns, "{limit:.3f}"."""
    return DataFrame(
        {heading: cell.format(**row) for heading, cell in cells.items()} for row in rows.to_dict("records")
    )


def side_by_side(columns: Mapping[str, ArrayLike]) -> DataFrame:
    """A table of columns that may differ in length."""
    return DataFrame({name: Series(values) for name, values in columns.items()})


def save(drawn: Drawn, name: str, heading: str, directory: Path) -> str:
    """Write NAME.svg, NAME.png and the data as NAME_PART.csv; the figure as HTML, picture and data embedded."""
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
    html = [
        f'<figure>\n<img alt="{escape(heading)}" src="{_embedded("image/svg+xml", image.getvalue())}"/>',
        f"<figcaption>{escape(drawn.caption)}</figcaption>\n</figure>",
        *(f"<h3>{escape(title)}</h3>\n{to_html(table)}" for title, table in drawn.tables.items()),
    ]
    return "\n".join([*html, f"<p>Data:\n{', '.join(links)}\n</p>"] if links else html)


def to_csv(table: DataFrame) -> str:
    """A table as CSV with nine digits; an empty cell is an unknown value."""
    return str(table.to_csv(index=False, float_format="%.9g", lineterminator="\n"))


def to_html(table: DataFrame) -> str:
    """A table as HTML, its texts escaped and not cut off."""
    with option_context("display.max_colwidth", None):
        return str(table.to_html(index=False, border=0, justify="unset"))


def _embedded(kind: str, content: bytes) -> str:
    return f"data:{kind};base64,{base64.b64encode(content).decode()}"
