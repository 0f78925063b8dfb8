"""Waviness at rest under a sliding oil: how its ripples are told from other waves, and Hooke's linear theory."""

from functools import cache
from math import inf, pi, sqrt
from typing import Any

import numpy as np
import pytest
import ripples
import xarray as xr
from ripples import SlidingWaviness

from ertel.case.case import Case
from ertel.inputs.python import Oil, rolling
from ertel.physics.fluidity import Fluidity, ReeEyring
from ertel.runs.response import respond_in_rolling


def case(law: Fluidity | str = "newtonian", nodes: int = 65, alpha: float = 20e-9, **changes: Any) -> Case:
    """A wavy surface at rest under 1 m/s: the other surface slides with 2 m/s."""
    oil = Oil(eta0=0.04, alpha=alpha, **changes)
    ball = {"radius": 0.01, "E_prime": 226e9, "load": 20.0, "mean_speed": 1.0, "slide_to_roll": -2.0, "oil": oil}
    return rolling(**ball, rheology=law, nodes=nodes, half_width=2.0, inlet=2.5)


def test_a_ripple_is_told_from_slow_changes() -> None:
    """dH = - a exp(i k X) (1 + 0.2 X) + 0.3 - 0.1 X, a complex, at the cosine and at the sine."""
    X = np.linspace(-2.0, 2.0, 129)
    share, length = 0.4 * np.exp(0.7j), 0.5
    dH = -share * np.exp(2j * pi / length * X) * (1.0 + 0.2 * X) + 0.3 - 0.1 * X
    waves = np.stack([np.zeros_like(X), dH.real, dH.imag])[:, None, :]
    amplitude, phase = ("wave", "Y", "X"), np.where(waves < 0, pi, 0.0)
    fields = {f"{name}_amplitude": (amplitude, np.abs(waves)) for name in ("dH", "dP")}
    fields |= {f"{name}_phase": (amplitude, phase) for name in ("dH", "dP")}
    found = ripples.ripples(xr.Dataset(fields, {"Y": [0.0], "X": X}), 1, length)
    assert found.clearance == pytest.approx(share, rel=1e-9)
    assert found.pressure == found.clearance


def middle(P: float = 1.0, H: float = 0.2) -> xr.Dataset:
    return xr.Dataset({"P": (("Y", "X"), [[P]]), "H": (("Y", "X"), [[H]])}, {"Y": [0.0], "X": [0.0]})


def test_the_middle_of_a_contact() -> None:
    """The slope of Eyring's law is eta/(1 + B^2)^{1/2}; of Dowson and Higginson's the bulk modulus is known."""
    thin, thick = case(ReeEyring(5e6)), case(density="incompressible")
    at, newtonian = ripples.centre(thin, middle()), ripples.centre(thick, middle())
    assert (at.film, at.pressure, at.lag) == (0.2 * thin.scales.film, thin.scales.p_h, -1.0)
    assert newtonian.viscosity == pytest.approx(newtonian.newtonian, rel=1e-9)
    assert newtonian.newtonian == pytest.approx(0.04 * thin.oil.viscosity_law.viscosity(at.pressure), rel=1e-12)
    B = 2 * at.newtonian / (at.film * 5e6)
    assert B > 1000
    assert at.viscosity == pytest.approx(at.newtonian / sqrt(1 + B**2), rel=1e-7)
    x = at.pressure / 5.9e8
    assert at.bulk_modulus == pytest.approx(5.9e8 * (1 + x) * (1 + 1.34 * x) / 0.34, rel=1e-5)
    assert newtonian.bulk_modulus == inf


def test_the_theory_needs_a_surface_at_rest() -> None:
    with pytest.raises(ValueError, match=r"^slide_to_roll = 0\.0: must be -2"):
        ripples.centre(rolling(M=20, L=5, nodes=65), middle())


@cache
def found(law: Fluidity | str, nodes: int, length: float, **oil: Any) -> tuple[SlidingWaviness, SlidingWaviness, float]:
    """Computed, by the theory, and Q."""
    chosen = case(law, nodes, **oil)
    data = respond_in_rolling(chosen, ripples.pair(length))
    assert data.attrs["status"] == "converged"
    at = ripples.centre(chosen, data)
    number = ripples.hooke_number(chosen, at, length)
    return ripples.ripples(data, 0, length), ripples.hooke(chosen, at, length), number


@pytest.mark.slow
@pytest.mark.parametrize(
    ("tau0", "alpha", "Q"),
    [(None, 20e-9, 2370), (5e6, 20e-9, 0.73), (1e6, 20e-9, 0.33), (None, 4e-9, 2.6), (1e6, 4e-9, 1.1)],
)
def test_ripples_follow_hookes_theory(tau0: float | None, alpha: float, Q: float) -> None:
    """Sixteen nodes in a wave of half the contact's radius: within 0.03 of the waves' height and 0.1 in the phase."""
    computed, theory, number = found("newtonian" if tau0 is None else ReeEyring(tau0), 129, 0.5, alpha=alpha)
    assert number == pytest.approx(Q, rel=0.05)
    assert abs(computed.clearance - theory.clearance) < 0.08
    assert abs(abs(computed.clearance) - abs(theory.clearance)) < 0.03
    assert abs(computed.pressure) == pytest.approx(abs(theory.pressure), rel=0.12)


@pytest.mark.slow
def test_eyrings_oil_leaves_the_waves_that_a_newtonian_oil_flattens() -> None:
    """The same contact and the same viscosity at rest: 0.75 and 0.13 of the height."""
    left, flattened = (found(law, 129, 0.5, alpha=20e-9)[0].clearance for law in (ReeEyring(5e6), "newtonian"))
    assert abs(left) > 5 * abs(flattened)


# -- Hooke ------------------------------------------------------------------------------------------------------------


def waviness(lag: float, bulk: float = float("inf")) -> tuple[complex, complex]:
    return ripples.hooke_waviness(100e-6, 200e-9, 226e9, effective_viscosity=10.0, lag=lag, bulk_modulus=bulk)


def test_waviness_stays_where_the_oil_carries_it() -> None:
    assert waviness(0.0) == (1.0, 0.0)


def test_fast_waviness_is_flattened_elastically() -> None:
    """Q -> infinity without compressibility: no ripple of the film, pressure ripple w E'/4."""
    clearance, pressure = waviness(1e9)
    assert abs(clearance) < 1e-6
    assert abs(pressure) == pytest.approx(2 * pi / 100e-6 * 226e9 / 4, rel=1e-9)


def test_compressible_oil_leaves_a_ripple() -> None:
    clearance, _ = waviness(1e9, bulk=5e9)
    C = 200e-9 * 226e9 * 2 * pi / 100e-6 / (4 * 5e9)
    assert abs(clearance) == pytest.approx(C / (1 + C), rel=1e-6)


def test_ripples_of_film_and_of_pressure_add_up_to_the_waviness() -> None:
    """The pressure ripple flattens the waviness by 4 p/(w E'), in its own phase."""
    for lag in (1e-3, 1e-2, -0.3):
        clearance, pressure = waviness(lag, bulk=5e9)
        assert abs(clearance - 4 / (2 * pi / 100e-6 * 226e9) * pressure - 1.0) < 1e-12
