"""The shape "measured": a part of a real surface."""

from dataclasses import dataclass
from math import cos, radians, sin
from typing import Annotated, Any

import numpy as np
from numpy.typing import ArrayLike

from ertel.case.height_map import MOST, HeightMap
from ertel.physics.band_limit import smooth_step
from ertel.physics.registry import SHAPES
from ertel.physics.units import ANGLE, POSITION, RMS, WIDTH, Amount, Bounds, Meaning, Quantity, plain

Array = Any  # NumPy arrays that broadcast
TAPER = 0.1  # of the shorter side, where no taper is given


@SHAPES.register("measured")
@dataclass(frozen=True)
class Measured:
    """A measured map of heights: a cubic spline through them, tapered to zero at the edges of the map.

    Its middle is at (x, y) on its surface at T = 0, turned by an angle from x to y.  Outside the map the surface is
    smooth.  From arrays in metres it is made by `Measured.of`.
    """

    file: Annotated[HeightMap, Meaning("file with the heights, relative to the case file", "disc.al3d")]
    length_x: Annotated[
        Amount | None, WIDTH, Meaning("length of the map along its x; left out: as the file says", "500 um")
    ] = None
    length_y: Annotated[
        Amount | None, WIDTH, Meaning("length of the map along its y; left out: as the file says", "500 um")
    ] = None
    rms: Annotated[Amount | None, RMS, Meaning("root mean square of its heights; left out: as measured", "50 nm")] = (
        None
    )
    cutoff: Annotated[Amount | None, WIDTH, Meaning("waves shorter than this are removed; left out: none", "20 um")] = (
        None
    )
    taper: Annotated[
        Amount | None,
        WIDTH,
        Meaning("distance from the edges of the map over which it becomes zero; left out: a tenth of the shorter side"),
    ] = None
    x: Annotated[Amount, POSITION, Meaning("its middle along x at T = 0")] = 0.0
    y: Annotated[Amount, POSITION, Meaning("its middle along y")] = 0.0
    angle: Annotated[float, ANGLE, Meaning("by which the map is turned, from x to y", "0 deg")] = 0.0
    filled: Annotated[
        int | None,
        Bounds(gt=0, le=MOST**2, whole=True),
        Meaning("points of the file that were gaps and were filled; ertel writes it beside its copy of the heights"),
    ] = None

    def __post_init__(self) -> None:
        if not isinstance(self.file, HeightMap):
            raise ValueError(f"file = {self.file!r}: must be a HeightMap; Measured.of(heights, spacing) makes one")
        for name in ("length_x", "length_y", "rms"):
            if getattr(self, name) is None:
                raise ValueError(f"{name}: missing; the heights themselves have no unit")
        sides = (self.length_x, self.length_y, self.taper)
        if not any(isinstance(side, Quantity) for side in sides) and self._taper > min(self._lengths) / 2:
            raise ValueError(f"taper = {self._taper:g} a: must be at most half of the shorter side of the map")

    @classmethod
    def of(cls, heights: ArrayLike, spacing: float | tuple[float, float], **placed: Any) -> "Measured":
        """The shape of heights (ny, nx) in metres, rows along y, at points `spacing` metres apart.

        spacing may be a pair, along x and along y.  placed: the other fields, such as x, y, cutoff.  Tilt and gaps are
        left as they are.  Raises ValueError as `HeightMap`, and for a spacing that is not above zero.
        """
        found = HeightMap(heights)
        steps = np.broadcast_to(np.asarray(spacing, dtype=float), (2,)).tolist()
        if not all(np.isfinite(step) and step > 0 for step in steps):
            raise ValueError(f"spacing = {spacing}: must be above zero, in metres")
        rows, columns = found.heights.shape
        sizes = {"length_x": columns * steps[0], "length_y": rows * steps[1], "rms": found.rms}
        return cls(found, **{name: Quantity(value, "m") for name, value in sizes.items()} | placed)

    @property
    def size(self) -> float:
        """The shortest wave that is kept (a): the cutoff, or two points."""
        return max(plain(self.cutoff or 0.0), 2 * min(self._steps))

    @property
    def covered(self) -> tuple[float, float]:
        """The sides of the map without the taper (a)."""
        along_x, along_y = self._lengths
        return along_x - 2 * self._taper, along_y - 2 * self._taper

    def heights(self, X: Array, Y: Array) -> Array:
        return self.heights_above(0.0, X, Y)

    def heights_above(self, shortest: float, X: Array, Y: Array) -> Array:
        """The heights without waves shorter than `shortest` (a)."""
        X, Y = X - plain(self.x), Y - plain(self.y)
        turn = radians(self.angle)
        along, across = X * cos(turn) + Y * sin(turn), Y * cos(turn) - X * sin(turn)
        (step_x, step_y), (length_x, length_y) = self._steps, self._lengths
        cutoff = max(plain(self.cutoff or 0.0), shortest)
        rows, columns = self.file.heights.shape
        places = along / step_x + (columns - 1) / 2, across / step_y + (rows - 1) / 2
        found = self.file.at(*places, (cutoff / step_x, cutoff / step_y))
        inside = smooth_step((length_x / 2 - np.abs(along)) / self._taper) * smooth_step(
            (length_y / 2 - np.abs(across)) / self._taper
        )
        return plain(self.rms or 0.0) / self.file.rms * found * inside

    @property
    def _lengths(self) -> tuple[float, float]:
        return plain(self.length_x or 0.0), plain(self.length_y or 0.0)

    @property
    def _steps(self) -> tuple[float, float]:
        (length_x, length_y), (rows, columns) = self._lengths, self.file.heights.shape
        return length_x / columns, length_y / rows

    @property
    def _taper(self) -> float:
        return TAPER * min(self._lengths) if self.taper is None else plain(self.taper)
