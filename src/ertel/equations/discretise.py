"""The contact of a case on a grid: the surfaces at a given time, and the oil.

Unlike `jnp.asarray`, `jax.device_put` has nothing to compile.
"""

from collections.abc import Sequence
from dataclasses import replace
from math import inf

import jax
import numpy as np
from jax import Array
from numpy.typing import NDArray

from ertel.case.case import Case
from ertel.equations import contact, outside
from ertel.equations.contact import NEWTONIAN_FLOW, Contact, PressureFlow, traceable
from ertel.equations.outside import Outside
from ertel.equations.thinning import ThinningFlow
from ertel.equations.touch import Asperities
from ertel.numerics.grid import Grid
from ertel.physics import surfaces
from ertel.physics.surfaces import CELLS_KEPT, Feature

INSTANT = 1e-4  # t0, half the time over which the change of the gap is taken


def outside_of(case: Case, grid: Grid) -> Outside:
    """The oil outside the grid; beside a layer of oil the gap is not full, so that there is no pressure."""
    lambda_bar = case.parameters.lambda_bar if case.layer is None else 0.0
    return outside.around_grid(grid, lambda_bar, case.geometry)


def layer_of(case: Case, grid: Grid) -> Array | None:
    """The oil per area that the surfaces bring along, at each Y, shape (n, 1); None where the gap is full."""
    return None if case.track is None else jax.device_put(case.track.across(grid.kept_y)[:, None])


def smooth_contact(case: Case, grid: Grid) -> Contact:
    """The two surfaces without roughness, and the oil at T = 0."""
    smooth = contact.bare_contact(case.geometry, grid, case.parameters.lambda_bar, case.lubricant)
    return replace(smooth, flow=flow_of(case, 0.0), asperities=asperities_of(case))


def asperities_of(case: Case) -> Asperities | None:
    """The law of the asperities in the units of the case; None where none touch."""
    curve, given, scales = case.asperities, case.surfaces, case.scales
    if curve is None or given is None or scales is None:
        return None
    friction = given.friction / scales.a_over_R
    return Asperities.of(curve.capped(given.hardness or inf), scales.p_h, scales.film, friction)


def flow_of(case: Case, T: float) -> PressureFlow:
    """The flow by the pressure gradient at time T: a shear-thinning oil is thinned by the sliding at that time."""
    if case.oil.is_newtonian:
        return NEWTONIAN_FLOW
    scales = case.scales
    assert scales is not None  # a rule of cases
    law = traceable(case.oil.fluidity_law)
    return ThinningFlow(law, scales.p_h, scales.shear_stress, case.motion.sliding(T))


def contact_of(case: Case, grid: Grid, T: float = 0.0) -> Contact:
    """The two surfaces and the oil at time T on a grid."""
    return roughened(smooth_contact(case, grid), case, grid, T)


def roughened(smooth: Contact, case: Case, grid: Grid, T: float) -> Contact:
    """The smooth contact with its curvature and the oil's flow at time T, and the case's roughness where it is then."""
    smooth = replace(smooth, flow=flow_of(case, T))
    if case.motion.bends:
        smooth = replace(smooth, gap=case.motion.curvature(T) * smooth.gap)
    if not case.features:
        return smooth
    return replace(smooth, gap=smooth.gap - heights(case.features, case, grid, T))


def heights(features: Sequence[Feature], case: Case, grid: Grid, T: float) -> Array:
    """The height of the roughness on the grid at time T; it moves with the surfaces.

    Of rough surfaces the waves that are too short for the grid are left out (`CELLS_KEPT`), so that a coarse grid does
    not mistake them for longer ones.
    """
    X, Y = grid.kept_x[None, :], grid.kept_y[:, None]
    return jax.device_put(surfaces.height(features, case.motion, T, X, Y, CELLS_KEPT * grid.spacing))


def gap_slope(case: Case, grid: Grid) -> Array:
    """dG/dX of the smooth gap G of the case, which is a parabola: the central difference is exact."""
    X, Y = grid.kept_x[None, :], grid.kept_y[:, None]
    return jax.device_put((case.geometry.gap(X + 1.0, Y) - case.geometry.gap(X - 1.0, Y)) / 2.0)


def gap_change(case: Case, grid: Grid, T: float) -> Array:
    """The rate of change of the undeformed gap, roughness included, following the flow, while its curvature stays."""
    slope, change = np.asarray(gap_slope(case, grid)), np.asarray(roughness_change(case, grid, T))
    return jax.device_put(case.motion.entrainment(T) * case.motion.curvature(T) * slope - change)


def roughness_change(case: Case, grid: Grid, T: float) -> Array | float:
    """The rate of change of the roughness following the flow, by a central difference; 0.0 where nothing slides."""
    motion = case.motion
    if not (case.features and motion.slides):
        return 0.0
    drift, Y = motion.entrainment.integral, grid.kept_y[:, None]

    def at(T_near: float) -> NDArray[np.float64]:
        X = grid.kept_x[None, :] + drift(T_near) - drift(T)
        return surfaces.height(case.features, motion, T_near, X, Y, CELLS_KEPT * grid.spacing)

    return jax.device_put((at(T + INSTANT) - at(T - INSTANT)) / (2.0 * INSTANT))
