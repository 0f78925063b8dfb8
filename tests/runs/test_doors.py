"""Directories that somebody else has made: ertel writes nowhere else, runs no code of theirs, waits for no pipe."""

import json
import os
import pickle
import shutil
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
import zarr
from stored_runs import Evil

import ertel
from ertel.runs import arrays, files, studies
from ertel.runs.directory import ask_to_stop, is_asked_to_stop
from ertel.runs.files import StoreError, content_of, sealed, unsealed
from ertel.runs.store import RunStore, compute
from ertel.runs.workers import LocalWorker

pytestmark = pytest.mark.skipif(os.name == "nt", reason="needs links and pipes")
PICKLE = {"zarr_format": 2, "shape": [1], "chunks": [1], "dtype": "|O", "order": "C", "fill_value": None}
PICKLE |= {"compressor": None, "filters": [{"id": "pickle", "protocol": 5}], "dimension_separator": "."}


@pytest.fixture
def victim(tmp_path):
    """A directory that is not of the run."""
    place, own = tmp_path / "victim", dict.fromkeys(("a.txt", "7", "old.partial"), "mine")
    place.mkdir()
    for name, text in own.items():
        (place / name).write_text(text)
    yield place
    assert {path.name: path.read_text() for path in place.iterdir()} == own


@pytest.mark.parametrize("kind", ["radial", "steady"])
def test_a_resumed_run_writes_through_no_link(kinds, copy, victim, kind):
    run = copy(kinds[kind].cut)
    for name in ("summary.json", "checkpoint.npz", "progress.json"):
        (run / f"{name}.partial").symlink_to(victim / "a.txt")
    for name in ("run.zarr.partial", "run.zarr.old") if kind == "steady" else ():  # those of a run in time are appended
        (run / name).symlink_to(victim)
    assert compute(RunStore.open(run))["status"] == "converged"
    assert not [path for path in run.rglob("*") if path.is_symlink() and path.name.endswith(".json")]


@pytest.mark.parametrize("name", ["run.zarr", "run.zarr/H_c", "run.zarr/H_c/c", "run.zarr/zarr.json.partial"])
def test_arrays_elsewhere_are_not_written(kinds, copy, victim, name):
    run = copy(kinds["radial"].cut)
    place = run / name
    if place.exists():
        shutil.move(place, run / "aside")
    ends = {"run.zarr": run / "aside", "run.zarr/zarr.json.partial": victim / "a.txt"}
    place.symlink_to(ends.get(name, victim))
    with pytest.raises(StoreError, match=rf"{name}: is a symbolic link, and ertel would write where it leads"):
        compute(RunStore.open(run))


def spoiled(run: Path, change: object) -> None:
    """Change the metadata of all arrays of a run; their checksum agrees."""
    file = run / "run.zarr" / "zarr.json"
    root = unsealed(file.read_bytes(), "attributes")
    change(root["consolidated_metadata"]["metadata"])
    file.write_bytes(sealed(root, "attributes"))


def test_names_of_arrays_lead_nowhere_else(kinds, copy, tmp_path):
    """The chunks of an array ../../letters were deleted."""
    run, letter = copy(kinds["radial"].cut), tmp_path / "letters" / "c" / "7"
    letter.parent.mkdir(parents=True)
    letter.write_text("mine")
    spoiled(run, lambda arrays: arrays.update({"../../letters": {**arrays["H_c"], "shape": [0]}}))
    with pytest.raises(StoreError, match=r"is damaged \('../../letters' is not the name of an array\)"):
        compute(RunStore.open(run))
    assert letter.read_text() == "mine"


@pytest.mark.parametrize("ends", ["dangling", "at a file"])
def test_asking_to_stop_makes_no_file_elsewhere(tmp_path, victim, ends):
    (tmp_path / "run").mkdir()
    (tmp_path / "run" / "stop").symlink_to(victim / ("new" if ends == "dangling" else "a.txt"))
    ask_to_stop(tmp_path / "run")
    assert is_asked_to_stop(tmp_path / "run") and not (tmp_path / "run" / "stop").is_symlink()


def test_two_may_write_a_file_at_once(tmp_path, monkeypatch):
    """The second one came while the first was writing; the first found its draft gone."""
    file, sync = tmp_path / "summary.json", files._sync

    def second(handle):
        monkeypatch.setattr(files, "_sync", sync)
        files.replace(file, b"second")
        assert file.read_bytes() == b"second"

    monkeypatch.setattr(files, "_sync", second)
    files.replace(file, b"first")
    assert (file.read_bytes(), [path.name for path in tmp_path.iterdir()]) == (b"first", ["summary.json"])


def test_drafts_of_killed_processes_are_deleted_and_nothing_else_is(tmp_path, victim):
    for name in ("stop.0123abcd.partial", "notes.partial", "a.txt.0123abcd.part"):
        (tmp_path / name).touch()
    (tmp_path / "summary.json.89abcdef.partial").symlink_to(victim / "a.txt")
    for path in tmp_path.glob("*.partial"):
        os.utime(path, (0, 0), follow_symlinks=False)
    (tmp_path / "stop.89abcdef.partial").touch()  # of a process that asks to stop now
    with files.locked(tmp_path):
        found = {path.name for path in tmp_path.iterdir()}
    assert found == {".lock", "stop.89abcdef.partial", "notes.partial", "a.txt.0123abcd.part", "victim"}


@pytest.mark.parametrize("name", ["runs", "runs/{digest}"])
def test_a_study_does_not_write_its_runs_elsewhere(tmp_path, victim, name):
    case = ertel.impact(M=20, L=5, method="radial", nodes=17, until=0.02)
    (place := tmp_path / "study" / name.format(digest=case.digest)).parent.mkdir(parents=True)
    place.symlink_to(victim)
    with pytest.raises(StoreError, match=rf"{place}: is a symbolic link, and ertel would write where it leads"):
        studies.run_study([case], tmp_path / "study", LocalWorker())


def test_metadata_of_an_earlier_format_among_those_of_a_run_are_refused(kinds, copy):
    """They name codecs that run pickles."""
    run = copy(kinds["radial"].cut)
    spoiled(run, lambda arrays: arrays["H_c"].update(PICKLE))
    shutil.rmtree(run / "run.zarr" / "H_c")
    (run / "run.zarr" / "H_c").mkdir()
    (run / "run.zarr" / "H_c" / "0").write_bytes(pickle.dumps(np.array([Evil()])))
    for look in (ertel.open, lambda path: compute(RunStore.open(path))):
        with pytest.raises(StoreError, match="has arrays of Zarr's format 2, which may hold programs"):
            look(run)
    with pytest.raises(ValueError, match="has arrays of Zarr's format 2, which may hold programs"):
        arrays.open_data(run / "run.zarr", consolidated=True)


@pytest.mark.parametrize("consolidated", [True, False])
@pytest.mark.parametrize("codec", ["numcodecs.pickle", "gzip"])
def test_codecs_that_ertel_does_not_write_are_refused(tmp_path, codec, consolidated):
    """In studies and fits, wherever their metadata are."""
    study = tmp_path / "sweep.zarr"
    xr.Dataset({"H": ("run", [1.0, 2.0]), "status": ("run", ["done", "a"])}).to_zarr(study, consolidated=consolidated)
    assert arrays.open_data(study, consolidated=consolidated).load()["status"].values.tolist() == ["done", "a"]
    for file in study.rglob("zarr.json"):
        file.write_text(file.read_text().replace('"zstd"', f'"{codec}"'))
    with pytest.raises(ValueError, match=rf"has arrays with codecs that ertel does not write \({codec}\)"):
        arrays.open_data(study, consolidated=consolidated).load()


def test_arrays_of_the_earlier_format_are_not_there(tmp_path):
    """Beside the metadata of a group as ertel writes it."""
    zarr.create_group(tmp_path, zarr_format=3)
    (tmp_path / "H").mkdir()
    (tmp_path / "H" / ".zarray").write_text(json.dumps(PICKLE))
    (tmp_path / "H" / "0").write_bytes(pickle.dumps(np.array([Evil()])))
    assert not arrays.open_data(tmp_path, consolidated=False).load().variables


@pytest.mark.parametrize("store", [arrays.RegularStore, arrays.SyncedStore])
def test_no_other_way_to_read_and_write_passes_the_checks(tmp_path, store):
    """Of zarr 3.1.6, which does not use it yet."""
    sync = [getattr(zarr.abc.store, name, None) for name in ("SupportsGetSync", "SupportsSetSync", "SupportsSyncStore")]
    assert not any(isinstance(store(tmp_path), each) for each in sync if each)


def test_neither_pipes_nor_endless_files_are_read(tmp_path, kinds, copy):
    os.mkfifo(tmp_path / "zarr.json")
    (tmp_path / "zero").symlink_to("/dev/zero")
    for name in ("zarr.json", "zero"):
        with pytest.raises(OSError, match="not a regular file"):
            content_of(tmp_path / name)
    with pytest.raises(OSError, match="not a regular file"):
        arrays.open_data(tmp_path, consolidated=False)
    (tmp_path / "long").write_bytes(b"12345")
    with pytest.raises(OSError, match="File too large"):
        content_of(tmp_path / "long", 4)
