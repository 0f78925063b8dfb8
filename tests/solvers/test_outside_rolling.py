"""A steady rolling contact feels the oil outside the grid, so that its film does not depend on the domain."""

import pytest

from ertel.inputs.case_files import parse_case
from ertel.solvers import steady


def film(nodes: int, half_width: float) -> float:
    contact, solver = {"kind": "rolling", "M": 10, "L": 5}, {"nodes": nodes, "half_width": half_width}
    return steady.steady(parse_case({"contact": contact, "solver": solver})).finest.measure()["H_c"]


def test_the_default_inlet_gives_the_film_of_a_long_one() -> None:
    """With P = 0 at its edge it would be 0.9 % thinner."""
    assert film(65, 3.0) == pytest.approx(film(129, 6.0), rel=2e-4)
