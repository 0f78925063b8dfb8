"""Tables as lines of text.  Imports nothing."""

from collections.abc import Iterator, Sequence


def lines(columns: Sequence[Sequence[str]], left: int = 0) -> Iterator[str]:
    """Columns side by side; the first `left` of them begin at the left, the others end at the right."""
    widths = [max(map(len, column)) for column in columns]
    for cells in zip(*columns, strict=True):
        padded = [
            cell.ljust(width) if number < left else cell.rjust(width)
            for number, (cell, width) in enumerate(zip(cells, widths, strict=True))
        ]
        yield "  ".join(padded).rstrip()
