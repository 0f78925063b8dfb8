"""The coefficients of the V-cycle, held against the Jacobian that they stand for."""

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from cases import OIL, rolled, steady_solver

from ertel.case.definition import grid_of
from ertel.equations import discretise
from ertel.equations.approach import balanced
from ertel.equations.flow import Rate
from ertel.numerics import multigrid, newton, stencils
from ertel.physics.geometry import CIRCLE
from ertel.physics.scales import Parameters
from ertel.solvers import nonlinear, steady
from ertel.solvers.nonlinear import Problem


def test_the_diagonal_knows_how_the_viscosity_changes() -> None:
    """At the foot of a spike it is larger than with the viscosity held fixed; the film is held fixed here."""
    case = rolled(Parameters.from_moes(20, 10), OIL, steady_solver(33))
    grid = grid_of(case)
    film = steady.steady_film(case).finest
    problem = Problem(
        discretise.contact_of(case, grid),
        multigrid.deformation_operators(grid, CIRCLE.compliance, "float64"),
        Rate(0.0, 0.0),
        balanced(),
        1.0,
        1.0,
        nonlinear.approach_as_unknown,
        nonlinear.point_preconditioner,
        newton.Options(),
    )

    @jax.jit
    def coefficients(problem: Problem, P: jax.Array, H: jax.Array, unit: jax.Array) -> tuple[Any, ...]:
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
