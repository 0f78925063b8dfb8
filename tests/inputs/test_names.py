"""Oils and materials by name, in case files and from Python: they become numbers, and given values win."""

import tomllib
from typing import Any

import pint
import pytest

import ertel
from ertel.case.records import ConfigError
from ertel.inputs import oils
from ertel.inputs.case_files import apply_overrides, parse_case
from ertel.physics.lubricant import Doolittle

CONTACT = {"kind": "rolling", "radius": "10 mm", "load": "20 N", "mean_speed": "0.5 m/s"}
BODIES = {"material_1": "steel", "material_2": "glass"}
NAMED = {"oil": "squalane", "temperature": "40 degC"}


def case_of(contact: dict[str, Any] | None = None, **lubricant: Any) -> ertel.Case:
    return parse_case({"contact": {**CONTACT, **(contact or BODIES)}, "lubricant": lubricant or NAMED})


def test_names_become_numbers():
    case = case_of()
    contact = case.contact
    assert (contact.E1, contact.nu1, contact.E2, contact.nu2) == (210e9, 0.3, 82e9, 0.206)
    assert contact.ball_density is None  # a rolling ball has inertia only if it is asked for
    assert case.oil == oils.at("squalane", "40 degC")
    assert isinstance(case.oil.viscosity, Doolittle)
    assert case.oil.reference.startswith("squalane at 40 degC. Viscosity: Schmidt")
    written = ertel.to_toml(case)
    assert "oil =" not in written and "temperature" not in written


def test_python_and_case_files_mean_the_same():
    named = {"radius": "10 mm", "load": 20, "mean_speed": 0.5, **BODIES, "oil": "squalane"}
    case = case_of()
    assert ertel.rolling(**named, temperature="40 degC") == case
    assert ertel.rolling(**named, temperature=313.15) == case
    assert ertel.rolling(**named, temperature=pint.UnitRegistry().Quantity(40.0, "degC")) == case
    assert ertel.rolling(**{**named, "oil": oils.at("squalane", "40 degC")}) == case


def test_the_material_of_an_impact_gives_the_ball_its_density():
    ball = {"radius": 0.01, "speed": 0.1, "material_1": "silicon-nitride", "material_2": "steel", "method": "radial"}
    case = ertel.impact(**ball, oil="iso-vg-68", temperature="60 degC")
    assert case.contact.ball_density == 3290.0
    assert ertel.impact(**ball, ball_density=3200, oil="iso-vg-68", temperature=333.15).contact.ball_density == 3200.0
    assert ertel.impact(**ball, mass="13 g", oil="iso-vg-68", temperature=333.15).contact.mass == 0.013


# -- given values win -------------------------------------------------------------------------------------------------


def test_a_given_viscosity_wins():
    oil = case_of(**NAMED, eta0="20 mPa*s").oil
    assert oil.eta0 == 0.02
    assert (oil.viscosity, oil.alpha) == (oils.at("squalane", 313.15).viscosity, oils.at("squalane", 313.15).alpha)
    assert oil.reference.endswith("Given: eta0.")


@pytest.mark.parametrize(("given", "law"), [({}, "roelands"), ({"viscosity": "barus"}, "barus")])
def test_a_given_alpha_wins_over_the_oils_own_pressure_law(given, law):
    oil = case_of(**NAMED, alpha="18 / GPa", **given).oil
    assert (oil.viscosity, oil.alpha) == (law, 18e-9)
    assert oil.eta0 == oils.at("squalane", 313.15).eta0
    assert oil.reference.endswith("Given: alpha, viscosity." if given else "Given: alpha.")


def test_a_given_law_and_a_given_source_win():
    oil = case_of(**NAMED, viscosity="isoviscous", density="incompressible", reference="mine").oil
    assert (oil.viscosity, oil.density, oil.reference) == ("isoviscous", "incompressible", "mine")


def test_given_elasticity_wins():
    contact = case_of({**BODIES, "E1": "206 GPa"}).contact
    assert (contact.E1, contact.nu1, contact.E2) == (206e9, 0.3, 82e9)
    assert case_of({**BODIES, "E_prime": "117 GPa"}).contact.given == ("radius", "load", "mean_speed", "E_prime")
    mixed = case_of({"material_1": "steel", "E2": "75 GPa", "nu2": 0.22}).contact
    assert (mixed.E1, mixed.E2) == (210e9, 75e9)


def test_the_temperature_of_a_case_file_can_be_replaced():
    data = {"contact": {**CONTACT, **BODIES}, "lubricant": NAMED}
    warm = parse_case(apply_overrides(data, ["lubricant.temperature=80 degC"]))
    assert warm.oil == oils.at("squalane", "80 degC")


# -- what is wrong ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("lubricant", "message"),
    [
        *[({**NAMED, "oil": oil}, "oil = .*: allowed: .*squalane$") for oil in ("squalan", 7, ["squalane"])],
        ({**NAMED, "temperature": "120 degC"}, 'temperature = "120 degC": must be between 25 degC and 100 degC'),
        ({**NAMED, "temperature": 40}, "temperature = 40: must be a temperature with its unit"),
        ({**NAMED, "temperature": "40"}, 'temperature = "40": must be a temperature with its unit'),
        ({"oil": "squalane"}, 'temperature: missing; oil = "squalane" needs it'),
        ({"temperature": "40 degC"}, 'temperature = "40 degC": needs lubricant.oil, one of iso-vg-100'),
        ({**NAMED, "oill": 1}, r"oill = 1: unknown key; did you mean oil\? allowed: oil, temperature"),
    ],
)
def test_what_is_wrong_with_an_oil(lubricant, message):
    with pytest.raises(ConfigError, match=f"^lubricant.{message}"):
        case_of(**lubricant)


@pytest.mark.parametrize(
    ("contact", "message"),
    [
        ({**BODIES, "material_2": "wood"}, 'material_2 = "wood": allowed: glass, sapphire, '),
        ({**BODIES, "material_2": 2}, "material_2 = 2: allowed: glass, sapphire, "),
        ({"material_1": "steel"}, "E2: missing"),
        ({**BODIES, "temperature": "40 degC"}, 'temperature = "40 degC": unknown key; allowed: material_1, '),
    ],
)
def test_what_is_wrong_with_a_material(contact, message):
    with pytest.raises(ConfigError, match=f"^contact.{message}"):
        case_of(contact)


def test_a_dimensionless_contact_has_no_materials():
    with pytest.raises(ConfigError, match=r'^contact.material_1 = "steel": a dimensionless contact has no materials'):
        parse_case({"contact": {"M": 100, "L": 5, "material_1": "steel"}})


SHEET = {"nu40": "68 mm^2/s", "nu100": "8.7 mm^2/s", "density": "880 kg/m^3"}


def test_an_oil_is_described_by_its_data_sheet():
    case = case_of(oil=SHEET, temperature="60 degC", alpha="20 / GPa")
    same = oils.data_sheet("68 mm^2/s", "8.7 mm^2/s", 880.0, "60 degC")
    assert case.oil.eta0 == same.eta0
    assert case.oil.alpha == pytest.approx(20e-9, rel=1e-15)
    assert parse_case(tomllib.loads(ertel.to_toml(case))) == case


@pytest.mark.parametrize(
    ("sheet", "message"),
    [
        ({**SHEET, "nu20": "200 mm^2/s"}, 'lubricant.oil.nu20 = "200 mm^2/s": unknown key; did you mean '),
        ({"nu40": "68 mm^2/s", "density": "880 kg/m^3"}, "lubricant.oil.nu100: missing"),
        ({**SHEET, "nu100": "70 mm^2/s"}, "lubricant.oil.nu40 = 68 mm^2/s and nu100 = 70 mm^2/s: must be nu40 > nu100"),
        ({**SHEET, "k" * 3000: 1.0}, 'lubricant.oil."kkk'),
        ({**SHEET, "nu40": 10**400}, "lubricant.oil.nu40 = (an integer of about 400 digits"),
    ],
    ids=lambda value: str(value)[:40],
)
def test_a_wrong_data_sheet_is_refused(sheet: dict[str, Any], message: str):
    with pytest.raises(ConfigError) as error:
        case_of(oil=sheet, temperature="60 degC")
    assert str(error.value).startswith(message) and len(str(error.value)) < 500
