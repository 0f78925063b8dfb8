"""A new number is computed at one place and is a line of the table of variables; all views have it then."""

import json
from pathlib import Path

import pytest
from cases import BALL
from made_up import BALL_ROLLS, solutions, steady

import ertel
from ertel.apps.browser.pictures import run_info, stamp_of
from ertel.apps.looking import _print_runs, listed
from ertel.apps.tables import print_summary
from ertel.case.status import Status
from ertel.results.dataset import to_csv
from ertel.results.numbers import key_numbers, pairs, scalars
from ertel.results.study_table import StudyRun, study_dataset
from ertel.results.summary import comparisons, steady_summary, with_error
from ertel.results.variables import FILM, VARIABLES, Variable
from ertel.runs.study_result import StudyResult
from ertel.solvers.radial import RadialImpact

MEAN = Variable(
    "mean film thickness", "H_mean", *FILM, "h_mean",
    over="step", at_moment=True, shown=True, has_error=True, panel="Mean film",
)  # fmt: skip
RADIAL = {"nodes": 33, "method": "radial", "time_tolerance": 1e-2, "until": "max-approach"}
CASE = ertel.impact(**BALL, oil=ertel.Oil(eta0="40 mPa*s", alpha="20 / GPa"), **RADIAL)


@pytest.fixture(autouse=True)
def new_number(monkeypatch: pytest.MonkeyPatch) -> None:
    """The two places: where the values of a film are computed, and the table."""
    measure = RadialImpact.measure

    def with_mean(method: RadialImpact, level: object) -> dict[str, float]:
        values = measure(method, level)
        return {**values, "H_mean": (values["H_c"] + values["H_min"]) / 2}

    monkeypatch.setattr(RadialImpact, "measure", with_mean)
    monkeypatch.setitem(VARIABLES, "H_mean", MEAN)


def test_all_views_of_a_run_and_of_a_study_have_it(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    result, film = ertel.run(CASE, tmp_path / "run"), CASE.scales.film
    summary = json.loads((tmp_path / "run" / "summary.json").read_text())
    H = summary["H_mean"]
    assert H == pytest.approx((summary["H_c"] + summary["H_min"]) / 2) == summary["si"]["h_mean_m"] / film
    assert float(result.dataset["H_mean"][-1]) > 0 and result.si["h_mean"].attrs["long_name"] == "mean film thickness"
    assert "mean film thickness H_mean" in repr(result) and "H_mean" in result._repr_html_()
    assert "h_mean_m" in to_csv(result.si, tmp_path)[0].read_text().splitlines()[0]
    assert "h_mean" in [row["name"] for row in pairs(summary, summary)]
    print_summary(CASE, summary)
    assert "mean film thickness" in capsys.readouterr().out
    _print_runs(listed(tmp_path), tmp_path)
    assert "H_mean" in capsys.readouterr().out
    for shown in (key_numbers(summary), run_info(tmp_path / "run", stamp_of(tmp_path / "run")).latest):  # in the app
        assert "H_mean" in [number.name for number in shown]
    other = {**summary, "H_c": 1, "H_min": 1, "H_mean": 1}
    estimates = with_error(CASE, summary, {part: dict(other) for part in comparisons(CASE)})
    assert estimates["error_estimate"]["H_mean"]["value"] == H

    runs = [StudyRun(scalars(summary), [], "converged", name) for name in "ab"]
    about = {"title": "speeds", "kind": "impact"}
    study = StudyResult(study_dataset("product", {"speed": ([0.1, 0.2], {"units": "m/s"})}, runs, about))
    assert study.dataset["h_mean"].values.tolist() == [H * film] * 2 and "h_mean_m" in study.rows()[0]
    assert any(column[0].startswith("h_mean (") for column in study.table())
    assert any("mean film thickness" in axes.get_ylabel() for axes in study.plot().axes)


def test_a_steady_contact_has_it_on_each_grid_and_in_its_summary() -> None:
    case = BALL_ROLLS
    assert steady(case)["H_mean"].dims == ("grid",)
    summary = steady_summary(case, solutions(case), {}, Status.CONVERGED)
    assert summary["H_mean"] == 1.0
    assert "mean film thickness" in [number.about.long_name for number in key_numbers(summary)]


def test_another_method_that_does_not_compute_it_does_without(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(VARIABLES, "H_other", MEAN)
    result = ertel.simulate(CASE)
    assert result.status.ok and "H_other" not in scalars(result.summary)
    assert result.dataset["H_other"].isnull().all()
