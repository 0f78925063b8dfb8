"""Fields kept on one side of an axis: the same numbers as on the whole plane."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from cases import OIL, free_ball, rolled, steady_solver
from jax import Array
from made_up import even_fields, every_symmetry
from numpy.testing import assert_allclose

from ertel.case.estimates import grid_of
from ertel.case.sections import Solver, Time
from ertel.equations import contact
from ertel.equations.contact import Contact
from ertel.equations.flow import Rate
from ertel.equations.state import State
from ertel.numerics.grid import NO_SYMMETRY, Grid, Symmetry
from ertel.numerics.stencils import extended, folded, total, unfolded
from ertel.physics.geometry import CIRCLE
from ertel.physics.lubricant import Barus, DowsonHigginson, Lubricant
from ertel.physics.scales import Parameters
from ertel.physics.surfaces import Feature, RingWaviness, Spot, Waviness
from ertel.solvers import steady
from ertel.solvers.transient import Transient2D

PARAMETERS = Parameters.from_moes(50, 5)
LAWS = Lubricant(Barus(5.0), DowsonHigginson(1.0))


def grid(even: Symmetry = NO_SYMMETRY) -> Grid:
    return Grid(17, 17, 0.2, even=even)


def bump(even: Symmetry) -> np.ndarray:
    """Random and even, zero on the edge, on the whole plane."""
    return np.pad(even_fields(even, 15, 15), 1)


@every_symmetry
def test_unfolding_undoes_folding(even) -> None:
    whole = bump(even)
    kept = folded(whole, even)
    assert kept.shape == grid(even).shape
    assert_allclose(unfolded(jnp.asarray(kept), even), whole)


@every_symmetry
def test_the_total_is_that_of_the_whole_plane(even) -> None:
    whole = bump(even)
    assert float(total(jnp.asarray(folded(whole, even)), even)) == pytest.approx(whole.sum(), rel=1e-14)


@every_symmetry
def test_beyond_an_axis_is_the_mirror_image(even) -> None:
    whole = bump(even)
    found, expected = (np.asarray(extended(*field)) for field in ((folded(whole, even), even), (whole, NO_SYMMETRY)))
    rows, columns = found.shape
    assert_allclose(found, expected[-rows:, -columns:])


@jax.jit
def film_residual_and_load(c: Contact, P: Array, U: float) -> tuple[Array, Array, Array]:
    H = contact.film_thickness(c, P, -0.2)
    return H, contact.residual(c, P, H, Rate(3.0, 0.1 * P, U)), contact.pressure_load(c, P)


@every_symmetry
def test_the_residual_is_that_of_the_whole_plane(even) -> None:
    """Of eq. (1), with the oil carried along where X is whole."""
    whole, U = bump(even), 0.0 if even.x else 1.0
    results = []
    for g in (grid(), grid(even)):
        c = contact.bare_contact(CIRCLE, g, 0.1, LAWS)
        H, r, load = film_residual_and_load(c, folded(whole, g.even), U)
        results.append([unfolded(np.asarray(f), g.even) for f in (H, r)] + [load])
    for expected, found in zip(*results, strict=True):
        assert_allclose(found, expected, rtol=1e-11, atol=1e-11)


def test_a_symmetric_grid_is_centred() -> None:
    with pytest.raises(ValueError, match="centred"):
        Grid(17, 17, 0.2, centre_x=-1.0, even=Symmetry(x=True))


# -- whole solutions --------------------------------------------------------------------------------------------------

TIGHT = {"nodes": 33, "tolerance": 1e-11}


def impact(fold: bool, *features: Feature) -> tuple[Transient2D, State]:
    solver = Solver("2d", half_width=2.0, fold=fold, **TIGHT)
    method = Transient2D(free_ball(PARAMETERS, OIL, solver, Time(start_approach=-0.5), *features))
    levels = [method.start()]
    for _ in range(20):
        levels.insert(0, method.advance(levels[:3], 0.05))
    return method, levels[0]


@pytest.mark.parametrize("features", [(), (Feature(Waviness(0.01, 0.8, 0.5)),), (Feature(RingWaviness(0.01, 0.8)),)])
def test_a_symmetric_impact_on_a_quarter_of_the_plane(features) -> None:
    (whole, expected), (quarter, found) = impact(False, *features), impact(True, *features)
    assert found.P.shape == (17, 17)
    assert float(expected.P.max()) > 0.3
    assert_allclose(quarter.whole(found.H), expected.H, atol=1e-10)
    assert_allclose(quarter.whole(found.P), expected.P, atol=1e-10)
    assert found.approach == pytest.approx(expected.approach, abs=1e-11)
    assert quarter.measure(found) == pytest.approx(whole.measure(expected), abs=1e-9)


@pytest.mark.parametrize(
    ("features", "shape"),
    [
        ((Feature(Waviness(0.01, 0.5, 0.5, phase_y=0.3)),), (33, 17)),
        ((Feature(Waviness(0.01, 0.5, phase_x=0.3)),), (17, 33)),
        ((Feature(Waviness(0.01, 0.5, phase_x=np.pi)),), (17, 17)),
        ((Feature(Spot(0.2, 0.01)), Feature(Spot(0.2, 0.01, y=0.1))), (33, 17)),
    ],
)
def test_what_is_not_symmetric_is_not_folded(features, shape) -> None:
    solver = Solver("2d", **TIGHT)
    assert grid_of(free_ball(PARAMETERS, OIL, solver, None, *features)).shape == shape


def test_steady_rolling_on_half_the_plane() -> None:
    results = []
    for fold in (False, True):
        results.append(steady.steady_film(rolled(PARAMETERS, OIL, steady_solver(fold=fold, **TIGHT))).finest)
    whole, half = results
    assert half.P.shape == (17, 33)
    assert_allclose(unfolded(half.H, half.grid.even), whole.H, atol=1e-10)
    assert half.measure() == pytest.approx(whole.measure(), abs=1e-9)
