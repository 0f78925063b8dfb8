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
    from ertel.batch import simulate_batch as simulate_batch
    from ertel.case import Case as Case
    from ertel.case import Output as Output
    from ertel.case import Solver as Solver
    from ertel.case import Time as Time
    from ertel.config import ConfigError as ConfigError
    from ertel.config import load_case as load_case
    from ertel.config import parse_case as parse_case
    from ertel.dataset import to_si as to_si
    from ertel.lubricant import Lubricant as Lubricant
    from ertel.scales import Parameters as Parameters
    from ertel.scales import Scales as Scales
    from ertel.simulation import Result as Result
    from ertel.simulation import simulate as simulate
    from ertel.simulation import transient as transient
    from ertel.status import Status as Status

    __version__: str

_HOMES = {
    "simulate_batch": "batch",
    "Case": "case",
    "Output": "case",
    "Solver": "case",
    "Time": "case",
    "ConfigError": "config",
    "load_case": "config",
    "parse_case": "config",
    "to_si": "dataset",
    "Lubricant": "lubricant",
    "Parameters": "scales",
    "Scales": "scales",
    "Result": "simulation",
    "simulate": "simulation",
    "transient": "simulation",
    "Status": "status",
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
