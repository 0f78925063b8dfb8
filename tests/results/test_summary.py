"""The outcome of a run as plain data."""

from ertel.inputs.case_files import parse_case
from ertel.results import variables
from ertel.results.summary import si_summary

BALL = {"radius": "10 mm", "mass": "32.6726 g", "speed": "0.1 m/s", "E_prime": "226.37 GPa"}
OIL = {"eta0": "0.1 Pa*s", "alpha": "22 / GPa"}


def test_si_summary_has_units_in_its_names():
    case = parse_case({"contact": BALL, "lubricant": OIL})
    values = dict.fromkeys(variables.AT_MAXIMUM, 1.0)
    si = si_summary(case, values)
    assert si is not None and case.scales is not None
    assert si["max_approach"] == {
        "t_s": case.scales.t0,
        "delta_m": case.scales.film,
        "f_N": case.scales.load,
        "p_c_Pa": case.scales.p_h,
        "p_max_Pa": case.scales.p_h,
        "h_c_m": case.scales.film,
        "h_min_m": case.scales.film,
        "x_min_m": case.scales.a,
    }
    assert si_summary(parse_case({"contact": {"M": 1, "L": 1}}), values) is None
