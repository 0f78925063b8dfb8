"""
Waves frozen into the film
==========================

Where the pressure is high the oil is so viscous that the film keeps its shape.  Only the boundary layer at the front of
an impact, or in the inlet of a rolling contact, forms it.  Pictures of the film along the middle (across) through time
(upwards) show this for both.
"""

import numpy as np

import ertel

# %%
# A ball with rings falls on the oil.  The dashed line is the edge of the dry contact.  Inside, the rings of the film
# stand upright: they do not change any more.
rings = ertel.Feature(ertel.RingWaviness(amplitude=0.03, wavelength=0.5))
impact = ertel.impact(M=200, L=10, nodes=161, half_width=2, roughness=[rings], interval=0.02)
fallen = ertel.simulate(impact)
figure = fallen.plot.spacetime()

# %%
# A wavy ball rolls into its contact and slides there; it is the faster surface.  The waves of the film do not go with
# those of the ball: they move with the mean speed of the surfaces, beside the dotted lines.
waves = ertel.Feature(ertel.Waviness(0.05, 0.75, front=-1.5, ramp=0.5), surface=1)
rolling = ertel.rolling(
    M=60,
    L=6,
    nodes=129,
    method="transient",
    motion={"slide_to_roll": 0.5},
    roughness=[waves],
    interval=0.04,
    until=2.5,
)
rolled = ertel.simulate(rolling)
figure = rolled.plot.spacetime()

# %%
# In numbers: how much the film of the impact changes in the last half of t0, inside and at the edge.
film = fallen.dataset["H"].sel(Y=0, method="nearest")
last = film["frame"] > float(film["frame"][-1]) - 0.5
change = np.abs(film[last][-1] - film[last][0]).compute() / float(film[last][-1].sel(X=0, method="nearest"))
inside, edge = (float(change.sel(X=slice(*place)).max()) for place in ((0.0, 0.4), (0.8, 0.9)))
print(f"inside {inside:.1%}, at the edge {edge:.0%} of the film in the middle")
assert inside < 0.1 < edge
