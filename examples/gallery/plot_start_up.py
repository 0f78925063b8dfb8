"""
Bearing ball at start-up
========================

The ball of a bearing starts to roll: its speed trebles while the load stays.  The thick film of the higher speed is
made in the inlet.  It moves through the contact with the mean speed of the surfaces, so that the film in the
centre grows only later.
"""

from matplotlib import pyplot as plt

import ertel

CONTACT = dict(M=50, L=10, nodes=65)  # at full speed

# %%
# The speed in units of its final value: 0.3 until T = 0.5, then a ramp that ends at T = 1.5.
RAMP = [[0, 0.3], [0.5, 0.3], [1.5, 1]]
start = ertel.simulate(
    ertel.rolling(
        method="transient", motion={"entrainment": RAMP}, until=8, interval=0.5, time_tolerance=5e-4, **CONTACT
    )
)
steady = ertel.simulate(ertel.rolling(inlet=4.5, half_width=3, **CONTACT))

data = start.dataset
figure, (history, profiles) = plt.subplots(1, 2, figsize=(9, 3.6), layout="constrained")
history.plot(data["time"], data["U"], color="grey", label="speed / final speed")
history.plot(data["time"], data["H_c"] / steady.summary["H_c"], label="central film / final film")
history.set(xlabel="time / (a/u_m)")
history.legend()
for T in (0.5, 1.5, 2.0, 2.5, 8.0):
    line = data["H"].sel(frame=T, method="nearest").sel(Y=0, method="nearest")
    profiles.plot(data["X"], line, label=f"T = {T}")
profiles.set(xlabel="x / a", ylabel="film thickness / (a²/R)", xlim=(-2, 1.5), ylim=(0, 0.4))
profiles.legend()

# %%
# When all oil of the start has left, the film is the steady one of the final speed.  And it comes late: half of the
# growth is reached at least half a transit time after the speed had half of its own.
change = data["H_c"] / steady.summary["H_c"]
half_speed = float(data["time"][data["U"] > 0.65][0])
half_film = float(data["time"][change > (change[0] + 1) / 2][0])
print(f"final film over steady film: {float(change[-1]):.4f}; the film is late by {half_film - half_speed:.2f} a/u_m")
assert abs(float(change[-1]) - 1) < 0.01
assert half_film - half_speed > 0.5
