"""The command line and rolling contacts: what is printed, and that wrong input leaves nothing behind."""

import json
import signal
from functools import partial
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from cases import ertel_, names, physics, stop_after

from ertel.inputs.case_files import load_case, parse_case
from ertel.runs import courses
from ertel.runs.drive import drive, simulate
from ertel.runs.stepping import StepLimits
from ertel.runs.store import RunStore, compute

OIL = {"eta0": "40 mPa*s", "alpha": "22 / GPa"}
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


def test_a_film_below_zero_fails_with_the_number_of_nodes(here):
    (here / "thin.toml").write_text('[contact]\nkind = "rolling"\nM = 20000\nL = 10\n[solver]\nnodes = 33\n')
    ran = ertel_("run", "thin.toml", code=1)
    assert "failed: the surfaces overlap" in ran.stderr
    assert "use solver.nodes >= 1409" in ran.stderr
    for text in (ran.stdout, ertel_("show", "runs/thin").stdout, ertel_("ls", "runs").stdout):
        assert "the film vanishes on this grid" in text
        assert "mu" not in text
        assert "computed" not in text


def test_run_show_and_plot(here):
    text = ertel_("run", "steady.toml").stdout
    for part in ("converged", "H_c", "error", "extrapolated", "nm", "Nijenbanning", "Hamrock", "computed", "%"):
        assert part in text
    assert text == ertel_("show", "runs/steady").stdout
    summary = json.loads(ertel_("show", "runs/steady", "--json").stdout)
    assert set(KEYS) <= set(summary)
    printed = ertel_("plot", "runs/steady").stdout.split()
    assert {Path(path).stem for path in printed} >= {"film", "pressure", "midlines", "convergence"}
    assert all(Path(path).read_bytes().startswith(b"\x89PNG") for path in printed)


def test_traction_without_meaning_is_warned_of(here):
    values = ('contact.load="40 N"', "contact.slide_to_roll=0.1", "lubricant.viscosity=barus", "solver.tolerance=0.01")
    more = [argument for value in values for argument in ("--set", value)]
    assert "lubricant.viscosity" in "".join(ertel_("run", "steady.toml", *more).stdout.split("\n"))
    assert any(
        said.startswith('lubricant.viscosity = "barus"')
        for said in json.loads(ertel_("show", "runs/steady", "--json").stdout)["warnings"]
    )


def test_interrupt_and_resume(here, monkeypatch, case):
    original = RunStore._write_checkpoint

    def write(self, arrays):
        original(self, arrays)
        signal.raise_signal(signal.SIGINT)

    with monkeypatch.context() as patch:
        patch.setattr(RunStore, "_write_checkpoint", write)
        result = ertel_("run", "steady.toml", "--out", "cut", "--flush", "0", code=130)
    assert "interrupted; to continue: ertel resume cut" in result.stderr
    assert json.loads(ertel_("show", "cut", "--json").stdout)["nodes"] == 33
    ertel_("resume", "cut", "-q")
    assert json.loads(ertel_("show", "cut", "--json").stdout)["nodes"] == 65
    xr.testing.assert_identical(physics(RunStore.open(here / "cut").dataset()), physics(simulate(case).dataset))


def test_a_run_under_way(here, case):
    run = RunStore.create(here / "cut", case)
    ertel_("show", "cut", code=2)
    ertel_("plot", "cut", code=2)
    drive(run.course, [run, stop_after(1)], run.resume())
    run.flush()
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


@pytest.mark.slow
def test_the_error_of_a_transient_run(here):
    short = ("run", "transient.toml", "--json", "--set", "time.until=0.1")
    fine = json.loads(ertel_(*short, "--error").stdout)
    coarse = json.loads(ertel_(*short, "--set", "solver.nodes=17").stdout)
    for name in ("H_c", "H_min"):
        parts = fine["error_estimate"][name]
        assert parts["grid"] == pytest.approx((fine[name] - coarse[name]) / 3)
        sizes = {part: abs(parts[part]) for part in ("grid", "time", "domain")}
        assert fine[f"{name}_error"] == pytest.approx(sum(size**2 for size in sizes.values()) ** 0.5)
        assert parts["dominant"] == max(sizes, key=sizes.get)


def test_a_transient_run_resumed(here):
    ertel_("run", "transient.toml", "--out", "whole", "-q")
    run = RunStore.create(here / "cut", load_case("transient.toml"))
    compute(run, [stop_after(3)])
    ertel_("resume", "cut", "-q")
    cut, whole = (RunStore.open(here / name).dataset() for name in ("cut", "whole"))
    xr.testing.assert_identical(physics(cut), physics(whole))


def test_a_transient_run_that_cannot_begin(here, monkeypatch):
    monkeypatch.setattr(courses, "StepLimits", partial(StepLimits, smallest=10.0))
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
        (["film"], "contact.M: missing"),
        (
            ["film", "--set", "contact.kind=impact", "--set", "contact.M=10", "--set", "contact.L=2"],
            'contact.kind = "impact": must be "rolling" for the film',
        ),
        (["params", "--set", "contact.kind=rolling", "--set", "contact.M=10"], "contact.L: missing"),
        (["params", "--set", "contact.kind=walking", "--set", "contact.M=10"], 'contact.kind = "walking"'),
        (["params", "--set", "contact.load=3 N"], 'contact.load = "3 N": not for an impact'),
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

ROLLED = {  # the dimensional case of reference/rolling.json
    **{"contact.radius": "10 mm", "contact.load": "38.885237 N", "contact.mean_speed": "0.502636 m/s"},
    **{"contact.E_prime": "219.7802 GPa", "lubricant.eta0": "40 mPa*s", "lubricant.alpha": "22 / GPa"},
}


def settings(values):
    return [word for key, value in values.items() for word in ("--set", f"{key}={value}")]


WORDS = settings(ROLLED)


def test_params_of_rolling():
    content = json.loads(ertel_("params", "--set", "contact.kind=rolling", *WORDS, "--json").stdout)
    assert [content["M"], content["L"]] == pytest.approx([200, 10], rel=1e-6)
    assert content["si"]["u_m_m_per_s"] == pytest.approx(0.502636)
    assert content["si"]["t0_s"] == pytest.approx(1.384509e-4 / 0.502636, rel=1e-6)
    assert {"stokes", "trapped_film"}.isdisjoint(content)
    assert "contact_time_s" not in content["si"]
    speeds = {"contact.kind": "rolling", "contact.speed_1": "0.6 m/s", "contact.speed_2": "0.405272 m/s"}
    rest = {key: value for key, value in ROLLED.items() if key != "contact.mean_speed"}
    also = json.loads(ertel_("params", *settings({**rest, **speeds}), "--json").stdout)
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


@pytest.mark.parametrize("command", ["params", "film"])
def test_a_value_of_a_case_file_is_replaced(here, command):
    def M(load):
        return json.loads(ertel_(command, "steady.toml", "--set", f"contact.load={load}", "--json").stdout)["M"]

    assert M("40 N") == pytest.approx(2 * M("20 N"))


def test_film_of_a_case_file(here):
    assert "Hamrock-Dowson" in ertel_("film", "steady.toml").stdout
    content = json.loads(ertel_("film", "transient.toml", "--json").stdout)
    assert content["films"][0]["central"] > 0
    assert "si" not in content["films"][0]
