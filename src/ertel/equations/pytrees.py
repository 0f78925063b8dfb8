"""Registration of oil laws as JAX pytrees; the laws themselves do not depend on JAX."""

from dataclasses import fields
from functools import cache
from typing import Any, TypeVar

from jax.tree_util import register_dataclass

from ertel.physics.fluidity import Fluidity
from ertel.physics.lubricant import Lubricant

Law = TypeVar("Law", bound=Fluidity)


def traceable(oil: Lubricant) -> Lubricant:
    """The same oil, with its records registered as JAX pytrees; their fields are arrays or numbers."""
    records: tuple[Any, ...] = (oil, oil.viscosity_law, oil.density_law)
    for record in records:
        _register(record.__class__)
    return oil


def traceable_law(law: Law) -> Law:
    """The same law of shear thinning, registered as a JAX pytree together with a law inside it (`Limited`)."""
    for inside in (getattr(law, field.name) for field in fields(law)):  # type: ignore[arg-type]
        if hasattr(inside, "fluidity"):
            traceable_law(inside)
    _register(law.__class__)
    return law


@cache
def _register(record: Any) -> None:
    try:
        register_dataclass(record)
    except ValueError as error:
        if "already registered" not in str(error).lower() and "duplicate" not in str(error).lower():
            raise
