"""Files of measured surfaces in a case: read, freed of trend and gaps, and replaced by their heights.

    [[roughness]]
    shape = "measured"
    file = "disc.al3d"
    detrend = "curvature"

The package SurfaceTopography (the extra "surfaces") knows the formats of the instruments, fits the trend and fills the
gaps.  It is not needed for a NumPy array without both (.npy, rows along y, `detrend = "none"`), nor for the file that
ertel itself writes into a run directory: that is named by its content, is checked against its name, and is taken as it
is.
"""

import logging
import re
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from io import BytesIO, TextIOWrapper
from pathlib import Path
from string import printable
from typing import IO, Any, NamedTuple
from zipfile import ZipFile, ZipInfo, is_zipfile

import numpy as np
from numpy.lib.format import MAGIC_PREFIX
from numpy.polynomial import Polynomial
from numpy.typing import NDArray

from ertel.case.height_map import MOST, HeightMap, Measured, array_in, check_shape, check_size
from ertel.case.reading import UTF_16, check_keys, regular_content
from ertel.case.records import ConfigError, named, refusing, shortened, show
from ertel.inputs import text_maps
from ertel.inputs.layout import READER, MeasuredFile, field_names
from ertel.inputs.quantities import parse_quantity
from ertel.physics.units import LENGTH, Quantity

OWN_NAME = re.compile(r"heights-[0-9a-f]{16}\.npy")
DETRENDS = {"mean": "center", "plane": "height", "curvature": "curvature"}  # by degree; as SurfaceTopography calls them
LONGEST_SIDE = 1.0  # m: of an instrument's map
MOST_GAPS = 0.5  # of the points
LARGEST_FILE = 600_000_000  # bytes, also unpacked: four maps of the most points, or one as text
LARGEST_XML = 10_000_000  # bytes: what stands beside the heights
MOST_NUMBERS = MOST**2
ALLOWED = f"a map has at most {MOST} points a side"
MOST_WORDS = 1_000_000  # of a line that is not all numbers
PART = 1 << 20  # characters of a line that are looked at in one go
NUMERIC = "0123456789+-.eE,;nNaAiIfFtTbBdD \t\r\n\0"  # also nan, inf, infinite and bad; NUL of UTF-16
TEXT = printable.encode() + bytes(range(0x80, 0x100))
BEFORE_XML = b"\xef\xbb\xbf \t\r\n"  # byte order mark and blanks
OFFICE = "[Content_Types].xml"  # a member of every office document
UNMARKED = ("nms", "hgt")  # formats of which any bytes may be
ROUND_OFF = 1e-12  # of the heights: no instrument measures what is smaller
READING = {*field_names(MeasuredFile)}
SIZES = ("length_x", "length_y", "rms")


class _Raw(NamedTuple):
    """The heights in a file.

    heights: (ny, nx), masked where there are gaps.  sizes: lengths along x and y, of a profile along x; empty if the
    file has none.  metre: one unit of both in metres, None if not known.
    """

    heights: NDArray[np.float64]
    sizes: tuple[float, ...]
    metre: float | None


def with_maps(read: Mapping[str, Any], folder: Path) -> tuple[dict[str, Any], dict[str, HeightMap]]:
    """The data of a case with the files of its measured surfaces read.

    Returns also their heights by the names under which the data now have them, as `Case.maps`.  Raises
    ValueError, naming the field, for a file that cannot be read or does not say what is needed.
    """
    maps: dict[str, HeightMap] = {}
    roughness = read.get("roughness")
    if not isinstance(roughness, list):
        return dict(read), maps
    tables = []
    for number, table in enumerate(roughness, 1):
        if isinstance(table, Mapping) and table.get("shape") == "measured" and isinstance(table.get("file"), str):
            place = f"roughness[{number}]"
            table, heights = named(place, _with_map, table, folder, place)
            maps[heights.name] = heights
        tables.append(table)
    return {**read, "roughness": tables}, maps


def _with_map(written: Mapping[str, Any], folder: Path, place: str) -> tuple[dict[str, Any], HeightMap]:
    """A table with lengths and heights as its file says, and the heights.

    A ValueError inside is a complaint about the file; a ConfigError names another key.
    """
    check_keys(written, (*field_names(MeasuredFile), *field_names(Measured), "shape", "surface"), place)
    table = {key: value for key, value in written.items() if value is not None}
    table |= READER.values(MeasuredFile, table, place)
    table |= READER.values(Measured, {key: table[key] for key in SIZES if key in table}, place)
    path = folder / table["file"]
    placed = {key: value for key, value in table.items() if key not in READING}
    with refusing("file", table["file"]):
        content = regular_content(path, LARGEST_FILE)
        if OWN_NAME.fullmatch(path.name):
            for key in READING & table.keys():
                applied = "was already applied when ertel wrote this file; remove it"
                raise ConfigError(f"{key} = {show(table[key])}: {applied}")
            heights = HeightMap(array_in(content))
            if heights.name != path.name:
                raise ValueError("was changed since ertel wrote it; put the run's own back")
            return placed, heights
        if "filled" in table:
            raise ConfigError(f"filled = {show(table['filled'])}: is counted as the file is read; leave it out")
        if path.suffix == ".npz":
            raise ValueError("may hold many arrays; write one with numpy.save")
        is_array = path.suffix == ".npy" or content.startswith(MAGIC_PREFIX)
        raw = (_array if is_array else _of_instrument)(table, content)
        heights = HeightMap(_smoothed(table, raw))
    filled = {"filled": gaps} if (gaps := int(np.ma.getmaskarray(raw.heights).sum())) else {}
    return {**placed, **_sizes(table, raw, heights), **filled, "file": heights.name}, heights


# -- reading ----------------------------------------------------------------------------------------------------------


def _array(table: Mapping[str, Any], content: bytes) -> _Raw:
    """A NumPy array, which has no sizes and no unit."""
    if "channel" in table:
        raise ConfigError(f"channel = {show(table['channel'])}: a NumPy array has none; leave it out")
    heights = array_in(content).astype(np.float64)
    text_maps.check_marks(heights)
    return _Raw(_with_gaps(heights), (), _metre(table))


def _of_instrument(table: Mapping[str, Any], content: bytes) -> _Raw:
    """A file that SurfaceTopography reads."""
    module = _surface_topography(f"file = {show(table['file'])}")
    check_declared(content)
    is_text = not content[:PART].translate(None, TEXT) or content[:2] in UTF_16
    channels: Any = ()
    ending = table["file"].rpartition(".")[2].lower()
    of_name = {"format": ending} if ending in UNMARKED else {}
    try:
        with _reading():
            channels = module.open_topography(BytesIO(content), **of_name).channels
    except ValueError:
        if not is_text:
            raise
    kind = channels[0].reader.format() if channels else ""
    if kind in UNMARKED and not of_name:
        raise ValueError(f"has no mark of a format that is known; one of .{kind} has none, and is known by its name")
    if is_text and _is_plain(channels):
        text = text_maps.read_rows(content)
        if text_maps.is_list(text):
            return _of_points(table, text)
        text_maps.check_matrix(text)
        if not channels or tuple(channels[0].nb_grid_pts) != text.numbers.shape[::-1]:
            with _reading():
                channels = module.open_topography(BytesIO(text.content)).channels
        text_maps.check_marks(text.numbers)
    channel = _channel(table, channels)
    if channel.unit is not None and "unit" in table:
        raise ConfigError(f"unit = {show(table['unit'])}: the file says {channel.unit}; leave it out")
    if channel.nb_grid_pts is not None:
        check_shape(tuple(map(int, channel.nb_grid_pts))[::-1])
    is_known = channel.physical_sizes or channel.is_uniform is False
    sizes = {} if is_known else {"physical_sizes": tuple(map(float, channel.nb_grid_pts))}
    with _reading():
        found = channel.topography(**sizes)
    if not found.is_uniform:
        raise ValueError("its points are not a regular profile; resample them first")
    with _reading():
        found = found if channel.unit is None else found.to_unit("m")
        heights = np.ma.array(found.heights(), dtype=np.float64, copy=True).T
    lengths = () if sizes else tuple(map(float, found.physical_sizes))
    return _Raw(_with_gaps(heights), lengths, _metre(table) if channel.unit is None else 1.0)


def _is_plain(channels: Any) -> bool:
    """Whether no reader of an instrument's own format knows the channels of a text."""
    kinds = {type(channel.reader).__name__ for channel in channels}
    flavours = [channel.info.get("raw_metadata", {}).get("format_flavor") for channel in channels]
    return len(channels) < 2 and kinds <= {"AscReader", "XYZReader"} and not any(flavours)


def _of_points(table: Mapping[str, Any], text: text_maps.Text) -> _Raw:
    heights, lengths, in_metres = text_maps.map_of_points(text)
    if in_metres and "unit" in table:
        raise ConfigError(f"unit = {show(table['unit'])}: the file has units; leave it out")
    text_maps.check_marks(heights)
    return _Raw(_with_gaps(heights), lengths, 1.0 if in_metres else _metre(table))


def _with_gaps(heights: NDArray[np.float64]) -> NDArray[np.float64]:
    """The heights, (ny, nx), with a mask where they are nan."""
    infinite = int(np.ma.filled(np.isinf(heights), False).sum())
    if infinite:
        raise ValueError(f"{infinite} of its heights are infinite; a gap must be nan")
    return np.ma.masked_invalid(np.ma.atleast_2d(heights))


@contextmanager
def _reading() -> Iterator[None]:
    """Any failure of SurfaceTopography, whose readers have their own, as a ValueError; some log its bytes."""
    before = logging.root.manager.disable
    logging.disable()
    try:
        with np.errstate(all="ignore"):
            yield
    except Exception as error:
        reason = shortened(" ".join(str(error).split()) or type(error).__name__)
        raise ValueError(f"SurfaceTopography cannot read it, {reason}") from error
    finally:
        logging.disable(before)


def _channel(table: Mapping[str, Any], channels: Any) -> Any:
    maps = {channel.channel_id: channel for channel in channels if channel.is_height_channel and channel.dim in (1, 2)}
    if not maps:
        raise ValueError("has no heights")
    if "channel" not in table:
        return max(maps.values(), key=lambda channel: channel.dim)  # the first map, or the first profile
    if table["channel"] not in maps:
        raise ConfigError(f"channel = {show(table['channel'])}: the file has {', '.join(map(show, maps))}")
    return maps[table["channel"]]


def _surface_topography(needed_for: str) -> Any:
    try:
        import SurfaceTopography
    except ImportError as error:
        why = "which reads measured surfaces, takes off their form and fills their gaps"
        install = "install it with pip install 'ertel[surfaces]'"
        raise ConfigError(f"{needed_for}: needs the package SurfaceTopography, {why}; {install}") from error
    return SurfaceTopography


def _metre(table: Mapping[str, Any]) -> float | None:
    """The unit that the table gives, in metres."""
    if "unit" not in table:
        return None
    try:
        return parse_quantity(f"1 {table['unit']}", LENGTH)
    except ValueError as error:
        raise ConfigError(f"unit = {show(table['unit'])}: must be a unit of length such as um") from error


# -- trend, gaps, sizes -----------------------------------------------------------------------------------------------


def _smoothed(table: Mapping[str, Any], raw: _Raw) -> NDArray[np.float64]:
    """The heights without trend and gaps."""
    heights, detrend = raw.heights, table.get("detrend", "plane")
    gaps = float(np.ma.getmaskarray(heights).mean()) if heights.size else 0.0
    if gaps > MOST_GAPS:
        raise ValueError(f"{gaps:.0%} of its points are gaps; at most {MOST_GAPS:.0%}")
    check_size(heights)
    if gaps or detrend != "none":
        entry = f'detrend = "{detrend}"' if detrend != "none" else f"file = {show(table['file'])}"
        if len(heights) == 1:
            heights = _smooth_line(heights[0], detrend)
        else:
            sizes = raw.sizes or tuple(map(float, heights.shape[::-1]))
            topography = _surface_topography(entry).Topography(heights.T, sizes)
            topography = topography if detrend == "none" else topography.detrend(DETRENDS[detrend])
            if gaps:
                topography = topography.interpolate_undefined_data_with_harmonic_function()
            heights = np.asarray(topography.heights()).T
        if detrend != "none" and np.abs(heights).max() < ROUND_OFF * np.abs(raw.heights).max():
            leaves = f"leaves nothing but round-off of file = {show(table['file'])}"
            raise ConfigError(f"{entry}: {leaves}; leave the map out")
    return np.asarray(heights, dtype=np.float64)


def _smooth_line(heights: Any, detrend: str) -> NDArray[np.float64]:
    """A profile without the polynomial that fits it best, and with straight lines in its gaps."""
    places, known = np.linspace(-1.0, 1.0, heights.size), ~np.ma.getmaskarray(heights)
    kept = heights.data[known]
    if detrend != "none":
        kept = kept - Polynomial.fit(places[known], kept, [*DETRENDS].index(detrend))(places[known])
    return np.interp(places, places[known], kept)


def _sizes(table: Mapping[str, Any], raw: _Raw, heights: HeightMap) -> dict[str, Any]:
    """Lengths and rms as the table gives them, or else as the file does."""
    rows, columns = heights.heights.shape
    along_x, along_y = (*raw.sizes, 1.0)[:2] if raw.sizes else (float(columns), float(rows))
    if "spacing" in table and (raw.sizes or "length_x" in table):
        known = "the file has lengths" if raw.sizes else "is given together with length_x"
        raise ConfigError(f"spacing = {show(table['spacing'])}: {known}; leave it out")
    needed = SIZES if rows > 1 else ("length_x", "rms")
    found = {key: table[key] for key in SIZES if key in table}
    found |= {"length_x": table["spacing"] * columns} if "spacing" in table else {}
    for key, other, share in (("length_x", "length_y", along_x / along_y), ("length_y", "length_x", along_y / along_x)):
        if key in needed and key not in found and other in found:  # of the same share of the map
            found[key] = found[other] * share
    missing = [key for key in needed if key not in found]
    if "length_x" in missing and not raw.sizes:
        raise ValueError('length_x: missing; the file does not say how long it is; give "500 um", say, or spacing')
    if missing and raw.metre is None:
        raise ValueError('unit: missing; the file does not say in which unit it is, give for example "um"')
    values = {"length_x": along_x, "length_y": along_y, "rms": heights.rms}
    found |= {key: Quantity(values[key] * (raw.metre or 1.0), "m") for key in missing}
    if wrong := [key for key, size in found.items() if isinstance(size, Quantity) and size.value > LONGEST_SIDE]:
        raise ValueError(f"{wrong[0]} = {found[wrong[0]]}: is above a metre; give unit, or length_x, length_y and rms")
    return found


# -- limits to an instrument's file -----------------------------------------------------------------------------------
#
# Checked before a reader unpacks it: readers of text make a list of numbers for each line, readers of XML a tree; a zip
# archive of a megabyte may unpack to gigabytes.  `zipfile` never unpacks more of a member than its declared size, so
# that a size that lies gains nothing.


def check_declared(content: bytes) -> None:
    """Raise ValueError, without the name of the file, for text or a zip archive that holds more than a map may."""
    _check_numbers(BytesIO(content))
    if is_zipfile(BytesIO(content)):
        try:
            with ZipFile(BytesIO(content)) as archive:
                _check_archive(archive)
        except ValueError:
            raise
        except Exception:  # of zipfile and what it unpacks with, for a damaged archive: for the readers to say
            return


def _check_numbers(stream: IO[bytes]) -> None:
    """The numbers of a text, in each line and in all; binary data hardly have any."""
    words = numbers = 0
    with TextIOWrapper(stream, encoding="latin-1") as text:
        while part := text.readline(PART):
            numeric, count = not part.strip(NUMERIC), len(part.replace(",", " ").replace(";", " ").split())
            words, numbers = words + count, numbers + count * numeric
            if words > (MOST if numeric else MOST_WORDS):
                what = "numbers" if numeric else "words"
                raise ValueError(f"has more than {MOST if numeric else MOST_WORDS} {what} in a line; {ALLOWED}")
            if numbers > MOST_NUMBERS:
                raise ValueError(f"has more than {MOST_NUMBERS} numbers; {ALLOWED}")
            words = 0 if part.endswith("\n") else words


def _check_archive(archive: ZipFile) -> None:
    """The members of a zip archive, by their declared sizes and by the first bytes of what looks like text."""
    members = archive.infolist()
    unpacked = sum(member.file_size for member in members)
    if unpacked > LARGEST_FILE:
        raise ValueError(f"unpacks to {unpacked / 1e9:.3g} GB; must be at most {LARGEST_FILE / 1e9:g} GB")
    if any(member.filename == OFFICE for member in members):
        raise ValueError("is an office document, which has no map of heights; export the map as text")
    for member in members:
        head = _head(archive, member)
        if member.filename.endswith(".xml") or head.startswith(b"<"):
            if member.file_size > LARGEST_XML:
                size = f"{member.file_size / 1e6:.3g} MB of XML"
                raise ValueError(f"{member.filename} in it is {size}; must be at most {LARGEST_XML / 1e6:g} MB")
        elif head:
            _check_numbers(archive.open(member))


def _head(archive: ZipFile, member: ZipInfo) -> bytes:
    """The beginning of a member of text; nothing of other data."""
    try:
        with archive.open(member) as stream:
            head = stream.read(64).lstrip(BEFORE_XML)
    except Exception:  # of zipfile, for a member that is damaged, encrypted or packed in an unknown way
        return b""
    return b"" if head.translate(None, TEXT) else head
