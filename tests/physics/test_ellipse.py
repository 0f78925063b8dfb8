"""The elliptical contact: constants, scales and film formulas against numbers worked out by quadrature elsewhere.

Table, worked example and film table are those of the design for elliptical contacts, found there by root finding and
quadrature, and from the published formula of Nijenbanning, Venner and Moes.
"""

from dataclasses import replace
from math import inf, nan, pi, sqrt

import numpy as np
import pytest
from closed_forms import parameters_from_ugw
from hypothesis import given
from hypothesis import strategies as st

from ertel.physics import film_formulas, hertz
from ertel.physics.dry_contact import hertz_ellipse
from ertel.physics.geometry import CIRCLE, Geometry, geometry
from ertel.physics.materials import reduced_radius
from ertel.physics.scales import FlowDirection, Parameters, hamrock_dowson, impact_scales, parameters, rolling_scales

TABLE = {  # D: kappa, E, F, beta, kernel factor, Delta_H, 2 pi/(3 kappa)
    4: (2.500706, 2.877289, 0.943543, 0.732696, 0.276571, 0.819819, 0.83752),
    2: (1.585802, 2.057027, 1.230995, 0.873029, 0.232114, 0.897651, 1.32072),
    1: (1, 1.570796, 1.570796, 1, 0.202642, 1, 2.09440),
    0.9: (0.932173, 1.517993, 1.626439, 1.017247, 0.199207, 1.017868, 2.24679),
    0.8: (0.861803, 1.464272, 1.689724, 1.035760, 0.195646, 1.038572, 2.43025),
    2 / 3: (0.763299, 1.391138, 1.789765, 1.062751, 0.190677, 1.072123, 2.74387),
    0.5: (0.630596, 1.297152, 1.952114, 1.101057, 0.184043, 1.128692, 3.32130),
    0.4: (0.544131, 1.239330, 2.081185, 1.127117, 0.179788, 1.175497, 3.84907),
    1 / 3: (0.482628, 1.200181, 2.188272, 1.146088, 0.176812, 1.215524, 4.33957),
    0.25: (0.399887, 1.150591, 2.359524, 1.171982, 0.172906, 1.281692, 5.23747),
    0.2: (0.345999, 1.120520, 2.493744, 1.188908, 0.170444, 1.335315, 6.05318),
    0.1: (0.222250, 1.059884, 2.914203, 1.226806, 0.165179, 1.512251, 9.42362),
    0.05: (0.144328, 1.029576, 3.334189, 1.248473, 0.162312, 1.700165, 14.5114),
    0.02: (0.082842, 1.011613, 3.882067, 1.262770, 0.160474, 1.957126, 25.2818),
    0.01: (0.054984, 1.005730, 4.289495, 1.267857, 0.159831, 2.153854, 38.0910),
}
NVM = {  # (M, L): H_Moes for D = 1, 0.5, 0.2, 0.1, 0.05
    (20, 10): (4.2648, 4.9653, 5.6963, 6.5453, 8.8691),
    (200, 10): (4.0420, 4.5634, 5.0422, 5.3061, 5.5117),
    (1000, 10): (3.7628, 4.1646, 4.5704, 4.8192, 5.0305),
    (200, 0): (1.1419, 1.3439, 1.5479, 1.69, 1.8285),
    (200, 5): (2.6083, 2.9408, 3.2637, 3.4596, 3.6275),
}
RATIOS = st.just(1.0) | st.floats(-2, 2).map(lambda power: min(max(10.0**power, 0.01), 100.0))


@pytest.mark.parametrize("D", TABLE)
def test_constants_of_the_table(D: float) -> None:
    e = hertz_ellipse(float(D))
    *others, load = TABLE[D]
    assert (e.kappa, e.E, e.F, e.beta, e.compliance, e.approach) == pytest.approx(others, rel=0, abs=6e-7)
    assert e.load == pytest.approx(load, rel=4e-6)


def test_a_circle_has_the_constants_of_a_circle() -> None:
    """And is no special place: kappa = D^{2/3} to first order on both sides (by hand from the series in m)."""
    e = hertz_ellipse(1.0)
    assert (e.kappa, e.beta, e.approach) == (1.0, 1.0, 1.0)
    assert (e.compliance, e.load) == (CIRCLE.compliance, CIRCLE.hertz_load)
    assert geometry(1.0, 30.0) is CIRCLE
    for epsilon in (-1e-5, -1e-7, 1e-8, 1e-6, 1e-5):
        assert hertz_ellipse(1 + epsilon).kappa - 1 == pytest.approx(2 / 3 * epsilon, abs=1e-10)


@given(RATIOS)
def test_exchange_of_the_axes(D: float) -> None:
    """The same ellipse: half widths, p_h, load and approach in metres do not know which axis is called x."""
    one, other = hertz_ellipse(D), hertz_ellipse(1 / D)
    assert one.kappa * other.kappa == pytest.approx(1, rel=1e-12)
    assert (one.E, one.F) == pytest.approx((one.kappa * other.E, other.F / one.kappa), rel=1e-12)


@pytest.mark.parametrize("D", [0.0, -1.0, 0.0099, 101.0, nan])
def test_a_ratio_out_of_range_is_refused(D: float) -> None:
    with pytest.raises(ValueError, match=r"^radius_ratio = .*: must be from 1/100 to 100"):
        hertz_ellipse(D)


# -- the geometry -----------------------------------------------------------------------------------------------------

X, Y = np.meshgrid(np.linspace(-3, 3, 13), np.linspace(-4, 4, 17))


@pytest.mark.parametrize("angle", [0.0, 30.0, 90.0])
def test_the_circle(angle: float) -> None:
    """Equal radii, whatever the angle: A = load^(1/3), sqrt(A^2 - r^2), A^2, V/4 - U X/5."""
    circle, r2 = Geometry(1.0, angle), X**2 + Y**2
    constants = (2 * pi / 3, 2 / pi**2, 4 / 5, *(1.0, 1.0), 1.0)
    found = circle.hertz_load, circle.compliance, circle.hertz.inertia, *circle.extent, circle.smaller
    assert found == pytest.approx(constants, rel=1e-15)
    assert circle.gap(X, Y) == pytest.approx(r2 / 2, abs=1e-14)
    assert circle.dry_pressure(0.5, X, Y) == pytest.approx(np.sqrt(np.maximum(0.5 ** (2 / 3) - r2, 0)), abs=1e-7)
    assert circle.dry_approach(0.5) == pytest.approx(0.5 ** (2 / 3), rel=1e-15)
    assert circle.distance(X, Y) == pytest.approx(np.sqrt(r2), abs=1e-14)
    assert circle.far_flow(1.0, 0.5, X, Y) == pytest.approx(1 / 4 - 0.5 * X / 5, abs=1e-14)


@pytest.mark.parametrize("D", [0.2, 3.0])
def test_a_quarter_turn_exchanges_the_axes(D: float) -> None:
    """In units of the swapped ellipse lengths are kappa times, displacements kappa^2/D times as large."""
    turned, swapped = Geometry(D, 90.0), Geometry(1 / D)
    kappa, film = hertz_ellipse(D).kappa, hertz_ellipse(D).kappa ** 2 / D
    assert turned.gap(X, Y) * film == pytest.approx(swapped.gap(kappa * X, kappa * Y), rel=1e-12)
    assert turned.dry_pressure(0.7, X, Y) == pytest.approx(swapped.dry_pressure(0.7, kappa * X, kappa * Y), abs=1e-6)
    assert turned.dry_approach(0.7) * film == pytest.approx(swapped.dry_approach(0.7))
    assert tuple(kappa * e for e in turned.extent) == pytest.approx(swapped.extent)
    assert kappa * turned.smaller == pytest.approx(swapped.smaller)
    assert turned.even == (True, True)


@pytest.mark.parametrize("angle", [0.0, 25.0, 90.0])
def test_the_dry_contact_fills_its_extent_and_carries_its_load(angle: float) -> None:
    ellipse = Geometry(0.3, angle)
    assert ellipse.even == ((angle % 90 == 0),) * 2
    wide, high = ellipse.extent
    x, y = np.linspace(-wide, wide, 801), np.linspace(-high, high, 801)
    P = ellipse.dry_pressure(1.0, x[None, :], y[:, None])
    assert P.sum() * (x[1] - x[0]) * (y[1] - y[0]) == pytest.approx(ellipse.hertz_load, rel=1e-4)
    assert (P > 0).any(axis=0)[5:-5].all() and (P > 0).any(axis=1)[5:-5].all()
    assert ellipse.distance(x[None, :], y[:, None])[P > 0].max() == pytest.approx(1, abs=0.01)


# -- scales -----------------------------------------------------------------------------------------------------------

WORKED = rolling_scales(R=0.01, load=100.0, mean_speed=0.5, E_prime=226.37e9, radius_ratio=0.2)
WORKED_PARAMETERS = parameters(WORKED, eta0=0.04, alpha=22e-9)


def test_worked_example() -> None:
    e, p = WORKED_PARAMETERS.hertz, WORKED_PARAMETERS
    found = WORKED.a, WORKED.a_y, WORKED.p_h, WORKED.approach, WORKED.load
    assert found == pytest.approx((139.690e-6, 403.729e-6, 846.615e6, 2.60564e-6, 100.0), rel=4e-6)
    found = p.lambda_bar, p.alpha_bar, p.M_BH, p.L_BH, p.M, p.L
    assert found == pytest.approx((0.01039991, 18.62553, 185.188, 8.96790, 512.567, 10.21061), rel=4e-6)
    assert (1.5 * e.kappa * e.beta * p.M) ** (2 / 3) == pytest.approx(46.42051, rel=1e-6)
    line = film_formulas.line_contact(hamrock_dowson(WORKED, 0.04, 22e-9), 0.2)
    assert sqrt(line.W / (2 * pi)) * WORKED.E_prime == pytest.approx(WORKED.p_h)


def test_films_of_the_worked_example() -> None:
    ugw = hamrock_dowson(WORKED, 0.04, 22e-9)
    rows = {film.name: film for film in film_formulas.films(WORKED_PARAMETERS, ugw)}
    nm = {name: [round((f or 0.0) * WORKED.film * 1e9, 2) for f in row[1:3]] for name, row in rows.items()}
    assert nm["Nijenbanning-Venner-Moes"] == [203.69, 0.0] and rows["Nijenbanning-Venner-Moes"].minimum is None
    assert nm["Hamrock-Dowson"] == [203.48, 151.39] and rows["Hamrock-Dowson"].inside
    assert nm["Chittenden et al."] == [203.41, 153.40]


@given(RATIOS, st.floats(-6, 6).map(lambda power: 10.0**power), st.floats(0, 1000))
def test_parameters_and_back(D: float, M: float, L: float) -> None:
    p = Parameters.from_moes(M, L, hertz_ellipse(D))
    assert (p.M, p.L) == (pytest.approx(M), pytest.approx(L))
    assert p.M_BH == pytest.approx(M * p.hertz.beta**0.25 * p.hertz.kappa)
    assert p.L_BH == pytest.approx(L * p.hertz.beta**-0.75)
    assert p.lambda_bar == pytest.approx((128 / 3) ** (1 / 3) * pi / p.M_BH ** (4 / 3))
    assert p.alpha_bar == pytest.approx(p.L_BH / pi * (1.5 * p.M_BH) ** (1 / 3))


@given(RATIOS)
def test_moes_numbers_of_a_physical_contact(D: float) -> None:
    """M, L by U, G, W alone, as published, and by lambda_bar, alpha_bar are the same."""
    s = rolling_scales(R=0.01, load=50.0, mean_speed=0.4, E_prime=2e11, radius_ratio=D)
    p = parameters(s, eta0=0.05, alpha=2e-8)
    ugw = parameters_from_ugw(*hamrock_dowson(s, 0.05, 2e-8), radius_ratio=D)
    assert (p.M, p.L) == (pytest.approx(ugw.M), pytest.approx(ugw.L))


@given(RATIOS)
def test_an_impact_stores_its_energy(D: float) -> None:
    """m v0^2/2 = (2/5) F* delta*; and the exchange of the axes is the same impact in metres."""
    one = impact_scales(R=0.01, mass=0.03, speed=0.1, E_prime=2e11, radius_ratio=D)
    other = impact_scales(R=0.01 / D, mass=0.03, speed=0.1, E_prime=2e11, radius_ratio=1 / D)
    assert 0.4 * one.load * one.approach == pytest.approx(0.03 * 0.1**2 / 2)
    assert (one.ball_mass, one.speed) == pytest.approx((0.03, 0.1))
    assert (one.load, one.approach, one.p_h) == pytest.approx((other.load, other.approach, other.p_h))
    assert (one.a, one.a_y) == pytest.approx((other.a_y, other.a))
    p, q = parameters(one, 0.1, 2e-8), parameters(other, 0.1, 2e-8)
    assert p.stokes == pytest.approx(q.stokes)
    assert p.trapped_film * one.film == pytest.approx(q.trapped_film * other.film)


def test_stokes_number_of_an_ellipsoid() -> None:
    """m v0/(6 pi eta0 R^2) with R^2 = 2 (R_x R_y)^{3/2}/(R_x + R_y): the force of the rigid gap by integration."""
    s = impact_scales(R=0.01, mass=0.03, speed=0.1, E_prime=2e11, radius_ratio=0.25)
    squared = 2 * (0.01 * 0.04) ** 1.5 / (0.01 + 0.04)
    assert parameters(s, 0.1, 2e-8).stokes == pytest.approx(0.03 * 0.1 / (6 * pi * 0.1 * squared))
    h0 = 1e-6
    x, y = (np.linspace(-600, 600, 2401) * sqrt(2 * R * h0) / 20 for R in (0.01, 0.04))
    p = 6 * 0.1 * 0.1 / (1 / 0.01 + 1 / 0.04) / (h0 + x[None, :] ** 2 / 0.02 + y[:, None] ** 2 / 0.08) ** 2
    force = p.sum() * (x[1] - x[0]) * (y[1] - y[0])
    assert force == pytest.approx(6 * pi * 0.1 * squared * 0.1 / h0, rel=2e-3)


def test_the_dry_motion_scales_with_the_dry_approach() -> None:
    """inertia Delta'' = -(Delta/Delta_H)^{3/2}, inertia (4/5) Delta_H: Delta_H times the circle's Delta(T/Delta_H)."""
    ellipse, T, step = Geometry(0.2), 1.0, 1e-3
    full = ellipse.dry_approach(1.0)
    before, now, after = (full * float(hertz.approach((T + dT) / full)) for dT in (-step, 0.0, step))
    acceleration = (after - 2 * now + before) / step**2
    assert ellipse.hertz.inertia * acceleration == pytest.approx(-((now / full) ** 1.5), rel=1e-5)


# -- film formulas ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("M", "L"), NVM)
def test_nijenbanning_of_the_table(M: float, L: float) -> None:
    for D, film in zip((1.0, 0.5, 0.2, 0.1, 0.05), NVM[M, L], strict=True):
        p = Parameters.from_moes(M, L, hertz_ellipse(D))
        found = film_formulas.films(p)[0].central or 0.0
        assert found * (1.5 * p.hertz.kappa * p.hertz.beta * M) ** (2 / 3) == pytest.approx(film, rel=0, abs=6e-5)


@pytest.mark.parametrize("angle", [0.0, 40.0, 90.0])
def test_formulas_do_not_know_the_name_of_the_axes(angle: float) -> None:
    """Exchange of the axes with the flow turned by 90 degrees: the same films in metres."""
    one = WORKED
    other = rolling_scales(R=0.05, load=100.0, mean_speed=0.5, E_prime=226.37e9, radius_ratio=5.0)
    films = []
    for s, turn in ((one, angle), (other, 90.0 - angle)):
        p, ugw = parameters(s, 0.04, 22e-9), hamrock_dowson(s, 0.04, 22e-9)
        found = film_formulas.films(p, ugw, turn)
        films.append({f.name: ((f.central or 0.0) * s.film, (f.minimum or 0.0) * s.film) for f in found})
        films[-1]["expected"] = (film_formulas.expected_film(p, turn) * s.film, 0.0)
    assert films[0].keys() == films[1].keys()
    for name in films[0]:
        assert films[0][name] == pytest.approx(films[1][name], rel=1e-9), name


def test_flow_at_an_angle() -> None:
    """Euler: 1/R_e = cos^2/Rx + sin^2/Ry; at 45 degrees R_e = R_s = 2 Rx Ry/(Rx + Ry)."""
    assert FlowDirection.at(0.2, 45.0) == pytest.approx((0.6, 1.0))
    ugw, p = hamrock_dowson(WORKED, 0.04, 22e-9), WORKED_PARAMETERS
    rows = {film.name: film for film in film_formulas.films(p, ugw, 45.0)}
    at = film_formulas.HamrockDowson(ugw.U * 0.6, ugw.G, ugw.W * 0.36)
    central = rows["Chittenden et al."].central or 0.0
    assert central * WORKED.film == pytest.approx(film_formulas.chittenden_central(at) * 0.01 / 0.6)
    assert not rows["Hamrock-Dowson"].inside and rows["Chittenden et al."].inside
    assert not rows["Nijenbanning-Venner-Moes"].inside and "Dowson-Toyoda" not in rows


def test_flow_along_the_longer_axis() -> None:
    """Only Chittenden's formula is made for it."""
    slender = rolling_scales(R=0.05, load=100.0, mean_speed=0.5, E_prime=226.37e9, radius_ratio=5.0)
    p, ugw = parameters(slender, 0.04, 22e-9), hamrock_dowson(slender, 0.04, 22e-9)
    rows = {film.name: film for film in film_formulas.films(p, ugw)}
    assert set(rows) == {"Hamrock-Dowson", "Chittenden et al."}
    assert rows["Hamrock-Dowson"].inside is False
    central = rows["Chittenden et al."].central
    assert film_formulas.expected_film(p) == pytest.approx(central, rel=0.25)
    assert film_formulas.films(replace(p, alpha_bar=0.0)) == []


# -- bodies -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("one", "other", "together"),
    [(6e-3, 3e-3, 2e-3), (6e-3, inf, 6e-3), (6e-3, -6.24e-3, 0.156), (6e-3, -6e-3, inf), (6e-3, -5e-3, -30e-3)],
)
def test_radii_of_balls_planes_and_raceways(one: float, other: float, together: float) -> None:
    assert reduced_radius(one, other) == pytest.approx(together)
