"""The paper's laws and its waves: as the paper writes them, on made-up fields whose answer is known."""

from typing import get_args

import numpy as np
import pytest
import xarray as xr
from boundary_layers import theory, waves
from hypothesis import given
from hypothesis import strategies as st
from made_up import FIRST_TOUCH, dry_front
from numpy.testing import assert_allclose

import ertel
from ertel import Parameters, amplitude_reduction, fronts, hertz

HALF = hertz.HALF_CONTACT_TIME


@given(st.floats(0.2, 5.0), st.floats(-0.999, 0.999))
def test_asymptotes_as_the_paper_writes_them(t_star, share):
    t = share * t_star
    assert theory.johnson_radius(t, t_star) == pytest.approx(np.sqrt(np.cos(np.pi * t / (2 * t_star))))
    assert theory.parabola_radius(t, t_star) == pytest.approx(np.sqrt(1 - share**2))
    assert t_star * theory.linear_front_speed(t, t_star) == pytest.approx(-share)
    if -0.95 < share < -0.01:
        by_place = theory.parabola_front_speed(theory.parabola_radius(t, t_star), t_star)
        assert t_star * by_place == pytest.approx(-share / np.sqrt(1 - share**2), rel=1e-9)


def test_how_near_the_asymptotes_come_to_the_exact_motion():
    """Johnson's cosine misses Delta by 2.1 % at most, the parabola A by 1.2 % in the central 70 %."""
    T = np.linspace(-HALF, HALF, 4001)
    exact = hertz.approach(T + HALF)
    assert np.max(np.abs(theory.johnson_radius(T) ** 2 - exact)) == pytest.approx(0.0213, abs=1e-4)
    central = np.abs(T) < 0.7 * HALF
    assert np.max(np.abs(theory.parabola_radius(T) - np.sqrt(exact))[central]) == pytest.approx(0.0119, abs=1e-4)


def test_asymptotes_end():
    assert_allclose(theory.parabola_front_speed([0.0, -0.5, 1.5]), [np.inf, np.nan, np.nan])
    for radius in (theory.johnson_radius, theory.parabola_radius):
        assert_allclose(radius([-9.0, 9.0]), 0.0, atol=2e-8)


def test_parabola_is_found_again_and_fits_the_dry_impact_with_the_papers_base():
    T = np.linspace(-1.0, 1.0, 41)
    assert theory.fit_half_base(T, theory.parabola_radius(T, 1.4)) == pytest.approx(1.4)
    T = np.linspace(-HALF, HALF, 2001)
    half_base = theory.fit_half_base(T, hertz.contact_radius(T + HALF))
    assert 2.65 < 2 * half_base < 2.75  # the paper's 2.7


def test_film_left_behind_and_the_power_law_through_it():
    """H = 0.03 v^0.67 at maximum approach must give C = 0.03 with no deviation."""
    X = np.linspace(0.0, 1.5, 301)
    front = fronts.Front(hertz.time_at(X[60:201] ** 2), X[60:201], hertz.front_speed(X[60:201]))
    H = 0.03 * np.nan_to_num(front.speed_at(X), nan=1.0) ** 0.67
    map_ = xr.Dataset({"H": ("r", H)}, {"r": X})
    trace = theory.film_behind_front(map_, front, X[(X > 0.75) & (X < 1.2)])
    assert 0.98 < trace.X.max() <= 1.0  # the front never came farther
    inside = theory.Trace(*(values[:-1] for values in trace))  # it stands still at the end
    C = theory.fit_power(inside)
    assert pytest.approx(0.03, rel=1e-9) == C
    assert theory.deviation(C * inside.speed**0.67, inside.H).worst < 1e-9
    assert theory.deviation([1.1, 0.7], [1.0, 1.0]) == pytest.approx((-0.1, np.sqrt(0.05), 0.3))


def test_the_front_is_rolling_with_its_speed_in_the_hertz_contact_of_its_time():
    """A contact of radius A a* with the same oil and speed has the film that its own a and p_h give."""
    p = Parameters.from_moes(1000, 10)
    for v, A in ((1.0, 1.0), (0.3, 1.0), (0.5, 0.8)):
        own = Parameters(p.lambda_bar * v / A**4, p.alpha_bar * A)
        film = ertel.formulas.nijenbanning_venner_moes(own.M, own.L) * A**2
        assert theory.film_from_speed(p, v, A) == pytest.approx(film)
        assert waves.local_nabla2(p, 0.3, v, A) == pytest.approx(own.nabla2(0.3 / A))
    assert theory.film_from_speed(p, [0.3, 1.0], [0.9, 1.0]).shape == (2,)
    assert waves.local_nabla2(p, 0.3, 1.0) == pytest.approx(p.nabla2(0.3))


def test_the_film_from_the_speed_of_the_front_of_a_line_is_that_of_a_line():
    p, v, A = ertel.impact(M=100, L=10, radius_ratio=0).parameters, 0.2, 0.8
    local = type(p)(p.lambda_bar * v / A**4, p.alpha_bar * A)
    film = A**2 * ertel.line_formulas.expected_line_film(local)
    assert float(theory.film_from_speed(p, v, A)) == pytest.approx(film)
    assert float(waves.local_nabla2(p, 0.2, v, A)) == pytest.approx(local.nabla2(0.2 / A))


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


def test_amplitudes_in_a_line_contact():
    """Its parameter is that of the same wavelength in the same Hertz contact."""
    W, U, G = 1e-4, 1e-11, 4000.0  # of a line contact; U of the sum speed
    M, L = W / np.sqrt(U), G * U**0.25
    lambda_bar, alpha_bar = 3 * np.pi**2 / 8 / M**2, G * np.sqrt(W / (2 * np.pi))
    nabla1, nabla2 = 0.3 * M**0.75 / L**0.5, 0.3 * 2 / np.sqrt(alpha_bar * lambda_bar)
    assert nabla1 / nabla2 == pytest.approx(theory.LINE_NABLA, rel=1e-4)
    first, later = 1 / (1 + 0.17 * nabla1 + 0.03 * nabla1**2), 1 / (1 + 0.125 * nabla1 + 0.04 * nabla1**2)
    assert theory.in_line_contact(nabla2) == pytest.approx(first, 1e-4)
    assert theory.in_line_contact(nabla2, theory.LINE_REFIT) == pytest.approx(later, 1e-4)


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


# -- the front by the pressure -----------------------------------------------------------------------------------------


@pytest.mark.parametrize("two_dimensional", [False, True])
@pytest.mark.parametrize("by", ["film", "slope", "half-hertz"])
def test_front_of_the_dry_impact_follows_the_exact_law(by, two_dimensional):
    front = theory.front(dry_front(two_dimensional=two_dimensional), by)
    assert_allclose(front.A, hertz.contact_radius(front.T - FIRST_TOUCH), atol=0.008)
    inside = (front.A > 0.3) & (front.A < 0.98)
    assert_allclose(front.speed[inside], hertz.front_speed(front.A[inside]), rtol=0.1, atol=0.02)


@pytest.mark.parametrize("by", ["slope", "half-hertz"])
def test_the_front_by_the_pressure_of_a_dry_line_contact_is_its_edge(by):
    """Under a load F its half width is sqrt(F)."""
    data = dry_front(two_dimensional=True).isel(Y=1, drop=True).assign_attrs(radius_ratio=0.0)
    load = np.linspace(0.05, 1.0, data.sizes["frame"])
    P = np.sqrt(np.maximum(load[:, None] - data["X"].values ** 2, 0.0))
    data = data.assign(P=(("frame", "X"), P), F=("time", load))
    front = theory.front(data, by)
    assert_allclose(front.A, np.sqrt(np.interp(front.T, data["frame"], load)), atol=0.008)


def test_a_small_run():
    """The three definitions of its front agree, oil slows it, and the film at maximum approach follows its speed."""
    solver = {"method": "radial", "half_width": 4.0}
    case = ertel.impact(M=1000, L=10, nodes=201, **solver, interval=0.02)
    data = ertel.simulate(case).dataset
    X = np.linspace(0.55, 0.85, 7)
    speeds = np.array([theory.front(data, by).speed_at(X) for by in get_args(theory.FrontDefinition)])
    assert len(speeds) == 3 and np.ptp(speeds, axis=0).max() < 0.1
    assert_allclose(speeds, np.broadcast_to(hertz.front_speed(X), speeds.shape), rtol=0.2)
    assert (speeds < hertz.front_speed(X)).all()
    last = fronts.at_max_approach(data)
    trace = theory.film_behind_front(last, fronts.front(data), np.linspace(0.75, 0.95, 41))
    assert theory.deviation(theory.fit_power(trace) * trace.speed**0.67, trace.H).rms < 0.1
    assert theory.deviation(theory.film_from_speed(case.parameters, trace.speed), trace.H).rms < 0.2
