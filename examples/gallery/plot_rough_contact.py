"""
A rough ball rolls
==================

The ball has a random, self-affine surface, as grinding leaves it, and is held while the smooth disc runs.  Where the
oil passes over a summit the pressure rises, and flattens it.
"""

import numpy as np
from matplotlib import pyplot as plt

import ertel

# %%
# The roughness is at rest, so that the contact is steady.  Its shortest waves have 16 cells of the grid.
roughness = ertel.SelfAffine(rms=0.02, hurst=0.8, shortest=0.75, longest=2.0, seed=3)
contact = dict(M=50, L=5, nodes=129, tolerance=0.03, motion={"slide_to_roll": -2})
smooth = ertel.simulate(ertel.rolling(**contact)).dataset
rough = ertel.simulate(ertel.rolling(roughness=[ertel.Feature(roughness, surface=1)], **contact)).dataset

figure, axes = plt.subplots(1, 3, figsize=(11, 3.4), layout="constrained")
undeformed = roughness.heights(*np.meshgrid(rough["X"], rough["Y"]))
maps = {"roughness before": undeformed, "film thickness": rough["H"], "pressure": rough["P"]}
for panel, (name, values) in zip(axes, maps.items(), strict=True):
    bottom, top = {"roughness before": (-0.06, 0.06), "film thickness": (0, 0.3)}.get(name, (0, None))
    picture = panel.pcolormesh(rough["X"], rough["Y"], values, vmin=bottom, vmax=top)
    panel.set(title=name, xlabel="x / a", ylabel="y / a", aspect="equal", xlim=(-1.7, 1.5), ylim=(-1.6, 1.6))
    figure.colorbar(picture, ax=panel, shrink=0.8)

# %%
# The load is the same: what the summits carry more, the valleys carry less.  And the film is flatter than the surface.
inside = np.hypot(rough["X"], rough["Y"]) < 0.6
before = np.std(undeformed[inside.transpose("Y", "X").values])
after = float((rough["H"] - smooth["H"]).where(inside).std())
print(f"in the middle {after / before:.2f} of the roughness are left")
assert np.allclose([float(data["load"][-1]) for data in (smooth, rough)], 2 * np.pi / 3, rtol=1e-3)
assert after < before / 2
