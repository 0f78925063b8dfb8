"""A steel ball falls on an oiled glass plate, as a camera sees it through the glass: the "bell" in the oil.

python examples/interferogram.py

The oil cannot escape in time.  The trapped film is thick in the middle, and its fringes are rings.  The script draws
them in green light and in white light, and finds the film in the intensity along the middle again, as an experimenter
would.
"""

import numpy as np

import ertel
from ertel import optics

GREEN = optics.Monochromatic(532e-9, coherence=np.inf)  # a laser
RIG = optics.Rig(oil_index=1.48)  # glass with 8 nm of chromium, oil, steel


def impact(nodes: int = 201) -> ertel.Result:
    """The ball until maximum approach, on a grid along the radius."""
    ball = ertel.impact(
        radius="10 mm",
        speed=0.05,  # m/s
        material_1="steel",
        material_2="glass",
        oil=ertel.oils.at("mineral-100", "40 degC"),
        method="radial",
        nodes=nodes,
        half_width=4,
        start_approach=-2,
    )
    return ertel.simulate(ball)


def films(result: ertel.Result) -> tuple[np.ndarray, np.ndarray]:
    """The film from near the centre outwards (m): as computed, and as it follows from the fringes."""
    a = result.case.scales.a
    last = result.si.isel(frame=-1).interp(r=np.linspace(0.15 * a, 1.2 * a, 400), method="cubic")
    film, density = last["h"].values, result.case.lubricant.density(last["p"].values / result.case.scales.p_h)
    n = RIG.index(density)
    intensity = RIG.fringes(GREEN.wavelength, n).reflectance(n * film)
    return film, optics.film_of_intensity(intensity, RIG, GREEN.wavelength, start=1.02 * film[0], density=density)


if __name__ == "__main__":
    result = impact()
    for name, light in {"green": GREEN, "white": optics.White()}.items():
        result.plot.interferogram(light=light, rig=RIG).savefig(f"interferogram-{name}.png")
    computed, seen = films(result)
    print(f"thinnest film: computed {computed.min() * 1e9:.2f} nm, from the fringes {seen.min() * 1e9:.2f} nm")
