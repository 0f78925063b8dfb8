"""The version of ertel that is installed, and a digest of its source code."""

import hashlib
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path


def installed_version() -> str:
    """The version in the package's metadata; "0+unknown" for a source tree that was not installed."""
    try:
        return version("ertel")
    except PackageNotFoundError:
        return "0+unknown"


@cache
def own_sources() -> str:
    """The `source_digest` of ertel itself, read once per process."""
    return source_digest(Path(__file__).parent)


def source_digest(directory: Path) -> str:
    """SHA-256 (hexadecimal) of the relative paths and contents of all Python files in a directory and below it."""
    digest = hashlib.sha256()
    files = {path.relative_to(directory).as_posix(): path for path in directory.rglob("*.py")}
    for name, path in sorted(files.items()):
        content = path.read_bytes()
        digest.update(f"{name}\0{len(content)}\0".encode())  # so that no two sets of files give the same bytes
        digest.update(content)
    return digest.hexdigest()
