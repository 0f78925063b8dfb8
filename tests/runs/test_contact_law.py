"""The law of a contact from a study: exact at its runs and for power laws, and read from a file without ertel."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from numpy.testing import assert_allclose

import ertel
from ertel.results.numbers import Number
from ertel.results.study_table import StudyRun, study_dataset
from ertel.results.variables import VARIABLES
from ertel.runs.studies import write_study
from ertel.runs.study_result import StudyResult

SPEEDS, LAYERS = [0.4, 0.1, 0.2], [3e-6, 12e-6]


def expected(v: Any, h: Any) -> tuple[Any, Any, Any]:
    """Power laws, the first of them 1 - e = St_c/St."""
    return np.broadcast_arrays(1 - 0.03 / v * (h / 1e-6) ** 0.3, 5e-5 * v**-0.2, 300 * v**1.2)


def run(v: float, h: float, status: str = "converged") -> StudyRun:
    values = zip(("restitution", "contact_time", "F_max"), expected(v, h), strict=True)
    numbers = {}
    for name, value in values:
        one = Number(name, VARIABLES[name], float(value), factor=1.0 if VARIABLES[name].scale else None).in_si
        numbers[one.name] = one
    return StudyRun(numbers if status == "converged" else {}, [], status, f"runs/{v}-{h}")


def study(runs: list[StudyRun], kind: str = "impact", layers: Any = LAYERS) -> StudyResult:
    along = {"speed": (SPEEDS, {"units": "m/s"}), "layer": (layers, {"units": "m"})}
    used = {name: axis for name, axis in along.items() if axis[0]}
    return StudyResult(study_dataset("product", used, runs, {"title": "wet", "kind": kind}))


RUNS = [run(v, h) for v in SPEEDS for h in LAYERS]
LAW = ertel.contact_law(study(RUNS))


def test_at_the_runs_and_for_power_laws_it_is_exact() -> None:
    for v, h in (
        (np.array(SPEEDS)[:, None], np.array(LAYERS)),
        (np.linspace(0.1, 0.4, 7)[:, None], np.geomspace(3e-6, 12e-6, 5)),
    ):
        assert_allclose(LAW(v, h), expected(v, h), rtol=1e-13)
    law = ertel.contact_law(study([run(v, 3e-6) for v in SPEEDS], layers=[]))
    assert_allclose(law([0.2, 0.3]), expected(np.array([0.2, 0.3]), 3e-6), rtol=1e-13)
    without_unit = replace(law, dataset=law.dataset.assign_coords(speed=law.dataset["speed"].assign_attrs(units="1")))
    with pytest.raises(ValueError, match=r"must be from 0\.1 to 0\.4$"):
        without_unit(0.5)


def test_from_a_directory_with_texts_and_as_a_table(tmp_path: Path) -> None:
    write_study(study(RUNS), tmp_path)
    law = ertel.contact_law(tmp_path)
    assert_allclose(law("0.2 m/s", "6 um"), expected(0.2, 6e-6), rtol=1e-13)
    law.save(tmp_path / "law.csv")
    head, *rows = (tmp_path / "law.csv").read_text().splitlines()
    assert head == "speed_m_per_s,layer_m,restitution,duration_s,force_N" and len(rows) == 6
    with pytest.raises(ValueError, match="wrong dimension"):
        law("0.2 N", "6 um")
    with pytest.raises(ValueError, match="is not a study"):
        ertel.contact_law(tmp_path / "nothing")


def test_the_file_is_read_without_ertel(tmp_path: Path) -> None:
    LAW.save(tmp_path / "law.nc")
    table = xr.load_dataset(tmp_path / "law.nc")
    assert "St_c differs from oil to oil" in table.attrs["comment"]
    assert table["speed"].values.tolist() == [0.1, 0.2, 0.4]
    units = {"speed": "m/s", "layer": "m", "duration": "s", "force": "N"}
    assert {name: table[name].attrs["units"] for name in units} == units
    assert float(table["restitution"].sel(speed=0.2, layer=3e-6)) == pytest.approx(expected(0.2, 3e-6)[0], rel=1e-15)
    assert replace(LAW, dataset=table)(0.3, 5e-6) == LAW(0.3, 5e-6)


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ((0.5, 3e-6), r"speed = 0\.5: must be from 0\.1 to 0\.4 m/s"),
        ((0.2, [3e-6, 2e-6]), r"layer = 2e-06: must be from 3e-06 to 1\.2e-05 m"),
        ((float("nan"), 3e-6), r"speed = nan: must be from"),
        ((0.2,), r"got 1 values; give speed and layer"),
    ],
)
def test_outside_the_table_there_is_no_law(values: Any, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        LAW(*values)


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        (study([*RUNS[:4], run(0.2, 3e-6, "missing"), RUNS[5]]), r"1 of 6 runs.*runs/0\.2-3e-06 \(missing\)"),
        (study([*RUNS[:4], RUNS[4]._replace(status="the film vanishes"), RUNS[5]]), r"1 of 6 runs failed.*vanishes"),
        (study([run(1, 1, "failed: no film")] * 6), r"6 of 6 runs failed or have no rebound.*failed: no film.*rebound"),
        (study(RUNS, kind="rolling"), r'"product" of rolling cases'),
        (study(RUNS, layers=[0.0, 3e-6]), r"layer must have two or more values above zero"),
        (study(RUNS, layers=["thin", "thick"]), r"layer must have two or more values above zero"),
    ],
)
def test_studies_that_give_no_law(wrong: StudyResult, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        ertel.contact_law(wrong)
