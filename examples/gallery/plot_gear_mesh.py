"""
A pair of teeth and a cam
=========================

Two teeth touch along a line whose radii, speeds and load change while it moves along the path of contact.
`ertel.gears` makes these signals from what the drawing says; the rest is one line contact in time.
"""

import matplotlib.pyplot as plt
import numpy as np

import ertel

THINNING = {"law": "ree-eyring", "tau0": "5 MPa"}
OIL = {"oil": ertel.Oil(eta0="40 mPa*s", alpha="20 / GPa"), "rheology": THINNING}
STEEL = {"E_prime": "226 GPa", "nodes": 129, **OIL}

mesh = ertel.gears.involute(
    teeth_1=20, teeth_2=20, module="4 mm", speed="1500 rpm", torque="230 N*m", face_width="20 mm"
)
teeth = ertel.simulate(ertel.rolling(**mesh.keywords, **STEEL, step=0.03))  # in t0

# %%
# One or two pairs of teeth carry the load, so it doubles in the middle of the path; the sliding changes its sign at the
# pitch point.  The film follows the radius, which is largest there, and falls by a tenth where the load doubles.
seen = teeth.si
figure, panels = plt.subplots(4, sharex=True, figsize=(5, 7), layout="constrained")
panels[0].plot(seen["t"] * 1e3, seen["h_c"] * 1e9, label="centre")
panels[0].plot(seen["t"] * 1e3, seen["h_min"] * 1e9, label="minimum")
panels[1].plot(seen["t"] * 1e3, seen["w"] / 1e3)
panels[2].plot(np.asarray(mesh.time) * 1e3, mesh.mean_speed, label="mean speed")
panels[2].plot(np.asarray(mesh.time) * 1e3, mesh.speed_1 - mesh.speed_2, label="sliding speed")
panels[3].plot(seen["t"] * 1e3, seen["mu_sliding"])
for panel, label in zip(panels, ("film (nm)", "load (kN)", "speed (m/s)", "traction coefficient"), strict=True):
    panel.set_ylabel(label)
panels[0].legend()
panels[2].legend()
panels[3].set_xlabel("time along the path of contact (ms)")

# %%
# The balance of energy closes, with the work of the gap that changes its radius.
assert teeth.summary["budgets"]["energy"]["imbalance"] < 5e-3

# %%
# A cam with a flat follower.  Twice near its nose the mean speed of the surfaces passes through zero.  What is left of
# the film there is carried by squeeze.
angle = np.arange(-60, 61, 2)
lift = [(each, 0.002 * (1 + np.cos(3 * np.radians(each)))) for each in angle.tolist()]
nose = ertel.cams.flat_tappet(lift, base_radius="30 mm", speed="1000 rpm", width="14 mm", preload="2 kN")
cam = ertel.simulate(ertel.rolling(**nose.keywords, **STEEL, time_tolerance=2e-4))

seen = cam.si
figure, panels = plt.subplots(2, sharex=True, figsize=(5, 4), layout="constrained")
panels[0].plot(np.degrees(1000 * np.pi / 30 * seen["t"]) + angle[0], seen["h_c"] * 1e9, label="centre")
panels[0].plot(np.degrees(1000 * np.pi / 30 * seen["t"]) + angle[0], seen["h_min"] * 1e9, label="minimum")
panels[1].plot(np.linspace(angle[0], angle[-1], len(nose.time)), nose.mean_speed)
panels[0].set_ylabel("film (nm)")
panels[0].legend()
panels[1].set(xlabel="angle of the cam (degrees)", ylabel="mean speed (m/s)")
