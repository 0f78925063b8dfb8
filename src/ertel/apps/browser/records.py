"""The case and the summary of a run as pages need them: read again only when a file has changed, and never raising."""

from functools import lru_cache
from pathlib import Path
from typing import Any

from ertel.apps.browser.folder import MOST, in_unicode
from ertel.apps.terminal import reason_of
from ertel.inputs.case_files import parse_case, read_toml
from ertel.runs.directory import CASE, SUMMARY
from ertel.runs.listing import summary_in

Stamp = tuple[int, int] | None  # of a file: when it was changed, and its size


def summary_of(run: Path) -> dict[str, Any] | None:
    """The summary of a run; None where there is none that can be read."""
    return _summary(run, _stamp(run / SUMMARY))[0]


def fault_of(run: Path) -> str:
    """The reason why the case or the summary of a run cannot be read; empty where both can, or are not there yet."""
    if in_unicode(run.name) != run.name:
        return "the name of the directory is not UTF-8; rename it"
    return _case_fault(run, _stamp(run / CASE)) or _summary(run, _stamp(run / SUMMARY))[1]


def _stamp(path: Path) -> Stamp:
    try:
        status = path.lstat()
    except OSError:
        return None
    return status.st_mtime_ns, status.st_size


@lru_cache(maxsize=2 * MOST)
def _summary(run: Path, stamp: Stamp) -> tuple[dict[str, Any] | None, str]:
    """The summary as the file was then, and what is wrong with it."""
    try:
        return summary_in(run), ""
    except (OSError, ValueError) as error:
        return None, _said(error)


@lru_cache(maxsize=2 * MOST)
def _case_fault(run: Path, stamp: Stamp) -> str:
    """What is wrong with the case as the file was then.  Measured surfaces are not read: they are large."""
    if stamp is None:
        return ""
    try:
        data = read_toml(run / CASE)
        if "roughness" not in data:
            parse_case(data)
    except (OSError, ValueError) as error:
        return _said(error)
    return ""


def _said(error: OSError | ValueError) -> str:
    if isinstance(error, OSError):
        return f"{Path(error.filename or SUMMARY).name}: {reason_of(error)}"
    return str(error)
