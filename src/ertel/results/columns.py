"""Files of columns as instruments write them: quantities by their name, with units, in SI.

The columns are parted by semicolons, tabs, commas or blanks; a number may have a decimal comma where commas do not part
them.  Lines that begin with # are left out.
"""

import csv
import re
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ertel.case.reading import regular_content
from ertel.physics.units import Unit, si_numbers

LARGEST_FILE = 20_000_000  # bytes: a million rows
SEPARATORS = ";", "\t", ","
COMMA = "has a comma inside of a column, and commas part the columns; write a point, or nothing for thousands"
HEADING = re.compile(r"(?P<name>.+?)\s*(?:[\[(]\s*(?P<unit>[^\])]+?)\s*[\])]|/\s*(?P<after>\S+))?\s*")
GAPS = {"", "nan", "na", "n/a", "-", "---"}


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
    def read(
        cls, path: Path, known: Collection[str], headings: Mapping[str, str], units: Mapping[str, str]
    ) -> "Columns":
        """The columns of a file that hold quantities with known names.

        headings: the name in the header by the quantity, where they differ.  units: the unit by the quantity, where the
        header does not say it; a file without a header has these columns, in this order.

        Raises ValueError where the file has no numbers, its lines have unlike numbers of columns, or a heading is not
        there, and where there is no file.
        """
        separator, lines, rows = _rows(path)
        header = rows[0]
        if not np.isnan([_number(text) for text in header]).any():
            if len(units) != len(header):
                raise ValueError(
                    f"{path.name}: has {len(header)} columns without a header; give the unit of each in their order, "
                    'such as x="um", h="nm"'
                )
            named = [(quantity, "") for quantity in units]
        else:
            rows, lines = rows[1:], lines[1:]
            if missing := [heading for heading in headings.values() if heading not in header]:
                raise ValueError(f"{path.name}: has no column {missing[0]!r}; {_listed(header)}")
            named = [_quantity(heading, headings, known) for heading in header]
            names = [name for name, _ in named if name]
            if twice := [name for name in names if names.count(name) > 1]:
                advice = f'say which one is {twice[0]}, such as columns={{"{twice[0]}": "{header[-1]}"}}'
                raise ValueError(f"{path.name}: {_listed(header)}; {advice}")
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
        if all(marks):
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


def _rows(path: Path) -> tuple[str | None, list[int], list[list[str]]]:
    """The separator of a file, the numbers of its lines, and their cells; the first one is its header if it has one."""
    if not path.exists() or path.is_dir():
        raise ValueError(f"{path.name}: not a file in {path.parent.absolute()}")
    try:
        content = regular_content(path, LARGEST_FILE)
    except ValueError as error:
        raise ValueError(f"{path.name}: {error}") from error
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError:
        text = content.decode("latin-1")
    lines = {n: line for n, line in enumerate(text.splitlines(), 1) if line.strip(" \t;,") and not line.startswith("#")}
    if len(lines) < 2:
        raise ValueError(f"{path.name}: has no rows of numbers")
    first = next(iter(lines.values()))
    separator = next((each for each in SEPARATORS if each in first), None)
    rows = []
    for number, line in lines.items():
        try:
            row = next(csv.reader([line], delimiter=separator)) if separator else line.split()
        except csv.Error as error:
            raise ValueError(f"{path.name}: line {number}: {error}") from error
        rows.append([cell.strip() for cell in row])
    for number, row in zip(lines, rows, strict=True):
        if len(row) != len(rows[0]):
            raise ValueError(f"{path.name}: line {number} has {len(row)} columns and the first has {len(rows[0])}")
    return separator, list(lines), rows


def _quantity(heading: str, headings: Mapping[str, str], known: Collection[str]) -> tuple[str, str]:
    """The quantity and the unit of a column by its heading; "" of one that is not known."""
    parts = HEADING.fullmatch(heading)
    written, unit = (parts["name"].lower(), parts["unit"] or parts["after"] or "") if parts else ("", "")
    for name, there in headings.items():
        if heading == there:
            return name, unit
    for name in sorted(set(known) - set(headings), key=len, reverse=True):  # h_c_nm is h_c and not h
        if written == name.lower():
            return name, unit
        if written.startswith(f"{name.lower()}_") and not unit:
            return name, heading[len(name) + 1 :].replace("_per_", "/")
    return "", ""


def _number(text: str) -> float:
    """A number with a decimal point or comma; NaN of any other text."""
    try:
        number = float(text.replace(",", "."))
    except ValueError:
        return np.nan
    return number if np.isfinite(number) else np.nan


def _listed(header: Collection[str]) -> str:
    return f"it has {', '.join(repr(name) for name in header)}"
