"""The film over the roughness, and warnings about solid contact: hardness, and what the model leaves out."""

from collections.abc import Iterator, Mapping
from math import inf
from typing import Any

import numpy as np

from ertel.case.case import Case
from ertel.results.variables import with_prefix

ROUGH = 3.0  # rms roughnesses: below so thick a film the roughness hinders the flow
NOTABLE = 0.01  # of the load


def touch_warnings(case: Case, values: Mapping[str, float | None]) -> list[str]:
    """Warnings about asperities that touch, from the values of a run; an empty list if there are none."""
    touches = case.touches and (values.get("asperity_share") or 0.0) > NOTABLE
    return [*_hardness(case, values["P_asperity_max"] or 0.0), *_thin(case, values["H_min"] or 0.0)] if touches else []


def _hardness(case: Case, P_max: float) -> Iterator[str]:
    """A sentence where the pressure of asperities (p_h) is held by their hardness on the area that touches."""
    assert case.surfaces is not None and case.asperities is not None and case.scales is not None
    hardness = case.surfaces.hardness or inf
    curve = case.asperities.capped(hardness)
    if curve.area is None or hardness == inf:
        return
    p, real = P_max * case.scales.p_h, np.interp(-P_max * case.scales.p_h, -curve.p, curve.p / curve.area)
    if p > 0.0 and real > 0.999 * hardness:
        yield (
            f"asperities flow: where they touch they carry the hardness, {with_prefix(hardness, 'Pa')}; their pressure "
            "is held at that, and no plastic flow is followed"
        )


def _thin(case: Case, H_min: float) -> Iterator[str]:
    """A sentence for what a film (a^2/R) that is about as thin as the roughness lacks: flow factors, heat.

    A film below the size of molecules is said by `runs.outlook`, with asperities and without.
    """
    assert case.scales is not None
    if H_min * case.scales.film < ROUGH * (case.sigma or 0.0):
        yield (
            f"the film is thinner than {ROUGH:g} times the roughness, which hinders its flow; ertel has no flow "
            "factors, so that the film may be off by some 10%"
        )
    if case.thermal and not case.thermal.is_solved:
        yield "the asperities carry their share in the isothermal film; heat thins the film, and more of it would touch"


def film_over_roughness(case: Case, values: Mapping[str, Any]) -> dict[str, float]:
    """Lambda, from the minimum film of a physical case with roughness as a number.

    That with heat where there is any, else the extrapolated one, else that on the grid.  Empty without a film, or
    without such a roughness.
    """
    films = (values.get(name) for name in ("H_min_warm", "H_min_extrapolated", "H_min"))
    H = next((film for film in films if film is not None), None)
    if H is None or case.sigma is None or case.scales is None:
        return {}
    return {"Lambda": H * case.scales.film / case.sigma}
