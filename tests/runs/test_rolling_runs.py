"""Rolling cases from file to summary: what is stored and printed; no moment of death costs more than a grid."""

import itertools
import json
import signal
import warnings
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from cases import ertel_, go_on, names, physics, stop_after

from ertel.inputs.case_files import load_case, parse_case
from ertel.model.status import Status
from ertel.results import diagnostics, summary, variables
from ertel.results.provenance import describe
from ertel.runs import store
from ertel.runs.drive import simulate
from ertel.runs.store import RunStore, SteadyStore, StoreError
from ertel.solvers import steady

OIL = {"viscosity": "barus", "density": "incompressible", "eta0": "40 mPa*s", "alpha": "22 / GPa"}
CONTACT = {  # of reference/rolling.json, M = 20, L = 10
    **{"kind": "rolling", "radius": "10 mm", "E_prime": "219.7802 GPa"},
    **{"load": "3.888524 N", "mean_speed": "0.502636 m/s"},
}
CASE = {"name": "small", "contact": CONTACT, "lubricant": OIL, "solver": {"nodes": 65}}
KEYS = [  # the issue's
    *("kind", "M", "L", "lambda_bar", "alpha_bar", "H_c", "H_min", "X_min", "Y_min", "Delta", "P_max", "load"),
    *("residual", "newton_iterations", "krylov_iterations", "convolutions", "wall_s", "status"),
    *("H_c_error", "H_min_error", "H_c_extrapolated", "H_min_extrapolated", "warnings", "si"),
]


@pytest.fixture(scope="module")
def case():
    return parse_case(CASE)


@pytest.fixture(scope="module")
def whole(case):
    return simulate(case)


@pytest.fixture
def here(tmp_path, monkeypatch):
    """An empty working directory with cases in it."""
    monkeypatch.chdir(tmp_path)
    oil = "\n".join(f'{key} = "{value}"' for key, value in OIL.items())
    contact = "\n".join(f'{key} = "{value}"' for key, value in CONTACT.items())
    (tmp_path / "steady.toml").write_text(f"[contact]\n{contact}\n[lubricant]\n{oil}\n[solver]\nnodes = 65\n")
    transient = '[contact]\nkind = "rolling"\nM = 20\nL = 10\n[solver]\nmethod = "transient"\nnodes = 33\n'
    motion = "[motion]\nload = { mean = 1, amplitude = 0.1, period = 1 }\n"
    (tmp_path / "transient.toml").write_text(f"{transient}{motion}[time]\nuntil = 0.3\ntolerance = 0.01\n")
    return tmp_path


# -- in memory --------------------------------------------------------------------------------------------------------


def test_the_dataset_of_a_steady_contact(whole):
    data = whole.dataset
    assert dict(data.sizes) == {"Y": 65, "X": 65, "grid": 2, "iteration": data.sizes["iteration"]}
    assert data["grid"].values.tolist() == [33, 65]
    assert data["H"].dims == data["P"].dims == ("Y", "X")
    assert data["history"].dims == ("grid", "iteration")
    assert (data.attrs["kind"], data.attrs["method"], data.attrs["status"]) == ("rolling", "steady", "converged")
    for name, variable in data.variables.items():
        assert {"units", "long_name", "symbol"} <= set(variable.attrs), name
    iterations = data["newton_iterations"].values.astype(int)
    for row, last, residual in zip(data["history"].values, iterations, data["residual"].values, strict=True):
        assert row[last] == residual <= 1e-8
        assert np.isnan(row[last + 1 :]).all()


def test_the_dataset_in_si(whole, case):
    si, s = variables.to_si(whole.dataset), case.scales
    assert s is not None
    last = whole.dataset.isel(grid=-1)
    assert si["load"].values[-1] == pytest.approx(3.888524, rel=1e-6)
    assert si["h_c"].values[-1] == pytest.approx(float(last["H_c"]) * s.film)
    assert si["h"].dims == ("y", "x")
    assert si["y_min"].attrs["units"] == "m"


def test_the_summary_of_a_steady_contact(whole, case):
    summary, s = whole.summary, case.scales
    assert set(KEYS) <= set(summary)
    assert summary["H_c"] == pytest.approx(0.4818634, rel=1e-4)  # reference/rolling.json
    assert summary["load"] == pytest.approx(2 * np.pi / 3, rel=1e-7)
    last = whole.dataset.isel(grid=-1)
    assert all(summary[name] == float(last[name]) for name in variables.MEASURED)
    assert summary["newton_iterations"] == whole.dataset["newton_iterations"].sum()
    coarse, fine = whole.dataset["H_c"].values
    assert summary["H_c_error"] == pytest.approx(abs(fine - coarse) / 3)
    assert summary["H_c_extrapolated"] == pytest.approx(fine + (fine - coarse) / 3)
    assert s is not None
    for name in ("h_c", "h_min", "h_c_error", "h_min_error", "h_c_extrapolated", "h_min_extrapolated"):
        assert summary["si"][f"{name}_m"] == pytest.approx(summary[f"H{name[1:]}"] * s.film)
    assert summary["si"]["load_N"] == pytest.approx(3.888524, rel=1e-6)
    assert summary["si"]["approach_m"] == pytest.approx(summary["Delta"] * s.film)
    assert {"delta_m", "u_m_m_per_s", "t0_s", "x_min_m", "y_min_m", "p_max_Pa"} <= set(summary["si"])
    assert "v0_m_per_s" not in summary["si"]


def test_the_error_bar_is_honest(whole):
    """Converged values of reference/rolling.json."""
    for name, converged in {"H_c": 0.49752, "H_min": 0.306632}.items():
        true = abs(whole.summary[name] - converged)
        assert true / 2 < whole.summary[f"{name}_error"] < 2 * true


def test_one_grid_has_no_error_bar():
    summary = simulate(parse_case({**CASE, "solver": {"nodes": 33}})).summary
    assert summary["H_c_error"] is summary["H_min_extrapolated"] is summary["si"]["h_c_error_m"] is None
    assert any("no error estimate" in warning for warning in summary["warnings"])


def test_what_moves_is_in_the_provenance():
    rough = [{"shape": "waviness", "amplitude": 0.1, "wavelength_x": 1.0}]
    moving = {"solver": {"method": "transient"}, "motion": {"slide_to_roll": 0.5}, "roughness": rough}
    described = describe(parse_case({"contact": {"kind": "rolling", "M": 20, "L": 10}, **moving}))
    assert described["motion"] == {
        "load": {"law": "Polyline", "points": ((0.0, 1.0),)},
        "entrainment": {"law": "Polyline", "points": ((0.0, 1.0),)},
        "inertia": 0.0,
        "slide_to_roll": 0.5,
    }
    assert json.loads(json.dumps(described["roughness"])) == [
        {
            **{"surface": 1, "law": "Waviness", "amplitude": 0.1, "wavelength_x": 1.0},
            **{"phase_x": 0.0, "phase_y": 0.0, "ramp": 0.0},
        }
    ]


# -- warnings ---------------------------------------------------------------------------------------------------------


def said(solutions, case) -> str:
    return " ".join(diagnostics.steady_warnings(case, solutions))


def test_warnings_of_a_coarse_grid(case):
    from dataclasses import replace

    coarse, fine = steady.nested(case)
    assert "no error estimate" in said([fine], case)
    assert "did not converge" in said([replace(coarse, status=Status.NEWTON_STALLED), fine], case)
    assert "overlap" in said([coarse, replace(fine, H=fine.H - 1)], case)
    assert "H_c is uncertain by about" in said([replace(coarse, H=0.5 * coarse.H), fine], case)
    assert "is not a node" in said([coarse, fine], parse_case({**CASE, "solver": {"nodes": 65, "inlet": 4.0}}))
    narrow = parse_case({**CASE, "solver": {"nodes": 33, "half_width": 2.0, "inlet": 2.75}})
    assert "the inlet is too short" in said([*steady.nested(narrow)], narrow)
    assert "the inlet is too short" not in said([coarse, fine], case)
    spot = {"shape": "spot", "height": 0.1, "radius": 0.1, "surface": 2}
    contact = CONTACT | {"slide_to_roll": 2}
    assert "2.1 cells" in said([coarse, fine], parse_case({**CASE, "contact": contact, "roughness": [spot]}))


# -- stored -----------------------------------------------------------------------------------------------------------


def test_a_stored_run_is_the_run_in_memory(tmp_path, case, whole):
    run = RunStore.create(tmp_path / "run", case)
    assert isinstance(run, SteadyStore)
    summary = store.run(run, go_on)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        data = xr.open_zarr(tmp_path / "run" / "run.zarr").load()  # and nothing else
    xr.testing.assert_identical(physics(data), physics(whole.dataset))
    assert data.attrs["status"] == "converged"
    assert data.attrs["H_c"] == summary["H_c"]
    assert run.summary() == summary
    same = {key: value for key, value in summary.items() if key not in ("wall_s", "compilations")}
    assert same.items() <= dict(whole.summary).items()
    assert load_case(tmp_path / "run" / "case.toml") == case
    assert names(tmp_path / "run") == {"case.toml", "run.zarr", "checkpoint.npz", "summary.json"}


def test_resumed_equals_uninterrupted(tmp_path, case, whole):
    run = RunStore.create(tmp_path / "run", case)
    summary = store.run(run, stop_after(1))
    assert (summary["status"], summary["nodes"]) == ("interrupted", 33)
    assert xr.open_zarr(tmp_path / "run" / "run.zarr").sizes["X"] == 33
    again = RunStore.open(tmp_path / "run")
    assert store.run(again, go_on)["status"] == "converged"
    xr.testing.assert_identical(physics(again.dataset()), physics(whole.dataset))
    assert again.solutions()[-1].history == tuple(
        whole.dataset["history"].values[-1][: len(again.solutions()[-1].history)]
    )


class Killed(BaseException):
    """Nobody catches it, like SIGKILL."""


PLACES = [(store, "_commit"), (SteadyStore, "_make_data"), (SteadyStore, "_write_checkpoint"), (Path, "rename")]


@pytest.mark.filterwarnings("ignore:Failed to open Zarr store with consolidated metadata")
@pytest.mark.parametrize(("place", "name"), PLACES)
@pytest.mark.parametrize("when", ["before", "after"])
@pytest.mark.parametrize("count", [1, 2, 3, 4])
def test_death_at_any_moment(tmp_path, monkeypatch, case, whole, place, name, when, count):
    known = steady.nested(case)
    solutions = [next(known), next(known)]
    monkeypatch.setattr(steady, "nested", lambda case, done: iter(solutions[len(done) :]))
    run = RunStore.create(tmp_path / "run", case)
    original, calls = getattr(place, name), itertools.count(1)

    def deadly(*arguments, **options):
        last = next(calls) == count
        if last and when == "before":
            raise Killed
        result = original(*arguments, **options)
        if last:
            raise Killed
        return result

    with monkeypatch.context() as patch:
        patch.setattr(place, name, deadly)
        try:
            store.run(run, go_on)
        except Killed:
            pass
        else:
            assert next(calls) <= count
    again = RunStore.open(tmp_path / "run")
    assert again.dataset().sizes["X"] in (33, 65)
    store.run(again, go_on)
    xr.testing.assert_identical(physics(again.dataset()), physics(whole.dataset))
    assert names(tmp_path / "run") == {"case.toml", "run.zarr", "checkpoint.npz", "summary.json"}


def test_a_run_that_gives_up(tmp_path, monkeypatch, case):
    from dataclasses import replace

    coarse, fine = steady.nested(case)
    stalled = [coarse, replace(fine, status=Status.NEWTON_STALLED)]
    monkeypatch.setattr(steady, "nested", lambda case, done: iter(stalled[len(done) :]))
    run = RunStore.create(tmp_path / "run", case)
    summary = store.run(run, go_on)
    assert (summary["status"], summary["H_c_error"]) == ("Newton stalled", None)
    assert store.run(RunStore.open(tmp_path / "run"), go_on)["status"] == "Newton stalled"


def test_nothing_computed_yet(tmp_path, case):
    run = RunStore.create(tmp_path / "run", case)
    data = run.dataset()
    assert (data.sizes["grid"], data.sizes["X"]) == (0, 65)
    assert np.isnan(data["H"].values).all()
    with pytest.raises(StoreError, match="nothing is computed yet"):
        run.summary_so_far()


# -- from the command line --------------------------------------------------------------------------------------------


def test_run_show_and_plot(here):
    text = ertel_("run", "steady.toml", "--error").stdout  # --error changes nothing: a steady run has its estimate
    for part in ("converged", "H_c", "error", "extrapolated", "nm", "Nijenbanning", "Hamrock", "computed", "%"):
        assert part in text
    assert text == ertel_("show", "runs/steady").stdout
    summary = json.loads(ertel_("show", "runs/steady", "--json").stdout)
    assert set(KEYS) <= set(summary)
    printed = ertel_("plot", "runs/steady").stdout.split()
    assert {Path(path).stem for path in printed} >= {"film", "pressure", "midlines", "convergence"}
    assert all(Path(path).read_bytes().startswith(b"\x89PNG") for path in printed)


def test_run_json_is_json_and_nothing_else(here):
    result = ertel_("run", "steady.toml", "--out", "here", "--json", "--set", "solver.nodes=33")
    assert result.stdout == (here / "here" / "summary.json").read_text()
    assert json.loads(result.stdout)["status"] == "converged"


def test_interrupt_and_resume(here, monkeypatch, whole):
    original = SteadyStore._write_checkpoint

    def write(self, arrays):
        original(self, arrays)
        signal.raise_signal(signal.SIGINT)

    with monkeypatch.context() as patch:
        patch.setattr(SteadyStore, "_write_checkpoint", write)
        result = ertel_("run", "steady.toml", "--out", "cut", code=130)
    assert "interrupted; to continue: ertel resume cut" in result.stderr
    assert json.loads(ertel_("show", "cut", "--json").stdout)["nodes"] == 33
    ertel_("resume", "cut", "-q")
    assert json.loads(ertel_("show", "cut", "--json").stdout)["nodes"] == 65
    xr.testing.assert_identical(physics(RunStore.open(here / "cut").dataset()), physics(whole.dataset))


def test_a_run_under_way(here, case):
    run = RunStore.create(here / "cut", case)
    ertel_("show", "cut", code=2)
    ertel_("plot", "cut", code=2)
    next(run.course())
    summary = json.loads(ertel_("show", "cut", "--json").stdout)
    assert (summary["status"], summary["nodes"]) == ("running", 33)


def test_a_transient_run(here):
    text = ertel_("run", "transient.toml").stdout
    for part in ("at the last time", "H_c", "Nijenbanning", "steps"):
        assert part in text
    summary = json.loads(ertel_("show", "runs/transient", "--json").stdout)
    assert summary["T"] == pytest.approx(0.3)
    assert summary["H_c_error"] is None
    assert {"steps", "newton_iterations", "krylov_iterations", "convolutions"} <= set(summary)
    assert {"max_approach", "restitution"}.isdisjoint(summary)
    data = RunStore.open(here / "runs" / "transient").dataset()
    w = 1 + 0.1 * np.sin(2 * np.pi * data["time"].values)
    np.testing.assert_allclose(data["w"].values, w, rtol=1e-12)
    np.testing.assert_allclose(data["F"].values, w, rtol=1e-3)
    assert summary["load"] == pytest.approx(2 * np.pi / 3 * w[-1], rel=1e-3)
    assert np.all(data["U"].values == 1.0)
    printed = ertel_("plot", "runs/transient").stdout.split()
    assert "overview.png" in {Path(path).name for path in printed}


def test_the_error_of_a_transient_run(here):
    fine = json.loads(ertel_("run", "transient.toml", "--set", "solver.nodes=65", "--error", "--json").stdout)
    coarse = json.loads(ertel_("run", "transient.toml", "--json").stdout)
    for name in ("H_c", "H_min"):
        assert fine[f"{name}_error"] == pytest.approx(abs(fine[name] - coarse[name]) / 3)
        assert fine[f"{name}_extrapolated"] == pytest.approx(fine[name] + (fine[name] - coarse[name]) / 3)


def test_a_transient_run_resumed(here):
    ertel_("run", "transient.toml", "--out", "whole", "-q")
    run = RunStore.create(here / "cut", load_case("transient.toml"))
    store.run(run, stop_after(3))
    ertel_("resume", "cut", "-q")
    cut, whole = (RunStore.open(here / name).dataset() for name in ("cut", "whole"))
    xr.testing.assert_identical(physics(cut), physics(whole))


def test_a_transient_run_that_cannot_begin(here, monkeypatch):
    monkeypatch.setattr(import_module("ertel.runs.drive"), "SMALLEST_STEP", 10.0)
    result = ertel_("run", "transient.toml", code=1)
    assert "failed: " in result.stderr
    assert "No step was taken" in ertel_("show", "runs/transient").stdout


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["run", "steady.toml", "--set", "contact.speed=1 m/s"], 'contact.speed = "1 m/s": not for a rolling contact'),
        (["run", "steady.toml", "--set", "time.until=3"], "time.until = 3.0: a steady contact has no time"),
        (["run", "steady.toml", "--set", "motion.load=[[0, 1], [1, 2]]"], "motion.load: varies in time"),
        (["run", "steady.toml", "--set", "solver.method=radial"], 'solver.method = "radial": must be "steady" or'),
        (["run", "steady.toml", "--set", "solver.nodes=66"], "solver.nodes = 66: must be"),
        (["run", "transient.toml", "--set", "time.until=rebound"], 'time.until = "rebound": is an event of an impact'),
        (["run", "transient.toml", "--set", "motion.entrainment=0"], "motion.entrainment: is 0 at T = 0"),
        (["run", "transient.toml", "--error", "--set", "solver.nodes=17"], "solver.nodes = 9"),
        (["run", "transient.toml", "--set", "roughness=3"], "roughness = 3: must be an array of tables"),
        (["film", "steady.toml", "--M", "3"], "steady.toml and --M are given together"),
        (["film"], "contact.M: missing"),
        (
            ["film", "--kind", "impact", "--M", "10", "--L", "2"],
            'contact.kind = "impact": must be "rolling" for the film',
        ),
        (["params", "--kind", "rolling", "--M", "10"], "contact.L: missing"),
        (["params", "--kind", "walking", "--M", "10"], 'contact.kind = "walking"'),
        (["params", "--load", "3 N"], 'contact.load = "3 N": not for an impact'),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, list) else "",
)
def test_wrong_input(here, arguments, said):
    result = ertel_(*arguments, code=2)
    assert result.stderr.startswith(f"ertel: {said}")
    assert len(result.stderr.splitlines()) == 1
    assert result.stdout == ""
    assert names(here) == {"steady.toml", "transient.toml"}


# -- params and film --------------------------------------------------------------------------------------------------

FLAGS = {  # the dimensional case of reference/rolling.json
    **{"--radius": "10 mm", "--load": "38.885237 N", "--mean-speed": "0.502636 m/s", "--E-prime": "219.7802 GPa"},
    **{"--eta0": "40 mPa*s", "--alpha": "22 / GPa"},
}
WORDS = [word for pair in FLAGS.items() for word in pair]


def test_params_of_rolling():
    content = json.loads(ertel_("params", "--kind", "rolling", *WORDS, "--json").stdout)
    assert [content["M"], content["L"]] == pytest.approx([200, 10], rel=1e-6)
    assert content["si"]["u_m_m_per_s"] == pytest.approx(0.502636)
    assert content["si"]["t0_s"] == pytest.approx(1.384509e-4 / 0.502636, rel=1e-6)
    assert {"stokes", "trapped_film"}.isdisjoint(content)
    assert "contact_time_s" not in content["si"]
    speeds = ["--speed-1", "0.6 m/s", "--speed-2", "0.405272 m/s"]
    flags = [word for word in WORDS if word not in ("--mean-speed", "0.502636 m/s")]
    also = json.loads(ertel_("params", "--kind", "rolling", *flags, *speeds, "--json").stdout)
    assert also["M"] == pytest.approx(content["M"])


def test_film_side_by_side():
    """Hamrock and Dowson's, and Nijenbanning's, of reference/rolling.json."""
    content = json.loads(ertel_("film", *WORDS, "--json").stdout)
    films = {film["name"]: film["si"] for film in content["films"]}
    assert films["Hamrock-Dowson"]["h_c_m"] == pytest.approx(167.8e-9, rel=1e-3)
    assert films["Hamrock-Dowson"]["h_min_m"] == pytest.approx(95.7e-9, rel=1e-3)
    assert films["Nijenbanning-Venner-Moes"]["h_c_m"] == pytest.approx(172.9e-9, rel=1e-3)
    assert films["Nijenbanning-Venner-Moes"]["h_min_m"] is None
    text = ertel_("film", *WORDS).stdout
    assert all(part in text for part in ("167.8 nm", "95.71 nm", "172.9 nm", "Wear 1994", "M small, L large"))


def test_film_of_a_case_file(here):
    assert "Hamrock-Dowson" in ertel_("film", "steady.toml").stdout
    content = json.loads(ertel_("film", "transient.toml", "--json").stdout)
    assert content["films"][0]["central"] > 0
    assert "si" not in content["films"][0]


def test_films_of_another_load_and_speed():
    """As if the case had been given with them."""
    a = parse_case({"contact": CONTACT, "lubricant": OIL})
    other = {"load": f"{2 * 3.888524!r} N", "mean_speed": f"{3 * 0.502636!r} m/s"}
    b = parse_case({"contact": CONTACT | other, "lubricant": OIL})
    assert a.scales is not None and b.scales is not None
    for one, two in zip(summary.films(a, 2.0, -3.0), summary.films(b), strict=True):
        for p, q in ((one.central, two.central), (one.minimum, two.minimum)):
            assert (p is None and q is None) or p * a.scales.film == pytest.approx(q * b.scales.film)
    assert summary.films(a, 1.0, 0.0) == []
