"""Handling of Ctrl-C."""

import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType


@contextmanager
def interruptible() -> Iterator[Callable[[object], bool]]:
    """An observer that stops the run after Ctrl-C; the current step or grid is finished first.

    A second Ctrl-C ends at once.
    """
    asked = False

    def on_interrupt(number: int, frame: FrameType | None) -> None:
        nonlocal asked
        if asked:
            raise KeyboardInterrupt
        asked = True

    before = signal.signal(signal.SIGINT, on_interrupt)
    try:
        yield lambda item: asked
    finally:
        signal.signal(signal.SIGINT, before)
