"""The house rules that a machine can check: arrows point down, one place for the FFT, silence, light start."""

import ast
import importlib.util
import os
import subprocess
import sys
from collections.abc import Callable, Collection, Iterable, Iterator
from pathlib import Path

import ertel

PACKAGE = Path(next(iter(ertel.__path__)))

# The floor plan: which rooms a room may look into.  A room that is not named here does not exist.
ROOMS: dict[str, set[str]] = {
    "physics": set(),
    "optics": set(),
    "numerics": set(),
    "case": {"physics", "numerics"},
    "equations": {"physics", "numerics", "case"},
    "inputs": {"physics", "optics", "case"},
    "results": {"physics", "optics", "numerics", "case", "equations", "plots"},
    "solvers": {"physics", "numerics", "case", "equations"},
    "plots": {"physics", "optics", "numerics", "case", "results"},
    "runs": {"physics", "optics", "numerics", "case", "equations", "inputs", "results", "solvers", "plots"},
    "apps": {"physics", "optics", "numerics", "case", "equations", "inputs", "results", "solvers", "plots", "runs"},
}
LONGEST_FILE = 400


def module_name(path: Path) -> str:
    return ".".join(path.relative_to(PACKAGE).with_suffix("").parts)


FILES = {module_name(path): path for path in sorted(PACKAGE.rglob("*.py"))}
TREES = {name: ast.parse(path.read_text(encoding="utf-8")) for name, path in FILES.items()}
INSIDE = [name for name in TREES if "." in name]


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


def outside(module: str) -> set[str]:
    """The packages that a module imports."""
    return {name.split(".")[0] for name in imports(TREES[module])}


def broken(wrong: Callable[[str], Collection[object]], modules: Iterable[str]) -> dict[str, Collection[object]]:
    """What is wrong in each module that breaks a rule."""
    return {module: found for module in modules if (found := wrong(module))}


def identifiers(tree: ast.AST) -> Iterator[str]:
    for node in ast.walk(tree):
        match node:
            case ast.Name(id=name) | ast.Attribute(attr=name) | ast.FunctionDef(name=name) | ast.arg(arg=name):
                yield name
            case ast.alias(name=name):
                yield name


def test_the_package_was_found():
    assert {"physics.scales", "equations.contact", "numerics.halfspace"} <= set(TREES)
    assert {room(module) for module in INSIDE} == set(ROOMS)


def test_arrows_point_down():
    def upward(module: str) -> set[str]:
        others = {room(name) for name in imported(module)} - {room(module), "version"}  # everybody may ask for it
        return others - ROOMS[room(module)]

    assert broken(upward, INSIDE) == {}


def test_no_circle():
    """The modules can be put in an order in which every one comes after those that it imports."""
    left = {name: imported(name) - {name} for name in INSIDE}
    while ready := [name for name, needs in left.items() if not needs & left.keys()]:
        for name in ready:
            del left[name]
    assert not left, f"these import each other: {sorted(left)}"


def test_files_are_short():
    lines = {module: len(path.read_text(encoding="utf-8").splitlines()) for module, path in FILES.items()}
    assert {module: n for module, n in lines.items() if n > LONGEST_FILE} == {}, f"{LONGEST_FILE} lines at most"


def test_the_ground_floor_needs_no_more_than_arrays():
    allowed = {"ertel", "numpy", "scipy", *sys.stdlib_module_names}
    assert broken(lambda m: outside(m) - allowed, [m for m in INSIDE if room(m) in ("physics", "optics")]) == {}
    assert broken(lambda m: outside(m) - allowed - {"jax"}, [m for m in INSIDE if room(m) == "numerics"]) == {}


def test_files_and_units_stay_at_the_edges():
    edge = {"pydantic", "pint", "tomllib", "zarr", "matplotlib", "typer", "rich", "xarray", "pandas"}
    inner = [module for module in INSIDE if room(module) not in ("inputs", "results", "plots", "runs", "apps")]
    assert broken(lambda module: outside(module) & edge, inner) == {}


def test_only_halfspace_speaks_of_the_fft():
    others = TREES.keys() - {"numerics.halfspace"}
    assert broken(lambda module: [n for n in identifiers(TREES[module]) if "fft" in n.lower()], others) == {}


def test_only_the_engine_speaks_of_dask():
    others = TREES.keys() - {"runs.cluster", "runs.on_workers"}
    assert broken(lambda module: outside(module) & {"dask", "distributed"}, others) == {}


def test_library_never_prints():
    library = [module for module in TREES if room(module) != "apps"]
    assert broken(lambda module: {"print"} & set(identifiers(TREES[module])), library) == {}


def test_public_names_are_explained():
    def silent(module: str) -> list[str]:
        public = [node for node in TREES[module].body if isinstance(node, ast.FunctionDef | ast.ClassDef)]
        return [node.name for node in public if not node.name.startswith("_") and ast.get_docstring(node) is None]

    assert broken(silent, TREES) == {}


def test_every_module_says_what_it_is_for():
    assert [module for module in TREES if module != "__init__" and not ast.get_docstring(TREES[module])] == []


def test_command_line_starts_light():
    """`ertel --help` answers at once: what takes long to import comes only when it is needed."""
    heavy = ["jax", "matplotlib", "xarray", "pint", "distributed"]
    code = f"import sys, ertel.apps.cli; print([name for name in {heavy} if name in sys.modules])"
    path = str(PACKAGE.parent)
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=path)
    assert done.stdout.strip() == "[]"


def test_a_check_needs_no_jax(tmp_path):
    """`ertel check` estimates memory and time without the two seconds that JAX takes to import."""
    check = """
import sys
from pathlib import Path
from ertel.apps.cases import check
Path("case.toml").write_text('[contact]\\nkind = "{kind}"\\nM = 200\\nL = 10\\n[solver]\\nmethod = "{method}"')
check(Path("case.toml"))
print([name for name in ("jax", "xarray", "matplotlib", "zarr") if name in sys.modules])
"""
    for kind, method in (("rolling", "steady"), ("impact", "radial")):
        code, environment = check.format(kind=kind, method=method), {**os.environ, "PYTHONPATH": str(PACKAGE.parent)}
        done = subprocess.run(
            [sys.executable, "-c", code], capture_output=True, text=True, check=True, env=environment, cwd=tmp_path
        )
        assert "memory" in done.stdout and done.stdout.splitlines()[-1] == "[]"


def test_package_is_typed():
    assert (PACKAGE / "py.typed").exists()
    assert importlib.util.find_spec("ertel") is not None
