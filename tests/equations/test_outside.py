"""The oil outside the grid: its load and deformation, on a square, on a rectangle with an inlet, and on a circle."""

import numpy as np
import pytest

from ertel.equations import outside
from ertel.equations.state import State
from ertel.numerics.grid import Grid, Symmetry
from ertel.physics.far_field import ContactMotion, far_pressure

LAMBDA_BAR = 0.05
APPROACHING, ROLLING = ContactMotion(-0.5, 1.0, 0.0, 0.0), ContactMotion(0.9, 0.0, 1.0, 1.0)


def around(grid: Grid, motion: ContactMotion) -> outside.Surroundings:
    return outside.around_grid(grid, LAMBDA_BAR).at(motion)


def test_load_outside_a_circle_is_that_of_the_closed_form() -> None:
    """P = lambda_bar V/(4 H^2), H = r^2/2 + 1/2: beyond radius w the integral is pi lambda_bar V/(2 H(w))."""
    found = outside.around_circle(np.linspace(0, 3, 9), LAMBDA_BAR).at(APPROACHING)
    assert found.load == pytest.approx(np.pi * LAMBDA_BAR / 2 / 5.0, rel=1e-6)
    assert found.edge[-1] == pytest.approx(LAMBDA_BAR / 4 / 5.0**2) and not found.edge[:-1].any()


@pytest.mark.parametrize("motion", [APPROACHING, ROLLING])
def test_load_outside_a_square_differs_from_that_of_a_circle_by_the_oil_between(motion: ContactMotion) -> None:
    n, w = 800, 3.0
    X, Y = np.meshgrid(*[(np.arange(n) + 0.5) * 2 * w / n - w] * 2)
    between = far_pressure(X, Y, motion, LAMBDA_BAR)[np.hypot(X, Y) > w].sum() * (2 * w / n) ** 2
    X, Y, area = outside.beyond_rectangle(-w, w, -w, w)
    square = area @ far_pressure(X, Y, motion, LAMBDA_BAR)
    theta, u = (np.arange(400) + 0.5) * np.pi / 200, ((np.arange(400) + 0.5) / 400)[:, None]
    P = far_pressure(w / u * np.cos(theta), w / u * np.sin(theta), motion, LAMBDA_BAR)
    circle = (P * w**2 / u**3).sum() * np.pi / 200 / 400
    assert circle - between == pytest.approx(square, rel=2e-3)


def test_a_folded_grid_has_the_same_oil_outside() -> None:
    whole, folded = Grid.square(17, 2.0), Grid(17, 17, 0.25, even=Symmetry(True, True))
    one, other = around(whole, APPROACHING), around(folded, APPROACHING)
    assert (one.load, one.uplift) == (other.load, other.uplift)
    assert np.array_equal(one.edge[8:, 8:], other.edge)
    assert not one.edge[1:-1, 1:-1].any() and (one.edge[0] > 0).all()


@pytest.mark.parametrize("motion", [APPROACHING, ROLLING._replace(velocity=0.2, load_rate=0.1)])
def test_the_change_with_the_speed_of_approach_is_that_of_the_oil_outside(motion: ContactMotion) -> None:
    oil = outside.around_grid(Grid.square(17, 3.0), LAMBDA_BAR)
    change, here, there = oil.change(motion), oil.at(motion), oil.at(motion._replace(velocity=motion.velocity + 0.1))
    for name in ("load", "uplift", "edge"):
        assert getattr(here, name) + 0.1 * getattr(change, name) == pytest.approx(getattr(there, name), rel=1e-9)
    assert change.load > 0 and change.uplift > 0 and not change.edge[1:-1, 1:-1].any()


def test_a_guess_is_zero_near_the_contact() -> None:
    grid = Grid.square(33, 4.0)
    guess = outside.around_grid(grid, LAMBDA_BAR).guess(ROLLING)
    assert guess[16, 16] == 0 and guess[16, 4] > 0 and guess[16, -4] == 0


def test_motion_is_predicted_from_two_levels() -> None:
    """Their loads on the grid and outside it, in units F*."""
    loads = {0.3: 0.5, 0.2: 0.4, -5.0: 9.0}
    levels = [State(T, 2 * T, 1 - T, {}, load=2.0 * load - 0.1, outside=0.1) for T, load in loads.items()]
    motion = outside.predicted(levels, 0.4, 2.0, 0.7)
    assert motion == pytest.approx(ContactMotion(0.8, 0.6, 0.6, 0.7))
    assert outside.predicted(levels[:1], 0.4, 2.0, 0.0) == pytest.approx(ContactMotion(0.6, 0.7, 0.5, 0.0))
