"""Pictures of steady rolling contacts: made-up fields, of which everything is known."""

from dataclasses import replace

import numpy as np
import pytest
from drawn import edge_of_oil, line, of_type, panels, right_of
from made_up import BALL_ROLLS as BALL
from made_up import C1, H_C, H_MIN, solutions, steady
from made_up import MOES_ROLLS as MOES

from ertel import plots
from ertel.case.methods import METHODS
from ertel.inputs.python import rolling
from ertel.physics import hertz
from ertel.physics.geometry import Geometry
from ertel.plots.view import View
from ertel.results.diagnostics import film_errors
from ertel.results.measurements import Measurement
from ertel.results.profiles import profile


@pytest.fixture(scope="module")
def ball():
    return steady(BALL)


@pytest.fixture(scope="module")
def moes():
    return steady(MOES)


def test_heading_gives_films_with_their_errors(ball, moes):
    heading = plots.film(moes).get_suptitle()
    assert r"$H_\mathrm{c}$ = 0.0967 ± 0.0017 $a^2/R$" in heading
    assert heading.startswith("Rolling: $M$ = 200,")
    heading = plots.overview(ball).get_suptitle()
    assert r"$h_\mathrm{c}$ = 185.3 ± 3.2 nm" in heading  # extrapolated; a^2/R = 1.9169 µm
    assert heading.startswith("Steel ball: $R$ = 10 mm,  $u_m$ = 0.5026 m/s,  $F$ = 38.89 N")
    one_grid = plots.convergence(moes.isel(grid=[2])).get_suptitle()
    assert r"$H_\mathrm{c}$ = 0.095 $a^2/R$" in one_grid
    sliding = steady(replace(BALL, contact=replace(BALL.contact, slide_to_roll=0.5)))
    assert "slide-to-roll 0.5" in plots.film(sliding).get_suptitle()
    assert "power loss" in plots.friction(sliding).get_suptitle()


def test_measured_film_along_and_across_a_steady_contact(ball):
    lines = profile(ball), profile(ball, along="y")
    x, y = (line["h"].values[30:50] for line in lines)
    along = Measurement("profile", "h", x, lines[0]["x"].values[30:50])
    across = Measurement("profile", "h", y, lines[1]["y"].values[30:50], along="y")
    first, second = panels(plots.midlines(ball, measured=(along, across)))[:2]
    for axes, values in ((first, x), (second, y)):
        assert [each.lines[0].get_ydata() for each in axes.containers] == [pytest.approx(values * 1e9)]


@pytest.mark.parametrize("layer", [None, 1e-7])
def test_error_bars_are_those_of_the_summary(layer):
    """Of a starved contact from three grids: its last two may differ little by chance."""
    case = replace(BALL, oil=replace(BALL.oil, layer=layer))
    found = film_errors(case, solutions(case))
    for name in ("H_c", "H_min"):
        first, *_, last = View(steady(case)).on_grids(name)
        assert last == pytest.approx(found[name]) and np.isnan(first.error)
    *others, before, last = solutions(case)
    near = replace(last, values={**last.values, "H_c": before.values["H_c"] + 1e-5})
    lucky = film_errors(case, (*others, before, near))["H_c"]
    assert lucky.error == pytest.approx((H_C[1] - H_C[0]) / 12 if layer else 1e-5 / 3)


def test_horseshoe(ball):
    (axes,) = panels(plots.film(ball))
    assert axes.get_xlabel() == "$x$ (µm)"
    (image,), (contours, _) = axes.images, of_type(axes, "QuadContourSet")
    assert np.asarray(image.get_array()).min() == pytest.approx(ball["H"].values.min() * C1.film * 1e9)
    np.testing.assert_allclose(np.diff(contours.levels), float(axes.get_title().split()[-2]))
    assert axes.get_aspect() == 1.0
    cavity = ball["X"].values[(ball["oil"] < 0.99 * ball["H"]).any("Y").values].min()
    assert edge_of_oil(axes)[:, 0].min() == pytest.approx(cavity * C1.a * 1e6, abs=0.075 * C1.a * 1e6)  # a cell


def test_midlines_carry_both_fields(ball):
    along, across = panels(plots.midlines(ball))
    (film,) = along.get_lines()
    x = ball["X"].values
    np.testing.assert_allclose(film.get_xdata(), x * C1.a * 1e6)
    np.testing.assert_allclose(film.get_ydata(), ball["H"].values[64] * C1.film * 1e9)
    dry, pressure = right_of(along).get_lines()
    np.testing.assert_allclose(pressure.get_ydata(), ball["P"].values[64] * C1.p_h * 1e-9)
    np.testing.assert_allclose(dry.get_ydata(), hertz.pressure(x) * C1.p_h * 1e-9)
    np.testing.assert_allclose(across.get_lines()[0].get_ydata(), ball["H"].values[:, 96] * C1.film * 1e9)
    assert (along.get_xlabel(), across.get_xlabel()) == ("$x$ (µm)", "$y$ (µm)")


def test_convergence_and_films_on_every_grid(moes):
    residuals, films = panels(plots.convergence(moes))
    assert residuals.get_yscale() == "log"
    np.testing.assert_array_equal(line(residuals, "65²").get_ydata(), [1.0, 1e-2, 1e-5, 1e-9])
    np.testing.assert_array_equal(line(residuals, "33²").get_xdata(), [0, 1, 2])
    np.testing.assert_array_equal(line(residuals, "tolerance").get_ydata(), METHODS["steady"].defaults.tolerance)
    central, minimum = films.containers
    np.testing.assert_array_equal(central.lines[0].get_ydata(), H_C)
    bars = central.lines[2][0].get_segments()
    np.testing.assert_allclose(bars[-1][:, 1], [0.095 - 0.005 / 3, 0.095 + 0.005 / 3])
    np.testing.assert_array_equal(minimum.lines[0].get_ydata(), H_MIN)
    assert [tick.get_text() for tick in films.get_xticklabels()] == ["33²", "65²", "129²", "∞"]
    hollow = [each.get_ydata()[0] for each in films.get_lines() if each.get_markerfacecolor() == "white"]
    np.testing.assert_allclose(hollow, [0.095 + 0.005 / 3, 0.04 + 0.01 / 3])


# -- an ellipse -------------------------------------------------------------------------------------------------------


OBLIQUE = rolling(M=200, L=10, radius_ratio=0.2, entrainment_angle=30.0, nodes=81)  # wide across the flow


@pytest.fixture(scope="module")
def ellipse():
    return steady(OBLIQUE)


def test_maps_of_an_ellipse_have_equal_axes_and_show_all_of_it(ellipse):
    geometry = Geometry(0.2, 30.0)
    along, across = geometry.extent
    pressed = geometry.dry_pressure(1.0, ellipse["X"].values[None, :], ellipse["Y"].values[:, None])
    for axes in panels(plots.maps(ellipse.assign(P=(("Y", "X"), pressed, ellipse["P"].attrs)))):
        assert axes.get_aspect() == 1.0
        (left, right), (low, high) = axes.get_xlim(), axes.get_ylim()
        assert -left > along and -low > across and high > across and right > along


def test_heading_grids_and_hertz_pressure_of_an_ellipse(ellipse):
    figure = plots.overview(ellipse)
    assert "$R_x/R_y$ = 0.2" in figure.get_suptitle() and "angle 30°" in figure.get_suptitle()
    grid = solutions(OBLIQUE)[-1].grid
    ticks = [text.get_text() for axes in figure.axes for text in axes.get_xticklabels()]
    assert f"{grid.nodes_x} x {grid.nodes_y}" in ticks
    across = panels(plots.midlines(ellipse))[1]
    (dry,) = [each for each in right_of(across).get_lines() if each.get_linestyle() == "--"]
    y, P = dry.get_data()
    load = float(ellipse["load"][-1]) / Geometry(0.2).hertz_load
    assert P == pytest.approx(Geometry(0.2, 30.0).dry_pressure(load, 0 * y, y))
