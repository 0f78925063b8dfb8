"""Pieces of what a notebook shows."""

from base64 import b64encode
from collections.abc import Sequence
from html import escape
from io import BytesIO
from typing import TYPE_CHECKING

if TYPE_CHECKING:  # matplotlib is imported when there is something to draw
    from matplotlib.figure import Figure

DOTS_PER_INCH = 80  # of a picture in a notebook


def row(tag: str, cells: Sequence[str]) -> str:
    """A row of a table.  tag: "td", or "th" for a heading."""
    return f"<tr>{''.join(f'<{tag}>{escape(cell)}</{tag}>' for cell in cells)}</tr>"


def image(figure: "Figure", name: str) -> str:
    """A figure as an image that the page contains."""
    png = BytesIO()
    figure.savefig(png, format="png", dpi=DOTS_PER_INCH)
    return f'<img alt="{escape(name)}" src="data:image/png;base64,{b64encode(png.getvalue()).decode()}">'
