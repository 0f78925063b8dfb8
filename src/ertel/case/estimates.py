"""The grid of a case on the plane, and estimates without a run: of layers of oil and of a physical contact."""

from math import floor, inf, log2, sqrt

import numpy as np

from ertel.case.case import Case
from ertel.numerics.grid import NO_SYMMETRY, Grid, Symmetry
from ertel.physics import hertz, surfaces
from ertel.physics.film_formulas import IMPACT_EXPONENT, starved_share
from ertel.physics.line_films import expected_line_film

CELLS_SHOWN, CELLS_OF_DETAIL = 16.0, 8.0  # least number in the contact's half width, in the finest detail of a surface
LARGEST_NEWTONIAN_STRESS = 6e6  # Pa: the stress at which squalane begins to thin (Liu et al. 2023, see the library)
_PLACES = np.polynomial.legendre.leggauss(64)


def grid_of(case: Case) -> Grid:
    """The grid of a case on the plane; the inlet is on the upstream side at T = 0."""
    s = case.solver
    centre = 0.0 if s.inlet is None else s.half_width - s.inlet
    upstream_is_left = case.motion.entrainment(0.0) >= 0
    centre_x = centre if upstream_is_left else -centre
    return Grid(s.nodes, case.method.space.across(s), case.spacing, centre_x, even=_symmetry(case, centre_x))


def _symmetry(case: Case, centre_x: float) -> Symmetry:
    """The axes about which a case is symmetric; the flow is along X."""
    in_y, in_x = (a and b for a, b in zip(surfaces.even(case.features), case.geometry.even, strict=True))
    in_y = in_y and (case.track is None or case.track.is_even)
    return Symmetry(in_y, in_x and not case.motion.flows and centre_x == 0) if case.solver.fold else NO_SYMMETRY


def coarsenings(case: Case, spacing: float, most: int) -> int:
    """The number of times, at most `most`, that a grid can be coarsened and still show contact and roughness.

    Once more where a meniscus passes node after node: then half as many cells show the contact.  Once more, too, along
    a rolling line, where the few nodes of the pressure spike are a large share of all.
    """
    shown = CELLS_SHOWN if case.layer is None else CELLS_SHOWN / 2
    shown = shown / 2 if case.geometry.is_line and not case.starts_apart else shown
    finest = min((getattr(f.shape, "size", 0.0) for f in case.features), default=inf)
    widest = min(case.geometry.smaller / shown, finest / CELLS_OF_DETAIL)
    return min(most, max(0, floor(log2(widest / spacing) + 1e-9))) if widest > 0 else 0


# -- estimates for layers of oil --------------------------------------------------------------------------------------


def starvation(case: Case) -> tuple[float, float]:
    """r, the oil of the layers over that of the flooded film, and the share of that film which is expected.

    Of an impact at maximum approach.  Infinite and 1 for a full gap.
    """
    if case.layer is None:
        return inf, 1.0
    flooded = sum(case.parameters.impact_films) / 2 if case.starts_apart else case.film_scale
    r = case.layer / (float(case.lubricant.density(1.0)) * flooded)
    return r, share_of(case, r)


def largest_film(case: Case) -> float:
    """The largest film of a rolling line contact in time, over that of T = 0, by the formula of the expected film."""
    if case.is_steady:
        return 1.0
    moments = [(w, abs(U), c) for w, U, c in case.motion.moments(case.schedule.duration) if w > 0.0 and U]
    films = []
    for w, U, c in moments:
        at = case.parameters.at(w, U, c)
        films.append(expected_line_film(at) * c * case.geometry.grown(w, c)[0] ** 2)
    return max(films) / films[0]


def share_of(case: Case, r: float) -> float:
    """The share of the flooded film on a layer of oil that is r times as thick."""
    if case.starts_apart:
        return starved_share(r, IMPACT_EXPONENT)
    return min(r, 1.0) if case.geometry.is_line else starved_share(r)  # nothing leaks out of a line to the sides


def wet_radius(layer: float) -> float:
    """The radius (a) up to which a layer (a^2/R) is wet by a ball at maximum approach, at most.

    The oil that the ball displaces fills the dry gap around the contact.  In the computed impacts it is 6 to 13 %
    smaller: the film holds oil back.  Early, where the ball is rigid, it is 2 sqrt(layer - H_0).
    """
    r = np.linspace(0.0, 2.0 * sqrt(layer + 1.0), 1001)[1:]
    mean_gap = 2.0 * np.cumsum(hertz.gap(r) * r) * r[0] / r**2
    return float(np.interp(layer, mean_gap, r))


# -- estimates of a physical contact --------------------------------------------------------------------------------


def film_estimate(case: Case) -> float:
    """The expected central film thickness (m), an impact's by its scale; infinite for a dimensionless case."""
    return case.film_scale * starvation(case)[1] * case.scales.film if case.scales else inf


def largest_pressure(case: Case) -> float:
    """The maximum Hertz pressure (Pa) at the largest load, an impact's without oil; zero for a dimensionless case."""
    if case.scales is None:
        return 0.0
    load, curvature = (signal.range(inf)[1] for signal in (case.motion.load, case.motion.curvature))
    return case.scales.p_h * (1.0 if case.starts_apart else case.geometry.grown(load, curvature)[1])


def newtonian_stress(case: Case) -> float:
    """The mean shear stress (Pa) that sliding gives a Newtonian oil; zero without sliding and for a dimensionless case.

    eta u_s/h with the film of a formula, and the mean over the contact of the viscosity at the Hertz pressure:

        2 integral from 0 to 1 of eta(p_h s) s ds,      p = p_h s at the radius sqrt(1 - s^2)

    Along a line it is the integral from 0 to 1 of eta(p_h sqrt(1 - x^2)) dx.
    """
    sliding = max(map(abs, case.motion.sliding.range(inf)))
    if case.scales is None or case.oil.eta0 is None or not sliding:
        return 0.0
    z, weight = _PLACES
    s, share = (1.0 + z) / 2.0, (1.0 + z) / 2.0
    if case.geometry.is_line:
        s, share = np.sqrt(1.0 - s**2), np.full_like(s, 0.5)
    with np.errstate(over="ignore", divide="ignore", invalid="ignore"):
        growth = float(np.sum(weight * share * case.oil.viscosity_law.viscosity(largest_pressure(case) * s)))
    stress = growth * case.oil.eta0 * sliding * case.scales.front_speed / film_estimate(case)
    return stress if stress >= 0.0 else inf  # beyond the pole of a modulus law
