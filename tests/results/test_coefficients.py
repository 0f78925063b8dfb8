"""A coefficient of friction is one number: in the summary, in SI, in the Dataset, in tables; also of earlier runs."""

import numpy as np
import pytest
import xarray as xr

import ertel
from ertel.apps.tables import film_rows, value_rows
from ertel.physics.film_formulas import FormulaFilm
from ertel.results.numbers import as_now, key_numbers, number, scalars
from ertel.results.variables import one_number, to_si, with_coefficients

PHYSICAL = {"radius": "10 mm", "load": "20 N", "mean_speed": 1.0, "E_prime": "226 GPa", "slide_to_roll": 0.01}
OIL = ertel.Oil(eta0="20 mPa*s", alpha="15 / GPa")


@pytest.fixture(scope="module")
def run() -> ertel.Result:
    return ertel.simulate(ertel.rolling(**PHYSICAL, oil=OIL, nodes=33))


def test_one_number_everywhere(run: ertel.Result):
    summary, mu = run.summary, run.summary["mu_sliding"]
    assert 0.001 < mu < 0.1  # 60 times as much in units a/R
    assert summary["si"]["mu_sliding"] == mu == float(run.dataset["mu_sliding"][-1])
    assert "in_units_of" not in run.dataset["mu_sliding"].attrs
    assert float(to_si(run.dataset)["mu_sliding"][-1]) == mu
    assert scalars(summary)["mu_sliding"].value == mu
    (shown,) = [number for number in key_numbers(summary) if number.about.symbol == "mu_sliding"]
    assert (shown.text, shown.text_in_si) == (f"{mu:.4g}", "")
    cell = float(run.dataset["X"][1] - run.dataset["X"][0]) ** 2
    force = float(run.dataset["tau_x"].sum()) * cell * run.case.scales.a_over_R
    assert mu == pytest.approx(force * 3 / (2 * np.pi), rel=0.02)


def test_a_dimensionless_case_does_not_know_a_over_R():
    assert with_coefficients({"mu_sliding": 2.0, "H_c": 0.1}, None) == {"mu_sliding": 2.0, "H_c": 0.1}


def test_summaries_and_data_of_earlier_versions(run: ertel.Result):
    """They had units a/R, beside the number itself in SI."""
    unit, now = run.case.scales.a_over_R, run.summary
    assert as_now({**now, "mu_sliding": now["mu_sliding"] / unit})["mu_sliding"] == now["mu_sliding"]
    assert as_now(now) == now
    reached = {
        "kind": "impact",
        "max_approach": {"H_c": 1.0, "mu_sliding": 9.0},
        "si": {"max_approach": {"mu_sliding": 0.1}},
    }
    assert as_now(reached)["max_approach"] == {"H_c": 1.0, "mu_sliding": 0.1}
    attributes = {"in_units_of": "a*/R", "si_factor": unit, "si_name": "mu_sliding", "si_units": "1"}
    old = xr.Dataset({"mu_sliding": ("grid", run.dataset["mu_sliding"].values / unit, attributes)})
    np.testing.assert_allclose(one_number(old)["mu_sliding"], run.dataset["mu_sliding"], rtol=1e-14)
    assert "in_units_of" not in one_number(old)["mu_sliding"].attrs
    assert one_number(old)["mu_sliding"].attrs["si_factor"] == 1.0
    assert one_number(run.dataset) is run.dataset


def test_the_films_of_an_impact_stand_where_those_of_rolling_do():
    fall = ertel.impact(
        radius=0.01, ball_density=7850, speed=0.1, E_prime="226 GPa", oil=ertel.Oil(eta0=0.0186, alpha=20e-9),
        method="radial", nodes=33, until="max-approach",
    )  # fmt: skip
    summary = ertel.simulate(fall).summary
    for name, key in {"H_c": "h_c_m", "H_min": "h_min_m", "P_max": "p_max_Pa", "Delta": "approach_m"}.items():
        assert summary[name] == summary["max_approach"][name]
        assert summary["si"][key] == summary["si"]["max_approach"]["delta_m" if name == "Delta" else key]
    assert summary["si"]["delta_m"] == fall.scales.approach
    least, most = fall.parameters.impact_films
    assert least < summary["H_c"] < most < fall.parameters.trapped_film


def test_tables_show_the_value_and_the_extrapolated_one_with_the_error(run: ertel.Result):
    case, film = run.case, FormulaFilm("formula", 0.12, 0.06, "source", "valid", True)
    values = {"H_c": (0.10, 0.01, 0.11), "H_min": (0.04, 0.02, 0.05)}
    computed = {name: number(case.kind, case.scales, name, *known) for name, known in values.items()}
    columns = list(zip(*film_rows(case, [film], computed), strict=True))
    assert columns[0][1:] == ("computed", "computed, extrapolated", "formula")
    assert columns[2][1:] == ("+-10.0%", "", "+9.1%") and columns[4][1:] == ("+-50.0%", "", "+20.0%")
    head, row = value_rows("", [computed["H_c"]])
    assert head[2:] == ["value", "in SI", "error", "extrapolated", "in SI"]
    assert float(row[6].split()[0]) == pytest.approx(1.1 * float(row[3].split()[0]), rel=1e-3)
