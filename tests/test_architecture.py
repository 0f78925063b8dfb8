"""The house rules that a machine can check: arrows point down, one place for the FFT, silence, budgets."""

import ast
import importlib.util
import io
import sys
import tokenize
from collections.abc import Callable, Collection, Iterable, Iterator
from functools import cache
from pathlib import Path

import ertel
from ertel.case.methods import METHODS
from ertel.solvers import SOLVERS

PACKAGE = Path(next(iter(ertel.__path__)))

# The floor plan: which rooms a room may look into.  A room that is not named here does not exist.
ROOMS: dict[str, set[str]] = {
    "physics": set(),
    "optics": set(),
    "numerics": set(),
    "case": {"physics", "numerics"},  # of numerics only the grid, which counts the nodes
    "equations": {"physics", "numerics", "case"},
    "inputs": {"physics", "optics", "case"},
    "results": {"physics", "numerics", "case"},
    "solvers": {"physics", "numerics", "case", "equations"},
    "plots": {"physics", "optics", "numerics", "case", "results"},
    "runs": {"physics", "optics", "numerics", "case", "equations", "inputs", "results", "solvers", "plots"},
    "apps": {"physics", "optics", "numerics", "case", "equations", "inputs", "results", "solvers", "plots", "runs"},
}
SHORTEST_FILE = 60
SHORT = {"case.status", "inputs.materials"}  # an enumeration and a public face
LONGEST_FILE = 400
LAWS = "physics.laws."  # each a file of its own, of any length, and outside of the budget
MOST_CODE, MOST_SHELL, MOST_FILES = 23_533, 13_800, 171  # aims: 17 500, 9 000, 140


def module_name(path: Path) -> str:
    return ".".join(path.relative_to(PACKAGE).with_suffix("").parts)


FILES = {module_name(path): path for path in sorted(PACKAGE.rglob("*.py"))}
INSIDE = [name for name in FILES if "." in name]


@cache
def parsed(module: str) -> ast.Module:
    return ast.parse(FILES[module].read_text(encoding="utf-8"))


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
    for name in imports(parsed(module)):
        package, _, rest = name.partition(".")
        while package == "ertel" and rest and rest not in FILES:
            rest = rest.rpartition(".")[0]
        if package == "ertel" and rest:
            found.add(rest)
    return found


def room(module: str) -> str:
    return module.split(".")[0]


def outside(module: str) -> set[str]:
    """The packages that a module imports."""
    return {name.split(".")[0] for name in imports(parsed(module))}


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
    assert {"physics.scales", "equations.contact", "numerics.halfspace"} <= set(FILES)
    assert {room(module) for module in INSIDE} == set(ROOMS)


def test_arrows_point_down():
    def upward(module: str) -> set[str]:
        others = {room(name) for name in imported(module)} - {room(module), "version"}  # everybody may ask for it
        return others - ROOMS[room(module)]

    assert broken(upward, INSIDE) == {}


def test_pictures_are_imported_when_they_are_drawn():
    def at_once(module: str) -> list[str]:
        above = (node for node in parsed(module).body if isinstance(node, ast.Import | ast.ImportFrom))
        return [name for node in above for name in imports(node) if name.startswith("ertel.plots")]

    assert broken(at_once, [module for module in INSIDE if room(module) == "runs"]) == {}


def test_the_case_takes_only_the_grid_from_numerics():
    def others(module: str) -> set[str]:
        return {name for name in imported(module) if room(name) == "numerics"} - {"numerics.grid"}

    assert broken(others, [module for module in INSIDE if room(module) == "case"]) == {}


def test_one_public_name_in_one_module():
    """In the library; commands and pictures (`ertel.plots.film`) have the names of what they show."""
    homes: dict[str, list[str]] = {}
    for module in INSIDE:
        if room(module) not in ("apps", "plots"):
            for node in parsed(module).body:
                if isinstance(node, ast.FunctionDef | ast.ClassDef) and not node.name.startswith("_"):
                    homes.setdefault(node.name, []).append(module)
    assert {name: modules for name, modules in homes.items() if len(modules) > 1} == {}


def test_only_the_compiler_sets_up_jax():
    """No private module of JAX anywhere, and its configuration in one place."""

    def private(module: str) -> list[str]:
        return [name for name in imports(parsed(module)) if name.startswith("jax._src")]

    def configured(module: str) -> list[int]:
        found = [node for node in ast.walk(parsed(module)) if isinstance(node, ast.Attribute) and node.attr == "config"]
        return [node.lineno for node in found if isinstance(node.value, ast.Name) and node.value.id == "jax"]

    assert broken(private, FILES) == {}
    assert broken(configured, FILES.keys() - {"runs.compile"}) == {}


def test_no_circle():
    """The modules can be put in an order in which every one comes after those that it imports."""
    left = {name: imported(name) - {name} for name in INSIDE}
    while ready := [name for name, needs in left.items() if not needs & left.keys()]:
        for name in ready:
            del left[name]
    assert not left, f"these import each other: {sorted(left)}"


def test_nobody_asks_which_method_it_is():
    """The record of a method says what it is like, and `solvers` which class carries it out: nobody else compares."""

    def compared(module: str) -> list[int]:
        found: list[ast.AST | None] = []
        for node in ast.walk(parsed(module)):
            match node:
                case ast.Compare(left=left, comparators=others):
                    found += [part for side in (left, *others) for part in ast.walk(side)]
                case ast.Dict(keys=keys):
                    found += keys
                case ast.MatchValue(value=value):
                    found.append(value)
        return [node.lineno for node in found if isinstance(node, ast.Constant) and node.value in METHODS]

    assert compared("solvers.__init__")  # the test sees them
    others = [module for module in INSIDE if module != "case.methods" and room(module) != "solvers"]
    assert broken(compared, others) == {}
    assert METHODS.keys() == SOLVERS.keys()


def test_files_are_neither_long_nor_crumbs():
    lines = {module: len(path.read_text(encoding="utf-8").splitlines()) for module, path in FILES.items()}
    assert {module: n for module, n in lines.items() if n > LONGEST_FILE} == {}, f"{LONGEST_FILE} lines at most"
    pieces = [module for module in INSIDE if FILES[module].name != "__init__.py" and module not in SHORT]
    pieces = [module for module in pieces if not module.startswith(LAWS)]
    assert {module: lines[module] for module in pieces if lines[module] < SHORTEST_FILE} == {}


def test_files_of_tests_have_tests():
    """A merge may leave an empty file, of which pytest says nothing."""
    files = Path(__file__).parent.rglob("test_*.py")
    assert [file.name for file in files if "def test_" not in file.read_text(encoding="utf-8")] == []


def lines_of_code(module: str) -> int:
    """The lines with code: no docstring, no comment, no blank."""
    source = FILES[module].read_text(encoding="utf-8")
    skipped = {tokenize.COMMENT, tokenize.NL, tokenize.NEWLINE, tokenize.INDENT, tokenize.DEDENT, tokenize.ENDMARKER}
    tokens = [t for t in tokenize.generate_tokens(io.StringIO(source).readline) if t.type not in skipped]
    texts = {
        line
        for node in ast.walk(parsed(module))
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant) and isinstance(node.value.value, str)
        for line in range(node.lineno, (node.end_lineno or node.lineno) + 1)
    }
    return len({line for t in tokens for line in range(t.start[0], t.end[0] + 1)} - texts)


def test_the_budget_of_code():
    """What grows pays in lines: these bounds are lowered when code goes, and not raised."""
    code = {module: lines_of_code(module) for module in FILES if not module.startswith(LAWS)}
    shell = sum(n for module, n in code.items() if room(module) in ("apps", "results", "plots", "runs", "inputs"))
    counted = {
        "code lines": (sum(code.values()), MOST_CODE),
        "code lines of apps, inputs, plots, results and runs": (shell, MOST_SHELL),
        "files": (len(code), MOST_FILES),
    }
    over = [f"{what} {n:_} of {most:_}".replace("_", " ") for what, (n, most) in counted.items() if n > most]
    assert not over, f"{', '.join(over)}: see CONTRIBUTING, Budget"


def test_what_pytest_reads_first_imports_no_jax():
    """It would read the environment before `pytest_configure` has set it."""
    harmless = sys.stdlib_module_names | {"hypothesis", "psutil", "pytest"}
    for file in Path(__file__).parent.rglob("conftest.py"):
        whole = ast.parse(file.read_text(encoding="utf-8"))
        whole.body = [node for node in whole.body if isinstance(node, ast.Import | ast.ImportFrom)]
        assert {name.partition(".")[0] for name in imports(whole)} <= harmless, file


def test_the_ground_floor_needs_no_more_than_arrays():
    allowed = {"ertel", "numpy", "scipy", *sys.stdlib_module_names}
    assert broken(lambda m: outside(m) - allowed, [m for m in INSIDE if room(m) in ("physics", "optics")]) == {}
    assert broken(lambda m: outside(m) - allowed - {"jax"}, [m for m in INSIDE if room(m) == "numerics"]) == {}


def test_files_and_units_stay_at_the_edges():
    edge = {"pydantic", "pint", "tomllib", "zarr", "matplotlib", "typer", "rich", "xarray", "pandas"}
    inner = [module for module in INSIDE if room(module) not in ("inputs", "results", "plots", "runs", "apps")]
    assert broken(lambda module: outside(module) & edge, inner) == {}


def test_only_halfspace_speaks_of_the_fft():
    others = FILES.keys() - {"numerics.halfspace"}
    assert broken(lambda module: [n for n in identifiers(parsed(module)) if "fft" in n.lower()], others) == {}


def test_only_the_engine_speaks_of_dask():
    others = FILES.keys() - {"runs.cluster"}
    assert broken(lambda module: outside(module) & {"dask", "distributed"}, others) == {}


def test_library_never_prints():
    library = [module for module in FILES if room(module) != "apps"]
    assert broken(lambda module: {"print"} & set(identifiers(parsed(module))), library) == {}


def test_public_names_are_explained():
    def silent(module: str) -> list[str]:
        public = [node for node in parsed(module).body if isinstance(node, ast.FunctionDef | ast.ClassDef)]
        return [node.name for node in public if not node.name.startswith("_") and ast.get_docstring(node) is None]

    assert broken(silent, FILES) == {}


def test_every_module_says_what_it_is_for():
    assert [module for module in FILES if module != "__init__" and not ast.get_docstring(parsed(module))] == []


def test_package_is_typed():
    assert (PACKAGE / "py.typed").exists()
    assert importlib.util.find_spec("ertel") is not None
