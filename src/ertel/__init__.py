"""ertel: elastohydrodynamic lubrication of point contacts, impact and rolling by one equation.

>>> import ertel
>>> case = ertel.impact(M=1000, L=10, method="radial", nodes=257)
>>> result = ertel.simulate(case)  # doctest: +SKIP
>>> result.summary["max_approach"]["H_c"]  # doctest: +SKIP

Everything below is imported when it is first used, so that `import ertel` costs nothing.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ertel import optics as optics
    from ertel import plots as plots
    from ertel.case.case import Case as Case
    from ertel.case.height_map import Measured as Measured
    from ertel.case.sections import Output as Output
    from ertel.case.sections import Solver as Solver
    from ertel.case.sections import Time as Time
    from ertel.case.status import Status as Status
    from ertel.inputs import materials as materials
    from ertel.inputs import oils as oils
    from ertel.inputs.case_files import ConfigError as ConfigError
    from ertel.inputs.case_files import load_case as load_case
    from ertel.inputs.case_files import parse_case as parse_case
    from ertel.inputs.case_files import to_toml as to_toml
    from ertel.inputs.python import Oil as Oil
    from ertel.inputs.python import impact as impact
    from ertel.inputs.python import quantity as quantity
    from ertel.inputs.python import rolling as rolling
    from ertel.physics import amplitude_reduction as amplitude_reduction
    from ertel.physics import film_formulas as formulas
    from ertel.physics import hertz as hertz
    from ertel.physics import units as units
    from ertel.physics.lubricant import Lubricant as Lubricant
    from ertel.physics.motion import Motion as Motion
    from ertel.physics.registry import DENSITY_LAWS as density_laws
    from ertel.physics.registry import FLUIDITY_LAWS as fluidity_laws
    from ertel.physics.registry import SHAPES as shapes
    from ertel.physics.registry import VISCOSITY_LAWS as viscosity_laws
    from ertel.physics.scales import Parameters as Parameters
    from ertel.physics.scales import Scales as Scales
    from ertel.physics.surfaces import Feature as Feature
    from ertel.physics.surfaces import RingWaviness as RingWaviness
    from ertel.physics.surfaces import SelfAffine as SelfAffine
    from ertel.physics.surfaces import Spot as Spot
    from ertel.physics.surfaces import Waviness as Waviness
    from ertel.results import fronts as fronts
    from ertel.results import result as accessor
    from ertel.results import waves as waves
    from ertel.results.result import Result as Result
    from ertel.results.study_result import StudyResult as StudyResult
    from ertel.results.traction_curve import TractionCurve as TractionCurve
    from ertel.results.variables import to_si as to_si
    from ertel.runs import tasks as tasks
    from ertel.runs.batch import simulate_batch as simulate_batch
    from ertel.runs.compile import cache as cache
    from ertel.runs.drive import simulate as simulate
    from ertel.runs.response import respond as respond
    from ertel.runs.response import respond_in_rolling as respond_in_rolling
    from ertel.runs.response import respond_linearly as respond_linearly
    from ertel.runs.store import open_run as open
    from ertel.runs.store import run as run
    from ertel.runs.studies import sweep as sweep
    from ertel.runs.traction import traction as traction

    __version__: str

_HOMES = {  # name: module, or module:name there
    "ConfigError": "inputs.case_files",
    "load_case": "inputs.case_files",
    "parse_case": "inputs.case_files",
    "to_toml": "inputs.case_files",
    "Oil": "inputs.python",
    "impact": "inputs.python",
    "quantity": "inputs.python",
    "rolling": "inputs.python",
    "Case": "case.case",
    "Output": "case.sections",
    "Solver": "case.sections",
    "Time": "case.sections",
    "Status": "case.status",
    "Lubricant": "physics.lubricant",
    "Motion": "physics.motion",
    "density_laws": "physics.registry:DENSITY_LAWS",
    "fluidity_laws": "physics.registry:FLUIDITY_LAWS",
    "shapes": "physics.registry:SHAPES",
    "viscosity_laws": "physics.registry:VISCOSITY_LAWS",
    "Parameters": "physics.scales",
    "Scales": "physics.scales",
    "Feature": "physics.surfaces",
    "Measured": "case.height_map",
    "RingWaviness": "physics.surfaces",
    "SelfAffine": "physics.surfaces",
    "Spot": "physics.surfaces",
    "Waviness": "physics.surfaces",
    "Result": "results.result",
    "StudyResult": "results.study_result",
    "TractionCurve": "results.traction_curve",
    "to_si": "results.variables",
    "simulate_batch": "runs.batch",
    "cache": "runs.compile",
    "simulate": "runs.drive",
    "respond": "runs.response",
    "respond_in_rolling": "runs.response",
    "respond_linearly": "runs.response",
    "open": "runs.store:open_run",
    "run": "runs.store",
    "sweep": "runs.studies",
    "traction": "runs.traction",
}
_MODULES = {
    "amplitude_reduction": "physics.amplitude_reduction",
    "formulas": "physics.film_formulas",
    "hertz": "physics.hertz",
    "materials": "inputs.materials",
    "oils": "inputs.oils",
    "optics": "optics",
    "units": "physics.units",
    "accessor": "results.result",
    "fronts": "results.fronts",
    "plots": "plots",
    "waves": "results.waves",
    "tasks": "runs.tasks",
}
_ROOMS = ("physics", "numerics", "case", "equations", "inputs", "results", "plots", "solvers", "runs", "apps")
__all__ = ["__version__", *_HOMES, *_MODULES]


def __getattr__(name: str) -> Any:
    if name == "__version__":
        from ertel.version import installed_version

        return installed_version()
    if name in _MODULES:
        return import_module(f"ertel.{_MODULES[name]}")
    if name in _ROOMS:
        return import_module(f"ertel.{name}")
    if name not in _HOMES:
        raise AttributeError(f"module 'ertel' has no attribute {name!r}")
    module, _, there = _HOMES[name].partition(":")
    return getattr(import_module(f"ertel.{module}"), there or name)


def __dir__() -> list[str]:
    return [*__all__, *_ROOMS]
