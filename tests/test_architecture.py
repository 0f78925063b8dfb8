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

# The floor plan: which rooms a room may look into.  A room that is not named here does not exist.
ROOMS: dict[str, set[str]] = {
    "physics": set(),
    "numerics": set(),
    "model": {"physics", "numerics"},
    "inputs": {"physics", "model"},
    "results": {"physics", "numerics", "model"},
    "solvers": {"physics", "numerics", "model"},
    "runs": {"physics", "numerics", "model", "inputs", "results", "solvers"},
    "apps": {"physics", "numerics", "model", "inputs", "results", "solvers", "runs"},
}
LONGEST_FILE = 400


def module_name(path: Path) -> str:
    return ".".join(path.relative_to(PACKAGE).with_suffix("").parts)


FILES = {module_name(path): path for path in sorted(PACKAGE.rglob("*.py"))}
TREES = {name: ast.parse(path.read_text(encoding="utf-8")) for name, path in FILES.items()}
INSIDE = [name for name in TREES if "." in name]

every_module = pytest.mark.parametrize("module", TREES)
in_a_room = pytest.mark.parametrize("module", INSIDE)


def imports(tree: ast.AST) -> Iterator[str]:
    """Every module that is imported anywhere in the file, also inside functions; from a import b gives a.b."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, "imports are absolute"
            yield from (f"{node.module}.{alias.name}" for alias in node.names)


def imported(module: str) -> set[str]:
    """The modules of ertel that a module imports, as far as they exist."""
    found = set()
    for name in imports(TREES[module]):
        package, _, rest = name.partition(".")
        while package == "ertel" and rest and rest not in TREES:
            rest = rest.rpartition(".")[0]
        if package == "ertel" and rest:
            found.add(rest)
    return found


def room(module: str) -> str:
    return module.split(".")[0]


def identifiers(tree: ast.AST) -> Iterator[str]:
    for node in ast.walk(tree):
        match node:
            case ast.Name(id=name) | ast.Attribute(attr=name) | ast.FunctionDef(name=name) | ast.arg(arg=name):
                yield name
            case ast.alias(name=name):
                yield name


def test_the_package_was_found():
    assert {"physics.scales", "model.contact", "numerics.halfspace"} <= set(TREES)
    assert {room(module) for module in INSIDE} == set(ROOMS)


@in_a_room
def test_arrows_point_down(module):
    others = {room(name) for name in imported(module)} - {room(module), "version"}  # everybody may ask for the version
    upward = others - ROOMS[room(module)]
    assert not upward, f"{module} looks into {sorted(upward)}"


def test_no_circle():
    """The modules can be put in an order in which every one comes after those that it imports."""
    left = {name: imported(name) - {name} for name in INSIDE}
    while ready := [name for name, needs in left.items() if not needs & left.keys()]:
        for name in ready:
            del left[name]
    assert not left, f"these import each other: {sorted(left)}"


@every_module
def test_files_are_short(module):
    lines = len(FILES[module].read_text(encoding="utf-8").splitlines())
    assert lines <= LONGEST_FILE, f"{module}: {lines} lines; split it, {LONGEST_FILE} at most"


@pytest.mark.parametrize("module", [name for name in INSIDE if room(name) in ("physics", "numerics")])
def test_the_ground_floor_needs_no_more_than_arrays(module):
    outside = {name.split(".")[0] for name in imports(TREES[module])} - set(sys.stdlib_module_names)
    assert outside <= {"ertel", "numpy", "scipy"} | ({"jax"} if room(module) == "numerics" else set())


@pytest.mark.parametrize("module", [name for name in INSIDE if room(name) not in ("inputs", "results", "runs", "apps")])
def test_files_and_units_stay_at_the_edges(module):
    outside = {name.split(".")[0] for name in imports(TREES[module])}
    assert not outside & {"pydantic", "pint", "tomllib", "zarr", "matplotlib", "typer", "rich", "xarray", "pandas"}


@every_module
def test_only_halfspace_speaks_of_the_fft(module):
    if module != "numerics.halfspace":
        assert [name for name in identifiers(TREES[module]) if "fft" in name.lower()] == []


@every_module
def test_library_never_prints(module):
    if not module.startswith("apps."):
        assert "print" not in identifiers(TREES[module])


@every_module
def test_public_names_are_explained(module):
    tree = TREES[module]
    public = [node for node in tree.body if isinstance(node, ast.FunctionDef | ast.ClassDef)]
    silent = [node.name for node in public if not node.name.startswith("_") and ast.get_docstring(node) is None]
    assert silent == []
    assert module == "__init__" or ast.get_docstring(tree), "the module says what it is for"


def test_command_line_starts_light():
    """`ertel --help` answers at once: what takes long to import comes only when it is needed."""
    heavy = ["jax", "matplotlib", "xarray", "pint"]
    code = f"import sys, ertel.apps.cli; print([name for name in {heavy} if name in sys.modules])"
    path = str(PACKAGE.parent)
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=path)
    assert done.stdout.strip() == "[]"


def test_package_is_typed():
    assert (PACKAGE / "py.typed").exists()
    assert importlib.util.find_spec("ertel") is not None
