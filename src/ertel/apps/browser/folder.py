"""The folder that the app was opened in: its runs and case files.  Nothing outside is read, written or started."""

import os
from dataclasses import dataclass
from pathlib import Path

from ertel.runs.directory import CASE, DATA, numbered
from ertel.runs.listing import find_runs, is_run

RUNS = "runs"  # where `ertel run` puts a run, too
MOST_FOLDERS = 1000  # that are looked into
MOST = 300  # runs that are listed


def in_unicode(text: str) -> str:
    """A name of the system for a page: with a sign in place of each byte that is not UTF-8."""
    return os.fsencode(text).decode(errors="replace")


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
        if is_run(path):
            raise ValueError(f"{path}: is a run; open the app in its folder, {path.resolve().parent}")
        return cls(path.resolve())

    def inside(self, name: str) -> Path:
        """The real path of something in the folder.  Raises Outside for everything else."""
        try:
            path = Path(os.path.realpath(self.root / name))  # unlike `resolve` it takes links that go round in circles
        except ValueError as error:
            raise Outside(f"{name[:100]!r}: is no path") from error
        if not path.is_relative_to(self.root):
            raise Outside(f"{name}: lies outside {self.root}, the folder of this app; open the app there")
        return path

    def name_of(self, path: Path) -> str:
        """The name of a path in the folder, with slashes."""
        return in_unicode(path.relative_to(self.root).as_posix())

    def run(self, name: str) -> Path:
        """The directory of a run.  Raises Outside, and ValueError where there is no run."""
        path = self.inside(name)
        if not is_run(path):
            raise ValueError(f"{name}: is no run; a run has {CASE} and {DATA}")
        return path

    def runs(self) -> list[Path]:
        """The runs in the folder, the latest first."""
        return sorted(find_runs(self.root, MOST_FOLDERS), key=_changed, reverse=True)[:MOST]

    def case_files(self) -> list[Path]:
        """The case files at the top of the folder, by name."""
        return sorted(path for path in self.root.glob("*.toml") if self._is_ours(path))

    def _is_ours(self, path: Path) -> bool:
        """Whether a path is a regular file in the folder, with a name that pages can show."""
        try:
            is_inside = path.is_file() and path.resolve().is_relative_to(self.root)
        except OSError:  # nobody may look at it
            return False
        return is_inside and in_unicode(path.name) == path.name

    def write_case(self, name: str, text: str) -> tuple[Path, Path]:
        """Write a new case file NAME.toml; its path, and that of its run, which does not exist yet.

        Where either is taken, the first of NAME-2, NAME-3, ... that is free.
        """
        for run in numbered(self.root / RUNS / name):
            file = self.root / f"{run.name}.toml"
            if run.exists():
                continue
            try:
                with file.open("x", encoding="utf-8") as opened:
                    opened.write(text)
            except FileExistsError:
                continue
            return file, run
        raise AssertionError("there is always a next number")


def _changed(path: Path) -> float:
    """When a run was last written to."""
    try:
        return max((path / name).stat().st_mtime for name in (CASE, "summary.json") if (path / name).exists())
    except (OSError, ValueError):
        return 0.0
