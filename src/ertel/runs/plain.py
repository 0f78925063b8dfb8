"""Results on disk as plain data, so that reading them runs no code and a damaged file is noticed.

Plain data: None, truth values, numbers, texts, lists, dicts with texts as keys, NumPy arrays of numbers or texts, and
Datasets of these.  Tuples are written as lists.  A file is a SHA-256 checksum and an npz archive: "text" is JSON in
which each list, dict, array and Dataset is named as such; the arrays stand beside it as "0", "1", ...
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

CHECKSUM = hashlib.sha256().digest_size  # bytes at the beginning of a file


def write(path: Path, content: Any) -> None:
    """Write plain data in one stroke: the file is complete or as it was.

    Raises TypeError where the content is not plain data, OSError with the name of the file where it cannot be written.
    """
    body, draft = _archive(content), path.with_name(f"{path.name}.partial")
    try:
        draft.write_bytes(hashlib.sha256(body).digest() + body)
        draft.replace(path)
    except OSError as error:
        draft.unlink(missing_ok=True)
        raise OSError(error.errno, error.strerror, str(path)) from error


def read(path: Path) -> Any:
    """What `write` was given.  Raises ValueError where the file is damaged, OSError where it cannot be read."""
    content = path.read_bytes()
    body = content[CHECKSUM:]
    if hashlib.sha256(body).digest() != content[:CHECKSUM]:
        raise ValueError(f"{path}: is damaged, its checksum does not fit")
    try:
        with np.load(io.BytesIO(body), allow_pickle=False) as archive:
            return _decoded(json.loads(archive["text"].item()), archive)
    except Exception as error:  # of zipfile, zlib, json, NumPy: somebody else wrote this file
        raise ValueError(f"{path}: is no file of plain data") from error


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
