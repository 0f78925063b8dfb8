"""Film formulas against values worked out elsewhere, and against each other in their limits.

The numbers of C1 (M = 200, L = 10, a steel ball under 38.9 N) are those of reference/rolling.json, "dimensional_C1".
"""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ertel import formulas
from ertel.scales import HamrockDowson, Parameters, hamrock_dowson, parameters, rolling_scales

ETA0, ALPHA = 0.04, 2.2e-8
C1 = rolling_scales(R=0.01, load=38.885237, mean_speed=0.502636, E_prime=2.197802e11)


def test_hamrock_dowson_of_c1() -> None:
    ugw = hamrock_dowson(C1, ETA0, ALPHA)
    assert formulas.hamrock_dowson_central(ugw) * C1.R * 1e9 == pytest.approx(167.8, abs=0.05)
    assert formulas.hamrock_dowson_minimum(ugw) * C1.R * 1e9 == pytest.approx(95.7, abs=0.05)


def test_nijenbanning_of_c1() -> None:
    p = parameters(C1, ETA0, ALPHA)
    assert formulas.nijenbanning_venner_moes(p.M, p.L) * C1.film * 1e9 == pytest.approx(172.9, abs=0.05)


def test_scales_of_c1() -> None:
    p = parameters(C1, ETA0, ALPHA)
    assert (p.M, p.L) == (pytest.approx(200, rel=1e-6), pytest.approx(10, rel=1e-6))
    assert C1.a == pytest.approx(0.0001384509, rel=1e-6)
    assert C1.p_h == pytest.approx(968577800.0, rel=1e-6)


@given(st.floats(1, 1e5))
def test_isoviscous_elastic_limit(M: float) -> None:
    """0.438 lambda_bar^{3/5}, and the whole formula comes to it as L -> 0 at high M."""
    law = 0.438 * Parameters.from_moes(M, 0).lambda_bar ** 0.6
    assert formulas.isoviscous_elastic(M) == pytest.approx(law, rel=2e-3)
    if M > 3e3:
        assert formulas.nijenbanning_venner_moes(M, 1e-6) == pytest.approx(law, rel=0.1)


@given(st.floats(10, 1e5), st.floats(1, 30))
def test_piezoviscous_elastic_limit(M: float, L: float) -> None:
    assert formulas.piezoviscous_elastic(M, L) == pytest.approx(0.952 * (L / M) ** 0.75, rel=1e-3)


def test_the_formula_lies_near_its_ruling_asymptote() -> None:
    ratio = formulas.nijenbanning_venner_moes(1e4, 25) / formulas.piezoviscous_elastic(1e4, 25)
    assert ratio == pytest.approx(1, abs=0.05)
    assert formulas.nijenbanning_venner_moes(1e-3, 1e-3) == pytest.approx(formulas.isoviscous_rigid(1e-3), rel=0.01)


@given(st.floats(5, 1000), st.floats(1, 20))
def test_film_falls_with_load_and_rises_with_the_oils_stiffness(M: float, L: float) -> None:
    film = formulas.nijenbanning_venner_moes
    assert film(1.1 * M, L) < film(M, L) < film(M, 1.1 * L)


@pytest.mark.parametrize(
    ("call", "name"),
    [
        (lambda: formulas.nijenbanning_venner_moes(-1, 5), "M"),
        (lambda: formulas.nijenbanning_venner_moes(10, 0), "L"),
        (lambda: formulas.isoviscous_elastic(10, 2.0), "radius_ratio"),
        (lambda: formulas.hamrock_dowson_central(HamrockDowson(U=0.0, G=5000, W=1e-6)), "U"),
    ],
)
def test_misuse_names_the_argument(call, name) -> None:
    with pytest.raises(ValueError, match=rf"^{name} = "):
        call()
