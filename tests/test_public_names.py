"""What `ertel.` offers: all of it found by dir and by completion, explained, and imported when it is first used."""

import inspect
import rlcompleter
import warnings

import pytest
from cases import python

import ertel

SHOWN = """
    impact rolling Oil quantity load_case Case Solver Time Output ConfigError simulate run open
    sweep converge fit traction stribeck cache respond respond_linearly respond_in_rolling Result Measurement to_si
    plots fronts
    formulas hertz gears cams materials oils optics Feature Spot Waviness RingWaviness Measured SelfAffine
"""
FOR_EXPERTS = """
    parse_case to_toml sampled Status Lubricant Motion Parameters Scales viscosity_laws density_laws fluidity_laws
    shapes units amplitude_reduction physics numerics case equations inputs results solvers runs apps
"""


def test_names_are_shown_completed_and_explained():
    assert set(SHOWN.split()) <= set(dir(ertel)) == {"__version__", *ertel.__all__} and len(dir(ertel)) <= 43
    completer = rlcompleter.Completer({"ertel": ertel})
    found = {completer.complete("ertel.", state) for state in range(2 * len(dir(ertel)))}
    assert all(any(str(name).startswith(f"ertel.{shown}") for name in found) for shown in SHOWN.split())
    assert all(inspect.getdoc(getattr(ertel, name)) for name in set(ertel.__all__) - {"__version__"})
    experts = FOR_EXPERTS.split()
    assert all(getattr(ertel, name) is not None for name in experts)
    assert set(experts).isdisjoint(dir(ertel))
    with pytest.raises(AttributeError, match="module 'ertel' has no attribute 'impakt'"):
        _ = ertel.impakt


CHECK = """
from pathlib import Path
from ertel.apps.cases import check
Path("case.toml").write_text('[contact]\\nkind = "{}"\\nM = 200\\nL = 10\\n[solver]\\nmethod = "{}"')
check(Path("case.toml"))
"""
USUAL_UNITS = """
import ertel
from ertel.case.estimates import grid_of
from ertel.results.dataset import assemble_steady
sizes = {"radius": "10 mm", "load": "20 N", "mean_speed": "800 mm/s", "E_prime": "230 GPa"}
case = ertel.rolling(**sizes, oil=ertel.Oil(eta0="40 mPa*s", alpha="22 / GPa"), nodes=33)
assert assemble_steady(case, grid_of(case), ()).sel(X=0.1, method="nearest").X.size == 1
"""


@pytest.mark.parametrize(
    ("code", "heavy"),
    [
        ("import ertel; dir(ertel)", "jax xarray matplotlib zarr pint pydantic scipy numpy"),
        ("import ertel; ertel.impact(M=1, L=1)", "jax xarray matplotlib zarr"),
        ("import ertel.case.case, ertel.case.estimates", "jax"),
        ("import ertel.apps.cli", "jax matplotlib xarray pint distributed"),  # so that `ertel --help` answers at once
        (CHECK.format("rolling", "steady") + CHECK.format("impact", "radial"), "jax xarray matplotlib zarr"),
        (USUAL_UNITS, "jax matplotlib zarr pint"),
    ],
)
def test_what_takes_long_to_import_comes_when_it_is_needed(code, heavy, tmp_path):
    loaded = f"import sys; print([name for name in {heavy.split()} if name in sys.modules])"
    printed = python("-c", f"{code}\n{loaded}", cwd=tmp_path).stdout
    assert printed.splitlines()[-1] == "[]"
    assert "memory" in printed or "check" not in code


FRONT = "the film is not resolved at the front"


def test_warnings_are_given_once_and_stand_in_the_repr(tmp_path):
    case = ertel.impact(**{"M": 200, "L": 10, "nodes": 33, "time_tolerance": 0.01, "until": 1.4})
    for run in (lambda: ertel.simulate(case), lambda: ertel.run(case, tmp_path / "run")):
        with pytest.warns(UserWarning, match=FRONT) as caught:
            result = run()
        assert len([w for w in caught if FRONT in str(w.message)]) == 1
        assert [str(w.message) for w in caught] == result.warnings
        assert all(w.filename == __file__ for w in caught)
        assert f"warning: {FRONT}" in repr(result)
        assert FRONT in result._repr_html_()
    case = ertel.impact(M=200, L=10, method="radial", nodes=129, half_width=4.0, time_tolerance=0.002, until=1.4)
    with warnings.catch_warnings(action="error"):
        assert ertel.simulate(case).warnings == []
