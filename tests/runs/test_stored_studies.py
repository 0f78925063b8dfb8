"""Studies on the disk: what is run, what is gathered, and how they go on after all that may come between."""

import itertools
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from cases import RADIAL, SMALL, names

import ertel
from ertel.case.case import Case
from ertel.inputs.studies import Study, convergence_series, coordinates, parse_study
from ertel.results.numbers import aligned
from ertel.runs import files, studies
from ertel.runs.files import StoreError
from ertel.runs.store import RunStore
from ertel.runs.studies import gather as gathered
from ertel.runs.studies import left_of, run_directory, run_study, write_study
from ertel.runs.workers import LocalWorker

RINGS = {"method": "radial", "nodes": 17}
SPEEDS, VISCOSITIES = ["0.1 m/s", "0.2 m/s"], ["10 mPa*s", "20 mPa*s"]


def plain(speed: Any = SPEEDS, eta0: Any = VISCOSITIES, until: float = 0.02) -> dict[str, Any]:
    contact, oil = {**SMALL["contact"], "speed": speed}, {**SMALL["lubricant"], "eta0": eta0}
    times = {"until": until, "tolerance": 0.1}
    return {"name": "balls", "contact": contact, "lubricant": oil, "solver": RINGS, "time": times}


def study_of(**varying: Any) -> Study:
    return parse_study(plain(**varying))


class Remembering:
    """Workers that do nothing, but remember what they should do."""

    def outcomes(self, tasks, should_stop):
        self.tasks = tasks
        return iter(())


@pytest.fixture(scope="module")
def four(tmp_path_factory: pytest.TempPathFactory) -> Path:
    directory = tmp_path_factory.mktemp("study")
    assert ertel.sweep(plain(), directory).complete
    return directory


def test_the_numbers_of_all_runs_stand_over_what_varies(four):
    found = gathered(study_of(), four).dataset
    assert dict(found.sizes) == {"speed": 2, "eta0": 2}
    assert found["speed"].values.tolist() == [0.1, 0.2] and found["speed"].attrs["units"] == "m/s"
    assert found["eta0"].values.tolist() == [0.01, 0.02] and found["eta0"].attrs["units"] == "Pa*s"
    assert set(found["status"].values.flat) == {"converged"}
    one = found.sel(speed=0.2, eta0=0.01)
    run = ertel.open(four / str(one["directory"].values))
    assert (run.case.contact.speed, run.case.oil.eta0) == (0.2, 0.01)
    extreme = run.summary["si"]["extremes"]["H_min"]["h_min_m"]
    assert float(one["h_min_extreme"]) == pytest.approx(extreme) and found["h_min_extreme"].attrs["units"] == "m"


def test_what_is_written_opens_without_ertel(four, recwarn):
    study = study_of()
    result = gathered(study, four)
    write_study(result, four)
    assert [str(w.message) for w in recwarn if "Zarr" in str(w.message)] == []
    stored = xr.open_zarr(four / "sweep.zarr", consolidated=False)
    assert stored.drop_attrs().equals(result.dataset.drop_attrs())
    table = (four / "sweep.csv").read_text().splitlines()
    assert table[0].startswith("speed_m_per_s,eta0_Pa_s,M,L,") and len(table) == 5
    assert table[2].startswith("0.1,0.02,")
    head, *rows = aligned(result.table())
    assert head.split()[:4] == ["speed", "(m/s)", "eta0", "(mPa*s)"] and len(rows) == 4
    assert "4 runs: 4 converged" in repr(result) and "<table>" in result._repr_html_()


def test_links_in_place_of_the_files_of_a_study_are_replaced(four, tmp_path):
    """In somebody else's study they may lead anywhere."""
    (tmp_path / "a.txt").write_text("mine")
    (tmp_path / "letters").mkdir()
    for name, target in {"sweep.csv": "a.txt", "sweep.png": "a.txt", "sweep.zarr": "letters"}.items():
        files.delete(four / name)
        (four / name).symlink_to(tmp_path / target)
    write_study(gathered(study_of(), four), four)
    assert names(tmp_path) == {"a.txt", "letters"} and names(tmp_path / "letters") == set()
    assert (tmp_path / "a.txt").read_text() == "mine"
    assert not [path for path in four.iterdir() if path.is_symlink()]


def test_only_what_is_new_is_done(four):
    study = study_of()
    assert left_of(study.cases, four) == {}
    assert run_study(study.cases, four, workers := Remembering()) == {} and workers.tasks == []
    study = study_of(eta0=["20 mPa*s", "30 mPa*s"])
    left = left_of(study.cases, four)
    assert sorted((case.contact.speed, case.oil.eta0) for case in left.values()) == [(0.1, 0.03), (0.2, 0.03)]
    assert gathered(study, four).dataset["status"].values.tolist() == [["converged", "missing"]] * 2


def test_a_stopped_study_goes_on_to_the_same_numbers(tmp_path):
    """After three steps of its first run."""
    study = study_of(until=0.1, speed="0.1 m/s")
    steps = itertools.count()
    said = run_study(study.cases, tmp_path / "a", LocalWorker(), asked=lambda: next(steps) > 3)
    assert list(said.values()) == ["interrupted", "interrupted"]
    result = gathered(study, tmp_path / "a", said)
    assert not result.complete and result.failed == []
    first = run_directory(tmp_path / "a", study.cases[0])
    assert 0 < ertel.open(first).summary["steps"] <= 4
    again = run_study(study.cases, tmp_path / "a", LocalWorker())
    whole = run_study(study.cases, tmp_path / "b", LocalWorker())
    assert again == whole and set(whole.values()) == {"converged"}
    found, wanted = (gathered(study, tmp_path / name).dataset["h_min_extreme"].values for name in "ab")
    assert np.array_equal(found, wanted)


def test_a_process_that_is_killed_while_it_writes_leaves_the_directory_of_its_study(tmp_path):
    with studies.alone(tmp_path):  # before it writes anything else
        (tmp_path / "progress.json.f562171d.partial").touch()
    assert studies.require_place(tmp_path, "fit") == tmp_path
    (tmp_path / "mine.f562171d.partial").touch()
    with pytest.raises(StoreError, match="holds other files"):
        studies.require_place(tmp_path, "fit")


def test_a_run_that_was_killed_is_not_said_to_run(tmp_path):
    """Unless a process is at it: it holds the lock."""
    study = study_of(eta0="10 mPa*s")
    store = RunStore.create(run_directory(tmp_path, study.cases[0]), study.cases[0])
    assert list(gathered(study, tmp_path).dataset["status"].values) == ["unfinished", "missing"]
    with store.alone():
        found = gathered(study, tmp_path)
        assert list(found.dataset["status"].values) == ["running", "missing"]
    assert not found.failed and not found.complete


def series_case(**changes: Any) -> Case:
    data = {**RADIAL, "solver": {"method": "radial", "nodes": 129}, "time": {"until": 0.02, "tolerance": 8e-4}}
    return ertel.parse_case(data | changes)


def test_a_series_doubles_the_cells_and_halves_the_steps():
    study = convergence_series(series_case(), 4)
    assert [case.solver.nodes for case in study.cases] == [17, 33, 65, 129]
    tolerances = [case.time.tolerance for case in study.cases if case.time]
    assert tolerances == pytest.approx([8e-4, 1e-4, 1.25e-5, 1.5625e-6])
    found = coordinates(study)
    assert found["nodes"][0] == [17, 33, 65, 129] and found["tolerance"][0] == pytest.approx(tolerances)
    ball = {**SMALL, "solver": RINGS, "time": {"step": "1 us"}}
    alone = convergence_series(ertel.parse_case(ball), along="time")
    assert {case.solver.nodes for case in alone.cases} == {17}
    assert [str(case.time.step) for case in alone.cases if case.time] == ["1e-06 s", "5e-07 s", "2.5e-07 s"]
    steady = convergence_series(ertel.rolling(M=20, L=10, nodes=129))
    assert [case.solver.nodes for case in steady.cases] == [33, 65, 129]
    assert list(coordinates(steady)) == ["nodes"]


@pytest.mark.parametrize(
    ("case", "given", "said"),
    [
        (series_case(), {"grids": 2}, "grids = 2: must be a whole number from 3 to 6"),
        (series_case(), {"along": "domain"}, 'along = "domain": allowed: grid, time'),
        (series_case(), {"grids": 5}, "solver.nodes = 129: has no 5 grids .* solver.nodes = 257 or 273"),
        (series_case(solver={"method": "radial", "nodes": 66}), {}, "solver.nodes = 66: has no 3 .* 65 or 69"),
        (ertel.rolling(M=20, L=10, nodes=65), {"along": "time"}, 'along = "time": a steady contact has no time steps'),
    ],
)
def test_a_series_that_cannot_be_is_refused(case: Case, given: dict[str, Any], said: str):
    with pytest.raises(ertel.ConfigError, match=f"^{said}"):
        convergence_series(case, **given)


def test_a_series_is_a_study_that_goes_on(tmp_path, monkeypatch):
    case = ertel.parse_case({**RADIAL, "time": {"tolerance": 0.064}})
    found = ertel.converge(case, tmp_path, along="time")
    own = {f"convergence.{ending}" for ending in ("zarr", "csv", "png")}
    assert found.complete and {path.name for path in tmp_path.glob("[!.]*")} == {"runs", *own}
    limits = found.limits
    assert {"H_c", "H_min", "T", "Delta", "P_c", "F", "power_loss"} == set(limits)
    values = found.dataset["H_c"].values
    assert np.ptp(values) > 0 and abs(limits["H_c"].value - values[-1]) <= limits["H_c"].error < 0.1 * values[-1]
    stored = xr.open_zarr(tmp_path / "convergence.zarr", consolidated=False)
    assert stored["H_c"].attrs["extrapolated"] == pytest.approx(limits["H_c"].value)
    text, columns = repr(found), "tolerance 0.064 0.008 0.001 order second order value error"
    assert text.splitlines()[1].split() == columns.split()
    assert "second order is assumed" in text and "3 runs: 3 converged" in text
    (axes,) = found.plot().axes
    assert (axes.get_xscale(), axes.get_yscale()) == ("log", "log")
    slope = axes.lines[-1].get_xydata()
    assert np.diff(np.log(slope[:, 1])) == pytest.approx(np.diff(np.log(slope[:, 0])) * 2 / 3)  # of the tolerance
    data = found.as_data()
    assert data["limits"]["H_c"]["value"] == limits["H_c"].value and len(data["runs"]) == 3
    monkeypatch.setattr(studies, "compute", None)
    again = ertel.converge(case, tmp_path, along="time")
    assert str(again.limits) == str(limits)  # nan is not equal to itself
