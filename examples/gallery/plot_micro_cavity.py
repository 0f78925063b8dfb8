"""
A micro-cavity rolls through
============================

A small dimple in one surface passes through a rolling contact of a steel ball and a glass disc.  Inside the contact
the oil is so viscous that it hardly flows along the film.  The dimple and the film around it are carried through as
they are.
"""

import numpy as np
from matplotlib import pyplot as plt

import ertel

case = ertel.rolling(
    radius="12.5 mm",
    load="15 N",
    mean_speed="0.09 m/s",
    E_prime="110 GPa",
    oil=ertel.Oil(eta0="0.25 Pa*s", alpha="22 / GPa"),
    method="transient",
    nodes=97,
    half_width=2,
    inlet=2.5,
    roughness=[{"shape": "spot", "depth": "175 nm", "radius": "20 um", "x": "-273 um"}],
    until=2.2,
    time_tolerance=5e-4,
    interval=0.55,
)
run = ertel.simulate(case)

# %%
# Five moments; the grey line is the film before the dimple arrives.
data = run.si
figure, axes = plt.subplots(1, 2, figsize=(9, 3.6), layout="constrained", width_ratios=(1.6, 1))
line = data["h"].sel(y=0, method="nearest")
for frame in range(1, data.sizes["frame"]):
    axes[0].plot(1e6 * data["x"], 1e9 * line.isel(frame=frame), label=f"{1e3 * float(data['frame'][frame]):.1f} ms")
axes[0].plot(1e6 * data["x"], 1e9 * line.isel(frame=0), color="grey", linewidth=3, alpha=0.4, zorder=0)
axes[0].set(xlabel="x (µm)", ylabel="film thickness (nm)", xlim=(-200, 180), ylim=(0, 500))
axes[0].legend()
picture = axes[1].pcolormesh(1e6 * data["x"], 1e6 * data["y"], 1e9 * data["h"].isel(frame=-2), vmin=100, vmax=450)
axes[1].set(xlabel="x (µm)", ylabel="y (µm)", aspect="equal", xlim=(-180, 180), ylim=(-180, 180))
figure.colorbar(picture, label="film thickness (nm)")

# %%
# In pure rolling the dimple moves with the surfaces.  At T = 1.65 it is 1.65 a from its start, to within a cell.
expected = -273e-6 / run.dataset["X"].si_factor + 1.65
deepening = (run.dataset["H"] - run.dataset["H"].isel(frame=0)).sel(frame=1.65, Y=0, method="nearest")
inside = deepening.sel(X=slice(-0.6, 0.6)).clip(min=0)
middle = float((inside * inside["X"]).sum() / inside.sum())
spacing = float(np.diff(run.dataset["X"])[0])
assert abs(middle - expected) < spacing
print(f"the dimple is at x = {middle:.3f} a, expected {expected:.3f} a; the cells are {spacing:.3f} a")
