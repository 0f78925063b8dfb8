"""Every error of a command as one sentence on stderr and an exit code; a traceback only in a file."""

import sys
import tempfile
import traceback
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from typing import Any

import typer
from typer.core import TyperGroup

from ertel.apps.exits import BAD_INPUT, FAILED, leave, reason_of
from ertel.apps.interrupts import Interrupted, raised
from ertel.apps.output import say

WrongUsage: Any = typer.BadParameter.__base__  # of all errors in flags and arguments


class Commands(TyperGroup):
    """The commands; no error leaves them as a traceback."""

    def invoke(self, ctx: Any) -> Any:
        """Run the command."""
        with as_sentences():
            return super().invoke(ctx)

    def main(self, *arguments: Any, standalone_mode: bool = True, **keywords: Any) -> Any:
        """Read the arguments, run the command, and exit; where it does not stand alone, return the exit code."""
        run = partial(super().main, *arguments, **{**keywords, "standalone_mode": False})
        try:
            with as_sentences(), raised(), warnings_said():
                code = run()
        except typer.Exit as end:
            code = end.exit_code
        if standalone_mode:
            sys.exit(code or 0)
        return code


@contextmanager
def warnings_said() -> Iterator[None]:
    """Python's warnings in this block as sentences on stderr."""
    with warnings.catch_warnings():
        warnings.showwarning = lambda message, *_: _say_warning(str(message))
        yield


def _say_warning(message: str) -> None:
    from ertel.runs import compiling

    if not compiling.is_of_cache(message):
        say(f"ertel: warning: {message}")


@contextmanager
def as_sentences() -> Iterator[None]:
    """Report each error in this block and exit; errors that carry an exit code already pass."""
    try:
        yield
    except (typer.Exit, typer.Abort):
        raise
    except KeyboardInterrupt as error:
        leave(error.code if isinstance(error, Interrupted) else Interrupted().code, "interrupted")
    except WrongUsage as error:
        leave(BAD_INPUT, _usage(error))
    except Exception as error:
        if isinstance(error.__cause__, Interrupted):  # that a compiled module met while it was imported
            leave(error.__cause__.code, "interrupted")
        leave(*_judged(error))


def _usage(error: Any) -> str:
    """What is wrong with the flags, and where they are explained."""
    told = str(error.format_message()).rstrip(".")
    return f"{told}; see {error.ctx.command_path} --help" if error.ctx else told


def _judged(error: Exception) -> tuple[int, str]:
    """The exit code and the sentence of an error that a command did not expect."""
    from ertel.inputs.messages import ConfigError
    from ertel.runs import compiling, outlook
    from ertel.runs.store import StoreError

    if isinstance(error, ConfigError | StoreError | compiling.NoDevice):
        return BAD_INPUT, str(error)
    if outlook.is_out_of_memory(error):
        return FAILED, "out of memory"
    if isinstance(error, OSError):
        return BAD_INPUT, f"{error.filename or 'input or output'}: {reason_of(error)}"
    try:
        compiling.devices()
    except compiling.NoDevice as cause:
        return BAD_INPUT, str(cause)
    return FAILED, f"internal error, {type(error).__name__}: {error}; {_where(error)}"


def _where(error: Exception) -> str:
    """Where the traceback is: in a file, or below where no file can be written."""
    told = "".join(traceback.format_exception(error))
    try:
        with tempfile.NamedTemporaryFile(
            "w", prefix="ertel-", suffix=".txt", delete=False, encoding="utf-8", errors="backslashreplace"
        ) as file:
            file.write(told)
    except OSError:
        return f"please report it:\n{told}"
    return f"please report it with the file {file.name}"
