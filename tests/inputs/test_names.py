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

CONTACT = {"kind": "rolling", "radius": "10 mm", "load": "20 N", "mean_speed": "0.5 m/s"}


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
    ball = {"radius": 0.01, "speed": 0.1, "material_1": "silicon-nitride", "material_2": "steel", "method": "radial"}
    case = ertel.impact(**ball, oil="iso-vg-68", temperature="60 degC")
    assert case.contact.ball_density == 3290.0
    assert ertel.impact(**ball, ball_density=3200, oil="iso-vg-68", temperature=333.15).contact.ball_density == 3200.0
    assert ertel.impact(**ball, mass="13 g", oil="iso-vg-68", temperature=333.15).contact.mass == 0.013


def test_python_and_case_files_mean_the_same():
    named = {"radius": "10 mm", "load": 20, "mean_speed": 0.5, **BODIES, "oil": "squalane"}
    case = case_of()
    assert ertel.rolling(**named, temperature="40 degC") == case
    assert ertel.rolling(**named, temperature=313.15) == case
    assert ertel.rolling(**named, temperature=pint.UnitRegistry().Quantity(40.0, "degC")) == case
    assert ertel.rolling(**{**named, "oil": oils.at("squalane", "40 degC")}) == case
    case = case_of(oil=SHEET, temperature="60 degC", alpha="20 / GPa")
    same = oils.data_sheet("68 mm^2/s", "8.7 mm^2/s", 880.0, "60 degC")
    assert case.oil.eta0 == same.eta0
    assert case.oil.alpha == pytest.approx(20e-9, rel=1e-15)
    assert parse_case(tomllib.loads(ertel.to_toml(case))) == case


def test_given_values_win():
    oil = case_of(**NAMED, eta0="20 mPa*s").oil
    assert oil.eta0 == 0.02
    assert (oil.viscosity, oil.alpha) == (oils.at("squalane", 313.15).viscosity, oils.at("squalane", 313.15).alpha)
    assert oil.reference.endswith("Given: eta0.")
    oil = case_of(**NAMED, viscosity="isoviscous", density="incompressible", reference="mine").oil
    assert (oil.viscosity, oil.density, oil.reference) == ("isoviscous", "incompressible", "mine")
    contact = case_of({**BODIES, "E1": "206 GPa"}).contact
    assert (contact.E1, contact.nu1, contact.E2) == (206e9, 0.3, 82e9)
    assert case_of({**BODIES, "E_prime": "117 GPa"}).contact.given == ("radius", "load", "mean_speed", "E_prime")
    mixed = case_of({"material_1": "steel", "E2": "75 GPa", "nu2": 0.22}).contact
    assert (mixed.E1, mixed.E2) == (210e9, 75e9)


@pytest.mark.parametrize(("given", "law"), [({}, "roelands"), ({"viscosity": "barus"}, "barus")])
def test_a_given_alpha_wins_over_the_oils_own_pressure_law(given, law):
    oil = case_of(**NAMED, alpha="18 / GPa", **given).oil
    assert (oil.viscosity, oil.alpha) == (law, 18e-9)
    assert oil.eta0 == oils.at("squalane", 313.15).eta0
    assert oil.reference.endswith("Given: alpha, viscosity." if given else "Given: alpha.")


Data = dict[str, Any]


def warm(thermal: Data, contact: Data = BODIES, lubricant: Data = NAMED) -> ertel.Case:
    return parse_case({"contact": {**CONTACT, **contact}, "lubricant": lubricant, "thermal": thermal})


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
    named = {"radius": "10 mm", "load": 20, "mean_speed": 0.5, **BODIES, "oil": "squalane", "temperature": "40 degC"}
    assert ertel.rolling(**named, thermal={}) == warm({})
    one = ertel.rolling(**named, thermal={"temperature_2": 333.15, "beta": 0.04})
    assert one == warm({"temperature_2": "60 degC", "beta": "0.04 / K"})


def test_resolved_thermal_data_are_written_and_read_back():
    case = warm({"temperature_1": "60 degC"})
    assert 'temperature_1 = "333.15 K"' in ertel.to_toml(case) and case.digest != warm({}).digest
    assert "thermal" not in case_of(**NAMED).to_data()
    exact = replace(case, thermal=replace(case.thermal, temperature_1=1000 / 3))  # of any number of digits
    for each in (case, exact):
        again = parse_case(tomllib.loads(ertel.to_toml(each)))
        assert again == each and again.digest == each.digest


def test_an_inlet_far_too_hot_for_the_formula():
    contact = {**BODIES, "mean_speed": "500 m/s", "load": "2000 N"}
    oil = {**NAMED, "oil": "iso-vg-100"}
    with pytest.raises(ConfigError, match=r'^thermal.inlet = "gupta": its formula gives phi_T = -'):
        warm({"inlet": "gupta"}, contact, oil)
    assert warm({"inlet": "wilson-sheu"}, contact, oil).thermal


def test_heat_needs_a_law_of_shear_thinning_where_the_surfaces_slide():
    sliding, oil = {**BODIES, "slide_to_roll": 0.1}, {**NAMED, "oil": "iso-vg-68"}
    with pytest.raises(ConfigError, match=r"^lubricant.rheology: missing; \[thermal\] needs it, .* stress of about 2"):
        warm({}, sliding, oil)
    with pytest.raises(ConfigError, match=r"^lubricant.rheology: missing"):
        warm(HOT, {**sliding, **{"E_prime": "226 GPa"}}, {**NUMBERS, "viscosity": "barus", "alpha": "28 / GPa"})
    for rheology in ("newtonian", {"law": "ree-eyring", "tau0": "5 MPa"}):
        assert warm({}, sliding, {**oil, "rheology": rheology}).thermal
    assert warm({}, sliding, {**NAMED, "temperature": "25 degC"}).thermal  # it brings its law
    assert warm({}, {**sliding, "slide_to_roll": 1e-4}, oil).thermal
    written = warm({}, sliding, {**oil, "rheology": "newtonian"}).to_data()
    assert parse_case(written).thermal  # a stored run can be read


BALL = {"radius": 0.01, "E_prime": 226e9, "oil": Oil(eta0=0.04, alpha=20e-9), "nodes": 65}
LOADED = {**BALL, "load": 20.0, "mean_speed": 1.0}
LIMITED = {"law": "limited", "base": {"law": "carreau", "G": "6 MPa", "n": 0.42}, "Lambda": 0.05}
WRITTEN: list[tuple[Any, Fluidity]] = [
    ({"law": "ree-eyring", "tau0": "5 MPa"}, ReeEyring(5e6)),
    ({"law": "carreau", "G": "6 MPa", "n": 0.42}, Carreau(6e6, 0.42)),
    ({"law": "carreau-yasuda", "G": "6 MPa", "n": 1, "a": 1.5}, CarreauYasuda(6e6, 1.0, 1.5)),
    (LIMITED, Limited(Carreau(6e6, 0.42), 0.05)),
]


@pytest.mark.parametrize(("written", "law"), WRITTEN, ids=lambda x: x["law"] if isinstance(x, dict) else "")
def test_a_law_is_written_and_read_back(written: Any, law: Fluidity) -> None:
    case = rolling(**LOADED, rheology=written)
    assert case.oil.fluidity_law == law
    assert case == rolling(**LOADED, rheology=law) == Case.from_data(case.to_data())
    plain = rolling(**LOADED)
    assert case.digest != plain.digest and plain == rolling(**LOADED, rheology="newtonian")
    assert plain.oil.is_newtonian and plain == Case.from_data(plain.to_data())


def test_where_an_oil_that_thins_does_not_work() -> None:
    with pytest.raises(ConfigError, match=r"rheology.*dimensionless.*in SI"):
        rolling(M=200, L=10, rheology=ReeEyring(5e6))
    with pytest.raises(ConfigError, match=r'rheology.*"radial" is for Newtonian oils only'):
        impact(**BALL, ball_density=7850, speed=0.1, method="radial", rheology=ReeEyring(5e6))


COOL = {**LOADED, "oil": "squalane", "temperature": "25 degC"}
WARM = {**LOADED, "oil": "pao-100", "temperature": "60 degC"}
EYRING = {"law": "ree-eyring", "tau0": "5 MPa"}


@pytest.mark.parametrize(
    ("contact", "written", "law"),
    [
        (COOL, "carreau", Carreau(6e6, 0.42)),
        (COOL, {"law": "carreau", "G": "4 MPa"}, Carreau(4e6, 0.42)),
        (COOL, {"law": "limited", "base": "carreau", "Lambda": 0.05}, Limited(Carreau(6e6, 0.42), 0.05)),
        (WARM, {"law": "limited", "base": EYRING}, Limited(ReeEyring(5e6), 0.035)),
    ],
)
def test_a_law_takes_the_data_of_a_named_oil(contact: dict[str, Any], written: Any, law: Fluidity) -> None:
    """What is given wins; the case holds numbers, and the sources of those it was not given."""
    case = rolling(**contact, rheology=written)
    assert case.oil.fluidity_law == law
    assert case == Case.from_data(case.to_data()) == rolling(**contact, rheology=law)
    used = "Rheology: Liu" if contact is COOL else "Rheology: Arana"
    assert (used in case.oil.reference) == (written != {"law": "limited", "base": EYRING, "Lambda": 0.04})


@pytest.mark.parametrize(
    ("contact", "written", "said"),
    [
        (LOADED, {"law": "ree-eyring"}, r"\.tau0: missing"),
        (LOADED, {"law": "carreau", "G": "6 MPa", "n": 1.5}, r"\.n = 1\.5: must be less than or equal to 1"),
        (LOADED, {"law": "eyring", "tau0": "5 MPa"}, r'\.law = "eyring"; allowed: newtonian, ree-eyring'),
        (LOADED, "ree-eyring", r' = "ree-eyring": has data of its own; give them as \{ law = "ree-eyring", \.\.\. \}'),
        (LOADED, {**LIMITED, "base": "newtonian"}, r'\.base = "newtonian": must be a table'),
        (LOADED, Limited(Carreau(6e6, 2.0), 0.05), r"\.base\.n = .*less than or equal to 1"),
        ({**COOL, "temperature": "40 degC"}, "carreau", r' = "carreau": .* squalane at 25 degC, not at 40 degC'),
        (WARM, {"law": "carreau", "n": 0.5}, r" = .*: the library has no G of pao-100; give .*G = \.\.\. \}$"),
        (WARM, {"law": "limited", "base": "carreau"}, r'\.base = "carreau": the library has no G and n of pao-100; '),
    ],
)
def test_what_is_wrong_is_said(contact: dict[str, Any], written: Any, said: str) -> None:
    """Also which data a named oil lacks; a law with all data needs none of them."""
    with pytest.raises(ConfigError, match=rf"^lubricant\.rheology{said}"):
        rolling(**contact, rheology=written)
    with_all = {"law": "carreau", "G": "5 MPa", "n": 0.5}
    assert rolling(**contact, rheology=with_all).oil.fluidity_law == Carreau(5e6, 0.5)


FALLING = {"radius": 0.01, "E_prime": 226e9, "ball_density": 7850, "speed": 0.1, "nodes": 65}
SQUALANE = {"oil": "squalane", "temperature": "25 degC"}


def test_a_named_oil_brings_the_law_of_the_library() -> None:
    case = rolling(**COOL)
    assert case.oil.rheology == Carreau(6e6, 0.42)
    assert "Rheology: Liu HC" in case.oil.reference
    assert case == rolling(**COOL, rheology="carreau") == rolling(**{**LOADED, "oil": oils.at("squalane", "25 degC")})
    assert impact(**FALLING, **SQUALANE).oil.rheology == Carreau(6e6, 0.42)
    plain = rolling(**COOL, rheology="newtonian")
    assert plain.oil.is_newtonian and "Rheology" not in plain.oil.reference
    assert plain.parameters == case.parameters
    assert oils.at("squalane", "25 degC", rheology="newtonian").is_newtonian
    named = {**COOL, "temperature": "40 degC"}
    case = rolling(**named)
    assert case.oil.is_newtonian
    assert rolling(**named, rheology=LIMITED).oil.rheology == Limited(Carreau(6e6, 0.42), 0.05)
    said = "Rheology: Newtonian, the library has G and n of squalane at 25 degC, not at 40 degC."
    assert case.oil.reference.endswith(said)


@pytest.mark.parametrize(
    ("contact", "reason"),
    [
        ({**FALLING, "method": "radial"}, 'solver.method = "radial" takes no other oils'),
        ({"M": 100, "L": 5}, "a dimensionless case has no stresses in Pa"),
    ],
)
def test_a_named_oil_is_newtonian_where_no_other_is_possible(contact: dict[str, Any], reason: str) -> None:
    oil = impact(**contact, **SQUALANE).oil
    assert oil.is_newtonian
    assert f"Rheology: Newtonian, because {reason}." in oil.reference
