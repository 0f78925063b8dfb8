"""Checks of arguments."""

from math import isfinite


def require_positive(name: str, value: float) -> None:
    """Raise ValueError unless value is finite and above zero."""
    if not (isfinite(value) and value > 0):
        raise ValueError(f"{name} = {value}: must be finite and above zero")


def require_not_negative(name: str, value: float) -> None:
    """Raise ValueError unless value is finite and not below zero."""
    if not (isfinite(value) and value >= 0):
        raise ValueError(f"{name} = {value}: must be finite and not below zero")
