"""The folder that the app was opened in: its runs and case files.  Nothing outside is read, written or started."""

import os
from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import count
from pathlib import Path

from ertel.runs.directories import CASE

DATA = "run.zarr"
RUNS = "runs"  # where `ertel run` puts a run, too
DEEPEST = 4  # levels of folders in which runs are looked for: a study has runs of its own
MOST_FOLDERS = 1000  # that are looked into
MOST = 300  # runs that are listed


class Outside(ValueError):
    """A path lies outside the folder of the app."""


@dataclass(frozen=True)
class Folder:
    """A folder with case files and runs.  root: its real path, without symbolic links."""

    root: Path

    @classmethod
    def at(cls, path: Path) -> "Folder":
        """The folder at a path.  Raises ValueError where there is none, and for that of a run."""
        if not path.is_dir():
            raise ValueError(f"{path}: is no folder; give one with case files or runs, or an empty one")
        if _is_run(path):
            raise ValueError(f"{path}: is a run; open the app in its folder, {path.resolve().parent}")
        return cls(path.resolve())

    def inside(self, name: str) -> Path:
        """The real path of something in the folder.  Raises Outside for everything else."""
        try:
            path = (self.root / name).resolve()
        except (OSError, ValueError) as error:
            raise Outside(f"{name[:100]!r}: is no path") from error
        if not path.is_relative_to(self.root):
            raise Outside(f"{name}: lies outside {self.root}, the folder of this app; open the app there")
        return path

    def name_of(self, path: Path) -> str:
        """The name of a path in the folder, with slashes."""
        return path.relative_to(self.root).as_posix()

    def run(self, name: str) -> Path:
        """The directory of a run.  Raises Outside, and ValueError where there is no run."""
        path = self.inside(name)
        if not _is_run(path):
            raise ValueError(f"{name}: is no run; a run has {CASE} and {DATA}")
        return path

    def runs(self) -> list[Path]:
        """The runs in the folder, the latest first."""
        found = sorted(_runs_below(self.root), key=_changed, reverse=True)
        return [path for path in found[:MOST] if path.resolve().is_relative_to(self.root)]

    def case_files(self) -> list[Path]:
        """The case files at the top of the folder, by name."""
        return sorted(path for path in self.root.glob("*.toml") if path.resolve().is_relative_to(self.root))

    def write_case(self, name: str, text: str) -> tuple[Path, Path]:
        """Write a new case file NAME.toml; its path, and that of its run, which does not exist yet.

        Where either is taken, the first of NAME-2, NAME-3, ... that is free.
        """
        for number in count(1):
            free = name if number == 1 else f"{name}-{number}"
            file, run = self.root / f"{free}.toml", self.root / RUNS / free
            if run.exists():
                continue
            try:
                with file.open("x", encoding="utf-8") as opened:
                    opened.write(text)
            except FileExistsError:
                continue
            return file, run
        raise AssertionError("there is always a next number")


def _runs_below(folder: Path) -> Iterator[Path]:
    """The runs below a folder, those near it first; in a large tree not all of them."""
    left, looked = deque([(folder, DEEPEST)]), 0
    while left and looked < MOST_FOLDERS:
        place, depth = left.popleft()
        looked += 1
        for path in _folders_in(place):
            if _is_run(path):
                yield path
            elif depth > 1:
                left.append((path, depth - 1))


def _folders_in(folder: Path) -> list[Path]:
    try:
        with os.scandir(folder) as entries:
            return [Path(entry.path) for entry in entries if entry.name[0] != "." and entry.is_dir()]
    except OSError:
        return []


def _is_run(path: Path) -> bool:
    try:
        return (path / CASE).is_file() and ((path / DATA).is_dir() or (path / f"{DATA}.old").is_dir())
    except OSError:  # a name that is too long
        return False


def _changed(path: Path) -> float:
    """When a run was last written to."""
    try:
        return max((path / name).stat().st_mtime for name in (CASE, "summary.json") if (path / name).exists())
    except (OSError, ValueError):
        return 0.0
