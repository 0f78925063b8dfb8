"""Pictures of runs in time: the axes carry the numbers of the run at the chosen moment, in the units that they say."""

from dataclasses import replace

import numpy as np
import pytest
from cases import python
from drawn import line, panels, words
from made_up import (
    BALL_FALLS,
    BALL_ROLLS,
    C1,
    MOES_FALLS,
    MOES_ROLLS,
    as_in_time,
    dry_impact,
    in_time,
    steady,
    with_temperature,
)
from matplotlib.colors import to_rgba

from ertel import plots
from ertel.case.sections import Drive
from ertel.inputs.case_files import parse_case
from ertel.physics.motion import Oscillation
from ertel.physics.surfaces import Feature, RingWaviness, Spot, Waviness, height
from ertel.plots.view import View
from ertel.results.figures import FIGURES_IN_TIME, FIGURES_STEADY, figures_of

ROUGH = (Feature(Waviness(0.01, 0.5, phase_x=0.3), 1), Feature(Spot(0.3, -0.05, x=-1.0), 2))
SCALES = parse_case(BALL_FALLS).scales
assert SCALES is not None and C1 is not None


@pytest.fixture(scope="module")
def ball():
    return dry_impact(BALL_FALLS)


@pytest.fixture(scope="module")
def moes():
    return dry_impact(MOES_FALLS)


@pytest.fixture(scope="module")
def runs(ball):
    return {"ball": ball, "moes rolls": in_time(MOES_ROLLS), "steady ball": with_temperature(steady(BALL_ROLLS))}


def frame_of_maximum(data):
    return int(np.flatnonzero(data["event"].values)[0])


# -- labels and headings ----------------------------------------------------------------------------------------------


MOMENTS = {"ball": "maximum approach", "moes rolls": "last map"}


@pytest.mark.parametrize(
    ("name", "run"),
    [*((name, run) for name in FIGURES_IN_TIME for run in MOMENTS if name != "front" or "rolls" not in run),
     *((name, "steady ball") for name in FIGURES_STEADY)],
)  # fmt: skip
def test_every_panel_says_what_it_shows(runs, name, run):
    if name not in figures_of(runs[run]):
        assert name == "asperities"  # nothing touches in these runs: `solvers/test_touch.py` has such a picture
        return
    figure = getattr(plots, name)(runs[run])
    figure.set_layout_engine("none")  # where texts lie takes the most time; `test_sheets` looks at it
    figure.draw_without_rendering()
    assert panels(figure)
    for axes in panels(figure):
        assert axes.get_xlabel() and axes.get_ylabel()
        assert axes.get_title() or (axes.get_legend() and run in MOMENTS)
    assert run not in MOMENTS or f"{MOMENTS[run]} at" in figure.get_suptitle()
    if "rolls" in run:
        legends = " ".join(word for axes in panels(figure) for word in words(axes))
        assert "dry" not in legends and "rebound" not in legends


# -- moments ----------------------------------------------------------------------------------------------------------


def test_a_time_chooses_the_map_next_to_it_and_an_event_its_own(moes):
    figure = plots.profiles(moes, at=1.62)
    frame = int(np.abs(moes["frame"].values - 1.62).argmin())
    shown = line(panels(figure)[1], "chosen map")
    np.testing.assert_array_equal(shown.get_ydata(), moes["P"].values[frame, 40])
    assert "chosen map at $T$ = 1.6 $t_0$" in figure.get_suptitle()
    assert "maximum approach at $T$ = 2.45" in plots.maps(moes, at="max-approach").get_suptitle()
    assert "end of the run at $T$ = 4 $t_0$" in plots.maps(in_time(MOES_ROLLS), at="end").get_suptitle()
    data = moes.isel(frame=slice(0, 30))  # without a maximum
    shown = line(panels(plots.profiles(data))[1], "last map")
    np.testing.assert_array_equal(shown.get_ydata(), data["P"].values[-1, 40])


# -- profiles and maps ------------------------------------------------------------------------------------------------


def test_profile_at_maximum_approach(ball):
    film, pressure = panels(plots.profiles(ball))
    frame, shown = frame_of_maximum(ball), line(film, "maximum approach")
    np.testing.assert_allclose(shown.get_xdata(), ball["X"].values * SCALES.a * 1e6)
    np.testing.assert_allclose(shown.get_ydata(), ball["H"].values[frame, 40] * SCALES.film * 1e9)  # thin: in nm
    assert film.get_ylabel() == "film thickness $h$ (nm)"
    assert to_rgba(shown.get_color()) == to_rgba("black")
    P = line(pressure, "maximum approach").get_ydata()
    np.testing.assert_allclose(P, ball["P"].values[frame, 40] * SCALES.p_h * 1e-9)


# -- roughness --------------------------------------------------------------------------------------------------------


def test_roughness_is_where_the_case_has_it():
    rough = (*ROUGH, Feature(RingWaviness(0.02, 0.4, y=0.2), 1))
    drive = Drive(entrainment=Oscillation(1.0, 0.3, 2.0), slide_to_roll=0.5)
    case = replace(as_in_time(MOES_ROLLS), roughness=rough, drive=drive)
    X, Y, data = np.linspace(-2, 2, 41)[None, :], np.linspace(-1, 1, 21)[:, None], in_time(case)
    for at in (0.0, 1.3):
        view = View.of(data, at)
        np.testing.assert_array_equal(view.roughness(X, Y), height(case.features, case.motion, view.time, X, Y))


# -- odd runs ---------------------------------------------------------------------------------------------------------


def test_odd_runs_can_be_drawn(moes):
    """One step; a film that vanishes; a moment without pressure."""
    assert plots.names_of(moes) == ("overview", "maps", "profiles", "history", "friction")  # all of a run
    known = ("overview", "film", "pressure", "midlines", "convergence", "friction")
    assert plots.names_of(steady(MOES_ROLLS)) == known
    assert all(callable(getattr(plots, name)) for name in plots.NAMES)
    for name in plots.names_of(moes):
        figure = plots.draw(moes.isel(frame=slice(0, 1), time=slice(0, 1)), name)
        figure.set_layout_engine("none")
        figure.draw_without_rendering()
    data = dry_impact(MOES_FALLS)
    data["H_min"][40:] = 0.0
    data["P"][-1] = 0.0
    assert panels(plots.history(data))[1].get_ylim()[0] > 0
    last = plots.maps(data, at=float(data["frame"][-1]))
    last.set_layout_engine("none")
    last.draw_without_rendering()


def test_nothing_is_shown_and_pyplot_is_left_alone():
    code = "import sys, ertel.plots; ertel.plots.draw; print('matplotlib.pyplot' in sys.modules)"
    assert python("-c", code).stdout == "False\n"


def test_a_long_run_has_its_time_in_milliseconds(ball):
    slow = ball.copy()
    for name in ("time", "frame"):
        slow[name] = slow[name].assign_attrs(si_factor=100.0 * slow[name].attrs["si_factor"])
    assert View(ball, 48).clock.endswith(" µs") and View(slow, 48).clock.endswith(" ms")
    assert plots.history(slow).axes[0].get_xlabel() == "time $t$ (ms)"


def test_a_contact_is_in_the_middle_of_its_panels_and_its_cavity_has_a_name():
    """The grid of a rolling contact reaches further upstream."""
    rolls = steady(BALL_ROLLS)
    assert rolls["X"].values[-1] < -rolls["X"].values[0]
    figure = plots.overview(rolls.assign(oil=np.minimum(rolls["H"], 0.3)))
    for axes in figure.axes[:2]:
        assert axes.get_xlim()[0] == pytest.approx(-axes.get_xlim()[1], rel=0.02)
    assert "cavity" in [text.get_text() for text in figure.axes[0].texts]
    assert "cavity" not in [text.get_text() for text in plots.film(rolls.assign(oil=rolls["H"])).axes[0].texts]


@pytest.mark.parametrize("run", [steady(BALL_ROLLS), dry_impact(BALL_FALLS)], ids=["steady", "in time"])
def test_the_overview_of_a_touching_contact_has_the_pressure_of_asperities(run):
    about = {**run["P"].attrs, "long_name": "pressure of asperities"}
    figure = plots.overview(run.assign(P_asperity=(0.5 * run["P"]).assign_attrs(about)))
    assert any(axes.get_title().startswith("Pressure of asperities") for axes in figure.axes)


def test_fonts_with_more_characters_are_asked_where_they_are(ball, monkeypatch):
    monkeypatch.setattr("ertel.plots.drawing.EASTERN", {"STIXGeneral", "not here"})
    assert plots.film(ball)._suptitle.get_fontfamily()[-1] == "STIXGeneral"
