"""The sums of the budgets over a run, the warning, what is shown; and the load of the oil outside the domain."""

from functools import cache

import numpy as np
import pytest
import xarray as xr
from cases import impact
from made_up import BALL_FALLS, BALL_ROLLS, solutions

from ertel.case.case import Case
from ertel.case.status import Status
from ertel.equations.outside import around_circle
from ertel.inputs.case_files import parse_case
from ertel.physics.far_field import ContactMotion
from ertel.results import balances, diagnostics, variables
from ertel.results.dataset import assemble
from ertel.results.numbers import more_lines
from ertel.results.summary import attributes, impact_summary, steady_summary
from ertel.runs.drive import simulate
from ertel.runs.result import Result

T = np.linspace(0.1, 2.0, 20)


def falling(case: Case, **terms: np.ndarray) -> xr.Dataset:
    """A ball under a constant force 0.3, with uneven terms of the budgets that close exactly."""
    V = 1 - 0.3 * T / case.motion.inertia
    lost = case.motion.inertia / 2 * np.gradient(-(V**2), T, edge_order=2)
    known = {"F": np.full_like(T, 0.3), "V": V, "Delta": T, "dissipation": lost, "H_c": 1 + 0 * T, "H_min": 1 + 0 * T}
    known |= {"mass": 5 - T, "outflow": 1.5 + 0 * T, "inflow": 0.2 + 0 * T, "cavity_source": 0.3 + 0 * T, **terms}
    known["dT"] = np.full_like(T, 0.1)
    records = [
        {"T": t, **dict.fromkeys(variables.STEPS, 0.0), **{name: float(values[i]) for name, values in known.items()}}
        for i, t in enumerate(T)
    ]
    return assemble(case, records, [], {"Y": np.linspace(-2, 2, 33), "X": np.linspace(-2, 2, 33)})


def test_constant_rates_are_summed_exactly() -> None:
    case = impact(1000, 10, 33)
    found = balances.in_time(case, falling(case))
    assert found["momentum"]["ball"] == pytest.approx(-0.3 * 1.9, rel=1e-13)
    assert found["momentum"]["impulse_of_film"] == pytest.approx(0.3 * 1.9, rel=1e-13)
    assert found["mass"]["outflow"] == pytest.approx(1.5 * 1.9)
    for name, terms in found.items():
        assert terms["imbalance"] == pytest.approx(0.0, abs=1e-13), name
    assert diagnostics.balance_warnings(case, found) == []
    summary = impact_summary(case, falling(case).isel(time=slice(1)), None, {}, Status.CONVERGED)
    assert summary["budgets"] == {}  # before the second step
    assert not any("imbalance" in line for line in more_lines(summary))
    case = impact(1000, 10, 33)
    found = balances.in_time(case, falling(case, outflow=1.52 + 0 * T, elastic_energy=0.01 * T, F=0.31 + 0 * T))
    assert found["mass"]["imbalance"] == pytest.approx(0.02 / 1.52)
    kinetic = 0.4 * (1 - 0.03 / 0.8) ** 2
    assert found["energy"]["imbalance"] == pytest.approx(0.019 / kinetic)
    of_mass, of_momentum, of_energy = diagnostics.balance_warnings(case, found)
    assert of_mass.startswith("mass is not conserved: imbalance of 1.3% (limit 1%)")
    assert "use solver.nodes >= 65 and time.tolerance <= 1.25e-05" in of_mass
    assert of_energy.startswith("energy is not conserved: imbalance of 5.1%")
    assert of_momentum.endswith("the motion of the ball and the load differ; use time.tolerance <= 1.25e-05")


def test_a_summary_has_them_in_si_and_one_line_of_them() -> None:
    case = parse_case(BALL_FALLS)
    assert case.scales is not None
    summary = impact_summary(case, falling(case), None, {"steps": 20}, Status.CONVERGED)
    in_si, energy = summary["si"]["budgets"], summary["budgets"]["energy"]
    assert in_si["energy"]["dissipated_J"] == pytest.approx(energy["dissipated"] * case.scales.load * case.scales.film)
    # m v0^2/2 is 2/5 of the unit; the momentum m v0 is 4/5
    assert 2 / 5 * case.scales.energy == pytest.approx(0.0326726 * 0.1**2 / 2, rel=1e-4)
    assert 4 / 5 * case.scales.momentum == pytest.approx(0.0326726 * 0.1, rel=1e-4)
    assert set(in_si["mass"]) == {"stored_m3", "inflow_m3", "outflow_m3", "cavity_source_m3"}
    assert list(more_lines(summary))[-1].startswith("imbalance: mass ")
    assert attributes(summary)["energy_imbalance"] == energy["imbalance"]


def test_a_steady_contact_has_rates() -> None:
    summary = steady_summary(BALL_ROLLS, solutions(BALL_ROLLS), {}, Status.CONVERGED)
    assert set(summary["budgets"]["energy"]) == {"dissipated", "outside", "work_of_surfaces", "imbalance"}
    assert summary["budgets"]["momentum"] == {"applied_load": 1.0, "film_load": pytest.approx(1.0), "imbalance": 0.0}
    assert summary["si"]["budgets"]["momentum"]["film_load_N"] == pytest.approx(38.885237)
    assert {"dissipated_W", "outside_W", "work_of_surfaces_W"} == set(summary["si"]["budgets"]["energy"])
    said = " ".join(summary["warnings"])  # a made-up film breaks them
    assert "energy is not conserved" in said and "use solver.nodes >= 161" in said


HERTZ = 2 * np.pi / 3


def lost(w: float, gap: float) -> float:
    """The load that a rigid ball with V = 1 in oil with lambda_bar = 0.1 loses by P = 0 at r = w, exactly."""
    H = gap + w**2 / 2
    whole = np.pi / 2 * 0.1 / gap
    within = np.pi / 2 * 0.1 * (1 / gap - 1 / H) - np.pi * w**2 * 0.1 / 4 / H**2
    return (whole - within) / (2 * np.pi / 3)


@pytest.mark.parametrize("w", [2.0, 4.0])
@pytest.mark.parametrize("gap", [0.05, 0.2])
def test_the_oil_outside_adds_as_much_inside(w: float, gap: float) -> None:
    oil = around_circle(np.linspace(0.0, w, 9), 0.1)
    load = oil.at(ContactMotion(-gap, 1.0, 0.0, 0.0)).load / HERTZ
    assert 2 * load == pytest.approx(lost(w, gap), rel=0.05)


@cache
def run(M: float, L: float, half_width: float) -> Result:
    return simulate(impact(M, L, 129, solver={"method": "radial", "half_width": half_width}))


def compared(M: float, L: float, narrow: float, wide: float) -> tuple[list[str], list[float]]:
    """What is said of the domain that is narrow, and by how much approach and load are off; nothing of the wide one."""
    runs = run(M, L, narrow), run(M, L, wide)
    ours, others = (each.summary for each in runs)
    said, nothing = ([warning for warning in each.warnings if "outside the domain" in warning] for each in runs)
    assert nothing == []
    return said, [abs(ours[name] / others[name] - 1) for name in ("Delta", "F")]


def test_the_stated_error_is_the_true_one() -> None:
    """Within a factor of two, for approach and load; and the advised width is enough."""
    narrow = run(20, 5, 2.0)
    share = balances.uncertain_momentum(narrow.case, narrow.dataset)
    advised = balances.needed_half_width(narrow.case, narrow.dataset)
    [warning], off = compared(20, 5, 2.0, advised)
    assert f"uncertain by about {share:.1%} of the ball's" in warning
    assert f"use solver.half_width >= {advised:g}" in warning
    assert all(0.5 < share / each < 2 for each in off)
    said, off = compared(100, 10, 2.0, 4.0)
    assert said == [] and max(off) < balances.UNCERTAIN_MOMENTUM
