"""A result shows its key numbers, in SI where it can, and its pictures."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from cases import python
from made_up import BALL_FALLS, BALL_ROLLS, C1, MOES_FALLS, MOES_ROLLS, dry_impact, in_time, solutions, steady
from matplotlib.figure import Figure

from ertel import plots
from ertel.case.status import Status
from ertel.inputs.case_files import parse_case
from ertel.results.dataset import provenance
from ertel.results.result import Result
from ertel.results.summary import impact_summary, rolling_summary, steady_summary
from ertel.results.variables import to_si

WORK = {"steps": 78, "newton_iterations": 80, "krylov_iterations": 200, "wall_s": 1.0}
MAXIMUM = {"T": 2.45, "Delta": 1.0, "F": 1.0, "P_c": 1.2, "P_max": 1.3, "H_c": 0.07, "H_min": 0.02}
MAXIMUM |= {"X_min": 0.9, "Y_min": 0.0, "power_loss": 0.004}


def impact(case_data, reached=MAXIMUM, **more):
    case, data = parse_case(case_data), dry_impact(case_data)
    summary = impact_summary(case, data, reached, WORK, Status.CONVERGED)
    return Result(case, data, {**summary, **more}, Status.CONVERGED)


def rolling(case):
    case = replace(case, solver=replace(case.solver, nodes=129))
    summary = steady_summary(case, solutions(case), {"wall_s": 1.0}, Status.CONVERGED)
    return Result(case, steady(case), summary, Status.CONVERGED)


def rolling_in_time(case):
    data = in_time(case)
    case = replace(case, solver=replace(case.solver, method="transient"))
    return Result(case, data, rolling_summary(case, data, WORK, Status.CONVERGED), Status.CONVERGED)


def test_repr_of_a_physical_impact():
    estimate = {"H_c": {"error": 0.0007, "extrapolated": 0.0693}, "H_min": {"error": 0.002, "extrapolated": 0.018}}
    result = impact({**BALL_FALLS, "name": "ball"}, error_estimate=estimate, restitution=0.93)
    text = repr(result)
    film = result.case.scales.film * 1e9
    assert text.startswith("Result: ball, converged\n  impact (2d), M = ")
    assert "at maximum approach" in text
    assert f"{0.07 * film:.4g} nm (0.07 a*^2/R), error 1.0%" in text
    assert "error 10.0%" in text
    assert "GPa (1.3 p_h*)" in text
    assert "(0.004 F* a*^2/(R t0))" in text and "traction" not in text
    assert "coefficient of restitution e  0.9300" in text
    assert len(text.splitlines()) < 15


def test_repr_carries_the_warnings():
    result = impact({**MOES_FALLS, "solver": {"nodes": 81}})
    (warning,) = [warning for warning in result.warnings if "not resolved at the front" in warning]
    assert f"warning: {warning}" in repr(result)
    assert warning in result._repr_html_().replace("&#x27;", "'").replace("&gt;", ">")


def test_repr_of_a_steady_contact(tmp_path: Path):
    result = rolling(BALL_ROLLS)
    text = repr(replace(result, directory=tmp_path))
    assert text.startswith("Result: steel_ball, converged\n  rolling (steady), M = 200, L = 10\n  on 129 x 129 nodes")
    assert f"{0.095 * C1.film * 1e9:.4g} nm (0.095 a^2/R), error 1.8%" in text
    assert f"stored in {tmp_path}" in text


def test_what_is_missing_is_not_shown():
    before = impact(MOES_FALLS, reached=None)
    assert "maximum approach was not reached" in repr(before)
    assert "<table>" not in before._repr_html_()
    assert "<img" not in replace(before, dataset=before.dataset.isel(frame=slice(0, 0)))._repr_html_()


def test_summary_is_plain_data_that_shows_little():
    result = rolling(BALL_ROLLS)
    plain = json.loads(json.dumps(result.summary))
    assert plain == {**result.summary} and isinstance(result.summary, dict)
    assert repr(result.summary).startswith("Summary: converged")
    assert len(repr(result.summary).splitlines()) < 12
    assert "central film thickness" in result.summary._repr_html_()


def test_a_notebook_gets_a_table_and_a_picture():
    html = rolling(BALL_ROLLS)._repr_html_()
    assert "<b>steel_ball</b>" in html
    assert "<td>H_min</td>" in html and "<th>in SI</th>" in html and "<th>error</th>" in html
    assert 'src="data:image/png;base64,iVBOR' in html


def test_a_dimensionless_run_in_time_has_no_column_in_si():
    result = rolling_in_time(MOES_ROLLS)
    text, html = repr(result), result._repr_html_()
    assert "at T = 4" in text and "0.08486 a^2/R" in text and "nm" not in text
    assert "<th>in SI</th>" not in html and "<th>error</th>" not in html


def test_si():
    result = rolling(BALL_ROLLS)
    np.testing.assert_allclose(result.si["h_c"].values, result.dataset["H_c"].values * C1.film)
    with pytest.raises(ValueError, match="dimensionless and has no SI scales"):
        _ = rolling(MOES_ROLLS).si


def test_plots_of_a_result():
    """They are found by their names; `plots.draw` has tests of every figure of every kind of run."""
    result, moving = rolling(MOES_ROLLS), impact(MOES_FALLS)
    assert "midlines" in dir(result.plot) and "history" not in dir(result.plot)
    assert repr(result.plot).startswith("Plot: overview(), film()")
    for data, known in ((result, plots.STEADY), (moving, plots.IN_TIME)):
        assert set(dir(data.plot)) - {"dataset"} <= set(known)
    assert result.plot.film()._repr_png_().startswith(b"\x89PNG")  # as a notebook shows it
    assert "chosen map at $T$ = 2" in moving.plot.profiles(at=2.0).get_suptitle()
    with pytest.raises(ValueError, match="no such figure"):
        moving.plot.convergence()


def test_dataset_ertel_of_a_run_that_xarray_alone_has_opened(tmp_path):
    data = dry_impact(BALL_FALLS).assign_attrs(provenance(parse_case(BALL_FALLS)))
    data.to_zarr(tmp_path / "run.zarr")
    opened = xr.open_zarr(tmp_path / "run.zarr")
    assert isinstance(opened.ertel.plot.film(), Figure)
    assert "film()" in repr(opened.ertel) and "interferogram()" in repr(opened.ertel)
    xr.testing.assert_identical(opened.ertel.si(), to_si(opened))
    assert opened.ertel.si()["h_c"].attrs["units"] == "m"
    with pytest.raises(ValueError, match="dimensionless"):
        dry_impact(MOES_FALLS).ertel.si()


def test_what_is_imported_and_when():
    """`dataset.ertel` is there with whatever makes or opens a run; `import ertel` imports no xarray.

    Matplotlib comes only with a picture.
    """
    code = """
import json, sys, xarray, ertel
before = hasattr(xarray.Dataset, "ertel")
ertel.simulate
import ertel.results.result
print(json.dumps([before, hasattr(xarray.Dataset, "ertel"), "matplotlib" in sys.modules]))
"""
    assert json.loads(python("-c", code).stdout) == [False, True, False]
