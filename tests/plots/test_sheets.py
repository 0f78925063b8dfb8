"""Pictures for print: their size, their letters, axes of one's own, and what is refused."""

from dataclasses import replace

import numpy as np
import pytest
import xarray as xr
from made_up import BALL_FALLS, BALL_ROLLS, MOES_FALLS, as_in_time, dry_impact, in_time, steady
from matplotlib.figure import Figure
from matplotlib.text import Text

from ertel import Measurement, plots
from ertel.case.estimates import grid_of
from ertel.inputs.python import rolling
from ertel.physics.surfaces import Feature, Spot
from ertel.plots import interferograms
from ertel.results.dataset import assemble_steady
from ertel.runs.result import Plot
from ertel.runs.study_result import StudyResult

ROUGH = replace(as_in_time(BALL_ROLLS), roughness=(Feature(Spot(0.3, -0.05), 1),))
UNSOLVED = rolling(M=200, L=10, nodes=81)


@pytest.fixture(scope="module")
def runs():
    ball = dry_impact(BALL_FALLS)
    return {
        "ball": ball,
        "before": ball.isel(frame=slice(0, 30)),
        "no maps": ball.isel(frame=slice(0, 0)),
        "moes": dry_impact(MOES_FALLS, radial=True),
        "rough": in_time(ROUGH),
        "steady": steady(BALL_ROLLS),
        "no solution": assemble_steady(UNSOLVED, grid_of(UNSOLVED), ()),
    }


def study():
    """Films and friction over speed, temperature and oil."""
    dims, speeds, kelvin = ("mean_speed", "temperature", "oil"), np.geomspace(0.1, 3.0, 4), np.array([313.15, 353.15])
    film = 1e-7 * speeds[:, None, None] ** 0.67 * np.array([3.0, 1.0])[None, :, None] * np.array([1.0, 1.3])
    numbers = {"h_c": (film, "m"), "h_min": (0.6 * film, "m"), "mu_sliding": (0.05 + 0.0 * film, "1")}
    variables = {name: (dims, values, {"units": unit, "long_name": name}) for name, (values, unit) in numbers.items()}
    axes = {
        "mean_speed": ("mean_speed", speeds, {"units": "m/s"}),
        "temperature": ("temperature", kelvin, {"units": "K"}),
    }
    return xr.Dataset(variables, {**axes, "oil": ["PAO", "ester"]}, {"title": "speeds", "kind": "rolling"})


PRINTED = {
    "history": (1, lambda runs: plots.draw(runs["moes"], "history", columns=1)),
    "maps": (1, lambda runs: plots.draw(runs["rough"], "maps", columns=1)),
    "overview": (2, lambda runs: plots.draw(runs["ball"], "overview", columns=2)),
    "study": (2, lambda runs: StudyResult(study()).plot(columns=2)),
    "interferogram": (1, lambda runs: Plot(runs["ball"]).interferogram(columns=1)),
    "comparison": (1, lambda runs: plots.comparison([runs["ball"], runs["moes"]], ["one", "two"], columns=1)),
}


@pytest.mark.parametrize("name", PRINTED)
def test_texts_are_legible_and_apart(runs, name, monkeypatch):
    """In print: of 7 to 9 pt, inside of the picture, and none over another."""
    drawn, draw = [], Text.draw

    def noted(text, renderer):
        if text.get_text().strip() and text.get_visible():
            drawn.append((text.get_text(), text.get_fontsize(), text.get_window_extent(renderer)))
        draw(text, renderer)

    monkeypatch.setattr(interferograms, "PIXELS", 40)
    columns, picture = PRINTED[name]
    figure = picture(runs)
    monkeypatch.setattr(Text, "draw", noted)  # now, because it is drawn while it is arranged, too
    figure.draw_without_rendering()
    width, height = figure.bbox.size
    assert width / figure.dpi * 25.4 == pytest.approx(85.0 * columns)
    for number, (text, size, box) in enumerate(drawn):
        assert 7.0 <= size <= 9.0, text
        assert box.x0 > -1 and box.y0 > -1 and box.x1 < width + 1 and box.y1 < height + 1, text
        for other, _, there in drawn[:number]:
            overlap = min(box.x1, there.x1) - max(box.x0, there.x0), min(box.y1, there.y1) - max(box.y0, there.y0)
            assert min(overlap) < 1.0, (text, other)


def test_panels_in_axes_of_ones_own(runs):
    figure = Figure()
    left, right = figure.subplots(1, 2)
    assert Plot(runs["steady"]).film(ax=left, title=False) is figure
    assert left.get_xlabel() == "$x$ (µm)" and not left.get_title() and not figure.get_suptitle()
    assert not right.has_data()
    assert plots.profiles(runs["ball"], ax=[left, right]) is figure and right.has_data()


FILM = Measurement("profile", "h", [1.0, 2.0, 3.0], [0, 1e-5, 2e-5])
LIGHTS = "must be mono, white or a light of ertel.optics"


@pytest.mark.parametrize(
    ("run", "name", "options", "said"),
    [
        ("ball", "film", {"columns": 3}, "columns = 3: must be 1 or 2"),
        ("ball", "film", {"figsize": (85, 60)}, r"figsize = \(85, 60\): .*in inches"),
        ("ball", "film", {"columns": 1, "figsize": (3.0, 3.0)}, "give one of them"),
        ("ball", "profiles", {"ax": Figure().subplots()}, "ax: this picture has 2 panels"),
        *(("moes", "overview", {"at": at}, r'at = .*0\.05 to 3\.9 t0 .*has "max-approach"$')
          for at in (0.01, 3.91, "touch")),
        ("before", "front", {}, r"the front has no speed: .*before it"),
        ("rough", "front", {}, "a rolling contact has none"),
        ("no maps", "overview", {}, "no maps"),
        ("steady", "history", {}, r"history: a steady contact has no such figure; it has overview, .*maps"),
        ("no solution", "overview", {}, "no solution"),
        ("moes", "interferogram", {}, r"the run is dimensionless.*run a case in SI.*film_scale"),
        ("ball", "interferogram", {"light": "sunny"}, f"light = 'sunny': {LIGHTS}"),
        ("ball", "movie", {"what": "oil"}, "what = 'oil': must be one of film, pressure in a movie"),
        ("ball", "movie", {"rate": 0.5}, "rate = 0.5: must be from 1 to 50"),
        ("ball", "film", {"measured": FILM}, "film: does not show what is measured; profiles and midlines do"),
        ("ball", "profiles", {"measured": replace(FILM, quantity="intensity")}, "is a profile of intensity; this pict"),
        ("ball", "profiles", {"measured": replace(FILM, along="y")}, "measurement is along y; profiles are along x"),
    ],
)  # fmt: skip
def test_refused(runs, run, name, options, said):
    with pytest.raises(plots.NoFigure, match=said):
        getattr(plots, name)(runs[run], **options)
