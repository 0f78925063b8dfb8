"""The examples in docstrings give what they say."""

import doctest
import pkgutil
from importlib import import_module

import pytest

import ertel

MODULES = [name for _, name, _ in pkgutil.walk_packages(ertel.__path__, "ertel.") if "__main__" not in name]
FINDER = doctest.DocTestFinder(exclude_empty=True)


@pytest.mark.parametrize("name", ["ertel", *MODULES])
def test_examples_in_docstrings(name):
    module, said = import_module(name), []
    runner = doctest.DocTestRunner(verbose=False, optionflags=doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE)
    for test in FINDER.find(module, name):
        runner.run(test, out=said.append)
    assert not runner.failures, "".join(said)


def test_there_are_examples():
    found = [test for name in MODULES for test in FINDER.find(import_module(name), name) if test.examples]
    assert len(found) >= 5
