"""Pictures of steady rolling contacts: made-up fields, of which everything is known."""

from dataclasses import replace

import numpy as np
import pytest
from drawn import line, of_type, panels, right_of
from made_up import BALL_ROLLS as BALL
from made_up import C1, H_C, solutions, steady, with_temperature

from ertel import plots
from ertel.physics import hertz
from ertel.plots.view import View
from ertel.results.diagnostics import film_errors


@pytest.fixture(scope="module")
def ball():
    return steady(BALL)


@pytest.mark.parametrize("layer", [None, 1e-7])
def test_error_bars_are_those_of_the_summary(ball, layer):
    """And the last two of three grids may differ little by chance: the change before is a bound."""
    case = replace(BALL, oil=replace(BALL.oil, layer=layer))
    found = film_errors(case, solutions(case))
    for name in ("H_c", "H_min") if layer is None else ():
        first, *_, last = View(ball).on_grids(name)
        assert last == pytest.approx(found[name]) and np.isnan(first.error)
    *others, before, last = solutions(case)
    near = replace(last, values={**last.values, "H_c": before.values["H_c"] + 1e-5})
    lucky = film_errors(case, (*others, before, near))["H_c"]
    assert lucky.error == pytest.approx((H_C[1] - H_C[0]) / 12)


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


def test_temperature_across_the_film(ball):
    """The mesh lies between surface 2 at zero and surface 1 on the film; the lines are those of the surfaces."""
    across, along = panels(plots.temperature(with_temperature(ball)))
    (mesh,) = of_type(across, "QuadMesh")
    loaded = ball["P"].values[64] > 1e-6 * ball["P"].values.max()
    film = ball["H"].values[64, loaded] * C1.film * 1e9
    np.testing.assert_allclose(mesh.get_coordinates()[..., 1], np.outer([0.0, 0.5, 1.0], film))
    colours = mesh.get_array().reshape(3, -1)
    for label, row, hottest in (("surface 2", 0, 46.85), ("surface 1", 2, 36.85)):  # degC
        drawn = line(along, label).get_ydata()
        assert drawn.max() == pytest.approx(hottest)
        np.testing.assert_allclose(colours[row], drawn[loaded])
    assert across.get_ylabel() == "$z$ (nm)" and across.get_xlim() == along.get_xlim()
