"""Files and directories that a user names: read once, here; from then on they are absolute."""

import shlex
from pathlib import Path

import typer


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
