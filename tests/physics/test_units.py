"""Marks of fields, and numbers that carry a unit."""

from dataclasses import dataclass
from math import inf, nan
from typing import Annotated, Any

import pytest

from ertel.physics import units
from ertel.physics.scales import Scales
from ertel.physics.units import Amount, Bounds, Mark, Quantity, Unit, marks, plain

ALL_UNITS = {name: value for name, value in vars(units).items() if isinstance(value, Unit)}


@dataclass(frozen=True)
class Groove:
    """A record for these tests."""

    depth: Annotated[Amount, units.HEIGHT]
    length: Annotated[float | None, units.LENGTH]
    turns: Annotated[int, Bounds(gt=0, le=10, whole=True)]
    note: str = ""


def test_marks_stand_in_the_annotations() -> None:
    assert marks(Groove) == {"depth": units.HEIGHT, "length": units.LENGTH, "turns": Bounds(gt=0, le=10, whole=True)}


def test_places_velocities_and_heights_may_be_negative_and_sizes_not() -> None:
    signed = {name for name, mark in ALL_UNITS.items() if mark.signed}
    assert signed == {"VELOCITY", "RADIUS", "ANGLE", "TIME", "POSITION", "HEIGHT"}
    for mark in ALL_UNITS.values():
        assert [mark.allows(value) for value in (1.0, -1.0, 0.0)] == [True, mark.signed, mark.signed]
        assert not any(mark.allows(value) for value in (inf, -inf, nan))


@pytest.mark.parametrize("mark", [mark for mark in ALL_UNITS.values() if mark.scale], ids=lambda mark: mark.unit)
def test_the_scale_of_an_amount_is_one_of_the_case(mark: Unit) -> None:
    scales = Scales(R=0.01, E_prime=2e11, a=2e-4, p_h=1e9, t0=4e-5)
    expected = {"t0": 4e-5, "a": 2e-4, "a^2/R": 4e-6}[mark.own]
    assert getattr(scales, mark.scale) == pytest.approx(expected, rel=1e-14)


@pytest.fixture(scope="module")
def registry() -> Any:
    return pytest.importorskip("pint").UnitRegistry()


@pytest.mark.parametrize("name", ALL_UNITS)
def test_the_example_of_a_unit_reads_as_such_a_quantity(name: str, registry: Any) -> None:
    mark = ALL_UNITS[name]
    number, _, unit = mark.example.partition(" ")
    quantity = registry.Quantity(float(number), registry.parse_units(f"1{unit}" if unit.startswith("/") else unit))
    assert mark.allows(quantity.to(mark.unit).magnitude)


@pytest.mark.parametrize(
    ("mark", "value", "complaint"),
    [
        (units.FINITE, -1e30, ""),
        (units.FINITE, -1e31, "must be between -1e+30 and 1e+30"),
        (units.FINITE, 10**400, "must be between -1e+30 and 1e+30"),  # more digits than a float can hold
        (units.FINITE, nan, "must be a finite number"),
        (units.ABOVE_ZERO, inf, "must be a finite number"),
        (units.ABOVE_ZERO, 0.0, "must be greater than 0"),
        (units.ABOVE_ZERO, 1e-30, ""),
        (units.ABOVE_ZERO, 1e-300, "must be between 1e-30 and 1e+30"),
        (units.NOT_NEGATIVE, 0.0, ""),
        (units.NOT_NEGATIVE, -1.0, "must be greater than or equal to 0"),
        (units.SHARE, 1.0, "must be less than 1"),
        (units.SHARE, 0.999, ""),
        (Bounds(gt=-1, le=0.5), 0.5, ""),
        (Bounds(gt=-1, le=0.5), 0.51, "must be less than or equal to 0.5"),
        (Bounds(whole=True), 1.0, "must be an integer"),
        (Bounds(whole=True), 1, ""),
        (units.LENGTH, 0.01, ""),
        (units.LENGTH, 0.0, "must be finite and above zero"),
        (units.LENGTH, nan, "must be finite and above zero"),
        (units.LENGTH, 1e-300, "must be between 1e-30 and 1e+30 m"),
        (units.LENGTH, 10**400, "must be between 1e-30 and 1e+30 m"),
        (units.POSITION, -1e31, "must be between -1e+06 and 1e+06, in units a"),
        (units.POSITION, -inf, "must be finite"),
        (units.POSITION, 0.0, ""),
    ],
)
def test_marks_say_what_is_wrong(mark: Mark, value: float, complaint: str) -> None:
    assert mark.complaint(value) == complaint


def test_a_quantity_shows_its_number_to_the_last_bit_and_is_no_plain_number() -> None:
    assert str(Quantity(0.1 + 0.2, "m")) == "0.30000000000000004 m"
    assert float(str(Quantity(1 / 3, "s")).split()[0]) == 1 / 3
    assert plain(0.5) == 0.5
    with pytest.raises(TypeError, match=r"^0.5 m: is in SI"):
        plain(Quantity(0.5, "m"))
