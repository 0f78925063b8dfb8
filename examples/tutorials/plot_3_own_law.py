"""
A law of your own, and a figure for a thesis
============================================

You measured how the viscosity of an oil grows with pressure, and none of the laws of ertel fits.  In this lesson you
write your own law in fifteen lines, check it, run an impact with it, draw a figure that is ready for print, and make
the law a package that other people install.
"""

import os
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Annotated

import jax
import numpy as np
from matplotlib.figure import Figure

import ertel
from ertel.numerics.programs import double_precision
from ertel.physics.units import ABOVE_ZERO, COMPLIANCE

# %%
# The law
# -------
# A law is a frozen dataclass with a method ``viscosity``, which gives eta/eta0 at a pressure in Pa.  This one is
# McEwen's (J Inst Petrol 1952;38:646): at low pressure it grows as Barus' law does, with the pressure-viscosity
# coefficient alpha, at high pressure as a power q.  ``Annotated`` names the units, so that a case file may say "22 /
# GPa".  ``register`` gives the name under which a run is stored.  ``of`` takes alpha from the oil, so that the name
# alone is enough.


@ertel.viscosity_laws.register("mcewen")
@dataclass(frozen=True)
class McEwen:
    """eta/eta0 = (1 + alpha p/q)^q."""

    alpha: Annotated[float, COMPLIANCE]
    q: Annotated[float, ABOVE_ZERO] = 11.0

    def viscosity(self, p):
        """eta/eta0 at p (Pa), of p's shape."""
        return (1 + self.alpha * p / self.q) ** self.q

    @classmethod
    def of(cls, oil):
        """The law of an oil with this alpha."""
        return cls(oil.alpha)


# %%
# It takes numbers, arrays of NumPy and arrays of JAX, because it has only operators.  For functions such as ``exp``
# use ``ertel.physics.registry.arrays_of(p).exp``.  Neither may it ask ``if p > ...``: the solver hands all pressures
# at once.
law = McEwen(alpha=22e-9)
print(law.viscosity(np.array([0, 0.2e9, 0.5e9, 1e9])))

# %%
# Check it
# --------
# The solver needs the derivative of the law and finds it itself, with JAX.  Ask JAX for the same derivative and
# compare it with that on paper, d ln(eta)/dp = alpha/(1 + alpha p/q), and with a difference of two values.  A law
# with a kink, or one that is not a number somewhere, fails here and not in the middle of the night.
with double_precision():
    pressures = np.linspace(0, 2e9, 9)
    of_jax = np.array([float(jax.grad(lambda p: jax.numpy.log(law.viscosity(p)))(p)) for p in pressures])
on_paper = law.alpha / (1 + law.alpha * pressures / law.q)
step = 1e3  # Pa
ends = [np.log(law.viscosity(pressures + side * step)) for side in (-1, 1)]
difference = (ends[1] - ends[0]) / (2 * step)
for name, found in (("JAX", of_jax), ("difference", difference)):
    error = np.abs(found / on_paper - 1).max()
    print(f"largest relative error of the derivative, {name}: {error:.0e}")
    assert error < 1e-6
assert abs(of_jax[0] - law.alpha) < 1e-12 * law.alpha  # alpha is what its name says

# %%
# Run it
# ------
# The same ball falls on two oils that differ in the law only; both have the same viscosity and the same alpha.  Along
# the radius this takes seconds.


def fall(viscosity):
    """A steel ball of 20 mm falls on oiled glass, until maximum approach."""
    return ertel.simulate(
        ertel.impact(
            radius="10 mm",
            speed="0.1 m/s",
            material_1="steel",
            material_2="glass",
            oil=ertel.Oil(eta0="60 mPa*s", alpha="22 / GPa", viscosity=viscosity),
            method="radial",
            nodes=97,
            half_width=4,
            start_approach=-1.5,
        )
    )


runs = {"Roelands": fall("roelands"), "McEwen": fall("mcewen")}
for name, run in runs.items():
    print(f"{name:9s} {run.verdict}")

# %%
# The trapped film is nearly the same, although at the highest pressure of the run the viscosities are far apart.  The
# film is trapped early, while the pressure is still low, and there only alpha counts.
films = [float(run.si["h_c"][-1]) for run in runs.values()]
p_max = float(runs["McEwen"].si["p"].max())
viscosities = [float(run.case.lubricant.viscosity(p_max / run.case.scales.p_h)) for run in runs.values()]
print(f"films {1e9 * films[0]:.0f} and {1e9 * films[1]:.0f} nm")
print(f"eta/eta0 at {p_max / 1e9:.2f} GPa: {viscosities[0]:.1e} and {viscosities[1]:.1e}")
assert abs(films[1] / films[0] - 1) < 0.03
assert viscosities[0] > 10 * viscosities[1]

# %%
# The figure
# ----------
# One column of a journal or of a thesis is 85 mm wide.  ``columns=1`` draws every picture of ertel in this width,
# with letters of 7 to 9 pt, and ``title=False`` leaves the heading to the caption.  Do not scale it afterwards.
figure = runs["McEwen"].plot.profiles(columns=1, title=False)

# %%
# Both runs in one figure need matplotlib itself: its size in inches, and its letters.
figure = Figure(figsize=(85 / 25.4, 2.4), layout="constrained")
axes = figure.add_subplot()
for (name, run), line in zip(runs.items(), ("-", "--"), strict=True):
    last = run.si.isel(frame=-1)
    axes.plot(1e6 * last["r"], 1e9 * last["h"], line, label=name)
axes.set(xlim=(0, 300), ylim=(0, 2000))
axes.set_xlabel("r (µm)", fontsize=8)
axes.set_ylabel("film thickness (nm)", fontsize=8)
axes.tick_params(labelsize=7)
axes.legend(fontsize=7, frameon=False)

# %%
# Publish it
# ----------
# A law in a script works in this script.  In a package it works for everybody who installs the package, in case
# files, in the app and on a cluster, without an import.  Two files make it.  One is a module, ``student_oils.py``,
# with the class from above, but without ``register``.  The other is ``pyproject.toml``:
#
# .. code-block:: toml
#
#    [project]
#    name = "student-oils"
#    version = "0.1"
#    dependencies = ["ertel"]
#
#    [project.entry-points."ertel.viscosity_laws"]
#    mcewen = "student_oils:McEwen"
#
# ``python -m pip install .`` writes the last two lines beside the module.  So does this script, in a temporary
# folder, to show it without installing anything.  Then a new Python process, which knows nothing of this page, checks
# a case file that names the law.
MODULE = '''
from dataclasses import dataclass
from typing import Annotated

from ertel.physics.units import ABOVE_ZERO, COMPLIANCE


@dataclass(frozen=True)
class McEwen:
    """eta/eta0 = (1 + alpha p/q)^q."""

    alpha: Annotated[float, COMPLIANCE]
    q: Annotated[float, ABOVE_ZERO] = 11.0

    def viscosity(self, p):
        return (1 + self.alpha * p / self.q) ** self.q
'''
CASE = """
[contact]
kind = "impact"
M = 200
L = 10

[lubricant]
alpha = "22 / GPa"
viscosity = { law = "mcewen", alpha = "22 / GPa", q = 9 }

[solver]
method = "radial"
nodes = 97
"""

with TemporaryDirectory() as folder:
    files = {
        "student_oils.py": MODULE,
        "student_oils-0.1.dist-info/METADATA": "Metadata-Version: 2.1\nName: student-oils\nVersion: 0.1\n",
        "student_oils-0.1.dist-info/entry_points.txt": "[ertel.viscosity_laws]\nmcewen = student_oils:McEwen\n",
        "ball.toml": CASE,
    }
    for name, text in files.items():
        path = Path(folder) / name
        path.parent.mkdir(exist_ok=True)
        path.write_text(text, encoding="utf-8")
    places = os.pathsep.join([folder, *sys.path])
    program = 'import ertel; print(ertel.load_case("ball.toml").lubricant)'
    done = subprocess.run(
        [sys.executable, "-c", program],
        capture_output=True,
        text=True,
        cwd=folder,
        env={**os.environ, "PYTHONPATH": places},
        check=False,
    )
print(done.stdout or done.stderr)
assert "McEwen(alpha=2.2e-08, q=9" in done.stdout

# %%
# Densities, laws of thinning and shapes of roughness are added in the same way, through ``ertel.density_laws``,
# ``ertel.fluidity_laws`` and ``ertel.shapes``.  The page `for developers <../developers.html>`_ has more.  Send your
# law with its source, and it can become a part of ertel.
