"""The law of a contact: restitution, duration and largest force of impacts, interpolated between the runs of a study.

It is for programs that move many wet particles and need a rule for what happens when two of them meet.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike

from ertel.physics.units import Unit, si_numbers
from ertel.results.dataset import with_units
from ertel.results.study_table import DONE, flat
from ertel.results.variables import name_in_si
from ertel.runs.fit_result import open_study
from ertel.runs.study_result import StudyResult

NUMBERS = {"restitution": "restitution", "contact_time": "duration", "F_max": "force"}  # of a run, in a law

COMMENT = (
    "For the oil and the ball of the study alone: in 1 - e = St_c/St, St_c differs from oil to oil (2.5 to 4.5 on the "
    "same layer). The oil carries no tension: with a full gap and a Stokes number below 50, e is an upper bound."
)


class ContactValues(NamedTuple):
    """The outcome of impacts, each of the shape of what was asked.

    restitution: speed after the impact over speed before.  duration: time (s) in which the load is above 1 % of its
    largest value.  force: that value (N).  Duration and force are in t0 and F* of each impact where the study is
    dimensionless.
    """

    restitution: Any
    duration: Any
    force: Any


@dataclass(frozen=True, eq=False)
class ContactLaw:
    """Restitution, duration and largest force over what a study varies.

    The logarithms of 1 - e, duration and force are interpolated linearly between the logarithms of what varies.  So
    power laws are exact, such as 1 - e = St_c/St.  The law is that of the study's oil and ball: St_c differs from oil
    to oil (2.5 to 4.5 on the same layer), so that one study does not give the e of another oil by its Stokes number.

    The oil carries no tension: in a full gap e is an upper bound below St = 50 (St = 20: 0.73, with tension 0.47; at
    St = 5 0.41, where with tension nothing comes back).

    Parameters
    ----------
    dataset : xarray.Dataset
        The table: restitution, duration (s) and force (N) over what varies, each rising.  That of a file is
        `ContactLaw(xarray.load_dataset(path))`.
    """

    dataset: xr.Dataset

    def __call__(self, *values: ArrayLike | str) -> ContactValues:
        """The outcome of impacts between those of the study.

        Parameters
        ----------
        *values : array_like
            What varies, in the order of the study and in its units in SI: `law(speed, layer)` in m/s and m, and
            `law(drop_height, layer)` in m; or a text with a unit, `law("0.5 m/s", "10 um")`.  They broadcast.

        Returns
        -------
        ContactValues
            restitution, duration (s) and force (N).

        Raises
        ------
        ValueError
            A value is outside the table, or there are too few or too many.
        """
        from scipy.interpolate import RegularGridInterpolator

        axes = {str(name): self.dataset[name] for name in self.dataset["restitution"].dims}
        if len(values) != len(axes):
            raise ValueError(f"law: got {len(values)} values; give {' and '.join(axes)}")
        units = [str(axis.attrs["units"]) for axis in axes.values()]
        values = tuple(si_numbers(each, Unit(unit, f"1 {unit}")) for each, unit in zip(values, units, strict=True))
        for (name, axis), value in zip(axes.items(), values, strict=True):
            least, most, given = float(axis[0]), float(axis[-1]), np.asarray(value, dtype=float)
            if not np.all((least <= given) & (given <= most)):
                wrong = given[~((least <= given) & (given <= most))].flat[0]
                unit = axis.attrs.get("in_units_of", axis.attrs["units"])
                raise ValueError(f"{name} = {wrong:g}: must be from {least:g} to {most:g} {unit}".removesuffix(" 1"))
        loss, *others = (self.dataset[name].transpose(*axes).values for name in ContactValues._fields)
        table = np.log(np.stack([1.0 - loss, *others], axis=-1))
        between = RegularGridInterpolator(
            [np.log(axis.values) for axis in axes.values()], table, bounds_error=False, fill_value=None
        )
        places = np.stack(np.broadcast_arrays(*map(np.log, values)), axis=-1)
        numbers = np.exp(between(places)).reshape(*places.shape[:-1], len(NUMBERS))
        loss, duration, force = np.moveaxis(numbers, -1, 0)
        return ContactValues(1.0 - loss, duration, force)

    def save(self, path: str | Path) -> None:
        """Write the table with its units: as CSV where the path ends so, or as NetCDF, which xarray and others read."""
        if Path(path).suffix == ".csv":
            flat(with_units(self.dataset)).to_dataframe().to_csv(path, index=False)
        else:
            self.dataset.to_netcdf(path, engine="scipy")


def contact_law(study: StudyResult | str | Path) -> ContactLaw:
    """The law of a contact from a study of impacts, over speed (or drop height) and layer, or whatever it varies.

    Parameters
    ----------
    study : StudyResult, str or Path
        Or its directory.  All combinations of two or more values of each, above zero, whose runs went on until the
        rebound.

    Returns
    -------
    ContactLaw
        `law(speed, layer)` gives restitution, duration (s) and largest force (N); `law.save("law.nc")`, or "law.csv",
        writes them.

    Raises
    ------
    ValueError
        The study does not vary numbers above zero in all combinations, or a run is missing, failed or has no rebound;
        the message names it.

    Examples
    --------
    >>> study = ertel.sweep("examples/sweeps/wet_restitution.toml", "sweeps/wet")  # doctest: +SKIP
    >>> ertel.contact_law(study)(0.5, 10e-6).restitution  # doctest: +SKIP
    """
    data = (study if isinstance(study, StudyResult) else open_study(Path(study))).dataset
    if data.attrs["kind"] != "impact" or data.attrs["mode"] != "product":
        raise ValueError(
            f'study: is a "{data.attrs["mode"]}" of {data.attrs["kind"]} cases; must be a "product" of impacts'
        )
    for name, axis in data.coords.items():
        if axis.dtype.kind != "f" or len(axis) < 2 or not np.all(axis > 0):
            raise ValueError(f"study: {name} must have two or more values above zero; it has {axis.values.tolist()}")
    stored = {name if name in data else name_in_si(name): new for name, new in NUMBERS.items()}
    empty = xr.full_like(data["warnings"], np.nan, dtype=float)
    about = {name: data.attrs[name] for name in ("title", "source", "date_created")} | {"comment": COMMENT}
    order = {name: data[name] for name in data["warnings"].dims}  # a file may have the coordinates in another order
    table = xr.Dataset({new: data.get(name, empty).variable for name, new in stored.items()}, order, about)
    lacking = (table.to_array().isnull().any("variable") | (data["status"] != DONE)).values
    if lacking.any():
        first, status = (data[name].values[lacking][0] for name in ("directory", "status"))
        raise ValueError(
            f"study: {lacking.sum()} of {lacking.size} runs failed or have no rebound, first {first} ({status}); "
            'all must converge with time.until = "rebound"'
        )
    return ContactLaw(table.sortby(list(order)))
