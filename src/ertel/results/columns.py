"""Files of columns as instruments write them: quantities by their name, with units, in SI.

The columns are parted by semicolons, tabs, commas or blanks, as most lines say; a number may have a decimal comma where
commas do not part them.  The numbers begin with the first line that has them.  Above it stand whatever the instrument
notes, the names of the columns, and their units, beside the names or in a row of their own.  Below it lines that begin
with # or % are left out.
"""

import csv
import re
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ertel.case.reading import decoded, regular_content
from ertel.physics.units import Unit, si_numbers

LARGEST_FILE = 20_000_000  # bytes: a million rows
MOST_COLUMNS, MOST_LISTED, LONGEST_NAME = 1000, 40, 200
SEPARATORS = ";", "\t", ",", None  # None: blanks
SAMPLE = 100  # lines, the last ones, from which the separator is taken
WORDS = re.compile(r"\S+(?:\s+[\[(][^\])]*[\])])?")  # between blanks, a unit in brackets with its name
MARKS = "#%", "#% \t/*"  # of comments, and what may stand with them before a header
COMMA = "has a comma inside of a column, and commas part the columns; write a point, or nothing for thousands"
THOUSANDS = re.compile(r"[-+]?[1-9]\d{0,2}([.,]\d{3})+")  # perhaps: refused beside the other sign
HEADING = re.compile(r"(?P<name>.+?)\s*(?:[\[(]\s*(?P<unit>[^\])]+?)\s*[\])]|/\s*(?P<after>\S+))?\s*")
GAPS = {"", "nan", "na", "n/a", "#n/a", "#na", "#value!", "#div/0!", "1.#qnan", "-", "--", "---"}


@dataclass(frozen=True)
class Columns:
    """The columns of a file.

    file: its name.  listed: the names in its first line, for messages.  texts, units: of the columns that are known, by
    quantity; "" is a unit that is not known.  lines: of the rows in the file, counted from 1.
    """

    file: str
    listed: str
    texts: Mapping[str, Sequence[str]]
    units: Mapping[str, str]
    lines: Sequence[int]

    @classmethod
    def read(cls, path: Path, known: Collection[str], units: Mapping[str, str]) -> "Columns":
        """The columns of a file that hold quantities with known names.

        units: by the quantity the unit, the name in the header, or both, "Film=nm", where the header does not say them.
        A file without a header has these columns, in this order.

        Raises ValueError where the file has no numbers, its lines have unlike numbers of columns, or a heading is not
        there, and where there is no file.
        """
        table = _table(path)
        headings: dict[str, str] = {}
        for name, given in units.items():  # a heading, or a heading and a unit, in the place of a unit
            heading, _, unit = (given, "", "") if table.has(given) else given.rpartition("=")
            if heading:
                headings[name], units = heading, {**units, name: unit}
        units = {name: unit for name, unit in units.items() if unit}
        try:
            header, unit_row = table.header(headings.values(), known)
        except ValueError as error:
            raise ValueError(f"{path.name}: {error}") from error
        if not header:
            if len(units) != table.width:
                raise ValueError(
                    f"{path.name}: has {table.width} columns without a header; give the unit of each in their order, "
                    'such as x="um", h="nm"'
                )
            named = [(quantity, "") for quantity in units]
        else:
            if missing := [heading for heading in headings.values() if not _is_among(heading, header)]:
                raise ValueError(f"{path.name}: has no column {missing[0]!r}; {_listed(header)}")
            named = [_quantity(heading, headings, known) for heading in header]
            named = [(name, unit or below) for (name, unit), below in zip(named, unit_row, strict=True)]
            names = [name for name, _ in named if name]
            if twice := [name for name in names if names.count(name) > 1]:
                advice = f'say which one is {twice[0]}, such as {twice[0]}="{header[-1]}"'
                raise ValueError(f"{path.name}: {_listed(header)}; {advice}")
        separator, lines, rows = table.separator, table.lines, table.rows
        texts = {name: column for (name, _), column in zip(named, zip(*rows, strict=True), strict=False) if name}
        for column in texts.values() if separator == "," else ():
            if commas := [(line, text) for line, text in zip(lines, column, strict=True) if "," in text]:
                raise ValueError(f"{path.name}: line {commas[0][0]}: {commas[0][1][:40]!r} {COMMA}")
        return cls(path.name, _listed(header), texts, {**dict(named), **units}, lines)

    def values(self, name: str, si_unit: str, unit: str = "") -> NDArray[np.float64]:
        """A column in SI, (rows,); NaN where it has a gap.

        Raises ValueError where its unit is not known or does not fit, or a text is not a number.
        """
        unit = self.units.get(name) or unit or ("1" if si_unit == "1" else "")
        if not unit:
            advice = f'write {name}_{si_unit} in the header or give {name}="{si_unit}"'
            raise ValueError(f"{self.file}: column {name!r} has no unit; {advice}")
        numbers = [_number(text) for text in self.texts[name]]
        marks = [
            next((n for n, text in zip(self.lines, self.texts[name], strict=True) if mark in text), 0) for mark in ",."
        ]
        if all(marks) and any(map(THOUSANDS.fullmatch, self.texts[name])):
            raise ValueError(
                f"{self.file}: column {name!r} has a comma in line {marks[0]} and a point in line {marks[1]}"
            )
        for line, text, number in zip(self.lines, self.texts[name], numbers, strict=True):
            if np.isnan(number) and text.lower() not in GAPS:
                raise ValueError(f"{self.file}: column {name!r} has {text!r} in line {line}; must be a number")
        try:
            found: NDArray[np.float64] = si_numbers(np.array(numbers), Unit(si_unit, f"1 {si_unit}"), unit)
        except ValueError as error:
            raise ValueError(f"{self.file}: column {name!r} in {unit!r}: {error}") from error
        return found


class _Table(NamedTuple):
    """The cells of a file.  separator: None for blanks.  above: of the lines before the numbers.  rows: at `lines`."""

    separator: str | None
    above: list[tuple[int, list[str]]]
    lines: list[int]
    rows: list[list[str]]

    @property
    def width(self) -> int:
        """The number of columns."""
        return len(self.rows[0])

    def has(self, heading: str) -> bool:
        """Whether this is the name of a column."""
        return any(_is_among(heading, cells) for _, cells in self.above)

    def header(self, headings: Collection[str], known: Collection[str]) -> tuple[list[str], list[str]]:
        """The names of the columns, and the units in the row below them; no names where there is no header.

        That is the last line of such a length with one of these headings, or with a known quantity, or else the last.
        Raises ValueError where numbers stand between it and the rows.
        """
        numbers, lines = [*zip(*[each for each in self.above if len(each[1]) == self.width], strict=True)] or ((), ())
        found = [n for n, cells in enumerate(lines) if any(_is_among(heading, cells) for heading in headings)] or [
            n for n, cells in enumerate(lines) if any(_quantity(cell, {}, known)[0] for cell in cells)
        ]
        number = next(reversed(found), len(lines) - 1)
        if number < 0:
            return [], []
        for line, cells in zip(numbers[number + 1 :], lines[number + 1 :], strict=True):
            if wrong := [cell for cell in cells if cell[:1].isdecimal() and cell != "1"]:
                raise ValueError(f"line {line}: {wrong[0][:40]!r} is not a unit, and the line is not a row of numbers")
        below = lines[number + 1] if number + 1 < len(lines) else [""] * self.width
        return lines[number], [cell.strip("[]() ") for cell in below]


def _table(path: Path) -> _Table:
    if not path.exists() or path.is_dir():
        raise ValueError(f"{path.name}: not a file in {path.parent.absolute()}")
    try:
        text = decoded(regular_content(path, LARGEST_FILE))
    except ValueError as error:
        raise ValueError(f"{path.name}: {error}") from error
    lines = {n: line for n, line in enumerate(text.splitlines(), 1) if line.strip(" \t;,")}
    separator = max(SEPARATORS, key=lambda each: sum(_score(line, each) for line in [*lines.values()][-SAMPLE:]))
    above: list[tuple[int, list[str]]] = []
    rows: dict[int, list[str]] = {}
    for number, line in lines.items():
        try:
            cells = _cells(line if rows else line.lstrip(MARKS[1]), separator)
        except csv.Error as error:
            raise ValueError(f"{path.name}: line {number}: {error}") from error
        if rows or (_is_row(cells) and line[0] not in MARKS[0]):
            if line[0] not in MARKS[0] or cells[0].lower() in GAPS:
                rows[number] = cells
        else:
            above.append((number, cells))
    if not rows:
        raise ValueError(f"{path.name}: has no rows of numbers")
    while all(len(cells) > 1 and not cells[-1] for cells in rows.values()):  # a separator also ends each line
        rows = {number: cells[:-1] for number, cells in rows.items()}
    first = next(iter(rows.values()))
    if len(first) > MOST_COLUMNS:
        raise ValueError(f"{path.name}: has {len(first)} columns; must have at most {MOST_COLUMNS}")
    above = [(n, cells if any(cells[len(first) :]) else cells[: len(first)]) for n, cells in above]
    for number, cells in rows.items():
        if len(cells) != len(first):
            sizes = f"line {number} has {len(cells)} columns and the first has {len(first)}"
            raise ValueError(f"{path.name}: {sizes}; remove a line that is not a row of numbers")
    return _Table(separator, above, list(rows), list(rows.values()))


def _cells(line: str, separator: str | None) -> list[str]:
    if separator is None:
        return WORDS.findall(line)
    return [cell.strip() for cell in next(csv.reader([line], delimiter=separator, skipinitialspace=True))]


def _is_row(cells: Sequence[str]) -> bool:
    """Whether most of the cells that are not gaps are numbers."""
    known = [not np.isnan(_number(cell)) for cell in cells if cell.lower() not in GAPS]
    return 2 * sum(known) > len(known)


def _score(line: str, separator: str | None) -> int:
    """The numbers less the other words in a line with this separator; 0 of a single one, and where words prevail."""
    cells = line.split(separator)
    score = sum(1 if not np.isnan(_number(cell)) else -1 for cell in cells if cell.strip().lower() not in GAPS)
    return max(score, 0) if len(cells) > 1 else 0


def _is_among(heading: str, header: Sequence[str]) -> bool:
    """Whether a column has this heading, or this name before its unit."""
    parts = [(cell, HEADING.fullmatch(cell[:LONGEST_NAME])) for cell in header]
    return any(heading == cell or (found and heading == found["name"]) for cell, found in parts)


def _quantity(heading: str, headings: Mapping[str, str], known: Collection[str]) -> tuple[str, str]:
    """The quantity and the unit of a column by its heading; "" of one that is not known."""
    parts = HEADING.fullmatch(heading[:LONGEST_NAME])
    written, unit = (parts["name"].lower(), parts["unit"] or parts["after"] or "") if parts else ("", "")
    for name, there in headings.items():
        if _is_among(there, [heading]):
            return name, unit
    for name in sorted(set(known) - set(headings), key=len, reverse=True):  # h_c_nm is h_c and not h
        if written == name.lower():
            return name, unit
        if written.startswith(f"{name.lower()}_") and not unit:
            return name, heading[len(name) + 1 :].replace("_per_", "/")
    return "", ""


def _number(text: str) -> float:
    """A number with a decimal point or comma, its power of ten after e or Fortran's D; NaN of any other text."""
    try:
        number = float(text.strip('"').replace(",", ".").upper().replace("D", "E"))
    except ValueError:
        return np.nan
    return number if np.isfinite(number) else np.nan


def _listed(header: Collection[str]) -> str:
    names, more = [repr(name) for name in header][:MOST_LISTED], len(header) - MOST_LISTED
    return f"it has {', '.join(names)}{f' and {more} more columns' if more > 0 else ''}"
