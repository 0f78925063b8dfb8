"""The picture of a measurement over a run."""

import numpy as np
import pytest
from drawn import line, panels, words
from made_up import BALL_FALLS, dry_impact

from ertel import Measurement, plots
from ertel.case.case import Case
from ertel.case.status import Status
from ertel.inputs.case_files import parse_case
from ertel.plots import NoFigure
from ertel.runs.result import Result


@pytest.fixture(scope="module")
def ball() -> Result:
    case: Case = parse_case(BALL_FALLS)
    return Result(case, dry_impact(BALL_FALLS, radial=True), {"warnings": []}, Status.CONVERGED)


def test_a_profile_over_that_of_the_run_with_the_rms_difference_in_the_title(ball):
    x, there = np.linspace(-1e-4, 1e-4, 21), ball.profile("60 us")
    h = np.interp(x, there["x"], there["h"]) + np.where(np.arange(21) % 2, 3e-9, -3e-9)
    found = ball.compare(Measurement("profile", "h", h, x, at="60 us", name="film.csv"))
    figure = ball.plot.measured(found)
    above, below = panels(figure)
    computed = line(above, "computed")
    assert computed.get_xdata() == pytest.approx(there["x"].values * 1e6)
    assert below.get_lines()[0].get_ydata() == pytest.approx(found.difference * 1e9)
    assert words(above) == ["computed", "measured, film.csv"]
    assert above.get_ylabel() == "film thickness $h$ (nm)" and below.get_xlabel() == "$x$ (µm)"
    assert "60 µs, between the maps" in figure.get_suptitle() and "rms difference 3 nm" in figure.get_suptitle()
    figure.draw_without_rendering()


def test_measured_film_and_pressure_on_the_profiles_of_the_run(ball):
    """Aligned, in the units of the picture; at the moment of the measurement, or of the picture."""
    there = ball.profile("60 us")
    x, h = there["x"].values[10:-10], there["h"].values[10:-10]
    film = Measurement(
        "profile", "h", h + 1e-7, x + 5e-6, 1e-8, at="60 us", align=("centre", "offset"), name="film.csv"
    )
    pressure = Measurement("profile", "p", there["p"].values[10:-10], x, name="sensor.csv")
    above, below = panels(ball.plot.profiles(measured=[film, pressure]))[:2]
    points = next(each for each in above.containers if each.get_label() == "measured, film.csv").lines[0]
    assert points.get_xdata() == pytest.approx(x * 1e6, abs=0.1) and points.get_ydata() == pytest.approx(
        h * 1e9, rel=0.02
    )
    points = next(each for each in below.containers if each.get_label() == "measured, sensor.csv").lines[0]
    assert points.get_ydata() == pytest.approx(there["p"].values[10:-10] * 1e-9)
    assert "59.85 µs" in ball.plot.profiles(measured=film).get_suptitle()
    late = ball.plot.profiles(at="90 us", measured=pressure)
    assert "89.78 µs" in late.get_suptitle()


@pytest.mark.parametrize(
    ("picture", "quantity", "given", "message"),
    [
        ("film", "h", {}, "film: does not show what is measured; profiles and midlines do"),
        ("profiles", "intensity", {}, "measurement is a profile of intensity; this picture shows profiles of h and p"),
        ("interferogram", "p", {}, "measurement is a profile of p; this picture shows profiles of h and intensity"),
        ("profiles", "h", {"kind": "history"}, "measurement is a history of h"),
        ("profiles", "h", {"along": "y"}, "measured: measurement is along y; profiles are along x"),
    ],
)
def test_a_measurement_that_a_picture_does_not_show(picture, quantity, given, message):
    plane = dry_impact(BALL_FALLS).isel(frame=slice(0, 50, 16))
    measured = Measurement(
        **{"kind": "profile", "quantity": quantity, "values": [1.0, 2.0, 3.0], **given, "x": [0, 1e-5, 2e-5]}
    )
    with pytest.raises(NoFigure) as error:
        getattr(plots, picture)(plane, measured=measured)
    assert message in str(error.value)
