"""
Laws of asperities against rough surfaces
=========================================

Random surfaces are pressed together dry, by FFT and conjugate gradients (Polonsky and Keer, Wear 1999;231:206).  The
laws of asperities get the spectrum of the same surfaces, and nothing to fit.
"""

import numpy as np
from matplotlib import pyplot as plt
from numpy.fft import irfft2, rfft2

from ertel.physics.asperities import GreenwoodTripp, Persson

NODES, LONGEST, SHORTEST, HURST = 256, 1 / 4, 1 / 32, 0.8  # of a periodic square with sides 1; E* = 1
q = 2 * np.pi * np.hypot(np.fft.fftfreq(NODES, 1 / NODES)[:, None], np.arange(NODES // 2 + 1))
kernel = np.divide(2.0, q, out=np.zeros_like(q), where=q > 0)
inside = (q >= 2 * np.pi / LONGEST) & (q <= 2 * np.pi / SHORTEST)
spectrum = np.where(inside, np.maximum(q, 1.0) ** (-2 * (1 + HURST)), 0.0)
m2, m4 = (c * (spectrum * q**n).sum() / spectrum.sum() for n, c in ((2, 0.5), (4, 0.375)))  # of a profile


def mean_gap(heights, load):
    """The mean gap under a mean pressure."""
    p, step, last, goes_on = np.full_like(heights, load), 0.0, 1.0, 0.0
    for _ in range(200):
        gap, touches = irfft2(kernel * rfft2(p)) - heights, p > 0
        gap -= gap[touches].mean()
        new = (gap[touches] ** 2).sum()
        step = np.where(touches, gap + goes_on * new / last * step, 0.0)
        rise = irfft2(kernel * rfft2(step))
        length = (gap * step)[touches].sum() / ((rise - rise[touches].mean()) * step)[touches].sum()
        p = np.maximum(p - length * step, 0.0)
        overlap, last = (p == 0) & (gap < 0), new
        p, goes_on = np.where(overlap, -length * gap, p), 0.0 if overlap.any() else 1.0
        p *= load / p.mean()
    return gap.mean()


phases = np.exp(2j * np.pi * np.random.default_rng(1).random(q.shape))
heights = irfft2(np.sqrt(spectrum) * phases, (NODES, NODES))
pressures = np.array([0.01, 0.03, 0.1, 0.2, 0.4]) * np.sqrt(2 * m2)  # over E* times the rms slope
gaps = np.array([mean_gap(heights / heights.std(), p) for p in pressures])

# %%
# Persson's law follows the surfaces.  Greenwood and Tripp's has the density and the radius of the summits that belong
# to this spectrum (Nayak 1971).  It is too soft: summits stand about one sigma above the mean plane.
eta, beta = m4 / m2 / (6 * np.pi * np.sqrt(3)), 3 * np.sqrt(np.pi / m4) / 8
laws = {"Persson": Persson(LONGEST, SHORTEST, HURST), "Greenwood, Tripp": GreenwoodTripp(eta * beta, beta**-0.5)}
figure, axes = plt.subplots(figsize=(6.0, 3.8), layout="constrained")
axes.semilogy(gaps, pressures / np.sqrt(2 * m2), "ko", markersize=4, label="surfaces pressed together")
for name, law in laws.items():
    curve = law.curve(1.0, 1.0)
    axes.semilogy(curve.h, curve.p / np.sqrt(2 * m2), label=name)
    ratio = np.exp(np.interp(gaps, curve.h, np.log(curve.p))) / pressures
    print(name, "over computed:", ratio.round(3))
assert ratio.max() < 0.1  # of Greenwood and Tripp
axes.set(xlabel="mean gap over rms roughness", ylabel=r"pressure over $E^*$ rms slope", xlim=(0, 2.5), ylim=(1e-4, 2))
axes.legend(frameon=False)
plt.show()
