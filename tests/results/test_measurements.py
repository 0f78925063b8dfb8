"""Profiles of runs, and measurements beside them: files, units, alignment, numbers."""

import os
import re
import tomllib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from cases import DATA, REFUSALS
from made_up import BALL_FALLS, BALL_ROLLS, C1, MOES_FALLS, dry_impact, in_time

import ertel
from ertel import Measurement
from ertel.case.status import Status
from ertel.inputs.case_files import parse_case
from ertel.optics import Interferometer, Monochromatic, Rig, reflection
from ertel.physics import hertz
from ertel.physics.motion import first_touch
from ertel.results.alignment import light_along, with_start
from ertel.results.dataset import to_csv
from ertel.results.numbers import scalars
from ertel.results.profiles import moment_of, profile, write_profile
from ertel.results.summary import impact_summary
from ertel.results.variables import to_si
from ertel.runs.result import Result
from ertel.runs.study_result import StudyResult

PROFILES = tomllib.loads((DATA / "measurements.toml").read_text(encoding="utf-8"))["profiles"]


def as_result(case_data) -> Result:
    """The dry impact of a ball of 10 mm, whose film is known in closed form."""
    case, data = parse_case(case_data), dry_impact(case_data, radial=True)
    then = data.drop_dims([name for name in data.dims if name != "time"]).sel(time=2.45, method="nearest")
    reached = {"T": 2.45, **{str(name): float(value) for name, value in then.data_vars.items()}}
    return Result(case, data, impact_summary(case, data, reached, {}, Status.CONVERGED), Status.CONVERGED)


@pytest.fixture(scope="module")
def ball() -> Result:
    return as_result(BALL_FALLS)


def read(folder: Path, text: str, encoding: str = "utf-8", **given) -> Measurement:
    (folder / "film.csv").write_bytes(text.encode(encoding))
    return Measurement.read(folder / "film.csv", **given)


def seen(line: xr.Dataset, x, moved=0.0, lifted=0.0, sigma=None, **given) -> Measurement:
    """A film of a run as it is measured at places x, in a frame that is moved."""
    return Measurement("profile", "h", np.interp(x - moved, line["x"], line["h"]) + lifted, x, sigma, **given)


def test_a_moment_by_number_by_quantity_and_by_event(ball):
    data, t0 = ball.dataset, ball.case.scales.t0
    T = 60e-6 / t0 + 1.0  # from the touch, and from the start
    for at in ("60 us", "6e-5 s", ertel.quantity("60 us"), T, str(T)):
        assert moment_of(data, at).T == pytest.approx(T, rel=1e-12)
    assert moment_of(data, "60 us").frame == np.abs(data["frame"].values - T).argmin()
    assert moment_of(data, "max-approach") == moment_of(data)
    for at in ("60 ms", "noon", 99.0, float("nan")):
        with pytest.raises(ValueError, match=r"at = .*0\.05 to 3\.9 t0 \(-35\.54 µs to 108\.5 µs\) .*max-approach"):
            moment_of(data, at)


def test_a_profile_on_the_plane_and_along_the_radius(ball):
    """Along x and along y, of an axisymmetric contact, at a map: the closed form."""
    plane, radial, s = dry_impact(BALL_FALLS), dry_impact(BALL_FALLS, radial=True), parse_case(BALL_FALLS).scales
    for data in (plane, radial):
        for along in "xy":
            line = profile(data, "max-approach", along)
            X, A = line[along].values / s.a, float(hertz.contact_radius(1.45))
            assert line["p"].values == pytest.approx(s.p_h * hertz.pressure(np.abs(X), A))
            assert line["h"].values == pytest.approx(s.film * (hertz.gap(np.abs(X), A) + 0.05))
            assert line["h"].attrs["units"] == "m" and float(line["t"]) == pytest.approx(1.45 * s.t0)
    data = ball.dataset
    first, second = (profile(data, float(data["frame"][n])) for n in (20, 21))
    between = profile(data, float(data["frame"][20] + 0.25 * (data["frame"][21] - data["frame"][20])))
    assert between["h"].values == pytest.approx(0.75 * first["h"].values + 0.25 * second["h"].values)
    assert "between the maps at" in between.attrs["moment"] and "between" not in first.attrs["moment"]


def test_t_is_zero_at_the_first_touch_however_the_run_starts(ball, tmp_path):
    """t counted from the start: "60 us" moved by as much as the ball fell before."""
    data = ball.dataset
    far = data.assign_coords({name: (name, data[name].values + 0.66, data[name].attrs) for name in ("time", "frame")})
    for at in ("20 us", "max-approach"):
        one, two = profile(data, at), profile(far, at)
        assert two["h"].values == pytest.approx(one["h"].values, rel=1e-12) and float(two["t"]) == float(one["t"])
    tables = (to_csv(to_si(data), tmp_path / name)[0] for name, data in (("near", data), ("far", far)))
    near, late = ([float(line.split(",")[0]) for line in each.read_text().splitlines()[1:]] for each in tables)
    assert near == pytest.approx(late) and near[0] == pytest.approx(-0.95 * ball.case.scales.t0)
    assert moment_of(far, 1.66).T == 1.66  # a plain number is T, from the start
    assert "$t$ = 54.24 µs" in ertel.plots.film(far).get_suptitle() == ertel.plots.film(ball.dataset).get_suptitle()


def test_the_summary_says_when_the_bodies_touch_and_counts_from_there(ball):
    s, si = ball.summary, ball.summary["si"]
    assert s["T_touch"] == pytest.approx(1.0) and s["T"] == 2.45
    t = 1.45 * ball.case.scales.t0
    assert si["t_s"] == pytest.approx(t) and scalars(s)["t"].value == pytest.approx(t)
    highest = si["extremes"]["P_max"]["t_s"], s["extremes"]["P_max"]["T"]
    assert highest[0] == pytest.approx((highest[1] - 1.0) * ball.case.scales.t0)
    assert f"at t = {1e6 * highest[0]:.4g} µs (T = {highest[1]:.4g})" in repr(ball)
    T = np.array([0.1, 0.5, 1.2])
    assert first_touch(T, np.array([-0.9, -0.6, -0.4]), -1.0) == first_touch([], [], -1.0) == 1.0
    assert first_touch(T, np.array([-0.9, -0.2, 0.5]), -1.0) == pytest.approx(0.7)
    data = in_time(BALL_ROLLS)
    assert to_si(data)["t"].values == pytest.approx(data["time"].values * C1.t0)  # rolling has no touch


def test_the_start_of_a_clock_is_found_from_all_of_its_frames(ball):
    """Two films by a clock that shows 23 us at the touch; of one alone the centre is not known either."""
    x, rng = np.linspace(-2.2e-4, 2.2e-4, 31), np.random.default_rng(1)
    frames = [
        seen(ball.profile(f"{t!r} s"), x, 0.0, rng.normal(0, 2e-9, 31), 2e-9, at=f"{t + 23e-6!r} s", align="start")
        for t in (5e-6, 20e-6)
    ]
    alone = replace(ball, dataset=dry_impact(BALL_FALLS, radial=True, rebound=False))  # a dry rebound has it once more
    moved = replace(frames[0], x=x + 4e-6, align=("start", "centre"))
    found = alone.compare(moved)
    assert found.shift["start"] == pytest.approx(23e-6, abs=0.2e-6) and found.rms < 3e-9
    assert "; start 2" in repr(found) and "; centre " in repr(found) and found.measurement is moved
    starts = {each.start for each in with_start(frames, ball)}
    assert len(starts) == 1 and starts.pop() == pytest.approx(23e-6, abs=0.1e-6)
    assert ball.plot.profiles(measured=frames[0])
    for at, message in (("max-approach", "start: measurement, at = 'max-approach', needs"), (None, "at = None, needs")):
        with pytest.raises(ValueError, match=message):
            replace(frames[0], at=at)
    with pytest.raises(ValueError, match="measurement: reaches from"):
        with_start([frames[0], replace(frames[1], at="1 ms")], ball)


def test_a_centre_that_is_far_off_is_doubted(ball):
    """A profile of another oil was moved by most of the contact, without a word."""
    x = np.linspace(-2.2e-4, 2.2e-4, 45)
    line, far = ball.profile(), 1.2e-4
    moved = seen(line, x, far, align="centre", name="film.csv")
    found = ball.compare(moved)
    assert found.shift["centre"] == pytest.approx(far, rel=0.02)
    (warning,) = found.warnings
    assert warning.startswith("film.csv: the centre 120") and "half of the contact's half width" in warning
    assert f"warning: {warning}" in repr(found)
    near = seen(line, x, 5e-6, align="centre")
    assert ball.compare(near).warnings == []
    from_a_corner = replace(near, x=x + 4e-4)  # of a camera
    assert ball.compare(from_a_corner).shift["centre"] == pytest.approx(4.05e-4, rel=0.01)
    assert ball.compare(from_a_corner).warnings == []


@pytest.mark.parametrize(("text", "given"), PROFILES)
def test_columns_and_units(tmp_path, text, given):
    film = read(tmp_path, text, "latin-1", **given)
    assert (film.kind, film.quantity) == ("profile", "h")
    assert film.x == pytest.approx([-1e-4, 0.0, 2e-4], rel=1e-14)
    assert film.values == pytest.approx([3.1e-7, 1e-7, 4e-7], rel=1e-14)


def test_codings_of_texts_and_a_history_with_its_standard_errors(tmp_path):
    for coding in ("utf-8-sig", "utf-16", "utf-16-le", "utf-16-be"):
        assert read(tmp_path, "x (µm)\th (nm)\r\n-100\t310\r\n", coding).x == pytest.approx([-1e-4])
    history = read(tmp_path, "t_us,h_c,sigma\n10,900,5\n20,700,4\n", h_c="nm")
    assert (history.kind, history.quantity) == ("history", "h_c")
    assert history.x == pytest.approx([1e-5, 2e-5]) and history.sigma == pytest.approx([5e-9, 4e-9])


@pytest.mark.parametrize(("text", "given", "message"), REFUSALS["measured_files"], ids=str)
def test_files_that_say_too_little_or_may_be_read_in_two_ways(tmp_path, text, given, message):
    with pytest.raises(ValueError, match=re.escape(message)):
        read(tmp_path, text, **given)


def test_what_is_no_file_of_columns(tmp_path):
    with pytest.raises(ValueError, match=re.escape(f"nothing.csv: not a file in {tmp_path}")):
        Measurement.read(tmp_path / "nothing.csv")
    with pytest.raises(ValueError, match="line 2: field larger than field limit"):
        read(tmp_path, f"x_um,h_nm\n1,{'1' * 140_000}\n")
    os.mkfifo(tmp_path / "pipe.csv")
    with pytest.raises(ValueError, match="is not a regular file"):
        Measurement.read(tmp_path / "pipe.csv")


def speeds(**more) -> StudyResult:
    """Films that go as a power of the speed."""
    u = np.array([4.0, 1.0, 2.0])
    about = {"units": "m", "long_name": "central film thickness", "symbol": "h_c"}
    table = {"h_c": ("mean_speed", 3e-7 * u**0.7, about), "status": ("mean_speed", ["converged"] * 3)}
    return StudyResult(xr.Dataset(table, {"mean_speed": u, **more}, {"title": "speeds"}))


def test_a_curve_over_the_speed_is_compared_with_a_study(tmp_path):
    """Between the speeds of the study the film is a power; the zero and the scale of the rig are found."""
    u = np.geomspace(1.0, 4.0, 7)
    rows = "".join(f"{1e3 * speed} {1e9 * (1.05 * 3e-7 * speed**0.7 - 2e-8)}\n" for speed in u)
    given = {"mean_speed": "Speed", "h": "film", "align": ["offset", "factor"]}
    curve = read(tmp_path, "Speed (mm/s) film (nm)\n" + rows, **given)
    found = speeds().compare(curve)
    assert found.rms < 1e-12 and found.shift == pytest.approx({"factor": 1.05, "offset": -2e-8}, rel=1e-6)
    assert "factor 1.05; offset -20 nm" in repr(found)
    figure = ertel.plots.measured(speeds().dataset, found)
    assert [axes.get_xlabel() for axes in figure.axes] == ["mean speed (m/s)"] * 2
    for study, message in (
        (speeds(eta0=[0.1, 0.2]), "is one curve, and in the study eta0 varies, too"),
        (replace(speeds(), dataset=speeds().dataset.rename(mean_speed="load")), "is a curve over mean_speed; compare"),
    ):
        with pytest.raises(ValueError, match=message):
            study.compare(curve)
    with pytest.raises(ValueError, match=r"align = 'tilt': allowed: offset, factor, index"):
        replace(curve, align="tilt")
    with pytest.raises(TypeError, match="must be a Measurement of the kind curve"):
        speeds().compare(Measurement("number", "h_c", [1e-7]))


def test_the_exported_profile_of_a_run_is_the_run(ball, tmp_path):
    path, _ = write_profile(ball.dataset, tmp_path, "60 us")
    found = ball.compare(Measurement.read(path, at="60 us"))
    assert found.rms < 1e-20 and len(found.x) == 81
    assert ball.compare(Measurement.read(path, p="Pa", at="60 us")).rms < 1e-3  # Pa, of 1 GPa
    # At the nodes of the grid, by Fresnel's coefficients, with the index of the oil under pressure.
    line, light = ball.profile(), light_along(ball.profile(), ball.case, RIG)
    inner = np.abs(line["x"].values) < 1.5e-4
    h, p = line["h"].values[inner], line["p"].values[inner]
    n = RIG.rig.index(np.asarray(ball.case.lubricant.density(p / ball.case.scales.p_h)))
    layer, wavelength = RIG.rig.coatings[0], 633e-9
    media = [RIG.rig.glass.index(wavelength), layer.medium.index(wavelength), n, RIG.rig.surface.index(wavelength)]
    seen = np.abs(reflection(media, [layer.thickness, h], wavelength)) ** 2
    assert np.interp(line["x"].values[inner], light["x"], light) == pytest.approx(seen, abs=2e-3)


def test_what_is_not_known_of_a_profile_is_found(ball):
    """A profile that is moved, lifted and tilted, with noise: all three within three standard errors."""
    line, sigma = ball.profile(), 2e-9
    x, known = np.linspace(-2e-4, 2e-4, 41), np.array([3e-6, 40e-9, 1e-4])
    lifted = known[1] + known[2] * x + np.random.default_rng(0).normal(0.0, sigma, 41)
    measured = seen(line, x, known[0], lifted, sigma, align=("centre", "offset", "tilt"))
    found = ball.compare(measured)
    shift = [found.shift[name] for name in ("centre", "offset", "tilt")]
    slope = np.gradient(np.interp(x - known[0], line["x"], line["h"]), x)
    shapes, scale = np.array([-slope, np.ones(41), x / 1e-4]), np.array([1.0, 1.0, 1e-4])
    errors = sigma * np.sqrt(np.diag(np.linalg.inv(shapes @ shapes.T))) / scale
    assert np.all(np.abs(shift - known) < 3 * errors) and np.all(errors < 0.2 * known)
    assert 1.5e-9 < found.rms < 2.1e-9 and "rms difference" in repr(found)
    assert measured.predicted(ball) == pytest.approx(measured.values - found.difference, abs=1e-20)
    assert ball.compare(replace(measured, align=())).rms > 1e-8


def test_a_film_that_was_computed_with_a_wrong_index(ball):
    """An interferometer gives n h: with 1.50 in place of 1.45 the film is too thin, by this factor."""
    line, x = ball.profile(), np.linspace(-2e-4, 2e-4, 41)
    h = np.interp(x, line["x"], line["h"])
    noise = np.random.default_rng(0).normal(0.0, 1e-9, 41)
    given = {"align": "index", "index": 1.5}
    found = ball.compare(Measurement("profile", "h", h * 1.45 / 1.5 + noise, x, 1e-9, **given))
    error = 1.45 * 1e-9 / np.sqrt(np.sum(h**2))
    assert abs(found.shift["index"] - 1.45) < 3 * error < 0.01
    assert found.measured == pytest.approx(h + noise * 1.5 / 1.45, rel=0.01) and "; index 1.449" in repr(found)
    assert found.shown == pytest.approx(h * 1.45 / 1.5, rel=0.01)


RIG = Interferometer(Rig(oil_index=1.45), Monochromatic(633e-9))


def intensity(ball, x, noise=0.0, **given) -> Measurement:
    """What a camera sees at places x: 200 counts and 50 of them without light."""
    line = light_along(ball.profile(), ball.case, RIG)
    share = np.interp(x, line["x"], line)
    counts = 50.0 + 200.0 * (share + noise * np.random.default_rng(1).standard_normal(len(x)))
    return Measurement("profile", "intensity", counts, x, 200.0 * (noise or 1.0), optics=RIG, **given)


def test_gain_and_background_of_an_intensity_are_found(ball):
    x = np.linspace(-2.5e-4, 2.5e-4, 201)
    found = ball.compare(intensity(ball, x, 0.01, align="centre"))
    exact = ball.compare(intensity(ball, x))
    assert exact.shift == pytest.approx({"gain": 200.0, "background": 50.0}) and exact.rms < 1e-9
    lifted = ball.compare(intensity(ball, x, align=["tilt"]))
    assert lifted.shift["tilt"] == pytest.approx(0.0, abs=1e-6)
    assert found.shift["gain"] == pytest.approx(200.0, rel=0.02) and abs(found.shift["centre"]) < 0.5e-6
    assert 1.6 < found.rms < 2.4 and "intensity" in repr(found)
    with pytest.raises(ValueError, match="measurement: is an intensity; give optics="):
        ball.compare(replace(intensity(ball, x), optics=None))
    # Dark in place of bright is another film, and no negative gain.
    x = np.linspace(-1.2e-4, 1.2e-4, 121)
    seen = intensity(ball, x)
    found = ball.compare(replace(seen, values=300.0 - seen.values))
    assert found.shift["gain"] > 0 and found.measurement.predicted(ball).std() < 0.01 * seen.values.std()


@pytest.mark.slow
def test_the_index_of_the_oil_is_found_in_an_intensity(ball):
    """With that of the rig off by 2 %."""
    x = np.linspace(-2.5e-4, 2.5e-4, 201)
    seen = replace(intensity(ball, x, 0.01), optics=replace(RIG, rig=replace(RIG.rig, oil_index=1.48)))
    found, wrong = ball.compare(replace(seen, align=("index", "centre"))), ball.compare(seen)
    assert found.shift["index"] == pytest.approx(1.45, abs=0.002) and "; index 1.4" in repr(found)
    assert found.rms < 2.4 < wrong.rms and abs(found.shift["centre"]) < 0.5e-6


def test_a_history_and_numbers(ball):
    t = np.array([-18e-6, 22e-6])
    h_c = np.interp(t, ball.si["t"], ball.si["h_c"])
    assert Measurement("history", "h_c", h_c, t).predicted(ball) == pytest.approx(h_c, rel=1e-14)
    late = Measurement("history", "h_c", h_c, t + 20e-6, align="centre")
    assert ball.compare(late).shift["centre"] == pytest.approx(20e-6, abs=1e-9)
    known, aligned = replace(late, align=(), start="20 us"), ball.compare(replace(late, align="start"))
    assert known.predicted(ball) == pytest.approx(h_c, rel=1e-9) and "; start 20 µs" in repr(aligned)
    for name, value in (("h_c", ball.summary["si"]["h_c_m"]), ("p_max", ball.summary["si"]["p_max_Pa"])):
        assert Measurement.number(name, value).predicted(ball) == pytest.approx([value])
        assert repr(ball.compare(Measurement.number(name, value))).endswith(", 1 value")
    # The run starts at -37.41 us, and its first step is 1.87 us later.
    h_c = ball.si["h_c"].values[0]
    assert Measurement("history", "h_c", [h_c, h_c], [-37.4e-6, -36e-6]).predicted(ball) == pytest.approx([h_c, h_c])
    with pytest.raises(ValueError, match="reaches from -38 µs"):
        Measurement("history", "h_c", [h_c, h_c], [-38e-6, 1e-6]).predicted(ball)
    for quantity in (str, ertel.quantity):
        given = Measurement.number("contact_time", quantity("95 us"), quantity("1 us"))
        assert given.values == pytest.approx([95e-6]) and given.sigma == pytest.approx(1e-6)
    with pytest.raises(ValueError, match="contact_time = -95 µs: must not be below zero"):
        Measurement.number("contact_time", "-95 us")
    assert film(at=ertel.quantity("60 us")).predicted(ball) == pytest.approx(film(at="60 us").predicted(ball))


def film(quantity="h", x=(0.0, 1e-4), at=None) -> Measurement:
    return Measurement("profile", quantity, [1e-7, 2e-7], x, at=at)


def test_what_a_run_does_not_have(ball):
    for measured, message in (
        (film(x=[0.0, 1e-2]), "reaches from 0 m to 10 mm, and the run only from -386.8 µm"),
        (film(at="1 s"), "at = '1 s': must be a time"),
        (Measurement.number("restitution", 0.9), "restitution: the run has no such number; it has M, "),
    ):
        with pytest.raises(ValueError, match=message):
            measured.predicted(ball)


def test_a_dimensionless_run_has_no_seconds_and_no_measurements():
    moes = as_result(MOES_FALLS)
    with pytest.raises(ValueError, match="at = '60 us': the case is dimensionless"):
        profile(moes.dataset, "60 us")
    history = Measurement("history", "h_c", [1e-7, 2e-7], [0.0, 1e-4])
    for measured in (film(), history, Measurement.number("h_c", "100 nm")):
        with pytest.raises(ValueError, match="dimensionless"):
            measured.predicted(moes)
