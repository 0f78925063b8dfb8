"""
Waviness in an impact
=====================

The ball is wavy.  Under the pressure of the impact the trapped oil pushes the waves flat.  How much of them is left
depends on the wavelength over the trapped film: short waves survive, long ones are flattened.
"""

import numpy as np
from matplotlib import pyplot as plt

import ertel

WAVELENGTHS = np.array([0.5, 0.8, 1.4])  # a*

# %%
# `ertel.respond_linearly` runs the smooth impact and, in step with it, the change by waves of small height.
case = ertel.impact(M=200, L=10, nodes=129, half_width=2, time_tolerance=5e-4)
waves = [[ertel.Feature(ertel.Waviness(1.0, wavelength, wavelength))] for wavelength in WAVELENGTHS]
response = ertel.respond_linearly(case, waves)

# %%
# The change along the middle at maximum approach, and the amplitude of its innermost wave.
line = response["dH"].sel(Y=0, method="nearest").compute()
left = [float(np.ptp(line.isel(wave=i).sel(X=slice(-w / 2, w / 2)).values)) / 2 for i, w in enumerate(WAVELENGTHS)]
nabla2 = np.array([case.parameters.nabla2(wavelength) for wavelength in WAVELENGTHS])
print(dict(zip(nabla2.round(2).tolist(), np.round(left, 3).tolist(), strict=True)))

figure, axes = plt.subplots(1, 2, figsize=(9, 3.6), layout="constrained")
for i, wavelength in enumerate(WAVELENGTHS):
    axes[0].plot(line["X"], line.isel(wave=i), label=f"{wavelength} a*")
axes[0].set(xlabel="x / a*", ylabel="change of the film / amplitude", xlim=(-1.2, 1.2), ylim=(-1.2, 1.7))
axes[0].legend(title="wavelength", ncols=3, loc="upper center")
curve = np.geomspace(0.5, 20)
axes[1].semilogx(nabla2, left, "o", label="impact, middle")
axes[1].semilogx(curve, ertel.amplitude_reduction.ratio_left(curve), color="grey", label="rolling, eq. (15)")
axes[1].set(xlabel="∇₂", ylabel="amplitude left", ylim=(0, 1))
axes[1].legend()

# %%
# Waves that are short beside the trapped film stay; longer ones are flattened more and more.
assert left[0] > 0.8
assert np.all(np.diff(left) < 0)
