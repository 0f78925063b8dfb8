"""The flow of an oil that thins: tables, a slow twin, its derivatives, its limits and its symmetries."""

from collections.abc import Callable
from functools import cache, partial
from itertools import product

import jax
import numpy as np
import pytest
from closed_forms import eyring_flow_factor, eyring_stress
from hypothesis import given
from hypothesis import strategies as st
from jax import Array
from numpy.testing import assert_allclose
from scipy.integrate import quad_vec
from scipy.optimize import root

from ertel.equations import across
from ertel.equations.across import Vector, series_of
from ertel.equations.contact import traceable
from ertel.equations.shear import LIMIT, Shear, shear
from ertel.physics.fluidity import Carreau, Fluidity, Limited, NewtonianOil, ReeEyring
from ertel.physics.laws.carreau_yasuda import CarreauYasuda

FLOW = jax.jit(shear)
FLOW_BY_40_NODES = jax.jit(partial(shear, points=40))
MANY_NODES = np.polynomial.legendre.leggauss(200)
WIDTH = 250  # points of every call: each law compiles once
EYRING = traceable(ReeEyring(1.0))
CARREAU = traceable(Carreau(1.0, 0.5))
NEWTON = traceable(NewtonianOil())
SQUALANE = traceable(Carreau(1.0, 0.42))
YASUDA = traceable(CarreauYasuda(1.0, 0.5, 1.3))
LIMITED = traceable(Limited(ReeEyring(1.0), 0.05, ambient=8.0, sharpness=0.1))
LAWS = {"eyring": EYRING, "carreau": CARREAU, "squalane": SQUALANE, "yasuda": YASUDA, "limited": LIMITED}
every_law = pytest.mark.parametrize("law", LAWS.values(), ids=LAWS)


def filled(values: object) -> np.ndarray:
    """Numbers (points,) or vectors (points, 2) of up to WIDTH points as a field of so many, ones after them."""
    given = np.asarray(values, dtype=float)
    return np.concatenate([given, np.ones((WIDTH - len(given), *given.shape[1:]))]).T


def flow(law: Fluidity, sliding: object, gradient: object, program: Callable[..., Shear] = FLOW) -> Shear:
    """The flow at ambient pressure in points given as (points, 2), as arrays of NumPy; the iterations are the most."""
    s, g = (np.atleast_2d(np.asarray(vectors, dtype=float)) for vectors in (sliding, gradient))
    starts = range(0, len(s), WIDTH)
    films = [program(law, np.zeros(WIDTH), *(filled(v[k : k + WIDTH]) for v in (s, g))) for k in starts]
    stress, flux, *by_gradient = (
        np.concatenate(parts, axis=-1)[..., : len(s)]
        for parts in zip(*((film.stress, film.flux, *film.by_gradient) for film in films), strict=True)
    )
    return Shear(stress, flux, tuple(by_gradient), max(film.iterations for film in films))


def twin(law: Fluidity, sliding: np.ndarray, gradient: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """tau_m and Q of one point: adaptive integration across the film, a general root finder, no derivative."""

    def across(stress: np.ndarray, power: int) -> np.ndarray:
        def rate(zeta: float) -> np.ndarray:
            tau = stress + zeta * gradient
            return zeta**power * law.fluidity(np.linalg.norm(tau), 0.0) * tau

        total, _ = quad_vec(rate, -0.5, 0.5, epsabs=0.0, epsrel=1e-11, limit=400)
        return total

    def misfit(stress: np.ndarray) -> np.ndarray:
        return np.arcsinh(across(stress, 0)) - np.arcsinh(sliding)

    solution = root(misfit, np.asarray(law.stress(np.abs(sliding), 0.0)) * np.sign(sliding), tol=1e-13)
    return solution.x, across(solution.x, 1)


# -- the tables of the design -----------------------------------------------------------------------------------------

SIGMA = [0.5, 1.0, 2.0, 4.0, 8.0]


@pytest.mark.parametrize("B", [0.0, 1.0, 10.0, 100.0, 1e3, 1e6])
def test_eyring_in_one_dimension(B: float) -> None:
    """Against the closed forms of Conry et al.

    sinh(100) = 1e43: in steep gradients the nodes move to the walls, and 8 of them give the flux to 1e-5.
    """
    for Sigma, close in ((np.array(SIGMA), 6e-7), (np.array([10.0, 30.0, 100.0]), 1e-5)):
        film = flow(EYRING, [[B, 0.0]] * len(Sigma), [[2.0 * S, 0.0] for S in Sigma])
        assert_allclose(6.0 * film.flux[0] / Sigma, eyring_flow_factor(B, Sigma), rtol=close)
        if close < 1e-6:
            assert_allclose(film.stress[0], eyring_stress(B, Sigma), rtol=1e-6, atol=1e-15)
        assert np.all(film.flux[1] == 0) and np.all(film.stress[1] == 0)


@pytest.mark.parametrize(
    ("B", "factors", "stresses"),
    [
        (0, [1.00003, 1.071941, 1.260475, 1.819012, 3.176691], [0.0] * 5),
        (1, [1.757872, 1.723605, 1.683287, 1.948336, 3.198027], [0.786136, 0.748699, 0.650671, 0.44093, 0.242249]),
        (10, [6.176161, 6.14954, 6.069117, 5.741032, 4.858474], [3.084227, 3.07076, 3.03001, 2.86198, 2.208142]),
    ],
)
def test_carreau_in_one_dimension(B: float, factors: list, stresses: list) -> None:
    """Six digits with 40 nodes.  Where the gradient exceeds G the flow has a narrow core, which 8 resolve to 4e-4."""
    Sigma = np.array([0.01, 0.5, 1.0, 2.0, 4.0])
    args = [[B, 0.0]] * 5, [[2.0 * S, 0.0] for S in Sigma]
    quick, exact = flow(CARREAU, *args), flow(CARREAU, *args, FLOW_BY_40_NODES)
    for film, near in ((exact, 0.0), (quick, np.array([0.0, 0.0, 3e-6, 6e-5, 4e-4]))):
        assert np.all(np.abs(6.0 * np.asarray(film.flux[0]) / Sigma / factors - 1.0) <= near + 6e-7)
        assert np.all(np.abs(np.asarray(film.stress[0]) - stresses) <= near + 6e-7)


@pytest.mark.parametrize(("law", "error"), [("eyring", 1e-5), ("carreau", 6e-4), ("squalane", 6e-4), ("yasuda", 6e-4)])
def test_the_error_of_the_flux_in_pure_rolling(law: str, error: float) -> None:
    """As the docstring of `model.shear` says it; most of it is there above ten times the law's stress."""
    gradient = [10.0, 12.0, 15.0, 20.0, 30.0, 50.0, 80.0, 100.0, 150.0, 200.0]
    rolling = flow(LAWS[law], [[0.0, 0.0]] * 10, [[g, 0.0] for g in gradient])
    z, weight = np.polynomial.legendre.leggauss(20)
    zeta = (np.arange(150)[:, None] + (z + 1.0) / 2.0) / 300.0  # 150 layers of half of the film
    weight = weight / 600.0
    for flux, g in zip(rolling.flux[0], gradient, strict=True):
        true = 2.0 * g * np.sum(weight * zeta**2 * LAWS[law].fluidity(zeta * g, np.zeros_like(zeta)))
        assert flux == pytest.approx(true, rel=error)


# -- the slow twin ----------------------------------------------------------------------------------------------------

POINTS = [
    ([3.0, 0.0], [1.0, 0.5]),
    ([30.0, 0.0], [-2.0, 3.0]),
    ([0.5, -2.0], [0.3, 1.0]),
    ([1000.0, 100.0], [4.0, 4.0]),
    ([0.0, 0.0], [2.0, -1.0]),
]


@pytest.mark.parametrize("point", POINTS, ids=str)
@every_law
def test_the_slow_twin_agrees(law: Fluidity, point: tuple) -> None:
    film = flow(law, *point)
    stress, flux = twin(law, np.array(point[0]), np.array(point[1]))
    close = 2e-4 if law is not EYRING else 1e-7  # the laws that bend sharply need more nodes than 8 for more
    assert_allclose(film.stress[:, 0], stress, rtol=close, atol=close * np.linalg.norm(stress) + 1e-9)
    assert_allclose(film.flux[:, 0], flux, rtol=close, atol=close * np.linalg.norm(flux))


# -- derivatives ------------------------------------------------------------------------------------------------------


def values(law: Fluidity, pressure: Array, s: Array, g: Array) -> tuple[Array, Array]:
    return shear(law, pressure, s, g)[:2]


def with_changes(at: tuple, changes: tuple) -> tuple[tuple[Array, Array], tuple[Array, Array]]:
    """Stress and flux, and their changes along those of the law's numbers, of the pressure, of s and of g."""
    return jax.jvp(values, at, changes)


WITH_CHANGES = jax.jit(with_changes)


def numbers(law: Fluidity, value: float) -> Fluidity:
    """A law all of whose numbers are this one: a change of them."""
    return jax.tree.map(lambda _: value, law)


@pytest.mark.parametrize("law", [EYRING, SQUALANE, LIMITED, pytest.param(YASUDA, marks=pytest.mark.slow)], ids=str)
def test_derivatives_are_those_of_differences(law: Fluidity) -> None:
    """In all arguments and in the numbers of the law, in many points."""
    draw = np.random.default_rng(1)
    s, g, ds, dg = (draw.normal(size=(2, WIDTH)) * size for size in (20.0, 0.8, 1.0, 1.0))
    p, dp = draw.uniform(0.0, 50.0, WIDTH), draw.normal(size=WIDTH)
    at, changes = (law, p, s, g), (numbers(law, 0.1), dp, ds, dg)
    step = 1e-5
    up, down = (FLOW(*jax.tree.map(lambda a, d, e=e: a + e * d, at, changes)) for e in (step, -step))
    _, slopes = WITH_CHANGES(at, changes)
    for slope, more, less in zip(slopes, up[:2], down[:2], strict=True):
        expected = (np.asarray(more) - np.asarray(less)) / (2 * step)
        assert_allclose(slope, expected, rtol=2e-6, atol=2e-6 * np.abs(slope).max())


@pytest.mark.parametrize(
    "law", [EYRING, CARREAU, SQUALANE, LIMITED, pytest.param(YASUDA, marks=pytest.mark.slow)], ids=str
)
def test_derivatives_are_those_of_the_slow_twin(law: Fluidity) -> None:
    s, g = (np.array(v) for v in ([3.0, 0.4], [0.6, 0.3]))
    ds, dg, step = np.array([0.7, -0.2]), np.array([0.3, 0.5]), 1e-4
    more, less = (twin(law, s + sign * step * ds, g + sign * step * dg) for sign in (1, -1))
    nothing, (s, g, ds, dg) = np.zeros(WIDTH), (filled([v]) for v in (s, g, ds, dg))
    _, changes = WITH_CHANGES((law, nothing, s, g), (numbers(law, 0.0), nothing, ds, dg))
    for change, up, down in zip(changes, more, less, strict=True):
        assert_allclose(change[:, 0], (up - down) / (2 * step), rtol=1e-5)


S, G = filled([[5.0, 1.0]]), filled([[0.6, -0.3]])


@cache
def linear_map() -> Callable[..., tuple[Array, Array]]:
    """From changes of s and g alone to those of the stress and of the flux, as a Krylov iteration takes it."""
    return jax.linearize(jax.jit(partial(values, EYRING, np.zeros(WIDTH))), S, G)[1]


def test_reverse_is_the_transpose_of_forward() -> None:
    """And forward, where law and pressure do not change, is what it is where their changes are zero."""
    draw = np.random.default_rng(6)
    ds, dg, *left = draw.normal(size=(4, 2, WIDTH))
    forward = linear_map()(ds, dg)
    reverse = jax.jit(jax.linear_transpose(linear_map(), S, G))(tuple(left))
    inner = [sum(np.vdot(a, b) for a, b in zip(*pair, strict=True)) for pair in ((left, forward), (reverse, (ds, dg)))]
    assert inner[0] == pytest.approx(inner[1], rel=1e-12)
    nothing = np.zeros(WIDTH)
    _, changes = WITH_CHANGES((EYRING, nothing, S, G), (numbers(EYRING, 0.0), nothing, ds, dg))
    for found, expected in zip(forward, changes, strict=True):
        assert_allclose(found, expected, rtol=1e-12, atol=1e-12)


def test_the_linear_map_does_not_repeat_the_iteration() -> None:
    """What a Krylov iteration repeats is arithmetic with known fields: no loop and no exponential."""
    text = str(jax.make_jaxpr(linear_map())(S, G))
    assert "mul" in text and not any(word in text for word in ("while", "expm1", "exp ", "sinh", "sqrt"))


def test_new_numbers_need_no_new_compilation() -> None:
    before = FLOW._cache_size()
    for tau0 in (1.0, 2.0, 3.0):
        flow(ReeEyring(tau0), [1.0, 2.0], [0.5, 0.5])
    assert FLOW._cache_size() <= before + 1


# -- limits and laws of nature ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("law", [NEWTON, ReeEyring(1e12), Carreau(1e12, 0.3), Carreau(1.0, 1.0)], ids=str)
def test_newtonian_to_round_off(law: Fluidity) -> None:
    """To the round-off of the stress at the walls; of the gradient, where the fluidity is one to the last bit."""
    draw = np.random.default_rng(2)
    s, g = 10.0 ** draw.uniform(-3, 3, (50, 2)), 10.0 ** draw.uniform(-3, 1, (50, 2))
    film = flow(law, s, g)
    at_walls = np.linalg.norm(s, axis=1) + np.linalg.norm(g, axis=1)
    assert np.all(np.linalg.norm(film.stress.T - s, axis=1) <= 1e-15 * at_walls)
    assert np.all(np.linalg.norm(film.flux.T - g / 12.0, axis=1) <= 1e-15 * at_walls)
    if law in (NEWTON, Carreau(1.0, 1.0)):
        assert_allclose(12.0 * film.flux.T, g, rtol=1e-14)


def test_a_film_at_rest_is_at_rest() -> None:
    for law in LAWS.values():
        film = flow(law, [0.0, 0.0], [0.0, 0.0])
        assert np.all(film.stress == 0) and np.all(film.flux == 0)
        film = flow(law, [0.0, 0.0], [2.0, 1.0])
        assert np.all(film.stress == 0)


@every_law
def test_small_gradients_see_two_viscosities(law: Fluidity) -> None:
    """d(phi tau)/dtau along the sliding and phi across; for Eyring's law at B = 10 (1 + B^2)^(1/2) and B/asinh B."""
    film = flow(law, [[10.0, 0.0]] * 2, [[1e-4, 0.0], [0.0, 1e-4]])
    tau, step = float(film.stress[0, 0]), 1e-5
    phi = float(law.fluidity(tau, 0.0))
    along = (law.fluidity(tau + step, 0.0) * (tau + step) - law.fluidity(tau - step, 0.0) * (tau - step)) / (2 * step)
    assert 12e4 * film.flux[0, 0] == pytest.approx(along, rel=1e-6)
    assert 12e4 * film.flux[1, 1] == pytest.approx(phi, rel=1e-6)
    if law is EYRING:
        assert (along, phi) == pytest.approx((10.049876, 10.0 / np.arcsinh(10.0)), rel=1e-7)


VECTOR = st.tuples(st.floats(-30.0, 30.0), st.floats(-30.0, 30.0))
SLOPE = st.tuples(st.floats(-3.0, 3.0), st.floats(-3.0, 3.0))
ANY_LAW = st.sampled_from(sorted(LAWS))


@given(ANY_LAW, VECTOR, SLOPE, st.floats(0.0, 6.3))
def test_no_direction_is_special(name: str, s: tuple, g: tuple, angle: float) -> None:
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    film = flow(LAWS[name], [s, turn @ s], [g, turn @ g])
    for field in film[:2]:
        assert_allclose(field[:, 1], turn @ field[:, 0], rtol=1e-7, atol=1e-7 * (np.linalg.norm(field[:, 0]) + 1e-3))


@given(ANY_LAW, VECTOR, SLOPE)
def test_reversed_gradients_reverse_the_flux_and_keep_the_stress(name: str, s: tuple, g: tuple) -> None:
    film = flow(LAWS[name], [s, s, (-s[0], -s[1])], [g, (-g[0], -g[1]), g])
    size = 1e-9 * (np.abs(film.stress).max() + 1e-3)
    assert_allclose(film.stress[:, 1], film.stress[:, 0], atol=size)
    assert_allclose(film.flux[:, 1], -film.flux[:, 0], atol=1e-9)
    assert_allclose(film.stress[:, 2], -film.stress[:, 0], atol=size)
    assert_allclose(film.flux[:, 2], film.flux[:, 0], atol=1e-9)


@given(ANY_LAW, VECTOR, SLOPE)
def test_mobilities_are_positive(name: str, s: tuple, g: tuple) -> None:
    """For a change of the gradient, and along the gradient."""
    film = flow(LAWS[name], s, g)
    xx, xy, yy = (12.0 * part for part in film.by_gradient)
    assert np.all(xx >= 1.0 - 1e-9) and np.all(yy >= 1.0 - 1e-9) and np.all(xx * yy - xy**2 > 0.9)
    assert 12.0 * np.dot(film.flux[:, 0], g) >= (1.0 - 1e-9) * np.dot(g, g)


@given(ANY_LAW, VECTOR, SLOPE, VECTOR, SLOPE)
def test_flow_is_monotone(name: str, s1: tuple, g1: tuple, s2: tuple, g2: tuple) -> None:
    """(ds, dtau_m) and (dQ, dg) never point against each other where only one of s and g differs."""
    film = flow(LAWS[name], [s1, s2, s1], [g1, g1, g2])
    sliding = np.dot(np.subtract(s2, s1), film.stress[:, 1] - film.stress[:, 0])
    flux = np.dot(np.subtract(g2, g1), film.flux[:, 2] - film.flux[:, 0])
    assert sliding >= -1e-6 and flux >= -1e-6


@given(ANY_LAW, VECTOR, SLOPE)
def test_heat_is_work(name: str, s: tuple, g: tuple) -> None:
    law, film = LAWS[name], flow(LAWS[name], s, g)
    heat = float(np.dot(s, film.stress[:, 0]) + np.dot(g, film.flux[:, 0]))  # over h/eta
    z, w = MANY_NODES
    tau = np.asarray(film.stress) + 0.5 * z * np.asarray(g)[:, None]
    square = tau[0] ** 2 + tau[1] ** 2
    assert heat == pytest.approx(np.sum(0.5 * w * law.fluidity(np.sqrt(square), 0.0) * square), rel=1e-3, abs=1e-12)


@pytest.mark.parametrize(
    "law",
    [
        LIMITED,
        *(
            pytest.param(law, marks=pytest.mark.slow)
            for law in (EYRING, CARREAU, traceable(Limited(CARREAU, 0.05, 4.0)))
        ),
    ],
    ids=str,
)
def test_the_series_agrees_with_the_nodes(law: Fluidity, monkeypatch: pytest.MonkeyPatch) -> None:
    """Stress and flux, then their changes, where the oil hardly thins: at some points the series holds."""
    draw = np.random.default_rng(5)
    sizes = 10.0 ** draw.uniform(-4, 0, (2, 1, WIDTH))
    s, g = sizes * draw.normal(size=(2, 2, WIDTH))
    pressure = np.ones(WIDTH)
    arguments = (law, pressure, s, g), (numbers(law, 0.0), pressure, s, g)

    def holding() -> np.ndarray:
        return np.asarray(jax.jit(lambda p, s, g: series_of(law, p, Vector(*s), Vector(*g)).holds)(pressure, s, g))

    by_series, share = jax.tree.leaves(WITH_CHANGES(*arguments)), holding().mean()
    monkeypatch.setattr(across, "SERIES_END", -1.0)
    by_nodes = jax.tree.leaves(jax.jit(lambda *both: with_changes(*both))(*arguments))
    assert 0.3 < share < 0.9 and not np.any(holding())
    walls = np.linalg.norm(s, axis=0) + np.linalg.norm(g, axis=0)
    for ours, exact, error in zip(by_series, by_nodes, (2e-9, 2e-9, 4e-8, 4e-8), strict=True):
        assert np.max(np.abs(np.asarray(ours) - exact) / walls) <= error


# -- the iteration ----------------------------------------------------------------------------------------------------


def corners(points: int, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Slidings and gradients over nine and four decades."""
    draw = np.random.default_rng(seed)
    B, Sigma = 10.0 ** draw.uniform(-3, 6, points), 10.0 ** draw.uniform(-2, 2, points)
    angle = draw.uniform(0, 6.3, points)
    return np.stack([B, 0 * B], 1), (2.0 * Sigma * np.stack([np.cos(angle), np.sin(angle)])).T


@pytest.mark.parametrize(
    ("law", "most", "points"),
    [
        (EYRING, 9, 20000),
        *((Carreau(1.0, n), 7, 20000) for n in (0.2, 0.42, 0.8)),
        *(
            (traceable(Limited(EYRING, 0.05, ambient, sharpness)), LIMIT - 1, 2000)
            for ambient, sharpness in product((1.0, 8.0, 100.0), (0.02, 0.05))
        ),
    ],
    ids=str,
)
def test_iterations_are_few_in_every_corner(law: Fluidity, most: int, points: int) -> None:
    """A limit of the stress needs more and never fails."""
    film = flow(law, *corners(points, 3))
    assert np.all(np.isfinite(film.stress)) and np.all(np.isfinite(film.flux))
    assert int(film.iterations) <= most
