"""Rolling in time: limits that tie it to the steady film and to the impact, conservation, order, work."""

from collections.abc import Sequence
from dataclasses import replace
from functools import cache
from itertools import pairwise
from math import pi

import jax
import numpy as np
import pytest
import xarray as xr
from cases import OIL, free_ball, rolled, steps_of
from cases import march as levels_of

from ertel.case.case import Case
from ertel.case.methods import METHODS
from ertel.case.sections import Drive, Time
from ertel.equations import contact
from ertel.equations.flow import Rate
from ertel.equations.outside import predicted
from ertel.equations.state import State
from ertel.physics.dry_contact import HERTZ_LOAD
from ertel.physics.motion import Oscillation, Polyline, Smooth, constant
from ertel.physics.scales import Parameters
from ertel.physics.surfaces import Feature, SelfAffine, Spot, Waviness
from ertel.results.balances import in_time
from ertel.solvers import steady
from ertel.solvers.transient import Transient2D

P20 = Parameters.from_moes(20, 5)  # a thick film: resolved by few nodes
TIGHT = 1e-8


def rolling(
    drive: Drive | None = None, *features: Feature, nodes: int = 33, time: Time | None = None, **solver
) -> Case:
    grid = replace(METHODS["transient"].defaults, **{"nodes": nodes, "tolerance": TIGHT, **solver})
    return rolled(P20, OIL, grid, drive, *features, time=time)


def march(case: Case, step: float, steps: int) -> list[State]:
    """Levels of a fixed-step run, newest first."""
    return levels_of(Transient2D(case), step, steps)


def total_pressure(level: State) -> float:
    """The sum over the nodes of the whole plane; the film is kept for Y >= 0."""
    P = np.asarray(level.P)
    return float(P[0].sum() + 2 * P[1:].sum())


def largest(a, b) -> float:
    return float(np.abs(np.asarray(a) - np.asarray(b)).max())


# -- limits -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("shape", "step"), [(Waviness(0.0, 0.5, 0.5), 0.05), (Spot(0.3, 0.0, x=-1.0), 0.37)])
def test_moving_roughness_of_no_height_leaves_the_film_steady(shape, step) -> None:
    """To the tolerance of the solver, from the first step, with steps of a fourth of a cell and of two cells."""
    last, *_, first = march(rolling(None, Feature(shape)), step, 10)
    assert largest(last.H, first.H) < 10 * TIGHT
    assert abs(last.approach - first.approach) < 10 * TIGHT
    assert largest(last.P, first.P) < 1e-6


def test_a_disturbed_film_comes_back_to_the_steady_one() -> None:
    """After the load has doubled for a while; the disturbance leaves with the oil, in about 2 t0."""
    push = Polyline(((0.0, 1.0), (0.2, 2.0), (0.4, 1.0)))
    last, *_, first = march(rolling(Drive(load=push)), 0.1, 80)
    assert largest(last.H, first.H) < 1e-5


def test_reversing_everything_mirrors_everything() -> None:
    """U -> -U and the roughness mirrored, in time."""
    feature = Waviness(0.02, 0.8, phase_x=0.4)
    there = march(rolling(None, Feature(feature)), 0.05, 6)[0]
    back = Drive(entrainment=constant(-1.0))
    here = march(rolling(back, Feature(replace(feature, phase_x=-0.4))), 0.05, 6)[0]
    assert largest(np.asarray(here.H)[:, ::-1], there.H) < 1e-7
    assert largest(np.asarray(here.P)[:, ::-1], there.P) < 1e-6


def impact_on_a_track(speed: float) -> State:
    """A free ball in its own scales, on a surface that moves."""
    return march(impact_over(speed), 0.05, 30)[0]


def impact_over(speed: float) -> Case:
    solver = replace(METHODS["2d"].defaults, nodes=33, tolerance=TIGHT, fold=False)
    case = free_ball(P20, OIL, solver, Time(start_approach=-0.5))
    return replace(case, drive=Drive(entrainment=Polyline(((0.0, speed),))))


@pytest.mark.slow
def test_without_entrainment_a_rolling_contact_with_inertia_is_the_impact() -> None:
    """U -> 0: the same fields, though solved by another preconditioner; and a small U matters little."""
    still, slow, slower = (impact_on_a_track(speed) for speed in (0.0, 1e-2, 1e-9))
    assert float(still.P.max()) > 0.5  # past the first touch
    assert largest(still.P, np.asarray(still.P)[:, ::-1]) < 1e-8
    assert largest(slower.H, still.H) < 1e-7
    assert abs(slower.approach - still.approach) < 1e-8
    assert 1e-6 < largest(slow.H, still.H) < 1e-2


def test_a_ball_that_hits_a_track_leans_the_film_towards_the_inlet() -> None:
    moving = impact_on_a_track(0.3)
    lean = np.asarray(moving.P) - np.asarray(moving.P)[:, ::-1]
    assert lean[:, :16].sum() > 0.01  # more pressure upstream
    found = Transient2D(impact_over(0.3)).measure(moving)
    H, x = np.asarray(moving.H), np.linspace(-2.0, 2.0, 33)
    i, j = np.unravel_index(np.argmin(np.where(np.asarray(moving.P) > 0, H, np.inf)), H.shape)
    assert (found["X_min"], found["Y_min"]) == pytest.approx((x[j], abs(x[i])))
    np.testing.assert_allclose(np.asarray(moving.P)[::-1], np.asarray(moving.P), atol=1e-7)


def test_little_inertia_is_none() -> None:
    """A light ball under a varying load follows the balance of load."""
    load = Oscillation(1.0, 0.2, 4.0)
    without = march(rolling(Drive(load=load)), 0.05, 12)[0]
    difference = []
    for inertia in (1e-3, 1e-4):
        light = march(rolling(Drive(load=load, inertia=inertia)), 0.05, 12)[0]
        difference.append(abs(light.approach - without.approach))
    assert difference[0] < 2e-3
    assert difference[1] < 0.2 * difference[0]


def test_a_heavy_ball_swings_about_the_applied_load() -> None:
    """A step of the load makes the ball swing past the new balance."""
    load = Polyline(((0.0, 1.0), (0.05, 1.2)))
    levels = march(rolling(Drive(load=load, inertia=0.5)), 0.05, 50)
    loads = [total_pressure(level) * (6 / 32) ** 2 / HERTZ_LOAD for level in levels]
    assert max(loads) > 1.3 and loads[0] < max(loads) - 0.1


# -- signals: curvature and slide-to-roll ratio -----------------------------------------------------------------------


def test_a_curvature_that_stays_is_another_radius() -> None:
    """A gap c times as curved is the contact of bodies with R/c: the same films, in its own units of length."""
    c, p = 2.0, P20
    s = c ** (-1 / 3)  # a of that contact
    other = Parameters(p.lambda_bar / (c**2 * s), p.alpha_bar * c * s)
    bent = march(rolling(Drive(curvature=constant(c))), 0.1, 4)
    grid = replace(METHODS["transient"].defaults, nodes=33, tolerance=TIGHT, half_width=3.0 / s, inlet=4.5 / s)
    small = march(rolled(other, OIL, grid), 0.1 / s, 4)
    for one, two in zip(bent, small, strict=True):
        assert largest(one.H, c * s**2 * np.asarray(two.H)) < 10 * TIGHT
        assert largest(one.P, c * s * np.asarray(two.P)) < 10 * TIGHT
        assert one.outside == pytest.approx(two.outside, rel=1e-6)  # F* is that of the contact itself


SWAY = Oscillation(1.0, 0.2, 3.0)


@pytest.mark.slow
def test_a_curvature_and_a_slide_to_roll_ratio_that_change_are_mirrored_with_the_speed() -> None:
    feature = Waviness(0.02, 0.8, phase_x=0.4)
    signals = Drive(curvature=SWAY, slide_to_roll=Oscillation(0.5, 0.4, 2.0))
    there, *_, first = march(rolling(signals, Feature(feature)), 0.1, 4)
    back = replace(signals, entrainment=constant(-1.0))
    here = march(rolling(back, Feature(replace(feature, phase_x=-0.4))), 0.1, 4)[0]
    assert largest(np.asarray(here.H)[:, ::-1], there.H) < 1e-7
    assert largest(first.H, there.H) > 0.1  # at the edge of the grid


@pytest.mark.slow
def test_a_ratio_given_as_a_signal_is_the_ratio() -> None:
    """The position of the roughness and the friction; where it changes, both follow."""
    wave = Feature(Waviness(0.02, 0.8))
    number, signal, changing = (
        rolling(Drive(slide_to_roll=ratio), wave) for ratio in (0.5, Smooth(((0.0, 0.5), (9.0, 0.5))), SWAY)
    )
    one, two = (march(case, 0.1, 3)[0] for case in (number, signal))
    assert largest(one.H, two.H) < 1e-12 and one.record["mu_sliding"] == pytest.approx(two.record["mu_sliding"])
    another = march(changing, 0.1, 3)[0]
    expected = one.record["mu_sliding"] * SWAY(0.3) / 0.5
    assert another.record["mu_sliding"] == pytest.approx(expected, rel=0.02)
    assert changing.motion.travel(1, 0.3) == pytest.approx(0.3 + 0.5 * SWAY.integral(0.3))


def test_a_signal_of_many_points_does_not_force_a_step_a_point() -> None:
    """The film of 201 points in 1 t0 is that of 26, in as many steps."""
    runs = []
    for points in (26, 201):
        times = np.linspace(0.0, 1.0, points)
        signal = Smooth(tuple(zip(times.tolist(), SWAY.at(times).tolist(), strict=True)))
        case = rolling(Drive(curvature=signal, load=signal), time=Time(until=1.0), tolerance=1e-4)
        runs.append(steps_of(case, Transient2D(case)))
    few, many = runs
    assert len(many) < 1.05 * len(few) + 2 and len(many) < 100
    assert many[-1].record["H_c"] == pytest.approx(few[-1].record["H_c"], rel=1e-3)


@pytest.mark.parametrize(("nodes", "most"), [(33, 0.02), pytest.param(65, 0.005, marks=pytest.mark.slow)])
def test_the_budgets_of_a_gap_that_changes_its_curvature(nodes: int, most: float) -> None:
    """The work of the gap that bends is part of the energy: without it the budget would not close on the finer grid.

    Energy 1.18 and .28 % on 33 and 65 nodes: of second order, as the bounds are.  Mass closes to round-off.
    """
    flatter = Smooth(tuple((0.1 * n, 1.0 - 0.015 * n) for n in range(16)))
    time = Time(until=1.5, step=0.05 * 32 / (nodes - 1))
    case = rolling(Drive(curvature=flatter), nodes=nodes, time=time, tolerance=1e-6)
    records = [step.record for step in steps_of(case, Transient2D(case))]
    columns = {name: ("time", [record[name] for record in records]) for name in records[0]}
    data = xr.Dataset(columns, {"time": [record["T"] for record in records]})
    found = {name: terms["imbalance"] for name, terms in in_time(case, data).items()}
    assert found["mass"] < 1e-12 and found["energy"] < most
    turned_over = float(np.trapezoid(data["power_from_surfaces"], data["time"]))
    assert 1.5 * 0.15 / 5 > 0.01 * turned_over  # -dc/dT times the integral of P G under the pressure of Hertz


# -- laws -------------------------------------------------------------------------------------------------------------


def test_the_load_is_balanced_at_every_step() -> None:
    load = Oscillation(1.0, 0.3, 2.0)
    for level in march(rolling(Drive(load=load)), 0.05, 10):
        F = (total_pressure(level) * (6 / 32) ** 2 + level.outside) / HERTZ_LOAD
        assert F == pytest.approx(load(level.T), abs=1e-8)


def test_the_oil_outside_is_squeezed_by_the_speed_of_the_same_step() -> None:
    """While the bodies come nearer and while they part."""
    method = Transient2D(rolling(Drive(load=Oscillation(1.0, 0.3, 2.0))))
    levels = levels_of(method, 0.05, 14)
    for i in (0, 9):
        new, T = levels[i], levels[i].T
        motion = predicted(levels[i + 1 :], T, HERTZ_LOAD, 1.0)
        motion = motion._replace(velocity=new.velocity, load_rate=0.3 * pi * np.cos(pi * T))
        around, still = (method.outside.at(m) for m in (motion, motion._replace(velocity=0.0, load_rate=0.0)))
        assert abs(around.load / still.load - 1) > 0.03
        assert new.outside == pytest.approx(around.load, rel=3e-3)
        edge = method.outside.is_edge
        assert np.asarray(new.P)[edge] == pytest.approx(around.edge[edge], abs=3e-3 * around.edge.max())


@pytest.mark.usefixtures("nothing_outside")
def test_each_level_solves_reynolds_equation() -> None:
    """With the roughness where it is by then, and the earlier oil from upstream, here exactly one node in each step.

    The slope of the void of the start, which is of first order, is put in the place of that of second order.
    """
    case = rolling(None, Feature(Waviness(0.02, 0.8)))
    method, step = Transient2D(case), 6 / 32
    now, before, earlier, *_ = march(case, step, 6)
    H = jax.jit(contact.film_thickness)(method.contact_at(now.T), now.P, now.approach)
    assert largest(H, now.H) < 1e-12
    mass, (old, older) = (
        np.asarray(jax.jit(contact.mass)(method.contact, now.P, H)),
        (np.asarray(o.fields["mass"]) for o in (before, earlier)),
    )
    following = np.zeros_like(mass)
    following[:, 2:] = (1.5 * mass[:, 2:] - 2.0 * old[:, 1:-1] + 0.5 * older[:, :-2]) / step
    oil, full, void, *_ = map(np.asarray, method.start_content)
    missing = full - oil
    following[:, 2:] += (1.5 * missing[:, 2:] - 2.0 * missing[:, 1:-1] + 0.5 * missing[:, :-2]) / step
    following[:, 2:] -= (void[:, 2:] - void[:, 1:-1]) / step
    squeeze_and_wedge = jax.jit(contact.residual)(method.contact, now.P, H, Rate(0.0, following))
    r = np.asarray(squeeze_and_wedge)[:, 3:-1] * step / 1.5
    P = np.asarray(now.P)[:, 3:-1]
    assert np.abs(r[P > 0]).max() < 3 * TIGHT
    assert r.min() > -3 * TIGHT


@pytest.mark.slow
def test_a_film_wave_travels_at_the_mean_speed_of_the_surfaces() -> None:
    """A short rise of the speed makes a ridge of oil at the inlet, which is carried through the contact at u_m."""
    pulse = Drive(entrainment=Polyline(((0.0, 1.0), (0.2, 1.4), (0.4, 1.0))))
    levels = march(rolling(pulse, nodes=65, tolerance=1e-6), 0.05, 32)
    x = Transient2D(rolling(nodes=65)).grid.x
    inside = np.abs(x) < 0.8
    steady = np.asarray(levels[-1].H)[0]  # along the axis
    carried = [level for level in levels if level.T > 0.55]
    crest = [x[inside][np.argmax((np.asarray(level.H)[0] - steady)[inside])] for level in carried]
    speed = np.polyfit([level.T for level in carried], crest, 1)[0]
    assert speed == pytest.approx(1.0, abs=0.05)


ROUGH = SelfAffine(rms=0.02, hurst=0.8, shortest=0.8, longest=2.0, seed=2, front=-0.5, ramp=1.0)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("case", "cells"),
    [
        (rolling(Drive(load=Oscillation(0.8, 0.2, 4.0, pi / 2)), nodes=65), 2),  # without a kink at T = 0
        (rolling(None, Feature(ROUGH), nodes=65), 4),
    ],
    ids=["load", "roughness"],
)
def test_second_order_in_time(case: Case, cells: int) -> None:
    """Under a load that swells gently, and over heights with two continuous derivatives that move.

    Upstream of the exit, where the film is smooth.  At the exit it changes within a cell or two.
    """
    films = [np.asarray(march(case, 6 / 64 / n, cells * n)[0].H) for n in (4, 8, 16)]
    upstream = Transient2D(case).grid.x < 0.4
    coarse, fine = (np.abs(late - early)[:, upstream].max() for early, late in pairwise(films))
    assert np.log2(coarse / fine) > 1.7


@cache
def shaken(halvings: int, periods: int = 2) -> dict[str, float]:
    """The end of a run under a load that oscillates quickly, with both tolerances halved so many times."""
    share = 0.5**halvings
    time = Time(until=0.1 * periods, tolerance=share * Time().tolerance)
    tolerance = share * METHODS["transient"].defaults.tolerance
    case = rolling(Drive(load=Oscillation(1.0, 0.3, 0.1)), time=time, tolerance=tolerance)
    steps = steps_of(case, Transient2D(case))
    assert steps[-1].status.ok
    return {**steps[-1].record, "steps": len(steps)}


def check_refining(halvings: Sequence[int], periods: int = 2) -> None:
    """The error of a run falls with the power 2/3 of the tolerances: what the steps leave over does not add up."""
    *runs, finest = (shaken(each, periods) for each in halvings)
    for each, run in zip(halvings, runs, strict=False):
        bound = 0.5 ** (2 / 3 * each) * periods / 2
        assert abs(run["H_c"] / finest["H_c"] - 1) < 5e-4 * bound
        assert abs(run["H_min"] / finest["H_min"] - 1) < 1e-3 * bound
        assert abs(run["Delta"] - finest["Delta"]) < 5e-4 * bound


def check_steps(halvings: Sequence[int], periods: int = 2) -> None:
    """The number of steps grows with the power -1/3 of the tolerances, as the local error is of third order."""
    growth = shaken(halvings[-1], periods)["steps"] / shaken(halvings[0], periods)["steps"]
    assert growth < 1.5 * 2 ** ((halvings[-1] - halvings[0]) / 3)


@pytest.mark.slow
def test_refining_in_time_does_not_drift() -> None:
    check_refining((0, 3), periods=1)
    check_steps((0, 3), periods=1)


@pytest.mark.slow
def test_halving_the_tolerances_ten_times_converges() -> None:
    check_refining(range(11))


@pytest.mark.slow
@pytest.mark.xfail(strict=True, reason="29.3 times the steps, 15.1 allowed: a node of the cavity that fills has a kink")
def test_halving_the_tolerances_ten_times_takes_few_steps() -> None:
    check_steps(range(11))


# -- the run ----------------------------------------------------------------------------------------------------------


def test_a_run_starts_from_the_steady_film_and_ends_in_time() -> None:
    case = rolling(time=Time(until=0.5), tolerance=1e-3)
    steps = steps_of(case, Transient2D(case))
    film = steady.settled(case).finest.measure()
    first, last = steps[0], steps[-1]
    assert first.frames[0].T == 0.0
    assert last.status.ok and last.record["T"] == pytest.approx(0.5)
    assert [frame.event for step in steps for frame in step.frames][-1] == "end"
    for name in ("H_c", "H_min", "X_min", "Y_min", "P_max", "Delta"):
        assert last.record[name] == pytest.approx(film[name], abs=1e-5)
    assert (last.record["U"], last.record["w"]) == (1.0, 1.0)
    assert last.record["F"] == pytest.approx(1.0, abs=1e-5)


@pytest.mark.slow
def test_work_of_a_step() -> None:
    """A cavity passes: 11.4 convolutions a step in the mean."""
    cavity = Feature(Spot(0.3, depth=0.05, x=-1.8))
    case = rolling(None, cavity, nodes=65, time=Time(until=1.0, tolerance=2e-4), tolerance=1e-3)
    steps = steps_of(case, Transient2D(case))
    work = [step.record["convolutions"] for step in steps]
    assert steps[-1].status.ok
    assert np.mean(work) < 13.6, np.mean(work)
