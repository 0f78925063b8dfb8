"""A run at the moment that a picture shows: its values, scales and words for the panels."""

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from math import isnan
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike

from ertel.case.case import Case
from ertel.case.height_map import HeightMap
from ertel.numerics.grid import Extrapolation, on_grids
from ertel.physics import surfaces
from ertel.physics.geometry import Geometry
from ertel.plots.drawing import NoFigure, Scale, Values
from ertel.results.alignment import NOT_FULL, Comparison
from ertel.results.dataset import maps_of
from ertel.results.figures import figures_of, is_line
from ertel.results.numbers import UNKNOWN, plus_minus
from ertel.results.parameters import geometry_of
from ertel.results.profiles import At, is_without_moments, mirrored, moment_of
from ertel.results.variables import COEFFICIENT, FILMS, names_where, with_clock, with_prefix

MARGIN, WIDEST = 1.3, 2.0  # of what is shown round the contact, at most so many half widths from its centre
LOADED = 0.02  # of the maximum pressure or load: with less the film carries nothing
CROPPED = 0.1  # of the maximum pressure: as much may lie where the inlet is cut, so that the contact is in the middle
LONG = 2.0  # ratio of the sides from which a contact is long
THINNER = 0.9  # of the film at the ends of a run: a thinner film between them is worth the picture
NOTHING = 1e-6  # of the scale of a load or a speed
SMOOTH = 1e-9  # a*^2/R: less roughness is round-off
NO_FRICTION = 1e-12  # in a/R: a coefficient that is zero but for round-off
CONDITIONS = {  # by kind, for the heading of a physical case: symbol, attribute of the Dataset, unit
    "impact": (("$v_0$", "v0_m_per_s", "m/s"), ("$p_h^*$", "p_h_Pa", "Pa")),
    "rolling": (("$u_m$", "u_m_m_per_s", "m/s"), ("$F$", "F_N", "N"), ("$p_h$", "p_h_Pa", "Pa")),
}


def case_of(dataset: xr.Dataset) -> Case:
    """The case that is stored with a Dataset.  Raises ValueError where it could not be written down."""
    if "case" not in dataset.attrs:
        raise ValueError(f"dataset: does not hold its case; {dataset.attrs.get('case_not_written', 'no reason given')}")
    return _read_case(dataset.attrs["case"], tuple(maps_of(dataset).items()))


@lru_cache(maxsize=4)
def _read_case(written: str, maps: tuple[tuple[str, HeightMap], ...]) -> Case:
    return Case.from_data(json.loads(written), dict(maps))


def name_of(attributes: Mapping[str, Any]) -> str:
    """The name of a case for a heading, from the attributes of its Dataset."""
    name = str(attributes["title"]).partition(", M = ")[0].replace("_", " ")  # a case without name has M and L there
    return name[:1].upper() + name[1:]


def field(x: Values, y: Values, values: Values) -> xr.DataArray:
    """A variable over the surface, (Y, X)."""
    return xr.DataArray(values, {"Y": y, "X": x}, ("Y", "X"))


def conditions_in_si(attributes: Mapping[str, Any], hidden: Sequence[str] = ()) -> list[str]:
    """Radius, speed, load and pressure of a physical case, but for hidden attributes; none of a dimensionless one."""
    named = [("$R$", "R_m", "m"), *CONDITIONS[attributes["kind"]]] if "R_m" in attributes else []
    return [f"{symbol} = {with_prefix(attributes[key], unit)}" for symbol, key, unit in named if key not in hidden]


class Limits(NamedTuple):
    """The same for all maps of a movie: the value at the top of its colours, and how far it reaches along x (a*)."""

    top: float
    side: float


@dataclass(frozen=True)
class View:
    """A run, and the map of it that is shown.

    frame: the number of the map; None of a steady contact.  moment: its name, such as maximum approach or last map.
    measured: profiles that are drawn beside those of the run.  limits: of the maps of a movie.  beside: another run;
    the panels of both have equal scales.
    """

    dataset: xr.Dataset
    frame: int | None = None
    moment: str = ""
    measured: tuple[Comparison, ...] = ()
    limits: Limits | None = None
    beside: "View | None" = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "dataset", with_clock(self.dataset))

    @classmethod
    def of(cls, dataset: xr.Dataset, at: At = None) -> "View":
        """The view of a run at a moment, see `results.profiles.moment_of`; the map next to it is taken.

        Raises NoFigure where there is nothing to draw yet, or no such moment.
        """
        try:
            if is_without_moments(dataset, at):
                return cls(dataset)
            moment = moment_of(dataset, at)
        except ValueError as error:
            raise NoFigure(str(error)) from error
        if at is None and (thinnest := _thinnest(dataset)):
            return cls(dataset, thinnest, "thinnest film")
        return cls(dataset, moment.frame, moment.name)

    # -- properties of the run ----------------------------------------------------------------------------------------

    @cached_property
    def case(self) -> Case:
        """The case of the run."""
        return case_of(self.dataset)

    @property
    def in_si(self) -> bool:
        """True if the run has SI scales."""
        return "si_factor" in self.dataset["H"].attrs

    @property
    def is_radial(self) -> bool:
        """True if the run is axisymmetric, with a radius in place of X and Y."""
        return "r" in self.dataset

    @property
    def geometry(self) -> Geometry:
        """The dry contact and its directions."""
        return geometry_of(self.dataset.attrs)

    @property
    def stretch(self) -> float:
        """The ratio of the lengths of the dry contact along y and along x."""
        along, across = self.geometry.extent
        return across / along

    @property
    def is_turned(self) -> bool:
        """True if maps are turned by a quarter, x downwards and y to the right, since the contact is long along y."""
        return self.stretch > LONG

    @property
    def slides(self) -> bool:
        """True if the surfaces slide."""
        return self.case.motion.slides

    # -- scales and words ---------------------------------------------------------------------------------------------

    def scale(self, name: str, largest: float | None = None) -> Scale:
        """The scale of a variable whose largest value, as stored, is given; left out, that of 1, or of all times."""
        largest = self.largest(name, _longest if name == "time" else lambda _: 1.0) if largest is None else largest
        return Scale.of(self.variable(name), largest, self.dataset.attrs["kind"])

    def largest(self, name: str, of: "Callable[[View], float] | None" = None) -> float:
        """The largest of a value that is found in a view: of this run, and of that beside it in units of this one.

        name: of a variable with the same units.  of: left out, the largest of the variable at the moment.
        """
        of = of or (lambda view: float(view.values(name).max()))
        if self.beside is None or (name == "time" and self.beside.frame is None):
            return of(self)
        here, there = (each.variable(name).attrs.get("si_factor", 1.0) for each in (self, self.beside))
        return max(of(self), of(self.beside) * there / here)

    def variable(self, name: str) -> xr.DataArray:
        """A variable of the Dataset; "X" also where that is a radius."""
        return self.dataset["r" if self.is_radial and name == "X" else name]

    @property
    def across(self) -> Scale:
        """The scale of distances along the surface."""
        return self.scale("X")

    def axis_label(self, axis: str) -> str:
        """The label of distances along "x" or "y"."""
        return f"${axis if self.in_si else axis.upper()}$ ({self.across.unit})"

    def legend(self, name: str) -> str:
        """A film or a pressure for a legend beside an axis that names it: minimum, and its symbol."""
        shown = self.scale(name)
        return f"{shown.long_name.split()[0]} {shown.symbol}"

    def with_unit(self, name: str, value: float) -> str:
        """A value of a variable with its unit; a negligible value is zero."""
        value = 0.0 if abs(value) < NOTHING else value
        z = self.scale(name, value)
        return f"{value * z.factor:.4g} {z.unit}".rstrip()

    @property
    def title(self) -> list[str]:
        """The name of the run, then its conditions."""
        about = self.dataset.attrs
        conditions = [f"$M$ = {about['M']:.4g}", f"$L$ = {about['L']:.3g}"]
        if self.geometry.is_line:
            length = f", {with_prefix(2 * about['a_y_m'], 'm')} long" if "a_y_m" in about else ""
            conditions.append(f"line contact{length}")
        elif "radius_ratio" in about:
            conditions.append(f"$R_x/R_y$ = {about['radius_ratio']:.3g}")
        if about.get("entrainment_angle"):
            conditions.append(f"angle {about['entrainment_angle']:.3g}°")
        if about["kind"] == "rolling" and self.slides and self.case.motion.keeps_ratio:
            conditions.append(f"slide-to-roll {self.case.motion.slide_to_roll:.3g}")
        return [name_of(about), *conditions_in_si(about), *conditions]

    @property
    def outcome(self) -> list[str]:
        """The films of a steady contact with their errors; of a run in time the moment, its load and its speed."""
        if self.frame is None:
            return [self._film_with_error(name) for name in FILMS]
        parts = [f"{self.moment} at {self.clock}"]
        if "F" in self.dataset:
            parts.append(f"load {self.with_unit('F', self.value('F'))}")
        if "U" in self.dataset and np.any(self.dataset["U"].values):
            parts.append(f"speed {self.with_unit('U', self.flow)}")
        return parts

    @property
    def clock(self) -> str:
        """The time of the map, as t = 60 µs."""
        time = self.scale("time")
        return f"{time.symbol} = {time.shown(self.time):.4g} {time.unit}"

    @property
    def friction(self) -> list[str]:
        """The coefficients of friction of a steady contact that are not zero, and its power loss."""
        coefficients = names_where(lambda variable: variable.scale == COEFFICIENT and variable.over == "step")
        there = [name for name in (*coefficients, "power_loss") if name in self.dataset]
        last = {name: float(self.dataset[name][-1]) for name in there}
        shown = {name: each for name, each in last.items() if name == "power_loss" or abs(each) > NO_FRICTION}
        return [f"{self.dataset[name].attrs['long_name']} {self.with_unit(name, each)}" for name, each in shown.items()]

    def _film_with_error(self, name: str) -> str:
        """A film, extrapolated, as h_c = 146 ± 10 nm: as many digits as the error deserves; or that it is not known."""
        film = self.on_grids(name)[-1]
        best = film.value if isnan(film.extrapolated) else film.extrapolated
        z = self.scale(name, best)
        if film.error > UNKNOWN * best:
            return f"{z.symbol} not known"
        return f"{z.symbol} = {plus_minus(best * z.factor, film.error * z.factor)} {z.unit}"

    def on_grids(self, name: str) -> list[Extrapolation]:
        """A value of a steady contact on every grid with its estimated error, which the coarsest does not have."""
        return on_grids(self.dataset[name].values.tolist(), regular=not self.case.layer)

    # -- values at the moment -----------------------------------------------------------------------------------------

    @property
    def time(self) -> float:
        """T of the map; 0 of a steady contact."""
        return 0.0 if self.frame is None else float(self.dataset["frame"].values[self.frame])

    def value(self, name: str) -> float:
        """A number at the moment of a run in time."""
        return float(np.interp(self.time, self.dataset["time"].values, self.dataset[name].values))

    @property
    def flow(self) -> float:
        """The entrainment; of a steady contact +1 where the oil goes to the right."""
        if self.frame is not None:
            return self.value("U") if "U" in self.dataset else 0.0
        loaded = (self.dataset["P"] > 0).any([axis for axis in self.dataset["P"].dims if axis != "X"])
        X = self.dataset["X"].values  # pressure reaches far upstream, and ends soon behind the contact
        return -float(np.sign(np.mean(X[loaded.values])))

    def values(self, name: str) -> Values:
        """A variable over the grid; "void" is the part of the gap without oil, zero where that is less than 1 %."""
        if name == "void":
            H = self.values("H")
            void = H - self.values("oil") if "oil" in self.dataset else np.zeros_like(H)
            return np.where(void > NOT_FULL * H, void, 0.0)
        return np.asarray(self._now[name].values)

    @cached_property
    def _now(self) -> xr.Dataset:
        """The maps at the moment; those of other moments stay on the disk where the Dataset was opened so."""
        axis = self.dataset["P"].dims[-1]
        maps = self.dataset[[name for name, each in self.dataset.items() if axis in each.dims]]
        return (maps if self.frame is None else maps.isel(frame=self.frame)).load()

    @property
    def x(self) -> Values:
        """The positions along the mid-line, Y = 0; of an axisymmetric run a radius and its mirror image."""
        return mirrored(self.dataset["r"].values, odd=True) if self.is_radial else np.asarray(self.dataset["X"].values)

    def midlines(self, name: str) -> Values:
        """A variable along the mid-line; in a run in time of all maps, (frames, x)."""
        return mirrored(self._along_x[name].values) if self.is_radial else np.asarray(self._along_x[name].values)

    @cached_property
    def _along_x(self) -> xr.Dataset:
        fields = self.dataset[["H", "P"]]
        return (fields.sel(Y=0.0, method="nearest") if "Y" in fields.dims else fields).load()

    def midline(self, name: str) -> Values:
        """A variable along the mid-line at the moment."""
        values = self.midlines(name)
        return values if self.frame is None else values[self.frame]

    def map(self, name: str) -> xr.DataArray:
        """A variable over the surface, (Y, X); a radial profile is turned round the centre."""
        values, data = self.values(name), self.dataset
        if not self.is_radial:
            require_maps(data, name)
            return field(data["X"].values, data["Y"].values, values)
        r = np.asarray(data["r"].values)
        x = np.linspace(-r[-1], r[-1], 601)
        return field(x, x, np.interp(np.hypot(x[:, None], x[None, :]), r, values))

    def extent(self, x: Values, P: Values, margin: float = MARGIN) -> float:
        """The distance from the centre up to which a profile along x is shown."""
        side, end = min(margin * reach(x, P), WIDEST * self.geometry.extent[0]), min(-float(x[0]), float(x[-1]))
        hidden = P[np.abs(x) > end].max(initial=0.0) if margin == MARGIN else P.max()
        return min(side, end) if hidden < CROPPED * P.max() else side  # as far to both sides

    def film_inside(self) -> float:
        """The maximum film thickness well inside the contact, along the mid-line."""
        x, P, H = self.x, self.midline("P"), self.midline("H")
        return float(H[np.abs(x) < 0.8 * min(reach(x, P), self.geometry.extent[0])].max())

    def roughness(self, X: ArrayLike, Y: ArrayLike) -> Values:
        """The height of the roughness (a*^2/R) at X, Y (a*), which broadcast, positive towards the film.

        As on the grid of the run, without the waves that are too short for it; zero where it is but round-off.
        """
        grid = self.dataset.coords
        shortest = surfaces.CELLS_KEPT * float(grid["X"][1] - grid["X"][0]) if "X" in grid else 0.0
        case = self.case
        heights = surfaces.height(case.features, case.motion, self.time, np.asarray(X), np.asarray(Y), shortest)
        heights = np.asarray(heights, dtype=np.float64)
        return heights if np.abs(heights).max(initial=0.0) > SMOOTH else np.zeros_like(heights)


def require_maps(dataset: xr.Dataset, name: str) -> None:
    """Raise NoFigure for a line contact.  name: of what needs a map."""
    if is_line(dataset.attrs):
        raise NoFigure(f"{name}: a line contact has no maps; it has {', '.join(figures_of(dataset))}")


def _thinnest(dataset: xr.Dataset) -> int | None:
    """The map with the thinnest film of a rolling contact in time, where it is clearly thinner than at both ends."""
    films = np.asarray(np.interp(dataset["frame"], dataset["time"], dataset["H_min"]))
    thin = dataset.attrs["kind"] == "rolling" and films.min() < THINNER * min(films[0], films[-1])
    return int(films.argmin()) if thin else None


def _longest(view: View) -> float:
    """The time of a run that is the farthest from t = 0."""
    times = view.dataset["time"]
    return float(np.abs(times - times.attrs.get("si_zero", 0.0)).max())


def reach(x: Values, P: Values) -> float:
    """The distance from the centre up to which a profile carries pressure."""
    loaded = x[LOADED * P.max() < P]
    farthest = float(np.abs(loaded).max()) if len(loaded) else float(x.max())
    return max(farthest, 0.2 * float(x.max()))  # something to see even at first touch


def of_two(runs: Sequence[xr.Dataset], at: Sequence[At]) -> tuple[View, View]:
    """Two runs at their moments, each beside the other; in SI, or without their SI scales where one has none."""
    one, two = (View.of(run, moment) for run, moment in zip(runs, at, strict=True))
    if not (one.in_si and two.in_si):
        one, two = (replace(view, dataset=_without_si(view.dataset)) for view in (one, two))
    return replace(one, beside=two), replace(two, beside=one)


def _without_si(dataset: xr.Dataset) -> xr.Dataset:
    """A run whose variables have no SI scales."""
    bare = dataset.copy()
    for variable in bare.variables.values():
        variable.attrs = {key: value for key, value in variable.attrs.items() if not key.startswith("si_")}
    return bare
