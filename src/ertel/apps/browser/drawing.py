"""Pictures of a run and the facts on it; these functions run in a process of their own, see `pictures`.

They return plain data and raise ValueError with a sentence for the page.
"""

import gc
from collections.abc import Sequence
from functools import lru_cache
from io import BytesIO
from pathlib import Path

import xarray as xr
from matplotlib.figure import Figure

from ertel import plots
from ertel.apps.browser.pictures import INTERFEROGRAM, PlotRequest, RunInfo
from ertel.plots.view import View
from ertel.results.variables import EVENTS, VARIABLES, is_steady
from ertel.runs.arrays import RegularStore

IN_TIME = ("maps", "profiles", "history", "front", "friction", INTERFEROGRAM, "overview")
STEADY = ("maps", "midlines", "friction", INTERFEROGRAM, "convergence", "overview")
STRESSES = ("tau_x", "tau_y", "loss")  # that only one figure needs
LATEST = ("H_c", "H_min", "P_max", "F", "mu_sliding")  # shown of a run that goes on
MOST = 3  # Datasets that are kept


def info(run: Path, stamp: int) -> RunInfo:
    """The facts on a run.  Raises ValueError where its data cannot be read."""
    data = _opened(run, stamp, STRESSES)
    title, latest = str(data.attrs["title"]), _latest(data)
    if is_steady(data):
        return RunInfo(title, _figures(data, STEADY), latest=latest)
    T, time = tuple(float(t) for t in data["frame"].values), View(data).scale("time")
    times = tuple(f"{t * time.factor:.3g} {_plain(time.unit)}" for t in T)
    events = {EVENTS[int(code)]: index for index, code in enumerate(data["event"].values) if code}
    return RunInfo(title, _figures(data, IN_TIME), T, times, events, latest)


def _figures(data: xr.Dataset, names: Sequence[str]) -> tuple[str, ...]:
    """Those of the figures that a run has."""
    missing = [*(["front"] if data.attrs["kind"] != "impact" else []), *([] if View(data).in_si else [INTERFEROGRAM])]
    return tuple(name for name in names if name not in missing)


def _latest(data: xr.Dataset) -> tuple[tuple[str, str, str], ...]:
    """The last values of a run; a friction that is zero is none."""
    last = {name: float(data[name].values[-1]) for name in LATEST if name in data and data[name].size}
    shown = {name: value for name, value in last.items() if value or not name.startswith("mu")}
    view = View(data)
    return tuple(
        (VARIABLES[name].long_name, name, _plain(view.with_unit(name, value))) for name, value in shown.items()
    )


def _plain(text: str) -> str:
    """A unit of matplotlib's as plain text."""
    return text.replace("$", "").replace("^*", "*").replace("^{*2}", "*²").replace("_", "").replace("\\,", " ").strip()


def draw(request: PlotRequest) -> bytes:
    """A picture as a file.  Raises ValueError where there is nothing to draw, or the data cannot be read."""
    left_out = () if request.figure in ("friction", "overview") else STRESSES
    data = _opened(request.run, request.stamp, left_out)
    try:
        figure = _figure(data, request)
    except Exception:
        _require_readable(data, request.run)
        raise
    content = BytesIO()
    figure.savefig(content, format=request.kind, dpi=request.dots)
    del figure
    gc.collect()  # it refers to itself, and its arrays are large
    return content.getvalue()


def _figure(data: xr.Dataset, request: PlotRequest) -> Figure:
    if request.figure != INTERFEROGRAM:
        return plots.draw(data, request.figure, request.at)
    from ertel.optics import Monochromatic, Rig, TwoBeams, White

    light = White() if request.light == "white" else Monochromatic()
    return plots.interferogram(data, request.at, light, TwoBeams() if request.light == "two-beam" else Rig())


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
