"""Warnings about friction and solid contact, and the film over the roughness."""

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from ertel.case.case import Case
from ertel.case.estimates import largest_pressure
from ertel.physics.lubricant import Barus
from ertel.results.variables import with_prefix

ROUGH = 3.0  # rms roughnesses: below so thick a film the roughness hinders the flow
NOTABLE = 0.01  # of the load
LARGEST_TRACTION = 0.15  # coefficient: more than traction fluids reach
BARUS_PRESSURE = 0.7e9  # Pa, above which the Barus law says nothing about traction


def friction_warnings(case: Case, coefficient: float) -> Iterator[str]:
    """Warnings where shear stress and traction are not meaningful; the film hardly changes.

    coefficient: the largest traction coefficient of the run.
    """
    p, mu, newtonian = largest_pressure(case), abs(coefficient), case.oil.is_newtonian
    if isinstance(case.oil.viscosity_law, Barus) and p > BARUS_PRESSURE and (mu or not newtonian):
        yield (
            f'lubricant.viscosity = "barus": greatly overestimates the viscosity above {BARUS_PRESSURE / 1e9:g} GPa, '
            f"and this contact has {p / 1e9:.2g} GPa: shear stress and traction are not meaningful; "
            'use "roelands", or a modulus or the Doolittle law with measured constants'
        )
    elif case.scales and mu > LARGEST_TRACTION:
        law = 'give lubricant.rheology, for example { law = "ree-eyring", tau0 = "5 MPa" }'
        remedy = law if newtonian else "check lubricant.rheology, or give it a limiting stress"
        yield (
            f"the traction coefficient {mu:.2g} is larger than that of any oil (about 0.1): shear stress and traction "
            f"are not meaningful; {remedy}"
        )


def touch_warnings(case: Case, values: Mapping[str, float | None]) -> Iterator[str]:
    """Warnings about asperities that touch, from the values of a run.

    Where their pressure is held by their hardness on the area that touches; and what a film that is about as thin as
    the roughness lacks: flow factors, heat.  A film below the size of molecules is said by `runs.outlook`.
    """
    surfaces, curve, scales = case.surfaces, case.asperities, case.scales
    if not (surfaces and curve and scales) or (values.get("asperity_share") or 0.0) <= NOTABLE:
        return
    p, hardness = (values["P_asperity_max"] or 0.0) * scales.p_h, surfaces.hardness
    if p > 0.0 and hardness and curve.area is not None:
        held = curve.capped(hardness).p
        if np.interp(-p, -held, held / curve.area) > 0.999 * hardness:
            yield (
                f"asperities flow: where they touch they carry the hardness, {with_prefix(hardness, 'Pa')}; their "
                "pressure is held at that, and no plastic flow is followed"
            )
    if (values["H_min"] or 0.0) * scales.film < ROUGH * (case.sigma or 0.0):
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
