"""Fits: values, errors and words by a model of powers, of which all is known; then runs that are stored and go on."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import tomli_w
from cases import REFUSALS, SMALL
from made_up import BALL_FALLS, dry_impact

import ertel
from ertel.case.case import Case
from ertel.case.status import Status
from ertel.inputs.case_files import ConfigError, parse_case
from ertel.inputs.fits import with_settings
from ertel.optics import CHROMIUM, SILICA, Constant, Interferometer, Layer, Monochromatic, Rig
from ertel.results import alignment
from ertel.results.alignment import light_along
from ertel.results.measurements import Measurement
from ertel.results.profiles import profile
from ertel.runs.fit import FitError, _outcome, fit, solve_fit
from ertel.runs.fit_problem import fit_problem, load_fit_problem
from ertel.runs.fit_result import FitPoint, FitResult
from ertel.runs.result import Result
from ertel.runs.workers import Failure

RINGS = {"method": "radial", "nodes": 17}
CASE = parse_case({**SMALL, "solver": RINGS})
UNKNOWNS: dict[str, Any] = {"lubricant.eta0": ("5 mPa*s", "1 Pa*s"), "lubricant.alpha": ("5 / GPa", "60 / GPa")}
ONE: dict[str, Any] = {"lubricant.eta0": ("5 mPa*s", "1 Pa*s")}
TRUTH = np.array([0.04, 20e-9])
FILM, RESTITUTION = (0.5, 0.5), (-0.07, 0.0)  # exponents of eta0 and alpha, about those of an impact


@dataclass(frozen=True, eq=False)
class Power(Measurement):
    """A number that goes as powers of eta0, alpha and the speed: all that the model computes."""

    powers: tuple[float, float] = FILM
    gridded: float = 0.0  # its relative error on 33 nodes

    def predicted(self, result: Any) -> np.ndarray:
        oil, speed = result.case.oil, result.case.contact.speed / 0.1
        barus = result.case.to_data()["lubricant"]["viscosity"] == "barus"
        alpha = oil.alpha * (1.25 * speed**0.1 if barus else 1.0)  # its films are those of a larger alpha
        error = self.gridded * (32 / (result.case.solver.nodes - 1)) ** 2
        return np.array([np.prod(np.array([oil.eta0, alpha]) ** self.powers) * speed**0.5 * (1.0 + error)])


def measured(powers: tuple[float, float], off: float = 0.0, speed: float = 1.0, sigma: float = 0.01) -> Power:
    value = float(np.prod(TRUTH**powers)) * speed**0.5
    return Power("number", "h_c", np.array([value * (1 + off * sigma)]), sigma=sigma * value, powers=powers)


def model(cases: Sequence[Case], warnings: Sequence[str] = ()) -> Any:
    return [SimpleNamespace(case=case, digest=case.digest, warnings=warnings) for case in cases]


def fitted(*data: Any, unknowns: Any = UNKNOWNS, runner: Any = model, **more: Any) -> FitResult:
    return solve_fit(fit_problem(CASE, data, unknowns, **more), runner)


def test_two_unknowns_their_errors_noise_and_conditions_by_linear_least_squares() -> None:
    found = fitted(measured(FILM), measured(RESTITUTION), measured(FILM))
    assert list(found.values.values()) == pytest.approx(TRUTH, rel=1e-4)
    A = np.array([FILM, RESTITUTION, FILM])
    covariance = np.linalg.inv(A.T @ A / 0.01**2)
    errors = np.sqrt(np.diag(covariance))
    assert found.dataset["relative_error"].values == pytest.approx(errors, rel=0.01)
    assert list(found.standard_errors.values()) == pytest.approx(TRUTH * errors, rel=0.01)
    assert float(found.dataset["correlation"][0, 1]) == pytest.approx(covariance[0, 1] / np.prod(errors), abs=1e-3)
    assert found.case.oil.eta0 == found.values["eta0"] and found.warnings == []
    assert "the data fix eta0*alpha to 1.4 %, alpha/eta0 to 29 %; alone eta0 to 14 %, alpha to 14 %" in repr(found)
    assert found.dataset.attrs["degrees_of_freedom"] == 1
    assert "<table>" in found._repr_html_()
    found = fitted(measured(FILM, 1.0), measured(RESTITUTION, -1.0))
    shift = np.linalg.solve(np.array([FILM, RESTITUTION]), [0.01, -0.01])
    assert np.log(list(found.values.values()) / TRUTH) == pytest.approx(shift, rel=0.02)
    assert found.dataset.attrs["chi_square"] < 1e-4
    fast = measured(FILM, speed=4.0), {"contact.speed": "0.4 m/s"}
    found = fitted(measured(FILM), fast, measured(RESTITUTION))
    assert list(found.values.values()) == pytest.approx(TRUTH, rel=1e-4)
    assert found.dataset["conditions"].values.tolist() == ["", "speed = 0.4 m/s", ""]


def film(eta0: float, speed: float) -> float:
    return 1e-6 * (eta0 * speed) ** 0.67


def test_a_curve_over_the_speed_with_a_common_offset(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """The zero of a rig's spacer is not known: a run at each speed, and one offset for all."""
    rows = [f"{1e3 * speed:.1f};{1e9 * film(0.04, speed) + 12:.4f}" for speed in (0.4, 0.1, 0.2)]
    (tmp_path / "curve.csv").write_text("\n".join(["Rig 2", "speed_mm_per_s;h_c_nm", *rows]).replace(".", ","))
    monkeypatch.setattr(alignment, "number_of", lambda _, run: film(run.case.oil.eta0, run.case.contact.speed))
    curve = Measurement.read(tmp_path / "curve.csv", sigma="1 nm", align="offset")
    assert (curve.kind, curve.along) == ("curve", "speed") and curve.x == pytest.approx([0.1, 0.2, 0.4])
    found = fitted(curve, unknowns=ONE)
    assert found.values["eta0"] == pytest.approx(0.04, rel=1e-3) and "offset 12 nm" in repr(found)
    assert found.dataset["x_unit"].values.tolist() == ["m/s"] * 3 and found.dataset.attrs["runs"] >= 6
    assert found.dataset.attrs["degrees_of_freedom"] == 1
    assert found.plot().axes[0].get_xlabel() == "speed (m/s)"
    with pytest.raises(ConfigError, match=r"contact.speed is an unknown and cannot be a condition"):
        fit_problem(CASE, curve, {"contact.speed": ("0.1 m/s", "1 m/s")})


def test_a_prior_decides_what_the_data_do_not_and_bounds_are_said() -> None:
    found = fitted(measured(FILM), measured(FILM))
    assert "the data do not decide" in found.warnings[0] and "give a prior" in found.warnings[0]
    with_prior = {**UNKNOWNS, "lubricant.alpha": {"bounds": ["5 / GPa", "60 / GPa"], "prior": ["20 / GPa", "2 / GPa"]}}
    found = fitted(measured(FILM), unknowns=with_prior)
    assert list(found.values.values()) == pytest.approx(TRUTH, rel=1e-3)
    assert found.standard_errors["alpha"] == pytest.approx(2e-9, rel=0.01)
    assert found.warnings[0].endswith("the prior does, to 20 %")
    low = {**UNKNOWNS, "lubricant.eta0": ("5 mPa*s", "20 mPa*s")}
    bound, unexplained = fitted(measured(RESTITUTION), measured(FILM), measured(FILM, 30.0), unknowns=low).warnings
    assert bound == "eta0 ends at its bound, 20 mPa*s: widen it, or doubt the case"
    assert unexplained.startswith("the case does not explain the data: the residuals are ")


def test_warnings_of_the_runs_and_the_law_are_said() -> None:
    """Chi square does not see a wrong law."""
    found = fitted(measured(FILM), measured(RESTITUTION), runner=partial(model, warnings=["the film is thin"]))
    assert any("the film is thin" in warning for warning in found.warnings)
    assert "alpha is that of the roelands law, which is 22 to 25 % too high" in repr(found)
    assert "the data fix eta0" in repr(found)
    unexplained = fitted(measured(FILM, 1e4), unknowns=ONE)
    assert "the data fix" not in repr(unexplained) and "roelands" not in repr(unexplained)


def test_runs_that_fail_are_stepped_back_from_or_said() -> None:
    asked = []

    def fails_once(cases: Sequence[Case]) -> Any:
        asked.append(cases[0].oil.eta0)
        return [Failure("no film") if len(asked) == 2 else case for case in model(cases)]  # 17 rings have no half

    found = fitted(measured(FILM), measured(RESTITUTION), runner=fails_once)
    assert asked[0] == 0.01 < asked[2] < asked[1] and found.values["eta0"] == pytest.approx(0.04, rel=1e-3)
    with pytest.raises(FitError, match=r"lubricant.eta0 = 10 mPa\*s, .* failed: no film"):
        fitted(measured(FILM), measured(RESTITUTION), runner=lambda cases: [Failure("no film")] * len(cases))

    def fails_later(cases: Sequence[Case]) -> Any:
        near = cases[1].oil.eta0 / cases[0].oil.eta0 < 1.005
        return [Failure("no space left")] * len(cases) if near else model(cases)

    exact = measured(FILM, sigma=1e-4), measured(RESTITUTION, sigma=1e-4)
    with pytest.raises(FitError, match=r"cannot go on with smaller steps: .* failed: no space left"):
        fitted(*exact, runner=fails_later)


@pytest.mark.parametrize(("unknowns", "sentence"), REFUSALS["unknowns"], ids=str)
def test_unknowns_that_are_refused(unknowns: Any, sentence: str) -> None:
    with pytest.raises(ConfigError, match=sentence):
        fit_problem(CASE, measured(FILM), unknowns)


@pytest.mark.parametrize(
    ("data", "sentence"),
    [
        (5, r"measurements = 5: must be a Measurement, or a list of them"),
        ("film.csv", r"measurements = 'film.csv': must be a Measurement"),
        ([0.87], r"measurements\[1\] = 0.87: must be a Measurement"),
        ([Measurement.number("restitution", 0.87)], r"measurements\[1\], restitution: sigma = None: must be given"),
        ([(measured(FILM), {"lubricant.eta0": "1 Pa*s"})], r"\[1\], measurement: lubricant.eta0 is an unknown"),
        ([(measured(FILM), {"lubricant.reference": "a rheometer"})], r"reference = 'a rheometer': changes nothing"),
        ([measured(FILM), (measured(FILM), {"contact.sped": "1 m/s"})], r"contact.sped = .*did you mean speed"),
    ],
)
def test_measurements_that_are_refused(data: Any, sentence: str) -> None:
    with pytest.raises(ConfigError, match=sentence):
        fit_problem(CASE, data, UNKNOWNS)


NAMED: dict[str, Any] = {
    "contact": {"radius": "10 mm", "material_1": "steel", "material_2": "steel", "drop_height": "10 mm"},
    "lubricant": {"oil": "squalane", "temperature": "40 degC"},
    "solver": RINGS,
}


@pytest.mark.parametrize(
    ("section", "key", "value"),
    [("lubricant", "temperature", "80 degC"), ("lubricant", "oil", "pao-100"), ("contact", "material_2", "glass")],
)
def test_conditions_that_are_names_are_resolved(section: str, key: str, value: str, tmp_path: Path) -> None:
    """Otherwise data of several temperatures were compared with one run."""
    expected = parse_case({**NAMED, section: {**NAMED[section], key: value}})
    data = [measured(FILM), (measured(FILM), {f"{section}.{key}": value})]
    (tmp_path / "ball.toml").write_text(tomli_w.dumps(NAMED))
    for case in (NAMED, tmp_path / "ball.toml"):
        problem = fit_problem(case, data, {"contact.radius": ("5 mm", "20 mm")})
        known, found = problem.cases(np.array([0.01]))
        assert known.digest != found.digest
        assert (found.contact, found.oil, found.solver) == (expected.contact, expected.oil, known.solver)


def test_the_error_of_the_grid_is_part_of_the_noise() -> None:
    fine = replace(CASE, solver=replace(CASE.solver, nodes=33))
    off = replace(measured(FILM), gridded=0.05)  # by five standard deviations
    found = solve_fit(fit_problem(fine, [off, measured(FILM)], ONE), model)
    assert found.warnings == [] and found.dataset.attrs["chi_square"] < 1.0
    value = off.values[0]
    assert found.dataset["grid_error"].values == pytest.approx([0.05 * value, 0.0], rel=0.02)
    assert "the error of the grid is in the noise: 5 sigma as a rule, 5 at most" in repr(found)
    expected = 0.04 * 20e-9 / CASE.oil.alpha
    assert abs(found.values["eta0"] / expected - 1.0) < 0.01  # the datum without it decides
    both = solve_fit(fit_problem(fine, [off] * 100, ONE), model)  # a hundred data have it together
    assert float(both.dataset["relative_error"][0]) == pytest.approx(0.1, rel=0.06)
    assert "the data fix eta0 to 10 %" in repr(both) or "the data fix eta0 to 9" in repr(both)
    alone = fitted(measured(FILM), measured(FILM), unknowns=ONE)
    assert "the error of the grid is not in the noise: solver.nodes = 9: must be" in repr(alone)


def test_laws_side_by_side() -> None:
    laws = ["roelands", "barus"]
    found = fitted(measured(FILM), measured(RESTITUTION), laws=laws)
    assert found.dataset["law"].values.tolist() == laws
    alphas = found.dataset["value_under"].sel(unknown="alpha").values
    assert alphas == pytest.approx([20e-9, 16e-9], rel=1e-3) and found.values["alpha"] == alphas[0]
    assert found.dataset["chi_square_under"].values == pytest.approx([0.0, 0.0], abs=1e-4)
    assert "under barus: eta0 = 40 mPa*s" in repr(found) and "alpha = 16 /GPa" in repr(found)
    assert "the data do not tell these laws apart: measure at a second speed" in repr(found)
    assert found.as_data()["laws"][0].startswith("under roelands: ") and "law" not in found.rows()[0]
    data = [(measured(FILM, speed=speed), {"contact.speed": f"{0.1 * speed} m/s"}) for speed in (0.1, 1.0, 10.0)]
    apart = fitted(*data, measured(RESTITUTION), laws=("barus", "roelands"))
    assert "the data speak for roelands: twice the log of the likelihood is larger by " in repr(apart)
    assert apart.case.to_data()["lubricant"]["viscosity"] == "barus"
    assert "fit laws = " in repr(fitted(measured(FILM), measured(RESTITUTION)))


@pytest.mark.parametrize("laws", [["barus", "roeland"], [5, "barus"], "roeland", 5])
def test_laws_that_are_refused(laws: Any) -> None:
    with pytest.raises(ConfigError, match=r"^laws = .*(did you mean roelands|allowed: )"):
        fit_problem(CASE, measured(FILM), ONE, laws)
    rough = ertel.impact(M=20, L=5, roughness=[ertel.Spot(0.3, 0.1)])
    with pytest.raises(ConfigError, match=r"^roughness.radius: roughness is not a table .in the case with roughness"):
        with_settings(rough, {"roughness.radius": 0.2})


DRY = dry_impact(BALL_FALLS, radial=True, rebound=False)
BALL = parse_case(BALL_FALLS)  # eta0 = 0.1 Pa s
START, SOUGHT = replace(BALL, oil=replace(BALL.oil, eta0=0.08)), {"lubricant.eta0": ("50 mPa*s", "200 mPa*s")}


def dry_films(cases: Sequence[Case]) -> list[Result]:
    """The dry impact with a film that goes as the root of eta0."""
    films = [DRY.assign(H=DRY["H"] + 0.1 * ((case.oil.eta0 / 0.1) ** 0.5 - 1.0)) for case in cases]
    return [Result(case, film, {"warnings": []}, Status.CONVERGED) for case, film in zip(cases, films, strict=True)]


def test_frames_by_a_clock_that_began_earlier() -> None:
    """The films of a run that starts from a larger gap, by a camera that shows 23 us at the touch, give the oil."""
    x, late = np.linspace(-2e-4, 2e-4, 21), {n: (n, DRY[n].values + 0.66, DRY[n].attrs) for n in ("time", "frame")}
    rng, frames = np.random.default_rng(2), []
    for t in (-10e-6, 5e-6):
        line = profile(DRY.assign_coords(late), f"{t!r} s")
        h = np.interp(x, line["x"], line["h"]) + 5e-9 * rng.standard_normal(21)
        frames.append(Measurement("profile", "h", h, x, 5e-9, at=f"{t + 23e-6!r} s", align="start"))
    problem = fit_problem(START, frames, SOUGHT)
    starts = {each.start for each, _ in problem.on_clocks(dry_films([BALL]))}
    assert problem.aligned == len(starts) == 1 and starts.pop() == pytest.approx(23e-6, abs=0.05e-6)
    known = [replace(each, align=(), start="23 us") for each in frames]
    found = solve_fit(fit_problem(START, known, SOUGHT), dry_films)
    assert abs(found.values["eta0"] - 0.1) < 3 * found.standard_errors["eta0"] < 0.02 and found.warnings == []
    assert "start 23 µs" in found.dataset.attrs["aligned"]
    wrong = solve_fit(fit_problem(START, [replace(each, align=()) for each in frames], SOUGHT), dry_films)
    assert "ends at its bound" in wrong.warnings[0] and "does not explain" in wrong.warnings[1]


RIG = Interferometer(light=Monochromatic(633e-9))


def fringes(result: Any, case: Case, x: np.ndarray, gain: float, background: float, seed: int) -> dict[str, Any]:
    """The light of a film with 1 % noise."""
    truth = light_along(result, case, RIG)
    noise = 0.004 * np.random.default_rng(seed).standard_normal(len(x))
    seen = background + gain * (np.interp(x, truth["x"], truth) + noise)
    return {"kind": "profile", "quantity": "intensity", "values": seen, "x": x, "sigma": 0.004 * gain, "optics": RIG}


def test_fringes_give_the_film_and_the_oil(tmp_path: Path) -> None:
    """Of unknown gain and background."""
    light = Measurement(**fringes(profile(DRY), BALL, np.linspace(-2.5e-4, 2.5e-4, 101), 180.0, 30.0, 3))
    found = solve_fit(fit_problem(START, light, SOUGHT), dry_films)
    assert "measurement 1, " in found.dataset.attrs["aligned"] and "background" in repr(found)
    error = found.standard_errors["eta0"]
    assert abs(found.values["eta0"] - 0.1) < 2 * error < 0.002 and found.warnings == []
    assert found.dataset.attrs["degrees_of_freedom"] == 101 - 2 - 1
    assert found.dataset["predicted"].values == pytest.approx(light.values, abs=5.0)
    found.to_csv(tmp_path / "fit.csv")
    title = found.plot().axes[0].get_title()
    for text in (found.dataset["aligned"].values[0], (tmp_path / "fit.csv").read_text(), title):
        assert "gain 179" in text and "background " in text


@pytest.mark.parametrize("kind", ["Damaged", "StoreError"])
def test_a_damaged_run_ends_a_fit(kind: str, tmp_path: Path) -> None:
    """The search does not step back from it, as from a run that fails, and end at another oil without a word."""
    case = ertel.impact(M=20, L=5, method="radial", nodes=33)
    with pytest.raises(FitError, match=rf"tau_y: is damaged; delete {tmp_path}.*, and the same call computes the run"):
        _outcome(tmp_path, case, f"failed: {kind}: tau_y: is damaged")
    assert _outcome(tmp_path, case, "failed: ValueError: no film").reason.endswith("ValueError: no film")


LISTS = """
case = "ball.toml"
[unknowns]
"lubricant.eta0" = { bounds = ["5 mPa*s", "1 Pa*s"] }
[[measurements]]
quantity = "h_c"
value = ["100 nm", "200 nm"]
sigma = "2 nm"
set = { "contact.speed" = ["0.1 m/s", "0.2 m/s"] }
"""
FRINGES = """
[[measurements]]
file = "fringes.csv"
wavelength = "633 nm"
coatings = "chromium 10 nm, silica 200 nm, 2.1 50 nm"
index = 1.45
sigma = 2
"""


def test_a_file_with_lists_is_one_measurement_for_each_value(tmp_path: Path) -> None:
    (tmp_path / "ball.toml").write_text(ertel.to_toml(CASE))
    (tmp_path / "fringes.csv").write_text("x_um,intensity (counts)\n0,10\n1,20\n2,15\n3,10\n")
    (tmp_path / "fit.toml").write_text(LISTS + FRINGES)
    *_, (light, _) = load_fit_problem(tmp_path / "fit.toml").data
    coatings = (Layer(CHROMIUM, 10e-9), Layer(SILICA, 200e-9), Layer(Constant(2.1), 50e-9))
    assert light.optics == Interferometer(Rig(coatings=coatings, oil_index=1.45), Monochromatic(633e-9))
    assert light.align == ("gain", "background") and light.values.tolist() == [10, 20, 15, 10]
    (tmp_path / "fit.toml").write_text('laws = ["roelands", "barus"]' + LISTS)
    assert list(load_fit_problem(tmp_path / "fit.toml").others) == ["barus"]
    (tmp_path / "fit.toml").write_text(LISTS)
    problem = load_fit_problem(tmp_path / "fit.toml", ["solver.nodes=33"])
    assert problem.case.solver.nodes == 33
    found = [(each.values.tolist(), each.sigma, index) for each, index in problem.data]
    assert found == [([1e-7], 2e-9, (0,)), ([2e-7], 2e-9, (1,))]
    assert problem.conditions == ({"contact.speed": "0.1 m/s"}, {"contact.speed": "0.2 m/s"})
    for *wrong, sentence in REFUSALS["fit_files"]:
        (tmp_path / "fit.toml").write_text((LISTS + FRINGES).replace(*wrong))
        with pytest.raises(ConfigError, match=sentence):
            load_fit_problem(tmp_path / "fit.toml")


@pytest.mark.slow
def test_fringes_of_an_impact_decide_viscosity_and_pressure_viscosity_coefficient() -> None:
    """Forty fringes of 33 rings fix both to less than 0.3 %, with the error of the grid, and within two such errors."""
    case = {
        "contact": {**NAMED["contact"], "material_2": "glass"},
        "lubricant": {"eta0": "99 mPa*s", "alpha": "21.8 / GPa"},
    }
    case |= {"solver": {"method": "radial", "nodes": 33}, "time": {"start_approach": -1.5, "until": "max-approach"}}
    truth = ertel.simulate({**case, "lubricant": {"eta0": "100 mPa*s", "alpha": "22 / GPa"}})
    seen = fringes(truth.profile(), truth.case, np.linspace(-250e-6, 250e-6, 301), 150.0, 40.0, 0)
    found = fit(case, Measurement(**seen, at="max-approach", align="centre"), UNKNOWNS)
    errors = np.array(list(found.standard_errors.values()))
    assert np.all(np.abs(np.array(list(found.values.values())) - [0.1, 22e-9]) < 2 * errors) and found.warnings == []
    assert np.all(found.dataset["relative_error"].values < 3e-3)


@pytest.mark.slow
def test_measured_frames_give_the_oil_whatever_the_gap_at_the_start_and_the_clock() -> None:
    """Films from a gap of 1.66, by a clock that shows 23 us at the touch; the runs of the fit start from a gap of 1."""
    ball = {**NAMED["contact"], "material_2": "glass", "method": "radial", "half_width": 2.5}
    ball |= {"until": "max-approach", "time_tolerance": 1e-4}
    truth = ertel.simulate(ertel.impact(**ball, oil=ertel.Oil(0.135, 24e-9), start_approach=-1.66, nodes=65))
    x, rng, frames = np.linspace(-1.5e-4, 1.5e-4, 31), np.random.default_rng(0), []
    for t in (10e-6, 25e-6, 40e-6):
        line = truth.profile(f"{t!r} s")
        h = np.interp(x, line["x"], line["h"])
        seen = h * (1 + 0.005 * rng.standard_normal(31))
        frames.append(Measurement("profile", "h", seen, x, 0.005 * h, at=f"{t + 23e-6!r} s", align="start"))
    start = ertel.impact(**ball, oil=ertel.Oil(0.1, 20e-9), start_approach=-1.0, nodes=33)
    found = fit(start, frames, UNKNOWNS)
    off = np.array(list(found.values.values())) - [0.135, 24e-9]
    assert np.all(np.abs(off) < 3 * found.dataset["standard_error"].values)
    assert np.all(found.dataset["relative_error"].values < 0.2)
    assert not any("bound" in warning or "does not explain" in warning for warning in found.warnings)


@pytest.mark.parametrize(("data", "grid"), [(1, 1.0), (2, 3.0), (5, 0.5)])
def test_the_error_of_the_grid_counts_once(data: int, grid: float) -> None:
    """One unknown: the variance is that of the mean of independent noise, and the square of the error of the grid."""
    sigma, ones = np.hypot(1.0, grid), np.ones(data)
    bounds, prior = np.array([[0.5], [2.0]]), np.array([[np.nan], [np.nan]])
    seen, share = ones[:, None] / sigma, grid / sigma * ones
    point = FitPoint(("eta0",), ("Pa*s",), np.ones(1), bounds, prior, 0.0 * ones, seen, 0, share)
    expected = 1.0 / data + grid**2
    assert point.covariance[0, 0] == pytest.approx(expected)
    assert point.products[0][0] ** 2 == pytest.approx(expected)
