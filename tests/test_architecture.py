"""The house rules that a machine can check: arrows point down, one place for the FFT, silence, light start."""

import ast
import importlib.util
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

import ertel

PACKAGE = Path(next(iter(ertel.__path__)))

# From the ground up.  A module may import only modules that stand before it.
PHYSICS = ["status", "bdf", "lubricant", "scales", "hertz", "motion", "roughness", "formulas"]
NUMERICS = ["symmetry", "grid", "halfspace", "multigrid", "tridiagonal", "lines", "newton"]
MODEL = ["closure", "contact", "case", "level", "radial", "solve2d", "steady2d", "transient2d", "tangent2d"]
RUNNING = ["compiling", "sweep", "dataset", "validity", "analysis", "simulation", "response", "batch"]
EDGES = ["units", "casefile", "config", "store", "drawing", "plotting_steady", "plotting"]
EDGES += ["page", "paper_front", "paper_waves", "paper_reduction", "paper_beyond", "paper", "cli"]
ORDER = [*PHYSICS, *NUMERICS, *MODEL, *RUNNING, *EDGES, "__init__", "__main__"]

TREES = {path.stem: ast.parse(path.read_text(encoding="utf-8")) for path in sorted(PACKAGE.glob("*.py"))}

every_module = pytest.mark.parametrize("module", TREES)


def imports(tree: ast.AST) -> Iterator[str]:
    """Every module that is imported anywhere in the file, also inside functions; from a import b gives a.b."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, "imports are absolute"
            yield from (f"{node.module}.{alias.name}" for alias in node.names)


def rooms(module: str) -> set[str]:
    """The modules of ertel that a module imports.  The version belongs to no room: everybody may ask for it."""
    found = set()
    for name in imports(TREES[module]):
        package, *rest = name.split(".")
        if package == "ertel" and rest:
            found.add(rest[0] if rest[0] in ORDER else "__init__")
        elif package == "ertel" and set(attributes_of(TREES[module], "ertel")) != {"__version__"}:
            found.add("__init__")
    return found


def attributes_of(tree: ast.AST, name: str) -> Iterator[str]:
    for node in ast.walk(tree):
        match node:
            case ast.Attribute(value=ast.Name(id=found), attr=attribute) if found == name:
                yield attribute


def identifiers(tree: ast.AST) -> Iterator[str]:
    for node in ast.walk(tree):
        match node:
            case ast.Name(id=name) | ast.Attribute(attr=name) | ast.FunctionDef(name=name) | ast.arg(arg=name):
                yield name
            case ast.alias(name=name):
                yield name


def test_the_package_was_found():
    assert {"scales", "contact", "halfspace"} <= set(TREES)


@every_module
def test_module_has_its_place(module):
    assert module in ORDER, f"give {module} its place in ORDER"


@every_module
def test_arrows_point_down(module):
    below = ORDER[: ORDER.index(module)]
    upward = rooms(module) - set(below)
    assert not upward, f"{module} imports {sorted(upward)}, which stand above it"


@every_module
def test_physics_knows_no_grid_and_no_solver(module):
    if module in PHYSICS:
        assert rooms(module) <= set(PHYSICS)
        outside = {name.split(".")[0] for name in imports(TREES[module])} - set(sys.stdlib_module_names)
        assert outside <= {"ertel", "jax", "numpy", "scipy"}


@pytest.mark.parametrize("module", [name for name in TREES if name not in EDGES])
def test_files_and_units_stay_at_the_edges(module):
    outside = {name.split(".")[0] for name in imports(TREES[module])}
    assert not outside & {"pydantic", "pint", "tomllib", "zarr", "matplotlib", "typer", "rich"}


@every_module
def test_only_halfspace_speaks_of_the_fft(module):
    if module != "halfspace":
        assert [name for name in identifiers(TREES[module]) if "fft" in name.lower()] == []


@every_module
def test_library_never_prints(module):
    if module != "cli":
        assert "print" not in identifiers(TREES[module])


@every_module
def test_public_names_are_explained(module):
    tree = TREES[module]
    public = [node for node in tree.body if isinstance(node, ast.FunctionDef | ast.ClassDef)]
    silent = [node.name for node in public if not node.name.startswith("_") and ast.get_docstring(node) is None]
    assert silent == []
    assert module.startswith("__") or ast.get_docstring(tree), "the module says what it is for"


@pytest.mark.skipif("cli" not in TREES, reason="no command line yet")
def test_command_line_starts_light():
    """`ertel --help` answers at once: what takes long to import comes only when it is needed."""
    heavy = ["jax", "matplotlib", "xarray", "pint"]
    code = f"import sys, ertel.cli; print([name for name in {heavy} if name in sys.modules])"
    path = str(PACKAGE.parent)
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=path)
    assert done.stdout.strip() == "[]"


def test_package_is_typed():
    assert (PACKAGE / "py.typed").exists()
    assert importlib.util.find_spec("ertel") is not None
