"""A case in a few lines, as text and as a table in a notebook."""

import re
from collections.abc import Iterator, Mapping
from html import escape
from typing import Any

NUMBER = re.compile(r"[-+]?\d+\.?\d*(e[-+]?\d+)?(?= |$)")
LEFT_OUT = ("schema", "name", "reference")


def text(title: str, data: Mapping[str, Any]) -> str:
    """title: the first line.  data: the case as plain data, a line each section."""
    return "\n".join([f"Case: {title}", *(f"  {name:<10} {content}" for name, content in _sections(data))])


def table(title: str, data: Mapping[str, Any]) -> str:
    """The same as an HTML table."""
    rows = "".join(f"<tr><th>{escape(n)}</th><td>{escape(content)}</td></tr>" for n, content in _sections(data))
    return f"<div>Case: {escape(title)}<table>{rows}</table></div>"


def _sections(data: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    for name, section in data.items():
        for one in section if isinstance(section, list) else [section]:
            if name not in LEFT_OUT:
                yield name, _pairs(one) if isinstance(one, Mapping) else _short(one)


def _pairs(data: Mapping[str, Any]) -> str:
    return ", ".join(f"{key} = {_short(value)}" for key, value in data.items() if key not in LEFT_OUT)


def _short(value: Any) -> str:
    """A value for reading: numbers, also those before a unit, with four digits."""
    if isinstance(value, Mapping):
        return f"{{ {_pairs(value)} }}"
    if isinstance(value, float):
        return f"{value:.4g}"
    return NUMBER.sub(lambda found: f"{float(found[0]):.4g}", value) if isinstance(value, str) else str(value)
