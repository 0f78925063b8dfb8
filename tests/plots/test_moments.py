"""Pictures of a chosen moment, the load and speed in their headings, and the roughness that they show."""

from dataclasses import replace

import numpy as np
import pytest
from made_up import BALL_FALLS, BALL_ROLLS, C1, MOES_FALLS, MOES_ROLLS, as_in_time, dry_impact, in_time, steady

from ertel import plots
from ertel.case.sections import Drive
from ertel.physics.motion import Oscillation
from ertel.physics.surfaces import Feature, RingWaviness, Spot, Waviness, height
from ertel.plots.stored import roughness_height

ROUGH = (Feature(Waviness(0.01, 0.5, phase_x=0.3), 1), Feature(Spot(0.3, -0.05, x=-1.0), 2))
SLIDING = Drive(entrainment=Oscillation(1.0, 0.3, 2.0), slide_to_roll=0.5)
AT_REST = Drive(slide_to_roll=-2.0)  # surface 1
TIME_FIGURES = ("overview", "film", "pressure", "maps", "profiles", "history")


@pytest.fixture(scope="module")
def moes():
    return dry_impact(MOES_FALLS)


def panels(figure):
    return [axes for axes in figure.axes if axes.get_label() != "<colorbar>" and axes.get_xlabel()]


def labels(axes):
    """What the legend says."""
    legend = axes.get_legend()
    return [text.get_text() for text in legend.get_texts()] if legend else []


def roughness_lines(axes):
    """The contour lines round hills and valleys."""
    sets = [c for c in axes.collections if type(c).__name__ == "QuadContourSet" and len(c.levels) == 1]
    return [(float(c.levels[0]), c.get_linestyle()[0][1] is None) for c in sets]


# -- moments ----------------------------------------------------------------------------------------------------------


def test_a_time_chooses_the_map_next_to_it(moes):
    pressure = panels(plots.profiles(moes, at=1.62))[1]
    (shown,) = [line for line in pressure.get_lines() if line.get_label() == "chosen map"]
    frame = int(np.abs(moes["frame"].values - 1.62).argmin())
    np.testing.assert_array_equal(shown.get_ydata(), moes["P"].values[frame, 40])
    assert "chosen map at $T$ = 1.6 $t_0$" in plots.profiles(moes, at=1.62).get_suptitle()


def test_an_event_chooses_its_map(moes):
    assert "maximum approach at $T$ = 2.45" in plots.maps(moes, at="max-approach").get_suptitle()
    assert "end of the run at $T$ = 4 $t_0$" in plots.maps(in_time(MOES_ROLLS), at="end").get_suptitle()


def test_the_rebound_stays_the_rebound(moes):
    """Maps between the chosen moment and maximum approach are not of the rebound."""
    early, late = (panels(plots.profiles(moes, at=at))[1] for at in (1.5, 3.5))
    dashed = [sum(line.get_linestyle() == "--" for line in axes.get_lines()) for axes in (early, late)]
    assert abs(dashed[0] - dashed[1]) <= 1
    assert "rebound" in labels(early) and "rebound" in labels(late)


@pytest.mark.parametrize("at", [0.01, 3.91, -1.0, "touch", "end"])
def test_a_moment_that_the_run_has_not_is_refused(moes, at):
    with pytest.raises(ValueError, match=r'at = .*0\.05 to 3\.9 t0 .*has "max-approach"$'):
        plots.overview(moes, at=at)


@pytest.mark.parametrize("name", TIME_FIGURES)
def test_every_picture_takes_a_moment(moes, name):
    assert "chosen map at" in getattr(plots, name)(moes, at=2.0).get_suptitle()


def test_a_steady_contact_has_no_moments():
    with pytest.raises(ValueError, match="steady contact has no moments"):
        plots.film(steady(MOES_ROLLS), at=1.0)


def test_a_figure_that_a_run_has_not_is_refused(moes):
    with pytest.raises(ValueError, match=r"history: a steady contact has no such figure; it has overview, .*maps"):
        plots.history(steady(MOES_ROLLS))
    with pytest.raises(ValueError, match="convergence: a run in time has no such figure"):
        plots.convergence(moes)


def test_heading_states_the_load_of_the_moment(moes):
    load = float(np.interp(2.45, moes["time"], moes["F"]))
    assert f"load {load:.3g} $F^*$" in plots.maps(moes).get_suptitle()
    assert "load 0 $F^*$" in plots.maps(moes, at=0.2).get_suptitle()
    ball = dry_impact(BALL_FALLS)
    newtons = float(ball["F"].attrs["si_factor"]) * load
    assert f"load {newtons:.4g} N" in plots.maps(ball).get_suptitle()


def test_heading_states_the_speed_of_the_moment():
    data = in_time(MOES_ROLLS)
    data["U"].values *= 1.0 - 0.1 * data["time"].values
    assert "speed 0.8 $u_m$" in plots.maps(data, at=2.0).get_suptitle()
    data = in_time(BALL_ROLLS)
    assert "load 38.89 N" in plots.maps(data).get_suptitle()
    assert "speed 0.5026 m/s" in plots.maps(data).get_suptitle()


# -- roughness --------------------------------------------------------------------------------------------------------


def test_roughness_is_where_the_case_has_it():
    rough = (*ROUGH, Feature(RingWaviness(0.02, 0.4, y=0.2), 1))
    case = replace(as_in_time(MOES_ROLLS), roughness=rough, drive=SLIDING)
    X, Y = np.linspace(-2, 2, 41)[None, :], np.linspace(-1, 1, 21)[:, None]
    data = in_time(case)
    for T in (0.0, 1.3):
        np.testing.assert_array_equal(roughness_height(data, T, X, Y), height(case.features, case.motion, T, X, Y))


def test_maps_show_hills_and_valleys():
    data = in_time(replace(as_in_time(BALL_ROLLS), roughness=ROUGH[:1]))
    for axes in panels(plots.maps(data)):
        hill, valley = sorted(roughness_lines(axes), reverse=True)
        assert hill == (pytest.approx(0.005, rel=1e-3), True)  # solid
        assert valley == (pytest.approx(-0.005, rel=1e-3), False)
        half = 0.005 * C1.film * 1e9
        assert labels(axes) == [f"roughness +{half:.3g} nm", f"roughness \N{MINUS SIGN}{half:.3g} nm"]


def test_profiles_show_the_roughness():
    for figure in (
        plots.profiles(in_time(replace(as_in_time(MOES_ROLLS), roughness=ROUGH[1:]))),
        plots.midlines(rough_steady()),
    ):
        for axes in panels(figure):
            assert axes.get_ylim()[0] < 0
            assert min(axes.get_yticks()) >= 0
            assert any(text.get_text().startswith("roughness") for text in axes.texts)


def rough_steady():
    return steady(replace(MOES_ROLLS, roughness=ROUGH[:1], drive=AT_REST))


def test_smooth_surfaces_show_none(moes):
    for figure in (plots.overview(moes), plots.overview(steady(MOES_ROLLS))):
        figure.draw_without_rendering()
        for axes in panels(figure):
            assert not roughness_lines(axes)
            assert not [text for text in axes.texts if "roughness" in text.get_text()]


def test_a_moment_without_pressure_can_be_drawn():
    data = dry_impact(MOES_FALLS)
    data["P"][-1] = 0.0
    plots.maps(data, at=float(data["frame"][-1])).draw_without_rendering()
