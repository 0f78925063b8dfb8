"""Every figure of every kind of run is drawn, and some of them carry the numbers of the run, in the units they say."""

from dataclasses import replace

import numpy as np
import pytest
from cases import python
from made_up import (
    BALL_FALLS,
    BALL_ROLLS,
    C1,
    H_C,
    MOES_FALLS,
    MOES_ROLLS,
    as_in_time,
    dry_impact,
    in_time,
    solutions,
    steady,
    with_temperature,
)

import ertel
from ertel import Measurement, plots
from ertel.case.sections import Drive
from ertel.case.status import Status
from ertel.inputs.case_files import parse_case
from ertel.physics import hertz
from ertel.physics.motion import Oscillation
from ertel.physics.surfaces import Feature, RingWaviness, Spot, Waviness, height
from ertel.plots.view import View
from ertel.results.diagnostics import film_errors
from ertel.results.figures import FIGURES_IN_TIME, FIGURES_OF_MAPS, FIGURES_STEADY, figures_of
from ertel.runs.result import Result

SCALES = parse_case(BALL_FALLS).scales


def panels(figure):
    """The axes of a figure without colour bars and without the right-hand ones of twins."""
    left = [axes for axes in figure.axes if axes.yaxis.get_label_position() == "left"]
    return [axes for axes in left if axes.get_label() != "<colorbar>"]


def right_of(axes):
    (twin,) = [other for other in axes.figure.axes if other is not axes and other.bbox.bounds == axes.bbox.bounds]
    return twin


def line(axes, label):
    (found,) = [candidate for candidate in axes.get_lines() if candidate.get_label() == label]
    return found


def words(axes):
    return [text.get_text() for text in axes.get_legend().get_texts()] if axes.get_legend() else []


@pytest.fixture(scope="module")
def runs(lines):
    one_step = dry_impact(MOES_FALLS).isel(frame=slice(0, 1), time=slice(0, 1))
    gone = dry_impact(MOES_FALLS)  # the film vanishes, and at last there is no pressure
    gone["H_min"][40:] = 0.0
    gone["P"][-1] = 0.0
    return {
        "ball": dry_impact(BALL_FALLS),
        "along the radius": dry_impact(BALL_FALLS, radial=True),
        "rolls": in_time(MOES_ROLLS),
        "steady": with_temperature(steady(BALL_ROLLS)),
        "line": ertel.open(lines / "steady").dataset,
        "falling line": ertel.open(lines / "impact").dataset,
        "one step": one_step,
        "gone": gone,
    }


@pytest.mark.parametrize(
    "kind", ["ball", "along the radius", "rolls", "steady", "line", "falling line", "one step", "gone"]
)
def test_every_figure_of_every_kind_of_run(runs, kind):
    """Each panel says what it shows, and each figure when; a figure that a run does not have is refused."""
    data = runs[kind]
    assert plots.names_of(data) and set(plots.names_of(data)) <= set(figures_of(data)) <= set(plots.NAMES)
    for name in plots.names_of(data) if kind in ("along the radius", "one step", "gone") else figures_of(data):
        if name == "front" and kind in ("rolls", "one step"):
            continue
        figure = plots.draw(data, name)
        figure.set_layout_engine("none")  # where texts lie takes the most time; `test_sheets` looks at it
        figure.draw_without_rendering()
        assert panels(figure), name
        for axes in panels(figure):
            assert axes.get_xlabel() and axes.get_ylabel() and (axes.get_title() or axes.get_legend()), name
        moment = {"ball": "maximum approach", "rolls": "last map"}.get(kind, "")
        assert moment in figure.get_suptitle(), name
        legends = " ".join(word for axes in panels(figure) for word in words(axes))
        assert kind != "rolls" or ("dry" not in legends and "rebound" not in legends), name
    for name in {*FIGURES_IN_TIME, *FIGURES_STEADY} - set(figures_of(data)) - {"asperities", "temperature"}:
        with pytest.raises(plots.NoFigure, match=f"^{name}: .* has no such figure; it has overview"):
            plots.draw(data, name)
    if "line" in kind:
        assert not {*FIGURES_OF_MAPS, "interferogram"} & {*figures_of(data)}
        for draw in (plots.interferogram, plots.animation, plots.movie):
            with pytest.raises(plots.NoFigure, match=r"a line contact has no maps|a steady contact does not move"):
                draw(data, **({} if draw is plots.movie else {"film_scale": 1e-6}))


def test_nothing_is_shown_and_pyplot_is_left_alone():
    code = "import sys, ertel.plots; ertel.plots.draw; print('matplotlib.pyplot' in sys.modules)"
    assert python("-c", code).stdout == "False\n"


def test_the_moment_and_the_numbers_of_a_run_in_time(runs):
    """A time chooses the map next to it, and an event its own; a thin film is in nm."""
    data = runs["ball"]
    frame = int(np.flatnonzero(data["event"].values)[0])
    film, pressure = panels(plots.profiles(data))
    shown = line(film, "maximum approach")
    np.testing.assert_allclose(shown.get_xdata(), data["X"].values * SCALES.a * 1e6)
    np.testing.assert_allclose(shown.get_ydata(), data["H"].values[frame, 40] * SCALES.film * 1e9)
    assert film.get_ylabel() == "film thickness $h$ (nm)"
    P = line(pressure, "maximum approach").get_ydata()
    np.testing.assert_allclose(P, data["P"].values[frame, 40] * SCALES.p_h * 1e-9)
    moes = dry_impact(MOES_FALLS)
    figure, near = plots.profiles(moes, at=1.62), int(np.abs(moes["frame"].values - 1.62).argmin())
    np.testing.assert_array_equal(line(panels(figure)[1], "chosen map").get_ydata(), moes["P"].values[near, 40])
    assert "chosen map at $T$ = 1.6 $t_0$" in figure.get_suptitle()
    assert "end of the run at $T$ = 4 $t_0$" in plots.maps(runs["rolls"], at="end").get_suptitle()
    early = moes.isel(frame=slice(0, 30))  # without a maximum
    last = line(panels(plots.profiles(early))[1], "last map").get_ydata()
    np.testing.assert_array_equal(last, early["P"].values[-1, 40])


def test_roughness_is_where_the_case_has_it():
    rough = Feature(Waviness(0.01, 0.5, phase_x=0.3), 1), Feature(Spot(0.3, -0.05, x=-1.0), 2)
    rough += (Feature(RingWaviness(0.02, 0.4, y=0.2), 1),)
    drive = Drive(entrainment=Oscillation(1.0, 0.3, 2.0), slide_to_roll=0.5)
    case = replace(as_in_time(MOES_ROLLS), roughness=rough, drive=drive)
    X, Y, data = np.linspace(-2, 2, 41)[None, :], np.linspace(-1, 1, 21)[:, None], in_time(case)
    for at in (0.0, 1.3):
        view = View.of(data, at)
        np.testing.assert_array_equal(view.roughness(X, Y), height(case.features, case.motion, view.time, X, Y))


@pytest.mark.parametrize("layer", [None, 1e-7])
def test_error_bars_are_those_of_the_summary(layer):
    """And the last two of three grids may differ little by chance: the change before is a bound."""
    case = replace(BALL_ROLLS, oil=replace(BALL_ROLLS.oil, layer=layer))
    found = film_errors(case, solutions(case))
    for name in ("H_c", "H_min") if layer is None else ():
        first, *_, last = View(steady(BALL_ROLLS)).on_grids(name)
        assert last == pytest.approx(found[name]) and np.isnan(first.error)
    *others, before, last = solutions(case)
    near = replace(last, values={**last.values, "H_c": before.values["H_c"] + 1e-5})
    lucky = film_errors(case, (*others, before, near))["H_c"]
    assert lucky.error == pytest.approx((H_C[1] - H_C[0]) / 12)


def test_the_numbers_of_a_steady_contact(runs):
    """Film and pressure along the flow, over the dry one; temperatures from surface 2 to surface 1."""
    data = runs["steady"]
    along, _ = panels(plots.midlines(data))
    film, x = data["H"].values[64] * C1.film * 1e9, data["X"].values
    np.testing.assert_allclose(along.get_lines()[0].get_ydata(), film)
    dry, pressure = right_of(along).get_lines()
    np.testing.assert_allclose(pressure.get_ydata(), data["P"].values[64] * C1.p_h * 1e-9)
    np.testing.assert_allclose(dry.get_ydata(), hertz.pressure(x) * C1.p_h * 1e-9)
    across, along = panels(plots.temperature(data))
    (mesh,) = [each for each in across.collections if type(each).__name__ == "QuadMesh"]
    loaded = data["P"].values[64] > 1e-6 * data["P"].values.max()
    np.testing.assert_allclose(mesh.get_coordinates()[..., 1], np.outer([0.0, 0.5, 1.0], film[loaded]))
    for label, row, hottest in (("surface 2", 0, 46.85), ("surface 1", 2, 36.85)):  # degC
        drawn = line(along, label).get_ydata()
        assert drawn.max() == pytest.approx(hottest)
        np.testing.assert_allclose(mesh.get_array().reshape(3, -1)[row], drawn[loaded])


def test_the_numbers_of_line_contacts(runs, lines):
    """Over the dry contact: the pressures carry the same load, and the edge of the dry impact moves as it should."""
    section = panels(plots.overview(runs["line"]))[0]
    hertz_line, pressure = (each.get_ydata() for each in right_of(section).get_lines())
    assert hertz_line.max() == pytest.approx(0.848163, rel=1e-3)  # GPa
    x = section.lines[0].get_xdata()
    assert np.trapezoid(hertz_line, x) == pytest.approx(np.trapezoid(pressure, x), rel=0.01)
    run = ertel.open(lines / "impact")
    _, through_time, _, pressure, _, _ = panels(run.plot.overview())
    assert line(pressure, "dry contact").get_ydata().max() == pytest.approx(np.sqrt(run.summary["F"]), rel=1e-3)
    edge = line(through_time, "edge of the dry contact")
    touch, most = 1.0, run.case.parameters.hertz.contact_time / 2  # T at both: it starts at Delta = -1
    A, T = edge.get_xdata(), edge.get_ydata()
    assert np.nanmax(A) == pytest.approx(1.0, abs=1e-3) and T[np.nanargmax(A)] == pytest.approx(touch + most, abs=0.1)
    assert np.isnan(A[touch > T]).all() and np.isfinite(A[(touch + 0.01 < T) & (touch + 2 * most - 0.01 > T)]).all()
    rises = (A > 0.5) & (touch + most - 0.5 > T)
    expected = [run.case.parameters.hertz.front_speed(a) for a in A[rises]]
    np.testing.assert_allclose(np.gradient(A, T)[rises], expected, rtol=0.02)


@pytest.mark.parametrize("name", ["film", "history", "interferogram"])
def test_two_runs_on_equal_scales(name):
    """Panels at the same place have the same labels, limits and colours; those of one run alone have others."""
    fast = {**BALL_FALLS, "contact": {**BALL_FALLS["contact"], "speed": "0.3 m/s"}}
    data, at = [dry_impact(case, radial=True) for case in (BALL_FALLS, fast)], ("max-approach", 1.05)

    def limits_of(axes):
        return [(*each.get_xlim(), *each.get_ylim()) for each in axes]

    one, two = (figure.axes for figure in plots.side_by_side(data, name, at))
    assert np.array(limits_of(one)) == pytest.approx(np.array(limits_of(two)), rel=1e-12)
    for here, there in zip(one, two, strict=True):
        assert (here.get_xlabel(), here.get_ylabel()) == (there.get_xlabel(), there.get_ylabel())
        for image, other in zip(here.images, there.images, strict=True):
            assert image.get_clim() == pytest.approx(other.get_clim(), rel=1e-12)
            assert image.get_cmap() == other.get_cmap()
    alone = [getattr(plots, name)(*each) for each in zip(data, at, strict=True)]
    assert limits_of(alone[0].axes) != limits_of(alone[1].axes)


def test_a_measured_film_over_that_of_the_run(runs):
    """Aligned, in the units of the picture; at the moment of the measurement, or of the picture."""
    ball = Result(parse_case(BALL_FALLS), runs["along the radius"], {"warnings": []}, Status.CONVERGED)
    there, about = ball.profile("60 us"), {"at": "60 us", "name": "film.csv"}
    x, h = there["x"].values[10:-10], there["h"].values[10:-10]
    found = ball.compare(Measurement("profile", "h", h + np.where(np.arange(len(x)) % 2, 3e-9, -3e-9), x, **about))
    above, below = panels(ball.plot.measured(found))
    assert line(above, "computed").get_xdata() == pytest.approx(there["x"].values * 1e6)
    assert below.get_lines()[0].get_ydata() == pytest.approx(found.difference * 1e9)
    title = above.figure.get_suptitle()
    assert words(above) == ["computed", "measured, film.csv"]
    assert "60 µs, between the maps" in title and "rms difference 3 nm" in title
    film = Measurement("profile", "h", h + 1e-7, x + 5e-6, 1e-8, align=("centre", "offset"), **about)
    pressure = Measurement("profile", "p", there["p"].values[10:-10], x)
    above, below = panels(ball.plot.profiles(measured=[film, pressure]))[:2]
    shown = next(each for each in above.containers if each.get_label() == "measured, film.csv").lines[0]
    assert shown.get_xdata() == pytest.approx(x * 1e6, abs=0.1)
    assert shown.get_ydata() == pytest.approx(h * 1e9, rel=0.02)
    assert below.containers[0].lines[0].get_ydata() == pytest.approx(there["p"].values[10:-10] * 1e-9)
    assert "59.85 µs" in ball.plot.profiles(measured=film).get_suptitle()
    assert "89.78 µs" in ball.plot.profiles(at="90 us", measured=replace(film, at=None)).get_suptitle()


def test_a_long_run_has_its_time_in_milliseconds(runs):
    ball, slow = runs["ball"], runs["ball"].copy()
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
    full = plots.film(rolls.assign(oil=rolls["H"]))
    assert "cavity" in [text.get_text() for text in figure.axes[0].texts]
    assert "cavity" not in [text.get_text() for text in full.axes[0].texts]


@pytest.mark.parametrize("kind", ["steady", "ball"])
def test_the_overview_of_a_touching_contact_has_the_pressure_of_asperities(runs, kind):
    about = {**runs[kind]["P"].attrs, "long_name": "pressure of asperities"}
    figure = plots.overview(runs[kind].assign(P_asperity=(0.5 * runs[kind]["P"]).assign_attrs(about)))
    assert any(axes.get_title().startswith("Pressure of asperities") for axes in figure.axes)


def test_fonts_with_more_characters_are_asked_where_they_are(runs, monkeypatch):
    monkeypatch.setattr("ertel.plots.drawing.EASTERN", {"STIXGeneral", "not here"})
    assert plots.film(runs["ball"])._suptitle.get_fontfamily()[-1] == "STIXGeneral"
