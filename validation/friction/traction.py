"""Traction curves of the oils of Arana et al. 2019 beside their formula, isothermal.

    python validation/friction/traction.py

prints the table of traction.md and draws traction.png.  The formula is `arana_traction` of tests/closed_forms.py.  Both
have Eyring's law with tau_E = 2 Lambda/alpha, alpha the secant coefficient at the mean pressure, both the film that is
computed here for S = 0, and both an oil of 60 degC.  They differ in three things: the formula has one pressure, the
mean of Hertz, where the curve has the pressure of the contact; it cuts off at Lambda, where the curve has the law
"limited"; and its film has the same thickness everywhere.  The second number of each cell is the curve with the shear
stress cut off at Lambda p, node by node.
"""

import sys
from collections.abc import Iterator, Mapping
from dataclasses import replace
from functools import cache
from itertools import product
from math import log, pi
from pathlib import Path
from typing import Any, NamedTuple

import jax.numpy as jnp
import numpy as np
from matplotlib.figure import Figure

import ertel
from ertel.case.case import Case
from ertel.numerics.integrals import Plane
from ertel.physics.fluidity import cut_off
from ertel.runs.traction import curve_of
from ertel.solvers import steady
from ertel.solvers.grid_solution import GridSolution

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "tests"))
from closed_forms import arana_traction
from common import table

OILS = ("naphthenic-100", "mineral-100", "pao-100")
TEMPERATURE, PRESSURE, RADIUS = "60 degC", 1e9, 0.01  # the radius is a choice: the text does not say it
SPEEDS = (2.0, 6.0, 16.0)
SLIDING = (0.0, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.4)
IN_TABLE = (0.01, 0.05, 0.1, 0.4)
NODES = 65
COLORS = ("#0072B2", "#D55E00", "#009E73")


class OilData(NamedTuple):
    """Lambda; at the mean pressure alpha in 1/Pa and eta in Pa s."""

    limit: float
    alpha: float
    viscosity: float


@cache
def data_of(oil: str) -> OilData:
    """What the formula needs of an oil."""
    known, at = ertel.oils.get(oil), ertel.oils.at(oil, TEMPERATURE)
    assert known.limiting_stress is not None and at.eta0 is not None
    mean = 2.0 / 3.0 * PRESSURE
    ratio = float(at.viscosity_law.viscosity(mean))
    return OilData(known.limiting_stress.data.Lambda, log(ratio) / mean, at.eta0 * ratio)


@cache
def case_of(oil: str, speed: float) -> Case:
    """A steel ball on a steel disc at 1 GPa."""
    data = data_of(oil)
    eyring = {"law": "ree-eyring", "tau0": f"{2.0 * data.limit / data.alpha!r} Pa"}
    E_prime = _case(1.0, oil, speed, eyring).contact.scales.E_prime  # type: ignore[union-attr]
    a = pi * RADIUS * PRESSURE / E_prime
    load = 2.0 * pi / 3.0 * PRESSURE * a**2
    return _case(load, oil, speed, {"law": "limited", "base": eyring, "Lambda": data.limit})


def _case(load: float, oil: str, speed: float, rheology: object) -> Case:
    return ertel.rolling(
        radius=RADIUS,
        load=load,
        mean_speed=speed,
        material_1="steel",
        material_2="steel",
        oil=oil,
        temperature=TEMPERATURE,
        rheology=rheology,
        nodes=NODES,
    )


class Traction(NamedTuple):
    """mu at one slide-to-roll ratio by the law, and with the stress cut off at Lambda p."""

    law: float
    cut: float


def traction(case: Case, film: GridSolution, limit: float) -> Traction:
    """The traction of a film in a case that may slide in another way, as `ertel.traction(..., film="once")` has it."""
    found, scales = replace(film, case=case).account.friction, case.scales
    assert scales is not None
    largest = np.maximum(limit * np.asarray(film.P) * scales.p_h / scales.shear_stress, 1e-30)
    cut = cut_off(np.asarray(found.stress), largest)
    force = float(Plane.of(film.grid).total(jnp.asarray(cut[0]))) / case.geometry.hertz_load
    return Traction(float(found.sliding[0]) * scales.a_over_R, force * scales.a_over_R)


def formula(oil: str, speed: float, film: float) -> np.ndarray:
    """mu of Arana et al. at all slide-to-roll ratios."""
    limit, alpha, viscosity = data_of(oil)
    mean = 2.0 / 3.0 * PRESSURE
    return np.array([arana_traction(limit, alpha, mean, viscosity, S * speed, film) for S in SLIDING])


def rows(panels: Mapping[str, Any]) -> Iterator[list[str]]:
    """One for each oil and speed, whose curves are drawn in the panel of the oil."""
    for oil, (speed, color) in product(OILS, zip(SPEEDS, COLORS, strict=True)):
        case = case_of(oil, speed)
        assert case.scales is not None
        film = steady.steady_film(case).finest
        assert film.status.ok
        measured = film.measure()
        thickness = measured["H_c"] * case.scales.film
        cases = curve_of(case, {"slide_to_roll": SLIDING}, "once").cases
        ours = np.array([traction(at, film, data_of(oil).limit) for at in cases])
        theirs = formula(oil, speed, thickness)
        cells = [", ".join(f"{mu:.4f}" for mu in (*ours[i], theirs[i])) for i in map(SLIDING.index, IN_TABLE)]
        worst = ", ".join(f"{error:.4f}" for error in np.abs(ours - theirs[:, None]).max(axis=0))
        highest = measured["P_max"] * case.scales.p_h / 1e9
        about = f"{speed:g}", f"{case.parameters.M:.0f}", f"{thickness * 1e9:.0f}", f"{highest:.2f}"
        panels[oil].plot(SLIDING, ours[:, 0], "o-", color=color, markersize=3.5, label=f"{speed:g} m/s")
        panels[oil].plot(SLIDING, ours[:, 1], ":", color=color)
        panels[oil].plot(SLIDING, theirs, "--", color=color)
        yield [oil, *about, *cells, worst]


if __name__ == "__main__":
    figure = Figure(figsize=(15, 5), layout="constrained", dpi=110)
    panels = dict(zip(OILS, figure.subplots(1, len(OILS), sharey=True), strict=True))
    heads = [f"S = {S:g}" for S in IN_TABLE]
    table(["oil", "u_m (m/s)", "M", "h_c (nm)", "p_max (GPa)", *heads, "largest differences"], rows(panels))
    for oil, panel in panels.items():
        panel.set(title=oil, xlabel="slide-to-roll ratio $S$")
    panels[OILS[0]].set_ylabel("traction coefficient (dotted: cut off, dashed: Arana et al.)")
    panels[OILS[0]].legend(frameon=False)
    figure.savefig(Path(__file__).with_suffix(".png"))
