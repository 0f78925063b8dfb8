"""`ertel fit`: table, files, interruption and going on, and what is refused."""

import json
import signal
from pathlib import Path
from typing import Any

import pytest
from app_runs import refused
from cases import LEFT, ertel_, names
from matplotlib.figure import Figure

from ertel.results.fit_result import FitResult
from ertel.runs.store import RunStore

CASE = """
[contact]
radius = "10 mm"
mass = "32.6726 g"
speed = "0.1 m/s"
E_prime = "226.37 GPa"
[lubricant]
eta0 = "18 mPa*s"
alpha = "22 / GPa"
[solver]
method = "radial"
nodes = 17
[time]
until = 0.02
tolerance = 0.1
"""
FIT = """
case = "ball.toml"
[unknowns]
"lubricant.eta0" = { bounds = ["5 mPa*s", "1 Pa*s"], prior = ["20 mPa*s", "1 mPa*s"] }
[[measurements]]
file = "pressure.csv"
"""


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "ball.toml").write_text(CASE)
    (tmp_path / "film.toml").write_text(FIT)
    (tmp_path / "pressure.csv").write_text("t_us,p_c_kPa,sigma_kPa\n0.5,10,1e6\n")
    return tmp_path


def test_a_fit_is_printed_and_stored_and_goes_on(here: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    finish = RunStore.finish
    monkeypatch.setattr(FitResult, "plot", lambda result: Figure())  # what is drawn is tested with fits

    def finish_and_interrupt(store: RunStore, summary: Any) -> None:
        finish(store, summary)
        signal.raise_signal(signal.SIGINT)

    with monkeypatch.context() as patch:
        patch.setattr(RunStore, "finish", finish_and_interrupt)
        result = ertel_("fit", "film.toml", "--jobs", "1", code=130)
    assert "interrupted; the same command continues" in result.stderr
    assert names(here / "fits" / "film") - LEFT == {"runs"} and len(names(here / "fits" / "film" / "runs")) == 1
    text = ertel_("fit", "film.toml", "--jobs", "1").stdout
    for part in ("fit of ball", "20 mPa*s", "5 %", "the prior does, to 5 %", "with fit.zarr, fit.csv and fit.png"):
        assert part in text
    assert names(here / "fits" / "film") == LEFT | {"runs", "fit.zarr", "fit.csv", "fit.png"}
    monkeypatch.setattr("ertel.runs.store.drive", None)  # nothing is computed again
    [unknown] = json.loads(ertel_("fit", "film.toml", "--jobs", "1", "--json").stdout)["unknowns"]
    assert unknown["value"] == pytest.approx(0.02, rel=1e-3) and unknown["unit"] == "Pa*s"


def test_a_fit_that_cannot_be_done_is_refused_in_a_sentence(here: Path) -> None:
    (here / "film.toml").write_text(FIT.replace("eta0", "eta"))
    assert "unknown key" in refused("fit", "film.toml")
    (here / "film.toml").write_text(FIT.replace("pressure.csv", "missing.csv"))
    assert "missing.csv" in refused("fit", "film.toml")
    (here / "film.toml").write_text(FIT)
    (here / "pressure.csv").write_text("t_us,p_c_kPa,sigma_kPa\n1e3,1,0.1\n")
    assert "the fit cannot begin" in refused("fit", "film.toml", "--jobs", "1", "--quiet", code=1)
