"""Small cases and reference data shared by the tests."""

from typing import Any

from ertel.case import Case
from ertel.config import parse_case


def impact(M: float, L: float, nodes: int, **sections: dict[str, Any]) -> Case:
    """A dimensionless Roelands impact on the 2-D grid; sections are merged over the defaults."""
    source: dict[str, Any] = {"contact": {"kind": "impact", "M": M, "L": L}, "solver": {"nodes": nodes}}
    for name, values in sections.items():
        source[name] = {**source.get(name, {}), **values}
    return parse_case(source)
