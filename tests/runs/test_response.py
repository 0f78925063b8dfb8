"""The response of an impact to waviness: small heights, lockstep, and the derivative of the whole run."""

from collections.abc import Callable
from functools import cache

import numpy as np
import pytest
import xarray as xr
from cases import impact

from ertel.physics.surfaces import Feature, RingWaviness, Waviness
from ertel.runs.response import respond, respond_linearly

WAVE = 0.5  # wavelength: 16 nodes


def waviness(amplitude: float) -> list[Feature]:
    return [Feature(Waviness(amplitude, WAVE, WAVE))]


@cache
def impact_with(response: Callable[..., xr.Dataset], *amplitudes: float) -> xr.Dataset:
    case = impact(
        200, 10, 65, solver={"half_width": 1.5, "tolerance": 1e-6}, time={"step": 0.02, "start_approach": -0.5}
    )
    return response(case, [waviness(amplitude) for amplitude in amplitudes])


def test_no_roughness_no_response() -> None:
    data = impact_with(respond, 0.0, 1e-3, 2e-3)
    assert data.attrs["status"] == "converged"
    assert float(abs(data.dH[0]).max()) == 0.0


def test_far_outside_the_surface_keeps_its_waves() -> None:
    """Where no pressure deforms it, dH = - roughness but for the ball's own shift."""
    data = impact_with(respond, 0.0, 1e-3, 2e-3)
    change = (data.dH + data.roughness)[1].sel(X=slice(1.4, None), Y=slice(1.4, None))
    assert float(abs(change - change.mean()).max()) < 0.02 * 1e-3
    assert float(abs(data.roughness[1]).max()) == pytest.approx(1e-3)


def test_the_response_is_proportional_to_a_small_height() -> None:
    data = impact_with(respond, 0.0, 1e-3, 2e-3)
    small, large = data.dH[1].values / 1e-3, data.dH[2].values / 2e-3
    assert np.abs(large - small).max() < 0.03 * np.abs(small).max()


def test_the_contact_flattens_the_waves() -> None:
    data = impact_with(respond, 0.0, 1e-3, 2e-3)
    along = data.dH[1].sel(Y=0.0).sel(X=slice(-0.5, 0.5))
    assert 0.02 < float(along.max() - along.min()) / 2e-3 < 0.95


def test_the_tangent_linear_run_is_the_limit_of_the_finite_ones() -> None:
    """(H(A) - H(-A))/(2 A) is within O(A^2) of the derivative: four times less height, far smaller difference."""
    exact = impact_with(respond_linearly, 1.0).dH[0].values
    finite = impact_with(respond, 4e-3, -4e-3, 1e-3, -1e-3)
    assert finite.attrs["status"] == "converged"
    dH = finite.dH.values
    errors = [np.abs((dH[i] - dH[i + 1]) / (2 * A) - exact).max() for i, A in ((0, 4e-3), (2, 1e-3))]
    assert errors[1] < 2e-3 * np.abs(exact).max()
    assert errors[1] < errors[0] / 4


def test_rings_keep_the_impact_round() -> None:
    case = impact(200, 10, 33, time={"step": 0.05, "start_approach": -0.5})
    data = respond(case, [[Feature(RingWaviness(1e-3, 0.5))]])
    dH = data.dH[0].values
    np.testing.assert_allclose(dH, dH.T, atol=1e-9)
    np.testing.assert_allclose(dH, dH[::-1], atol=1e-9)


def test_only_the_2d_method_has_waves() -> None:
    with pytest.raises(ValueError, match=r'^solver\.method = "radial"'):
        respond(impact(200, 10, 65, solver={"method": "radial", "nodes": 65}), [waviness(1e-3)])
