"""Pictures for pages, and the outlook on a new case: made by a process of its own, so that pages answer meanwhile.

Neither process imports JAX; matplotlib and xarray are imported by the one that draws, when it begins.
"""

import asyncio
import ctypes
import gc
import os
import signal
import sys
import threading
from collections import OrderedDict
from collections.abc import Callable, Sequence
from concurrent.futures import Executor, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass, field
from functools import lru_cache
from importlib import import_module
from io import BytesIO
from multiprocessing import active_children, get_context, parent_process
from pathlib import Path
from tempfile import TemporaryDirectory
from time import monotonic
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ertel.apps.arguments import Measured
from ertel.inputs.fits import interferometer
from ertel.results.figures import figures_of, is_line, is_steady
from ertel.results.numbers import Number, number, scales_in
from ertel.results.variables import names_where, unit_of, with_clock, with_prefix
from ertel.runs.directory import DATA

if TYPE_CHECKING:  # imported in the process that draws
    import xarray as xr
    from matplotlib.figure import Figure

    from ertel.plots.view import View

INTERFEROGRAM, STUDY = "interferogram", "study"
PACE = 5.0  # frames a second of a movie, so that it is there after some ten seconds
LIGHTS = {"mono": "green light, 532 nm", "two-beam": "two beams", "white": "white light"}
CHOICES = {  # the pictures that there are of a figure, where there are several
    "maps": {"": "at a time", **{f"movie {what}": f"movie of the {what}" for what in ("film", "pressure")}},
    INTERFEROGRAM: {**LIGHTS, **{f"movie {light}": f"movie, {LIGHTS[light]}" for light in LIGHTS}},
}
FIGURES = {  # in the order of their tabs: label, icon
    "maps": ("Film and pressure", "blur_circular"),
    "profiles": ("Mid-line", "show_chart"),
    "midlines": ("Mid-lines", "show_chart"),
    "history": ("Motion", "timeline"),
    "front": ("Front", "open_in_full"),
    "spacetime": ("Through time", "waves"),
    "friction": ("Friction", "local_fire_department"),
    "temperature": ("Temperature", "thermostat"),
    INTERFEROGRAM: ("Interferogram", "lens_blur"),
    "convergence": ("Grids", "grid_on"),
    "overview": ("Overview", "dashboard"),
}
HEAVY = ("ertel.plots", "ertel.runs.arrays", "ertel.runs.outlook")  # imported before they are needed
PICTURES = "pictures"  # where pages get them, as seen from a page
MEMORY = {-3: 2**17, -1: 2**17, -8: 1}  # M_MMAP_THRESHOLD, M_TRIM_THRESHOLD, M_ARENA_MAX of glibc's malloc.h
MOST_NODES = 128  # along a side of a map, of what is under the pointer
NAMES = {"x": "X", "y": "X", "h": "H", "p": "P"}  # the variables that have the units of these
KEPT, KEPT_OPEN = 16, 3  # pictures, of some 0.4 MB each with the fields under the pointer; Datasets
LIMIT, OF_MOVIES, PAUSE = 60.0, 600.0, 600.0  # s for what the other process is asked, and until it is asked again
LATE = "it takes too long to read, as a pipe or a device does; ertel show, or ertel check of a case, tells more"
ENDED = "the process that draws has ended, perhaps for want of memory; it begins again"


@dataclass(frozen=True)
class RunInfo:
    """The facts on a run that a page must know.

    figures: the names of its pictures.  T: the times of its maps in t0, empty for a steady contact; t0: in s, 0 where
    it is not known; zero: T at t = 0.  events: the maps of events by name.  latest: the values of the last step or
    grid.
    """

    title: str = ""
    figures: tuple[str, ...] = ()
    T: tuple[float, ...] = ()
    t0: float = 0.0
    zero: float = 0.0
    events: dict[str, int] = field(default_factory=dict)
    latest: Sequence[Number] = ()


@dataclass(frozen=True)
class PlotRequest:
    """A picture.  figure: its name.  at: a time in t0 or an event.  choice: see `CHOICES`.

    dots: per inch.  stamp: of the data, see `stamp_of`.  columns: 1 for a narrow window, as `plots.Sheet` has them.
    beside: the picture that has equal scales.  measured: a file, the direction of a profile, what is known of it.
    """

    run: Path
    figure: str
    at: float | str | None = None
    choice: str = ""
    kind: str = "png"
    dots: int = 110
    stamp: int = 0
    columns: Literal[1] | None = None
    beside: "PlotRequest | None" = None
    measured: tuple[Path, str, Measured] | None = None

    @property
    def is_movie(self) -> bool:
        """True for a movie of the whole run."""
        return self.choice.startswith("movie")

    @property
    def address(self) -> str:
        """The address of the picture."""
        return f"{PICTURES}/{hash(self) & (2**64 - 1):016x}.{self.kind}"


@dataclass(frozen=True)
class Readout:
    """Film and pressure on a regular grid, and the maps of a picture that show them.

    boxes: left, right, lower and upper edge of each map, in shares of the picture, then as x and y.  is_turned: x is
    downwards, y to the right.  x, y: of the nodes.  fields: film and pressure, (y, x).  units: of x, y, film, pressure,
    by their symbols; in SI all values are in SI.
    """

    boxes: Sequence[tuple[NDArray[np.float64], NDArray[np.float64]]]
    is_turned: bool
    x: NDArray[np.float64]
    y: NDArray[np.float64]
    fields: Sequence[NDArray[np.float32]]
    units: dict[str, str]
    in_si: bool

    def at(self, across: float, down: float) -> str:
        """Position, film and pressure at a place of the picture, in shares of its sides; empty beside the maps."""
        for (left, right, low, high), edges in self.boxes:
            share, up = (across - left) / (right - left), (1.0 - down - low) / (high - low)
            if 0.0 <= share <= 1.0 and 0.0 <= up <= 1.0:
                place = edges[0] + share * (edges[1] - edges[0]), edges[2] + up * (edges[3] - edges[2])
                x, y = place[::-1] if self.is_turned else place
                return self._text(x, y, *(self._between_nodes(field, x, y) for field in self.fields))
        return ""

    def _between_nodes(self, field: NDArray[np.float32], x: float, y: float) -> float:
        row = int(np.clip(np.searchsorted(self.y, y), 1, len(self.y) - 1))
        along_x = [np.interp(x, self.x, each) for each in field[row - 1 : row + 1]]
        return float(np.interp(y, self.y[row - 1 : row + 1], along_x))

    def _text(self, *values: float) -> str:
        named = zip(self.units.items(), values, strict=True)
        if self.in_si:
            return ",  ".join(f"{symbol} = {with_prefix(value, unit)}" for (symbol, unit), value in named)
        return ",  ".join(f"{symbol.upper()} = {value:.3g} {unit}" for (symbol, unit), value in named)


class Picture(NamedTuple):
    """A picture as a file, what is under the pointer on its maps, None where it has none, and words to it."""

    content: bytes
    readout: Readout | None = None
    words: str = ""


def stamp_of(path: Path, data: str = DATA) -> int:
    """A number that changes when the data of a run or a study are written; 0 where there are none yet."""
    try:
        return (path / data / "zarr.json").stat().st_mtime_ns
    except OSError:
        return 0


# -- in the process that draws ----------------------------------------------------------------------------------------


def run_info(run: Path, stamp: int) -> RunInfo:
    """The facts on a run.  Raises ValueError where its data cannot be read."""
    from ertel.results.profiles import events_of

    data = _opened(run, stamp)
    about, steady = data.attrs, is_steady(data)
    scales = scales_in({**about, "si": about}) if "R_m" in about else None
    drawn = {*figures_of(data), *([INTERFEROGRAM] if scales and not is_line(about) else [])}
    figures = tuple(name for name in FIGURES if name in drawn and (name != "front" or about["kind"] == "impact"))
    there = [name for name in names_where(lambda variable: variable.shown) if name in data and data[name].size]
    latest = [number(about["kind"], scales, name, x) for name in there if (x := float(data[name].values[-1]))]
    if steady:
        return RunInfo(str(about["title"]), figures, latest=latest)
    frames = with_clock(data)["frame"]
    t0, zero = (frames.attrs.get(key, 0.0) for key in ("si_factor", "si_zero"))
    return RunInfo(str(about["title"]), figures, tuple(frames.values.tolist()), t0, zero, dict(events_of(data)), latest)


def draw_picture(request: PlotRequest) -> Picture:
    """A picture.  Raises ValueError where there is nothing to draw, or the data cannot be read."""
    from ertel.plots.drawing import NoFigure

    try:
        return _movie(request) if request.is_movie else _still(request)
    except Exception as error:  # of zarr, its codecs, the system
        if isinstance(error, ValueError if request.measured else NoFigure):
            raise
        raise _unreadable(request.run) from error
    finally:
        gc.collect()  # a figure refers to itself, and its arrays are large
        keep_small()


def _movie(request: PlotRequest) -> Picture:
    """A movie of the film, the pressure, or the fringes in a light."""
    from ertel import plots

    data = _opened.__wrapped__(request.run, request.stamp)  # its maps are all loaded, and are not to be kept
    what = request.choice.removeprefix("movie ")
    rig = interferometer(what) if what in LIGHTS else None
    movie = plots.animation(data, rig.light, rig.rig, rate=PACE) if rig else plots.movie(data, what, PACE)
    with TemporaryDirectory() as place:
        movie.save(file := Path(place) / f"movie.{request.kind}", writer="pillow")
        return Picture(file.read_bytes())


def _still(request: PlotRequest) -> Picture:
    from ertel import plots
    from ertel.apps.measuring import beside, measurement_in
    from ertel.plots.view import View
    from ertel.runs.fit_result import open_study

    sheet: Any = {"columns": request.columns}
    run, at, words = request.run, request.at, ""
    if request.measured:
        file, along, given = request.measured
        data, found = beside(run, measurement_in(file, given, along=along))
        figure, words = plots.measured(data, found, **sheet), repr(found)
    elif request.figure == STUDY:
        figure = open_study(run).plot(**sheet)
    elif other := request.beside:
        runs = _opened(run, request.stamp), _opened(other.run, other.stamp)
        figure = plots.side_by_side(runs, request.figure, (at, other.at), **sheet)[0]
    elif request.figure == INTERFEROGRAM:
        rig = interferometer(request.choice or "mono")
        figure = plots.interferogram(_opened(run, request.stamp), at, rig.light, rig.rig, **sheet)
    else:
        figure = plots.draw(_opened(run, request.stamp), request.figure, at, **sheet)
    content = BytesIO()
    figure.savefig(content, format=request.kind, dpi=request.dots)
    if request.measured or request.figure == STUDY:
        return Picture(content.getvalue(), None, words)
    return Picture(content.getvalue(), readout_of(figure, View.of(_opened(run, request.stamp), at)))


def readout_of(figure: "Figure", view: "View") -> Readout | None:
    """The readout of a figure that is drawn; None where it has no maps over the surface."""
    maps = [axes for axes in figure.axes if axes.get_aspect() != "auto" and axes.get_label() != "<colorbar>"]
    if not maps:
        return None
    about = {symbol: view.variable(name).attrs for symbol, name in NAMES.items()}
    one = {symbol: each.get("si_factor", 1.0) for symbol, each in about.items()}
    boxes = [axes.get_position().get_points().T.ravel() for axes in maps]
    edges = [np.array([*axes.get_xlim(), *axes.get_ylim()]) / view.across.factor for axes in maps]
    sides = dict(zip("YX" if view.is_turned else "XY", np.abs(edges).reshape(-1, 2, 2).max(axis=(0, 2)), strict=True))
    fields = [view.map(name).sel({axis: slice(-side, side) for axis, side in sides.items()}) for name in ("H", "P")]
    every = {axis: slice(None, None, -(-nodes // MOST_NODES)) for axis, nodes in fields[0].sizes.items()}
    film, pressure = (each.isel(every) for each in fields)
    kind = view.dataset.attrs["kind"]
    units = {symbol: each.get("si_units") or unit_of(kind, each["in_units_of"]) for symbol, each in about.items()}
    return Readout(
        [(box, edge * one["x"]) for box, edge in zip(boxes, edges, strict=True)],
        view.is_turned,
        film["X"].values * one["x"],
        film["Y"].values * one["x"],
        [(each.values * one[symbol]).astype(np.float32) for symbol, each in (("h", film), ("p", pressure))],
        units,
        view.in_si,
    )


def _unreadable(run: Path) -> ValueError:
    return ValueError(f"the data of this run cannot be read; ertel show {run.name} tells more")


@lru_cache(maxsize=KEPT_OPEN)
def _opened(run: Path, stamp: int) -> "xr.Dataset":
    """The data of a run as they were at a moment; the maps are read when they are drawn."""
    from ertel.runs.arrays import open_data

    if not stamp:
        raise ValueError("nothing is written yet")
    try:
        data = open_data(run / DATA, consolidated=True)
        rest = data if is_steady(data) else data[[name for name in data if data[name].ndim < 2]]
        rest.load()
    except Exception as error:  # of zarr, its codecs, the system
        raise _unreadable(run) from error
    return data


def _with_plain_errors(function: Callable[..., Any], *arguments: Any) -> Any:
    """The result of a function; its errors as plain ValueErrors, without a history.

    A process that receives an error of `plots`, also in the history of another, would import matplotlib.
    """
    try:
        return function(*arguments)
    except ValueError as error:
        message = str(error)
    except Exception as error:  # of xarray, matplotlib, the system
        message = f"{type(error).__name__} in the process that draws; ertel show, or ertel check of a case, tells more"
    raise ValueError(message)


def _begin() -> None:
    """End with the app, leave Ctrl-C and the accelerator to others, and import what takes long before it is needed."""
    threading.Thread(target=_end_with_the_app, daemon=True).start()
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    keep_small()
    os.environ["JAX_PLATFORMS"] = "cpu"  # or the outlook would ask the accelerator for its memory
    sys.modules["dask"] = None  # type: ignore[assignment] # xarray would import it, which takes 20 MB, and use it for nothing
    for name in HEAVY:
        import_module(name)


def keep_small() -> None:
    """Give free memory back to the system, now, and at once from now on, where the C library can; glibc keeps much."""
    if os.name == "posix" and hasattr(library := ctypes.CDLL(None), "mallopt"):
        for option, value in MEMORY.items():
            library.mallopt(option, value)
        library.malloc_trim(0)


def _end_with_the_app() -> None:
    """Wait until the app has ended, however it ended, and end this process."""
    app = parent_process()
    if app is not None:
        app.join()
        os._exit(1)


# -- in the process of the app ----------------------------------------------------------------------------------------


class Worker:
    """Draws pictures and keeps the last ones by their addresses.  make: the executor of what takes long.

    One thing is done after the other.  What takes too long, since a file of it is a pipe perhaps, is ended.  It is not
    tried again for some time, so that only its own page is without an answer.
    """

    def __init__(self, make: Callable[[], Executor] = lambda: ProcessPoolExecutor(1, get_context("spawn"), _begin)):
        self._make, self._executor = make, make()
        self._turn, self._drawing = asyncio.Lock(), asyncio.Lock()
        self._endless = dict[frozenset[str], float]()  # until when, by the runs
        self.kept: OrderedDict[str, Picture] = OrderedDict()

    def begin(self) -> None:
        """Start the other process, before it is needed."""
        self._executor.submit(int)

    async def info(self, run: Path) -> RunInfo:
        """The facts on a run.  Raises ValueError where its data cannot be read, or are not there yet."""
        return await self.result_of(run_info, run, stamp_of(run))

    async def draw(self, request: PlotRequest) -> Picture:
        """A picture, which then has its address.  Raises ValueError where there is nothing to draw."""
        async with self._drawing:  # who asks for the same waits for it
            if request.address not in self.kept:
                self.kept[request.address] = await self.result_of(draw_picture, request)
                if len(self.kept) > KEPT:
                    self.kept.popitem(last=False)
            self.kept.move_to_end(request.address)
            return self.kept[request.address]

    async def result_of(self, function: Callable[..., Any], of: Any, *more: Any) -> Any:
        """The result from the other process; one that ended, for want of memory perhaps, is started again.

        of: a run, a request for a picture of one or two, or the values of a form.
        """
        asked = frozenset(str(getattr(each, "run", each)) for each in (of, getattr(of, "beside", None) or of))
        async with self._turn:
            if any(late <= asked and monotonic() < until for late, until in self._endless.items()):
                raise ValueError(LATE)
            work = asyncio.wrap_future(self._executor.submit(_with_plain_errors, function, of, *more))
            try:
                return await asyncio.wait_for(work, OF_MOVIES if getattr(of, "is_movie", False) else LIMIT)
            except (TimeoutError, BrokenProcessPool) as error:
                for process in active_children():  # this program has no others of this kind
                    process.kill()
                self._executor = self._make()
                if isinstance(error, TimeoutError):
                    self._endless[asked] = monotonic() + PAUSE
                raise ValueError(LATE if isinstance(error, TimeoutError) else ENDED) from error

    def close(self) -> None:
        """End the other process."""
        self._executor.shutdown(wait=False, cancel_futures=True)
