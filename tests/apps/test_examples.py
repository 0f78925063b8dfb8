"""The examples run: each case file loads, each script gives the number that it is about."""

import importlib.util
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import ertel
from ertel.case.estimates import grid_of
from ertel.equations import discretise
from ertel.inputs.case_files import load_case
from ertel.inputs.studies import load_study
from ertel.results.diagnostics import case_warnings
from ertel.results.parameters import formula_films

EXAMPLES = Path(__file__).parents[2] / "examples"


def script(name):
    spec = importlib.util.spec_from_file_location(name, EXAMPLES / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


BALL = 0.0113732484076433, 28.3409466485018, 1417047332.42509, 3.7214539925301e-05, 123477183.938577, 1.24005218274667
PARAMETERS = {  # lambda_bar, alpha_bar, p_h (Pa), t0 (s), eta/eta0 and rho/rho0 at P = 1, by version 0.1.0
    "high_load": (5.09541362851802e-05, 78.5019684685223, None, None, 2.48163876654357e17, 1.29175879931444),
    "impact_on_rolling_track": BALL,
    "micro_cavity": (
        *(0.0430775699287087, 8.42665917786791, 383029962.63036, 0.00151934863220241),
        *(530.900450788247, 1.13383985313492),
    ),
    "moes_impact": (0.00109777358813405, 36.4373860260115, None, None, 5897136418.34051, 1.25069539781653),
    "reversal": (0.0236508150007676, 8.45636820521867, None, None, 969.50476251269, 1.13412557398946),
    "rolling": (
        *(0.00933188765332427, 21.3114089927171, 968700408.759869, 0.000276936849979739),
        *(2621431.72972813, 1.2113030426677),
    ),
    "steel_ball_impact": BALL,
}


@pytest.mark.parametrize("name", PARAMETERS)
def test_case_files_mean_what_they_always_did(name):
    case = load_case(EXAMPLES / f"{name}.toml")
    oil, scales = case.lubricant, case.scales
    found = [case.parameters.lambda_bar, case.parameters.alpha_bar, scales and scales.p_h, scales and scales.t0]
    found += [float(oil.viscosity(1.0)), float(oil.density(1.0))]
    assert found == [value and pytest.approx(value, rel=1e-13) for value in PARAMETERS[name]]


def test_studies_load():
    found = {path.stem: len(load_study(path).cases) for path in (EXAMPLES / "sweeps").glob("*.toml")}
    assert found == {"film_and_speed": 10, "wet_restitution": 25}
    for name in ("rough_impact", "rough_rolling"):
        assert not [text for text in case_warnings(load_case(EXAMPLES / f"{name}.toml")) if "roughness" in text]


@pytest.mark.slow
def test_wet_restitution(tmp_path):
    """The slowest ball on the thinnest and on the thickest layer, on fewer nodes."""
    coarse = ["solver.nodes=65", "time.tolerance=1e-3"]
    ends = ["contact.speed='0.1 m/s'", "lubricant.layer=['3 um', '48 um']", *coarse]
    found = ertel.sweep(EXAMPLES / "sweeps/wet_restitution.toml", tmp_path, overrides=ends).dataset
    assert found["restitution"].values.ravel() == pytest.approx([0.757, 0.430], abs=0.01)
    assert found["t_contact"].values.ravel() == pytest.approx([8.9e-5, 3.3e-4], rel=0.03)
    assert found["f_max"].values.ravel() == pytest.approx([15.97, 8.96], rel=0.02)


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::UserWarning:own_lubricant")
def test_own_lubricant():
    """Less stiff than Roelands' at high pressure, the oil flees for longer: the trapped film is thinner."""
    roelands, power = script("own_lubricant").central_films(nodes=33)
    assert roelands == pytest.approx(0.1456, rel=0.005)
    assert 0.5 * roelands < power < roelands


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::UserWarning")
def test_thinning_film():
    """The Newtonian film does not depend on sliding; that of squalane, which thins, falls with it."""
    example = script("thinning_film")
    example.SLIDING = [0.0, 1.5]
    films = {name: curve.dataset["h_c"].values for name, curve in example.curves(nodes=33).items()}
    assert films["newtonian"][1] == pytest.approx(films["newtonian"][0], rel=1e-12)
    assert films["carreau"][0] < films["newtonian"][0]
    assert films["carreau"][1] < 0.98 * films["carreau"][0]


@pytest.mark.slow
def test_interferogram():
    """The fringes give the film back under which they were seen, on so coarse a grid too."""
    example = script("interferogram")
    computed, seen = example.films(example.impact(nodes=65))
    assert computed.min() == pytest.approx(580e-9, rel=0.01)
    assert seen == pytest.approx(computed, abs=1e-12)


@pytest.mark.slow  # skewed and long ellipses have quick tests in solvers
@pytest.mark.filterwarnings("ignore:H_min is uncertain:UserWarning")
@pytest.mark.parametrize(
    ("name", "nodes", "key", "formula", "least", "most"),
    [
        ("squalane", 65, "H_c_extrapolated", "Nijenbanning", 0.85, 1.15),  # an oil and materials by name
        # on so small a grid the film is too thin
        ("skewed_ellipse", 33, "H_c", "Chittenden", 0.6, 1.1),
        ("ball_bearing", 65, "H_c", "Chittenden", 0.6, 1.1),
        ("gear_flanks", 65, "H_c", "Chittenden", 0.6, 1.1),
    ],
)
def test_films_are_of_the_size_of_a_formula(name, nodes, key, formula, least, most):
    case = load_case(EXAMPLES / f"{name}.toml", [f"solver.nodes={nodes}"])
    summary = ertel.simulate(case).summary
    expected = next(film.central for film in formula_films(case) if film.name.startswith(formula))
    assert summary["status"] == "converged"
    assert least * expected < summary[key] < most * expected


@pytest.mark.slow  # whole planes; rough runs have quick tests in runs
@pytest.mark.parametrize(("name", "until"), [("rough_impact", 0.2), ("rough_rolling", 0.05)])
@pytest.mark.filterwarnings("ignore::UserWarning")
def test_rough_examples(name, until):
    """They begin as they should: the film feels the hills, and nothing touches."""
    short = ["solver.nodes=33", f"time.until={until}", "time.tolerance=0.01"]
    case = load_case(EXAMPLES / f"{name}.toml", short)
    rough, smooth = (ertel.simulate(each) for each in (case, replace(case, roughness=())))
    assert rough.summary["status"] == smooth.summary["status"] == "converged"
    films = [run.dataset["H"].isel(frame=-1).values for run in (rough, smooth)]
    assert films[0].min() > 0
    assert np.abs(films[0] - films[1]).max() > 0.02 * case.film_scale
    grid = grid_of(case)
    heights = np.asarray(discretise.heights(case.features, case, grid, until))
    assert np.corrcoef((films[1] - films[0]).ravel(), heights.ravel())[0, 1] > 0.9
