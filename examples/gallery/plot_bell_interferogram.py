"""
The bell: interferogram of an impact
====================================

An experimenter sees the trapped oil through the glass as rings: the "bell".  The rings are contours of the film.
Counting them gives its height without a computation.
"""

import numpy as np

import ertel
from ertel import optics

RIG = optics.Rig(oil_index=1.48)  # glass with a thin layer of chromium, oil, steel
GREEN = optics.Monochromatic(532e-9, coherence=np.inf)  # a laser

ball = ertel.impact(
    radius="10 mm",
    speed=0.05,
    material_1="steel",
    material_2="glass",
    oil=ertel.oils.at("mineral-100", "40 degC"),
    method="radial",
    nodes=151,
    half_width=4,
    start_approach=-2,
)
result = ertel.simulate(ball)
figure = result.plot.interferogram(light=GREEN, rig=RIG)

# %%
# The way back: from the intensity in green light along a radius to the film.  The index of the oil follows its
# density, which is known from the computed pressure; an experimenter estimates it.
a = result.case.scales.a
last = result.si.isel(frame=-1).interp(r=np.linspace(0.15 * a, 1.2 * a, 400), method="cubic")
film, density = last["h"].values, result.case.lubricant.density(last["p"].values / result.case.scales.p_h)
index = RIG.index(density)
intensity = RIG.fringes(GREEN.wavelength, index).reflectance(index * film)
seen = optics.film_of_intensity(intensity, RIG, GREEN.wavelength, start=1.02 * film[0], density=density)

# %%
# Both films agree to a nanometre at the thinnest place.
assert abs(seen.min() - film.min()) < 1e-9
print(f"thinnest film: {film.min() * 1e9:.1f} nm computed, {seen.min() * 1e9:.1f} nm from the fringes")
