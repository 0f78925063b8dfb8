"""The folder that the app was opened in: runs, studies and their files.  Nothing outside is read, written or started.

The case and the summary of a run are read again only when a file has changed, and never raise an error.
"""

import csv
import json
import os
from collections.abc import Collection, Mapping
from contextlib import suppress
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

from ertel.apps.terminal import reason_of
from ertel.case.status import Status
from ertel.inputs.case_files import parse_case, read_toml
from ertel.runs.directory import (
    CASE,
    DATA,
    RUNS,
    SUMMARY,
    find_runs,
    is_run,
    kind_of,
    numbered,
    read_progress,
    read_summary,
    study_of,
)  # fmt: skip
from ertel.runs.files import content_of, is_locked

# the commands that do the study of a file, and the section by which it is one; they put it into fits/ and sweeps/
STUDIES = {"fit": "unknowns", "sweep": "sweep"}
OF_COLUMNS = (".csv", ".txt", ".tsv", ".dat", ".asc")  # endings of files with measurements
TO_DO = {"missing", "interrupted", "running", "unfinished"}  # in the table of a sweep
IN_WORDS = {"fit": "fit of", "sweep": "study over", "traction": "curve over", "convergence": "convergence over"}
LONGEST = 80  # characters of what is said of a study
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
        found = [run for run in find_runs(self.root, MOST_FOLDERS) if run.parent.parent.parent != self.root / "fits"]
        return sorted(found, key=_changed, reverse=True)[:MOST]

    def case_files(self) -> list[Path]:
        """The case files at the top of the folder, by name."""
        return [file for file, command in self._files().items() if not command]

    def measurements(self) -> list[Path]:
        """The files of columns at the top of the folder, by name."""
        return sorted(path for path in self.root.iterdir() if path.suffix.lower() in OF_COLUMNS and self._is_ours(path))

    def studies(self) -> list[Path]:
        """The directories of studies, by name; one whose file is here may not exist yet."""
        runs = find_runs(self.root, MOST_FOLDERS)
        others = {study for run in runs if (study := study_of(run, self.root))}
        found = sorted(others.union(self._files_of_studies()))
        return [path for path in found if not is_run(path) and os.path.realpath(path) == str(path)]

    def file_of(self, study: Path) -> Path | None:
        """The file from which a study is started; None where there is none at the top of the folder."""
        return self._files_of_studies().get(study)

    def _files_of_studies(self) -> dict[Path, Path]:
        """The files of studies by the directories of these."""
        return {self.root / f"{command}s" / file.stem: file for file, command in self._files().items() if command}

    def _files(self) -> dict[Path, str]:
        """The files at the top of the folder by name, with the commands that do their studies; none of a case."""
        files = sorted(path for path in self.root.glob("*.toml") if self._is_ours(path))
        return {file: _command_of(file, _stamp(file)) for file in files}

    def _is_ours(self, path: Path) -> bool:
        """True if a path is a regular file in the folder, with a name that pages can show."""
        try:
            is_inside = path.is_file() and path.resolve().is_relative_to(self.root)
        except OSError:  # nobody may look at it
            return False
        return is_inside and in_unicode(path.name) == path.name

    def awaited(self) -> set[str]:
        """The names of the files that studies of the folder have as their cases, also of those that are not there."""
        found = set()
        for file in self._files_of_studies().values():
            with suppress(ValueError):
                found.add(os.path.normpath(str(read_toml(file).get("case"))))
        return found

    def write(
        self, name: str, content: bytes, place: str = "", ending: str = ".toml", but: Collection[str] = ()
    ) -> tuple[Path, Path]:
        """Write a new file, NAME and its ending; its path, and that of its run or study, in `place`, not yet there.

        Where either is taken, the first of NAME-2, NAME-3, ... that is free.  place: "" of a file that has none.  but:
        names of files that are not written.
        """
        for run in numbered(self.root / place / name):
            file = self.root / f"{run.name}{ending}"
            with suppress(FileExistsError):
                if not (place and run.exists()) and file.name not in but:
                    with file.open("xb") as opened:
                        opened.write(content)
                    return file, run
        raise AssertionError("there is always a next number")


def _changed(run: Path) -> int:
    """The time when a run was last written to."""
    return max((stamp[0] for stamp in _stamps(run) if stamp), default=0)


# -- studies ----------------------------------------------------------------------------------------------------------


@lru_cache(maxsize=MOST)
def _command_of(file: Path, stamp: Stamp) -> str:
    with suppress(ValueError):
        return command_in(read_toml(file))
    return ""


def command_in(data: Mapping[str, Any]) -> str:
    """The command that does the study in plain data; empty for a case."""
    return next((command for command, section in STUDIES.items() if section in data), "")


@lru_cache(maxsize=MOST)
def _about(study: Path, kind: str, stamp: Stamp) -> str:
    with suppress(OSError, ValueError, LookupError, TypeError, AttributeError, RecursionError):
        attributes = json.loads(content_of(study / f"{kind}.zarr" / "zarr.json"))["attributes"]
        unknowns = ", ".join(str(each).partition(" = ")[0] for each in attributes.get("found", ()))
        return f"{IN_WORDS[kind]} {unknowns or attributes['over']}"[:LONGEST]
    return ""


def about_study(study: Path) -> str:
    """A study in words, with what varies, or the unknowns of a fit, as far as its files tell."""
    kind = kind_of(study) or ("fit" if study.parent.name == "fits" else "sweep")
    about = _about(study, kind, _stamp(study / f"{kind}.zarr" / "zarr.json"))
    return about or IN_WORDS[kind].partition(" ")[0]


def progress_of(path: Path) -> dict[str, Any] | None:
    """The progress of a run or a fit; other studies keep none, but have runs, and a table when they have ended."""
    if (found := read_progress(path)) or is_run(path) or not (path / RUNS).is_dir():
        return found
    status = Status.RUNNING if is_locked(path) else Status.INTERRUPTED
    with suppress(OSError, ValueError, LookupError, csv.Error):
        rows = csv.DictReader(content_of(path / f"{kind_of(path)}.csv").decode().splitlines())
        if status is Status.INTERRUPTED and not TO_DO & {row["status"] for row in rows}:
            status = Status.CONVERGED
    done = sum(summary_of(run) is not None for run in find_runs(path))
    return {"status": status.value, "done": 0.0, "message": f"{done} runs are done"}


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
    with suppress(OSError, ValueError):
        return (status := path.lstat()).st_mtime_ns, status.st_size
    return None


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
