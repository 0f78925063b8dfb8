"""Contacts with an oil that thins: steady rolling, rolling in time, impact; the Newtonian limit and the work."""

from functools import cache
from pathlib import Path

import numpy as np
import pytest
from cases import march
from numpy.testing import assert_allclose

from ertel.case.case import Case
from ertel.inputs.case_files import load_case
from ertel.inputs.python import Oil, impact, rolling
from ertel.physics.fluidity import Carreau, Fluidity, Limited, ReeEyring
from ertel.results import balances
from ertel.solvers import steady
from ertel.solvers.steady import Rolling
from ertel.solvers.transient import Transient2D

EXAMPLES = Path(__file__).parents[2] / "examples"
OIL = Oil(eta0=0.04, alpha=20e-9)
BALL = {"radius": 0.01, "E_prime": 226e9, "oil": OIL}
LOADED = {**BALL, "load": 20.0, "mean_speed": 1.0}  # M = 61, L = 11, p_h = 0.79 GPa
STIFF = ReeEyring(1e15)


def rolled(law: Fluidity | str, slide_to_roll: float, nodes: int = 33, **changes: object) -> Case:
    return rolling(**{**LOADED, "slide_to_roll": slide_to_roll, "nodes": nodes, "rheology": law, **changes})


@cache
def film(law: Fluidity | str, slide_to_roll: float = 0.0) -> Rolling:
    return steady.steady_film(rolled(law, slide_to_roll))


def krylov(found: Rolling) -> int:
    return sum(s.krylov for s in found.solutions)


def test_without_thinning_the_film_is_newtonian():
    newtonian, found = film("newtonian").finest, film(STIFF, 0.5).finest
    for field in ("P", "H"):
        assert_allclose(getattr(found, field), getattr(newtonian, field), rtol=0, atol=1e-12)
    assert (found.newton, found.krylov) == (newtonian.newton, newtonian.krylov)


EYRING, LIMITED = ReeEyring(2e6), Limited(Carreau(6e6, 0.42), 0.05)
SLIDING = (0.0, 0.5, 1.9)


@pytest.mark.parametrize(
    "law", [EYRING, pytest.param(LIMITED, marks=pytest.mark.slow)], ids=["eyring", "limited-carreau"]
)
def test_sliding_makes_the_film_thinner(law: Fluidity):
    """Also pure rolling thins it, by the pressure gradient in the inlet."""
    found = [film("newtonian"), *(film(law, S) for S in SLIDING)]
    assert all(f.finest.status.ok for f in found)
    assert np.all(np.diff([f.finest.measure()["H_c"] for f in found]) < -1e-4)


def test_thinning_takes_little_more_work():
    assert max(krylov(film(EYRING, S)) for S in SLIDING) <= 1.5 * krylov(film("newtonian"))


@pytest.mark.slow
def test_a_limiting_stress_takes_little_more_work():
    """On 65 nodes; 1.57 times where the preconditioner has no tangent mobility."""
    newtonian, found = (steady.steady_film(rolled(law, 0.5, 65)) for law in ("newtonian", LIMITED))
    assert krylov(found) <= 1.5 * krylov(newtonian)


@pytest.mark.slow
def test_the_budgets_close_as_well_as_those_of_a_newtonian_oil():
    energies = []
    for law, S in (("newtonian", 0.0), (ReeEyring(2e6), 1.9)):
        case = rolled(law, S)
        found = balances.steady(case, film(law, S).finest.account.terms, 1.0)
        assert found["mass"]["imbalance"] < 1e-6
        energies.append(found["energy"]["imbalance"])
    assert energies[1] <= energies[0]


@pytest.mark.slow  # 2 min each
@pytest.mark.skipif(not EXAMPLES.exists(), reason="the examples are not part of a package")
@pytest.mark.parametrize("name", ["ball_bearing", "gear_flanks"])
def test_the_mass_of_an_ellipse_closes_on_all_grids_and_its_energy_better_on_a_finer_one(name: str):
    case = load_case(EXAMPLES / f"{name}.toml", ["solver.nodes=129", "solver.tolerance=1e-4"])
    coarse, fine = (balances.steady(case, s.account.terms, 1.0) for s in steady.steady_film(case).solutions[-2:])
    assert max(each["mass"]["imbalance"] for each in (coarse, fine)) < 1e-5
    assert 0.0 < fine["energy"]["imbalance"] < min(coarse["energy"]["imbalance"] / 1.5, 0.02)


def test_the_direction_of_rolling_does_not_matter():
    backwards = steady.steady_film(rolled(ReeEyring(2e6), 0.5, mean_speed=-1.0)).finest
    assert_allclose(np.asarray(backwards.H)[:, ::-1], film(ReeEyring(2e6), 0.5).finest.H, rtol=0, atol=1e-9)


@pytest.mark.slow
def test_a_steady_film_stays_as_it_is():
    case = rolled(ReeEyring(2e6), 1.0, method="transient", until=1.0)
    method = Transient2D(case)
    start, newest = method.start(), march(method, 0.2, 3)[0]
    assert_allclose(newest.H, start.H, rtol=0, atol=3e-5)


@pytest.mark.slow
def test_an_impact_of_an_oil_that_thins():
    """On a track that moves and slides: as a Newtonian one without thinning, thinner with it."""
    films = {}
    track = {"speed": 0.1, "mean_speed": 0.5, "slide_to_roll": 1.0, "nodes": 17, "tolerance": 1e-8}
    for law in ("newtonian", STIFF, ReeEyring(2e4)):
        films[law] = march(Transient2D(impact(**BALL, **track, ball_density=7850, rheology=law)), 0.2, 4)[0]
    assert_allclose(films[STIFF].H, films["newtonian"].H, rtol=0, atol=1e-12)
    assert float(films[ReeEyring(2e4)].H.min()) < float(films["newtonian"].H.min()) - 1e-3


@pytest.mark.slow
@pytest.mark.parametrize("law", [EYRING, Carreau(6e6, 0.42)], ids=["eyring", "carreau"])
def test_film_and_traction_are_of_second_order(law: Fluidity):
    """On 65, 129 and 257 nodes; the traction of Carreau's oil is still at 2.3."""
    case = rolled(law, 0.5, 257)
    levels = steady.steady_film(case).solutions[-3:]
    assert all(s.status.ok for s in levels)
    films = [s.measure()["H_c"] for s in levels]
    tractions = [float(s.account.friction.sliding[0]) for s in levels]
    for values, highest in ((films, 2.2), (tractions, 2.2 if law is EYRING else 2.5)):
        first, second = np.abs(np.diff(values))
        assert 1.8 < np.log2(first / second) < highest


@pytest.mark.slow
def test_strong_sliding_at_high_load_takes_no_more_work():
    """Two gear teeth at M = 4000 on 129 nodes along X; Krylov iterations there: 11, Newtonian 12."""
    teeth = {"radius_x_1": 10.78e-3, "radius_x_2": 23.66e-3, "radius_y_1": 0.3, "load": 800.0, "mean_speed": 2.085}
    oil = Oil(eta0=0.0131, alpha=19.2e-9)
    newtonian, found = (
        steady.steady_film(
            rolling(**teeth, slide_to_roll=-0.38, E_prime=226e9, oil=oil, rheology=law, nodes=129, tolerance=0.03)
        ).finest
        for law in ("newtonian", ReeEyring(5e6))
    )
    assert found.status.ok
    assert found.krylov <= 1.5 * newtonian.krylov
