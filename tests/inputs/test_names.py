"""Oils and materials by name, in case files and from Python; given values win; laws of shear thinning."""

import tomllib
from dataclasses import replace
from typing import Any

import pint
import pytest
from cases import BODIES, HOT, NAMED, NUMBERS, SHEET

import ertel
from ertel.case.case import Case
from ertel.inputs import oils
from ertel.inputs.case_files import ConfigError, parse_case
from ertel.inputs.python import Oil, impact, rolling
from ertel.physics.fluidity import Carreau, Fluidity, Limited, ReeEyring
from ertel.physics.laws.carreau_yasuda import CarreauYasuda
from ertel.physics.lubricant import Doolittle

Data = dict[str, Any]
CONTACT = {"kind": "rolling", "radius": "10 mm", "load": "20 N", "mean_speed": "0.5 m/s"}
TYPED = {"radius": "10 mm", "load": 20, "mean_speed": 0.5, **BODIES, "oil": "squalane"}  # the same in Python


def case_of(contact: Data | None = None, **lubricant: Any) -> Case:
    return parse_case({"contact": {**CONTACT, **(contact or BODIES)}, "lubricant": lubricant or NAMED})


def warm(thermal: Data, contact: Data = BODIES, lubricant: Data = NAMED) -> Case:
    return parse_case({"contact": {**CONTACT, **contact}, "lubricant": lubricant, "thermal": thermal})


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
    ball = {"radius": 0.01, "speed": 0.1, "material_1": "silicon-nitride", "material_2": "steel", "method": "radial"}
    ball |= {"oil": "iso-vg-68", "temperature": "60 degC"}
    assert impact(**ball).contact.ball_density == 3290.0
    assert impact(**ball, ball_density=3200).contact.ball_density == 3200.0
    assert impact(**ball, mass="13 g").contact.mass == 0.013


def test_python_and_case_files_mean_the_same():
    case = case_of()
    assert rolling(**TYPED, temperature="40 degC") == rolling(**TYPED, temperature=313.15) == case
    of_pint = pint.UnitRegistry().Quantity
    assert rolling(**{**TYPED, "radius": of_pint(10, "mm")}, temperature=of_pint(40.0, "degC")) == case
    assert rolling(**{**TYPED, "oil": oils.at("squalane", "40 degC")}) == case
    case = case_of(oil=SHEET, temperature="60 degC", alpha="20 / GPa")
    assert case.oil.eta0 == oils.data_sheet("68 mm^2/s", "8.7 mm^2/s", 880.0, "60 degC").eta0
    assert case.oil.alpha == pytest.approx(20e-9, rel=1e-15)
    assert parse_case(tomllib.loads(ertel.to_toml(case))) == case
    assert rolling(**TYPED, temperature="40 degC", thermal={}) == warm({})
    one = rolling(**TYPED, temperature="40 degC", thermal={"temperature_2": 333.15, "beta": 0.04})
    assert one == warm({"temperature_2": "60 degC", "beta": "0.04 / K"})


def test_given_values_win():
    named = oils.at("squalane", 313.15)
    oil = case_of(**NAMED, eta0="20 mPa*s").oil
    assert oil.eta0 == 0.02
    assert (oil.viscosity, oil.alpha) == (named.viscosity, named.alpha)
    assert oil.reference.endswith("Given: eta0.")
    oil = case_of(**NAMED, viscosity="isoviscous", density="incompressible", reference="mine").oil
    assert (oil.viscosity, oil.density, oil.reference) == ("isoviscous", "incompressible", "mine")
    for given, law, said in (({}, "roelands", "Given: alpha."), ({"viscosity": "barus"}, "barus", "alpha, viscosity.")):
        oil = case_of(**NAMED, alpha="18 / GPa", **given).oil
        assert (oil.viscosity, oil.alpha, oil.eta0) == (law, 18e-9, named.eta0)
        assert oil.reference.endswith(said)
    contact = case_of({**BODIES, "E1": "206 GPa"}).contact
    assert (contact.E1, contact.nu1, contact.E2) == (206e9, 0.3, 82e9)
    assert case_of({**BODIES, "E_prime": "117 GPa"}).contact.given == ("radius", "load", "mean_speed", "E_prime")
    mixed = case_of({"material_1": "steel", "E2": "75 GPa", "nu2": 0.22}).contact
    assert (mixed.E1, mixed.E2) == (210e9, 75e9)


def test_names_give_all_thermal_data():
    found = warm({}).thermal
    assert warm({"temperature": "313.15 K"}).thermal == found  # as it is in [lubricant]
    assert (found.temperature, found.temperature_1, found.temperature_2) == (313.15, 313.15, 313.15)
    assert found.conductivity == 0.14
    assert found.beta == pytest.approx(0.0367, abs=1e-4)
    assert (found.density, found.expansion) == (pytest.approx(795, abs=5), pytest.approx(8e-4, rel=0.15))
    assert found.bodies[0].conductivity == 47.0 and found.bodies[0].density == 7850.0
    assert found.bodies[1].heat_capacity == 880.0
    assert (found.viscosity, found.inlet) == ("houpert", "solved")
    found = warm({"beta": "0.05 / K", "conductivity_2": "2 W/(m*K)", "temperature_1": "60 degC"}).thermal
    assert (found.beta, found.bodies[1].conductivity, found.temperature_1) == (0.05, 2.0, 333.15)
    assert found.temperature_2 == 313.15


def test_resolved_thermal_data_are_written_and_read_back():
    case = warm({"temperature_1": "60 degC"})
    assert 'temperature_1 = "333.15 K"' in ertel.to_toml(case) and case.digest != warm({}).digest
    assert "thermal" not in case_of(**NAMED).to_data()
    exact = replace(case, thermal=replace(case.thermal, temperature_1=1000 / 3))  # of any number of digits
    for each in (case, exact):
        again = parse_case(tomllib.loads(ertel.to_toml(each)))
        assert again == each and again.digest == each.digest


def test_heat_needs_a_law_of_shear_thinning_where_the_surfaces_slide_and_an_inlet_that_is_not_far_too_hot():
    fast, oil = {**BODIES, "mean_speed": "500 m/s", "load": "2000 N"}, {**NAMED, "oil": "iso-vg-100"}
    with pytest.raises(ConfigError, match=r'^thermal.inlet = "gupta": its formula gives phi_T = -'):
        warm({"inlet": "gupta"}, fast, oil)
    assert warm({"inlet": "wilson-sheu"}, fast, oil).thermal
    sliding, oil = {**BODIES, "slide_to_roll": 0.1}, {**NAMED, "oil": "iso-vg-68"}
    with pytest.raises(ConfigError, match=r"^lubricant.rheology: missing; \[thermal\] needs it, .* stress of about 2"):
        warm({}, sliding, oil)
    with pytest.raises(ConfigError, match=r"^lubricant.rheology: missing"):
        warm(HOT, {**sliding, "E_prime": "226 GPa"}, {**NUMBERS, "viscosity": "barus", "alpha": "28 / GPa"})
    for rheology in ("newtonian", {"law": "ree-eyring", "tau0": "5 MPa"}):
        assert warm({}, sliding, {**oil, "rheology": rheology}).thermal
    assert warm({}, sliding, {**NAMED, "temperature": "25 degC"}).thermal  # it brings its law
    assert warm({}, {**sliding, "slide_to_roll": 1e-4}, oil).thermal
    written = warm({}, sliding, {**oil, "rheology": "newtonian"}).to_data()
    assert parse_case(written).thermal  # a stored run can be read


# -- laws of shear thinning -------------------------------------------------------------------------------------------

BALL = {"radius": 0.01, "E_prime": 226e9, "oil": Oil(eta0=0.04, alpha=20e-9), "nodes": 65}
LOADED = {**BALL, "load": 20.0, "mean_speed": 1.0}
SQUALANE = {"oil": "squalane", "temperature": "25 degC"}
COOL = {**LOADED, **SQUALANE}
WARM = {**LOADED, "oil": "pao-100", "temperature": "60 degC"}
CARREAU = Carreau(6e6, 0.42)
EYRING = {"law": "ree-eyring", "tau0": "5 MPa"}
LIMITED = {"law": "limited", "base": {"law": "carreau", "G": "6 MPa", "n": 0.42}, "Lambda": 0.05}


@pytest.mark.parametrize(
    ("contact", "written", "law", "source"),
    [
        (LOADED, EYRING, ReeEyring(5e6), ""),
        (LOADED, {"law": "carreau", "G": "6 MPa", "n": 0.42}, CARREAU, ""),
        (LOADED, {"law": "carreau-yasuda", "G": "6 MPa", "n": 1, "a": 1.5}, CarreauYasuda(6e6, 1.0, 1.5), ""),
        (LOADED, LIMITED, Limited(CARREAU, 0.05), ""),
        # A law takes the data of a named oil; what is given wins.
        (COOL, "carreau", CARREAU, "Rheology: Liu"),
        (COOL, {"law": "carreau", "G": "4 MPa"}, Carreau(4e6, 0.42), "Rheology: Liu"),
        (COOL, {"law": "limited", "base": "carreau", "Lambda": 0.05}, Limited(CARREAU, 0.05), "Rheology: Liu"),
        (WARM, {"law": "limited", "base": EYRING}, Limited(ReeEyring(5e6), 0.035), "Rheology: Arana"),
    ],
)
def test_a_law_is_written_and_read_back(contact: Data, written: Any, law: Fluidity, source: str) -> None:
    """The case holds numbers, and the sources of those it was not given."""
    case = rolling(**contact, rheology=written)
    assert case.oil.fluidity_law == law
    assert case == rolling(**contact, rheology=law) == Case.from_data(case.to_data())
    assert source in case.oil.reference
    plain = rolling(**contact, rheology="newtonian")
    assert plain.oil.is_newtonian and case.digest != plain.digest
    assert plain == Case.from_data(plain.to_data()) and (plain == rolling(**contact)) == (contact is not COOL)


@pytest.mark.parametrize(
    ("contact", "written", "said"),
    [
        (LOADED, {"law": "ree-eyring"}, r"\.tau0: missing"),
        (LOADED, {"law": "carreau", "G": "6 MPa", "n": 1.5}, r"\.n = 1\.5: must be less than or equal to 1"),
        (LOADED, {"law": "eyring", "tau0": "5 MPa"}, r'\.law = "eyring"; allowed: newtonian, ree-eyring'),
        (LOADED, "ree-eyring", r' = "ree-eyring": has data of its own; .*law = "ree-eyring"'),
        (LOADED, {**LIMITED, "base": "newtonian"}, r'\.base = "newtonian": must be a table'),
        (LOADED, Limited(Carreau(6e6, 2.0), 0.05), r"\.base\.n = .*less than or equal to 1"),
        ({**COOL, "temperature": "40 degC"}, "carreau", r' = "carreau": .* squalane at 25 degC, not at 40 degC'),
        (WARM, {"law": "carreau", "n": 0.5}, r" = .*: the library has no G of pao-100; give .*G = \.\.\. \}$"),
        (WARM, {"law": "limited", "base": "carreau"}, r'\.base = "carreau": the library has no G and n of pao-100; '),
        ({"M": 200, "L": 10}, ReeEyring(5e6), ".*dimensionless.*in SI"),
    ],
)
def test_what_is_wrong_is_said(contact: Data, written: Any, said: str) -> None:
    """Also which data a named oil lacks."""
    with pytest.raises(ConfigError, match=rf"^lubricant\.rheology{said}"):
        rolling(**contact, rheology=written)


def test_a_named_oil_brings_the_law_of_the_library() -> None:
    case = rolling(**COOL)
    assert case.oil.rheology == CARREAU
    assert "Rheology: Liu HC" in case.oil.reference
    assert case == rolling(**COOL, rheology="carreau") == rolling(**{**LOADED, "oil": oils.at("squalane", "25 degC")})
    plain = rolling(**COOL, rheology="newtonian")
    assert plain.oil.is_newtonian and "Rheology" not in plain.oil.reference
    assert plain.parameters == case.parameters
    assert oils.at("squalane", "25 degC", rheology="newtonian").is_newtonian
    named = {**COOL, "temperature": "40 degC"}
    case = rolling(**named)
    assert case.oil.is_newtonian
    assert rolling(**named, rheology=LIMITED).oil.rheology == Limited(CARREAU, 0.05)  # it needs no data of the oil
    assert "Rheology: Newtonian, the library has G and n of squalane at 25 degC, not at 40" in case.oil.reference


def test_a_named_oil_is_newtonian_where_no_other_is_possible() -> None:
    falling = {"radius": 0.01, "E_prime": 226e9, "ball_density": 7850, "speed": 0.1, "nodes": 65}
    assert impact(**falling, **SQUALANE).oil.rheology == CARREAU
    for contact, reason in (
        ({**falling, "method": "radial"}, '"radial" takes no other oils'),
        ({"M": 100, "L": 5}, "Pa"),
    ):
        oil = impact(**contact, **SQUALANE).oil
        assert oil.is_newtonian
        assert "Rheology: Newtonian, because " in oil.reference and reason in oil.reference
    with pytest.raises(ConfigError, match=r'rheology.*"radial" is for Newtonian oils only'):
        impact(**{**BALL, **falling}, method="radial", rheology=ReeEyring(5e6))
