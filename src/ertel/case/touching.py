"""The rules for asperities that touch: their sizes are in SI, and no wave counts twice."""

from collections.abc import Iterator

import numpy as np

from ertel.case.case import Case
from ertel.case.records import show, with_unit
from ertel.physics.surfaces import has_waves
from ertel.physics.units import LENGTH

ROUND_OFF = 1e-4  # of a wavelength that both parts of a spectrum name


NO_TOUCH = 1e-9  # of p_h: a pressure that does not push


def first_touch(case: Case) -> float:
    """The gap (a^2/R) below which asperities carry a pressure; 0 where none touch."""
    given, scales = case.surfaces, case.scales
    if given is None or given.asperities is None or scales is None:
        return 0.0
    curve = given.asperities.curve(given.rms or 0.0, scales.E_prime / 2)
    return float(np.interp(-NO_TOUCH * scales.p_h, -curve.p, curve.h)) / scales.film


def rough_surfaces(case: Case) -> Iterator[tuple[str, str]]:
    """The fields of a case that do not go with its section [surfaces], and what is wrong."""
    given, scales = case.surfaces, case.scales
    if given is None:
        return
    if scales is None:
        yield "surfaces", "needs a contact in SI; give radius, load, ... or leave the section [surfaces] out"
        return
    longest = getattr(given.asperities, "longest", 0.0)
    for number, feature in enumerate(case.features, 1):
        shortest = scales.a * getattr(feature.shape, "size", 0.0)
        if has_waves(feature.shape) and longest > shortest * (1 + ROUND_OFF):
            place = f"surfaces.asperities.longest = {show(with_unit(longest, LENGTH))}"
            yield place, f"roughness[{number}] has the waves from {shortest:.4g} m on; must be at most as long"
    if given.asperities and case.layer is not None and given.rms and case.layer * scales.film < given.rms:
        yield "lubricant.layer", f"is below the roughness of the surfaces, {given.rms:.3g} m; must be above it"
