"""The rate of change following the flow: one term for impact, rolling in time and steady rolling."""

from itertools import pairwise

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from ertel.equations.flow import Flow, OilContent, Rate, downstream, kinked_at, rate_in_time, steady_rate, through_faces
from ertel.numerics import bdf, stencils

SPACING = 0.125
X = SPACING * np.arange(-32, 33)
INSIDE = slice(16, -16)  # nothing from beyond the edge has come here

MASS = 2 + np.sin(X) + X**2
NO_START = np.zeros((1, 65))


def row(values: np.ndarray) -> np.ndarray:
    return np.asarray(values)[None]


def rate_of(mass, times, U: float, start=NO_START) -> np.ndarray:
    """The rate of a mass (X, T) at times[0], with the earlier times after it, in oil that moves with a speed U."""
    distances = [U * (late - early) / SPACING for late, early in pairwise(times)]
    weights = bdf.derivative_weights(times)
    masses = [row(mass(X, T)) for T in times]
    return np.asarray(moving(weights, masses, Flow(U, distances, without_void(start))))[0]


def without_void(mass: np.ndarray) -> OilContent:
    """As `OilContent.without_void`, of an array of NumPy."""
    return OilContent(mass, mass, np.zeros_like(mass), 1.0)


@jax.jit
def moving(weights: np.ndarray, masses: list[np.ndarray], flow: Flow | None) -> jax.Array:
    """The rate of the first of the masses; the others are those of the earlier times."""
    return rate_in_time(weights, masses[1:], flow, SPACING).of(masses[0], SPACING)


@jax.jit
def steady(U: float, mass: np.ndarray) -> jax.Array:
    return steady_rate(U).of(mass, SPACING)


def test_without_flow_the_rate_is_the_squeeze() -> None:
    """Impact: the oil stays."""
    weights = bdf.derivative_weights([1.0, 0.9, 0.75])
    masses = [row(np.exp(T) * MASS) for T in (1.0, 0.9, 0.75)]
    rate = moving(weights, masses, None)
    assert_allclose(rate, sum(w * m for w, m in zip(weights, masses, strict=True)), rtol=1e-14)
    still = moving(weights, masses, Flow(0.0, (0.0, 0.0), without_void(row(MASS))))
    assert_allclose(still, rate, atol=1e-12)


def test_the_steady_wedge_is_the_past_one_and_two_nodes_upstream() -> None:
    """Steady rolling: BDF2 along the flow in steps of one node, with the present film as the past."""
    U, step = 1.7, SPACING / 1.7
    wedge = np.asarray(steady(U, row(MASS)))[0]
    assert_allclose(rate_of(lambda X, T: MASS, [0.0, -step, -2 * step], U)[INSIDE], wedge[INSIDE], rtol=1e-13)
    assert_allclose(wedge[2:], U * (3 * MASS[2:] - 4 * MASS[1:-1] + MASS[:-2]) / (2 * SPACING), rtol=1e-13)


@settings(max_examples=15)
@given(st.floats(1e-3, 2.0), st.floats(1e-3, 2.0), st.floats(0.1, 3.0), st.booleans())
def test_a_steady_start_keeps_its_steady_rate_whatever_the_steps(a: float, b: float, U: float, first: bool) -> None:
    times = [0.0, -a] if first else [0.0, -a, -a - b]
    found = rate_of(lambda X, T: MASS, times, U, start=row(MASS))
    assert_allclose(found, np.asarray(steady(U, row(MASS)))[0], rtol=1e-9, atol=1e-9)


@settings(max_examples=15)
@given(st.floats(-3.0, 3.0))
def test_oil_that_rides_along_does_not_change(U: float) -> None:
    """In whole nodes to round-off, else as far as the interpolation goes."""
    times = [0.0, -0.1, -0.25]
    assert np.abs(rate_of(lambda X, T: np.sin(X - U * T), times, U)[INSIDE]).max() < 1e-8 / 0.1


@pytest.mark.parametrize("U", [0.0, 1.0, -1.6])
def test_second_order_in_time(U: float) -> None:
    """dm/dT + U dm/dX of a film that changes and moves."""

    def mass(X: np.ndarray, T: float) -> np.ndarray:
        return np.cos(X) * np.exp(T)

    exact = (np.cos(X) - U * np.sin(X))[INSIDE]
    errors = [np.abs(rate_of(mass, [0.0, -h, -2.2 * h], U)[INSIDE] - exact).max() for h in (0.2, 0.1, 0.05)]
    assert all(3.4 < coarse / fine < 4.6 for coarse, fine in pairwise(errors)), errors


@settings(max_examples=15)
@given(st.floats(-3.0, 3.0), st.integers(0, 10**6))
def test_reversing_the_flow_mirrors_the_rate(U: float, seed: int) -> None:
    now, old, older, start = np.random.default_rng(seed).random((4, 1, 65))

    def rate(U: float, *fields: np.ndarray) -> np.ndarray:
        flow = Flow(U, (U, 0.7 * U), without_void(fields[3]))
        return np.asarray(moving(np.array([1.5, -2.0, 0.5]), list(fields[:3]), flow))

    mirrored = rate(-U, *(field[:, ::-1] for field in (now, old, older, start)))
    assert_allclose(mirrored[:, ::-1], rate(U, now, old, older, start), atol=1e-11)


@settings(max_examples=8)
@given(st.lists(st.floats(0.2, 3.0), min_size=12, max_size=12), st.integers(0, 10**6))
def test_oil_is_neither_made_nor_lost_on_its_way(steps: list[float], seed: int) -> None:
    """A heap of oil far from the edges: the sum of all masses stays the same, whatever the steps."""
    heap = np.zeros(257)
    heap[100:110] = np.random.default_rng(seed).random(10)
    levels = [row(heap)]
    for late, early in zip(steps, [0.0, *steps], strict=False):
        levels = [advanced(levels, late, early), *levels][:2]
        assert float(levels[0].sum()) == pytest.approx(heap.sum(), rel=1e-10)


def advanced(levels: list, step: float, before: float) -> jnp.ndarray:
    """The mass that rides with the oil after one more step (in nodes), from one or two levels."""
    weights = bdf.derivative_weights([step, 0.0, -before][: 1 + len(levels)])
    return without_change(np.asarray(weights), levels, (step, before)[: len(levels)])


@jax.jit
def without_change(weights: jnp.ndarray, levels: list, distances: tuple) -> jnp.ndarray:
    rate = rate_in_time(weights, levels, Flow(1.0, distances, OilContent.without_void(jnp.zeros_like(levels[0]))), 1.0)
    return -rate.past / rate.new


def lost_per_wavelength(steps: list[float]) -> float:
    """The share of its amplitude that a wave of eight nodes loses to transport alone in steps of so many nodes."""
    phase = np.pi / 4 * np.arange(1025)
    levels = [np.stack([np.cos(phase), np.sin(phase)])]
    for late, early in zip(steps, [0.0, *steps], strict=False):
        levels = [advanced(levels, late, early), *levels][:2]
    left = np.hypot(*np.asarray(levels[0])[:, 400:600]).mean()
    return 1 - left ** (8 / sum(steps))


def test_a_wave_that_rides_with_the_oil_keeps_its_height() -> None:
    """Below 0.1 % per wavelength with whole cells (here: round-off), below 1 % with arbitrary steps."""
    assert abs(lost_per_wavelength([1.0] * 80)) < 1e-12
    assert abs(lost_per_wavelength([1.0, 3.0, 2.0, 1.0] * 20)) < 1e-12
    for step in (0.2, 0.37, 0.5, 0.7, 1.6):
        assert 0 <= lost_per_wavelength([step] * 80) < 0.01
    random = np.random.default_rng(1).uniform(0.1, 2.5, 100)
    assert 0 <= lost_per_wavelength(list(random)) < 0.01


def with_meniscus(node: int, before: float, U: float) -> tuple[OilContent, jax.Array]:
    """A starved film that is full from a node on, with so much oil on the node before it, and its pressure."""
    full, i = jnp.asarray(row(1.0 + (X - 1.0) ** 2)), jnp.arange(65)[None]
    P = jnp.where(i >= node, 1.0, 0.0)
    oil = jnp.where(i >= node, full, jnp.where(i == node - 1, before, 0.5))
    kinked = kinked_at(P)
    void = jnp.where(i >= node, 0.0, downstream(full, kinked) - oil)
    oil, full, void, kinked, P = (field[:, :: 1 if U > 0 else -1] for field in (oil, full, void, kinked, P))
    return OilContent(oil, full, void, U, kinked), P


@pytest.mark.parametrize("U", [1.0, -1.0])
@pytest.mark.parametrize("node", [20, 30, 33])
@pytest.mark.parametrize("step", [0.05, 0.12, 0.3])
def test_a_starved_film_that_has_settled_has_the_rate_of_the_steady_film(U: float, node: int, step: float) -> None:
    """Whatever the start, whose meniscus is elsewhere; without this the start decides how the oil passes it."""
    (start, _), (late, P) = with_meniscus(30, 0.6, U), with_meniscus(node, 0.7, U)
    flow = Flow(U, (U * step / SPACING,) * 2, start, settles=True)
    weights = bdf.derivative_weights([0.0, -step, -2 * step])

    def rate(flow: Flow) -> np.ndarray:
        return np.asarray(rate_in_time(weights, [late.oil] * 2, flow, SPACING, [P] * 2).of(late.oil, SPACING))[0]

    expected = np.diff(through_faces(late, U), axis=1)[0] / SPACING
    assert_allclose(rate(flow.beside(P, late.oil)), expected, atol=1e-11)
    assert_allclose(rate(flow._replace(settles=False).beside(P, late.oil)), rate(flow), atol=0)


def test_a_number_of_nodes_upstream_of_the_edge_is_none() -> None:
    """The first node has no node upstream: no slope; the second a first-order one, as the steady difference has."""
    slope = np.asarray(jax.jit(stencils.upstream_slope)(row(MASS), SPACING))[0]
    assert slope[0] == 0.0
    assert slope[1] == pytest.approx((MASS[1] - MASS[0]) / SPACING)
    assert Rate(2.0, 1.0).of(row(MASS), SPACING)[0, 0] == 2 * MASS[0] + 1


BEND = row(X**2) * np.array([[0.5], [0.7]])


@jax.jit
def brought(
    weights: np.ndarray, masses: list[np.ndarray], flow: Flow, pressures: list[np.ndarray], bent: tuple | None
) -> tuple[jax.Array, jax.Array]:
    """What the flow takes from the nodes of a film, and the same by what passes the faces."""
    rate = rate_in_time(weights, masses[1:], flow, SPACING, pressures, bent)
    stays = sum(weight * mass for weight, mass in zip(weights, masses, strict=True))
    return rate.of(masses[0], SPACING) - stays, jnp.diff(rate.through, axis=1) / SPACING


@pytest.mark.parametrize("U", [1.0, -1.0])
@pytest.mark.parametrize("start", [1.0, -1.0])
@pytest.mark.parametrize("kind", ["full", "bent", "starved"])
def test_what_the_flow_takes_from_a_cell_passes_its_faces(kind: str, start: float, U: float) -> None:
    """Of any films, with and against the flow of the start; so their sum is what passes the outermost faces."""
    random = np.random.default_rng(3)
    *masses, oil, full, void = random.random((6, 2, 65))
    pressures = [np.where(random.random((2, 65)) < 0.95, 1.0, 0.0) for _ in range(2)]
    starved = kind == "starved"
    content = OilContent(oil, full if starved else oil, void, start, random.random((2, 65)) < 0.1 if starved else None)
    steps = (1.7, 2.4) if starved else (0.7, 0.3)  # the oil of no inner node comes from beyond a full inlet
    flow = Flow(0.9 * U, tuple(U * step for step in steps), content)
    bent = (BEND, np.array([0.1, 0.3])) if kind == "bent" else None
    weights = bdf.derivative_weights([0.0, -steps[0], -sum(steps)])
    found, expected = brought(weights, masses, flow, pressures, bent)
    assert_allclose(found[:, 1:-1], expected[:, 1:-1], atol=1e-11)
