"""Warnings: they come where they should, and their advice can be taken."""

import re
from dataclasses import dataclass, replace

import numpy as np
import pytest
from cases import impact

import ertel
from ertel.inputs.case_files import parse_case
from ertel.numerics.grid import check_nodes
from ertel.physics.surfaces import Feature, RingWaviness, Spot, Waviness
from ertel.results.diagnostics import case_warnings, resolution
from ertel.results.friction import friction_warnings
from ertel.runs.outlook import outlook

ISOVISCOUS = {"viscosity": "isoviscous", "density": "incompressible"}
BARUS = {**ISOVISCOUS, "viscosity": "barus"}


def advised(text):
    """The number of nodes that a warning advises, which is allowed."""
    nodes = int(re.search(r"nodes >= (\d+)", text)[1])
    check_nodes(nodes)
    return nodes


def test_advised_nodes_are_enough():
    """The small example of the README, of 129 nodes, does not hide that its minimum film is uncertain."""
    for nodes, said in ((65, ""), (129, "(3.8 cells"), (257, "")):
        [text] = resolution(impact(1000, 10, nodes))
        assert f"the film is not resolved at the front {said}" in text and "H_min is uncertain" in text
        assert nodes != 129 or advised(text) == 353
        assert not list(resolution(impact(1000, 10, advised(text))))


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
        (Waviness(0.01, wavelength_y=0.7), 0.7),
        (RingWaviness(0.01, 0.4), 0.4),
        (Spot(0.2, 0.1), 0.4),
        (Hill(), None),
    ],
)
def test_roughness_knows_its_size(shape, size):
    warnings = " ".join(case_warnings(replace(impact(20, 5, 65), roughness=(Feature(shape),))))
    assert getattr(shape, "size", None) == size
    assert ("roughness" in warnings) == (size is not None)
    assert size is None or f"smallest width {size:g} a" in warnings


@pytest.mark.parametrize(
    ("M", "L", "nodes", "speaks"),
    [(1000, 10, 129, True), (200, 10, 129, True), (200, 10, 257, False), (20, 10, 65, False), (100, 0, 129, False)],
)
def test_rolling_says_whether_its_film_is_resolved(M, L, nodes, speaks):
    """H_c of reference/rolling.json is off by 35, 7.4, 1.9, 3.1 and 3.3 % there."""
    solver, contact = {"method": "transient", "nodes": nodes}, {"kind": "rolling", "M": M, "L": L}
    case = parse_case({"contact": contact, "lubricant": BARUS if L else ISOVISCOUS, "solver": solver})
    text = " ".join(resolution(case, 1.0))
    assert ("the film is not resolved in the inlet" in text) == speaks
    assert not speaks or advised(text) > nodes


@pytest.mark.parametrize(
    ("lambda_bar", "nodes", "H_min_error", "speaks"),
    [(0.1, 65, 0.28, False), (0.01, 65, 1.3, False), (1e-3, 97, 6.2, True), (1e-3, 193, 1.5, False),
     (1e-4, 129, 37.0, True), (1e-4, 257, 8.1, True), (1e-4, 385, 3.3, False)],
)  # fmt: skip
def test_the_front_of_an_isoviscous_impact(lambda_bar, nodes, H_min_error, speaks):
    """It warns where H_min of the radial method is off by more than 5 % (of 1025 nodes); H_c is right to 0.16 %."""
    contact, solver = {"lambda_bar": lambda_bar, "alpha_bar": 0.0}, {"method": "radial", "nodes": nodes}
    text = " ".join(resolution(parse_case({"contact": contact, "lubricant": ISOVISCOUS, "solver": solver})))
    assert (H_min_error > 5.0) == speaks == ("not resolved at the front" in text)
    assert not speaks or advised(text) < 400


EYRING = {"law": "ree-eyring", "tau0": "5 MPa"}


def of_friction(coefficient, load="20 N", grows=1.0, **oil):
    """The warnings of the friction of rolling in time with this coefficient."""
    contact = {"kind": "rolling", "radius": "10 mm", "E_prime": "226 GPa", "load": load, "mean_speed": "1 m/s"}
    sections = {"lubricant": {"eta0": "40 mPa*s", "alpha": "20 / GPa", **oil}, "motion": {"load": grows}}
    case = parse_case({"contact": contact, **sections, "solver": {"method": "transient", "nodes": 65}})
    return " ".join(friction_warnings(case, coefficient))


@pytest.mark.parametrize(
    ("given", "speaks"),
    [
        ({"coefficient": 0.1}, True),
        ({"coefficient": 0.0}, False),
        ({"coefficient": 0.0, "rheology": {"law": "limited", "base": EYRING, "Lambda": 0.05}}, True),
        ({"coefficient": 0.1, "viscosity": "roelands"}, False),
        ({"coefficient": 0.05, "load": "12 N", "rheology": EYRING}, False),
        ({"coefficient": 0.1, "load": "10 N"}, False),
        ({"coefficient": 0.1, "load": "10 N", "grows": [["0 s", 1.0], ["5 s", 2.0]]}, True),
    ],
)
def test_traction_by_barus_above_its_pressures(given, speaks):
    """Of p_h = 0.79 GPa at 20 N and 0.67 GPa at 12 N."""
    text = of_friction(**{"viscosity": "barus", **given})
    for part in ('lubricant.viscosity = "barus": ', "above 0.7 GPa, and this contact has 0.79 GPa", 'use "roelands"'):
        assert (part in text) == speaks


@pytest.mark.parametrize(
    ("rheology", "coefficient", "expected"),
    [
        ("newtonian", 6.0, ["coefficient 6 is larger than that of any oil (about 0.1): ", "; give lubricant.rheology"]),
        (EYRING, 0.3, ["coefficient 0.3 is larger", "; check lubricant.rheology"]),
        (EYRING, 0.05, []),
        (EYRING, -0.05, []),
        (EYRING, -0.2, ["coefficient 0.2"]),
    ],
)
def test_a_traction_that_means_nothing_is_said(rheology, coefficient, expected):
    text = of_friction(coefficient, rheology=rheology)
    assert bool(text) == bool(expected) and all(part in text for part in expected)


def test_roughness_sliding_and_a_track_before_the_run():
    wavy = ertel.rolling(M=100, L=5, roughness=[Feature(Waviness(2.0, wavelength_y=0.5))])
    (rough,) = outlook(wavy)["roughness"]
    assert rough["shape"] == "Waviness"
    assert (rough["size"], rough["lowest"], rough["highest"]) == pytest.approx((0.5, -2.0, 2.0), rel=1e-2)
    assert rough["rms"] == pytest.approx(2.0 / np.sqrt(2), rel=0.02)
    for case, part in (
        (wavy, "roughness[1] stands 2 a^2/R high"),
        (ertel.rolling(M=100, L=5, motion={"slide_to_roll": 20}), "opposite directions"),
        (ertel.rolling(M=200, L=10, layer=[(0.0, 0.07)]), "has one point"),
        (ertel.rolling(M=200, L=10, layer=[(50.0, 0.07), (60.0, 0.08)]), "beside the grid"),
    ):
        assert any(part in text for text in outlook(case)["warnings"])
