"""A case writes itself, knows its digest, and refuses what makes no sense, whichever way it was made."""

import re
from dataclasses import dataclass, fields, replace
from math import nan
from typing import Annotated, Any

import pytest
from cases import CASES, changed_cases

from ertel.case.case import Case
from ertel.case.conditions import Conditions
from ertel.case.methods import METHODS
from ertel.case.sections import SECTIONS, Drive, Output, Solver, Time
from ertel.physics.lubricant import Barus, Oil
from ertel.physics.motion import FREE_BALL, STEADY_ROLLING
from ertel.physics.scales import Parameters
from ertel.physics.surfaces import Feature, RingWaviness, Spot, Waviness
from ertel.physics.units import WIDTH, Amount, Quantity

MOES: dict[str, Any] = {"M": 200.0, "L": 10.0}
BALL: dict[str, Any] = {"radius": 0.01, "mass": 0.03, "speed": 0.1, "E_prime": 2e11}
TRACK: dict[str, Any] = {"kind": "rolling", "radius": 0.01, "load": 40.0, "mean_speed": 0.5, "E_prime": 2e11}
OIL = Oil(eta0=0.04, alpha=2.2e-8)


def impact(**sections: Any) -> Case:
    return Case(Conditions(**MOES), **sections)


def rolling(method: str = "steady", **sections: Any) -> Case:
    return Case(Conditions("rolling", **MOES), solver=METHODS[method].defaults, **sections)


def test_the_name_and_where_the_oils_data_come_from_change_no_result() -> None:
    case = impact(oil=replace(OIL, reference="a data sheet"), name="one")
    other = impact(oil=replace(OIL, reference="another"), name="two")
    assert case == other
    assert case.digest == other.digest
    case = Case(Conditions(**BALL), oil=replace(OIL, viscosity="barus"))  # not equal, but with the same law
    other = replace(case, oil=replace(case.oil, viscosity=Barus(2.2e-8)))
    assert case.lubricant == other.lubricant


@pytest.mark.parametrize("data", [data for _, data in CASES], ids=str)
def test_whatever_changes_a_result_changes_the_digest(data) -> None:
    case = Case.from_data(data)
    for place, changed in changed_cases(data):
        assert case != changed, place
        assert case.digest != changed.digest, place


def test_stored_runs_are_found_again() -> None:
    stored = [(digest, data) for digest, data in CASES if digest]
    assert [Case.from_data(data).digest for _, data in stored] == [digest for digest, _ in stored]


def test_no_field_was_forgotten() -> None:
    """Every field of every record of a case is among the changes above, and so is the kind of contact."""
    wanted = {f"{name}.{f.name}" for name, section in SECTIONS.items() for f in fields(section.record)}
    wanted |= {f"roughness.{f.name}" for shape in (Waviness, RingWaviness, Spot) for f in fields(shape)}
    found = {place for _, data in CASES for place, _ in changed_cases(data)}
    assert (wanted | {"roughness.surface"}) - found == {"contact.kind", "lubricant.reference"}
    assert impact().digest != rolling().digest


@dataclass(frozen=True)
class Nameless:
    width: Annotated[Amount, WIDTH] = 1.0

    def viscosity(self, p: Any) -> Any:
        return p

    def density(self, p: Any) -> Any:
        return p

    def heights(self, X: Any, Y: Any) -> Any:
        return X


def test_what_has_no_name_cannot_be_written() -> None:
    case = impact(roughness=(Feature(Nameless()),))
    with pytest.raises(ValueError, match=r"^roughness\[1\]\.Nameless: is not a registered shape.*ertel\.shapes"):
        case.to_data()
    with pytest.raises(ValueError, match="is not a registered shape"):
        _ = case.digest
    for law in ("viscosity", "density"):
        with pytest.raises(ValueError, match=f"Nameless: is not a registered {law} law"):
            Oil(**{law: Nameless()})


def test_what_is_filled_in_and_what_follows() -> None:
    case = impact()
    assert case.time == Time(start_approach=-1.0, until="max-approach")
    assert case.output == Output()
    assert (case.oil.eta0, case.oil.alpha) == (0.04, 2.2e-8)
    assert case.motion == FREE_BALL
    assert case.schedule[:-1] == (-1.0, "max-approach", 5e-5, None, 0.1, None)
    assert case.schedule.contact_time == pytest.approx(2.943275)
    case = rolling()
    assert (case.time, case.output, case.is_steady, case.starts_apart) == (None, None, True, False)
    assert case.motion == STEADY_ROLLING
    with pytest.raises(ValueError, match="a steady contact has no time"):
        _ = case.schedule
    centred = replace(METHODS["transient"].defaults, inlet=3.0)
    case = rolling("transient")
    assert replace(case, solver=centred) == replace(case, solver=replace(centred, inlet=None))
    assert Case.from_data(replace(case, solver=centred).to_data()).solver.inlet is None
    assert impact().on_half_grid().solver.nodes == 129  # twice the spacing
    assert impact().film_scale == pytest.approx((10 / 200) ** 0.5)
    assert rolling().film_scale == pytest.approx(0.0823, rel=0.1)
    p = Parameters.from_moes(30.0, 5.0)
    assert half_width({"lambda_bar": p.lambda_bar, "alpha_bar": p.alpha_bar}) == half_width({"M": 30, "L": 5}) > 2


MOVED = replace(rolling(), drive=Drive(slide_to_roll=-2.0), roughness=(Feature(Spot(0.3, 0.1)),))
ON_TRACK = Case(Conditions(**TRACK), OIL, METHODS["steady"].defaults)


@pytest.mark.parametrize(
    ("case", "changes", "place"),
    [  # of each kind one; the rules themselves are in data/refusals.toml
        (impact(), {"solver": Solver(half_width=nan)}, "solver.half_width = NaN"),
        (ON_TRACK, {"oil": replace(OIL, viscosity=Barus(-1.0))}, 'lubricant.viscosity.alpha = "-1.0 1/Pa"'),
        (ON_TRACK, {"time": Time(tolerance=Quantity(1e-3, "m"))}, 'time.tolerance = "0.001 m"'),
        (ON_TRACK, {"roughness": (Feature(Spot(Quantity(1e-3, "s"), 0.1)),)}, 'roughness[1].radius = "0.001 s"'),
        (MOVED, {"drive": None}, "roughness[1].surface = 1"),
    ],
)
def test_every_rule_is_kept_by_replace_too(case, changes, place) -> None:
    with pytest.raises(ValueError, match=f"^{re.escape(place)}"):
        replace(case, **changes)


@pytest.mark.parametrize("values", [{"M": 1e300, "L": 10.0}, {"M": 10**400, "L": 10.0}, {"M": 200.0, "L": 1e31}])
def test_numbers_of_an_absurd_size_are_refused(values) -> None:
    with pytest.raises(ValueError, match=r"^contact\.[ML] = .*: must be between"):
        Conditions(**values)


@pytest.mark.parametrize("name", ["", "ball", "Kugel 2 (schnell)", "a_b-c.d", "x" * 100, "µ" * 50])
def test_a_plain_file_name_is_a_name(name) -> None:
    assert impact(name=name).name == name


def half_width(contact: dict[str, Any], **solver: Any) -> float:
    return Case.from_data({"contact": contact, "solver": solver}).solver.half_width


@pytest.mark.parametrize(("M", "expected"), [(1e4, 2.0), (100, 2.0), (50, 3.25), (20, 6.0), (1, 8.0)])
def test_the_default_domain_of_an_impact_widens_at_low_loads(M: float, expected: float) -> None:
    assert half_width({"M": M, "L": 5}) == expected
    assert half_width({"M": M, "L": 5}, half_width=2.5) == 2.5
    assert half_width({"M": M, "L": 5}, method="radial") == pytest.approx(2 * expected, abs=0.26)


@pytest.mark.parametrize("across", [None, 2.00001, 2.11])
def test_the_side_along_y_of_an_ellipse_reads_back(across: float | None) -> None:
    """A side that ends as long as that along x is not the default, which follows the ellipse."""
    contact = {"kind": "rolling", "M": 5.26, "L": 0.5, "radius_ratio": 2.5}
    solver = {"method": "transient"} | ({"half_width_y": across} if across else {})
    case = Case.from_data({"contact": contact, "solver": solver})
    assert Case.from_data(case.to_data()) == case
