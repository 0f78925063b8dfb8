"""Limits to the declared content of an instrument's file, checked before a reader unpacks it.

Readers of text make a list of numbers for each line, readers of XML a tree; a zip archive of a megabyte may unpack to
gigabytes.  `zipfile` never unpacks more of a member than its declared size, so that a size that lies gains nothing.
"""

from io import BytesIO, TextIOWrapper
from string import printable
from typing import IO
from zipfile import ZipFile, ZipInfo, is_zipfile

from ertel.case.height_map import MOST

LARGEST_FILE = 600_000_000  # bytes, also unpacked: four maps of the most points, or one as text
LARGEST_XML = 10_000_000  # bytes: what stands beside the heights
MOST_NUMBERS = MOST**2
MOST_WORDS = 1_000_000  # of a line that is not all numbers
PART = 1 << 20  # characters of a line that are looked at in one go
NUMERIC = "0123456789+-.eE,;nNaAiIfFtTbBdD \t\r\n\0"  # also nan, inf, infinite and bad; NUL of UTF-16
TEXT = printable.encode() + bytes(range(0x80, 0x100))
BEFORE_XML = b"\xef\xbb\xbf \t\r\n"  # byte order mark and blanks
OFFICE = "[Content_Types].xml"  # a member of every office document


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
            numeric, found = not part.strip(NUMERIC), len(part.replace(",", " ").replace(";", " ").split())
            words, numbers = words + found, numbers + found * numeric
            if words > (MOST if numeric else MOST_WORDS):
                what = "numbers" if numeric else "words"
                raise ValueError(f"has more than {MOST if numeric else MOST_WORDS} {what} in a line; {_allowed()}")
            if numbers > MOST_NUMBERS:
                raise ValueError(f"has more than {MOST_NUMBERS} numbers; {_allowed()}")
            words = 0 if part.endswith("\n") else words


def _allowed() -> str:
    return f"a map has at most {MOST} points a side"


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
            _check_xml(member)
        elif head:
            _check_numbers(archive.open(member))


def _check_xml(member: ZipInfo) -> None:
    if member.file_size > LARGEST_XML:
        size = f"{member.file_size / 1e6:.3g} MB of XML"
        raise ValueError(f"{member.filename} in it is {size}; must be at most {LARGEST_XML / 1e6:g} MB")


def _head(archive: ZipFile, member: ZipInfo) -> bytes:
    """The beginning of a member of text; nothing of other data."""
    try:
        with archive.open(member) as stream:
            head = stream.read(64).lstrip(BEFORE_XML)
    except Exception:  # of zipfile, for a member that is damaged, encrypted or packed in an unknown way
        return b""
    return b"" if head.translate(None, TEXT) else head
