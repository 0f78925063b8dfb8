"""The moment of a run in time that a picture shows, and the mid-line profiles through time."""

from dataclasses import dataclass

import numpy as np
import xarray as xr

from ertel.plots.drawing import At, NoFigure, Values, scale
from ertel.results.variables import EVENTS, with_prefix

MAXIMUM, LAST, END, CHOSEN = "maximum approach", "last map", "end of the run", "chosen map"
NAMES = {"max-approach": MAXIMUM, "end": END}
ROUNDING = 1e-9  # t0
NOTHING = 1e-6  # of the scale of a load or a speed


@dataclass(frozen=True)
class Profiles:
    """Film and pressure along the mid-line through time: P, H of shape (frames, x), dimensionless."""

    x: Values
    T: Values
    P: Values
    H: Values
    chosen: int  # the frame that is shown
    moment: str  # what it is: MAXIMUM, LAST, END or CHOSEN
    turning: int | None  # the frame of maximum approach, if there is one

    @property
    def time(self) -> float:
        """T of the frame that is shown."""
        return float(self.T[self.chosen])


def profiles_of(dataset: xr.Dataset, at: At = None) -> Profiles:
    """The mid-line, Y = 0 of a map or a radius and its mirror image, and the frame that is asked for.

    at: a time in t0 (the map next to it is taken) or an event, "max-approach" or "end"; by default maximum approach, or
    the last map where there is none.

    Raises NoFigure, a ValueError, where there is no map yet, and for a time or an event that the run has not.
    """
    T = np.asarray(dataset["frame"].values)
    if not len(T):
        raise NoFigure("dataset: has no maps yet, there is nothing to draw")
    chosen, moment = _choose(dataset, at)
    if "r" in dataset:
        x, P, H = (_mirrored(dataset[name].values, odd=name == "r") for name in ("r", "P", "H"))
    else:
        x = np.asarray(dataset["X"].values)
        P, H = (dataset[name].sel(Y=0.0, method="nearest").values for name in ("P", "H"))
    return Profiles(x, T, P, H, chosen, moment, _events(dataset).get("max-approach"))


def _choose(dataset: xr.Dataset, at: At) -> tuple[int, str]:
    """The frame, and what it is called."""
    T, events = np.asarray(dataset["frame"].values), _events(dataset)
    if at is None:
        return (events["max-approach"], MAXIMUM) if "max-approach" in events else (len(T) - 1, LAST)
    if isinstance(at, str):
        if at in events:
            return events[at], NAMES[at]
    elif T[0] - ROUNDING <= at <= T[-1] + ROUNDING:
        return int(np.abs(T - at).argmin()), CHOSEN
    known = ", ".join(f'"{event}"' for event in events) or "no events"
    span = f"{T[0]:.4g} to {T[-1]:.4g} t0"
    raise NoFigure(f"at = {at!r}: must be a time from {span} or an event of this run, which has {known}")


def _events(dataset: xr.Dataset) -> dict[str, int]:
    """The frames of the events by name."""
    codes = dataset["event"].values
    return {EVENTS[code]: int(np.flatnonzero(codes == code)[0]) for code in sorted({int(c) for c in codes}) if code}


def _mirrored(values: Values, odd: bool) -> Values:
    left = values[..., :0:-1]
    return np.concatenate([-left if odd else left, values], axis=-1)


def entrainment(dataset: xr.Dataset, T: float) -> float:
    """U at T; zero where the run does not tell."""
    return _at(dataset, "U", T) if "U" in dataset else 0.0


def heading(dataset: xr.Dataset, p: Profiles) -> list[str]:
    """What is shown: the moment, and the load and the speed of that moment."""
    time = scale(dataset, "time", 1.0)
    parts = [f"{p.moment} at {time.symbol} = {p.time * time.factor:.4g} {time.unit}"]
    if "F" in dataset:
        parts.append(f"load {shown(dataset, 'F', _at(dataset, 'F', p.time))}")
    if "U" in dataset and np.any(dataset["U"].values):
        parts.append(f"speed {shown(dataset, 'U', entrainment(dataset, p.time))}")
    return parts


def _at(dataset: xr.Dataset, name: str, T: float) -> float:
    return float(np.interp(T, dataset["time"].values, dataset[name].values))


def shown(dataset: xr.Dataset, name: str, value: float) -> str:
    """A value with its unit; nothing to speak of is zero."""
    value = 0.0 if abs(value) < NOTHING else value
    attributes = dataset[name].attrs
    if "si_factor" in attributes:
        return with_prefix(value * attributes["si_factor"], attributes["si_units"])
    return f"{value:.3g} {scale(dataset, name, 1.0).unit}"
