"""Frames of a camera: the film along a line through an interferogram in monochromatic light.

The film is that of `optics.film_of_intensity`, on each side from outside, where the gap falls towards the centre, as
far as fringes are wide enough; the brightest and the darkest of them are its limits.  The order is that with which the
film in the centre is the nearest to the given one.  The centre is that of the best symmetry: turned by 180 degrees
about it the picture is most like itself, which noise, brightness and the direction of the flow do not change.
"""

import warnings
from contextlib import suppress
from functools import partial
from io import BytesIO
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ertel.case.reading import regular_content
from ertel.case.records import refusing
from ertel.inputs.quantities import parse_quantity, quantity_of
from ertel.optics import DoubtfulFilm, Interferometer, Monochromatic, Rig, film_of_intensity
from ertel.physics.hertz import pressure
from ertel.physics.lubricant import DowsonHigginson
from ertel.physics.units import ANGLE, LENGTH, STRESS

Array = NDArray[np.float64]
LARGEST_FILE, MOST_PIXELS = 200_000_000, 50_000_000
PLAINER = {"LA": "L", "P": "RGB", "PA": "RGB", "CMYK": "RGB"}  # modes of Pillow; an alpha channel is not light
ACROSS = 1  # lines to each side whose mean is taken
ENDS = 2.0  # percent of the points of a line that are brighter, and darker, than its fringes: noise
NARROWEST = 5  # points of half a fringe, where the line ends
MOSTLY = 0.8
WIDE = 6.0  # pixels: a wider structure does not count for the centre
ALIKE = 0.2  # likeness of a picture to itself that is turned about its centre
FAINT = 5.0  # standard errors: range of the light along a line below which it may be noise, which has 4.1
SWING = 0.15  # of the contrast, that a fringe passes its middle by


class FrameLine(NamedTuple):
    """The light along a line of a frame, and its film where it is asked for.

    x: places from the centre (m), intensity with its standard error noise; h: film thickness and sigma, its standard
    error by the noise (m), nan where another film is nearly as likely, (n,).  centre: column and row of that pixel.
    """

    x: Array
    intensity: Array
    noise: float
    h: Array | None
    sigma: Array | None
    centre: tuple[float, float]


def line_of_frame(
    path: Path,
    pixel: str,
    line: str = "x",
    centre: str = "auto",
    optics: Interferometer | None = None,
    film: str = "",
    hertz: str = "",
    page: int | None = None,
) -> FrameLine:
    """The light along a line through the centre of a PNG or TIFF file, and the film where it is known in the centre.

    Parameters
    ----------
    path : Path
        A frame in grey, or in colours, of which the one with the strongest fringes is taken.
    pixel : str
        The size of a pixel on the surface, "1.2 um".
    line : str
        "x", "y", or the angle from x towards y, "30 deg"; y points downwards in the picture.
    centre : str
        "auto", or the column and the row of a pixel, "320, 240".
    optics : Interferometer, optional
        The rig and its monochromatic light, for the film.
    film : str
        The film in the centre, about: fringes give it but for steps of wavelength/2n.  Without it there is none.
    hertz : str
        Hertz pressure and radius of a circular contact, "0.5 GPa, 130 um": the oil is as dense there, by Dowson and
        Higginson's law, as it is under this pressure.  Without it its index is that at ambient pressure.
    page : int, optional
        Which page of a TIFF file with several, from 1.

    Returns
    -------
    FrameLine

    Raises
    ------
    ValueError
        The file is not such a picture, or a value is not allowed; the message names it.
    """
    grey = _picture(path, page)
    size = quantity_of("pixel", pixel, LENGTH)
    with refusing("frame", path.name):
        middle = _symmetric(grey) if centre == "auto" else None
    middle = middle or _given(centre, grey)
    places, light, noise = _along(grey, middle, _angle(line))
    with refusing("frame", path.name):
        if np.ptp(np.percentile(light, [ENDS, 100.0 - ENDS])) < FAINT * noise:
            raise ValueError("has no fringes along the line that stand out of its noise")
    x, intensity = _wide_fringes(places, light)
    if hertz and not film:
        raise ValueError(f'hertz = "{hertz}": is for a film, and film is missing')
    if not film:
        return FrameLine(size * x, intensity, noise, None, None, middle)
    if optics is None or not isinstance(optics.light, Monochromatic):
        raise ValueError("optics: must have monochromatic light for a film")
    start = quantity_of("film", film, LENGTH)
    dark, bright = np.percentile(intensity, [ENDS, 100.0 - ENDS])
    rig, wavelength = optics.rig, optics.light.wavelength
    density = _density(size * x, hertz)
    h, begin = np.zeros_like(x), int(np.argmin(np.abs(x)))
    for side in (slice(0, begin + 1), slice(None, begin - 1 if begin else None, -1)):
        with refusing("frame", path.name):
            found, doubtful = _side(intensity[side], rig, wavelength, start, (dark, bright), density[side])
        h[side] = np.where(doubtful, np.nan, found)
    share = noise / (bright - dark)
    index = rig.index(density)
    phase = 4.0 * np.pi * index * h / wavelength
    sigma = wavelength * share / (2.0 * np.pi * index) / np.maximum(np.abs(np.sin(phase)), np.sqrt(share))
    return FrameLine(size * x, intensity, noise, h, sigma, middle)


def _density(x: Array, hertz: str) -> Array:
    """rho/rho0 of the oil at places along a line, see `line_of_frame`."""
    if not hertz:
        return np.ones_like(x)
    with refusing("hertz", hertz):
        if hertz.count(",") != 1:
            raise ValueError('must be a pressure and a radius, "0.5 GPa, 130 um"')
        p_h, radius = map(parse_quantity, hertz.split(","), (STRESS, LENGTH))
    return np.asarray(DowsonHigginson().density(p_h * pressure(np.abs(x) / radius, 1.0)))


def _side(
    intensity: Array, rig: Rig, wavelength: float, film: float, limits: tuple[float, float], density: Array
) -> tuple[Array, NDArray[np.bool_]]:
    """The film from outside to the centre, where it is about `film`, and where it is doubtful.

    One that begins outside has to end near that film, or else it begins in the centre.  Where the gap does not fall to
    its thinnest place by nearly all that it changes, it turned on fringes, and is doubtful everywhere.
    """
    period = wavelength / (2.0 * rig.index(density))
    light = partial(_film, rig=rig, wavelength=wavelength, limits=limits)
    branches = [light(intensity, order * period[0], density=density) for order in (20.25, 20.75)]
    h, doubtful = max(branches, key=lambda found: float(found[0][0] - found[0][-1]))  # the gap falls
    h = h - period * np.round((h[-1] - film) / period[-1])
    if abs(h[-1] - film) > period[-1] / 8.0:
        inside_out = light(intensity[::-1], film, density=density[::-1])
        h, doubtful = (each[::-1] for each in inside_out)  # type: ignore[assignment]
    gap = h[: int(np.argmin(h)) + 1][::NARROWEST]
    return h, doubtful | (gap[0] - gap[-1] < max(MOSTLY * np.abs(np.diff(gap)).sum(), period[0] / 2.0))


def _film(
    intensity: Array, start: float, rig: Rig, wavelength: float, limits: tuple[float, float], density: Array
) -> tuple[Array, NDArray[np.bool_]]:
    """A film that begins with this one, next to the first point if that is on a fringe, and where it is doubtful."""
    for first in range(len(intensity) // 4):
        with suppress(ValueError), warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always", DoubtfulFilm)
            h = film_of_intensity(intensity[first:], rig, wavelength, start, density[first:], limits)
            doubtful = np.zeros(len(h), dtype=bool)
            for each in caught:
                doubtful |= getattr(each.message, "points", False)
            return np.append(np.full(first, h[0]), h), np.append(np.full(first, True), doubtful)
    raise ValueError("it has too few points between its fringes; take more pixels")


def _picture(path: Path, page: int | None) -> Array:
    """The pixels, (rows, columns), of the colour with the largest contrast.  page: of a file with several, from 1."""
    from PIL import Image

    with refusing("frame", path.name):
        content = regular_content(path, LARGEST_FILE)
        several = False
        try:
            with warnings.catch_warnings(), Image.open(BytesIO(content), formats=("PNG", "TIFF")) as image:
                warnings.simplefilter("ignore")  # that it is large: it is refused
                with suppress(EOFError):
                    image.seek(1)
                    several = page is None
                image.seek((page or 1) - 1)
                columns, rows = image.size
                fits = 16 <= min(columns, rows) and columns * rows <= MOST_PIXELS
                if fits:
                    pixels = np.asarray(image.convert(PLAINER.get(image.mode, image.mode)), dtype=float)
        except Image.DecompressionBombError as error:
            raise ValueError("has too many pixels; must have at most 50 million") from error
        except EOFError as error:
            raise ValueError(f"has no page {page}") from error
        except Exception as error:  # of Pillow, for damaged files, too
            raise ValueError("is not a PNG or TIFF picture, or is damaged") from error
        if several:
            raise ValueError("has several pages; page must name one, 1 for the first")
        if not fits:
            raise ValueError(f"has {columns} x {rows} pixels; must have 16 a side, and at most 50 million")
        if not np.isfinite(pixels).all():
            raise ValueError("has pixels that are not finite numbers")
        colours = pixels.reshape(*pixels.shape[:2], -1)[..., :3]
        grey: Array = colours[..., int(np.argmax(colours.std(axis=(0, 1))))]
        if not np.ptp(grey) > 0:
            raise ValueError("has one brightness only")
    return grey


def _symmetric(grey: Array) -> tuple[float, float]:
    """The point about which the picture is most like itself when it is turned by 180 degrees: column and row.

    That of its narrow fringes, which are outside of the contact: there the gap is symmetric, in rolling, too.  Raises
    ValueError where it is not like itself: of 400 x 360 pixels of noise, white or blurred, the likeness is below 0.15.
    """
    from scipy.ndimage import gaussian_filter
    from scipy.signal import convolve

    fringes = gaussian_filter(grey, 1.0) - gaussian_filter(grey, WIDE)
    weighted = fringes * np.hanning(len(grey))[:, None] * np.hanning(grey.shape[1])
    likeness = convolve(weighted, weighted)
    row, column = (int(place) for place in np.unravel_index(int(np.argmax(likeness)), likeness.shape))
    rows, columns = (
        slice(max(0, twice - size + 1), min(twice, size - 1) + 1)
        for twice, size in zip((row, column), grey.shape, strict=True)
    )
    part = fringes[rows, columns]  # that is there when it is turned, too
    alike = float((part * part[::-1, ::-1]).sum() / (part**2).sum())
    if alike < ALIKE:
        why = "has no fringes that are symmetric about a point, as those around a contact are"
        raise ValueError(f"{why} (likeness {alike:.2f}, at least {ALIKE} is needed); give the centre")
    return column / 2.0, row / 2.0


def _given(centre: str, grey: Array) -> tuple[float, float]:
    try:
        column, row = (float(part) for part in centre.replace(",", " ").split())
    except ValueError:
        column = row = -1.0
    if not (0 <= column < grey.shape[1] and 0 <= row < grey.shape[0]):
        raise ValueError(f'centre = "{centre}": must be auto, or a column and a row of the picture such as "320, 240"')
    return column, row


def _angle(line: str) -> float:
    if line in ("x", "y"):
        return 0.0 if line == "x" else np.pi / 2
    return float(np.deg2rad(quantity_of("line", line, ANGLE)))


def _along(grey: Array, centre: tuple[float, float], angle: float) -> tuple[Array, Array, float]:
    """Places in pixels from the centre, the mean intensity of some parallel lines there, and its noise."""
    from scipy.ndimage import map_coordinates

    way, off = np.array([np.cos(angle), np.sin(angle)]), np.array([-np.sin(angle), np.cos(angle)])
    corners = np.array(grey.shape[::-1]) - 1.0
    with np.errstate(divide="ignore"):
        ends = [np.min(np.where(sign * way > 1e-9, corners - centre, np.array(centre)) / np.maximum(np.abs(way), 1e-9))
                for sign in (-1, 1)]  # fmt: skip
    x = np.arange(-int(ends[0]), int(ends[1]) + 1, dtype=float)
    lines = [
        map_coordinates(grey, (np.array(centre) + np.outer(x, way) + shift * off).T[::-1], order=1, mode="nearest")
        for shift in range(-ACROSS, ACROSS + 1)
    ]
    second = np.diff(np.array(lines), n=2, axis=1)  # of smooth fringes nearly nothing but noise
    noise = float(np.median(np.abs(second))) / 0.6745 / np.sqrt(6.0 * len(lines))
    return x, np.mean(lines, axis=0), noise


def _wide_fringes(x: Array, intensity: Array) -> tuple[Array, Array]:
    """The part of a line about the centre in which no half fringe is narrower than it may be."""
    dark, bright = np.percentile(intensity, [ENDS, 100.0 - ENDS])
    swing = (intensity - 0.5 * (dark + bright)) / (bright - dark)
    clear = np.flatnonzero(np.abs(swing) > SWING)
    passed = clear[1:][np.diff(np.sign(swing[clear])) != 0]  # where a fringe has passed its middle
    narrow = x[passed[1:]][np.diff(passed) < NARROWEST]
    first, last = max(narrow[narrow < 0], default=x[0]), min(narrow[narrow > 0], default=x[-1])
    kept = (x >= first) & (x <= last)
    return x[kept], intensity[kept]
