"""The outcome of a run in one line: film with its error, lambda ratio, friction, restitution, heat."""

import numpy as np

from ertel.case.case import Case
from ertel.physics.amplitude_reduction import lambda_ratio
from ertel.physics.units import RMS, in_si, plain
from ertel.results.measurements import Outcome
from ertel.results.numbers import Number, numbers, plus_minus, values_of
from ertel.results.profiles import moment_of
from ertel.results.variables import PREFIXES, exponent

Sigma = float | str | None  # rms roughness in m, or with a unit


def lambda_of(result: Outcome, sigma_1: Sigma = None, sigma_2: Sigma = None) -> float:
    """The lambda ratio of a physical run: its film over the rms roughness of both surfaces together.

    With roughness that is given the film is the minimum film thickness of the run.  Without it the roughness is that of
    the case, measured maps and rough surfaces by their rms.  The grid of such a run has their valleys and summits, and
    its film is the mean, weighted with the pressure, at maximum approach or at the end.

    Parameters
    ----------
    result : Result
        A run of a physical case.
    sigma_1, sigma_2 : float or str, optional
        Rms roughness of the surfaces, in m or with a unit, "20 nm"; one that is left out is smooth.

    Returns
    -------
    float
        Lambda, dimensionless.

    Raises
    ------
    ValueError
        The case is dimensionless, the run has no film, or there is no roughness.
    """
    scales, table = result.case.scales, numbers(result.summary)
    if scales is None or "H_min" not in table:
        raise ValueError(f"lambda ratio: {'the case is dimensionless' if scales is None else 'the run has no film'}")
    given = [sigma for sigma in (sigma_1, sigma_2) if sigma is not None]
    if given:
        return lambda_ratio(table["H_min"].value * scales.film, *(_sigma(sigma) for sigma in given))
    own = _rms(result.case)
    if not own:
        raise ValueError("sigma_1: missing; the surfaces of the case are smooth, or have no rms")
    data = result.dataset[["H", "P"]]
    data = data if result.case.is_steady else data.isel(frame=moment_of(result.dataset).frame)
    return lambda_ratio(float(np.average(data["H"], weights=data["P"])), *own)


def verdict(result: Outcome, *sigma: Sigma) -> str:
    """The outcome in one line, with what the run has: "film 341 ± 15 nm, Lambda = 1.9, mu = 0.047, 11 K".

    The film is the central one, with heat the warm one, and its error that of the discretisation.  K is the rise of the
    mean temperature of the film above the inlet.

    Parameters
    ----------
    result : Result
        A run.
    *sigma : float or str
        Rms roughness of the surfaces as of `lambda_of`; left out: that of the case, if it has one.

    Returns
    -------
    str
        Empty where the run has no values.
    """
    table = numbers(result.summary)
    if not values_of(result.summary):
        return ""
    parts = [f"film {_film(table.get('h_c_warm') or table['H_c'])}"]
    if sigma or (result.case.scales and _rms(result.case)):
        parts.append(f"Lambda = {lambda_of(result, *sigma):.2g}")
    friction = table.get("mu_sliding_warm") or table.get("mu_sliding")
    if friction and friction.unit == "1" and abs(friction.value) > 0:
        parts.append(f"mu = {abs(friction.value):.3g}")
    parts += [f"restitution {table['restitution'].value:.3f}"] if "restitution" in table else []
    thermal, data = result.summary.get("thermal"), result.case.thermal
    if thermal and data:
        parts.append(f"{thermal['T_film_mean_K'] - data.temperature:.3g} K")
    return ", ".join(parts)


def _sigma(given: Sigma) -> float:
    try:
        return in_si(given, RMS.in_si)
    except ValueError as error:
        raise ValueError(f"sigma = {str(given)!r}: {error}") from error


def _rms(case: Case) -> list[float]:
    """The rms of the rough surfaces of a case, in a^2/R."""
    found = [getattr(feature.shape, "rms", None) for feature in case.features]
    return [plain(rms) for rms in found if rms]


def _film(film: Number) -> str:
    factor, unit = film.factor or 1.0, film.unit if film.factor is None else film.si_units
    power = exponent(abs(film.value * factor)) if unit == "m" else 0
    shown = 10.0**-power * factor
    return f"{plus_minus(film.value * shown, (film.error or 0.0) * shown)} {PREFIXES[power] if power else ''}{unit}"
