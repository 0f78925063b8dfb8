"""The stencils against plain loops."""

import itertools

import jax.numpy as jnp
import numpy as np
import pytest

from ertel.numerics import stencils
from ertel.numerics.grid import WHOLE, Even
from ertel.numerics.stencils import Pair
from ertel.numerics.symmetry import folded

NODES = 9
FACES = ((0, -1, 0), (0, 1, 0), (-1, 0, 1), (1, 0, 1))  # to a neighbour in Y, in X; which mobility
every_symmetry = pytest.mark.parametrize("even", [WHOLE, Even(y=True), Even(x=True), Even(True, True)], ids=str)


def some_fields(even: Even) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """f and both mobilities on the whole plane, even where asked."""
    fields = np.random.default_rng(5).random((3, NODES, NODES))
    fields = (fields + fields[:, ::-1]) / 2 if even.y else fields
    fields = (fields + fields[:, :, ::-1]) / 2 if even.x else fields
    return fields[0], fields[1], 0.5 * fields[2]


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
def test_diffusion_is_that_of_plain_loops(even: Even, directions: str) -> None:
    f, eps_x, other = some_fields(even)
    eps_y = {"twice as readily along X": eps_x / 2, "independent": other, "equal": eps_x}[directions]
    kept = [jnp.asarray(folded(field, even)) for field in (f, eps_x, eps_y)]
    pair = Pair.of(kept[1], kept[1] if directions == "equal" else kept[2])
    assert (pair.other is None) == (directions == "equal")
    found = stencils.inside(stencils.diffusion(pair, kept[0], even), even)
    np.testing.assert_allclose(found, folded(diffusion_in_loops((eps_x, eps_y), f), even), atol=1e-14)
    faces = stencils.inside(stencils.face_sum(pair, even), even)
    np.testing.assert_allclose(faces, folded(face_sum_in_loops((eps_x, eps_y)), even), atol=1e-14)


@every_symmetry
def test_the_largest_value_around_a_node(even: Even) -> None:
    f, _, _ = some_fields(even)
    around = [f[max(j - 1, 0) : j + 2, max(i - 1, 0) : i + 2].max() for j in range(NODES) for i in range(NODES)]
    found = stencils.largest_around(folded(jnp.asarray(f), even), even)
    np.testing.assert_array_equal(found, folded(jnp.asarray(around).reshape(NODES, NODES), even))
