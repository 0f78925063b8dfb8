"""The run directory: what it holds, and that no moment of death costs more than the last seconds."""

import itertools
import os
import signal
import subprocess
import sys
import textwrap
import time
import warnings
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from cases import go_on, physics, stop_after

import ertel
from ertel.inputs.case_files import load_case, parse_case
from ertel.model.status import Status
from ertel.results import variables
from ertel.runs import store
from ertel.runs.drive import Course, Frame, method_of, simulate, transient
from ertel.runs.store import RunStore, StoreError, TransientStore

CASE = {
    "name": "small",
    "contact": {"M": 200, "L": 10},
    "solver": {"nodes": 33},
    "time": {"tolerance": 0.01, "until": 1.4},
}


@pytest.fixture(scope="module")
def case():
    return parse_case(CASE)


@pytest.fixture(scope="module")
def method(case):
    return method_of(case)


@pytest.fixture(scope="module")
def uninterrupted(case, method):
    return simulate(case, method=method)


# -- a whole run ------------------------------------------------------------------------------------------------------


def test_a_stored_run_is_the_run_in_memory(tmp_path, case, method, uninterrupted):
    run = RunStore.create(tmp_path / "run", case, method)
    summary = store.run(run, go_on, method)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        data = xr.open_zarr(tmp_path / "run" / "run.zarr").load()  # and nothing else
    xr.testing.assert_identical(physics(data), physics(uninterrupted.dataset))
    assert data.attrs["status"] == "converged"
    assert data.attrs["M"] == case.parameters.M
    assert data.attrs["steps"] == summary["steps"] == uninterrupted.summary["steps"]
    assert run.summary() == summary
    same = {key: value for key, value in summary.items() if key not in ("wall_s", "compilations")}
    assert same.items() <= dict(uninterrupted.summary).items()


def test_the_resolved_case_is_the_case(tmp_path, case, method):
    RunStore.create(tmp_path / "run", case, method)
    again = load_case(tmp_path / "run" / "case.toml")
    assert again == case
    assert again.source == case.source


def test_variables_say_what_they_are(uninterrupted):
    for name, variable in uninterrupted.dataset.variables.items():
        assert {"units", "long_name", "symbol"} <= set(variable.attrs), name
    assert uninterrupted.dataset["H"].dims == ("frame", "Y", "X")
    assert uninterrupted.dataset["H_c"].dims == ("time",)


def test_frames_are_at_their_times(uninterrupted, case):
    frames = uninterrupted.dataset["frame"].values
    regular = frames[uninterrupted.dataset["event"].values == 0]
    assert np.allclose(regular, case.output.interval * np.arange(1, len(regular) + 1), rtol=1e-12)
    assert np.all(np.diff(frames) >= 0)  # so that .sel(frame=..., method="nearest") works


def test_writing_is_cheap(tmp_path, case, uninterrupted, method):
    """A flush costs far less than the seconds between two of them."""
    run = RunStore.create(tmp_path / "run", case, method)
    for step in transient(case, None, method):
        run.append(step)
    started = time.perf_counter()
    run.flush()
    assert time.perf_counter() - started < 0.2 * store.FLUSH_INTERVAL


# -- interrupted ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("steps", [1, 2, 7])
def test_resumed_equals_uninterrupted(tmp_path, case, method, uninterrupted, steps):
    run = RunStore.create(tmp_path / "run", case, method)
    assert store.run(run, stop_after(steps), method)["status"] == "interrupted"
    assert run.dataset().sizes["time"] == steps
    again = RunStore.open(tmp_path / "run")
    summary = store.run(again, go_on)
    xr.testing.assert_identical(physics(again.dataset()), physics(uninterrupted.dataset))
    assert summary["status"] == "converged"
    assert summary["newton_iterations"] == uninterrupted.summary["newton_iterations"]


def test_resumed_equals_uninterrupted_for_the_radial_method(tmp_path):
    case = parse_case({**CASE, "solver": {"method": "radial", "nodes": 49}})
    method = method_of(case)
    run = RunStore.create(tmp_path / "run", case, method)
    store.run(run, stop_after(9), method)
    again = RunStore.open(tmp_path / "run")
    store.run(again, go_on)
    assert again.dataset()["H"].dims == ("frame", "r")
    xr.testing.assert_identical(physics(again.dataset()), physics(simulate(case).dataset))


def test_resumed_many_times(tmp_path, case, method, uninterrupted):
    RunStore.create(tmp_path / "run", case, method)
    for _ in range(100):
        run = RunStore.open(tmp_path / "run")
        if store.run(run, stop_after(3), method)["status"] == "converged":
            break
    xr.testing.assert_identical(physics(run.dataset()), physics(uninterrupted.dataset))


def test_wall_time_adds_up(tmp_path, case, method):
    run = RunStore.create(tmp_path / "run", case, method)
    first = store.run(run, stop_after(2), method)["wall_s"]
    second = store.run(RunStore.open(tmp_path / "run"), go_on, method)["wall_s"]
    assert second > first > 0


class Killed(BaseException):
    """Nobody catches it, like SIGKILL."""


def deaths():
    """Where a run can die: the functions that a flush calls, before and after each, sooner or later."""
    places = [
        (store, "_commit"),
        (TransientStore, "_extend"),
        (TransientStore, "_write_checkpoint"),
        (Course, "to_arrays"),
    ]
    return [(place, name, when, count) for place, name in places for when in ("before", "after") for count in (2, 5)]


@pytest.mark.parametrize(("place", "name", "when", "count"), deaths())
def test_death_within_a_flush(tmp_path, monkeypatch, case, method, uninterrupted, place, name, when, count):
    run = RunStore.create(tmp_path / "run", case, method)
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
        patch.setattr(store, "FLUSH_INTERVAL", -1.0)  # flush at every step
        patch.setattr(place, name, deadly)
        with pytest.raises(Killed):
            store.run(run, go_on, method)
    xr.open_zarr(tmp_path / "run" / "run.zarr").load()  # readers see a whole, if shorter, run
    again = RunStore.open(tmp_path / "run")
    store.run(again, go_on, method)
    xr.testing.assert_identical(physics(again.dataset()), physics(uninterrupted.dataset))


@pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="no such signal here")
def test_killed_process(tmp_path, case, method, uninterrupted):
    """A real SIGKILL while the store is being written."""
    RunStore.create(tmp_path / "run", case, method)
    program = f"""
        import time
        from pathlib import Path
        from ertel.runs import store
        store.FLUSH_INTERVAL = -1.0
        run = store.RunStore.open(Path({str(tmp_path / "run")!r}))
        def slowly(step):
            print("step", flush=True)
            return True
        store.run(run, slowly)
    """
    path = str(Path(ertel.__path__[0]).parent)
    environment = {**os.environ, "PYTHONPATH": path}
    command = [sys.executable, "-c", textwrap.dedent(program)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, env=environment) as process:
        assert process.stdout is not None
        for _ in range(4):
            process.stdout.readline()
        time.sleep(0.03)
        process.kill()
    again = RunStore.open(tmp_path / "run")
    seen = again.summary_so_far()["steps"]
    assert 0 < seen < uninterrupted.summary["steps"]
    store.run(again, go_on, method)
    xr.testing.assert_identical(physics(again.dataset()), physics(uninterrupted.dataset))


def test_a_run_that_gives_up_keeps_what_it_has(tmp_path, monkeypatch, case, method, uninterrupted):
    run = RunStore.create(tmp_path / "run", case, method)
    monkeypatch.setattr(import_module("ertel.runs.drive"), "SMALLEST_STEP", 0.02)
    monkeypatch.setattr(import_module("ertel.runs.drive"), "FIRST_STEP", 0.03)
    summary = store.run(run, go_on, method)
    assert summary["status"] == Status.STEP_TOO_SMALL.value
    assert summary["max_approach"] is None
    assert 0 < run.dataset().sizes["time"] == summary["steps"] < uninterrupted.summary["steps"]
    assert run.dataset().attrs["status"] == summary["status"]


def test_only_one_at_a_time(tmp_path, case, method):
    run = RunStore.create(tmp_path / "run", case, method)
    second = RunStore.open(tmp_path / "run")

    def meddle(step):
        with pytest.raises(StoreError, match="another process"):
            store.run(second, go_on, method)
        return False

    store.run(run, meddle, method)
    assert store.run(second, go_on, method)["status"] == "converged"


# -- directories that will not do -------------------------------------------------------------------------------------


def test_existing_output_is_left_alone(tmp_path, case, method):
    (tmp_path / "run").mkdir()
    (tmp_path / "run" / "precious").write_text("data")
    with pytest.raises(StoreError, match=r"run: exists already; choose another --out"):
        RunStore.create(tmp_path / "run", case, method)
    assert [path.name for path in tmp_path.rglob("*")] == ["run", "precious"]


def test_an_empty_directory_will_do(tmp_path, case, method):
    (tmp_path / "run").mkdir()
    RunStore.create(tmp_path / "run", case, method)
    assert RunStore.open(tmp_path / "run").case == case


def test_a_file_in_the_way(tmp_path, case, method):
    (tmp_path / "file").write_text("")
    for target in (tmp_path / "file", tmp_path / "file" / "run"):
        with pytest.raises(StoreError):
            RunStore.create(target, case, method)
    assert [path.name for path in tmp_path.iterdir()] == ["file"]


def test_failure_while_making_leaves_nothing(tmp_path, monkeypatch, case, method):
    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(store, "_create_arrays", full)
    with pytest.raises(StoreError, match="run: cannot write there, no space left on device"):
        RunStore.create(tmp_path / "run", case, method)
    assert list(tmp_path.iterdir()) == []


def test_a_case_without_source_cannot_be_stored(tmp_path, case, method):
    from dataclasses import replace

    with pytest.raises(StoreError, match="parse_case"):
        RunStore.create(tmp_path / "run", replace(case, source={}), method)


@pytest.mark.parametrize("missing", ["case.toml", "run.zarr"])
def test_not_a_run(tmp_path, missing):
    for name in {"case.toml", "run.zarr"} - {missing}:
        (tmp_path / name).mkdir()
    with pytest.raises(StoreError, match=f"is no run of ertel, {missing} is missing"):
        RunStore.open(tmp_path)


def test_nothing_computed_yet(tmp_path, case, method):
    run = RunStore.create(tmp_path / "run", case, method)
    assert run.summary() is None
    assert run.dataset().sizes["time"] == 0
    with pytest.raises(StoreError, match="nothing is computed yet"):
        run.summary_so_far()


def test_unused_directory(tmp_path, case):
    assert store.unused_directory(case, tmp_path) == tmp_path / "small"
    (tmp_path / "small").mkdir()
    (tmp_path / "small-2").mkdir()
    assert store.unused_directory(case, tmp_path) == tmp_path / "small-3"


# -- the Dataset ------------------------------------------------------------------------------------------------------


def a_run(contact, oil=None):
    """Two steps and two maps of a made-up run."""
    case = parse_case({"contact": contact, "lubricant": oil or {}})
    x = np.linspace(-1, 1, 5)
    records = [{"T": T, **{name: float(k) for k, name in enumerate(variables.SCALARS)}} for T in (0.1, 0.2)]
    frames = [
        Frame(T, {"P": np.full((5, 5), T), "H": np.full((5, 5), 2 * T)}, event)
        for T, event in ((0.1, ""), (0.2, "end"))
    ]
    return case, variables.assemble(case, records, frames, {"Y": x, "X": x})


BALL = {"radius": "10 mm", "mass": "32.6726 g", "speed": "0.1 m/s", "E_prime": "226.37 GPa"}
OIL = {"eta0": "0.1 Pa*s", "alpha": "22 / GPa"}


def test_si_is_the_scales_times_the_dimensionless():
    case, data = a_run(BALL, OIL)
    si, scales = variables.to_si(data), case.scales
    assert scales is not None
    for name, new, factor, units in [
        ("H_c", "h_c", scales.film, "m"),
        ("P_max", "p_max", scales.p_h, "Pa"),
        ("F", "f", scales.load, "N"),
        ("V", "v", 0.1, "m/s"),
        ("time", "t", scales.t0, "s"),
        ("X", "x", scales.a, "m"),
        ("H", "h", scales.film, "m"),
        ("frame", "frame", scales.t0, "s"),
    ]:
        np.testing.assert_allclose(si[new].values, data[name].values * factor, rtol=1e-12)
        assert si[new].attrs["units"] == units
        assert si[new].attrs["long_name"] == data[name].attrs["long_name"]
    assert si["h"].dims == ("frame", "y", "x")
    assert si["newton_iterations"].equals(data["newton_iterations"].rename(time="t").assign_coords(t=si["t"]))


def test_dimensionless_runs_have_no_si():
    _, data = a_run({"M": 100, "L": 10})
    with pytest.raises(ValueError, match="dimensionless"):
        variables.to_si(data)


def test_si_summary_has_units_in_its_names():
    case, _ = a_run(BALL, OIL)
    values = dict.fromkeys(variables.AT_MAXIMUM, 1.0)
    si = variables.si_summary(case, values)
    assert si is not None and case.scales is not None
    assert si["max_approach"] == {
        "t_s": case.scales.t0,
        "delta_m": case.scales.film,
        "f_N": case.scales.load,
        "p_c_Pa": case.scales.p_h,
        "p_max_Pa": case.scales.p_h,
        "h_c_m": case.scales.film,
        "h_min_m": case.scales.film,
        "x_min_m": case.scales.a,
    }
    assert variables.si_summary(parse_case({"contact": {"M": 1, "L": 1}}), values) is None


@pytest.mark.parametrize(
    ("value", "unit", "text"),
    [
        (1.4e9, "Pa", "1.4 GPa"),
        (6.7e-7, "m", "0.67 µm"),
        (6.7e-8, "m", "67 nm"),
        (0.1, "m/s", "0.1 m/s"),
        (0.0, "m", "0 m"),
        (98.5, "N", "98.5 N"),
    ],
)
def test_values_for_reading(value, unit, text):
    assert variables.with_prefix(value, unit) == text
