"""Files of columns as instruments write them: quantities by their name, with units, in SI.

The columns are parted by semicolons, tabs, commas or blanks; a number may have a decimal comma where commas do not part
them.  Lines that begin with # are left out.
"""

import csv
import re
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ertel.physics.units import Unit, in_si

SEPARATORS = ";", "\t", ","
HEADING = re.compile(r"(?P<name>.+?)\s*(?:[\[(]\s*(?P<unit>[^\])]+?)\s*[\])]|/\s*(?P<after>\S+))?\s*")
GAPS = {"", "nan", "na", "n/a", "-", "---"}


@dataclass(frozen=True)
class Columns:
    """The columns of a file.

    file: its name.  header: the names in its first line.  texts, units: of the columns that are known, by quantity;
    "" is a unit that is not known.
    """

    file: str
    header: tuple[str, ...]
    texts: Mapping[str, list[str]]
    units: Mapping[str, str]

    @classmethod
    def read(
        cls, path: Path, known: Collection[str], headings: Mapping[str, str], units: Mapping[str, str]
    ) -> "Columns":
        """The columns of a file that hold quantities with known names.

        Parameters
        ----------
        path : Path
            The file.  Without a header it has the columns of `units`, in this order.
        known : collection of str
            Names of quantities.
        headings : mapping
            The name in the header by the quantity, where they differ.
        units : mapping
            The unit by the quantity, where the header does not say it.

        Raises
        ------
        ValueError
            The file has no numbers, its lines have unlike numbers of columns, or a heading is not there.
        """
        rows = _rows(path)
        header = tuple(rows[0])
        if all(_is_number(text) for text in header):
            if len(units) != len(header):
                raise ValueError(
                    f"{path.name}: has {len(header)} columns without a header; give the unit of each in their order, "
                    'such as x="um", h="nm"'
                )
            named = [(quantity, "") for quantity in units]
        else:
            rows = rows[1:]
            if missing := [heading for heading in headings.values() if heading not in header]:
                raise ValueError(f"{path.name}: has no column {missing[0]!r}; {_listed(header)}")
            named = [_quantity(heading, headings, known) for heading in header]
            names = [name for name, _ in named if name]
            if twice := [name for name in names if names.count(name) > 1]:
                advice = f'say which one is {twice[0]}, such as columns={{"{twice[0]}": "{header[-1]}"}}'
                raise ValueError(f"{path.name}: {_listed(header)}; {advice}")
        texts = {name: list(column) for (name, _), column in zip(named, zip(*rows, strict=True), strict=False) if name}
        return cls(path.name, header, texts, {name: unit for name, unit in named if name} | dict(units))

    @property
    def listed(self) -> str:
        """The names in the header, for messages."""
        return _listed(self.header)

    def values(self, name: str, si_unit: str, unit: str = "") -> NDArray[np.float64]:
        """A column in SI, (rows,); NaN where it has a gap.

        Raises ValueError where its unit is not known or does not fit, or a text is not a number.
        """
        unit = self.units.get(name) or unit or ("1" if si_unit == "1" else "")
        if not unit:
            advice = f'write {name}_{si_unit} in the header or give {name}="{si_unit}"'
            raise ValueError(f"{self.file}: column {name!r} has no unit; {advice}")
        factor = 1.0
        if unit != si_unit:
            try:
                factor = in_si(f"1 {unit}", Unit(si_unit, f"1 {si_unit}"))
            except ValueError as error:
                raise ValueError(f"{self.file}: column {name!r} in {unit!r}: {error}") from error
        for number, text in enumerate(self.texts[name], 1):
            if not (_is_number(text) or text.lower() in GAPS):
                raise ValueError(f"{self.file}: column {name!r} has {text!r} in row {number}; must be a number")
        return factor * np.array([_number(text) if _is_number(text) else np.nan for text in self.texts[name]])


def _rows(path: Path) -> list[list[str]]:
    """The cells of a file, the first line its header if it has one."""
    content = path.read_bytes()
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError:
        text = content.decode("latin-1")
    lines = [line for line in text.splitlines() if line.strip(" \t;,") and not line.startswith("#")]
    if len(lines) < 2:
        raise ValueError(f"{path.name}: has no rows of numbers")
    separator = next((each for each in SEPARATORS if each in lines[0]), None)
    rows = list(csv.reader(lines, delimiter=separator)) if separator else [line.split() for line in lines]
    rows = [[cell.strip() for cell in row] for row in rows]
    if odd := next((n for n, row in enumerate(rows, 1) if len(row) != len(rows[0])), 0):
        raise ValueError(f"{path.name}: line {odd} has {len(rows[odd - 1])} columns and the first has {len(rows[0])}")
    return rows


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
            return name, heading.strip()[len(name) + 1 :].replace("_per_", "/")
    return "", ""


def _number(text: str) -> float:
    return float(text.replace(",", "."))


def _is_number(text: str) -> bool:
    try:
        return bool(np.isfinite(_number(text)))
    except ValueError:
        return False


def _listed(header: Collection[str]) -> str:
    return f"it has {', '.join(repr(name) for name in header)}"
