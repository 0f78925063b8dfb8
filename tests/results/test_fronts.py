"""Front, film and waves of an impact: on made-up fields whose answer is known, and on one small run."""

import numpy as np
import pytest
import xarray as xr
from cases import impact

from ertel.physics import amplitude_reduction, film_formulas, hertz
from ertel.physics.scales import Parameters
from ertel.results import fronts, waves
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


def test_parabola_is_found_again_and_fits_the_dry_impact_with_the_papers_base():
    T = np.linspace(-1.0, 1.0, 41)
    assert fronts.fit_half_base(T, hertz.parabola_radius(T, 1.4)) == pytest.approx(1.4)
    T = np.linspace(-hertz.HALF_CONTACT_TIME, hertz.HALF_CONTACT_TIME, 2001)
    half_base = fronts.fit_half_base(T, hertz.contact_radius(T + hertz.HALF_CONTACT_TIME))
    assert 2.65 < 2 * half_base < 2.75  # the paper's 2.7


def test_film_left_behind_and_the_power_law_through_it():
    """H = 0.03 v^0.67 at maximum approach must give C = 0.03 with no deviation."""
    data = dry_impact()
    front, r = fronts.front(data), data["r"].values
    data["H"][-1] = 0.03 * np.nan_to_num(front.speed_at(r), nan=1.0) ** 0.67
    trace = fronts.film_behind_front(data, front, r[(r > 0.75) & (r < 1.2)])
    assert trace.X.max() <= 1.0  # the front never came farther
    C = fronts.fit_power(trace)
    assert pytest.approx(0.03, rel=1e-9) == C
    assert fronts.deviation(C * trace.speed**0.67, trace.H).worst < 1e-9
    assert fronts.deviation([1.1, 0.7], [1.0, 1.0]) == pytest.approx((-0.1, np.sqrt(0.05), 0.3))


def test_the_front_is_rolling_with_its_speed_in_the_hertz_contact_of_its_time():
    """A contact of radius A a* with the same oil and speed has the film that its own a and p_h give."""
    p = Parameters.from_moes(1000, 10)
    for v, A in ((1.0, 1.0), (0.3, 1.0), (0.5, 0.8)):
        own = Parameters(p.lambda_bar * v / A**4, p.alpha_bar * A)
        film = film_formulas.nijenbanning_venner_moes(own.M, own.L) * A**2
        assert fronts.film_from_speed(p, v, A) == pytest.approx(film)
        assert waves.local_nabla2(p, 0.3, v, A) == pytest.approx(own.nabla2(0.3 / A))
    assert fronts.film_from_speed(p, [0.3, 1.0], [0.9, 1.0]).shape == (2,)
    assert waves.local_nabla2(p, 0.3, 1.0) == pytest.approx(p.nabla2(0.3))


def test_ridges_that_a_front_left_behind():
    """Ridges of amplitude f(r) on a bell: what the bell has at either crest or trough is the same and drops out."""
    X = np.linspace(-1.5, 1.5, 241)
    Y, wavelength = X[:, None], 0.3
    radius = np.hypot(X, Y)
    dH = (1 - radius**2 / 2) * np.cos(2 * np.pi * X / wavelength) + np.exp(-(radius**2))
    r = np.array([0.1, 0.4, 0.8])
    found = waves.ridge_amplitude(X, X, dH, wavelength, r)
    assert np.isnan(found[0])  # no trough so near the centre
    np.testing.assert_allclose(found[1:], 1 - r[1:] ** 2 / 2, rtol=1e-4)


@pytest.mark.parametrize(("off", "errors", "rel"), [(0.0, 1.0, 1e-4), (0.3, [1.0, 0.001, 0.001, 0.001], 1e-2)])
def test_a_reduction_curve_is_found_again(off, errors, rel):
    """A point with a large error hardly bends it."""
    n = np.array([0.5, 1.0, 3.0, 9.0])
    found = waves.fit_reduction(n, amplitude_reduction.ratio_left(n) + off * (n == n[0]), errors)
    assert found == pytest.approx((0.15, 0.015), rel=rel)
    if off == 0.0:
        np.testing.assert_allclose(found.ratio(n), amplitude_reduction.ratio_left(n), rtol=1e-6)


def test_amplitude_reduction():
    """Eq. (15), and that the line contact's parameter is that of the same wavelength in the same Hertz contact."""
    assert amplitude_reduction.ratio_left(0.0) == 1.0
    assert amplitude_reduction.ratio_left([10.0]) == pytest.approx([0.25])
    assert amplitude_reduction.ratio_left(2.0, 0.0) == amplitude_reduction.ratio_left(2.0)  # transverse: the same curve
    assert amplitude_reduction.ratio_left(2.0, 2.0) == amplitude_reduction.ratio_left(2.0 * np.exp(0.5))
    assert amplitude_reduction.ratio_left(2.0, np.inf) == amplitude_reduction.ratio_left(2.0 * np.e)
    with pytest.raises(ValueError, match=r"^ratio = -1"):
        amplitude_reduction.ratio_left(2.0, -1)
    W, U, G = 1e-4, 1e-11, 4000.0  # of a line contact; U of the sum speed
    M, L = W / np.sqrt(U), G * U**0.25
    lambda_bar, alpha_bar = 3 * np.pi**2 / 8 / M**2, G * np.sqrt(W / (2 * np.pi))
    nabla1, nabla2 = 0.3 * M**0.75 / L**0.5, 0.3 * 2 / np.sqrt(alpha_bar * lambda_bar)
    assert nabla1 / nabla2 == pytest.approx(amplitude_reduction.LINE_NABLA, rel=1e-4)
    first, later = 1 / (1 + 0.17 * nabla1 + 0.03 * nabla1**2), 1 / (1 + 0.125 * nabla1 + 0.04 * nabla1**2)
    assert amplitude_reduction.in_line_contact(nabla2) == pytest.approx(first, 1e-4)
    assert amplitude_reduction.in_line_contact(nabla2, amplitude_reduction.LINE_REFIT) == pytest.approx(later, 1e-4)


def test_waves_of_a_cosine():
    X = np.linspace(-1.5, 1.5, 301)  # 20 nodes a wave, crests between nodes
    dH = -0.7 * np.cos(2 * np.pi * (X - 0.003) / 0.2)
    assert [wave.amplitude for wave in waves.waves(X, dH)] == pytest.approx([0.7] * 8, rel=1e-3)
    last = waves.last_wave(X, dH)
    assert (last.start, last.end, last.X) == pytest.approx((0.753, 0.953, 0.853), abs=1e-3)


def test_the_last_wave_lies_wholly_inside():
    """Beyond the edge the waves keep their full height: none of it may count."""
    X = np.linspace(0.0, 1.5, 601)
    dH = np.where(X < 0.97, 0.4, 1.0) * np.sin(2 * np.pi * X / 0.2)
    assert waves.last_wave(X, dH).amplitude == pytest.approx(0.4, rel=1e-2)
    assert waves.last_wave(X, dH, edge=0.85).end < 0.85
    with pytest.raises(ValueError, match="no complete wave"):
        waves.last_wave(X, dH, edge=0.15)


def test_amplitude_of_waves_that_fade_outwards():
    X = np.linspace(0.0, 1.2, 961)
    found = waves.waves(X, (1 - X) * np.cos(2 * np.pi * X / 0.1))
    np.testing.assert_allclose([w.amplitude for w in found], [1 - w.X for w in found], rtol=0.05)


def test_a_small_run():
    """The three definitions of its front agree, oil slows it, and the film at maximum approach follows its speed."""
    case = impact(1000, 10, 201, solver={"method": "radial", "half_width": 4.0}, output={"interval": 0.02})
    data = simulate(case).dataset
    X = np.linspace(0.55, 0.85, 7)
    speeds = np.array([fronts.front(data, by).speed_at(X) for by in DEFINITIONS])
    assert np.ptp(speeds, axis=0).max() < 0.1
    np.testing.assert_allclose(speeds, np.broadcast_to(hertz.front_speed(X), speeds.shape), rtol=0.2)
    assert (speeds < hertz.front_speed(X)).all()
    trace = fronts.film_behind_front(data, fronts.front(data), np.linspace(0.75, 0.95, 41))
    C = fronts.fit_power(trace)
    assert fronts.deviation(C * trace.speed**0.67, trace.H).rms < 0.1
    assert fronts.deviation(fronts.film_from_speed(case.parameters, trace.speed), trace.H).rms < 0.2
