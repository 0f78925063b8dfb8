"""The order of convergence of the numbers of a case, their extrapolated values and errors, from runs on several grids.

Each grid has half the spacing of the one before it, and each run in time half the steps.  The discretisation is of
second order in both, so that the error is a third of the last difference.  That holds where the order is seen: where
the differences fall by 2^order with an order near two.  Elsewhere nothing is extrapolated and the error is the largest
difference between the grids, three times this where the differences do not fall (Eca L, Hoekstra M. A procedure for the
estimation of the numerical uncertainty of CFD calculations based on grid refinement studies. J Comput Phys
2014;262:104-130, section 4).
"""

from collections.abc import Sequence
from math import isnan, log2, nan
from typing import NamedTuple

import numpy as np
import xarray as xr

from ertel.numerics.grid import extrapolate
from ertel.results.variables import stored_in

ORDER = 2.0  # that is assumed
SEEN = (1.5, 2.5)  # observed orders at which it is
FALLING = 2.0**0.5  # ratio of differences below which they do not fall
NOT_FALLING = 3.0  # times the largest difference, by Eca and Hoekstra


class Limit(NamedTuple):
    """A number in the limit of fine grids.

    order: observed on the three finest grids, nan where the differences change their sign.  value: extrapolated by
    second order, or that on the finest grid where this order is not seen.  error: of the value.  seen: whether the
    order is.
    """

    order: float
    value: float
    error: float
    seen: bool


def limit(values: Sequence[float]) -> Limit:
    """The limit of a number on three or more grids, coarsest first, each with half the spacing of the one before."""
    *_, coarsest, coarse, fine = values
    first, second = coarse - coarsest, fine - coarse
    order = log2(first / second) if first * second > 0.0 else nan
    if order >= SEEN[0]:
        _, error, value = extrapolate(coarse, fine, coarsest)
        return Limit(order, value, error, order <= SEEN[1])
    spread = float(np.ptp(values))
    return Limit(order, fine, spread if abs(first) >= FALLING * abs(second) else NOT_FALLING * spread, False)


def with_limits(dataset: xr.Dataset) -> xr.Dataset:
    """The runs of a series, its numbers with the attributes order, extrapolated, error and order_seen."""
    dataset = dataset.assign_attrs(assumed_order=ORDER)
    for name, one in limits_of(dataset).items():
        about = {"extrapolated": one.value, "error": one.error, "order_seen": int(one.seen)}
        dataset[name].attrs |= about if isnan(one.order) else {"order": one.order, **about}
    return dataset


def limits_of(dataset: xr.Dataset) -> dict[str, Limit]:
    """The limits of the numbers that all runs of a series have and that differ, by their name in it."""
    there = stored_in(dataset, lambda variable: variable.has_error)
    values = {name: _on_grid(dataset, name).values.tolist() for name in there}
    return {name: limit(each) for name, each in values.items() if all(each) and np.ptp(each) > 0.0}


def _on_grid(dataset: xr.Dataset, name: str) -> xr.DataArray:
    """The values on the grids; a grid without an estimated error has only the one value."""
    there = f"{name}_on_grid"
    return dataset[there].fillna(dataset[name]) if there in dataset else dataset[name]
