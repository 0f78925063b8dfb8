"""The moment of a run that is asked for, and film, pressure and oil along a line through the centre at that moment.

`moment_of` is the one place that reads `at`, for all pictures, exports and measurements.  A picture shows the map next
to a time; a profile is interpolated linearly in time between the two maps around it, so that it depends smoothly on the
time and on the case.
"""

from collections.abc import Mapping, Sequence
from contextlib import suppress
from math import nan
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from ertel.physics.units import TIME, Quantity, in_si, si_numbers
from ertel.results.dataset import with_units
from ertel.results.figures import is_line, is_steady
from ertel.results.variables import EVENTS, VARIABLES, shifted, to_si, with_clock, with_prefix

Values = NDArray[np.float64]
# a time in t0 or with its unit, an event, or None: maximum approach, or the last map
At = float | str | Quantity | None
MAXIMUM, LAST, END, CHOSEN = "maximum approach", "last map", "end of the run", "chosen map"
NAMES = {"max-approach": MAXIMUM, "end": END}
ALONG = {"x": ("X", "Y"), "y": ("Y", "X")}  # the axis of a line, and the other one
ON_A_LINE = ("H", "P", "oil")
ROUNDING = 1e-9  # t0


class Instant(NamedTuple):
    """A moment of a run in time.  T: in t0.  frame: the number of the map next to it.  name: in words."""

    T: float
    frame: int
    name: str


def events_of(dataset: xr.Dataset) -> Mapping[str, int]:
    """The maps of the events of a run in time, by name."""
    codes = dataset["event"].values
    return {EVENTS[code]: int(np.flatnonzero(codes == code)[0]) for code in sorted({int(c) for c in codes}) if code}


def is_without_moments(dataset: xr.Dataset, at: At) -> bool:
    """Whether a run is a steady contact.  Raises ValueError for a moment of it, and where it has no solution."""
    if not is_steady(dataset):
        return False
    if at is not None:
        raise ValueError(f"at = {at!r}: a steady contact has no moments to choose from; leave it out")
    if np.isnan(dataset["H_c"].values[-1:]).all():
        raise ValueError(f"dataset: has no solution ({dataset.attrs.get('status', 'running')})")
    return True


def moment_of(dataset: xr.Dataset, at: At = None) -> Instant:
    """The moment of a run in time that is asked for.

    dataset: a run in time, dimensionless as it is stored.  at: T, from the start of the run in t0, as a number; a time
    with its unit, "95 us", of a physical case, from the first touch, see `results.variables`; or an event of the run,
    "max-approach" or "end".  By default maximum approach, or the last map where there is none.  Raises ValueError where
    the run has no maps yet, or does not have this moment.
    """
    frames, events = with_clock(dataset)["frame"], events_of(dataset)
    T, at = np.asarray(frames.values), moment_text(at)
    if not T.size:
        raise ValueError("dataset: has no maps yet")
    if at is None:
        frame = events.get("max-approach", len(T) - 1)
        return Instant(float(T[frame]), frame, MAXIMUM if "max-approach" in events else LAST)
    if isinstance(at, str) and at in events:
        return Instant(float(T[events[at]]), events[at], NAMES[at])
    time = _in_t0(frames, at)
    if T[0] - ROUNDING <= time <= T[-1] + ROUNDING:
        return Instant(time, int(np.abs(T - time).argmin()), CHOSEN)
    names = ", ".join(f'"{event}"' for event in events) or "no events"
    ends = " to ".join(with_prefix(shifted(end, frames.attrs), "s") for end in (T[0], T[-1]))
    in_seconds = f" ({ends})" if "si_factor" in frames.attrs else ""
    span = f"{T[0]:.4g} to {T[-1]:.4g} t0{in_seconds}"
    raise ValueError(f"at = {at!r}: must be a time from {span} or an event of this run, which has {names}")


def moment_text(at: Any) -> float | str | None:
    """A moment as a number or a text, also where it is a quantity of ertel or of pint."""
    if hasattr(at, "units"):
        return f"{si_numbers(at, TIME.in_si):.12g} s"
    moment: float | str | None = str(at) if isinstance(at, Quantity) else at
    return moment


def _in_t0(frames: xr.DataArray, at: float | str) -> float:
    """T of a moment, where maps are kept at these times; NaN of a text that is not a time."""
    with suppress(ValueError):
        return float(at)
    try:
        seconds = in_si(at, TIME.in_si)
    except ValueError:
        return nan
    about = frames.attrs
    if "si_factor" not in about:
        raise ValueError(f"at = {at!r}: the case is dimensionless; give a time in t0, a plain number")
    return float(seconds / about["si_factor"] + about.get("si_zero", 0.0))


# -- along a line -----------------------------------------------------------------------------------------------------


def profile(dataset: xr.Dataset, at: At = None, along: str = "x") -> xr.Dataset:
    """Film thickness, pressure and oil along a line through the centre, at a moment of a run in time.

    Between two maps they are interpolated linearly in time.  An axisymmetric run has the same line along x and y; a
    line contact has only that along x.

    dataset: a run, dimensionless as it is stored.  at: as of `moment_of`; of a steady contact it is left out.  along:
    "x" or "y".  Raises ValueError where the direction is not one of these, or the run does not have it or this moment.

    The variables are h, p and h_oil over x or y in SI, with the scalar t of a run in time; of a dimensionless case H, P
    and oil over X or Y, with time.  The attribute `moment` says in words where it was taken.
    """
    if along not in ALONG:
        raise ValueError(f'along = {along!r}: must be "x" or "y"')
    axis, other = ALONG[along]
    if along == "y" and is_line(dataset.attrs):
        raise ValueError('along = "y": nothing of a line contact changes along y; leave it out for the profile along x')
    fields, moment = fields_at(dataset, ON_A_LINE, at)
    if "r" in fields.coords:
        line = _through_centre(fields.load(), axis)
    else:
        line = fields.load().interp({other: 0.0}) if other in fields.coords else fields.load()
    line = line.drop_vars([other, "frame"], errors="ignore").assign_attrs(dataset.attrs, moment=moment)
    return to_si(line) if "si_factor" in line["H"].attrs else line


def fields_at(dataset: xr.Dataset, names: Sequence[str], at: At) -> tuple[xr.Dataset, str]:
    """The fields with these names that a run has, at a moment as of `moment_of`, and the moment in words."""
    dataset = with_clock(dataset)
    fields = dataset[[name for name in names if name in dataset]]
    if is_without_moments(dataset, at):
        return fields, "steady contact"
    return _at(fields, moment_of(dataset, at))


def _at(fields: xr.Dataset, moment: Instant) -> tuple[xr.Dataset, str]:
    """The fields at a moment, between two maps interpolated, and the moment in words."""
    frame = fields["frame"]
    T, unit = frame.values, frame.attrs.get("si_units", "")

    def text(time: float) -> str:
        return with_prefix(shifted(time, frame.attrs), unit) if unit else f"{time:.4g} t0"

    if abs(T[moment.frame] - moment.T) <= ROUNDING:
        now, words = fields.isel(frame=moment.frame), f"{moment.name} at {text(moment.T)}"
    else:
        first = int(np.searchsorted(T, moment.T)) - 1
        now = between(fields, moment.T).isel(frame=0)
        words = f"{text(moment.T)}, between the maps at {text(T[first])} and {text(T[first + 1])}"
    return now.assign_coords(time=((), moment.T, frame.attrs)), words


def between(dataset: xr.Dataset, T: float) -> xr.Dataset:
    """A run in time with one map, at T (t0): between the two maps around it each field is interpolated linearly."""
    first = int(np.clip(np.searchsorted(dataset["frame"], T) - 1, 0, dataset.sizes["frame"] - 2))
    return dataset.isel(frame=slice(first, first + 2)).load().interp(frame=[T])


def mirrored(values: Values, odd: bool = False) -> Values:
    """A radial profile and its mirror image, along the last axis; odd: with the sign changed."""
    left = values[..., :0:-1]
    return np.concatenate([-left if odd else left, values], axis=-1)


def _through_centre(fields: xr.Dataset, axis: str) -> xr.Dataset:
    """Radial profiles as they are along a diameter."""
    about = VARIABLES[axis]
    words = {"long_name": about.long_name, "symbol": about.symbol}
    words |= {"si_name": about.si_name} if "si_factor" in fields["r"].attrs else {}
    line = {name: ((axis,), mirrored(values.values), values.attrs) for name, values in fields.data_vars.items()}
    place = ((axis,), mirrored(fields["r"].values, odd=True), {**fields["r"].attrs, **words})
    return xr.Dataset(line, {axis: place, **{name: c for name, c in fields.coords.items() if not c.dims}})


def write_profile(dataset: xr.Dataset, directory: Path, at: At = None, along: str = "x") -> tuple[Path, str]:
    """Write a `profile` as CSV; its path, and the moment in words.

    The columns are named with their unit, x_m, h_m, p_Pa, h_oil_m, t_s; without SI they are X, H, P, oil, time.
    """
    line = profile(dataset, at, along)
    directory.mkdir(parents=True, exist_ok=True)
    when = "" if at is None else "_" + "".join(c if c.isalnum() or c in ".-" else "_" for c in str(at))
    path = directory / f"profile_{along}{when}.csv"
    with_units(line).to_dataframe().to_csv(path)
    return path, str(line.attrs["moment"])
