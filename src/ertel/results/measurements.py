"""Measurements beside results: a film profile, a history or a number, in SI, and what a run has in their place.

A `Measurement` is read from a file or made of arrays.  It may be aligned: where its zero in place or time, its offset,
its tilt or the index of the oil are not known, they are those for which the squares of the differences from the run are
smallest; see `alignment`.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from difflib import get_close_matches
from os import PathLike
from pathlib import Path
from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from ertel.case.reading import hint_for
from ertel.physics.units import Quantity, Unit, in_si, si_numbers
from ertel.results import alignment
from ertel.results.alignment import CONDITIONS, INTENSITY, QUANTITIES, Comparison, si_unit, squares
from ertel.results.columns import Columns
from ertel.results.profiles import At, moment_text
from ertel.results.variables import with_prefix

Values = NDArray[np.float64]
Size = float | str | Quantity  # in SI, or with a unit
Kind = Literal["profile", "history", "curve", "number"]
PLACES, TIME, SIGMA = ("x", "y", "r"), "t", "sigma"
READ = ("at", "start", "along", "align", "sigma", "index")  # what a file takes beside units, and a number
CLOCK = Unit("s", "60 us", signed=True)
NUMBER = ("quantity", "value", "sigma")
USUAL = {"profile": "h", "history": "h_c", "curve": "h_c"}  # quantities, of a file with several
ALIGNMENTS = ("start", "centre", "offset", "tilt", "index")
OF_CURVES = ("offset", "factor", "index")
ALWAYS_ALIGNED = ("gain", "background")  # of an intensity
INDICES = np.linspace(0.95, 1.05, 41)  # over that of the rig, which are tried
FILMS = ("h", "h_c", "h_min", "h_oil")  # that can have an index
NOT_BELOW_ZERO = (*FILMS, "contact_time", "restitution")  # unless the zero is not known


@dataclass(frozen=True, eq=False)
class Measurement:
    """A measured profile, history or number, in SI.

    Parameters
    ----------
    kind : "profile", "history", "curve" or "number"
        Over a place at a moment, over time, over a condition of several runs, or one number.
    quantity : str
        Its name in the SI Dataset of a run, "h", "p", "h_c", or in its summary, "restitution", "contact_time", ...; or
        "intensity", of light, in arbitrary units.
    values : array
        The measured values, (n,).
    x : array, optional
        Places (m), times (s) or values of the condition, (n,); None of a number.
    sigma : float or array, optional
        Standard error of the values.
    at : float, str or Quantity, optional
        The moment of a profile, "60 us" from the first touch or "max-approach", see `results.profiles.moment_of`.
    along : "x" or "y"
        The direction of a profile; of a curve its condition: "mean_speed", "speed" (of rolling the mean speed, too),
        "slide_to_roll", "load" or "temperature".
    align : sequence of str
        What is not known: "start" of the clock; "centre", a shift in place or time; "offset" of the values; "tilt", a
        slope of them; "factor", of the values of a curve; "index" of the oil, of an intensity within 5 %.  Its "gain"
        and "background" are never known.
    name : str
        For messages and pictures.
    index : float, optional
        The index of the oil with which films were computed from fringes; to align "index".
    optics : Interferometer, optional
        The rig and the light of an intensity: `ertel.optics.Interferometer(rig, light)`.
    start : float, str or Quantity
        The reading of the instrument's clock at the first touch, t = 0 of a run in SI.

    Raises
    ------
    ValueError
        The lengths differ, a value is not finite, or a name is not known.
    """

    kind: Kind
    quantity: str
    values: Values
    x: Values | None = None
    sigma: float | Values | None = None
    at: At = None
    along: str = "x"
    align: Sequence[str] = ()
    name: str = "measurement"
    index: float | None = None
    optics: Any = None
    start: Any = 0.0

    def __post_init__(self) -> None:
        si_unit(self.quantity)
        values = np.atleast_1d(np.asarray(_in_si(self.quantity, self.values), dtype=np.float64))
        x = np.zeros_like(values) if self.x is None else np.asarray(_in_si(self.axis, self.x), dtype=np.float64)
        if self.sigma is not None:
            object.__setattr__(self, "sigma", _in_si(self.quantity, self.sigma))
        object.__setattr__(self, "start", float(_in_si(TIME, self.start)))
        sigma = np.asarray(1.0 if self.sigma is None else self.sigma, dtype=np.float64)
        axes = (*CONDITIONS,) if self.kind == "curve" else PLACES[:2]
        for name, value, allowed in (("kind", self.kind, get_args(Kind)), ("along", self.along, axes)):
            if value not in allowed:
                raise ValueError(f"{name} = {value!r}: must be of {', '.join(allowed)}")
        align = (self.align,) if isinstance(self.align, str) else tuple(self.align)
        light = self.quantity == INTENSITY
        possible: Sequence[str] = OF_CURVES if self.kind == "curve" else ALIGNMENTS
        possible = ("start", "centre", "tilt", "index", *ALWAYS_ALIGNED) if light else possible
        if unknown := [name for name in align if name not in possible]:
            raise ValueError(f"align = {unknown[0]!r}: {hint_for(unknown[0], possible)}")
        align = (*align, *(name for name in ALWAYS_ALIGNED if light and name not in align))
        if "index" in align and not light and (self.quantity not in FILMS or self.index is None):
            raise ValueError(f"index = {self.index}: must be the index with which {self.name}, a film, was computed")
        if self.index is not None and not 1.0 < self.index < 3.0:
            raise ValueError(f"index = {self.index:g}: must be above 1 and below 3; oils have 1.4 to 1.7")
        if (self.x is None) != (self.kind == "number"):
            raise ValueError(f"x: must be {'left out of' if self.kind == 'number' else 'given for'} a {self.kind}")
        if values.shape != x.shape or values.ndim != 1 or sigma.shape not in ((), values.shape):
            raise ValueError(f"values: have the shape {values.shape}, x {x.shape}, sigma {sigma.shape}; must be alike")
        if self.at is not None and self.kind != "profile":
            raise ValueError(f"at = {self.at!r}: {self.name} is a {self.kind}, without a moment; leave it out")
        if len(values) <= len(align):
            wanted = f"more than {len(align)}, the numbers to align" if align else "at least one row without a gap"
            raise ValueError(f"{self.name}: has {len(values)} values; must be {wanted}")
        if not np.all((sigma > 0) & np.isfinite(sigma)):
            raise ValueError(f"{self.name}: sigma has {np.min(sigma):g} (in SI); must be finite and above zero")
        if not (np.all(np.isfinite(values)) and np.all(np.isfinite(x))):
            raise ValueError(f"{self.name}: has values or x that are not finite")
        _check_possible(self.name, self.quantity, values, align)
        object.__setattr__(self, "values", values)
        object.__setattr__(self, "x", None if self.x is None else x)
        object.__setattr__(self, "align", align)
        object.__setattr__(self, "at", moment_text(self.at))
        if self.start or "start" in align:
            self.moments()  # raises where it has no clock

    @classmethod
    def number(cls, quantity: str, value: Size, sigma: Size | None = None) -> "Measurement":
        """The measurement of one number of a run.

        Parameters
        ----------
        quantity : str
            Its name in the summary: "restitution", "contact_time", "h_c", "mu_sliding", ...
        value : float, str or Quantity
            In SI, or a text with a unit, "95 us".
        sigma : float, str or Quantity, optional
            Its standard error, in the same way.

        Returns
        -------
        Measurement
            Of kind "number".

        Raises
        ------
        ValueError
            There is no such number, or the unit does not fit.
        """
        found, error = _in_si(quantity, value), None if sigma is None else _in_si(quantity, sigma)
        return cls("number", quantity, np.array([found]), sigma=error, name=quantity)

    @classmethod
    def read(
        cls,
        path: str | PathLike[str],
        *,
        at: At = None,
        along: str = "x",
        align: Sequence[str] = (),
        sigma: Size | None = None,
        index: float | None = None,
        optics: Any = None,
        start: Any = 0.0,
        **units: str,
    ) -> "Measurement":
        """A measurement from a file of columns: `Measurement.read("film.csv", x="um", h="nm", at="60 us")`.

        The file has a place x, y or r, a time t or a condition such as mean_speed, and a quantity by its name in the SI
        Dataset: h, p, h_c, ..., or intensity, whose unit does not count.  Units stand in the header, as "x_um",
        "x (um)", "x [um]" or "x/um", in a row below it, or are given.  A file without header has the columns that are
        given, in this order.  Rows with a gap are left out.

        Parameters
        ----------
        path : str or Path
            The file, see `results.columns`.
        at, along, align, index, optics, start
            As of `Measurement`.
        sigma : float, str or Quantity, optional
            Standard error, in SI or with a unit.  A column "sigma" goes before; without a unit it has that of the
            values.
        **units : str
            Units of the columns by the quantity, x="um", their names in the header, x="Radius [um]", or both,
            x="Radius=um"; of several quantities in a file the one that is named here.

        Returns
        -------
        Measurement
            In the order of the places or times.

        Raises
        ------
        ValueError
            There is no such file; a column or a unit is missing, and the message names the columns that there are; a
            value cannot be.
        """
        if unknown := sorted({*units} - {*QUANTITIES, *CONDITIONS, SIGMA}):
            close = get_close_matches(unknown[0], [*QUANTITIES, SIGMA, *READ], n=1, cutoff=0.85)
            advice = f"did you mean {close[0]}? " if close else ""
            raise ValueError(
                f"{unknown[0]}: {advice}must be the name of a place, a time or a result, such as x, t, h, h_c"
            )
        file = Columns.read(Path(path), {*QUANTITIES, *CONDITIONS, SIGMA}, units)
        axis = next((name for name in (*PLACES, TIME, *CONDITIONS) if name in file.texts), "")
        kind: Kind = "history" if axis == TIME else "curve" if axis in CONDITIONS else "profile"
        there = [name for name in file.texts if name not in (*PLACES, TIME, SIGMA, axis)]
        given = [name for name in there if name in units]
        name = next(iter([*given, *(name for name in there if name == USUAL[kind]), *there]), "")
        if not (axis and name):
            wanted = f"quantity such as {USUAL[kind]}" if axis else "place x, y or r and no time t"
            raise ValueError(f'{file.file}: has no {wanted}; {file.listed}; give {USUAL[kind] if axis else "x"}="NAME"')
        unit = si_unit(name)
        if name == INTENSITY:  # in arbitrary units
            file = replace(file, units={**file.units, INTENSITY: "", SIGMA: ""})
        rows = [file.values(axis, si_unit(axis)), file.values(name, unit)]
        rows += [file.values(SIGMA, unit, file.units[name])] if SIGMA in file.texts else []
        _check_possible(file.file, name, rows[1], align, file.lines)
        whole = np.array(rows)[:, np.all(np.isfinite(rows), axis=0)]
        x, values, *errors = whole[:, np.argsort(whole[0], kind="stable")]
        error = errors[0] if errors else None if sigma is None else _in_si(name, sigma)
        along = axis if axis == "y" or kind == "curve" else along
        name = "h_c" if kind == "curve" and name == "h" else name
        return cls(kind, name, values, x, error, at, along, align, file.file, index, optics, start)

    # -- beside a run -------------------------------------------------------------------------------------------------

    def predicted(self, result: Any) -> Values:
        """The values of a run in the place of the measured ones.

        A profile is interpolated linearly along the line and between maps, a history between steps.  Where the
        measurement is to be aligned they are as its instrument would show them: moved, offset and tilted so that the
        squares of the differences are smallest.

        Parameters
        ----------
        result : Result
            A run.

        Returns
        -------
        array (n,)
            In SI, one for each measured value.

        Raises
        ------
        ValueError
            The run is dimensionless, does not have this quantity or moment, or does not reach as far.
        TypeError
            The result is not one.
        """
        return self.compared(result).shown

    def compared(self, result: Any) -> Comparison:
        """The measurement beside a run, aligned.  Parameters and errors are those of `predicted`.

        A curve is compared with a study, or with the results of runs at each of its x.
        """
        if not (hasattr(result, "dataset") or (self.kind == "curve" and isinstance(result, list))):
            raise TypeError(f"result = {result!r}: must be the Result of a run")
        if self.x is None:
            value = np.array([alignment.number_of(self, result)])
            return Comparison(self, np.zeros(1), self.values, value, value)
        if "start" in self.align:
            return replace(alignment.with_start([self], result)[0].compared(result), measurement=self)
        if self.start:
            x = self.x - self.start if self.kind == "history" else self.x
            found = replace(self, x=x, at=self.moment, start=0.0).compared(result)
            return replace(found, measurement=self, shift={"start": self.start, **found.shift})
        if self.quantity == INTENSITY and self.optics and "index" in self.align:
            return self._with_best_index(result)
        line = alignment.curve_over(self, result) if self.kind == "curve" else alignment.line_of(self, result)
        there, values = line[self.axis].values, line.values
        shift = {"centre": alignment.best_centre(self, there, values)} if "centre" in self.align else {}
        x = self.x - shift.get("centre", 0.0)
        if x.min() < there[0] or x.max() > there[-1]:
            ends = [with_prefix(end, si_unit(self.axis)) for end in (x.min(), x.max(), there[0], there[-1])]
            raise ValueError("{}: reaches from {} to {}, and the run only from {} to {}".format(self.name, *ends))
        powers = self.kind == "curve" and bool(np.all(there > 0) and np.all(values > 0))  # straight in logarithms
        log, power = (np.log, np.exp) if powers else (np.asarray, np.asarray)
        at_x: Any = power(np.interp(log(x), log(there), log(values)))
        parts, shown = alignment.as_shown(self, at_x)
        factor = parts.get("index", parts.get("factor", 1.0))
        if "gain" in parts:  # an intensity stays in the units in which it was measured
            at_x, line = (parts["gain"] * each + parts["background"] for each in (at_x, line))
        elif "index" in parts:
            parts["index"] *= self.index or 1.0
        sigma = None if self.sigma is None else np.ones_like(x) * self.sigma / factor
        return Comparison(self, x, at_x + (self.values - shown) / factor, at_x, shown, shift | parts, line, sigma)

    def _with_best_index(self, result: Any) -> Comparison:
        """The comparison of an intensity with the index of the oil, about that of the rig, that fits best."""

        def compared(index: float) -> Comparison:
            optics = replace(self.optics, rig=replace(self.optics.rig, oil_index=index))
            return replace(self, optics=optics, align=[each for each in self.align if each != "index"]).compared(result)

        index = alignment.best(lambda n: squares(self, compared(n).shown), self.optics.rig.oil_index * INDICES)
        found = compared(index)
        return replace(found, measurement=self, shift={**found.shift, "index": index})

    def moments(self) -> tuple[float, float]:
        """The first and the last time (s) by its clock.  Raises ValueError where it has none."""
        if self.kind == "history":
            return float(np.min(self.x)), float(np.max(self.x))  # type: ignore[arg-type]
        try:
            moment = float(in_si(self.at if isinstance(self.at, str) else "", CLOCK))
        except ValueError as error:
            wanted = "needs a moment at = with a unit, such as 60 us, by the instrument's clock"
            raise ValueError(f"start: {self.name}, at = {self.at!r}, {wanted}") from error
        return moment, moment

    @property
    def moment(self) -> At:
        """The moment of a profile by the clock of the run, as far as the start is known."""
        return f"{self.moments()[0] - self.start!r} s" if self.start and self.kind == "profile" else self.at

    @property
    def weight(self) -> Values:
        """1/sigma of each value; one where that is not known."""
        return np.ones_like(self.values) / (1.0 if self.sigma is None else self.sigma)

    @property
    def axis(self) -> str:
        """The name of x: "x" or "y" of a profile, "t" of a history, the condition of a curve."""
        return TIME if self.kind == "history" else self.along if self.kind in ("profile", "curve") else "x"


def _check_possible(name: str, quantity: str, values: Values, align: Sequence[str], lines: Sequence[int] = ()) -> None:
    """Raise ValueError for a film or a time below zero, unless the zero is not known.  lines: in the file of a name."""
    below = np.flatnonzero(values < 0.0)
    if len(below) and quantity in NOT_BELOW_ZERO and not {"offset", "tilt"} & {*align}:
        where = f"{name}, line {lines[below[0]]}" if lines else name
        allowed = "must not be below zero" + ("; its zero may be aligned, offset" if quantity in FILMS else "")
        raise ValueError(f"{where}: {quantity} = {with_prefix(float(values[below[0]]), si_unit(quantity))}: {allowed}")


def _in_si(quantity: str, value: Any) -> Any:
    """A value or an array of a quantity in SI."""
    unit, value = si_unit(quantity), str(value) if isinstance(value, Quantity) else value
    try:
        return (
            float(value) if unit == "1" and isinstance(value, str) else si_numbers(value, Unit(unit, f"1 {unit}", True))
        )
    except ValueError as error:
        raise ValueError(f"{quantity} = {str(value)[:60]!r}: {error}") from error
