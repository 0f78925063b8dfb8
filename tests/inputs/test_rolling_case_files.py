"""Case files of rolling and of elliptical contacts, and of motion: what they may say, and what it means."""

from math import pi
from typing import Any

import pytest
from cases import BALL

import ertel
from ertel.case.case import Case
from ertel.case.estimates import grid_of
from ertel.case.methods import METHODS
from ertel.inputs.case_files import parse_case
from ertel.physics.geometry import CIRCLE, Geometry
from ertel.physics.motion import STEADY_ROLLING, Motion, Oscillation, Polyline, constant

MOES = {"kind": "rolling", "M": 200, "L": 10}
TRACK = {"kind": "rolling", "radius": "10 mm", "load": "38.885237 N", "E_prime": "219.7802 GPa"}
C1 = {**TRACK, "mean_speed": "0.502636 m/s"}  # the dimensional case of reference/rolling.json


def case(contact: dict[str, Any] = MOES, **sections: Any) -> Case:
    oil = {} if "M" in contact else {"lubricant": {"eta0": "40 mPa*s", "alpha": "22 / GPa"}}
    return parse_case({"contact": contact, **oil, **sections})


def in_time(contact: dict[str, Any] = MOES, **sections: Any) -> Case:
    return case(contact, solver={"method": "transient"}, **sections)


def test_physical_input_is_the_reference():
    found = case(C1)
    given = [found.parameters.M, found.parameters.L, found.scales.a, found.scales.p_h, found.scales.front_speed]
    assert given == pytest.approx([200, 10, 1.384509e-4, 968577800.0, 0.502636], rel=1e-6)
    assert found.motion == STEADY_ROLLING
    assert found.solver == METHODS["steady"].defaults
    one = case(TRACK | {"speed_1": "0.6 m/s", "speed_2": "0.4 m/s"})
    two = case(TRACK | {"mean_speed": "0.5 m/s", "slide_to_roll": 0.4})
    found, expected = ((each.parameters.lambda_bar, each.motion.slide_to_roll) for each in (one, two))
    assert found == pytest.approx(expected, rel=1e-9)
    mass = 4 / 3 * pi * 0.01**3 * 7850
    one = in_time(C1 | {"ball_density": "7850 kg/m^3"})
    two = in_time(C1 | {"mass": f"{mass!r} kg"})
    s = one.scales
    assert one.motion.inertia == pytest.approx(mass * s.film / (s.load * s.t0**2), rel=1e-9)
    assert two.motion.inertia == pytest.approx(one.motion.inertia, rel=1e-9)


@pytest.mark.parametrize(("first", "second", "slide"), [(1, 0, 2), (0, 1, -2), (2, -1, 6)])
def test_a_surface_may_rest_or_run_backwards(first, second, slide):
    found = in_time(TRACK | {"speed_1": f"{first} m/s", "speed_2": f"{second} m/s"})
    assert found.motion.slide_to_roll == slide
    assert found.scales.front_speed == pytest.approx(0.5)
    travels = [found.motion.travel(surface, 1.0) * found.scales.front_speed for surface in (1, 2)]
    assert travels == pytest.approx([first, second])


def test_a_negative_mean_speed_reverses_the_flow():
    forth, back = (in_time(TRACK | {"mean_speed": f"{sign}0.5 m/s"}) for sign in ("", "-"))
    assert back.parameters == forth.parameters
    assert (forth.motion.entrainment(0.0), back.motion.entrainment(0.0)) == (1.0, -1.0)
    table = {"mean": 1.0, "amplitude": 0.5, "period": "2 ms"}
    back = in_time(TRACK | {"mean_speed": "-0.5 m/s"}, motion={"entrainment": table})
    slid = in_time(TRACK | {"mean_speed": "-0.5 m/s"}, motion={"entrainment": table, "sliding": 0.02})
    assert slid.motion.slide_to_roll == pytest.approx(0.02) and not slid.motion.keeps_ratio
    backwards, period = Oscillation(-1.0, -0.5, 0.002 / back.scales.t0), 0.002 / back.scales.t0
    for T in (0.0, 0.3 * period, 0.8 * period):
        assert back.motion.entrainment(T) == pytest.approx(backwards(T))
        assert back.motion.entrainment.integral(T) == pytest.approx(backwards.integral(T))
    assert back.motion.entrainment.range(1e3) == pytest.approx(backwards.range(1e3))


@pytest.mark.parametrize(("M", "half_width"), [(10, 3.0), (5, 3.0), (2, 10.25), (1, 25.75), (0.145, 336.75)])
def test_the_default_domain_is_wide_where_oil_far_away_carries_the_load(M, half_width):
    """By (5/M)^(4/3), as lambda_bar; the share of the load outside is that of M = 5."""
    solver = case({"kind": "rolling", "M": M, "L": 10}).solver
    assert (solver.half_width, solver.inlet, solver.nodes) == (half_width, 1.5 * half_width, 257)


def test_the_default_domain_of_an_ellipse_and_of_a_light_ball_in_si_is_wide():
    wide = case({"kind": "rolling", "M": 1, "L": 10, "radius_ratio": 0.5}).solver
    usual = case({"kind": "rolling", "M": 100, "L": 10, "radius_ratio": 0.5}).solver
    assert wide.half_width > 5 * usual.half_width
    assert wide.inlet / wide.half_width == pytest.approx(usual.inlet / usual.half_width)
    light = {"kind": "rolling", "radius": "1 mm", "load": "1 mN", "mean_speed": "0.1 m/s", "E_prime": "226 GPa"}
    found = case(light, lubricant={"eta0": "0.1 Pa*s", "alpha": "20 / GPa"})
    assert found.parameters.M < 4
    assert found.solver.half_width == pytest.approx(3 * (5 / found.parameters.M) ** (4 / 3), abs=0.25)
    assert case(solver={"half_width": 4.0}).solver.inlet == 6.0
    assert case(solver={"half_width": 4.0, "inlet": 4.0}).solver.inlet is None  # centred
    found = case(MOES | {"radius_ratio": 0.17}, solver={"nodes": 129})
    fine, half = grid_of(found), grid_of(found.on_half_grid())
    assert (half.nodes_x, half.nodes_y) == ((fine.nodes_x + 1) // 2, (fine.nodes_y + 1) // 2)
    assert (half.x[0], half.y[0]) == pytest.approx((fine.x[0], fine.y[0]))


@pytest.mark.parametrize(
    ("entrainment", "centred"),
    [
        ([[0, 1], [2, -1]], True),
        ([[0, 1], [2, 0]], False),
        ([[0, 1], [50, -1]], False),  # long after the end
        ({"mean": 0.1, "amplitude": 1, "period": 3, "phase": 1}, True),
        (-1, False),
    ],
)
def test_a_reversal_has_a_centred_grid(entrainment, centred):
    solver = in_time(motion={"entrainment": entrainment}).solver
    assert (solver.half_width, solver.inlet) == ((4.5, None) if centred else (3.0, 4.5))


def test_times_with_units():
    motion = {"load": {"mean": 1, "amplitude": 0.1, "period": "2 ms"}}
    motion["entrainment"] = [["0 s", 1], ["1 ms", 2], ["5 ms", 1]]
    found = in_time(C1, motion=motion, time={"until": "3 ms", "step": "10 us"}, output={"interval": "1 ms"})
    t0 = found.scales.t0
    assert found.motion.load == Oscillation(1.0, 0.1, 0.002 / t0)
    assert found.motion.entrainment == Polyline(((0.0, 1.0), (0.001 / t0, 2.0), (0.005 / t0, 1.0)))
    plan = found.schedule
    assert (plan.until, plan.step, plan.interval) == (0.003 / t0, 1e-5 / t0, 0.001 / t0)
    found = case(BALL | {"mean_speed": "0.3 m/s", "slide_to_roll": 0.5})
    assert found.motion.entrainment(1.0) == pytest.approx(0.3 / found.scales.front_speed)
    assert (found.motion.inertia, found.motion.slide_to_roll) == (0.8, 0.5)
    also = case({"M": 200, "L": 10}, motion={"entrainment": 0.5, "load": 0.1})
    assert also.motion == Motion(constant(0.1), constant(0.5), 0.8)


LOADED = {"kind": "rolling", "load": "100 N", "mean_speed": "0.5 m/s", "E_prime": "226.37 GPa"}
GROOVE = {"radius_x_1": "6 mm", "radius_y_1": "6 mm", "radius_x_2": "20 mm", "radius_y_2": "-6.24 mm"}


@pytest.mark.parametrize(
    ("radii", "R", "ratio"),
    [
        ({"radius_x": "10 mm", "radius_y": "50 mm"}, 0.01, 0.2),
        ({"radius_x_1": "10 mm", "radius_y_1": "50 mm"}, 0.01, 0.2),  # against a plane
        ({"radius_x_1": "20 mm", "radius_x_2": "20 mm", "radius_y_1": "25 mm", "radius_y_2": "-50 mm"}, 0.01, 0.2),
        (GROOVE, 60 / 13e3, 60 / 13 / 156),  # of an inner ring, with a ball: 1/R_x = 1/6 + 1/20, 1/R_y = 1/156
    ],
)
def test_reduced_radii(radii, R, ratio):
    found = case(LOADED | radii)
    assert (found.scales.R, found.parameters.radius_ratio) == pytest.approx((R, ratio))
    one, ball = case(LOADED | {"radius_x": "10 mm", "radius_y": "10 mm"}), case(LOADED | {"radius": "10 mm"})
    assert one.geometry is CIRCLE
    assert (one.scales, one.parameters, one.solver) == (ball.scales, ball.parameters, ball.solver)


@pytest.mark.parametrize(("written", "angle"), [("0.5 rad", 28.64788975654), (30, 30.0), ("90 deg", 90.0)])
def test_an_angle_in_python_and_in_a_case_file(written, angle):
    found = ertel.rolling(M=200, L=10, radius_ratio=0.4, entrainment_angle=written)
    assert found.geometry == Geometry(0.4, pytest.approx(angle))
    text = f"{written} deg" if written == 30 else written
    assert found.contact == case(MOES | {"radius_ratio": 0.4, "entrainment_angle": text}).contact


@pytest.mark.parametrize("kind", ["impact", "rolling"])
@pytest.mark.parametrize("D", [0.05, 0.3, 1.0, 3.0, 20.0])
@pytest.mark.parametrize("angle", [0.0, 35.0, 90.0])
def test_the_default_grid_follows_the_ellipse(kind, D, angle):
    """Distances from the contact, and the spacing, are those of the circle in units of the smaller half width."""
    turned = {"entrainment_angle": f"{angle} deg"} if angle else {}
    drive = {"motion": {"entrainment": 0.5}} if kind == "impact" and angle else {}
    found = case(MOES | {"kind": kind, "radius_ratio": D} | turned, **drive)
    grid, unit, (wide, high) = grid_of(found), found.geometry.smaller, found.geometry.extent
    circle = grid_of(case({"kind": kind, "M": found.parameters.as_ball.M, "L": 10.0}))
    left, right = (1e-9 + (abs(edge) - 1) * unit for edge in (circle.x[0], circle.x[-1]))
    assert -grid.x[0] - wide >= 0.94 * left and grid.x[-1] - wide >= 0.94 * right - 0.02
    assert grid.x[-1] - grid.x[0] >= 2 * wide + left + right - 1e-6
    assert grid.y[-1] - high >= 0.999 * unit * (circle.y[-1] - 1)
    assert 0.8 * circle.spacing * unit < grid.spacing <= 1.15 * circle.spacing * unit
    assert all((abs(axis) < 1e-9).any() for axis in (grid.x, grid.y))  # a node at zero
