"""The film over the roughness, and warnings about solid contact: hardness, molecules, what the model leaves out."""

from collections.abc import Iterator, Mapping
from math import inf
from typing import Any

import numpy as np

from ertel.case.case import Case
from ertel.results.variables import with_prefix

MOLECULES = 1e-9  # m: a film below it is no liquid
ROUGH = 3.0  # rms roughnesses: below so thick a film the hills stand in the way of the flow
NOTABLE = 0.01  # of the load


def touch_warnings(case: Case, values: Mapping[str, float | None]) -> list[str]:
    """Warnings about asperities that touch, from the values of a run; an empty list if there are none."""
    if not case.touches or values.get("H_min") is None:
        return []
    touches = (values.get("asperity_share") or 0.0) > NOTABLE
    flows = _hardness(case, values.get("P_asperity_max") or 0.0) if touches else ()
    return [*flows, *_thin(case, values)]


def _hardness(case: Case, P_max: float) -> Iterator[str]:
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


def _thin(case: Case, values: Mapping[str, float | None]) -> Iterator[str]:
    assert case.surfaces is not None and case.scales is not None
    h_min, rms = (values["H_min"] or 0.0) * case.scales.film, case.surfaces.rms or 0.0
    share = values.get("asperity_share") or 0.0
    if 0.0 < h_min < MOLECULES:
        yield f"the minimum gap of {with_prefix(h_min, 'm')} is below the size of the oil's molecules: no liquid film"
    if share > NOTABLE and h_min < ROUGH * rms:
        yield (
            f"the film is thinner than {ROUGH:g} times the roughness: the hills stand in the way of its flow, which "
            "flow factors would show and ertel does not have; it may be off by some 10%"
        )
    if share > NOTABLE and case.thermal and not case.thermal.is_solved:
        yield "the asperities carry their share in the isothermal film; heat thins the film, and more of it would touch"


def film_over_roughness(case: Case, values: Mapping[str, Any]) -> dict[str, float]:
    """Lambda, from the minimum film of a physical case with roughness as a number; the warm one, where there is heat.

    Empty without a film, or without such a roughness.
    """
    H, rms = values.get("H_min_warm", values.get("H_min")), case.surfaces.rms if case.surfaces else None
    if H is None or rms is None or case.scales is None:
        return {}
    return {"Lambda": H * case.scales.film / rms}
