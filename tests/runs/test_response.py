"""The response to waviness: of an impact, in lockstep and by the derivative of the run; of rolling, by one solve."""

from collections.abc import Callable
from functools import cache

import numpy as np
import pytest
import xarray as xr
from cases import OIL, SMALL, impact, rolled, steady_solver

from ertel.case.case import Case
from ertel.case.methods import METHODS
from ertel.case.sections import Drive
from ertel.inputs.case_files import parse_case
from ertel.inputs.python import quantity
from ertel.physics.lubricant import Oil
from ertel.physics.scales import Parameters
from ertel.physics.surfaces import Feature, RingWaviness, Shape, Waviness
from ertel.runs.response import respond, respond_in_rolling, respond_linearly

WAVE = 0.75  # wavelength: 8 nodes


def waviness(amplitude: float) -> list[Feature]:
    return [Feature(Waviness(amplitude, WAVE, WAVE))]


@cache
def impact_with(response: Callable[..., xr.Dataset], *amplitudes: float) -> xr.Dataset:
    solver, time = {"half_width": 1.5, "tolerance": 1e-6}, {"step": 0.04, "start_approach": -0.5}
    case = impact(200, 10, 33, solver=solver, time=time)
    return response(case, [waviness(amplitude) for amplitude in amplitudes])


def finite() -> xr.Dataset:
    return impact_with(respond, 0.0, 1e-3, 2e-3, 4e-3, -4e-3, -1e-3)


def test_no_roughness_no_response_and_waves_are_flattened_in_the_contact_only() -> None:
    """Where no pressure deforms the surface, dH = - roughness but for the ball's own shift."""
    data = finite()
    assert data.attrs["status"] == "converged"
    assert float(abs(data.dH[0]).max()) == 0.0
    assert float(abs(data.roughness[1]).max()) == pytest.approx(1e-3)
    change = (data.dH + data.roughness)[1].sel(X=slice(1.4, None), Y=slice(1.4, None))
    assert float(abs(change - change.mean()).max()) < 0.02 * 1e-3
    along = data.dH[1].sel(Y=0.0).sel(X=slice(-0.5, 0.5))
    assert 0.02 < float(along.max() - along.min()) / 2e-3 < 0.95
    data = finite()
    small, large = data.dH[1].values / 1e-3, data.dH[2].values / 2e-3
    assert np.abs(large - small).max() < 0.03 * np.abs(small).max()


def test_the_tangent_linear_run_is_the_limit_of_the_finite_ones() -> None:
    """(H(A) - H(-A))/(2 A) is within O(A^2) of the derivative: four times less height, far smaller difference."""
    exact = impact_with(respond_linearly, 1.0).dH[0].values
    dH = finite().dH.values
    errors = [np.abs((dH[i] - dH[j]) / (2 * A) - exact).max() for i, j, A in ((3, 4, 4e-3), (1, 5, 1e-3))]
    assert errors[1] < 2e-3 * np.abs(exact).max()
    assert errors[1] < errors[0] / 4


def test_rings_keep_the_impact_round() -> None:
    case = impact(200, 10, 33, time={"step": 0.05, "start_approach": -0.5})
    data = respond(case, [[Feature(RingWaviness(1e-3, 0.5))]])
    dH = data.dH[0].values
    np.testing.assert_allclose(dH, dH.T, atol=1e-9)
    np.testing.assert_allclose(dH, dH[::-1], atol=1e-9)


SHORT = {"step": 0.1, "start_approach": -0.5}


@pytest.mark.parametrize("response", [respond, respond_linearly])
def test_roughness_may_be_given_in_si(response: Callable[..., xr.Dataset]) -> None:
    case = parse_case({**SMALL, "time": SHORT, "solver": {"nodes": 33}})
    assert case.scales
    height, length = quantity("10 nm"), quantity("60 um")
    plain = Waviness(10e-9 / case.scales.film, 60e-6 / case.scales.a)
    found = response(case, [[Feature(Waviness(height, length))], [Feature(plain)]])
    assert float(abs(found.dH[0]).max()) > 0
    np.testing.assert_allclose(found.dH[0].values, found.dH[1].values, rtol=1e-6, atol=1e-12)


TURN = 1.5  # wavelength: 8 nodes


def rolling(drive: Drive | None = None) -> Case:
    return rolled(Parameters.from_moes(20, 5), OIL, steady_solver(33), drive)


def test_amplitude_and_phase_are_those_of_the_film_at_any_time() -> None:
    """Beside the contact the film is minus the roughness, but for the ball's motion and the far field of dP."""
    data = respond_in_rolling(rolling(), [[Feature(Waviness(0.01, TURN, TURN, phase_x=0.3))], []])
    assert data.attrs["status"] == "converged"
    assert data["H"].shape == (33, 33)
    assert float(data["frequency"][0]) == pytest.approx(2 * np.pi / TURN)
    assert float(data["dH_amplitude"][1].max()) == 0.0
    T = 0.37
    dH = (data["dH_amplitude"] * np.cos(data["frequency"] * T + data["dH_phase"]))[0].sel(Y=-3.0)
    height = 0.01 * np.cos(2 * np.pi / TURN * (data["X"] - T) + 0.3) * np.cos(2 * np.pi / TURN * 3.0)
    off = dH + height
    assert float(off.max() - off.min()) < 0.01 * 0.01
    dP = data["dP_amplitude"][0]
    assert float(dP.max()) > 0.01
    assert float(dP.where(data["P"] == 0).max()) == 0.0


def test_responses_add_up() -> None:
    """Two features of one frequency in one response, one of them on a surface that moves backwards."""
    case = rolling(Drive(slide_to_roll=4.0))  # speeds 3 and -1
    one, other = Feature(Waviness(0.01, 3 * TURN, TURN)), Feature(Waviness(0.02, TURN, TURN, phase_x=0.5), 2)
    data = respond_in_rolling(case, [[one, other], [one], [other]])
    both, *alone = data["dH_amplitude"].values * np.exp(1j * data["dH_phase"].values)
    assert np.abs(alone[1]).max() > 0.01
    assert np.abs(both - sum(alone)).max() < 1e-5 * 0.03
    with pytest.warns(UserWarning, match="there is no error estimate of the response"):
        data = respond_in_rolling(rolling(), [[Feature(Waviness(0.01, TURN, TURN))]])
    assert np.isnan(data["dH_error"].values).all()


@pytest.mark.slow
def test_an_unresolved_response_in_rolling_says_so() -> None:
    """On 257 nodes it is 0.53, on 65 nodes 0.65."""
    case = rolled(Parameters.from_moes(200, 10), Oil(), steady_solver(65, tolerance=0.03))
    with pytest.warns(UserWarning, match=r"^roughnesses\[1\]: the response at the centre is uncertain by up to 29%"):
        data = respond_in_rolling(case, [[Feature(Waviness(1.0, 1.0))]])
    assert data.attrs["status"] == "converged"
    assert float(data["dH_error"][0]) > abs(float(data["dH_amplitude"].sel(X=0, Y=0, method="nearest")[0]) - 0.53)


FALL, ALONG_R = impact(200, 10, 17, time=SHORT), impact(200, 10, 65, solver={"method": "radial"})
ROLLS, IN_TIME = rolling(), rolled(Parameters.from_moes(20, 5), OIL, METHODS["transient"].defaults)
FEATURE = r"^roughnesses\[1\]\[1\]."
IN_SI, WAVES = [Waviness(quantity("1 nm"), 0.5)], [Waviness(0.01, 0.5), Waviness(0.01, 1.0)]


@pytest.mark.parametrize(
    ("response", "case", "shapes", "message"),
    [
        (respond, FALL, IN_SI, f"{FEATURE}amplitude = .*: must be a plain number"),
        (respond_linearly, FALL, IN_SI, f"{FEATURE}amplitude = .*: must be a plain number"),
        (respond_in_rolling, ROLLS, [Waviness(0.01, quantity("5 um"))], r"^roughnesses\[1\]"),
        (respond, ALONG_R, WAVES, r'^solver\.method = "radial"'),
        (respond_in_rolling, IN_TIME, WAVES, r'^solver\.method = "transient": must be "steady"'),
        (respond_in_rolling, ROLLS, [RingWaviness(0.01, 0.5)], f"{FEATURE}shape = RingWaviness: must be a waviness"),
        (respond_in_rolling, ROLLS, [Waviness(0.01, 0.5, front=1.0)], f"{FEATURE}front = 1.0: must be infinite"),
        (respond_in_rolling, ROLLS, WAVES, r"^roughnesses\[1\]: .* 12\.5664, 6\.28319; must be the same"),
    ],
)
def test_what_has_no_response_is_refused_before_it_is_computed(
    response: Callable[..., xr.Dataset], case: Case, shapes: list[Shape], message: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("ertel.numerics.programs.Program.__call__", None)
    with pytest.raises(ValueError, match=message):
        response(case, [[Feature(shape) for shape in shapes]])
