"""Laws and shapes by name, own ones and those that other packages announce."""

from dataclasses import dataclass, fields
from importlib.metadata import EntryPoint

import pytest

from ertel.physics import fluidity, registry, surfaces  # noqa: F401  # the last one and the first register their own
from ertel.physics.lubricant import Barus
from ertel.physics.registry import DENSITY_LAWS, FLUIDITY_LAWS, SHAPES, VISCOSITY_LAWS, Registry
from ertel.physics.units import marks


@dataclass(frozen=True)
class Plate:
    """A record for these tests, and what a package announces."""


@dataclass
class Soft:
    """Not frozen."""


class Heir(Plate):
    """Made without the decorator."""


class Bare:
    """No dataclass."""


@pytest.fixture
def plates() -> Registry:
    found = Registry("plate", "ertel.plates")
    found.register("flat")(Plate)
    return found


def test_a_registry_is_a_mapping_from_names_to_records(plates: Registry) -> None:
    assert dict(plates) == {"flat": Plate}
    assert plates["flat"] is Plate
    assert plates.name_of(Plate()) == "flat"
    assert "round" not in plates
    with pytest.raises(KeyError):
        plates["round"]


def test_a_name_is_given_once_but_a_module_may_be_run_again(plates: Registry) -> None:
    assert plates.register("flat")(Plate) is Plate

    @dataclass(frozen=True)
    class Other:
        pass

    with pytest.raises(ValueError, match=r'^name = "flat": is the plate Plate already; choose another'):
        plates.register("flat")(Other)
    assert plates["flat"] is Plate


@pytest.mark.parametrize("record", [Soft, Bare, Heir, Plate(), 3.0])
def test_a_record_is_a_frozen_dataclass(plates: Registry, record: type) -> None:
    with pytest.raises(TypeError, match="a plate must be a frozen dataclass"):
        plates.register("other")(record)


def test_a_record_without_a_name_says_how_to_give_it_one(plates: Registry) -> None:
    with pytest.raises(ValueError) as caught:
        plates.name_of(Barus(1.0))
    message = "Barus: is not a registered plate, so it cannot be written down; put @ertel.plates.register("
    assert str(caught.value).startswith(message)


def test_what_other_packages_announce_is_known_before_it_is_imported(monkeypatch: pytest.MonkeyPatch) -> None:
    """As entry points of the registry's group; it is imported once, and stands beside what is registered here."""
    loaded: list[str] = []

    class Announced(EntryPoint):
        def load(self):  # type: ignore[no-untyped-def]
            loaded.append(self.name)
            return Plate

    point = Announced(name="announced", value="somewhere:Plate", group="ertel.plates")
    monkeypatch.setattr(registry, "entry_points", lambda group: [point] if group == "ertel.plates" else [])
    plates = Registry("plate", "ertel.plates")
    plates.register("flat")(Plate)
    assert list(plates) == ["flat", "announced"] and len(plates) == 2
    assert loaded == []
    assert plates["announced"] is plates["announced"] is Plate
    assert loaded == ["announced"]
    assert Registry("plate", "ertel.plates").name_of(Plate()) == "announced"
    assert len(Registry("plate", "ertel.others")) == 0


@pytest.mark.parametrize("laws", [VISCOSITY_LAWS, DENSITY_LAWS, FLUIDITY_LAWS, SHAPES], ids=lambda laws: laws.noun)
def test_every_field_of_a_shipped_record_has_a_mark_and_every_law_a_source(laws: Registry) -> None:
    for record in laws.values():
        if record.__module__.startswith("ertel.physics"):
            assert {f.name for f in fields(record)} - {"base"} == set(marks(record))
            assert laws is SHAPES or len(record.reference) > 10
