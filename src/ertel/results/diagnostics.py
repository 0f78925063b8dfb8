"""Warnings if grid, domain, inlet or initial gap are not sufficient, each with a remedy."""

from collections.abc import Iterator, Sequence
from math import ceil, inf, isfinite, sqrt
from typing import TYPE_CHECKING, Any

import numpy as np

from ertel.case.case import Case
from ertel.case.height_map import Measured
from ertel.case.methods import as_written, of_kind
from ertel.case.rules import computes
from ertel.case.sections import MOST_NODES, WIDEST_HALF_WIDTH
from ertel.case.spaces import FRONT_POSITION
from ertel.case.status import Status
from ertel.numerics.grid import Extrapolation, allowed_nodes, on_grids
from ertel.physics.line_scales import LineScales
from ertel.physics.surfaces import CELLS_IN_WAVE, CELLS_KEPT, has_waves
from ertel.physics.thermal import AT_REST, AT_REST_ON_A_LINE, INLET_FACTORS, SLOWEST, slow_excess
from ertel.results.balances import UNCERTAIN_MOMENTUM, Balances, needed_half_width, share_outside, uncertain_momentum
from ertel.results.numbers import UNKNOWN
from ertel.results.variables import FILMS

if TYPE_CHECKING:
    import xarray as xr

    from ertel.results.dataset import SteadyGrid

CELLS_IN_FRONT = 10.0  # wanted across the length of the front's pressure sweep, `sweep_length`
ISOVISCOUS_SWEEP = 2.0  # that length over (lambda_bar dA/dT)^{2/5} where the oil is isoviscous
SWEEP_ALPHA_BAR = 10.0  # least alpha_bar in that length for rolling
GAP_SHARE = 3.0  # initial gap in units of the trapped film, below which the shape depends on it
OUTSIDE_SHARE = 0.25  # of the load of a rolling contact that the oil outside the domain may carry
SHORT_LINE = 20.0  # half widths: below, the ends of a line contact count
LARGE_ERROR = 0.1  # of a film: its estimated discretisation error from which it is said to be uncertain
LARGE_IMBALANCE = 0.01  # of a balance, from which there is a warning
MEANING = {  # of an imbalance
    "mass": "oil is gained or lost on the grid",
    "momentum": "the motion of the ball and the load differ",
    "energy": "the dissipation is uncertain by more than that",
}
LARGE_CONTACT = 0.3  # a/R, up to which the parabola is within a few per cent of a sphere
CLEARLY_THINNER = 0.95  # phi_T below which the error of the inlet formula is said


def impact_warnings(case: Case, data: "xr.Dataset") -> list[str]:
    """Warnings about grid, domain or initial gap of an impact; an empty list if there are none."""
    return [*_film(case, data), *resolution(case), *_domain(case, data), *case_warnings(case)]


def rolling_warnings(case: Case, data: "xr.Dataset") -> list[str]:
    """Warnings about grid and inlet of a transient rolling contact; an empty list if there are none."""
    vanishes = list(_film(case, data))
    resolved = vanishes or [*resolution(case, _mean_speed(data)), *_outside(case, share_outside(data))]
    return [*resolved, *case_warnings(case)]


def steady_warnings(case: Case, solutions: "Sequence[SteadyGrid]") -> list[str]:
    """Warnings about grid and domain of a steady contact; an empty list if there are none."""
    finest = solutions[-1]
    failure = steady_failure(case, finest)
    outside = _outside(case, finest.outside / case.geometry.hertz_load / case.motion.load(0.0))
    return [*([failure] if failure else _grid(case, solutions)), *outside, *case_warnings(case)]


def case_warnings(case: Case) -> list[str]:
    """Warnings that follow from the case alone, without a run; an empty list if there are none."""
    start = _gap(case) if case.starts_apart else _centre(case)
    return [*start, *_roughness(case), *_maps(case), *_size(case)]


def steady_failure(case: Case, solution: "SteadyGrid") -> str:
    """The reason why there is no steady solution, with a remedy; "" where there is one."""
    if not solution.status.is_solved:
        why = f"residual {solution.residual:.2g}, {case.solver.tolerance:g} is allowed"
        why = why if isfinite(solution.residual) else "the iteration led to values that are not numbers"
        why = solution.status.value if solution.status is Status.NO_AGREEMENT else why
        if case.touches and _cells(case, case.motion.entrainment(0.0))[0] < CELLS_IN_FRONT:
            return f"the solution failed ({why}): {no_film(case)}"
        return f"the solution failed ({why}), and the run has no result; {solution.status.advice}"
    return "" if solution.measure()["H_min"] > 0.0 else no_film(case)


# -- balances and friction --------------------------------------------------------------------------------------------


def balance_warnings(case: Case, balances: Balances) -> list[str]:
    """A warning for every balance that does not close; an empty list if all do."""
    return [
        f"{name} is not conserved: imbalance of {terms['imbalance']:.1%} (limit {LARGE_IMBALANCE:.0%}), "
        f"{MEANING[name]}; {_closing(case, name)}"
        for name, terms in balances.items()
        if (terms["imbalance"] or 0.0) > LARGE_IMBALANCE
    ]


def _closing(case: Case, name: str) -> str:
    """The remedy for an imbalance: a finer grid, unless it is an integral over time only, and shorter steps."""
    grid = _use(2 * case.solver.nodes - 1)
    if case.is_steady:
        return f"use solver.tolerance <= {case.solver.tolerance / 10:g}" if name == "momentum" else grid
    time = case.schedule
    steps = f"time.step <= {time.step / 2:g}" if time.step else f"time.tolerance <= {time.tolerance / 4:g}"
    return f"use {steps}" if name == "momentum" else f"{grid} and {steps}"


# -- resolution -------------------------------------------------------------------------------------------------------


def sweep_length(case: Case, speed: float = 0.0) -> float:
    """Length of the pressure sweep in a: at the front of an impact, or in the inlet of rolling with the entrainment U.

    Rolling: sqrt(alpha_bar lambda_bar U).  With ten cells across it the steady films for M = 20 to 1000 and L = 5 to 10
    are 4 to 7 % too thin in the centre and up to 15 % at the minimum.  Isoviscous films need as many cells as if
    alpha_bar were about 10.

    Impact, at X = 0.9 of the dry one: sqrt(alpha_bar lambda_bar dA/dT), but at least 2 (lambda_bar dA/dT)^{2/5}, that
    of an oil whose viscosity does not matter there: at the distance l from the edge of a Hertz contact P goes with
    l^{1/2} and H with l^{3/2}, so that dP/dX = lambda_bar dA/dT/H^2 gives l^{5/2} (Snoeijer JH, Eggers J, Venner CH.
    Phys Fluids 2013;25:101705).  The factor is measured: with ten cells across it H_min is 2, 3 and 4 % too small for
    lambda_bar = 0.01, 0.001 and 0.0001 and alpha_bar = 0, and 3 % for 0.001 and alpha_bar = 3 and 10.  The dry impact
    of an ellipsoid takes longer by the dry approach in a*^2/R.
    """
    p = case.parameters
    if not case.starts_apart:
        return float((max(p.alpha_bar, SWEEP_ALPHA_BAR) * p.lambda_bar * abs(speed)) ** 0.5)
    viscous = p.lambda_bar * p.hertz.front_speed(FRONT_POSITION)
    return float(max(np.sqrt(p.alpha_bar * viscous), ISOVISCOUS_SWEEP * viscous**0.4))


def _cells(case: Case, speed: float) -> tuple[float, str]:
    """The number of cells across the pressure sweep, and the same in words."""
    length = sweep_length(case, speed)
    cells = length / case.spacing
    sweep = f"sqrt(alpha_bar lambda_bar U) = {length:.3g} a"
    if case.starts_apart:
        sweep = f"of {length:.3g} a* at X = {FRONT_POSITION}"
    return cells, f"{cells:.1f} cells across the pressure sweep {sweep}, about {CELLS_IN_FRONT:.0f} are needed"


def _resolve(case: Case, cells: float) -> str:
    """The advice for `CELLS_IN_FRONT` cells across the sweep in place of these.

    The gap of a ball, X^2, leaves the line between two nodes by up to a quarter of the spacing squared.  A layer of oil
    that is thinner than this is not seen, on the largest grid perhaps.
    """
    nodes = 1 + (case.solver.nodes - 1) * max(CELLS_IN_FRONT / cells, case.spacing / sqrt(4 * (case.layer or inf)))
    return _use(nodes) if nodes < 8 * MOST_NODES else "the film is too thin for any grid"  # also on a smaller domain


def resolution(case: Case, speed: float = 0.0) -> Iterator[str]:
    """A warning if the grid has too few cells across the pressure sweep, see `sweep_length`."""
    cells, words = _cells(case, speed)
    where, effect = "at the front", "H_min is uncertain"
    if not case.starts_apart and cells:
        where = "in the inlet"
        effect = f"the films are too thin by roughly {min(7 * (CELLS_IN_FRONT / cells) ** 2, 50) / 100:.0%}"
    if 0 < cells < CELLS_IN_FRONT:
        yield f"the film is not resolved {where} ({words}): {effect}; {_resolve(case, cells)}"


def no_film(case: Case) -> str:
    """The sentence on a steady contact whose film vanishes on the grid, with the number of nodes that it needs."""
    cells, words = _cells(case, case.motion.entrainment(0.0))
    return (
        f"the surfaces overlap: the grid does not resolve the film ({words}), and the run has no result; "
        f"{_resolve(case, min(cells, CELLS_IN_FRONT / 2))}"
    )


def _film(case: Case, data: "xr.Dataset") -> Iterator[str]:
    gone = np.flatnonzero(data["H_min"].values <= 0.0)
    if gone.size:
        first = data.isel(time=gone[0])
        cells, _ = _cells(case, 0.0 if case.starts_apart else _mean_speed(data))
        yield (
            f"the film vanishes on this grid, first at T = {float(first['time']):.4g}, "
            f"X = {float(first['X_min']):.3g}: H_min is meaningless from then on; "
            f"{_resolve(case, min(cells, CELLS_IN_FRONT / 2))}"
        )


def _use(nodes: float) -> str:
    """The advice to use at least this number of nodes, rounded up to an allowed number."""
    needed = allowed_nodes(nodes)
    more = f", more than the {MOST_NODES} that are allowed: use a smaller solver.half_width, too"
    return f"use solver.nodes >= {needed}{more if needed > MOST_NODES else ''}"


# -- rolling ----------------------------------------------------------------------------------------------------------


def _outside(case: Case, share: float) -> Iterator[str]:
    """A warning where the oil outside carries a large share of the load: its pressure is that of formulas.

    Steady, against wide domains, H_c is off by 0.005, 0.2 and 0.15 % for M = 5, 2 and 1 on the default domain, whose
    share is 0.24 at most; by 1.5 % for M = 5, L = 2 and a share of 0.30; for M = 2, L = 10 and 22, by 0.2 and 0.6 % at
    0.38, by 3.4 and 1.4 % at 0.55.  In time V is zero outside: by up to 3 % for M = 5 on the default domain under a
    load that swings by 30 %.
    """
    if share > OUTSIDE_SHARE:
        half_width = min(ceil(2 * case.solver.half_width * share / OUTSIDE_SHARE) / 2, WIDEST_HALF_WIDTH)
        yield (
            f"the domain is too small (the oil outside it carries {share:.0%} of the load, {OUTSIDE_SHARE:.0%} is "
            f"allowed): the films are off by up to about {share**2 / 6:.0%}, which the error estimate does not "
            f"include; use solver.half_width >= {half_width:g}"
        )


def _mean_speed(data: "xr.Dataset") -> float:
    """The mean entrainment of a run in time; 0 before its first step."""
    return float(np.average(np.abs(data["U"]), weights=data["dT"])) if data.sizes["time"] else 0.0


def film_errors(case: Case, solutions: "Sequence[SteadyGrid]") -> dict[str, Extrapolation]:
    """Errors and extrapolated values of the films by name; empty without two grids that converged.

    On a layer of oil a film changes irregularly from grid to grid where the meniscus is in the contact.
    """
    if len(solutions) < 2 or not all(s.status.ok for s in solutions[-2:]):
        return {}
    films = {name: [s.measure()[name] for s in solutions] for name in FILMS}
    return {name: on_grids(values, regular=not case.layer)[-1] for name, values in films.items()}


def _grid(case: Case, solutions: "Sequence[SteadyGrid]") -> Iterator[str]:
    """Warnings about the errors of the films, and about the pressure spike."""
    if len(solutions) < 2:
        enough = 257 if case.geometry.is_line else 65
        yield f"there is no error estimate, because there is no coarser grid; use solver.nodes >= {enough}"
        return
    coarse, fine = (solution.measure() for solution in solutions[-2:])
    if films := film_errors(case, solutions):
        shares = {name: film.error / abs(film.extrapolated) for name, film in films.items() if film.extrapolated}
        worst = max(shares, key=lambda name: shares[name])
        if shares[worst] > LARGE_ERROR:
            finer = _use(2 * case.solver.nodes - 1)
            is_known = shares[worst] <= UNKNOWN and films[worst].extrapolated > 0.0  # as of `Number.known`
            how_well = f"uncertain by about {shares[worst]:.0%}" if is_known else "not known"
            yield f"{worst} is {how_well} on this grid; {finer}"
    else:
        yield f"there is no error estimate, because the grid of {solutions[-2].grid.nodes} nodes did not converge"
    if abs(fine["P_max"] - coarse["P_max"]) > LARGE_ERROR * fine["P_max"]:
        yield (
            f"the pressure spike is not resolved: P_max changes from {coarse['P_max']:.3g} to {fine['P_max']:.3g} "
            "between the two finest grids; the film thickness does not depend on it"
        )


def _centre(case: Case) -> Iterator[str]:
    s = case.solver
    cells = (s.inlet or s.half_width) * (s.nodes - 1) / (2 * s.half_width)
    if abs(cells - round(cells)) >= 1e-6:
        yield (
            "the centre of the contact is not a node of this grid: H_c and P_c are those of the nearest node; "
            f"use solver.inlet = {1.5 * s.half_width:g}"
        )


# -- heat --------------------------------------------------------------------------------------------------------------


def thermal_warnings(case: Case, heat: Any) -> list[str]:
    """Warnings where the formulas for the temperatures are used outside their range; an empty list if they are not."""
    assert case.thermal is not None
    warnings, inlet, line = [], INLET_FACTORS[case.thermal.inlet], case.geometry.is_line
    if heat.inlet.L_t > inlet.largest_L_t:
        warnings.append(
            f"the inlet factor phi_T = {heat.inlet.factor:.3g} ({inlet.source}) is made for {inlet.valid}, and this "
            f"inlet has L_t = {heat.inlet.L_t:.3g}; its film is uncertain"
        )
    if case.thermal.inlet == "gupta" and heat.inlet.factor < CLEARLY_THINNER:
        warnings.append(
            f"the inlet factor phi_T = {heat.inlet.factor:.3g} makes the film too thin: in a ball's pure rolling by "
            '7, 12 and 23 % at L_t = 0.3, 1.1 and 4.6, with sliding by 11 to 31 %; use thermal.inlet = "solved"'
        )
    for number, peclet in enumerate(heat.peclet, 1):
        rest, excess = (AT_REST, slow_excess(peclet)) if not line else (AT_REST_ON_A_LINE, slow_excess(peclet, line))
        if excess > slow_excess(SLOWEST):
            slow = f"below {SLOWEST:g} heat also flows along the surface"
            warnings.append(
                f"surface {number} moves slowly, with a Peclet number of {peclet:.2g}: "
                f"{'it counts as at rest' if peclet < rest else slow}, "
                f"and its temperature rise is about {excess:.0%} too high"
            )
    if not heat.converged:
        warnings.append(
            f"the temperatures did not converge in {heat.iterations} iterations: they and the traction with heat are "
            "not meaningful"
        )
    return warnings


# -- every run --------------------------------------------------------------------------------------------------------


def _roughness(case: Case) -> Iterator[str]:
    sizes = [(getattr(f.shape, "size", inf), i, has_waves(f.shape)) for i, f in enumerate(case.features, 1)]
    size, number, waves = min(sizes, default=(inf, 0, False))
    width = 2 * case.solver.half_width
    cells = size * (case.solver.nodes - 1) / width
    if cells >= CELLS_IN_WAVE:
        return
    lost, longer = "", ""
    if waves:
        lost = f"; waves below {CELLS_KEPT:g} cells are lowered or left out"
        longer = f", or leave out waves of roughness[{number}] below {size * CELLS_IN_WAVE / cells:.3g} a"
    yield (
        f"the roughness is not resolved ({cells:.1f} cells across its smallest width {size:.3g} a, about "
        f"{CELLS_IN_WAVE:.0f} are needed{lost}); {_use(width * CELLS_IN_WAVE / size + 1)}{longer}"
    )


def _maps(case: Case) -> Iterator[str]:
    """Warnings about a measured map or profile that had gaps, or is smaller than the Hertzian contact."""
    along_x, along_y = case.geometry.extent
    for number, shape in enumerate((feature.shape for feature in case.features), 1):
        if not isinstance(shape, Measured):
            continue
        what, sides = ("profile", 1) if shape.is_uniform_along_y else ("map", 2)
        if shape.filled:
            yield (
                f"roughness[{number}]: {shape.filled} of the {shape.file.heights.size} points of the {what} were gaps: "
                "their heights are interpolated from their rims"
            )
        if shape.covered[0] < 2 * along_x or shape.covered[1] < 2 * along_y:
            both = shape.covered, (2 * along_x, 2 * along_y)
            covered, contact = (" by ".join(f"{side:.3g} a" for side in each[:sides]) for each in both)
            yield (
                f"roughness[{number}]: the {what} is smaller than the contact (without its taper {covered}, "
                f"the contact {contact}): beyond it the surface is smooth"
            )


def _size(case: Case) -> Iterator[str]:
    s = case.scales
    if isinstance(s, LineScales) and s.length < SHORT_LINE * s.a:
        ends = "its ends, where the film is thinner, are not computed"
        yield f"the line contact is short (length = {s.length / s.a:.3g} b, b the half width): {ends}"
    if isinstance(s, LineScales) and case.starts_apart and s.R < s.length:
        why = "bodies with a radius below the length do not deform as half spaces"
        yield f"the approach of the cylinder is uncertain by some 5 % ({why}: R = {s.R / s.length:.2g} length)"
    if s and s.a > LARGE_CONTACT * s.R:
        yield (
            f"the contact is not small (a = {s.a / s.R:.2g} R): Hertz theory, the half-space and the parabolic gap are "
            f"good up to about {LARGE_CONTACT:g} R"
        )


# -- impact -----------------------------------------------------------------------------------------------------------


def _gap(case: Case) -> Iterator[str]:
    gap, film = -case.schedule.start_approach, case.parameters.trapped_film
    if gap < GAP_SHARE * film and case.layer is None:  # whose oil has no pressure before the ball is in it
        yield (
            f"the initial gap {gap:.3g} is not much larger than the trapped film {film:.3g} (units a*^2/R): the shape "
            f"of the film depends on it, and the first film is {case.first_film[0]:.3g} (time.start); "
            f"use time.start_approach <= {-GAP_SHARE * film:.3g}"
        )


def _domain(case: Case, data: "xr.Dataset") -> Iterator[str]:
    share = uncertain_momentum(case, data) if data.sizes["time"] else 0.0
    if share > UNCERTAIN_MOMENTUM:
        needed = needed_half_width(case, data)
        able = of_kind(case.kind, lambda method: len(method.axes) < len(case.method.axes) and computes(method, case))
        cheaper = f" with {as_written(able)}" if able else ""
        yield (
            "the momentum that the oil outside the domain takes is uncertain by about "
            f"{min(share, 1.0):.1%} of the ball's: approach, load and restitution are off by about as much; "
            f"use solver.half_width >= {needed:g}{cheaper}"
        )
