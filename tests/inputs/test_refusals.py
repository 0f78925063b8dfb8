"""What is refused in a case file: one line that names field, value and what is allowed."""

from datetime import date
from typing import Any

import numpy as np
import pytest
from cases import BALL, BODIES, HOT, NAMED, NUMBERS, SHEET, STEEL

from ertel.inputs.case_files import ConfigError, parse_case

Data = dict[str, Any]
Rows = list[tuple[Any, list[str]]]  # what is wrong; how its message begins, and what is in it

MOES = {"M": 1000, "L": 10}
OIL = {"eta0": "0.1 Pa*s", "alpha": "22 / GPa"}
ROLLING = {"kind": "rolling", **MOES}
THICK = ROLLING | {"M": 1}
SLENDER = MOES | {"radius_ratio": 0.5}
HEAVY = NAMED | {"oil": SHEET | {"density": 1000}}
TRACK = {"kind": "rolling", "radius": "10 mm", "load": "20 N", "E_prime": "226.37 GPa"}
ROLLED = {**TRACK, "mean_speed": "0.5 m/s"}
ROLLER = {**ROLLED, "length": "10 mm"}
CYLINDER = {"radius": "10 mm", "length": "10 mm", "speed": "1 m/s", "E_prime": "226 GPa"}
TWO_SPEEDS = {"speed_1": "1 m/s", "speed_2": "1 m/s"}
IN_TIME = {"method": "transient"}


def without(key: str, *tables: Data) -> Data:
    return {k: v for table in tables for k, v in table.items() if k != key}


def refused(sections: Data, said: list[str], folder: Any = ".") -> None:
    with pytest.raises(ConfigError) as caught:
        parse_case(sections, folder)
    message, (start, *parts) = str(caught.value), said
    assert message.startswith(start)
    assert all(part in message for part in parts), message
    assert message.isprintable() and len(message) < 600


HOSTILE = ["x" * 10**7, ["x" * 10**6] * 10, {"k" * 10**6: 1}, 10**400, -(10**400), [[[]]], "\x1b[31m\u202e"]
PLACES = "contact.M lubricant.eta0 lubricant.viscosity lubricant.reference solver.nodes solver.method solver.fold "
PLACES += "motion.load motion.entrainment time.until time.step output.interval name contact lubricant solver motion "


@pytest.mark.parametrize("place", f"{PLACES} roughness time output schema".split())
def test_messages_stay_short_and_printable(place: str) -> None:
    section, _, key = place.partition(".")
    for value in (*HOSTILE, date(2020, 1, 1)):
        table = {**(MOES if section == "contact" else {}), key: value} if key else value
        refused({"contact": MOES, section: table}, [section])


# -- the contact ------------------------------------------------------------------------------------------------------

ELASTIC = without("E_prime", BALL) | STEEL
CONTACTS: Rows = [
    (MOES | {"raduis": "1 mm"}, ['contact.raduis = "1 mm": unknown key', "did you mean radius?"]),
    (MOES | {"kind": "bounce"}, ["contact.kind = \"bounce\": allowed: 'impact' or 'rolling'"]),
    (MOES | {"radius_ratio": 0.001}, ["contact.radius_ratio = 0.001: ", "or 0 for a line contact"]),
    (MOES | {"length_ratio": 50}, ["contact.length_ratio = 50", "radius_ratio = 0"]),
    (ROLLER | {"radius_ratio": 0}, ["contact.radius_ratio = 0", "give length"]),
    (ROLLER | {"radius_y_1": "20 mm"}, ['contact.radius_y_1 = "20 mm": ', "no radius along y"]),
    (ROLLER | {"entrainment_angle": "20 deg"}, ["contact.entrainment_angle", "across the flow"]),
    (ROLLER | {"ball_density": "7850 kg/m^3"}, ["contact.ball_density", "give contact.mass"]),
    (CYLINDER | {"length": "0.1 mm", "mass": "300 g"}, ["contact: its values together give length_ratio", "to 5"]),
    (CYLINDER, ["contact.mass: missing; allowed: mass"]),
    (MOES | {"kind": "line"}, ['contact.kind = "line": ', "give contact.length", "allowed: 'impact' or 'rolling'"]),
    (ROLLED | {"load": "200 N/mm"}, ['contact.load = "200 N/mm": is a load per length', "contact.length"]),
    (ROLLED | {"line_load": "200 N/mm"}, ['contact.line_load = "200 N/mm": unknown key; give load', "length"]),
    ({"M": -5, "L": 10}, ["contact.M = -5: ", "greater than 0"]),
    ({"M": "1000", "L": 10}, ['contact.M = "1000": must be a number']),
    ({"M": True, "L": 10}, ["contact.M = true: must be a number"]),
    ({}, ["contact.M: missing", "lambda_bar and alpha_bar", "radius"]),
    ({"M": 1000}, ["contact.L: missing", "contact.M = 1000", "M and L"]),
    (MOES | {"lambda_bar": 1}, ["contact.M = 1000.0 and contact.lambda_bar = 1.0 are given together; allowed: "]),
    (MOES | BALL, ['contact.M = 1000.0 and contact.radius = "10 mm" are given together; allowed: ']),
    (MOES | {"slide_to_roll": 1}, ["contact.slide_to_roll = 1", "motion.slide_to_roll"]),
    (MOES | {"material_1": "steel"}, ['contact.material_1 = "steel": a dimensionless contact has no materials']),
    *[(without(key, BALL), [f"contact.{key}: missing; allowed: {key}; or "]) for key in BALL],
    *[(without(key, ELASTIC), [f"contact.{key}: missing; contact."]) for key in STEEL],
    *[(ELASTIC | {"nu1": nu}, ["contact.nu1 = "]) for nu in (-1, 0.51, float("nan"))],
    (BALL | {"ball_density": "8 g/cm^3"}, ["contact.mass = ", "contact.ball_density = ", "given together"]),
    (BALL | {"drop_height": "1 m"}, ["contact.speed = ", "contact.drop_height = ", "given together"]),
    (BALL | STEEL, ["contact.E_prime = ", "contact.E1 = ", "given together"]),
    (BALL | {"load": "1 N"}, ['contact.load = "1 N"', "impact", "motion.load"]),
    (BALL | {"speed_1": "1 m/s"}, ["contact.speed_1", "impact", "contact.mean_speed"]),
    (BALL | {"slide_to_roll": 1}, ["contact.slide_to_roll = 1", "mean_speed"]),
    ({"kind": "rolling"}, ["contact.M: missing", "load", "mean_speed or speed_1 and speed_2"]),
    (ROLLED | {"speed": "1 m/s"}, ['contact.speed = "1 m/s"', "rolling", "contact.mean_speed"]),
    (TRACK, ["contact.mean_speed: missing", "speed_1 and speed_2"]),
    (TRACK | {"speed_1": "1 m/s"}, ["contact.speed_2: missing", 'contact.speed_1 = "1 m/s"']),
    (ROLLED | TWO_SPEEDS, ["contact.mean_speed", "contact.speed_1", "together"]),
    (TRACK | TWO_SPEEDS | {"speed_2": "-1 m/s"}, ["contact.speed_1", 'contact.speed_2 = "-1 m/s"', "not be zero"]),
    (TRACK | TWO_SPEEDS | {"slide_to_roll": 1}, ["contact.slide_to_roll = 1", "mean_speed only"]),
    (ROLLED | {"mean_speed": "0 m/s"}, ['contact.mean_speed = "0 m/s"', "must not be zero"]),
    ({"kind": "rolling", "M": 0.01, "L": 10}, ["contact: M = 0.01 is too low: ", "half_width = 1000", "formulas"]),
]
BODIED = without("E_prime", ROLLED) | BODIES
CONTACTS += [
    (BODIED | {"material_2": "wood"}, ['contact.material_2 = "wood": allowed: glass, sapphire, ']),
    (BODIED | {"material_2": 2}, ["contact.material_2 = 2: allowed: glass, sapphire, "]),
    (without("material_2", BODIED), ["contact.E2: missing"]),
    (BODIED | {"temperature": "40 degC"}, ["contact.temperature = ", "did you mean lubricant.temperature or"]),
]

# radii of curvature
BALL_ROLLS = without("radius", ROLLED)
REDUCED = BALL_ROLLS | {"radius_x": "10 mm", "radius_y": "50 mm"}
BODY = BALL_ROLLS | {"radius_x_1": "10 mm", "radius_y_1": "10 mm"}
ELLIPSE = ROLLING | {"radius_ratio": 0.5}
CONTACTS += [
    (without("radius_y_1", BODY), ["contact.radius_y_1: missing"]),
    (BODY | {"radius_y_2": "-9 mm"}, ['contact.radius_y_1 = "10 mm" and contact.radius_y_2 = "-9 mm"']),
    (BODY | {"radius_y_2": "-10 mm"}, ["contact.radius_y_1 = ", "point contact"]),
    (BODY | {"radius_x_1": "0 mm"}, ['contact.radius_x_1 = "0 mm": must not be zero']),
    (without("radius_y", REDUCED), ["contact.radius_y: missing"]),
    (REDUCED | {"radius_y": "1.1 m"}, ["contact: the reduced radii", "allowed: from 1/100 to 100"]),
    *[  # it suggested radius_2, which makes two spheres: half the film
        (ROLLED | {key: "20 mm"}, ['contact.radius = "10 mm" and contact.' + key + ' = "20 mm" are given together'])
        for key in ("radius_x", "radius_y")
    ],
    (REDUCED | {"radius_ratio": 0.2}, ["contact.radius_ratio = 0.2"]),
    (REDUCED | {"entrainment_angle": "200 deg"}, ['contact.entrainment_angle = "200 deg"']),
    (REDUCED | {"entrainment_angle": 30}, ["contact.entrainment_angle = 30"]),
    (REDUCED | {"ball_density": "7850 kg/m^3"}, ['contact.ball_density = "7850 kg/m^3"']),
    (ELLIPSE | {"radius_ratio": 0.005}, ["contact.radius_ratio = 0.005"]),
    (MOES | {"ellipticity": 2.0}, ["contact.ellipticity = 2.0: ", "give radius_ratio"]),
    (ELLIPSE | {"kind": "impact", "entrainment_angle": "30 deg"}, ['contact.entrainment_angle = "30 deg"']),
]

# -- the oil and the temperatures -------------------------------------------------------------------------------------

OILS: Rows = [
    (OIL | {"tau0": "5 MPa"}, ["lubricant.tau0", 'rheology = { law = "ree-eyring", tau0 = "5 MPa" }']),
    (OIL | {"viscosity": "baras"}, ['lubricant.viscosity = "baras": ', "'barus'"]),
    (OIL | {"alpha": "3 m"}, ['lubricant.alpha = "3 m": ', "[length]", "22 / GPa"]),
    (OIL | {"alpha": "3 quux"}, ['lubricant.alpha = "3 quux": has an unknown unit', "22 / GPa"]),
    (OIL | {"alpha": 2.2e-8}, ["lubricant.alpha = 2.2e-08: ", "unit", "22 / GPa"]),
    *[(NAMED | {"oil": oil}, ["lubricant.oil = ", ": allowed: ", "squalane"]) for oil in ("squalan", 7, ["squalane"])],
    (NAMED | {"temperature": "120 degC"}, ['lubricant.temperature = "120 degC": must be between 25 degC and 100 degC']),
    (NAMED | {"temperature": 40}, ["lubricant.temperature = 40: must be a temperature with its unit"]),
    (without("temperature", NAMED), ['lubricant.temperature: missing; oil = "squalane" needs it']),
    (without("oil", NAMED), ['lubricant.temperature = "40 degC": needs lubricant.oil, one of iso-vg-100']),
    (NAMED | {"oill": 1}, ["lubricant.oill = 1: unknown key; did you mean oil? allowed: oil, temperature"]),
]
SHEETS: Rows = [
    (SHEET | {"nu20": "200 mm^2/s"}, ['lubricant.oil.nu20 = "200 mm^2/s": unknown key; did you mean ']),
    (without("nu100", SHEET), ["lubricant.oil.nu100: missing"]),
    (SHEET | {"nu100": "70 mm^2/s"}, ["lubricant.oil.nu40 = 68 mm^2/s and nu100 = 70 mm^2/s: must be nu40 > nu100"]),
    (SHEET | {"k" * 3000: 1.0}, ['lubricant.oil."kkk']),
    (SHEET | {"nu40": 10**400}, ["lubricant.oil.nu40 = (an integer of about 400 digits"]),
]
OILS += [({"oil": sheet, "temperature": "60 degC"}, said) for sheet, said in SHEETS]
THERMAL: list[tuple[Data, Data, Data, list[str]]] = [
    (
        {},
        ROLLED,
        NAMED,
        ["density_1: missing; give it, ", '"7850 kg/m^3", or name ', "contact.material_1", "missing are also heat_"],
    ),
    ({}, BODIED, NUMBERS, ["temperature: missing; give that of the oil in the inlet, ", '"40 degC"']),
    (
        {"temperature": "40 degC"},
        BODIED,
        NUMBERS,
        ["conductivity: missing; give it, ", "lubricant.oil; missing are also beta"],
    ),
    ({}, BODIED, NAMED | {"oil": "pao-100"}, ["conductivity: missing; the library has none ", '"pao-100"']),
    ({"temperature": "80 degC"}, BODIED, NAMED, ['temperature = "80 degC": differs from lubricant.temperature = "4']),
    ({"temperature_1": 60}, BODIED, NAMED, ["temperature_1 = 60: must be a temperature with its unit"]),
    ({"inlet": "moes"}, BODIED, NAMED, ["inlet = \"moes\": allowed: 'solved', 'gupta', 'wilson-sheu'"]),
    ({"viscosity": "vogel"}, BODIED, NAMED, ["viscosity = \"vogel\": allowed: 'houpert' or 'exponential'"]),
    ({"inlet_factor": "none"}, BODIED, NAMED, ['inlet_factor = "none": unknown key; ']),
    (HOT | {"temperature": "-140 degC"}, BODIED, NUMBERS, ['viscosity = "houpert": temperature = 133.15 K: ', "138 K"]),
]

# -- the other sections -----------------------------------------------------------------------------------------------

OSCILLATION = {"mean": 1, "amplitude": 1, "period": 1}
LOADS: Rows = [
    ([], ["motion.load = []", "[T, value]", "amplitude"]),
    ([1, 2], ["motion.load[1] = 1", "[T, value]"]),
    ([[0, 1], [1]], ["motion.load[2]", "[T, value]"]),
    ([[0, "a"]], ['motion.load[1][2] = "a"', "number"]),
    (True, ["motion.load = true", "[T, value]"]),
    ({"smooth": []}, ["motion.load.smooth = []", "[T, value]"]),
    ({"smooth": "x"}, ['motion.load.smooth = "x"', "[T, value]"]),
    ({"smooth": [[each, 1] for each in range(10_001)]}, ["motion.load.smooth = ", "10001 points; at most 10000"]),
    ({"mean": 1}, ["motion.load.amplitude: missing"]),
    ({"mean": 1, "amplitude": 1, "periode": 1}, ["motion.load.periode = 1", "did you mean period?"]),
    (OSCILLATION | {"fase": 1}, ["motion.load.fase = 1", "did you mean phase?"]),
    (OSCILLATION | {"period": 0}, ["motion.load.period = 0", "above zero"]),
]
SPOT = {"shape": "spot", "height": 0.1, "radius": 0.3}
WAVE = {"shape": "waviness", "amplitude": 1}
SHAPES: Rows = [
    (5, ["roughness[1] = 5: must be a table", "waviness, rings, spot"]),
    (SPOT | {"radios": 1}, ["roughness[1].radios = 1", "did you mean radius?"]),
    (SPOT | {"radius": -1}, ["roughness[1].radius = -1", "above zero", "units a,", "50 um"]),
    (SPOT | {"radius": "1 s"}, ['roughness[1].radius = "1 s"', "wrong dimension"]),
    (SPOT | {"depth": 1}, ["roughness[1].height", "together with depth"]),
    (SPOT | {"surface": True}, ["roughness[1].surface = true: allowed: 1 or 2"]),
    (WAVE, ["roughness[1].wavelength_x: missing", "wavelength_y"]),
    (WAVE | {"wavelength_x": 1, "ramp": 1}, ["roughness[1].ramp = 1", "front"]),
    ({"shape": "measured", "file": 0}, ["roughness[1].file = 0: must be a string"]),
    ({"shape": "measured", "file": "map.npy", "length_xx": 1}, ["roughness[1].length_xx = 1", "did you mean length_x"]),
]
BACK = {"slide_to_roll": -2}
SECTIONS: Rows = [
    ({"contat": {}}, ["contat = {  }: unknown key; did you mean contact? allowed: ", "solver"]),
    ({"schema": True}, ["schema = true: allowed: 1"]),
    ({"solver": {"node": 3}}, ["solver.node = 3: unknown key; did you mean nodes?", "half_width"]),
    ({"nodes": 65}, ["nodes = 65: unknown key; did you mean solver.nodes? allowed: schema, name, contact"]),
    ({"tolerance": 1}, ["tolerance = 1: unknown key; did you mean solver.tolerance or time.tolerance?"]),
    ({"oil": "squalane"}, ['oil = "squalane": unknown key; did you mean lubricant.oil?']),
    ({"solver": {"until": 1}}, ["solver.until = 1: unknown key; did you mean time.until? allowed: method"]),
    ({"solver": 5}, ["solver = 5: must be a section, [solver]"]),
    ({"solver": {"nodes": 100}}, ["solver.nodes = 100: ", "97", "105"]),
    ({"contact": THICK, "solver": {"half_width": 3.0}}, ["solver.half_width = 3.0: must be at least 8.39", "leave"]),
    ({"contact": SLENDER, "solver": {"method": "radial"}}, ['solver.method = "radial": is for circular', "R_y = 0.5"]),
    ({"contact": SLENDER, "solver": {"half_width_y": 1.5}}, ["solver.half_width_y = 1.5"]),
    ({"solver": {"method": "radial", "half_width_y": 3.0}}, ["solver.half_width_y = 3"]),
    ({"time": {"until": "never"}}, ['time.until = "never": ', '"max-approach"', '"rebound"', "above zero"]),
    ({"contact": ROLLED, "lubricant": OIL, "solver": IN_TIME, "time": {"until": "5 mm"}}, ["time.until", "5 ms"]),
    (
        {"contact": ROLLING, "solver": IN_TIME, "motion": {"load": [[0, 1], [1, 100]]}, "time": {"until": 2}},
        ["solver.half_width = ", "must be greater than 4.64", "inside the grid at all times"],
    ),
    (
        {"contact": ROLLING | {"radius_ratio": 0}, "solver": IN_TIME, "motion": {"curvature": 0.03}},
        ["solver.half_width = ", "must be greater than 5.77"],
    ),
    ({"motion": {"speed": 1}}, ["motion.speed = 1: unknown key", "entrainment"]),
    *[({"roughness": value}, ["roughness = ", "must be an array of tables, [[roughness]]"]) for value in (False, SPOT)],
    ({"roughness": [SPOT, SPOT | {"shape": "dent"}]}, ['roughness[2].shape = "dent"', "waviness, rings, spot"]),
    ({"contact": ROLLING, "roughness": [SPOT | {"surface": 2}], "motion": BACK}, ["roughness[1].surface = 2: moves"]),
    (
        {"contact": ROLLED, "solver": IN_TIME, "thermal": HOT},
        [
            'thermal: solver.method = "transient" is for contacts',
            'without [thermal]; use solver.method = "steady", or leave [thermal] out',
        ],
    ),
    ({"thermal": HOT}, ["thermal: ", "no method of impact supports it; leave [thermal] out"]),
    (
        {
            "contact": ROLLED,
            "thermal": HOT,
            "motion": {"load": {"mean": 1, "amplitude": 0.5, "period": 2}},
        },
        ["motion.load = ", "varies in time", 'use solver.method = "transient" without [thermal]'],
    ),
    ({"contact": ROLLING, "lubricant": {}, "thermal": HOT}, ["thermal: needs a contact in SI"]),
    # which field is named where several could be wrong
    ({"contact": ROLLED, "lubricant": HEAVY, "thermal": {}}, ["lubricant.oil.density = 1000"]),
    ({"contact": ROLLED, "lubricant": {"temperature": 65}, "thermal": HOT}, ["lubricant.temperature = 65: m"]),
]
REFUSED: list[tuple[Data, list[str]]] = [
    *(({"contact": contact, "lubricant": OIL if "M" not in contact else {}}, said) for contact, said in CONTACTS),
    *(({"contact": BODIED, "lubricant": oil}, said) for oil, said in OILS),
    *(
        ({"contact": contact, "lubricant": oil, "thermal": thermal}, [f"thermal.{start}", *parts])
        for thermal, contact, oil, (start, *parts) in THERMAL
    ),
    *(({"contact": ROLLING, "motion": {"load": load}}, said) for load, said in LOADS),
    *(({"contact": ROLLING, "roughness": [shape]}, said) for shape, said in SHAPES),
    *(
        ({"contact": MOES} | ({"lubricant": OIL} if "thermal" in table else {}) | table, said)
        for table, said in SECTIONS
    ),
    ({}, ["contact: the section [contact] is missing"]),
]


@pytest.mark.parametrize(("sections", "said"), REFUSED, ids=lambda value: str(value)[:80])
def test_what_is_wrong_is_said_in_a_line(sections: Data, said: list[str], tmp_path) -> None:
    np.save(tmp_path / "map.npy", np.eye(20))
    refused(sections, said, tmp_path)
