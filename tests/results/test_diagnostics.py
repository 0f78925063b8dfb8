"""Warnings: they come where they should, and their advice can be taken."""

import re
from dataclasses import dataclass, replace

import numpy as np
import pytest
import xarray as xr
from cases import impact

from ertel.inputs.case_files import parse_case
from ertel.numerics.grid import check_nodes
from ertel.physics.surfaces import Feature, RingWaviness, Spot, Waviness
from ertel.results import diagnostics
from ertel.runs.outlook import outlook


def said(case, half_width=2.0):
    """The warnings of an impact of which no map was kept yet."""
    nodes = case.solver.nodes
    data = xr.Dataset(
        {"H_min": ("time", np.array([0.1])), "X_min": ("time", np.array([0.0])), "P": (("frame",), np.zeros(0))},
        {"time": np.array([0.1]), "X": np.linspace(-half_width, half_width, nodes)},
    )
    return " ".join(diagnostics.impact_warnings(case, data))


def test_the_small_example_of_the_readme_does_not_hide_that_its_minimum_film_is_uncertain():
    text = said(impact(1000, 10, 129))
    assert "the film is not resolved at the front (3.8 cells" in text
    assert "H_min is uncertain; use solver.nodes >= 353" in text


@pytest.mark.parametrize("nodes", [65, 129, 257])
def test_advised_nodes_are_allowed_and_enough(nodes):
    advised = int(re.search(r"nodes >= (\d+)", said(impact(1000, 10, nodes)))[1])
    check_nodes(advised)
    assert "not resolved" not in said(impact(1000, 10, advised))


@dataclass(frozen=True)
class Hill:
    """A shape that says nothing of its size."""

    def heights(self, X, Y):
        return 0.0 * X


@pytest.mark.parametrize(
    ("shape", "size"),
    [
        (Waviness(0.01, 0.5, 0.25), 0.25),
        (Waviness(0.01, 0.5), 0.5),
        (RingWaviness(0.01, 0.4), 0.4),
        (Spot(0.2, 0.1), 0.4),
        (Hill(), None),
    ],
)
def test_roughness_knows_its_size(shape, size):
    warnings = said(replace(impact(20, 5, 65), roughness=(Feature(shape),)))
    assert getattr(shape, "size", None) == size
    assert ("roughness" in warnings) == (size is not None)
    assert size is None or f"smallest width {size:g} a" in warnings


@pytest.mark.parametrize(
    ("M", "L", "nodes", "speaks"),
    [(1000, 10, 129, True), (200, 10, 129, True), (200, 10, 257, False), (20, 10, 65, False), (100, 0, 129, False)],
)
def test_rolling_in_time_says_whether_its_film_is_resolved(M, L, nodes, speaks):
    """H_c of reference/rolling.json is off by 35, 7.4, 1.9, 3.1 and 3.3 % there."""
    oil = {"viscosity": "barus" if L else "isoviscous", "density": "incompressible"}
    case = parse_case(
        {
            "contact": {"kind": "rolling", "M": M, "L": L},
            "lubricant": oil,
            "solver": {"method": "transient", "nodes": nodes},
        }
    )
    T = np.array([0.1, 0.2])
    names = {"H_min": 0.1, "X_min": 0.0, "U": 1.0, "dT": 0.1}
    data = xr.Dataset({name: ("time", np.full(2, value)) for name, value in names.items()}, {"time": T})
    text = " ".join(diagnostics.rolling_warnings(case, data.assign(P=("frame", np.zeros(0)))))
    assert ("the film is not resolved in the inlet" in text) == speaks
    if speaks:
        check_nodes(int(re.search(r"nodes >= (\d+)", text)[1]))


SLIDING = {"radius": "10 mm", "E_prime": "226 GPa", "load": "20 N", "mean_speed": "1 m/s", "slide_to_roll": 0.1}
EYRING = {"law": "ree-eyring", "tau0": "5 MPa"}
LIMITED = {"law": "limited", "base": EYRING, "Lambda": 0.05}


@pytest.mark.parametrize(
    ("contact", "lubricant", "pressure"),
    [
        ({}, {}, "0.79"),
        ({"slide_to_roll": 0.0}, {}, ""),
        ({"slide_to_roll": 0.0}, {"rheology": LIMITED}, "0.79"),
        ({}, {"viscosity": "roelands"}, ""),
        ({"load": "12 N"}, {"rheology": EYRING}, ""),
    ],
)
def test_traction_by_barus_above_its_pressures(contact, lubricant, pressure):
    """Of p_h = 0.79 GPa at 20 N and 0.67 GPa at 12 N."""
    oil = {"eta0": "40 mPa*s", "alpha": "20 / GPa", "viscosity": "barus", **lubricant}
    text = before_rolling({**SLIDING, **contact}, oil)
    assert ('lubricant.viscosity = "barus": greatly overestimates the viscosity' in text) == bool(pressure)
    assert (f"above 0.7 GPa, and this contact has {pressure} GPa" in text) == bool(pressure)
    assert ('use "roelands"' in text) == bool(pressure)


def test_traction_by_barus_under_a_load_that_grows():
    oil, light = {"eta0": "40 mPa*s", "alpha": "20 / GPa", "viscosity": "barus"}, {**SLIDING, "load": "10 N"}
    assert "barus" not in before_rolling(light, oil)
    assert "has 0.79 GPa" in before_rolling(light, oil, load=[[0.0, 1.0], [5.0, 2.0]])


def before_rolling(contact, oil, **motion):
    """The warnings of the friction of rolling in time; the coefficient is small, and zero without sliding."""
    solver = {"method": "transient", "nodes": 65}
    source = {"contact": {"kind": "rolling", **contact}, "lubricant": oil, "solver": solver, "motion": motion}
    case = parse_case(source)
    return " ".join(diagnostics.friction_warnings(case, case.motion.slide_to_roll))


@pytest.mark.parametrize(
    ("rheology", "coefficient", "expected"),
    [
        ("newtonian", 6.0, ["coefficient 6 is larger than that of any oil (about 0.1): ", "; give lubricant.rheology"]),
        (EYRING, 0.3, ["coefficient 0.3 is larger than that of any oil", "; check lubricant.rheology, or give it a"]),
        (EYRING, 0.05, []),
        (EYRING, -0.05, []),
        (EYRING, -0.2, ["coefficient 0.2"]),
    ],
)
def test_a_traction_that_means_nothing_is_said(rheology, coefficient, expected):
    oil = {"eta0": "40 mPa*s", "alpha": "20 / GPa", "rheology": rheology}
    case = parse_case({"contact": {"kind": "rolling", **SLIDING}, "lubricant": oil, "solver": {"nodes": 65}})
    text = " ".join(diagnostics.friction_warnings(case, coefficient))
    assert bool(text) == bool(expected)
    assert all(part in text for part in expected)


@pytest.mark.parametrize(
    ("lambda_bar", "nodes", "H_min_error", "speaks"),
    [(0.1, 65, 0.28, False), (0.01, 65, 1.3, False), (1e-3, 97, 6.2, True), (1e-3, 193, 1.5, False),
     (1e-4, 129, 37.0, True), (1e-4, 257, 8.1, True), (1e-4, 385, 3.3, False)],
)  # fmt: skip
def test_the_front_of_an_isoviscous_impact(lambda_bar, nodes, H_min_error, speaks):
    """It warns where H_min of the radial method is off by more than 5 % (of 1025 nodes); H_c is right to 0.16 %."""
    oil = {"viscosity": "isoviscous", "density": "incompressible"}
    contact = {"lambda_bar": lambda_bar, "alpha_bar": 0.0}
    case = parse_case({"contact": contact, "lubricant": oil, "solver": {"method": "radial", "nodes": nodes}})
    assert (H_min_error > 5.0) == speaks
    text = " ".join(outlook(case)["warnings"])
    assert ("not resolved at the front" in text) == speaks
    if speaks:
        assert int(re.search(r"nodes >= (\d+)", text)[1]) < 400
