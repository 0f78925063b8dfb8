"""The paper's waves: bars, dots and marks on made-up fields whose answer is known, and on small runs."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import xarray as xr

from ertel.apps.boundary_layers import beyond, reduction, runs
from ertel.apps.boundary_layers.figures import FIGURES
from ertel.apps.boundary_layers.pages import Drawn
from ertel.apps.boundary_layers.plans import QUICK
from ertel.apps.boundary_layers.reduction import extrapolated, over_film
from ertel.physics import amplitude_reduction
from ertel.physics.scales import Parameters
from ertel.results.waves import local_nabla2

M, L, WAVE = 200, 10, 0.4
X = np.linspace(-1.5, 1.5, 301)
SMALL = replace(
    QUICK,
    radial_nodes=101,
    impacts={(M, L): (WAVE,)},
    impact_grids=(33, 65),
    rolling={(M, L): (1.0, 1.5)},
    rolling_grids=(33, 65),
    twins=((M, L, WAVE, 0.6),),
    twin_grids=(33, 65),
    marched=(100, L, 1.0, 65),
    shown=(M, L),
    shaped={(M, L): (WAVE,)},
    oils={(M, L): (WAVE,)},
    soft={M: (WAVE,)},
    beyond_grids=(33, 65),
    straight=((M, L, 1.0),),
    straight_grids=(33, 65),
    starved={"impact": ((M, L),), "rolling": ((50, 10),)},
    starved_grids=(33, 65),
)


def test_extrapolation_and_its_bar():
    """Of errors with h^2 the limit is exact; with h the bar just reaches it."""
    second, first = extrapolated(0.5 + 0.04, 0.5 + 0.01), extrapolated(0.5 + 0.04, 0.5 + 0.02)
    assert second["limit"] == pytest.approx(0.5)
    assert first["limit"] - first["error"] == pytest.approx(0.5)


def fading(amplitude: float) -> xr.Dataset:
    """What an impact leaves of one wave, and a front that comes to rest at 1, A^2 = 1 - (1 - T)^2."""
    T = np.linspace(0, 1, 101)
    dH = amplitude * np.cos(2 * np.pi * X / WAVE)
    names = [runs.wave_name(shape, runs.HEIGHT, WAVE) for shape in ("transverse", "rings")]
    return xr.Dataset(
        {
            "dH": (("wave", "X"), [dH, dH / 2]),
            "along": (("wave", "X"), [np.full_like(X, amplitude / 4)] * 2),
            "X_min": ("time", np.sqrt(1 - (1 - T) ** 2)),
            "Y_min": ("time", np.zeros_like(T)),
            "P_max": ("time", np.ones_like(T)),
        },
        {"X": X, "time": T, "frame": 1.0, "wave": names},
    )


def test_marks_of_other_shapes():
    results = {task.name: fading(A) for task, A in zip(runs.shape_runs(SMALL)[M, L], (0.6, 0.5), strict=True)}
    marks = list(beyond.impacts_on_shapes(results, SMALL))
    assert [mark["kind"] for mark in marks] == ["transverse", "rings", "longitudinal"]
    assert [mark["coarse"] for mark in marks] == pytest.approx([0.6, 0.3, 0.15], rel=1e-3)
    assert [mark["fine"] for mark in marks] == pytest.approx([0.5, 0.25, 0.125], rel=1e-3)
    across, _, along = marks
    assert along["X"] == across["X"] == pytest.approx(0.7)
    speed, p = np.sqrt(1 - across["X"] ** 2) / across["X"], Parameters.from_moes(M, L)
    assert across["local"] == pytest.approx(float(local_nabla2(p, WAVE, speed)), rel=0.02)
    assert across["hertz"] == pytest.approx(float(local_nabla2(p, WAVE, speed, across["X"])), rel=0.02)


def test_figure_5():
    """The last complete wave of a response of constant amplitude 0.4."""
    known, name = fading(0.4), runs.wave_name("isotropic", runs.HEIGHT, WAVE)
    response = known.isel(wave=[0]).assign(shape=known["dH"], H=known["dH"][0]).assign_coords(wave=[name])
    smooth, _, fine = reduction.wave_tasks(SMALL)
    made = reduction.deformed_waves({smooth.name: known, fine.name: response}, SMALL)
    [table] = made.tables.values()
    assert table.to_dict("list") == {"wavelength (a*)": ["0.4"], "X": ["0.700"], "A_d/A_i": ["0.400"]}
    assert list(made.data["dH"]) == ["X", "H", "dH/A_i, wavelength 0.4"]


def test_wavelength_over_film_is_nabla2_where_the_oil_is_piezoviscous():
    p = Parameters.from_moes(M, L)
    assert over_film(p, WAVE) == pytest.approx(p.nabla2(WAVE))
    assert over_film(p, WAVE, 0.3, 0.7) == pytest.approx(float(local_nabla2(p, WAVE, 0.3, 0.7)))
    soft = Parameters.from_moes(M, 0)
    assert over_film(soft, WAVE) == pytest.approx(WAVE / (0.3135 * np.sqrt(soft.lambda_bar)))


# -- the figures themselves, from small runs ---------------------------------------------------------------------------


def drawn(name: str, results: dict[str, Any]) -> Drawn:
    for task in FIGURES[name].tasks(SMALL):
        if task.name not in results:
            results[task.name] = task.function(*task.arguments)
    made = FIGURES[name].draw(results, SMALL)
    for table in made.tables.values():
        assert len(table) and table.notna().all().all()
    for table in made.data.values():
        assert table.notna().any().all()
    return made


@pytest.mark.slow
def test_figures_of_waves():
    results: dict[str, Any] = {}  # what has been run already, shared by the figures
    made = drawn("fig6", results)
    assert 0.3 < made.data["rolling"]["limit"][0] < 0.8
    assert made.data["impact"]["last"].sum() == 1
    assert (drawn("fig7", results).data["impact"]["fine"] < 1.05).all()
    assert len(drawn("fig8", results).tables[f"Compared with {runs.USUAL}"]) == 2


@pytest.mark.slow
def test_a_starved_impact_follows_a_curve_like_that_of_rolling():
    made = drawn("fig9", {})
    fits = made.tables["Exponents of the curve"]
    assert list(fits["contact"]) == ["impact", "rolling"]
    assert fits["g"].astype(float).between(1.8, 3.2).all()
    shares = made.data["starved"]
    assert (shares["R"] < np.minimum(shares["r"], 1.0) + 0.02).all()


@pytest.mark.slow
def test_long_ridges_under_rolling():
    """Hardly deformed where they are short, nearly flat where they are long, as (15) has it with f = e."""
    nabla2 = Parameters.from_moes(M, L).nabla2(0.5)
    found = runs.ridged_rolling(M, L, 0.5, 65)
    assert found == pytest.approx(float(amplitude_reduction.ratio_left(nabla2, np.inf)), abs=0.2)
