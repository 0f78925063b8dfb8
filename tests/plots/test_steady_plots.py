"""Pictures of rolling contacts, steady and in time: made-up fields, of which everything is known."""

from dataclasses import replace

import numpy as np
import pytest
from made_up import BALL_ROLLS as BALL
from made_up import BARUS, C1, H_C, H_MIN, in_time, solutions, steady
from made_up import MOES_ROLLS as MOES

from ertel import plots
from ertel.case.sections import SOLVERS
from ertel.equations.discretise import grid_of
from ertel.inputs.python import rolling
from ertel.physics import hertz
from ertel.physics.geometry import Geometry
from ertel.plots import steady as steady_plots
from ertel.plots import transient
from ertel.plots.steady import estimate_of
from ertel.results.dataset import assemble_steady
from ertel.solvers.steady import Rolling


@pytest.fixture(scope="module")
def ball():
    return steady(BALL)


@pytest.fixture(scope="module")
def moes():
    return steady(MOES)


def panels(figure):
    """The axes of a figure without those of colour bars and the right-hand ones of twins."""
    return [axes for axes in figure.axes if axes.get_label() != "<colorbar>" and axes.get_xlabel()]


def right_of(figure, axes):
    (twin,) = [other for other in figure.axes if other is not axes and other.bbox.bounds == axes.bbox.bounds]
    return twin


def labelled(axes, label):
    (found,) = [candidate for candidate in axes.get_lines() if candidate.get_label() == label]
    return found


def arrow(axes):
    """Where the flow's arrow points: x of its end less that of its start."""
    (found,) = [text for text in axes.texts if getattr(text, "arrow_patch", None)]
    return found.xy[0] - found.get_position()[0]


# -- steady -----------------------------------------------------------------------------------------------------------


def test_the_figures_of_a_dataset(moes):
    assert plots.figures_of(moes) is steady_plots.STEADY_FIGURES
    assert plots.figures_of(in_time(MOES)) is transient.FIGURES


@pytest.mark.parametrize("name", steady_plots.STEADY_FIGURES)
@pytest.mark.parametrize("data", ["ball", "moes"])
def test_every_panel_says_what_it_shows(name, data, request):
    figure = steady_plots.STEADY_FIGURES[name](request.getfixturevalue(data))
    figure.draw_without_rendering()
    assert panels(figure)
    for axes in panels(figure):
        assert axes.get_ylabel()
        assert axes.get_title()


def test_heading_gives_films_with_their_errors(ball, moes):
    heading = steady_plots.STEADY_FIGURES["film"](moes).get_suptitle()
    assert r"$H_\mathrm{c}$ = 0.0950 ± 0.0017 $a^2/R$" in heading
    assert heading.startswith("Rolling: $M$ = 200,")
    heading = steady_plots.STEADY_FIGURES["overview"](ball).get_suptitle()
    assert r"$h_\mathrm{c}$ = 182.1 ± 3.2 nm" in heading  # a^2/R = 1.9169 µm
    assert heading.startswith("Steel ball: $R$ = 10 mm,  $u_m$ = 0.5026 m/s,  $F$ = 38.89 N")


def test_error_bars_are_those_of_the_run(moes):
    """The same rule as in the summary."""
    for name in ("H_c", "H_min"):
        found = estimate_of(moes, name)
        known = [Rolling(solutions(MOES)[:count]).extrapolate(name) for count in (2, 3)]  # type: ignore[arg-type]
        np.testing.assert_allclose(found.errors, [np.nan, *(one.error for one in known)])
        assert found.extrapolated == pytest.approx(known[-1].extrapolated)


def test_one_grid_has_no_error(moes):
    heading = steady_plots.STEADY_FIGURES["convergence"](moes.isel(grid=[2])).get_suptitle()
    assert r"$H_\mathrm{c}$ = 0.095 $a^2/R$" in heading


def test_horseshoe(ball):
    (axes,) = panels(steady_plots.STEADY_FIGURES["film"](ball))
    assert axes.get_xlabel() == "$x$ (µm)"
    (mesh,) = [c for c in axes.collections if type(c).__name__ == "QuadMesh"]
    shown = np.asarray(mesh.get_array())
    assert shown.min() == pytest.approx(ball["H"].values.min() * C1.film * 1e9)
    (contours,) = [c for c in axes.collections if type(c).__name__ == "QuadContourSet"]
    np.testing.assert_allclose(np.diff(contours.levels), float(axes.get_title().split()[-2]))
    assert axes.get_aspect() == 1.0


@pytest.mark.parametrize("flow", [1.0, -1.0])
def test_arrow_shows_the_flow(flow):
    for name in ("film", "pressure"):
        (axes,) = panels(steady_plots.STEADY_FIGURES[name](steady(MOES, flow)))
        assert np.sign(arrow(axes)) == flow
    for axes in panels(plots.maps(in_time(MOES, flow))):
        assert np.sign(arrow(axes)) == flow


def test_still_surfaces_have_no_arrow():
    assert not [axes for axes in panels(plots.maps(in_time(MOES, 0.0))) if axes.texts]


def test_midlines_carry_both_fields(ball):
    figure = steady_plots.STEADY_FIGURES["midlines"](ball)
    along, across = panels(figure)
    (film,) = along.get_lines()
    x = ball["X"].values
    np.testing.assert_allclose(film.get_xdata(), x * C1.a * 1e6)
    np.testing.assert_allclose(film.get_ydata(), ball["H"].values[64] * C1.film * 1e9)
    dry, pressure = right_of(figure, along).get_lines()
    np.testing.assert_allclose(pressure.get_ydata(), ball["P"].values[64] * C1.p_h * 1e-9)
    np.testing.assert_allclose(dry.get_ydata(), hertz.pressure(x) * C1.p_h * 1e-9)
    np.testing.assert_allclose(across.get_lines()[0].get_ydata(), ball["H"].values[:, 96] * C1.film * 1e9)
    assert (along.get_xlabel(), across.get_xlabel()) == ("$x$ (µm)", "$y$ (µm)")


def test_convergence_on_every_grid(moes):
    axes, _ = panels(steady_plots.STEADY_FIGURES["convergence"](moes))
    assert axes.get_yscale() == "log"
    np.testing.assert_array_equal(labelled(axes, "65²").get_ydata(), [1.0, 1e-2, 1e-5, 1e-9])
    np.testing.assert_array_equal(labelled(axes, "33²").get_xdata(), [0, 1, 2])
    np.testing.assert_array_equal(labelled(axes, "tolerance").get_ydata(), SOLVERS["steady"].tolerance)


def test_films_on_every_grid(moes):
    _, axes = panels(steady_plots.STEADY_FIGURES["convergence"](moes))
    central, minimum = (container for container in axes.containers)
    np.testing.assert_array_equal(central.lines[0].get_ydata(), H_C)
    bars = central.lines[2][0].get_segments()
    np.testing.assert_allclose(bars[-1][:, 1], [0.095 - 0.005 / 3, 0.095 + 0.005 / 3])
    np.testing.assert_array_equal(minimum.lines[0].get_ydata(), H_MIN)
    assert [tick.get_text() for tick in axes.get_xticklabels()] == ["33²", "65²", "129²", "∞"]
    hollow = [line.get_ydata()[0] for line in axes.get_lines() if line.get_markerfacecolor() == "white"]
    np.testing.assert_allclose(hollow, [0.095 + 0.005 / 3, 0.04 + 0.01 / 3])


# -- in time ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", transient.FIGURES)
@pytest.mark.parametrize("case", [MOES, BALL])
def test_a_run_in_time_can_be_drawn(name, case):
    figure = transient.FIGURES[name](in_time(case))
    figure.draw_without_rendering()
    assert "last map at" in figure.get_suptitle()
    legends = [legend for axes in panels(figure) if (legend := axes.get_legend())]
    words = " ".join(text.get_text() for legend in legends for text in legend.get_texts())
    assert "dry" not in words and "rebound" not in words


def test_what_drives_it():
    axes = panels(plots.history(in_time(BALL)))[0]
    labels = {candidate.get_label() for candidate in axes.get_lines()}
    assert {"load of the film", "applied load", "entrainment"} <= labels


def test_where_the_film_is_thinnest():
    axes = panels(plots.history(in_time(BALL)))[2]
    np.testing.assert_allclose(labelled(axes, "to the side").get_ydata(), 0.8 * C1.a * 1e6)
    assert axes.get_ylabel() == "place of the minimum film (µm)"


def test_a_steady_film_is_not_drawn_over_decades():
    assert panels(plots.history(in_time(MOES)))[1].get_yscale() == "linear"


def test_without_a_solution_there_is_nothing_to_draw():
    with pytest.raises(ValueError, match="no solution"):
        steady_plots.STEADY_FIGURES["overview"](assemble_steady(MOES, grid_of(MOES), ()))


def test_sliding_is_said():
    sliding = replace(BALL, contact=replace(BALL.contact, slide_to_roll=0.5))
    assert "slide-to-roll 0.5" in steady_plots.STEADY_FIGURES["film"](steady(sliding)).get_suptitle()


def test_heading_of_a_run_in_time():
    heading = plots.overview(in_time(BALL)).get_suptitle()
    assert "$u_m$ = 0.5026 m/s" in heading and "$F$ = 38.89 N" in heading and "v_0" not in heading


# -- an ellipse -------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def ellipse():
    """Wide across the flow, whose direction is 30 degrees off the axis."""
    return steady(rolling(M=200, L=10, radius_ratio=0.2, entrainment_angle=30.0, nodes=81))


def test_maps_of_an_ellipse_have_equal_axes_and_show_all_of_it(ellipse):
    geometry = Geometry(0.2, 30.0)
    along, across = geometry.extent
    for name in ("film", "pressure"):
        pressed = geometry.dry_pressure(1.0, ellipse["X"].values[None, :], ellipse["Y"].values[:, None])
        axes = panels(getattr(plots, name)(ellipse.assign(P=(("Y", "X"), pressed, ellipse["P"].attrs))))[0]
        assert axes.get_aspect() == 1.0
        (left, right), (low, high) = axes.get_xlim(), axes.get_ylim()
        assert -left > along and -low > across and high > across and right > along


def test_heading_and_grids_of_an_ellipse(ellipse):
    figure = plots.overview(ellipse)
    heading = figure.get_suptitle()
    assert "$R_x/R_y$ = 0.2" in heading and "angle 30°" in heading
    ticks = [text.get_text() for axes in figure.axes for text in axes.get_xticklabels()]
    grid = solutions(rolling(M=200, L=10, radius_ratio=0.2, entrainment_angle=30.0, nodes=81))[-1].grid
    assert f"{grid.nodes_x} x {grid.nodes_y}" in ticks


def test_dashed_is_the_hertz_pressure_of_the_ellipse(ellipse):
    axes = panels(plots.midlines(ellipse))[1]  # across the flow
    (dry,) = [line for line in right_of(axes.figure, axes).get_lines() if line.get_linestyle() == "--"]
    y, P = dry.get_data()
    load = float(ellipse["load"][-1]) / Geometry(0.2).hertz_load
    assert P == pytest.approx(Geometry(0.2, 30.0).dry_pressure(load, 0 * y, y))


# -- friction ---------------------------------------------------------------------------------------------------------


SLIDING = rolling(
    radius=0.01, load=38.885237, mean_speed=0.502636, slide_to_roll=0.2, E_prime=2.197802e11, oil=BARUS, nodes=81
)


def test_friction_in_time_shows_stress_loss_and_coefficients():
    data = in_time(SLIDING)
    data["mu_sliding"][:], data["mu_rolling"][:], data["power_loss"][:] = 0.04, 0.0005, 1.5
    stress, loss, coefficients, power = panels(plots.friction(data, at=2.0))[:4]
    assert stress.get_title().startswith("Shear stress, a line every ") and stress.get_title().endswith(" MPa")
    assert loss.get_title().endswith(" W/mm²")
    assert labelled(coefficients, "traction coefficient").get_ydata()[-1] == pytest.approx(0.04)
    right = right_of(coefficients.figure, coefficients)
    assert labelled(right, "rolling resistance coefficient").get_ydata()[-1] == pytest.approx(0.0005)
    watt = labelled(power, "power loss").get_ydata()[-1]
    assert watt == pytest.approx(1.5 * C1.power * (1e3 if "mW" in power.get_ylabel() else 1.0))


def test_without_sliding_there_is_no_stress_to_show():
    assert [axes.get_title().partition(",")[0] for axes in panels(plots.friction(in_time(BALL)))] == [
        "Power loss",
        "Coefficients of friction",
        "Power loss",
    ]
