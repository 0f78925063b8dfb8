"""The stored tables of validation are those of today's code: `validation/all.py` compares them."""

import ast
import importlib.util
from importlib import import_module
from pathlib import Path
from types import ModuleType

import pytest

PROGRAM = Path(__file__).parents[1] / "validation" / "all.py"
if not PROGRAM.exists():
    pytest.skip("the validation programs are not part of a package", allow_module_level=True)
spec = importlib.util.spec_from_file_location("validation_all", PROGRAM)
validation = importlib.util.module_from_spec(spec)
spec.loader.exec_module(validation)
MINUTES = 3.0  # pages that take longer are compared by `python validation/all.py --check`
PAGE = "# Films\n\n| M | H_c | steps |\n| --- | --- | --- |\n| 20 | 0.4373 | 100 |\n\nText with 2 nodes.\n"


def test_a_printed_table_takes_the_place_of_the_one_with_its_head():
    printed = "noise\n| M | H_c | steps |\n| --- | --- | --- |\n| 20 | 0.5000 | 90 |\n| 30 | 0.4000 | 91 |\n"
    made = validation.spliced(PAGE, printed)
    assert made.splitlines()[4:6] == ["| 20 | 0.5000 | 90 |", "| 30 | 0.4000 | 91 |"]
    assert made.endswith("\n\nText with 2 nodes.\n")
    assert [p for p in validation.PAGES if not (validation.ROOT / p.program).exists()] == []
    assert [p.path for p in validation.PAGES if not (validation.ROOT / p.path).exists()] == []


@pytest.mark.parametrize(
    ("old", "new", "count"),
    [
        ("0.4373", "0.4374", 0),  # a unit of the last digit
        ("0.4373", "0.4573", 1),
        ("| 100 |", "| 110 |", 0),  # steps
        ("| 100 |", "| 150 |", 1),
        ("| 20 |", "| 20 (film vanished) |", 1),
        ("Text", "Words", 1),
        ("2 nodes", "9 nodes", 1),
    ],
)
def test_numbers_and_words_that_differ_are_found(old, new, count):
    assert len(validation.differences(PAGE, PAGE.replace(old, new))) == count


def missing(program):
    """The names of modules of ertel that a program uses, and that are not there."""
    used, modules = list(ast.walk(ast.parse(program))), {"ertel": import_module("ertel")}
    for line in used:
        if isinstance(line, ast.ImportFrom) and (line.module or "").split(".")[0] == "ertel":
            for name in [alias.name for alias in line.names]:
                found = getattr(import_module(line.module), name, None)
                try:
                    found = found or import_module(f"{line.module}.{name}")
                except ModuleNotFoundError:
                    yield f"{line.module}.{name}"
                modules |= {name: found} if isinstance(found, ModuleType) else {}
    own = {name.id for name in used if isinstance(name, ast.Name) and isinstance(name.ctx, ast.Store)}
    for name in used:
        if isinstance(name, ast.Attribute) and isinstance(name.value, ast.Name) and name.value.id not in own:
            module = modules.get(name.value.id)
            if module and not hasattr(module, name.attr):
                yield f"{module.__name__}.{name.attr}"


def test_programs_use_names_that_are_there():
    assert [*missing("from ertel import hertz, no_name\nhertz.pressure(hertz.no_law)")] == [
        "ertel.no_name",
        "ertel.physics.hertz.no_law",
    ]
    programs = [path for folder in ("validation", "benchmarks") for path in (validation.ROOT / folder).rglob("*.py")]
    assert {path.name: names for path in programs if (names := [*missing(path.read_text(encoding="utf-8"))])} == {}


@pytest.mark.slow
@pytest.mark.parametrize("page", validation.chosen([], MINUTES), ids=lambda page: f"{page.path} {page.program}")
def test_stored_tables_are_those_of_the_code(page):
    if ("reference" in page.arguments or "cavity" in page.arguments) and not validation.REFERENCE.exists():
        pytest.skip("the reference numbers are not beside the checkout")
    assert validation.check(page) == []
