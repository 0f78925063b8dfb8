"""The stencils against plain loops."""

import itertools

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from made_up import even_fields, every_symmetry
from numpy.testing import assert_allclose, assert_array_equal

from ertel.numerics import stencils
from ertel.numerics.grid import Grid, Symmetry
from ertel.numerics.stencils import POINTS, Pair, folded

NODES = 9
FACES = ((0, -1, 0), (0, 1, 0), (-1, 0, 1), (1, 0, 1))  # to a neighbour in Y, in X; which mobility


def diffusion_in_loops(eps: tuple[np.ndarray, np.ndarray], f: np.ndarray) -> np.ndarray:
    result = np.zeros_like(f)
    for i, j in itertools.product(range(1, NODES - 1), repeat=2):
        for down, right, which in FACES:
            k, m = i + down, j + right
            result[i, j] += (eps[which][i, j] + eps[which][k, m]) / 2 * (f[k, m] - f[i, j])
    return result


def face_sum_in_loops(eps: tuple[np.ndarray, np.ndarray]) -> np.ndarray:
    result = np.zeros_like(eps[0])
    for i, j in itertools.product(range(1, NODES - 1), repeat=2):
        result[i, j] = sum((eps[which][i, j] + eps[which][i + down, j + right]) / 2 for down, right, which in FACES)
    return result


@every_symmetry
@pytest.mark.parametrize("directions", ["twice as readily along X", "independent", "equal"])
def test_diffusion_is_that_of_plain_loops(even: Symmetry, directions: str) -> None:
    f, eps_x, other = even_fields(even, 3, NODES, NODES)
    eps_y = {"twice as readily along X": eps_x / 2, "independent": other, "equal": eps_x}[directions]
    kept = [folded(field, even) for field in (f, eps_x, eps_y)]
    pair = Pair(kept[1], None if directions == "equal" else kept[2])
    assert (pair.other is None) == (directions == "equal")

    @jax.jit
    def both(pair: Pair, f: jax.Array) -> list[jax.Array]:
        sums = stencils.diffusion(pair, f, even), stencils.face_sum(pair, even)
        return [stencils.inside(each, even) for each in sums]

    found, faces = both(pair, kept[0])
    np.testing.assert_allclose(found, folded(diffusion_in_loops((eps_x, eps_y), f), even), atol=1e-14)
    np.testing.assert_allclose(faces, folded(face_sum_in_loops((eps_x, eps_y)), even), atol=1e-14)


@every_symmetry
def test_the_middle_of_a_grid(even: Symmetry) -> None:
    grid = Grid(17, 9, 0.5, even=even)
    field, middle = grid.kept_x + 10 * grid.kept_y[:, None], grid.middle()
    assert (middle.x[-1], middle.y[-1]) == (2.0, 1.0)
    assert_array_equal(field[stencils.middle(field.shape, even)], middle.kept_x + 10 * middle.kept_y[:, None])


@every_symmetry
def test_the_largest_value_around_a_node(even: Symmetry) -> None:
    f = even_fields(even, NODES, NODES)
    around = [f[max(j - 1, 0) : j + 2, max(i - 1, 0) : i + 2].max() for j in range(NODES) for i in range(NODES)]
    found = jax.jit(lambda f: stencils.largest_around(f, even))(folded(f, even))
    np.testing.assert_array_equal(found, folded(np.array(around).reshape(NODES, NODES), even))


# -- shifts along X ---------------------------------------------------------------------------------------------------


shifted = jax.jit(lambda field, nodes: stencils.carried_along_x(field, nodes)[0])

LINE = np.arange(65.0)
MIDDLE = slice(24, 41)  # far enough from the ends


@given(st.integers(-20, 20), st.integers(0, 10**6))
def test_a_shift_by_whole_nodes_is_exact(shift: int, seed: int) -> None:
    field = np.random.default_rng(seed).random((3, 65))
    moved = np.asarray(shifted(jnp.asarray(field), float(shift)))
    assert_array_equal(moved, field[:, np.clip(np.arange(65) - shift, 0, 64)])


@given(st.floats(-15.0, 15.0))
def test_polynomials_are_carried_exactly(shift: float) -> None:
    def polynomial(x: np.ndarray) -> np.ndarray:
        t = (x - 32) / 16
        return 1 + t - 2 * t**3 + t ** (POINTS - 1)

    moved = np.asarray(shifted(jnp.asarray(polynomial(LINE))[None], shift))[0]
    assert_allclose(moved[MIDDLE], polynomial(LINE - shift)[MIDDLE], atol=1e-11)


@given(st.floats(-9.0, 9.0), st.integers(0, 10**6))
def test_both_directions_are_treated_alike(shift: float, seed: int) -> None:
    field = jnp.asarray(np.random.default_rng(seed).random((2, 65)))
    assert_allclose(shifted(field[:, ::-1], -shift)[:, ::-1], shifted(field, shift), atol=1e-13)


def test_beyond_its_ends_the_field_keeps_the_value_of_the_end() -> None:
    field = jnp.asarray(np.linspace(2.0, 3.0, 65))[None]
    assert_allclose(shifted(field, 100.0), 2.0)
    assert_allclose(shifted(field, -100.0), 3.0)


carried = jax.jit(stencils.carried_along_x)


@given(st.floats(-9.0, 9.0), st.integers(0, 10**6))
def test_the_flux_form_is_the_shift_where_all_is_smooth(shift: float, seed: int) -> None:
    field = jnp.asarray(np.random.default_rng(seed).random((2, 65)))
    found, expected = carried(field, shift, field >= 0)[0], shifted(field, shift)
    assert_allclose(found[:, MIDDLE], expected[:, MIDDLE], atol=2e-15)


@given(st.floats(-9.0, 9.0), st.integers(0, 10**6))
def test_what_leaves_a_cell_has_passed_its_faces(shift: float, seed: int) -> None:
    """In a full gap but for the nodes whose oil comes from beyond the ends.  A uniform field passes by its shift."""
    random = np.random.default_rng(seed)
    field, some = random.random((2, 65)), random.random((2, 65)) < 0.9
    for smooth, cells in ((some, LINE >= 0), (None, (shift <= LINE) & (LINE < 64 + shift))):
        moved, passed = carried(field, shift, smooth)
        assert_allclose((field - moved)[:, cells], np.diff(passed, axis=1)[:, cells], atol=1e-13)
        assert_allclose(carried(np.full((2, 65), 0.7), shift, smooth)[1], 0.7 * shift, atol=1e-12)


@given(st.floats(-9.0, 9.0), st.integers(0, 10**6))
def test_the_flux_form_keeps_the_sum_and_is_monotone_where_nothing_is_smooth(shift: float, seed: int) -> None:
    random = np.random.default_rng(seed)
    heap = np.zeros((2, 65))
    heap[:, MIDDLE] = random.random((2, 17))
    partly, _ = carried(jnp.asarray(heap), shift, random.random((2, 65)) < 0.9)
    assert_allclose(np.asarray(partly).sum(axis=1), heap.sum(axis=1), rtol=1e-13)
    step = np.where(LINE < 32, 0.05, 0.005)[None]
    moved = np.asarray(carried(jnp.asarray(step), shift, np.zeros((1, 65), bool))[0])[0]
    assert np.all(np.diff(moved) <= 1e-16) and moved.max() <= 0.05 + 1e-16 and moved.min() >= 0.005 - 1e-16


@given(st.floats(0.0, 1.0), st.floats(0.0, np.pi))
def test_no_wave_grows(shift: float, per_node: float) -> None:
    """So that no number of steps makes it unstable."""
    wave = np.stack([np.cos(per_node * LINE), np.sin(per_node * LINE)])
    found = np.asarray(shifted(jnp.asarray(wave), shift))[:, MIDDLE]
    assert np.hypot(*found).max() <= 1 + 1e-12


@pytest.mark.parametrize("step", [0.1, 0.3, 0.5, 0.8])
def test_a_wave_of_eight_nodes_loses_less_than_half_a_percent_per_wavelength(step: float) -> None:
    wave = np.stack([np.cos(np.pi / 4 * LINE), np.sin(np.pi / 4 * LINE)])
    kept = np.hypot(*np.asarray(shifted(jnp.asarray(wave), step))[:, MIDDLE]).mean()
    assert 1 - kept ** (8 / step) < 0.005


@pytest.mark.parametrize("even", [Symmetry(False, False), Symmetry(True, False), Symmetry(True, True)], ids=str)
def test_slopes_of_a_parabola_are_exact_up_to_the_edge(even: Symmetry) -> None:
    """Also where the field does not vanish there; about an axis the parabola is even."""
    X, Y = np.meshgrid(*[0.25 * np.arange(-4, 5)] * 2)
    tilt_x, tilt_y = (0.0 if mirror else 0.7 for mirror in (even.x, even.y))
    f = 3.0 + X**2 - 2.0 * Y**2 + tilt_x * X + tilt_y * Y
    found = jax.jit(stencils.node_slopes, static_argnums=2)(folded(f, even), 0.25, even)
    for slope, expected in zip(found, (2.0 * X + tilt_x, tilt_y - 4.0 * Y), strict=True):
        assert_allclose(slope, folded(expected, even), atol=1e-12)
