"""
Where the steel is stressed most
================================

A steel roller rolls and slides on steel under 1.5 GPa.  The pressure of the film makes the largest von Mises stress
some 0.7 half widths below the surface.  The shear stress of the oil changes the stress along the surface: it adds
tension at the outlet in the body that it brakes, and at the inlet in the one that it drives.
"""

from matplotlib import pyplot as plt

import ertel


def rolled(slide_to_roll):
    """A steady line contact with an oil whose shear stress has a limit."""
    roller = ertel.rolling(
        radius="10 mm",
        length="10 mm",
        load="6.1 kN",
        mean_speed="2 m/s",
        slide_to_roll=slide_to_roll,
        material_1="steel",
        material_2="steel",
        oil=ertel.Oil(eta0="40 mPa*s", alpha="20 / GPa"),
        rheology={"law": "limited", "base": {"law": "ree-eyring", "tau0": "5 MPa"}, "Lambda": 0.08},
        nodes=513,
        name="steel roller",
    )
    return ertel.simulate(roller)


run = rolled(0.3)
figure = run.plot.stress(body=1)

# %%
# The ratio to the yield stress is that of hardened steel, whose yield stress is a third of its hardness.
print(run)

# %%
# The stress along the surface: body 1 is the faster one, which the oil brakes.
figure, axes = plt.subplots(figsize=(6, 3.2), layout="constrained")
for body, label in ((1, "braked"), (2, "driven")):
    surface = run.stress(body=body, depths=[0.0]).isel(z=0)
    axes.plot(1e6 * surface["x"], 1e-6 * surface["sigma_xx"], label=f"body {body}, {label}")
axes.set(xlabel="x (µm)", ylabel=r"$\sigma_{xx}$ at the surface (MPa)", xlim=(-500, 500))
axes.legend()

# %%
# The largest stress of a roller that only rolls, and of one that slides.
still = rolled(0.0)
for name, each in (("rolling", still), ("sliding", run)):
    si, mu = each.summary["si"], each.summary["mu_sliding"]
    print(f"{name}: mu = {mu:.3f}, {si['von_mises_max_Pa'] / 1e9:.3f} GPa, {1e6 * si['z_von_mises_m']:.0f} um deep")
assert run.summary["mu_sliding"] > 0.04
assert 0.54 < still.summary["von_mises_max"] < 0.60
