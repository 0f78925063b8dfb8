"""What a tribologist types in Python: the same keys, the same case and the same messages as in a case file."""

import inspect
import re
from dataclasses import fields

import numpy as np
import pytest
from cases import STEEL

import ertel
from ertel.case.conditions import FOREIGN, Conditions
from ertel.case.reading import NOT_THERE
from ertel.case.sections import Output, Solver, Time
from ertel.inputs.case_files import ConfigError, parse_case
from ertel.physics.lubricant import Roelands
from ertel.physics.units import Quantity

CONTACT = {"radius": "10 mm", "ball_density": "7850 kg/m^3", "speed": "0.1 m/s", **STEEL}
IN_SI = {"radius": 0.01, "ball_density": 7850, "speed": 0.1, "E1": 210e9, "nu1": 0.3, "E2": 210e9, "nu2": 0.3}
OIL = ertel.Oil(eta0=0.0186, alpha=20e-9)
LUBRICANT = {"eta0": "18.6 mPa*s", "alpha": "20 / GPa"}
ROLLING = {"radius": 0.01, "load": 40.0, "mean_speed": 0.5, "E_prime": 2.2e11}
ROLLING_TEXTS = {"radius": "10 mm", "load": "40 N", "mean_speed": "50 cm/s", "E_prime": "220 GPa"}


def names(record):
    return {item.name for item in fields(record)}


@pytest.mark.parametrize(("function", "kind"), [(ertel.impact, "impact"), (ertel.rolling, "rolling")])
def test_keywords_are_the_keys_of_case_files_and_explained(function, kind):
    """No more and no fewer; the tolerance in time has a name of its own beside the solver's."""
    time = names(Time) - {"tolerance"} | {"time_tolerance"}
    expected = names(Conditions) - {"kind"} - set(FOREIGN[kind]) | names(Solver) | time | names(Output)
    if kind == "rolling":
        expected -= {"start_approach", "start"}  # of an impact
        expected |= {"thermal"}  # of a steady contact
    beside = {"oil", "temperature", "rheology", "material_1", "material_2", "motion", "roughness", "surfaces", "name"}
    beside |= {"layer", "layer_1", "layer_2"}
    parameters = inspect.signature(function).parameters
    assert set(parameters) == expected | beside
    assert all(p.kind is inspect.Parameter.KEYWORD_ONLY for p in parameters.values())
    assert all(name in inspect.getdoc(function) for name in parameters)


@pytest.mark.parametrize("record", [ertel.Oil, ertel.Solver, ertel.Time, ertel.Output])
def test_every_field_of_a_record_has_its_meaning_unit_and_default(record):
    documented = inspect.getdoc(record)
    assert all(f"\n{name}" in documented for name in names(record))
    assert "Annotated" not in str(inspect.signature(record))
    assert "eta0 : quantity (Pa*s)\n    Viscosity at ambient pressure" in inspect.getdoc(ertel.Oil)
    assert "nodes : integer, default 257\n" in inspect.getdoc(ertel.Solver)


@pytest.mark.parametrize(
    ("functions", "keyword", "hint"),
    [
        ([ertel.impact, ertel.rolling], "raduis", r"did you mean radius\?"),
        ([ertel.impact, ertel.rolling], "ellipticity", "give radius_ratio"),
        ([ertel.impact, ertel.rolling], "eta0", r"did you mean oil=Oil\(eta0=...\)\? allowed: M, L"),
        # A key of a section is refused with its place; an impact has no [thermal].
        ([ertel.rolling], "inertia", r"did you mean motion={'inertia': ...}\?"),
        ([ertel.rolling], "conductivity", r"did you mean thermal={'conductivity': ...}\?"),
        ([ertel.impact], "conductivity", "allowed: "),
        ([ertel.impact], "load", "its load follows from mass and speed"),
    ],
)
def test_a_wrong_keyword_is_named_with_a_hint(functions, keyword, hint):
    for function in functions:
        with pytest.raises(TypeError, match=f"'{keyword}': {hint}"):
            function(**{keyword: 0.1})


def test_si_and_texts_with_units_are_the_same_case():
    si = ertel.impact(**IN_SI, oil=OIL)
    assert ertel.impact(**CONTACT, oil=ertel.Oil(**LUBRICANT)) == si
    assert parse_case({"contact": CONTACT, "lubricant": LUBRICANT}) == si
    assert si.scales is not None and si.scales.p_h == pytest.approx(1.42e9, rel=5e-3)
    assert ertel.impact(M=200, L=10, radius=None, roughness=None) == ertel.impact(M=200, L=10)
    case = ertel.impact(M=200, L=10, tolerance=1e-2, time_tolerance=1e-3)
    assert (case.solver.tolerance, case.schedule.tolerance) == (1e-2, 1e-3)
    numbers = {**IN_SI, "ball_density": np.int64(7850), "nodes": np.int64(129)}
    case = ertel.impact(**numbers, oil=ertel.Oil(np.float64(0.0186), np.float64(20e-9)))
    assert case.to_data() == ertel.impact(**IN_SI, oil=OIL, nodes=129).to_data()
    case = ertel.impact(**IN_SI, oil=ertel.Oil(eta0=0.0186, alpha=20e-9, viscosity=Roelands(20e-9, 0.6, 1.96e8)))
    expected = Roelands(20e-9, 0.6).viscosity(0.5 * si.scales.p_h)
    assert case.lubricant.viscosity(0.5) == pytest.approx(expected, rel=1e-14)


def test_every_section_arrives():
    rough = ertel.Spot(radius=ertel.quantity("50 um"), depth=ertel.quantity("1 um"), x=ertel.quantity("-0.2 mm"))
    table = {"shape": "spot", "radius": "50 um", "depth": "1 um", "x": "-0.2 mm"}
    solver = {"method": "transient", "nodes": 65, "tolerance": 1e-4, "fold": False}
    motion = {"load": [[0, 1], ["1 ms", 2]], "entrainment": {"mean": 1, "amplitude": 0.2, "period": "5 ms"}}
    time, output = {"until": "2 ms", "step": 0.01}, {"interval": 0.5}
    case = ertel.rolling(**ROLLING, oil=OIL, **solver, motion=motion, roughness=[rough], **time, **output, name="test")
    sections = {"lubricant": LUBRICANT, "solver": solver, "motion": motion, "time": time, "output": output}
    contact = {"kind": "rolling", **ROLLING_TEXTS}
    assert case == parse_case({"name": "test", "contact": contact, "roughness": [table], **sections})
    assert case.name == "test"
    assert case.time is not None and case.time.until == Quantity(2e-3, "s")
    assert ertel.rolling(**ROLLING, oil=OIL, method="transient", roughness=[table]).roughness == case.roughness


def test_what_ertel_does_not_do_is_said():
    for key, reason in NOT_THERE.items():
        for section, kept in (("contact", {"M": 200, "L": 10}), ("lubricant", {})):
            with pytest.raises(ConfigError, match=re.escape(reason)):
                parse_case({"contact": {"M": 200, "L": 10}, section: {**kept, key: 1}})


def of_surfaces(**given):
    return ertel.rolling(**ROLLING, oil=OIL, surfaces=given).surfaces


def of_oil(**given):
    return ertel.Oil(**{"eta0": 0.0186, "alpha": 20e-9, **given})


def of_ball(**given):
    return ertel.impact(**{**IN_SI, "oil": OIL, **given})


def of_signal(value):
    return ertel.sampled(lambda T: value if T == 0.5 else 1.0, until=1.0)


PERSSON = {"law": "persson", "longest": 5e-5, "shortest": 1e-6}


@pytest.mark.parametrize(
    ("function", "given", "said"),
    [  # what only Python can say; the rules themselves are in data/refusals.toml
        (of_ball, {"radius": -0.01}, "contact.radius = -0.01: must be"),
        (of_ball, {"radius": np.ones(2)}, 'contact.radius = "[1. 1.]": must be a quantity above zero'),
        (of_ball, {"motion": {"load": np.ones((2, 2))}}, "motion.load = "),
        (of_ball, {"roughness": 5}, "roughness = 5: must be a list of shapes, features or tables"),
        (of_ball, {"oil": 5}, "oil = 5: must be made by Oil(eta0=..., alpha=...), or be the name"),
        (of_oil, {"eta0": "18.6 mPa"}, "eta0 = '18.6 mPa': has the wrong dimension"),
        (of_oil, {"eta0": "1 m**(9**9**9)"}, "eta0 = '1 m**(9**9**9)': has an unknown unit"),
        (of_oil, {"z": np.ones(2)}, "z = array([1., 1.]): must be a number"),
        (of_oil, {"viscosity": "\x1b" * 10**6}, "viscosity = "),
        (of_oil, {"rheology": {"law": "ree-eyring", "tau0": "5 MPa"}}, "rheology = "),
        (of_surfaces, {"sigma": "Ra 0.04"}, 'surfaces.sigma = "Ra 0.04": must be a quantity above zero with a unit'),
        (of_surfaces, {"sigma": "Ra Ra 40 nm"}, 'surfaces.sigma = "Ra Ra 40 nm": must be a quantity above zero'),
        (of_surfaces, {"sigma": "Ra" * 50_000}, "surfaces.sigma = "),
        (of_surfaces, {"sigma": 1e-7, "asperities": {**PERSSON, "hurst": "5 um"}}, "surfaces.asperities.hurst"),
        *((ertel.quantity, {"text": text}, "text = ") for text in (5, "5 kg", "x" * 10**6, "\x1b")),
        *((of_signal, {"value": value}, "function(0.5) = ") for value in (float("nan"), float("inf"), "a", None)),
    ],
    ids=lambda value: getattr(value, "__name__", str(value)[:40]),
)
def test_wrong_and_absurd_input_is_refused_in_a_short_line(function, given, said):
    with pytest.raises(ValueError) as caught:
        function(**given)
    message = str(caught.value)
    assert message.startswith(said) and isinstance(caught.value, ConfigError) == (function is not of_oil)
    assert len(message) < 450 and message.isprintable()
    assert any(word in message for word in ("allowed", "must be", "write for example"))


def test_roughness_as_numbers_in_every_way():
    """Ra of Gaussian heights; plain numbers, also those of a law, are in SI."""
    found = of_surfaces(sigma_1="Ra 0.04 um", sigma_2=2e-8, asperities=PERSSON)
    assert found.sigma_1 == pytest.approx(50e-9) and found.rms == pytest.approx((50**2 + 20**2) ** 0.5 * 1e-9)
    assert found.asperities.longest == 5e-5 and found.asperities.hurst == 0.8


ON_A_LAYER = {"M": 100, "L": 10, "oil": ertel.Oil(layer=3.0)}
ROUGH = {"sigma": "2 um", "asperities": {"law": "persson", "longest": "50 um", "shortest": "1 um"}}


@pytest.mark.parametrize(
    ("given", "wide", "said"),
    [
        (ON_A_LAYER, {"half_width": 3.75, "inlet": 5.75}, r"use solver\.half_width = 3\.75, solver\.inlet = 5\.75$"),
        ({**ROLLING, "oil": OIL, "surfaces": ROUGH}, {"half_width": 4.0}, r"use solver\.half_width = 4, or a smaller"),
    ],
)
def test_a_grid_that_is_too_narrow_is_told_how_wide_it_has_to_be(given, wide, said):
    with pytest.raises(ConfigError, match=said):
        ertel.rolling(**given)
    narrow = {name: width - 0.25 for name, width in wide.items()}
    with pytest.raises(ConfigError, match="edge of the grid"):
        ertel.rolling(**given, **narrow)
    ertel.rolling(**given, **wide)
