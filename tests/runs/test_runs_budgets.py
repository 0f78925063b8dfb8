"""The budgets of runs: they close, with the order of the method, and they explain the rebound; their friction."""

from dataclasses import replace
from functools import cache
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from cases import OIL, impact, rolled
from numpy.testing import assert_allclose

from ertel.case.estimates import grid_of
from ertel.case.methods import METHODS
from ertel.case.sections import Drive, Time
from ertel.equations import discretise
from ertel.equations.account import friction
from ertel.numerics.integrals import Plane
from ertel.physics.motion import Oscillation, constant
from ertel.physics.scales import Parameters
from ertel.physics.surfaces import Feature, Waviness
from ertel.results import balances
from ertel.results.diagnostics import LARGE_IMBALANCE
from ertel.runs.drive import simulate
from ertel.runs.result import Result

FRICTION = jax.jit(friction)
P20 = Parameters.from_moes(20, 5)
KINETIC = 2 / 5  # of a free ball before it meets the oil


def imbalances(result: Result) -> dict[str, float]:
    return {name: terms["imbalance"] for name, terms in result.summary["budgets"].items()}


@cache
def rebound(method: str) -> Result:
    nodes, width = {"2d": (33, 2.0), "radial": (129, 4.0)}[method]
    return simulate(impact(100, 5, nodes, solver={"method": method, "half_width": width}, time={"until": "rebound"}))


@pytest.mark.parametrize("method", ["2d", "radial"])
def test_the_square_of_the_restitution_is_one_minus_the_dissipated_share(method: str) -> None:
    """As far as the energy closes; what goes to the oil outside the grid is dissipated there."""
    result = rebound(method)
    energy = result.summary["budgets"]["energy"]
    lost = (energy["dissipated"] + energy["outside"]) / KINETIC
    assert 0.1 < lost < 0.4
    assert abs(energy["elastic"]) + abs(energy["oil"]) < 1e-3
    # the records begin after the first step, at almost the first speed
    assert result.summary["restitution"] ** 2 == pytest.approx(1 - lost, abs=energy["imbalance"] + 2e-3)
    assert imbalances(result)["energy"] < 2e-3
    assert imbalances(result)["momentum"] < 1e-3


def test_both_methods_dissipate_the_same() -> None:
    """In all, and at every time; with what is lost outside the grid, which is narrower on the plane."""
    plane, disc = (rebound(method).summary["budgets"]["energy"] for method in ("2d", "radial"))
    assert plane["outside"] > 2 * disc["outside"]
    assert plane["dissipated"] + plane["outside"] == pytest.approx(disc["dissipated"] + disc["outside"], rel=0.02)
    found = []
    for d in (rebound(method).dataset for method in ("2d", "radial")):
        found.append(np.interp([0.5, 1.0, 1.5, 2.0], d["time"], d["power_loss"] + d["outside_power"]))
    assert_allclose(found[0], found[1], rtol=0.03)


def test_budgets_close_with_the_order_of_grid_and_step() -> None:
    """That of mass to round-off.  The load outside is large on this narrow grid: a fifth of the energy goes there."""
    found = []
    for nodes, step in ((33, 0.05), (65, 0.025)):
        sections: dict[str, Any] = {"solver": {"half_width": 2.0}, "time": {"until": 2.0, "step": step}}
        mass, *others = imbalances(simulate(impact(20, 5, nodes, **sections))).values()
        assert mass < 1e-12
        found.append(others)
    orders = np.log2(np.divide(*found))
    assert np.all(orders > 1.4), orders
    assert max(found[1]) < 2.5e-3


@cache
def rolling(direction: float = 1.0, load: float = 0.0, height: float = 0.1) -> Result:
    """Waviness on one of two sliding surfaces, and a load that swings: all terms but inertia."""
    solver = replace(METHODS["transient"].defaults, nodes=33, tolerance=1e-8, fold=False, inlet=None, half_width=4.0)
    drive = Drive(Oscillation(1.0, load, 2.0), constant(direction), slide_to_roll=1.0)
    return simulate(rolled(P20, OIL, solver, drive, Feature(Waviness(height, 2.0)), time=Time(until=1.0, step=0.05)))


@pytest.mark.parametrize("load", [0.0, 0.3])
def test_rolling_over_waves_closes(load: float) -> None:
    found = imbalances(rolling(load=load))
    assert found["mass"] < 1e-12 and found["momentum"] < 1e-6 and found["energy"] < 0.015
    assert np.ptp(rolling(load=load).dataset["elastic_energy"].values) > 1e-3  # the waves change what is stored


MASSES = ("mass", "inflow", "outflow")  # the source of a cavity, a check, is zero
ENERGIES = ("elastic_energy", "oil_energy", "dissipation", "power_from_surfaces", "power_to_surfaces", "outside_power")


@pytest.mark.parametrize("term", MASSES + ENERGIES)
def test_a_budget_that_forgets_a_term_warns(term: str) -> None:
    """While the load grows; the whole budget is far from a warning."""
    whole, name = rolling(load=0.3), "mass" if term in MASSES else "energy"
    data = whole.dataset.sel(time=slice(None, 0.5))
    forgotten = data.assign({term: 0.0 * data[term]})
    closed, opened = (balances.in_time(whole.case, each)[name]["imbalance"] for each in (data, forgotten))
    assert closed is not None and opened is not None
    assert opened > LARGE_IMBALANCE > 2.5 * closed


def test_the_wave_that_slides_does_work() -> None:
    """It is part of the budget: without it the energy would not close."""
    with_wave, smooth = (rolling(height=height).summary["budgets"]["energy"] for height in (0.1, 1e-12))
    extra = with_wave["work_of_surfaces"] - smooth["work_of_surfaces"]
    turned_over = float(np.trapezoid(rolling().dataset["power_from_surfaces"], rolling().dataset["time"]))
    assert abs(extra) > 2 * with_wave["imbalance"] * turned_over


def test_both_directions_have_the_same_budgets() -> None:
    """The wave is even in X at T = 0."""
    there, back = (rolling(direction).summary["budgets"] for direction in (1.0, -1.0))
    for name in there:
        assert back[name] == pytest.approx(there[name], rel=1e-5, abs=1e-9)


def test_the_power_loss_is_that_of_sliding_and_of_the_pressure() -> None:
    """At every step: load times traction coefficient times sliding speed, and the dissipation."""
    d = rolling(load=0.3).dataset
    assert_allclose(d["power_loss"], 1.0 * d["U"] * d["mu_sliding"] * d["F"] + d["dissipation"], rtol=1e-10)
    assert float(d["mu_sliding"].min()) > 0 and float(d["mu_rolling"].min()) > 0
    assert rolling(load=0.3).summary["mu_sliding"] == float(d["mu_sliding"][-1])
    assert "mu_sliding_y" not in rolling(load=0.3).summary  # the waves run across: all is even in Y
    data = rolling().dataset
    assert data.attrs["energy_imbalance"] == imbalances(rolling())["energy"]
    assert {"mass", "outflow", "elastic_energy", "dissipation", "outside_power"} <= set(data.data_vars)
    assert float(data["dissipation"].min()) > 0
    assert data["dissipation"].sizes == {"time": 20}


def test_the_maps_are_those_of_their_film() -> None:
    """Between the steps too: stress and loss follow from the stored pressure and film."""
    case, d = rolling(load=0.3).case, rolling(load=0.3).dataset
    grid = grid_of(case)
    assert d.sizes["frame"] > 5
    for frame in (0, 3, -1):
        now = d.isel(frame=frame)
        c = discretise.contact_of(case, grid, float(now["frame"]))
        found = FRICTION(Plane.of(grid), c, *(jnp.asarray(now[name].values) for name in "PH"), 1.0, 1.0, 1.0)
        for name, expected in zip(("tau_x", "tau_y", "loss"), (*found.stress, found.loss), strict=True):
            assert_allclose(now[name], expected, rtol=1e-9, atol=1e-12, err_msg=name)
    assert float(d["tau_x"].max()) > 1.0


@pytest.mark.parametrize("method", ["2d", "radial"])
def test_an_impact_has_a_power_loss_and_no_traction(method: str) -> None:
    result = rebound(method)
    d, reached = result.dataset, result.summary
    assert_allclose(d["power_loss"], d["dissipation"], rtol=1e-12)
    assert_allclose(d["mu_sliding"], 0.0)
    assert_allclose(d["mu_rolling"], 0.0, atol=1e-12)
    assert "mu_sliding" not in reached and "mu_rolling" not in reached
    near = float(np.interp(reached["T"], d["time"], d["power_loss"]))
    assert reached["power_loss"] == pytest.approx(near, rel=0.05)
