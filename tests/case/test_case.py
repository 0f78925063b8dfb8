"""A case writes itself, knows its digest, and refuses what makes no sense, whichever way it was made."""

from dataclasses import dataclass, fields, replace
from math import inf, nan
from typing import Annotated, Any

import pytest
from cases import STEEL_BODIES, changed_cases

from ertel.case.case import Case
from ertel.case.conditions import Conditions
from ertel.case.methods import METHODS
from ertel.case.sections import SECTIONS, Drive, Output, Solver, Time
from ertel.physics.lubricant import Barus, Oil
from ertel.physics.motion import FREE_BALL, STEADY_ROLLING, Oscillation, Polyline, constant
from ertel.physics.scales import Parameters
from ertel.physics.surfaces import Feature, RingWaviness, Spot, Waviness
from ertel.physics.units import WIDTH, Amount, Quantity

MOES: dict[str, Any] = {"M": 200.0, "L": 10.0}
BALL: dict[str, Any] = {"radius": 0.01, "mass": 0.03, "speed": 0.1, "E_prime": 2e11}
TRACK: dict[str, Any] = {"kind": "rolling", "radius": 0.01, "load": 40.0, "mean_speed": 0.5, "E_prime": 2e11}
OIL = Oil(eta0=0.04, alpha=2.2e-8)


def impact(**sections: Any) -> Case:
    return Case(Conditions(**MOES), **sections)


def rolling(method: str = "steady", **sections: Any) -> Case:
    return Case(Conditions("rolling", **MOES), solver=METHODS[method].defaults, **sections)


# -- equality and digest ----------------------------------------------------------------------------------------------


def test_the_name_and_where_the_oils_data_come_from_change_no_result() -> None:
    case = impact(oil=replace(OIL, reference="a data sheet"), name="one")
    other = impact(oil=replace(OIL, reference="another"), name="two")
    assert case == other
    assert case.digest == other.digest


STEEL = {"E1": "2e11 Pa", "nu1": 0.3, "E2": "2e11 Pa", "nu2": 0.3}
WAVE = {"shape": "waviness", "amplitude": 0.1, "wavelength_x": 0.5, "wavelength_y": 0.7, "front": 1.0, "ramp": 0.5}
RINGS = {"shape": "rings", "amplitude": 0.1, "wavelength": 0.5}
SPOT = {"shape": "spot", "radius": 0.3, "height": 0.1}
CAVITY = {"shape": "spot", "radius": 0.3, "depth": 0.1}
DROPPED = {"radius": "0.01 m", "ball_density": "7850 kg/m^3", "drop_height": "0.1 m", "E_prime": "2e11 Pa"}
TWO_BALLS = {"radius_1": "0.02 m", "radius_2": "0.03 m", "mass": "0.03 kg", "speed": "0.1 m/s", **STEEL}
TWO_SPEEDS = {"E_prime": "2e11 Pa", "load": "40.0 N", "speed_1": "0.6 m/s", "speed_2": "0.4 m/s"}
REDUCED = {"radius_x": "0.01 m", "radius_y": "0.02 m"}
PAIRS = {"radius_x_1": "0.01 m", "radius_y_1": "0.01 m", "radius_x_2": "0.1 m", "radius_y_2": "-0.02 m"}
OF_OIL = {"temperature": "313.0 K", "conductivity": "0.15 W/(m*K)", "beta": "0.04 1/K"}
PERSSON = {"law": "persson", "longest": "5e-05 m", "shortest": "1e-06 m", "hurst": 0.8}
SURFACES = {
    **{"sigma_1": "1e-07 m", "sigma_2": "5e-08 m", "asperities": PERSSON},
    **{"boundary_friction": 0.1, "hardness": "7e9 Pa"},
}
THERMAL = OF_OIL | STEEL_BODIES


def in_si(kind: str, **contact: Any) -> dict[str, Any]:
    return {"contact": {"kind": kind, **contact}, "lubricant": {"eta0": "0.04 Pa*s", "alpha": "2.2e-08 1/Pa"}}


BASES: list[dict[str, Any]] = [  # every field is given in one of them, or has a default
    {"contact": MOES, "roughness": [WAVE, RINGS, SPOT], "time": {"until": 1.0, "step": 0.01, "start": "undeformed"}},
    {"contact": MOES, "roughness": [CAVITY], "motion": {"load": 0.5, "entrainment": 0.5, "slide_to_roll": 0.5}},
    {"contact": MOES, "lubricant": {"layer": 0.1, "z": 0.6}, "solver": {"inlet": 2.5}},
    {"contact": MOES, "lubricant": {"layer_1": 0.1, "layer_2": 0.05}, "solver": {"half_width_y": 4.0}},
    {"contact": {"lambda_bar": 0.01, "alpha_bar": 20.0}},
    {"contact": {"kind": "rolling", **MOES, "radius_ratio": 0.5, "entrainment_angle": "20.0 deg"}},
    {"contact": {"kind": "rolling", **MOES}, "solver": {"method": "transient"}, "motion": {"inertia": 0.5}},
    in_si("impact", **TWO_BALLS, mean_speed="0.1 m/s", slide_to_roll=0.5),
    in_si("impact", **DROPPED),
    in_si("rolling", **TWO_SPEEDS, radius="0.01 m") | {"thermal": THERMAL},
    in_si("rolling", **TWO_SPEEDS, **REDUCED),
    in_si("rolling", **TWO_SPEEDS, **PAIRS),
    in_si("rolling", **TWO_SPEEDS, radius="0.01 m", length="0.02 m"),
    {"contact": {"kind": "rolling", **MOES, "radius_ratio": 0.0, "length_ratio": 50.0}},
    {
        "contact": {"kind": "rolling", **MOES},
        "solver": {"method": "transient"},
        "motion": {"sliding": 0.2, "curvature": 1.1},
    },
    in_si("rolling", **TWO_SPEEDS, radius="0.01 m") | {"surfaces": {"sigma": "1e-07 m"}},
    in_si("rolling", **TWO_SPEEDS, radius="0.01 m") | {"surfaces": SURFACES},
]


@pytest.mark.parametrize("data", BASES, ids=str)
def test_whatever_changes_a_result_changes_the_digest(data) -> None:
    case = Case.from_data(data)
    for place, changed in changed_cases(data):
        assert case != changed, place
        assert case.digest != changed.digest, place


DIGESTS = [  # of stored runs: without a reason none of them changes
    *("de1cda670c1efac0", "f17e048c60a6f183", "da7aa5e8ba2d81c4", "78ea61356aeb2ce9", "c873a9f8a0f1e0e1"),
    *("dd54a1d78a6d2dff", "92e04ce75b28b26c", "cdb69999876aea0f", "96cccb8c39080259", "f083984f32288c08"),
    *("1276cdda72d544b5", "71a03254d982f76f"),
]


def test_stored_runs_are_found_again() -> None:
    assert [Case.from_data(data).digest for data in BASES[: len(DIGESTS)]] == DIGESTS


def test_no_field_was_forgotten() -> None:
    """Every field of every record of a case is among the changes above, and so is the kind of contact."""
    wanted = {f"{name}.{f.name}" for name, section in SECTIONS.items() for f in fields(section.record)}
    wanted |= {f"roughness.{f.name}" for shape in (Waviness, RingWaviness, Spot) for f in fields(shape)}
    found = {place for data in BASES for place, _ in changed_cases(data)}
    assert (wanted | {"roughness.surface"}) - found == {"contact.kind", "lubricant.reference"}
    assert impact().digest != rolling().digest


def test_a_law_by_name_and_its_record_are_two_ways_of_saying() -> None:
    """Not equal, but with the same law."""
    case = Case(Conditions(**BALL), oil=replace(OIL, viscosity="barus"))
    other = replace(case, oil=replace(case.oil, viscosity=Barus(2.2e-8)))
    assert case.lubricant == other.lubricant


# -- own laws and shapes ----------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Nameless:
    width: Annotated[Amount, WIDTH] = 1.0

    def viscosity(self, p: Any) -> Any:
        return p

    def density(self, p: Any) -> Any:
        return p

    def heights(self, X: Any, Y: Any) -> Any:
        return X


def test_what_has_no_name_cannot_be_written() -> None:
    case = impact(roughness=(Feature(Nameless()),))
    with pytest.raises(ValueError, match=r"^roughness\[1\]\.Nameless: is no registered shape.*ertel\.shapes"):
        case.to_data()
    with pytest.raises(ValueError, match="is no registered shape"):
        case.digest  # noqa: B018
    for law in ("viscosity", "density"):
        with pytest.raises(ValueError, match=f"Nameless: is no registered {law} law"):
            Oil(**{law: Nameless()})


# -- what is filled in ------------------------------------------------------------------------------------------------


def test_the_record_says_all_that_is_solved() -> None:
    case = impact()
    assert case.time == Time(start_approach=-1.0, until="max-approach")
    assert case.output == Output()
    assert (case.oil.eta0, case.oil.alpha) == (0.04, 2.2e-8)
    assert case.motion == FREE_BALL
    assert case.schedule[:-1] == (-1.0, "max-approach", 5e-5, None, 0.1, None)
    assert case.schedule.contact_time == pytest.approx(2.943275)


def test_a_steady_case_has_no_time() -> None:
    case = rolling()
    assert (case.time, case.output, case.is_steady, case.starts_apart) == (None, None, True, False)
    assert case.motion == STEADY_ROLLING
    with pytest.raises(ValueError, match="a steady contact has no time"):
        case.schedule  # noqa: B018


def test_an_inlet_as_wide_as_the_half_is_a_centred_grid() -> None:
    centred = replace(METHODS["transient"].defaults, inlet=3.0)
    case = rolling("transient")
    assert replace(case, solver=centred) == replace(case, solver=replace(centred, inlet=None))
    assert Case.from_data(replace(case, solver=centred).to_data()).solver.inlet is None


def test_derived_numbers() -> None:
    assert impact().on_half_grid().solver.nodes == 129  # twice the spacing
    assert impact().film_scale == pytest.approx((10 / 200) ** 0.5)
    assert rolling().film_scale == pytest.approx(0.0823, rel=0.1)


# -- what makes no sense, by whichever door ---------------------------------------------------------------------------

RADIAL = METHODS["radial"].defaults
TRANSIENT = METHODS["transient"].defaults
ROUGH = (Feature(Spot(0.3, 0.1)),)
STEADY, IN_TIME = rolling(), rolling("transient")
PHYSICAL = Case(Conditions(**BALL), OIL)
FAST = Case(Conditions(**BALL, mean_speed=1.0), OIL)
ENTRAINED = 'motion.entrainment = 1.0: is given together with contact.mean_speed = "1.0 m/s"; allowed: one of them'
ON_TRACK = Case(Conditions(**TRACK), OIL, METHODS["steady"].defaults)
NO_L = Case(Conditions(M=200.0), Oil(viscosity="isoviscous", density="incompressible"))
FINE = impact(solver=Solver(nodes=4097))
RESTING = replace(STEADY, drive=Drive(slide_to_roll=-2.0), roughness=ROUGH)
LOADED = Drive(load=constant(1.0))
HUGE = Quantity(1e30, "m")
NANOMETRES = Feature(Spot(0.3, Quantity(1e-8, "m")))
NO_NAMES = {
    **{name: f'"{name}"' for name in ("../../evil", "/tmp/evil", "run::1", ".", "..", ".hidden", "µ" * 51)},
    **{"a\\b": '"a\\\\b"', "two\nlines": '"two\\nlines"'},
    **{"\x1b[31mred": '"\\u001b[31mred"', "\u202etxt": '"\\u202etxt"'},
}


def drive_to(value: float, at: Amount = 1.0) -> Drive:
    return Drive(load=Polyline(((0.0, 1.0), (at, value))))


Refusal = tuple[Case, dict[str, Any], str]
REFUSED: list[Refusal] = [
    # method
    (impact(), {"solver": TRANSIENT}, 'solver.method = "transient": must be "2d" or "radial"'),
    (STEADY, {"solver": METHODS["2d"].defaults}, 'solver.method = "2d": must be "steady" or "transient"'),
    (impact(roughness=ROUGH), {"solver": RADIAL}, 'roughness: solver.method = "radial" is for smooth surfaces'),
    (
        impact(solver=RADIAL),
        {"drive": Drive(constant(1.0), constant(1.0))},
        'motion: solver.method = "radial" is for a',
    ),
    (impact(), {"solver": replace(RADIAL, inlet=2.0)}, 'solver.inlet = 2.0: solver.method = "radial" has none'),
    (impact(), {"solver": replace(RADIAL, half_width=1.1)}, "solver.half_width = 1.1: must be at least 1.2"),
    # grid
    (impact(), {"solver": Solver(nodes=9)}, "solver.nodes = 9: must be greater than or equal to 17"),
    (impact(), {"solver": Solver(nodes=39)}, "solver.nodes = 39: "),
    (impact(), {"solver": Solver(nodes=8193)}, "solver.nodes = 8193: must be less than or equal to 4097"),
    (impact(), {"solver": Solver(half_width=1.0)}, "solver.half_width = 1.0: must be greater than 1"),
    (impact(), {"solver": Solver(half_width=1e9)}, "solver.half_width = 1000000000.0: must be less than or equal to"),
    (impact(), {"solver": Solver(half_width=nan)}, "solver.half_width = NaN: must be a finite number"),
    # is lengthened for multigrid, and could not be read again
    (STEADY, {"solver": replace(STEADY.solver, half_width=560.4, half_width_y=999.0)}, "solver.half_width_y = 1120.8"),
    (impact(), {"solver": Solver(tolerance=0.0)}, "solver.tolerance = 0.0: must be greater than 0"),
    (STEADY, {"solver": replace(STEADY.solver, inlet=5.5)}, "solver.inlet = 5.5: must be above 1 and below 5"),
    # oil
    (PHYSICAL, {"oil": Oil(alpha=2e-8)}, "lubricant.eta0: missing"),
    (PHYSICAL, {"oil": Oil(eta0=0.04)}, "lubricant.alpha: missing"),
    (PHYSICAL, {"oil": replace(OIL, viscosity=Barus(-1.0))}, 'lubricant.viscosity.alpha = "-1.0 1/Pa": must be finite'),
    (PHYSICAL, {"oil": replace(OIL, layer=-1.0)}, "lubricant.layer = -1.0: must be a finite number above zero"),
    (PHYSICAL, {"oil": replace(OIL, eta0=6e-5)}, "lubricant.eta0 = 6e-05 Pa s: Roelands' law needs"),
    (impact(), {"contact": Conditions(M=200.0, L=0.0)}, "contact.L = 0: must be above zero with lubricant.viscosity"),
    (impact(), {"oil": Oil(viscosity="isoviscous")}, "contact.L = 10.0: must be 0 or left out with lubricant.visc"),
    (NO_L, {"oil": replace(NO_L.oil, density="dowson-higginson")}, 'lubricant.density = "dowson-higginson": needs'),
    # time
    (STEADY, {"time": Time()}, "time: a steady contact has no time"),
    (STEADY, {"time": Time(until=5.0)}, "time.until = 5.0: a steady contact has no time"),
    (STEADY, {"output": Output(1.0)}, "output.interval = 1.0: a steady contact has no time"),
    (IN_TIME, {"time": Time(-1.0)}, "time.start_approach = -1.0: not for a rolling contact"),
    (IN_TIME, {"time": Time(start="undeformed")}, 'time.start = "undeformed": not for a rolling contact'),
    (IN_TIME, {"time": Time(until="rebound")}, 'time.until = "rebound": is an event of an impact'),
    (impact(), {"time": Time(until="later")}, 'time.until = "later": must be a finite number above zero, in'),
    (impact(), {"time": Time(start_approach=1.0)}, "time.start_approach = 1.0: must be less than 0"),
    (impact(), {"time": Time(-2e5, until=1.0)}, "time.start_approach = -200000.0: the ball would fall for 200000 t0"),
    (impact(), {"time": Time(until=Quantity(1.0, "s"))}, 'time.until = "1.0 s": must be a plain number'),
    (impact(time=Time(until="rebound")), {"drive": LOADED}, 'time.until = "rebound": a ball under a load may never'),
    (impact(), {"time": Time(until=1e9)}, "time.until = 1000000000.0: is 1e+09 t0; must be at most 100000 t0"),
    (IN_TIME, {"time": Time(until=10.0, step=1e-9)}, "time.step = 1e-09: needs 1e+10 steps; must be at least 1e-06 t0"),
    (impact(), {"output": Output(1e-9)}, "output.interval = 1e-09: gives 2.47e+09 maps with 7.84e+06 GB; at most"),
    (FINE, {"output": Output(0.005)}, "output.interval = 0.005: gives 494 maps with 398 GB"),
    (PHYSICAL, {"output": Output(Quantity(1e-10, "s"))}, 'output.interval = "1e-10 s": gives 9.39e+05 maps'),
    # name and source
    *[(impact(), {"name": name}, f"name = {shown}: must be a plain file name: ") for name, shown in NO_NAMES.items()],
    (impact(), {"name": 5}, "name = 5: must be a string"),
    (impact(), {"oil": replace(OIL, reference="\x1b]0;title")}, 'lubricant.reference = "\\u001b]0;title": must be one'),
    # sizes
    (impact(), {"contact": Conditions(lambda_bar=1e-29, alpha_bar=10.0)}, "contact: its values together give M = "),
    (impact(), {"roughness": (Feature(Spot(1e-300, 0.1)),)}, "roughness[1].radius = 1e-300: must be between 1e-06 and"),
    (PHYSICAL, {"roughness": (Feature(Spot(HUGE, 0.1)),)}, 'roughness[1].radius = "1e+30 m": is 5.13076e+33 a in this'),
    # units
    (PHYSICAL, {"roughness": (Feature(Spot(Quantity(1e-3, "s"), 0.1)),)}, 'roughness[1].radius = "0.001 s": must be a'),
    (PHYSICAL, {"time": Time(tolerance=Quantity(1e-3, "m"))}, 'time.tolerance = "0.001 m": must be a number'),
    # motion
    (STEADY, {"drive": Drive(load=constant(0.0))}, "motion.load = 0.0: is 0 at T = 0; must be above zero there"),
    (STEADY, {"drive": Drive(entrainment=constant(0.0))}, "motion.entrainment = 0.0: is 0 at T = 0"),
    (STEADY, {"drive": drive_to(2.0)}, "motion.load = [[0.0, 1.0], [1.0, 2.0]]: varies in time from 1 to 2; use"),
    (IN_TIME, {"drive": drive_to(0.0)}, "motion.load = [[0.0, 1.0], [1.0, 0.0]]: goes down to 0; must stay above zero"),
    (STEADY, {"drive": Drive(inertia=-1.0)}, "motion.inertia = -1.0: must be greater than or equal to 0"),
    (IN_TIME, {"drive": Drive(Oscillation(1.0, inf, 1.0))}, "motion.load.amplitude = Infinity: must be a finite numb"),
    (IN_TIME, {"drive": Drive(constant(nan))}, "motion.load = NaN: must be a finite number"),
    (IN_TIME, {"drive": drive_to(2.0, at=inf)}, "motion.load = [[0.0, 1.0], [Infinity, 2.0]]: must be a finite"),
    (PHYSICAL, {"drive": drive_to(2.0, at=Quantity(1.0, "m"))}, 'motion.load = [[0.0, 1.0], ["1.0 m", 2.0]]: must '),
    (impact(), {"drive": Drive(inertia=1.0)}, "motion.inertia = 1.0: belongs to dimensionless rolling cases; for an"),
    (ON_TRACK, {"drive": Drive(inertia=1.0)}, "motion.inertia = 1.0: belongs to dimensionless rolling cases; give"),
    (ON_TRACK, {"drive": Drive(slide_to_roll=1.0)}, "motion.slide_to_roll = 1.0: belongs to dimensionless cases; with"),
    (FAST, {"drive": Drive(entrainment=constant(1.0))}, ENTRAINED),
    # roughness
    (RESTING, {"drive": None}, "roughness[1].surface = 1: moves, so its film is not steady"),
    (impact(), {"roughness": (*ROUGH, NANOMETRES)}, 'roughness[2].height = "1e-08 m": must be a plain number'),
]


@pytest.mark.parametrize(("case", "changes", "message"), REFUSED, ids=[message[:60] for *_, message in REFUSED])
def test_every_rule_is_kept_by_replace_too(case, changes, message) -> None:
    with pytest.raises(ValueError) as caught:
        replace(case, **changes)
    assert str(caught.value).startswith(message)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("values", [{"M": 1e300, "L": 10.0}, {"M": 10**400, "L": 10.0}, {"M": 200.0, "L": 1e31}])
def test_numbers_of_an_absurd_size_are_refused(values) -> None:
    with pytest.raises(ValueError, match=r"^contact\.[ML] = .*: must be between"):
        Conditions(**values)


@pytest.mark.parametrize("name", ["", "ball", "Kugel 2 (schnell)", "a_b-c.d", "x" * 100, "µ" * 50])
def test_a_plain_file_name_is_a_name(name) -> None:
    assert impact(name=name).name == name


# -- the default domain -----------------------------------------------------------------------------------------------


def half_width(contact: dict[str, Any], **solver: Any) -> float:
    return Case.from_data({"contact": contact, "solver": solver}).solver.half_width


@pytest.mark.parametrize(("M", "expected"), [(1e4, 2.0), (100, 2.0), (50, 3.25), (20, 6.0), (1, 8.0)])
def test_the_default_domain_of_an_impact_widens_at_low_loads(M: float, expected: float) -> None:
    assert half_width({"M": M, "L": 5}) == expected
    assert half_width({"M": M, "L": 5}, half_width=2.5) == 2.5
    assert half_width({"M": M, "L": 5}, method="radial") == pytest.approx(2 * expected, abs=0.26)


@pytest.mark.parametrize("across", [None, 2.00001, 2.11])
def test_the_side_along_y_of_an_ellipse_reads_back(across: float | None) -> None:
    """A side that ends as long as that along x is not the default, which follows the ellipse."""
    contact = {"kind": "rolling", "M": 5.26, "L": 0.5, "radius_ratio": 2.5}
    solver = {"method": "transient"} | ({"half_width_y": across} if across else {})
    case = Case.from_data({"contact": contact, "solver": solver})
    assert Case.from_data(case.to_data()) == case


def test_a_default_domain_depends_on_the_load_however_it_is_given() -> None:
    p = Parameters.from_moes(30.0, 5.0)
    assert half_width({"lambda_bar": p.lambda_bar, "alpha_bar": p.alpha_bar}) == half_width({"M": 30, "L": 5}) > 2
