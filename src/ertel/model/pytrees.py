"""Registration of oil laws as JAX pytrees; the laws themselves do not depend on JAX."""

from functools import cache
from typing import Any

from jax.tree_util import register_dataclass

from ertel.physics.lubricant import Lubricant


def traceable(oil: Lubricant) -> Lubricant:
    """The same oil, with its records registered as JAX pytrees; their fields are arrays or numbers."""
    records: tuple[Any, ...] = (oil, oil.viscosity_law, oil.density_law)
    for record in records:
        _register(record.__class__)
    return oil


@cache
def _register(record: Any) -> None:
    try:
        register_dataclass(record)
    except ValueError as error:
        if "already registered" not in str(error).lower() and "duplicate" not in str(error).lower():
            raise
