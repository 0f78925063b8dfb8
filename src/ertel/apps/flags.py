"""The keys of [contact], and two of [lubricant], as flags of a command."""

import inspect
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Annotated, Any

import typer

if TYPE_CHECKING:
    from ertel.model.case import Case

NUMBERS = ("M", "L", "lambda_bar", "alpha_bar", "radius_ratio", "slide_to_roll", "nu1", "nu2")
FLAGS = {
    "kind": "kind of contact; default impact",
    "M": "load parameter of Moes",
    "L": "lubricant parameter of Moes",
    "lambda_bar": "dimensionless viscosity",
    "alpha_bar": "dimensionless pressure-viscosity index",
    "radius_ratio": "R_x/R_y of a dimensionless elliptical contact",
    "radius": "reduced radius of curvature",
    "radius_1": "radius of body 1",
    "radius_2": "radius of body 2",
    "radius_x": "reduced radius along the axis x of an elliptical contact",
    "radius_y": "reduced radius along the axis y",
    "radius_x_1": "radius of body 1 along x; negative: concave, left out: plane",
    "radius_y_1": "radius of body 1 along y",
    "radius_x_2": "radius of body 2 along x",
    "radius_y_2": "radius of body 2 along y",
    "entrainment_angle": "angle from the axis x to the entrainment, such as 30 deg",
    "mass": "mass of the ball (impact)",
    "ball_density": "density of the ball (impact)",
    "speed": "impact speed (impact)",
    "drop_height": "height of fall (impact)",
    "load": "load (rolling)",
    "speed_1": "speed of surface 1 (rolling)",
    "speed_2": "speed of surface 2 (rolling)",
    "mean_speed": "mean of the surface speeds (rolling)",
    "slide_to_roll": "slide-to-roll ratio (rolling)",
    "E_prime": "reduced elastic modulus E'",
    "E1": "elastic modulus of body 1",
    "nu1": "Poisson ratio of body 1",
    "E2": "elastic modulus of body 2",
    "nu2": "Poisson ratio of body 2",
    "eta0": "viscosity at ambient pressure",
    "alpha": "pressure-viscosity index",
}


def with_flags(command: Callable[..., None]) -> Callable[..., None]:
    """A command with FLAGS before its own options; its first argument contains the flags that were given."""

    def taking_flags(**values: Any) -> None:
        given = {name: values.pop(name) for name in FLAGS}
        command({name: value for name, value in given.items() if value is not None}, **values)

    parameters = [
        inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, default=None, annotation=_flag(name)) for name in FLAGS
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
    kind = float if name in NUMBERS else str
    metavar = "impact|rolling" if name == "kind" else "NUMBER" if name in NUMBERS else "QUANTITY"
    help_ = FLAGS[name][0].upper() + FLAGS[name][1:] + "."
    return Annotated[kind | None, typer.Option(flag_of(name), show_default=False, metavar=metavar, help=help_)]


def case_of_flags(given: Mapping[str, object]) -> "Case":
    """The case that flags describe, with a Barus oil of constant density.  Raises ValueError as case files do."""
    from ertel.inputs.case_files import parse_case

    contact = dict(given)
    oil: dict[str, object] = {key: contact.pop(key) for key in ("eta0", "alpha") if key in contact}
    isoviscous = 0 in (given.get("L"), given.get("alpha_bar"))
    oil |= {"viscosity": "isoviscous" if isoviscous else "barus", "density": "incompressible"}
    return parse_case({"contact": contact, "lubricant": oil})
