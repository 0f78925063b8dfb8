"""
From boundary friction to a full film
=====================================

A steel ball rolls and slides on a ground steel disc.  At 1 mm/s its asperities carry the load, at 5 m/s the oil does.
In between both share it: the Stribeck curve.
"""

from matplotlib import pyplot as plt

import ertel

ball = ertel.rolling(
    radius="10 mm",
    load="38.9 N",
    mean_speed="0.5 m/s",
    slide_to_roll=0.1,
    E1="200 GPa",
    nu1=0.3,
    E2="200 GPa",
    nu2=0.3,
    oil=ertel.Oil(eta0="40 mPa*s", alpha="22 / GPa"),
    rheology={"law": "ree-eyring", "tau0": "5 MPa"},
    surfaces={"sigma": "100 nm", "asperities": {"law": "persson", "longest": "50 um", "shortest": "1 um"}},
    nodes=65,
    name="ground ball",
)
curve = ertel.stribeck(ball, "0.001:5:13").dataset
share = curve["asperity_share"].values
assert share[0] > 0.99 and share[-1] < 0.01

# %%
# Friction has a part of the asperities and a part of the oil; the film is shown over the roughness.
figure, (left, right) = plt.subplots(1, 2, figsize=(9.0, 3.6), layout="constrained")
speed = curve["mean_speed"]
left.semilogx(speed, curve["mu_sliding"], "o-", color="black", markersize=3.5, label="traction coefficient")
left.semilogx(speed, curve["mu_boundary"], color="#D55E00", label="asperities")
left.semilogx(speed, curve["mu_oil"], color="#0072B2", label="oil")
left.set(xlabel="mean speed (m/s)", ylabel="friction coefficient", ylim=(0.0, None))
left.legend(frameon=False)
right.semilogx(speed, curve["asperity_share"], "o-", color="#D55E00", markersize=3.5)
right.set(xlabel="mean speed (m/s)", ylabel="share of the load on asperities", ylim=(0.0, 1.02))
film = right.twinx()
film.loglog(speed, curve["Lambda"], color="#0072B2")
film.set_yticks([0.25, 0.5, 1, 2, 4], ["0.25", "0.5", "1", "2", "4"])
film.minorticks_off()
film.set_ylabel("minimum film over roughness", color="#0072B2")
left.figure.suptitle("A ground steel ball, 0.97 GPa, rms roughness 100 nm")

# %%
# At 0.5 m/s the hills touch most in the side lobes and at the outlet, where the film is thinnest.
plt.show()
touching = ertel.simulate(ball).plot.asperities()
