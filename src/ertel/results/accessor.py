"""The accessor `ertel` of xarray: pictures and SI values of a run that xarray alone has opened.

    >>> import xarray as xr
    >>> from ertel import accessor
    >>> run = xr.open_zarr("runs/ball/run.zarr")  # doctest: +SKIP
    >>> run.ertel.plot.film(at="max-approach")  # doctest: +SKIP
    >>> run.ertel.si()["h_c"]  # doctest: +SKIP

`import ertel` does not import xarray, and so cannot register it; importing this module does, and so does everything
that makes or opens a run.
"""

import xarray as xr

from ertel.results.result import Plot
from ertel.results.variables import to_si


@xr.register_dataset_accessor("ertel")  # type: ignore[no-untyped-call]
class RunAccessor:
    """What ertel knows of a Dataset of a run: `dataset.ertel.plot` and `.si()`."""

    def __init__(self, dataset: xr.Dataset):
        self._dataset = dataset

    @property
    def plot(self) -> Plot:
        """The pictures of the run: `dataset.ertel.plot.film(at="max-approach")`, ..."""
        return Plot(self._dataset)

    def si(self) -> xr.Dataset:
        """The Dataset in SI units under SI names (h_c for H_c, t for time).  Raises ValueError if dimensionless."""
        return to_si(self._dataset)

    def __repr__(self) -> str:
        return f"{self.plot}; also si()"
