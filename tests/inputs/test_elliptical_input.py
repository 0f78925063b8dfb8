"""Elliptical contacts as a user gives them: radii of both bodies, reduced radii, or a ratio; and what is refused."""

import json

import pytest
from cases import ertel_

import ertel
from ertel.case.definition import grid_of
from ertel.inputs.case_files import load_case, parse_case
from ertel.physics.geometry import CIRCLE, Geometry

ROLLING = {"kind": "rolling", "load": "100 N", "mean_speed": "0.5 m/s", "E_prime": "226.37 GPa"}
IMPACT = {"mass": "33 g", "speed": "0.1 m/s", "E_prime": "226.37 GPa"}
OIL = {"eta0": "40 mPa*s", "alpha": "22 / GPa"}
REDUCED = {"radius_x": "10 mm", "radius_y": "50 mm"}
MOES = {"M": 200, "L": 10}


def case_of(contact: dict, **sections: dict) -> ertel.Case:
    oil = {} if "M" in contact else {"lubricant": OIL}
    return parse_case({"contact": contact, **oil, **sections})


@pytest.mark.parametrize(
    "radii",
    [
        REDUCED,
        {"radius_x_1": "10 mm", "radius_y_1": "50 mm"},  # against a plane
        {"radius_x_1": "20 mm", "radius_x_2": "20 mm", "radius_y_1": "25 mm", "radius_y_2": "-50 mm"},
    ],
)
def test_the_worked_example_in_three_ways(radii: dict) -> None:
    case = case_of({**ROLLING, **radii})
    assert (case.scales.a, case.parameters.M_BH) == pytest.approx((139.690e-6, 185.188), rel=4e-6)
    assert case.parameters.radius_ratio == pytest.approx(0.2)


def test_a_ball_in_the_groove_of_an_inner_ring() -> None:
    """A ball of 6 mm radius on an inner ring of 20 mm with a groove of 6.24 mm: 1/R_x = 1/6 + 1/20, 1/R_y = 1/156."""
    bodies = {"radius_x_1": "6 mm", "radius_y_1": "6 mm", "radius_x_2": "20 mm", "radius_y_2": "-6.24 mm"}
    case = case_of({**ROLLING, **bodies})
    assert case.scales.R == pytest.approx(60 / 13 * 1e-3)
    assert case.parameters.radius_ratio == pytest.approx(60 / 13 / 156)


def test_equal_radii_are_the_circle() -> None:
    one = case_of({**ROLLING, "radius_x": "10 mm", "radius_y": "10 mm"})
    ball = case_of({**ROLLING, "radius": "10 mm"})
    assert one.geometry is CIRCLE
    assert (one.scales, one.parameters, one.solver) == (ball.scales, ball.parameters, ball.solver)


def test_keywords_are_those_of_case_files(tmp_path) -> None:
    path = tmp_path / "case.toml"
    path.write_text('[contact]\nkind = "rolling"\nM = 200\nL = 10\nradius_ratio = 0.4\nentrainment_angle = "0.5 rad"\n')
    case = ertel.rolling(M=200, L=10, radius_ratio=0.4, entrainment_angle="0.5 rad")
    assert load_case(path).contact == case.contact
    assert case.contact.angle == pytest.approx(28.64788975654)
    assert ertel.rolling(M=200, L=10, radius_ratio=0.4, entrainment_angle=30).geometry == Geometry(0.4, 30.0)
    assert ertel.rolling(M=200, L=10, radius_ratio=0.4, entrainment_angle="90 deg").geometry == Geometry(0.4, 90.0)
    assert ertel.Case.from_data(case.to_data()) == case
    slender = ertel.impact(radius_x=0.01, radius_y=0.05, **IMPACT, oil=ertel.Oil(**OIL))
    assert slender.parameters.radius_ratio == pytest.approx(0.2)


# -- the default domain -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", ["impact", "rolling"])
@pytest.mark.parametrize("D", [0.05, 0.3, 1.0, 3.0, 20.0])
@pytest.mark.parametrize("angle", [0.0, 35.0, 90.0])
def test_the_default_grid_follows_the_ellipse(kind: str, D: float, angle: float) -> None:
    """Distances from the contact, and the spacing, are those of the circle in units of the smaller half width."""
    turned = {"entrainment_angle": f"{angle} deg"} if angle else {}
    drive = {"motion": {"entrainment": 0.5}} if kind == "impact" and angle else {}
    case = case_of({"kind": kind, **MOES, "radius_ratio": D, **turned}, **drive)
    grid, unit, (wide, high) = grid_of(case), case.geometry.smaller, case.geometry.extent
    circle = grid_of(case_of({"kind": kind, "M": case.parameters.as_ball.M, "L": 10.0}))
    left, right = (1e-9 + (abs(edge) - 1) * unit for edge in (circle.x[0], circle.x[-1]))
    assert -grid.x[0] - wide >= 0.94 * left and grid.x[-1] - wide >= 0.94 * right - 0.02
    assert grid.x[-1] - grid.x[0] >= 2 * wide + left + right - 1e-6
    assert grid.y[-1] - high >= 0.999 * unit * (circle.y[-1] - 1)
    assert 0.8 * circle.spacing * unit < grid.spacing <= 1.15 * circle.spacing * unit
    assert all((abs(axis) < 1e-9).any() for axis in (grid.x, grid.y))  # a node at zero


def test_a_half_grid_covers_the_same_domain() -> None:
    case = case_of({"kind": "rolling", **MOES, "radius_ratio": 0.17}, solver={"nodes": 129})
    fine, half = grid_of(case), grid_of(case.on_half_grid())
    assert (half.nodes_x, half.nodes_y) == ((fine.nodes_x + 1) // 2, (fine.nodes_y + 1) // 2)
    assert (half.x[0], half.y[0]) == pytest.approx((fine.x[0], fine.y[0]))


# -- the command line -------------------------------------------------------------------------------------------------

CONTACT = {f"contact.{key}": value for key, value in ROLLING.items()}
CONTACT |= {f"lubricant.{key}": value for key, value in OIL.items()}


def answer(command: str, **radii: str) -> dict:
    given = CONTACT | {f"contact.{key}": value for key, value in radii.items()}
    words = [word for key, value in given.items() for word in ("--set", f"{key}={value}")]
    return json.loads(ertel_(command, *words, "--json").stdout)


def test_params_and_films_of_the_worked_example() -> None:
    content = answer("params", radius_x_1="10 mm", radius_y_1="20 mm", radius_y_2="-33.333333333 mm")
    named = {"lambda_bar": 0.01039991, "alpha_bar": 18.62553, "M": 512.567, "L": 10.21061}
    named |= {"M_BH": 185.188, "L_BH": 8.96790, "radius_ratio": 0.2, "kappa": 0.345999}
    assert {name: content[name] for name in named} == pytest.approx(named, rel=4e-6)
    si = {"a_m": 139.690e-6, "a_y_m": 403.729e-6, "p_h_Pa": 846.615e6, "delta_m": 2.60564e-6}
    assert {name: content["si"][name] for name in si} == pytest.approx(si, rel=4e-6)
    films = {row["name"]: row["si"] for row in answer("film", **REDUCED)["films"]}
    assert films["Nijenbanning-Venner-Moes"]["h_c_m"] == pytest.approx(203.69e-9, abs=5e-12)
