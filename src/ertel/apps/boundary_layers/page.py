"""Figures with captions, tables and data on one HTML page that opens without a network."""

import base64
import io
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from jinja2 import Environment, PackageLoader
from markupsafe import Markup
from matplotlib import rc_context
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


@dataclass(frozen=True)
class Part:
    """A figure on the page.  picture: address of the image; files: name -> address; failure: why there is no figure.

    Pictures and files are embedded: their addresses are data URLs.
    """

    heading: str
    picture: str = ""
    caption: str = ""
    tables: Mapping[str, Markup] = field(default_factory=dict)
    files: Mapping[str, str] = field(default_factory=dict)
    failure: str = ""


def save(drawn: Drawn, name: str, heading: str, directory: Path) -> Part:
    """Write NAME.svg, NAME.png and the data as NAME_PART.csv; the figure as a part of the page."""
    directory.mkdir(parents=True, exist_ok=True)
    image = io.BytesIO()
    with rc_context({"svg.hashsalt": name}):  # the same figure gives the same file
        drawn.figure.savefig(image, format="svg", metadata={"Date": None})
    (directory / f"{name}.svg").write_bytes(image.getvalue())
    drawn.figure.savefig(directory / f"{name}.png", dpi=150)
    files = {f"{name}_{part}.csv": to_csv(table).encode() for part, table in drawn.data.items()}
    for file, content in files.items():
        (directory / file).write_bytes(content)
    return Part(
        heading,
        _embedded("image/svg+xml", image.getvalue()),
        drawn.caption,
        {title: to_html(table) for title, table in drawn.tables.items()},
        {file: _embedded("text/csv", content) for file, content in files.items()},
    )


def side_by_side(columns: Mapping[str, ArrayLike]) -> DataFrame:
    """A table of columns that may differ in length."""
    return DataFrame({name: Series(values) for name, values in columns.items()})


def to_csv(table: DataFrame) -> str:
    """A table as CSV with nine digits; an empty cell is an unknown value."""
    return str(table.to_csv(index=False, float_format="%.9g", lineterminator="\n"))


def to_html(table: DataFrame) -> Markup:
    """A table as HTML, its texts escaped and not cut off."""
    with option_context("display.max_colwidth", None):
        return Markup(table.to_html(index=False, border=0, justify="unset"))


def page(title: str, remarks: Sequence[str], parts: Sequence[Part]) -> str:
    """The HTML page."""
    loader = PackageLoader("ertel.apps.boundary_layers")
    environment = Environment(loader=loader, autoescape=True, trim_blocks=True)
    return environment.get_template("page.html").render(title=title, remarks=remarks, parts=parts)


def _embedded(kind: str, content: bytes) -> str:
    return f"data:{kind};base64,{base64.b64encode(content).decode()}"
