"""The examples in docstrings give what they say."""

import doctest
import pkgutil
from importlib import import_module

import ertel

MODULES = [name for _, name, _ in pkgutil.walk_packages(ertel.__path__, "ertel.") if "__main__" not in name]
FINDER = doctest.DocTestFinder(exclude_empty=True)
OPTIONS = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE


def test_examples_in_docstrings():
    said: list[str] = []
    for name in ("ertel", *MODULES):
        for test in FINDER.find(import_module(name), name):
            doctest.DocTestRunner(verbose=False, optionflags=OPTIONS).run(test, out=said.append)
    assert not said, "".join(said)


def test_there_are_examples():
    found = [test for name in MODULES for test in FINDER.find(import_module(name), name) if test.examples]
    assert len(found) >= 5
