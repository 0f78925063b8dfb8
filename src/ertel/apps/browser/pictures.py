"""Pictures for pages: drawn by a process of its own, so that pages answer meanwhile; the last ones are kept.

Neither process imports JAX, and this one imports no matplotlib.
"""

import asyncio
import os
import signal
import threading
from collections import OrderedDict
from collections.abc import Callable
from concurrent.futures import Executor, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass, field
from importlib import import_module
from multiprocessing import get_context, parent_process
from pathlib import Path
from typing import Any

INTERFEROGRAM = "interferogram"
LIGHTS = {"mono": "green light, 532 nm", "two-beam": "two beams", "white": "white light"}
DRAWING = "ertel.apps.browser.drawing"  # by its name: the other process imports it
PICTURES = "/pictures"  # where pages get them
KEPT = 60  # pictures, of some 0.2 MB each


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
        return (run / "run.zarr" / "zarr.json").stat().st_mtime_ns
    except OSError:
        return 0


# -- in the other process ---------------------------------------------------------------------------------------------


def _drawn(function: str, *arguments: Any) -> Any:
    """The result of a function of `drawing`; its errors as plain ValueErrors, without a history.

    A process that receives an error of `plots`, also in the history of another, would import matplotlib.
    """
    try:
        return getattr(import_module(DRAWING), function)(*arguments)
    except ValueError as error:
        message = str(error)
    except Exception as error:  # of zarr, its codecs, xarray, matplotlib: the data are damaged
        message = f"the data of this run cannot be drawn ({type(error).__name__}); ertel show tells more"
    raise ValueError(message)


def _begin() -> None:
    """End with the app, leave Ctrl-C to it, and import what takes long before it is asked for."""
    threading.Thread(target=_end_with_the_app, daemon=True).start()
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    import_module(DRAWING)


def _end_with_the_app() -> None:
    """Wait until the app has ended, however it ended, and end this process."""
    app = parent_process()
    if app is not None:
        app.join()
        os._exit(1)


# -- in this one ------------------------------------------------------------------------------------------------------


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
        found: RunInfo = await self._asked("info", run, stamp_of(run))
        return found

    async def draw(self, request: PlotRequest) -> bytes:
        """A picture as a file.  Raises ValueError where there is nothing to draw."""
        if request.key not in self.kept:
            self.kept[request.key] = await self._asked("draw", request)
            while len(self.kept) > KEPT:
                self.kept.popitem(last=False)
        self.kept.move_to_end(request.key)
        return self.kept[request.key]

    async def address(self, request: PlotRequest) -> str:
        """The address of a picture, which is drawn when this returns.  Raises ValueError where it cannot be."""
        await self.draw(request)
        return f"{PICTURES}/{request.key}"

    async def _asked(self, function: str, *arguments: Any) -> Any:
        """The answer of the other process; one that ended, for want of memory perhaps, is started again."""
        try:
            return await asyncio.get_running_loop().run_in_executor(self._executor, _drawn, function, *arguments)
        except BrokenProcessPool as error:
            self._executor = self._make()
            raise ValueError(
                "the process that draws has ended, for want of memory perhaps; it was started again"
            ) from error

    def close(self) -> None:
        """End the process that draws."""
        self._executor.shutdown(wait=False, cancel_futures=True)
