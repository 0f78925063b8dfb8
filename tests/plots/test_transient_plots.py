"""Pictures: that the axes carry the numbers of the run, in the units that they say."""

import numpy as np
import pytest
from made_up import BALL_FALLS as BALL
from made_up import BALL_ROLLS, in_time
from made_up import MOES_FALLS as MOES
from made_up import dry_impact as made_up
from matplotlib.colors import to_rgba

from ertel import plots
from ertel.inputs.case_files import parse_case
from ertel.physics import hertz
from ertel.plots import drawing, transient
from ertel.results import fronts


@pytest.fixture(scope="module")
def ball():
    return made_up(BALL)


@pytest.fixture(scope="module")
def moes():
    return made_up(MOES)


def panels(figure):
    """The axes of a figure without those of colour bars."""
    return [axes for axes in figure.axes if axes.get_label() != "<colorbar>"]


def line(axes, label):
    (found,) = [candidate for candidate in axes.get_lines() if candidate.get_label() == label]
    return found


# -- labels -----------------------------------------------------------------------------------------------------------


def test_physical_labels_have_si_units(ball):
    film, pressure, film_profiles, *_ = panels(plots.overview(ball))[0], *panels(plots.overview(ball))[3:5]
    assert film.get_xlabel() == "$x$ (µm)"
    assert film.get_ylabel() == "$y$ (µm)"
    assert pressure.get_title().endswith("GPa")
    assert film_profiles.get_ylabel() == r"pressure $p$ (GPa)"
    motion = panels(plots.history(ball))[0]
    assert motion.get_xlabel() == "time $t$ (µs)"


def test_dimensionless_labels_have_the_papers_units(moes):
    film, pressure = panels(plots.profiles(moes))
    assert film.get_xlabel() == "$X$ ($a^*$)"
    assert film.get_ylabel() == "film thickness $H$ ($a^{*2}/R$)"
    assert pressure.get_ylabel() == "pressure $P$ ($p_h^*$)"


@pytest.mark.parametrize("name", transient.FIGURES)
@pytest.mark.parametrize("data", ["ball", "moes"])
def test_every_panel_says_what_it_shows(name, data, request):
    for axes in panels(transient.FIGURES[name](request.getfixturevalue(data))):
        assert axes.get_xlabel()
        assert axes.get_ylabel()
        assert axes.get_title() or axes.get_legend()


def test_title_says_the_conditions(ball, moes):
    title = plots.overview(ball).get_suptitle()
    assert "10 mm" in title and "0.1 m/s" in title and "1.394 GPa" in title and "maximum approach" in title
    assert "$M$ = 1000" in plots.overview(moes).get_suptitle()


def test_name_is_the_title():
    assert plots.maps(made_up({**MOES, "name": "my_case"})).get_suptitle().startswith("My case:")


# -- data -------------------------------------------------------------------------------------------------------------


def test_profile_at_maximum_approach(ball):
    film, pressure = panels(plots.profiles(ball))
    frame = int(np.flatnonzero(ball["event"].values)[0])
    scales = parse_case(BALL).scales
    assert scales is not None
    shown = line(film, "maximum approach")
    np.testing.assert_allclose(shown.get_xdata(), ball["X"].values * scales.a * 1e6)
    np.testing.assert_allclose(shown.get_ydata(), ball["H"].values[frame, 40] * scales.film * 1e9)  # thin: in nm
    assert film.get_ylabel() == "film thickness $h$ (nm)"
    assert to_rgba(shown.get_color()) == to_rgba("black")
    np.testing.assert_allclose(
        line(pressure, "maximum approach").get_ydata(), ball["P"].values[frame, 40] * scales.p_h * 1e-9
    )


def test_radial_profiles_are_mirrored():
    data = made_up(MOES, radial=True)
    shown = line(panels(plots.profiles(data))[1], "maximum approach")
    x, P = shown.get_xdata(), shown.get_ydata()
    assert len(x) == 81
    np.testing.assert_array_equal(x, -x[::-1])
    np.testing.assert_array_equal(P, P[::-1])
    assert P[40] == P.max()


def test_radial_map_is_the_profile_turned_round():
    field = drawing.map_of(made_up(MOES, radial=True), "P", 48)
    r = np.hypot(field.y[:, None], field.x[None, :])
    np.testing.assert_allclose(field.values, hertz.pressure(r, float(hertz.contact_radius(1.45))), atol=0.12)
    np.testing.assert_array_equal(field.values, field.values.T)


def test_map_shows_the_film(moes):
    axes = panels(plots.maps(moes))[0]
    (mesh,) = [c for c in axes.collections if type(c).__name__ == "QuadMesh"]
    values = np.asarray(mesh.get_array())
    frame = int(np.flatnonzero(moes["event"].values)[0])
    cut = (81 - len(values)) // 2  # the part round the contact
    assert 0 < cut < 30
    np.testing.assert_array_equal(values, moes["H"].values[frame, cut:-cut, cut:-cut])
    step = float(axes.get_title().split()[-2])
    (contours,) = [c for c in axes.collections if type(c).__name__ == "QuadContourSet"]
    np.testing.assert_allclose(np.diff(contours.levels), step)


def test_rebound_is_dashed(moes):
    axes = panels(plots.profiles(moes))[0]
    lines = [candidate for candidate in axes.get_lines() if len(candidate.get_xdata()) > 0]
    assert {candidate.get_linestyle() for candidate in lines} == {"-", "--"}
    assert line(axes, "rebound").get_linestyle() == "--"


def test_one_map_after_the_maximum_is_no_rebound(moes):
    """A run until maximum approach may end with a map just after it."""
    maximum = int(np.flatnonzero(moes["event"].values)[0])
    kept = [*range(maximum - 20, maximum + 1, 5), maximum + 1]  # so few that each has its line
    axes = panels(plots.profiles(moes.isel(frame=kept)))[0]
    assert "rebound" not in [candidate.get_label() for candidate in axes.get_lines()]


def test_without_maximum_the_last_map_is_shown():
    data = made_up(MOES).isel(frame=slice(0, 30))
    axes = panels(plots.profiles(data))[1]
    np.testing.assert_array_equal(line(axes, "last map").get_ydata(), data["P"].values[-1, 40])


def test_histories(moes):
    motion, film, front, pressure = panels(plots.history(moes))
    T = moes["time"].values
    np.testing.assert_array_equal(line(motion, "load $F/F^*$").get_xdata(), T)
    np.testing.assert_array_equal(line(motion, "load $F/F^*$").get_ydata(), moes["F"].values)
    assert film.get_yscale() == "log"
    assert len(film.get_lines()) == len(pressure.get_lines()) == 3  # two curves and the moment of the maximum
    dry = line(front, "edge of the dry contact").get_ydata()
    np.testing.assert_allclose(np.nanmax(dry), 1.0, atol=1e-3)
    made_of = line(front, "front: place of the minimum film thickness").get_ydata()
    loaded = np.isfinite(made_of)
    np.testing.assert_allclose(made_of[loaded & np.isfinite(dry)], dry[loaded & np.isfinite(dry)])


def test_the_front_and_its_speed(ball):
    place, speed = panels(plots.front(ball))
    scales = parse_case(BALL).scales
    assert scales is not None
    assert (place.get_ylabel(), speed.get_ylabel()) == ("distance from the centre (µm)", "speed (m/s)")
    shown, dry = line(speed, "front: place of the minimum film"), line(speed, "edge of the dry contact")
    expected = fronts.front(ball)
    np.testing.assert_allclose(shown.get_xdata(), expected.T * scales.t0 * 1e6)
    np.testing.assert_allclose(shown.get_ydata(), expected.speed * scales.front_speed)
    late = shown.get_xdata() > 0.5 * shown.get_xdata()[-1]  # the made-up front is the edge of the dry contact
    same = np.interp(shown.get_xdata()[late], dry.get_xdata(), dry.get_ydata())
    np.testing.assert_allclose(shown.get_ydata()[late], same, atol=0.02 * scales.front_speed)


def test_no_front_before_maximum_approach_nor_in_rolling(ball):
    with pytest.raises(plots.NoFigure, match=r"the front has no speed: .*before it"):
        plots.front(ball.isel(frame=slice(0, 30)))
    with pytest.raises(plots.NoFigure, match="a rolling contact has none"):
        plots.front(in_time(BALL_ROLLS))


def test_histories_mark_the_maximum(ball):
    motion = panels(plots.history(ball))[0]
    scales = parse_case(BALL).scales
    assert scales is not None
    moment = [candidate for candidate in motion.get_lines() if candidate.get_linestyle() == ":"]
    np.testing.assert_allclose(moment[0].get_xdata(), 2.45 * scales.t0 * 1e6)


@pytest.mark.parametrize(("largest", "unit"), [(1.0, "µm"), (0.01, "nm"), (300.0, "mm")])
def test_prefix_fits(ball, largest, unit):
    shown = drawing.scale(ball, "H", largest)
    assert shown.unit == unit
    assert 0.5 <= largest * shown.factor < 500


def test_short_runs_can_be_drawn():
    data = made_up(MOES).isel(frame=slice(0, 1), time=slice(0, 1))
    for draw in transient.FIGURES.values():
        draw(data).draw_without_rendering()


def test_a_film_that_vanishes_can_be_drawn():
    data = made_up(MOES)
    data["H_min"][40:] = 0.0
    film = panels(plots.history(data))[1]
    assert film.get_ylim()[0] > 0


def test_a_run_without_maps_says_so():
    data = made_up(MOES).isel(frame=slice(0, 0))
    with pytest.raises(ValueError, match="no maps"):
        plots.overview(data)


def test_impact_has_no_flow(moes):
    assert not [text for axes in panels(plots.maps(moes)) for text in axes.texts if text.get_text() == "flow"]


def test_long_headings_are_broken(ball):
    heading = plots.overview(ball).get_suptitle()
    assert heading.count("\n") == 0
    assert plots.maps(ball).get_suptitle().replace("\n", "  ") == heading


def test_nothing_is_shown_and_pyplot_is_left_alone():
    import subprocess
    import sys

    code = "import sys, ertel.plots.transient; print('matplotlib.pyplot' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, text=True).stdout.strip() == "False"
