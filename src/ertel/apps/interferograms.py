"""The interferogram of a run as a picture or a movie."""

from collections.abc import Callable
from dataclasses import dataclass
from enum import StrEnum
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ertel.apps.terminal import BAD_INPUT, bad_input, leave, print_path

if TYPE_CHECKING:  # these take long to import
    import xarray as xr

    from ertel.optics import Light, Rig

MOVIES = {"gif": "pillow", "webp": "pillow", "mp4": "ffmpeg"}  # format: who writes it


class Sight(StrEnum):
    """How a contact is looked at."""

    mono = "mono"
    two_beam = "two-beam"
    white = "white"


Interferogram = Annotated[
    Sight | None,
    typer.Option(
        help="Draw the fringes that an experimenter sees: of one wavelength, of two beams only, or in white light.",
        show_default=False,
    ),
]
Wavelength = Annotated[
    str | None, typer.Option(metavar="LENGTH", help="Of the fringes; default 532 nm.", show_default=False)
]


@dataclass(frozen=True)
class View:
    """The flags of an interferogram.  wavelength: a quantity, or None for green light."""

    sight: Sight | None
    wavelength: str | None
    at: str | None
    kind: str

    def check(self) -> None:
        """Leave with a message where flags do not go together."""
        if self.kind in MOVIES and self.sight is None:
            leave(BAD_INPUT, f"--format {self.kind}: only an interferogram moves; add --interferogram mono")
        if self.kind in MOVIES and self.at is not None:
            leave(BAD_INPUT, f"--at {self.at}: a movie shows all times; leave it out, or use --format png")
        if self.wavelength is not None and self.sight in (None, Sight.white):
            leave(BAD_INPUT, f"--wavelength {self.wavelength}: only for --interferogram mono or two-beam")

    def optics(self) -> tuple["Light", "Rig"]:
        """The light and the rig.  Raises ValueError for a wavelength that is none."""
        from ertel.optics import Monochromatic, Rig, TwoBeams, White

        rig = TwoBeams() if self.sight is Sight.two_beam else Rig()
        if self.sight is Sight.white:
            return White(), rig
        return Monochromatic(self._metres()) if self.wavelength else Monochromatic(), rig

    def _metres(self) -> float:
        from ertel.inputs.quantities import parse_quantity
        from ertel.physics.units import Unit

        try:
            return parse_quantity(self.wavelength, Unit("m", "532 nm")) or 0.0
        except ValueError as error:
            raise ValueError(f"--wavelength {self.wavelength}: {error}") from error


def write(data: "xr.Dataset", view: View, target: Path) -> None:
    """Write the interferogram into a directory and print its name."""
    _find_writer(view.kind)
    with bad_input():
        save = _drawn(data, view)
    target.mkdir(parents=True, exist_ok=True)
    path = target / f"interferogram-{view.sight}.{view.kind}"
    save(path)
    print_path(path)


def _drawn(data: "xr.Dataset", view: View) -> Callable[[Path], object]:
    """What saves the picture or the movie.  Raises ValueError where there is nothing to draw."""
    from ertel import plots
    from ertel.apps.plotting import time_or_event

    light, rig = view.optics()
    if view.kind in MOVIES:
        return partial(plots.animation(data, light, rig).save, writer=MOVIES[view.kind])
    at = None if view.at is None else time_or_event(view.at)
    return plots.interferogram(data, at, light, rig).savefig


def _find_writer(kind: str) -> None:
    """Tell matplotlib where the program is that writes a format, if it is not matplotlib itself."""
    if MOVIES.get(kind) != "ffmpeg":
        return
    from matplotlib import rcParams

    try:
        from imageio_ffmpeg import get_ffmpeg_exe
    except ImportError:
        leave(BAD_INPUT, f"--format {kind}: needs imageio-ffmpeg, pip install 'ertel[movie]'; gif and webp do not")
    rcParams["animation.ffmpeg_path"] = get_ffmpeg_exe()
