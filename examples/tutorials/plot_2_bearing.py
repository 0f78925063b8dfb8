"""
A bearing, from data sheet to Lambda and friction
=================================================

You have the data sheet of a deep groove ball bearing and of its oil.  Is the film thick enough to keep ball and ring
apart, and how large is the friction?  In this lesson you compute both for the most loaded ball, and find out which of
your numbers the answer depends on.
"""

from math import pi
from pathlib import Path
from tempfile import mkdtemp

from matplotlib import pyplot as plt

import ertel
from ertel.case.estimates import newtonian_stress
from ertel.runs.result import verdict

# %%
# From the bearing to one contact
# -------------------------------
# The data sheet has the balls, the raceway of the inner ring, its groove, the load and the speed.  In a bearing under
# radial load the most loaded ball carries about five times the mean (Stribeck).  The ball rolls on both rings, and
# the mean speed of the surfaces in the contact follows from the pitch diameter.
BALLS, DIAMETER = 9, 12e-3  # m
RACEWAY, GROOVE = 20e-3, 0.52 * 12e-3  # m, radii
RADIAL_LOAD, TURNS = 540.0, 3000 / 60  # N, 1/s

load = 5 * RADIAL_LOAD / BALLS
pitch = 2 * RACEWAY + DIAMETER
speed = 2 * pi * TURNS * pitch / 4 * (1 - (DIAMETER / pitch) ** 2)
print(f"most loaded ball {load:.0f} N, mean speed {speed:.2f} m/s")

# %%
# The case
# --------
# The oil is an ISO VG 68 with its viscosities at 40 and 100 degC, its density and its pressure-viscosity coefficient.
# The groove is concave, so its radius is below zero.
#
# Friction needs a law for high shear stress.  Here the oil thins by Ree and Eyring, and its stress cannot exceed a
# limit that grows with the pressure.  ``tau0`` and ``Lambda`` stand on no data sheet; these are usual values, and we
# shall see what they do.  ``[thermal]`` has the film solved with its heat, and gives temperatures.
CASE = Path(mkdtemp()) / "bearing.toml"
CASE.write_text(
    f"""
[contact]
kind = "rolling"
radius_x_1 = "{DIAMETER / 2} m"   # the ball
radius_y_1 = "{DIAMETER / 2} m"
radius_x_2 = "{RACEWAY} m"        # the inner ring
radius_y_2 = "{-GROOVE} m"
load = "{load} N"
mean_speed = "{speed} m/s"
slide_to_roll = 0.02
material_1 = "steel"
material_2 = "steel"

[lubricant]
oil = {{ nu40 = "68 mm^2/s", nu100 = "8.7 mm^2/s", density = "880 kg/m^3", alpha = "20 / GPa" }}
temperature = "60 degC"
rheology = {{ law = "limited", Lambda = 0.05, base = {{ law = "ree-eyring", tau0 = "5 MPa" }} }}

[thermal]
conductivity = "0.13 W/(m*K)"

[solver]
method = "steady"
nodes = 65
tolerance = 0.03
""",
    encoding="utf-8",
)
case = ertel.load_case(CASE)
hertz = case.scales
print(f"Hertz pressure {hertz.p_h / 1e9:.2f} GPa, half width along the rolling direction {1e6 * hertz.a:.0f} µm")

# %%
# Why a law of thinning?  Without one the viscosity under this pressure would give a shear stress that no oil carries,
# and a traction coefficient above that of dry steel.  ertel warns of it before such a run.
stress = newtonian_stress(ertel.load_case(CASE, ["lubricant.rheology=newtonian"]))
newtonian = stress / (2 / 3 * hertz.p_h)
print(f"without thinning: mean shear stress {stress / 1e6:.0f} MPa, traction coefficient {newtonian:.1f}")
assert newtonian > 1

# %%
# Film and Lambda
# ---------------
# 65 nodes along the rolling direction are few.  They answer in some two minutes, with an error that the result tells;
# for the final number take 129.
result = ertel.simulate(case)
figure = result.plot.film()

# %%
# The contact is ten times as wide as it is long, and the picture is turned by a quarter.  Lambda is the minimum film
# over the rms roughness of both surfaces together, here 60 nm on the ring and 20 nm on the ball.  The verdict has all
# in one line: the central film, Lambda, the traction coefficient, and how much warmer the film is than the inlet.
print(verdict(result, "60 nm", "20 nm"))
Lambda = result.lambda_ratio("60 nm", "20 nm")
error = result.summary["H_min_error"] / result.summary["H_min"]
print(f"Lambda = {Lambda:.1f} ± {error * Lambda:.1f}")
assert Lambda * (1 - error) > 3

# %%
# Even with the error of this coarse grid Lambda is above 3: the surfaces are apart.
#
# How much film does the heat cost?  ``thermal.inlet = "none"`` leaves the film as if it were cold.
cold = ertel.simulate(ertel.load_case(CASE, ["thermal.inlet=none"]))
with_heat, without = (1e9 * each.summary["si"]["h_c_m"] for each in (result, cold))
print(f"central film on the grid {with_heat:.0f} nm with heat, {without:.0f} nm without")
assert 0.85 < with_heat / without < 0.97

# %%
# This ball hardly slides, and the heat of its inlet is small.
#
# Friction
# --------
# The traction coefficient over the slide-to-roll ratio, for three laws.  ``film="once"`` takes the film of the first
# point for all points of a curve, in the time of one.  That needs a film that is not solved with its heat.


def rheology(tau0, limit):
    """The law with other numbers, as one gives it to --set on the command line."""
    return f'lubricant.rheology={{ law="limited", Lambda={limit}, base={{ law="ree-eyring", tau0="{tau0} MPa" }} }}'


SLIDING = [0.002, 0.005, 0.01, 0.02, 0.05, 0.1]
LAWS = {"usual": (5, 0.05), "lower limit": (5, 0.03), "thins earlier": (3, 0.05)}  # MPa, 1
figure, axes = plt.subplots(figsize=(6, 3.4), layout="constrained")
traction, films = {}, {}
for name, (tau0, limit) in LAWS.items():
    changed = ertel.load_case(CASE, [rheology(tau0, limit), "thermal.inlet=gupta"])
    curve = ertel.traction(changed, slide_to_roll=SLIDING, film="once").dataset
    traction[name], films[name] = abs(curve["mu_sliding"].values), curve["h_c"].values
    axes.plot(SLIDING, traction[name], "o-", label=f"{name}: tau0 = {tau0} MPa, limit {limit} p")
axes.set(xlabel="slide-to-roll ratio", ylabel="traction coefficient", ylim=(0, None))
axes.legend()

# %%
# What does the answer depend on?
# -------------------------------
# Friction depends on the two numbers that nobody gave you.
for name, mu in traction.items():
    print(f"{name:14s} mu = {mu[-1]:.4f}, film {1e9 * films[name][-1]:.0f} nm")
assert traction["usual"][-1] / traction["lower limit"][-1] > 1.1
assert traction["usual"][-1] / traction["thins earlier"][-1] > 1.1

# %%
# Measure one traction curve of your oil on a rig, and fit ``tau0`` and ``Lambda`` to it (`An impact as a viscometer
# <../howto/impact_viscometer.html>`_ shows a fit).  The film hardly feels them.  It depends on what the data sheet
# does give; a formula is enough to see how much.


def formula(*changes):
    """Central film (m) of Nijenbanning, Venner and Moes."""
    changed = ertel.load_case(CASE, changes)
    return changed.film_scale * changed.scales.film


OTHER_ALPHA = 'lubricant.oil={ nu40="68 mm^2/s", nu100="8.7 mm^2/s", density="880 kg/m^3", alpha="22.4 / GPa" }'
CHANGES = {
    "alpha 12 % higher, the usual error of a correlation": OTHER_ALPHA,
    "10 K warmer": 'lubricant.temperature="70 degC"',
    "half the speed": f'contact.mean_speed="{speed / 2} m/s"',
    "twice the load": f'contact.load="{2 * load} N"',
}
change = {name: formula(each) / formula() - 1 for name, each in CHANGES.items()}
for name, share in change.items():
    print(f"film {share:+5.0%}  {name}")
assert change["half the speed"] < change["10 K warmer"] < -0.15 < change["twice the load"] < 0

# %%
# So: know the temperature of the inlet.  Ten kelvins cost more film than the doubt of alpha, and the load counts for
# almost nothing.

# %%
# From rest to full speed: the Stribeck curve
# -------------------------------------------
# At full speed the surfaces are apart.  While the bearing starts they are not.  ``[surfaces]`` has their roughness, and
# a law lets their asperities touch: here Persson's for ground steel with waves from 1 to 50 µm.  It needs both ends of
# the spectrum and no number to fit.
ROUGH = [
    "surfaces.sigma_1=20 nm",
    "surfaces.sigma_2=60 nm",
    'surfaces.asperities={ law = "persson", longest = "50 um", shortest = "1 um" }',
]
start = ertel.stribeck(ertel.load_case(CASE, ROUGH), f"0.03:{speed}:6")
figure = start.plot()
on_asperities = start.dataset["asperity_share"].values
for each, share in zip(start.dataset["mean_speed"].values, on_asperities, strict=True):
    print(f"{each:5.2f} m/s: asperities carry {share:.1%}")
assert on_asperities[0] > 0.5 and on_asperities[-1] < 0.01

# %%
# Friction falls from that of the boundary, 0.12 (``surfaces.boundary_friction``), to that of the oil.  So the ratio of
# film to roughness is not the whole answer: the curve says at which speed the load has passed to the oil.
