"""The content of `ertel about`: versions, devices, the compile cache, and how to cite."""

import os
import platform
from importlib.metadata import PackageNotFoundError, version

import ertel
from ertel.runs import compiling

PACKAGES = {"JAX": "jax", "jaxlib": "jaxlib", "NumPy": "numpy", "SciPy": "scipy", "xarray": "xarray", "zarr": "zarr"}
CITATION = (
    "The ertel developers. ertel: elastohydrodynamic lubrication of point contacts, impact and rolling by one "
    "equation. Version {version}. Cite with it: Lubrecht AA, Biboulet N, Venner CH. Boundary layers: unifying the "
    "impact and rolling EHL point contacts. Tribology International."
)


def about() -> dict[str, str]:
    """What is installed and where, by name; helpful in a report of a problem."""
    return {
        "ertel": ertel.__version__,
        "Python": f"{platform.python_version()} on {platform.system()} {platform.machine()}",
        **{name: _version(package) for name, package in PACKAGES.items()},
        "known faults": compiling.wrong_version(_version("jaxlib")) or "none in this version of JAX",
        "devices": devices(),
        "compile cache": str(compiling.cache_directory() or "none: there is no home directory"),
        "citation": CITATION.format(version=ertel.__version__),
    }


def devices() -> str:
    """The devices that JAX computes on."""
    try:
        found = [device.device_kind for device in compiling.devices()]
    except (ImportError, compiling.NoDevice) as error:
        return f"none: {error}"
    return ", ".join(f"{kind} ({os.cpu_count()} cores)" if kind == "cpu" else kind for kind in found)


def _version(package: str) -> str:
    try:
        return version(package)
    except PackageNotFoundError:
        return "not installed"
