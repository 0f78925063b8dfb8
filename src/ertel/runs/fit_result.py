"""The outcome of a fit: values of the unknowns with their standard errors, and what the data decide.

The unknowns are positive numbers p, and a fit works with ln p: its Jacobian J has the derivatives of what is predicted,
in standard deviations of the data, with respect to ln p.  A singular value s of J with the right singular vector v says
that the data fix the product of all p^v to the relative uncertainty 1/s; here v is scaled so that its largest component
w is one, and the uncertainty is 1/(s w).  The covariance of ln p is (J^T J)^-1, with the rows of the priors in J (Press
WH et al. Numerical Recipes, 3rd ed. Cambridge University Press; 2007, section 15.4).  It follows from the standard
deviations that are given and is not scaled by chi square.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from math import exp, log
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from ertel.case.case import Case
from ertel.results.study_table import counted
from ertel.results.variables import in_celsius, with_prefix
from ertel.runs.arrays import open_data
from ertel.runs.directory import KINDS as KINDS
from ertel.runs.directory import kind_of, read_case
from ertel.runs.files import StoreError
from ertel.runs.study_result import ConvergenceResult, StudyResult
from ertel.version import installed_version

Values = NDArray[np.float64]
UNDECIDED = 0.5  # relative uncertainty above which the data do not decide a product
SMALLEST_POWER = 0.05  # of an unknown that is named in a product
NEAR_BOUND = 0.01  # in ln p: an unknown so close ends at its bound
UNLIKELY = 0.01  # probability of a larger chi square below which the case does not explain the data


@dataclass(frozen=True)
class FitPoint:
    """A point of the search of a fit, also the one where it has ended.

    names: of the unknowns, short.  values, bounds, priors: in SI; bounds (2, unknown), priors with their standard
    deviations (2, unknown), nan where there is none.  units: "" of plain numbers.  residuals: (predicted -
    measured)/sigma.  jacobian: of these, with respect to the logarithms of the unknowns.  aligned: how many values the
    alignment of measurements takes from the data.  grid: the error of the grid in the data, in sigma, whose part it is;
    all data have it together, so that many of them do not make it smaller.
    """

    names: tuple[str, ...]
    units: tuple[str, ...]
    values: Values
    bounds: Values
    priors: Values
    residuals: Values
    jacobian: Values
    aligned: int = 0
    grid: Values | float = 0.0

    @property
    def rows(self) -> tuple[Values, Values]:
        """Residuals and Jacobian of the data and of the priors that there are."""
        expected, sigma = self.priors
        there = np.isfinite(sigma)
        residuals = np.concatenate([self.residuals, ((self.values - expected) / sigma)[there]])
        return residuals, np.vstack([self.jacobian, np.diag(self.values / sigma)[there]])

    def with_noise(self, ratio: Values, grid: Values) -> "FitPoint":
        """The same with another sigma, in which the old one is `ratio`, and the error of the grid."""
        return replace(self, residuals=self.residuals * ratio, jacobian=self.jacobian * ratio[:, None], grid=grid)

    @property
    def chi_square(self) -> float:
        """The sum of the squares of all residuals, those of the priors too."""
        return float(np.sum(self.rows[0] ** 2))

    @property
    def freedom(self) -> int:
        """The number of data and priors less that of the unknowns and of the values that align the data."""
        return len(self.rows[0]) - len(self.values) - self.aligned

    @property
    def covariance(self) -> Values:
        """The covariance of the logarithms; very large in directions that nothing fixes.

        The residuals are weighted by all of sigma; of it the noise is independent, the error of the grid is not.
        """
        rows = self.rows[1]
        noise = np.ones(len(rows))
        noise[: len(self.residuals)] -= np.square(self.grid)
        gain = self._of_noise @ rows.T
        return np.asarray((gain * noise) @ gain.T + np.outer(self.moved, self.moved))

    @property
    def _of_noise(self) -> Values:
        """The covariance if all of sigma were independent noise."""
        _, s, v = np.linalg.svd(self.rows[1], full_matrices=False)
        return np.asarray((v.T / np.maximum(s, 1e-9 * max(s[0], 1.0)) ** 2) @ v)

    @property
    def moved(self) -> Values:
        """The logarithms by which the error of the grid moves the unknowns."""
        return np.asarray(self._of_noise @ self.jacobian.T @ (self.grid * np.ones(len(self.residuals))))

    @property
    def products(self) -> tuple[Values, Values]:
        """Relative uncertainty (product,) and exponents (product, unknown) of what the data fix, the best one first."""
        u, singular, v = np.linalg.svd(self.jacobian)
        missing = (0, len(v) - len(singular))
        noise = np.sqrt((1.0 - np.square(self.grid) * np.ones(len(u))) @ u[:, : len(singular)] ** 2)
        s, noise = np.pad(singular, missing), np.pad(noise, missing, constant_values=1.0)
        largest = v[np.arange(len(v)), np.argmax(np.abs(v), axis=1)]
        with np.errstate(divide="ignore"):
            exponents = v / largest[:, None]
            return np.hypot(noise / (s * np.abs(largest)), exponents @ self.moved), exponents

    @property
    def in_words(self) -> str:
        """The products of the unknowns that the data fix, and how well, then with the priors each unknown alone."""
        fixed = [f"{powers_in_words(self.names, e)} to {in_percent(u)}" for u, e in zip(*self.products, strict=True)]
        errors = np.sqrt(np.diag(self.covariance))
        alone = [f"{name} to {in_percent(error)}" for name, error in zip(self.names, errors, strict=True)]
        return f"the data fix {', '.join(fixed)}" + (f"; alone {', '.join(alone)}" if len(alone) > 1 else "")

    @property
    def is_explained(self) -> bool:
        """Whether a chi square as large as this one is likely enough."""
        from scipy.special import chdtrc  # the chi-square distribution; scipy.stats is slow to import, and large

        # as many unknowns as data should meet them, unless a bound is in the way
        return bool(chdtrc(max(self.freedom, 1), self.chi_square) >= UNLIKELY)

    @property
    def warnings(self) -> list[str]:
        """The sentences on what the data do not decide, on bounds, and on a case that does not explain the data."""
        found = []
        for uncertainty, exponents in zip(*self.products, strict=True):
            known = float(np.sqrt(exponents @ self.covariance @ exponents))
            advice = "measure something else, give a prior, or fix an unknown"
            rest = f"the prior does, to {in_percent(known)}" if known <= UNDECIDED else advice
            if not uncertainty <= UNDECIDED:
                which = powers_in_words(self.names, exponents)
                found.append(f"the data do not decide {which} ({in_percent(uncertainty)}): {rest}")
        for name, unit, value, ends in zip(self.names, self.units, self.values, self.bounds.T, strict=True):
            if near := [end for end in ends if abs(log(value / end)) < NEAR_BOUND]:
                found.append(f"{name} ends at its bound, {amount(near[0], unit)}: widen it, or doubt the case")
        if not self.is_explained:
            factor = (self.chi_square / max(self.freedom, 1)) ** 0.5
            found.append(f"the case does not explain the data: the residuals are {factor:.2g} times their sigma")
        return found


def in_percent(uncertainty: float) -> str:
    """The standard deviation of a logarithm in words: a percentage, or a factor where it is large."""
    if uncertainty <= UNDECIDED:
        return f"{100 * uncertainty:.2g} %"
    return f"a factor of {exp(uncertainty):.2g}" if uncertainty < log(10.0) else "no better than a factor of 10"


def powers_in_words(names: Sequence[str], exponents: Values) -> str:
    """A product of powers in words: eta0*alpha^0.9."""
    text = ""
    for number in np.argsort(-exponents, kind="stable"):
        size = abs(exponents[number])
        if size >= SMALLEST_POWER:
            power = "" if abs(size - 1.0) < SMALLEST_POWER else f"^{size:.2g}"
            text += ("/" if exponents[number] < 0 else "*" if text else "") + names[number] + power
    return text


def amount(value: float, unit: str) -> str:
    """A value in SI for reading.  unit: "" of a plain number."""
    return with_prefix(float(value), unit or "1")


# -- the record -------------------------------------------------------------------------------------------------------


def fit_dataset(solution: FitPoint, data: Mapping[str, tuple[Any, str]], about: Mapping[str, Any]) -> xr.Dataset:
    """The outcome of a fit as a Dataset.

    Over `unknown`: values, standard errors, bounds and priors in SI, their unit, correlation; over `datum`: what is
    measured and predicted; over `product`: relative uncertainty and exponents of the products that the data fix.

    data: name -> values along the data, and what they are: measured, sigma, predicted and others.  about: attributes,
    title and others.
    """
    covariance, (uncertainty, exponents) = solution.covariance, solution.products
    relative = np.sqrt(np.diag(covariance))
    names, units = (np.array(texts, dtype=object) for texts in (solution.names, solution.units))
    variables = {
        "value": (["unknown"], solution.values, "value in SI"),
        "standard_error": (["unknown"], solution.values * relative, "standard error in SI"),
        "relative_error": (["unknown"], relative, "standard error of the natural logarithm"),
        "unit": (["unknown"], units, "SI unit"),
        "lower": (["unknown"], solution.bounds[0], "bound in SI"),
        "upper": (["unknown"], solution.bounds[1], "bound in SI"),
        "prior": (["unknown"], solution.priors[0], "in SI"),
        "prior_sigma": (["unknown"], solution.priors[1], "in SI"),
        "correlation": (["unknown", "other"], covariance / np.outer(relative, relative), "correlation"),
        **{name: (["datum"], values, text) for name, (values, text) in data.items()},
        "residual": (["datum"], solution.residuals, "(predicted - measured)/sigma"),
        "jacobian": (["datum", "unknown"], solution.jacobian, "d residual/d ln unknown"),
        "uncertainty": (["product"], uncertainty, "relative uncertainty of a product of powers"),
        "exponent": (["product", "unknown"], exponents, "exponents of a product of powers"),
    }
    found = zip(solution.names, solution.values, solution.units, relative, strict=True)
    numbers = {
        "chi_square": solution.chi_square,
        "degrees_of_freedom": solution.freedom,
        "decided": solution.in_words if solution.is_explained else "",
        "found": [f"{name} = {amount(value, unit)} ± {in_percent(error)}" for name, value, unit, error in found],
    }
    return xr.Dataset(
        {name: (dims, values, {"long_name": text}) for name, (dims, values, text) in variables.items()},
        {"unknown": names, "other": names},
        {**numbers, "source": f"ertel {installed_version()}", **about},
    )


def open_study(directory: Path) -> StudyResult:
    """The study in a directory: of a sweep, a traction curve, a convergence series or a fit.

    Raises StoreError where there is none with numbers, or they cannot be read.
    """
    if not (kind := kind_of(directory)):
        raise StoreError(f"{directory} is not a study; there is no {', '.join(KINDS)}.zarr in it")
    try:
        data = open_data(directory / f"{kind}.zarr", consolidated=False).load()
        best = str(data.attrs.get("best", ""))
        if not (directory / best).resolve().is_relative_to(directory.resolve()):
            raise ValueError(f"{best} lies outside of the study")
        if kind == "fit":
            return FitResult(data, directory, case=read_case(directory / best))
        return (ConvergenceResult if kind == "convergence" else StudyResult)(data, directory)
    except Exception as error:  # of zarr, its codecs, the system
        raise StoreError(f"the outcome of this study cannot be read ({error}); start it again") from error


def with_laws(fits: Mapping[str, "FitResult"]) -> "FitResult":
    """The first of several fits, by the law of viscosity, with the values, errors and chi squares of all.

    Over `law`: value_under and standard_error_under of each unknown, in SI, and chi_square_under.
    """
    first, *_ = fits.values()
    chi = {law: float(each.dataset.attrs["chi_square"]) for law, each in fits.items()}
    about = {law: f"{'; '.join(fit.dataset.attrs['found'])}; chi square {chi[law]:.3g}" for law, fit in fits.items()}
    sigma = {law: np.hypot(fit.dataset["sigma"], fit.dataset["grid_error"]) for law, fit in fits.items()}
    unlikely = {law: chi[law] + 2.0 * float(np.log(sigma[law]).sum()) for law in fits}
    best, second, *_ = sorted(unlikely, key=lambda law: unlikely[law])  # each with the error of its own grid
    off = unlikely[second] - unlikely[best]
    apart = f"the data speak for {best}: twice the log of the likelihood is larger by {off:.3g} than for {second}"
    if off < -2.0 * log(UNLIKELY):
        apart = "the data do not tell these laws apart: measure at a second speed"
    under: dict[str, Any] = {"chi_square_under": ("law", list(chi.values()), {"long_name": "chi square under a law"})}
    for name in ("value", "standard_error"):
        values = [fit.dataset[name].values for fit in fits.values()]
        under[f"{name}_under"] = ("law", "unknown"), values, first.dataset[name].attrs
    texts = [*(f"under {law}: {text}" for law, text in about.items()), apart]
    runs = sum(fit.dataset.attrs["runs"] for fit in fits.values())
    kept = [digest for fit in fits.values() for digest in fit.dataset.attrs["kept"]]
    data = first.dataset.assign(under).assign_coords(law=np.array(list(fits), dtype=object))
    return replace(first, dataset=data.assign_attrs(laws=texts, runs=runs, kept=kept, under=""))


@dataclass(frozen=True, repr=False, eq=False, kw_only=True)
class FitResult(StudyResult):
    """The result of a fit.

    Parameters
    ----------
    dataset : xarray.Dataset
        See `fit_dataset`.
    case : Case
        The case with the values that were found.
    directory : Path, optional
        Of the fit.
    """

    case: Case

    @property
    def heading(self) -> str:
        """The title of the table."""
        return f"fit of {self.dataset.attrs['title']}"

    @property
    def values(self) -> dict[str, float]:
        """The values of the unknowns, in SI."""
        return {row["unknown"]: row["value"] for row in self.rows()}

    @property
    def standard_errors(self) -> dict[str, float]:
        """The standard errors of the unknowns, in SI."""
        return {row["unknown"]: row["standard_error"] for row in self.rows()}

    def _frame(self) -> Any:
        """The unknowns as a table, in SI."""
        return self._along("unknown").to_dataframe().reset_index()

    def as_data(self) -> dict[str, Any]:
        """The fit as plain data for JSON."""
        return {
            **self.dataset.attrs,
            "unknowns": self.rows(),
            "correlation": self.dataset["correlation"].values.tolist(),
        }

    def to_csv(self, path: str | Path) -> None:
        """Write the data as a CSV file: what is measured, predicted and left over."""
        self._along("datum").to_dataframe().to_csv(path, index=False)

    def _along(self, dimension: str) -> xr.Dataset:
        return self.dataset.drop_dims([str(other) for other in self.dataset.dims if other != dimension])

    def table(self) -> list[list[str]]:
        """The columns of a table to read, each with its heading first."""
        rows = self.rows()
        names = [str(row["unknown"]) for row in rows]
        correlation = zip(names, self.dataset["correlation"].values, strict=True)
        return [
            ["unknown", *names],
            ["value", *(amount(*in_celsius(row["value"], row["unit"])) for row in rows)],
            ["standard error", *(amount(row["standard_error"], row["unit"]) for row in rows)],
            ["relative", *(in_percent(row["relative_error"]) for row in rows)],
            *([name, *(f"{value:.3f}" for value in column)] for name, column in correlation),
        ]

    @property
    def remarks(self) -> list[str]:
        """Lines below the table: what the data decide, how well they are explained, and warnings."""
        chi, freedom, runs = (self.dataset.attrs[name] for name in ("chi_square", "degrees_of_freedom", "runs"))
        per = f"{chi / freedom:.3g} for each of {freedom} degrees of freedom" if freedom else "no degree of freedom"
        work = f"{self.dataset.sizes['datum']} data, chi square {chi:.3g}, {per}; {counted(runs, 'run')}"
        said = [text for name in ("decided", "under", "grid", "aligned") if (text := self.dataset.attrs.get(name))]
        return [*said, work, *self.dataset.attrs.get("laws", []), *(f"warning: {warning}" for warning in self.warnings)]
