"""Writes the inventories in this folder: where the pages of other packages explain the few names that ours mention.

    python docs/inventories/write.py

Sphinx reads them in place of the complete ones, which it would have to fetch.  Every name must exist in the installed
package; a new name that docstrings mention is added below.
"""

from importlib import import_module
from pathlib import Path

from sphobjinv import DataObjStr, Inventory

# package: (names, their page as a pattern); $ stands for the name
NAMES = {
    "python": {
        "class": {
            "float": "library/functions.html#$",
            "int": "library/functions.html#$",
            "bool": "library/functions.html#$",
            "str": "library/stdtypes.html#$",
            "dict": "library/stdtypes.html#$",
            "list": "library/stdtypes.html#$",
            "tuple": "library/stdtypes.html#$",
            "pathlib.Path": "library/pathlib.html#$",
            "collections.abc.Callable": "library/collections.abc.html#$",
            "collections.abc.Mapping": "library/collections.abc.html#$",
            "collections.abc.Sequence": "library/collections.abc.html#$",
        },
        "exception": {"ValueError": "library/exceptions.html#$"},
    },
    "numpy": {
        "class": {"numpy.ndarray": "reference/generated/numpy.ndarray.html#$"},
        "attribute": {"numpy.float64": "reference/arrays.scalars.html#$"},
    },
    "xarray": {
        "class": {name: "generated/$.html#$" for name in ("xarray.Dataset", "xarray.DataArray")},
        "function": {"xarray.open_zarr": "generated/$.html#$"},
    },
    "matplotlib": {"class": {"matplotlib.figure.Figure": "api/figure_api.html#$"}},
}


def require(name: str) -> None:
    """Raise AttributeError or ImportError where the installed packages do not have a name."""
    module, _, attribute = name.rpartition(".")
    getattr(import_module(module or "builtins"), attribute)


def write(package: str) -> None:
    """The inventory of one package."""
    inventory = Inventory()
    inventory.project, inventory.version = package, ""
    for role, names in NAMES[package].items():
        for name, uri in names.items():
            require(name)
            inventory.objects.append(
                DataObjStr(
                    name=name,
                    domain="py",
                    role=role,
                    priority="1",
                    uri=uri.replace("$.html", name + ".html"),
                    dispname="-",
                )
            )
    data = inventory.data_file(contract=True)
    Path(__file__).with_name(f"{package}.inv").write_bytes(compress(data))


def compress(data: bytes) -> bytes:
    from sphobjinv import compress as compressed

    return compressed(data)


if __name__ == "__main__":
    for package in NAMES:
        write(package)
