"""
A ball on a layer of oil
========================

A steel ball falls on glass: once into a pool of oil, once on a layer of 2 µm.  On the layer the film is thinner, and
the ball keeps more of its speed: only the oil that fills the gap takes energy from it.
"""

from matplotlib import pyplot as plt

import ertel


def fall(**oil):
    """A rebound, on 151 nodes along the radius."""
    ball = ertel.impact(
        radius="10 mm",
        speed="0.3 m/s",
        material_1="steel",
        material_2="glass",
        oil=ertel.oils.at("mineral-100", "40 degC"),
        method="radial",
        nodes=151,
        half_width=4,
        start_approach=-2,
        until="rebound",
        **oil,
    )
    return ertel.simulate(ball)


runs = {"pool": fall(), "layer of 2 µm": fall(layer="2 um")}
figure, axes = plt.subplots(figsize=(5, 3.2), layout="constrained")
for name, run in runs.items():
    data = run.si.isel(frame=int((run.dataset["event"] > 0).argmax()))  # maximum approach
    (line,) = axes.plot(1e6 * data["r"], 1e6 * data["h"], label=f"{name}, e = {run.summary['restitution']:.3f}")
    axes.plot(1e6 * data["r"], 1e6 * data["h_oil"], color=line.get_color(), linestyle=":")
axes.set(xlabel="r (µm)", ylabel="film thickness, dotted: oil (µm)", xlim=(0, 600), ylim=(0, 6))
axes.legend()

# %%
# From above: the oil fills the gap inside the orange line, a circle that is just wider than the picture.
pool, layer = runs.values()
figure = layer.plot.film(at="max-approach")

# %%
# In green light the rings end where the gap is no longer full.  Beyond, the light crosses the layer and then air.
figure = layer.plot.interferogram(at="max-approach")

# %%
# The trapped film follows the curve of starved rolling (Chevalier et al. 1998). r: the oil over that of the pool.
lowest = [run.dataset.isel(time=int(run.dataset["Delta"].argmax())) for run in runs.values()]
trapped = [float(each["H_c"]) * pool.case.scales.film for each in lowest]
r = 2e-6 / (trapped[0] * float(pool.case.lubricant.density(float(lowest[0]["P_c"]))))
reduction = r / (1 + r**2.2) ** (1 / 2.2)
print(f"film on the layer over that in the pool: {trapped[1] / trapped[0]:.3f}, by the curve {reduction:.3f}")
assert abs(trapped[1] / trapped[0] - reduction) < 0.05
assert layer.summary["restitution"] > pool.summary["restitution"] + 0.05
