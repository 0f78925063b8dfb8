"""A run as an instrument shows it, beside what was measured: light, and values whose zero, scale or place is unknown.

An interferometer measures the optical path n h and an intensity, in arbitrary units, of a place whose zero it does not
know.  What is shown is

    factor computed(x - centre) + offset + tilt (x - mean x)

with the unknown parts for which the squares of the differences from the measured values are smallest.  The factor is
the gain of an intensity, n/n_assumed of a film that was computed with an assumed index of the oil, or
that of a film over the speed.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import inf
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from ertel.results.numbers import IN_SI, numbers
from ertel.results.profiles import profile
from ertel.results.study_table import counted
from ertel.results.variables import VARIABLES, Variable, names_where, shifted, to_si, with_clock, with_prefix

Values = NDArray[np.float64]
FACTORS, LEVELS = ("index", "factor", "gain"), ("offset", "background")  # one of each, by the quantity
SHIFTS = 401  # of the centre that are tried before the best is refined
START = "start"
STARTS = 21  # of a clock, the same
FAR = 0.5  # of the half width of the contact: a centre that is farther from where it is expected is doubted
LEAST = 1e-3  # of the ratio of measured to computed values: a factor is above zero, or fringes would be inverted
PLACES = 8001  # along a line, where its light is computed: fringes are finer than the grid
NOT_FULL = 0.01  # void, as a share of the gap, from which on the gap is not full


def light_along(line: xr.Dataset, case: Any, optics: Any) -> xr.DataArray:
    """The light that comes back along a line: intensity as an `optics.Interferometer` gives it, over x or y in m.

    line: see `results.profiles.profile`, in SI.  case: of the run.  Films are interpolated by a cubic spline, pressure
    and void linearly.
    """
    axis = str(line["h"].dims[0])
    there, h, p = (np.asarray(line[name].values) for name in (axis, "h", "p"))
    void = np.maximum(h - line["h_oil"].values, 0.0) if "h_oil" in line else np.zeros_like(h)
    x = np.linspace(there[0], there[-1], PLACES)
    density = np.asarray(case.lubricant.density(np.interp(x, there, p) / case.scales.p_h), dtype=np.float64)
    from scipy.interpolate import CubicSpline  # here and below: pictures do without 30 MB

    film = np.maximum(CubicSpline(there, h)(x), 0.0)
    missing = np.minimum(np.interp(x, there, np.where(void > NOT_FULL * h, void, 0.0)), film)
    about = {"long_name": "intensity", "symbol": "I", "units": "1"}
    place = {axis: (axis, x, line[axis].attrs)}
    return xr.DataArray(optics.intensity(film, density, missing), place, (axis,), attrs=about)


def as_shown(measured: Any, computed: Values) -> tuple[dict[str, float], Values]:
    """The unknowns of a measurement by name, and computed values as its instrument shows them with these."""
    ways = {name: computed for name in FACTORS} | {name: np.ones_like(measured.x) for name in LEVELS}
    ways["tilt"] = measured.x - measured.x.mean()
    names = [name for name in ways if name in measured.align]
    factor = next((name for name in names if name in FACTORS), "")
    shapes = np.reshape([ways[name] for name in names], (len(names), len(measured.x))).T
    scale = np.abs(shapes).max(axis=0)
    known = 0.0 if factor else computed
    A, b = shapes / scale * measured.weight[:, None], (measured.values - known) * measured.weight
    shares = np.linalg.lstsq(A, b)[0]
    if factor and shares[0] < (least := LEAST * float(np.abs(measured.values).max())):
        shares = np.array([least, *np.linalg.lstsq(A[:, 1:], b - least * A[:, 0])[0]])
    parts = dict(zip(names, (shares / scale).tolist(), strict=True))
    return parts, shapes @ (shares / scale) + known


def best_centre(measured: Any, there: Values, values: Values) -> float:
    """The shift that leaves the smallest squares, as far as the run reaches, which has these values there."""
    low, high = measured.x.max() - there[-1], measured.x.min() - there[0]
    if low >= high:  # the run is shorter than the measurement, of which the caller tells
        return 0.0

    def shown(centre: float) -> Values:
        return as_shown(measured, np.interp(measured.x - centre, there, values))[1]

    return best(lambda centre: squares(measured, shown(centre)), np.linspace(low, high, SHIFTS))


def squares(measured: Any, shown: Values) -> float:
    """The sum of the squares that shown values leave, in standard deviations where these are known."""
    return float(np.sum((measured.weight * (measured.values - shown)) ** 2))


def best(squares: Callable[[float], float], tried: Values) -> float:
    """The number, one of those that are tried or beside it, that leaves the smallest squares."""
    from scipy.optimize import minimize_scalar

    least = int(np.argmin([squares(number) for number in tried]))
    bounds = tried[max(least - 1, 0)], tried[min(least + 1, len(tried) - 1)]
    return float(minimize_scalar(squares, bounds=bounds, options={"xatol": 1e-6 * (tried[1] - tried[0])}).x)


def with_start(measured: Sequence[Any], result: Any) -> list[Any]:
    """Measurements of one clock with its start, which leaves the smallest squares of all of them together.

    Raises ValueError where the run is shorter than what is measured, or has no time.
    """
    if "frame" not in result.dataset.dims:
        raise ValueError(f"{measured[0].name}: has a clock to align, and a steady contact has no time")
    data, low, high = with_clock(result.dataset), -inf, inf
    for each in measured:
        axis = data["time" if each.kind == "history" else "frame"]  # a profile needs a map
        first, last = (shifted(float(T), axis.attrs) for T in (axis[0], axis[-1]))
        begins, ends = each.moments()
        low, high = max(low, ends - last), min(high, begins - first)
    if low > high:
        reach = [with_prefix(moment, "s") for moment in (begins, ends, first, last)]
        raise ValueError("{}: reaches from {} to {}, and the run only from {} to {}".format(each.name, *reach))

    def on(start: float) -> list[Any]:
        return [replace(m, start=start, align=[name for name in m.align if name != "start"]) for m in measured]

    def left(start: float) -> float:
        return sum(squares(m, m.predicted(result)) for m in on(start))

    return on(best(left, np.linspace(low, high, STARTS)))


# -- beside a run ------------------------------------------------------------------------------------------------------

INTENSITY = "intensity"
QUANTITIES: Mapping[str, Variable] = {  # by the names of the SI Dataset and of the summary
    **{variable.si_name or name: variable for name, variable in VARIABLES.items()},
    **{name: VARIABLES[name] for name in names_where(lambda v: not (v.over or v.at_moment))},
    INTENSITY: Variable("intensity", "I"),
}


CONDITIONS: Mapping[str, tuple[str, str]] = {  # over which curves are measured: the field of the case, and its SI unit
    "mean_speed": ("contact.mean_speed", "m/s"),
    "speed": ("contact.speed", "m/s"),  # of rolling the mean speed
    "slide_to_roll": ("contact.slide_to_roll", "1"),
    "temperature": ("lubricant.temperature", "K"),
    "load": ("contact.load", "N"),
}


def si_unit(quantity: str) -> str:
    """The SI unit of a quantity, "1" of a plain number.  Raises ValueError for a name that is not known."""
    if quantity in CONDITIONS:
        return CONDITIONS[quantity][1]
    if quantity not in QUANTITIES:
        raise ValueError(f"quantity = {quantity!r}: must be the name of a result, such as h, h_c, restitution")
    about = QUANTITIES[quantity]
    return about.si_units or (about.unit if about.unit in IN_SI else "1")


@dataclass(frozen=True, eq=False, repr=False)
class Comparison:
    """A measurement beside a run, in SI.

    Attributes
    ----------
    measurement : Measurement
        As it was given, see `measurements`, which makes this comparison.
    x : array (n,)
        Its places or times, aligned; zero of a number.
    measured, computed : array (n,)
        The values, aligned, and those of the run; of an intensity with the gain and the background of the measured one.
    shown : array (n,)
        The values of the run as the instrument shows them, beside the measured ones as they were given.
    shift : mapping
        What the alignment took off: "start" (s) of the clock, "centre" (m or s) of x, "offset" or "background" and
        "tilt" (per m or s) of the values; and their "gain", or the "index" of the oil that fits best.
    line : DataArray or None
        All that the run has along the line or through time, its attribute `moment` in words; None of a number.
    sigma : array (n,) or None
        The standard errors of the aligned values.
    """

    measurement: Any
    x: Values
    measured: Values
    computed: Values
    shown: Values
    shift: Mapping[str, float] = field(default_factory=dict)
    line: xr.DataArray | None = None
    sigma: Values | None = None

    @property
    def difference(self) -> Values:
        """Measured less computed, (n,)."""
        return self.measured - self.computed

    @property
    def rms(self) -> float:
        """The root mean square of the difference."""
        return float(np.sqrt(np.mean(self.difference**2)))

    @property
    def where(self) -> str:
        """The moment of a profile in words, "" of a history and of a number."""
        return "" if self.line is None else str(self.line.attrs["moment"])

    @property
    def text(self) -> str:
        """The rms difference in words, with its share of the mean."""
        share = self.rms / float(np.abs(self.computed).mean() or 1.0)
        return f"rms difference {with_prefix(self.rms, si_unit(self.measurement.quantity))} ({share:.1%} of the mean)"

    @property
    def aligned(self) -> str:
        """The values that the alignment took off, in words: "centre 5 µm; offset 20 nm"."""
        unit, along = si_unit(self.measurement.quantity), si_unit(self.measurement.axis)
        units = {"start": "s", "centre": along, "offset": unit, "tilt": f"{unit}/{along}"}
        return "; ".join(f"{name} {with_prefix(value, units.get(name, '1'))}" for name, value in self.shift.items())

    @property
    def warnings(self) -> list[str]:
        """The sentence on a centre that is far both from the zero of x and from the middle of what is measured."""
        m, centre = self.measurement, self.shift.get("centre", 0.0)
        if m.kind != "profile" or self.line is None:
            return []
        far, middle = FAR * self.line.attrs.get("a_m", np.inf), (m.x.min() + m.x.max()) / 2
        if min(abs(centre), abs(centre - middle)) <= far:
            return []
        off = f"more than {with_prefix(far, 'm')}, half of the contact's half width,"
        where = f"{off} from the zero of {m.axis} and from the middle of the measured places"
        return [f"{m.name}: the centre {with_prefix(centre, 'm')} is {where}: doubt the case, its oil first"]

    @property
    def in_words(self) -> str:
        """The comparison in a line: where, the difference, and what the alignment took off."""
        m, where = self.measurement, f", {self.where}" if self.where else ""
        about = f"{m.name}: {QUANTITIES[m.quantity].long_name}{where}: {self.text}, {counted(len(self.x), 'value')}"
        return f"{about}; {self.aligned}" if self.aligned else about

    def __repr__(self) -> str:
        return "\n".join([self.in_words, *(f"warning: {warning}" for warning in self.warnings)])


# -- the number, line or curve of runs in the place of a measurement, in SI -------------------------------------------


def number_of(measured: Any, result: Any) -> float:
    """The number of a run, in SI."""
    found = numbers(result.summary)
    table = found | {each.about.si_name: each for each in found.values() if each.about.si_name}
    if measured.quantity not in table:
        raise ValueError(f"{measured.quantity}: the run has no such number; it has {', '.join(table)}")
    number = table[measured.quantity]
    if number.factor is None and number.unit not in ("1", *IN_SI):
        raise ValueError(f"{measured.quantity}: the case is dimensionless, and the measurement is in SI")
    return number.in_si.value


def curve_over(measured: Any, result: Any) -> xr.DataArray:
    """The quantity over the condition of a curve, in SI: of a study, or of a list of runs at each x."""
    if isinstance(result, list):
        x, values = np.asarray(measured.x), np.array([number_of(measured, each) for each in result])
        about = {"long_name": QUANTITIES[measured.quantity].long_name, "units": si_unit(measured.quantity)}
    else:
        data = result.dataset
        axis = "mean_speed" if measured.axis == "speed" and "speed" not in data.coords else measured.axis
        if axis not in data.coords:
            what = ", ".join(map(str, data.coords)) or "nothing" if "status" in data else "nothing: it is one run"
            raise ValueError(
                f"{measured.name}: is a curve over {measured.axis}; compare it with a study; here varies {what}"
            )
        if several := [name for name in data.coords if name != axis and data[name].size > 1]:
            raise ValueError(f"{measured.name}: is one curve, and in the study {several[0]} varies, too")
        if measured.quantity not in data:
            raise ValueError(
                f"{measured.quantity}: the runs have no such number; they have {', '.join(map(str, data))}"
            )
        x, values, about = data[axis].values, data[measured.quantity].values.ravel(), data[measured.quantity].attrs
    order = np.argsort(x, kind="stable")
    order = order[np.isfinite(values[order])]
    if not len(order):
        raise ValueError(f"{measured.quantity}: no run has this number")
    about_x = {"units": si_unit(measured.axis), "long_name": measured.axis, "symbol": measured.axis}
    along = {measured.axis: (measured.axis, x[order], about_x)}
    return xr.DataArray(values[order], along, attrs={"symbol": measured.quantity, **about, "moment": ""})


def line_of(measured: Any, result: Any) -> xr.DataArray:
    """The quantity along the line of a profile, or through time, in SI."""
    data: xr.Dataset = result.dataset
    if measured.kind == "profile":
        data = profile(data, measured.at, measured.along)
    elif "time" in data.dims:
        data = data.drop_dims([name for name in data.dims if name != "time"])
        data = to_si(_from_the_start(with_clock(data))) if "si_factor" in data["time"].attrs else data
    else:
        raise ValueError(f"{measured.name}: is a history, and a steady contact has none")
    if measured.axis not in data.coords:
        raise ValueError(f"{measured.name}: is in SI, and the case is dimensionless")
    if measured.kind == "profile" and measured.quantity == INTENSITY:
        if measured.optics is None:
            raise ValueError(f"{measured.name}: is an intensity; give optics=ertel.optics.Interferometer(rig, light)")
        data = light_along(data, result.case, measured.optics).to_dataset(name=INTENSITY).assign_attrs(data.attrs)
    if measured.quantity not in data:
        raise ValueError(
            f"{measured.quantity}: the run has no such {measured.kind}; it has {', '.join(map(str, data))}"
        )
    return data[measured.quantity].assign_attrs(moment=data.attrs.get("moment", ""), a_m=data.attrs.get("a_m", np.inf))


def _from_the_start(history: xr.Dataset) -> xr.Dataset:
    """The history of a run from its start: before the first step it is as after it."""
    start = history.isel(time=[0]).assign_coords(time=("time", [0.0], history["time"].attrs))
    return xr.concat([start, history], "time") if float(history["time"][0]) > 0 else history
