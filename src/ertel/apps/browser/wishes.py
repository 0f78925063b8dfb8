"""What pages ask of the process that draws, and what it answers: records, and no more."""

from dataclasses import dataclass, field
from pathlib import Path

INTERFEROGRAM = "interferogram"
LIGHTS = {"mono": "green light, 532 nm", "two-beam": "two beams", "white": "white light"}


@dataclass(frozen=True)
class Told:
    """What a page must know of a run.

    figures: the names of its pictures.  T: the times of its maps in t0, empty for a steady contact; times: the same as
    text.  events: the maps of events by name.  news: label, symbol and value of the last step or grid.
    """

    title: str
    figures: tuple[str, ...]
    T: tuple[float, ...]
    times: tuple[str, ...]
    events: dict[str, int] = field(default_factory=dict)
    news: tuple[tuple[str, str, str], ...] = ()


@dataclass(frozen=True)
class Wish:
    """A picture.  figure: its name.  at: a time in t0 or an event.  light: of an interferogram, one of `LIGHTS`.

    dots: per inch.  stamp: of the data, see `stamp_of`.
    """

    run: Path
    figure: str
    at: float | str | None = None
    light: str = "mono"
    kind: str = "png"
    dots: int = 110
    stamp: int = 0


def stamp_of(run: Path) -> int:
    """A number that changes when data are written; 0 where there are none yet."""
    try:
        return (run / "run.zarr" / "zarr.json").stat().st_mtime_ns
    except OSError:
        return 0
