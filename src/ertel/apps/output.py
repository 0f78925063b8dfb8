"""What reaches the terminal: writing that never fails, and text without control characters.

A closed or full standard output does not stop a command: what it computes is kept, and the fault is told at the end.
"""

import codecs
import errno
import io
import json
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, TextIO

LONGEST = 2000  # characters of a message
SPELLED = {"µ": "u", "Δ": "Delta", "→": "->", "±": "+-", "²": "^2", "∞": "inf"}  # where a terminal cannot show them
ERRORS = "ertel.spelled"
QUIET = (errno.EPIPE, errno.EBADF)  # nobody listens any more: `ertel ... | head -1`


# -- text -------------------------------------------------------------------------------------------------------------


def printable(text: str) -> str:
    """The text with control characters escaped; lines and tabs remain."""
    return "".join(c if c.isprintable() or c in "\n\t" else ascii(c)[1:-1] for c in text)


def short(text: str) -> str:
    """The text, with its middle left out where it is very long."""
    half = LONGEST // 2
    return text if len(text) <= LONGEST else f"{text[:half]} ... {text[-half:]}"


def say(message: str) -> None:
    """Print a message on stderr."""
    print(printable(short(message)), file=sys.stderr, flush=True)


def print_json(content: Any) -> None:
    """Print data as JSON, in ASCII: every terminal takes it, and it reads back as the same data."""
    print(json.dumps(content, indent=2, allow_nan=False))


def _spelled(error: UnicodeError) -> tuple[str, int]:
    """Characters that the terminal cannot show, in letters or as escapes; a handler of `codecs`."""
    assert isinstance(error, UnicodeEncodeError)
    missing = error.object[error.start : error.end]
    return "".join(SPELLED.get(c) or c.encode("ascii", "backslashreplace").decode() for c in missing), error.end


# -- streams ----------------------------------------------------------------------------------------------------------


class Forgiving(io.RawIOBase):
    """A stream that goes on without writing after a fault.  fault: the first one, None while there is none."""

    def __init__(self, raw: Any):
        self.raw = raw
        self.fault: OSError | None = None

    def writable(self) -> bool:
        return True

    def write(self, data: Any) -> int | None:
        if self.fault is None:
            try:
                written: int | None = self.raw.write(data)
                return written
            except OSError as error:
                self.fault = error
        return len(data)

    def fileno(self) -> int:
        number: int = self.raw.fileno()
        return number

    def isatty(self) -> bool:
        terminal: bool = self.raw.isatty()
        return terminal


@contextmanager
def never_failing() -> Iterator[None]:
    """Standard output and standard error that take every character and never raise an error.

    The program ends with its own exit code, with 1 instead of 0 if its output could not be written.
    """
    _open_what_is_closed()
    codecs.register_error(ERRORS, _spelled)
    out, err = _forgiving(sys.stdout), _forgiving(sys.stderr)
    sys.stdout, sys.stderr = _text(out, sys.stdout), _text(err, sys.stderr)
    try:
        yield
    except SystemExit as end:
        sys.stdout.flush()
        if out.fault and out.fault.errno not in QUIET:
            say(f"ertel: cannot write to standard output: {(out.fault.strerror or str(out.fault)).lower()}")
            raise SystemExit(end.code or 1) from None
        raise


def _open_what_is_closed() -> None:
    """Open closed standard streams on nothing: otherwise the next file takes their number and receives their text."""
    while (number := os.open(os.devnull, os.O_RDWR)) <= 2:
        os.set_inheritable(number, True)
    os.close(number)


def _forgiving(stream: TextIO | None) -> Forgiving:
    if stream is None:
        return Forgiving(open(os.devnull, "wb", buffering=0))
    stream.flush()
    return Forgiving(getattr(stream.buffer, "raw", stream.buffer))


def _text(raw: Forgiving, before: TextIO | None) -> TextIO:
    encoding = before.encoding if before else "utf-8"
    return io.TextIOWrapper(io.BufferedWriter(raw), encoding, ERRORS, line_buffering=raw.isatty())
