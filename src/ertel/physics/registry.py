"""Registries of laws and shapes by name.  Case files and stored cases refer to laws and shapes by these names.

    @VISCOSITY_LAWS.register("power")
    @dataclass(frozen=True)
    class Power: ...

Other packages add laws and shapes through entry points in the groups "ertel.viscosity_laws", "ertel.density_laws",
"ertel.fluidity_laws", "ertel.asperity_laws" and "ertel.shapes".  The name of the entry point is the name of the law;
the entry point loads the record.
"""

from collections.abc import Callable, Iterator, Mapping
from functools import cached_property
from importlib.metadata import EntryPoint, entry_points
from typing import Any, Self, TypeVar

import numpy as np

Record = TypeVar("Record", bound=type)


class Registry(Mapping[str, type]):
    """Frozen dataclasses by name.  noun: their kind, for messages.  group: the group of entry points."""

    def __init__(self, noun: str, group: str):
        self.noun, self.group = noun, group
        self._records: dict[str, type] = {}

    def register(self, name: str) -> Callable[[Record], Record]:
        """A decorator that gives a frozen dataclass its name.

        Raises TypeError if it is not a frozen dataclass, ValueError if another record has the name.
        """

        def decorate(record: Record) -> Record:
            made = vars(record).get("__dataclass_params__") if isinstance(record, type) else None
            if made is None or not made.frozen:
                raise TypeError(f"{record!r}: a {self.noun} must be a frozen dataclass")
            other = self._records.get(name)
            if other is not None and _home(other) != _home(record):  # a cell of a notebook may run again
                raise ValueError(f'name = "{name}": is the {self.noun} {other.__qualname__} already; choose another')
            self._records[name] = record
            return record

        return decorate

    def name_of(self, record: object, place: str = "") -> str:
        """The name under which the type of a record is registered.  Raises ValueError, with the place, if not."""
        for name, registered in self.items():
            if type(record) is registered:
                return name
        kind = type(record).__name__
        if isinstance(record, Mapping):
            records = ", ".join(law.__name__ for law in self.values())
            raise ValueError(f"{place}must be a name or a record of a {self.noun} ({records}); tables are for cases")
        raise ValueError(
            f"{place}{kind}: is not a registered {self.noun}, so it cannot be written down; put "
            f'@ertel.{self.group.partition(".")[2]}.register("a-name") above its class'
        )

    @cached_property
    def _announced(self) -> Mapping[str, EntryPoint]:
        return {point.name: point for point in entry_points(group=self.group)}

    def __getitem__(self, name: str) -> type:
        if name not in self._records:
            self.register(name)(self._announced[name].load())
        return self._records[name]

    def __iter__(self) -> Iterator[str]:
        return iter({**self._records, **self._announced})

    def __len__(self) -> int:
        return len({**self._records, **self._announced})


def _home(record: type) -> tuple[str, str]:
    return record.__module__, record.__qualname__


VISCOSITY_LAWS = Registry("viscosity law", "ertel.viscosity_laws")
DENSITY_LAWS = Registry("density law", "ertel.density_laws")
FLUIDITY_LAWS = Registry("fluidity law", "ertel.fluidity_laws")
OIL_LAWS = {"viscosity": VISCOSITY_LAWS, "density": DENSITY_LAWS, "rheology": FLUIDITY_LAWS}  # by field of an oil
ASPERITY_LAWS = Registry("law of asperities", "ertel.asperity_laws")
SHAPES = Registry("shape", "ertel.shapes")


class OfAnyOil:
    """A law that needs no data of the oil, so that its name alone is enough."""

    @classmethod
    def of(cls, oil: object) -> Self:
        """The law of an oil."""
        return cls()


def arrays_of(values: Any) -> Any:
    """The namespace of an array's own functions, for laws that take arrays of NumPy and of JAX."""
    return values.__array_namespace__() if hasattr(values, "__array_namespace__") else np
