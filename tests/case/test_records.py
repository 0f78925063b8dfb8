"""Records as plain data and back, to the last bit, and in the units of a case."""

import functools
import re
from collections.abc import Callable
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np
import pytest
from cases import CASES

from ertel.case.case import READER, Case
from ertel.case.conditions import Conditions
from ertel.case.records import checked, data_of, named, oil_data, scaled, show
from ertel.case.sections import Drive, Output, Solver, Time
from ertel.physics.lubricant import Barus, Oil, Viscosity
from ertel.physics.motion import Oscillation, Polyline, constant
from ertel.physics.scales import Scales
from ertel.physics.surfaces import Feature, Spot, Waviness
from ertel.physics.units import DURATION, LENGTH, Amount, Quantity

SCALES = Scales(R=0.01, E_prime=2e11, a=2e-4, p_h=1e9, t0=4e-5)
SECONDS = Quantity(0.002, "s")


@dataclass(frozen=True)
class Tube:
    radius: Annotated[float, LENGTH]
    until: Annotated[Amount, DURATION] = 1.0
    note: str = ""


def test_a_quantity_is_written_with_its_unit_and_an_amount_as_it_was_given() -> None:
    assert data_of(Tube(0.01, 2.0)) == {"radius": "0.01 m", "until": 2.0}
    written = data_of(Tube(0.01, Quantity(0.005, "s"), "thin"))
    assert written == {"radius": "0.01 m", "until": "0.005 s", "note": "thin"}
    assert data_of(Waviness(0.1, 0.5)) == {"amplitude": 0.1, "wavelength_x": 0.5, "phase_x": 0.0, "phase_y": 0.0}
    assert data_of(Time()) == {"tolerance": 5e-5}
    assert data_of(Drive()) == {}
    with pytest.raises(ValueError, match="cannot be written down"):
        data_of(Drive(load=lambda T: 1.0))  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("signal", "data"),
    [
        (constant(2.0), 2.0),
        (Polyline(((0.0, 1.0), (1.5, 2.0))), [[0.0, 1.0], [1.5, 2.0]]),
        (Polyline(((1.5, 2.0),)), [[1.5, 2.0]]),
        (Polyline(((Quantity(0.0, "s"), 2.0),)), [["0.0 s", 2.0]]),
        (Polyline(((Quantity(-0.001, "s"), 1.0), (5.0, 1.0))), [["-0.001 s", 1.0], [5.0, 1.0]]),
        (Oscillation(1.0, 0.2, 3.0), {"mean": 1.0, "amplitude": 0.2, "period": 3.0, "phase": 0.0}),
        (Oscillation(1.0, 0.2, SECONDS, 1.0), {"mean": 1.0, "amplitude": 0.2, "period": "0.002 s", "phase": 1.0}),
    ],
    ids=str,
)
def test_a_signal_has_three_forms(signal, data) -> None:
    assert data_of(Drive(load=signal)) == {"load": data}
    assert READER.signal(data, "motion.load") == signal


def test_a_law_with_data_of_its_own_is_a_table() -> None:
    assert oil_data(Oil(viscosity=Barus(2e-8)))["viscosity"] == {"law": "barus", "alpha": "2e-08 1/Pa"}
    with pytest.raises(ValueError, match=r'^oil\.viscosity\.law = "tar"; allowed: .*isoviscous, barus, roelands'):
        READER.law({"law": "tar"}, Viscosity, "oil.viscosity")
    law = READER.law({"law": "barus", "alpha": "-2e-8 1/Pa"}, Viscosity, "oil.viscosity")  # which the case checks
    with pytest.raises(ValueError, match=r'^lubricant\.viscosity\.alpha = "-2e-08 1/Pa": must be finite and above'):
        Case(Conditions(M=200, L=10), Oil(viscosity=law))


DOORS: dict[str, Callable[[Any], Any]] = {
    "read": lambda data: READER.record(Tube, data, "tube"),
    "check": lambda record: checked(record, "tube"),
    "scale": lambda record: scaled(record, None, "tube"),  # in a dimensionless case
}


@pytest.mark.parametrize(
    ("door", "given", "place", "word"),
    [
        ("read", {"radius": "0.01 m", "width": 1}, "tube.width = 1", "unknown key; allowed: radius, until, note"),
        ("read", {"until": 1.0}, "tube.radius", "missing"),
        ("read", {"radius": "10 mm"}, 'tube.radius = "10 mm"', "must be a number and the unit m"),
        ("read", [0.01], "tube = [0.01]", "must be a section, [tube]"),
        ("check", Tube(-0.01), 'tube.radius = "-0.01 m"', "finite and above zero"),
        ("check", Tube(0.01, Quantity(0.0, "s")), 'tube.until = "0.0 s"', "finite and above zero"),
        ("check", Tube("0.01"), 'tube.radius = "0.01"', "must be a number"),  # type: ignore[arg-type]
        ("check", Tube(np.ones(2)), 'tube.radius = "[1. 1.]"', "must be a number"),  # type: ignore[arg-type]
        ("check", Tube(1e-300), 'tube.radius = "1e-300 m"', "between 1e-30 and 1e+30 m"),
        ("check", Tube(10**400), 'tube.radius = "(an integer of about 400 digits) m"', "between 1e-30 and 1e+30 m"),
        ("check", Tube(0.01, 1e31), "tube.until = 1e+31", "between 1e-30 and 1e+30, in units t0"),
        ("check", Solver(nodes=65.0), "tube.nodes = 65.0", "must be an integer"),  # type: ignore[arg-type]
        ("check", Solver(tolerance=1.0), "tube.tolerance = 1.0", "must be less than 1"),
        ("scale", Output(SECONDS), 'tube.interval = "0.002 s"', "a plain number"),
        ("scale", Feature(Spot(Quantity(1.0, "m"), 0.1)), 'tube.radius = "1.0 m"', "a dimensionless case has no m"),
        ("scale", Drive(load=Oscillation(1.0, 0.1, SECONDS)), 'tube.load.period = "0.002 s"', "a plain number"),
        ("scale", Drive(load=Polyline(((SECONDS, 1.0),))), 'tube.load[1] = "0.002 s"', "a plain number"),
    ],
    ids=str,
)
def test_what_a_record_cannot_have_is_refused_with_its_place(door, given, place, word) -> None:
    with pytest.raises(ValueError, match=f"^{re.escape(place)}: .*{re.escape(word)}"):
        DOORS[door](given)


def test_a_complaint_is_about_the_field_of_the_place() -> None:
    with pytest.raises(ValueError, match=r"^signal\.period = 0.0: must be above zero"):
        named("signal", Oscillation, 1.0, 0.1, 0.0)
    with pytest.raises(ValueError, match=r"^contact: has numbers too large or too small to compute with"):
        named("contact", lambda: 1 / 0)


CYCLE: dict[str, Any] = {}
CYCLE["again"] = CYCLE
NESTED = functools.reduce(lambda inner, _: [inner], range(900), [])


def test_values_are_shown_as_in_a_case_file_and_long_ones_are_cut() -> None:
    assert show(Quantity(0.01, "m")) == '"0.01 m"'
    assert show({"mean": 1, "amplitude": True}) == "{ mean = 1, amplitude = true }"
    assert show([[0, 1.5], ["1 s", 2]]) == '[[0, 1.5], ["1 s", 2]]'
    assert show(Polyline(((0.0, 1.0), (1.0, 2.0)))) == "[[0.0, 1.0], [1.0, 2.0]]"
    assert show("é\n") == '"é\\n"'
    assert show({"a b": 1, "c-d": 2}) == '{ "a b" = 1, c-d = 2 }'
    # Escape sequences and reversed text (bidirectional controls) do not reach a terminal.
    assert show("\x1b[31mred\x07") == '"\\u001b[31mred\\u0007"'
    assert show("\u202eabc\x9b\u200b\x7f") == '"\\u202eabc\\x9b\\u200b\\x7f"'
    assert show({"\x1b]0;title": 1}) == '{ "\\u001b]0;title" = 1 }'
    for value in ("x" * 10**7, ["x" * 10**6] * 100, NESTED, CYCLE, 10**5000, np.zeros(10**6)):
        assert len(show(value)) <= 100


def test_quantities_come_to_the_units_of_the_case() -> None:
    spot = scaled(Feature(Spot(Quantity(1e-4, "m"), Quantity(2e-8, "m"), x=-3.0)), SCALES, "roughness[1]")
    assert spot == Feature(Spot(1e-4 / SCALES.a, 2e-8 / SCALES.film, x=-3.0))
    assert scaled(Time(until=Quantity(4e-4, "s"), step=0.1), SCALES, "time") == Time(until=4e-4 / SCALES.t0, step=0.1)
    polyline = Polyline(((Quantity(0.0, "s"), 1.0), (Quantity(4e-5, "s"), 2.0), (5.0, 1.0)))
    assert scaled(polyline, SCALES, "load") == Polyline(((0.0, 1.0), (4e-5 / SCALES.t0, 2.0), (5.0, 1.0)))
    drive = Drive(load=Oscillation(1.0, 0.1, Quantity(8e-5, "s")))
    assert scaled(drive, SCALES, "motion") == Drive(load=Oscillation(1.0, 0.1, 8e-5 / SCALES.t0))
    polyline = Polyline(((1.0, 1.0), (Quantity(4e-5, "s"), 2.0)))
    with pytest.raises(ValueError, match=r"^motion\.load = .*rising T"):
        scaled(Drive(load=polyline), SCALES, "motion")


def test_a_case_is_a_few_lines_of_text():
    (data,) = (data for digest, data in CASES if digest == "96cccb8c39080259")  # a ball, in SI
    rough = [{"shape": "spot", "radius": 0.1, "depth": 0.01}, {"shape": "rings", "amplitude": 0.1, "wavelength": 1}]
    oil = {**data["lubricant"], "reference": "a long text"}
    lines = repr(Case.from_data({**data, "name": "ball <1>", "lubricant": oil, "roughness": rough})).splitlines()
    assert lines[0].startswith("Case: ball <1>, impact (2d), M = ")
    assert lines[1].startswith("  contact    kind = impact, radius = 0.01 m, ")
    assert "E_prime = 2e+11 Pa" in lines[1]
    assert sum(line.startswith("  roughness") for line in lines) == 2
    assert "a long text" not in "".join(lines)
    assert len(lines) < 10
