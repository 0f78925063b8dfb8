"""The folder that the app was opened in: runs, fits and their files.  Nothing outside is read, written or started.

The case and the summary of a run are read again only when a file has changed, and never raise an error.
"""

import os
from contextlib import suppress
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

from ertel.apps.terminal import reason_of
from ertel.inputs.case_files import parse_case, read_toml
from ertel.runs.directory import CASE, DATA, SUMMARY, find_runs, is_run, numbered, read_summary

RUNS, FITS = "runs", "fits"  # where `ertel run` puts a run, and `ertel fit` a fit, too
MOST_FOLDERS = 1000  # that are looked into
MOST = 300  # runs that are listed
Stamp = tuple[int, int] | None  # of a file: when it was changed, and its size


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
            raise ValueError(f"{path} is not a folder; give one with case files or runs, or an empty one")
        if is_run(path):
            raise ValueError(f"{path} is a run; open the app in its folder, {path.resolve().parent}")
        return cls(path.resolve())

    def inside(self, name: str) -> Path:
        """The real path of something in the folder.  Raises Outside for everything else."""
        try:
            path = Path(os.path.realpath(self.root / name))  # unlike `resolve` it takes links that go round in circles
        except ValueError as error:
            raise Outside(f"{name[:100]!r} is not a path") from error
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
            raise ValueError(f"{name} is not a run directory ({CASE} and {DATA} are missing)")
        return path

    def runs(self) -> list[Path]:
        """The runs in the folder, the latest first; without those of fits."""
        found = [run for run in find_runs(self.root, MOST_FOLDERS) if not self.is_fit(run.parent.parent)]
        return sorted(found, key=_changed, reverse=True)[:MOST]

    def case_files(self) -> list[Path]:
        """The case files at the top of the folder, by name."""
        return [path for path in self._toml_files() if not _has_unknowns(path, _stamp(path))]

    def fits(self) -> list[Path]:
        """The directories of the fits whose files are at the top of the folder, by name; they may not exist yet."""
        files = [path for path in self._toml_files() if _has_unknowns(path, _stamp(path))]
        return [fit for file in files if self.is_fit(fit := self.root / FITS / file.stem)]

    def is_fit(self, path: Path) -> bool:
        """True if a path is where a fit may be: not that of a run, and not a link."""
        return path.parent == self.root / FITS and not is_run(path) and os.path.realpath(path) == str(path)

    def fit(self, name: str) -> tuple[Path, Path]:
        """The directory and the file of a fit.  Raises Outside, and ValueError where there is none."""
        path = self.inside(name)
        if path not in self.fits():
            raise ValueError(f"{name} is not a fit of a file with [unknowns] in this folder")
        return path, self.file_of(path)

    def file_of(self, fit: Path) -> Path:
        """The file of a fit."""
        return self.root / f"{fit.name}.toml"

    def _toml_files(self) -> list[Path]:
        return sorted(path for path in self.root.glob("*.toml") if self._is_ours(path))

    def _is_ours(self, path: Path) -> bool:
        """True if a path is a regular file in the folder, with a name that pages can show."""
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
            with suppress(FileExistsError):
                if not run.exists():
                    with file.open("x", encoding="utf-8") as opened:
                        opened.write(text)
                    return file, run
        raise AssertionError("there is always a next number")


def _changed(run: Path) -> int:
    """The time when a run was last written to."""
    return max((stamp[0] for stamp in _stamps(run) if stamp), default=0)


@lru_cache(maxsize=MOST)
def _has_unknowns(path: Path, stamp: Stamp) -> bool:
    """Whether a file was that of a fit at a time, see `inputs.fits`."""
    try:
        return "unknowns" in read_toml(path)
    except ValueError:
        return False


# -- the files of a run -----------------------------------------------------------------------------------------------


def summary_of(run: Path) -> dict[str, Any] | None:
    """The summary of a run; None where there is none that can be read."""
    return _read(run, *_stamps(run))[0]


def fault_of(run: Path) -> str:
    """The reason why the case or the summary of a run cannot be read; empty where both can, or are not there yet."""
    if in_unicode(run.name) != run.name:
        return "the name of the directory is not UTF-8; rename it"
    return _read(run, *_stamps(run))[1]


def _stamps(run: Path) -> list[Stamp]:
    """The stamps of case and summary."""
    return [_stamp(run / CASE), _stamp(run / SUMMARY)]


def _stamp(path: Path) -> Stamp:
    try:
        status = path.lstat()
    except (OSError, ValueError):
        return None
    return status.st_mtime_ns, status.st_size


@lru_cache(maxsize=2 * MOST)
def _read(run: Path, case: Stamp, summary: Stamp) -> tuple[dict[str, Any] | None, str]:
    """The summary as the files were then, and what is wrong.  Measured surfaces are not read: they are large."""
    found = None
    try:
        found = read_summary(run)
        if case and "roughness" not in (data := read_toml(run / CASE)):
            parse_case(data)
    except OSError as error:
        return None, f"{Path(error.filename or SUMMARY).name}: {reason_of(error)}"
    except ValueError as error:
        return found, str(error)
    return found, ""
