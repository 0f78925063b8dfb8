"""Names of run directories, also of several processes at once, and directories that will not do."""

import os
import threading
from pathlib import Path

import pytest
from cases import stop_after

import ertel
from ertel.inputs.case_files import parse_case
from ertel.runs.arrays import AppendedData
from ertel.runs.directory import Taken
from ertel.runs.files import StoreError
from ertel.runs.store import RunStore, changes, compute

pytestmark = pytest.mark.filterwarnings("ignore:the film is not resolved", "ignore:the oil outside the domain")
DATA = {"name": "small", "contact": {"M": 200, "L": 10}, "solver": {"method": "radial", "nodes": 33}}
CASE = parse_case({**DATA, "time": {"tolerance": 0.01, "until": 0.15}, "output": {"interval": 0.05}})


# -- names ------------------------------------------------------------------------------------------------------------


def test_the_next_free_name(tmp_path):
    taken = [RunStore.create_unused(CASE, tmp_path / "runs").directory.name for _ in range(3)]
    assert taken == ["small", "small-2", "small-3"]
    assert sorted(path.name for path in (tmp_path / "runs").iterdir()) == taken


@pytest.mark.filterwarnings("ignore:Consolidated metadata is currently not part")  # filters are not those of a thread
def test_many_runs_at_once_take_different_names(tmp_path):
    """Of four, two were refused."""
    together, made = threading.Barrier(4), []

    def make():
        together.wait()
        made.append(RunStore.create_unused(CASE, tmp_path).directory)

    threads = [threading.Thread(target=make) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert sorted(path.name for path in made) == ["small", "small-2", "small-3", "small-4"]
    assert sorted(tmp_path.iterdir()) == sorted(made)
    assert all(RunStore.open(path).case == CASE for path in made)


def test_a_name_that_is_taken_at_the_last_moment(tmp_path, monkeypatch):
    """Between the look for it and the move."""
    rename = Path.rename

    def late(self, target):
        if Path(target).name == "small":
            (Path(target) / "of others").mkdir(parents=True)
        return rename(self, target)

    monkeypatch.setattr(Path, "rename", late)
    assert RunStore.create_unused(CASE, tmp_path).directory == tmp_path / "small-2"
    assert sorted(path.name for path in tmp_path.iterdir()) == ["small", "small-2"]
    with pytest.raises(Taken, match="small: exists already"):
        RunStore.create(tmp_path / "small", CASE)


def test_a_path_is_a_path(tmp_path, monkeypatch):
    """Zarr would read some as addresses and others as below the home directory."""
    (tmp_path / "home").mkdir()
    (tmp_path / "here").mkdir()
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    monkeypatch.chdir(tmp_path / "here")
    for path in ("run::1", "~/run", "s3:/bucket/run", "memory:/run"):
        compute(RunStore.create(Path(path), CASE), [stop_after(1)])
        summary = compute(RunStore.open(Path(path)))
        assert ertel.open(path).summary == summary
        assert (tmp_path / "here" / path / "run.zarr").is_dir()
    assert list((tmp_path / "home").iterdir()) == []


def test_directories_say_what_changed():
    before, now = {"contact": {"M": 200.0}, "name": "a"}, {"contact": {"M": 300.0}, "name": "b"}
    assert changes(before, now) == "contact.M 200.0 → 300.0"


# -- directories that will not do -------------------------------------------------------------------------------------


def test_existing_output_is_left_alone(tmp_path):
    (tmp_path / "run").mkdir()
    (tmp_path / "run" / "precious").write_text("data")
    for target, said in (("run", "run: exists already"), ("run/precious", ""), ("run/precious/run", "")):
        with pytest.raises(StoreError, match=said):
            RunStore.create(tmp_path / target, CASE)
    assert [path.name for path in tmp_path.rglob("*")] == ["run", "precious"]


def test_an_empty_directory_will_do_where_it_is_named(tmp_path):
    """A move onto an empty directory replaces it, so another name is found where none is given."""
    (tmp_path / "small").mkdir()
    assert RunStore.create_unused(CASE, tmp_path).directory == tmp_path / "small-2"
    assert list((tmp_path / "small").iterdir()) == []
    RunStore.create(tmp_path / "small", CASE)
    assert RunStore.open(tmp_path / "small").case == CASE


def test_failure_while_making_leaves_nothing(tmp_path, monkeypatch):
    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(AppendedData, "create", full)
    with pytest.raises(StoreError, match="run: cannot write there, no space left on device"):
        RunStore.create(tmp_path / "run", CASE)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("missing", ["case.toml", "run.zarr"])
def test_not_a_run(tmp_path, missing):
    for name in {"case.toml", "run.zarr"} - {missing}:
        (tmp_path / name).mkdir()
    with pytest.raises(StoreError, match=rf"is not an ertel run directory \(no {missing}\)"):
        RunStore.open(tmp_path)


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="needs a POSIX system")
@pytest.mark.parametrize("name", ["summary.json", "checkpoint.npz"])
def test_a_pipe_is_not_waited_for(tmp_path, name):
    """Reading it would never end."""
    run = RunStore.create(tmp_path / "run", CASE)
    os.mkfifo(tmp_path / "run" / name)
    read = run.summary if name == "summary.json" else run.item
    with pytest.raises(OSError, match=f"not a regular file: .*{name}"):
        read()
