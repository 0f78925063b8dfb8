"""ertel: elastohydrodynamic lubrication of point contacts, impact and rolling by one equation.

>>> import ertel
>>> case = ertel.impact(M=1000, L=10, method="radial", nodes=257)
>>> result = ertel.simulate(case)  # doctest: +SKIP
>>> result.summary["H_c"]  # doctest: +SKIP

Everything below is imported when it is first used, so that `import ertel` costs nothing.
"""

import ast
from importlib import import_module
from pathlib import Path
from typing import Any


def _homes(statements: list[ast.stmt]) -> dict[str, tuple[str, str]]:
    """Each name of a stub: the module from which it is imported, and its name there."""
    homes: dict[str, tuple[str, str]] = {}
    for statement in statements:
        match statement:
            case ast.ImportFrom(module=str(module), names=aliases):
                homes |= {alias.name: (module, alias.name) for alias in aliases}
            case ast.Assign(targets=[ast.Name(id=name)], value=ast.Name(id=there)):
                homes[name] = homes.pop(there)
    return homes


_STUB = ast.parse(Path(__file__).with_suffix(".pyi").read_text(encoding="utf-8")).body
_END_OF_SHOWN = next(n for n, statement in enumerate(_STUB) if isinstance(statement, ast.AnnAssign))  # __version__
_HOMES = _homes(_STUB)
__all__ = ["__version__", *_homes(_STUB[:_END_OF_SHOWN])]


def __getattr__(name: str) -> Any:
    if name == "__version__":
        from ertel.version import installed_version

        return installed_version()
    if name not in _HOMES:
        raise AttributeError(f"module 'ertel' has no attribute {name!r}")
    import_module("ertel.inputs.quantities")  # so that all rooms read texts with a unit, see `physics.units.in_si`
    module, there = _HOMES[name]
    if module == "ertel":
        return import_module(f"ertel.{there}")
    return getattr(__import__(module, fromlist=[there]), there)


def __dir__() -> list[str]:
    return __all__
