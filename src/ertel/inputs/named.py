"""The keys that name an oil, a material or a file; `inputs.names` and `inputs.height_maps` replace them by numbers."""

from dataclasses import dataclass
from typing import Annotated, Literal

from ertel.physics.units import (
    COMPLIANCE,
    DENSITY,
    EXPANSION,
    KINEMATIC_VISCOSITY,
    TEMPERATURE,
    Meaning,
)


@dataclass(frozen=True)
class Materials:
    """The materials of both bodies, in [contact]."""

    material_1: Annotated[
        str | None, Meaning("material of body 1, in an impact the ball; ertel oils lists the names", "steel")
    ] = None
    material_2: Annotated[str | None, Meaning("material of body 2", "glass")] = None


@dataclass(frozen=True)
class DataSheet:
    """An oil by its data sheet, in [lubricant]."""

    nu40: Annotated[float, KINEMATIC_VISCOSITY, Meaning("kinematic viscosity at 40 degC")]
    nu100: Annotated[float, KINEMATIC_VISCOSITY, Meaning("kinematic viscosity at 100 degC", "8.7 mm^2/s")]
    density: Annotated[float, DENSITY, Meaning("density at 15 degC", "880 kg/m^3")]
    expansion: Annotated[float | None, EXPANSION, Meaning("thermal expansion coefficient")] = None
    alpha: Annotated[float | None, COMPLIANCE, Meaning("pressure-viscosity coefficient, at all temperatures")] = None
    reference: Annotated[str, Meaning("source of the data", "data sheet of the oil")] = ""


@dataclass(frozen=True)
class NamedLubricant:
    """An oil by its name or its data sheet, in [lubricant]; keys that are given as well win over its data."""

    oil: Annotated[
        str | DataSheet | None,
        Meaning("name of an oil, ertel oils lists them, or a table with its data sheet", "squalane"),
    ] = None
    temperature: Annotated[float | None, TEMPERATURE, Meaning("temperature of the inlet; goes with oil")] = None


@dataclass(frozen=True)
class MeasuredFile:
    """How the file of a measured map is read, in [[roughness]]."""

    channel: Annotated[
        str | None, Meaning("which of the channels of the file; left out: its first one with heights", "Height")
    ] = None
    unit: Annotated[str | None, Meaning("unit of lengths and heights of a file that does not say it", "um")] = None
    detrend: Annotated[
        Literal["plane", "curvature", "mean", "none"] | None,
        Meaning("what is taken off the heights as the form of the body; left out: plane", "curvature"),
    ] = None
