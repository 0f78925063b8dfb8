"""Damaged run directories: what is read is what was written, or the damaged file is named; nothing in between."""

import io
import itertools
import json
import os
import pickle
import random
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
import zarr
from cases import changed_cases, physics, stop_after
from stored_runs import Evil

import ertel
from ertel.runs import arrays
from ertel.runs.files import LOCK, Damaged, StoreError, with_checksum
from ertel.runs.store import RunStore, compute


@pytest.fixture(params=["impact", pytest.param("steady", marks=pytest.mark.slow)])
def runs(request, kinds):
    return kinds[request.param]


def flip(file: Path, chance: random.Random) -> bytes:
    """Flip one bit of a file; what it was before."""
    whole = file.read_bytes()
    flipped = bytearray(whole)
    flipped[chance.randrange(len(flipped))] ^= 1 << chance.randrange(8)
    file.write_bytes(flipped)
    return whole


def any_file(directory: Path, chance: random.Random) -> Path:
    """Any file of a run that has content, of each kind equally often."""
    kinds = ("*.*", "run.zarr/zarr.json", "run.zarr/*/zarr.json", "run.zarr/*/c/**/*")
    found = sorted(directory.glob(chance.choice(kinds)))
    return chance.choice([file for file in found if file.is_file() and file.name != LOCK])  # which is empty


# -- any bit of any file ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("trials", [30, pytest.param(200, marks=pytest.mark.slow)])
def test_no_flipped_bit_is_silent_in_a_finished_run(runs, copy, trials):
    directory, chance = copy(runs.finished), random.Random(1)
    seen = []
    for _ in range(trials):
        file = any_file(directory, chance)
        before = flip(file, chance)
        seen.append(runs.opened(directory))
        file.write_bytes(before)
    assert True in seen and False in seen


@pytest.mark.parametrize("trials", [6, pytest.param(40, marks=pytest.mark.slow)])
def test_no_flipped_bit_is_silent_in_a_resumed_run(runs, copy, trials):
    chance, seen = random.Random(2), []
    for number in range(trials):
        directory = copy(runs.cut, str(number))
        flip(any_file(directory, chance), chance)
        seen.append(runs.resumed(directory))
        shutil.rmtree(directory)
    assert True in seen and False in seen


# -- a case file that was edited --------------------------------------------------------------------------------------

REFUSED = r"case\.toml was changed \(.*→.*put it back|case\.toml: cannot be read as a case .*put the run's own back"


def test_no_edit_mixes_two_cases(runs, copy):
    """Neither in the data of a finished run, nor between stop and resume, nor while an object has the run in memory."""
    finished, cut = copy(runs.finished), copy(runs.cut, "cut")
    text = (finished / "case.toml").read_text()
    opened = RunStore.open(cut)
    all_edits = [ertel.to_toml(changed) for _, changed in changed_cases(opened.case.to_data())]
    spot = '\n[[roughness]]\nshape = "spot"\nheight = 0.1\nradius = 0.5\n'
    other = text.replace("schema = 1", "schema = 2"), text.replace('kind = "', 'kind = "un')
    for edited in (*all_edits, text + spot, *other):
        assert edited != text
        for directory in (finished, cut):
            (directory / "case.toml").write_text(edited)
        for look in (lambda: ertel.open(finished), lambda: compute(RunStore.open(cut)), lambda: compute(opened)):
            with pytest.raises(StoreError, match=REFUSED):
                look()
    assert len(all_edits) >= 14
    renamed = text.replace('"small"', '"renamed"').replace("[lubricant]", '[lubricant]\nreference = "new"')
    assert renamed != text  # which no result depends on
    for directory in (finished, cut):
        (directory / "case.toml").write_text(renamed)
    compute(opened)
    assert runs.opened(cut) and runs.opened(finished)
    assert RunStore.open(finished).case.name == "renamed"


# -- the data ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("chunk", ["H_c/c/0", "P/c/1/0/0", "event/c/0", "X/c/0"])
def test_a_missing_chunk_is_noticed(impact, copy, chunk):
    directory = copy(impact.finished)
    (directory / "run.zarr" / chunk).unlink()
    name = chunk.split("/")[0]
    with pytest.raises(Damaged, match=rf"run\.zarr/{name}: .*1 of \d chunks are missing"):
        ertel.open(directory)
    if name in ("H_c", "event"):  # xarray alone reads what is no value of a run
        values = xr.open_zarr(directory / "run.zarr")[name].values
        assert (values == -1 if name == "event" else np.isnan(values)).all()


def all_metadata(root: dict[str, Any]) -> dict[str, Any]:
    return root["consolidated_metadata"]["metadata"]


@pytest.mark.parametrize(
    ("edit", "said"),
    [
        (lambda root: root["attributes"].update(R_m=0.02), "not agree"),
        (lambda root: all_metadata(root)["H_c"]["attributes"].update(si_factor=1.0), "not agree"),
        (lambda root: all_metadata(root).pop("H_c"), "not agree"),
        (lambda root: root.pop("consolidated_metadata"), "not agree"),
        (lambda root: root["attributes"].pop("checksum"), "no checksum; older versions"),
    ],
)
def test_changed_metadata_are_noticed(impact, copy, edit, said):
    directory = copy(impact.finished)
    path = directory / "run.zarr" / "zarr.json"
    root = json.loads(path.read_text())
    edit(root)
    path.write_text(json.dumps(root))
    for read in (ertel.open, lambda path: compute(RunStore.open(path)), lambda path: ertel.run(impact.case, path)):
        with pytest.raises(Damaged, match=rf"zarr\.json: is damaged \(.*{said}.*; the run must be computed again"):
            read(directory)
    assert (directory / "summary.json").exists()


def test_data_older_than_the_checkpoint_are_refused(impact, copy):
    directory = copy(impact.cut)
    shutil.rmtree(directory / "run.zarr")
    shutil.copytree(impact.begun / "run.zarr", directory / "run.zarr")
    with pytest.raises(Damaged, match=r"run\.zarr: is damaged \(holds fewer rows than the checkpoint counts\)"):
        compute(RunStore.open(directory))


def test_a_run_that_another_version_left_unfinished_is_refused(impact, copy):
    """Without a variable: the rows to come would have no place."""
    directory = copy(impact.cut)
    root = arrays.read_root(directory / "run.zarr", "")
    del all_metadata(root)["mu_sliding"]
    arrays.write_root(directory / "run.zarr", root)
    with pytest.raises(StoreError, match="was left unfinished by another version of ertel; the run must be"):
        compute(RunStore.open(directory))


def test_data_that_are_replaced_while_they_are_read(steady, copy, monkeypatch):
    """By the process that computes them, grid by grid."""
    data, read, attempts = copy(steady.finished) / "run.zarr", arrays._read, itertools.count()

    def replaced(path, advice):
        if next(attempts) == 0:
            arrays.update_attributes(data, {"title": "the next grid"}, advice)
            raise Damaged(path, "chunks are missing", advice)
        return read(path, advice)

    monkeypatch.setattr(arrays, "_read", replaced)
    assert RunStore.open(data.parent).dataset().attrs["title"] == "the next grid"
    assert next(attempts) == 2


def test_steady_data_are_written_again_from_the_checkpoint(steady, copy):
    directory = copy(steady.finished)
    flip(directory / "run.zarr" / "H" / "c" / "0" / "0", random.Random(4))
    with pytest.raises(Damaged, match=r"run\.zarr/H: is damaged .*; it is written again when the run is continued"):
        ertel.open(directory)
    assert steady.resumed(directory)


# -- the summary ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("text", ["", "[]", '{"status": "converged"}', "[" * 900])
def test_a_damaged_summary_is_written_again(impact, copy, text):
    directory = copy(impact.finished)
    (directory / "summary.json").write_bytes(text.encode("latin-1"))
    with pytest.raises(Damaged, match=r"summary\.json: is damaged .* written again when the run is continued"):
        ertel.open(directory)
    assert impact.resumed(directory)


def test_the_summary_of_another_case_is_refused(kinds, copy):
    directory = copy(kinds["impact"].finished)
    shutil.copy(kinds["radial"].finished / "summary.json", directory)
    with pytest.raises(StoreError, match=r"summary\.json is not that of case\.toml"):
        ertel.open(directory)
    assert kinds["impact"].resumed(directory)


# -- the checkpoint ---------------------------------------------------------------------------------------------------


def test_a_damaged_checkpoint_is_named(runs, copy):
    directory = copy(runs.cut)
    checkpoint = directory / "checkpoint.npz"
    whole = checkpoint.read_bytes()
    for length in (0, 10, -1):
        checkpoint.write_bytes(whole[:length])
        with pytest.raises(Damaged, match=r"checkpoint\.npz: is damaged .*checksum.*; delete it to have the run"):
            compute(RunStore.open(directory))
    checkpoint.unlink()
    assert runs.resumed(directory)


# -- nothing is executed ----------------------------------------------------------------------------------------------


def test_no_pickle_is_loaded_from_a_checkpoint(impact, copy):
    directory = copy(impact.cut)
    content = io.BytesIO()
    with zipfile.ZipFile(content, "w") as file:
        header = io.BytesIO()
        np.lib.format.write_array_header_1_0(header, {"descr": "|O", "fortran_order": False, "shape": (1,)})
        file.writestr("store_digest.npy", header.getvalue() + pickle.dumps([Evil()]))
    (directory / "checkpoint.npz").write_bytes(with_checksum(content.getvalue()))
    with pytest.raises(Damaged, match=r"checkpoint\.npz: is damaged \(Object arrays cannot be loaded"):
        compute(RunStore.open(directory))


def test_the_format_does_not_depend_on_the_environment(runs, tmp_path):
    """Zarr takes its default from ZARR_DEFAULT_ZARR_FORMAT; all runs were broken by it."""
    with zarr.config.set({"default_zarr_format": 2}):
        compute(RunStore.create(tmp_path / "run", runs.case), [stop_after(1)])
        assert runs.resumed(tmp_path / "run")
    found = xr.open_zarr(tmp_path / "run" / "run.zarr").load()
    xr.testing.assert_identical(physics(found), physics(runs.whole.dataset))


# -- kills, full disks and damage: a short form of validation/faults -------------------------------------------------

ALL = ["radial", "2d", "rolling", "steady", "ellipse", "thinning", "thinning in time", "thermal", "measured", "study"]
FAULTS = Path(__file__).parents[2] / "validation" / "faults" / "faults.py"


@pytest.mark.slow
@pytest.mark.parametrize(("kinds", "count"), [(["radial", "study"], 8), (ALL, 4 * len(ALL))], ids=["radial", "all"])
def test_nothing_is_silent_and_no_flushed_step_is_lost(tmp_path: Path, kinds: list[str], count: int):
    """In a process of its own, because it forks: so many kills and more, full disks, damaged runs."""
    environment = {**os.environ, "PYTHONPATH": str(Path(ertel.__path__[0]).parent), "TMPDIR": str(tmp_path)}
    faults = "kills", "disk", "bits"
    command = [sys.executable, str(FAULTS), *faults, "--count", str(count), "--seed", "14", "--kinds", *kinds]
    done = subprocess.run(command, capture_output=True, text=True, env=environment, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    ends = [line.partition(" trials")[0] for line in done.stdout.splitlines() if " trials, " in line]
    assert ends == [f"{fault}, seed 14: {count}" for fault in faults]
    assert "refused damage" in done.stdout
