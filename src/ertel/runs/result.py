"""The result of a run, with text and notebook output, values in SI, and pictures; and its outcome in one line."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from html import escape
from pathlib import Path
from types import MethodType
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from ertel.case.case import Case
from ertel.case.status import Status
from ertel.physics.amplitude_reduction import lambda_ratio
from ertel.physics.units import ROUGHNESS, in_si, plain
from ertel.results.alignment import Comparison
from ertel.results.figures import FIGURES_IN_TIME, FIGURES_STEADY, figures_of, is_line
from ertel.results.measurements import Measurement
from ertel.results.numbers import Number, html_image, lines, numbers, plus_minus, values_of
from ertel.results.profiles import At, moment_of, profile
from ertel.results.stress import stress
from ertel.results.variables import prefixed, to_si

if TYPE_CHECKING:  # matplotlib is imported when there is something to draw
    from matplotlib.figure import Figure

PHYSICAL = ("interferogram", "measured")  # of a case in SI; a line contact has no interferogram
Sigma = float | str | None  # rms roughness in m, or with a unit


@dataclass(frozen=True, repr=False)
class Plot:
    """The pictures of a run, each a matplotlib Figure: `plot.film(at="max-approach")` is `ertel.plots.film` of the run.

    `at` selects the time in a transient run: a time in t0 or "95 us", or an event, "max-approach" or "end"; see
    `ertel.plots`.  Raises ValueError for a picture or a time that the run does not have.
    """

    dataset: xr.Dataset

    def __getattr__(self, name: str) -> "Callable[..., Figure]":
        if name not in {*FIGURES_IN_TIME, *FIGURES_STEADY, *PHYSICAL}:
            raise AttributeError(f"Plot: has no picture {name!r}; it has {', '.join(self._names())}")
        from ertel import plots

        return MethodType(getattr(plots, name), self.dataset)

    def _names(self) -> tuple[str, ...]:
        names, more = figures_of(self.dataset), PHYSICAL[is_line(self.dataset.attrs) :]
        return (*names, *more) if "si_factor" in self.dataset["H"].attrs else names

    def __dir__(self) -> Iterable[str]:
        return [*self._names(), "dataset"]

    def __repr__(self) -> str:
        return "Plot: " + ", ".join(f"{name}()" for name in self._names())


class Summary(dict[str, Any]):
    """A summary: a plain dict with all results; its text shows only the key numbers."""

    def __repr__(self) -> str:
        return "\n".join([f"Summary: {self['status']}", *lines(self)])


@dataclass(frozen=True, repr=False, eq=False)
class Result:
    """The result of a run.

    Parameters
    ----------
    case : Case
        The case of the run.
    dataset : xarray.Dataset
        Scalars and fields, dimensionless; `si` is the same in SI.
    summary : mapping
        The outcome as plain data, see `results.summary`; it shows its key numbers only.
    status : Status
        How the run ended; `status.ok` says whether it converged.
    directory : Path, optional
        Where the run is stored.
    """

    case: Case
    dataset: xr.Dataset
    summary: dict[str, Any]
    status: Status
    directory: Path | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "summary", Summary(self.summary))

    @property
    def si(self) -> xr.Dataset:
        """The Dataset in SI units under SI names (h_c for H_c, t for time).  Raises ValueError if dimensionless."""
        return to_si(self.dataset)

    @property
    def track(self) -> list[list[float | str]] | float | str:
        """The oil that a rolling contact leaves behind, at its end: points [y, thickness], in SI texts with a unit.

        It is the `layer` of the contact that follows on this track: `ertel.rolling(..., layer=result.track)`.  The oil
        of both surfaces is taken together.  A line contact leaves one thickness behind.  Raises ValueError for an
        impact and a run that failed.
        """
        if not self.status.ok:
            raise ValueError(f"track: the run ended with status {self.status.value!r} and leaves none")
        if self.case.starts_apart:
            raise ValueError("track: the run is an impact; a rolling contact leaves a track behind")
        oil = self.dataset["oil"] if self.case.is_steady else self.dataset["oil"].isel(frame=-1)
        end = 0.0 if self.case.is_steady else float(self.dataset["time"][-1])
        outlet = oil.isel(X=-1 if self.case.motion.entrainment(end) >= 0 else 0)
        scales = self.case.scales
        if self.case.geometry.is_line:
            return f"{float(outlet) * scales.film!r} m" if scales else float(outlet)
        points = np.transpose([outlet["Y"].values, outlet.values]).tolist()
        return [[f"{y * scales.a!r} m", f"{oil * scales.film!r} m"] for y, oil in points] if scales else points

    def profile(self, at: At = None, along: str = "x") -> xr.Dataset:
        """Film thickness, pressure and oil along a line through the centre, in SI; see `results.profiles.profile`."""
        return profile(self.dataset, at, along)

    def stress(self, at: At = None, body: int = 1, depths: Any = None, along: str | None = "x") -> xr.Dataset:
        """The stresses in a body below the film, by its pressure and its shear stress; see the page on stresses.

        Parameters
        ----------
        at : float, str or Quantity, optional
            The moment of a run in time, as for a `profile`.
        body : 1 or 2
            Body 1 has the speed u1; in an impact it is the ball.
        depths : lengths, optional
            In m or with a unit; without dimensions in a.  Left out: to 1.5 half widths of the contact.
        along : "x", "y" or None
            A section through the centre along x or y, or None for all nodes.

        Returns
        -------
        xarray.Dataset
            sigma_xx, ... sigma_yz (tension is positive), von_mises and shear, the largest shear stress of all planes,
            over depth and place; in SI where the case is, or else in p_h and a.  Without dimensions a/R is not known,
            and they are those of the pressure alone.

        Raises
        ------
        ValueError
            Another body, direction or depth, or a moment that the run does not have or at which it carries no load.
        """
        return stress(self.case, self.dataset, at, body, depths, along)

    def compare(self, measurement: Measurement) -> Comparison:
        """The run beside a measurement: aligned values, their difference and its rms; see `Measurement.predicted`."""
        if not isinstance(measurement, Measurement):
            raise TypeError(f"measurement = {measurement!r}: must be a Measurement, such as Measurement.read gives")
        return measurement.compared(self)

    def lambda_ratio(self, sigma_1: Sigma = None, sigma_2: Sigma = None) -> float:
        """The lambda ratio of a physical run: its film over the rms roughness of both surfaces together.

        With roughness that is given, here or in [surfaces] of the case, the film is the minimum film thickness, the
        warm and extrapolated one.  Without any the roughness is that of the case, measured maps and rough surfaces by
        their rms.  The grid of such a run has their valleys and summits, and its film is the (warm) mean, weighted
        with the pressure, at maximum approach or at the end.

        Parameters
        ----------
        sigma_1, sigma_2 : float or str, optional
            Rms roughness of the surfaces, in m or with a unit, "20 nm", or "Ra 16 nm"; one that is left out is smooth.

        Returns
        -------
        float
            Lambda, dimensionless.

        Raises
        ------
        ValueError
            The case is dimensionless, the run has no film, or there is no roughness.
        """
        scales, table = self.case.scales, numbers(self.summary)
        minimum = table.get("H_min_warm") or table.get("H_min")
        if scales is None or minimum is None:
            raise ValueError(f"lambda ratio: {'the run has no film' if scales else 'the case is dimensionless'}")
        given = [sigma for sigma in (sigma_1, sigma_2) if sigma is not None]
        if not given and self.case.sigma:
            given = [self.case.sigma]
        if given:
            if not minimum.known:
                raise ValueError("lambda ratio: the minimum film is not known, its error is too large; use more nodes")
            return lambda_ratio(minimum.in_si.value, *(_sigma(sigma) for sigma in given))
        own = _rms(self.case)
        if not own:
            why = "the roughness of the case has no rms" if self.case.features else "the surfaces are smooth"
            raise ValueError(f"sigma_1: missing; {why}")
        data = self.dataset[["H", "P"]]
        data = data if self.case.is_steady else data.isel(frame=moment_of(self.dataset).frame)
        return lambda_ratio(self.summary.get("phi_T", 1.0) * float(np.average(data["H"], weights=data["P"])), *own)

    @property
    def verdict(self) -> str:
        """The outcome in one line; see `runs.result.verdict`."""
        return verdict(self)

    @property
    def plot(self) -> Plot:
        """The pictures of the run: `result.plot.overview()`, `result.plot.film(at="max-approach")`, ..."""
        return Plot(self.dataset)

    @property
    def warnings(self) -> list[str]:
        """Warnings about the grid, the domain or the inlet, with advice."""
        return list(self.summary["warnings"])

    def __repr__(self) -> str:
        stored = [f"  stored in {self.directory}"] if self.directory else []
        title = f"{self.case.name}, " if self.case.name else ""
        return "\n".join([f"Result: {title}{self.status.value}", *lines(self.summary), *stored])

    def _repr_html_(self) -> str:
        return f"<pre>{escape(repr(self))}</pre>{html_image(self.plot.overview, 'overview')}"


# -- in one line -------------------------------------------------------------------------------------------------------


def verdict(result: Result, *sigma: Sigma) -> str:
    """The outcome in one line, with what the run has: "film 341 ± 15 nm, Lambda = 1.9, mu = 0.047, 11 K".

    The film is the central one, with heat the warm one, and its error that of the discretisation.  K is the rise of the
    mean temperature of the film above the inlet.  sigma: as of `Result.lambda_ratio`.  Empty where the run has no
    values.
    """
    table = numbers(result.summary)
    if not values_of(result.summary):
        return ""
    parts = [f"{'warm ' * ('H_c_warm' in table)}film {_film(table.get('H_c_warm') or table['H_c'])}"]
    known = (table.get("H_min_warm") or table["H_min"]).known
    if sigma or (result.case.scales and known and (result.case.sigma or _rms(result.case))):
        parts.append(f"Lambda = {result.lambda_ratio(*sigma):.2g}")
    friction = table.get("mu_sliding_warm") or table.get("mu_sliding")
    if friction and friction.unit == "1" and abs(friction.value) > 0:
        parts.append(f"mu = {abs(friction.value):.3g}")
    parts += [f"restitution {table['restitution'].value:.3f}"] if "restitution" in table else []
    if "T_film_mean" in table and result.case.thermal:
        parts.append(f"{table['T_film_mean'].value - result.case.thermal.temperature:.3g} K")
    return ", ".join(parts)


def _sigma(given: float | str) -> float:
    try:
        return in_si(given, ROUGHNESS)
    except ValueError as error:
        raise ValueError(f"sigma = {str(given)!r}: {error}") from error


def _rms(case: Case) -> list[float]:
    """The rms of the rough surfaces of a case, in a^2/R."""
    found = [getattr(feature.shape, "rms", None) for feature in case.features]
    return [plain(rms) for rms in found if rms]


def _film(film: Number) -> str:
    if not film.known:
        return "not known"
    film = film.in_si
    one, name = prefixed(film.unit, film.value)
    return f"{plus_minus(film.value / one, (film.error or 0.0) / one)} {name}"
