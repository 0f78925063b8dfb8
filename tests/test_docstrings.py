"""The examples in docstrings give what they say, and what users call is explained in sections."""

import ast
import doctest
import inspect
import pkgutil
from importlib import import_module
from pathlib import Path

import pytest

import ertel

MODULES = [name for _, name, _ in pkgutil.walk_packages(ertel.__path__, "ertel.") if "__main__" not in name]
FINDER = doctest.DocTestFinder(exclude_empty=True)
OPTIONS = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE


def test_examples_in_docstrings():
    said, found = [], 0
    for name in ("ertel", *MODULES):
        for test in FINDER.find(import_module(name), name):
            doctest.DocTestRunner(verbose=False, optionflags=OPTIONS).run(test, out=said.append)
            found += bool(test.examples)
    assert not said, "".join(said)
    assert found >= 5


def test_a_docstring_begins_with_a_noun_or_a_verb():
    """A question word promises an answer and names nothing."""
    riddles = []
    for path in Path(ertel.__path__[0]).rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef):
                first = (ast.get_docstring(node) or "").partition(" ")[0]
                if first in ("What", "How", "Where", "Which", "When", "Who", "Of"):
                    riddles.append((path.name, getattr(node, "name", "")))
    assert riddles == []


CALLED = [name for name in dir(ertel) if callable(getattr(ertel, name)) and name not in ("ConfigError", "StoreError")]


@pytest.mark.parametrize("name", CALLED)
def test_what_users_call_is_explained_in_sections(name):
    thing = getattr(ertel, name)
    text, signature = inspect.getdoc(thing), inspect.signature(thing)
    sections = ["Parameters"] if signature.parameters else []
    if not inspect.isclass(thing):
        sections.append("Returns")
    if "StoreError" in text or "ConfigError" in text or "ValueError" in text:
        sections.append("Raises")
    assert [section for section in sections if f"\n{section}\n{'-' * len(section)}\n" not in text] == []
    assert "Raises " not in text
