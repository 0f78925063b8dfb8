"""The directory of a traction curve, which keeps every finished point.

======================  =========================================================================================
case.toml               the resolved case; `ertel run` of it is the contact without the curve
traction.json           what varies, the version, and the points so far
traction.csv            the points as a table
traction.png            the curve
.lock                   empty; the process that computes the curve holds a lock on it, see `files.locked`
======================  =========================================================================================

After each point traction.json is replaced in one stroke, with its checksum.  The other two are written at the end, and
after an interruption.
"""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from ertel.results.curve_points import Point
from ertel.results.traction_curve import TractionCurve
from ertel.runs.curves import Curve
from ertel.runs.directory import Taken, changes, make, numbered
from ertel.runs.files import content_of, locked, reading, replace, sealed, unsealed
from ertel.version import installed_version, own_sources

POINTS, TABLE, PICTURE = "traction.json", "traction.csv", "traction.png"
OF_VERSION = ("version", "sources")  # of ertel; last of what the points depend on


class CurveStore:
    """The directory of one curve: `of` makes or opens it.  points: those that are there."""

    def __init__(self, directory: Path, curve: Curve, points: Sequence[Point]):
        self.directory, self.curve, self.points = directory, curve, tuple(points)

    @classmethod
    def of(cls, directory: Path, curve: Curve) -> "CurveStore":
        """The store of a curve in a directory that holds it, or that does not exist or is empty.

        Raises Taken where the directory holds something else, Damaged, or StoreError where it cannot be made.
        """
        if (directory / POINTS).exists():
            return cls(directory, curve, _points(directory, curve))
        new = cls(directory, curve, ())
        make(directory, curve.case, new._write_first)
        return new

    @classmethod
    def in_turn(cls, parent: Path, curve: Curve) -> "CurveStore":
        """The store in parent/NAME, parent/NAME-2, ...: the first that holds this curve or does not exist."""
        for directory in numbered(parent / (curve.case.name or curve.case.kind)):
            try:
                return cls.of(directory, curve)
            except Taken:
                continue
        raise AssertionError("there is always a next number")

    @contextmanager
    def alone(self) -> Iterator[None]:
        """Keep other processes from computing this curve.  Raises StoreError where one computes it."""
        with locked(self.directory):
            self.points = _points(self.directory, self.curve)
            yield

    def keep(self, new: Point) -> None:
        """Write one more point; it is on the disk when this returns."""
        self.points = (*self.points, new)
        replace(self.directory / POINTS, self._content())

    @property
    def drawn(self) -> bool:
        """Whether table and picture are there."""
        return all((self.directory / name).exists() for name in (TABLE, PICTURE))

    def draw(self, found: TractionCurve) -> None:
        """Write the table and the picture of the points."""
        if self.points:
            found.to_csv(self.directory / TABLE)
            found.plot().savefig(self.directory / PICTURE)

    def _write_first(self, directory: Path) -> None:
        replace(directory / POINTS, self._content())

    def _content(self) -> bytes:
        return sealed({**_identity(self.curve), "points": list(self.points)})


def _identity(curve: Curve) -> dict[str, Any]:
    """All that the points depend on."""
    asked = {"varies": curve.axis, "values": list(curve.values), "film": curve.film, "case": curve.case.to_data()}
    return {**asked, **dict(zip(OF_VERSION, (installed_version(), own_sources()), strict=True))}


def _points(directory: Path, curve: Curve) -> tuple[Point, ...]:
    """The points in a directory.  Raises Taken where they are of another curve, Damaged."""
    path = directory / POINTS
    with reading(path, "choose another directory"):
        content = unsealed(content_of(path))
        points = tuple(content.pop("points"))
    if said := changes(content, _identity(curve)):
        said = "another version of ertel" if said.startswith(OF_VERSION) else said
        raise Taken(f"{directory}: holds another curve ({said})")
    return points
