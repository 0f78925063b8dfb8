"""Case files: TOML, or plain data of the same layout, to a Case and back."""

import re
import tomllib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from copy import deepcopy
from math import inf
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from ertel.case.case import Case
from ertel.case.conditions import Conditions
from ertel.case.reading import Reader, regular_content
from ertel.case.records import ConfigError, amounts, field_name, shortened, show
from ertel.case.rules import plain_name
from ertel.inputs.height_maps import with_maps
from ertel.inputs.layout import READER, Materials, field_names
from ertel.inputs.names import require_rheology, without_names
from ertel.inputs.quantities import parse_quantity, plain_data
from ertel.physics.surfaces import Feature
from ertel.physics.units import Quantity, Unit, marks

__all__ = ["ConfigError", "apply_overrides", "as_case", "load_case", "parse_case", "path_of", "read_toml", "to_toml"]

CaseLike = Case | str | PathLike[str] | Mapping[str, object]


def load_case(path: str | PathLike[str], overrides: Iterable[str] = ()) -> Case:
    """The case in a TOML file, with overrides such as "solver.nodes=129" applied.

    Without a name in the file the case is called as the file is; what a name may not contain becomes "_".

    Parameters
    ----------
    path : str or Path
        The case file.
    overrides : iterable of str
        Values in place of those in the file, as SECTION.KEY=VALUE.

    Returns
    -------
    Case
        The case, checked.

    Raises
    ------
    ConfigError
        The file cannot be read, or contains something that is not allowed.
    """
    path = path_of("path", path, "a case file; parse_case takes a mapping")
    return parse_case(case_data(path, overrides), path.parent)


def case_data(path: str | PathLike[str], overrides: Iterable[str] = ()) -> dict[str, Any]:
    """The plain data of a case file, or of a study, as written, with overrides and its name.  Raises ConfigError."""
    data = apply_overrides(read_toml(Path(path)), overrides)
    data.setdefault("name", plain_name(Path(path).stem))
    return data


def parse_case(data: Mapping[str, object], folder: str | Path = ".") -> Case:
    """The case in plain data with the sections and keys of a case file.

    folder: that in which files lie that the data name.  Raises ConfigError at the first error.

    Examples
    --------
    >>> case = parse_case({"contact": {"M": 1000, "L": 10}, "solver": {"method": "radial"}})
    >>> round(case.parameters.alpha_bar, 2)
    36.44
    """
    if not isinstance(data, Mapping):
        raise ConfigError(f"data = {written(data)}: must be a mapping; load_case reads a case file")
    return case_in(data, Path(folder))


def case_in(
    data: Mapping[str, object], folder: Path = Path(), features: Sequence[Feature] = (), reader: Reader = READER
) -> Case:
    """The case in plain data, see `parse_case`, with features besides those in the data.  reader: of quantities."""
    data = plain_data(data)
    if "contact" not in data:
        keys = ", ".join((*field_names(Materials), *field_names(Conditions)))
        raise ConfigError(f"contact: the section [contact] is missing; it takes {keys}")
    named = data
    try:
        named = without_names(data, folder, reader)
        read, maps = with_maps(named, folder)
        case = Case.from_data(read, maps, reader, features)
    except ValueError as error:
        raise ConfigError(_as_written(str(error), named["contact"])) from error
    require_rheology(case, data.get("lubricant"))
    require_laws(case)
    return with_all_units(case)


def with_all_units(case: Case) -> Case:
    """The same case.  Raises ConfigError for one in SI where a length or a time is a plain number other than zero.

    Of [lubricant], [motion] and [[roughness]].  The numbers of [solver], [time] and [output] belong to the computation:
    they are in the units of the contact, a, t0 and a^2/R, in every case.
    """
    shapes = {f"roughness[{number}]": feature.shape for number, feature in enumerate(case.roughness, 1)}
    records = {"lubricant": case.oil, "motion": case.drive, **shapes} if case.scales else {}
    for place, record in records.items():
        for where, mark, amount in amounts(record, place) if record else ():
            if not isinstance(amount, Quantity) and amount not in (0.0, inf):
                needs = f'in a case in SI it needs its unit, such as "{mark.example}"'
                raise ConfigError(f"{where} = {show(amount)}: is a plain number; {needs}")
    return case


def require_laws(case: Case) -> None:
    """Raise ConfigError for a law of the user's own that JAX cannot differentiate at p = 0, where the solver begins."""
    laws: dict[str, Any] = {
        "viscosity": case.oil.viscosity_law,
        "density": case.oil.density_law,
        "rheology": case.oil.fluidity_law,
    }
    for name, law in laws.items():
        if type(law).__module__.startswith("ertel."):
            continue
        import jax  # here: most cases need none

        along = getattr(case.lubricant, name, lambda stress: laws["rheology"].fluidity(stress, 0.0))
        try:
            with jax.debug_nans(False), jax.transfer_guard("allow"), jax.numpy_dtype_promotion("standard"):
                value, slope = jax.jvp(along, (np.zeros(1),), (np.ones(1),))
        except jax.errors.TracerArrayConversionError as error:
            why = "is computed by numpy, and the solver differentiates it: write jax.numpy in place of numpy"
            raise ConfigError(f"lubricant.{name}: {why}") from error
        if name != "rheology" and not (np.isfinite(value).all() and np.isfinite(slope).all()):
            found = f"has the value {float(value[0]):g} and the slope {float(slope[0]):g} at p = 0"
            raise ConfigError(f"lubricant.{name}: {found}; both must be finite, because the solver begins there")


def as_case(given: CaseLike, name: str = "case") -> Case:
    """The case that is given as such, as plain data, or as the path of a case file.

    name: of the argument.  Raises ConfigError for anything else, and as `load_case` and `parse_case`.
    """
    match given:
        case Case():
            return given
        case str() | PathLike():
            return load_case(given)
        case Mapping():
            return parse_case(given)
    raise ConfigError(f"{name} = {written(given)}: must be a Case, a mapping, or the path of a case file")


def path_of(name: str, given: Any, what: str) -> Path:
    """The path that is given, as a text or a path.  what: it must be the path of.  Raises ConfigError."""
    if isinstance(given, str | PathLike):
        return Path(given)
    raise ConfigError(f"{name} = {written(given)}: must be the path of {what}")


def written(value: object) -> str:
    """A value as it is written in Python, for messages, in one line."""
    return shortened(" ".join(repr(value).split()))


def _as_written(text: str, written: Any) -> str:
    """A message of the case, which knows SI only, with the quantities of [contact] as the user wrote them."""
    for key, mark in marks(Conditions).items() if isinstance(written, Mapping) else ():
        if isinstance(mark, Unit) and f"contact.{key} = " in text:
            with suppress(ValueError):
                in_si = f"{parse_quantity(written.get(key), mark)!r} {mark.unit}"
                text = text.replace(f'contact.{key} = "{in_si}"', f"contact.{key} = {show(written[key])}")
    return text


# -- files ------------------------------------------------------------------------------------------------------------


DEEPEST = 3  # tables around a key
LARGEST_FILE = 1_000_000  # bytes: thousands of points of a signal
# A dotted key of many parts: the time that tomllib takes for it goes with the square of their number.
_NAME = r"""(?:[\w-]++|"[^"\n]*+"|'[^'\n]*+')"""
LONG_KEY = re.compile(rf"(?<![\w-])(?:{_NAME}[ \t]*+\.[ \t]*+){{20}}")


def read_toml(path: Path) -> dict[str, Any]:
    """The plain data of a TOML file of at most 1 MB, in UTF-8 with or without a byte order mark.

    Raises ConfigError if it is missing, not a regular file (a pipe may never end), too large or not valid TOML.
    """
    name = f"the case file {path}"
    return parse_toml(read_text(path, name), name)


def parse_toml(text: str, name: str) -> dict[str, Any]:
    """The plain data in TOML text.  Raises ConfigError, which begins with the name of the text, if it is not valid."""
    if LONG_KEY.search(text):
        raise ConfigError(f"{name} is not valid TOML: a key has more than 20 parts, a.b.c...; a case file needs two")
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise ConfigError(f"{name} is not valid TOML: {shortened(str(error))}") from error
    except ValueError as error:  # of Python's own limit
        raise ConfigError(f"{name} is not valid TOML: an integer has thousands of digits") from error
    except RecursionError as error:
        raise ConfigError(f"{name} is not valid TOML: arrays or tables are nested hundreds of times") from error


def read_text(path: Path, name: str) -> str:
    """The text of a regular file of at most 1 MB, in UTF-8.  Raises ConfigError with its name if it cannot be read."""
    try:
        return regular_content(path, LARGEST_FILE).decode("utf-8-sig")
    except UnicodeDecodeError as error:
        wrong = f"byte {error.start + 1} is not"
        raise ConfigError(f"{name} is not valid TOML: must be text in UTF-8, but {wrong}") from error
    except ValueError as error:
        raise ConfigError(f"{name} {error}") from error


def to_toml(case: Case) -> str:
    """A case as a case file, complete and in SI; it reads back as the same case, to the last bit.

    A case with measured surfaces needs the files of `Case.maps` beside it, as in a run directory.  Raises ValueError
    for a law or a shape that has no registered name, and for anything else than a case.
    """
    import tomli_w

    return tomli_w.dumps(as_case(case).to_data())


def apply_overrides(data: Mapping[str, Any], overrides: Iterable[str]) -> dict[str, Any]:
    """Apply "section.key=value" items to the data, also to tables in a section; a value is TOML, or else a string."""
    merged = deepcopy(dict(data))
    for item in overrides:
        target, equals, text = item.partition("=")
        *tables, key = parts = target.strip().split(".")
        if not equals or not all(parts) or len(tables) > DEEPEST:
            raise ConfigError(f"--set {shortened(item)}: must be section.key=value, for example solver.nodes=129")
        place = merged
        for part in tables:
            place = place.setdefault(part, {})
            if not isinstance(place, dict):
                raise ConfigError(f"--set {shortened(item)}: {shortened(part)} is not a section or a table")
        value = _toml_or_text(text.strip())
        if key == "law" and place.get(key) != value:
            place.clear()  # the numbers of a law are not those of another
        place[key] = value
    return merged


def put(data: dict[str, Any], place: Sequence[str | int], value: Any) -> None:
    """Put a value at a place into plain data themselves; tables on the way are made."""
    table: Any = data
    for number, part in enumerate(place[:-1], 1):
        table = table[part] if isinstance(part, int) else table.setdefault(part, {})
        if not isinstance(table, dict if isinstance(place[number], str) else list):
            raise ConfigError(f"{field_name(place)}: {part} is not a table")
    table[place[-1]] = value


@contextmanager
def in_the_case(values: Mapping[str, Any]) -> Iterator[None]:
    """In this block a complaint about a case says which one it is: that with these values by their fields."""
    try:
        yield
    except ValueError as error:
        where = ", ".join(f"{field} = {show(value)}" for field, value in values.items())
        raise ConfigError(f"{error} (in the case with {where})") from error


def _toml_or_text(text: str) -> object:
    try:
        data = tomllib.loads(f"value = {text}")
    except (ValueError, RecursionError):
        return text
    return data["value"] if len(data) == 1 else text  # not what follows in further lines
