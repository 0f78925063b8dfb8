"""Films from fringes: round trips, with noise and without, and where they end."""

import warnings

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ertel.optics import CHROMIUM, SILICA, DoubtfulFilm, Layer, Rig, TwoBeams, film_of_intensity

GREEN = 532e-9
X = np.linspace(-1.0, 1.0, 401)
FILMS = {  # of which none begins on a fringe
    "wedge": 0.1e-6 + 1e-6 * (X + 1),
    "ball": 0.11e-6 + 1.35e-6 * X**2,
    "dimple": 0.2e-6 + np.where(np.abs(X) < 0.6, 0.72e-6 * (1 - (X / 0.6) ** 2) ** 2, 4.5e-6 * (np.abs(X) - 0.6) ** 2),
    "rolling": 0.29e-6 - 0.09e-6 * np.exp(-200 * (X - 0.4) ** 2) + 3.94e-6 * np.maximum(np.abs(X) - 0.6, 0.0) ** 2,
}
SPACER = Rig(coatings=(Layer(CHROMIUM, 8e-9), Layer(SILICA, 300e-9)))


def seen(rig, film, density=1.0):
    n = rig.index(density)
    return rig.fringes(GREEN, n).reflectance(n * film)


@pytest.mark.parametrize("rig", [Rig(), TwoBeams(), SPACER], ids=["many beams", "two beams", "spacer"])
@pytest.mark.parametrize("name", FILMS)
def test_round_trip(rig, name):
    film = FILMS[name]
    found = film_of_intensity(seen(rig, film), rig, GREEN, start=film[0] + 15e-9)
    np.testing.assert_allclose(found, film, atol=1e-9)
    assert np.median(np.abs(found - film)) < 1e-14


def test_coating_whose_phase_is_half_a_period():
    """The phase does not jump by a period where its middle passes from pi to -pi."""
    rig, film = Rig(coatings=(Layer(CHROMIUM, 8e-9), Layer(SILICA, 82e-9))), FILMS["wedge"]
    np.testing.assert_allclose(film_of_intensity(seen(rig, film), rig, GREEN, film[0])[:-2], film[:-2], atol=1e-9)


def test_round_trip_under_pressure():
    """With the density that the oil has along the profile; without it the film is too thick as the index is too low."""
    film, density = FILMS["rolling"], 1.0 + 0.2 * np.sqrt(np.maximum(1.0 - (X / 0.8) ** 2, 0.0))
    intensity = seen(Rig(), film, density)
    np.testing.assert_allclose(film_of_intensity(intensity, Rig(), GREEN, film[0], density), film, atol=1e-9)
    ignored = film_of_intensity(intensity, Rig(), GREEN, film[0])
    assert ignored[200] / film[200] == pytest.approx(Rig().index(1.2) / Rig().index(1.0), rel=0.02)


def test_any_unit():
    """An intensity as a camera counts it, with the counts of a dark and a bright fringe."""
    film, reflectance = FILMS["ball"], seen(Rig(), FILMS["ball"])
    fringe = seen(Rig(), np.linspace(0.0, GREEN, 5001))
    counts = 40 + 300 * reflectance
    limits = (40 + 300 * fringe.min(), 40 + 300 * fringe.max())
    np.testing.assert_allclose(film_of_intensity(counts, Rig(), GREEN, film[0], limits=limits), film, atol=2e-9)


@settings(max_examples=10)  # a quarter of a second each
@given(st.floats(0.05e-6, 1e-6), st.floats(0.0, 2.0), st.floats(-2.0, 2.0), st.floats(0.0, 400e-9))
def test_round_trip_of_random_films(base, slope, bend, spacer):
    """Films that rise all the way, over several fringes, behind any spacer, wherever they begin beside a fringe."""
    rig = Rig(coatings=(Layer(CHROMIUM, 8e-9), Layer(SILICA, spacer)))
    film = base + 1e-6 * np.cumsum(0.6 + 0.5 * slope + 0.25 * bend * X) / len(X)
    try:
        found = film_of_intensity(seen(rig, film), rig, GREEN, film[0])
    except ValueError:
        return  # begins on a fringe
    np.testing.assert_allclose(found[:-2], film[:-2], atol=1e-9)  # the end may be on a fringe


def test_noise():
    """One per cent of the contrast: a nanometre or two, more on the fringes."""
    film = FILMS["wedge"]
    intensity = seen(Rig(), film)
    noisy = intensity + 0.01 * np.ptp(intensity) * np.random.default_rng(1).standard_normal(len(X))
    error = film_of_intensity(noisy, Rig(), GREEN, film[0]) - film
    assert np.median(np.abs(error)) < 2e-9
    assert np.abs(error).max() < 20e-9


# -- noise: the campaign --------------------------------------------------------------------------------------------


def any_film(random, x):
    """A ball, a wedge or a dimple, of any size and with its thinnest place anywhere."""
    thinnest = random.uniform(0.15e-6, 0.4e-6)
    kind = random.integers(3)
    if kind == 0:
        return thinnest + random.uniform(0.4e-6, 1.4e-6) * (x - random.uniform(-0.3, 0.3)) ** 2
    if kind == 1:
        return thinnest + random.uniform(0.4e-6, 1e-6) * (x + 1) + random.uniform(-0.15e-6, 0.15e-6) * x**2
    rim, height = random.uniform(0.4, 0.7), random.uniform(0.2e-6, 0.8e-6)
    outside = random.uniform(2e-6, 4e-6) * np.maximum(np.abs(x) - rim, 0.0) ** 2
    return thinnest + height * np.maximum(1 - (x / rim) ** 2, 0.0) ** 2 + outside


def noisy_profile(seed, points, noise):
    """A film with eight of 200 points in each period, what it is found to be, and whether that is said to doubt."""
    random, rig = np.random.default_rng(seed), Rig()
    while True:
        film = any_film(random, np.linspace(-1.0, 1.0, points))
        intensity = seen(rig, film)
        intensity = intensity + noise * 0.43 * random.standard_normal(points)  # contrast 0.43
        coarse = np.interp(np.linspace(0, 1, 200), np.linspace(0, 1, points), film)
        if np.abs(np.diff(coarse)).max() > GREEN / (2 * rig.index(1.0)) / 8:
            continue
        with warnings.catch_warnings(record=True) as given:
            warnings.simplefilter("always")
            try:
                found = film_of_intensity(intensity, rig, GREEN, film[0])
            except ValueError:
                continue  # begins on a fringe
        return film, found, any(warning.category is DoubtfulFilm for warning in given)


def campaign(seeds, points, noise):
    """How many films are wrong by a quarter of a period or more, and how many of those are not said to be doubtful."""
    wrong, unsaid = 0, 0
    for seed in seeds:
        film, found, doubtful = noisy_profile(seed, points, noise)
        amiss = bool(np.abs(found - film).max() > GREEN / (8 * Rig().index(1.0)))
        wrong, unsaid = wrong + amiss, unsaid + (amiss and not doubtful)
    return wrong, unsaid


FORTY = [(40, points, noise, 2) for points in (200, 400, 800, 1600) for noise in (0.0, 0.01, 0.02)]


@pytest.mark.parametrize(
    ("films", "points", "noise", "most"),
    [(10, 400, 0.02, 1), (5, 1600, 0.02, 1), *(pytest.param(*films, marks=pytest.mark.slow) for films in FORTY)],
)
def test_few_noisy_films_are_wrong_and_those_are_said_to_be_doubtful(films, points, noise, most):
    """More points do not make it worse."""
    wrong, unsaid = campaign(range(films), points, noise)
    assert wrong <= most and unsaid == 0


def test_a_film_that_may_pass_or_turn_is_said_to_be_doubtful():
    """It lies flat on a fringe between two slopes: the mirror image has the same intensity, and is as smooth."""
    slope = np.maximum(np.abs(X) - 0.3, 0.0)
    period = GREEN / (2 * TwoBeams().index(1.0))
    fringe = period * (1.0 - np.angle(TwoBeams().fringes(GREEN, TwoBeams().index(1.0)).first) / (2 * np.pi))
    film = fringe + np.where(X < 0, 1.0, -1.0) * slope**2 * 1e-6
    with pytest.warns(DoubtfulFilm, match="doubtful at .* of 401 points") as given:
        film_of_intensity(seen(TwoBeams(), film), TwoBeams(), GREEN, film[0])
    warning = given[0].message
    assert warning.points.shape == X.shape and warning.points[-1] and not warning.points[0]


@pytest.mark.parametrize(
    ("noise", "apart"), [(0.003, 1.5e-8), *(pytest.param(n, 5e-9, marks=pytest.mark.slow) for n in (0.0, 0.003))]
)
def test_films_that_turn_on_fringes(noise, apart):
    """Wherever the thinnest place is: before a fringe, on it, or just behind it."""
    random = np.random.default_rng(2)
    for thinnest in np.arange(0.2e-6, 0.38e-6, apart):  # a period
        film = thinnest + 0.5e-6 * X**2
        intensity = seen(Rig(), film)
        intensity = intensity + noise * np.ptp(intensity) * random.standard_normal(len(X))
        try:
            found = film_of_intensity(intensity, Rig(), GREEN, film[0])
        except ValueError:
            continue  # begins on a fringe
        np.testing.assert_allclose(found[-20:], film[-20:], atol=2e-8)
        assert np.median(np.abs(found - film)) < 1e-9


@pytest.mark.parametrize(
    ("intensity", "limits", "message"),
    [
        (np.ones((4, 4)), None, r"intensity of shape \(4, 4\)"),
        (np.array([0.2, np.nan, 0.3]), None, "cut the gaps out"),
        (np.array([0.0, 0.1, 0.2]), None, "is on a bright or dark fringe"),
        (np.array([0.2, 0.1, 0.2]), (0.5, 0.1), r"limits = \(0.5, 0.1\)"),
    ],
)
def test_profiles_that_say_nothing_are_refused(intensity, limits, message):
    with pytest.raises(ValueError, match=message):
        film_of_intensity(intensity, Rig(), GREEN, 0.0, limits=limits)
