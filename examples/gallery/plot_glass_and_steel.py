"""
Glass on steel and steel on glass
=================================

A ball slides fast on a flat.  One of the two is of steel, the other one of glass, which conducts heat 45 times worse.
It matters which of the two is the fast one: with fast glass the central film is thicker, and the film at its end is
thinner.  Both films together take some two minutes on one core.
"""

from matplotlib import pyplot as plt

import ertel

STEEL = {"density": "7850 kg/m^3", "heat_capacity": "460 J/(kg*K)", "conductivity": "47 W/(m*K)"}
GLASS = {"density": "2500 kg/m^3", "heat_capacity": "840 J/(kg*K)", "conductivity": "1.05 W/(m*K)"}
CONTACT = {"radius": "10 mm", "load": "37 N", "mean_speed": "2 m/s", "slide_to_roll": 1.9, "E_prime": "226 GPa"}
OIL = {"oil": ertel.Oil(eta0="40 mPa*s", alpha="22 / GPa"), "rheology": {"law": "ree-eyring", "tau0": "10 MPa"}}


def slid(fast, slow, name):
    """A contact whose body 1 moves at 3.9 m/s and body 2 at 0.1 m/s."""
    thermal = {"temperature": "313 K", "beta": "0.04 / K", "conductivity": "0.14 W/(m*K)"}
    for number, body in ((1, fast), (2, slow)):
        thermal |= {f"{key}_{number}": value for key, value in body.items()}
    return ertel.simulate(ertel.rolling(**CONTACT, **OIL, nodes=129, thermal=thermal, name=name))


# %%
# Both pictures have the oil in the shape of the film, with the fast surface above.  The elastic modulus is the same in
# both runs, so that they differ by their heat alone.  Here glass is fast.  Oil at the fast surface is hot, and thin.
glass = slid(GLASS, STEEL, "fast_glass")
figure = glass.plot.temperature()

# %%
# Here steel is fast.  It stays cool, and the oil is hot and thin at the slow glass.
steel = slid(STEEL, GLASS, "fast_steel")
figure = steel.plot.temperature()

# %%
# The oil shears where it is thin, and the rest of it moves with the cooler surface.  If that is the fast one, the
# surfaces drag along more oil than in a film that is equally warm across, by the share c.  This is the viscosity wedge:
# the same oil then makes a thinner film in the middle.
figure, axes = plt.subplots(figsize=(6, 3.4), layout="constrained")
for name, run in (("fast glass", glass), ("fast steel", steel)):
    line, si = run.si.sel(y=0.0, method="nearest"), run.summary["si"]
    axes.plot(1e6 * line["x"], 1e9 * line["h"], label=name)
    share = float(line["share"].sel(x=0.0, method="nearest"))
    print(f"{name}: h_c = {1e9 * si['h_c_m']:.0f} nm, c = {share:.2f}, mu = {run.summary['mu_sliding']:.3f}")
axes.set(xlabel="x (µm)", ylabel="film thickness (nm)", xlim=(-250, 180), ylim=(0, 1000))
axes.legend()
assert glass.summary["H_c"] > 1.15 * steel.summary["H_c"]
