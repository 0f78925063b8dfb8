"""`dataset.ertel`: pictures and SI values of a run that xarray alone has opened."""

import json
import subprocess
import sys

import pytest
import xarray as xr
from made_up import BALL_FALLS, MOES_FALLS, dry_impact
from matplotlib.figure import Figure

from ertel.inputs.case_files import parse_case
from ertel.results import result  # noqa: F401  # registers it
from ertel.results.dataset import provenance
from ertel.results.variables import to_si


@pytest.fixture
def opened(tmp_path) -> xr.Dataset:
    """A run in SI, written and opened by xarray alone."""
    data = dry_impact(BALL_FALLS).assign_attrs(provenance(parse_case(BALL_FALLS)))
    data.to_zarr(tmp_path / "run.zarr")
    return xr.open_zarr(tmp_path / "run.zarr")


def test_pictures_of_a_stored_run(opened):
    assert isinstance(opened.ertel.plot.film(), Figure)
    assert "film()" in repr(opened.ertel) and "interferogram()" in repr(opened.ertel)


def test_si_of_a_stored_run(opened):
    si = opened.ertel.si()
    xr.testing.assert_identical(si, to_si(opened))
    assert si["h_c"].attrs["units"] == "m"


def test_what_a_dataset_has_not():
    with pytest.raises(ValueError, match="dimensionless"):
        dry_impact(MOES_FALLS).ertel.si()


def test_it_is_registered_with_the_runs_and_not_before():
    """Not by `import ertel`, which does not import xarray; by whatever makes or opens a run."""
    code = (
        "import xarray as xr, ertel, json; before = hasattr(xr.Dataset, 'ertel'); ertel.simulate;"
        "print(json.dumps([before, hasattr(xr.Dataset, 'ertel')]))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert json.loads(done.stdout) == [False, True]
