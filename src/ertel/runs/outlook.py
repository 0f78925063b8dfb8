"""The outlook of a case before it is run: warnings, grid, memory and time.  It needs no JAX.

Warnings about what is asked of the model beyond its range stand here; those of the grid, the domain and the roughness
in `results.diagnostics`.
"""

import os
from collections.abc import Iterator, Mapping
from contextlib import suppress
from math import ceil, inf, isfinite, prod, sqrt
from typing import Any

import numpy as np

from ertel.case import estimates
from ertel.case.case import Case
from ertel.case.estimates import grid_of, wet_radius
from ertel.case.sections import Time
from ertel.inputs import materials
from ertel.physics import surfaces
from ertel.physics.geometry import CIRCLE
from ertel.physics.motion import Track
from ertel.physics.surfaces import CELLS_KEPT
from ertel.physics.units import plain
from ertel.results import diagnostics
from ertel.results.friction import friction_warnings
from ertel.results.numbers import numbers
from ertel.results.parameters import formula_films, parameter_summary, regime, rheology_of
from ertel.results.variables import names_where, with_prefix
from ertel.runs.compile import jax_devices, may_use_accelerator

MOST_SHOWN = 257  # points a side at which the heights of a roughness are looked at
OIL_DENSITY = 900.0  # kg/m^3, typical
LOW_STOKES = 50.0  # below which the tension in a full gap changes restitution by more than a tenth
TENSION = 5.0  # St times that change, as it is at St = 20: .26; at St = 5 nothing comes back
SMALLEST_FILM = 1e-9  # m: about the size of the oil's molecules

# Time steps and seconds, measured on one to two cores with `benchmarks/steps.py`, `scaling.py` and `time_error.py`,
# Newtonian oils.  Another machine, a hard case or a busy hour changes them by a factor of three.  Steps: 178 to maximum
# approach (M = 1000), 259 and 417 to the rebound (M = 100, 1000), 295 while a cavity passes: 52 to 84 for each t0 at a
# tolerance of 5e-5, 77 in place of 178 at 1e-3.
STEPS = 75.0  # for each t0, at the default tolerance
STEPS_POWER = 0.3  # with which the steps grow with 1/tolerance
STEPS_OF_A_PERIOD = 16.0
TIMES_OF_THINNING = 2.0, 6.0  # what a steady film and a step of a shear-thinning oil take, times a Newtonian one
SECONDS_TO_START = 5.0  # with compiled programs from the cache; some fifteen more where there are none

# bytes = BASE + 8 (arrays * nodes that are computed + maps * nodes of the plane), see `methods.Cost`
BASE = 0.55e9  # Python, JAX and the compiler
EXHAUSTED = "RESOURCE_EXHAUSTED"  # how JAX begins such messages


def outlook(case: Case) -> dict[str, Any]:
    """The outlook of a case as plain data.

    Returns
    -------
    dict
        name, kind, method, digest; rheology in words; parameters, see `parameters.parameter_summary`; films of a
        rolling contact at T = 0 by the formulas, in a^2/R; its regime in words, empty for an impact; start: film
        (a^2/R) and load (F*) with which an impact starts, empty for rolling; grid: nodes, nodes_across, spacing and
        sweep (a), cells_in_sweep, and spacing_m of a physical case; starvation: r and share, see
        `estimates.starvation`, and wet_radius (a) of an impact of circular symmetry, empty for a full gap;
        roughness: `roughness_of`; memory:
        needed and available bytes, None where that is not known; time: steps and seconds, roughly; warnings.
    """
    available, needed = memory_available(), memory_needed(case)
    shortage = memory_shortage(case) if 0 < available < needed else ""
    some = 1e-9 if case.motion.slides else 0.0  # of friction it is enough to know whether the surfaces slide
    resolution = diagnostics.resolution(case, case.motion.entrainment(0.0))
    sentences = [shortage, *resolution, *warnings_of(case), *friction_warnings(case, some)]
    return {
        "name": case.name,
        "kind": case.kind,
        "method": case.solver.method,
        "digest": case.digest,
        "rheology": rheology_of(case),
        "parameters": parameter_summary(case),
        "films": [film._asdict() for film in formula_films(case, *case.motion.moment(0.0))],
        "regime": regime(case),
        "start": dict(zip(("film", "load"), case.first_film, strict=True)) if case.starts_apart else {},
        "grid": _grid(case),
        "starvation": _starvation(case),
        "roughness": roughness_of(case),
        "Lambda": {"sigma_m": case.sigma, "expected": estimates.film_estimate(case) / case.sigma} if case.sigma else {},
        "memory": {"needed": needed, "available": available or None},
        "time": {"steps": expected_steps(case), "seconds": expected_seconds(case)},
        "warnings": [sentence for sentence in sentences if sentence],
    }


# -- grid -------------------------------------------------------------------------------------------------------------


def _grid(case: Case) -> dict[str, float | int]:
    """The grid, and the length of the pressure sweep in a: at the front of an impact, in the inlet of rolling."""
    spacing, across = case.spacing, case.method.space.across(case.solver)
    sweep = diagnostics.sweep_length(case, case.motion.entrainment(0.0))
    in_si = {"spacing_m": spacing * case.scales.a} if case.scales else {}
    numbers = {"nodes": case.solver.nodes, "nodes_across": across, "spacing": spacing}
    return {**numbers, **in_si, "sweep": sweep, "cells_in_sweep": sweep / spacing}


def _starvation(case: Case) -> dict[str, float]:
    """The expected effect of the layers of oil; empty for a full gap."""
    if case.track is None:
        return {}
    wet = {"wet_radius": wet_radius(case.track.extremes[1])} if case.starts_apart and case.geometry is CIRCLE else {}
    return dict(zip(("r", "share"), estimates.starvation(case), strict=True)) | wet


# -- time -------------------------------------------------------------------------------------------------------------


def expected_steps(case: Case) -> int:
    """The number of time steps of a run, roughly; 0 of a steady contact."""
    if case.is_steady:
        return 0
    time = case.schedule
    if time.step:
        return round(time.duration / time.step)
    steps = STEPS * time.duration * (Time().tolerance / time.tolerance) ** STEPS_POWER
    period = case.motion.shortest_period
    return int(max(steps, STEPS_OF_A_PERIOD * time.duration / period if isfinite(period) else 0.0))


def expected_seconds(case: Case) -> float:
    """The seconds that a run takes, roughly, with compiled programs from the cache."""
    cost = case.method.cost
    kept = case.solver.nodes**2 if cost.is_dense else prod(grid_of(case).shape)
    more, slower = (1.0, 1.0) if case.oil.is_newtonian else TIMES_OF_THINNING
    start, each = cost.step
    return SECONDS_TO_START + more * cost.film * kept + slower * expected_steps(case) * (start + each * kept)


# -- memory -----------------------------------------------------------------------------------------------------------


def memory_needed(case: Case) -> float:
    """The memory in bytes that a run of the case needs, approximately."""
    nodes, cost = case.solver.nodes, case.method.cost
    moments = 1 if case.is_steady else case.schedule.duration / case.schedule.interval + 2
    fields = names_where(lambda variable: variable.over == "map")  # the summary reads all of them
    maps = len(fields) * moments * nodes ** len(case.method.axes)
    return BASE + 8.0 * (cost.arrays * (nodes**2 if cost.is_dense else grid_of(case).size) + maps)


def memory_available() -> float:
    """The memory in bytes of the device that JAX computes on; 0 where it is not known."""
    if may_use_accelerator() and (limit := (jax_devices()[0].memory_stats() or {}).get("bytes_limit")):
        return float(limit)
    with suppress(AttributeError, ValueError, OSError):  # not on Windows
        return float(os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE"))
    return 0.0


def memory_shortage(case: Case) -> str:
    """The memory that the grid of a case needs, that of the machine, and which grid fits, as part of a sentence."""
    available, smaller = memory_available(), case
    with suppress(ValueError):  # the coarsest grid
        smaller = case.on_half_grid()
        while memory_needed(smaller) > available > 0:
            smaller = smaller.on_half_grid()
    has = f", the machine has {available / 1e9:.2g} GB" if available else ""
    needs = f"solver.nodes = {case.solver.nodes} needs about {memory_needed(case) / 1e9:.2g} GB of memory{has}"
    return f"{needs}; solver.nodes = {smaller.solver.nodes} needs {memory_needed(smaller) / 1e9:.2g} GB"


def is_out_of_memory(error: BaseException) -> bool:
    """Whether an error says that no memory is left."""
    return isinstance(error, MemoryError) or (isinstance(error, RuntimeError) and EXHAUSTED in str(error))


# -- warnings ---------------------------------------------------------------------------------------------------------


def warnings_of(case: Case) -> list[str]:
    """All warnings that follow from the case alone; every run gives them first."""
    return [*beyond(case), *diagnostics.case_warnings(case)]


def beyond(case: Case, computed: float | None = None) -> list[str]:
    """Warnings of a case beyond the range of the model.

    computed: the minimum film (m) of the run, None where only the expected one is known.
    """
    film = ("expected", estimates.film_estimate(case)) if computed is None else ("minimum", computed)
    oil = (_pressure_of_the_oil(case), _shear_stress(case), _oil_inertia(case), _no_tension(case))
    others = (_thin_film(*film), _layer(case), _sliding(case), *_rough(case), _track(case))
    return [sentence for sentence in (*_yielding(case), *oil, *others) if sentence]


def with_case_warnings(case: Case, summary: Mapping[str, Any]) -> dict[str, Any]:
    """The summary of a run with the warnings of its case before its own."""
    minimum = numbers(summary).get("H_min")
    computed = minimum.value * minimum.factor if minimum and minimum.factor is not None else None
    stress = (summary.get("si") or {}).get("von_mises_max_Pa")
    hard = next(_materials((case.contact.E1, case.contact.nu1)), None) if stress else None
    ratio = {"yield_ratio": stress / hard.strength.data.yield_stress} if hard else {}
    return {**summary, **ratio, "warnings": [*beyond(case, computed), *summary["warnings"]]}


def _sliding(case: Case) -> str:
    """A sentence where the surfaces move against each other: a slide-to-roll ratio in per cent is far above two."""
    if abs(case.motion.slide_to_roll) <= 2.0:
        return ""
    given = f"slide_to_roll = {case.motion.slide_to_roll:g}"
    return f"{given}: above 2 the surfaces move in opposite directions; a ratio in per cent is divided by 100"


def roughness_of(case: Case) -> list[dict[str, Any]]:
    """Each roughness on the grid at T = 0: shape, size of its finest detail (a), rms, lowest, highest (a^2/R; in m)."""
    s, spacing, grid, found = case.scales, case.spacing, grid_of(case), []
    X, Y = grid.x[None, :: grid.nodes // MOST_SHOWN + 1], grid.y[:: grid.nodes_y // MOST_SHOWN + 1, None]
    for feature in case.features:
        heights = np.broadcast_to(
            surfaces.height((feature,), case.motion, 0.0, X, Y, CELLS_KEPT * spacing), (Y.size, X.size)
        )
        sizes = {"size": getattr(feature.shape, "size", inf), "rms": heights.std()}
        sizes |= {"lowest": heights.min(), "highest": heights.max()}
        in_si = {f"{name}_m": value * (s.a if name == "size" else s.film) for name, value in sizes.items()} if s else {}
        shape = {"shape": type(feature.shape).__name__}
        found.append(shape | {name: float(value) for name, value in {**sizes, **in_si}.items()})
    return found


def _rough(case: Case) -> Iterator[str]:
    """A sentence for every roughness that stands higher than the expected film is thick."""
    if case.touches:
        return
    film = case.film_scale * estimates.starvation(case)[1]
    for number, rough in enumerate(roughness_of(case), 1):
        if rough["highest"] > film:
            heights = [_height(case, height) for height in (rough["highest"], film)]
            yield (
                f"roughness[{number}] stands {heights[0]} high, and the expected film is {heights[1]}: where the "
                "contact does not flatten it, the film breaks down and solids touch; surfaces.asperities lets them"
            )


def _height(case: Case, value: float) -> str:
    return with_prefix(value * case.scales.film, "m") if case.scales else f"{value:.3g} a^2/R"


def _track(case: Case) -> str:
    """A sentence where a profile of the layer across the track says nothing: of one point, or beside the grid."""
    if not isinstance(case.oil.layer, Track) or case.track is None:
        return ""
    places, edge = [plain(y) for y, _ in case.track.points], case.solver.half_width_y or case.solver.half_width
    if len(places) == 1:
        return "lubricant.layer has one point: the layer is the same everywhere; give its thickness alone"
    if min(places) < edge and max(places) > -edge:
        return ""
    span = f"from y = {min(places):.3g} a to {max(places):.3g} a"
    return f"the points of lubricant.layer lie {span}, beside the grid, which ends at {edge:g} a"


def _yielding(case: Case) -> Iterator[str]:
    """A sentence for every body that yields.  A body is of a material of the library if it has its E and nu."""
    p, contact = estimates.largest_pressure(case), case.contact
    for material in _materials((contact.E1, contact.nu1), (contact.E2, contact.nu2)) if p else ():
        limit = material.strength.data.first_yield
        if p > limit:
            yield (
                f"the maximum Hertz pressure is {with_prefix(p, 'Pa')}, and {material.name} of the hardness "
                f"{with_prefix(material.strength.data.hardness, 'Pa')} yields from about {with_prefix(limit, 'Pa')} "
                "(1.6 times the yield stress): the bodies here are elastic, and pressures and films are not those of "
                "bodies that yield"
            )


def _materials(*bodies: tuple[float | None, float | None]) -> Iterator[Any]:
    """The materials of the library with a known strength that have the E and nu of one of the bodies."""
    for material in map(materials.get, materials.names()):
        elastic = material.elasticity.data
        if material.strength and (elastic.E, elastic.nu) in bodies:
            yield material


def _pressure_of_the_oil(case: Case) -> str:
    """A sentence where the viscosity is extrapolated beyond the pressures for which the law of the oil has a source."""
    p, highest = estimates.largest_pressure(case), getattr(case.oil.viscosity_law, "highest", None)
    if highest is None or p <= highest or not (case.motion.slides or case.thermal):
        return ""
    return (
        f"the viscosity law of the oil has a source up to {with_prefix(highest, 'Pa')}, and this contact has "
        f"{with_prefix(p, 'Pa')}: friction is extrapolated; the film, which the inlet makes, hardly depends on it"
    )


def _shear_stress(case: Case) -> str:
    """A sentence where a Newtonian oil would have a shear stress that no oil has."""
    stress = estimates.newtonian_stress(case) if case.oil.is_newtonian else 0.0
    if stress <= estimates.LARGEST_NEWTONIAN_STRESS:
        return ""
    return (
        f"the oil is Newtonian, and sliding would give it a mean shear stress of about {with_prefix(stress, 'Pa')}; "
        "oils begin to thin at some MPa: friction and power loss are not meaningful, the film hardly depends on it; "
        'give lubricant.rheology, for example { law = "ree-eyring", tau0 = "5 MPa" }'
    )


def _oil_inertia(case: Case) -> str:
    """A sentence where the oil that an impact squeezes out has more inertia than viscosity: rho v h/eta0 above 1."""
    s, eta0 = case.scales, case.oil.eta0
    if not case.starts_apart or s is None or eta0 is None:
        return ""
    thickness = (case.layer or 1.0) * s.film
    inertia = OIL_DENSITY * s.speed * thickness / eta0
    if inertia <= 1.0:
        return ""
    return (
        f"the inertia of the oil rules this impact: rho v h/eta0 = {inertia:.2g} is above 1 (v = {s.speed:.3g} m/s, "
        f"h = {with_prefix(thickness, 'm')}, an oil of {OIL_DENSITY:g} kg/m^3), and the model has none: load, film and "
        "restitution are not those of this oil"
    )


def _no_tension(case: Case) -> str:
    """A sentence on the rebound from a full gap at a low Stokes number, where tension in the oil counts."""
    St, lost = case.parameters.stokes, TENSION / case.parameters.stokes
    if case.geometry.is_line:  # whose film on the rebound is about the trapped one
        lost = 1.0 / (St * sqrt(sum(case.parameters.impact_films) / 2))
    if not case.starts_apart or case.layer or case.schedule.until != "rebound" or lost <= TENSION / LOW_STOKES:
        return ""
    return (
        f"the Stokes number is {St:.3g}, and oil without tension does not hold the ball back: restitution is an upper "
        f"bound; tension in the oil lowers it by about {min(lost, 1.0):.2g}, at most to zero"
    )


def _layer(case: Case) -> str:
    """A sentence where a ball starts in its layer of oil, or where this may reach the edge of the grid."""
    if case.track is None or not case.starts_apart:
        return ""
    layer, start = case.track.extremes[1], case.schedule.start_approach
    edge = min(case.solver.half_width, case.solver.half_width_y or inf)
    if layer > -start:
        thicker = f"lubricant.layer = {layer:.4g} a*^2/R is thicker than the initial gap {-start:.4g}"
        return f"the ball starts in the oil: {thicker}; use time.start_approach <= {-layer:.4g}, or leave it out"
    wet = wet_radius(layer)
    if case.geometry is not CIRCLE or wet <= edge:
        return ""
    return (
        "the oil that the ball displaces may reach the edge of the grid, where it is lost (it may get to "
        f"{wet:.3g} a*, the edge is at {edge:g}); use solver.half_width >= {ceil(4 * wet) / 4:g}"
    )


def _thin_film(which: str, thickness: float) -> str:
    """A sentence where a film is thinner than molecules."""
    if not 0.0 < thickness < SMALLEST_FILM:
        return ""
    return (
        f"the {which} film of {with_prefix(thickness, 'm')} is thinner than {with_prefix(SMALLEST_FILM, 'm')}, about "
        "the size of the oil's molecules: it is not a liquid film there, and solids with their roughness may touch"
    )
