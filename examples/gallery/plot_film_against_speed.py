"""
Film against speed, beside the formulas
=======================================

The film of a ball on a disc grows with the speed to a power of about two thirds.  This is the first curve that every
optical rig measures, and the one on which film thickness formulas are judged.
"""

import numpy as np
from matplotlib import pyplot as plt

import ertel
from ertel.physics import scales

SPEEDS = np.array([0.25, 0.5, 1.0, 2.0])  # m/s


def contact(speed, nodes):
    """A steel ball on a steel disc at a mean speed (m/s)."""
    oil = ertel.Oil(eta0="40 mPa*s", alpha="22 / GPa")
    steel = dict(material_1="steel", material_2="steel")
    return ertel.rolling(radius="10 mm", load=38.9, mean_speed=speed, oil=oil, nodes=nodes, tolerance=0.03, **steel)


def formula(case, name):
    """Central film (m) by a formula."""
    hamrock_dowson = scales.hamrock_dowson(case.scales, case.oil.eta0, case.oil.alpha)
    films = {film.name: film.central for film in ertel.formulas.films(case.parameters, hamrock_dowson)}
    return films[name] * case.scales.film


# %%
# 129 nodes a side.  Each steady run also knows the film on half as many nodes, and from both an extrapolated value
# and an estimate of the error: the bars.
runs = [ertel.simulate(contact(speed, 129)) for speed in SPEEDS]
unit = np.array([run.case.scales.film for run in runs])
central = np.array([run.summary["H_c_extrapolated"] for run in runs]) * unit
error = np.array([run.summary["H_c_error"] for run in runs]) * unit

figure, axes = plt.subplots(figsize=(6, 4.2), layout="constrained")
axes.errorbar(SPEEDS, 1e9 * central, 1e9 * error, fmt="o", capsize=4, label="ertel, extrapolated, and its error")
more = np.geomspace(0.2, 2.5, 20)
for name in ("Hamrock-Dowson", "Nijenbanning-Venner-Moes"):
    axes.plot(more, [1e9 * formula(contact(speed, 129), name) for speed in more], label=name)
axes.set(xscale="log", yscale="log", xlabel="mean speed (m/s)", ylabel="central film thickness (nm)")
axes.set_xticks(SPEEDS, SPEEDS)
axes.set_yticks([100, 200, 400], [100, 200, 400])
axes.minorticks_off()
axes.legend()

# %%
# The exponent of the speed.
exponent = np.polyfit(np.log(SPEEDS), np.log(central), 1)[0]
assert 0.62 < exponent < 0.74
print(f"film ~ speed^{exponent:.3f}")
