"""The rules for roughness, in the gap and as asperities: no wave counts twice, a steady film has none that moves."""

from collections.abc import Iterator
from math import ceil, exp, inf, sqrt

import numpy as np

from ertel.case.case import Case
from ertel.case.methods import as_written, of_kind
from ertel.case.records import show, with_unit
from ertel.physics.surfaces import has_waves
from ertel.physics.units import LENGTH

ROUND_OFF = 1e-4  # of a wavelength that both parts of a spectrum name
REACH = 1.3  # Hertz pressures that asperities must be able to carry
LONGEST_END = 50.0  # of the line that continues a curve in ln h
NO_TOUCH, AT_EDGE = 1e-9, 1e-4  # of p_h: a pressure that does not push, and one that does not count on an edge


def touching_gap(case: Case) -> float:
    """The gap (a^2/R) below which asperities carry a pressure; 0 where none touch."""
    return 0.0 if case.asperities is None else _gap(case, NO_TOUCH)


def _gap(case: Case, pressure: float) -> float:
    """The gap (a^2/R) at which the asperities of a case carry a pressure (p_h)."""
    curve, scales = case.asperities, case.scales
    assert curve is not None and scales is not None
    return float(np.interp(-pressure * scales.p_h, -np.asarray(curve.p), curve.h)) / scales.film


def _largest(case: Case) -> float:
    """The largest pressure (Pa) that asperities carry: at a hardness, or at the straight end of their curve."""
    given, curve = case.surfaces, case.asperities
    assert given is not None and curve is not None
    (rise, close) = (float(np.log(part[0] / part[1])) for part in (curve.p, curve.h))
    return min(given.hardness or inf, float(curve.p[0]) * exp(min(-LONGEST_END * rise / close, LONGEST_END)))


def rough_surfaces(case: Case) -> Iterator[tuple[str, str]]:
    """The fields of a case that do not go with its section [surfaces], and what is wrong."""
    given, scales = case.surfaces, case.scales
    if given is None:
        return
    if scales is None:
        yield "surfaces", "needs a contact in SI; give radius, load, ... or leave the section [surfaces] out"
        return
    if given.asperities is not None:
        yield from _asperities(case)
    longest = getattr(given.asperities, "longest", 0.0)
    for number, feature in enumerate(case.features, 1):
        shortest = scales.a * getattr(feature.shape, "size", 0.0)
        if has_waves(feature.shape) and longest > shortest * (1 + ROUND_OFF):
            place = f"surfaces.asperities.longest = {show(with_unit(longest, LENGTH))}"
            yield place, f"roughness[{number}] has the waves from {shortest:.4g} m on; must be at most as long"
    if given.asperities and case.layer is not None and case.layer * scales.film < (case.sigma or 0.0):
        yield "lubricant.layer", f"is below the roughness of the surfaces, {case.sigma:.3g} m; must be above it"


def _asperities(case: Case) -> Iterator[tuple[str, str]]:
    """The faults of a law, of its hardness, of a grid and of a fall that begin where asperities touch already."""
    given, curve = case.surfaces, case.asperities
    assert given is not None and curve is not None and case.scales is not None
    if complaint := curve.complaint:
        yield "surfaces.asperities", f"its curve {complaint}"
    elif given.hardness is not None and curve.area is None:
        yield "surfaces.hardness", "needs a law that says the area in touch, such as persson; leave it out"
    elif (limit := _largest(case)) < REACH * case.scales.p_h:
        place, p_h = "hardness" if limit == given.hardness else "asperities", case.scales.p_h
        most = f"lets asperities carry {limit:.3g} Pa at most, and the Hertz pressure is {p_h:.3g} Pa"
        yield f"surfaces.{place}", f"{most}: they cannot carry the load without oil; must be at least {REACH} times p_h"
    else:
        edge = case.geometry.gap(case.solver.half_width, 0.0) - case.geometry.dry_approach(1.0)
        if (gap := _gap(case, AT_EDGE)) > edge:
            dry, width = case.geometry.dry_approach(1.0), case.solver.half_width
            needed = ceil(4 * width * sqrt((gap + dry) / (edge + dry))) / 4  # of a parabola
            touch = f"asperities touch up to a gap of {gap:.3g} a^2/R, at the edge of the grid there are {edge:.3g}"
            yield "surfaces", f"{touch}; use solver.half_width = {needed:g}, or a smaller roughness"
        if case.starts_apart and case.schedule.start_approach > -touching_gap(case):
            most = f"must be at most {-touching_gap(case):.4g}, where asperities do not touch yet"
            yield "time.start_approach", f"{most}; leave it out"


def roughness_fits(case: Case) -> Iterator[tuple[str, str]]:
    """A steady film needs roughness that does not change in time, a line contact one that does not change along y."""
    for number, feature in enumerate(case.features, 1):
        if case.geometry.is_line and not getattr(feature.shape, "is_uniform_along_y", False):
            yield f"roughness[{number}]", "varies along y; a line takes a waviness without wavelength_y, or a profile"
        moves = case.motion.travel(feature.surface, 1.0) != 0
        if case.is_steady and moves and not getattr(feature.shape, "is_ridges_along_x", False):
            instead = (
                f"use {methods_in_time(case)}, or a slide_to_roll at which it is at rest (surface 1: -2, surface 2: 2)"
            )
            yield f"roughness[{number}].surface = {feature.surface}", f"moves, so its film is not steady; {instead}"


def methods_in_time(case: Case) -> str:
    """The methods in time of a kind of contact, as they are written, and what none of them supports."""
    methods = of_kind(case.kind, lambda method: not method.is_steady)
    heat = case.thermal is None or any(method.supports.thermal for method in methods)
    return as_written(methods) + ("" if heat else " without [thermal]")
