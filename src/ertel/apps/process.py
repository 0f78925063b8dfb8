"""The process of a command: its memory, its standard streams, and the signals and errors that end it.

Every error is one sentence on stderr and an exit code; a traceback goes into a file only.

The signals are Ctrl-C, SIGTERM, and SIGHUP when the terminal is closed; the exit code is 128 + the number of the
signal.
"""

import codecs
import ctypes
import errno
import os
import signal
import sys
import tempfile
import threading
import traceback
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from io import TextIOWrapper
from pathlib import Path
from types import FrameType
from typing import Any, NoReturn, TextIO, cast

import typer
from typer.core import TyperGroup

from ertel.apps.terminal import ASKED, BAD_INPUT, FAILED, in_shell, leave, printable, reason_of, say

WrongUsage: Any = typer.BadParameter.__base__  # of all errors in flags and arguments

# what mallopt(3) calls each setting, its number there, and its value: one arena, and no limit on what is kept
MALLOC = (("ARENA_MAX", -8, 1), ("MMAP_THRESHOLD_", -3, 2**30), ("TRIM_THRESHOLD_", -1, 2**31 - 1))
SPELLED = {"µ": "u", "Δ": "Delta", "→": "->", "±": "+-", "²": "^2", "∞": "inf"}  # where a terminal cannot show them
ERRORS = "ertel.spelled"
NO_GLYPH = "some characters are boxes in pictures, because no font here has them; install one, such as Noto Sans CJK"
UNHEARD = (errno.EPIPE, errno.EBADF)  # nobody reads any more: `ertel ... | head -1`
SIGNALS = [getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name)]
HEARD = "\x1b[?25h\nertel: stops after the current step, on a second Ctrl-C at once; "  # and shows the cursor


def keep_freed_memory() -> None:
    """Keep freed memory in this process and in those that it starts; what the user has set in the environment wins.

    On grids from about 513 x 513 nodes on, glibc returns the arrays of each time step to the kernel, and the kernel
    clears them page by page before the next step gets them back: a quarter of the time of a step.
    """
    with suppress(OSError, AttributeError):  # another C library
        mallopt = ctypes.CDLL("libc.so.6").mallopt
        for name, number, value in MALLOC:
            if f"MALLOC_{name}" not in os.environ:
                mallopt(number, value)
                os.environ[f"MALLOC_{name}"] = str(value)


# -- streams ----------------------------------------------------------------------------------------------------------


class SafeStream:
    """A text stream that takes every character; after a first error, which it keeps, its text goes nowhere."""

    def __init__(self, stream: TextIO | None):
        self._stream = cast(TextIOWrapper, stream or open(os.devnull, "w"))  # noqa: SIM115 - open until the end
        self._stream.reconfigure(errors=ERRORS)
        self.fault: OSError | None = None

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)

    def write(self, text: str) -> int:
        """Write a text."""
        with self._kept():
            self._stream.write(text)
        return len(text)

    def flush(self) -> None:
        """Write what waits."""
        with self._kept():
            self._stream.flush()

    @contextmanager
    def _kept(self) -> Iterator[None]:
        try:
            yield
        except OSError as error:
            self.fault = error
            os.dup2(os.open(os.devnull, os.O_WRONLY), self._stream.fileno())


@contextmanager
def safe_streams() -> Iterator[None]:
    """Let no command stop because its output is closed or full: what it computes is kept.

    The program ends with its own exit code, with 1 instead of 0 if its output could not be written.
    """
    while (number := os.open(os.devnull, os.O_RDWR)) <= 2:  # closed: the next file would receive the text
        os.set_inheritable(number, True)
    os.close(number)
    codecs.register_error(ERRORS, _spelled)
    out, err = SafeStream(sys.stdout), SafeStream(sys.stderr)
    sys.stdout, sys.stderr = cast(TextIO, out), cast(TextIO, err)
    try:
        yield
    except SystemExit as end:
        out.flush()
        if out.fault and out.fault.errno not in UNHEARD:
            say(f"ertel: cannot write to standard output: {reason_of(out.fault)}")
            raise SystemExit(end.code or FAILED) from None
        raise


def _spelled(error: UnicodeError) -> tuple[str, int]:
    """Characters that the terminal cannot show, in letters or as escapes; a handler of `codecs`."""
    assert isinstance(error, UnicodeEncodeError)
    missing = error.object[error.start : error.end]
    return "".join(SPELLED.get(c) or c.encode("ascii", "backslashreplace").decode() for c in missing), error.end


# -- signals ----------------------------------------------------------------------------------------------------------


class Interrupted(KeyboardInterrupt):
    """A signal asked the program to end.  number: of the signal.  code: the exit code."""

    def __init__(self, number: int):
        super().__init__(number)
        self.number, self.code = number, 128 + number


class Stop:
    """An observer that stops a run after a signal.  advice: how to go on.  code: the exit code, 0 before."""

    code = 0

    def __init__(self, advice: str):
        self.advice = advice

    def __call__(self, item: object = None) -> bool:
        """True after a signal."""
        return self.code > 0

    def leave(self) -> NoReturn:
        """End the program after a signal, or after the file that asks to stop."""
        leave(self.code or ASKED, f"interrupted; {self.advice}")


@contextmanager
def raised() -> Iterator[None]:
    """Signals raise `Interrupted` where the program is."""

    def on_signal(number: int, frame: FrameType | None) -> None:
        raise Interrupted(number)

    def raise_again(unraisable: Any) -> None:
        """It came in a destructor or another place where Python ignores exceptions."""
        if isinstance(unraisable.exc_value, Interrupted):
            again = threading.Timer(0.1, os.kill, [os.getpid(), unraisable.exc_value.number])  # this hook is over then
            again.start()
        else:
            before(unraisable)

    with _handled(on_signal):
        before, sys.unraisablehook = sys.unraisablehook, raise_again
        try:
            yield
        finally:
            sys.unraisablehook = before


@contextmanager
def interruptible(advice: str) -> Iterator[Stop]:
    """An observer that stops the run after a signal; the current step or grid is finished first.

    A second Ctrl-C or SIGTERM ends the process at once and without a word, also in compiled code; so the first one says
    on a terminal how to go on, which is the advice.  A second SIGHUP does not: a terminal that is closed and its shell
    both send one.
    """
    stop = Stop(advice)

    def on_signal(number: int, frame: FrameType | None) -> None:
        stop.code = 128 + number
        for each in (signal.SIGINT, signal.SIGTERM):
            if signal.getsignal(each) is on_signal:
                signal.signal(each, signal.SIG_DFL)
        if os.isatty(2):
            os.write(2, f"{HEARD}{printable(advice)}\n".encode())

    with _handled(on_signal):
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


# -- errors -----------------------------------------------------------------------------------------------------------


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
            with raised(), warnings_as_sentences() as not_drawn:
                code = super().main(*arguments, **{**keywords, "standalone_mode": False})
            code = code or (FAILED if not_drawn else 0)
        except Exception as error:
            code, sentence = _judged(error)
            say(f"ertel: {sentence}")
        if standalone_mode:
            sys.exit(code or 0)
        return code


@contextmanager
def warnings_as_sentences() -> Iterator[list[str]]:
    """Print Python's warnings in this block as sentences on stderr; those of pictures that are not drawn."""
    not_drawn: list[str] = []
    said: set[str] = set()

    def show(message: str, category: type[Warning]) -> None:
        from ertel.runs.compile import is_of_cache
        from ertel.runs.files import NotDrawn

        if issubclass(category, NotDrawn):
            not_drawn.append(message)
        if " missing from font(s)" in message:
            message = NO_GLYPH
        if not (is_of_cache(message) or (message == NO_GLYPH and NO_GLYPH in said)):
            say(f"ertel: warning: {message}")
        said.add(message)

    with warnings.catch_warnings():
        warnings.showwarning = lambda message, category, *_: show(str(message), category)
        yield not_drawn


def _judged(error: Exception) -> tuple[int, str]:
    """The exit code and the sentence of an error that ended a command."""
    if isinstance(error.__cause__, Interrupted):  # that a compiled module met while it was imported
        return error.__cause__.code, "interrupted"
    if isinstance(error, WrongUsage):
        message = str(error.format_message()).replace("Value error, ", "").rstrip(".")  # a prefix of pydantic
        return BAD_INPUT, f"{message}; see {error.ctx.command_path} --help" if error.ctx else message
    from ertel.case.records import ConfigError
    from ertel.runs.files import Damaged, StoreError

    if isinstance(error, Damaged):
        return BAD_INPUT, f"{error}{_repair(error.path)}"
    if isinstance(error, ConfigError | StoreError):
        return BAD_INPUT, str(error)
    from ertel.runs import outlook
    from ertel.runs.compile import NoDevice, jax_devices

    if isinstance(error, NoDevice):
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


def _repair(damaged: Path) -> str:
    """The command that repairs a damaged file of a run, as the end of a sentence; empty for other files."""
    from ertel.runs.directory import CASE, CHECKPOINT, SUMMARY, read_case
    from ertel.runs.files import StoreError

    run = next((parent for parent in damaged.parents[:2] if (parent / CASE).exists()), None)
    if run is None:
        return ""
    to_resume = f"ertel resume {in_shell(run)}"
    if damaged.name == CHECKPOINT:
        return f": rm {in_shell(damaged)}; {to_resume}"
    try:
        resumable = damaged.name == SUMMARY or read_case(run).is_steady
    except StoreError:
        return ""
    return f": {to_resume}" if resumable else f": ertel run {in_shell(run / CASE)}"


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
