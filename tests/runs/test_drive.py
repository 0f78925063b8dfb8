"""The loop: events, maps, giving up, rigs, summary, progress and warnings."""

import io
import itertools
from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

import jax
import numpy as np
import pytest
from cases import impact, march
from rich.console import Console

import ertel
from ertel.equations.approach import ClosureLine, NewtonsLaw
from ertel.physics.motion import constant
from ertel.physics.registry import OIL_LAWS
from ertel.results.summary import with_error
from ertel.runs.drive import LogLines, bars, drive, result_of, run_of, simulate, watch
from ertel.runs.stepping import TransientRun
from ertel.solvers.radial import RadialImpact
from ertel.solvers.transient import Transient2D


def test_maps_lie_at_exact_times_and_events_are_kept() -> None:
    result = simulate(impact(200, 10, 33, output={"interval": 0.25}, time={"until": 2.75}))
    peak, data = result.summary, result.dataset
    times, events = data.frame.values, data.event.values
    np.testing.assert_allclose(times[events == 0], 0.25 * np.arange(1, 11), rtol=1e-12)  # 2.75 is the end
    assert np.sum(events == 1) == 1 and np.sum(events == 2) == 1
    assert float(data.time[-1]) == pytest.approx(2.75, rel=1e-12)
    assert peak["Delta"] >= float(data.Delta.max()) - 1e-9
    i = int(data.Delta.values.argmax())
    assert float(data.time[i - 1]) < peak["T"] < float(data.time[i + 1])
    frame = data.isel(frame=int((data.event == 1).values.argmax()))
    assert float(frame.H.isel(X=16, Y=16)) == pytest.approx(peak["H_c"], rel=1e-14)


def test_first_contact_is_resolved_automatically() -> None:
    """The step falls by itself when the oil stiffens and grows again later."""
    data = simulate(impact(1000, 10, 33, solver={"method": "radial"})).dataset
    dT = data.dT.values
    contact = int(np.argmax(data.F.values > 0.01))
    assert dT[:contact].max() > 2.5 * dT[contact : contact + 10].min()
    assert dT[-3:].max() > 1.5 * dT[contact : contact + 10].min()


@pytest.mark.parametrize("method", [Transient2D, RadialImpact])
def test_a_rig_may_prescribe_the_approach(method: type[Transient2D] | type[RadialImpact]) -> None:
    """Pressed in and held: the load is that of a dry ball pressed in further, by a part of the film that stays."""

    def motion(T: float) -> float:
        return -1.0 + 1.5 * np.sin(np.pi / 2 * min(T / 1.5, 1.0))

    class Rig(NewtonsLaw):
        def line(self, T: float, *_: Any) -> ClosureLine:
            return ClosureLine(1.0, 0.0, motion(T))

    case = impact(200, 10, 33, time={"until": 2.5, "tolerance": 1e-3})
    pressed = method(case)
    pressed.closure = Rig(case.motion.inertia, case.motion.load)
    data = result_of(TransientRun(case, pressed)).dataset
    np.testing.assert_allclose(data.Delta.values, [motion(T) for T in data.time.values], atol=1e-12)
    H_c = float(data.H_c[-1])
    assert H_c > 0.1
    assert 0.5**1.5 < float(data.F[-1]) < (0.5 + H_c) ** 1.5


@pytest.mark.slow
def test_a_rig_may_press_with_a_given_load() -> None:
    """A law in which Delta has no weight, for bodies that start apart."""
    method = Transient2D(impact(20, 5, 33, time={"start_approach": -0.3}))
    method.closure = NewtonsLaw(0.0, constant(0.3))
    for level in march(method, 0.1, 2)[:2]:
        assert method.measure(level)["F"] == pytest.approx(0.3, rel=1e-5)


def test_progress_goes_from_nothing_to_all() -> None:
    for until in ("max-approach", "rebound", 2.0):
        run = run_of(impact(200, 10, 33, solver={"method": "radial"}, time={"until": until}))
        shares: list[float] = []
        drive(run, [lambda step, run=run, shares=shares: shares.append(run.progress(step).done)])
        assert 0 <= shares[0] < 0.05
        assert shares[-1] > 0.75
        assert all(a <= b for a, b in itertools.pairwise(shares))


def test_warnings_speak_where_they_should() -> None:
    coarse = simulate(impact(1000, 10, 33, time={"until": 1.2}))
    assert any("pressure sweep" in w for w in coarse.summary["warnings"])
    thin = simulate(impact(1000, 10, 33))
    assert any("the film vanishes" in w for w in thin.summary["warnings"])
    assert thin.status.value == thin.summary["status"] == "the film vanishes on this grid"
    assert (thin.summary["budgets"], thin.summary["extremes"]) == ({}, {})
    near = simulate(impact(200, 10, 33, time={"start_approach": -0.2, "until": 1.0}))
    assert any("initial gap" in w for w in near.summary["warnings"])


def test_error_estimate_is_exact_for_the_orders_that_it_assumes() -> None:
    def at(h: float, step: float, width: float) -> dict[str, Any]:
        H_c = 0.07 + 3 * h**2 - 2 * step**2 + 0.01 / width**3
        near = {"H_c": H_c, "H_min": 0.01 - h**2, "Delta": 0.96 + h**2 + 0.05 / width**3}
        return {**near, "restitution": 0.9 - 0.2 * h + 30 * step**2, "F_max": 0.8 + h**2 - step**2}

    fine = at(0.01, 0.01, 2.0)
    others = {"grid": at(0.02, 0.01, 2.0), "time": at(0.02, 0.01 * 0.5**0.5, 2.0), "domain": at(0.02, 0.01, 3.0)}
    case = impact(200, 10, 33)
    found = with_error(case, fine, others)["error_estimate"]
    assert found["H_c"]["extrapolated"] == pytest.approx(0.07, rel=1e-12)
    parts = {"grid": -3e-4, "time": 2e-4, "domain": -0.00125}
    assert {name: found["H_c"][name] for name in parts} == pytest.approx(parts, rel=1e-9)
    assert found["H_c"]["error"] == pytest.approx(0.00135, rel=1e-9)  # more than independent parts would have
    assert found["F_max"]["error"] == pytest.approx(2**0.5 * 1e-4, rel=1e-9)  # and not zero, where the parts cancel
    assert found["restitution"]["extrapolated"] == pytest.approx(0.9, rel=1e-12)
    assert found["restitution"]["error"] == pytest.approx((0.002**2 + 0.003**2) ** 0.5, rel=1e-9)
    assert [found[name]["dominant"] for name in ("H_c", "H_min", "Delta")] == ["domain", "grid", "domain"]
    assert found["Delta"]["value"] == fine["Delta"]
    assert with_error(case, fine, {**others, "time": {"H_c": None}})["error_estimate"] is None


def test_a_log_tells_of_a_study_as_a_whole() -> None:
    file, clock = io.StringIO(), [0.0]
    shown = LogLines(Console(file=file, width=40), lambda: clock[0])
    whole = shown.add_task("runs", total=4, message="")
    for done in range(3):
        part = shown.add_task("a1b2c3d4", total=1.0, message="T 0.500  step 12")
        clock[0] += 40.0
        shown.update(part, completed=0.4)
        clock[0] += 30.0
        shown.remove_task(part)
        shown.update(whole, advance=1, message=f"run {done} converged")
    assert file.getvalue().splitlines() == [
        "runs  25%  run 0 converged  70 s so far",
        "runs  50%  run 1 converged  2 min so far, about 2 min left",
        "runs  75%  run 2 converged  4 min so far, about 70 s left",
    ]


@pytest.mark.parametrize(("platform", "label"), [("cpu", "impact"), ("gpu", "impact on Made-up 9000")])
def test_the_bar_names_a_device_that_is_not_the_cpu(platform: str, label: str, monkeypatch: pytest.MonkeyPatch) -> None:
    device = SimpleNamespace(platform=platform, device_kind="Made-up 9000")
    monkeypatch.setattr("ertel.runs.compile.jax_devices", lambda: [device])
    with bars(False) as shown:
        watch(shown, SimpleNamespace(case=impact(200, 10, 33)))  # type: ignore[arg-type]
    assert [task.description for task in shown.tasks] == [label]


@dataclass(frozen=True)
class Own:
    """Viscosity and shear thinning by NumPy, which JAX cannot trace; a density with an infinite slope at p = 0."""

    def viscosity(self, p: Any) -> Any:
        return np.exp(2e-8 * p)

    def density(self, p: Any) -> Any:
        return 1.0 + 1e-6 * p**0.5

    def fluidity(self, stress: Any, pressure: Any) -> Any:
        return np.cosh(stress / 5e6)

    def stress(self, rate: Any, pressure: Any) -> Any:
        return rate


@pytest.mark.parametrize(
    ("law", "said"),
    [
        ("viscosity", "is computed by numpy, .* write jax.numpy in"),
        ("rheology", "is computed by numpy, .* write jax.numpy in"),
        ("density", "the slope inf at p = 0; both must be finite"),
    ],
)
def test_a_law_that_jax_cannot_differentiate_is_refused_when_its_case_is_made(monkeypatch, law, said):
    monkeypatch.setitem(OIL_LAWS[law]._records, "own", Own)
    contact = {"radius": "10 mm", "load": "20 N", "mean_speed": "1 m/s", "E_prime": "220 GPa"}
    refused = pytest.raises(ertel.ConfigError, match=f"^lubricant.{law}: .*{said}")
    with refused, jax.transfer_guard("disallow"), jax.numpy_dtype_promotion("strict"), jax.debug_nans(True):
        ertel.rolling(**contact, nodes=17, oil=ertel.Oil(eta0=0.04, alpha=2e-8, **{law: Own()}))


def test_a_notebook_without_widgets_has_a_line_and_no_warning(monkeypatch, capsys, recwarn):
    monkeypatch.setattr("rich.console._is_jupyter", lambda: True)
    monkeypatch.setattr("ertel.runs.drive.find_spec", lambda name: None)
    with bars(True) as shown:
        bar = shown.add_task("ball", total=1.0, message="compiling")
        shown.update(bar, completed=1.0, message="grid 65")
    assert capsys.readouterr().err == "ball  100%  grid 65  0 s so far\n" and not recwarn.list
