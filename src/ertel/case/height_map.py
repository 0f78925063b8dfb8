"""Heights that were measured at the points of a map, and a smooth surface through them."""

import hashlib
from collections.abc import Mapping, Sequence
from functools import cached_property, lru_cache
from io import BytesIO
from tokenize import TokenError
from typing import Any

import numpy as np
from numpy.lib import format as npy
from numpy.typing import ArrayLike, NDArray

from ertel.physics.band_limit import kept_share
from ertel.physics.units import LARGEST, SMALLEST

Array = Any  # NumPy arrays that broadcast

FEWEST, MOST = 4, 4096  # points along a side: a cubic spline needs the first, the second is 134 MB
SPLINES = 8  # kept in memory: some maps on the grids of a hierarchy


def check_shape(shape: Sequence[int]) -> None:
    """Raise ValueError for a shape that no map may have."""
    if len(shape) != 2 or min(shape) < FEWEST or max(shape) > MOST:
        written = " x ".join(map(str, shape)) or "a number"
        raise ValueError(f"heights: is {written}; must be a map of {FEWEST} to {MOST} points a side")


def check_size(heights: NDArray[np.float64]) -> None:
    """Raise ValueError for heights that are all zero, or whose squares no number can hold."""
    largest = float(max(abs(heights.min()), abs(heights.max())))
    if not largest:
        raise ValueError("heights: are all zero; leave the map out")
    if not SMALLEST <= largest <= LARGEST:
        raise ValueError(f"heights: reach {largest:.3g}; the largest must be between {SMALLEST:g} and {LARGEST:g}")


def array_in(content: bytes) -> NDArray[Any]:
    """The array in the content of a NumPy file; its shape is looked at before any memory is taken.

    Raises ValueError for something else than an array of numbers, and for a shape that no map may have.
    """
    stream = BytesIO(content)
    try:
        shape, kind = _header(stream)
    except (ValueError, TypeError, KeyError, SyntaxError, TokenError) as error:  # NumPy evaluates the header as Python
        raise ValueError(f"is no array of numbers, {error}") from error
    check_shape(shape)
    bytes_left = len(content) - stream.tell()
    if kind.kind not in "biuf" or kind.itemsize * shape[0] * shape[1] > bytes_left:
        raise ValueError(f"is no array of numbers, {shape[0]} x {shape[1]} of {kind} in {bytes_left} bytes")
    found: NDArray[Any] = np.load(BytesIO(content), allow_pickle=False)
    return found


def _header(stream: BytesIO) -> tuple[tuple[int, ...], np.dtype[Any]]:
    """Shape and type in the header of a NumPy file."""
    version = npy.read_magic(stream)
    read = npy.read_array_header_1_0 if version == (1, 0) else npy.read_array_header_2_0
    shape, _, kind = read(stream)
    return shape, kind


class HeightMap:
    """Heights on a regular map, equal to another one if all its heights are the same.

    Parameters
    ----------
    heights : array (ny, nx)
        Heights, in any unit; rows along y, columns along x.  All finite.

    Raises ValueError for another number of dimensions, too few or too many points, a gap, a map without heights, or
    heights of which the largest is below 1e-30 or above 1e30.
    """

    def __init__(self, heights: ArrayLike):
        found = np.array(heights, dtype="<f8", order="C")
        check_shape(found.shape)
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

    @classmethod
    def from_bytes(cls, content: bytes) -> "HeightMap":
        """The map in such a file.  Raises ValueError where it holds something else."""
        return cls(array_in(content))

    def at(self, columns: Array, rows: Array, cutoffs: tuple[float, float]) -> Array:
        """The smooth surface at places counted in points, (0, 0) at the first; arrays that broadcast.

        cutoffs: a wavelength counted in points along x and along y; nothing is lost of waves at least as long, and
        those below half of it are gone (`band_limit.kept_share`).  (0, 0) leaves all.  The surface goes through the
        heights that are left; it is a cubic spline, whose second derivatives are continuous.
        """
        from scipy.ndimage import map_coordinates

        columns, rows = np.broadcast_arrays(columns, rows)
        places = [rows.ravel(), columns.ravel()]
        found = map_coordinates(_spline(self, *cutoffs), places, order=3, mode="reflect", prefilter=False)
        return found.reshape(rows.shape)

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
        along_y, along_x = (
            np.arange(rows)[:, None] * cutoff_y / (2 * rows),
            np.arange(columns) * cutoff_x / (2 * columns),
        )
        kept = idctn(dctn(kept) * kept_share(np.hypot(along_x, along_y)))
    return np.asarray(spline_filter(kept, order=3, mode="reflect"), dtype=np.float64)
