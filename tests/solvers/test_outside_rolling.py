"""A steady rolling contact feels the oil outside the grid, so that its film does not depend on the domain."""

import pytest
from cases import march, orders

from ertel.case.case import Case
from ertel.equations import discretise
from ertel.inputs.case_files import parse_case
from ertel.physics.scales import Parameters
from ertel.solvers import guesses, steady
from ertel.solvers.transient import Transient2D


def case_of(nodes: int, M: float, L: float, solver: dict[str, float] | None = None, **contact: float) -> Case:
    contact = {"kind": "rolling", "M": M, "L": L, **contact}
    return parse_case({"contact": contact, "solver": {"nodes": nodes, **(solver or {})}})


def film(nodes: int, half_width: float | None = None, M: float = 10, L: float = 5) -> float:
    s = steady.steady_film(case_of(nodes, M, L, None if half_width is None else {"half_width": half_width})).finest
    assert s.status.ok
    return s.measure()["H_c"]


def test_the_default_inlet_gives_the_film_of_a_long_one() -> None:
    """With P = 0 at its edge it would be 0.9 % thinner."""
    assert film(33, 3.0) == pytest.approx(film(65, 6.0), rel=2e-4)


@pytest.mark.parametrize(("M", "L", "H_c"), [(2, 22, 4.90), (1, 10, 27.3)])
def test_the_default_domain_is_wide_enough_for_a_low_load(M: float, L: float, H_c: float) -> None:
    """Films extrapolated in the grid and in the width of the domain; 65 nodes are 0.7 % below them."""
    assert film(65, M=M, L=L) == pytest.approx(H_c, rel=0.01)


@pytest.mark.parametrize(("M", "L", "half_width"), [(2, 22, 12.0), (5, 2, 6.0)])
def test_a_low_load_has_the_film_of_a_domain_twice_as_wide(M: float, L: float, half_width: float) -> None:
    """On equal spacing.  Where the oil outside ended beside the contact it was 1.6 % and 1.0 % off."""
    assert film(65, half_width, M=M, L=L) == pytest.approx(film(129, 2 * half_width, M=M, L=L), rel=1e-3)


@pytest.mark.slow  # 1 min
def test_a_low_load_that_swings_has_the_film_of_a_domain_twice_as_wide() -> None:
    """Where the oil outside was not squeezed it was 2.2 % off at T = 3."""

    def films(nodes: int, half_width: float) -> list[float]:
        load = {"mean": 1.0, "amplitude": 0.3, "period": 4.0}
        solver = {"nodes": nodes, "half_width": half_width, "method": "transient"}
        case = {"contact": {"kind": "rolling", "M": 5, "L": 2}, "solver": solver, "motion": {"load": load}}
        method = Transient2D(parse_case(case))
        return [method.measure(level)["H_c"] for level in march(method, 0.1, 35)[::5]]

    assert films(33, 3.0) == pytest.approx(films(65, 6.0), rel=5e-3)


def test_the_oil_outside_has_the_approach_of_the_contact() -> None:
    """And not that of the first guess, which left the load outside 0.13 % of the load off on 33 nodes."""
    case = case_of(65, 5, 2)
    for s in steady.steady_film(case).solutions:
        own = discretise.outside_of(case, s.grid).at(guesses.motion_of(case, s.approach))
        assert own.load == pytest.approx(s.outside, abs=1e-4 * case.geometry.hertz_load)


def test_the_film_of_an_ellipse_is_of_second_order_also_beside_much_oil_outside() -> None:
    """On a narrow domain: a third of the load is outside.  Its differences had two signs."""
    case = case_of(129, 10, 2, {"half_width": 3.0, "half_width_y": 3.0}, radius_ratio=0.4)
    solutions = steady.steady_film(case).solutions
    assert [s.grid.nodes for s in solutions] == [33, 65, 129]
    assert solutions[-1].outside > 0.3 * case.geometry.hertz_load
    assert orders([s.measure()["H_c"] for s in solutions])[0] == pytest.approx(2.0, abs=0.35)


@pytest.mark.slow
def test_a_stop_is_the_same_in_both_directions() -> None:
    """The rupture outside stays where the flow left it; it went to the other side where U had been below zero."""

    def films(direction: float) -> list[float]:
        way = [[0.0, direction], [0.5, direction], [1.0, 0.0]]
        solver = {"nodes": 33, "half_width": 3.0, "method": "transient"}
        contact = {"kind": "rolling", "M": 5, "L": 2}
        method = Transient2D(parse_case({"contact": contact, "solver": solver, "motion": {"entrainment": way}}))
        return [method.measure(level)["H_c"] for level in march(method, 0.1, 15)]

    assert films(-1.0) == pytest.approx(films(1.0), rel=1e-6)


# H_c/lambda_bar^2 of a rigid ball in an isoviscous oil: M = 0.3, extrapolated from 257 and 513 nodes.  With oil outside
# that ended beside the contact, 65 nodes on domains of 1, 2 and 4 times the width gave .2132, .2179 and .2205, .2234 in
# the limit, where they give .2234 now.  Brewe, Hamrock and Taylor (1979) have .2218.
RIGID = 0.2249


@pytest.mark.parametrize(("M", "L"), [(0.5, 10), (0.145, 47)])
def test_a_very_low_load_has_the_film_of_a_rigid_ball(M: float, L: float) -> None:
    assert film(65, M=M, L=L) == pytest.approx(RIGID * Parameters.from_moes(M, L).lambda_bar ** 2, rel=0.01)
