"""The extremes of a film lie where they are said to lie, on every kind of grid."""

import jax.numpy as jnp
import numpy as np
import pytest
from cases import OIL, free_ball

from ertel.case.case import Case
from ertel.case.sections import Solver
from ertel.equations.state import State, measure
from ertel.numerics.grid import Grid, Symmetry
from ertel.numerics.stencils import folded
from ertel.physics.scales import Parameters
from ertel.physics.surfaces import Feature, RingWaviness, Spot
from ertel.solvers.transient import Transient2D

x = np.linspace(-2.0, 2.0, 33)
X, Y = x[None, :], x[:, None]
P20 = Parameters.from_moes(20, 5)


def found(case: Case, P: np.ndarray, H: np.ndarray) -> dict[str, float]:
    method = Transient2D(case)
    fields = {name: folded(jnp.asarray(field), method.grid.even) for name, field in {"P": P, "H": H}.items()}
    return method.measure(State(1.0, 0.5, 0.5, fields))


def a_ball(*features: Feature) -> Case:
    return free_ball(P20, OIL, Solver(nodes=33), None, *features)


def dip(at_x: float, at_y: float) -> np.ndarray:
    return 0.1 - 0.05 * np.exp(-10 * ((X - at_x) ** 2 + (Y - at_y) ** 2))


P = np.maximum(1 - (X**2 + Y**2) / 2, 0.0)


@pytest.mark.parametrize(("at_x", "at_y"), [(0.0, 0.625), (0.0, -0.625), (0.375, 0.0), (-0.5, 0.25)])
def test_the_film_over_a_spot_is_thinnest_at_the_spot(at_x: float, at_y: float) -> None:
    values = found(a_ball(Feature(Spot(0.3, 0.1, x=at_x, y=at_y))), P, dip(at_x, at_y))
    assert (values["X_min"], values["Y_min"]) == (at_x, at_y)
    assert (values["X_P_max"], values["Y_P_max"]) == (0.0, 0.0)


@pytest.mark.parametrize("features", [(), (Feature(Spot(0.3, 0.1)),), (Feature(RingWaviness(0.1, 0.5)),)])
def test_an_axisymmetric_film_is_thinnest_on_a_ring(features: tuple[Feature, ...]) -> None:
    H = 0.1 + (np.hypot(X, Y) - 0.625 * 2**0.5) ** 2
    values = found(a_ball(*features), P, H)
    assert values["X_min"] == pytest.approx(0.625 * 2**0.5) and values["Y_min"] == 0.0


def test_of_two_lobes_the_one_at_positive_y_is_named_on_half_and_whole_planes() -> None:
    H = np.minimum(dip(0.25, 0.75), dip(0.25, -0.75))
    H[x < 0] -= 1e-12  # round-off
    for even in (Symmetry(), Symmetry(y=True)):
        grid = Grid(33, 33, 0.125, even=even)
        values = measure(grid, *(folded(jnp.asarray(field), even) for field in (P, H)))
        assert (values["X_min"], values["Y_min"]) == (0.25, 0.75)


def test_a_peak_of_one_node_falls_to_its_neighbours_and_a_smooth_one_does_not() -> None:
    for even in (Symmetry(), Symmetry(True, True)):
        grid = Grid(33, 33, 0.125, even=even)
        needle = np.where((X == 0) & (Y == 0), 3.0, P)
        falls = [measure(grid, *(folded(jnp.asarray(f), even) for f in (p, P)))["P_fall"] for p in (P, needle, 0 * P)]
        assert falls[0] == pytest.approx(0.125**2 / 2, rel=1e-9)
        assert falls[1] == pytest.approx(1 - (1 - 0.125**2 / 2) / 3, rel=1e-9)
        assert falls[2] == 0.0
