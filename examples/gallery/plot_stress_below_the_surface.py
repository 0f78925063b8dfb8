"""
Where the steel is stressed most
================================

A steel ball rolls and slides on steel under 2 GPa.  The pressure of the film makes the largest von Mises stress about half
a contact radius below the surface.  The shear stress of the oil moves it, to the front in the body that it drives and to
the back in the one that it brakes, and adds to the stress at the surface.
"""

from matplotlib import pyplot as plt

import ertel


def rolled(slide_to_roll):
    """A steady contact with an oil whose shear stress has a limit."""
    ball = ertel.rolling(
        radius="10 mm",
        load="320 N",
        mean_speed="1 m/s",
        slide_to_roll=slide_to_roll,
        material_1="steel",
        material_2="steel",
        oil=ertel.Oil(eta0="40 mPa*s", alpha="20 / GPa"),
        rheology={"law": "limited", "base": {"law": "ree-eyring", "tau0": "5 MPa"}, "Lambda": 0.08},
        nodes=129,
        name="steel on steel",
    )
    return ertel.simulate(ball)


run = rolled(0.3)
figure = run.plot.stress(body=1)

# %%
# The ratio to the yield stress is that of hardened steel, a third of its hardness.
print(run)

# %%
# At the surface the faster body, which the oil brakes, and the slower one, which it drives, differ.
figure, axes = plt.subplots(figsize=(6, 3.2), layout="constrained")
for body, label in ((1, "braked"), (2, "driven")):
    surface = run.stress(body=body, depths=[0.0]).isel(z=0)
    axes.plot(1e6 * surface["x"], 1e-6 * surface["sigma_xx"], label=f"body {body}, {label}")
axes.set(xlabel="x (µm)", ylabel=r"$\sigma_{xx}$ at the surface (MPa)", xlim=(-500, 500))
axes.legend()

# %%
# The stress with friction, and that of a ball that only rolls.
still = rolled(0.0)
for name, each in (("rolling", still), ("sliding", run)):
    si, mu = each.summary["si"], each.summary["mu_sliding"]
    print(f"{name}: mu = {mu:.3f}, {si['von_mises_max_Pa'] / 1e9:.3f} GPa, {1e6 * si['z_von_mises_m']:.0f} um deep")
assert run.summary["mu_sliding"] > 0.04
assert 0.60 < still.summary["von_mises_max"] < 0.64
