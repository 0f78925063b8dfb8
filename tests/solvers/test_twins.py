"""The 2-D method and its radial twin, which share nothing but the physics, and both against independent numbers."""

from functools import cache
from typing import Any

import pytest
from cases import impact

from ertel.runs.drive import simulate

pytestmark = pytest.mark.usefixtures("nothing_outside")

# reference/impact.json: M, L, Roelands + Dowson-Higginson, values at maximum approach, and its stated accuracy
REFERENCE = {
    200: {"T": 2.4025, "Delta": 0.8682, "P_c": 1.2506, "H_c": 0.15353, "H_min": 0.03999},
    1000: {"T": 2.45, "Delta": 0.9619, "P_c": 1.1938, "H_c": 0.06796, "H_min": 0.00819},
}
ACCURACY = {"T": 0.0015, "Delta": 0.001, "P_c": 0.003, "H_c": 0.003, "H_min": 0.03}


@cache
def at_maximum(M: float, method: str, nodes: int, half_width: float) -> dict[str, Any]:
    case = impact(M, 10, nodes, solver={"method": method, "half_width": half_width})
    maximum: dict[str, Any] = simulate(case).summary["max_approach"]
    return maximum


@pytest.mark.parametrize(
    ("M", "nodes", "radial"),
    [
        (200, 129, 201),
        pytest.param(200, 257, 401, marks=pytest.mark.slow),
        pytest.param(1000, 257, 401, marks=pytest.mark.slow),
    ],
)
def test_the_twins_agree_and_ever_better(M: float, nodes: int, radial: int) -> None:
    twin = at_maximum(M, "radial", radial, 2.0)["H_c"]
    coarse, fine = (abs(at_maximum(M, "2d", n, 2.0)["H_c"] / twin - 1) for n in (nodes // 2 + 1, nodes))
    assert fine < 0.01
    assert fine < 0.6 * coarse


@pytest.mark.parametrize(("nodes", "radial"), [(129, 201), pytest.param(257, 401, marks=pytest.mark.slow)])
def test_the_twins_agree_in_everything(nodes: int, radial: int) -> None:
    """The smallest film, which the grid resolves worst, within its change from half the nodes."""
    half, two = (at_maximum(200, "2d", n, 2.0) for n in (nodes // 2 + 1, nodes))
    one = at_maximum(200, "radial", radial, 2.0)
    for name in ("T", "Delta", "F", "P_c", "H_c"):
        assert two[name] == pytest.approx(one[name], rel=5e-3), name
    assert abs(two["H_min"] - one["H_min"]) < abs(two["H_min"] - half["H_min"]) / 2
    if nodes == 257:  # 3.05 % on 129
        assert two["H_min"] == pytest.approx(one["H_min"], rel=0.03)


@pytest.mark.slow
@pytest.mark.parametrize(("M", "half_width"), [(200, 4.0), (1000, 2.0)])
def test_2d_reference(M: int, half_width: float) -> None:
    """Within the reference's accuracy plus our own error, the change from half the nodes.

    The quick tests reach it through the radial twin, whose reference impacts are in its own tests.
    """
    fine, coarse = (at_maximum(M, "2d", nodes, half_width) for nodes in (257, 129))
    for name, value in REFERENCE[M].items():
        allowed = ACCURACY[name] * value + abs(fine[name] - coarse[name])
        assert abs(fine[name] - value) < allowed, name
