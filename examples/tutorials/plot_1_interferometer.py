"""
A rig with an interferometer
============================

You have a ball-on-disk rig: a steel ball of 19 mm rolls on a glass disk, and a camera sees the oil between them
through the glass.  In this lesson you compute what the camera should see, take the film out of a picture, and put it
beside the computed film.  At the end you know which errors matter.

There is no camera here.  The "measured" picture is made by the program itself, with a secret, and with noise.
"""

from pathlib import Path
from tempfile import mkdtemp

import numpy as np
from matplotlib import pyplot as plt

import ertel
from ertel import optics

# %%
# The rig
# -------
# First the light and the layers.  This rig has a laser, 10 nm of chromium on the glass, and a mineral oil whose index
# was measured at ambient pressure.  A spacer layer of silica would be one more ``Layer`` in ``coatings``.
GREEN = optics.Monochromatic(532e-9, coherence=np.inf)
CHROMIUM = optics.Layer(optics.CHROMIUM, 10e-9)
RIG = optics.Rig(coatings=(CHROMIUM,), oil_index=1.48)

# %%
# From a film thickness follows how bright it is.  Two beams alone, one from the chromium and one from the ball, would
# give a cosine (grey).  The light that goes through the film more than once makes the bright fringes broad and the
# dark ones narrow, and it moves them.  ertel uses all beams.
film = np.linspace(0, 600e-9, 601)
simple = optics.TwoBeams(coatings=(CHROMIUM,), oil_index=1.48)
figure, axes = plt.subplots(figsize=(6, 3), layout="constrained")
for name, rig, color in (("two beams", simple, "grey"), ("all beams", RIG, "tab:green")):
    axes.plot(1e9 * film, rig.fringes(GREEN.wavelength, RIG.oil_index).reflectance(1.48 * film), color, label=name)
axes.set(xlabel="film thickness (nm)", ylabel="reflected share of the light", ylim=(0, None))
axes.legend(loc="lower right")

# %%
# The contact
# -----------
# The disk and the ball run at 0.78 m/s.  129 nodes a side give the film to a percent or two in a few seconds; the
# result tells its own error.


def contact(speed):
    """The ball on the disk at a mean speed (m/s)."""
    return ertel.rolling(
        radius="9.5 mm",
        load="20 N",
        mean_speed=speed,
        material_1="steel",
        material_2="glass",
        oil="mineral-100",
        temperature="40 degC",
        nodes=129,
        tolerance=0.03,
    )


computed = ertel.simulate(contact(0.78))
print(computed.verdict)

# %%
# This is what the camera should see.  In the middle the film is flat.  The bright horseshoe is where it is thinner.
# Right of the line the oil does not fill the gap, and the light crosses oil and then air.
figure = computed.plot.interferogram(light=GREEN, rig=RIG)

# %%
# The "measurement"
# -----------------
# Now the picture of the camera, which you would read from a file.  The secret of this one: the disk runs 3 % faster
# than its display says.  A pixel is 1 µm wide, a camera counts up to 4095, and its noise is 10 counts.
PIXELS = np.arange(-190, 191) * 1e-6  # m


def camera(result, noise):
    """Counts of the pixels, (y, x)."""
    pixels = result.si[["h", "p", "h_oil"]].interp(x=PIXELS, y=PIXELS, method="cubic").transpose("y", "x", ...)
    h, case = pixels["h"].values, result.case
    density = np.asarray(case.lubricant.density(np.maximum(pixels["p"].values, 0) / case.scales.p_h))
    void = np.where(h - pixels["h_oil"].values > 1e-9, h - pixels["h_oil"].values, 0)  # air below the oil
    light = optics.Chart(RIG, GREEN, h.max(), density.max()).linear(h, density, void=void)
    return 6000 * light[..., 0] + noise * np.random.default_rng(1).standard_normal(h.shape)


truth = ertel.simulate(contact(0.78 * 1.03))
picture = camera(truth, noise=10)

figure, panels = plt.subplots(1, 2, figsize=(8, 4), sharey=True, layout="constrained")
for axes, name, counts in zip(panels, ("computed", '"measured"'), (camera(computed, 0), picture), strict=True):
    axes.imshow(counts, extent=(-190, 190, -190, 190), origin="lower", cmap="gray")
    axes.set(title=name, xlabel="x (µm)")
panels[0].set_ylabel("y (µm)")

# %%
# From fringes to the film
# ------------------------
# The intensity along the middle is a film again, if three things are known: how bright the darkest and the brightest
# fringe are, the index of the oil, and the film at one point.
#
# The first comes from the picture itself, from the many fringes around the contact.  The index grows as the oil is
# compressed; the pressure is nearly that of a dry contact.  And the formula of Nijenbanning, Venner and Moes is good
# enough for the film in the middle: it need only be known to an eighth of wavelength/index, 45 nm.  If it is not, a
# picture in white light or one while the disk speeds up tells it.
case = computed.case
distance = np.hypot(PIXELS, PIXELS[:, None])
limits = tuple(np.percentile(picture[(distance > 145e-6) & (PIXELS < 0)], [1, 99]))
pressure = np.sqrt(np.maximum(1 - (PIXELS / case.scales.a) ** 2, 0))  # over the maximum pressure
density = np.asarray(case.lubricant.density(pressure))
start = case.film_scale * case.scales.film
print(f"counts from {limits[0]:.0f} to {limits[1]:.0f}, film by the formula {1e9 * start:.0f} nm")


def film_along(row, start, density, rig=RIG):
    """The film (m) along the middle, from the centre to the left and to the right."""
    middle = len(row) // 2
    ways = (slice(middle, None, -1), slice(middle, None))
    left, right = (
        optics.film_of_intensity(row[way], rig, GREEN.wavelength, start, density=density[way], limits=limits)
        for way in ways
    )
    return np.concatenate([left[:0:-1], right])


# %%
# The profile ends at 120 µm on both sides: on the right, a little further, the oil does not fill the gap any more.
inside = np.abs(PIXELS) < 120.5e-6
x, row = PIXELS[inside], picture[188:193, inside].mean(axis=0)  # five rows
measured = film_along(row, start, density[inside])

# %%
# Beside the computed film
# ------------------------
# A measured profile is a file with units in its header.  ``compare`` puts it beside the run.
file = Path(mkdtemp()) / "profile.csv"
np.savetxt(file, np.transpose([1e6 * x, 1e9 * measured]), delimiter=",", header="x_um,h_nm", comments="")
compared = computed.compare(ertel.Measurement.read(file, sigma="2 nm"))
print(compared)
figure = computed.plot.measured(compared)

# %%
# The measured film is thicker, by nearly the same share everywhere in the flat middle.  A film grows with the speed
# to the power 0.67, so the disk must be faster than its display says.  That finds the secret.
flat = np.abs(x) < 80e-6
share = np.mean(compared.measured[flat] / compared.computed[flat])
faster = share ** (1 / 0.67)
print(f"film thicker by {share - 1:.1%}, disk faster by {faster - 1:.1%}")
assert abs(faster - 1.03) < 0.005

# %%
# What is the error?
# ------------------
# Here, and only here, the true film is known.  Each of the usual mistakes can be made on purpose.  Where another film
# is nearly as likely, ``film_of_intensity`` warns.
true = truth.si["h"].interp(x=x, y=0, method="cubic").values
wrong = {
    "as above": measured,
    "the oil's index is that at ambient pressure": film_along(row, start, np.ones_like(x)),
    "a cosine in place of all beams": film_along(row, start, density[inside], simple),
    "the next fringe": film_along(row, start + 532e-9 / (2 * 1.576), density[inside]),
}
errors = {name: 1e9 * np.mean((film - true)[flat]) for name, film in wrong.items()}
for name, error in errors.items():
    print(f"{error:+6.1f} nm  {name}")

# %%
# The noise of the camera hardly counts.  The index does, and it must be that of the compressed oil; so do all beams,
# when the film is thin.  A wrong order is so large that it is seen at once.  What remains is the error of the grid,
# which the computed film tells itself, and the numbers of the oil: its alpha is seldom known to better than 10 %, and
# the film goes with about its square root.
assert abs(errors["as above"]) < 1
assert errors["the oil's index is that at ambient pressure"] > 10
assert errors["the next fringe"] > 150

# %%
# To let ertel find alpha or the viscosity from such profiles, see `An impact as a viscometer
# <../howto/impact_viscometer.html>`_.
