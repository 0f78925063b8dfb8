import itertools

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from ertel.numerics.grid import (
    LARGEST_COARSEST,
    LEAST,
    SMALLEST_COARSEST,
    Grid,
    Symmetry,
    allowed_nodes,
    check_coarsening,
    check_nodes,
    nodes_across,
    on_grids,
)


@given(st.integers(4, 400), st.floats(0.5, 8.0))
def test_a_square_grid_is_symmetric_to_the_last_bit(half: int, half_width: float) -> None:
    grid = Grid.square(2 * half + 1, half_width)
    assert np.array_equal(grid.x, -grid.x[::-1])
    assert grid.x[half] == 0.0
    assert grid.x[-1] == pytest.approx(half_width, rel=1e-14)


@given(st.integers(4, 16), st.integers(0, 6))
def test_coarser_grids_share_every_second_node(c: int, k: int) -> None:
    grids = Grid.square(c * 2**k + 1, 2.0).hierarchy()
    for fine, coarse in itertools.pairwise(grids):
        np.testing.assert_allclose(coarse.x, fine.x[::2], rtol=0, atol=1e-15)
    assert SMALLEST_COARSEST <= grids[-1].nodes <= LARGEST_COARSEST


def test_allowed_counts_and_advice_for_others() -> None:
    for nodes in (5, 17, 33, 129, 257, 289, 385, 513, 1025):
        check_nodes(nodes)
    for nodes in (-3, 0, 1, 4, 6, 128, 258, 39):
        with pytest.raises(ValueError, match=rf"nodes = {nodes}: .*nearest are"):
            check_nodes(nodes)
    with pytest.raises(ValueError, match="the nearest are 257 and 289"):
        check_nodes(260)
    for at_least, nodes in {1: 5, 100: 105, 129: 129, 129.1: 145, 336.4: 353, 514: 577}.items():
        assert allowed_nodes(at_least) == nodes
        check_nodes(nodes)


@pytest.mark.parametrize(("nodes_x", "nodes_y"), [(257, 129), (65, 33), (33, 129)])
def test_a_rectangle_is_coarsened_alike_in_both_directions(nodes_x: int, nodes_y: int) -> None:
    grid = Grid(nodes_x, nodes_y, 0.1, centre_x=-1.0)
    check_coarsening(grid)
    assert grid.shape == (len(grid.y), len(grid.x)) == (nodes_y, nodes_x)
    for fine, coarse in itertools.pairwise(grid.hierarchy()):
        np.testing.assert_allclose(coarse.x, fine.x[::2], rtol=0, atol=1e-14)
        np.testing.assert_allclose(coarse.y, fine.y[::2], rtol=0, atol=1e-14)


@pytest.mark.parametrize(("nodes_x", "nodes_y", "message"), [(100, 129, "nodes = 100"), (2049, 17, "less different")])
def test_a_rectangle_that_multigrid_cannot_coarsen_is_refused(nodes_x: int, nodes_y: int, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        check_coarsening(Grid(nodes_x, nodes_y, 0.1))


@given(st.sampled_from([33, 65, 129, 161, 257, 641]), st.floats(0.14, 6.7))
@example(161, 25 / 160)  # 29 nodes leave 81 x 15 on the coarsest grid, more than are solved directly
def test_a_side_that_can_be_coarsened_as_often_as_the_other(nodes: int, ratio: float) -> None:
    """A little longer than asked for; the middle is a node; the half grid has the same sides."""
    across = nodes_across(nodes, ratio)
    exact = ratio * (nodes - 1)
    assert -1e-4 <= (across - 1) - exact < max(8, 0.25 * exact) and across % 2 == 1
    grid = Grid(nodes, across, 0.1, even=Symmetry(True, False))
    check_coarsening(grid)
    assert min(grid.hierarchy()[-1].shape) >= 3
    if across > 17 and nodes > 33:
        assert nodes_across((nodes + 1) // 2, (across - 1) / (nodes - 1)) == (across + 1) // 2


def test_values_of_an_irregular_order_have_a_least_error() -> None:
    """Films on a layer of oil, M = 4.08, L = 2.65: 33 and 65 nodes agree by chance; 257 nodes have 0.5120."""
    films = [0.5090, 0.5090, 0.5112]
    _, two, three = on_grids(films, regular=False)
    assert abs(two.extrapolated - 0.5123) < two.error == pytest.approx(LEAST * 0.5090)
    assert abs(three.extrapolated - 0.5123) < three.error == pytest.approx(LEAST / 2 * 0.5112)
    assert [one.error for one in on_grids(films)[1:]] == pytest.approx([0.0, 0.0022 / 3])  # of second order
