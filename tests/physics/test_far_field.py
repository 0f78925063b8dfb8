"""The oil far from the contact: its pressure solves Reynolds' equation."""

from collections.abc import Callable

import numpy as np
import pytest
from scipy.optimize import brentq

from ertel.physics.far_field import ContactMotion as Motion
from ertel.physics.far_field import far_film, far_pressure, squeeze
from ertel.physics.geometry import CIRCLE, SHARE_OF_DEFORMATION, Geometry
from ertel.physics.rupture import rupture

LAMBDA_BAR = 0.03
X, Y = np.array([-6.0, -4.5, -3.0, -2.5]), np.array([1.0, 3.0, 0.0, 2.0])


GEOMETRIES = [CIRCLE, Geometry(0.4), Geometry(0.4, 30.0), Geometry(2.0, 90.0)]
Field = Callable[[np.ndarray, np.ndarray], np.ndarray]


def imbalance(
    pressure: Field, x: np.ndarray, y: np.ndarray, motion: Motion, geometry: Geometry, step: float = 0.02
) -> np.ndarray:
    """div(H^3 grad P)/lambda_bar - (U dH/dX - V), by central differences, for the parabolic gap."""
    half = step / 2

    def flux(x: np.ndarray, y: np.ndarray, along: tuple[float, float]) -> np.ndarray:
        dx, dy = (step / 2 * a for a in along)
        slope = (pressure(x + dx, y + dy) - pressure(x - dx, y - dy)) / step
        return far_film(x, y, motion, geometry) ** 3 / LAMBDA_BAR * slope

    outflow = flux(x + half, y, (1, 0)) - flux(x - half, y, (1, 0)) + flux(x, y + half, (0, 1))
    outflow -= flux(x, y - half, (0, 1))
    slope = (geometry.gap(x + half, y) - geometry.gap(x - half, y)) / step
    return outflow / step - (motion.entrainment * slope - motion.velocity)


@pytest.mark.parametrize("geometry", GEOMETRIES)
@pytest.mark.parametrize("motion", [Motion(-0.5, 1.0, 0.0, 0.0), Motion(-0.5, 0.0, 0.0, 1.0), Motion(-1, 0.7, 0, 0.4)])
def test_a_full_gap_solves_reynolds_equation_where_nothing_is_deformed(motion: Motion, geometry: Geometry) -> None:
    def pressure(x: np.ndarray, y: np.ndarray) -> np.ndarray:
        flow = geometry.far_flow(motion.velocity, motion.entrainment, x, y)
        return LAMBDA_BAR * flow / far_film(x, y, motion, geometry) ** 2

    assert np.abs(imbalance(pressure, X, Y, motion, geometry)).max() < 2e-3


@pytest.mark.parametrize("geometry", GEOMETRIES)
def test_a_parabola_that_grows_sucks_as_bodies_that_part(geometry: Geometry) -> None:
    """div(H^3 grad P)/lambda_bar = dH/dT for H = c G with dc/dT = 1, as the speed of each place says."""

    def pressure(x: np.ndarray, y: np.ndarray) -> np.ndarray:
        apart = geometry.far_flow(-1.0, 0.0, x, y) * geometry.bent(x, y)
        return LAMBDA_BAR * apart / geometry.gap(x, y) ** 2

    still = imbalance(pressure, X, Y, Motion(0.0, 0.0, 0.0, 0.0), geometry)
    np.testing.assert_allclose(still, geometry.gap(X, Y), rtol=1e-3)


def test_the_oil_around_a_gap_of_another_curvature() -> None:
    """It is that of a contact in which all of the gap is c times as large, at lambda_bar c^-2; and it grows as said."""
    c, motion = 2.0, Motion(0.5, 0.1, 0.8, 1.0, load_rate=0.2)
    bent = Motion(c * 0.5, c * 0.1, c * 0.8, 1.0, c * 0.2, curvature=c)
    P = far_pressure(X, Y, motion, LAMBDA_BAR)
    np.testing.assert_allclose(far_pressure(X, Y, bent, c**2 * LAMBDA_BAR), P, rtol=1e-12)
    less, more = (far_pressure(X, Y, motion._replace(bending=rate), LAMBDA_BAR) for rate in (0.02, -0.02))
    assert (less < P).all() and (P < more).all()


# -- the rupture ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("velocity", [0.0, 0.4])
@pytest.mark.parametrize("geometry", GEOMETRIES)
def test_a_ruptured_film_solves_reynolds_equation(geometry: Geometry, velocity: float) -> None:
    """In front of the contact and beside it, downstream of its middle, where a film that ends at X = 0 has no pressure.

    The steps of the differences are long, because the table is linear between its angles; dH/dX is 3.
    """
    motion = Motion(-0.1, velocity, 0.0, 1.0, load_rate=0.0)
    x, y = np.array([-6.0, -3.0, 0.2, 0.5, 0.0]), np.array([1.0, 0.5, 3.0, 4.5, 3.5])

    def pressure(x: np.ndarray, y: np.ndarray) -> np.ndarray:
        return far_pressure(x, y, motion, LAMBDA_BAR, geometry)

    assert (pressure(x, y) > 0).all()
    assert np.abs(imbalance(pressure, x, y, motion, geometry, 0.2)).max() < 0.02


@pytest.mark.parametrize("s", [-1.0, -0.5, 0.0, 0.5, 0.9])
def test_the_rupture_of_a_circle_is_the_closed_form(s: float) -> None:
    """s = 5 V/(4 U r); F = s + cos(phi) + A cosh(3 phi) from the direction upstream, F = F' = 0 at its end.

    The term in k = C/r^2 is A (5 k cosh(3 phi_c) cosh(5^(1/2) phi)/cosh(5^(1/2) phi_c) - 5 k cosh(3 phi)).
    """
    end = brentq(lambda phi: s + np.cos(phi) + np.sin(phi) / (3 * np.tanh(3 * phi)), 1e-6, np.pi - 1e-9)
    A, phi = np.sin(end) / (3 * np.sinh(3 * end)), np.linspace(0.0, np.pi, 181)
    wet, r, root = phi < end, 3.0, 5**0.5
    if s == 0.0:
        assert (np.degrees(end), A) == (pytest.approx(108.435, abs=1e-3), pytest.approx(0.002164, abs=1e-6))
    x, y, V = -r * np.cos(phi), r * np.sin(phi), np.full_like(phi, 0.8 * s * r)
    found = CIRCLE.ruptured_flow(V, 1.0, x, y, np.zeros_like(phi)) * 5 / r
    within = 5e-4 if s % 0.5 else 5e-6  # between the speeds of the table
    assert found == pytest.approx(np.where(wet, s + np.cos(phi) + A * np.cosh(3 * phi), 0.0), abs=5 * within)
    k = 0.05
    in_k = (CIRCLE.ruptured_flow(V, 1.0, x, y, np.full_like(phi, k * r**2)) * 5 / r - found) / k
    beside = np.cosh(3 * end) * np.cosh(root * phi) / np.cosh(root * end)
    expected = np.where(wet, 5 * A * (beside - np.cosh(3 * phi)), 0.0)
    inner = np.abs(phi - end) > 0.02
    assert in_k[inner] == pytest.approx(expected[inner], abs=5e-3 if s % 0.5 == 0 else 2e-2)


def around(V: float, entrainment: float = 1.0, held: bool = True, geometry: Geometry = CIRCLE) -> np.ndarray:
    """f at all angles from the direction upstream, at r = 3, without a constant of the gap."""
    phi = np.linspace(0.0, np.pi, 181)
    return geometry.ruptured_flow(0 * phi + V, entrainment, -3 * np.cos(phi), 3 * np.sin(phi), 0 * phi, held)


def test_a_small_speed_of_approach_adds_the_closed_form_where_there_is_oil() -> None:
    phi, root, end = np.linspace(0.0, np.pi, 181), 8**0.5, np.radians(108.435)
    wet = phi < end
    expected = np.where(wet, 0.3 / 4 * (1 - np.cosh(root * phi) / np.cosh(root * end)), 0.0)
    assert around(0.3) - around(0.0) == pytest.approx(expected, abs=5e-4)  # the angles are half a degree apart
    assert around(0.3, entrainment=0.0) == pytest.approx(expected, abs=5e-4)  # as after U > 0
    assert around(0.3, entrainment=-1.0)[::-1] == pytest.approx(around(0.3), abs=1e-9)
    drawn_apart = around(-0.3)
    assert np.array_equal(drawn_apart > 1e-12, wet) and (drawn_apart <= around(0.0)).all()


@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize("geometry", GEOMETRIES[:2])
def test_the_pressure_of_a_rupture_that_stays_differs_by_the_square_of_the_speed(geometry: Geometry, sign: int) -> None:
    """From that of a rupture that moves, at the speeds of its table."""
    full = rupture(geometry.radius_ratio, 1.0, 0.0).full
    speeds = [sign * share * full * 3.0 for share in (0.125, 0.0625)]
    more, less = (np.abs(around(V, 1.0, False, geometry) - around(V, 1.0, True, geometry)).max() for V in speeds)
    assert 0 < less < 0.4 * more  # of the speed itself: 0.5


def test_a_gap_that_fills_faster_than_it_is_drawn_apart_is_full_and_rest_changes_nothing() -> None:
    one = np.ones_like(X)
    assert np.array_equal(CIRCLE.ruptured_flow(9.0 * one, 0.5, -X, Y, one), CIRCLE.far_flow(9.0 * one, 0.5, -X, Y))
    assert np.array_equal(CIRCLE.ruptured_flow(-one, 0.0, X, Y, one), CIRCLE.far_flow(-one, 0.0, X, Y))


def test_a_quarter_turn_swaps_the_radii() -> None:
    """Lengths and films of the other are in R_y, so that U X is 1/D and C is D times as large."""
    phi = np.linspace(-3.0, 3.0, 101)
    x, y, zero = 3 * np.cos(phi), 3 * np.sin(phi), 0 * phi
    turned = Geometry(0.4, 90.0).ruptured_flow(zero, 1.0, x, y, zero - 0.2)
    swapped = Geometry(2.5).ruptured_flow(zero, 1.0, x, y, zero - 0.5)
    assert turned == pytest.approx(swapped, abs=1e-4)


def test_a_rate_that_falls_with_the_distance_counts_more_than_at_its_place() -> None:
    """H = r^2/2, outflow r/2 from a uniform rate and 1 from the rate 1/r: P = lambda_bar integral of outflow/H^3."""
    r = np.geomspace(3.0, 3e4, 40001)
    H = r**2 / 2
    uniform, falling = (np.trapezoid(q / H**3, r) for q in (r / 2, np.ones_like(r)))
    assert falling / (uniform / r[0]) == pytest.approx(SHARE_OF_DEFORMATION, rel=1e-4)


def test_the_deformation_in_rolling_is_that_by_the_rate_of_the_load() -> None:
    r = np.array([2.0, 5.0])
    dry, step = 0.5**1.5, 1e-5
    rate = ((0.5 + step) ** 1.5 - (0.5 - step) ** 1.5) / (2 * step)
    given = squeeze(r, Motion(0.5, 1.0, dry, 1.0, load_rate=rate))
    assert given == pytest.approx(squeeze(r, Motion(0.5, 1.0, dry, 1.0)), rel=1e-9)


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
    assert far_pressure(-X, Y, Motion(0.5, 0.0, 0.5, 1.0), LAMBDA_BAR) == pytest.approx(0.0, abs=1e-15)
    motion = Motion(0.5, 0.3, 0.5, 1.0)
    at_rest = motion._replace(entrainment=0.0, load_rate=0.0)  # the sign of a zero is that of the flow before
    for there in (motion, at_rest):
        for geometry in (CIRCLE, Geometry(0.4, 30.0)):
            pairs = ((1, there), (-1, there._replace(entrainment=-there.entrainment)))
            one, other = (far_pressure(s * X, s * Y, m, LAMBDA_BAR, geometry) for s, m in pairs)
            assert one == pytest.approx(other, rel=1e-12)
