"""Warnings that need no run: yield, the pressures of the oil's law, shear stress of a Newtonian oil, thin films."""

import warnings
from dataclasses import replace
from math import exp
from typing import Any

import pytest

import ertel
from ertel.case.estimates import newtonian_stress
from ertel.runs.outlook import beyond, outlook

STEEL = {"material_1": "steel", "material_2": "steel"}
BALL = {"radius": "10 mm", "load": "20 N", "mean_speed": 1.0, "nodes": 33, **STEEL}
VG68 = {"oil": "iso-vg-68", "temperature": "40 degC"}
OWN = {"oil": ertel.Oil(eta0="10 mPa*s", alpha="15 / GPa")}


def said(**more: Any) -> str:
    return " ".join(outlook(ertel.rolling(**{**BALL, **more}))["warnings"])


def test_inside_of_the_model_nothing_is_said() -> None:
    assert beyond(ertel.rolling(**BALL, **VG68)) == []
    assert beyond(ertel.rolling(M=100, L=5)) == []
    # Of 60 HRC: 697 HV, 1.6/3 of it is 3.65 GPa; p_h goes with the third root of the load, 0.80 GPa at 20 N.
    assert "yields from about 3.648 GPa" in said(**VG68, load="7 kN")  # 5.65 GPa
    assert "yields" not in said(**VG68, load="1.8 kN")  # 3.59 GPa
    grows = {"method": "transient", "motion": {"load": [[0, 1], ["1 ms", 4]]}, "until": "2 ms", "half_width": 4.0}
    assert "yields" in said(**VG68, load="1 kN", **grows)
    assert "yields" not in said(**VG68, load="7 kN", material_1="glass", material_2="glass")
    fall = ertel.impact(radius="10 mm", speed=5.0, **STEEL, **VG68, method="radial", nodes=65)
    assert sum("yields" in sentence for sentence in outlook(fall)["warnings"]) == 1


def test_pressures_for_which_an_oil_has_a_source() -> None:
    pao = {"oil": "pao-100", "temperature": "60 degC", "rheology": {"law": "ree-eyring", "tau0": "5 MPa"}}
    assert "has a source up to 1 GPa, and this contact has 1.088 GPa" in said(**pao, load="50 N", slide_to_roll=0.1)
    assert "has a source up to" not in said(**pao, load="50 N")  # the film is made in the inlet
    assert "has a source up to" not in said(**pao, load="30 N", slide_to_roll=0.1)
    assert "up to 200 MPa" in said(oil="squalane", temperature="40 degC", slide_to_roll=0.1)
    assert "has a source up to" not in said(oil="squalane", temperature="25 degC", slide_to_roll=0.1)


def test_the_shear_stress_of_a_newtonian_oil() -> None:
    assert "Newtonian, and sliding would give it a mean shear stress of about 37" in said(**VG68, slide_to_roll=0.1)
    eyring = {"law": "ree-eyring", "tau0": "5 MPa"}
    for quiet in ({}, {"slide_to_roll": 1e-6}, {"slide_to_roll": 0.1, "rheology": eyring}):
        assert "Newtonian" not in said(**VG68, **quiet)
    # An isoviscous oil has eta0 u_s/h everywhere; a Barus oil the mean of exp(alpha p) over the Hertz contact.
    oil = ertel.Oil(eta0=0.04, alpha=10e-9, viscosity="isoviscous")
    case = ertel.rolling(**{**BALL, "oil": oil, "slide_to_roll": 0.5})
    assert case.scales is not None
    film = case.film_scale * case.scales.film
    assert newtonian_stress(case) == pytest.approx(0.04 * 0.5 / film, rel=1e-12)
    barus = ertel.rolling(**{**BALL, "oil": replace(oil, viscosity="barus"), "slide_to_roll": 0.5})
    assert barus.scales is not None
    x = 10e-9 * barus.scales.p_h
    mean = 2 * ((x - 1) * exp(x) + 1) / x**2
    film = barus.film_scale * barus.scales.film
    assert newtonian_stress(barus) == pytest.approx(mean * 0.04 * 0.5 / film, rel=1e-9)


def test_films_of_molecules_and_the_inertia_of_the_oil() -> None:
    slow = ertel.rolling(**{**BALL, **OWN, "mean_speed": 1e-4})
    assert "is thinner than 1 nm" in said(**OWN, mean_speed=1e-4)
    assert slow.film_scale * slow.scales.film < 1e-9 < 20 * slow.film_scale * slow.scales.film
    assert "molecules" not in said(**OWN, mean_speed=1e-2)
    # A glass bead of 5.5 mm falls on 0.2 mm of water with 1 m/s: rho v h/eta0 = 900 1 2e-4/1e-3 = 180.
    bead = {"radius": "2.75 mm", "ball_density": "2580 kg/m^3", "material_1": "glass", "material_2": "glass"}
    water = ertel.Oil(eta0="1 mPa*s", viscosity="isoviscous", density="incompressible")
    case = ertel.impact(**bead, speed="1 m/s", oil=water, layer="0.2 mm", method="radial", half_width=14, nodes=193)
    assert any("rho v h/eta0 = 1.8e+02 is above 1" in sentence for sentence in outlook(case)["warnings"])
    oil = replace(water, eta0=1.0)
    slow = ertel.impact(**bead, speed="1 m/s", oil=oil, layer="0.2 mm", method="radial", half_width=14, nodes=193)
    assert not any("inertia" in sentence for sentence in outlook(slow)["warnings"])


def test_a_low_stokes_number_and_the_first_film_of_an_impact() -> None:
    """Of a rebound from a full gap: restitution is an upper bound."""
    of = {"L": 5, "method": "radial", "until": "rebound"}
    heavy, light, to_the_bottom = ertel.impact(M=1000, **of), ertel.impact(M=20, **of), {**of, "until": "max-approach"}
    held = [
        any("upper bound" in sentence for sentence in outlook(case)["warnings"])
        for case in (heavy, light, ertel.impact(M=20, **to_the_bottom), ertel.impact(M=20, layer=0.1, **of))
    ]
    assert held == [False, True, False, False]
    # Squeezed by a ball from far, or the gap itself.
    near = {"M": 200, "L": 10, "method": "radial", "start_approach": -0.03}
    assert outlook(ertel.impact(**near))["start"] == pytest.approx({"film": 0.1984, "load": 0.1228}, abs=1e-4)
    undeformed = ertel.impact(**near, start="undeformed")
    assert outlook(undeformed)["start"] == pytest.approx({"film": 0.03, "load": 0.0})
    assert undeformed.digest != ertel.impact(**near).digest


def test_python_warns_before_the_run_and_once() -> None:
    case = ertel.rolling(**BALL, **OWN, tolerance=0.5, slide_to_roll=0.1)
    seen: list[int] = []
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("ignore")  # of sockets that earlier tests have left
        warnings.simplefilter("always", UserWarning)
        result = ertel.simulate(case, observers=[lambda item: seen.append(len(caught))])
    assert seen[0] == 1 and "the oil is Newtonian" in str(caught[0].message)
    assert caught[0].filename == __file__
    assert sum("the oil is Newtonian" in str(each.message) for each in caught) == 1
    assert "the oil is Newtonian" in result.warnings[0]
