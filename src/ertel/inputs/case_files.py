"""Case files: TOML, or plain data of the same layout, to a Case and back."""

import tomllib
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from ertel.inputs.messages import ConfigError, message
from ertel.inputs.names import without_names
from ertel.inputs.schema import case_file, keys_of, plain, section_of
from ertel.model.case import Case
from ertel.model.conditions import Conditions
from ertel.model.records import show
from ertel.physics.units import Unit, marks

__all__ = ["ConfigError", "apply_overrides", "load_case", "parse_case", "read_toml", "to_toml"]


def load_case(path: str | Path, overrides: Iterable[str] = ()) -> Case:
    """The case in a TOML file, with overrides such as "solver.nodes=129" applied.

    Raises ConfigError if the file cannot be read or contains something that is not allowed.
    """
    path = Path(path)
    data = apply_overrides(read_toml(path), overrides)
    data.setdefault("name", path.stem)
    return parse_case(data)


def parse_case(data: Mapping[str, object]) -> Case:
    """The case in plain data with the sections and keys of a case file.

    Raises ConfigError at the first error.

    Examples
    --------
    >>> case = parse_case({"contact": {"M": 1000, "L": 10}, "solver": {"method": "radial"}})
    >>> round(case.parameters.alpha_bar, 2)
    36.44
    """
    if "contact" not in data:
        keys = ", ".join(keys_of(section_of(Conditions)))
        raise ConfigError(f"contact: the section [contact] is missing; it takes {keys}")
    data = without_names(data)
    try:
        read = plain(case_file().model_validate(data))
    except ValidationError as error:
        raise ConfigError(message(error)) from error
    try:
        return Case.from_data(read)
    except ValueError as error:
        raise ConfigError(_as_written(str(error), data["contact"], read["contact"])) from error


def _as_written(text: str, written: Any, read: Mapping[str, Any]) -> str:
    """A message of the model, which knows SI only, with the quantities of [contact] as the user wrote them."""
    for key, mark in marks(Conditions).items():
        if isinstance(mark, Unit) and key in read:
            text = text.replace(f'contact.{key} = "{read[key]!r} {mark.unit}"', f"contact.{key} = {show(written[key])}")
    return text


# -- files ------------------------------------------------------------------------------------------------------------


def read_toml(path: Path) -> dict[str, Any]:
    """The plain data of a TOML file; ConfigError if it is missing or not valid TOML."""
    try:
        return tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise ConfigError(f"cannot read the case file {path}: {(error.strerror or str(error)).lower()}") from error
    except ValueError as error:  # TOMLDecodeError and UnicodeDecodeError
        raise ConfigError(f"the case file {path} is not valid TOML: {error}") from error


def to_toml(case: Case) -> str:
    """A case as a case file, complete and in SI; it reads back as the same case, to the last bit.

    Raises ValueError for a law or a shape that has no registered name.
    """
    import tomli_w

    return tomli_w.dumps(case.to_data())


def apply_overrides(data: Mapping[str, Any], overrides: Iterable[str]) -> dict[str, Any]:
    """Apply "section.key=value" items to the data; a value is TOML, otherwise a plain string."""
    merged = {key: dict(value) if isinstance(value, dict) else value for key, value in data.items()}
    for item in overrides:
        target, equals, text = item.partition("=")
        *section, key = target.strip().split(".")
        if not equals or not key or len(section) > 1:
            raise ConfigError(f"--set {item}: must be section.key=value, for example solver.nodes=129")
        place = merged.setdefault(section[0], {}) if section else merged
        if not isinstance(place, dict):
            raise ConfigError(f"--set {item}: {section[0]} is no section")
        place[key] = _toml_or_text(text.strip())
    return merged


def _toml_or_text(text: str) -> object:
    try:
        return tomllib.loads(f"value = {text}")["value"]
    except tomllib.TOMLDecodeError:
        return text
