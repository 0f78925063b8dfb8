"""Elastic half space: the displacement of its surface, and waves below it.  The only module with FFTs.

On a grid of one row nothing changes along Y: the half space is a half plane, and the kernel a logarithm.

The pressure is constant on the cell around each node and zero on the edge nodes of the grid.  Love's closed form gives
the displacement that one cell causes; a convolution sums over all cells: each wave of the pressure is multiplied by its
displacement.  Because the pressure is zero on the edge, a period of 2 (nodes - 1) in each direction is enough to
separate the periodic images, and FFTs of that length are fast.  On small grids products with the matrices of the same
cosines and sines are faster: few operations, each of which a device does at its full speed.

Below the surface each wave of a load decays by itself (`physics.stress`): `Waves` takes fields apart and puts them
together again, on periods that are longer, because the images cannot be cut off there.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property, lru_cache, partial
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array, lax, tree
from jax.tree_util import register_dataclass
from numpy.typing import NDArray

from ertel.numerics.grid import Grid, Symmetry
from ertel.numerics.programs import require_double


def love_coefficients(rows: int, columns: int, spacing: float) -> NDArray[np.float64]:
    """Integral of 1/distance over a cell, for a node [i, j] cells away from it: shape (rows, columns).

    Source: Love AEH, Phil Trans R Soc A 1929;228:377.
    """
    # far from the cell these are differences of large numbers: extended precision keeps them exact to double
    corner = np.arange(max(rows, columns) + 1, dtype=np.longdouble) - 0.5
    x, y = corner[None, : columns + 1], corner[: rows + 1, None]
    antiderivative = x * np.arcsinh(y / np.abs(x)) + y * np.arcsinh(x / np.abs(y))
    cell = np.diff(np.diff(antiderivative, axis=0), axis=1)
    return np.asarray(cell * spacing, dtype=np.float64)


def line_coefficients(columns: int, spacing: float, reach: float) -> NDArray[np.float64]:
    """Integral of ln(reach/distance) over a cell, for a node j cells away from it: shape (1, columns).

    reach: the distance at which the displacement by a line load is zero.
    """
    beyond = np.arange(columns, dtype=np.longdouble) + 0.5  # the far end of the cell; the near one is one less
    near = beyond - 1.0
    logarithm = 1.0 + np.log(reach / np.longdouble(spacing)) - beyond * np.log(beyond) + near * np.log(np.abs(near))
    return np.asarray(logarithm * spacing, dtype=np.float64)[None]


GRIDS = 16  # whose spectra are kept: a grid and all its coarser ones, in turns, on which one of them may be costly


@lru_cache(maxsize=GRIDS)
def _unit_spectrum(rows: int, columns: int) -> NDArray[np.float64]:
    """Fourier transform of the coefficients for unit spacing, shape (rows, columns).

    The kernel is even, and so is its transform, which is real.
    """
    along_x = np.fft.rfft(love_coefficients(rows, columns, 1.0)[:, _distances(columns)]).real
    return np.fft.rfft(along_x[_distances(rows)], axis=0).real


@lru_cache(maxsize=GRIDS)
def _line_spectrum(columns: int, spacing: float, reach: float) -> NDArray[np.float64]:
    """The same of the coefficients on a line."""
    return np.fft.rfft(line_coefficients(columns, spacing, reach)[:, _distances(columns)]).real


def _distances(nodes: int) -> NDArray[np.int64]:
    """Distance from the first node to each node of a period, the shorter way round; one row is its own period."""
    period = max(2 * (nodes - 1), 1)
    return np.minimum(np.arange(period), period - np.arange(period))


# The nodes a side up to which convolutions are products, by the kind of device, for fields even in X and in Y; half as
# many for each axis about which they are not.  On a CPU they are then equally fast or faster (measured on one core).
# For other devices the bound is computed and not measured: 24 n^3 operations for n kept nodes a side, at 50 Tflop/s
PRODUCTS, PRODUCTS_ELSEWHERE = {"cpu": 65}, 1025


@dataclass(frozen=True)
class Kernel:
    """The half space on a grid, for fields that are even about these axes and stored on one side.

    spectrum: the displacement by each wave of the pressure, real.
    """

    spectrum: Array
    even: Symmetry = field(metadata={"static": True})

    def displacement(self, P: Array) -> Array:
        """Normal displacement under the pressure P, both on the same nodes; P = 0 on the edge.

        A complex P takes two convolutions.
        """
        if jnp.iscomplexobj(P):
            return lax.complex(self.convolved(P.real), self.convolved(P.imag))
        return self.convolved(P)

    def convolved(self, P: Array) -> Array:
        """The displacement under a real pressure."""
        raise NotImplementedError

    def alternating(self) -> tuple[Array, Array]:
        """The displacement by pressures of one that alternate from node to node, along X and along both axes."""
        return self.spectrum[0, -1], self.spectrum[-1, -1]


@register_dataclass
@dataclass(frozen=True)
class TransformKernel(Kernel):
    """Convolution by FFT.  The spectrum has the shape (2 (n_y - 1), n_x), or (n_y, n_x) for fields even in X or Y."""

    def convolved(self, P: Array) -> Array:
        return _by_transforms(self.spectrum, P, self.even)

    def alternating(self) -> tuple[Array, Array]:
        shortest = -1 if any(self.even) else self.spectrum.shape[0] // 2
        return self.spectrum[0, -1], self.spectrum[shortest, -1]


@register_dataclass
@dataclass(frozen=True)
class ProductKernel(Kernel):
    """Convolution by products of matrices: to the waves along Y and along X, and back to the nodes."""

    to_waves: tuple[Array, Array]
    to_nodes: tuple[Array, Array]

    def convolved(self, P: Array) -> Array:
        return _by_products(self.spectrum, self.to_waves, self.to_nodes, P)


def kernel(grid: Grid, compliance: float = 1.0, dtype: str = "float64", reach: float = 1.0) -> Kernel:
    """The half space on a grid, by products where they are faster on the device that JAX computes on.

    compliance: the displacement is this factor times the double integral of P/distance; on a grid of one row, times
    the integral of P ln(reach/distance).
    """
    require_double()  # differences of large numbers
    if grid.nodes_y == 1:
        whole = _line_spectrum(grid.nodes_x, grid.spacing, reach) * compliance
    else:
        whole = _unit_spectrum(grid.nodes_y, grid.nodes_x) * (compliance * grid.spacing)
    put = partial(tree.map, lambda values: jax.device_put(values.astype(dtype)))  # which has nothing to compile
    whole_axes = 2 - sum(grid.even)
    most = PRODUCTS.get(jax.default_backend(), PRODUCTS_ELSEWHERE)
    if max(grid.nodes_x, grid.nodes_y) - 1 > (most - 1) >> whole_axes:
        return TransformKernel(put(whole if any(grid.even) else whole[_distances(grid.nodes_y)]), grid.even)
    along_y, along_x = (_waves(*axis) for axis in zip((grid.nodes_y, grid.nodes_x), grid.even, strict=True))
    spectrum = whole[np.ix_(along_y.numbers, along_x.numbers)]
    to_waves, to_nodes = (along_y.to_waves, along_x.to_waves.T), (along_y.to_nodes, along_x.to_nodes.T)
    return ProductKernel(put(spectrum), grid.even, put(to_waves), put(to_nodes))


class _Waves(NamedTuple):
    """The waves of a period along one axis: their numbers, and the matrices to them and back to the nodes."""

    numbers: NDArray[np.int64]
    to_waves: NDArray[np.float64]
    to_nodes: NDArray[np.float64]


@lru_cache(maxsize=32)
def _waves(nodes: int, even: bool) -> _Waves:
    """The waves for so many nodes of the whole plane: cosines, and between them sines where fields are not even."""
    if nodes == 1:
        return _Waves(np.zeros(1, int), np.ones((1, 1)), np.ones((1, 1)))
    period, last = 2 * (nodes - 1), nodes - 1
    numbers = np.arange(nodes) if even else (np.arange(period) + 1) // 2
    places = np.arange((nodes + 1) // 2 if even else nodes)
    is_sine = False if even else (np.arange(period) % 2 == 0) & (numbers > 0)
    angles = 2.0 * np.pi / period * (np.outer(numbers, places) % period) - np.pi / 2 * np.expand_dims(is_sine, -1)
    waves = np.cos(angles)
    # each wave stands for two, except the first and the last; so does each node where fields are even
    twice = np.where(np.isin(numbers, (0, last)), 1.0, 2.0) / period
    mirrored = np.where(np.isin(places, (0, last)) | (not even), 1.0, 2.0)
    return _Waves(numbers, waves * mirrored, (waves * twice[:, None]).T)


@jax.jit  # one tracing for each shape
def _by_products(spectrum: Array, to_waves: tuple[Array, Array], to_nodes: tuple[Array, Array], P: Array) -> Array:
    product = partial(jnp.linalg.multi_dot, precision=lax.Precision.HIGHEST)  # a GPU would round to ten bits
    return product([to_nodes[0], spectrum * product([to_waves[0], P, to_waves[1]]), to_nodes[1]])


@partial(jax.jit, static_argnames="even")  # one tracing for each shape
def _by_transforms(spectrum: Array, P: Array, even: Symmetry) -> Array:
    """Only rows with data are transformed along X, and only rows of the result are transformed back.

    Where fields are even, the transform is a cosine transform and real: it comes first, so that the other one has real
    data too.
    """
    if P.shape[0] == 1:
        return _along_one_row(spectrum, P, even)
    if even.y and not even.x:
        return _by_transforms(spectrum.T, P.T, Symmetry(x=True)).T
    period_x = 2 * (spectrum.shape[1] - 1)
    period_y = 2 * (spectrum.shape[0] - 1) if even.x else spectrum.shape[0]
    rows, columns = P.shape
    if not even.x:
        along = jnp.fft.rfft(P, n=period_x, axis=1)
        rows_back = jnp.fft.ifft(jnp.fft.fft(along, n=period_y, axis=0) * spectrum, axis=0)[:rows]
        return jnp.fft.irfft(rows_back, n=period_x, axis=1)[:, :columns]
    across = _cosines(P, period_x).T
    if even.y:
        back = _cosines(_cosines(across, period_y) * spectrum.T, period_y) / period_y
    else:
        back = jnp.fft.irfft(jnp.fft.rfft(across, n=period_y, axis=1) * spectrum.T, n=period_y, axis=1)
    return _cosines(back[:, :rows].T, period_x)[:, :columns] / period_x


def _along_one_row(spectrum: Array, P: Array, even: Symmetry) -> Array:
    period, columns = 2 * (spectrum.shape[1] - 1), P.shape[1]
    if even.x:
        return _cosines(_cosines(P, period) * spectrum, period)[:, :columns] / period
    return jnp.fft.irfft(jnp.fft.rfft(P, n=period, axis=1) * spectrum, n=period, axis=1)[:, :columns]


def _cosines(half: Array, period: int) -> Array:
    """Fourier transform along the last axis of even sequences, stored for one side: real, frequencies 0 to period/2."""
    last, nodes = period // 2, half.shape[1]
    # each entry occurs twice in a period, except the first and the last
    twice = np.where(np.isin(np.arange(nodes), (0, last)), 1.0, 2.0).astype(half.dtype)
    return jnp.fft.rfft(half * twice, n=period, axis=1).real


# -- below the surface -------------------------------------------------------------------------------------------------

PADDING, MOST_PADDING, PADDING_OF_A_ROW = 4, 8, 64  # periods over the sides of the grid
DEEPEST_WAVE = 16.0  # k times depth, from which a wave is left out: it has fallen by e^-16
ODD_SIZES = sorted(3**i * 5**j * 7**k for i in range(13) for j in range(9) for k in range(8))  # of fast transforms


@dataclass(frozen=True)
class Waves:
    """Fields at the nodes of a rectangle as sums of plane waves exp(i k.x), padded with zeros.

    rows, columns: nodes along Y and X; one row is a field that does not change along Y.

    The periods are 4 times the sides; that along the shorter side is as long as the other one, at most 8 times the side
    (of one row 64 times).  In the stresses by a Hertz pressure the periodic images are then less than 0.001 p_h, on
    the grids of ellipses up to 1 : 10.  A period has an odd number of nodes, so that every wave has a direction.
    """

    rows: int
    columns: int
    spacing: float

    @cached_property
    def periods(self) -> tuple[int, int]:
        """The nodes of a period along Y and X."""
        sides = self.rows, self.columns
        lengths = [min(max(PADDING * max(sides), PADDING * n), MOST_PADDING * n) for n in sides]
        lengths = [1, PADDING_OF_A_ROW * self.columns] if self.rows == 1 else lengths
        across, along = (next(size for size in ODD_SIZES if size >= length) for length in lengths)
        return across, along

    def amplitudes(self, field: NDArray[np.float64]) -> NDArray[np.complex128]:
        """The amplitudes of the waves of a field."""
        return np.fft.rfft2(field, self.periods)

    def below(
        self, depth: float, law: Callable[..., Sequence[Any]], loads: Sequence[Any], row: int | None = None
    ) -> list[NDArray[np.float64]]:
        """The fields at the nodes at a depth; of one row where it is given, which costs a tenth.

        law: of the wave numbers along X (1, m) and Y (n, 1), the depth and the amplitudes of the loads at the surface:
        the amplitudes of the fields.  loads: from `amplitudes`; 0 for none.
        """
        across, along = self.periods
        k_x = 2.0 * np.pi * np.fft.rfftfreq(along, self.spacing)
        k_y = 2.0 * np.pi * np.fft.fftfreq(across, self.spacing)
        most = DEEPEST_WAVE / depth if depth > 0.0 else np.inf
        kept = np.ix_(np.abs(k_y) <= most, k_x <= most)
        fields = []
        for each in law(
            (k_x[kept[1]], k_y[kept[0]]), depth, *(load[kept] if np.ndim(load) else load for load in loads)
        ):
            if row is None:
                waves = np.zeros((across, each.shape[1]), dtype=complex)
                waves[kept[0][:, 0]] = each
                lines = np.fft.ifft(waves, axis=0)[: self.rows]
            else:
                lines = np.exp(1j * row * self.spacing * k_y[kept[0]]).T / across @ each
            fields.append(np.fft.irfft(lines, along, axis=1)[:, : self.columns])
        return fields
