"""Profiles of runs, and measurements beside them: files, units, alignment, numbers."""

from dataclasses import replace

import numpy as np
import pytest
from made_up import BALL_FALLS, MOES_FALLS, dry_impact

import ertel
from ertel import Measurement
from ertel.case.status import Status
from ertel.inputs.case_files import parse_case
from ertel.physics import hertz
from ertel.results.profiles import moment_of, profile, write_profile
from ertel.results.result import Result
from ertel.results.summary import impact_summary


def as_result(case_data) -> Result:
    """The dry impact of a ball of 10 mm, whose film is known in closed form."""
    case, data = parse_case(case_data), dry_impact(case_data, radial=True)
    then = data.drop_dims([name for name in data.dims if name != "time"]).sel(time=2.45, method="nearest")
    reached = {"T": 2.45, **{str(name): float(value) for name, value in then.data_vars.items()}}
    return Result(case, data, impact_summary(case, data, reached, {}, Status.CONVERGED), Status.CONVERGED)


@pytest.fixture(scope="module")
def ball() -> Result:
    return as_result(BALL_FALLS)


@pytest.fixture
def written(tmp_path):
    def write(text: str, encoding: str = "utf-8"):
        path = tmp_path / "film.csv"
        path.write_bytes(text.encode(encoding))
        return path

    return write


# -- moments and profiles ---------------------------------------------------------------------------------------------


def test_a_moment_by_number_by_quantity_and_by_event(ball):
    data, t0 = ball.dataset, ball.case.scales.t0
    T = 60e-6 / t0
    for at in ("60 us", "6e-5 s", ertel.quantity("60 us"), T, str(T)):
        assert moment_of(data, at).T == pytest.approx(T, rel=1e-12)
    assert moment_of(data, "60 us").frame == np.abs(data["frame"].values - T).argmin()
    assert moment_of(data, "max-approach") == moment_of(data)
    map_at = data["frame"].values[moment_of(data, T).frame] * t0 * 1e6
    assert f"$t$ = {map_at:.4g} µs" in ertel.plots.film(data, "60 us").get_suptitle()


@pytest.mark.parametrize("at", ["60 ms", "noon", 99.0, float("nan")])
def test_a_moment_that_a_run_does_not_have(ball, at):
    with pytest.raises(ValueError, match=r"at = .*0\.05 to 3\.9 t0 \(1\.87 µs to 145\.9 µs\) .*max-approach"):
        moment_of(ball.dataset, at)


def test_a_profile_on_the_plane_and_along_the_radius():
    """Along x and along y, of an axisymmetric contact, at a map: the closed form."""
    plane, radial, s = dry_impact(BALL_FALLS), dry_impact(BALL_FALLS, radial=True), parse_case(BALL_FALLS).scales
    for data in (plane, radial):
        for along in "xy":
            line = profile(data, "max-approach", along)
            X, A = line[along].values / s.a, float(hertz.contact_radius(1.45))
            assert line["p"].values == pytest.approx(s.p_h * hertz.pressure(np.abs(X), A))
            assert line["h"].values == pytest.approx(s.film * (hertz.gap(np.abs(X), A) + 0.05))
            assert line["h"].attrs["units"] == "m" and float(line["t"]) == pytest.approx(2.45 * s.t0)


def test_between_maps_a_profile_is_interpolated_and_says_so(ball):
    data = ball.dataset
    first, second = (profile(data, float(data["frame"][n])) for n in (20, 21))
    between = profile(data, float(data["frame"][20] + 0.25 * (data["frame"][21] - data["frame"][20])))
    assert between["h"].values == pytest.approx(0.75 * first["h"].values + 0.25 * second["h"].values)
    assert "between the maps at" in between.attrs["moment"] and "between" not in first.attrs["moment"]


# -- files ------------------------------------------------------------------------------------------------------------

PLACES, FILMS = np.array([-1e-4, 0.0, 2e-4]), np.array([3.1e-7, 1e-7, 4e-7])


@pytest.mark.parametrize(
    ("text", "given"),
    [
        ("x_um,h_nm\n-100,310\n200,400\n0,100\n", {}),
        ("# rig 2\nx (µm);h [nm]\n-100,0;310,0\n0;100\n50;\n200;400\n", {}),
        ("x/mm\th/um\n-0.1\t0.31\n0\t0.1\n0.2\t0.4\n", {}),
        ("-100 310\n0 100\n200 400\n", {"x": "um", "h": "nm"}),
        ("Place (um),Film\n-100,310\n0,100\n200,400\n", {"h": "nm", "columns": {"x": "Place (um)", "h": "Film"}}),
        ("x_um,p_GPa,h_nm,t_us\n-100,1,310,60\n0,1,100,60\n200,1,400,60\n", {}),
    ],
)
def test_columns_and_units(written, text, given):
    read = Measurement.read(written(text, "latin-1"), **given)
    assert (read.kind, read.quantity) == ("profile", "h")
    assert read.x == pytest.approx(PLACES, rel=1e-14) and read.values == pytest.approx(FILMS, rel=1e-14)


def test_a_history_with_its_standard_errors(written):
    read = Measurement.read(written("t_us,h_c,sigma\n10,900,5\n20,700,4\n"), h_c="nm")
    assert (read.kind, read.quantity) == ("history", "h_c")
    assert read.x == pytest.approx([1e-5, 2e-5]) and read.sigma == pytest.approx([5e-9, 4e-9])


@pytest.mark.parametrize(
    ("text", "given", "message"),
    [
        ("Place,Film\n1,2\n", {}, "film.csv: has no place x, y or r and no time t; it has 'Place', 'Film'"),
        ("x_um,Film\n1,2\n", {}, "film.csv: has no quantity such as h; it has 'x_um', 'Film'"),
        ("x,h_nm\n1,2\n3,4\n", {}, "column 'x' has no unit; write x_m in the header"),
        ("x_um,h_kg\n1,2\n3,4\n", {}, "column 'h' in 'kg': has the wrong dimension"),
        ("x_um,h_nm\n1,2\n3,none\n", {}, "column 'h' has 'none' in row 2"),
        ("x_um,h_nm,h_mm\n1,2,3\n", {}, "say which one is h"),
        ("x_um,h_nm\n1,2\n3,4,5\n", {}, "line 3 has 3 columns and the first has 2"),
        ("1,2\n3,4\n", {}, "has 2 columns without a header"),
        ("x_um,h_nm\n1,2\n", {"columns": {"h": "film"}}, "has no column 'film'; it has 'x_um', 'h_nm'"),
        ("x_um,h_nm\n1,2\n", {"film": "nm"}, "film: must be the name of a place, a time or a result"),
        ("x_um,h_nm\n1,2\n2,3\n", {"align": ["zoom"]}, "align = 'zoom': must be of centre, offset, tilt"),
        ("x_um,T\n1,2\n", {}, "has no quantity such as h; it has 'x_um', 'T'; give columns={\"h\": ...}"),
        ("x_um,h_nm\n1,nan\n", {}, "film.csv: has 0 values; must be at least one row without a gap"),
        ("x_um,h_nm,sigma\n1,2,0\n", {}, "film.csv: sigma has 0 (in SI); must be finite and above zero"),
        ("t_us,h_c_nm\n1,2\n", {"at": "1 us"}, "at = '1 us': film.csv is a history, without a moment"),
        ("x_um,h_nm\n1,2\n", {"along": "z"}, "along = 'z': must be of x, y"),
        ("x_um,h_nm\n1,2\n2,3\n", {"sigma": "2 s"}, "h = '2 s': has the wrong dimension"),
    ],
)
def test_files_that_say_too_little(written, text, given, message):
    with pytest.raises(ValueError) as error:
        Measurement.read(written(text), **given)
    assert message in str(error.value)


# -- beside a run -----------------------------------------------------------------------------------------------------


def test_the_exported_profile_of_a_run_is_the_run(ball, tmp_path):
    path, _ = write_profile(ball.dataset, tmp_path, "60 us")
    found = ball.compare(Measurement.read(path, at="60 us"))
    assert found.rms < 1e-20 and len(found.x) == 81
    assert ball.compare(Measurement.read(path, p="Pa", at="60 us")).rms < 1e-3  # Pa, of 1 GPa


def test_what_is_not_known_of_a_profile_is_found(ball):
    """A profile that is moved, lifted and tilted, with noise: all three within three standard errors."""
    line, sigma = ball.profile(), 2e-9
    x, known = np.linspace(-2e-4, 2e-4, 41), np.array([3e-6, 40e-9, 1e-4])
    h = np.interp(x - known[0], line["x"], line["h"]) + known[1] + known[2] * x
    h += np.random.default_rng(0).normal(0.0, sigma, 41)
    measured = Measurement("profile", "h", h, x, sigma, align=("centre", "offset", "tilt"))
    found = ball.compare(measured)
    shift = [found.shift[name] for name in ("centre", "offset", "tilt")]
    slope = np.gradient(np.interp(x - known[0], line["x"], line["h"]), x)
    shapes, scale = np.array([-slope, np.ones(41), x / 1e-4]), np.array([1.0, 1.0, 1e-4])
    errors = sigma * np.sqrt(np.diag(np.linalg.inv(shapes @ shapes.T))) / scale
    assert np.all(np.abs(shift - known) < 3 * errors) and np.all(errors < 0.2 * known)
    assert 1.5e-9 < found.rms < 2.1e-9 and "rms difference" in repr(found)
    assert measured.predicted(ball) == pytest.approx(h - found.difference, abs=1e-20)
    assert ball.compare(replace(measured, align=())).rms > 1e-8


def test_a_history_and_numbers(ball):
    t = np.array([20e-6, 61e-6])
    h_c = np.interp(t, ball.si["t"], ball.si["h_c"])
    assert Measurement("history", "h_c", h_c, t).predicted(ball) == pytest.approx(h_c, rel=1e-14)
    late = Measurement("history", "h_c", h_c, t + 20e-6, align="centre")
    assert ball.compare(late).shift["centre"] == pytest.approx(20e-6, abs=1e-9)
    for name, value in (("h_c", ball.summary["si"]["h_c_m"]), ("p_max", ball.summary["si"]["p_max_Pa"])):
        assert Measurement.number(name, value).predicted(ball) == pytest.approx([value])
    assert Measurement.number("contact_time", "95 us", "1 us").values == pytest.approx([95e-6])


@pytest.fixture(scope="module")
def moes() -> Result:
    return as_result(MOES_FALLS)


def film(quantity="h", x=(0.0, 1e-4), at=None) -> Measurement:
    return Measurement("profile", quantity, [1e-7, 2e-7], x, at=at)


@pytest.mark.parametrize(
    ("measured", "message"),
    [
        (film(x=[0.0, 1e-2]), "reaches from 0 m to 10 mm, and the run only from -386.8 µm"),
        (film(quantity="h_c"), "h_c: the run has no such profile; it has h, p, h_oil"),
        (film(at="1 s"), "at = '1 s': must be a time"),
        (Measurement.number("restitution", 0.9), "restitution: the run has no such number; it has M, "),
    ],
)
def test_what_a_run_does_not_have(ball, measured, message):
    with pytest.raises(ValueError) as error:
        measured.predicted(ball)
    assert message in str(error.value)


def test_a_dimensionless_run_has_no_seconds_and_no_measurements(moes):
    with pytest.raises(ValueError, match="at = '60 us': the case is dimensionless"):
        profile(moes.dataset, "60 us")
    history = Measurement("history", "h_c", [1e-7, 2e-7], [0.0, 1e-4])
    for measured in (film(), history, Measurement.number("h_c", "100 nm")):
        with pytest.raises(ValueError, match="dimensionless"):
            measured.predicted(moes)
