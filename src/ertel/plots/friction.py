"""Panels that show friction: shear stress and power loss over the surface, coefficients and power loss through time."""

from dataclasses import replace

import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from ertel.plots import stored
from ertel.plots.drawing import BLUE, ORANGE, Field, Scale, draw_map, extent, head_map, levels, map_of, scale
from ertel.plots.histories import draw_series
from ertel.plots.moments import Profiles, shown

STRESS_COLOURS, LOSS_COLOURS = "BuPu", "YlOrBr"
WORDS = {  # of a heading
    "mu_sliding": "traction coefficient",
    "mu_sliding_y": "along y",
    "mu_rolling": "rolling resistance",
    "power_loss": "power loss",
}
NOTHING = 1e-12  # in a/R: a coefficient that is zero but for round-off
SEEN = 0.1  # of the largest power loss: less does not count where a map ends
LOADED = 0.02  # of the largest load: with less, a coefficient says nothing


def slides(dataset: xr.Dataset) -> bool:
    """Whether the surfaces slide."""
    return stored.slide_to_roll(dataset) != 0.0


def draw_stress(axes: Axes, dataset: xr.Dataset, frame: int | None = None) -> None:
    """The size of the shear stress in the middle of the film, with contour lines at equal steps."""
    along_x, along_y = (map_of(dataset, name, frame) for name in ("tau_x", "tau_y"))
    field = replace(along_x, values=np.hypot(along_x.values, along_y.values))
    z = replace(scale(dataset, "tau_x", _top(field)), symbol=r"$\tau_\mathrm{m}$", long_name="shear stress")
    _draw(axes, dataset, field, z, frame, STRESS_COLOURS, "Shear stress")


def draw_loss(axes: Axes, dataset: xr.Dataset, frame: int | None = None) -> None:
    """The power loss per area, with contour lines at equal steps."""
    field = map_of(dataset, "loss", frame)
    z = replace(scale(dataset, "loss", _top(field)), symbol="")
    _draw(axes, dataset, field, z, frame, LOSS_COLOURS, "Power loss")


def _draw(
    axes: Axes, dataset: xr.Dataset, field: Field, z: Scale, frame: int | None, colours: str, heading: str
) -> None:
    steps = levels(_top(field) * z.factor)
    loss = map_of(dataset, "loss", frame)
    profile = loss.values.max(axis=0)
    side = extent(dataset, loss.x, np.where(profile > SEEN * profile.max(), profile, 0.0))
    draw_map(axes, dataset, field, side, z, steps, colours)
    head_map(axes, dataset, heading, z, steps)


def _top(field: Field) -> float:
    return max(float(field.values.max()), 1e-9)  # something to divide where there is no friction


def draw_coefficients(axes: Axes, dataset: xr.Dataset, p: Profiles) -> None:
    """Traction and rolling resistance through time, each with its own axis, while the film carries load."""
    right = axes.twinx() if slides(dataset) else axes
    loaded = dataset["F"] > LOADED * dataset["F"].max()
    for place, name, colour in ((axes, "mu_sliding", BLUE), (right, "mu_rolling", ORANGE)):
        if name == "mu_sliding" and place is right:
            continue
        values = dataset[name].where(loaded)
        z = scale(dataset, name, float(np.abs(values).max()))
        draw_series(place, dataset, p, {name: (z.long_name, colour, "-")}, z.factor, values.values)
        low, high = (float(limit) * z.factor for limit in (values.min(), values.max()))
        bottom, top = min(1.2 * low, 0.0), max(1.2 * high, 0.0)
        place.set_ylim(bottom, top if top > bottom else 1.0)
        place.set_ylabel(z.label, color=colour)
        place.tick_params(axis="y", colors=colour)
    axes.set_title("Coefficients of friction")


def draw_power(axes: Axes, dataset: xr.Dataset, p: Profiles) -> None:
    """The power loss through time."""
    top = max(float(dataset["power_loss"].max()), 1e-9)
    z = replace(scale(dataset, "power_loss", top), symbol="")
    draw_series(axes, dataset, p, {"power_loss": (z.long_name, BLUE, "-")}, z.factor)
    axes.set(ylabel=z.label, ylim=(0.0, 1.2 * top * z.factor), title="Power loss")


def said(dataset: xr.Dataset, values: dict[str, float]) -> list[str]:
    """Coefficients that are not zero, and the power loss, for a heading."""
    return [
        f"{WORDS[name]} {shown(dataset, name, value)}"
        for name, value in values.items()
        if name == "power_loss" or abs(value) > NOTHING
    ]
