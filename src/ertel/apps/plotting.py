"""`ertel plot`: the figures of a run, and its interferogram as a picture or a movie."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from ertel.apps.terminal import BAD_INPUT, bad_input, leave, print_path

if TYPE_CHECKING:  # these take long to import
    import xarray as xr

    from ertel.optics import Light, Rig

Lighting = Literal["mono", "two-beam", "white"]
MOVIES = {"gif": "pillow", "webp": "pillow", "mp4": "ffmpeg"}  # format: matplotlib's name of its writer


Interferogram = Annotated[
    Lighting | None,
    typer.Option(
        help="Draw the fringes that an experimenter sees: of one wavelength, of two beams only, or in white light.",
        show_default=False,
    ),
]
Wavelength = Annotated[
    str | None, typer.Option(metavar="LENGTH", help="Of the fringes; default 532 nm.", show_default=False)
]


@dataclass(frozen=True)
class PlotOptions:
    """The flags of `ertel plot`.

    Attributes
    ----------
    what : str or None
        The name of one figure; None for all.
    at : str or None
        The moment, a time or the name of an event.
    lighting : Lighting or None
        The light of an interferogram; None for the figures of the run.
    wavelength : str or None
        A quantity; None for green light.
    kind : str
        The file format: png, svg, pdf, or a movie.
    """

    what: str | None
    at: str | None
    lighting: Lighting | None
    wavelength: str | None
    kind: str

    def check(self) -> None:
        """Leave with a message where flags do not go together."""
        if self.kind in MOVIES and self.lighting is None:
            leave(BAD_INPUT, f"--format {self.kind}: only an interferogram moves; add --interferogram mono")
        if self.kind in MOVIES and self.at is not None:
            leave(BAD_INPUT, f"--at {self.at}: a movie shows all times; leave it out, or use --format png")
        if self.wavelength is not None and self.lighting in (None, "white"):
            leave(BAD_INPUT, f"--wavelength {self.wavelength}: only for --interferogram mono or two-beam")

    def moment(self) -> float | str | None:
        """The moment as a number where it is one."""
        try:
            return None if self.at is None else float(self.at)
        except ValueError:
            return self.at

    def optics(self) -> tuple["Light", "Rig"]:
        """The light and the rig.  Raises ValueError for an impossible wavelength."""
        from ertel.inputs.quantities import parse_quantity
        from ertel.optics import Monochromatic, Rig, TwoBeams, White
        from ertel.physics.units import Unit

        if self.lighting == "white":
            return White(), Rig()
        rig = TwoBeams() if self.lighting == "two-beam" else Rig()
        if not self.wavelength:
            return Monochromatic(), rig
        try:
            metres = parse_quantity(self.wavelength, Unit("m", "532 nm"))
        except ValueError as error:
            raise ValueError(f"--wavelength {self.wavelength}: {error}") from error
        return Monochromatic(metres or 0.0), rig


def write(data: "xr.Dataset", options: PlotOptions, target: Path) -> None:
    """Draw the figures of a run or its interferogram, then write them into a directory and print their names."""
    from ertel import plots

    if options.kind == "mp4":
        _find_ffmpeg()
    saves: dict[str, Callable[[Path], object]] = {}
    with bad_input():
        if options.lighting is None:
            names = [options.what] if options.what else plots.names_of(data)
            saves |= {name: plots.draw(data, name, options.moment()).savefig for name in names}
        elif options.kind in MOVIES:
            movie = plots.animation(data, *options.optics())
            saves[f"interferogram-{options.lighting}"] = partial(movie.save, writer=MOVIES[options.kind])
        else:
            picture = plots.interferogram(data, options.moment(), *options.optics())
            saves[f"interferogram-{options.lighting}"] = picture.savefig
    target.mkdir(parents=True, exist_ok=True)
    for name, save in saves.items():
        path = target / f"{name}.{options.kind}"
        save(path)
        print_path(path)


def _find_ffmpeg() -> None:
    """Tell matplotlib where the program is that writes mp4."""
    from matplotlib import rcParams

    try:
        from imageio_ffmpeg import get_ffmpeg_exe
    except ImportError:
        leave(BAD_INPUT, "--format mp4: needs imageio-ffmpeg, pip install 'ertel[movie]'; gif and webp do not")
    rcParams["animation.ffmpeg_path"] = get_ffmpeg_exe()
