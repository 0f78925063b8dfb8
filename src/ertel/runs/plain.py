"""Results on disk as plain data, so that reading them runs no code and a damaged file is noticed.

Plain data: None, truth values, numbers, texts, lists, dicts with texts as keys, NumPy arrays of numbers or texts, and
Datasets of these.  Tuples are written as lists.  A file is an npz archive and its checksum (`files.with_checksum`).  In
the archive "text" is JSON in which each list, dict, array and Dataset is named as such; the arrays are "0", "1", ...
"""

import hashlib
import io
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from ertel.runs.files import reading, replace, with_checksum, without_checksum


def write_plain(path: Path, content: Any) -> None:
    """Write plain data atomically.

    Raises TypeError where the content is not plain data, OSError with the name of the file where it cannot be written.
    """
    archive = with_checksum(_archive(content))
    try:
        replace(path, archive)
    except OSError as error:
        raise OSError(error.errno, error.strerror, str(path)) from error


def read_plain(path: Path) -> Any:
    """The content that was written.  Raises Damaged where the file is damaged, OSError where it cannot be read."""
    content = path.read_bytes()
    with (
        reading(path, "delete it"),
        np.load(io.BytesIO(without_checksum(content)), allow_pickle=False) as archive,
    ):
        return _decoded(json.loads(archive["text"].item()), archive)


def digest(content: Any) -> str:
    """SHA-256 (hexadecimal) of plain data.  Raises TypeError where the content is not plain data."""
    return hashlib.sha256(_archive(content)).hexdigest()


def _archive(content: Any) -> bytes:
    """The npz archive; equal content gives equal bytes, because NumPy writes no dates."""
    arrays: list[NDArray[Any]] = []
    text, archive = json.dumps(_encoded(content, arrays)), io.BytesIO()
    np.savez(archive, allow_pickle=False, text=np.array(text), **{str(i): array for i, array in enumerate(arrays)})
    return archive.getvalue()


def _encoded(content: Any, arrays: list[NDArray[Any]]) -> Any:
    """Content as JSON has it; its arrays are added to the list."""
    match content:
        case None | bool() | int() | float() | str():
            return content
        case np.generic():
            return _encoded(content.item(), arrays)
        case np.ndarray() if content.dtype.kind in "biufcU":
            arrays.append(content)
            return {"array": len(arrays) - 1}
        case list() | tuple():
            return {"list": [_encoded(value, arrays) for value in content]}
        case dict() if all(isinstance(key, str) for key in content):
            return {"dict": {key: _encoded(value, arrays) for key, value in content.items()}}
        case xr.Dataset():
            return {"dataset": _encoded(content.to_dict(data="array"), arrays)}
    raise TypeError(f"a {type(content).__name__} cannot be kept: use numbers, texts, lists, dicts, arrays, Datasets")


def _decoded(content: Any, arrays: Mapping[str, NDArray[Any]]) -> Any:
    if not isinstance(content, Mapping):
        return content
    [(kind, value)] = content.items()
    match kind:
        case "array":
            return arrays[str(value)]
        case "list":
            return [_decoded(each, arrays) for each in value]
        case "dict":
            return {key: _decoded(each, arrays) for key, each in value.items()}
        case "dataset":
            return xr.Dataset.from_dict(_decoded(value, arrays))
    raise ValueError(f"{kind}: must be array, list, dict or dataset")
