"""Pictures of runs in time: the axes carry the numbers of the run at the chosen moment, in the units that they say."""

from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from cases import python
from drawn import flow_arrows, line, of_type, panels, right_of, roughness_lines, words
from made_up import BALL_FALLS, BALL_ROLLS, BARUS, C1, MOES_FALLS, MOES_ROLLS, as_in_time, dry_impact, in_time, steady
from matplotlib.colors import to_rgba

from ertel import plots
from ertel.case.sections import Drive
from ertel.inputs.case_files import parse_case
from ertel.inputs.python import rolling
from ertel.physics import hertz
from ertel.physics.motion import Oscillation
from ertel.physics.surfaces import Feature, RingWaviness, Spot, Waviness, height
from ertel.plots.drawing import Scale
from ertel.plots.view import View
from ertel.results import fronts
from ertel.results.variables import FIGURES_IN_TIME, FIGURES_STEADY

ROUGH = (Feature(Waviness(0.01, 0.5, phase_x=0.3), 1), Feature(Spot(0.3, -0.05, x=-1.0), 2))
SLIDING = rolling(
    radius=0.01, load=38.885237, mean_speed=0.502636, slide_to_roll=0.2, E_prime=2.197802e11, oil=BARUS, nodes=81
)
SCALES = parse_case(BALL_FALLS).scales
assert SCALES is not None and C1 is not None


@pytest.fixture(scope="module")
def ball():
    return dry_impact(BALL_FALLS)


@pytest.fixture(scope="module")
def moes():
    return dry_impact(MOES_FALLS)


@pytest.fixture(scope="module")
def runs(ball, moes):
    rolls = {"ball rolls": in_time(BALL_ROLLS), "moes rolls": in_time(MOES_ROLLS)}
    return {"ball": ball, "moes": moes, **rolls, "steady ball": steady(BALL_ROLLS), "steady moes": steady(MOES_ROLLS)}


def frame_of_maximum(data):
    return int(np.flatnonzero(data["event"].values)[0])


# -- labels and headings ----------------------------------------------------------------------------------------------


def test_labels_have_si_units_or_those_of_the_paper(ball, moes):
    film, _, _, pressure, profiles, _ = panels(plots.overview(ball))
    assert (film.get_xlabel(), film.get_ylabel()) == ("$x$ (µm)", "$y$ (µm)")
    assert pressure.get_title().endswith("GPa")
    assert profiles.get_ylabel() == r"pressure $p$ (GPa)"
    assert panels(plots.history(ball))[0].get_xlabel() == "time $t$ (µs)"
    film, pressure = panels(plots.profiles(moes))
    assert (film.get_xlabel(), film.get_ylabel()) == ("$X$ ($a^*$)", "film thickness $H$ ($a^{*2}/R$)")
    assert pressure.get_ylabel() == "pressure $P$ ($p_h^*$)"


MOMENTS = {"ball": "maximum approach", "moes": "chosen map", "ball rolls": "last map", "moes rolls": "last map"}


@pytest.mark.parametrize(
    ("name", "run"),
    [*((name, run) for name in FIGURES_IN_TIME for run in MOMENTS if name != "front" or "rolls" not in run),
     *product(FIGURES_STEADY, ("steady ball", "steady moes"))],
)  # fmt: skip
def test_every_panel_says_what_it_shows(runs, name, run):
    figure = getattr(plots, name)(runs[run], at=2.0 if run == "moes" else None)
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


def test_heading_says_the_conditions(runs):
    heading = {name: plots.overview(runs[name]).get_suptitle() for name in MOMENTS}
    assert all(said in heading["ball"] for said in ("10 mm", "0.1 m/s", "1.394 GPa", "maximum approach"))
    assert "$M$ = 1000" in heading["moes"]
    assert "$u_m$ = 0.5026 m/s" in heading["ball rolls"] and "$F$ = 38.89 N" in heading["ball rolls"]
    assert "v_0" not in heading["ball rolls"]
    assert "\n" not in heading["ball"]  # but where the figure is narrow
    assert plots.maps(runs["ball"]).get_suptitle().replace("\n", "  ") == heading["ball"]
    assert plots.maps(dry_impact({**MOES_FALLS, "name": "my_case"})).get_suptitle().startswith("My case:")


def test_heading_states_load_and_speed_of_the_moment(ball, moes):
    load = float(np.interp(2.45, moes["time"], moes["F"]))
    assert f"load {load:.4g} $F^*$" in plots.maps(moes).get_suptitle()
    assert "load 0 $F^*$" in plots.maps(moes, at=0.2).get_suptitle()
    assert f"load {float(ball['F'].attrs['si_factor']) * load:.4g} N" in plots.maps(ball).get_suptitle()
    data = in_time(MOES_ROLLS)
    data["U"].values *= 1.0 - 0.1 * data["time"].values
    assert "speed 0.8 $u_m$" in plots.maps(data, at=2.0).get_suptitle()
    heading = plots.maps(in_time(BALL_ROLLS)).get_suptitle()
    assert "load 38.89 N" in heading and "speed 0.5026 m/s" in heading


@pytest.mark.parametrize(
    ("name", "largest", "unit"),
    [("H", 1.0, "µm"), ("H", 0.01, "nm"), ("H", 300.0, "mm"), ("loss", 1.0, "W/mm²"), ("U", 1e-3, "m/s")],
)
def test_unit_fits(ball, name, largest, unit):
    shown = Scale.of(ball[name], largest, "impact")
    assert shown.unit == unit
    assert name != "H" or 0.5 <= largest * shown.factor < 500


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


def test_radial_runs_are_mirrored_and_turned_round():
    data = dry_impact(MOES_FALLS, radial=True)
    shown = line(panels(plots.profiles(data))[1], "maximum approach")
    x, P = shown.get_xdata(), shown.get_ydata()
    assert len(x) == 81 and P[40] == P.max()
    np.testing.assert_array_equal(x, -x[::-1])
    np.testing.assert_array_equal(P, P[::-1])
    field = View(data, 48).map("P")
    r = np.hypot(field["Y"].values[:, None], field["X"].values[None, :])
    np.testing.assert_allclose(field.values, hertz.pressure(r, float(hertz.contact_radius(1.45))), atol=0.12)
    np.testing.assert_array_equal(field, field.T)


def test_map_shows_the_film(moes):
    axes = panels(plots.maps(moes))[0]
    (image,), (contours,) = axes.images, of_type(axes, "QuadContourSet")
    values = np.asarray(image.get_array())
    cut = (81 - len(values)) // 2  # the part round the contact
    assert 0 < cut < 30
    np.testing.assert_array_equal(values, moes["H"].values[frame_of_maximum(moes), cut:-cut, cut:-cut])
    np.testing.assert_allclose(np.diff(contours.levels), float(axes.get_title().split()[-2]))


@pytest.mark.parametrize("at", [None, 1.5, 3.5])
def test_rebound_is_dashed(moes, at):
    """Maps between the chosen moment and maximum approach are not of the rebound."""
    axes = panels(plots.profiles(moes, at=at))[1]
    dashed = [candidate for candidate in axes.get_lines() if candidate.get_linestyle() == "--"]
    assert line(axes, "rebound") in dashed
    assert len(dashed) == pytest.approx(8, abs=1)
    maximum = frame_of_maximum(moes)  # a run until maximum approach may end with a map just after it: no rebound
    kept = [*range(maximum - 20, maximum + 1, 5), maximum + 1]  # so few that each has its line
    assert "rebound" not in words(panels(plots.profiles(moes.isel(frame=kept)))[0])


@pytest.mark.parametrize(("contact", "flow"), [*product((in_time, steady), (1.0, -1.0)), (in_time, 0.0)])
def test_arrow_shows_the_flow(contact, flow):
    assert [flow_arrows(axes) for axes in panels(plots.maps(contact(MOES_ROLLS, flow)))] == 2 * [[flow] if flow else []]


# -- histories --------------------------------------------------------------------------------------------------------


def test_histories_of_an_impact(ball, moes):
    motion, film, front, pressure = panels(plots.history(moes))
    load = line(motion, "load $F/F^*$")
    np.testing.assert_array_equal(load.get_xdata(), moes["time"].values)
    np.testing.assert_array_equal(load.get_ydata(), moes["F"].values)
    assert film.get_yscale() == "log"
    assert len(film.get_lines()) == len(pressure.get_lines()) == 3  # two curves and the moment of the maximum
    dry = line(front, "edge of the dry contact").get_ydata()
    np.testing.assert_allclose(np.nanmax(dry), 1.0, atol=1e-3)
    place = line(front, "front: place of the minimum film thickness").get_ydata()
    both = np.isfinite(place) & np.isfinite(dry)
    np.testing.assert_allclose(place[both], dry[both])
    moment = [candidate for candidate in panels(plots.history(ball))[0].get_lines() if candidate.get_linestyle() == ":"]
    np.testing.assert_allclose(moment[0].get_xdata(), 2.45 * SCALES.t0 * 1e6)


def test_histories_of_a_rolling_contact():
    motion, film, place, _ = panels(plots.history(in_time(BALL_ROLLS)))
    assert {"load of the film", "applied load", "entrainment"} <= set(words(motion))
    assert film.get_yscale() == "linear"
    np.testing.assert_allclose(line(place, "to the side").get_ydata(), 0.8 * C1.a * 1e6)
    assert place.get_ylabel() == "place of the minimum film (µm)"


def test_the_front_and_its_speed(ball):
    place, speed = panels(plots.front(ball))
    assert (place.get_ylabel(), speed.get_ylabel()) == ("distance from the centre (µm)", "speed (m/s)")
    shown, dry = line(speed, "front"), line(speed, "edge of the dry contact")
    expected = fronts.front(ball)
    np.testing.assert_allclose(shown.get_xdata(), expected.T * SCALES.t0 * 1e6)
    np.testing.assert_allclose(shown.get_ydata(), expected.speed * SCALES.front_speed)
    late = shown.get_xdata() > 0.5 * shown.get_xdata()[-1]  # the made-up front is the edge of the dry contact
    same = np.interp(shown.get_xdata()[late], dry.get_xdata(), dry.get_ydata())
    np.testing.assert_allclose(shown.get_ydata()[late], same, atol=0.02 * SCALES.front_speed)


def test_paths_through_time_have_the_mean_speed_of_the_surfaces(moes):
    data = in_time(MOES_ROLLS)
    data["U"].values *= -0.5
    axes, *_ = panels(plots.spacetime(data))
    path = line(axes, "path with the mean speed")
    np.testing.assert_allclose(np.diff(path.get_xdata()), -0.5 * np.diff(path.get_ydata()), rtol=1e-12)
    (image,) = axes.collections
    film = data["H"].sel(Y=0, method="nearest").where(data["P"].sel(Y=0, method="nearest") > 0.02 * data["P"].max())
    np.testing.assert_array_equal(np.ma.filled(image.get_array(), np.nan), film)
    axes, *_ = panels(plots.spacetime(moes))
    edge = line(axes, "edge of the dry contact").get_xdata()
    assert np.nanmax(edge) == pytest.approx(1.0, abs=0.01)


def test_a_run_that_carries_nothing_can_be_drawn():
    data = dry_impact(MOES_FALLS)
    data["P"].values[:] = 0.0
    for name in ("maps", "profiles", "spacetime"):
        plots.draw(data, name).draw_without_rendering()


def test_thinnest_film_is_shown_first():
    data = in_time(BALL_ROLLS)
    data["H_min"][:] = 0.05 + 0.01 * np.abs(data["time"] - 1.5)
    assert "thinnest film at $t$ = " in plots.maps(data).get_suptitle() and View.of(data).time == pytest.approx(1.5)
    data["H_min"][:] = 0.05 + 0.01 * data["time"]  # at the start
    assert "last map" in plots.maps(data).get_suptitle()


def test_what_the_grid_makes_of_a_rebound_is_marked(moes):
    """Teeth of the power loss, one for every cell that the front passes, and a spike of pressure at the end."""
    data = moes.copy(deep=True)
    T, end = data["time"].values, data["frame"].values[-1]
    data["power_loss"][:] = 1.0 + np.where(T > 2.45, 0.2 * (-1.0) ** np.arange(len(T)), 0.0)
    (_, power) = panels(plots.friction(data))
    mean, raw = line(power, "mean over a cell").get_ydata(), line(power, "teeth of the grid").get_ydata()
    assert np.ptp(mean[(T > 2.6) & (T < end - 0.15)]) < 0.5 * np.ptp(raw) and (mean[T < 2.45] == raw[T < 2.45]).all()
    data["F"][-3:], data["P_max"][-2] = 0.0, 9.0
    pressure = panels(plots.history(data))[3]
    assert pressure.get_ylim()[1] < 2.0 and "spike of the grid" in words(pressure)
    assert "spike of the grid" not in words(panels(plots.history(moes))[3])


def test_friction_of_sliding_surfaces():
    data = in_time(SLIDING)
    data["mu_sliding"][:], data["mu_rolling"][:], data["power_loss"][:] = 0.04, 0.0005, 1.5
    stress, loss, coefficients, power = panels(plots.friction(data, at=2.0))
    assert stress.get_title().startswith("Shear stress, a line every ") and stress.get_title().endswith(" MPa")
    assert loss.get_title().endswith(" W/mm²")
    assert line(coefficients, "traction coefficient").get_ydata()[-1] == pytest.approx(0.04)
    resistance = line(right_of(coefficients), "rolling resistance coefficient")
    assert resistance.get_ydata()[-1] == pytest.approx(0.0005)
    watt = line(power, "power loss").get_ydata()[-1]
    assert watt == pytest.approx(1.5 * C1.power * (1e3 if "mW" in power.get_ylabel() else 1.0))
    without_sliding = [axes.get_title().partition(",")[0] for axes in panels(plots.friction(in_time(BALL_ROLLS)))]
    assert without_sliding == ["Power loss", "Coefficients of friction", "Power loss"]


# -- roughness --------------------------------------------------------------------------------------------------------


def test_roughness_is_where_the_case_has_it():
    rough = (*ROUGH, Feature(RingWaviness(0.02, 0.4, y=0.2), 1))
    drive = Drive(entrainment=Oscillation(1.0, 0.3, 2.0), slide_to_roll=0.5)
    case = replace(as_in_time(MOES_ROLLS), roughness=rough, drive=drive)
    X, Y, data = np.linspace(-2, 2, 41)[None, :], np.linspace(-1, 1, 21)[:, None], in_time(case)
    for at in (0.0, 1.3):
        view = View.of(data, at)
        np.testing.assert_array_equal(view.roughness(X, Y), height(case.features, case.motion, view.time, X, Y))


def test_maps_show_hills_and_valleys():
    data = in_time(replace(as_in_time(BALL_ROLLS), roughness=ROUGH[:1]))
    half = 0.005 * C1.film * 1e9
    for axes in panels(plots.maps(data)):
        valley, hill = sorted(roughness_lines(axes))
        assert hill == (pytest.approx(0.005, rel=1e-3), True)  # solid
        assert valley == (pytest.approx(-0.005, rel=1e-3), False)
        assert words(axes) == [f"roughness +{half:.3g} nm", f"roughness \N{MINUS SIGN}{half:.3g} nm"]


def test_profiles_show_the_roughness_below():
    data = in_time(replace(as_in_time(MOES_ROLLS), roughness=ROUGH[1:]))
    at_rest = Drive(slide_to_roll=-2.0)  # surface 1
    rough = steady(replace(MOES_ROLLS, roughness=(Feature(Waviness(0.01, 0.5, phase_x=0.3), 1),), drive=at_rest))
    for axes in panels(plots.profiles(data, at=1.0)) + panels(plots.midlines(rough)):
        assert axes.get_ylim()[0] < 0 <= min(axes.get_yticks())
        assert any(text.get_text().startswith("roughness") for text in axes.texts)
    for axes in panels(plots.profiles(data, at="end")):  # the spot has left, but for round-off
        assert axes.get_ylim()[0] == 0 and not axes.texts
    assert all(roughness_lines(axes) for axes in panels(plots.maps(rough)))


def test_a_smooth_contact_shows_no_roughness_and_a_resting_one_no_flow(moes):
    for axes in panels(plots.overview(moes)) + panels(plots.overview(steady(MOES_ROLLS))):
        assert not roughness_lines(axes)
        assert not [text for text in axes.texts if "roughness" in text.get_text()]
    assert not [text for axes in panels(plots.maps(moes)) for text in axes.texts]


# -- odd runs ---------------------------------------------------------------------------------------------------------


def test_odd_runs_can_be_drawn(moes):
    """One step; a film that vanishes; a moment without pressure."""
    assert plots.names_of(moes) == ("overview", "maps", "profiles", "history", "friction")  # all of a run
    known = ("overview", "film", "pressure", "midlines", "convergence", "friction")
    assert plots.names_of(steady(MOES_ROLLS)) == known
    assert all(callable(getattr(plots, name)) for name in plots.NAMES)
    for name in plots.names_of(moes):
        plots.draw(moes.isel(frame=slice(0, 1), time=slice(0, 1)), name).draw_without_rendering()
    data = dry_impact(MOES_FALLS)
    data["H_min"][40:] = 0.0
    data["P"][-1] = 0.0
    assert panels(plots.history(data))[1].get_ylim()[0] > 0
    plots.maps(data, at=float(data["frame"][-1])).draw_without_rendering()


def test_nothing_is_shown_and_pyplot_is_left_alone():
    code = "import sys, ertel.plots; ertel.plots.draw; print('matplotlib.pyplot' in sys.modules)"
    assert python("-c", code).stdout == "False\n"


# -- two runs ---------------------------------------------------------------------------------------------------------


def test_two_runs_have_common_units(ball, moes):
    """In SI where both runs are, with units that fit both; runs of another ball have other scales."""
    larger = dry_impact({**BALL_FALLS, "contact": {**BALL_FALLS["contact"], "radius": "100 mm"}})
    film, _, thinnest = panels(plots.comparison([ball, larger], ["one", "two"]))
    assert thinnest.get_yscale() == "log"  # it falls fivefold
    assert film.get_ylabel().startswith("film thickness $h$ (") and film.get_xlabel().startswith("$x$ (")
    ratios = [np.ptp(line(film, name).get_xdata()) for name in ("one", "two")]
    factors = [float(run["X"].attrs["si_factor"]) for run in (ball, larger)]
    assert ratios[1] / ratios[0] == pytest.approx(factors[1] / factors[0])
    assert thinnest.get_xlabel().startswith("time $t$")
    film, *_ = panels(plots.comparison([ball, moes], ["one", "two"]))
    assert film.get_xlabel() == "$X$ ($a^*$)"
    np.testing.assert_array_equal(line(film, "one").get_xdata(), ball["X"].values)
    film, pressure = panels(plots.comparison([steady(BALL_ROLLS), steady(MOES_ROLLS)], ["one", "two"]))  # no history
    assert film.get_ylabel() == "film thickness $H$ ($a^2/R$)" and pressure.get_xlabel() == "$X$ ($a$)"
    assert len(panels(plots.comparison([steady(BALL_ROLLS), in_time(BALL_ROLLS)], ["one", "two"]))) == 2
