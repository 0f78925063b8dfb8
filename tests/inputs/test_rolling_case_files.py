"""Case files of rolling contacts, of motion and of roughness: what they may say, mean, and what is refused."""

from math import pi
from typing import Any

import pytest

from ertel.case.case import Case
from ertel.case.sections import ROLLING_UNTIL, SOLVERS, Time
from ertel.inputs.case_files import ConfigError, parse_case
from ertel.physics.motion import FREE_BALL, STEADY_ROLLING, Motion, Oscillation, Polyline, constant

MOES = {"kind": "rolling", "M": 200, "L": 10}
C1 = {  # the dimensional case of reference/rolling.json
    "kind": "rolling",
    "radius": "10 mm",
    "load": "38.885237 N",
    "mean_speed": "0.502636 m/s",
    "E_prime": "219.7802 GPa",
}
OIL = {"eta0": "40 mPa*s", "alpha": "22 / GPa"}
BALL = {"radius": "10 mm", "mass": "32.6726 g", "speed": "0.1 m/s", "E_prime": "226.37 GPa"}
SPOT = {"shape": "spot", "height": 0.1, "radius": 0.3}
IN_TIME = {"method": "transient"}
TRACK = {k: v for k, v in C1.items() if k != "mean_speed"}


def case(contact: dict[str, Any] = MOES, **sections: Any) -> Case:
    oil = {"lubricant": OIL} if "radius" in contact else {}
    return parse_case({"contact": contact, **oil, **sections})


def in_time(contact: dict[str, Any] = MOES, **sections: Any) -> Case:
    return case(contact, solver=IN_TIME, **sections)


# -- the contact ------------------------------------------------------------------------------------------------------


def test_physical_input_is_the_reference():
    found = case(C1)
    given = [found.parameters.M, found.parameters.L, found.scales.a, found.scales.p_h, found.scales.front_speed]
    assert given == pytest.approx([200, 10, 1.384509e-4, 968577800.0, 0.502636], rel=1e-6)
    assert found.motion == STEADY_ROLLING
    assert found.solver == SOLVERS["steady"]


def test_two_speeds_are_a_mean_and_a_slide():
    one = case(TRACK | {"speed_1": "0.6 m/s", "speed_2": "0.4 m/s"})
    two = case(TRACK | {"mean_speed": "0.5 m/s", "slide_to_roll": 0.4})
    found, expected = ((each.parameters.lambda_bar, each.motion.slide_to_roll) for each in (one, two))
    assert found == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize(
    ("speeds", "slide"), [(("1 m/s", "0 m/s"), 2), (("0 m/s", "1 m/s"), -2), (("2 m/s", "-1 m/s"), 6)]
)
def test_a_surface_may_rest_or_run_backwards(speeds, slide):
    found = in_time(TRACK | dict(zip(("speed_1", "speed_2"), speeds, strict=True)))
    assert found.motion.slide_to_roll == slide
    assert found.scales.front_speed == pytest.approx(0.5)
    share = found.scales.front_speed
    travels = [found.motion.travel(surface, 1.0) * share for surface in (1, 2)]
    assert travels == pytest.approx([float(speed.split()[0]) for speed in speeds])


def test_a_negative_mean_speed_reverses_the_flow():
    forth, back = (in_time(TRACK | {"mean_speed": f"{sign}0.5 m/s"}) for sign in ("", "-"))
    assert back.parameters == forth.parameters
    assert (forth.motion.entrainment(0.0), back.motion.entrainment(0.0)) == (1.0, -1.0)
    table = {"mean": 1.0, "amplitude": 0.5, "period": 2.0}
    back = in_time(TRACK | {"mean_speed": "-0.5 m/s"}, motion={"entrainment": table})
    assert back.motion.entrainment == Oscillation(-1.0, -0.5, 2.0)


def test_the_ball_s_mass_is_its_inertia():
    mass = 4 / 3 * pi * 0.01**3 * 7850
    one = in_time(C1 | {"ball_density": "7850 kg/m^3"})
    two = in_time(C1 | {"mass": f"{mass!r} kg"})
    s = one.scales
    assert one.motion.inertia == pytest.approx(mass * s.film / (s.load * s.t0**2), rel=1e-9)
    assert two.motion.inertia == pytest.approx(one.motion.inertia, rel=1e-9)


def test_dimensionless_inertia_and_slide():
    assert in_time(motion={"inertia": 0.3, "slide_to_roll": 1}).motion == Motion(constant(1), constant(1), 0.3, 1)


# -- the defaults -----------------------------------------------------------------------------------------------------


def test_method_and_grid_of_a_rolling_contact():
    assert case().solver == SOLVERS["steady"]
    assert in_time().solver == SOLVERS["transient"]
    assert in_time().time == Time(until=ROLLING_UNTIL)


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


@pytest.mark.parametrize(
    ("M", "solver", "expected"),
    [
        (1, {"half_width": 3.0}, r"^solver\.half_width = 3\.0: must be at least 8\.39 at M = 1, .* leave it out"),
        (0.01, {}, r"^contact: M = 0\.01 is too low: .*half_width = 1000"),
    ],
)
def test_a_domain_that_the_load_lies_outside_of_is_refused(M, solver, expected):
    with pytest.raises(ValueError, match=expected):
        case({"kind": "rolling", "M": M, "L": 10}, solver=solver)


def test_an_inlet_goes_with_the_width():
    assert case(solver={"half_width": 4.0}).solver.inlet == 6.0
    assert case(solver={"half_width": 4.0, "inlet": 4.0}).solver.inlet is None  # centred


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


# -- motion -----------------------------------------------------------------------------------------------------------


def test_times_with_units():
    found = in_time(
        C1,
        motion={
            "load": {"mean": 1, "amplitude": 0.1, "period": "2 ms"},
            "entrainment": [["0 s", 1], ["1 ms", 2], [5, 1]],
        },
        time={"until": "3 ms", "step": "10 us"},
        output={"interval": "1 ms"},
    )
    t0 = found.scales.t0
    assert found.motion.load == Oscillation(1.0, 0.1, 0.002 / t0)
    assert found.motion.entrainment == Polyline(((0.0, 1.0), (0.001 / t0, 2.0), (5.0, 1.0)))
    plan = found.schedule
    assert (plan.until, plan.step, plan.interval) == (0.003 / t0, 1e-5 / t0, 0.001 / t0)


def test_an_impact_on_a_rolling_track():
    found = case(BALL | {"mean_speed": "0.3 m/s", "slide_to_roll": 0.5})
    assert found.motion.entrainment(1.0) == pytest.approx(0.3 / found.scales.front_speed)
    assert (found.motion.inertia, found.motion.slide_to_roll) == (0.8, 0.5)
    also = case({"M": 200, "L": 10}, motion={"entrainment": 0.5, "load": 0.1})
    assert also.motion == Motion(constant(0.1), constant(0.5), 0.8)


def test_an_impact_without_motion_is_a_free_ball():
    assert case({"M": 200, "L": 10}).motion == FREE_BALL
    assert case({"M": 200, "L": 10}, solver={"method": "radial"}, motion={"load": 0}).motion == FREE_BALL


@pytest.mark.parametrize(
    ("shape", "slide"),
    [
        ({**SPOT, "surface": 1}, -2),
        ({**SPOT, "surface": 2}, 2),
        ({"shape": "waviness", "amplitude": 0.1, "wavelength_y": 0.5}, 0),
    ],
)
def test_roughness_at_rest_or_along_the_flow_is_steady(shape, slide):
    assert case(roughness=[shape], motion={"slide_to_roll": slide}).roughness


# -- what is refused: the message names field, value and what is allowed ----------------------------------------------

TWO_SPEEDS = {"speed_1": "1 m/s", "speed_2": "1 m/s"}
OSCILLATION = {"mean": 1, "amplitude": 1, "period": 1}
CONTACTS: list[tuple[dict[str, Any], list[str]]] = [
    ({"kind": "rolling"}, ["contact.M: missing", "load", "mean_speed or speed_1 and speed_2"]),
    (MOES | C1, ["contact.M = 200", 'contact.radius = "10 mm"', "given together"]),
    (C1 | {"speed": "1 m/s"}, ['contact.speed = "1 m/s"', "rolling", "contact.mean_speed"]),
    (C1 | {"drop_height": "1 m"}, ["contact.drop_height", "rolling", "contact.speed_1"]),
    (BALL | {"load": "1 N"}, ['contact.load = "1 N"', "impact", "motion.load"]),
    (BALL | {"speed_1": "1 m/s"}, ["contact.speed_1", "impact", "contact.mean_speed"]),
    (BALL | {"slide_to_roll": 1}, ["contact.slide_to_roll = 1", "mean_speed"]),
    (MOES | {"slide_to_roll": 1}, ["contact.slide_to_roll = 1", "motion.slide_to_roll"]),
    (TRACK, ["contact.mean_speed: missing", "speed_1 and speed_2"]),
    (TRACK | {"speed_1": "1 m/s"}, ["contact.speed_2: missing", 'contact.speed_1 = "1 m/s"']),
    (C1 | TWO_SPEEDS, ["contact.mean_speed", "contact.speed_1", "together"]),
    (TRACK | TWO_SPEEDS | {"speed_2": "-1 m/s"}, ["contact.speed_1", 'contact.speed_2 = "-1 m/s"', "not be zero"]),
    (TRACK | TWO_SPEEDS | {"slide_to_roll": 1}, ["contact.slide_to_roll = 1", "mean_speed only"]),
    (C1 | {"mean_speed": "0 m/s"}, ['contact.mean_speed = "0 m/s"', "must not be zero"]),
    (C1 | {"load": "-1 N"}, ['contact.load = "-1 N"', "above zero", "40 N"]),
    (C1 | {"mass": "1 g", "ball_density": "1 kg/m^3"}, ["contact.mass", "contact.ball_density"]),
]
LOADS: list[tuple[Any, list[str]]] = [
    ([], ["motion.load = []", "[T, value]", "amplitude"]),
    ([1, 2], ["motion.load[1] = 1", "[T, value]"]),
    ([[0, 1], [1]], ["motion.load[2]", "[T, value]"]),
    ([[0, 1, 2]], ["motion.load[1]", "[T, value]"]),
    ([[0, "a"]], ['motion.load[1][2] = "a"', "number"]),
    ("much", ['motion.load = "much"', "[T, value]", "amplitude"]),
    (True, ["motion.load = true", "[T, value]"]),
    ({"mean": 1}, ["motion.load.amplitude: missing"]),
    (OSCILLATION | {"fase": 1}, ["motion.load.fase = 1", "did you mean phase?"]),
    (OSCILLATION | {"period": 0}, ["motion.load.period = 0", "above zero"]),
]
WAVE = {"shape": "waviness", "amplitude": 1}
SHAPES: list[tuple[Any, list[str]]] = [
    (5, ["roughness[1] = 5: must be a table", "waviness, rings, spot"]),
    (SPOT | {"radios": 1}, ["roughness[1].radios = 1", "did you mean radius?"]),
    (SPOT | {"radius": -1}, ["roughness[1].radius = -1", "above zero", "units a,", "50 um"]),
    (SPOT | {"radius": "1 s"}, ['roughness[1].radius = "1 s"', "wrong dimension"]),
    (SPOT | {"depth": 1}, ["roughness[1].height", "together with depth"]),
    ({"shape": "spot", "height": 1}, ["roughness[1].radius: missing"]),
    (WAVE, ["roughness[1].wavelength_x: missing", "wavelength_y"]),
    (WAVE | {"wavelength_x": 1, "ramp": 1}, ["roughness[1].ramp = 1", "front"]),
]
REFUSED: list[tuple[dict[str, Any], list[str]]] = [
    *(({"contact": contact}, said) for contact, said in CONTACTS),
    *(({"motion": {"load": load}}, said) for load, said in LOADS),
    *(({"roughness": [shape]}, said) for shape, said in SHAPES),
    ({"contact": C1, "solver": IN_TIME, "time": {"until": "5 mm"}}, ["time.until", "5 ms"]),
    ({"motion": {"speed": 1}}, ["motion.speed = 1", "unknown key", "entrainment"]),
    ({"roughness": [SPOT | {"surface": 2}], "motion": {"slide_to_roll": -2}}, ["roughness[1].surface = 2"]),
    ({"roughness": SPOT}, ["roughness = ", "array of tables", "[[roughness]]"]),
    ({"roughness": [SPOT, SPOT | {"shape": "dent"}]}, ['roughness[2].shape = "dent"', "waviness, rings, spot"]),
]


@pytest.mark.parametrize(("sections", "expected"), REFUSED, ids=str)
def test_refused(sections, expected):
    with pytest.raises(ConfigError) as caught:
        case(**sections)
    assert all(part in str(caught.value) for part in expected), caught.value
    assert "\n" not in str(caught.value)
