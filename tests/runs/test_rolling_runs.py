"""Steady rolling contacts from file to summary, and when there is no result."""

from dataclasses import replace

import numpy as np
import pytest
from cases import ertel_
from stored_runs import CASES, ROLL, STEADY

import ertel
from ertel import plots
from ertel.case.status import Status
from ertel.inputs.case_files import parse_case
from ertel.results import diagnostics, variables
from ertel.runs.drive import simulate
from ertel.runs.store import RunStore, compute
from ertel.solvers import steady

pytestmark = pytest.mark.filterwarnings("ignore:H_min is uncertain", "ignore:there is no error estimate")
KEYS = "kind M L lambda_bar alpha_bar H_c H_min X_min Y_min Delta P_max load residual newton_iterations wall_s status "
KEYS += "krylov_iterations convolutions H_c_error H_min_error H_c_extrapolated H_min_extrapolated warnings si"
CASE = CASES["steady"]


def test_the_summary_of_a_steady_contact(kinds):
    whole, s = kinds["steady"].whole, CASE.scales
    summary = whole.summary
    assert summary.keys() >= set(KEYS.split())
    assert summary["load"] == pytest.approx(2 * np.pi / 3, rel=1e-7)
    last = whole.dataset.isel(grid=-1)
    there = [name for name in variables.names_where(lambda variable: variable.at_moment) if name in summary]
    assert len(there) > 8 and all(summary[name] == float(last[name]) for name in there)
    assert summary["newton_iterations"] == whole.dataset["newton_iterations"].sum()
    coarse, fine = whole.dataset["H_c"].values
    assert summary["H_c_error"] == pytest.approx(abs(fine - coarse) / 3)
    assert summary["H_c_extrapolated"] == pytest.approx(fine + (fine - coarse) / 3)
    assert s is not None
    films = [name for name in KEYS.split() if name.startswith(("H_c", "H_min"))]
    expected = {f"h{name[1:]}_m": summary[name] * s.film for name in films}
    expected |= {"load_N": 3.888524, "approach_m": summary["Delta"] * s.film}
    assert {name: summary["si"][name] for name in expected} == pytest.approx(expected, rel=1e-6, abs=0.0)
    assert {"delta_m", "u_m_m_per_s", "t0_s", "x_min_m", "y_min_m", "p_max_Pa"} <= set(summary["si"])
    assert "v0_m_per_s" not in summary["si"]


def test_the_film_and_its_error_bar_are_those_of_the_reference(nothing_outside):
    """The film on this grid and the converged one, of reference/rolling.json."""
    summary = simulate(CASE).summary
    assert summary["H_c"] == pytest.approx(0.4190912, rel=1e-4)
    for name, converged in {"H_c": 0.431967, "H_min": 0.292473}.items():
        true = abs(summary[name] - converged)
        assert true / 2 < summary[f"{name}_error"] < 2 * true


def said(solutions, case=CASE) -> str:
    return " ".join(diagnostics.steady_warnings(case, solutions))


def test_warnings_of_a_coarse_grid(grids):
    coarse, fine = grids
    narrow = replace(fine, outside=0.4 * CASE.geometry.hertz_load)
    for word, solutions in (
        ("no error estimate", [fine]),
        ("did not converge", [replace(coarse, status=Status.NEWTON_STALLED), fine]),
        ("overlap", [coarse, replace(fine, H=fine.H - 1)]),
        ("H_c is uncertain by about", [replace(coarse, H=0.5 * coarse.H), fine]),
        ("H_min is not known on this grid", [replace(coarse, H=3.0 * coarse.H), fine]),
        ("carries 40% of the load", [coarse, narrow]),
        ("the films are off by up to about 3%", [coarse, narrow]),
        ("use solver.half_width >= 5", [coarse, narrow]),
    ):
        assert word in said(solutions) and word not in said(grids)
    assert "is not a node" in said(grids, parse_case({**STEADY, "solver": {"nodes": 65, "inlet": 4.0}}))
    height, radius = (f"{0.1 * unit} m" for unit in (CASE.scales.film, CASE.scales.a))
    spot = {"shape": "spot", "height": height, "radius": radius, "surface": 2}
    rough = {**STEADY, "contact": ROLL | {"slide_to_roll": 2}, "roughness": [spot]}
    assert "2.1 cells" in said(grids, parse_case(rough))


def test_a_run_that_gives_up(tmp_path, monkeypatch, grids):
    coarse, fine = grids
    stalled = [coarse, replace(fine, status=Status.NEWTON_STALLED)]
    monkeypatch.setattr(steady, "nested", lambda case, done: iter(stalled[len(done) :]))
    run = RunStore.create(tmp_path / "run", CASE)
    summary = compute(run)
    assert (summary["status"], summary["H_c_error"]) == ("Newton iteration stalled", None)
    assert compute(RunStore.open(tmp_path / "run"))["status"] == "Newton iteration stalled"
    data = run.dataset()
    assert np.isnan(data["H"]).all() and np.isnan(data["P"]).all()  # the first guess stood there
    assert np.isfinite(data["H_c"]).values.tolist() == np.isfinite(data["mass"]).values.tolist() == [True, False]
    assert np.isfinite(data["history"][1, 0]) and data["newton_iterations"].dtype == float
    with pytest.raises(ValueError, match=r"has no solution \(Newton iteration stalled\)"):
        plots.draw(data, "film")
    assert "the run failed (Newton iteration stalled)" in ertel_("export", str(tmp_path / "run")).stderr


@pytest.mark.parametrize("M", [5, 10])
def test_the_default_domain_of_a_low_load_is_no_reason_for_a_warning(M):
    """H_c is within 0.2 % of that on a domain four times as wide."""
    low = parse_case({"contact": {"kind": "rolling", "M": M, "L": 10}, "solver": {"nodes": 33}})
    text = said([*steady.nested(low)], low)
    assert "inlet" not in text and "domain" not in text


def assert_without_numbers(summary):
    there = {*variables.names_where(lambda variable: variable.at_moment)} & summary.keys() - {"T"}
    assert len(there) > 8 and {summary[name] for name in (*there, "H_c_error", "H_min_error")} == {None}
    assert summary["budgets"] == {} and not summary.get("extremes")


def test_a_film_below_zero_is_no_result():
    """The same in time, where the film is the one at the start."""
    for method in ("steady", "transient"):
        result = simulate(ertel.rolling(M=20000, L=10, nodes=33, tolerance=0.03, method=method))
        assert (result.status, result.summary["status"]) == (Status.FILM_VANISHED, "the film vanishes on this grid")
        assert_without_numbers(result.summary)
        assert "the grid does not resolve the film" in result.warnings[0]
        assert "use solver.nodes >= 1409" in result.warnings[0]
        assert "%" not in " ".join(result.warnings)
        assert "no result" in repr(result) and "H_c" not in repr(result)


def test_an_iteration_that_leaves_the_numbers(tmp_path, monkeypatch):
    """It ends with a status, words and a summary.json, and the next grid begins from its first guess."""
    solve, guesses = steady._program, []

    def lost(problem, P, approach, P_f):
        guesses.append(approach)
        s, Delta = solve(problem, P, approach, P_f)
        return s._replace(P=np.nan * s.P, H=np.nan * s.H, residual=np.nan, history=np.nan * s.history), np.nan * Delta

    monkeypatch.setattr(steady, "_program", lost)
    compute(RunStore.create(tmp_path / "run", CASE))
    summary = RunStore.open(tmp_path / "run").summary()
    assert (summary["status"], summary["residual"]) == ("Newton iteration stalled", None)
    assert_without_numbers(summary)
    assert "the solution failed (the iteration led to values that are not numbers)" in summary["warnings"][0]
    assert np.isfinite(guesses).all() and len(guesses) == 3


@pytest.mark.parametrize(
    ("layer", "advice"),
    [(1e-9, "the film is too thin for any grid"), (1e-4, "use solver.nodes >= 321"), (0.05, "use solver.nodes >= 129")],
)
def test_a_grid_is_advised_only_where_one_can_help(layer, advice):
    """The gap between two nodes, spacing^2/4 at most off the line, is to be lower than the layer is thick."""
    assert diagnostics.no_film(ertel.rolling(M=20, L=5, layer=layer, nodes=65)).endswith(f"; {advice}")
