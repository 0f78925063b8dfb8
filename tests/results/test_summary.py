"""The outcome of a run as plain data: values in SI, film formulas, the extremes of a run in time."""

import numpy as np
import pytest
import xarray as xr
from made_up import BALL_ROLLS, C1, MOES_FALLS, MOES_ROLLS, as_in_time, dry_impact, in_time

from ertel.case.status import Status
from ertel.inputs.case_files import parse_case
from ertel.physics import hertz
from ertel.results import parameters, variables
from ertel.results.numbers import lines, more_lines
from ertel.results.summary import extremes, impact_summary, rolling_summary

BALL = {"radius": "10 mm", "mass": "32.6726 g", "speed": "0.1 m/s", "E_prime": "226.37 GPa"}
ROLLING = {  # of reference/rolling.json, M = 20, L = 10
    **{"kind": "rolling", "radius": "10 mm", "E_prime": "219.7802 GPa"},
    **{"load": "3.888524 N", "mean_speed": "0.502636 m/s"},
}
ROLLING_OIL = {"viscosity": "barus", "density": "incompressible", "eta0": "40 mPa*s", "alpha": "22 / GPa"}
OIL = {"eta0": "0.1 Pa*s", "alpha": "22 / GPa"}


def test_si_summary_has_units_in_its_names():
    case = parse_case({"contact": BALL, "lubricant": OIL})
    scales = case.scales
    assert scales is not None
    film, pressure, place = scales.film, scales.p_h, scales.a
    assert variables.values_in_si(dict.fromkeys(variables.AT_MAXIMUM, 1.0), scales) == {
        **{"t_s": scales.t0, "delta_m": film, "f_N": scales.load, "p_c_Pa": pressure, "p_max_Pa": pressure},
        **{"h_c_m": film, "h_min_m": film, "x_min_m": place, "y_min_m": place},
    }
    dimensionless = impact_summary(parse_case(MOES_FALLS), dry_impact(MOES_FALLS), None, {}, Status.CONVERGED)
    assert "si" not in dimensionless


def test_duration_and_largest_load_of_an_impact():
    """Of the dry one F = Delta^(3/2), so that F = 0.01 at Delta = 0.01^(2/3)."""
    case, data = parse_case({"contact": BALL, "lubricant": OIL}), dry_impact(MOES_FALLS)
    assert impact_summary(case, data, None, {}, Status.CONVERGED)["contact_time"] is None  # not yet free
    left = data.assign(F=data["F"].where(data["time"] < 3.9, 0.0))
    summary = impact_summary(case, left, None, {}, Status.CONVERGED)
    duration = hertz.CONTACT_TIME - 2 * float(hertz.time_at(0.01 ** (2 / 3)))
    assert summary["contact_time"] == pytest.approx(duration, abs=0.02)  # the steps are 0.05
    assert summary["F_max"] == pytest.approx(1.0, abs=1e-3)
    assert case.scales is not None
    assert summary["si"]["t_contact_s"] == pytest.approx(summary["contact_time"] * case.scales.t0)
    assert summary["si"]["f_max_N"] == pytest.approx(summary["F_max"] * case.scales.load)


def test_films_of_another_load_and_speed():
    """As if the case had been given with them."""
    a = parse_case({"contact": ROLLING, "lubricant": ROLLING_OIL})
    other = {"load": f"{2 * 3.888524!r} N", "mean_speed": f"{3 * 0.502636!r} m/s"}
    b = parse_case({"contact": ROLLING | other, "lubricant": ROLLING_OIL})
    assert a.scales is not None and b.scales is not None
    for one, two in zip(parameters.formula_films(a, 2.0, -3.0), parameters.formula_films(b), strict=True):
        for p, q in ((one.central, two.central), (one.minimum, two.minimum)):
            assert (p is None and q is None) or p * a.scales.film == pytest.approx(q * b.scales.film)
    assert parameters.formula_films(a, 1.0, 0.0) == []


# -- extremes ----------------------------------------------------------------------------------------------------------

WORK = {"steps": 1, "newton_iterations": 1, "krylov_iterations": 1, "wall_s": 1.0}


def with_a_peak(data: xr.Dataset, fall: float) -> xr.Dataset:
    """The highest pressure, 3.2, at the eighth step."""
    at = np.arange(data.sizes["time"]) == 7
    places = {"P_max": 3.2, "X_P_max": 0.9, "Y_P_max": -0.1, "P_fall": fall}
    return data.assign({name: ("time", np.where(at, value, data[name].values)) for name, value in places.items()})


def test_the_extremes_of_the_whole_run() -> None:
    data = with_a_peak(in_time(MOES_ROLLS), 0.02)
    both = extremes(data)
    thin = int(np.argmin(data["H_min"].values))
    assert both["H_min"]["value"] == float(data["H_min"].values.min()) < float(data["H_min"].values[0])
    assert both["H_min"]["T"] == float(data["time"].values[thin])
    assert (both["H_min"]["X"], both["H_min"]["Y"], both["H_min"]["note"]) == (0.2, 0.8, "")
    assert both["P_max"] == {"value": 3.2, "T": pytest.approx(0.7), "X": 0.9, "Y": -0.1, "note": ""}
    assert extremes(data.isel(time=slice(0, 0))) == {}


def test_a_peak_as_narrow_as_the_grid_is_said_to_be_the_grids() -> None:
    data = with_a_peak(in_time(MOES_ROLLS), 0.85)
    summary = rolling_summary(as_in_time(MOES_ROLLS), data, WORK, Status.CONVERGED)
    (line,) = [line for line in lines(summary) if "highest pressure" in line]
    assert "P_max: 3.2 p_h at T = 0.7 t0, X = 0.9, Y = -0.1 a; it depends on the grid" in line
    assert "85% lower" in line


def test_the_extremes_in_si() -> None:
    data = with_a_peak(in_time(BALL_ROLLS), 0.02)
    summary = rolling_summary(as_in_time(BALL_ROLLS), data, WORK, Status.CONVERGED)
    peak = summary["si"]["extremes"]["P_max"]
    assert peak == {
        "p_max_Pa": pytest.approx(3.2 * C1.p_h),
        "t_s": pytest.approx(0.7 * C1.t0),
        "x_m": pytest.approx(0.9 * C1.a),
        "y_m": pytest.approx(-0.1 * C1.a),
    }
    thinnest, highest = list(more_lines(summary))[:2]
    assert "nm (" in thinnest and "GPa (3.2 p_h) at t = " in highest and "µm" in highest
