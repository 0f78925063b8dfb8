"""Every error of a command as one sentence on stderr and an exit code; a traceback only in a file."""

import sys
import tempfile
import traceback
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import typer
from typer.core import TyperGroup

from ertel.apps.process import Interrupted, raised
from ertel.apps.terminal import BAD_INPUT, FAILED, leave, reason_of, say

WrongUsage: Any = typer.BadParameter.__base__  # of all errors in flags and arguments


class Commands(TyperGroup):
    """The commands; no error leaves them as a traceback."""

    def invoke(self, ctx: Any) -> Any:
        """Run the command; typer would end it with 130 and no message after any signal."""
        try:
            return super().invoke(ctx)
        except Interrupted as interrupt:
            leave(interrupt.code, "interrupted")

    def main(self, *arguments: Any, standalone_mode: bool = True, **keywords: Any) -> Any:
        """Read the arguments, run the command, and exit; where it does not stand alone, return the exit code."""
        try:
            with raised(), warnings_said():
                code = super().main(*arguments, **{**keywords, "standalone_mode": False})
        except Exception as error:
            code, sentence = _judged(error)
            say(f"ertel: {sentence}")
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
    from ertel.runs.compile import is_of_cache

    if not is_of_cache(message):
        say(f"ertel: warning: {message}")


def _judged(error: Exception) -> tuple[int, str]:
    """The exit code and the sentence of an error that ended a command."""
    if isinstance(error.__cause__, Interrupted):  # that a compiled module met while it was imported
        return error.__cause__.code, "interrupted"
    if isinstance(error, WrongUsage):
        return BAD_INPUT, _usage(error)
    from ertel.case.records import ConfigError
    from ertel.runs import outlook
    from ertel.runs.compile import NoDevice, jax_devices
    from ertel.runs.files import StoreError

    if isinstance(error, ConfigError | StoreError | NoDevice):
        return BAD_INPUT, str(error)
    if outlook.is_out_of_memory(error):
        return FAILED, "out of memory"
    if isinstance(error, OSError):
        return BAD_INPUT, f"{error.filename or 'input or output'}: {reason_of(error)}"
    try:
        jax_devices()
    except NoDevice as cause:
        return BAD_INPUT, str(cause)
    return FAILED, f"internal error, {type(error).__name__}: {error}; {_where(error)}"


def _usage(error: Any) -> str:
    """The fault in the flags, and the command that explains them."""
    message = str(error.format_message()).rstrip(".")
    return f"{message}; see {error.ctx.command_path} --help" if error.ctx else message


def _where(error: Exception) -> str:
    """The place of the traceback: a file, or the next lines where no file can be written."""
    text = "".join(traceback.format_exception(error))
    try:
        with tempfile.NamedTemporaryFile(
            "w", prefix="ertel-", suffix=".txt", delete=False, encoding="utf-8", errors="backslashreplace"
        ) as file:
            file.write(text)
    except OSError:
        return f"please report it:\n{text}"
    return f"please report it with the file {file.name}"
