"""The terms of the budgets at one time: closed forms, and that they see a wrong pressure."""

from dataclasses import dataclass, replace
from functools import cache
from unittest.mock import patch

import jax
import numpy as np
import pytest
from cases import BARUS, BARUS_LIMIT, OIL, rolled, steady_solver
from jax.tree_util import register_dataclass

from ertel.case.case import Case
from ertel.case.estimates import grid_of
from ertel.case.sections import Drive
from ertel.equations import contact, discretise
from ertel.physics.lubricant import Oil
from ertel.physics.motion import constant
from ertel.physics.scales import Parameters
from ertel.solvers import guesses, steady
from ertel.solvers.grid_solution import GridSolution
from ertel.solvers.steady import Rolling


def case_of(speed: float = 1.0, nodes: int = 65, oil: Oil = OIL, L: float = 5) -> Case:
    """A resolved rolling contact on a centred grid."""
    solver = steady_solver(nodes, inlet=None, half_width=4.0)
    return rolled(Parameters.from_moes(20, L), oil, solver, Drive(entrainment=constant(speed)))


@cache
def film(speed: float = 1.0, L: float = 5, oil: Oil = OIL, nodes: int = 65) -> Rolling:
    return steady.steady_film(case_of(speed, nodes, oil, L))


def imbalances(s: GridSolution) -> tuple[float, float]:
    """Of mass and of energy, as shares of the outflow and of the dissipation."""
    t = s.account.terms
    mass = t["inflow"] + t["cavity_source"] - t["outflow"]
    energy = t["power_from_surfaces"] - t["power_to_surfaces"] - t["dissipation"] - t["outside_power"]
    return mass / t["outflow"], energy / t["dissipation"]


@pytest.mark.usefixtures("nothing_outside")
def test_the_solids_under_hertz_pressure_store_two_fifths() -> None:
    """Of F delta; the oil stores the integral of its energy of compression over the film, all of thickness 0.1."""
    case = case_of(nodes=129)
    grid = grid_of(case)
    P, approach = guesses.dry_guess(case.geometry, grid, 1.0)
    c = discretise.contact_of(case, grid)
    H = contact.film_thickness(c, P, approach)
    solution = steady.steady_film(case_of(nodes=33)).finest
    dry = replace(solution, grid=grid, P=P, H=H, approach=approach, outside=0.0)
    assert dry.account.terms["elastic_energy"] == pytest.approx(2 / 5, rel=2e-3)
    r = np.linspace(0, 1, 20001)
    in_oil = 0.1 * 3 * np.trapezoid(r * np.asarray(case.lubricant.compression(np.sqrt(1 - r**2))), r)
    flat = replace(dry, H=np.full_like(np.asarray(P), 0.1))
    assert flat.account.terms["oil_energy"] == pytest.approx(in_oil, rel=5e-3)


WAYS = [(1.0, 5, OIL), (-1.0, 5, OIL), (1.0, BARUS_LIMIT, OIL)]


@pytest.mark.parametrize(
    ("speed", "L", "oil", "nodes"),
    [*((*way, 65) for way in WAYS), *(pytest.param(*w, 129, marks=pytest.mark.slow) for w in (*WAYS, (1.0, 5, BARUS)))],
)
def test_steady_rolling_dissipates_what_its_resistance_takes(speed: float, L: float, oil: Oil, nodes: int) -> None:
    """In both directions, with and without piezoviscosity, and with an incompressible oil; of second order.

    The oil that flows in flows out, to the tolerance of the solver.
    """
    mass, energy = imbalances(film(speed, L, oil, nodes).finest)
    assert abs(mass) < 1e-8
    assert abs(energy) < 6e-3 * (128 / (nodes - 1)) ** 2


def test_both_directions_have_the_same_budgets() -> None:
    there, back = (film(speed).finest.account.terms for speed in (1.0, -1.0))
    assert back == pytest.approx({**there, "mu_rolling": -there["mu_rolling"]}, rel=1e-6)


@pytest.mark.parametrize("nodes", [65, pytest.param(129, marks=pytest.mark.slow)])
def test_the_steady_energy_closes_with_the_order_of_the_grid(nodes: int) -> None:
    solutions = film(nodes=nodes).solutions
    found = np.abs([imbalances(s)[1] for s in solutions])
    orders = np.log2(found[:-1] / found[1:])
    assert [s.grid.nodes for s in solutions][:2] == [33, 65]
    assert orders[-1] > 1.8, orders


def test_a_wrong_pressure_opens_the_budgets() -> None:
    """10 % more pressure with the same film: more flows and dissipates than the motion of the surfaces brings."""
    s = film().finest
    mass, energy = imbalances(replace(s, P=1.1 * s.P))
    assert abs(mass) > 0.02
    assert abs(energy) > 0.05
    ahead = np.roll(np.asarray(s.P), -1, axis=1)  # the pressure one cell further upstream
    assert abs(imbalances(replace(s, P=ahead))[1]) > 0.1


@register_dataclass
@dataclass(frozen=True)
class Leaking(contact.PressureFlow):
    """Oil goes into the surfaces, in proportion to its pressure."""

    def source(self, contact: contact.Contact, P: jax.Array, H: jax.Array) -> jax.Array:
        return -0.05 * P


def test_a_leak_that_the_account_leaves_out_opens_the_balance_of_mass() -> None:
    """By what leaks, 0.05 times the load on the grid; with it the balance closes to the tolerance of the solver."""
    with patch.object(discretise, "flow_of", lambda case, T: Leaking()):
        told = steady.steady_film(case_of(nodes=33)).finest
        assert abs(imbalances(told)[0]) < 1e-8
    untold = replace(told).account.terms  # as if the surfaces were tight
    lacks = untold["inflow"] - untold["outflow"]
    assert lacks == pytest.approx(0.05 * told.load, rel=0.01)  # the nodes on the edge do not count
    assert lacks == pytest.approx(told.account.terms["outflow"] - untold["outflow"], rel=1e-6)
