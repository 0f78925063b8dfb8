"""Front and film of an impact: on made-up fields whose answer is known, and on one small run."""

import numpy as np
import pytest
import xarray as xr
from cases import impact

from ertel.physics import amplitude_reduction, hertz
from ertel.results import fronts
from ertel.runs.drive import simulate

TOUCH = 1.0
DEFINITIONS = ("film", "slope", "half-hertz")


def dry_impact(interval: float = 0.02, two_dimensional: bool = False) -> xr.Dataset:
    """The dry impact as if it were a run: Hertz' pressure, and a film that is least at the contact's edge."""
    end = TOUCH + hertz.HALF_CONTACT_TIME
    frames = np.append(np.arange(0.5, end, interval), end)
    A = hertz.contact_radius(frames - TOUCH)[:, None]
    X = np.linspace(-1.5, 1.5, 601) if two_dimensional else np.linspace(0.0, 1.5, 301)
    fields = {"P": np.sqrt(np.maximum(A**2 - X**2, 0.0)), "H": 0.01 + (np.abs(X) - A) ** 2}
    dims, axes = ("frame", "r"), {"r": X}
    if two_dimensional:
        dims, axes = ("frame", "Y", "X"), {"Y": np.array([-0.5, 0.0, 0.5]), "X": X}
        fields = {name: np.stack([0.3 * f, f, 0.3 * f], axis=1) for name, f in fields.items()}
    scalars = {"Delta": hertz.approach(frames - TOUCH), "X_min": A[:, 0], "Y_min": 0 * A[:, 0], "P_max": A[:, 0]}
    variables = {name: ("time", values) for name, values in scalars.items()}
    variables |= {name: (dims, f) for name, f in fields.items()}
    variables["event"] = "frame", (frames == end).astype(int)
    return xr.Dataset(variables, {"time": frames, "frame": frames, **axes})


@pytest.mark.parametrize("two_dimensional", [False, True])
@pytest.mark.parametrize("by", DEFINITIONS)
def test_front_of_the_dry_impact_follows_the_exact_law(by, two_dimensional):
    front = fronts.front(dry_impact(two_dimensional=two_dimensional), by)
    np.testing.assert_allclose(front.A, hertz.contact_radius(front.T - TOUCH), atol=0.008)
    inside = (front.A > 0.3) & (front.A < 0.98)
    tolerance = 2e-3 if by == "film" else 0.1
    np.testing.assert_allclose(front.speed[inside], hertz.front_speed(front.A[inside]), rtol=tolerance, atol=0.02)


def test_front_tells_when_it_passed_and_how_fast():
    front = fronts.front(dry_impact())
    X = np.array([0.4, 0.75, 0.95])
    np.testing.assert_allclose(front.passed(X), TOUCH + hertz.time_at(X**2), atol=2e-3)
    np.testing.assert_allclose(front.speed_at(X), hertz.front_speed(X), rtol=5e-3)
    assert np.isnan(front.speed_at(1.2)) and np.isnan(front.passed(0.01))


def test_front_from_maps_needs_maps():
    with pytest.raises(ValueError, match="too few times"):
        fronts.front(dry_impact(interval=10.0), "slope")


def test_amplitude_reduction():
    """Eq. (15), by the direction of the waves."""
    assert amplitude_reduction.ratio_left(0.0) == 1.0
    assert amplitude_reduction.ratio_left([10.0]) == pytest.approx([0.25])
    assert amplitude_reduction.ratio_left(2.0, 0.0) == amplitude_reduction.ratio_left(2.0)  # transverse: the same curve
    assert amplitude_reduction.ratio_left(2.0, 2.0) == amplitude_reduction.ratio_left(2.0 * np.exp(0.5))
    assert amplitude_reduction.ratio_left(2.0, np.inf) == amplitude_reduction.ratio_left(2.0 * np.e)
    with pytest.raises(ValueError, match=r"^ratio = -1"):
        amplitude_reduction.ratio_left(2.0, -1)


# -- a real run --------------------------------------------------------------------------------------------------------


def test_a_small_run():
    """The three definitions of its front agree, oil slows it, and the film at maximum approach follows its speed."""
    case = impact(1000, 10, 201, solver={"method": "radial", "half_width": 4.0}, output={"interval": 0.02})
    data = simulate(case).dataset
    X = np.linspace(0.55, 0.85, 7)
    speeds = np.array([fronts.front(data, by).speed_at(X) for by in DEFINITIONS])
    assert np.ptp(speeds, axis=0).max() < 0.1
    np.testing.assert_allclose(speeds, np.broadcast_to(hertz.front_speed(X), speeds.shape), rtol=0.2)
    assert (speeds < hertz.front_speed(X)).all()
    X = np.linspace(0.75, 0.95, 41)
    r, H = fronts.outwards(fronts.at_max_approach(data)["H"])
    constant = np.interp(X, r, H) / fronts.front(data).speed_at(X) ** 0.67
    assert np.std(constant) < 0.1 * np.mean(constant)
