"""Messages of commands on stderr, and their exit codes."""

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import NoReturn

import typer

FAILED, BAD_INPUT, INTERRUPTED = 1, 2, 130


def check_jax() -> None:
    """Warn if the installed JAX gives wrong results."""
    from ertel.runs import compiling

    compiling.check_jax(lambda message: print(f"ertel: warning: {message}", file=sys.stderr))


def leave(code: int, message: str) -> NoReturn:
    """End with an exit code and a message."""
    print(f"ertel: {message}", file=sys.stderr)
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
