"""A result shows its key numbers, in SI where it can, its pictures, and its outcome in one line."""

import json
from dataclasses import replace
from math import hypot
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr
from made_up import BALL_FALLS, BALL_ROLLS, C1, MOES_FALLS, MOES_ROLLS, dry_impact, in_time, solutions, steady
from matplotlib.figure import Figure

import ertel
from ertel.case.methods import METHODS
from ertel.case.status import Status
from ertel.inputs.case_files import parse_case
from ertel.physics.amplitude_reduction import lambda_ratio
from ertel.results.dataset import provenance
from ertel.results.figures import FIGURES_IN_TIME, FIGURES_STEADY
from ertel.results.numbers import key_numbers, scalars
from ertel.results.parameters import parameters_of, scale_values
from ertel.results.summary import impact_summary, rolling_summary, steady_summary
from ertel.runs.result import Result, verdict

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


def test_repr_of_a_physical_impact():
    estimate = {"H_c": {"error": 0.0007, "extrapolated": 0.0693}, "H_min": {"error": 0.002, "extrapolated": 0.018}}
    result = impact({**BALL_FALLS, "name": "ball"}, error_estimate=estimate, restitution=0.93)
    text = repr(result)
    assert text.startswith("Result: ball, converged\n  impact (2d), M = ")
    film = f"{0.0693 * result.case.scales.film * 1e9:.4g} nm (0.0693 a*^2/R) ± 1.0%"
    energy = "(0.004 F* a*^2/(R t0))"
    for part in ("at maximum approach", film, "± 11.1%", "GPa (1.3 p_h*)", energy, "restitution e  0.9300"):
        assert part in text
    assert "traction" not in text
    assert len(text.splitlines()) < 15


def test_a_steady_contact_as_text_as_plain_data_in_si_and_for_a_notebook(tmp_path: Path):
    result = rolling(BALL_ROLLS)
    text = repr(replace(result, directory=tmp_path))
    assert text.startswith("Result: steel_ball, converged\n  rolling (steady), M = 200, L = 10\n  on 129 x 129 nodes")
    best, bar = result.summary["H_c_extrapolated"], result.summary["H_c_error"]
    assert f"{best * C1.film * 1e9:.4g} nm ({best:.4g} a^2/R) ± {bar / best:.1%}" in text
    assert f"stored in {tmp_path}" in text
    assert json.loads(json.dumps(result.summary)) == {**result.summary} and isinstance(result.summary, dict)
    assert repr(result.summary).startswith("Summary: converged")
    assert len(repr(result.summary).splitlines()) < 13
    html = result._repr_html_()
    assert html.startswith("<pre>Result: steel_ball, converged") and 'src="data:image/png;base64,iVBOR' in html
    np.testing.assert_allclose(result.si["h_c"].values, result.dataset["H_c"].values * C1.film)


def test_a_dimensionless_run_in_time_has_no_column_in_si():
    data, case = in_time(MOES_ROLLS), replace(MOES_ROLLS, solver=METHODS["transient"].defaults)
    result = Result(case, data, rolling_summary(case, data, WORK, Status.CONVERGED), Status.CONVERGED)
    text = repr(result)
    assert "at T = 4" in text and "0.08486 a^2/R" in text and "nm" not in text
    with pytest.raises(ValueError, match="dimensionless and has no SI scales"):
        _ = result.si


def test_plots_of_a_result(tmp_path):
    """They are found by their names; `plots.draw` has tests of every figure of every kind of run."""
    result, moving = rolling(MOES_ROLLS), impact(MOES_FALLS)
    assert "midlines" in dir(result.plot) and "history" not in dir(result.plot)
    assert repr(result.plot).startswith("Plot: overview(), film()")
    for data, known in ((result, FIGURES_STEADY), (moving, FIGURES_IN_TIME)):
        assert set(dir(data.plot)) - {"dataset"} <= set(known)
    assert result.plot.film()._repr_png_().startswith(b"\x89PNG")  # as a notebook shows it
    assert "chosen map at $T$ = 2" in moving.plot.profiles(at=2.0).get_suptitle()
    with pytest.raises(ValueError, match="no such figure"):
        moving.plot.convergence()


def test_a_run_that_xarray_alone_has_opened(tmp_path):
    data = dry_impact(BALL_FALLS).assign_attrs(provenance(parse_case(BALL_FALLS)))
    data.to_zarr(tmp_path / "run.zarr")
    opened = xr.open_zarr(tmp_path / "run.zarr")
    assert isinstance(ertel.plots.film(opened), Figure)
    assert ertel.to_si(opened)["h_c"].attrs["units"] == "m"


FILM = {"H_c": 341e-9, "H_min": 200e-9, "H_c_error": 15e-9, "H_min_error": 8e-9}


def rolled(case=BALL_ROLLS, dataset=None, **more):
    """A steady run with known films, of which the case has the scales."""
    films = {name: value / C1.film for name, value in FILM.items()}
    films |= {f"{name}_extrapolated": films[name] for name in ("H_c", "H_min")}
    si = {"si": scale_values(case)} if case.scales else {}
    summary = {"kind": "rolling", **parameters_of(case), **films, "mu_sliding": -0.047, **si, **more}
    return Result(case, dataset, {**summary, "status": "converged", "warnings": []}, Status.CONVERGED)


def test_the_line_has_what_the_run_has():
    assert verdict(rolled()) == "film 341 ± 15 nm, mu = 0.047"
    assert verdict(rolled(), "60 nm", 80e-9) == "film 341 ± 15 nm, Lambda = 2, mu = 0.047"
    assert verdict(rolled(H_c_error=None, mu_sliding=0.0)) == "film 341 nm"
    assert verdict(rolled(H_c=None)) == ""
    assert verdict(rolled(MOES_ROLLS)).startswith("film 0.") and "mu" not in verdict(rolled(MOES_ROLLS))
    # with heat the film and the friction are the warm ones
    films = {"H_c_warm": 300e-9 / C1.film, "H_min_warm": 180e-9 / C1.film}
    heat = {**films, "mu_sliding_warm": 0.031, "T_film_mean": 324.0}
    thermal = SimpleNamespace(temperature=313.0)
    case = SimpleNamespace(features=(), surfaces=None, sigma=None, scales=C1, thermal=thermal)
    assert verdict(replace(rolled(**heat), case=case)) == "warm film 300 ± 13 nm, mu = 0.031, 11 K"
    doubtful = rolled(H_min_error=150e-9 / C1.film)
    assert key_numbers(doubtful.summary)[1].text == "not known"
    assert verdict(doubtful).startswith("film 341 ± 15 nm")
    assert "h_min" not in scalars(doubtful.summary) and "h_min_on_grid" in scalars(doubtful.summary)
    with pytest.raises(ValueError, match="the minimum film is not known"):
        doubtful.lambda_ratio("60 nm")


def test_the_lambda_ratio():
    assert lambda_ratio(3.0, 1.0) == 3.0 and lambda_ratio(5.0, 3.0, 4.0) == 1.0
    assert rolled().lambda_ratio("60 nm", "80 nm") == pytest.approx(2.0)
    assert rolled().lambda_ratio("Ra 48 nm", " Ra 64 nm") == pytest.approx(2.0)
    with pytest.raises(ValueError, match="sigma = -1: must not be negative"):
        lambda_ratio(1.0, -1.0)
    for sigma, case, message in (
        ((), BALL_ROLLS, "sigma_1: missing"),
        (("20 nm",), MOES_ROLLS, "lambda ratio: the case is dimensionless"),
        (("20",), BALL_ROLLS, "unit"),
    ):
        with pytest.raises(ValueError, match=message):
            rolled(case).lambda_ratio(*sigma)
    run = rolled(H_min_warm=150e-9 / C1.film, H_min_extrapolated=220e-9 / C1.film)
    assert run.lambda_ratio("55 nm") == pytest.approx(3.0)  # 150/200 of 220 nm, over 55 nm


def test_a_rough_surface_brings_its_own():
    """A map with a given rms on each surface; the film is the mean with the pressure as weight."""
    heights = np.random.default_rng(0).normal(size=(16, 16))
    maps = [ertel.Measured.of(each * 40e-9, 5e-6) for each in (heights, heights / 2)]
    rough = [ertel.Feature(shape, surface) for surface, shape in enumerate(maps, 1)]
    case = replace(BALL_ROLLS, roughness=tuple(rough), solver=replace(BALL_ROLLS.solver, method="transient"))
    H, P = np.array([[[1.0, 2.0], [4.0, 9.0]]]), np.array([[[0.0, 3.0], [1.0, 0.0]]])
    axes = "frame", "Y", "X"
    data = xr.Dataset({"H": (axes, H), "P": (axes, P), "event": ("frame", [2])}, {"frame": [1.0]})
    sigma = hypot(heights.std(), heights.std() / 2) * 40e-9
    assert rolled(case, data).lambda_ratio() == pytest.approx(2.5 * C1.film / sigma, rel=1e-3)
    assert f"Lambda = {2.5 * C1.film / sigma:.2g}" in verdict(rolled(case, data))
