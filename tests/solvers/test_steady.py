"""Steady rolling against independent solutions of the same discretisation, and against the laws it must keep.

The reference numbers are those of reference/rolling.json: "grids" (the exact solution on N x N nodes) and "converged"
(extrapolated), H in units a^2/R.  They were made by a classical multigrid program and a dense Newton code.
"""

from dataclasses import replace
from functools import cache
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from cases import BARUS, BARUS_LIMIT, extrapolated, rolled, steady_solver

from ertel.case.case import Case
from ertel.case.sections import Drive
from ertel.equations import contact, discretise
from ertel.equations.approach import balanced
from ertel.equations.flow import Rate, steady_rate
from ertel.numerics import multigrid, newton, stencils
from ertel.physics.dry_contact import HERTZ_LOAD
from ertel.physics.geometry import CIRCLE
from ertel.physics.lubricant import Oil
from ertel.physics.motion import constant
from ertel.physics.scales import Parameters
from ertel.solvers import guesses, nonlinear, steady
from ertel.solvers.steady import Rolling

pytestmark = pytest.mark.usefixtures("nothing_outside")

ROELANDS = Oil(alpha=2.2e-8, p0=196078400.0, z=0.668678)  # "rheology" of the reference
OILS = {"barus": BARUS, "roelands": ROELANDS}
FILM_THICKNESS = jax.jit(contact.film_thickness)
NAMES = ("Delta", "H_c", "H_min", "P_c")

GRIDS = {  # fluid, M, L: nodes: Delta, H_c, H_min, P_c
    ("barus", 100, 0): {
        129: (0.93977579, 0.03951914, 0.02717971, 0.982632),
        257: (0.9386755, 0.04056314, 0.02791778, 0.982459),
    },
    ("barus", 200, 10): {
        65: (0.92960042, 0.07258829, 0.02937287, 1.008965),
        129: (0.91471012, 0.09309097, 0.03821461, 1.018565),
        257: (0.91067729, 0.09864828, 0.04114936, 1.021538),
    },
    ("roelands", 20, 10): {
        65: (0.55893303, 0.4190912, 0.28639004, 1.03406),
        129: (0.55143025, 0.42871573, 0.29095988, 1.036504),
        257: (0.54944296, 0.43115262, 0.29220633, 1.036958),
    },
    ("roelands", 200, 10): {
        65: (0.93708968, 0.05987772, 0.02574207, 1.00053),
        129: (0.92425832, 0.07630199, 0.03584297, 1.007339),
        257: (0.92075247, 0.08073866, 0.0382728, 1.00926),
    },
    ("roelands", 1000, 10): {
        129: (0.98343241, 0.01608136, 0.00423125, 1.000055),
        257: (0.97862093, 0.0223264, 0.00687585, 1.002772),
    },
}
CONVERGED = {  # H_c, its uncertainty
    ("barus", 100, 0): (0.040877, 4e-6),
    ("barus", 200, 10): (0.100544, 4e-6),
    ("roelands", 20, 10): (0.431967, 2.1e-5),
    ("roelands", 200, 10): (0.08226, 4e-6),
    ("roelands", 1000, 10): (0.024643, 6e-6),
}
# quick: one oil on 129 nodes a side, the other on 65; slow: all on 257.  Each oil on each grid is to be compiled
FINEST = {("roelands", 20, 10): 129, ("roelands", 200, 10): 129, ("roelands", 1000, 10): 129, ("barus", 200, 10): 65}
QUICK = list(FINEST.items())
SLOW = [pytest.param(key, 257, marks=pytest.mark.slow) for key in GRIDS]
every_case = pytest.mark.parametrize(("key", "nodes"), [*QUICK, *SLOW], ids=str)


def case_of(key: tuple[str, float, float], nodes: int, drive: Drive | None = None, **solver: Any) -> Case:
    fluid, M, L = key
    return rolled(Parameters.from_moes(M, L or BARUS_LIMIT), OILS[fluid], steady_solver(nodes, **solver), drive)


@cache
def rolling(key: tuple[str, float, float], nodes: int = 129, entrainment: float = 1.0, fold: bool = True) -> Rolling:
    drive = Drive(entrainment=constant(entrainment)) if entrainment != 1.0 else None
    return steady.steady_film(case_of(key, nodes, drive, fold=fold))


@every_case
def test_the_discrete_solution_is_the_references(key, nodes) -> None:
    """To four digits on every grid."""
    found = {s.grid.nodes: s.measure() for s in rolling(key, nodes).solutions}
    published = {n: values for n, values in GRIDS[key].items() if n <= nodes}
    assert published
    for n, values in published.items():
        assert [found[n][name] for name in NAMES] == pytest.approx(values, rel=1e-4), n


def dense_film(M: float, n: int) -> tuple[np.ndarray, np.ndarray, float]:
    """P, H and Delta of an isoviscous oil on n x n nodes, those with Y >= 0: the reference's discretisation once more.

    Nothing of ertel is used: Newton's iteration with NumPy's dense matrices, to a residual of 1e-12.  u holds P inside
    the edge, Delta and, always one, the factor of the gap, so that H and P at all nodes are matrices times u.
    """
    h, lambda_bar = 6 / (n - 1), (128 * np.pi**3 / (3 * M**4)) ** (1 / 3)
    i, j = np.divmod(np.arange((n // 2 + 1) * n), n)
    X, Y = -4.5 + h * j, h * i
    a, b = h * (np.arange(n + 1) - 0.5), h * (np.arange(n + 1)[:, None] - 0.5)  # the corners of a cell, from a node
    love = np.diff(np.diff(a * np.arcsinh(b / abs(a)) + b * np.arcsinh(a / abs(b))), axis=0) * 2 / np.pi**2
    along = abs(j - j[:, None])
    deformation = love[abs(i - i[:, None]), along] + np.where(i > 0, love[i + i[:, None], along], 0.0)
    k = np.flatnonzero((j > 0) & (j < n - 1) & (i < n // 2))
    around = k - 1, k + 1, k + n, np.where(i[k] > 0, k - n, k + n)
    gap = (X**2 + Y**2) / 2
    film = np.column_stack([deformation[:, k], -np.ones(i.size), gap])
    pressure = np.zeros_like(film)
    pressure[k, range(k.size)] = 1.0
    second = np.where(j[k] > 1, 0.5, 0.0)[:, None]  # the first node has but one upstream
    wedge = (film[k] - film[k - 1] + second * (film[k] - 2 * film[k - 1] + film[k - 2])) / h
    load = np.append(h**2 * np.where(i[k] > 0, 2.0, 1.0), [0.0, 0.0])
    u = np.append(np.sqrt(np.maximum(1 - 2 * gap[k], 0.0)), [0.9, 1.0])  # Hertz' pressure, and a gap
    for _ in range(20):
        H, P = film @ u, pressure @ u
        eps, rise = H**3 / lambda_bar, 3 * H**2 / lambda_bar
        residual, jacobian = wedge @ u, wedge.copy()
        for q in around:
            mean, slope = (eps[q] + eps[k]) / (2 * h**2), (P[q] - P[k]) / (2 * h**2)
            residual -= mean * (P[q] - P[k])
            jacobian -= mean[:, None] * (pressure[q] - pressure[k])
            jacobian -= (slope * rise[q])[:, None] * film[q] + (slope * rise[k])[:, None] * film[k]
        free = np.append((P[k] > 0) | (residual < 0), True)
        left = np.append(residual, load @ u - 2 * np.pi / 3)[free]
        if abs(left).max() < 1e-12:
            return P.reshape(-1, n), H.reshape(-1, n), u[-2]
        u[:-1][free] -= np.linalg.solve(np.vstack([jacobian, load])[free, :-1][:, free], left)
        u[:-2] = np.maximum(u[:-2], 0.0)
    raise AssertionError(f"not solved: {abs(left).max()}")


@pytest.mark.parametrize(("M", "nodes"), [(30, 33), pytest.param(100, 65, marks=pytest.mark.slow)])
def test_a_dense_newton_iteration_finds_the_same_film(M: float, nodes: int) -> None:
    """At every node.  The second is a row of the reference that is not exact, and so not among `GRIDS`.

    Its H_min, 0.02380523, is 1.02e-4 (relative) above the 0.02380280 that both programs find.  A residual of 6e-5 left
    at the thinnest film would move H_min as far.  Its Delta, H_c and P_c agree to 1e-5, its row of 129 nodes to 3e-7.
    """
    s = rolling(("barus", M, 0), nodes).finest
    P, H, approach = dense_film(M, nodes)
    np.testing.assert_allclose(np.asarray(s.P), P, rtol=0, atol=1e-7)
    np.testing.assert_allclose(np.asarray(s.H), H, rtol=0, atol=1e-8)
    assert s.approach == pytest.approx(approach, abs=1e-8)


@every_case
def test_every_grid_converges_with_bounded_work(key, nodes) -> None:
    """Residual 1e-8 from the Hertz pressure; neither Newton's nor the Krylov iterations grow with the grid."""
    for s in rolling(key, nodes).solutions:
        assert s.status.ok and s.residual <= 1e-8
        assert s.newton <= 10, s.grid.nodes
        assert s.krylov <= 8 * s.newton, s.grid.nodes


@pytest.mark.parametrize(("key", "nodes"), [*QUICK[:2], *SLOW], ids=str)
def test_the_error_estimate_is_honest(key, nodes) -> None:
    """The true error of H_c lies within a factor 2 of the estimate, and extrapolation gains a factor 4 at least."""
    exact, uncertainty = CONVERGED[key]
    found = extrapolated(rolling(key, nodes), "H_c")
    true = abs(found.value - exact)
    assert 0.5 < true / found.error < 2
    assert abs(found.extrapolated - exact) < true / 4 + uncertainty


@pytest.mark.parametrize(("nodes", "least"), [(129, 1.85), pytest.param(257, 1.9, marks=pytest.mark.slow)])
def test_second_order_in_space(nodes: int, least: float) -> None:
    """H_c and Delta on 33, 65 and 129 nodes a side, or on 65, 129 and 257, where the film is resolved."""
    for name in ("H_c", "Delta"):
        values = [s.measure()[name] for s in rolling(("roelands", 20, 10), nodes).solutions[-3:]]
        order = np.log2((values[1] - values[0]) / (values[2] - values[1]))
        assert order > least, (name, order)


def test_reversing_the_flow_mirrors_the_solution() -> None:
    there = rolling(("barus", 200, 10), 65).finest
    back = rolling(("barus", 200, 10), 65, -1.0).finest
    np.testing.assert_allclose(back.grid.x, -there.grid.x[::-1])
    np.testing.assert_allclose(np.asarray(back.H)[:, ::-1], np.asarray(there.H), atol=1e-8)
    np.testing.assert_allclose(np.asarray(back.P)[:, ::-1], np.asarray(there.P), atol=1e-7)


@pytest.mark.slow
def test_symmetry_across_the_flow() -> None:
    s = rolling(("roelands", 200, 10), 33, fold=False).finest
    np.testing.assert_allclose(np.asarray(s.P)[::-1], np.asarray(s.P), atol=1e-7)
    np.testing.assert_allclose(np.asarray(s.H)[::-1], np.asarray(s.H), atol=1e-8)


@every_case
def test_the_load_is_carried_by_the_film(key, nodes) -> None:
    s = rolling(key, nodes).finest
    assert s.measure()["load"] == pytest.approx(HERTZ_LOAD, abs=2e-8)
    c = discretise.contact_of(case_of(key, nodes), s.grid)
    H = FILM_THICKNESS(c, s.P, s.approach)
    np.testing.assert_allclose(np.asarray(s.H), np.asarray(H), atol=1e-12)


def test_pressure_is_nowhere_negative_and_oil_lacks_only_where_there_is_none() -> None:
    """P >= 0, the residual is zero where P > 0 and not negative where P = 0."""
    key = ("roelands", 200, 10)
    s = rolling(key).finest
    c = discretise.contact_of(case_of(key, 129), s.grid)
    r = np.asarray(jax.jit(lambda c, P, H: contact.residual(c, P, H, steady_rate(1.0)))(c, s.P, s.H))
    P = np.asarray(s.P)
    assert P.min() >= 0
    assert np.abs(r[P > 0]).max() <= 1e-8
    assert r.min() >= -1e-8


@pytest.mark.slow
def test_mass_is_conserved_along_the_flow() -> None:
    """Upstream of cavitation, what flows through a section and what left at the sides before it add up to one constant.

    The wedge is the derivative of the flux 3/2 (rho H)_i - 1/2 (rho H)_{i-1} from cell face to cell face.
    """
    key = ("roelands", 200, 10)
    s = rolling(key, 33, fold=False).finest
    c = discretise.contact_of(case_of(key, 33), s.grid)
    h, P = s.grid.spacing, np.asarray(s.P)
    mass = c.lubricant.density(P) * np.asarray(s.H)
    eps = np.asarray(jax.jit(lambda c, P, H: c.flow.mobilities(c, P, H).secant.x)(c, s.P, s.H))
    carried = (1.5 * mass[:, 1:-1] - 0.5 * mass[:, :-2])[1:-1]
    pressed = (-(eps[:, 2:] + eps[:, 1:-1]) / 2 * (P[:, 2:] - P[:, 1:-1]) / h)[1:-1]
    through = h * np.sum(carried + pressed, axis=0)  # at the faces i + 1/2, i = 1 ...
    sides = [(eps[a, 1:-1] + eps[b, 1:-1]) / 2 * (P[b, 1:-1] - P[a, 1:-1]) / h for a, b in ((0, 1), (-1, -2))]
    lost = h * np.cumsum(sides[0] + sides[1])
    total = through + lost
    full = np.flatnonzero(np.all(P[1:-1, 1:-1] > 0, axis=0))
    full = full[full > 1]
    assert len(full) > 0.6 * len(total)
    np.testing.assert_allclose(total[full], total[full[0]], rtol=1e-7)


def test_pressure_tends_to_hertz() -> None:
    s = rolling(("roelands", 1000, 10)).finest
    hertz, _ = guesses.dry_guess(CIRCLE, s.grid, 1.0)
    assert np.sqrt(np.mean((np.asarray(s.P) - hertz) ** 2)) < 0.02


@pytest.mark.parametrize("part", ["load", "entrainment"])
def test_no_load_or_no_flow_is_refused(part) -> None:
    with pytest.raises(ValueError, match=rf"^motion\.{part} = 0.0: is 0 at T = 0"):
        case_of(("barus", 200, 10), 129, Drive(**{part: constant(0.0)}))


@cache
def solved_to(tolerance: float, M: float, nodes: int, L: float = 10, fluid: str = "roelands") -> Rolling:
    found = steady.steady_film(case_of((fluid, M, L), nodes, tolerance=tolerance))
    assert found.finest.status.ok
    return found


@pytest.mark.parametrize(
    ("nodes", "to_a_millionth", "to_the_grids_error"),
    [(129, [57] * 3, [28] * 3), pytest.param(257, [67] * 3, [34, 33, 28], marks=pytest.mark.slow)],
)
def test_what_is_left_is_less_than_a_tenth_of_the_error_of_the_grid_at_half_the_work(
    nodes: int, to_a_millionth: list[int], to_the_grids_error: list[int]
) -> None:
    """Work in convolutions on the finest grid, all grids together, at M = 20, 200, 1000.

    To a residual of a millionth 51, 51 and 50 on 129 nodes, 61, 56 and 51 on 257; to what the grid is worth 26, 25 and
    26, and 31, 30 and 26.
    """
    for M, most, few in zip((20, 200, 1000), to_a_millionth, to_the_grids_error, strict=True):
        exact, found = (solved_to(tolerance, M, nodes) for tolerance in (1e-6, steady.AS_EXACT_AS_THE_GRID))
        assert exact.convolutions <= most and found.convolutions <= few, M
        for film in ("H_c", "H_min"):
            discretisation = extrapolated(exact, film).error
            assert abs(found.finest.measure()[film] - exact.finest.measure()[film]) < 0.1 * discretisation, M
            assert extrapolated(found, film).error == pytest.approx(discretisation, rel=0.1), M


@pytest.mark.parametrize("fluid", ["barus", "roelands"])
@pytest.mark.parametrize("M", [10, 100, 3000, *(pytest.param(M, marks=pytest.mark.slow) for M in (30, 300, 1000))])
def test_every_load_and_lubricant_converges(fluid: str, M: float) -> None:
    """From the default start, to 1e-8, on 65 nodes a side and half of them, resolved or not."""
    for L in (0, 2.5, 5, 10, 20):
        if fluid == "barus" or L > 0:
            assert all(s.status.is_solved for s in rolling((fluid, M, L), 65).solutions), (L,)


# -- the preconditioner -----------------------------------------------------------------------------------------------


def test_the_diagonal_knows_how_the_viscosity_changes() -> None:
    """At the foot of a spike it is larger than with the viscosity held fixed; the film is held fixed here."""
    case = case_of(("roelands", 20, 10), 33)
    film = rolling(("roelands", 20, 10), 33).finest
    grid = film.grid
    elastic = multigrid.deformation_operators(grid, CIRCLE.compliance, "float64")
    c = discretise.contact_of(case, grid)
    problem = nonlinear.Problem(c, elastic, Rate(0.0, 0.0), balanced(), 1.0, 1.0, steady.ALGORITHMS)

    @jax.jit
    def coefficients(problem: nonlinear.Problem, P: jax.Array, H: jax.Array, unit: jax.Array) -> tuple[Any, ...]:
        """Those of the finest grid, the sum of the mobilities at the faces, and what the operator makes of a unit."""
        free = jnp.where(P > 0.0, 1.0, 0.0)
        level = nonlinear.multigrid_levels(problem, P, H, free, 1.0, multigrid.point_smoother)[0]
        c = level.coefficients
        return c, stencils.face_sum(c.eps, grid.even), level.operator(unit, jnp.zeros(grid.shape))

    nothing = np.zeros(grid.shape)
    c, faces, _ = coefficients(problem, film.P, film.H, nothing)
    faces = np.asarray(faces) / grid.spacing**2
    steepening = np.asarray(c.steepening) * np.asarray(c.free)
    foot = np.unravel_index(np.argmax(steepening / faces), faces.shape)
    assert steepening[foot] > 0.3 * faces[foot]
    nothing[foot] = 1.0
    found = float(coefficients(problem, film.P, film.H, nothing)[2][foot])
    assert found == pytest.approx(faces[foot] + steepening[foot], rel=1e-9)


def test_the_film_does_not_depend_on_the_preconditioner(monkeypatch) -> None:
    """The identity in its place, with as many Krylov iterations as it takes, gives the same film."""
    found = rolling(("roelands", 20, 10), 17).finest
    options = replace(steady.OPTIONS, krylov_limit=300, first_reduction=1e-6)
    plain = nonlinear.Algorithms(nonlinear.approach_as_unknown, lambda *_: newton.Inverse(lambda r: r), options)
    monkeypatch.setattr(steady, "ALGORITHMS", plain)
    same = steady.steady_film(case_of(("roelands", 20, 10), 17)).finest
    assert found.status.ok and same.status.ok and same.krylov > 10 * found.krylov
    for name in ("P", "H", "approach"):
        np.testing.assert_allclose(getattr(same, name), getattr(found, name), atol=1e-6, err_msg=name)


SHARP = [
    *((("barus", 3000, 20), nodes) for nodes in (33, 65, 129)),
    (("roelands", 1000, 10), 129),
]


@pytest.mark.slow  # another program for each grid
@pytest.mark.parametrize(("key", "nodes"), SHARP, ids=str)
def test_the_preconditioner_loses_nothing_in_single_precision(key, nodes, monkeypatch) -> None:
    """Beside double: the Krylov iterations.  Barus' viscosity is far beyond single precision."""
    single = rolling(key, nodes)
    monkeypatch.setattr(nonlinear, "PRECISION", "float64")
    double = steady.steady_film(case_of(key, nodes))
    for s, d in zip(single.solutions, double.solutions, strict=True):
        assert s.status.is_solved and d.status.is_solved
        assert s.krylov <= d.krylov + 2


@pytest.mark.slow
@pytest.mark.parametrize(("M", "L", "bound"), [(20, 10, 41), (300, 20, 46)])
def test_the_sharpest_spikes_converge_on_a_fine_grid(M: float, L: float, bound: int) -> None:
    """Barus on 513 nodes a side; Krylov iterations there: 37, and 37 to 42, where round-off decides."""
    assert solved_to(1e-6, M, 513, L, "barus").finest.krylov <= bound


def test_the_krylov_iterations_do_not_grow_with_the_grid() -> None:
    """M = 1000, to 1e-6, on 65 and 129 nodes a side: 15, 16."""
    *_, coarse, fine = (s.krylov for s in solved_to(1e-6, 1000, 129).solutions)
    assert fine <= 1.1 * coarse


@pytest.mark.slow
@pytest.mark.parametrize("nodes", [513, 1025])
def test_the_krylov_iterations_do_not_grow_on_fine_grids(nodes: int) -> None:
    """M = 1000, to 1e-6, from 65 nodes a side to 1025: 15, 16, 19, 20, 23."""
    found = {s.grid.nodes: s.krylov for s in solved_to(1e-6, 1000, nodes).solutions}
    assert 0.7 * found[257] <= min(found[65], found[129]) <= max(found[65], found[129]) <= 1.3 * found[257]
    assert found[nodes] <= 1.3 * found[257]


def test_the_isoviscous_film_grows_with_the_speed_to_three_fifths() -> None:
    """L = 0: H_c follows 0.438 lambda_bar^{3/5} from below, a tenth off at M = 100."""
    films = {M: extrapolated(rolling(("roelands", M, 0), 129), "H_c").extrapolated for M in (30, 100)}
    speeds = {M: Parameters.from_moes(M, 0).lambda_bar for M in films}
    exponent = np.log(films[100] / films[30]) / np.log(speeds[100] / speeds[30])
    assert exponent == pytest.approx(0.6, abs=0.015)
    assert 0.8 < films[100] / (0.438 * speeds[100] ** 0.6) < 1.0
