"""The figures for cylinders: the film that an impact leaves, the dry law, figures from made-up and from small runs."""

from dataclasses import replace

import numpy as np
import pytest
import xarray as xr
from boundary_layers import figures, line_reduction, line_runs, lines, runs
from boundary_layers.figures import PaperFigure
from boundary_layers.plans import QUICK, LinePlan
from boundary_layers.tasks import Task
from test_boundary_layers import drawn

from ertel.physics.dry_contact import HertzLine

M, L = 60.0, 10.0
PLACES = (0.7, 0.8, 0.9)
SMALL = replace(QUICK, lines=LinePlan((60, 150), (257, 513), (257, 513), {(150, 10): (0.4,)}, (0.5, 0.7, 0.9), PLACES))


@pytest.mark.slow
def test_an_impact_leaves_the_film_of_rolling_at_its_front():
    """Nothing is fitted: rho H(X) = A^2 q(lambda_bar v/A^4, alpha_bar A)."""
    impact = line_runs.line_impact(M, L, runs.USUAL, 257, runs.NO_MAPS)
    left = np.interp(PLACES, *lines.profile(impact, "left"))
    ratio = left / line_runs.rolled_oil(M, L, runs.USUAL, PLACES, 257)
    assert 0.93 < ratio[-1] < ratio[0] < 1.1


def test_the_time_of_the_dry_impact_of_a_cylinder():
    """pi kappa in the limit of a spring; its duration is that of the Hertz contact."""
    for length in lines.LENGTHS:
        T, A = lines.dry_impact(length)
        dry = HertzLine(length)
        assert -2 * T[0] == pytest.approx(dry.contact_time, rel=1e-5)
        assert (A[0], A[-1], T[-1]) == (0.0, 1.0, 0.0)
        assert np.gradient(A, T)[1000] == pytest.approx(dry.front_speed(A[1000]), rel=1e-3)


def left_by_a_front(factor):
    """An impact whose front moves as the edge of a dry one, and leaves this multiple of 1 - X/2."""
    X = np.linspace(-1.5, 1.5, 301)
    T, A = (values[::20] for values in lines.dry_impact(100.0))
    P = np.sqrt(np.maximum(A[:, None] ** 2 - X**2, 0.0))
    event = np.zeros(len(T), dtype=int)
    event[-1] = 1
    left = np.tile(factor * (1 - np.abs(X) / 2), (len(T), 1))
    data = {"P": (("frame", "X"), P), "left": (("frame", "X"), left), "H": (("frame", "X"), left)}
    data |= {"F": ("time", A**2), "X_min": ("time", A), "P_max": ("time", A), "event": ("frame", event)}
    return xr.Dataset(data, {"X": X, "time": T, "frame": T}, {"radius_ratio": 0.0, "length_ratio": 100.0})


def test_film_left_over_the_film_of_rolling():
    """Extrapolated over both grids; a front that moves as the dry one needs no other speed."""
    contact = (M, L, runs.USUAL)
    impacts = {contact: [left_by_a_front(1.04), left_by_a_front(1.01)]}
    rolled = {contact: [1 - each / 2 for each in PLACES]}
    made = line_reduction.film_left({"impacts": impacts, "rolled": rolled}, SMALL)
    rows = made.data["left"]
    assert rows["ratio"].to_numpy() == pytest.approx(1.0, abs=1e-6)
    assert rows["ratio, computed front"].to_numpy() == pytest.approx(1.0, abs=0.03)
    dry, _ = made.tables.values()
    assert list(dry.iloc[0]) == ["M = 60, L = 10, Roelands", *["1.000 ± 0.020"] * 3]


def test_waves_of_impact_and_rolling():
    """A wave of 0.5 on both grids, and rolling with 0.4 at all places."""
    wavelength, X = 0.4, np.linspace(-1.5, 1.5, 301)
    dH = 0.5 * np.cos(2 * np.pi * X / wavelength)
    name = runs.wave_name(line_runs.SHAPE, runs.HEIGHT, wavelength)
    wave = ("wave", "X"), [dH]
    impact = left_by_a_front(1.0)[["X_min", "P_max"]].assign_coords(X=X, frame=0.0, wave=[name])
    impact = impact.assign(dH=wave, shape=wave, H=("X", 0 * X))
    case, places = (150, 10), SMALL.lines.wave_places
    results = {"waves": {case: [impact, impact]}, "rolling": {case: {A: [[0.4], [0.4]] for A in places}}}
    waves = line_reduction.waves_reduced(results, SMALL).data["waves"]
    assert list(waves["X"].round(3)) == [0.5, 0.7]
    assert waves["limit"].to_numpy() == pytest.approx(0.5, rel=1e-3)
    assert waves["rolling_limit"].to_numpy() == pytest.approx(0.4)
    speed = lines.dry_speed(waves["X"])
    assert (waves["hertz"] / waves["everywhere"]).to_numpy() == pytest.approx(np.sqrt(waves["X"] / speed), rel=1e-6)
    deformed = line_reduction.deformed_waves(results["waves"], SMALL).data["dH"]
    assert list(deformed) == ["X", "H", "dH/A_i, wavelength 0.4"]


def test_the_figures_for_cylinders_have_a_page_of_their_own(monkeypatch, tmp_path):
    names = figures.names_of("lines")
    fails = PaperFigure("Title", lambda plan: [Task("bad", int, ("no number",))], line_reduction.film_left)
    monkeypatch.setattr(figures, "FIGURES", dict.fromkeys(figures.FIGURES, fails))
    file, missing = figures.make(names, True, tmp_path)
    assert file.name == "lines.html" and list(missing) == names == [f"line{n}" for n in range(1, 8)]
    with pytest.raises(ValueError, match="must be all, lines, fig1"):
        figures.names_of("line8")


@pytest.fixture(scope="module")
def done():
    return {}


@pytest.mark.slow
@pytest.mark.parametrize("name", figures.GROUPS["lines"])
def test_figures_for_cylinders(name, done):
    drawn(name, done, SMALL)
