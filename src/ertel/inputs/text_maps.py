"""Heights in text: a matrix of numbers, a list of points x, y, height, or a profile: x, height, or heights alone.

Nobody declares what such a file is.  Its shape and its numbers decide; what may be read in two ways is refused, with
the line.  A gap is nan or bad.
"""

import re
from collections.abc import Sequence
from math import prod
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ertel.case.reading import decoded
from ertel.case.records import shortened
from ertel.physics.units import LENGTH, si_numbers

Numbers = NDArray[np.float64]
GAPS = {"nan", "bad"}
SENTINELS = (-9999.0, -99999.0, -32768.0, 32767.0, -2147483648.0, 9999.0, 99999.0)  # with which programs mark a gap
FAR = 100.0  # ranges of all others, from which on any height is a mark; for those of programs one range is enough
ROUNDED = 0.02  # of a step: coordinates are written with few digits
MOST_COLUMNS = 8  # of a list of points with more than x, y and a height
NUMBER_OR_TWO = re.compile(r"\s*[-+]?\d+,\d+(e[-+]?\d+)?", re.I)
ORDERS = "z", "xz", "xy", "xyz"  # of the names in a header; programs call the height of a profile y, too
OF_MATRIX = re.compile(r"#\s*(Width|Height|Value units)\s*:")
UNITS = re.compile(r"#\s*Lateral units:\s*(\S+).*?#\s*Value units:\s*(\S+)", re.S)  # as Gwyddion writes them
HEADING = re.compile(  # a name, and its unit in brackets or after / or _
    r"(?<![a-z])(x|y|z|h|height)(?![a-z])[^\[(/_\t;,xyz]*(?:[\[(/_]\s*([^\W\d][^\])\s;,]*))?", re.I
)


class Text(NamedTuple):
    """header: the lines before the numbers.  numbers: (rows, columns).  lines: of the rows in the file, from 1."""

    header: tuple[str, ...]
    numbers: Numbers
    lines: tuple[int, ...]

    @property
    def content(self) -> bytes:
        """The same with points and blanks, as SurfaceTopography reads it."""
        rows = (" ".join(map(repr, row)) for row in self.numbers.tolist())
        return "\n".join([*self.header, *rows, ""]).encode()


def read_rows(content: bytes) -> Text:
    """The numbers in a text.  Raises ValueError, with the line, for a row of which a part is not a number."""
    lines = {n: line.rstrip("\t ;,") for n, line in enumerate(decoded(content).splitlines(), 1)}
    lines = {n: line for n, line in lines.items() if line.strip()}
    rows = {n: line for n, line in lines.items() if not line.startswith("#")}
    start = next((n for n, line in rows.items() if _is_row(line)), 0)
    if not start:
        raise ValueError("SurfaceTopography cannot read it, and it has no rows of numbers")
    rows = {n: line for n, line in rows.items() if n >= start}
    if all(map(NUMBER_OR_TWO.fullmatch, rows.values())):
        both = f"{shortened(rows[start])!r} may be one number or two"
        raise ValueError(f"line {start}: {both}; write points, or part the numbers by semicolons")
    separator, comma = _written("\n".join(rows.values()))
    found: list[Numbers] = []
    for number, line in rows.items():
        cells = line.split(separator)
        try:
            found.append(np.array([np.nan if cell.strip().lower() in GAPS else _number(cell, comma) for cell in cells]))
        except ValueError as error:
            raise ValueError(f"line {number}: {error}; a gap is written nan") from error
        if len(cells) != len(found[0]):
            raise ValueError(f"line {number} has {len(cells)} numbers, and line {start} has {len(found[0])}")
    return Text(tuple(line for n, line in lines.items() if n not in rows), np.array(found), tuple(rows))


def _is_row(line: str) -> bool:
    """Whether most of the words in a line are numbers or stars."""
    words = re.split(r"[\s;]+", line.strip()) if re.search(r"[\s;]", line.strip()) else line.split(",")
    numbers = sum(bool(re.fullmatch(r"[-+]?[\d.,]+(e[-+]?\d+)?,?|nan,?|bad,?|\*+,?", word, re.I)) for word in words)
    return numbers > len(words) / 2


def _written(text: str) -> tuple[str | None, bool]:
    """The separator of the numbers, None for blanks, and whether they have a decimal comma."""
    separator = next((each for each in (";", "\t") if each in text), None)
    if separator is None and "," in text and ("." in text or re.search(r",\s", text) or " " not in text.strip()):
        return ",", False
    if "," in text and "." in text:
        raise ValueError("its numbers have commas and points; write them with points alone")
    return separator, "," in text


def _number(cell: str, comma: bool) -> float:
    cell = cell.strip()
    if re.fullmatch(r"[-+]?0\d+", cell):
        raise ValueError(f"{shortened(cell)!r} may be the decimals of another number; part the numbers by blanks")
    try:
        return float(cell.replace(",", ".") if comma else cell)
    except ValueError:
        raise ValueError(f"{shortened(cell)!r} is not a number") from None


# -- what the numbers are ---------------------------------------------------------------------------------------------


def is_list(text: Text) -> bool:
    """Whether the rows are points: x, y, height, or those of a profile.  Raises ValueError for further columns."""
    rows, columns = text.numbers.shape
    values = [np.unique(column) for column in text.numbers.T] if 3 < columns <= MOST_COLUMNS else []
    if sum(1 < len(each) <= rows / 2 and _even(each) for each in values) > 1:
        raise ValueError(f"is a list of points with {columns} columns; leave x, y and the height")
    return columns <= 3


def _even(values: Numbers) -> bool:
    steps = np.diff(values)
    return bool(len(steps) and steps.mean() and np.all(np.abs(steps / steps.mean() - 1) < ROUNDED))


def map_of_points(text: Text) -> tuple[Numbers, tuple[float, ...], bool]:
    """Heights (ny, nx) or (nx,), their lengths along x and y, and whether the header gives units: they are in m then.

    Heights alone have no lengths.  Raises ValueError, with the line, where points are missing, given twice or not at
    regular places.
    """
    units = _units(text.header, text.numbers.shape[1])
    *places, z = (si_numbers(column, LENGTH, unit) for column, unit in zip(text.numbers.T, units, strict=True))
    if len(places) == 2 and not np.ptp(places[1]):  # a profile along x
        places.pop()
    if not places:
        return z, (), bool(units[0])
    axes, numbers = zip(*(np.unique(each, return_inverse=True) for each in places), strict=True)
    if not all(map(_even, axes)):
        raise ValueError(f"its points are not a regular {'map' if len(axes) == 2 else 'profile'}; resample them first")
    shape, point = tuple(map(len, axes))[::-1], numbers[::-1]
    found, first, count = np.unique(np.ravel_multi_index(point, shape), return_index=True, return_counts=True)
    if count.max() > 1:
        raise ValueError(f"line {text.lines[first[count.argmax()]]}: this point is given {count.max()} times")
    if missing := prod(shape) - len(found):
        raise ValueError(f"{missing} of its {' x '.join(map(str, shape[::-1]))} points are missing; write nan for them")
    heights = np.empty(shape)
    heights[point] = z
    return heights, tuple(float(np.ptp(each) * len(each) / (len(each) - 1)) for each in axes), bool(units[0])


def _units(header: Sequence[str], columns: int) -> tuple[str, ...]:
    """The units of x, y and height, or of the last of them; "" where the header has none."""
    if found := UNITS.search("\n".join(header)):
        return (*[found[1]] * (columns - 1), found[2])
    below: tuple[str, ...] = ("",) * columns
    for line in reversed(header):  # those of the columns stand next to them
        words = re.findall(r"[^\s;,()[\]#]+", line)
        if len(words) == columns and all(map(_is_length, words)):
            below = tuple(words)
            continue
        names, units = zip(*HEADING.findall(line) or [("", "")], strict=True)
        order, given = "".join(name[0].lower() for name in names if name), sum(map(bool, units))
        is_whole = given == columns or (not given and not any(map(_is_length, words)))
        if len(names) == columns and order.replace("h", "z") in ORDERS and is_whole:
            return units if given else below
        if re.search(r"[\[(]", line) or OF_MATRIX.match(line) or (order and columns in (len(words), len(names))):
            needed = "must have x, y and z in this order, of a profile x and z, or z, with all units or none"
            raise ValueError(f"its header {shortened(line)!r} is not understood; {needed}, such as x (um), z (nm)")
    return below


def _is_length(word: str) -> bool:
    try:
        return word.isalpha() and bool(si_numbers(1.0, LENGTH, word))
    except ValueError:
        return False


def check_matrix(text: Text) -> None:
    """Raise ValueError for a first row or a first column that has the places of the heights."""
    for what, rows in (("row", text.numbers), ("column", text.numbers.T)):
        if len(rows) > 3 and _even(rows[0, 1:]) and _like(rows[1], rows[2]) and not _like(rows[0], rows[1]):
            places = ", ".join(f"{value:g}" for value in rows[0, 1:4])
            raise ValueError(
                f"line {text.lines[0]}: the first {what} has places ({places}, ...) and no heights; remove it"
            )


def _like(one: Numbers, two: Numbers) -> bool:
    """Whether two rows are both uneven, or both even with about the same step."""
    if not (_even(one[1:]) and _even(two[1:])):
        return _even(one[1:]) == _even(two[1:])
    return bool(0.5 < (one[2] - one[1]) / (two[2] - two[1]) < 2)


def check_marks(heights: Numbers) -> None:
    """Raise ValueError for a height that marks a gap: -9999 and its like, or one far from all others."""
    values, counts = np.unique(heights[np.isfinite(heights)], return_counts=True)
    for end, inner in ((0, values[1:]), (-1, values[:-1])):
        if len(inner) < 2:
            return
        distance = abs(values[end] - inner[end])
        far = 1.0 if values[end] in SENTINELS else FAR
        if distance > far * np.ptp(inner):
            others = f"the others are from {inner[0]:g} to {inner[-1]:g}"
            raise ValueError(
                f"its height {values[end]:g} marks a gap ({counts[end]} points, {others}); write nan for it"
            )
