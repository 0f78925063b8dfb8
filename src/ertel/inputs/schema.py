"""The layout of case files: sections and keys with their types, by pydantic; what is wrong with one; TOML and back.

A quantity is a string with a unit ("10 mm"), a dimensionless number a plain number.  Inside, everything is SI.  An
amount may be either: a plain number in the units of the case, a, a^2/R or t0, or a quantity.
"""

import json
import tomllib
from collections.abc import Iterable, Mapping, Sequence
from difflib import get_close_matches
from functools import partial
from pathlib import Path
from typing import Annotated, Any, Literal, get_args

from pydantic import (
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Discriminator,
    Field,
    Tag,
    ValidationError,
    ValidationInfo,
    field_validator,
)

from ertel.inputs import quantities
from ertel.inputs.quantities import SI, Amount, parse_amount, parse_quantity
from ertel.model import case as defaults
from ertel.physics import lubricant


class ConfigError(ValueError):
    """The input is wrong: the message, one line, names the field, its value and what is allowed."""

    def __init__(self, message: str):
        super().__init__("".join(c if c.isprintable() else ascii(c)[1:-1] for c in message))


# -- sections and keys ------------------------------------------------------------------------------------------------


class _Section(BaseModel):
    model_config = ConfigDict(extra="forbid", strict=True, frozen=True, allow_inf_nan=False)

    @field_validator("*", mode="before")
    @classmethod
    def _quantity_to_si(cls, value: object, info: ValidationInfo) -> object:
        marks = [m for m in cls.model_fields[str(info.field_name)].metadata if isinstance(m, SI)]
        return parse_quantity(value, marks[0]) if marks else value


class ContactSection(_Section):
    """What meets: Moes' M and L, or lambda_bar and alpha_bar, or physical input."""

    kind: defaults.Kind = "impact"
    M: Annotated[float | None, Field(gt=0)] = None
    L: Annotated[float | None, Field(ge=0)] = None
    lambda_bar: Annotated[float | None, Field(gt=0)] = None
    alpha_bar: Annotated[float | None, Field(ge=0)] = None
    radius: Annotated[float | None, quantities.LENGTH] = None
    radius_1: Annotated[float | None, quantities.LENGTH] = None
    radius_2: Annotated[float | None, quantities.LENGTH] = None
    mass: Annotated[float | None, quantities.MASS] = None
    ball_density: Annotated[float | None, quantities.DENSITY] = None
    speed: Annotated[float | None, quantities.SPEED] = None
    drop_height: Annotated[float | None, quantities.LENGTH] = None
    load: Annotated[float | None, quantities.LOAD] = None
    speed_1: Annotated[float | None, quantities.VELOCITY] = None
    speed_2: Annotated[float | None, quantities.VELOCITY] = None
    mean_speed: Annotated[float | None, quantities.VELOCITY] = None
    slide_to_roll: float | None = None
    E_prime: Annotated[float | None, quantities.STRESS] = None
    E1: Annotated[float | None, quantities.STRESS] = None
    nu1: Annotated[float | None, Field(gt=-1, le=0.5)] = None
    E2: Annotated[float | None, quantities.STRESS] = None
    nu2: Annotated[float | None, Field(gt=-1, le=0.5)] = None


class LubricantSection(_Section):
    """The oil: its laws, and the data they need."""

    viscosity: Literal["roelands", "barus", "isoviscous"] = "roelands"
    density: Literal["dowson-higginson", "incompressible"] = "dowson-higginson"
    eta0: Annotated[float | None, quantities.VISCOSITY] = None
    alpha: Annotated[float | None, quantities.COMPLIANCE] = None
    p0: Annotated[float, quantities.STRESS] = lubricant.P0_ROELANDS
    z: Annotated[float | None, Field(gt=0)] = None
    reference: str | None = None


def _amount(si: SI, own: str) -> Any:
    return BeforeValidator(partial(parse_amount, si=si, own=own))


Duration = Annotated[Amount, _amount(quantities.DURATION, "t0")]
Time = Annotated[Amount, _amount(quantities.TIME, "t0")]
Length = Annotated[Amount, _amount(quantities.SMALL_LENGTH, "a")]
Position = Annotated[Amount, _amount(quantities.POSITION, "a")]
Height = Annotated[Amount, _amount(quantities.HEIGHT, "a^2/R")]
Share = Annotated[float, Field(gt=0, lt=1)]


class SolverSection(_Section):
    """Grid and tolerance, see ertel.case.Solver; what is left out comes from ertel.case.SOLVERS."""

    method: defaults.Method | None = None
    nodes: Annotated[int, Field(gt=0, le=4097)] | None = None
    half_width: Annotated[float, Field(gt=1)] | None = None
    inlet: Annotated[float, Field(gt=1)] | None = None
    tolerance: Share | None = None
    fold: bool | None = None


def _event_or_time(value: object) -> object:
    events = get_args(defaults.Stop)
    if isinstance(value, str) and value in events:
        return value
    try:
        return parse_amount(value, quantities.DURATION, "t0")
    except ValueError as error:
        names = ", ".join(f'"{event}"' for event in events)
        raise ValueError(f'must be {names} or a time above zero, in units t0 or a quantity such as "5 ms"') from error


class TimeSection(_Section):
    """Start, end and steps, see ertel.case.Time."""

    start_approach: Annotated[float, Field(lt=0)] | None = None
    until: Annotated[defaults.Stop | Amount | None, BeforeValidator(_event_or_time)] = None
    tolerance: Share = defaults.Time.tolerance
    step: Duration | None = None


class OutputSection(_Section):
    """What is kept, see ertel.case.Output."""

    interval: Duration = Amount(defaults.Output.interval)


class OscillationTable(_Section):
    """mean + amplitude sin(2 pi T/period + phase)."""

    mean: float
    amplitude: float
    period: Duration
    phase: float = 0.0


NUMBER, POINTS, TABLE = "<number>", "<points>", "<table>"  # tags, no part of a field's name


def _signal_form(value: object) -> str | None:
    if isinstance(value, int | float) and not isinstance(value, bool):
        return NUMBER
    if isinstance(value, list | tuple):
        return POINTS
    return TABLE if isinstance(value, dict | OscillationTable) else None


Point = Annotated[tuple[Time, float], Field(strict=False)]
Signal = Annotated[
    Annotated[float, Tag(NUMBER)]
    | Annotated[tuple[Point, ...], Field(strict=False, min_length=1), Tag(POINTS)]
    | Annotated[OscillationTable, Tag(TABLE)],
    Discriminator(_signal_form),
]
_SIGNAL_TEXT = "a number, an array of [T, value], or a table { mean, amplitude, period, phase }"


class MotionSection(_Section):
    """What drives the contact in time, see ertel.motion.Motion."""

    load: Signal | None = None
    entrainment: Signal | None = None
    slide_to_roll: float | None = None
    inertia: Annotated[float, Field(ge=0)] | None = None


class WavinessSection(_Section):
    """See ertel.roughness.Waviness; a wavelength that is left out is infinite."""

    shape: Literal["waviness"]
    amplitude: Height
    wavelength_x: Length | None = None
    wavelength_y: Length | None = None
    phase_x: float = 0.0
    phase_y: float = 0.0
    front: Position | None = None
    ramp: Length | None = None
    surface: Literal[1, 2] = 1


class RingsSection(_Section):
    """See ertel.roughness.RingWaviness."""

    shape: Literal["rings"]
    amplitude: Height
    wavelength: Length
    phase: float = 0.0
    x: Position = Amount(0.0)
    y: Position = Amount(0.0)
    surface: Literal[1, 2] = 1


class SpotSection(_Section):
    """See ertel.roughness.Spot; a bump of some height, or a cavity of some depth."""

    shape: Literal["spot"]
    height: Height | None = None
    depth: Height | None = None
    radius: Length
    x: Position = Amount(0.0)
    y: Position = Amount(0.0)
    surface: Literal[1, 2] = 1


SHAPES: Mapping[str, type[BaseModel]] = {"waviness": WavinessSection, "rings": RingsSection, "spot": SpotSection}


def _shape_of(value: object) -> str | None:
    shape = value.get("shape") if isinstance(value, dict) else getattr(value, "shape", None)
    return f"<{shape}>" if isinstance(shape, str) and shape in SHAPES else None


FeatureSection = Annotated[
    Annotated[WavinessSection, Tag("<waviness>")]
    | Annotated[RingsSection, Tag("<rings>")]
    | Annotated[SpotSection, Tag("<spot>")],
    Discriminator(_shape_of),
]


class CaseFile(_Section):
    """A whole case file."""

    schema_version: Annotated[Literal[1], Field(alias="schema")] = 1  # of the layout of case files
    name: str = ""
    contact: ContactSection
    lubricant: LubricantSection = LubricantSection()
    solver: SolverSection = SolverSection()
    motion: MotionSection | None = None
    roughness: Annotated[tuple[FeatureSection, ...], Field(strict=False)] = ()
    time: TimeSection | None = None
    output: OutputSection | None = None


# -- the door in ------------------------------------------------------------------------------------------------------


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


def validate(data: Mapping[str, object]) -> CaseFile:
    """Plain data as a case file; ConfigError about the first thing that is wrong."""
    if "contact" not in data:
        raise ConfigError(f"contact: the section [contact] is missing; it takes {_list(ContactSection.model_fields)}")
    try:
        return CaseFile.model_validate(dict(data))
    except ValidationError as error:
        raise ConfigError(_message(error)) from error


# -- one clear message ------------------------------------------------------------------------------------------------


def _message(error: ValidationError) -> str:
    """The first thing that is wrong: field = value: what is allowed."""
    first = error.errors()[0]
    place = [part for part in first["loc"] if not _is_tag(part)]
    field = f"{field_name(place)} = {show(first['input'])}"
    match first["type"]:
        case "extra_forbidden":
            return f"{field}: unknown key; " + _known_keys(str(place[-1]), _model(first["loc"][:-1]))
        case "value_error":
            return f"{field}: {first['ctx']['error']}"
        case "literal_error":
            return f"{field}: allowed: {first['ctx']['expected']}"
        case "union_tag_not_found" if place[0] == "roughness":
            given = first["input"].get("shape") if isinstance(first["input"], dict) else None
            said = ": missing" if given is None else f" = {show(given)}"
            return f"{field_name(place)}.shape{said}; allowed: {_list(SHAPES)}"
        case "union_tag_not_found" | "too_short":
            return f"{field}: must be {_SIGNAL_TEXT}"
        case "tuple_type" if place == ["roughness"]:
            return f"{field}: must be an array of tables, [[roughness]]"
        case "missing" | "too_long" | "tuple_type" if POINTS in first["loc"]:
            return f"{field}: must be [T, value]"
        case "missing":
            return f"{field_name(place)}: missing"
        case "model_type" | "model_attributes_type":
            return f"{field}: must be a section, [{place[0]}]"
    return f"{field}: " + first["msg"].replace("Input should be", "must be").replace("valid ", "")


def _is_tag(part: str | int) -> bool:
    return isinstance(part, str) and part.startswith("<") and part.endswith(">")


def field_name(place: Sequence[str | int]) -> str:
    """section.key, an element of an array by its number from 1: roughness[1].amplitude."""
    return "".join(f"[{part + 1}]" if isinstance(part, int) else f".{part}" for part in place).removeprefix(".")


def _model(place: Sequence[str | int]) -> type[BaseModel]:
    """The section at a place in a case file."""
    if not place:
        return CaseFile
    if place[-1] == TABLE:
        return OscillationTable
    if place[0] == "roughness":
        return SHAPES[str(place[2]).strip("<>")]
    section = CaseFile.model_fields[str(place[0])].annotation
    found = next(part for part in (section, *get_args(section)) if isinstance(part, type))
    assert issubclass(found, BaseModel)
    return found


def _known_keys(name: str, model: type[BaseModel]) -> str:
    known = [field.alias or key for key, field in model.model_fields.items()]
    close = get_close_matches(name, known, n=1)
    return (f"did you mean {close[0]}? " if close else "") + f"allowed: {_list(known)}"


def _list(names: Iterable[str]) -> str:
    return ", ".join(names)


def show(value: object) -> str:
    """A value as one would write it in TOML."""
    if isinstance(value, Amount):
        return show(value.plain)
    if isinstance(value, BaseModel):
        return show(plain_data(value))
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{key} = {show(item)}" for key, item in value.items()) + " }"
    if isinstance(value, list | tuple):
        return "[" + ", ".join(show(item) for item in value) + "]"
    return json.dumps(value, default=str, ensure_ascii=False).replace("\x7f", "\\u007f")


# -- the door out -----------------------------------------------------------------------------------------------------


def plain_data(model: BaseModel) -> dict[str, object]:
    """A validated section or file as plain data that reads back as exactly the same: quantities as strings in SI."""
    data: dict[str, object] = {}
    for key, field in type(model).model_fields.items():
        value = getattr(model, key)
        unit = next((mark.unit for mark in field.metadata if isinstance(mark, SI)), None)
        if value is not None and value != ():
            data[field.alias or key] = f"{value!r} {unit}" if unit else _plain(value)
    return data


def _plain(value: object) -> object:
    if isinstance(value, BaseModel):
        return plain_data(value)
    if isinstance(value, Amount):
        return value.plain
    return [_plain(item) for item in value] if isinstance(value, tuple) else value


def to_toml(data: Mapping[str, object]) -> str:
    """Plain data of a case file as TOML."""
    blocks: list[tuple[str, Mapping[str, object]]] = []
    top = {}
    for key, value in data.items():
        if isinstance(value, Mapping):
            blocks.append((f"[{key}]", value))
        elif isinstance(value, list):
            blocks += [(f"[[{key}]]", item) for item in value]
        else:
            top[key] = value
    lines = [f"{key} = {show(value)}" for key, value in top.items()]
    for heading, values in blocks:
        lines += ["", heading, *(f"{key} = {show(value)}" for key, value in values.items())]
    return "\n".join(lines) + "\n"
