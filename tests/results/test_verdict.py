"""The lambda ratio and the verdict of a run, from hand-made numbers."""

from math import hypot
from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr
from made_up import BALL_ROLLS, C1, MOES_ROLLS

import ertel
from ertel.physics.amplitude_reduction import lambda_ratio
from ertel.results.parameters import parameters_of, scale_values
from ertel.results.result import lambda_of, verdict

FILM = {"H_c": 341e-9, "H_min": 200e-9, "H_c_error": 15e-9, "H_min_error": 8e-9}


def rolled(case=BALL_ROLLS, dataset=None, **more):
    """A steady run with known films, of which the case has the scales."""
    films = {name: value / C1.film for name, value in FILM.items()}
    films |= {f"{name}_extrapolated": films[name] for name in ("H_c", "H_min")}
    si = {"si": scale_values(case)} if case.scales else {}
    summary = {"kind": "rolling", **parameters_of(case), **films, "mu_sliding": -0.047, **si, **more}
    return SimpleNamespace(case=case, dataset=dataset, summary=summary)


def test_the_line_has_what_the_run_has():
    assert verdict(rolled()) == "film 341 ± 15 nm, mu = 0.047"
    assert verdict(rolled(), "60 nm", 80e-9) == "film 341 ± 15 nm, Lambda = 2, mu = 0.047"
    assert verdict(rolled(H_c_error=None, mu_sliding=0.0)) == "film 341 nm"
    assert verdict(rolled(H_c=None)) == ""
    assert verdict(rolled(MOES_ROLLS)).startswith("film 0.") and "mu" not in verdict(rolled(MOES_ROLLS))


def test_with_heat_the_film_and_the_friction_are_the_warm_ones():
    thermal = {"h_c_m": 300e-9, "h_min_m": 180e-9, "mu_sliding": 0.031, "T_film_mean_K": 324.0}
    result = rolled(thermal=thermal)
    result.case = SimpleNamespace(features=(), scales=C1, thermal=SimpleNamespace(temperature=313.0))
    assert verdict(result) == "film 300 nm, mu = 0.031, 11 K"


def test_the_lambda_ratio():
    assert lambda_ratio(3.0, 1.0) == 3.0 and lambda_ratio(5.0, 3.0, 4.0) == 1.0
    assert lambda_of(rolled(), "60 nm", "80 nm") == pytest.approx(2.0)
    with pytest.raises(ValueError, match="sigma = -1: must not be negative"):
        lambda_ratio(1.0, -1.0)
    with pytest.raises(ValueError, match="sigma_1: missing"):
        lambda_of(rolled())
    with pytest.raises(ValueError, match="lambda ratio: the case is dimensionless"):
        lambda_of(rolled(MOES_ROLLS), "20 nm")
    with pytest.raises(ValueError, match="unit"):
        lambda_of(rolled(), "20")


def test_a_rough_surface_brings_its_own():
    """A map with a given rms on each surface; the film is the mean with the pressure as weight."""
    heights = np.random.default_rng(0).normal(size=(16, 16))
    maps = [ertel.Measured.of(each * 40e-9, 5e-6) for each in (heights, heights / 2)]
    rough = [ertel.Feature(shape, surface) for surface, shape in enumerate(maps, 1)]
    ball = {"radius": 0.01, "load": 38.885237, "mean_speed": 0.502636, "E_prime": 2.197802e11}
    case = ertel.rolling(**ball, oil=BALL_ROLLS.oil, nodes=81, roughness=rough, method="transient", until=1.0)
    H, P = np.array([[[1.0, 2.0], [4.0, 9.0]]]), np.array([[[0.0, 3.0], [1.0, 0.0]]])
    data = xr.Dataset(
        {"H": (("frame", "Y", "X"), H), "P": (("frame", "Y", "X"), P), "event": ("frame", [2])}, {"frame": [1.0]}
    )
    sigma = hypot(heights.std(), heights.std() / 2) * 40e-9
    assert lambda_of(rolled(case, data)) == pytest.approx(2.5 * C1.film / sigma, rel=1e-3)
    assert f"Lambda = {2.5 * C1.film / sigma:.2g}" in verdict(rolled(case, data))
