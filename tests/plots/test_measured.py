"""The picture of a measurement over a run."""

import numpy as np
import pytest
from drawn import line, panels, words
from made_up import BALL_FALLS, dry_impact
from matplotlib.figure import Figure

from ertel import Measurement
from ertel.case.case import Case
from ertel.case.status import Status
from ertel.inputs.case_files import parse_case
from ertel.plots import NoFigure
from ertel.results.result import Result


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


def test_a_history_with_error_bars_and_a_number_that_has_no_picture(ball):
    t = np.array([20e-6, 60e-6, 100e-6])
    measured = Measurement("history", "h_c", np.interp(t, ball.si["t"], ball.si["h_c"]), t, sigma=5e-9)
    figure = ball.plot.measured(ball.compare(measured), columns=1, title=False)
    assert len(panels(figure)[0].collections) == 1 and "$t$ (µs)" in panels(figure)[1].get_xlabel()
    assert figure.get_figwidth() * 25.4 == pytest.approx(85.0) and not figure.get_suptitle()
    own = Figure().subplots(1, 2)
    assert ball.plot.measured(ball.compare(measured), ax=own) is own[0].figure and own[1].has_data()
    with pytest.raises(NoFigure, match="is one number"):
        ball.plot.measured(type(ball.compare(measured))(Measurement.number("restitution", 0.9), t, t, t))
