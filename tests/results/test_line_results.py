"""Numbers, profiles, files and fronts of line contacts: all along x, in SI those of the whole roller."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

import ertel
from ertel.physics.line_scales import LineScales
from ertel.results import numbers
from ertel.results.dataset import to_csv, to_netcdf, to_vtk
from ertel.results.variables import VARIABLES

ACROSS = {name for name, variable in VARIABLES.items() if variable.is_across} | {"Y", "y"}


@pytest.fixture(scope="module")
def steady(lines: Path) -> ertel.Result:
    return ertel.open(lines / "steady")


@pytest.fixture(scope="module")
def impact(lines: Path) -> ertel.Result:
    return ertel.open(lines / "impact")


def test_nothing_lies_across_a_line(steady: ertel.Result, impact: ertel.Result, tmp_path: Path) -> None:
    assert ACROSS > {"Y_min", "Y_P_max", "mu_sliding_y", "mu_sliding_y_warm", "tau_y"}
    for run in (steady, impact):
        assert not ACROSS & {*run.dataset.variables, *run.summary, *numbers.scalars(run.summary)}
        assert run.dataset["H"].dims[-1] == "X" and run.dataset["H"].shape[-1] == run.case.solver.nodes
        assert not any("y =" in line or "Y =" in line for line in numbers.lines(run.summary))
        assert all("Y" not in one for one in run.summary.get("extremes", {}).values())
        (table,) = to_csv(run.dataset, tmp_path)
        assert not ACROSS & {*table.read_text().splitlines()[0].split(",")}
    assert "on 129 nodes along x" in repr(steady)
    assert "X = 0.9" in repr(impact) and " a*\n" in repr(impact)
    for text in (repr(impact), repr(impact.case)):  # 2d is the name of a square grid
        assert "impact (line contact, in time), M = " in text and "(2d)" not in text


def test_units_are_those_of_the_whole_roller(steady: ertel.Result, impact: ertel.Result) -> None:
    found = numbers.scales_in(steady.summary)
    assert isinstance(found, LineScales) and found.length == pytest.approx(0.01)
    assert found.load == pytest.approx(2000)
    table = numbers.numbers(steady.summary)
    assert table["load"].in_si.value == pytest.approx(2000, rel=1e-6)
    rolling = 0.5 * np.trapezoid(steady.si["h"] * np.gradient(steady.si["p"], steady.si["x"]), steady.si["x"]) * 0.01
    assert table["mu_rolling"].value * 2000 == pytest.approx(rolling, rel=0.05)
    lost = 2 * rolling + 2000 * table["mu_sliding"].value * 0.0001  # W, at 1 m/s
    assert table["power_loss"].in_si.value == pytest.approx(lost, rel=0.05)
    assert steady.dataset["load"].attrs["in_units_of"] == "a* p_h*" and table["load"].unit == "a p_h"
    assert impact.dataset["mass"].attrs["in_units_of"] == "rho0 a*^3/R"
    assert impact.dataset["F"].attrs["in_units_of"] == "F*"


def test_files_for_other_programs(impact: ertel.Result, tmp_path: Path, steady: ertel.Result) -> None:
    (path,) = to_netcdf(impact.dataset, tmp_path)
    with xr.open_dataset(path, engine="scipy") as stored:
        assert stored["P"].dims == ("frame", "X")
        np.testing.assert_array_equal(stored["P"], impact.dataset["P"])
    pytest.importorskip("pyevtk")
    with pytest.raises(ValueError, match="a line contact has profiles only"):
        to_vtk(impact.dataset, tmp_path)
    line = steady.profile()
    assert line["h"].dims == ("x",)
    film = ertel.Measurement("profile", "h", line["h"].values[40:90], line["x"].values[40:90] + 5e-6, align="centre")
    found = steady.compare(film)
    assert found.shift["centre"] == pytest.approx(5e-6, abs=1e-7)
    assert found.rms < 1e-9
    with pytest.raises(ValueError, match="nothing of a line contact changes along y"):
        steady.compare(replace(film, along="y"))
    oil, last = steady.track, float(steady.dataset["oil"].values[-1])
    assert oil == f"{last * steady.case.scales.film!r} m"
    case = ertel.rolling(M=20, L=10, radius_ratio=0, layer=last)
    assert case.layer == pytest.approx(last)


def test_the_front_of_a_line_impact(impact: ertel.Result) -> None:
    front = ertel.fronts.front(impact.dataset)
    assert np.all(np.diff(front.A) > -0.01) and 0.85 < front.A[-1] < 1.0
    H = ertel.fronts.at_max_approach(impact.dataset)["H"]
    X = np.linspace(0.3, 0.8, 6)
    assert np.isfinite(front.speed_at(X)).all() and np.all(np.diff(np.interp(X, H["X"], H)) < 0.0)
