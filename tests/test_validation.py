"""The stored tables of validation are those of today's code: `validation/all.py` compares them."""

import importlib.util
from pathlib import Path

import pytest

PROGRAM = Path(__file__).parents[1] / "validation" / "all.py"
pytestmark = pytest.mark.skipif(not PROGRAM.exists(), reason="the validation programs are not part of a package")
MINUTES = 3.0  # pages that take longer are compared by `python validation/all.py --check`

if PROGRAM.exists():
    spec = importlib.util.spec_from_file_location("validation_all", PROGRAM)
    validation = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(validation)
    QUICK = validation.chosen([], MINUTES)
else:
    QUICK = []

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


@pytest.mark.slow
@pytest.mark.parametrize("page", QUICK, ids=lambda page: f"{page.path} {page.program}")
def test_stored_tables_are_those_of_the_code(page):
    if ("reference" in page.arguments or "cavity" in page.arguments) and not validation.REFERENCE.exists():
        pytest.skip("the reference numbers are not beside the checkout")
    assert validation.check(page) == []
