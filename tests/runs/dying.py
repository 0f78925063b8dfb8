"""Death in the middle of a run, for tests of what it leaves behind."""

import itertools
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import pytest


class Killed(BaseException):
    """Nobody catches it, like SIGKILL."""


@contextmanager
def killed(
    monkeypatch: pytest.MonkeyPatch, place: Any, name: str, when: str = "after", count: int = 1
) -> Iterator[None]:
    """End this block before or after the given call of a function; it may also come to its own end before."""
    original, calls = getattr(place, name), itertools.count(1)

    def deadly(*arguments: Any, **options: Any) -> Any:
        last = next(calls) == count
        if last and when == "before":
            raise Killed
        result = original(*arguments, **options)
        if last:
            raise Killed
        return result

    with monkeypatch.context() as patch:
        patch.setattr(place, name, deadly)
        try:
            yield
        except Killed:
            return
        assert next(calls) <= count, "it was killed and went on"
