"""Warnings that need no run: what is asked of the model beyond its range.  `ertel check` and every run give them first.

What concerns the grid, the domain and the roughness is in `results.diagnostics`.
"""

from collections.abc import Iterator, Mapping
from typing import Any

from ertel.case.case import Case
from ertel.case.estimates import LARGEST_NEWTONIAN_STRESS, film, largest_pressure, newtonian_stress
from ertel.inputs import materials
from ertel.results import diagnostics
from ertel.results.numbers import numbers
from ertel.results.variables import with_prefix

SMALLEST_FILM = 1e-9  # m: about the size of the oil's molecules


def warnings_of(case: Case) -> list[str]:
    """All warnings that follow from the case alone; an empty list if there are none."""
    return [*beyond(case), *diagnostics.case_warnings(case)]


def beyond(case: Case) -> list[str]:
    """What a physical case asks of the model beyond its range; empty where it is inside, or dimensionless."""
    found = (*_yielding(case), _pressure_of_the_oil(case), _stress_of_the_oil(case), _thin_film(case))
    return [sentence for sentence in found if sentence]


def with_these(case: Case, summary: Mapping[str, Any]) -> dict[str, Any]:
    """The summary of a run with these warnings before its own; of the film by what was computed."""
    said = [*_yielding(case), _pressure_of_the_oil(case), _stress_of_the_oil(case)]
    film = numbers(summary).get("H_min")
    if film is None or film.factor is None:
        said.append(_thin_film(case))
    else:
        said.append(_of_molecules("the minimum film", film.value * film.factor))
    return {**summary, "warnings": [*filter(None, said), *summary["warnings"]]}


def _yielding(case: Case) -> Iterator[str]:
    """A sentence for every body that yields.  A body is of a material of the library if it has its E and nu."""
    p, contact = largest_pressure(case), case.contact
    bodies = dict.fromkeys(((contact.E1, contact.nu1), (contact.E2, contact.nu2)))
    for name in materials.names() if p else ():
        material = materials.get(name)
        elastic = material.elasticity.data
        if material.strength is None or (elastic.E, elastic.nu) not in bodies:
            continue
        limit = material.strength.data.first_yield
        if p > limit:
            yield (
                f"the maximum Hertz pressure is {with_prefix(p, 'Pa')}, and {name} of the hardness "
                f"{with_prefix(material.strength.data.hardness, 'Pa')} yields from about {with_prefix(limit, 'Pa')} "
                "(1.6 times the yield stress): the bodies here are elastic, and pressures and films are not those of "
                "bodies that yield"
            )


def _pressure_of_the_oil(case: Case) -> str:
    """A sentence where the viscosity is extrapolated beyond the pressures for which the law of the oil has a source."""
    p, highest = largest_pressure(case), getattr(case.oil.viscosity_law, "highest", None)
    if highest is None or p <= highest or not (case.motion.slide_to_roll or case.thermal):
        return ""
    return (
        f"the viscosity law of the oil has a source up to {with_prefix(highest, 'Pa')}, and this contact has "
        f"{with_prefix(p, 'Pa')}: friction is extrapolated; the film, which the inlet makes, hardly depends on it"
    )


def _stress_of_the_oil(case: Case) -> str:
    """A sentence where a Newtonian oil would have a shear stress that no oil has."""
    stress = newtonian_stress(case) if case.oil.is_newtonian else 0.0
    if stress <= LARGEST_NEWTONIAN_STRESS:
        return ""
    return (
        f"the oil is Newtonian, and sliding would give it a mean shear stress of about {with_prefix(stress, 'Pa')}; "
        "oils begin to thin at some MPa: friction and power loss are not meaningful, the film hardly depends on it; "
        'give lubricant.rheology, for example { law = "ree-eyring", tau0 = "5 MPa" }'
    )


def _thin_film(case: Case) -> str:
    """A sentence where the film is expected to be thinner than molecules."""
    return _of_molecules("the expected film", film(case))


def _of_molecules(name: str, thickness: float) -> str:
    if not 0.0 < thickness < SMALLEST_FILM:
        return ""
    return (
        f"{name} of {with_prefix(thickness, 'm')} is thinner than {with_prefix(SMALLEST_FILM, 'm')}, about the size of "
        "the oil's molecules: it is not a liquid film there, and solids with their roughness may touch"
    )
