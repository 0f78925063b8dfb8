"""Pictures for pages: drawn by a process of its own, so that pages answer meanwhile; the last ones are kept.

Neither process imports JAX, and this one imports no matplotlib.
"""

import asyncio
import gc
import os
import signal
import threading
from collections import OrderedDict
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from multiprocessing import get_context, parent_process
from pathlib import Path
from typing import Any, TypeVar

from ertel.apps.browser.wishes import Told, Wish, stamp_of

T = TypeVar("T")

KEPT = 60  # pictures, of some 0.2 MB each


# -- in the other process ---------------------------------------------------------------------------------------------


def _tell(run: Path, stamp: int) -> Told:
    from ertel.apps.browser import drawing

    return _plainly(drawing.tell, run, stamp)


def _draw(wish: Wish) -> bytes:
    from ertel.apps.browser import drawing

    content = _plainly(drawing.draw, wish)
    gc.collect()  # the figure, whose arrays are large, refers to itself
    return content


def _plainly(work: Callable[..., T], *arguments: Any) -> T:
    """The result of a function; its errors as plain ValueErrors, without a history.

    A process that receives an error of `plots`, also in the history of another, would import matplotlib.
    """
    try:
        return work(*arguments)
    except ValueError as error:
        said = str(error)
    except Exception as error:  # of zarr, its codecs, xarray, matplotlib: the data are damaged
        said = f"the data of this run cannot be drawn ({type(error).__name__}); ertel show tells more"
    raise ValueError(said)


def _begin() -> None:
    """End with the app, leave Ctrl-C to it, and import what takes long before it is asked for."""
    threading.Thread(target=_end_with_the_app, daemon=True).start()
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    from ertel.apps.browser import drawing as drawing


def _end_with_the_app() -> None:
    """Wait until the app has ended, however it ended, and end this process."""
    app = parent_process()
    if app is not None:
        app.join()
        os._exit(1)


# -- in this one ------------------------------------------------------------------------------------------------------


def _process() -> Executor:
    return ProcessPoolExecutor(1, mp_context=get_context("spawn"), initializer=_begin)


class Artist:
    """Draws pictures and keeps the last ones.  make: of the executor that draws."""

    def __init__(self, make: Callable[[], Executor] = _process):
        self._make, self._executor = make, make()
        self._kept: OrderedDict[Wish, bytes] = OrderedDict()

    def begin(self) -> None:
        """Start the process that draws, before it is needed."""
        self._executor.submit(int)

    async def tell(self, run: Path) -> Told:
        """What is known of a run.  Raises ValueError where its data cannot be read, or are not there yet."""
        return await self._asked(_tell, run, stamp_of(run))

    async def draw(self, wish: Wish) -> bytes:
        """A picture as a file.  Raises ValueError where there is nothing to draw."""
        if wish not in self._kept:
            self._kept[wish] = await self._asked(_draw, wish)
            while len(self._kept) > KEPT:
                self._kept.popitem(last=False)
        self._kept.move_to_end(wish)
        return self._kept[wish]

    async def _asked(self, work: Callable[..., T], *arguments: Any) -> T:
        """The answer of the other process; one that ended, for want of memory perhaps, is started again."""
        with self._renewed_if_broken():
            return await asyncio.get_running_loop().run_in_executor(self._executor, work, *arguments)
        raise AssertionError("a broken process is an error")

    @contextmanager
    def _renewed_if_broken(self) -> Iterator[None]:
        try:
            yield
        except BrokenProcessPool as error:
            self._executor = self._make()
            raise ValueError(
                "the process that draws has ended, for want of memory perhaps; it was started again"
            ) from error

    def close(self) -> None:
        """End the process that draws."""
        self._executor.shutdown(wait=False, cancel_futures=True)
