"""What follows from a case before it is run: parameters, films by formulas, grid, memory, time, warnings."""

from typing import Any

import numpy as np

from ertel.case.case import Case
from ertel.case.grids import grid_of, radii
from ertel.results import diagnostics
from ertel.results.parameters import films, parameter_summary, rheology_of
from ertel.runs import beforehand, duration, memory


def outlook(case: Case) -> dict[str, Any]:
    """What follows from a case before it is run, as plain data.

    Returns
    -------
    dict
        name, kind, method, digest; rheology in words; parameters, see `parameters.parameter_summary`; films of a
        rolling contact at T = 0 by the formulas, in a^2/R; grid: nodes, nodes_across, spacing and sweep (a),
        cells_in_sweep, and spacing_m of a physical case; memory: needed and available bytes, None where that is not
        known; time: steps and seconds, roughly; warnings.
    """
    said = _resolution_warning(case)
    there, needed = memory.available(), memory.needed(case)
    short = memory.shortage(case) if 0 < there < needed else ""
    return {
        "name": case.name,
        "kind": case.kind,
        "method": case.solver.method,
        "digest": case.digest,
        "rheology": rheology_of(case),
        "parameters": parameter_summary(case),
        "films": [film._asdict() for film in films(case, case.motion.load(0.0), case.motion.entrainment(0.0))],
        "grid": _grid(case),
        "memory": {"needed": needed, "available": there or None},
        "time": {"steps": duration.steps(case), "seconds": duration.seconds(case)},
        "warnings": [sentence for sentence in (short, said, *_case_warnings(case)) if sentence],
    }


def _case_warnings(case: Case) -> list[str]:
    """Warnings that need no run; of friction as far as it is enough to know whether the surfaces slide."""
    some = 1e-9 if case.motion.slide_to_roll else 0.0
    return [*beforehand.warnings_of(case), *diagnostics.friction_warnings(case, some)]


def _grid(case: Case) -> dict[str, float | int]:
    spacing, sweep = _spacing(case), _sweep(case)
    nodes = case.solver.nodes
    across = 1 if case.solver.method == "radial" else grid_of(case).nodes_y
    found = {"nodes": nodes, "nodes_across": across, "spacing": spacing}
    in_si = {"spacing_m": spacing * case.scales.a} if case.scales else {}
    return {**found, **in_si, "sweep": sweep, "cells_in_sweep": sweep / spacing}


def _spacing(case: Case) -> float:
    """The spacing in a; of a radial grid where the front is looked at."""
    if case.solver.method != "radial":
        return grid_of(case).spacing
    r = radii(case.solver.nodes, case.solver.half_width)
    near = int(np.abs(r - diagnostics.FRONT_POSITION).argmin())
    return float(r[near + 1] - r[near])


def _sweep(case: Case) -> float:
    """The length of the pressure sweep in a: at the front of an impact, in the inlet of rolling at T = 0."""
    if case.starts_apart:
        return diagnostics.front_length(case)
    return diagnostics.sweep_length(case, case.motion.entrainment(0.0))


def _resolution_warning(case: Case) -> str:
    if case.starts_apart:
        return diagnostics.front_warning(case, _spacing(case))
    return diagnostics.sweep_warning(case, abs(case.motion.entrainment(0.0)))
