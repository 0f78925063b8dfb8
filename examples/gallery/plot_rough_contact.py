"""
A rough ball rolls
==================

The ball has a rough surface, here a sum of waves with random phases whose heights fall with the wavelength.  The disc
is smooth.  Where the oil has to pass over a summit the film is thin; the pressure rises there and flattens the
summit.
"""

import numpy as np
from matplotlib import pyplot as plt

import ertel

RANDOM = np.random.default_rng(seed=1)
WAVELENGTHS = np.array([2.0, 1.5, 1.1, 0.8])  # a
RMS = 0.02  # a^2/R, of the whole surface

# %%
# The roughness is at rest, so that the contact is steady: the smooth disc runs, the rough ball slides on it.
amplitudes = WAVELENGTHS / np.sqrt((WAVELENGTHS**2 / 4).sum()) * RMS  # a product of two cosines has the variance 1/4
waves = [
    ertel.Feature(ertel.Waviness(A, L, L, *RANDOM.uniform(0, 2 * np.pi, 2)), surface=1)
    for A, L in zip(amplitudes, WAVELENGTHS, strict=True)
]
contact = dict(M=50, L=5, nodes=129, tolerance=0.03, motion={"slide_to_roll": -2})
smooth = ertel.simulate(ertel.rolling(**contact)).dataset
rough = ertel.simulate(ertel.rolling(roughness=waves, **contact)).dataset

figure, axes = plt.subplots(1, 3, figsize=(11, 3.4), layout="constrained")
for panel, name, label in ((axes[0], "H", "film thickness / (a²/R)"), (axes[1], "P", "pressure / p_h")):
    top = 0.3 if name == "H" else None
    picture = panel.pcolormesh(rough["X"], rough["Y"], rough[name], vmin=0, vmax=top)
    panel.set(xlabel="x / a", ylabel="y / a", aspect="equal", xlim=(-1.7, 1.5), ylim=(-1.6, 1.6))
    figure.colorbar(picture, ax=panel, label=label, shrink=0.8)
for data, name in ((smooth, "smooth"), (rough, "rough")):
    axes[2].plot(data["X"], data["P"].sel(Y=0, method="nearest"), label=f"pressure, {name}")
axes[2].set(xlabel="x / a", xlim=(-1.7, 1.5))
axes[2].legend()

# %%
# The load is the same: the pressures on the summits are taken from the valleys.
load = [float(data["load"][-1]) for data in (smooth, rough)]
assert np.allclose(load, 2 * np.pi / 3, rtol=1e-3)
