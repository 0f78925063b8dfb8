"""Film formulas against values worked out elsewhere, and against each other in their limits.

The numbers of C1 (M = 200, L = 10, a steel ball under 38.9 N) are those of reference/rolling.json, "dimensional_C1".
"""

from math import exp, log, sqrt

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import ertel
from ertel.physics import film_formulas
from ertel.physics.scales import HamrockDowson, Parameters, hamrock_dowson, parameters, rolling_scales

ETA0, ALPHA = 0.04, 2.2e-8
C1 = rolling_scales(R=0.01, load=38.885237, mean_speed=0.502636, E_prime=2.197802e11)
STEEL = HamrockDowson(U=1e-11, G=5000.0, W=1e-6)
ROLLERS = HamrockDowson(U=1e-11, G=5000.0, W=1e-4)
LN10, LN5000 = log(10), log(5000)


# -- values worked out by hand: sums of logarithms ---------------------------------------------------------------------


def test_hamrock_dowson_and_line_contacts_by_hand() -> None:
    """k = 1.03: 1 - 0.61 exp(-0.7519) = 0.71241 and 1 - exp(-0.7004) = 0.50362.

    Line contacts: 10^-7.18 5000^0.54 = 6.56817e-6 and 10^-7.19 5000^0.56 = 7.61067e-6.
    """
    power = exp(-11 * 0.67 * LN10 + 0.53 * LN5000 + 6 * 0.067 * LN10)
    assert film_formulas.hamrock_dowson_central(STEEL) == pytest.approx(2.69 * power * 0.71241, rel=2e-5)
    power = exp(-11 * 0.68 * LN10 + 0.49 * LN5000 + 6 * 0.073 * LN10)
    assert film_formulas.hamrock_dowson_minimum(STEEL) == pytest.approx(3.63 * power * 0.50362, rel=2e-5)
    assert film_formulas.dowson_higginson_minimum(ROLLERS) == pytest.approx(2.65 * 6.56817e-6, rel=1e-5)
    assert film_formulas.dowson_toyoda_central(ROLLERS) == pytest.approx(3.06 * 7.61067e-6, rel=1e-5)


@pytest.mark.parametrize(
    ("radius_ratio", "central", "minimum"),
    [(1.0, 1.79816e-5, 1.05931e-5), (0.125, 2.52227e-5, 2.02067e-5), (8.0, 0.672598e-5, 0.334573e-5)],
)
def test_chittenden_by_hand(radius_ratio, central, minimum) -> None:
    """10^-7.042 5000^0.49 = 5.89515e-6; (Ry/Rx)^{2/3} = 1, 4 (along the minor axis), 1/4 (along the major one)."""
    assert film_formulas.chittenden_central(STEEL, radius_ratio) == pytest.approx(central, rel=1e-5)
    assert film_formulas.chittenden_minimum(STEEL, radius_ratio) == pytest.approx(minimum, rel=1e-5)


def test_elliptic_nijenbanning_by_hand() -> None:
    """M = 100, L = 5, Rx/Ry = 1/4, in Moes' units.

    ln D = -1.386294, D^{4/7} = 0.452862, so e = 1.276985; D^{14/15} = 0.274206, so 1 + 0.796 D^{14/15} = 1.218268.
    """
    e = 1.276985
    by_hand = {
        film_formulas.isoviscous_rigid(100, 0.25): 145 * 1.218268 ** (-15 / 7) * 4 * 1e-4,
        film_formulas.isoviscous_elastic(100, 0.25): 3.18 * e**-0.56 * 4 ** (1 / 15) * 100 ** (-2 / 15),
        film_formulas.piezoviscous_rigid(100, 5, 0.25): 1.29 * 1.17275 ** (-2 / 3) * 5 ** (2 / 3),
        film_formulas.piezoviscous_elastic(100, 5, 0.25): 1.48 * e**-0.35 * 4 ** (1 / 24) * 100 ** (-1 / 12) * 5**0.75,
    }
    for film, moes in by_hand.items():
        assert film / film_formulas.moes_unit(100) == pytest.approx(moes, rel=1e-5)
    # joined with s = 1.5 (1 + exp(-1.2 * 1.646015/3.279014)) = 2.321259
    joined = film_formulas.nijenbanning_venner_moes(100, 5, 0.25) / film_formulas.moes_unit(100)
    assert joined == pytest.approx(3.35007, rel=1e-5)


# -- against each other, and against computed films --------------------------------------------------------------------


BARUS = {(20, 10): 0.49752, (50, 5): 0.179797, (100, 0): 0.040877, (100, 5): 0.109865, (100, 10): 0.164641}
BARUS |= {(200, 10): 0.100544, (1000, 10): 0.031203}  # reference/rolling.json, converged H_c


@pytest.mark.parametrize(("M", "L"), BARUS)
def test_nijenbanning_near_converged_films(M, L) -> None:
    assert -0.14 < film_formulas.nijenbanning_venner_moes(M, L) / BARUS[M, L] - 1 < 0.07


@given(st.floats(1e-12, 5e-11), st.floats(2500, 6500), st.floats(5e-8, 1e-6), st.floats(1, 3))
def test_chittenden_goes_on_from_hamrock_dowson(U, G, W, k) -> None:
    """Two fits to the same kind of contact, flow along the minor axis: k = 1.03 (Ry/Rx)^0.64."""
    ugw, radius_ratio = HamrockDowson(U, G, W), (k / film_formulas.BALL) ** (-1 / 0.64) if k > 1.03 else 1.0
    k = max(k, film_formulas.BALL)
    central = film_formulas.chittenden_central(ugw, radius_ratio) / film_formulas.hamrock_dowson_central(ugw, k)
    minimum = film_formulas.chittenden_minimum(ugw, radius_ratio) / film_formulas.hamrock_dowson_minimum(ugw, k)
    assert central == pytest.approx(1, abs=0.25)
    assert minimum == pytest.approx(1, abs=0.1)


def test_films_side_by_side() -> None:
    """Of C1, in a^2/R."""
    ugw, p = hamrock_dowson(C1, ETA0, ALPHA), parameters(C1, ETA0, ALPHA)
    assert (p.M, p.L, C1.a, C1.p_h) == pytest.approx((200, 10, 0.0001384509, 968577800.0), rel=1e-6)
    rows = {film.name: film for film in film_formulas.films(p, ugw)}
    assert rows["Nijenbanning-Venner-Moes"].central == film_formulas.nijenbanning_venner_moes(p.M, p.L)
    assert film_formulas.nijenbanning_venner_moes(p.M, p.L) * C1.film * 1e9 == pytest.approx(172.9, abs=0.05)
    central, minimum = rows["Hamrock-Dowson"].central, rows["Hamrock-Dowson"].minimum
    assert central is not None and central * C1.film * 1e9 == pytest.approx(167.8, abs=0.05)
    assert minimum is not None and minimum * C1.film * 1e9 == pytest.approx(95.7, abs=0.05)
    for film in rows.values():
        assert film.source and film.valid and (film.central or film.minimum)
    assert rows["Hamrock-Dowson"].inside and rows["Chittenden et al."].inside
    assert not rows["Dowson-Higginson"].inside  # of a line, and this is a ball
    slow = HamrockDowson(U=1e-14, G=4500, W=1e-6)
    rows = {film.name: film for film in film_formulas.films(Parameters.from_moes(1e4, 5), slow)}
    assert not rows["Hamrock-Dowson"].inside and not rows["Dowson-Higginson"].inside


def test_films_without_physical_input_or_piezoviscosity() -> None:
    """Formulas with a power of G have nothing to say; the asymptotes of L neither."""
    names = [film.name for film in film_formulas.films(Parameters.from_moes(200, 10))]
    assert names[0] == "Nijenbanning-Venner-Moes"
    assert not {"Hamrock-Dowson", "Dowson-Toyoda"} & set(names)
    films = film_formulas.films(Parameters.from_moes(1e4, 0), HamrockDowson(U=1e-11, G=0.0, W=1e-5))
    inside = {film.name: film.inside for film in films}
    soft, rigid = "Hamrock-Dowson, soft", "Brewe et al., rigid"
    assert list(inside) == ["Nijenbanning-Venner-Moes", soft, rigid, "isoviscous, rigid", "isoviscous, elastic"]
    assert list(inside.values()) == [True, False, False, False, True]


def test_a_formula_that_says_inside_is_right() -> None:
    """Contacts of all regimes, seeded: within 1.3 of Nijenbanning, Venner and Moes', the isoviscous ones within 1.5."""
    draw, seen = np.random.default_rng(39), set()
    for number in range(3000):
        R, F, u, eta0, alpha, E = np.exp(
            draw.uniform(*np.log([(1e-3, 1e-2, 1e-2, 1e-3, 5e-9, 1e9), (0.1, 1e4, 30, 1, 4e-8, 4e11)]))
        )
        D = 1.0 if number % 2 else float(draw.uniform(0.02, 1))
        scales = rolling_scales(R, F, u, E if number % 3 else 2.2e11, D)
        rows = film_formulas.films(parameters(scales, eta0, alpha), hamrock_dowson(scales, eta0, alpha))
        for film in rows[1:]:
            if film.inside and film.central and rows[0].central:
                seen.add(film.name)
                most = 1.5 if film.name.endswith(("soft", "rigid")) else 1.32
                assert 1 / most < film.central / rows[0].central < most, (scales, film)
    assert {"Hamrock-Dowson", "Chittenden et al.", "Dowson-Toyoda", "Hamrock-Dowson, soft"} < seen


def test_a_light_ball_is_outside() -> None:
    """A ball of 15 mm rolls under 0.76 N: 20 um, where Hamrock and Dowson's formula gives 1.04 um."""
    light = rolling_scales(R=0.015, load=0.76488, mean_speed=3.1481, E_prime=2.307692e11)
    p, ugw = parameters(light, 0.05, ALPHA), hamrock_dowson(light, 0.05, ALPHA)
    rows = {film.name: film for film in film_formulas.films(p, ugw)}
    um = {name: (film.central or 0.0) * light.film * 1e6 for name, film in rows.items()}
    assert um["Hamrock-Dowson"] == pytest.approx(1.042, abs=1e-3) and not rows["Hamrock-Dowson"].inside
    assert not rows["Chittenden et al."].inside and not rows["Dowson-Toyoda"].inside
    assert um["Brewe et al., rigid"] == pytest.approx(20.0, abs=0.1) and rows["Brewe et al., rigid"].inside
    assert film_formulas.regime_of(p.M, p.L) == "isoviscous, rigid"


def test_rigid_and_soft_films_by_hand() -> None:
    """A ball, in Moes' units: 32 (0.131 atan(1/2) + 1.683)^2/(5/3)^2/M^2, and 2.7875 (4 M^{8/3})^0.67/M^2 times the k.

    ertel's films on 65 nodes: 33.69 for M = 1 and 374.0 for M = 0.3; converged 1.154 for M = 100; L = 0 in all.
    """
    unit = film_formulas.moes_unit
    assert film_formulas.rigid_film(1.0) / unit(1.0) == pytest.approx(32 * 1.743738**2 * 0.36, rel=1e-6)
    for M, film in {1.0: 33.69, 0.3: 374.0}.items():
        assert film_formulas.rigid_film(M) / unit(M) == pytest.approx(film, rel=0.05)
    central, minimum = film_formulas.soft_film(100.0)
    g = (4 * 100 ** (8 / 3)) ** 0.67
    assert central / unit(100) == pytest.approx(11.15 * g / 4e4 * (1 - 0.72 * exp(-0.2884)))
    assert minimum / unit(100) == pytest.approx(8.70 * g / 4e4 * (1 - 0.85 * exp(-0.3193)))
    assert central == pytest.approx(BARUS[100, 0], rel=0.06)
    U, W = 1e-8, 100 * 2e-8**0.75  # the same as published in U and W
    assert central / unit(100) * sqrt(2 * U) == pytest.approx(7.32 * 0.4604 * U**0.64 * W**-0.22, rel=0.03)


def test_regimes_by_name() -> None:
    """The regimes of Hamrock's map, whose numbers are g_V = G W^3/U^2 and g_E = W^{8/3}/U^2."""
    contacts = {(0.5, 15.7): "isoviscous, rigid", (200, 10): "piezoviscous, elastic", (1e3, 0): "isoviscous, elastic"}
    contacts[0.3, 1e6] = "piezoviscous, rigid"
    assert {contact: film_formulas.regime_of(*contact) for contact in contacts} == contacts
    W, U, G = 1e-6, 1e-11, 5000.0
    found = film_formulas.regime_numbers(W / (2 * U) ** 0.75, G * (2 * U) ** 0.25)
    assert found == pytest.approx((G * W**3 / U**2, W ** (8 / 3) / U**2))


@pytest.mark.slow
@pytest.mark.parametrize("number", range(4))
def test_inside_against_computed_films(number: int) -> None:
    """Seeded contacts in Hamrock and Dowson's range, on 65 nodes: their formula is within 1.25 of the film."""
    draw = np.random.default_rng(number)
    M, L = exp(draw.uniform(log(12), log(150))), exp(draw.uniform(log(3), log(14)))
    oil = ertel.Oil(viscosity="barus", density="incompressible")
    film = ertel.simulate(ertel.rolling(M=M, L=L, nodes=65, oil=oil)).summary["H_c"]
    U = 1e-11
    ugw = HamrockDowson(U, L / (2 * U) ** 0.25, M * (2 * U) ** 0.75)
    rows = {row.name: row for row in film_formulas.films(Parameters.from_moes(M, L), ugw)}
    central = rows["Hamrock-Dowson"].central
    assert rows["Hamrock-Dowson"].inside and central is not None and 1 / 1.25 < central / film < 1.25


@given(st.floats(1, 1e5), st.floats(1, 30))
def test_elastic_limits(M: float, L: float) -> None:
    """0.438 lambda_bar^{3/5}, to which the whole formula comes as L -> 0 at high M, and 0.952 (L/M)^{3/4}."""
    law = 0.438 * Parameters.from_moes(M, 0).lambda_bar ** 0.6
    assert film_formulas.isoviscous_elastic(M) == pytest.approx(law, rel=2e-3)
    if M > 3e3:
        assert film_formulas.nijenbanning_venner_moes(M, 1e-6) == pytest.approx(law, rel=0.1)
    if M >= 10:
        assert film_formulas.piezoviscous_elastic(M, L) == pytest.approx(0.952 * (L / M) ** 0.75, rel=1e-3)
    film = film_formulas.nijenbanning_venner_moes  # near the asymptote that rules
    assert film(1e4, 25) == pytest.approx(film_formulas.piezoviscous_elastic(1e4, 25), rel=0.05)
    assert film(1e-3, 1e-3) == pytest.approx(film_formulas.isoviscous_rigid(1e-3), rel=0.01)


@given(st.floats(5, 1000), st.floats(1, 20))
def test_film_falls_with_load_and_rises_with_the_oils_stiffness(M: float, L: float) -> None:
    film = film_formulas.nijenbanning_venner_moes
    assert film(1.1 * M, L) < film(M, L) < film(M, 1.1 * L)


@pytest.mark.parametrize(
    ("call", "name"),
    [
        (lambda: film_formulas.nijenbanning_venner_moes(-1, 5), "M"),
        (lambda: film_formulas.nijenbanning_venner_moes(10, -1), "L"),
        (lambda: film_formulas.isoviscous_elastic(10, 2.0), "radius_ratio"),
        (lambda: film_formulas.hamrock_dowson_central(HamrockDowson(U=0.0, G=5000, W=1e-6)), "U"),
        (lambda: film_formulas.hamrock_dowson_minimum(STEEL, ellipticity=0.0), "ellipticity"),
        (lambda: film_formulas.chittenden_central(STEEL, radius_ratio=-1.0), "radius_ratio"),
        (lambda: film_formulas.chittenden_minimum(HamrockDowson(U=1e-11, G=0.0, W=1e-6)), "G"),
        (lambda: film_formulas.dowson_toyoda_central(HamrockDowson(U=1e-11, G=5000, W=-1e-4)), "W"),
    ],
)
def test_misuse_names_the_argument(call, name) -> None:
    with pytest.raises(ValueError, match=rf"^{name} = "):
        call()
