"""What the pictures need to know of the case that is stored with a Dataset; the only place that reads its attribute."""

import json
from math import inf
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike, NDArray

from ertel.physics import surfaces
from ertel.physics.motion import Motion, Oscillation, Polyline, Signal
from ertel.physics.surfaces import Feature, Shape

SHAPES = (surfaces.Waviness, surfaces.RingWaviness, surfaces.Spot)


def _case(dataset: xr.Dataset) -> dict[str, Any]:
    case: dict[str, Any] = json.loads(dataset.attrs["case"])
    return case


def slide_to_roll(dataset: xr.Dataset) -> float:
    """(u1 - u2)/u_m."""
    return float(_case(dataset)["motion"]["slide_to_roll"])


def start_approach(dataset: xr.Dataset) -> float:
    """Delta of an impact at T = 0."""
    return float(_case(dataset)["time"]["start_approach"])


def tolerance(dataset: xr.Dataset) -> float:
    """The tolerance of the discrete equations."""
    return float(_case(dataset)["solver"]["tolerance"])


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
        Height in a*^2/R, positive where metal stands towards the film; zero where all surfaces are smooth.
    """
    features, motion = _roughness(_case(dataset))
    return np.asarray(surfaces.height(features, motion, T, np.asarray(X), np.asarray(Y)), dtype=np.float64)


def _roughness(case: dict[str, Any]) -> tuple[list[Feature], Motion]:
    """The features, those of shapes that ertel knows, and the motion that carries them."""
    known = {shape.__name__: shape for shape in SHAPES}
    features = [Feature(_shape(known[d["law"]], d), d["surface"]) for d in case["roughness"] if d["law"] in known]
    stored = case["motion"]
    load, entrainment = (_signal(stored[name]) for name in ("load", "entrainment"))
    return features, Motion(load, entrainment, stored["inertia"], stored["slide_to_roll"])


def _shape(kind: type[Any], stored: dict[str, Any]) -> Shape:
    """A shape from its stored fields; what is infinite was left out."""
    shape: Shape = kind(**{name: stored.get(name, inf) for name in kind.__dataclass_fields__})
    return shape


def _signal(stored: dict[str, Any]) -> Signal:
    values = {name: value for name, value in stored.items() if name != "law"}
    if stored["law"] == "Oscillation":
        return Oscillation(**values)
    return Polyline(tuple((T, value) for T, value in values["points"]))
