"""
Dropped ball in an impact viscometer
====================================

A steel ball falls on oiled glass.  The oil in the middle cannot escape: its viscosity grows so fast under pressure
that it is trapped.  How thick the trapped film is depends on the product of viscosity and pressure-viscosity
coefficient, so that the ball is a viscometer.  For a rigid ball and Barus' law the film is sqrt(3 alpha eta0 R v0);
the elastic ball keeps a constant share of it, which calibrates the instrument.
"""

import numpy as np
from matplotlib import pyplot as plt

import ertel

OIL = ertel.Oil(eta0="20 mPa*s", alpha="20 / GPa", viscosity="barus", density="incompressible")
HEIGHTS = np.array([1e-3, 4e-3, 16e-3])  # m, from which the ball falls


def drop(height):
    """The impact of a ball of 20 mm diameter that falls from a height (m), until maximum approach."""
    ball = ertel.impact(
        radius="10 mm",
        drop_height=height,
        material_1="steel",
        material_2="glass",
        oil=OIL,
        method="radial",
        nodes=201,
        half_width=3,
        start_approach=-2,
    )
    return ertel.simulate(ball)


# %%
# Three drops.  The central film is that at maximum approach.
impacts = [drop(height) for height in HEIGHTS]
speeds = np.array([impact.case.scales.speed for impact in impacts])
film = np.array([impact.summary["si"]["h_c_m"] for impact in impacts])
rigid = np.sqrt(3 * OIL.alpha * OIL.eta0 * 10e-3 * speeds)

figure, (profiles, calibration) = plt.subplots(1, 2, figsize=(9, 3.6), layout="constrained")
for impact, speed in zip(impacts, speeds, strict=True):
    last = impact.si.isel(frame=-1)
    profiles.plot(1e3 * last["r"], 1e6 * last["h"], label=f"{speed:.2f} m/s")
profiles.set(xlabel="r (mm)", ylabel="film thickness (µm)", xlim=(0, 0.5), ylim=(0, 3))
profiles.legend(title="at touch")
calibration.plot(1e6 * rigid, 1e6 * film, "o")
share = film @ rigid / (rigid @ rigid)
calibration.axline((0, 0), slope=share, color="grey", linestyle="--")
calibration.set(xlabel=r"$(3 \alpha \eta_0 R v_0)^{1/2}$ (µm)", ylabel="central film thickness (µm)")

# %%
# The share is the same for all speeds within three percent: 0.84 to 0.89 for this oil.
assert np.all(np.abs(film / rigid / share - 1) < 0.03)
assert 0.84 < share < 0.89
print(f"the film is {share:.3f} of that under a rigid ball")
