"""Runs with rough surfaces: what a grid keeps of them, and a run directory that needs nothing from outside."""

import sys
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from cases import ertel_, impact, names, physics, stop_after

import ertel
from ertel.case.case import Case
from ertel.case.estimates import grid_of
from ertel.case.height_map import HeightMap, Measured
from ertel.equations import discretise
from ertel.inputs.case_files import load_case
from ertel.physics.surfaces import Feature, SelfAffine
from ertel.plots.view import View
from ertel.results import diagnostics
from ertel.runs.compile import compilations
from ertel.runs.drive import simulate
from ertel.runs.files import StoreError
from ertel.runs.store import RunStore, compute
from ertel.solvers import steady

ROUGH = SelfAffine(rms=0.02, hurst=0.8, shortest=0.2, longest=1.0, seed=3)
HEIGHTS = np.random.default_rng(0).normal(size=(20, 30))
DISC = Measured(HeightMap(HEIGHTS), 6.0, 4.0, 0.02)
TOML = """
name = "rough"
contact = { M = 200, L = 10 }
solver = { nodes = 33 }
time = { tolerance = 0.01, until = 0.4 }
[[roughness]]
shape = "measured"
file = "disc.npy"
detrend = "none"
length_x = 4.5
rms = 0.01
cutoff = 0.5
"""


def rough(nodes: int, shape: Any = ROUGH) -> Case:
    return replace(impact(200, 10, nodes, time={"tolerance": 0.01, "until": 0.1}), roughness=(Feature(shape),))


@pytest.mark.parametrize("shape", [ROUGH, DISC], ids=["self-affine", "measured"])
def test_a_coarse_grid_has_no_waves_that_are_none(shape) -> None:
    """Taken at every fourth node the short waves would look like long ones: as high as they are themselves."""
    case = rough(129, shape)
    fine = grid_of(case)
    coarse = fine.coarser().coarser()
    X, Y = coarse.kept_x[None, :], coarse.kept_y[:, None]
    long_ones = shape.heights_above(2.0 * 2.0 * coarse.spacing, X, Y)
    mistaken = np.sqrt(np.mean((shape.heights(X, Y) - long_ones) ** 2))
    kept = np.sqrt(np.mean((np.asarray(discretise.heights(case.features, case, coarse, 0.0)) - long_ones) ** 2))
    assert kept < 1e-12 < 0.1 * mistaken


def test_a_grid_that_resolves_a_surface_has_all_of_it() -> None:
    case = rough(129)
    grid = grid_of(case)
    found = discretise.heights(case.features, case, grid, 0.0)
    np.testing.assert_allclose(found, ROUGH.heights(grid.kept_x[None, :], grid.kept_y[:, None]), atol=1e-14)
    # The wave fronts pass with the surface, seen by one who moves with the mean speed.
    case = ertel.rolling(M=200, L=10, method="transient", nodes=65, motion={"slide_to_roll": 1.0}, roughness=[ROUGH])
    smooth = replace(case, roughness=())
    grid = grid_of(case)
    found = discretise.gap_change(case, grid, 0.3) - discretise.gap_change(smooth, grid, 0.3)
    step, now = 1e-3, discretise.CELLS_KEPT * grid.spacing
    X, Y = grid.kept_x[None, :] - 1.5 * 0.3, grid.kept_y[:, None]
    slope = (ROUGH.heights_above(now, X + step, Y) - ROUGH.heights_above(now, X - step, Y)) / (2 * step)
    np.testing.assert_allclose(found, 0.5 * slope, atol=1e-4 * np.abs(slope).max())


@pytest.mark.slow
def test_second_order_in_space() -> None:
    """The film on the grids of the nested iteration, of which the coarsest lacks the shortest waves (2.7 cells)."""
    surface = replace(ROUGH, rms=0.01, shortest=0.5, longest=2.0, seed=1)
    case = ertel.rolling(M=50, L=8, nodes=129, motion={"slide_to_roll": -2.0}, roughness=[surface])
    grids = steady.settled(case).solutions[-3:]
    assert [s.grid.nodes for s in grids] == [33, 65, 129]
    films = [np.asarray(s.H)[::step, ::step] for s, step in zip(grids, (1, 2, 4), strict=True)]
    inside = np.hypot(grids[0].grid.x, grids[0].grid.y[:, None]) < 0.8
    early, late = (np.sqrt(np.mean((a - b)[inside] ** 2)) for a, b in pairwise(films))
    assert np.log2(early / late) > 1.8


@pytest.mark.parametrize(
    ("shape", "nodes", "said"),
    [
        (ROUGH, 65, "3.2 cells across its smallest width 0.2 a, about 16 are needed; waves below 4 cells are"),
        (ROUGH, 65, "or leave out waves of roughness[1] below 1 a"),
        (replace(ROUGH, longest=3.0, shortest=1.0), 65, ""),
        (DISC, 65, "6.4 cells across its smallest width 0.4 a"),
        (replace(DISC, cutoff=1.0), 65, ""),
        (replace(DISC, length_x=2.4, cutoff=1.0), 65, "the map is smaller than the contact (without"),
    ],
)
def test_what_the_grid_and_the_map_lack_is_said(shape, nodes, said) -> None:
    warned = " ".join(text for text in diagnostics.case_warnings(rough(nodes, shape)) if "roughness" in text)
    assert said in warned
    assert bool(warned) == bool(said)


def test_another_surface_needs_no_compilation() -> None:
    simulate(rough(33))
    compiled = compilations()
    for shape in (replace(ROUGH, seed=5, longest=0.7), DISC):
        simulate(rough(33, shape))
    assert compilations() == compiled


@pytest.fixture
def case(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Case:
    """A case whose file is gone when it is run, and so is the package that would read others."""
    np.save(tmp_path / "disc.npy", HEIGHTS)
    (tmp_path / "rough.toml").write_text(TOML, encoding="utf-8")
    found = load_case(tmp_path / "rough.toml")
    (tmp_path / "disc.npy").unlink()
    monkeypatch.setitem(sys.modules, "SurfaceTopography", None)
    return found


@pytest.fixture
def roller() -> Case:
    """With a profile on a surface at rest."""
    x = np.linspace(0.0, 8.0, 400)
    profile = Measured(HeightMap(np.cos(9 * x) + np.cos(4 * x)), 8.0, rms=0.01, cutoff=0.5)
    motion = {"slide_to_roll": -2.0}
    return ertel.rolling(radius_ratio=0, M=10, L=10, nodes=65, motion=motion, roughness=[profile])


@pytest.mark.parametrize(
    ("name", "figure"), [("case", "maps"), pytest.param("roller", "midlines", marks=pytest.mark.slow)]
)
def test_a_run_is_resumed_shown_and_plotted_from_its_directory_alone(tmp_path, request, name, figure) -> None:
    directory, case = tmp_path / "run", request.getfixturevalue(name)
    compute(RunStore.create(directory, case), [stop_after(4)])
    (feature,) = case.features
    assert f"heights-{feature.shape.file.digest}.npy" in names(directory)
    moved = directory.rename(tmp_path / "moved")
    ertel_("resume", str(moved))
    ertel_("show", str(moved))
    ertel_("plot", str(moved), "--what", figure)
    data, whole = ertel.open(moved).dataset, simulate(case).dataset
    xr.testing.assert_identical(physics(data), physics(whole))
    X, Y = np.linspace(-1, 1, 9)[None, :], np.linspace(-1, 1, 5)[:, None]
    shown = View(data).roughness(X, Y)
    np.testing.assert_allclose(shown, feature.shape.heights_above(4 * grid_of(case).spacing, X, Y), atol=1e-15)
    assert np.ptp(shown) > 0.001


def test_the_directory_has_the_heights(tmp_path, case) -> None:
    RunStore.create(tmp_path / "run", case)
    again = load_case(tmp_path / "run" / "case.toml")
    assert again == case and again.digest == case.digest
    (tmp_path / "case.toml").write_bytes((tmp_path / "run" / "case.toml").read_bytes())
    with pytest.raises(ertel.ConfigError, match=r'^roughness\[1\].file = "heights-.*: cannot be read'):
        load_case(tmp_path / "case.toml")


@pytest.mark.parametrize("damage", ["changed", "cut", "gone"])
def test_a_damaged_copy_is_noticed(tmp_path, case, damage) -> None:
    RunStore.create(tmp_path / "run", case)
    (copy,) = (tmp_path / "run").glob("heights-*.npy")
    if damage == "changed":
        np.save(copy, HEIGHTS + 1e-9)
    elif damage == "cut":
        copy.write_bytes(copy.read_bytes()[:500])
    else:
        copy.unlink()
    with pytest.raises(StoreError, match=r"case.toml: cannot be read as a case \(roughness\[1\].file = .*put the run"):
        RunStore.open(tmp_path / "run")
