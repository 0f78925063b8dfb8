"""What a run with the section [thermal] says: maps in K, a part of the summary, lines to read, warnings."""

from contextlib import ExitStack
from pathlib import Path
from typing import Any
from unittest.mock import patch

import numpy as np
import pytest
from cases import STEEL_BODIES
from made_up import BALL_ROLLS, solutions, steady

import ertel
from ertel.apps.tables import print_summary
from ertel.case.estimates import grid_of
from ertel.case.sections import Inlet
from ertel.case.status import Status
from ertel.inputs.case_files import parse_case
from ertel.physics.thermal import AT_REST, SLOWEST, slow_excess
from ertel.results.dataset import assemble_steady
from ertel.results.diagnostics import thermal_warnings
from ertel.results.numbers import key_numbers, lines
from ertel.results.summary import steady_summary
from ertel.results.variables import HEATED_MAPS, to_si
from ertel.runs.store import RunStore
from ertel.solvers import grid_solution
from ertel.solvers.heat import heated

pytestmark = pytest.mark.filterwarnings("ignore:H_min is uncertain", "ignore:the pressure spike", "ignore:surface")
DATA = {"temperature": "40 degC", "conductivity": "0.14 W/(m*K)", "beta": "0.04 / K"} | STEEL_BODIES
OIL = {"eta0": "40 mPa*s", "alpha": "22 / GPa"}
CONTACT = {"kind": "rolling", "radius": "10 mm", "E_prime": "219.7802 GPa", "load": "3.888524 N"}
CONTACT |= {"mean_speed": "2 m/s", "slide_to_roll": 0.03}  # so fast that both surfaces move: a program of traction's


def case_of(**sections: Any) -> ertel.Case:
    return parse_case({"contact": CONTACT, "lubricant": OIL, "solver": {"nodes": 65}, **sections})


def computed(folder: Path, flush_interval: float) -> tuple[ertel.Result, dict[str, int]]:
    """A stored run with heat, and how often account and heat were computed."""
    names = "_account_program", "heated"
    with ExitStack() as stack:
        stack.enter_context(patch.object(RunStore, "flush_interval", flush_interval))
        mocks = [
            stack.enter_context(patch.object(grid_solution, name, wraps=getattr(grid_solution, name))) for name in names
        ]
        run = ertel.run(case_of(thermal=DATA | {"inlet": "gupta"}), folder)
    return run, {name: mock.call_count for name, mock in zip(names, mocks, strict=True)}


@pytest.fixture(scope="module")
def counted(tmp_path_factory: pytest.TempPathFactory) -> tuple[ertel.Result, dict[str, int]]:
    return computed(tmp_path_factory.mktemp("runs") / "run", 100.0)  # which is written at its end alone


@pytest.fixture(scope="module")
def run(counted: tuple[ertel.Result, dict[str, int]]) -> ertel.Result:
    return counted[0]


def test_maps_and_summary(run: ertel.Result) -> None:
    """Both are those of `heated`, in K, on the whole plane; the shear stress of the warm film is odd along y."""
    data, said = run.dataset, run.summary
    found = heated(run.case, *(data[name].values[32:] for name in ("P", "H")))
    for name, part, sign in (("tau_x_warm", 0, 1.0), ("tau_y_warm", 1, -1.0)):
        assert data[name].attrs["in_units_of"] == data["tau_x"].attrs["in_units_of"]
        np.testing.assert_allclose(data[name].values[32:], found.stress[part], atol=1e-9)
        np.testing.assert_array_equal(data[name].values, sign * data[name].values[::-1])
    for name in ("T_1", "T_2", "T_film"):
        assert data[name].dims == ("Y", "X") and data[name].attrs["units"] == "K"
        np.testing.assert_allclose(data[name].values[32:], getattr(found, name), atol=1e-9)
        np.testing.assert_array_equal(data[name].values, data[name].values[::-1])
        assert said[f"{name}_max"] == pytest.approx(float(data[name].max()))
        assert said[f"{name}_max"] > 313.15 + 0.04
        assert to_si(data)[name].attrs["units"] == "K"
    assert 313.15 < said["T_film_mean"] < said["T_film_max"]
    assert said["thermal"]["converged"]
    assert said["T_max"] == pytest.approx(313.15 + float(found.T.max())) and said["T_max"] >= said["T_1_max"]
    across = data["T_across"].sel(X=said["X_T_max"], method="nearest")  # the hottest place is on the axis
    assert float(across.max()) == pytest.approx(said["T_max"]) and said["Y_T_max"] == 0.0
    assert float(across[across.dims[0]][int(np.argmax(across.values))]) == pytest.approx(said["zeta_T_max"])
    data = assemble_steady(run.case, grid_of(run.case), [])
    assert all(data[name].shape == (65, 65) and np.isnan(data[name]).all() for name in HEATED_MAPS)


def test_what_is_said_and_shown(run: ertel.Result, capsys: pytest.CaptureFixture[str]) -> None:
    said, si = run.summary, run.summary["si"]
    assert said["phi_T"] < 1.0
    assert si["h_c_warm_m"] == pytest.approx(said["phi_T"] * si["h_c_m"])
    assert si["h_min_warm_m"] == pytest.approx(said["phi_T"] * si["h_min_m"])
    assert 0.5 < said["mu_sliding_warm"] / said["mu_sliding"] < 1.1  # thinner by phi_T, and less viscous
    text = "\n".join(lines(said))
    hottest = f"highest temperatures: surface 1 {said['T_1_max'] - 273.15:.1f} degC"
    for part in (f"(phi_T = {said['phi_T']:.4g}, L_t = {said['L_t']:.3g})", "central film thickness, warm", hottest):
        assert part in text
    assert f"{said['mu_sliding_warm']:.4g}" in text
    # Tables have the warm films, friction and a temperature; the cold films follow in one line.
    print_summary(run.case, said)
    rows = capsys.readouterr().out.splitlines()
    assert [(row.split()[4], " nm " in row) for row in rows[3:5]] == [("H_c_warm", True), ("H_min_warm", True)]
    assert [row.startswith("Without heat") for row in rows if " H_c " in row] == [True]
    assert any("mu_sliding_warm" in row for row in rows)
    assert [number.name for number in key_numbers(said)][-1] == "T_film_max"
    assert key_numbers(said)[-1].text.endswith(" degC")


def test_off_when_absent() -> None:
    assert "thermal" not in steady_summary(BALL_ROLLS, solutions(BALL_ROLLS), {}, Status.CONVERGED)
    assert not set(HEATED_MAPS) & set(steady(BALL_ROLLS))


def test_warnings(run: ertel.Result) -> None:
    found = heated(run.case, *(run.dataset[name].values[32:] for name in ("P", "H")))
    assert thermal_warnings(run.case, found._replace(peclet=(8.0, 0.0))) == []
    slow = thermal_warnings(run.case, found._replace(peclet=(2.0, 1.0)))
    assert [line[:17] for line in slow] == ["surface 1 moves s", "surface 2 moves s"]
    hot, _ = thermal_warnings(run.case, found._replace(inlet=Inlet(1.5, 0.6), peclet=(8.0, 8.0)))
    assert hot.startswith("the inlet factor phi_T = 0.6 (Gupta") and "for L_t up to about 1" in hot
    [lost] = thermal_warnings(run.case, found._replace(converged=False, peclet=(8.0, 8.0)))
    assert lost.startswith("the temperatures did not converge")


def test_how_much_too_hot_a_slow_surface_is() -> None:
    """Tian and Kennedy: 2 q a/[k (pi (4/pi + Pe))^{1/2}], at rest q a/k, fast 2 q a/[k (pi Pe)^{1/2}]."""
    for peclet in (0.3, AT_REST, 3.0, SLOWEST, 30.0):
        rise = 2.0 / np.sqrt(np.pi * (AT_REST + peclet))
        ours = 1.0 if peclet < AT_REST else 2.0 / np.sqrt(np.pi * peclet)
        assert slow_excess(peclet) == pytest.approx(ours / rise - 1.0)
    assert slow_excess(0.0) == 0.0


def test_account_and_heat_are_computed_once_for_a_grid(counted: tuple[ertel.Result, dict[str, int]], tmp_path) -> None:
    """Checkpoints, data and summary share them; the heat is that of the finest grid so far, of 33 and 65 nodes."""
    assert counted[1] == {"_account_program": 2, "heated": 1}
    assert computed(tmp_path / "run", 0.0)[1] == {"_account_program": 2, "heated": 2}
