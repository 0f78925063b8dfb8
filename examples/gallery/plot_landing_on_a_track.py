"""
A ball lands on a moving track
==============================

A steel ball falls on a steel track that runs at 4 m/s.  Impact and rolling are one equation, and here they happen at
once: the oil is trapped by the impact and is carried along by the track while the ball is still falling.  (ertel
warns that the traction of this Newtonian oil means nothing; here only the film matters.)
"""

from matplotlib import pyplot as plt

import ertel


def land(track):
    """The impact on a track of a given speed (m/s), until maximum approach."""
    case = ertel.impact(
        radius="10 mm",
        ball_density=7850,
        speed=0.1,
        mean_speed=track / 2,
        slide_to_roll=-2.0,  # the ball does not spin
        E_prime="231 GPa",
        oil=ertel.Oil(eta0="18.6 mPa*s", alpha="20 / GPa"),
        nodes=81,
        half_width=2.5,
        time_tolerance=5e-4,
    )
    return ertel.simulate(case)


# %%
# The same ball on a track at rest and on one that moves to the right.
runs = {track: land(track) for track in (0.0, 4.0)}

figure, axes = plt.subplots(1, 3, figsize=(11, 3.4), layout="constrained")
for panel, (track, run) in zip(axes, runs.items(), strict=False):
    last = run.si.isel(frame=-1)
    picture = panel.pcolormesh(1e6 * last["x"], 1e6 * last["y"], 1e6 * last["h"], vmin=0, vmax=1)
    panel.set(title=f"track at {track:g} m/s", xlabel="x (µm)", ylabel="y (µm)", aspect="equal")
    panel.set(xlim=(-300, 300), ylim=(-300, 300))
    axes[2].plot(1e6 * last["x"], 1e6 * last["h"].sel(y=0, method="nearest"), label=f"{track:g} m/s")
figure.colorbar(picture, ax=axes[1], label="film thickness (µm)")
axes[2].set(xlabel="x (µm)", ylabel="film thickness (µm)", xlim=(-300, 300), ylim=(0, 1.5))
axes[2].legend()

# %%
# The trapped oil moves with the mean speed of the surfaces: its summit has gone the way that they went since first
# touch, up to the size of the cells and the time that trapping takes.
moving = runs[4.0]
data = moving.dataset
summit = data["H"].isel(frame=-1).sel(Y=0, method="nearest").sel(X=slice(-0.8, 0.8)).idxmax("X")
since_touch = float(data["time"][-1] - data["time"][data["Delta"] > 0][0])
share = float(summit) / (float(data["U"][-1]) * since_touch)
print(f"the summit lies at {float(summit):.2f} a*, {share:.2f} of the way of the surfaces")
assert 0.85 < share < 1.15
