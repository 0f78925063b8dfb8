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
SHOWN = """
    impact rolling Oil quantity load_case Case Solver Time Output ConfigError simulate run open simulate_batch tasks
    sweep fit traction cache respond respond_linearly respond_in_rolling Result Measurement to_si plots fronts waves
    formulas hertz materials oils optics Feature Spot Waviness RingWaviness Measured SelfAffine
"""
FOR_EXPERTS = """
    parse_case to_toml Status Lubricant Motion Parameters Scales viscosity_laws density_laws fluidity_laws shapes
    units accessor amplitude_reduction physics numerics case equations inputs results solvers runs apps
"""


def in_a_process(code: str) -> str:
    environment = {**os.environ, "PYTHONPATH": SOURCE, "JAX_PLATFORMS": "cpu"}
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, env=environment)
    return done.stdout.strip()


def test_dir_and_completion():
    assert set(SHOWN.split()) <= set(dir(ertel)) == {"__version__", *ertel.__all__} and len(dir(ertel)) <= 41
    completer = rlcompleter.Completer({"ertel": ertel})
    found = {completer.complete("ertel.", state) for state in range(2 * len(dir(ertel)))}
    assert all(any(str(name).startswith(f"ertel.{shown}") for name in found) for shown in SHOWN.split())


def test_every_name_is_there_and_explained_and_those_for_experts_are_not_shown():
    assert all(inspect.getdoc(getattr(ertel, name)) for name in set(ertel.__all__) - {"__version__"})
    experts = FOR_EXPERTS.split()
    assert all(getattr(ertel, name) is not None for name in experts)
    assert set(experts).isdisjoint(dir(ertel))


def test_an_unknown_name():
    with pytest.raises(AttributeError, match="module 'ertel' has no attribute 'impakt'"):
        _ = ertel.impakt


def test_import_is_light_and_a_case_needs_neither_jax_nor_xarray_nor_matplotlib():
    code = """
import sys, ertel

def loaded(*heavy):
    return [name for name in ("jax", "xarray", "matplotlib", "zarr", *heavy) if name in sys.modules]

dir(ertel)
light = loaded("pint", "pydantic", "scipy", "numpy")
ertel.impact(M=1, L=1)
print(light, loaded())
"""
    assert in_a_process(code) == "[] []"


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
