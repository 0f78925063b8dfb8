"""The outcome of a run as plain data: values in SI, extremes, coefficients of friction, and the error of a run."""

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
import xarray as xr
from cases import impact
from made_up import BALL_FALLS, BALL_ROLLS, C1, MOES_FALLS, MOES_ROLLS, as_in_time, dry_impact, in_time

import ertel
from ertel.apps.tables import film_rows, value_rows
from ertel.case.case import Case
from ertel.case.estimates import grid_of
from ertel.case.sections import Time
from ertel.case.status import Status
from ertel.inputs.case_files import parse_case
from ertel.physics import hertz
from ertel.physics.film_formulas import FormulaFilm
from ertel.physics.units import Quantity
from ertel.results import parameters
from ertel.results.numbers import key_numbers, lines, more_lines, number, scalars
from ertel.results.summary import comparisons, extremes, impact_summary, rolling_summary, with_error
from ertel.results.variables import names_where, to_si, with_coefficients
from ertel.runs.drive import simulate
from ertel.solvers import radial

AT_MAXIMUM = [
    name
    for name in names_where(lambda variable: variable.at_moment and not variable.of_touch)
    if not name.startswith("mu_")
]
WORK = {"steps": 1, "newton_iterations": 1, "krylov_iterations": 1, "wall_s": 1.0}


def test_duration_and_largest_load_of_an_impact() -> None:
    """Of the dry one F = Delta^(3/2), so that F = 0.01 at Delta = 0.01^(2/3)."""
    case, data = parse_case(BALL_FALLS), dry_impact(MOES_FALLS)
    assert impact_summary(case, data, None, {}, Status.CONVERGED)["contact_time"] is None  # not yet free
    left = data.assign(F=data["F"].where(data["time"] < 3.9, 0.0))
    summary = impact_summary(case, left, None, {}, Status.CONVERGED)
    duration = hertz.CONTACT_TIME - 2 * float(hertz.time_at(0.01 ** (2 / 3)))
    assert summary["contact_time"] == pytest.approx(duration, abs=0.02)  # the steps are 0.05
    assert summary["F_max"] == pytest.approx(1.0, abs=1e-3)
    assert summary["si"]["t_contact_s"] == pytest.approx(summary["contact_time"] * case.scales.t0)
    assert summary["si"]["f_max_N"] == pytest.approx(summary["F_max"] * case.scales.load)


def test_films_of_another_load_speed_and_radius() -> None:
    """As if the case had been given with them."""
    a, known = BALL_ROLLS, BALL_ROLLS.contact
    other = {"load": 2 * known.load, "mean_speed": 3 * known.mean_speed, "radius": known.radius / 1.5}
    b = replace(a, contact=replace(known, **other))
    for one, two in zip(parameters.formula_films(a, 2.0, -3.0, 1.5), parameters.formula_films(b), strict=True):
        for p, q in ((one.central, two.central), (one.minimum, two.minimum)):
            assert (p is None and q is None) or p * a.scales.film == pytest.approx(q * b.scales.film)
    assert parameters.formula_films(a, 1.0, 0.0) == []


def with_a_peak(data: xr.Dataset, fall: float) -> xr.Dataset:
    """The highest pressure, 3.2, at the eighth step."""
    at = np.arange(data.sizes["time"]) == 7
    places = {"P_max": 3.2, "X_P_max": 0.9, "Y_P_max": -0.1, "P_fall": fall}
    return data.assign({name: ("time", np.where(at, value, data[name].values)) for name, value in places.items()})


def test_the_extremes_of_the_whole_run() -> None:
    data = with_a_peak(in_time(BALL_ROLLS), 0.02)
    thin = int(np.argmin(data["H_min"].values))
    assert float(data["H_min"][thin]) < float(data["H_min"][0])
    place = {"T": float(data["time"][thin]), "X": 0.2, "Y": 0.8}
    assert extremes(data) == {
        "H_min": {"value": float(data["H_min"][thin]), **place, "note": ""},
        "P_max": {"value": 3.2, "T": pytest.approx(0.7), "X": 0.9, "Y": -0.1, "note": ""},
    }
    assert extremes(data.isel(time=slice(0, 0))) == {}
    summary = rolling_summary(as_in_time(BALL_ROLLS), data, WORK, Status.CONVERGED)
    assert summary["si"]["extremes"]["P_max"] == {
        **{"p_max_Pa": pytest.approx(3.2 * C1.p_h), "t_s": pytest.approx(0.7 * C1.t0)},
        **{"x_m": pytest.approx(0.9 * C1.a), "y_m": pytest.approx(-0.1 * C1.a)},
    }
    thinnest, highest = list(more_lines(summary))[:2]
    assert "nm (" in thinnest and "GPa (3.2 p_h) at t = " in highest and "µm" in highest
    data = with_a_peak(in_time(MOES_ROLLS), 0.85)
    summary = rolling_summary(as_in_time(MOES_ROLLS), data, WORK, Status.CONVERGED)
    (line,) = [line for line in lines(summary) if "highest pressure" in line]
    assert "P_max: 3.2 p_h at T = 0.7 t0, X = 0.9, Y = -0.1 a; it depends on the grid" in line and "85% lower" in line
    assert any("the film is not resolved in the inlet" in warning for warning in summary["warnings"])


@pytest.fixture(scope="module")
def run() -> ertel.Result:
    contact = {"radius": "10 mm", "load": "20 N", "mean_speed": 1.0, "E_prime": "226 GPa", "slide_to_roll": 0.01}
    return ertel.simulate(ertel.rolling(**contact, oil=ertel.Oil(eta0="20 mPa*s", alpha="15 / GPa"), nodes=33))


def test_one_number_everywhere(run: ertel.Result) -> None:
    """In the summary, in SI, in the Dataset, in tables; a dimensionless case does not know a/R."""
    summary, mu = run.summary, run.summary["mu_sliding"]
    assert 0.001 < mu < 0.1  # 60 times as much in units a/R
    assert summary["si"]["mu_sliding"] == mu == float(run.dataset["mu_sliding"][-1])
    assert "in_units_of" not in run.dataset["mu_sliding"].attrs
    assert float(to_si(run.dataset)["mu_sliding"][-1]) == mu == scalars(summary)["mu_sliding"].value
    (shown,) = [number for number in key_numbers(summary) if number.about.symbol == "mu_sliding"]
    assert (shown.text, shown.text_in_si) == (f"{mu:.4g}", "")
    cell = float(run.dataset["X"][1] - run.dataset["X"][0]) ** 2
    force = float(run.dataset["tau_x"].sum()) * cell * run.case.scales.a_over_R
    assert mu == pytest.approx(force * 3 / (2 * np.pi), rel=0.02)
    assert with_coefficients({"mu_sliding": 2.0, "H_c": 0.1}, None) == {"mu_sliding": 2.0, "H_c": 0.1}


def test_a_film_that_vanished_has_no_numbers() -> None:
    """Nor has the impact as a whole, though the ball came back."""
    case, data = parse_case(MOES_FALLS), dry_impact(MOES_FALLS)
    data["V"][-1], data["F"][-1] = -0.9, 0.0
    last = data["H_min"].values.size - 1
    reached = {**dict.fromkeys((*AT_MAXIMUM, "power_loss"), 1.0), "T": 0.5}
    whole = impact_summary(case, data, reached, {}, Status.CONVERGED)
    assert whole["restitution"] == 0.9
    data["H_min"][last] = 0.0
    gone = impact_summary(case, data, reached, {}, Status.CONVERGED)
    assert gone["status"] == Status.FILM_VANISHED.value
    assert gone["restitution"] is gone["contact_time"] is gone["F_max"] is gone["T"] is gone["H_c"] is None
    assert not key_numbers(gone)
    # At M = 1e-3 it left eight times as fast, with a restitution of 8.0.
    case, data = parse_case(MOES_FALLS), dry_impact(MOES_FALLS)
    data["V"][-1], data["F"][-1] = -8.0, 0.0
    wrong = impact_summary(case, data, None, {}, Status.CONVERGED)
    assert wrong["restitution"] is wrong["contact_time"] is wrong["F_max"] is None
    assert any("the ball leaves 8 times as fast as it came" in words for words in wrong["warnings"])
    loaded = parse_case({**MOES_FALLS, "motion": {"load": [[0, 1], [1, 0]]}})
    assert impact_summary(loaded, data, None, {}, Status.CONVERGED)["restitution"] == 8.0  # the load may have done it


def test_an_approach_in_si_is_told_from_that_of_the_dry_contact() -> None:
    steel = {"radius": 0.01, "ball_density": 7850, "speed": 0.1, "E_prime": "226 GPa", "method": "radial"}
    fall = ertel.impact(**steel, oil=ertel.Oil(eta0=0.0186, alpha=20e-9), nodes=33, until="max-approach")
    summary = ertel.simulate(fall).summary
    assert summary["si"]["approach_m"] == summary["Delta"] * fall.scales.film
    assert summary["si"]["delta_m"] == fall.scales.approach
    least, most = fall.parameters.impact_films
    assert least < summary["H_c"] < most < fall.parameters.trapped_film


def test_tables_show_the_extrapolated_value_with_its_error_and_that_on_the_grid(run: ertel.Result) -> None:
    case, film = run.case, FormulaFilm("formula", 0.12, 0.06, "source", "valid", True)
    values = {"H_c": (0.11, 0.011, 0.10), "H_min": (0.05, 0.025, 0.04)}
    computed = {name: number(case.kind, case.scales, name, *known) for name, known in values.items()}
    columns = list(zip(*film_rows(case, [film], computed), strict=True))
    assert columns[0][1:] == ("computed", "computed, on the grid", "formula")
    assert columns[2][1:] == ("+-10.0%", "", "+9.1%") and columns[4][1:] == ("+-50.0%", "", "+20.0%")
    head, row = value_rows("", [computed["H_c"]])
    assert head[2:] == ["value", "in SI", "error", "on the grid", "in SI"]
    assert float(row[3].split()[0]) == pytest.approx(1.1 * float(row[6].split()[0]), rel=1e-3)


@pytest.mark.parametrize("status", [Status.NEWTON_STALLED, Status.STEP_TOO_SMALL])
def test_a_failed_run_in_time_hands_out_no_numbers(status: Status) -> None:
    """Neither those at maximum approach, which it had reached, nor extremes and the last values."""
    reached = dict.fromkeys((*AT_MAXIMUM, "power_loss"), 1.0)
    for summary in (
        impact_summary(parse_case(MOES_FALLS), dry_impact(MOES_FALLS), reached, {"steps": 1}, status),
        rolling_summary(as_in_time(MOES_ROLLS), in_time(MOES_ROLLS), {"steps": 1}, status),
    ):
        assert set(scalars(summary)) == {"M", "L"}
        assert summary["H_c"] is None
        assert not summary["extremes"] and not summary["budgets"]
        assert f"no result: {status.value}" in "\n".join(lines(summary))


@pytest.mark.parametrize("nodes", [65, 97, 129, 257, 385])
def test_the_wider_grid_has_the_spacing_and_the_nodes_of_the_half_grid(nodes: int) -> None:
    case = parse_case({"contact": {"kind": "rolling", "M": 100, "L": 5}, "solver": {"nodes": nodes}})
    assert sorted(comparisons(case)) == ["domain", "grid"]  # a steady contact has no error in time
    half, wide = (grid_of(comparisons(case)[name]) for name in ("grid", "domain"))
    assert wide.spacing == pytest.approx(half.spacing, rel=1e-12)
    assert -wide.x[0] == pytest.approx(1.5 * -half.x[0], rel=0.03)
    assert wide.x[-1] == pytest.approx(1.5 * half.x[-1], rel=0.03)
    assert np.abs(wide.x).min() == pytest.approx(0, abs=1e-9)


def test_the_wider_radial_grid_is_as_fine_in_the_contact() -> None:
    found = comparisons(impact(200, 10, 129, solver={"method": "radial", "half_width": 4.0}))
    half, wide = (radial.radii(found[name].solver.nodes, found[name].solver.half_width) for name in ("grid", "domain"))
    assert (half[-1], wide[-1]) == (4.0, 6.0)
    assert np.diff(wide).min() == pytest.approx(np.diff(half).min(), rel=0.02)
    assert Time(step=0.02).with_steps(0.5**0.5).step == pytest.approx(0.02 * 0.5**0.5)
    assert Time(step=Quantity(1e-5, "s")).with_steps(0.5**0.5).step == Quantity(1e-5 * 0.5**0.5, "s")
    assert Time(tolerance=8e-4).with_steps(0.5**0.5).tolerance == pytest.approx(8e-4 / 8**0.5)


def ball(nodes: int, half_width: float, tolerance: float, until: Any, M: float = 50, L: float = 5) -> Case:
    solver = {"method": "radial", "half_width": half_width}
    return impact(M, L, nodes, solver=solver, time={"tolerance": tolerance, "until": until})


FINEST = {"H_c": 0.20693013337, "Delta": 0.66208490757}  # what `truth` computes of M = 50, L = 5 at maximum approach


@cache
def truth(until: Any, *contact: float) -> dict[str, float]:
    return dict(simulate(ball(401, 12.0, 1e-5, until, *contact)).summary)


@pytest.mark.slow
def test_the_finest_run_gives_what_the_estimates_are_compared_with() -> None:
    assert {name: truth("max-approach")[name] for name in FINEST} == pytest.approx(FINEST, rel=1e-6)


def ratios(
    half_width: float, tolerance: float, until: Any, *names: str, contact: tuple[float, ...] = ()
) -> tuple[dict[str, Any], list[float]]:
    """The estimates of a run, and the true errors over the estimated ones.  contact: M and L."""
    case = ball(129, half_width, tolerance, until, *contact)
    others = {name: simulate(other).summary for name, other in comparisons(case).items()}
    found: dict[str, Any] = with_error(case, simulate(case).summary, others)["error_estimate"]
    exact = FINEST if until == "max-approach" else truth(until, *contact)
    return found, [abs(found[name]["value"] - exact[name]) / found[name]["error"] for name in names]


@pytest.mark.parametrize(
    ("half_width", "tolerance"),
    [*(pytest.param(*each, marks=pytest.mark.slow) for each in ((3.0, 5e-5), (8.0, 3e-4))), (2.0, 5e-5)],
)
def test_the_estimate_is_honest(half_width: float, tolerance: float) -> None:
    """True error over estimated error: for H_c a half to 2; Delta's parts may cancel, it is never understated."""
    found, (H_c, Delta) = ratios(half_width, tolerance, "max-approach", "H_c", "Delta")
    assert 0.5 < H_c < 2, found["H_c"]
    assert (0.5 if half_width == 2.0 else 0) < Delta < 2, found["Delta"]
    assert found["H_c"]["dominant"] == "time"
    assert half_width > 2 or found["Delta"]["dominant"] == "domain"


@pytest.mark.slow
@pytest.mark.parametrize(("half_width", "tolerance"), [(3.0, 5e-5), (8.0, 3e-4), (2.0, 5e-5)])
def test_the_estimates_of_a_whole_impact_are_honest(half_width: float, tolerance: float) -> None:
    """True error over estimated error of restitution, contact time and largest load: all bars hold the truth."""
    _, off = ratios(half_width, tolerance, "rebound", *names_where(lambda variable: variable.of_impact))
    assert all(0.3 < each < 1 for each in off), off


@pytest.mark.slow
@pytest.mark.parametrize("M", [200, 1000])
def test_the_bar_of_a_restitution_holds_the_truth(M: float) -> None:
    """Also at high loads, where most of the error is of the spacing and of first order."""
    _, (off,) = ratios(3.0, 5e-5, "rebound", "restitution", contact=(M, 10))
    assert 0.3 < off < 1
