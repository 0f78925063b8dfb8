"""The key `rheology` of a case: laws of shear thinning in case files and in Python, written down and read back."""

from typing import Any

import pytest

from ertel.case.case import Case
from ertel.inputs import oils
from ertel.inputs.case_files import ConfigError
from ertel.inputs.python import Oil, impact, rolling
from ertel.physics.fluidity import Carreau, CarreauYasuda, Fluidity, Limited, ReeEyring
from ertel.runs.batch import check_alike

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


def test_a_batch_takes_one_kind_of_law() -> None:
    laws = ReeEyring(5e6), ReeEyring(2e6), "newtonian"
    first, second, other = (rolling(**LOADED, method="transient", rheology=law) for law in laws)
    check_alike([first, second])
    with pytest.raises(ValueError, match=r"^lubricant\.rheology"):
        check_alike([first, other])


# -- from the library -------------------------------------------------------------------------------------------------

COOL = {**LOADED, "oil": "squalane", "temperature": "25 degC"}
WARM = {**LOADED, "oil": "pao-100", "temperature": "60 degC"}
EYRING = {"law": "ree-eyring", "tau0": "5 MPa"}


@pytest.mark.parametrize(
    ("contact", "written", "law"),
    [
        (COOL, "carreau", Carreau(6e6, 0.42)),
        (COOL, {"law": "carreau"}, Carreau(6e6, 0.42)),
        (COOL, {"law": "carreau", "n": 0.5}, Carreau(6e6, 0.5)),
        (COOL, {"law": "carreau", "G": "4 MPa"}, Carreau(4e6, 0.42)),
        (COOL, {"law": "limited", "base": "carreau", "Lambda": 0.05}, Limited(Carreau(6e6, 0.42), 0.05)),
        (WARM, {"law": "limited", "base": EYRING}, Limited(ReeEyring(5e6), 0.035)),
        (WARM, {"law": "limited", "base": EYRING, "Lambda": 0.04}, Limited(ReeEyring(5e6), 0.04)),
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
        (LOADED, {"law": "ree-eyring", "tau0": 5}, r"\.tau0 = 5: must be a quantity"),
        (LOADED, {"law": "ree-eyring"}, r"\.tau0: missing"),
        (LOADED, {"law": "carreau", "G": "6 MPa", "n": 1.5}, r"\.n = 1\.5: must be less than or equal to 1"),
        (LOADED, {"law": "carreau", "G": "6 MPa", "n": 0}, r"\.n = 0: must be greater than 0"),
        (LOADED, {"law": "eyring", "tau0": "5 MPa"}, r'\.law = "eyring"; allowed: newtonian, ree-eyring'),
        (LOADED, "ree-eyring", r' = "ree-eyring": has data of its own; give them as \{ law = "ree-eyring", \.\.\. \}'),
        (LOADED, "eyring", r' = "eyring": allowed: '),
        (LOADED, {**LIMITED, "base": "newtonian"}, r'\.base = "newtonian": must be a table'),
        (LOADED, ReeEyring(-1.0), r"\.tau0 = .*above zero"),
        (LOADED, Limited(Carreau(6e6, 2.0), 0.05), r"\.base\.n = .*less than or equal to 1"),
        ({**COOL, "temperature": "40 degC"}, "carreau", r' = "carreau": .* squalane at 25 degC, not at 40 degC'),
        (WARM, {"law": "carreau", "n": 0.5}, r" = .*: the library has no G of pao-100; give .*G = \.\.\. \}$"),
        (COOL, {"law": "limited", "base": EYRING}, r" = .*: the library has no Lambda of squalane; give .*Lambda = "),
        (WARM, {"law": "limited", "base": "carreau"}, r'\.base = "carreau": the library has no G and n of pao-100; '),
        (WARM, "limited", r"\.base: missing"),
        (COOL, {"law": ["carreau"]}, r"\.law = \[.carreau.\]; allowed: newtonian, "),
    ],
)
def test_what_is_wrong_is_said(contact: dict[str, Any], written: Any, said: str) -> None:
    """Also which data a named oil lacks; a law with all data needs none of them."""
    with pytest.raises(ConfigError, match=rf"^lubricant\.rheology{said}"):
        rolling(**contact, rheology=written)
    with_all = {"law": "carreau", "G": "5 MPa", "n": 0.5}
    assert rolling(**contact, rheology=with_all).oil.fluidity_law == Carreau(5e6, 0.5)


# -- oils bring their law ---------------------------------------------------------------------------------------------

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


def test_only_at_temperatures_that_have_a_source() -> None:
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
