"""Laws of oils, each in a file of its own: one that is put here is known by its name everywhere."""

from importlib import import_module
from pkgutil import iter_modules

for _module in iter_modules(__path__):
    import_module(f"{__name__}.{_module.name}")
