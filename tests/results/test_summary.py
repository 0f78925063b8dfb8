"""The outcome of a run as plain data."""

import pytest
from made_up import MOES_FALLS, dry_impact

from ertel.case.status import Status
from ertel.inputs.case_files import parse_case
from ertel.results import parameters, variables
from ertel.results.summary import impact_summary

BALL = {"radius": "10 mm", "mass": "32.6726 g", "speed": "0.1 m/s", "E_prime": "226.37 GPa"}
ROLLING = {  # of reference/rolling.json, M = 20, L = 10
    **{"kind": "rolling", "radius": "10 mm", "E_prime": "219.7802 GPa"},
    **{"load": "3.888524 N", "mean_speed": "0.502636 m/s"},
}
ROLLING_OIL = {"viscosity": "barus", "density": "incompressible", "eta0": "40 mPa*s", "alpha": "22 / GPa"}
OIL = {"eta0": "0.1 Pa*s", "alpha": "22 / GPa"}


def test_si_summary_has_units_in_its_names():
    case = parse_case({"contact": BALL, "lubricant": OIL})
    assert case.scales is not None
    assert variables.in_si(dict.fromkeys(variables.AT_MAXIMUM, 1.0), case.scales) == {
        "t_s": case.scales.t0,
        "delta_m": case.scales.film,
        "f_N": case.scales.load,
        "p_c_Pa": case.scales.p_h,
        "p_max_Pa": case.scales.p_h,
        "h_c_m": case.scales.film,
        "h_min_m": case.scales.film,
        "x_min_m": case.scales.a,
        "y_min_m": case.scales.a,
    }
    dimensionless = impact_summary(parse_case(MOES_FALLS), dry_impact(MOES_FALLS), None, {}, Status.CONVERGED)
    assert "si" not in dimensionless


def test_films_of_another_load_and_speed():
    """As if the case had been given with them."""
    a = parse_case({"contact": ROLLING, "lubricant": ROLLING_OIL})
    other = {"load": f"{2 * 3.888524!r} N", "mean_speed": f"{3 * 0.502636!r} m/s"}
    b = parse_case({"contact": ROLLING | other, "lubricant": ROLLING_OIL})
    assert a.scales is not None and b.scales is not None
    for one, two in zip(parameters.films(a, 2.0, -3.0), parameters.films(b), strict=True):
        for p, q in ((one.central, two.central), (one.minimum, two.minimum)):
            assert (p is None and q is None) or p * a.scales.film == pytest.approx(q * b.scales.film)
    assert parameters.films(a, 1.0, 0.0) == []
