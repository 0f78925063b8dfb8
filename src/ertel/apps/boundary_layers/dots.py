"""Amplitude ratios A_d/A_i from the runs with waves, each with the parameter nabla2 of its place."""

from collections.abc import Iterator, Mapping
from typing import NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike

from ertel import Parameters, fronts, hertz, waves
from ertel.apps.boundary_layers.plans import Plan
from ertel.apps.boundary_layers.smooth import NAMES, Results, Values, radial_name
from ertel.apps.boundary_layers.waves import HEIGHT, impact_name, rolling_name, twin_name, wave_name

FILM, HALF_HERTZ, DRY = NAMES["film"], NAMES["half-hertz"], "dry law"  # the speeds of the front
SMALLEST_ERROR = 0.01  # of a ratio, in the fit: no ratio counts as more accurate


class Extrapolated(NamedTuple):
    """A value on two grids, the fine one with half the spacing."""

    coarse: float
    fine: float

    @property
    def limit(self) -> float:
        """The limit of a method of second order (Richardson)."""
        return self.fine + (self.fine - self.coarse) / 3

    @property
    def error(self) -> float:
        """The error bar: distance between this limit and that of a method of first order."""
        return 2 / 3 * abs(self.fine - self.coarse)

    def columns(self) -> dict[str, float]:
        """Columns of a data file."""
        return {"coarse": self.coarse, "fine": self.fine, "limit": self.limit, "error": self.error}

    def cells(self) -> dict[str, str]:
        """Cells of a table."""
        return {"A_d/A_i coarse": f"{self.coarse:.3f}", "fine": f"{self.fine:.3f}", "extrapolated": self.text()}

    def text(self) -> str:
        """The limit with its error bar."""
        return f"{self.limit:.3f} ± {self.error:.3f}"


# -- impact -----------------------------------------------------------------------------------------------------------


class Dot(NamedTuple):
    """One wave in an impact: A_d/A_i at X.

    local: local nabla2 by the speed of the front, for FILM, HALF_HERTZ and DRY.  hertz: that of FILM with the Hertz
    contact of the moment when the front passed.  everywhere: the global nabla2.  last: whether it is the last wave.
    """

    M: float
    L: float
    wavelength: float
    X: float
    ratio: Extrapolated
    local: Mapping[str, float]
    hertz: float
    everywhere: float
    last: bool


def dots(results: Results, plan: Plan) -> Iterator[Dot]:
    """Each complete wave inside the contact, from the centre outwards."""
    for (M, L), wavelengths in plan.waves.impacts.items():
        smooth = results[radial_name(M, L, plan)]
        front, by_pressure = fronts.front(smooth), fronts.front(smooth, "half-hertz")
        grids = [results[impact_name(M, L, nodes)] for nodes in plan.waves.grids]
        for wavelength in wavelengths:
            found = [_waves(grid, wavelength, float(front.A[-1])) for grid in grids]
            pairs = list(zip(*(each[::-1] for each in found), strict=False))  # from the edge inwards
            for number, (coarse, fine) in reversed(list(enumerate(pairs))):
                yield _dot(M, L, wavelength, coarse, fine, front, by_pressure, last=number == 0)


def _waves(data: xr.Dataset, wavelength: float, edge: float) -> list[waves.Wave]:
    response = data.sel(wave=wave_name(HEIGHT, wavelength))
    return waves.waves(response["X"].values, response["dH"].values, edge)


def _dot(
    M: float,
    L: float,
    wavelength: float,
    coarse: waves.Wave,
    fine: waves.Wave,
    front: fronts.Front,
    by_pressure: fronts.Front,
    last: bool,
) -> Dot:
    p, X = Parameters.from_moes(M, L), fine.X
    speeds = {FILM: front.speed_at(X), HALF_HERTZ: by_pressure.speed_at(X), DRY: hertz.front_speed(X)}
    local = {name: float(waves.local_nabla2(p, wavelength, speed)) for name, speed in speeds.items()}
    then = float(waves.local_nabla2(p, wavelength, speeds[FILM], X))
    ratio = Extrapolated(coarse.amplitude, fine.amplitude)
    return Dot(M, L, wavelength, X, ratio, local, then, p.nabla2(wavelength), last)


# -- rolling ----------------------------------------------------------------------------------------------------------


class Rolled(NamedTuple):
    """A rolling contact over waves."""

    M: float
    L: float
    wavelength: float
    nabla2: float
    ratio: Extrapolated


class Twin(NamedTuple):
    """An impact's wave at X, and rolling at the parameters of the front as it passed there."""

    M: float
    L: float
    wavelength: float
    X: float
    nabla2: float
    impact: Extrapolated
    rolling: Extrapolated


def rolled_over(results: Results, plan: Plan) -> Iterator[Rolled]:
    """The rolling contacts."""
    for (M, L), wavelengths in plan.waves.rolling.items():
        grids = [results[rolling_name(M, L, nodes)] for nodes in plan.waves.rolling_grids]
        for wavelength, coarse, fine in zip(wavelengths, *grids, strict=True):
            nabla2 = Parameters.from_moes(M, L).nabla2(wavelength)
            yield Rolled(M, L, wavelength, nabla2, Extrapolated(coarse, fine))


def curve_of(rolled: list[Rolled]) -> waves.Reduction:
    """The curve of the form of (15) fitted to the rolling contacts, each weighted by its error bar."""
    errors = [max(r.ratio.error, SMALLEST_ERROR) for r in rolled]
    return waves.fit_reduction([r.nabla2 for r in rolled], [r.ratio.limit for r in rolled], errors)


def twins_of(impacts: list[Dot], results: Results, plan: Plan) -> Iterator[Twin]:
    """The rolling twins, each with the wave of the impact that is nearest to its place."""
    for M, L, wavelength, X in plan.waves.twins:
        own = [dot for dot in impacts if (dot.M, dot.L, dot.wavelength) == (M, L, wavelength)]
        nearest = min(own, key=lambda dot: abs(dot.X - X))
        (_, coarse), (nabla2, fine) = (
            results[twin_name(M, L, wavelength, X, nodes)] for nodes in plan.waves.twin_grids
        )
        yield Twin(M, L, wavelength, nearest.X, nabla2, nearest.ratio, Extrapolated(coarse, fine))


# -- deviation from a curve -------------------------------------------------------------------------------------------


class Scatter(NamedTuple):
    """Deviation of A_d/A_i from a curve: mean and root mean square."""

    mean: float
    rms: float

    def text(self) -> str:
        """A cell of a table."""
        return f"{self.mean:+.3f}, {self.rms:.3f}"


def scatter(values: ArrayLike, curve: Values) -> Scatter:
    """Deviation of values from a curve, both (n,)."""
    off = np.asarray(values) - curve
    return Scatter(float(off.mean()), float(np.sqrt(np.mean(off**2))))
