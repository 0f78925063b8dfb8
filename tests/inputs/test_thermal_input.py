"""The section [thermal]: completed from the library, given values win, and one sentence for what is wrong."""

import re
from typing import Any

import pytest

import ertel
from ertel.case.records import ConfigError
from ertel.inputs.case_files import parse_case

CONTACT = {"kind": "rolling", "radius": "10 mm", "load": "20 N", "mean_speed": "0.5 m/s"}
BODIES = {"material_1": "steel", "material_2": "glass"}
NAMED = {"oil": "squalane", "temperature": "40 degC"}
NUMBERS = {"eta0": "15 mPa*s", "alpha": "18 / GPa"}
ELASTIC = {"E_prime": "226 GPa"}
OIL = {"temperature": "40 degC", "conductivity": "0.15 W/(m*K)", "beta": "0.04 / K"}
STEEL = {"density": "7850 kg/m^3", "heat_capacity": "460 J/(kg*K)", "conductivity": "47 W/(m*K)"}
ALL = OIL | {f"{key}_{number}": value for number in (1, 2) for key, value in STEEL.items()}


def case_of(
    thermal: dict[str, Any],
    contact: dict[str, Any] = BODIES,
    lubricant: dict[str, Any] = NAMED,
    **sections: dict[str, Any],
) -> ertel.Case:
    return parse_case({"contact": {**CONTACT, **contact}, "lubricant": lubricant, "thermal": thermal, **sections})


def test_names_give_all_data():
    found = case_of({}).thermal
    assert (found.temperature, found.temperature_1, found.temperature_2) == (313.15, 313.15, 313.15)
    assert found.conductivity == 0.14
    assert found.beta == pytest.approx(0.0367, abs=1e-4)
    assert found.bodies[0].conductivity == 47.0 and found.bodies[0].density == 7850.0
    assert found.bodies[1].heat_capacity == 880.0
    assert (found.viscosity, found.inlet_factor) == ("houpert", "gupta")


def test_given_values_win():
    found = case_of({"beta": "0.05 / K", "conductivity_2": "2 W/(m*K)", "temperature_1": "60 degC"}).thermal
    assert (found.beta, found.bodies[1].conductivity, found.temperature_1) == (0.05, 2.0, 333.15)
    assert found.temperature_2 == 313.15


def test_numbers_do_without_names():
    found = case_of({**ALL, "inlet_factor": "none", "viscosity": "exponential"}, ELASTIC, NUMBERS).thermal
    assert found.bodies[0] == found.bodies[1]
    assert (found.viscosity, found.inlet_factor) == ("exponential", "none")


def test_python_and_case_files_mean_the_same():
    named = {"radius": "10 mm", "load": 20, "mean_speed": 0.5, **BODIES, "oil": "squalane", "temperature": "40 degC"}
    assert ertel.rolling(**named, thermal={}) == case_of({})
    warm = ertel.rolling(**named, thermal={"temperature_2": 333.15, "beta": 0.04})
    assert warm == case_of({"temperature_2": "60 degC", "beta": "0.04 / K"})


COLD = {**ALL, "temperature": "-140 degC"}


@pytest.mark.parametrize(
    ("thermal", "contact", "lubricant", "said"),
    [
        ({}, ELASTIC, NAMED, 'density_1: missing; give it, .*"7850 kg/m.3", or name .*contact.material_1'),
        ({}, BODIES, NUMBERS, 'temperature: missing; give that of the oil in the inlet, .*"40 degC"'),
        ({"temperature": "40 degC"}, BODIES, NUMBERS, "conductivity: missing; give it, .*lubricant.oil"),
        ({}, BODIES, {**NAMED, "oil": "pao-100"}, 'conductivity: missing; the library has none .*"pao-100"'),
        ({"temperature_1": 60}, BODIES, NAMED, "temperature_1 = 60: must be a temperature with its unit"),
        ({"temperature_2": "60 mm"}, BODIES, NAMED, 'temperature_2 = "60 mm": must be a temperature with its'),
        ({"beta": "0 / K"}, BODIES, NAMED, 'beta = "0 / K": must be a quantity above zero'),
        ({"conductivity_1": "47"}, BODIES, NAMED, 'conductivity_1 = "47": must be a quantity above zero'),
        ({"inlet_factor": "moes"}, BODIES, NAMED, "inlet_factor = \"moes\": allowed: 'gupta', 'wilson-sheu'"),
        ({"viscosity": "vogel"}, BODIES, NAMED, "viscosity = \"vogel\": allowed: 'houpert' or 'exponential'"),
        ({"density": "7850 kg/m^3"}, BODIES, NAMED, 'density = "7850 kg/m.3": unknown key; did you mean '),
        (COLD, BODIES, NUMBERS, 'viscosity = "houpert": temperature = 133.15 K: .* needs more than 138 K'),
    ],
)
def test_what_is_wrong_is_named(thermal: Any, contact: Any, lubricant: Any, said: str):
    with pytest.raises(ConfigError, match=rf"^thermal\.{said}") as error:
        case_of(thermal, contact, lubricant)
    assert "\n" not in str(error.value)


BALL = {"kind": "impact", "radius": "10 mm", "speed": "0.1 m/s", "ball_density": "7850 kg/m^3", **ELASTIC}
ROLLING = {**CONTACT, **ELASTIC}


@pytest.mark.parametrize(
    ("sections", "said"),
    [
        ({"contact": ROLLING, "solver": {"method": "transient"}}, 'is for a steady contact, and this one has .*"trans'),
        ({"contact": BALL}, 'is for a steady contact, and this one has solver.method = "2d"; leave'),
        ({"contact": {"kind": "rolling", "M": 100, "L": 5}, "lubricant": {}}, "needs a contact in SI"),
    ],
)
def test_temperatures_are_for_steady_contacts_in_SI(sections: dict[str, Any], said: str):
    with pytest.raises(ConfigError, match=f"^thermal: {said}"):
        parse_case({"lubricant": NUMBERS, "thermal": ALL, **sections})


def test_an_inlet_far_too_hot_for_the_formula():
    contact = {**BODIES, "mean_speed": "500 m/s", "load": "2000 N"}
    oil = {**NAMED, "oil": "iso-vg-100"}
    with pytest.raises(ConfigError, match=r'^thermal.inlet_factor = "gupta": its formula gives phi_T = -'):
        case_of({}, contact, oil)
    assert case_of({"inlet_factor": "wilson-sheu"}, contact, oil).thermal


def test_two_temperatures_of_the_inlet_are_refused():
    assert case_of({"temperature": "313.15 K"}).thermal.temperature == 313.15
    said = re.escape('thermal.temperature = "80 degC": differs from lubricant.temperature = "40 degC", for which')
    with pytest.raises(ConfigError, match=said):
        case_of({"temperature": "80 degC"})


def test_heat_needs_a_law_of_shear_thinning_where_the_surfaces_slide():
    sliding, oil = {**BODIES, "slide_to_roll": 0.1}, {**NAMED, "oil": "iso-vg-68"}
    with pytest.raises(ConfigError, match=r"^lubricant.rheology: missing; \[thermal\] needs it, .* stress of about 2"):
        case_of({}, sliding, oil)
    with pytest.raises(ConfigError, match=r"^lubricant.rheology: missing"):
        case_of(ALL, {**sliding, **ELASTIC}, {**NUMBERS, "viscosity": "barus", "alpha": "28 / GPa"})
    for rheology in ("newtonian", {"law": "ree-eyring", "tau0": "5 MPa"}):
        assert case_of({}, sliding, {**oil, "rheology": rheology}).thermal
    assert case_of({}, sliding, {**NAMED, "temperature": "25 degC"}).thermal  # it brings its law
    assert case_of({}, {**sliding, "slide_to_roll": 1e-4}, oil).thermal
    written = case_of({}, sliding, {**oil, "rheology": "newtonian"}).to_data()
    assert parse_case(written).thermal  # a stored run can be read
