"""The oil far from the contact: its pressure solves Reynolds' equation."""

import numpy as np
import pytest

from ertel.physics.geometry import CIRCLE, SHARE_OF_DEFORMATION, Geometry, far_film, far_pressure, squeeze
from ertel.physics.geometry import ContactMotion as Motion

LAMBDA_BAR = 0.03
X, Y = np.array([-6.0, -4.5, -3.0, -2.5]), np.array([1.0, 3.0, 0.0, 2.0])


def imbalance(motion: Motion, geometry: Geometry = CIRCLE, step: float = 0.02) -> np.ndarray:
    """div(H^3 grad P)/lambda_bar - (U dH/dX - V), by central differences, for the parabolic gap."""

    def pressure(x: np.ndarray, y: np.ndarray) -> np.ndarray:
        return far_pressure(x, y, motion, LAMBDA_BAR, geometry)

    def flux(x: np.ndarray, y: np.ndarray, along: tuple[float, float]) -> np.ndarray:
        dx, dy = (step / 2 * a for a in along)
        slope = (pressure(x + dx, y + dy) - pressure(x - dx, y - dy)) / step
        return far_film(x, y, motion, geometry) ** 3 / LAMBDA_BAR * slope

    half = step / 2
    outflow = flux(X + half, Y, (1, 0)) - flux(X - half, Y, (1, 0)) + flux(X, Y + half, (0, 1))
    outflow -= flux(X, Y - half, (0, 1))
    slope = (geometry.gap(X + half, Y) - geometry.gap(X - half, Y)) / step
    return outflow / step - (motion.entrainment * slope - motion.velocity)


@pytest.mark.parametrize("geometry", [CIRCLE, Geometry(0.4), Geometry(0.4, 30.0), Geometry(2.0, 90.0)])
@pytest.mark.parametrize("motion", [Motion(-0.5, 1.0, 0.0, 0.0), Motion(-0.5, 0.0, 0.0, 1.0), Motion(-1, 0.7, 0, 0.4)])
def test_the_pressure_solves_reynolds_equation_where_nothing_is_deformed(motion: Motion, geometry: Geometry) -> None:
    assert np.abs(imbalance(motion, geometry)).max() < 2e-3


def test_a_rate_that_falls_with_the_distance_counts_more_than_at_its_place() -> None:
    """H = r^2/2, outflow r/2 from a uniform rate and 1 from the rate 1/r: P = lambda_bar integral of outflow/H^3."""
    r = np.geomspace(3.0, 3e4, 40001)
    H = r**2 / 2
    uniform, falling = (np.trapezoid(q / H**3, r) for q in (r / 2, np.ones_like(r)))
    assert falling / (uniform / r[0]) == pytest.approx(SHARE_OF_DEFORMATION, rel=1e-4)


def test_the_deformation_outside_a_dry_contact_grows_as_its_load() -> None:
    """Without viscosity's part: V less the rate is what the film thickness loses, for the load A^3 at Delta = A^2."""
    r, step, approach = np.array([2.0, 5.0]), 1e-5, 0.5

    def film(Delta: float) -> np.ndarray:
        return far_film(r, 0 * r, Motion(Delta, 1.0, Delta**1.5, 0.0))

    lost = 1 + (film(approach + step) - film(approach - step)) / (2 * step)
    weighted = 1 - squeeze(r, Motion(approach, 1.0, 0.0, 0.0))
    assert weighted == pytest.approx(SHARE_OF_DEFORMATION * lost, rel=1e-6)


def test_oil_that_is_drawn_apart_cavitates_and_reversed_entrainment_is_the_mirror_image() -> None:
    assert (far_pressure(X, Y, Motion(0.5, -1.0, 0.5, 0.0), LAMBDA_BAR) == 0).all()
    assert (far_pressure(-X, Y, Motion(0.5, 0.0, 0.5, 1.0), LAMBDA_BAR) == 0).all()
    there, back = Motion(0.5, 0.3, 0.5, 1.0), Motion(0.5, 0.3, 0.5, -1.0)
    one, other = (far_pressure(s * X, Y, m, LAMBDA_BAR) for s, m in ((1, there), (-1, back)))
    assert np.array_equal(one, other)
