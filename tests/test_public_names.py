"""What `ertel.` offers: all of it found by dir and by completion, explained, and imported when it is first used."""

import inspect
import os
import rlcompleter
import subprocess
import sys
import warnings
from pathlib import Path

import pytest

import ertel

SOURCE = str(Path(ertel.__path__[0]).parent)
PROMISED = {
    *(
        "impact",
        "rolling",
        "Oil",
        "quantity",
        "simulate",
        "run",
        "open",
        "simulate_batch",
        "tasks",
        "sweep",
        "plots",
        "formulas",
    ),
    *(
        "load_case",
        "parse_case",
        "to_toml",
        "Case",
        "Result",
        "Solver",
        "Time",
        "Output",
        "Spot",
        "Waviness",
        "Measured",
        "SelfAffine",
        "fronts",
    ),
    *(
        "viscosity_laws",
        "density_laws",
        "shapes",
        "respond",
        "respond_linearly",
        "respond_in_rolling",
        "waves",
        "hertz",
        "materials",
        "oils",
        "to_si",
    ),
}


def in_a_process(code: str) -> str:
    environment = {**os.environ, "PYTHONPATH": SOURCE, "JAX_PLATFORMS": "cpu"}
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, env=environment)
    return done.stdout.strip()


def test_dir_and_completion():
    assert PROMISED <= set(dir(ertel))
    completer = rlcompleter.Completer({"ertel": ertel})
    found = {completer.complete("ertel.", state) for state in range(2 * len(dir(ertel)))}
    assert all(any(str(name).startswith(f"ertel.{promised}") for name in found) for promised in PROMISED)


@pytest.mark.parametrize("name", sorted(set(ertel.__all__) - {"__version__"}))
def test_every_name_is_there_and_explained(name):
    assert inspect.getdoc(getattr(ertel, name))


def test_an_unknown_name():
    with pytest.raises(AttributeError, match="module 'ertel' has no attribute 'impakt'"):
        _ = ertel.impakt


def test_import_is_light():
    heavy = ["jax", "xarray", "matplotlib", "pint", "pydantic", "zarr", "scipy", "numpy"]
    code = f"import sys, ertel; dir(ertel); print([name for name in {heavy} if name in sys.modules])"
    assert in_a_process(code) == "[]"


def test_a_case_needs_neither_jax_nor_xarray_nor_matplotlib():
    heavy = ["jax", "xarray", "matplotlib", "zarr"]
    code = f"import sys, ertel; ertel.impact(M=1, L=1); print([name for name in {heavy} if name in sys.modules])"
    assert in_a_process(code) == "[]"


# -- warnings reach whoever runs a case -------------------------------------------------------------------------------

SMALL = {"M": 200, "L": 10, "nodes": 33, "time_tolerance": 0.01, "until": 1.4}
FRONT = "the film is not resolved at the front"


def test_warnings_are_given_once_and_stand_in_the_repr(tmp_path):
    case = ertel.impact(**SMALL)
    for run in (lambda: ertel.simulate(case), lambda: ertel.run(case, tmp_path / "run")):
        with pytest.warns(UserWarning, match=FRONT) as caught:
            result = run()
        assert len([w for w in caught if FRONT in str(w.message)]) == 1
        assert [str(w.message) for w in caught] == result.warnings
        assert all(w.filename == __file__ for w in caught)
        assert f"warning: {FRONT}" in repr(result)
        assert FRONT in result._repr_html_()


def test_a_run_that_resolves_all_is_silent():
    case = ertel.impact(M=200, L=10, method="radial", nodes=97, half_width=4.0, time_tolerance=0.002, until=1.4)
    with warnings.catch_warnings(action="error"):
        assert ertel.simulate(case).warnings == []
