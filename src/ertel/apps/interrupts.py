"""Ctrl-C, and the signals by which a system ends a program: SIGTERM, and SIGHUP when its terminal is closed.

The exit code is 128 + the number of the signal.
"""

import os
import signal
import socket
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType
from typing import Any

SIGNALS = [getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name)]
HANGUP = getattr(signal, "SIGHUP", None)


class Interrupted(KeyboardInterrupt):
    """A signal asked the program to end.  number: of the signal.  code: the exit code."""

    def __init__(self, number: int = signal.SIGINT):
        super().__init__(number)
        self.number, self.code = number, 128 + number


class Stop:
    """An observer that stops a run after a signal; it is called with every item.  code: the exit code, 0 before."""

    code = 0

    def __call__(self, item: object) -> bool:
        return self.code > 0


@contextmanager
def raised() -> Iterator[None]:
    """Signals raise `Interrupted` where the program is."""

    def on_signal(number: int, frame: FrameType | None) -> None:
        raise Interrupted(number)

    with _handled(on_signal), _never_lost():
        yield


@contextmanager
def deferred() -> Iterator[None]:
    """Signals wait for the end of this block, which must be short: what it starts is then whole and can be ended."""
    came: list[int] = []
    with _handled(lambda number, frame: came.append(number)):
        yield
    for number in came[:1]:
        signal.raise_signal(number)


@contextmanager
def _never_lost() -> Iterator[None]:
    """Raise a signal again that came in a destructor or another place where Python ignores exceptions."""
    before = sys.unraisablehook

    def hook(unraisable: Any) -> None:
        if isinstance(unraisable.exc_value, Interrupted):
            threading.Timer(0.01, os.kill, [os.getpid(), unraisable.exc_value.number]).start()
        else:
            before(unraisable)

    sys.unraisablehook = hook
    try:
        yield
    finally:
        sys.unraisablehook = before


@contextmanager
def interruptible() -> Iterator[Stop]:
    """An observer that stops the run after a signal; the current step or grid is finished first.

    A second signal ends the process at once.
    """
    stop = Stop()

    def on_signal(number: int, frame: FrameType | None) -> None:
        stop.code = 128 + number

    with _handled(on_signal), _second_ends():
        yield stop


@contextmanager
def _handled(handler: Callable[[int, FrameType | None], None]) -> Iterator[None]:
    """Handle the signals; one that is ignored remains ignored, so that `nohup` works."""
    before = {number: signal.getsignal(number) for number in SIGNALS}
    ours = {number: old for number, old in before.items() if old not in (signal.SIG_IGN, None)}
    for number in ours:
        signal.signal(number, handler)
    try:
        yield
    finally:
        for number, old in ours.items():
            signal.signal(number, old)


@contextmanager
def _second_ends() -> Iterator[None]:
    """End the process at the second signal.  A thread listens, because handlers wait while compiled code runs.

    A second SIGHUP does not count: a terminal that is closed and its shell both send one.
    """
    listener, sender = socket.socketpair()
    sender.setblocking(False)
    before = signal.set_wakeup_fd(sender.fileno(), warn_on_full_buffer=False)
    threading.Thread(target=_end_at_second, args=(listener,), daemon=True).start()
    try:
        yield
    finally:
        signal.set_wakeup_fd(before)
        sender.close()  # which ends the thread


def _end_at_second(listener: socket.socket) -> None:
    with listener:
        listener.recv(1)
        second = listener.recv(1)  # nothing at the end of the block above
        while second and second[0] == HANGUP:
            second = listener.recv(1)
    if second:
        if os.isatty(2):
            os.write(2, b"\x1b[?25h\n")  # show the cursor, which a progress bar hides
        os._exit(128 + second[0])
