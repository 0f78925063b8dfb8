"""The oil that there is: cavities that keep their void, layers of oil, starved contacts, steady and in time."""

from dataclasses import replace
from functools import cache
from itertools import pairwise
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from cases import march, orders, parse_case
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose

import ertel
from ertel.case.case import Case
from ertel.case.estimates import starvation, wet_radius
from ertel.equations import contact, discretise
from ertel.equations.flow import downstream, void_change, void_downstream
from ertel.numerics.stencils import unfolded, upstream_slope
from ertel.physics.film_formulas import starved_share
from ertel.physics.surfaces import Feature, SelfAffine, Waviness
from ertel.results.parameters import formula_films
from ertel.runs.drive import simulate
from ertel.runs.outlook import warnings_of
from ertel.runs.response import respond_in_rolling, respond_linearly
from ertel.runs.result import Result
from ertel.solvers import steady
from ertel.solvers.grid_solution import GridSolution
from ertel.solvers.radial import RadialImpact
from ertel.solvers.transient import Transient2D

# R, the film over the flooded one, by r, the oil that enters over that of the flooded film, at M = 200, L = 10
STARVED = {4: 0.9789, 2: 0.9352, 1: 0.7903, 0.5: 0.4778, 0.25: 0.2463}
# layers and the films H_c that impacts trap, at M = 200, L = 10: an independent radial program
ON_A_LAYER = [(0.5, 0.1482), (0.2, 0.11628), (0.1, 0.07302)]


def case_of(kind: str, layer: Any, M: float = 200, **solver: Any) -> Case:
    oil = {} if layer is None else {"layer": layer}
    return parse_case({"contact": {"kind": kind, "M": M, "L": 10}, "lubricant": oil, "solver": solver})


@cache
def rolled_on(layer: float | None, nodes: int = 65) -> GridSolution:
    return steady.steady_film(case_of("rolling", layer, method="steady", nodes=nodes)).finest


# -- the void of a steady film ----------------------------------------------------------------------------------------

VOID = jax.jit(void_downstream)
LINES = st.tuples(st.integers(0, 10**6), st.floats(0.1, 3.0), st.floats(0.0, 0.5))


@settings(max_examples=20, deadline=None)
@given(LINES)
def test_the_void_is_a_sum_along_the_flow(line: tuple[int, float, float]) -> None:
    seed, U, first = line
    random = np.random.default_rng(seed)
    P, r = random.random((3, 33)) * (random.random((3, 33)) < 0.3), random.normal(size=(3, 33))
    expected = np.zeros((3, 33))
    expected[:, 0] = first
    for i in range(1, 33):
        expected[:, i] = np.where(P[:, i] > 0, 0.0, np.maximum(expected[:, i - 1] + 0.1 * r[:, i] / U, 0.0))
    assert_allclose(VOID(P, r, first, U, 0.1), expected, atol=1e-12)


def test_the_change_of_the_void_is_its_derivative() -> None:
    random = np.random.default_rng(1)
    held = random.random((3, 33)) < 0.7
    held[:, 0] = True
    P, r, dr = np.where(held, 0.0, 1.0), 1.0 + random.random((3, 33)), random.normal(size=(3, 33))
    first, d_first = np.full(3, 0.3), random.normal(size=3)
    step = 1e-4  # the void is piecewise linear

    def void(r: jax.Array, first: jax.Array) -> jax.Array:
        return void_downstream(jnp.asarray(P), r, first, 2.0, 0.1)

    @jax.jit
    def three_ways(r: jax.Array, dr: jax.Array) -> tuple[jax.Array, ...]:
        by_jax = jax.jvp(void, (r, first), (dr, d_first))[1]
        up, down = (void(r + share * dr, first + share * d_first) for share in (step, -step))
        return void_change(jnp.asarray(1.0 - P), dr * 0.1 / 2.0, d_first), by_jax, (up - down) / (2.0 * step)

    found, by_jax, expected = three_ways(r, dr)
    assert_allclose(found, by_jax, atol=1e-12)
    assert_allclose(found, expected, atol=1e-11)
    r -= 1.5  # in places the cavities are full again: no void is left, and none comes by a small change
    assert 0.2 < np.mean(np.asarray(VOID(P, r, first, 2.0, 0.1))[P == 0.0] == 0.0) < 0.8
    _, by_jax, expected = three_ways(r, dr)
    assert_allclose(by_jax, expected, atol=1e-11)


def test_the_oil_that_passes_is_that_of_the_upstream_slope() -> None:
    full = np.random.default_rng(2).random((2, 17))
    passing, slope = jax.jit(lambda full: (downstream(full), upstream_slope(full, 0.1)))(full)
    assert_allclose(np.diff(passing, axis=1), 0.1 * np.asarray(slope)[:, 1:], atol=1e-14)


# -- steady rolling ---------------------------------------------------------------------------------------------------


@jax.jit
def mobility_and_passing(
    c: contact.Contact, P: jax.Array, H: jax.Array, kinked: jax.Array
) -> tuple[jax.Array, jax.Array]:
    """The mobility, and what passes if all is full."""
    return c.lubricant.mobility(P, H, c.lambda_bar), downstream(contact.mass(c, P, H), kinked)


@pytest.mark.parametrize("layer", [0.0365, 0.0712, 0.15])
def test_all_oil_that_enters_passes_every_line(layer: float) -> None:
    """The flux through a line across the flow: that of the layer, less what leaves to the sides, which is nothing."""
    s = rolled_on(layer)
    assert s.status.ok and float(np.min(s.H)) > 0
    c, content = discretise.contact_of(s.case, s.grid), s.content
    eps, full = (np.asarray(field) for field in mobility_and_passing(c, s.P, s.H, content.kinked))
    driven = -0.5 * (eps[:, 1:] + eps[:, :-1]) * np.diff(s.P, axis=1) / s.grid.spacing
    flux = (full[:, :-1] - np.asarray(content.void)[:, :-1] + driven)[:-1]  # the row on the edge is given
    rows = np.r_[1.0, np.full(len(flux) - 1, 2.0)]  # the axis is the first of them
    through = rows @ flux / (rows.sum() * layer)
    assert_allclose(through, 1.0, atol=1e-8)
    balance = s.account.terms
    assert balance["inflow"] == pytest.approx(balance["outflow"], rel=1e-6)
    assert abs(balance["cavity_source"]) < 1e-12


def test_the_oil_is_between_nothing_and_the_full_gap() -> None:
    s = rolled_on(0.0712)
    oil, full = (np.asarray(field) for field in (s.content.oil, s.content.full))
    P = np.asarray(s.P)
    assert np.all(oil <= full + 1e-15) and np.all(oil >= 0)
    assert_allclose(oil[P > 0], full[P > 0])
    X = s.grid.kept_x
    assert_allclose(oil[:, X < -3], 0.0712, rtol=1e-12)


def test_a_starved_film_is_the_mirror_of_the_one_that_rolls_back() -> None:
    forth = case_of("rolling", 0.0712, method="steady", nodes=33, half_width=3.0, inlet=3.0)
    back = replace(forth, drive=parse_case({**forth.to_data(), "motion": {"entrainment": -1.0}}).drive)
    one, other = (steady.steady_film(case).finest for case in (forth, back))
    assert_allclose(other.H, np.asarray(one.H)[:, ::-1], atol=1e-10)
    assert_allclose(other.content.oil, np.asarray(one.content.oil)[:, ::-1], atol=1e-9)


def film_reduction(r: float, nodes: int) -> float:
    """rho H at the centre over that of the flooded contact."""
    s = rolled_on(None, nodes)
    centre = s.grid.kept_x.searchsorted(0.0)
    flooded = float(s.content.oil[0, centre])
    return float(rolled_on(round(r * flooded, 10), nodes).content.oil[0, centre]) / flooded


@pytest.mark.parametrize("nodes", [65, pytest.param(129, marks=pytest.mark.slow)])
@pytest.mark.parametrize("r", STARVED)
def test_the_film_of_a_starved_contact(r: float, nodes: int) -> None:
    """Against an independent dense program on a spacing of 0.05; ours are 0.094 and 0.047."""
    assert film_reduction(r, nodes) == pytest.approx(STARVED[r], abs=0.07 if nodes == 65 else 0.008)


@pytest.mark.slow
def test_a_starved_film_is_of_second_order() -> None:
    """From 65 to 257 nodes, where the inlet decides the film; one that is the layer hardly depends on the grid."""
    solved = steady.steady_film(case_of("rolling", 0.1, method="steady", nodes=257)).solutions[1:]
    for name in ("H_c", "H_min", "Delta"):
        assert orders([s.measure()[name] for s in solved])[0] > 1.8, name


# The whole plane of a track that is not symmetric, whose program it shares.  Newton's iteration would fill and empty
# the same nodes in turns, if it did not hold where the film is kinked.
SQUARE = {"nodes": 33, "half_width": 3.0, "half_width_y": 3.0, "inlet": 4.5}


@pytest.mark.slow
@pytest.mark.parametrize(
    "changes",
    [
        {"contact": {"radius_ratio": 0.5}},
        {"contact": {"radius_ratio": 0.5, "entrainment_angle": "30 deg"}, "solver": SQUARE},
        {"contact": {"radius_ratio": 0.5, "entrainment_angle": "30 deg"}, "solver": {**SQUARE, "nodes": 65}},
    ],
    ids=["ellipse", "at an angle", "at an angle, 65 nodes"],
)
def test_other_contacts_starve_too(changes: dict[str, Any]) -> None:
    data: dict[str, Any] = {"contact": {"kind": "rolling", "M": 200, "L": 10}, "lubricant": {"layer": 0.06}}
    data["solver"] = {"method": "steady", "nodes": 65}
    case = parse_case({name: {**section, **changes.get(name, {})} for name, section in data.items()})
    s = steady.steady_film(case).finest
    assert s.status.ok
    assert s.account.terms["inflow"] == pytest.approx(s.account.terms["outflow"], rel=1e-6)


# -- a track ----------------------------------------------------------------------------------------------------------


def rolled_after(track: Any, M: float = 200, nodes: int = 65) -> Result:
    return simulate(case_of("rolling", track, M, method="steady", nodes=nodes))


def test_a_track_loses_its_oil_to_the_sides() -> None:
    """Each pass pushes oil to the ridges: the film falls, the oil on the whole track is the same."""
    runs = [rolled_after(0.0712)]
    for _ in range(3):
        runs.append(rolled_after(runs[-1].track))
    films = [run.summary["H_c"] for run in runs]
    assert films[0] == pytest.approx(rolled_on(0.0712).measure()["H_c"], rel=1e-12)
    assert all(0.5 < later / earlier < 0.95 for earlier, later in pairwise(films))
    for run in runs:
        oil = np.array(run.track)[:, 1]
        assert np.mean(oil) == pytest.approx(0.0712, rel=1e-8)
        assert oil.max() > 2 * 0.0712  # in the ridges
        assert_allclose(oil, oil[::-1], rtol=1e-12)


@pytest.mark.slow
def test_a_track_with_more_oil_on_one_side_is_the_mirror_of_that_on_the_other() -> None:
    more = [[-1.0, 0.05], [1.0, 0.1]]
    one, other = (rolled_after(track, 50, 33) for track in (more, [[-1.0, 0.1], [1.0, 0.05]]))
    assert one.status.ok and other.status.ok
    assert_allclose(one.dataset["H"], other.dataset["H"][::-1], atol=1e-8)
    assert one.dataset["oil"][-1, 0] == pytest.approx(0.1)
    assert one.dataset["H"].sel(Y=0.75).min() > one.dataset["H"].sel(Y=-0.75).min()


def test_an_oil_may_have_the_track() -> None:
    points: Any = [[-1.0, 0.05], [1.0, 0.1]]
    in_oil = ertel.rolling(M=200, L=10, oil=ertel.Oil(layer=points))
    assert in_oil.digest == ertel.rolling(M=200, L=10, layer=points).digest
    with pytest.raises(ValueError, match=r"lubricant\.layer\[2\]\[2\] = -0\.1: must be .* above zero"):
        ertel.rolling(M=200, L=10, oil=ertel.Oil(layer=[[0.0, 0.1], [1.0, -0.1]]))


def test_a_run_that_leaves_no_track_is_refused() -> None:
    run = simulate(case_of("impact", 0.1, M=20, method="radial", nodes=33))
    with pytest.raises(ValueError, match="a rolling contact leaves a track"):
        run.track  # noqa: B018


# -- in time ----------------------------------------------------------------------------------------------------------


def test_a_rebound_loses_no_oil_to_its_cavity() -> None:
    """What is stored changes by what flows out of the last nodes that are solved, by both backward differences."""
    case = case_of("impact", None, M=20, nodes=33)
    method = Transient2D(case)
    levels = march(method, 0.05, 72)
    assert (np.asarray(levels[0].P) == 0).sum() > 100  # the film has cavitated
    for level in levels[:40:4]:
        assert abs(level.record["cavity_source"]) < 1e-12
        oil, P, H = (np.asarray(level.fields[name]) for name in ("mass", "P", "H"))
        assert np.all(oil > 0)
        assert np.all(oil[P == 0] <= H[P == 0] + case.solver.tolerance * case.film_scale)
    cavity = (np.asarray(levels[0].P) == 0) & (np.asarray(levels[8].P) == 0)
    late, early = (np.asarray(level.fields["mass"])[cavity] for level in (levels[0], levels[4]))
    assert_allclose(late, early, rtol=0.02)  # the oil stays; BDF2 swings a little where a node has just emptied


@pytest.mark.parametrize(("layer", "imbalance"), [pytest.param(None, 1e-6, marks=pytest.mark.slow), (0.15, 1e-12)])
def test_a_contact_that_rolls_back_finds_what_it_left(layer: float | None, imbalance: float) -> None:
    """The cavity behind the contact becomes its inlet; on a layer the film of both ways is nearly the same."""
    case = case_of("rolling", layer, M=20, method="transient", nodes=33)
    changes = {"motion": {"entrainment": [[0.0, 1.0], [2.0, -1.0]]}, "time": {"until": 9.0, "tolerance": 5e-3}}
    run = simulate(parse_case({**case.to_data(), "solver": {"method": "transient", "nodes": 33}, **changes}))
    assert run.status.ok
    assert run.summary["budgets"]["mass"]["imbalance"] < imbalance
    there, back = run.dataset["H_c"].values[[0, -1]]
    assert back == pytest.approx(there, rel=0.15 if layer is None else 0.01)


@pytest.mark.slow
def test_a_ball_that_falls_again_finds_the_cavity_that_it_left() -> None:
    """A load pulls the ball back into the pool, which has not filled all of the gap again."""
    case = case_of("impact", None, M=20, nodes=33)
    changes = {"motion": {"load": 0.3}, "time": {"until": 12.0, "tolerance": 5e-3}}
    run = simulate(parse_case({**case.to_data(), **changes}))
    assert run.status.ok
    V, H = run.dataset["V"].values, run.dataset["H_c"].values
    first, second = H[1:][(V[:-1] > 0) & (V[1:] <= 0)]
    assert second < 0.6 * first
    assert run.summary["budgets"]["mass"]["imbalance"] < 1e-12


def test_a_layer_is_neither_made_nor_lost_in_an_impact() -> None:
    case = case_of("impact", 0.1, M=20, nodes=33)
    method = Transient2D(case)
    levels = march(method, 0.05, 72)
    assert levels[0].velocity < 0 < levels[-1].velocity
    stored = [unfolded(np.asarray(level.fields["mass"]), method.grid.even).sum() for level in levels]
    assert_allclose(stored, stored[-1], rtol=1e-12)
    assert all(float(level.fields["mass"].min()) > 0 for level in levels)


@pytest.mark.slow
def test_the_oil_before_a_ball_that_falls_on_a_moving_layer_is_the_layer() -> None:
    """No waves run from the meniscus, which is where the layer meets the ball; two nodes beside it take its bank."""
    data = case_of("impact", 0.15, M=20, nodes=33).to_data()
    method = Transient2D(parse_case({**data, "motion": {"entrainment": 1.0}}))
    levels = march(method, 0.05, 40)
    wet = np.any([np.asarray(level.P) > 0 for level in levels], axis=(0, 1)).argmax()
    for level in levels:
        oil = np.asarray(level.fields["mass"])
        assert_allclose(oil[:, : wet - 2], 0.15, rtol=1e-12)
        assert oil.min() > 0.05
    assert float(levels[0].P.max()) > 0.5


@pytest.mark.slow
def test_a_rigid_sphere_meets_a_layer() -> None:
    """Before it gives way: the wet radius is 2 sqrt(h - H_0), and the force (1 - H_0/H_f)^2 of the flooded one.

    H_f = 2 h - H_0 is the film at the meniscus.  The flooded force of the parabola X^2/2 is pi lambda_bar V/(2 H_0).
    """
    layer, St = 0.3, 2000.0
    data = {"contact": {"lambda_bar": 16 / (15 * St), "alpha_bar": 0.0}, "solver": {"nodes": 65, "half_width": 2.0}}
    oil = {"viscosity": "isoviscous", "density": "incompressible", "layer": layer}
    method = Transient2D(parse_case({**data, "lubricant": oil}))
    for level in march(method, 0.01, 82):
        H_0 = -level.approach
        if H_0 < layer - 0.05:
            wet = np.sqrt((unfolded(np.asarray(level.P), method.grid.even) > 0).sum() / np.pi)
            assert wet * method.grid.spacing == pytest.approx(2 * np.sqrt(layer - H_0), abs=method.grid.spacing / 2)
            flooded = np.pi * method.contact.lambda_bar * level.velocity / (2 * H_0)
            assert level.load / flooded == pytest.approx((1 - H_0 / (2 * layer - H_0)) ** 2, rel=0.05)


@pytest.mark.parametrize(("layer", "H_c"), ON_A_LAYER)
def test_impacts_on_a_layer_against_another_program(layer: float, H_c: float) -> None:
    case = case_of("impact", layer, method="radial", nodes=129, half_width=2.5)
    method = RadialImpact(case)
    levels = march(method, 0.02, 160)
    top = max(levels, key=lambda level: level.approach)
    assert float(top.H[0]) == pytest.approx(H_c, rel=0.005)
    volume = np.asarray(method.mesh.volume)
    stored = [float(volume @ np.asarray(level.fields["mass"])) for level in levels]
    assert_allclose(stored, stored[-1], rtol=1e-10)
    wet = max(float(np.max(method.mesh.r, where=np.asarray(level.P) > 0, initial=0.0)) for level in levels)
    assert 0.85 < wet / wet_radius(layer) < 1.0


# -- estimates --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("r", STARVED)
def test_the_formula_of_the_starved_film(r: float) -> None:
    assert starved_share(r) == pytest.approx(STARVED[r], abs=0.02)


@pytest.mark.parametrize(("layer", "H_c"), ON_A_LAYER)
def test_the_film_that_is_expected_of_a_layer(layer: float, H_c: float) -> None:
    """In an impact, by the range of the flooded film, which is 5 % below the computed one here."""
    assert starvation(case_of("impact", layer))[1] == pytest.approx(H_c / 0.15347, rel=0.07)


def test_formulas_say_both_films() -> None:
    """A layer of what the flooded film takes leaves 2^(-1/g) of it, a thin one itself at the density in the contact."""
    case = case_of("rolling", None)
    flooded, density = formula_films(case)[0], float(case.lubricant.density(1.0))
    assert flooded.central is not None
    films = {film.name: film for film in formula_films(case_of("rolling", flooded.central * density))}
    assert films[flooded.name] == flooded
    assert films[f"{flooded.name}, starved"].central == pytest.approx(2 ** (-1 / 2.7) * flooded.central, rel=1e-12)
    thin = {film.name: film for film in formula_films(case_of("rolling", 1e-3))}[f"{flooded.name}, starved"]
    assert thin.central == pytest.approx(1e-3 / density, rel=1e-4) and thin.minimum is None


def test_a_ball_starts_above_its_layer() -> None:
    def starting(layer: Any, **time: float) -> Case:
        data = {"contact": {"M": 200, "L": 10}, "lubricant": {"layer": layer}, "time": time}
        return parse_case({**data, "solver": {"half_width": 6.0}})

    beside = [[0.0, 0.1], [0.3, 3.0]]  # thick where the ball comes near, too

    assert starting(0.5).schedule.start_approach == -1.0
    assert starting(3.0).schedule.start_approach == -3.0 and "starts in" not in " ".join(warnings_of(starting(3.0)))
    assert starting(beside).schedule.start_approach == -3.0
    for layer in (3.0, beside):
        assert "the ball starts in the oil" in " ".join(warnings_of(starting(layer, start_approach=-2.0)))


def test_oil_that_reaches_the_edge_is_said_before_the_run() -> None:
    said = warnings_of(case_of("impact", 0.5))
    assert len(said) == 1 and "may get to 2.1 a*, the edge is at 2); use solver.half_width >= 2.25" in said[0]
    assert not warnings_of(case_of("impact", 0.5, half_width=2.25))


def test_a_starved_film_stays_steady_whatever_the_step() -> None:
    case = case_of("rolling", 0.0712, method="transient", nodes=33)
    method = Transient2D(case)
    for step in (0.05, 0.4):
        late = march(method, step, 8)[0]
        for name in ("H", "mass"):
            assert_allclose(late.fields[name], method.start().fields[name], atol=1e-6)


@cache
def under_a_load_that_swings(nodes: int, until: float) -> Result:
    load = {"mean": 1.0, "amplitude": 0.4, "period": 3.0}
    return simulate(
        ertel.rolling(
            M=100,
            L=10,
            layer=0.05,
            nodes=nodes,
            method="transient",
            motion={"load": load},
            until=until,
            time_tolerance=1e-4,
        )
    )


@pytest.mark.slow
@pytest.mark.parametrize("until", [0.3, 6.0])
def test_the_oil_upstream_is_the_layer_while_the_load_swings(until: float) -> None:
    """No waves run from the meniscus: the oil before it is the layer, and no node is dried or flooded by them.

    The short run ends while a wave leaves.
    """
    run = under_a_load_that_swings(65, until)
    assert run.status.ok
    assert run.summary["budgets"]["mass"]["imbalance"] < 1e-12
    X, oil, P = (run.dataset[name].values for name in ("X", "oil", "P"))
    wet = X[np.any(P > 0, axis=(0, 1))].min()
    assert_allclose(oil[..., X < wet - 0.2], 0.05, rtol=1e-10)
    assert oil.min() > 0.02


@pytest.mark.slow
def test_the_film_under_a_load_that_swings_is_near_that_of_a_finer_grid() -> None:
    """H_c hardly depends on the load; on 257 nodes it is 0.0411 to 0.0423 in T = 3 to 6."""
    T, H = (under_a_load_that_swings(65, 6.0).dataset[name].values for name in ("time", "H_c"))
    late = H[T >= 3]
    assert 0.0405 < late.min() and late.max() < 0.0430


@pytest.mark.slow
@pytest.mark.parametrize("speed", [1.2, 0.8])
def test_a_film_that_settles_becomes_the_steady_one(speed: float) -> None:
    """Whatever the start, whose menisci are elsewhere, and although a step is longer than a cell."""
    given = {"M": 200, "L": 10, "layer": 0.0712, "nodes": 65}
    motion = {"entrainment": [[0, speed], [1, 1]]}
    run = simulate(ertel.rolling(**given, method="transient", motion=motion, until=14.0, step=0.1))
    steady = simulate(ertel.rolling(**given)).summary["H_c"]
    assert run.dataset["H_c"].values[-1] == pytest.approx(steady, rel=3e-3)


TURNS = {"stop and start": [[0, 1], [2, 0], [3, 0], [5, 1]], "there and back": [[0, 1], [4, -1]]}


@pytest.mark.slow  # 1 min each
@pytest.mark.parametrize(("name", "nodes", "change"), [("stop and start", 129, 1e-5), ("there and back", 65, 0.05)])
def test_a_thin_layer_is_kept_where_the_flow_stops_or_turns(name: str, nodes: int, change: float) -> None:
    """And the film comes back; where it turns the contact rolls on the track that it left.

    On 65 nodes the steady equations have a second film, whose meniscus is a node away in one row: H_c differs by 3e-4.
    """
    motion = {"entrainment": TURNS[name]}
    given = {"nodes": nodes, "method": "transient", "motion": motion, "until": 12.0, "time_tolerance": 1e-4}
    run = simulate(ertel.rolling(M=100, L=10, layer=0.05, **given))
    assert run.status.ok
    assert run.summary["budgets"]["mass"]["imbalance"] < 1e-12
    assert run.dataset["oil"].values.min() > 0.0
    first, last = run.dataset["H_c"].values[[0, -1]]
    assert last == pytest.approx(first, rel=change)


def test_more_oil_reaches_the_contact_with_the_flow() -> None:
    """Starved rolling at a falling speed: the film thins, and no oil is lost."""
    data = case_of("rolling", 0.0712, method="transient", nodes=33).to_data()
    case = parse_case({**data, "motion": {"entrainment": [[0, 1], [1, 0.5]]}})
    levels = march(Transient2D(case), 0.05, 40)
    assert all(abs(level.record["cavity_source"]) < 1e-12 for level in levels[:-1])
    inflow = [level.record["inflow"] for level in levels[:-1]]
    assert inflow[0] == pytest.approx(0.0712 * 6 * 0.5, rel=0.03)


# -- what is given ----------------------------------------------------------------------------------------------------


def test_the_oil_that_both_surfaces_bring() -> None:
    """(u1 h1 + u2 h2)/u_m in rolling, h1 + h2 in an impact."""
    contact = {"kind": "rolling", "M": 200, "L": 10}
    sliding = {"contact": contact, "motion": {"slide_to_roll": 0.4}, "lubricant": {"layer_1": 0.05, "layer_2": 0.03}}
    assert parse_case(sliding).layer == pytest.approx(1.2 * 0.05 + 0.8 * 0.03)
    on_one = {"contact": {**contact, "kind": "impact"}, "lubricant": {"layer_2": 0.03}}
    assert parse_case(on_one).layer == pytest.approx(0.03)
    assert case_of("rolling", None).layer is None


@pytest.mark.parametrize(
    ("lubricant", "motion", "message"),
    [
        ({"layer": 0.0}, {}, r"lubricant\.layer = 0.*above zero"),
        ({"layer": -0.1}, {}, r"lubricant\.layer = -0\.1.*above zero"),
        ({"layer_1": -1.0}, {}, r"lubricant\.layer_1 = -1\.0.*above zero"),
        ({"layer": 5.0}, {}, r"lubricant\.layer = 5.*edge of the grid"),
        ({"layer": 0.1, "layer_1": 0.1}, {}, r"lubricant\.layer = 0\.1.*layer_1 and layer_2"),
        ({"layer_1": 0.1}, {"slide_to_roll": 3.0}, r"layer_1, layer_2.*slide_to_roll = 3"),
    ],
)
def test_layers_that_make_no_sense_are_refused(lubricant: Any, motion: Any, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        parse_case({"contact": {"kind": "rolling", "M": 200, "L": 10}, "lubricant": lubricant, "motion": motion})


@pytest.mark.parametrize(
    ("shape", "field"), [(Waviness(0.1, 0.5), "amplitude = 0.1"), (SelfAffine(0.1, 0.8, 0.2, 1.0), "rms = 0.1")]
)
def test_a_layer_covers_the_roughness(shape: Any, field: str) -> None:
    smooth = case_of("impact", 0.05)
    with pytest.raises(ValueError, match=rf"lubricant\.layer = 0\.05.*roughness\[1\]\.{field}"):
        replace(smooth, roughness=(Feature(shape),))
    assert replace(smooth, roughness=(Feature(Waviness(0.05, 0.5)),)).layer == 0.05


def test_an_impact_on_a_very_thick_layer_begins_above_it_and_is_read_again() -> None:
    case = ertel.impact(M=1000, L=10, method="radial", half_width=64, nodes=33, layer=1010.0)
    assert case.schedule.start_approach == -1010.0
    assert Case.from_data(case.to_data()) == case


@pytest.mark.parametrize("respond", [respond_linearly, respond_in_rolling])
def test_a_linear_response_is_that_of_a_flooded_contact(respond: Any) -> None:
    kind = "impact" if respond is respond_linearly else "rolling"
    with pytest.raises(ValueError, match=r"lubricant\.layer: must be left out"):
        respond(case_of(kind, 0.05, nodes=33), [[Feature(Waviness(0.01, 0.5))]])
