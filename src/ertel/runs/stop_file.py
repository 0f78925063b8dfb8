"""The file `stop` in a run directory, or in that of a study: whoever makes it asks the run to stop, from any machine.

The run ends after its current step or grid, as after Ctrl-C, and can be resumed.  It deletes the file then, and also
when it begins: a file that is left over from before does not stop it.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

STOP = "stop"


def ask(directory: Path) -> None:
    """Ask the run in a directory to stop.  Raises OSError where the file cannot be made."""
    (directory / STOP).touch()


def is_asked(directory: Path) -> bool:
    """Whether the run in a directory is asked to stop."""
    return (directory / STOP).is_file()


@contextmanager
def fresh(directory: Path) -> Iterator[None]:
    """Delete the file before and after this block.  Raises OSError where it cannot be deleted."""
    _forget(directory)
    yield
    _forget(directory)


def _forget(directory: Path) -> None:
    if is_asked(directory):
        (directory / STOP).unlink(missing_ok=True)
