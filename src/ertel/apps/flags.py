"""The keys of [contact], and two of [lubricant], as flags of a command, with their meanings."""

import inspect
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ertel.case.conditions import Conditions
from ertel.physics.lubricant import Oil
from ertel.physics.units import Unit, marks, meanings

if TYPE_CHECKING:
    from ertel.case.case import Case

OF_THE_OIL = ("eta0", "alpha")
MEANINGS = {**meanings(Conditions), **{name: meanings(Oil)[name] for name in OF_THE_OIL}}
QUANTITIES = {name for record in (Conditions, Oil) for name, mark in marks(record).items() if isinstance(mark, Unit)}


def with_flags(command: Callable[..., None]) -> Callable[..., None]:
    """A command with a flag for each key before its own options; its first argument contains those that were given."""

    def taking_flags(**values: Any) -> None:
        given = {name: values.pop(name) for name in MEANINGS}
        command({name: value for name, value in given.items() if value is not None}, **values)

    parameters = [
        inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, default=None, annotation=_flag(name))
        for name in MEANINGS
    ]
    own = list(inspect.signature(command).parameters.values())[1:]
    parameters += [parameter.replace(kind=inspect.Parameter.KEYWORD_ONLY) for parameter in own]
    taking_flags.__signature__ = inspect.Signature(parameters)  # type: ignore[attr-defined]
    taking_flags.__annotations__ = {p.name: p.annotation for p in parameters}
    taking_flags.__name__, taking_flags.__doc__ = command.__name__, command.__doc__
    return taking_flags


def flag_of(name: str) -> str:
    """The flag for a key: --slide-to-roll for slide_to_roll."""
    return f"--{name.replace('_', '-')}"


def _flag(name: str) -> Any:
    is_text = name == "kind" or name in QUANTITIES
    kind = str if is_text else float
    metavar = "impact|rolling" if name == "kind" else "QUANTITY" if is_text else "NUMBER"
    text = MEANINGS[name].text
    help_ = f"{text[0].upper()}{text[1:]}."
    return Annotated[kind | None, typer.Option(flag_of(name), show_default=False, metavar=metavar, help=help_)]


def case_of_flags(given: Mapping[str, object]) -> "Case":
    """The case that flags describe, with a Barus oil of constant density.  Raises ValueError as case files do."""
    from ertel.inputs.case_files import parse_case

    contact = dict(given)
    oil: dict[str, object] = {key: contact.pop(key) for key in OF_THE_OIL if key in contact}
    isoviscous = 0 in (given.get("L"), given.get("alpha_bar"))
    oil |= {"viscosity": "isoviscous" if isoviscous else "barus", "density": "incompressible"}
    return parse_case({"contact": contact, "lubricant": oil})
