"""Messages of commands on stderr, and their exit codes."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import NoReturn

import typer

from ertel.apps.output import say

FAILED, BAD_INPUT = 1, 2  # and 128 + the number of a signal, see `interrupts`
ASKED = 130  # stopped by a file, see `ertel.runs.directory`: as by Ctrl-C


def leave(code: int, message: str) -> NoReturn:
    """End with an exit code and a message."""
    say(f"ertel: {message}")
    raise typer.Exit(code)


def reason_of(error: OSError) -> str:
    """The message of the system, without number and file name."""
    return (error.strerror or str(error)).lower()


@contextmanager
def bad_input() -> Iterator[None]:
    """Report errors in this block as errors of the input."""
    try:
        yield
    except ValueError as error:
        leave(BAD_INPUT, str(error))
    except OSError as error:
        leave(BAD_INPUT, f"{error.filename or 'output'}: {reason_of(error)}")
