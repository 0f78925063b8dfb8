"""Heights measured at the points of a map or a profile, a smooth surface through them, and the shape "measured"."""

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from io import BytesIO
from math import cos, inf, prod, radians, sin
from tokenize import TokenError
from typing import Annotated, Any

import numpy as np
from numpy.lib import format as npy
from numpy.typing import ArrayLike, NDArray

from ertel.physics import units
from ertel.physics.asperities import Spectrum
from ertel.physics.registry import SHAPES
from ertel.physics.surfaces import kept_share, smooth_step
from ertel.physics.units import Amount, Bounds, Meaning, Quantity, explained, plain

Array = Any  # NumPy arrays that broadcast

FEWEST, MOST = 4, 4096  # points along a side: a cubic spline needs the first, the second is 134 MB
SPLINES = 8  # kept in memory: some maps on the grids of a hierarchy
LONGEST = 2**20  # points of a profile: 8 MB
TAPER = 0.1  # of the shorter side, where no taper is given


def check_shape(shape: Sequence[int]) -> None:
    """Raise ValueError for a shape that no map and no profile, of one row, may have."""
    is_profile = len(shape) == 1 or (len(shape) == 2 and shape[0] == 1)
    sides, most = (shape[-1:], LONGEST) if is_profile else (shape, MOST)
    if len(shape) not in (1, 2) or min(sides) < FEWEST or max(sides) > most:
        written = " x ".join(map(str, shape)) or "a number"
        allowed = f"a map of {FEWEST} to {MOST} points a side, or a profile of {FEWEST} to {LONGEST}"
        raise ValueError(f"heights: is {written}; must be {allowed}")


def check_size(heights: NDArray[np.float64]) -> None:
    """Raise ValueError for heights that are all zero, or whose squares no number can hold."""
    largest = float(max(abs(heights.min()), abs(heights.max())))
    if not largest:
        raise ValueError("heights: are all zero; leave the map out")
    if not units.SMALLEST <= largest <= units.LARGEST:
        sizes = f"between {units.SMALLEST:g} and {units.LARGEST:g}"
        raise ValueError(f"heights: reach {largest:.3g}; the largest must be {sizes}")


def array_in(content: bytes) -> NDArray[Any]:
    """The array in the content of a NumPy file; its shape is looked at before any memory is taken.

    Raises ValueError for something else than an array of numbers, and for a shape that no map may have.
    """
    stream = BytesIO(content)
    try:
        read = npy.read_array_header_1_0 if npy.read_magic(stream) == (1, 0) else npy.read_array_header_2_0
        shape, _, kind = read(stream)
    except (ValueError, TypeError, KeyError, SyntaxError, TokenError) as error:  # NumPy evaluates the header as Python
        raise ValueError(f"is not an array of numbers, {str(error)[:100]}") from error
    check_shape(shape)
    bytes_left = len(content) - stream.tell()
    if kind.kind not in "biuf" or kind.itemsize * prod(shape) > bytes_left:
        raise ValueError(f"is not an array of numbers, {' x '.join(map(str, shape))} of {kind} in {bytes_left} bytes")
    return np.load(BytesIO(content), allow_pickle=False)


class HeightMap:
    """Heights on a regular map or profile, equal to another one if all its heights are the same.

    Parameters
    ----------
    heights : array (ny, nx) or (nx,)
        Heights, in any unit; rows along y, columns along x.  All finite.  One row is a profile, the same at all y.

    Raises ValueError for another number of dimensions, too few or too many points, a gap, a map without heights, or
    heights of which the largest is below 1e-30 or above 1e30.
    """

    def __init__(self, heights: ArrayLike):
        found = np.array(heights, dtype="<f8", order="C")
        check_shape(found.shape)
        found = np.atleast_2d(found)
        if not np.isfinite(found).all():
            raise ValueError("heights: has gaps, or numbers that are not finite; fill them first")
        check_size(found)
        found.setflags(write=False)
        self.heights: NDArray[np.float64] = found

    @cached_property
    def digest(self) -> str:
        """Digest of the heights: 16 hexadecimal digits."""
        return hashlib.sha256(str(self.heights.shape).encode() + self.heights.tobytes()).hexdigest()[:16]

    @property
    def name(self) -> str:
        """The name of its file, which says what must be in it."""
        return f"heights-{self.digest}.npy"

    @cached_property
    def rms(self) -> float:
        """Root mean square of the heights."""
        return float(np.sqrt(np.mean(self.heights**2)))

    def to_bytes(self) -> bytes:
        """The content of its file: a NumPy array."""
        content = BytesIO()
        np.save(content, self.heights, allow_pickle=False)
        return content.getvalue()

    def at(self, columns: Array, rows: Array, cutoffs: tuple[float, float]) -> Array:
        """The smooth surface at places counted in points, (0, 0) at the first; arrays that broadcast.

        cutoffs: a wavelength counted in points along x and along y; nothing is lost of waves at least as long, and
        those below half of it are gone (`surfaces.kept_share`).  (0, 0) leaves all.  The surface goes through the
        heights that are left; it is a cubic spline, whose second derivatives are continuous.
        """
        from scipy.ndimage import map_coordinates

        columns, rows = np.broadcast_arrays(columns, rows)
        places = [rows.ravel(), columns.ravel()]
        surface = map_coordinates(_spline(self, *cutoffs), places, order=3, mode="reflect", prefilter=False)
        return surface.reshape(rows.shape)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, HeightMap) and self.digest == other.digest

    def __hash__(self) -> int:
        return hash(self.digest)

    def __repr__(self) -> str:
        rows, columns = self.heights.shape
        return f"HeightMap({rows} x {columns} heights, {self.digest})"


NO_MAPS: Mapping[str, HeightMap] = {}


@lru_cache(maxsize=SPLINES)
def _spline(heights: HeightMap, cutoff_x: float, cutoff_y: float) -> NDArray[np.float64]:
    """The coefficients of the cubic spline through the heights without short waves.

    The waves are those of the cosine transform: a map need not be periodic, its mirror image follows at each edge.
    """
    from scipy.fft import dctn, idctn
    from scipy.ndimage import spline_filter

    kept = heights.heights
    if cutoff_x or cutoff_y:
        rows, columns = kept.shape
        along_y = np.arange(rows)[:, None] * cutoff_y / (2 * rows)
        along_x = np.arange(columns) * cutoff_x / (2 * columns)
        kept = idctn(dctn(kept) * kept_share(np.hypot(along_x, along_y)))
    return np.asarray(spline_filter(kept, order=3, mode="reflect"), dtype=np.float64)


@SHAPES.register("measured")
@explained
@dataclass(frozen=True)
class Measured:
    """A measured map of heights, or a profile: a cubic spline through them, tapered to zero at its edges.

    Its middle is at (x, y) on its surface at T = 0, turned by an angle from x to y.  Outside the map the surface is
    smooth.  A profile, of one row, is the roughness of a line contact, or ridges along y; it has ends along x alone.
    `Measured.of` makes one of arrays in metres.
    """

    file: Annotated[HeightMap, Meaning("file with the heights, relative to the case file", "disc.al3d")]
    length_x: Annotated[
        Amount | None, units.WIDTH, Meaning("length of the map along its x; left out: as the file says", "500 um")
    ] = None
    length_y: Annotated[
        Amount | None, units.WIDTH, Meaning("length of a map along its y; left out: as the file says", "500 um")
    ] = None
    rms: Annotated[
        Amount | None, units.RMS, Meaning("root mean square of its heights; left out: as measured", "50 nm")
    ] = None
    cutoff: Annotated[
        Amount | None, units.WIDTH, Meaning("waves shorter than this are removed; left out: none", "20 um")
    ] = None
    taper: Annotated[
        Amount | None,
        units.WIDTH,
        Meaning("distance from the edges of the map over which it becomes zero; left out: a tenth of the shorter side"),
    ] = None
    x: Annotated[Amount, units.POSITION, Meaning("its middle along x at T = 0")] = 0.0
    y: Annotated[Amount, units.POSITION, Meaning("its middle along y")] = 0.0
    angle: Annotated[float, units.ANGLE, Meaning("by which the map is turned, from x to y", "0 deg")] = 0.0
    filled: Annotated[
        int | None,
        Bounds(gt=0, le=MOST**2, whole=True),
        Meaning("points of the file that were gaps and were filled; ertel writes it beside its copy of the heights"),
    ] = None

    def __post_init__(self) -> None:
        if not isinstance(self.file, HeightMap):
            raise ValueError(f"file = {self.file!r}: must be a HeightMap; Measured.of(heights, spacing) makes one")
        for name in ("length_y", "y", "angle") if self.is_uniform_along_y else ():
            if getattr(self, name):
                raise ValueError(f"{name} = {getattr(self, name)}: a profile is the same at all y; leave it out")
        for name in ("length_x", "rms") if self.is_uniform_along_y else ("length_x", "length_y", "rms"):
            if getattr(self, name) is None:
                raise ValueError(f"{name}: missing; the heights themselves have no unit")
        sides = (self.length_x, self.length_y, self.taper)
        if not any(isinstance(side, Quantity) for side in sides) and self._taper > min(self._lengths) / 2:
            raise ValueError(f"taper = {self._taper:g} a: must be at most half of the shorter side of the map")

    @classmethod
    def of(cls, heights: ArrayLike, spacing: float | tuple[float, float], **placed: Any) -> "Measured":
        """The shape of heights (ny, nx), or (nx,) of a profile, in metres, rows along y, `spacing` metres apart.

        spacing of a map may be a pair, along x and along y.  Both may be quantities of pint, or have a text's unit.
        placed: the other fields, such as x, y, cutoff.  Tilt and gaps are left as they are.  Raises ValueError as
        `HeightMap`, and for a spacing that is not above zero.
        """
        found = HeightMap(units.si_numbers(heights, units.LENGTH))
        step = np.asarray(units.si_numbers(spacing, units.LENGTH), dtype=float)
        sides = [points for points in found.heights.shape[::-1] if points > 1]
        if step.shape not in ((), (len(sides),)) or not (np.isfinite(step) & (step > 0)).all():
            raise ValueError(f"spacing = {spacing}: must be above zero, in metres; one number, or two for a map")
        sizes = dict(zip(("length_x", "length_y"), (step * sides).tolist(), strict=False)) | {"rms": found.rms}
        return cls(found, **{name: Quantity(value, "m") for name, value in sizes.items()} | placed)

    @property
    def size(self) -> float:
        """The shortest wave that is kept (a): the cutoff, or two points."""
        return max(plain(self.cutoff or 0.0), 2 * min(self._steps))

    @property
    def even(self) -> tuple[bool, bool]:
        return self.is_uniform_along_y, False

    @property
    def is_uniform_along_y(self) -> bool:
        """Whether it is a profile, the same at all Y."""
        return len(self.file.heights) == 1

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
        inside_x = smooth_step((length_x / 2 - np.abs(along)) / self._taper)
        inside_y = smooth_step((length_y / 2 - np.abs(across)) / self._taper)
        return plain(self.rms or 0.0) / self.file.rms * found * (inside_x * inside_y)

    @lru_cache(maxsize=SPLINES)  # noqa: B019  # the record is small, and its map is kept by the case
    def lost_waves(self, cutoff: float) -> Spectrum:
        """The waves that a cutoff (a) takes from the map, q in 1/a and variance in (a^2/R)^2.

        They and the waves that are left have the variance of the map together.
        """
        from scipy.fft import dctn

        heights, (length_x, length_y) = self.file.heights, self._lengths
        rows, columns = heights.shape
        q = np.pi * np.hypot(np.arange(columns) / length_x, np.arange(rows)[:, None] / length_y)
        squares = (dctn(heights, norm="ortho") * plain(self.rms or 0.0) / self.file.rms) ** 2 / heights.size
        cut = 1.0 - kept_share(q * cutoff / (2 * np.pi)) ** 2
        return Spectrum.of(q[cut > 0], (squares * cut)[cut > 0])

    @property
    def _lengths(self) -> tuple[float, float]:
        return plain(self.length_x or 0.0), inf if self.is_uniform_along_y else plain(self.length_y or 0.0)

    @property
    def _steps(self) -> tuple[float, float]:
        (length_x, length_y), (rows, columns) = self._lengths, self.file.heights.shape
        return length_x / columns, length_y / rows

    @property
    def _taper(self) -> float:
        return TAPER * min(self._lengths) if self.taper is None else plain(self.taper)
