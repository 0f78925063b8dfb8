"""Beyond the paper: the runs of Figs. 7 and 8 with waves of other shapes and other lubricants, and their ratios."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from pandas import DataFrame

from ertel import Feature, Parameters, RingWaviness, Waviness, fronts, respond, waves
from ertel.apps.boundary_layers.dots import Extrapolated
from ertel.apps.boundary_layers.plans import Moes, impact_seconds
from ertel.apps.boundary_layers.reduction import case_cells
from ertel.apps.boundary_layers.waves import HEIGHT, impact_case, last_wave
from ertel.runs.tasks import Task

Maker = Callable[[float, float], Waviness | RingWaviness]
SHAPES: Mapping[str, Maker] = {  # of height and wavelength
    "isotropic": lambda height, wavelength: Waviness(height, wavelength, wavelength),
    "transverse": lambda height, wavelength: Waviness(height, wavelength),
    "rings": lambda height, wavelength: RingWaviness(height, wavelength),
}
USUAL, SOFT = "Roelands, compressible", "isoviscous"
OILS: Mapping[str, Mapping[str, str]] = {  # the section [lubricant] of a case file
    USUAL: {},
    "Roelands, incompressible": {"density": "incompressible"},
    "Barus, incompressible": {"viscosity": "barus", "density": "incompressible"},
    SOFT: {"viscosity": "isoviscous", "density": "incompressible"},
}
Shaped = tuple[str, float]  # key of SHAPES, wavelength (a*)


def shape_name(shape: str, wavelength: float) -> str:
    """Coordinate of a wave in the result of `shaped_impact`."""
    return f"{shape}, wavelength {wavelength:g}"


def shaped_impact(M: float, L: float, shapes: Sequence[Shaped], nodes: int, oil: str = USUAL) -> xr.Dataset:
    """The response of an impact to waves of several shapes at maximum approach, along Y = 0.

    Parameters
    ----------
    shapes : sequence of (shape, wavelength)
        Key of `SHAPES` and wavelength (a*) of each; the height A_i is that of Fig. 6.
    oil : str
        Key of `OILS`.

    Returns
    -------
    xarray.Dataset
        H (X) of the smooth impact, dH/A_i (wave, X) for each `shape_name`, X_min and P_max over time, and `along`
        (wave, X): amplitude of transverse waves where the front ran along their ridges, see `waves.ridge_amplitude`,
        nan for the other shapes.

    Raises
    ------
    RuntimeError
        A run failed.
    """
    case = impact_case(M, L, nodes, OILS[oil])
    height = HEIGHT * case.parameters.trapped_film
    data = respond(case, [[Feature(SHAPES[shape](height, wavelength))] for shape, wavelength in shapes])
    if data.attrs["status"] != "converged":
        raise RuntimeError(f"M = {M}, L = {L}, {oil}, {nodes} nodes: {data.attrs['status']}")
    along = [_along(data, *shape, dH / height) for shape, dH in zip(shapes, data["dH"].values, strict=True)]
    line = data[["H", "dH", "X_min", "Y_min", "P_max"]].drop_vars("roughness").sel(Y=0.0, method="nearest")
    found = line.assign(dH=line["dH"] / height, along=(("wave", "X"), np.stack(along)))
    return found.assign_coords(wave=[shape_name(*shape) for shape in shapes]).drop_attrs().load()


def _along(data: xr.Dataset, shape: str, wavelength: float, dH: np.ndarray) -> np.ndarray:
    X, Y = data["X"].values, data["Y"].values
    return waves.ridge_amplitude(X, Y, dH, wavelength, X) if shape == "transverse" else np.full(len(X), np.nan)


def shaped_name(kind: str, M: float, L: float, nodes: int) -> str:
    """Name of a task that is a `shaped_impact`: of "shapes" or of a key of `OILS`."""
    return f"{kind.replace(', ', '_')}_M{M:g}_L{L:g}_{nodes}"


def shaped_tasks(
    kind: str, case: Moes, shapes: Sequence[Shaped], grids: tuple[int, int], oil: str = USUAL
) -> list[Task]:
    """An impact on both grids."""
    return [
        Task(
            shaped_name(kind, *case, nodes),
            shaped_impact,
            (*case, tuple(shapes), nodes, oil),
            impact_seconds(len(shapes) + 1, nodes),
        )
        for nodes in grids
    ]


# -- ratios -----------------------------------------------------------------------------------------------------------


class Mark(NamedTuple):
    """A_d/A_i for one kind of waves or oil at X; nabla2 of this place, with the momentary Hertz contact, and global.

    Without piezoviscosity nabla2 is infinite; wavelength over trapped film takes its place, see `over_film`.
    """

    kind: str
    M: float
    L: float
    wavelength: float
    X: float
    ratio: Extrapolated
    local: float
    hertz: float
    everywhere: float

    @property
    def case(self) -> tuple[float, float, float]:
        """M, L and wavelength."""
        return self.M, self.L, self.wavelength


class Grids(NamedTuple):
    """The results of an impact on both grids."""

    coarse: xr.Dataset
    fine: xr.Dataset

    def wave(self, shape: str, wavelength: float) -> "Grids":
        """The results for one wave."""
        name = shape_name(shape, wavelength)
        return Grids(self.coarse.sel(wave=name), self.fine.sel(wave=name))

    def front(self) -> fronts.Front:
        """The front on the fine grid."""
        return fronts.front(self.fine)


def over_film(p: Parameters, wavelength: float, speed: float = 1.0, A: float = 1.0) -> float:
    """Wavelength over trapped film for the speed and radius (a*) of the front; equal to nabla2 if alpha_bar > 0.4.

    nabla2 = wavelength/sqrt(L/M), and sqrt(L/M) is the film at which a rigid ball stops; that of an isoviscous oil is
    0.3135 sqrt(lambda_bar).
    """
    return wavelength / A / Parameters(p.lambda_bar * speed / A**4, p.alpha_bar * A).trapped_film


def _mark(kind: str, case: Moes, wavelength: float, X: float, ratio: Extrapolated, front: fronts.Front) -> Mark:
    p, speed = Parameters.from_moes(*case), float(front.speed_at(X))
    places = over_film(p, wavelength, speed), over_film(p, wavelength, speed, X), over_film(p, wavelength)
    return Mark(kind, *case, wavelength, X, ratio, *places)


def last_waves(kind: str, case: Moes, shape: str, wavelength: float, grids: Grids) -> Mark:
    """The last complete wave inside the contact, on both grids."""
    front = grids.front()
    coarse, fine = (last_wave(grid, float(front.A[-1])) for grid in grids.wave(shape, wavelength))
    return _mark(kind, case, wavelength, fine.X, Extrapolated(coarse.amplitude, fine.amplitude), front)


def ridges_at(case: Moes, wavelength: float, X: float, grids: Grids) -> Mark:
    """The longitudinal waves at X: transverse waves where the front runs along their ridges."""
    coarse, fine = (float(np.interp(X, g["X"], g["along"])) for g in grids.wave("transverse", wavelength))
    return _mark("longitudinal", case, wavelength, X, Extrapolated(coarse, fine), grids.front())


# -- what Figs. 7 and 8 share ------------------------------------------------------------------------------------------


def draw_marks(axes: Axes, marks: Sequence[Mark], styles: Mapping[str, tuple[str, str]]) -> None:
    """Marks with error bars.  styles: kind -> marker, colour."""
    for kind, (marker, colour) in styles.items():
        own = [mark for mark in marks if mark.kind == kind]
        place, limit = [mark.local for mark in own], [mark.ratio.limit for mark in own]
        bar = [mark.ratio.error for mark in own]
        if own:
            axes.errorbar(place, limit, bar, fmt=marker, color=colour, mfc="none", capsize=2, label=kind)


def marks_data(marks: Sequence[Mark]) -> DataFrame:
    """The marks as a data file."""
    names = ("M", "L", "wavelength", "X", "local", "hertz", "everywhere", "kind")
    return DataFrame({**{name: getattr(mark, name) for name in names}, **mark.ratio.columns()} for mark in marks)


def marks_table(kind: str, marks: Iterator[Mark] | Sequence[Mark]) -> DataFrame:
    """The marks as a table.  kind: heading of its first column."""
    return DataFrame(
        {
            kind: mark.kind,
            **case_cells(*mark.case),
            "X": f"{mark.X:.3f}",
            **mark.ratio.cells(),
            "nabla2 local": f"{mark.local:.2f}",
            "momentary Hertz contact": f"{mark.hertz:.2f}",
            "global": f"{mark.everywhere:.2f}",
        }
        for mark in marks
    )
