"""Stresses in the bodies of a run: which loads, which numbers, pictures and files."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from cases import REFUSALS, ertel_
from made_up import BALL_FALLS, BALL_ROLLS, C1, MOES_FALLS, dry_impact, solutions, steady

import ertel
from ertel import plots
from ertel.case.status import Status
from ertel.inputs.case_files import parse_case
from ertel.plots.drawing import NoFigure
from ertel.results import numbers
from ertel.results.stress import loads_on, shear_on_body, stress, stress_numbers
from ertel.results.summary import steady_summary
from ertel.runs.outlook import with_case_warnings

STEEL = replace(BALL_ROLLS, contact=replace(BALL_ROLLS.contact, E_prime=None, E1=210e9, nu1=0.3, E2=82e9, nu2=0.206))


@pytest.fixture(scope="module")
def ball() -> xr.Dataset:
    """A Hertz pressure with an inlet, and no sliding."""
    return steady(BALL_ROLLS)


@pytest.fixture(scope="module")
def line(lines: Path) -> ertel.Result:
    return ertel.open(lines / "steady")


def test_the_film_brakes_and_drives(line: ertel.Result) -> None:
    """Its force on a body is minus the friction coefficient times the load; see F1 of the page on friction."""
    mu, rolling = line.summary["mu_sliding"], line.summary["mu_rolling"]
    for body, coefficient in ((1, mu + rolling), (2, rolling - mu)):
        surface = line.stress(body=body, depths=[0.0])
        force = np.trapezoid(-surface["sigma_xz"][0], surface["x"]) * 0.01  # m long
        assert force / 2000.0 == pytest.approx(-coefficient, rel=0.03)  # the slopes of the pressure are differences
        np.testing.assert_allclose(surface["sigma_zz"][0], -line.si["p"], atol=1e-6 * float(line.si["p"].max()))


def test_shear_on_a_body_of_a_known_film(ball: xr.Dataset) -> None:
    """A film with tau_m = 2 under a pressure that rises by 1: H/2 = 0.25 of it pulls both bodies back."""
    X = np.linspace(-1.0, 1.0, 9)
    P = np.where(np.abs(X[:, None]) < 0.6, X + 2.0, 0.0)
    film = {"P": P, "H": np.full((9, 9), 0.5), "tau_x": np.full((9, 9), 2.0), "tau_y": np.full((9, 9), 0.5)}
    for body, sign in ((1, -1.0), (2, 1.0)):
        q_x, q_y = shear_on_body(film, X[1] - X[0], body)
        np.testing.assert_allclose(q_x, np.where(P > 0.0, 2.0 * sign - 0.25, 0.0))
        np.testing.assert_allclose(q_y[4], 0.5 * sign)
    data = ball.assign(tau_x=3.0 * ball["P"])
    one, two = loads_on(STEEL, data, 1), loads_on(STEEL, data, 2)
    assert (one.nu, two.nu) == (0.3, 0.206) and loads_on(BALL_ROLLS, data).nu == 0.3
    unit = STEEL.scales.a_over_R
    assert (one.q_x[64, 96] / unit, two.q_x[64, 96] / unit) == pytest.approx((-3.0, 3.0), rel=0.1)
    alone = loads_on(parse_case(MOES_FALLS), data)
    assert not alone.q_x.any() and alone.p.any()
    warm = loads_on(STEEL, data.assign(tau_x_warm=ball["P"]))  # with heat
    assert warm.q_x[64, 96] / unit == pytest.approx(-1.0, rel=0.1)


def test_a_section_and_all_nodes_agree(ball: xr.Dataset) -> None:
    depths = [0.0, 50e-6, "0.1 mm"]
    along_x, along_y, every = (stress(STEEL, ball, depths=depths, along=each) for each in ("x", "y", None))
    assert along_x["von_mises"].dims == ("z", "x") and along_y["von_mises"].dims == ("z", "y")
    assert every["von_mises"].dims == ("z", "y", "x")
    np.testing.assert_allclose(along_x["z"], [0.0, 50e-6, 100e-6])
    for name in along_x:
        assert along_x[name].attrs["units"] == "Pa" and along_x[name].attrs["long_name"]
        np.testing.assert_allclose(along_x[name], every[name][:, 64], atol=1.0)
        np.testing.assert_allclose(along_y[name], every[name].sel(x=0.0, method="nearest"), atol=1e-3)
    assert every.attrs["body"] == 1 and every.attrs["poisson_ratio"] == 0.3
    assert stress(parse_case(MOES_FALLS), dry_impact(MOES_FALLS))["von_mises"].attrs["in_units_of"] == "p_h*"


@pytest.mark.parametrize("radial", [False, True])
def test_a_run_in_time_has_them_at_its_moment(radial: bool) -> None:
    """The dry impact: at any time the stresses of Hertz, in units of its radius and pressure then."""
    data, case = dry_impact(BALL_FALLS, radial=radial), parse_case(BALL_FALLS)
    for frame in (20, 48):
        A = float(data["P_c"][frame])
        found = stress_numbers(case, data.isel(frame=frame))
        assert found["von_mises_max"] == pytest.approx(0.620 * A, rel=0.01)
        assert found["Z_von_mises"] == pytest.approx(0.481 * A, rel=0.05)
    section = stress(case, data, depths=[0.481 * A * case.scales.a])
    assert float(section["von_mises"].max()) == pytest.approx(0.620 * A * case.scales.p_h, rel=0.01)
    assert section.attrs["moment"].startswith("maximum approach")
    assert "between the maps" in stress(case, data, at=1.02, depths=[0.0]).attrs["moment"]
    assert stress_numbers(case, data.isel(frame=-1).assign(P=0.0 * data["P"][-1])) == {}


def test_what_is_not_there_is_refused(ball: xr.Dataset, line: ertel.Result) -> None:
    for given, message in REFUSALS["stresses"]:
        with pytest.raises(ValueError, match=message):
            stress(STEEL, ball, **given)
    with pytest.raises(ValueError, match=r"along = 'y': .*not of a line contact"):
        line.stress(along="y")
    data = dry_impact(MOES_FALLS)
    with pytest.raises(ValueError, match="carries no load"):
        stress(parse_case(MOES_FALLS), data.assign(P=0.0 * data["P"]))


def test_the_summary_compares_it_with_the_yield_stress(line: ertel.Result) -> None:
    """Hardened steel of 6.84 GPa yields at a third of it."""
    solved = solutions(STEEL)
    summary = with_case_warnings(STEEL, steady_summary(STEEL, solved, {}, Status.CONVERGED))
    p_h = STEEL.scales.p_h
    assert summary["si"]["von_mises_max_Pa"] == pytest.approx(0.62 * p_h, rel=0.01)
    assert summary["yield_ratio"] == pytest.approx(0.62 * p_h / (6.84e9 / 3), rel=0.01)
    (told,) = (each for each in numbers.lines(summary) if "von Mises" in each)
    assert "of the yield stress" in told and "µm deep at x = 0 m, y = 0 m; largest shear stress" in told
    table = numbers.scalars(summary)
    assert table["z_von_mises"].value == pytest.approx(0.48 * STEEL.scales.a, rel=0.02)
    assert table["shear_max"].unit == "Pa"
    other = replace(STEEL, contact=replace(STEEL.contact, E1=70e9))
    assert "yield_ratio" not in with_case_warnings(other, steady_summary(other, solved, {}, Status.CONVERGED))
    summary = steady_summary(STEEL, solutions(STEEL), {}, Status.INTERRUPTED)
    assert "von_mises_max" not in summary and not any("von Mises" in each for each in numbers.lines(summary))
    assert line.summary["von_mises_max"] == pytest.approx(0.558, rel=0.05)
    assert line.summary["Z_shear"] == pytest.approx(0.786, rel=0.1)
    assert "von Mises stress in body 1" in repr(line) and "y = " not in repr(line)


def test_the_picture_marks_the_largest_stress(ball: xr.Dataset, line: ertel.Result) -> None:
    section, profile, *_ = plots.stress(ball, body=2).axes
    (mark,) = section.get_lines()
    assert abs(mark.get_xdata()[0]) < 5.0 and mark.get_ydata()[0] == pytest.approx(0.48 * C1.a * 1e6, rel=0.1)
    assert "body 2" in section.get_ylabel() and section.get_ylim()[1] == 0.0
    mises, shear, *_ = profile.get_lines()
    assert mises.get_xdata().max() == pytest.approx(0.62 * C1.p_h * 1e-9, rel=0.01)
    assert shear.get_xdata().max() == pytest.approx(0.31 * C1.p_h * 1e-9, rel=0.01)
    moes = plots.stress(dry_impact(MOES_FALLS), at=2.0)
    assert "by the pressure alone" in moes.axes[0].get_title()
    with pytest.raises(NoFigure):
        plots.stress(ball, at=1.0)


def test_export_and_plot_on_the_command_line(line: ertel.Result, tmp_path: Path) -> None:
    export = ("export", str(line.directory), "--out", str(tmp_path))
    for to in ("csv", "netcdf"):
        ertel_(*export, "--what", "stress", "--to", to)
    heading, *rows = (tmp_path / "stress_x.csv").read_text().splitlines()
    assert heading.startswith("z_m,x_m,sigma_xx_Pa,") and heading.endswith(",von_mises_Pa,shear_Pa")
    assert len(rows) == 31 * 129
    with xr.open_dataset(tmp_path / "stress_x.nc", engine="scipy") as stored:
        np.testing.assert_allclose(stored["von_mises"], line.stress()["von_mises"])
    for wrong in (["--to", "vtk", "--what", "stress"], ["--body", "2"], ["--what", "stress", "--along", "y"]):
        ertel_(*export, *wrong, code=2)
    ertel_("plot", str(line.directory), "--what", "stress", "--out", str(tmp_path))
    assert (tmp_path / "stress.png").exists()
