"""Figures with captions, numbers and data on one HTML page that opens without a network."""

import base64
import csv
import io
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from html import escape
from itertools import zip_longest
from pathlib import Path
from typing import NamedTuple

from matplotlib import rc_context
from matplotlib.figure import Figure

from ertel.results.fronts import Values

STYLE = """
body { font: 16px/1.5 system-ui, sans-serif; max-width: 62rem; margin: 2rem auto; padding: 0 1rem; color: #222; }
figure { margin: 2.5rem 0; }
img { width: 100%; height: auto; }
table { border-collapse: collapse; font-size: 0.85rem; margin: 0.5rem 0; }
th, td { padding: 0.15rem 0.7rem; text-align: right; border-bottom: 1px solid #ddd; }
th:first-child, td:first-child { text-align: left; }
.failed { color: #a00; }
"""


class Table(NamedTuple):
    """Numbers to read."""

    head: list[str]
    rows: list[list[str]]


@dataclass(frozen=True)
class Drawn:
    """A figure, what it says, the data behind it (name of a file: its columns, (n,) each) and numbers to read."""

    figure: Figure
    caption: str
    data: Mapping[str, Mapping[str, Values]] = field(default_factory=dict)
    tables: Sequence[Table] = ()


def save(drawn: Drawn, name: str, directory: Path) -> str:
    """Write NAME.svg, NAME.png and the data as CSV; the figure as a piece of HTML."""
    directory.mkdir(parents=True, exist_ok=True)
    image = io.BytesIO()
    with rc_context({"svg.hashsalt": name}):  # the same figure gives the same file
        drawn.figure.savefig(image, format="svg", metadata={"Date": None})
    (directory / f"{name}.svg").write_bytes(image.getvalue())
    drawn.figure.savefig(directory / f"{name}.png", dpi=150)
    links = []
    for part, columns in drawn.data.items():
        file, text = f"{name}_{part}.csv", to_csv(columns)
        (directory / file).write_text(text, encoding="utf-8", newline="")
        links.append(f'<a download="{escape(file)}" href="{_embedded("text/csv", text.encode())}">{escape(file)}</a>')
    picture = f'<img alt="{escape(name)}" src="{_embedded("image/svg+xml", image.getvalue())}">'
    tables = "\n".join(_table(table) for table in drawn.tables)
    data = f"<p>Data: {', '.join(links)}</p>" if links else ""
    return f"{picture}\n<figcaption>{escape(drawn.caption)}</figcaption>\n{tables}\n{data}"


def to_csv(columns: Mapping[str, Values]) -> str:
    """Columns of any length side by side."""
    text = io.StringIO()
    writer = csv.writer(text)
    writer.writerow(columns)
    for row in zip_longest(*columns.values(), fillvalue=""):
        writer.writerow([value if value == "" else f"{value:.9g}" for value in row])
    return text.getvalue()


def page(title: str, remarks: Sequence[str], figures: Mapping[str, str]) -> str:
    """A page of figures: heading -> HTML."""
    parts = [f"<figure><h2>{escape(heading)}</h2>\n{body}\n</figure>" for heading, body in figures.items()]
    said = "\n".join(f"<p>{escape(remark)}</p>" for remark in remarks)
    head = f'<meta charset="utf-8"><title>{escape(title)}</title><style>{STYLE}</style>'
    body = "\n".join([f"<h1>{escape(title)}</h1>", said, *parts])
    return f'<!doctype html>\n<html lang="en"><head>{head}</head>\n<body>\n{body}\n</body></html>\n'


def failed(reason: str) -> str:
    """Instead of a figure."""
    return f'<p class="failed">Not made: {escape(reason)}</p>'


def _table(table: Table) -> str:
    head = "".join(f"<th>{escape(cell)}</th>" for cell in table.head)
    rows = "\n".join(f"<tr>{''.join(f'<td>{escape(cell)}</td>' for cell in row)}</tr>" for row in table.rows)
    return f"<table><thead><tr>{head}</tr></thead>\n<tbody>{rows}</tbody></table>"


def _embedded(kind: str, content: bytes) -> str:
    return f"data:{kind};base64,{base64.b64encode(content).decode()}"
