"""What a shell completes: run directories, case files, keys of --set, names of figures.

`ertel --install-completion` tells the shell.  These functions run at each press of the tab key and import little.
"""

from collections.abc import Iterator
from pathlib import Path

CASE = "case.toml"  # in a run directory


def run_directories(incomplete: str) -> list[str]:
    """Directories of runs that begin so, and directories in which there may be some."""
    return [text for path, text in _entries(incomplete) if path.is_dir()]


def case_files(incomplete: str) -> list[str]:
    """Case files that begin so, and directories in which there may be some."""
    return [text for path, text in _entries(incomplete) if path.is_dir() or path.suffix == ".toml"]


def settings(incomplete: str) -> list[str]:
    """section.key= for the keys of case files that begin so."""
    from ertel.inputs.layout import SECTIONS, section

    found = [f"{name}.{key.name}=" for name in SECTIONS for key in section(name).keys]
    return [text for text in found if text.startswith(incomplete)]


def figures(incomplete: str) -> list[str]:
    """Names of figures that begin so."""
    from ertel import plots

    return [name for name in plots.NAMES if name.startswith(incomplete)]


def _entries(incomplete: str) -> Iterator[tuple[Path, str]]:
    """What lies in the directory that a text names so far and begins like its end: the path and the whole text.

    A directory of a run is complete; any other one ends with a slash, so that one can go on.
    """
    folder, slash, start = incomplete.rpartition("/")
    place = Path(f"{folder}{slash}").expanduser() if slash else Path()
    try:
        found = sorted(place.iterdir())
    except OSError:
        return
    for path in found:
        if path.name.startswith(start) and (start or not path.name.startswith(".")):
            is_open = path.is_dir() and not (path / CASE).exists()
            yield path, f"{folder}{slash}{path.name}{'/' if is_open else ''}"
