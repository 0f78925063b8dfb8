"""Optical rigs as users write them on the command line and in the file of a fit.

    light = "mono"                              # or "two-beam", "white"
    wavelength = "532 nm"
    coatings = "chromium 8 nm, silica 200 nm"   # on the glass, from the glass to the oil
    index = 1.48                                # of the oil at ambient pressure

What is left out is as in `optics.Rig`.  Other glass, surfaces and lamps are for Python: `optics.Interferometer`.
"""

from collections.abc import Mapping

from ertel.case.reading import hint_for
from ertel.inputs.quantities import parse_quantity
from ertel.optics import CHROMIUM, SILICA, Interferometer, Layer, Light, Medium, Monochromatic, Rig, TwoBeams, White
from ertel.optics.light import GREEN
from ertel.optics.rig import COATINGS, OIL_INDEX
from ertel.physics.units import Unit

KEYS = ("light", "wavelength", "coatings", "index")
LIGHTS: Mapping[str, type[Rig]] = {"mono": Rig, "two-beam": TwoBeams, "white": Rig}
MEDIA: Mapping[str, Medium] = {"chromium": CHROMIUM, "silica": SILICA}
LENGTH = Unit("m", "532 nm")


def interferometer(
    light: str = "mono", wavelength: str | None = None, coatings: str | None = None, index: float | None = None
) -> Interferometer:
    """The rig and the light that a user describes.

    Parameters
    ----------
    light : "mono", "two-beam" or "white"
        Of one wavelength, the same without the light that crosses the film more than once, or daylight.
    wavelength : str, optional
        With a unit; default 532 nm.
    coatings : str, optional
        Media with their thicknesses, from the glass to the oil, or "none"; default "chromium 8 nm".
    index : float, optional
        Of the oil at ambient pressure.

    Returns
    -------
    Interferometer

    Raises
    ------
    ValueError
        A value is not allowed; the message names it.
    """
    if light not in LIGHTS:
        raise ValueError(f"light = {light!r}: {hint_for(light, tuple(LIGHTS))}")
    if light == "white" and wavelength:
        raise ValueError(f"wavelength = {wavelength!r}: white light has none; leave it out")
    lamp: Light = White() if light == "white" else Monochromatic(_length("wavelength", wavelength or f"{GREEN} m"))
    parts = [] if coatings == "none" else [each.split(maxsplit=1) for each in (coatings or "").split(",")]
    layers = tuple(_layer(*part) for part in parts) if coatings else COATINGS
    return Interferometer(LIGHTS[light](coatings=layers, oil_index=index or OIL_INDEX), lamp)


def _layer(medium: str = "", thickness: str = "") -> Layer:
    if medium not in MEDIA:
        raise ValueError(f"coatings = {medium!r}: {hint_for(medium, tuple(MEDIA))}, each with its thickness")
    return Layer(MEDIA[medium], _length("coatings", thickness))


def _length(name: str, written: str) -> float:
    try:
        return parse_quantity(written, LENGTH)
    except ValueError as error:
        raise ValueError(f"{name} = {written!r}: {error}") from error
