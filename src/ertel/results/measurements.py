"""Measurements beside results: a film profile, a history or a number, in SI, and what a run has in their place.

A `Measurement` is read from a file or made of arrays.  It may be aligned: where its zero in place or time, its offset
or its tilt are not known, they are those for which the squares of the differences from the run are smallest.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from os import PathLike
from pathlib import Path
from typing import Any, Literal, get_args

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from ertel.physics.units import Unit, in_si
from ertel.results.columns import Columns
from ertel.results.numbers import IN_SI, numbers
from ertel.results.profiles import At, profile
from ertel.results.variables import OUTCOME, VARIABLES, Variable, to_si, with_prefix

Values = NDArray[np.float64]
Kind = Literal["profile", "history", "number"]
PLACES, TIME, SIGMA = ("x", "y", "r"), "t", "sigma"
USUAL = {"profile": "h", "history": "h_c"}  # quantities, of a file with several
ALIGNMENTS = ("centre", "offset", "tilt")
SHIFTS = 401  # of the centre that are tried before the best is refined
QUANTITIES: Mapping[str, Variable] = {  # by the names of the SI Dataset and of the summary
    **{variable.si_name or name: variable for name, variable in VARIABLES.items()},
    **{name: VARIABLES[name] for name in OUTCOME},
}


@dataclass(frozen=True, eq=False)
class Measurement:
    """A measured profile, history or number, in SI.

    Parameters
    ----------
    kind : "profile", "history" or "number"
        Over a place at a moment, over time, or one number.
    quantity : str
        Its name in the SI Dataset of a run, "h", "p", "h_c", or in its summary, "restitution", "contact_time", ...
    values : array
        The measured values, (n,).
    x : array, optional
        Places (m) or times (s), (n,); None of a number.
    sigma : float or array, optional
        Standard error of the values.
    at : float, str or Quantity, optional
        The moment of a profile, "60 us" or "max-approach", see `results.profiles.moment_of`.
    along : "x" or "y"
        The direction of a profile.
    align : sequence of str
        What is not known: "centre", a shift in place or time; "offset" of the values; "tilt", a slope of the values.
    name : str
        For messages and pictures.

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

    def __post_init__(self) -> None:
        values = np.atleast_1d(np.asarray(self.values, dtype=np.float64))
        x = np.zeros_like(values) if self.x is None else np.asarray(self.x, dtype=np.float64)
        sigma = np.asarray(1.0 if self.sigma is None else self.sigma, dtype=np.float64)
        align = (self.align,) if isinstance(self.align, str) else tuple(self.align)
        _unit(self.quantity)
        if unknown := [name for name in align if name not in ALIGNMENTS]:
            raise ValueError(f"align = {unknown[0]!r}: must be of {', '.join(ALIGNMENTS)}")
        if (self.x is None) != (self.kind == "number"):
            raise ValueError(f"x: must be {'left out of' if self.kind == 'number' else 'given for'} a {self.kind}")
        if values.shape != x.shape or values.ndim != 1 or sigma.shape not in ((), values.shape):
            raise ValueError(f"values: have the shape {values.shape}, x {x.shape}, sigma {sigma.shape}; must be alike")
        for name, value, allowed in (("kind", self.kind, get_args(Kind)), ("along", self.along, PLACES[:2])):
            if value not in allowed:
                raise ValueError(f"{name} = {value!r}: must be of {', '.join(allowed)}")
        if self.at is not None and self.kind != "profile":
            raise ValueError(f"at = {self.at!r}: {self.name} is a {self.kind}, without a moment; leave it out")
        if len(values) <= len(align):
            wanted = f"more than {len(align)}, the numbers to align" if align else "at least one row without a gap"
            raise ValueError(f"{self.name}: has {len(values)} values; must be {wanted}")
        if not np.all((sigma > 0) & np.isfinite(sigma)):
            raise ValueError(f"{self.name}: sigma has {np.min(sigma):g} (in SI); must be finite and above zero")
        if not (np.all(np.isfinite(values)) and np.all(np.isfinite(x))):
            raise ValueError(f"{self.name}: has values or x that are not finite")
        object.__setattr__(self, "values", values)
        object.__setattr__(self, "x", None if self.x is None else x)
        object.__setattr__(self, "align", align)

    @classmethod
    def number(cls, quantity: str, value: float | str, sigma: float | str | None = None) -> "Measurement":
        """The measurement of one number of a run.

        Parameters
        ----------
        quantity : str
            Its name in the summary: "restitution", "contact_time", "h_c", "mu_sliding", ...
        value : float or str
            In SI, or a text with a unit, "95 us".
        sigma : float or str, optional
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
        sigma: float | str | None = None,
        columns: Mapping[str, str] | None = None,
        **units: str,
    ) -> "Measurement":
        """A profile or a history from a file of columns: `Measurement.read("film.csv", x="um", h="nm", at="60 us")`.

        The file has a place x, y or r, or a time t, and a quantity by its name in the SI Dataset: h, p, h_c, ...  Units
        stand in the header, as "x_um", "x (um)", "x [um]" or "x/um", or are given.  A file without header has the
        columns that are given, in this order.  Rows with a gap are left out.

        Parameters
        ----------
        path : str or Path
            The file, see `results.columns`.
        at, along, align
            As of `Measurement`.
        sigma : float or str, optional
            Standard error, in SI or with a unit.  A column "sigma" goes before; without a unit it has that of the
            values.
        columns : mapping, optional
            The names in the header by the quantity, where they differ: {"x": "Position (um)", "h": "Film [nm]"}.
        **units : str
            Units of the columns by the quantity, x="um"; of several quantities in a file the one that is named here.

        Returns
        -------
        Measurement
            In the order of the places or times.

        Raises
        ------
        ValueError
            A column or a unit is missing; the message names the columns that there are.
        """
        if unknown := {*units, *(columns or {})} - {*QUANTITIES, SIGMA}:
            raise ValueError(
                f"{sorted(unknown)[0]}: must be the name of a place, a time or a result, such as x, t, h, h_c"
            )
        file = Columns.read(Path(path), {*QUANTITIES, SIGMA}, columns or {}, units)
        axis = next((name for name in (*PLACES, TIME) if name in file.texts), "")
        kind: Kind = "history" if axis == TIME else "profile"
        there = [name for name in file.texts if name not in (*PLACES, TIME, SIGMA)]
        given = [name for name in there if name in units or name in (columns or {})]
        name = next(iter([*given, *(name for name in there if name == USUAL[kind]), *there]), "")
        if not (axis and name):
            wanted = f"quantity such as {USUAL[kind]}" if axis else "place x, y or r and no time t"
            raise ValueError(
                f'{file.file}: has no {wanted}; {file.listed}; give columns={{"{USUAL[kind] if axis else "x"}": ...}}'
            )
        unit = _unit(name)
        rows = [file.values(axis, _unit(axis)), file.values(name, unit)]
        rows += [file.values(SIGMA, unit, file.units[name])] if SIGMA in file.texts else []
        whole = np.array(rows)[:, np.all(np.isfinite(rows), axis=0)]
        x, values, *errors = whole[:, np.argsort(whole[0], kind="stable")]
        error = errors[0] if errors else None if sigma is None else _in_si(name, sigma)
        return cls(kind, name, values, x, error, at, "y" if axis == "y" else along, align, file.file)

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
        """
        compared = self.compared(result)
        return self.values - compared.difference

    def compared(self, result: Any) -> "Comparison":
        """The measurement beside a run, aligned.  Parameters and errors are those of `predicted`."""
        if self.x is None:
            return Comparison(self, np.zeros(1), self.values, np.array([self._number(result)]))
        line, shift = self._line(result), {}
        there, values = line[self.axis].values, line.values
        if "centre" in self.align:
            shift["centre"] = self._best_centre(there, values)
        x = self.x - shift.get("centre", 0.0)
        if x.min() < there[0] or x.max() > there[-1]:
            ends = [with_prefix(end, _unit(self.axis)) for end in (x.min(), x.max(), there[0], there[-1])]
            raise ValueError("{}: reaches from {} to {}, and the run only from {} to {}".format(self.name, *ends))
        computed = np.interp(x, there, values)
        lines, difference = self._straightened(self.values - computed)
        return Comparison(self, x, computed + difference, computed, shift | lines, line)

    @property
    def axis(self) -> str:
        """The name of x: "x" or "y" of a profile, "t" of a history."""
        return TIME if self.kind == "history" else self.along

    def _number(self, result: Any) -> float:
        table = {
            name: each for each in numbers(result.summary).values() for name in (each.name, each.about.si_name) if name
        }
        if self.quantity not in table:
            raise ValueError(f"{self.quantity}: the run has no such number; it has {', '.join(table)}")
        number = table[self.quantity]
        if number.factor is None and number.unit not in ("1", *IN_SI):
            raise ValueError(f"{self.quantity}: the case is dimensionless, and the measurement is in SI")
        return number.value * (1.0 if number.factor is None else number.factor)

    def _line(self, result: Any) -> xr.DataArray:
        """The quantity along the line of a profile, or through time, in SI."""
        data: xr.Dataset = result.dataset
        if self.kind == "profile":
            data = profile(data, self.at, self.along)
        elif "time" in data.dims:
            data = data.drop_dims([name for name in data.dims if name != "time"])
            data = to_si(data) if "si_factor" in data["time"].attrs else data
        else:
            raise ValueError(f"{self.name}: is a history, and a steady contact has none")
        if self.axis not in data.coords:
            raise ValueError(f"{self.name}: is in SI, and the case is dimensionless")
        if self.quantity not in data:
            raise ValueError(f"{self.quantity}: the run has no such {self.kind}; it has {', '.join(map(str, data))}")
        return data[self.quantity].assign_attrs(moment=data.attrs.get("moment", ""))

    # -- alignment ----------------------------------------------------------------------------------------------------

    def _straightened(self, difference: Values) -> tuple[dict[str, float], Values]:
        """The offset and the tilt, as far as they are not known, that leave the smallest squares, and what is left."""
        assert self.x is not None
        ways = {"offset": np.ones_like(self.x), "tilt": self.x - self.x.mean()}  # the tilt is about the middle
        names = [name for name in ways if name in self.align]
        shapes = np.reshape([ways[name] for name in names], (len(names), len(self.x))).T
        scale = np.abs(shapes).max(axis=0)
        shares = np.linalg.lstsq(shapes / scale * self._weight[:, None], difference * self._weight)[0] / scale
        return dict(zip(names, shares.tolist(), strict=True)), difference - shapes @ shares

    @property
    def _weight(self) -> Values:
        return np.ones_like(self.values) / (1.0 if self.sigma is None else self.sigma)

    def _best_centre(self, there: Values, values: Values) -> float:
        """The shift that leaves the smallest squares, as far as the run reaches, which has these values there."""
        x = self.x
        assert x is not None
        low, high = x.max() - there[-1], x.min() - there[0]
        if low >= high:  # the run is shorter than the measurement, of which the caller tells
            return 0.0

        from scipy.optimize import minimize_scalar  # here: pictures do without its 16 MB

        def squares(centre: float) -> float:
            _, difference = self._straightened(self.values - np.interp(x - centre, there, values))
            return float(np.sum((self._weight * difference) ** 2))

        tried = np.linspace(low, high, SHIFTS)
        best, step = tried[np.argmin([squares(each) for each in tried])], (high - low) / (SHIFTS - 1)
        bounds = max(low, best - step), min(high, best + step)
        return float(minimize_scalar(squares, bounds=bounds, options={"xatol": 1e-6 * step}).x)


@dataclass(frozen=True, eq=False, repr=False)
class Comparison:
    """A measurement beside a run, in SI.

    Attributes
    ----------
    measurement : Measurement
        As it was given.
    x : array (n,)
        Its places or times, aligned; zero of a number.
    measured, computed : array (n,)
        The values, aligned, and those of the run.
    shift : mapping
        What the alignment took off: "centre" (m or s) of x, "offset" and "tilt" (per m or s) of the values.
    line : DataArray or None
        All that the run has along the line or through time, its attribute `moment` in words; None of a number.
    """

    measurement: Measurement
    x: Values
    measured: Values
    computed: Values
    shift: Mapping[str, float] = field(default_factory=dict)
    line: xr.DataArray | None = None

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
        return f"rms difference {with_prefix(self.rms, _unit(self.measurement.quantity))} ({share:.1%} of the mean)"

    def __repr__(self) -> str:
        m = self.measurement
        units = {"centre": _unit(m.axis), "offset": _unit(m.quantity), "tilt": f"{_unit(m.quantity)}/{_unit(m.axis)}"}
        shift = "".join(f"; {name} {with_prefix(value, units[name])}" for name, value in self.shift.items())
        where = f", {self.where}" if self.where else ""
        return f"{m.name}: {QUANTITIES[m.quantity].long_name}{where}: {self.text}, {len(self.x)} values{shift}"


def _unit(quantity: str) -> str:
    """The SI unit of a quantity, "1" of a plain number.  Raises ValueError for a name that is not known."""
    if quantity not in QUANTITIES:
        raise ValueError(f"quantity = {quantity!r}: must be the name of a result, such as h, h_c, restitution")
    about = QUANTITIES[quantity]
    return about.si_units or (about.unit if about.unit in IN_SI else "1")


def _in_si(quantity: str, value: float | str) -> float:
    unit = _unit(quantity)
    is_number = unit == "1" or not isinstance(value, str)
    try:
        return float(value) if is_number else in_si(value, Unit(unit, f"1 {unit}", True))
    except ValueError as error:
        raise ValueError(f"{quantity} = {value!r}: {error}") from error
