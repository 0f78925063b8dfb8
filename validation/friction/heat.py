"""Tables of heat.md: inlet factor, the film between cold walls, a traction curve from cold and from hot, grids, work.

    python validation/friction/heat.py

The traction curves take the film of one slide-to-roll ratio, so that they show what heat does.
"""

import sys
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax.tree_util import register_dataclass

import ertel
from ertel.case.case import Case
from ertel.case.estimates import grid_of
from ertel.equations import discretise
from ertel.equations.account import friction
from ertel.numerics.integrals import Plane
from ertel.physics.thermal import Solid, gupta_factor, peclet_number, wilson_sheu_factor
from ertel.solvers import heat, steady
from ertel.solvers.heat import Heated, Moving, warmed
from ertel.solvers.steady import GridSolution

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "tests"))
from closed_forms import flash_temperature, mean_rise, nahme
from common import table

NODES = 129
SLIDE_TO_ROLL = (0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 1.5, 1.9, 2.0)
FILM_AT = 0.05  # S at which the film is computed
PLAIN_STEPS = 60
CELSIUS = 273.15


def case(second: str, nodes: int = NODES) -> Case:
    """A steel ball of 20 mm on a disc, 100 N, 4 m/s, squalane at 25 degC."""
    return ertel.rolling(
        radius="10 mm",
        load="100 N",
        mean_speed="4 m/s",
        slide_to_roll=FILM_AT,
        material_1="steel",
        material_2=second,
        oil="squalane",
        temperature="25 degC",
        rheology={"law": "carreau", "G": "6 MPa", "n": 0.42},
        nodes=nodes,
        thermal={},
    )


def inlet_factor() -> None:
    """Both formulas against L_t."""
    rows = []
    for L_t in (0.01, 0.1, 0.5, 1.0, 3.0):
        gupta = [gupta_factor(L_t, S, 0.5 / 226) for S in (0.0, 0.2, 1.0)]
        wilson = [wilson_sheu_factor(L_t, S) for S in (0.0, 0.2, 1.0)]
        rows.append([f"{L_t:g}", *(f"{value:.4f}" for value in (*gupta, *wilson))])
    table(["L_t", "Gupta S = 0", "0.2", "1", "Wilson-Sheu S = 0", "0.2", "1"], rows)


@register_dataclass
@dataclass(frozen=True)
class Released:
    """The heat of a film whose viscosity falls with the temperature T, and its derivative."""

    most: Any
    beta: float

    def __call__(self, T: Any) -> Any:
        heat = self.most * jnp.exp(-self.beta * T)
        return heat, -self.beta * heat


def cold_walls() -> None:
    """Viscosity of a sheared film over that at its cold walls, by the mean temperature and by Nahme."""
    beta, film, conductivity, wall = 0.04, 1e-7, 0.14, Moving(np.zeros((1, 1)))
    rows = []
    for Na in (0.1, 1.0, 8.0, 50.0, 100.0, 1000.0, 1e4):
        released = Na * conductivity / (beta * film)  # at 1 m/s
        found = warmed(Released(np.array([released]), beta), (wall, wall), np.array([film / conductivity]))
        ours, exact = found.x[0, 0] / released, nahme(Na).viscosity
        rows.append([f"{Na:g}", f"{ours:.6f}", f"{exact:.6f}", f"{ours / exact - 1:.2%}", f"{found.iterations}"])
    table(["Na", "by the mean temperature", "Nahme, exact", "excess", "Newton iterations"], rows)


def worked_example() -> None:
    """40 MPa, 1 m/s, 100 nm; half of the heat into steel at 0.5 m/s, over 280 um."""
    uniform = np.full(281, 20e6)
    uniform[0] /= 2
    surface = flash_temperature(uniform, Solid(7850.0, 460.0, 47.0), 0.5, 1e-6)[-1]
    print(f"mean rise in the film {mean_rise(40e6, 1.0, 1e-7, 0.14):.2f} K, surface {surface:.1f} K")


def at(chosen: Case, slide_to_roll: float) -> Case:
    """The same contact with another slide-to-roll ratio."""
    return replace(chosen, contact=replace(chosen.contact, slide_to_roll=slide_to_roll))


def film(chosen: Case) -> GridSolution:
    """The isothermal film."""
    found = steady.steady_film(chosen).finest
    assert found.status.ok
    return found


def plain_iteration(chosen: Case, s: GridSolution, S: float) -> tuple[float, float]:
    """The highest rise of the film's temperature (K) in the last two steps of T <- T(q(T)), from a cold film."""
    scales, thermal, grid = chosen.scales, chosen.thermal, s.grid
    assert scales and thermal and chosen.oil.eta0
    mean = scales.front_speed
    thinner = thermal.inlet(chosen.oil.eta0, scales.p_h / scales.E_prime, mean, S).factor * s.H
    sheared = heat._sheared(chosen, grid, thermal.viscosity_of(chosen.oil.eta0), s.P, thinner, S * mean)
    heat_at = jax.jit(lambda T: sheared(T)[0])  # one program for all steps
    speeds = mean * (1 + S / 2), mean * (1 - S / 2)
    rises = [
        heat._rise(body, u, peclet_number(body, u, scales.a), scales.a, grid)
        for body, u in zip(thermal.bodies, speeds, strict=True)
    ]
    T, seen = np.zeros(s.P.shape), [0.0]
    for _ in range(PLAIN_STEPS):
        constant = Released(heat_at(T), 0.0)
        T = warmed(constant, rises, np.asarray(sheared.H) / thermal.conductivity).film
        seen.append(float(T.max()))
    return seen[-2], seen[-1]


def curve(second: str) -> None:
    """Traction and temperatures against S, from a cold film and from one with three times the heat."""
    chosen = case(second)
    scales, s = chosen.scales, film(chosen)
    assert scales
    isothermal = jax.jit(friction)
    c, load = discretise.contact_of(chosen, s.grid), chosen.geometry.hertz_load
    M, L = chosen.parameters.M, chosen.parameters.L
    h_c = s.measure()["H_c"] * scales.film
    conditions = f"M = {M:.0f}, L = {L:.1f}, p_h = {scales.p_h / 1e9:.2f} GPa, h_c = {h_c * 1e9:.0f} nm"
    print(f"\n### Steel on {second}: {conditions}\n")

    def row(S: float) -> list[str]:
        cool = float(isothermal(Plane.of(s.grid), c, s.P, s.H, S, 1.0, load).sliding[0]) * scales.a_over_R
        sliding = at(chosen, S)
        found = heat.heated(sliding, s.P, s.H)
        hot = heat.heated(sliding, s.P, s.H, heat=3.0 * found.heat)
        assert found.converged and hot.converged
        return [
            *(f"{S:g}", f"{found.inlet.factor:.4f}", f"{cool:.4f}", f"{traction(chosen, found):.4f}"),
            *(f"{T.max() - CELSIUS:.1f}" for T in (found.T_1, found.T_2, found.T_film)),
            *(f"{found.iterations}, {hot.iterations}", f"{abs(hot.T_film - found.T_film).max():.0e}"),
            " / ".join(f"{rise:.1f}" for rise in plain_iteration(chosen, s, S)),
        ]

    head = ["S", "phi_T", "mu isothermal", "mu warm", "T_1", "T_2", "T_film (degC)"]
    table([*head, "iterations", "hot start differs (K)", "plain iteration (K)"], map(row, SLIDE_TO_ROLL))


def traction(chosen: Case, found: Heated) -> float:
    """The traction coefficient."""
    assert chosen.scales
    return float(found.sliding[0]) * chosen.scales.a_over_R


def grids() -> None:
    """Order and work: the same contact on finer grids, a Hertzian pressure and a film of 100 nm that opens outside."""

    def row(nodes: int) -> list[str]:
        chosen = case("glass", nodes)
        assert chosen.scales and chosen.thermal
        grid = grid_of(chosen)
        r2 = grid.kept_x[None, :] ** 2 + grid.kept_y[:, None] ** 2
        P, H = np.sqrt(np.maximum(1.0 - r2, 0.0)), 1e-7 / chosen.scales.film + np.maximum(r2 - 1.0, 0.0)
        found = heat.heated(at(chosen, 0.2), P, H)
        rise = found.T_film.max() - chosen.thermal.temperature
        about = f"{traction(chosen, found):.6f}", f"{rise:.4f}"
        return [f"{nodes}", *about, f"{found.iterations}", f"{found.applications}"]

    table(["nodes", "mu", "T_film - T_0 (K)", "Newton iterations", "convolutions"], map(row, (33, 65, 129, 257)))


if __name__ == "__main__":
    for part in (inlet_factor, cold_walls, worked_example, grids):
        part()
        print()
    for disc in ("steel", "glass"):
        curve(disc)
