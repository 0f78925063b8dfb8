"""A steady rolling contact feels the oil outside the grid, so that its film does not depend on the domain."""

import pytest

from ertel.inputs.case_files import parse_case
from ertel.physics.scales import Parameters
from ertel.solvers import steady


def film(nodes: int, half_width: float | None = None, M: float = 10, L: float = 5) -> float:
    contact = {"kind": "rolling", "M": M, "L": L}
    solver = {"nodes": nodes} if half_width is None else {"nodes": nodes, "half_width": half_width}
    s = steady.steady_film(parse_case({"contact": contact, "solver": solver})).finest
    assert s.status.ok
    return s.measure()["H_c"]


def test_the_default_inlet_gives_the_film_of_a_long_one() -> None:
    """With P = 0 at its edge it would be 0.9 % thinner."""
    assert film(33, 3.0) == pytest.approx(film(65, 6.0), rel=2e-4)


@pytest.mark.parametrize(("M", "L", "H_c"), [(2, 22, 4.85), (1, 10, 26.7)])
def test_the_default_domain_is_wide_enough_for_a_low_load(M: float, L: float, H_c: float) -> None:
    """Films on domains two and four times as wide, extrapolated."""
    assert film(65, M=M, L=L) == pytest.approx(H_c, rel=0.04)


RIGID = 0.2164  # H_c/lambda_bar^2 of a rigid ball in an isoviscous oil: a polar grid of its own, extrapolated


@pytest.mark.parametrize(("M", "L"), [(0.5, 10), (0.145, 47)])
def test_a_very_low_load_has_the_film_of_a_rigid_ball(M: float, L: float) -> None:
    assert film(65, M=M, L=L) == pytest.approx(RIGID * Parameters.from_moes(M, L).lambda_bar ** 2, rel=0.03)
