"""Case files: TOML to Case and back.  Validation by pydantic, units by pint, both at this door only.

A quantity is a string with a unit ("10 mm"), a dimensionless number a plain number.  Inside, everything is SI.
"""

import json
import re
import tomllib
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from decimal import Decimal
from difflib import get_close_matches
from functools import cache
from math import isfinite
from pathlib import Path
from typing import Annotated, Any, Literal, TypeVar, cast, get_args

from pydantic import BaseModel, ConfigDict, Field, ValidationError, ValidationInfo, field_validator

from ertel import case as defaults
from ertel import grid, lubricant, radial, scales
from ertel.case import Case
from ertel.scales import Parameters, Scales


class ConfigError(ValueError):
    """The input is wrong: the message, one line, names the field, its value and what is allowed."""

    def __init__(self, message: str):
        super().__init__("".join(c if c.isprintable() else ascii(c)[1:-1] for c in message))


@dataclass(frozen=True)
class SI:
    """Marks a field as a quantity: the unit it has inside, and an example of how to write it."""

    unit: str
    example: str


LENGTH = SI("m", "10 mm")
MASS = SI("kg", "33 g")
DENSITY = SI("kg/m^3", "7850 kg/m^3")
SPEED = SI("m/s", "0.1 m/s")
STRESS = SI("Pa", "210 GPa")
VISCOSITY = SI("Pa*s", "40 mPa*s")
COMPLIANCE = SI("1/Pa", "22 / GPa")

FEWEST_NODES = 17  # of the 2-D method

T = TypeVar("T")
PositiveNumber = Annotated[float, Field(gt=0)]


class _Section(BaseModel):
    model_config = ConfigDict(extra="forbid", strict=True, frozen=True, allow_inf_nan=False)

    @field_validator("*", mode="before")
    @classmethod
    def _quantity_to_si(cls, value: object, info: ValidationInfo) -> object:
        marks = [m for m in cls.model_fields[str(info.field_name)].metadata if isinstance(m, SI)]
        return parse_quantity(value, marks[0]) if marks else value


class ContactSection(_Section):
    """What meets: Moes' M and L, or lambda_bar and alpha_bar, or physical input."""

    kind: Literal["impact"] = "impact"
    M: Annotated[float | None, Field(gt=0)] = None
    L: Annotated[float | None, Field(ge=0)] = None
    lambda_bar: Annotated[float | None, Field(gt=0)] = None
    alpha_bar: Annotated[float | None, Field(ge=0)] = None
    radius: Annotated[float | None, LENGTH] = None
    radius_1: Annotated[float | None, LENGTH] = None
    radius_2: Annotated[float | None, LENGTH] = None
    mass: Annotated[float | None, MASS] = None
    ball_density: Annotated[float | None, DENSITY] = None
    speed: Annotated[float | None, SPEED] = None
    drop_height: Annotated[float | None, LENGTH] = None
    E_prime: Annotated[float | None, STRESS] = None
    E1: Annotated[float | None, STRESS] = None
    nu1: Annotated[float | None, Field(gt=-1, le=0.5)] = None
    E2: Annotated[float | None, STRESS] = None
    nu2: Annotated[float | None, Field(gt=-1, le=0.5)] = None


class LubricantSection(_Section):
    """The oil: its laws, and the data they need."""

    viscosity: Literal["roelands", "barus", "isoviscous"] = "roelands"
    density: Literal["dowson-higginson", "incompressible"] = "dowson-higginson"
    eta0: Annotated[float | None, VISCOSITY] = None
    alpha: Annotated[float | None, COMPLIANCE] = None
    p0: Annotated[float, STRESS] = lubricant.P0_ROELANDS
    z: Annotated[float | None, Field(gt=0)] = None
    reference: str | None = None


class SolverSection(_Section):
    """Grid and tolerance, see ertel.case.Solver."""

    method: defaults.Method = defaults.Solver.method
    nodes: Annotated[int, Field(gt=0, le=4097)] = defaults.Solver.nodes
    half_width: Annotated[float, Field(gt=1)] = defaults.Solver.half_width
    tolerance: Annotated[float, Field(gt=0, lt=1)] = defaults.Solver.tolerance


class TimeSection(_Section):
    """Start, end and steps, see ertel.case.Time."""

    start_approach: Annotated[float, Field(lt=0)] = defaults.Time.start_approach
    until: defaults.Stop | float = defaults.Time.until
    tolerance: Annotated[float, Field(gt=0, lt=1)] = defaults.Time.tolerance
    step: Annotated[float | None, Field(gt=0)] = defaults.Time.step

    @field_validator("until", mode="before")
    @classmethod
    def _an_event_or_a_time(cls, value: object) -> object:
        events = get_args(defaults.Stop)
        is_time = isinstance(value, float | int) and not isinstance(value, bool) and isfinite(value) and value > 0
        if not (value in events or is_time):
            raise ValueError("must be " + ", ".join(f'"{e}"' for e in events) + " or a time above zero, in units t0")
        return value


class OutputSection(_Section):
    """What is kept, see ertel.case.Output."""

    interval: PositiveNumber = defaults.Output.interval


class CaseFile(_Section):
    """A whole case file."""

    schema_version: Annotated[Literal[1], Field(alias="schema")] = 1  # of the layout of case files
    name: str = ""
    contact: ContactSection
    lubricant: LubricantSection = LubricantSection()
    solver: SolverSection = SolverSection()
    time: TimeSection = TimeSection()
    output: OutputSection = OutputSection()


# -- the door in ------------------------------------------------------------------------------------------------------


def load_case(path: str | Path, overrides: Iterable[str] = ()) -> Case:
    """The case in a TOML file, with overrides such as "solver.nodes=129" laid over it.

    Raises ConfigError when the file cannot be read or says something that is not allowed.
    """
    path = Path(path)
    data = apply_overrides(read_toml(path), overrides)
    data.setdefault("name", path.stem)
    return parse_case(data)


def parse_case(data: Mapping[str, object]) -> Case:
    """The case in plain data with the sections and keys of a case file.

    Examples
    --------
    >>> case = parse_case({"contact": {"M": 1000, "L": 10}, "solver": {"method": "radial"}})
    >>> round(case.parameters.alpha_bar, 2)
    36.44
    """
    file = _validate(data)
    written = dict(cast(Mapping[str, object], data["contact"]))
    route = _only_one(written, (MOES, BARS, PHYSICAL))
    si = _physical_scales(file.contact, written) if route is PHYSICAL else None
    oil = _oil(file.lubricant, physical=route is PHYSICAL)
    parameters = _parameters(file.contact, oil, si, written, route)
    case = Case(
        parameters=parameters,
        lubricant=_lubricant(oil, parameters, si),
        solver=defaults.Solver(**dict(file.solver)),
        time=defaults.Time(**dict(file.time)),
        output=defaults.Output(**dict(file.output)),
        scales=si,
        kind=file.contact.kind,
        name=file.name,
        source=plain_data(file.model_copy(update={"lubricant": oil})),
    )
    return check_case(case)


def check_case(case: Case) -> Case:
    """The case again, or ConfigError where its grid is too small or cannot be coarsened."""
    nodes = case.solver.nodes
    if case.solver.method == "radial":
        _named("solver", radial.check_grid, nodes, case.solver.half_width)
        return case
    if nodes < FEWEST_NODES:
        raise ConfigError(f"solver.nodes = {nodes}: must be at least {FEWEST_NODES}")
    _named("solver", grid.check_nodes, nodes)
    return case


def read_toml(path: Path) -> dict[str, Any]:
    """The plain data of a TOML file; ConfigError when it is missing or no TOML."""
    try:
        return tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise ConfigError(f"cannot read the case file {path}: {(error.strerror or str(error)).lower()}") from error
    except ValueError as error:  # TOMLDecodeError and UnicodeDecodeError
        raise ConfigError(f"the case file {path} is not valid TOML: {error}") from error


def apply_overrides(data: Mapping[str, Any], overrides: Iterable[str]) -> dict[str, Any]:
    """Lay "section.key=value" items over the data; a value is TOML, or else a string as it stands."""
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


# -- quantities -------------------------------------------------------------------------------------------------------

_NUMBER = re.compile(r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?|[+-]?(?:nan|inf)\b)\s*(.*?)\s*", re.IGNORECASE)


def parse_quantity(value: object, si: SI) -> float | None:
    """A quantity such as "10 mm" as a finite number above zero in the SI unit; None stays None.

    Examples
    --------
    >>> parse_quantity("22 / GPa", COMPLIANCE) == 22e-9
    True
    """
    if value is None:
        return None
    wanted = f'a quantity above zero with a unit such as "{si.example}"'
    match = _NUMBER.fullmatch(value) if isinstance(value, str) else None
    if match is None or not match[2]:
        raise ValueError(f"must be {wanted}")
    unit = f"1{match[2]}" if match[2].startswith("/") else match[2]
    if not (isfinite(float(match[1])) and float(match[1]) > 0):
        raise ValueError(f"must be {wanted}")
    return float(Decimal(match[1]) * _factor(unit, si))  # decimal, so that "18.6 mPa*s" is the float 0.0186


@cache
def _factor(unit: str, si: SI) -> Decimal:
    """How many SI units one `unit` is."""
    if unit == si.unit:
        return Decimal(1)
    import pint  # late: it takes a while, and dimensionless cases never need it

    registry = _registry()
    try:
        found = registry.Quantity(1.0, registry.parse_units(unit))
    except Exception as error:  # pint raises many kinds, from its own to the tokenizer's
        raise ValueError(f'has an unknown unit "{unit}"; write for example "{si.example}"') from error
    try:
        return Decimal(f"{found.to(si.unit).magnitude:.14g}")  # without the round-off of powers of ten
    except pint.PintError as error:
        raise ValueError(f'has the wrong dimension {found.dimensionality}; write for example "{si.example}"') from error


@cache
def _registry() -> Any:
    import pint

    return pint.UnitRegistry()


# -- the parameters ---------------------------------------------------------------------------------------------------

Keys = tuple[str, ...]
MOES: Keys = ("M", "L")
BARS: Keys = ("lambda_bar", "alpha_bar")
RADII = (("radius",), ("radius_1", "radius_2"))
INERTIA = (("mass",), ("ball_density",))
MOTION = (("speed",), ("drop_height",))
ELASTICITY = (("E_prime",), ("E1", "nu1", "E2", "nu2"))
PHYSICAL: Keys = tuple(key for group in (RADII, INERTIA, MOTION, ELASTICITY) for keys in group for key in keys)
_PHYSICAL_TEXT = "radius (or two radii), mass or ball_density, speed or drop_height, E_prime or E1, nu1, E2, nu2"


def _parameters(
    contact: ContactSection, oil: LubricantSection, si: Scales | None, written: Mapping[str, object], route: Keys
) -> Parameters:
    """lambda_bar and alpha_bar by the one route that the input takes; zero pressure index where the oil has none."""
    isoviscous = oil.viscosity == "isoviscous"
    if si:
        return _named("contact", scales.parameters, si, oil.eta0, 0.0 if isoviscous else oil.alpha)
    first, second = route
    if isoviscous and written.get(second):
        raise ConfigError(f'{_entry(second, written)}: must be 0 or left out with lubricant.viscosity = "isoviscous"')
    _complete({second: 0, **written} if isoviscous else written, route)
    make = Parameters.from_moes if route is MOES else Parameters
    return _named("contact", make, getattr(contact, first), getattr(contact, second) or 0.0)


def _physical_scales(contact: ContactSection, written: Mapping[str, object]) -> Scales:
    """Scales of the impact, each of its four inputs given in exactly one of the allowed ways."""
    ways = {}
    for alternatives in (RADII, INERTIA, MOTION, ELASTICITY):
        keys = _only_one(written, alternatives)
        _complete(written, keys)
        ways[alternatives] = tuple(getattr(contact, key) for key in keys)
    ball = ways[RADII][0]
    (mass,) = ways[INERTIA] if "mass" in written else (_named("contact", scales.sphere_mass, ball, *ways[INERTIA]),)
    (speed,) = ways[MOTION] if "speed" in written else (_named("contact", scales.drop_speed, *ways[MOTION]),)
    modulus = ways[ELASTICITY]
    E_prime = modulus[0] if len(modulus) == 1 else _named("contact", scales.reduced_modulus, *modulus)
    return _named("contact", scales.impact_scales, scales.reduced_radius(*ways[RADII]), mass, speed, E_prime)


def _oil(oil: LubricantSection, physical: bool) -> LubricantSection:
    """The oil with typical data filled in, or with what is missing demanded where the contact is physical."""
    if not physical:
        return oil.model_copy(update={"eta0": oil.eta0 or lubricant.ETA0, "alpha": oil.alpha or lubricant.ALPHA})
    for key, si in {"eta0": VISCOSITY, "alpha": COMPLIANCE}.items():
        if getattr(oil, key) is None and not (key == "alpha" and oil.viscosity == "isoviscous"):
            raise ConfigError(f'lubricant.{key}: missing, a physical contact needs it, for example "{si.example}"')
    return oil


def _only_one(written: Mapping[str, object], alternatives: Sequence[Keys]) -> Keys:
    """The one alternative of which something is written in [contact]."""
    present = [keys for keys in alternatives if any(key in written for key in keys)]
    allowed = "; or ".join(_PHYSICAL_TEXT if keys is PHYSICAL else " and ".join(keys) for keys in alternatives)
    if not present:
        raise ConfigError(f"contact.{alternatives[0][0]}: missing; allowed: {allowed}")
    if len(present) > 1:
        pair = [_entry(next(key for key in keys if key in written), written) for keys in present[:2]]
        raise ConfigError(f"{' and '.join(pair)} are given together; allowed: {allowed}")
    return present[0]


def _complete(written: Mapping[str, object], keys: Keys) -> None:
    missing = [key for key in keys if key not in written]
    if missing:
        present = next(key for key in keys if key in written)
        raise ConfigError(f"contact.{missing[0]}: missing; {_entry(present, written)} needs " + " and ".join(keys))


def _entry(key: str, written: Mapping[str, object]) -> str:
    return f"contact.{key} = {show(written[key])}"


def _lubricant(oil: LubricantSection, parameters: Parameters, si: Scales | None) -> lubricant.Lubricant:
    p_h = si.p_h if si else parameters.alpha_bar / (oil.alpha or lubricant.ALPHA)
    if p_h == 0 and oil.viscosity != "isoviscous":
        raise ConfigError(f'contact.L = 0: must be above zero with lubricant.viscosity = "{oil.viscosity}"')
    if p_h == 0 and oil.density == "dowson-higginson":
        raise ConfigError(
            'lubricant.density = "dowson-higginson": needs a pressure scale, which a dimensionless isoviscous case '
            'does not have; allowed: density = "incompressible", or physical input'
        )
    viscosity: lubricant.Viscosity = lubricant.Isoviscous()
    if oil.viscosity == "barus":
        viscosity = lubricant.Barus(parameters.alpha_bar)
    elif oil.viscosity == "roelands":
        z = oil.z or _named("lubricant", lubricant.roelands_exponent, oil.alpha, oil.eta0, oil.p0)
        viscosity = lubricant.Roelands(parameters.alpha_bar, z, p_h / oil.p0)
    dense = oil.density == "dowson-higginson"
    density = lubricant.DowsonHigginson(p_h / lubricant.DENSITY_PRESSURE) if dense else lubricant.Incompressible()
    return lubricant.Lubricant(viscosity, density)


# -- one clear message ------------------------------------------------------------------------------------------------


def _validate(data: Mapping[str, object]) -> CaseFile:
    if "contact" not in data:
        raise ConfigError(f"contact: the section [contact] is missing; it takes {_list(ContactSection.model_fields)}")
    try:
        return CaseFile.model_validate(dict(data))
    except ValidationError as error:
        raise ConfigError(_message(error)) from error


def _message(error: ValidationError) -> str:
    """The first thing that is wrong: field = value: what is allowed."""
    first = error.errors()[0]
    names = [str(part) for part in first["loc"]]
    field = f"{'.'.join(names)} = {show(first['input'])}"
    if first["type"] == "extra_forbidden":
        return f"{field}: unknown key; " + _known_keys(names)
    if first["type"] == "value_error":
        return f"{field}: {first['ctx']['error']}"
    if first["type"] == "literal_error":
        return f"{field}: allowed: {first['ctx']['expected']}"
    if first["type"] in ("model_type", "model_attributes_type"):
        return f"{field}: must be a section, [{names[0]}]"
    return f"{field}: " + first["msg"].replace("Input should be", "must be").replace("valid ", "")


def _known_keys(names: Sequence[str]) -> str:
    model: type[BaseModel] = CaseFile
    for name in names[:-1]:
        model = model.model_fields[name].annotation  # type: ignore[assignment]
    known = [field.alias or key for key, field in model.model_fields.items()]
    close = get_close_matches(names[-1], known, n=1)
    return (f"did you mean {close[0]}? " if close else "") + f"allowed: {_list(known)}"


def _list(names: Iterable[str]) -> str:
    return ", ".join(names)


def show(value: object) -> str:
    """A value as one would write it in TOML."""
    return json.dumps(value, default=str, ensure_ascii=False).replace("\x7f", "\\u007f")


def _named(section: str, function: Callable[..., T], *arguments: Any) -> T:
    """function(*arguments), its complaint about an argument as one about a field of the section."""
    try:
        return function(*arguments)
    except (ValueError, ArithmeticError) as error:
        message = str(error)
        raise ConfigError(message if message.startswith(f"{section}.") else f"{section}.{message}") from error


# -- the door out -----------------------------------------------------------------------------------------------------


def plain_data(model: BaseModel) -> dict[str, object]:
    """A validated section or file as plain data that reads back as exactly the same: quantities as strings in SI."""
    data: dict[str, object] = {}
    for key, field in type(model).model_fields.items():
        value = getattr(model, key)
        unit = next((mark.unit for mark in field.metadata if isinstance(mark, SI)), None)
        if isinstance(value, BaseModel):
            data[key] = plain_data(value)
        elif value is not None:
            data[field.alias or key] = f"{value!r} {unit}" if unit else value
    return data


def to_toml(data: Mapping[str, object]) -> str:
    """Plain data of a case file as TOML."""
    top = [f"{key} = {show(value)}" for key, value in data.items() if not isinstance(value, dict)]
    lines = [*top]
    for section, values in data.items():
        if isinstance(values, dict):
            lines += ["", f"[{section}]", *(f"{key} = {show(value)}" for key, value in values.items())]
    return "\n".join(lines) + "\n"
