"""Optical interferometry of a film: what an experimenter sees through coated glass.

    rig = Rig(coatings=(Layer(CHROMIUM, 10e-9), Layer(SILICA, 200e-9)), oil_index=1.45)
    chart = Chart(rig, White(), thickest=2e-6, density=1.25)
    rgb = chart.picture(film, density)                   # film in m and rho/rho0 over the pixels of a picture
    film = film_of_intensity(intensity, rig, 532e-9, start=0.4e-6)   # and back, along a profile

All is in SI.  Light comes at normal incidence.  Where a gap is not full, the oil is a layer on the glass, at ambient
pressure, above a layer of air: streamers and menisci are far wider than a wavelength, so that no mixture of oil and air
has an index.  The layers, their indices and the oil's index are parameters, with sources in `rig`.
"""

from ertel.optics.inverse import DoubtfulFilm, film_of_intensity
from ertel.optics.light import BlackBody, Chart, Daylight, Interferometer, Lamp, Light, Monochromatic, White
from ertel.optics.rig import (
    BK7,
    CHROMIUM,
    SILICA,
    STEEL,
    Constant,
    Fringes,
    JohnsonChristy,
    Layer,
    Medium,
    Rig,
    Sellmeier,
    TwoBeams,
    lorentz_lorenz,
    reflection,
)

__all__ = [
    "BK7", "CHROMIUM", "SILICA", "STEEL", "BlackBody", "Chart", "Constant", "Daylight", "DoubtfulFilm", "Fringes",
    "Interferometer", "JohnsonChristy", "Lamp", "Layer", "Light", "Medium", "Monochromatic", "Rig",
    "Sellmeier", "TwoBeams", "White", "film_of_intensity", "lorentz_lorenz", "reflection",
]  # fmt: skip
