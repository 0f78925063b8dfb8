"""The arrays of a run on disk: a Dataset as Zarr files in which nothing changes unnoticed.

`xarray.open_zarr` alone opens them.  The chunks carry checksums.  The metadata of all arrays stand in one file,
run.zarr/zarr.json, with their checksum among its attributes.  The file is replaced atomically: it says how many rows
readers see.  Zarr also wants a zarr.json in each array; nobody here reads those.

The arrays are appended in time (`AppendedData`), or replaced grid by grid (`ReplacedData`).  `create` writes those of a
run that has not started.  `flush` writes what is new before a checkpoint, and returns what the checkpoint must store
about it.  `restore` resets the arrays to a checkpoint; an empty checkpoint and no result mean the start.  It raises
Damaged where that cannot be done; then nothing has changed.

advice: how to go on where the data are damaged.
"""

import asyncio
import json
import warnings
from collections.abc import Coroutine, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from math import ceil, nan
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np
import xarray as xr
import zarr
from numpy.typing import NDArray
from zarr.abc.buffer import Buffer, BufferPrototype
from zarr.api import asynchronous
from zarr.codecs import Crc32cCodec, ZstdCodec
from zarr.core.buffer import default_buffer_prototype
from zarr.core.sync import sync
from zarr.storage import LocalStore

from ertel.case.status import Status
from ertel.results import dataset
from ertel.results.dataset import Frame, provenance
from ertel.runs.files import DRAFT, Damaged, StoreError, content_of, delete, reading, replace, sealed, unsealed

if TYPE_CHECKING:  # they bring JAX
    from ertel.runs.drive import SteadyRun
    from ertel.runs.stepping import TransientRun

ROOT = "zarr.json"
GROWING = ("time", "frame")  # the dimensions along which rows are appended
ROWS = 4096  # of numbers in a chunk; each map is a chunk of its own
NO_NUMBER = -1  # what a missing chunk of integers holds
LARGEST_CHUNK = 256 * 10**6  # bytes: a map of 4097 x 4097 nodes has half of it
FORMAT: Final = 3  # of Zarr; earlier ones may hold pickles
OLD_FORMAT = (".zarray", ".zgroup", ".zattrs", ".zmetadata")  # the metadata of earlier ones
CODECS = ("bytes", "zstd", "crc32c", "vlen-utf8")  # of what ertel writes, the last one of texts
WRITTEN = "store_written"  # in a checkpoint: how many rows of the arrays belong to it

Root = dict[str, Any]  # the content of ROOT without its checksum
Record = Mapping[str, float]


class RegularStore(LocalStore):
    """A local store, perhaps made by somebody else, with regular files of a sensible size and arrays as ertel's only.

    Reading a pipe may never end.  Other formats and codecs may run programs that the data name.
    """

    get_sync = set_sync = None  # type: ignore[assignment] # or a later zarr might pass by `get` and `set`

    async def get(self, key: str, prototype: BufferPrototype | None = None, *_: Any, **__: Any) -> Buffer | None:
        if key.endswith(OLD_FORMAT):
            return None
        try:
            content = await asyncio.to_thread(content_of, self.root / key, LARGEST_CHUNK)
        except (FileNotFoundError, NotADirectoryError):
            return None
        if key.endswith(ROOT):
            require_plain(json.loads(content), key)
        return (prototype or default_buffer_prototype()).buffer.from_bytes(content)


class SyncedStore(RegularStore):
    """A local store whose chunks are on the disk when they are written."""

    async def set(self, key: str, value: Any) -> None:
        if key.endswith(ROOT):
            await super().set(key, value)
        else:
            await asyncio.to_thread(replace, self.root / key, value.to_bytes())


def require_plain(metadata: Any, name: str) -> None:
    """Raise ValueError unless all metadata in JSON, also consolidated ones, are of format 3 with codecs of ertel."""
    waiting = [metadata]
    while waiting:
        part = waiting.pop()
        if isinstance(part, dict):
            if part.get("zarr_format", FORMAT) != FORMAT:
                raise ValueError(f"{name} has arrays of Zarr's format {part['zarr_format']}, which may hold programs")
            codecs = [each["name"] if isinstance(each, dict) else each for each in part.get("codecs", [])]
            if wrong := [each for each in codecs if each not in CODECS] or part.get("storage_transformers"):
                raise ValueError(f"{name} has arrays with codecs that ertel does not write ({wrong[0]})")
            part = list(part.values())
        waiting.extend(part if isinstance(part, list) else [])


def open_data(path: Path, consolidated: bool) -> xr.Dataset:
    """The data of a run, a study or a fit, whose values are read when they are needed."""
    data: xr.Dataset = xr.open_zarr(RegularStore(path, read_only=True), chunks=None, consolidated=consolidated)
    return data


def write(store: LocalStore, data: xr.Dataset) -> None:
    """Write a Dataset into an empty store, all of its arrays at once."""

    async def create() -> None:
        group = await asynchronous.create_group(store=store, zarr_format=FORMAT, attributes=dict(data.attrs))
        await _all(_create_array(group, str(name), each) for name, each in data.variables.items())
        await asynchronous.consolidate_metadata(store, zarr_format=FORMAT)

    with _writing():
        sync(create())
    write_root(store.root, json.loads((store.root / ROOT).read_bytes()))


async def _create_array(group: zarr.AsyncGroup, name: str, variable: xr.Variable) -> None:
    rows = ROWS if variable.ndim == 1 else 1
    array = await group.create_array(
        name,
        shape=variable.shape,
        chunks=tuple(rows if dim in GROWING else max(n, 1) for dim, n in variable.sizes.items()),
        dtype=variable.dtype,
        fill_value=nan if variable.dtype.kind == "f" else NO_NUMBER,
        compressors=[ZstdCodec(), Crc32cCodec()],
        dimension_names=[str(dim) for dim in variable.dims],
        attributes=variable.attrs,
    )
    if variable.size:
        await array.setitem(..., variable.values)


def append(path: Path, arrays: Mapping[str, NDArray[Any]]) -> None:
    """Append rows to arrays, all at once.  Readers see them when the file ROOT counts them."""

    async def append_all() -> None:
        stored = await _stored_arrays(SyncedStore(path), "r+")
        await _all(stored[name].append(rows) for name, rows in arrays.items())

    with _writing():
        sync(append_all())


async def _all(work: Iterable[Coroutine[Any, Any, Any]]) -> None:
    """Do all of this at once.  The first error is raised when all have ended: nothing is written after it."""
    for outcome in await asyncio.gather(*work, return_exceptions=True):
        if isinstance(outcome, BaseException):
            raise outcome


async def _stored_arrays(store: LocalStore, mode: Any) -> dict[str, zarr.AsyncArray[Any]]:
    """The arrays of a run by their names, as its consolidated metadata tell them."""
    group = await asynchronous.open_group(store=store, mode=mode, zarr_format=FORMAT, use_consolidated=True)
    return {name: array async for name, array in group.arrays()}


@contextmanager
def _writing() -> Iterator[None]:
    """Chunks without a number are written too: only a lost one is missing."""
    with warnings.catch_warnings(), zarr.config.set({"array.write_empty_chunks": True}):
        warnings.filterwarnings("ignore", message="Consolidated metadata is currently not part")
        yield


# -- the metadata -----------------------------------------------------------------------------------------------------


def read_root(path: Path, advice: str) -> Root:
    """The metadata of all arrays.  Raises Damaged, with the advice, where the file is missing or damaged."""
    try:
        text = content_of(path / ROOT)
    except (FileNotFoundError, NotADirectoryError) as error:
        raise Damaged(path / ROOT, "missing", advice) from error
    with reading(path / ROOT, advice):
        root = unsealed(text, "attributes")
        require_plain(root, ROOT)
        if wrong := [name for name in _metadata(root) if not name.isidentifier()]:  # such as ../../letters
            raise ValueError(f"{wrong[0]!r} is not the name of an array")
        return root


def write_root(path: Path, root: Root) -> None:
    """Replace the metadata: from here on readers see the new rows."""
    replace(path / ROOT, sealed(root, "attributes"))


def update_attributes(path: Path, attributes: Mapping[str, Any], advice: str) -> None:
    """Add attributes of the Dataset, or replace them."""
    root = read_root(path, advice)
    root["attributes"].update(attributes)
    write_root(path, root)


def _metadata(root: Root) -> dict[str, dict[str, Any]]:
    return root["consolidated_metadata"]["metadata"]


def rows_of(root: Root) -> dict[str, int]:
    """The number of rows that readers see, by dimension."""
    return {dimension: _metadata(root)[dimension]["shape"][0] for dimension in GROWING}


def with_rows(root: Root, rows: Mapping[str, int]) -> Root:
    """The metadata that count so many rows."""
    arrays = {}
    for name, metadata in _metadata(root).items():
        length, *rest = metadata["shape"]
        arrays[name] = {**metadata, "shape": [rows.get(metadata["dimension_names"][0], length), *rest]}
    return {**root, "consolidated_metadata": {**root["consolidated_metadata"], "metadata": arrays}}


def delete_uncounted(path: Path, root: Root) -> None:
    """Delete the chunks that have only rows that the metadata do not count, and what a killed process left."""
    for file in path.rglob(f"*{DRAFT}"):
        file.unlink()
    for name, metadata in _metadata(root).items():
        chunk = metadata["chunk_grid"]["configuration"]["chunk_shape"][0]
        kept = ceil(metadata["shape"][0] / chunk)
        for file in (path / name / "c").glob("*"):
            if int(file.name) >= kept:
                delete(file)


# -- reading ----------------------------------------------------------------------------------------------------------


def read(path: Path, advice: str) -> xr.Dataset:
    """The Dataset.  Raises Damaged, with the advice, where a file is missing or damaged."""
    while True:
        before = _text(path)
        try:
            return _read(present(path), advice)
        except (Damaged, FileNotFoundError):
            if _text(path) == before:  # not replaced by a running process meanwhile
                raise


def _text(path: Path) -> bytes:
    try:
        return content_of(present(path) / ROOT)
    except OSError:
        return b""


def old_of(path: Path) -> Path:
    """The temporary path of the data while they are replaced."""
    return path.with_name(f"{path.name}.old")


def present(path: Path) -> Path:
    """The present path of the data."""
    return path if path.exists() else old_of(path)


def _read(path: Path, advice: str) -> xr.Dataset:
    root = read_root(path, advice)
    variables = {}
    with reading(path, advice):
        found = sync(_values(RegularStore(path, read_only=True)))
    for name, metadata in _metadata(root).items():
        with reading(path / name, advice):
            if isinstance(found[name], BaseException):
                raise found[name]
            values = dataset.indexed(name, metadata["dimension_names"], np.asarray(found[name]))
            variables[name] = (*values, metadata["attributes"])
    return xr.Dataset(variables, attrs=root["attributes"])


async def _values(store: LocalStore) -> dict[str, Any]:
    """The values of all arrays, read at once; an exception in the place of those that cannot be read."""

    async def whole(array: zarr.AsyncArray[Any]) -> Any:
        if missing := array.nchunks - await array.nchunks_initialized():
            raise ValueError(f"{missing} of {array.nchunks} chunks are missing")
        return await array.getitem(...)

    arrays = await _stored_arrays(store, "r")
    found = await asyncio.gather(*map(whole, arrays.values()), return_exceptions=True)
    return dict(zip(arrays, found, strict=True))


# -- of a run ---------------------------------------------------------------------------------------------------------


class AppendedData:
    """Scalars of every time step and maps at chosen times; what no checkpoint counts is cut off by `restore`."""

    advice = "the run must be computed again from its case.toml"

    def __init__(self, run: "TransientRun"):
        self._run = run

    def create(self, path: Path) -> None:
        data = self._run.dataset([], [], None)
        write(SyncedStore(path), data.assign_attrs(status=Status.RUNNING.value))

    def flush(self, path: Path, records: Sequence[Record], frames: Sequence[Frame], result: Any) -> dict[str, Any]:
        root = read_root(path, self.advice)
        columns = dataset.columns(self._run.case, records) if records else {}
        append(path, {**columns, **(dataset.maps(self._run.case, frames) if frames else {})})
        new = {"time": len(records), "frame": len(frames)}
        rows = {dimension: count + new[dimension] for dimension, count in rows_of(root).items()}
        write_root(path, with_rows(root, rows))
        return {WRITTEN: np.array(list(rows.values()))}

    def restore(self, path: Path, checkpoint: Mapping[str, Any], result: Any) -> None:
        root = read_root(path, self.advice)
        if not {*self._run.dataset([], [], None).variables} <= {*_metadata(root)}:
            raise StoreError(f"{path.parent}: was left unfinished by another version of ertel; {self.advice}")
        present = rows_of(root)
        written: Sequence[int] = checkpoint[WRITTEN].tolist() if checkpoint else [0] * len(present)
        rows = dict(zip(present, written, strict=True))
        if any(rows[dimension] > count for dimension, count in present.items()):
            raise Damaged(path, "holds fewer rows than the checkpoint counts", self.advice)
        read(path, self.advice)  # nothing is computed on damaged data
        first = provenance(self._run.case)
        attributes = {name: value for name, value in root["attributes"].items() if name in first}
        root = {**with_rows(root, rows), "attributes": {**attributes, "status": Status.RUNNING.value}}
        write_root(path, root)
        delete_uncounted(path, root)


class ReplacedData:
    """Scalars of every grid and the maps on the finest one so far: they follow from the checkpoint."""

    advice = "it is written again when the run is continued"

    def __init__(self, run: "SteadyRun"):
        self._run = run

    def create(self, path: Path) -> None:
        self._write(path, self._run.begin())

    def _write(self, path: Path, result: Any) -> None:
        data = self._run.dataset([], [], result).assign_attrs(status=Status.RUNNING.value)
        write(LocalStore(path), data)

    def flush(self, path: Path, records: Sequence[Record], frames: Sequence[Frame], result: Any) -> dict[str, Any]:
        """Write the data again; the old data remain readable between the two renames."""
        old, draft = old_of(path), path.with_name(f"{path.name}{DRAFT}")
        delete(draft)
        self._write(draft, result)
        if path.exists():
            delete(old)
            path.rename(old)
        draft.rename(path)
        delete(old)
        return {}

    def restore(self, path: Path, checkpoint: Mapping[str, Any], result: Any) -> None:
        if result is not None:  # from the start the first flush replaces them, whatever they are
            self.flush(path, [], [], result)
