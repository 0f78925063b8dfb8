"""Pictures of line contacts: along x and through time, over the dry contact; no maps."""

from pathlib import Path

import numpy as np
import pytest
from drawn import line, panels, right_of, words

import ertel
from ertel.plots import NoFigure
from ertel.results.figures import FIGURES_IN_TIME, FIGURES_OF_MAPS, FIGURES_STEADY, figures_of


@pytest.fixture(scope="module")
def runs(lines: Path) -> dict[str, ertel.Result]:
    return {name: ertel.open(lines / name) for name in ("steady", "impact")}


def test_no_maps_are_offered_or_drawn(runs: dict[str, ertel.Result]) -> None:
    without = (*FIGURES_OF_MAPS, "temperature")  # these have no heat
    for name, all_figures in (("steady", FIGURES_STEADY), ("impact", FIGURES_IN_TIME)):
        data = runs[name].dataset
        assert figures_of(data) == tuple(figure for figure in all_figures if figure not in without)
        assert not {*FIGURES_OF_MAPS, "interferogram"} & {*dir(runs[name].plot)}
        for figure in FIGURES_OF_MAPS:
            with pytest.raises(NoFigure, match=f"{figure}: a line contact has no such figure; it has overview"):
                ertel.plots.draw(data, figure)
        with pytest.raises(NoFigure, match="interferogram: a line contact has no maps; it has overview"):
            ertel.plots.interferogram(data, film_scale=1e-6)
    for movie in (ertel.plots.movie, lambda data: ertel.plots.animation(data, film_scale=1e-6)):
        with pytest.raises(NoFigure, match="animation: a line contact has no maps"):
            movie(runs["impact"].dataset)


def test_a_steady_contact_over_the_dry_one(runs: dict[str, ertel.Result]) -> None:
    figure = runs["steady"].plot.overview()
    section, grids, _ = panels(figure)
    hertz, pressure = (each.get_ydata() for each in right_of(section).get_lines())
    assert hertz.max() == pytest.approx(0.848163, rel=1e-3)  # GPa
    assert np.trapezoid(hertz, section.lines[0].get_xdata()) == pytest.approx(
        np.trapezoid(pressure, section.lines[0].get_xdata()), rel=0.01
    )
    assert words(section) == ["oil in the gap"]  # behind the contact it does not fill the gap
    assert [tick.get_text() for tick in grids.get_xticklabels()] == ["129", "∞"]
    assert "line contact, 10 mm long" in figure.get_suptitle() and "2 kN" in figure.get_suptitle()
    stress, loss = panels(runs["steady"].plot.friction())
    assert (stress.get_title(), loss.get_title()) == ("Shear stress", "Power loss per area")
    assert len(panels(runs["steady"].plot.midlines())) == 1


def test_an_impact_through_time(runs: dict[str, ertel.Result]) -> None:
    run = runs["impact"]
    film, through_time, _, pressure, _, _ = panels(run.plot.overview())
    assert words(film) == ["maximum approach", "rebound"]
    dry, load = line(pressure, "dry contact").get_ydata(), run.summary["F"]
    assert dry.max() == pytest.approx(np.sqrt(load), rel=1e-3)
    edge = line(through_time, "edge of the dry contact")
    touch, most = 1.0, run.case.parameters.hertz.contact_time / 2  # T at both: it starts at Delta = -1
    A, T = edge.get_xdata(), edge.get_ydata()
    assert np.nanmax(A) == pytest.approx(1.0, abs=1e-3) and T[np.nanargmax(A)] == pytest.approx(touch + most, abs=0.1)
    assert np.isnan(A[touch > T]).all() and np.isfinite(A[(touch + 0.01 < T) & (touch + 2 * most - 0.01 > T)]).all()
    speed = np.gradient(A, T)
    steady = (A > 0.5) & (touch + most - 0.5 > T)
    expected = [run.case.parameters.hertz.front_speed(a) for a in A[steady]]
    np.testing.assert_allclose(speed[steady], expected, rtol=0.02)
    for figure in ("profiles", "history", "front", "friction"):
        assert panels(ertel.plots.draw(run.dataset, figure))


def test_two_runs_side_by_side(runs: dict[str, ertel.Result]) -> None:
    impact = runs["impact"].dataset
    one, two = ertel.plots.side_by_side([impact, impact], "spacetime", at=("max-approach", "end"))
    assert panels(one)[0].get_xlim() == panels(two)[0].get_xlim()
    assert len(panels(ertel.plots.comparison([impact, runs["steady"].dataset], ["impact", "rolling"]))) == 2
