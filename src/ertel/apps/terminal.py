"""The words of a command: messages, JSON, paths, and the exit codes that go with them."""

import json
import os
import re
import shlex
import sys
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from os.path import lexists
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NoReturn

import typer

LONGEST = 2000  # characters of a message
FAILED, BAD_INPUT = 1, 2  # exit codes; and 128 + the number of a signal, see `process`
OF_ERTEL = re.compile(rb"source\x00{5}\x02.{4}ertel ", re.DOTALL)  # an attribute: name, kind, length, text
LARGEST_OUTPUT = 4 * 10**9  # bytes of a file
ASKED = 130  # stopped by a file, see `ertel.runs.directory`: as by Ctrl-C


def printable(text: str) -> str:
    """The text with control characters escaped; lines and tabs remain."""
    return "".join(c if c.isprintable() or c in "\n\t" else ascii(c)[1:-1] for c in text)


def say(message: str) -> None:
    """Print a message on stderr, without its middle where it is very long."""
    half = LONGEST // 2
    short = message if len(message) <= LONGEST else f"{message[:half]} ... {message[-half:]}"
    print(printable(short), file=sys.stderr, flush=True)


def print_json(content: Any) -> None:
    """Print data as JSON, in ASCII: every terminal takes it, and it reads back as the same data."""
    print(json.dumps(content, indent=2, allow_nan=False))


def print_text(text: str = "", **style: Any) -> None:
    """Print a text, with its control characters escaped, in a style of typer where a terminal has it."""
    plain = os.environ.get("NO_COLOR") or os.environ.get("TERM") == "dumb"
    typer.secho(printable(text), color=False if plain else None, **style)


def capital(text: str) -> str:
    """A message with a capital letter, as a sentence begins."""
    return f"{text[:1].upper()}{text[1:]}"


# -- exit codes -------------------------------------------------------------------------------------------------------


def leave(code: int, message: str) -> NoReturn:
    """End with an exit code and a message."""
    say(f"ertel: {message}")
    raise typer.Exit(code)


def reason_of(error: OSError) -> str:
    """The message of the system, without number and file name."""
    return (error.strerror or str(error)).lower()


@contextmanager
def bad_input() -> Iterator[None]:
    """Report every ValueError of this block as wrong input; ConfigError and StoreError are wherever they are raised."""
    try:
        yield
    except ValueError as error:
        leave(BAD_INPUT, str(error))


@contextmanager
def writing_to(directory: Path, advice: str) -> Iterator[None]:
    """End with the reason and an advice where a file of this directory cannot be written in this block."""
    try:
        yield
    except OSError as error:
        leave(FAILED, f"cannot write to {shown(directory)}: {reason_of(error)}; {advice}")


@contextmanager
def placing(
    directory: Path, overwrite: bool = False, may_be_link: bool = True, pictures: Iterable[str] = ()
) -> Iterator[Path]:
    """Give a new directory for the files of this block; then move them into this one, also in place of ertel's own.

    pictures: names of those that will be among them, whose places are looked at before the work.
    """
    if not may_be_link and directory.is_symlink():
        leave(BAD_INPUT, f"{shown(directory)}: is a symbolic link; delete it, or name a directory with --out")
    for name in pictures:
        _require_own(directory / name, overwrite)
    made = [path for path in (directory, *directory.parents) if not path.exists()]
    directory.mkdir(parents=True, exist_ok=True)
    try:
        with TemporaryDirectory(prefix=".ertel-", dir=directory) as draft:
            yield Path(draft)
            new = sorted(Path(draft).iterdir())
            for path in new:
                _require_own(directory / path.name, overwrite, path)
            for path in new:
                path.replace(directory / path.name)
    finally:
        for path in made:
            with suppress(OSError):  # it has files
                path.rmdir()


def _require_own(place: Path, overwrite: bool, new: Path | None = None) -> None:
    """Leave where there is a file without the mark of ertel's pictures or NetCDF, which is not the same as the new one.

    A table has no mark, and may be the user's own with the same columns; it replaces no file that has one.
    """
    from ertel.runs.files import content_of

    if not lexists(place) or (overwrite and (place.is_symlink() or not place.is_dir())):
        return
    try:
        content = content_of(place, LARGEST_OUTPUT)
    except OSError:  # a directory, a pipe, a link to nowhere
        content = b""
    latest = new.read_bytes() if new and content else None
    is_marked = _is_marked(content) and (latest is None or _is_marked(latest))
    if place.is_dir() and not place.is_symlink():
        leave(BAD_INPUT, f"{shown(place)}: is a directory; move it, or choose another name")
    if not (is_marked or (content and content == latest)):
        is_picture = place.suffix.lower() not in (".csv", ".nc", ".vti", ".pvd") and place.is_file()
        why = "has no mark of ertel (a picture of an earlier version has none)" if is_picture else "is another file"
        leave(BAD_INPUT, f"{shown(place)}: {why}; move it, or add --overwrite")


def _is_marked(content: bytes) -> bool:
    """Whether it is a picture by its text, or a NetCDF file by its attribute `source`."""
    from ertel.results.figures import MADE_BY

    return MADE_BY.encode() in content or (content[:3] == b"CDF" and bool(OF_ERTEL.search(content)))


# -- paths ------------------------------------------------------------------------------------------------------------


def local_path(text: str | Path) -> Path:
    """A path as a user writes it, made absolute; ~ is the home directory.  Raises BadParameter if it cannot be."""
    if not str(text):
        raise typer.BadParameter("must not be empty")
    if "://" in str(text) or "::" in str(text):  # xarray and others read a::b as two addresses
        raise typer.BadParameter(f"{text}: must be a path on this machine, not an address")
    try:
        return Path(text).expanduser().absolute()
    except (RuntimeError, OSError) as error:  # no such home directory, or no working directory any more
        raise typer.BadParameter(f"{text}: {str(error).lower().rstrip('.')}; give the whole path") from error


def shown(path: Path) -> str:
    """A path as short as it is clear: relative if it lies in the working directory."""
    try:
        return str(path.relative_to(Path.cwd()))
    except (ValueError, OSError):
        return str(path)


def in_shell(path: Path) -> str:
    """A path as a word of a command; one that begins with - would be read as a flag."""
    word = shown(path)
    return shlex.quote(f"./{word}" if word.startswith("-") else word)
