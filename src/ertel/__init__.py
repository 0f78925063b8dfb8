"""ertel: elastohydrodynamic lubrication of point contacts, impact and rolling by one equation.

>>> import ertel
>>> case = ertel.parse_case({"contact": {"M": 1000, "L": 10}, "solver": {"method": "radial", "nodes": 257}})
>>> result = ertel.simulate(case)  # doctest: +SKIP
>>> result.dataset.H_c  # doctest: +SKIP

The names below are imported when first used, so that `import ertel` costs nothing.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ertel.inputs.case_files import ConfigError as ConfigError
    from ertel.inputs.case_files import load_case as load_case
    from ertel.inputs.case_files import parse_case as parse_case
    from ertel.model.case import Case as Case
    from ertel.model.sections import Output as Output
    from ertel.model.sections import Solver as Solver
    from ertel.model.sections import Time as Time
    from ertel.model.status import Status as Status
    from ertel.physics.lubricant import Lubricant as Lubricant
    from ertel.physics.scales import Parameters as Parameters
    from ertel.physics.scales import Scales as Scales
    from ertel.results.variables import to_si as to_si
    from ertel.runs.batch import simulate_batch as simulate_batch
    from ertel.runs.drive import Result as Result
    from ertel.runs.drive import simulate as simulate
    from ertel.runs.drive import transient as transient

    __version__: str

_HOMES = {
    "simulate_batch": "runs.batch",
    "Case": "model.case",
    "Output": "model.sections",
    "Solver": "model.sections",
    "Time": "model.sections",
    "ConfigError": "inputs.case_files",
    "load_case": "inputs.case_files",
    "parse_case": "inputs.case_files",
    "to_si": "results.variables",
    "Lubricant": "physics.lubricant",
    "Parameters": "physics.scales",
    "Scales": "physics.scales",
    "Result": "runs.drive",
    "simulate": "runs.drive",
    "transient": "runs.drive",
    "Status": "model.status",
}
__all__ = ["__version__", *_HOMES]


def __getattr__(name: str) -> Any:
    if name == "__version__":
        return _version()
    if name not in _HOMES:
        raise AttributeError(f"module 'ertel' has no attribute {name!r}")
    return getattr(import_module(f"ertel.{_HOMES[name]}"), name)


def __dir__() -> list[str]:
    return __all__


def _version() -> str:
    from importlib.metadata import PackageNotFoundError, version

    try:
        return version("ertel")
    except PackageNotFoundError:  # a source tree that was not installed
        return "0+unknown"
