"""
Oscillating speed and load
==========================

The speed of a contact oscillates by a half, or its load by a fifth.  The speed changes the film in the inlet; the
change is carried to the centre with the mean speed of the surfaces.  The load changes the size of the contact and
lets the film breathe.
"""

import numpy as np
from matplotlib import pyplot as plt

import ertel

PERIOD = 4.0  # in a/u_m


def oscillate(**signal):
    """A rolling contact whose speed or load oscillates, over two periods."""
    motion = {name: {"mean": 1, "amplitude": size, "period": PERIOD} for name, size in signal.items()}
    case = ertel.rolling(
        M=50, L=10, nodes=65, method="transient", motion=motion, until=2 * PERIOD, time_tolerance=5e-4, interval=PERIOD
    )
    return ertel.simulate(case)


# %%
# The first period begins with the steady film and is not yet periodic; the second one nearly is.
runs = {"speed": oscillate(entrainment=0.5), "load": oscillate(load=0.2)}

figure, axes = plt.subplots(1, 2, figsize=(9, 3.6), sharey=True, layout="constrained")
for panel, (name, run) in zip(axes, runs.items(), strict=True):
    data = run.dataset
    drive = data["U"] if name == "speed" else data["w"]
    panel.plot(data["time"], drive, color="grey", label=name)
    panel.plot(data["time"], data["H_c"] / data["H_c"][0], label="central film")
    panel.plot(data["time"], data["H_min"] / data["H_min"][0], label="minimum film")
    panel.set(xlabel="time / (a/u_m)", title=f"oscillating {name}")
    panel.legend()
axes[0].set_ylabel("relative to the steady contact")


# %%
# The phase of the film in the second period tells how late it is.
def late(run, name):
    data = run.dataset.interp(time=np.linspace(PERIOD, 2 * PERIOD, 200, endpoint=False))
    first = np.exp(-2j * np.pi * data["time"].values / PERIOD)
    return -np.angle((data["H_c"].values @ first) / (data[name].values @ first)) * PERIOD / (2 * np.pi)


delay = late(runs["speed"], "U")
print(f"the film follows the speed {delay:.2f} a/u_m later")
assert 0.7 < delay < 1.3  # the way from the inlet at x = -a to the centre takes one a/u_m
assert max(budget["imbalance"] for budget in runs["speed"].summary["budgets"].values()) < 0.02
