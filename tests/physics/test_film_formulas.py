"""Film formulas against values worked out elsewhere, and against each other in their limits.

The numbers of C1 (M = 200, L = 10, a steel ball under 38.9 N) are those of reference/rolling.json, "dimensional_C1".
"""

from math import exp, log

import pytest
from hypothesis import given
from hypothesis import strategies as st

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
    assert rows["Hamrock-Dowson"].inside and rows["Dowson-Higginson"].inside
    assert rows["Chittenden et al."].inside is None
    slow = HamrockDowson(U=1e-14, G=4500, W=1e-6)
    rows = {film.name: film for film in film_formulas.films(Parameters.from_moes(1e4, 5), slow)}
    assert not rows["Hamrock-Dowson"].inside and not rows["Dowson-Higginson"].inside


def test_films_without_physical_input_or_piezoviscosity() -> None:
    """Formulas with a power of G have nothing to say; the asymptotes of L neither."""
    names = [film.name for film in film_formulas.films(Parameters.from_moes(200, 10))]
    assert names[0] == "Nijenbanning-Venner-Moes"
    assert not {"Hamrock-Dowson", "Dowson-Toyoda"} & set(names)
    films = film_formulas.films(Parameters.from_moes(1e4, 0), HamrockDowson(U=1e-11, G=0.0, W=1e-5))
    assert [film.name for film in films] == ["Nijenbanning-Venner-Moes", "isoviscous, rigid", "isoviscous, elastic"]
    assert [film.inside for film in films] == [True, False, True]


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
