"""
A track that starves
====================

A ball rolls over the same track twenty times, and nothing brings oil back.  Each pass pushes some oil to the ridges
beside the track, so that the next one finds less.  Two tracks with different layers come to the same film.
"""

import numpy as np
from matplotlib import pyplot as plt

import ertel

PASSES = 20


def rolled_over(layer):
    """The runs of all passes: each finds the oil that the one before leaves behind."""
    runs = []
    for _ in range(PASSES):
        ball = ertel.rolling(
            radius="10 mm",
            load="10 N",
            mean_speed="0.2 m/s",
            E_prime="220 GPa",
            oil=ertel.Oil(eta0="40 mPa*s", alpha="22 / GPa"),
            nodes=129,
            layer=layer,
        )
        runs.append(ertel.simulate(ball))
        layer = runs[-1].track
    return runs


tracks = {"60 nm": rolled_over("60 nm"), "120 nm": rolled_over("120 nm")}
figure, (left, right) = plt.subplots(1, 2, figsize=(8, 3.2), layout="constrained")
for name, runs in tracks.items():
    films = [float(run.si["h_c"][-1]) for run in runs]
    left.plot(range(1, PASSES + 1), 1e9 * np.array(films), "o", label=f"layer of {name}")
left.set(xlabel="pass", ylabel="central film thickness (nm)", xticks=(1, 5, 10, 15, 20), ylim=(0, None))
left.legend()
for number in (1, 5, 20):
    behind = tracks["120 nm"][number - 1].si["h_oil"].isel(x=-1)
    right.plot(1e6 * behind["y"], 1e9 * behind, label=f"after pass {number}")
right.set(xlabel="y (µm)", ylabel="oil left on the track (nm)", title="layer of 120 nm")
right.legend()

# %%
# The first pass of the thicker layer, and the last one: the edge of the full film has come to the contact.
figure = tracks["120 nm"][0].plot.film()
figure = tracks["120 nm"][-1].plot.film()

# %%
# No oil is lost: what the track loses is in the ridges.
first, last = (run.si["h_oil"].isel(x=-1).mean().item() for run in (tracks["120 nm"][0], tracks["120 nm"][-1]))
print(f"mean oil behind the first pass {1e9 * first:.4f} nm, behind the last {1e9 * last:.4f} nm")
assert abs(last / first - 1) < 1e-6
assert films[-1] < 0.6 * films[0]
