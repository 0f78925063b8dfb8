"""Pictures of a run and what is known of it; these functions run in a process of their own, see `pictures`.

They return plain data and raise ValueError with a sentence for the page.
"""

from collections.abc import Sequence
from functools import lru_cache
from io import BytesIO
from pathlib import Path

import xarray as xr
from matplotlib.figure import Figure

from ertel import plots
from ertel.apps.browser.wishes import INTERFEROGRAM, Told, Wish
from ertel.plots.view import View
from ertel.results.variables import EVENTS, VARIABLES, is_steady
from ertel.runs.checked_zarr import RegularStore

IN_TIME = ("maps", "profiles", "history", "front", "friction", INTERFEROGRAM, "overview")
STEADY = ("maps", "midlines", "friction", INTERFEROGRAM, "convergence", "overview")
STRESSES = ("tau_x", "tau_y", "loss")  # that only one figure needs
NEWS = ("H_c", "H_min", "P_max", "F", "mu_sliding")  # what is told of a run that goes on
MOST = 3  # Datasets that are kept


def tell(run: Path, stamp: int) -> Told:
    """What is known of a run.  Raises ValueError where its data cannot be read."""
    data = _opened(run, stamp, STRESSES)
    steady = is_steady(data)
    figures = [
        name
        for name in (STEADY if steady else IN_TIME)
        if (name != "front" or data.attrs["kind"] == "impact") and (name != INTERFEROGRAM or View(data).in_si)
    ]
    T = () if steady else tuple(float(t) for t in data["frame"].values)
    time = None if steady else View(data).scale("time")
    times = tuple(f"{t * time.factor:.3g} {_plain(time.unit)}" for t in T) if time else ()
    codes = [] if steady else [int(code) for code in data["event"].values]
    events = {EVENTS[code]: index for index, code in enumerate(codes) if code}
    return Told(str(data.attrs["title"]), tuple(figures), T, times, events, _news(data))


def _news(data: xr.Dataset) -> tuple[tuple[str, str, str], ...]:
    """The last values of a run; a friction that is zero is none."""
    last = {name: float(data[name].values[-1]) for name in NEWS if name in data and data[name].size}
    told = {name: value for name, value in last.items() if value or not name.startswith("mu")}
    view = View(data)
    return tuple((VARIABLES[name].long_name, name, _plain(view.with_unit(name, value))) for name, value in told.items())


def _plain(text: str) -> str:
    """A unit of matplotlib's as plain text."""
    return text.replace("$", "").replace("^*", "*").replace("^{*2}", "*²").replace("_", "").replace("\\,", " ").strip()


def draw(wish: Wish) -> bytes:
    """A picture as a file.  Raises ValueError where there is nothing to draw, or the data cannot be read."""
    left_out = () if wish.figure in ("friction", "overview") else STRESSES
    data = _opened(wish.run, wish.stamp, left_out)
    try:
        figure = _interferogram(data, wish) if wish.figure == INTERFEROGRAM else _figure(data, wish)
    except Exception:
        _require_readable(data, wish.run)
        raise
    content = BytesIO()
    figure.savefig(content, format=wish.kind, dpi=wish.dots)
    return content.getvalue()


def _figure(data: xr.Dataset, wish: Wish) -> Figure:
    return plots.draw(data, wish.figure, wish.at)


def _interferogram(data: xr.Dataset, wish: Wish) -> Figure:
    from ertel.optics import Monochromatic, Rig, TwoBeams, White

    light = White() if wish.light == "white" else Monochromatic()
    return plots.interferogram(data, wish.at, light, TwoBeams() if wish.light == "two-beam" else Rig())


def _require_readable(data: xr.Dataset, run: Path) -> None:
    """Raise ValueError unless all arrays can be read."""
    try:
        data.copy().load()
    except Exception as error:  # of zarr, its codecs, the system
        raise _unreadable(run) from error


def _unreadable(run: Path) -> ValueError:
    return ValueError(f"the data of this run cannot be read; ertel show {run.name} tells more")


@lru_cache(maxsize=MOST)
def _opened(run: Path, stamp: int, left_out: Sequence[str]) -> xr.Dataset:
    """The data of a run as they were at a moment; arrays are read when they are needed."""
    if not stamp:
        raise ValueError("nothing is written yet")
    try:
        store = RegularStore(run / "run.zarr", read_only=True)
        data: xr.Dataset = xr.open_zarr(store, chunks=None, consolidated=True, drop_variables=left_out)
    except Exception as error:  # of zarr, its codecs, the system
        raise _unreadable(run) from error
    return data
