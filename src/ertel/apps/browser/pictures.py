"""Pictures for pages: drawn by a process of its own, so that pages answer meanwhile; the last ones are kept.

Neither process imports JAX; matplotlib and xarray are imported by the one that draws, when it begins.
"""

import asyncio
import gc
import os
import signal
import threading
from collections import OrderedDict
from collections.abc import Callable, Sequence
from concurrent.futures import Executor, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass, field
from functools import lru_cache
from importlib import import_module
from io import BytesIO
from multiprocessing import get_context, parent_process
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ertel.results.variables import VARIABLES, is_steady
from ertel.runs.directory import DATA

if TYPE_CHECKING:  # imported in the process that draws
    import xarray as xr
    from matplotlib.figure import Figure

    from ertel.plots.view import View

INTERFEROGRAM = "interferogram"
LIGHTS = {"mono": "green light, 532 nm", "two-beam": "two beams", "white": "white light"}
IN_TIME = ("maps", "profiles", "history", "front", "friction", INTERFEROGRAM, "overview")
STEADY = ("maps", "midlines", "friction", INTERFEROGRAM, "convergence", "overview")
STRESSES = ("tau_x", "tau_y", "loss")  # only one figure needs them
LATEST = ("H_c", "H_min", "P_max", "F", "mu_sliding")  # shown of a run that goes on
HEAVY = ("ertel.plots", "ertel.runs.arrays")  # imported before they are needed
PICTURES = "/pictures"  # where pages get them
KEPT = 60  # pictures, of some 0.2 MB each
KEPT_OPEN = 3  # Datasets


@dataclass(frozen=True)
class RunInfo:
    """The facts on a run that a page must know.

    figures: the names of its pictures.  T: the times of its maps in t0, empty for a steady contact; times: the same as
    text.  events: the maps of events by name.  latest: label, symbol and value of the last step or grid.
    """

    title: str = ""
    figures: tuple[str, ...] = ()
    T: tuple[float, ...] = ()
    times: tuple[str, ...] = ()
    events: dict[str, int] = field(default_factory=dict)
    latest: tuple[tuple[str, str, str], ...] = ()


@dataclass(frozen=True)
class PlotRequest:
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

    @property
    def key(self) -> str:
        """The name of the picture in its address."""
        return format(hash(self) & (2**64 - 1), "016x")


def stamp_of(run: Path) -> int:
    """A number that changes when data are written; 0 where there are none yet."""
    try:
        return (run / DATA / "zarr.json").stat().st_mtime_ns
    except OSError:
        return 0


# -- in the process that draws ----------------------------------------------------------------------------------------


def run_info(run: Path, stamp: int) -> RunInfo:
    """The facts on a run.  Raises ValueError where its data cannot be read."""
    from ertel.plots.view import View
    from ertel.results.profiles import events_of

    data = _opened(run, stamp, STRESSES)
    view, title = View(data), str(data.attrs["title"])
    steady = is_steady(data)
    missing = {"front" if data.attrs["kind"] != "impact" else "", INTERFEROGRAM if not view.in_si else ""}
    figures = tuple(name for name in (STEADY if steady else IN_TIME) if name not in missing)
    if steady:
        return RunInfo(title, figures, latest=_latest(view))
    T, time = tuple(float(t) for t in data["frame"].values), view.scale("time")
    times = tuple(f"{t * time.factor:.3g} {_plain(time.unit)}" for t in T)
    return RunInfo(title, figures, T, times, dict(events_of(data)), _latest(view))


def _latest(view: "View") -> tuple[tuple[str, str, str], ...]:
    """The last values of a run, without a friction that is zero."""
    data = view.dataset
    last = {name: float(data[name].values[-1]) for name in LATEST if name in data and data[name].size}
    return tuple(
        (VARIABLES[name].long_name, name, _plain(view.with_unit(name, value)))
        for name, value in last.items()
        if value or not name.startswith("mu")
    )


def _plain(text: str) -> str:
    """A unit of matplotlib's as plain text."""
    return text.replace("$", "").replace("^*", "*").replace("^{*2}", "*²").replace("_", "").replace("\\,", " ").strip()


def draw_picture(request: PlotRequest) -> bytes:
    """A picture as a file.  Raises ValueError where there is nothing to draw, or the data cannot be read."""
    left_out = () if request.figure in ("friction", "overview") else STRESSES
    data = _opened(request.run, request.stamp, left_out)
    try:
        figure = _figure(data, request)
    except Exception:
        try:
            data.copy().load()
        except Exception as error:  # of zarr, its codecs, the system
            raise _unreadable(request.run) from error
        raise
    content = BytesIO()
    figure.savefig(content, format=request.kind, dpi=request.dots)
    del figure
    gc.collect()  # it refers to itself, and its arrays are large
    return content.getvalue()


def _figure(data: "xr.Dataset", request: PlotRequest) -> "Figure":
    from ertel import plots

    if request.figure != INTERFEROGRAM:
        return plots.draw(data, request.figure, request.at)
    from ertel.optics import Monochromatic, Rig, TwoBeams, White

    light = White() if request.light == "white" else Monochromatic()
    return plots.interferogram(data, request.at, light, TwoBeams() if request.light == "two-beam" else Rig())


@lru_cache(maxsize=KEPT_OPEN)
def _opened(run: Path, stamp: int, left_out: Sequence[str]) -> "xr.Dataset":
    """The data of a run as they were at a moment; arrays are read when they are needed."""
    import xarray as xr

    from ertel.runs.arrays import RegularStore

    if not stamp:
        raise ValueError("nothing is written yet")
    try:
        store = RegularStore(run / DATA, read_only=True)
        data: xr.Dataset = xr.open_zarr(store, chunks=None, consolidated=True, drop_variables=left_out)
    except Exception as error:  # of zarr, its codecs, the system
        raise _unreadable(run) from error
    return data


def _unreadable(run: Path) -> ValueError:
    return ValueError(f"the data of this run cannot be read; ertel show {run.name} tells more")


def _with_plain_errors(function: Callable[..., Any], *arguments: Any) -> Any:
    """The result of a function; its errors as plain ValueErrors, without a history.

    A process that receives an error of `plots`, also in the history of another, would import matplotlib.
    """
    try:
        return function(*arguments)
    except ValueError as error:
        message = str(error)
    except Exception as error:  # of zarr, its codecs, xarray, matplotlib: the data are damaged
        message = f"the data of this run cannot be drawn ({type(error).__name__}); ertel show tells more"
    raise ValueError(message)


def _begin() -> None:
    """End with the app, leave Ctrl-C to it, and import what takes long before it is asked for."""
    threading.Thread(target=_end_with_the_app, daemon=True).start()
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    for name in HEAVY:
        import_module(name)


def _end_with_the_app() -> None:
    """Wait until the app has ended, however it ended, and end this process."""
    app = parent_process()
    if app is not None:
        app.join()
        os._exit(1)


# -- in the process of the app ----------------------------------------------------------------------------------------


def _process() -> Executor:
    return ProcessPoolExecutor(1, mp_context=get_context("spawn"), initializer=_begin)


class PlotWorker:
    """Draws pictures and keeps the last ones by their keys.  make: of the executor that draws."""

    def __init__(self, make: Callable[[], Executor] = _process):
        self._make, self._executor = make, make()
        self.kept: OrderedDict[str, bytes] = OrderedDict()

    def begin(self) -> None:
        """Start the process that draws, before it is needed."""
        self._executor.submit(int)

    async def info(self, run: Path) -> RunInfo:
        """The facts on a run.  Raises ValueError where its data cannot be read, or are not there yet."""
        info: RunInfo = await self._result_of(run_info, run, stamp_of(run))
        return info

    async def draw(self, request: PlotRequest) -> bytes:
        """A picture as a file.  Raises ValueError where there is nothing to draw."""
        if request.key not in self.kept:
            self.kept[request.key] = await self._result_of(draw_picture, request)
            while len(self.kept) > KEPT:
                self.kept.popitem(last=False)
        self.kept.move_to_end(request.key)
        return self.kept[request.key]

    async def address(self, request: PlotRequest) -> str:
        """The address of a picture, which is drawn when this returns.  Raises ValueError where it cannot be."""
        await self.draw(request)
        return f"{PICTURES}/{request.key}"

    async def _result_of(self, function: Callable[..., Any], *arguments: Any) -> Any:
        """The result from the other process; one that ended, for want of memory perhaps, is started again."""
        loop = asyncio.get_running_loop()
        try:
            return await loop.run_in_executor(self._executor, _with_plain_errors, function, *arguments)
        except BrokenProcessPool as error:
            self._executor = self._make()
            raise ValueError(
                "the process that draws has ended, for want of memory perhaps; it was started again"
            ) from error

    def close(self) -> None:
        """End the process that draws."""
        self._executor.shutdown(wait=False, cancel_futures=True)
