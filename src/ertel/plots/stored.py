"""What the pictures need to know of the case that is stored with a Dataset; the only place that reads its attribute."""

import json
from functools import lru_cache

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike, NDArray

from ertel.case.case import Case
from ertel.case.height_map import HeightMap
from ertel.physics import surfaces
from ertel.physics.geometry import Geometry
from ertel.physics.geometry import geometry as of_ratio
from ertel.results.dataset import maps_of


def _case_of(dataset: xr.Dataset) -> Case:
    """The case of a run.  Raises ValueError where it could not be written down."""
    if "case" not in dataset.attrs:
        raise ValueError(f"dataset: does not hold its case; {dataset.attrs.get('case_not_written', 'no reason given')}")
    return _case(dataset.attrs["case"], tuple(maps_of(dataset).items()))


@lru_cache(maxsize=4)
def _case(written: str, maps: tuple[tuple[str, HeightMap], ...]) -> Case:
    return Case.from_data(json.loads(written), dict(maps))


def geometry(dataset: xr.Dataset) -> Geometry:
    """The dry contact and its directions."""
    return of_ratio(dataset.attrs.get("radius_ratio", 1.0), dataset.attrs.get("entrainment_angle", 0.0))


def slide_to_roll(dataset: xr.Dataset) -> float:
    """(u1 - u2)/u_m."""
    return _case_of(dataset).motion.slide_to_roll


def start_approach(dataset: xr.Dataset) -> float:
    """Delta of an impact at T = 0."""
    return _case_of(dataset).schedule.start_approach


def tolerance(dataset: xr.Dataset) -> float:
    """The tolerance of the discrete equations."""
    return _case_of(dataset).solver.tolerance


def density(dataset: xr.Dataset, P: NDArray[np.float64]) -> NDArray[np.float64]:
    """rho/rho0 of the oil at pressures in p_h, of their shape."""
    return np.asarray(_case_of(dataset).lubricant.density(P), dtype=np.float64)


def roughness_height(dataset: xr.Dataset, T: float, X: ArrayLike, Y: ArrayLike) -> NDArray[np.float64]:
    """Height of the roughness at time T over the contact's own coordinates.

    Parameters
    ----------
    T : float
        Time in t0; 0 for a steady contact.
    X, Y : arrays that broadcast
        Positions in a*.

    Returns
    -------
    array of the broadcast shape
        Height in a*^2/R, positive where metal stands towards the film; zero where all surfaces are smooth.  As on the
        grid of the run, without the waves that are too short for it.
    """
    case = _case_of(dataset)
    shortest = surfaces.CELLS_KEPT * float(dataset["X"][1] - dataset["X"][0]) if "X" in dataset.coords else 0.0
    heights = surfaces.height(case.features, case.motion, T, np.asarray(X), np.asarray(Y), shortest)
    return np.asarray(heights, dtype=np.float64)
