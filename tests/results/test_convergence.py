"""The limit of a number on fine grids: exact where the order is seen, and an error that holds where it is not."""

from math import isnan

import numpy as np
import pytest

from ertel.results.convergence import limit

# H_c and H_min of steady contacts, exact solutions of one discretisation on 65 to 513 nodes, and their limits: a
# classical multigrid program and a dense Newton code, see tests/solvers/test_steady.py
FILMS = {
    "M 20, L 10, H_c": ([0.4818634, 0.49356106, 0.49652168, 0.49726678], 0.49752, 5.2e-5),
    "M 20, L 10, H_min": ([0.29876257, 0.30515754, 0.30629817, 0.30655028], 0.306632, 9.3e-5),
    "M 50, L 5, H_c": ([0.16465561, 0.17598937, 0.17884717, 0.17956175], 0.179797, 1.1e-5),
    "M 50, L 5, H_min": ([0.08936727, 0.09366737, 0.09492248, 0.0952233], 0.095325, 2.8e-5),
}


@pytest.mark.parametrize("grids", [3, 4])
@pytest.mark.parametrize("case", FILMS)
def test_the_error_holds_the_truth_of_a_reference(case: str, grids: int) -> None:
    values, truth, uncertainty = FILMS[case]
    found = limit(values[:grids])
    assert found.seen and 1.5 < found.order < 2.5
    assert abs(found.value - truth) < found.error + uncertainty
    assert found.error < abs(values[grids - 1] - values[grids - 2]) / 2  # and is no wider than it must


@pytest.mark.parametrize("order", [0.7, 1.0, 1.6, 2.0, 2.4, 3.0, 4.0])
def test_the_error_holds_the_truth_of_other_orders(order: float) -> None:
    values = [1.0 + 0.1 * 2.0 ** (-order * number) for number in range(4)]
    found = limit(values)
    assert found.order == pytest.approx(order)
    assert abs(found.value - 1.0) <= found.error * (1 + 1e-9)
    assert found.seen == (1.5 <= order <= 2.5)
    if order == 2.0:
        assert found.value == pytest.approx(1.0, abs=1e-12)
    if order < 1.5:
        assert found.value == values[-1]  # nothing is extrapolated


@pytest.mark.parametrize(
    ("values", "width"),
    [
        ([1.0, 0.4, 0.7, 0.55], 0.6),  # to and fro, about 0.6: all that the grids differ
        ([1.43, 1.78, 2.48], 3 * 1.05),  # a spike that every grid makes higher
        ([0.7, 0.9, 0.3], 3 * 0.6),
        ([0.5, 0.5, 0.5], 0.0),
    ],
)
def test_without_an_order_the_error_is_wide(values: list[float], width: float) -> None:
    found = limit(values)
    assert not found.seen and found.value == values[-1]
    assert found.error == pytest.approx(width)
    assert isnan(found.order) or found.order < 0.5


def test_noise_that_hides_the_order_widens_the_error() -> None:
    """A last difference that is small by chance does not make the error small."""
    steady = limit([1.4, 1.1, 1.025])
    lucky = limit([1.4, 1.1, 1.0999])
    assert steady.seen and not lucky.seen
    assert lucky.error == pytest.approx(np.abs(1.1 - 1.4) / 12)
