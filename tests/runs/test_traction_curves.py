"""Traction curves in memory: each point is the friction of its own steady contact."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import xarray as xr
from cases import STEEL_BODIES

from ertel.case.case import Case
from ertel.case.sections import Drive
from ertel.inputs.case_files import ConfigError, parse_case
from ertel.physics.motion import constant
from ertel.runs.traction import traction
from ertel.solvers import steady
from ertel.solvers.heat import heated

CONTACT = {"kind": "rolling", "radius": "10 mm", "E_prime": "226 GPa", "load": "20 N"}  # that of test_thinning
OIL = {"eta0": "40 mPa*s", "alpha": "20 / GPa"}
EYRING = {"law": "ree-eyring", "tau0": "2 MPa"}
FRICTION = ("mu_sliding", "mu_rolling", "mu_1", "mu_2", "power_loss", "tau_max")


def physical(rheology: Any = "newtonian", **speeds: Any) -> Case:
    contact = {**CONTACT, **(speeds or {"mean_speed": "1 m/s"})}
    return parse_case({"contact": contact, "lubricant": {**OIL, "rheology": rheology}, "solver": {"nodes": 33}})


@pytest.fixture(scope="module")
def newtonian() -> Any:
    return traction(physical(), slide_to_roll="-0.1:0.2:4")


@pytest.fixture(scope="module")
def eyring() -> Any:
    return traction(physical(EYRING), slide_to_roll=[-0.1, 0.0, 0.1])


@pytest.mark.parametrize("oil", ["newtonian", pytest.param("eyring", marks=pytest.mark.slow)])
def test_no_sliding_is_no_traction_and_negative_sliding_mirrors_it(oil: str, request: pytest.FixtureRequest) -> None:
    data = request.getfixturevalue(oil).dataset
    assert float(data["mu_sliding"].sel(slide_to_roll=0.0)) == 0.0
    back, forth = (data.sel(slide_to_roll=S) for S in (-0.1, 0.1))
    assert forth["mu_sliding"] > 0
    for one, sign, other in (("mu_sliding", -1, "mu_sliding"), ("mu_1", 1, "mu_2"), ("power_loss", 1, "power_loss")):
        assert float(back[one]) == pytest.approx(sign * float(forth[other]), rel=1e-9)


def test_the_power_is_that_of_the_forces(newtonian: Any) -> None:
    """Sliding spends mu F (u1 - u2), on top of what rolling spends."""
    data = newtonian.dataset
    spent = data["power_loss"] - data["power_loss"].sel(slide_to_roll=0.0)
    F, u_m = 20.0, 1.0
    np.testing.assert_allclose(spent, data["mu_sliding"] * F * data["slide_to_roll"] * u_m, rtol=1e-6, atol=1e-12)
    assert "solved once" in newtonian.dataset.attrs["film"]
    each = traction(physical(), slide_to_roll=[-0.1, 0.2], film="each")
    once = newtonian.dataset.isel(slide_to_roll=[0, -1])
    xr.testing.assert_allclose(each.dataset[[*FRICTION]], once[[*FRICTION]], rtol=1e-12)
    assert newtonian.dataset["newton_iterations"].sum() == each.dataset["newton_iterations"].sum() / 2


@pytest.mark.slow
def test_each_point_of_an_oil_that_thins_has_its_own_film(eyring: Any) -> None:
    data = eyring.dataset
    assert data.attrs["film"] == "solved for each point"
    assert (data["newton_iterations"] > 0).all()
    still, sliding = (float(data["h_c"].sel(slide_to_roll=S)) for S in (0.0, 0.1))
    assert sliding < still
    once = traction(physical(EYRING), slide_to_roll=[0.0, 0.1], film="once").dataset
    assert once["h_c"].values.tolist() == [still, still]
    assert float(once["mu_sliding"][1]) == pytest.approx(float(data["mu_sliding"][2]), rel=0.02)
    assert float(once["mu_sliding"][1]) != float(data["mu_sliding"][2])


@pytest.mark.parametrize("axis", [pytest.param("mean_speed", marks=pytest.mark.slow), "load"])
def test_a_point_over_the_speed_or_the_load_is_its_own_case(axis: str) -> None:
    base = physical(mean_speed="1 m/s", slide_to_roll=0.05)
    value = 2.0 * getattr(base.contact, axis)
    at = replace(base, contact=replace(base.contact, **{axis: value}))
    film = steady.steady_film(at).finest
    found = film.account.friction
    data = traction(base, **{axis: [0.5 * value, value]}).dataset.isel({axis: 1})  # each with scales of its own
    assert float(data[axis]) == value
    assert at.scales is not None
    assert float(data["mu_sliding"]) == pytest.approx(float(found.sliding[0]) * at.scales.a_over_R, rel=1e-9)
    assert float(data["power_loss"]) == pytest.approx(float(found.power) * at.scales.power, rel=1e-9)
    assert float(data["h_c"]) == pytest.approx(film.measure()["H_c"] * at.scales.film, rel=1e-9)
    hersey = at.oil.eta0 * at.contact.speeds.mean / at.scales.p_h
    assert float(data["hersey"]) == pytest.approx(hersey, rel=1e-12) and data["hersey"].attrs["units"] == "m"


@pytest.mark.slow
def test_a_dimensionless_case(newtonian: Any) -> None:
    si = physical()
    assert si.scales is not None
    contact = {"kind": "rolling", "M": si.parameters.M, "L": si.parameters.L}
    case = parse_case({"contact": contact, "lubricant": OIL, "solver": {"nodes": 33}})
    curve = traction(case, slide_to_roll=[0.0, 0.1])
    assert "a/R" in repr(curve) and "a/R" in curve._repr_html_()
    mu = curve.dataset["mu_sliding"] * si.scales.a / si.scales.R  # the same contact in SI
    np.testing.assert_allclose(mu[1], newtonian.dataset["mu_sliding"].sel(slide_to_roll=0.1), rtol=1e-9)
    sliding = traction(replace(case, drive=Drive(slide_to_roll=0.3)), slide_to_roll=[0.1])
    assert float(sliding.dataset["mu_sliding"][0]) == pytest.approx(float(curve.dataset["mu_sliding"][1]), rel=1e-9)


HOT = {"temperature": "313.15 K", "conductivity": "0.14 W/(m*K)", "beta": "0.035 / K"} | STEEL_BODIES


def test_heat_lowers_the_traction(newtonian: Any) -> None:
    """Each point has the friction of the warm film at its own slide-to-roll ratio; a Newtonian film serves all."""
    case = physical()
    warm_case = parse_case({**case.to_data(), "thermal": HOT | {"inlet": "gupta"}})
    curve = traction(warm_case, slide_to_roll=[0.0, 0.1])
    data, cold = curve.dataset, newtonian.dataset.sel(slide_to_roll=[0.0, 0.1])
    np.testing.assert_allclose(data["mu_sliding"], cold["mu_sliding"], rtol=1e-12)
    assert abs(data["mu_sliding_warm"][0]) < 1e-9
    assert 0.0 < float(data["mu_sliding_warm"][1]) < float(cold["mu_sliding"][1])
    assert data["newton_iterations"].values.tolist()[1] == 0
    at = replace(warm_case, contact=replace(warm_case.contact, slide_to_roll=0.1))
    assert at.scales is not None
    film = steady.steady_film(warm_case).finest
    found = heated(at, film.P, film.H, grid=film.grid)
    assert float(data["mu_sliding_warm"][1]) == pytest.approx(float(found.sliding[0]) * at.scales.a_over_R, rel=1e-9)
    assert float(data["T_film_max"][1]) == pytest.approx(float(np.max(found.T_film)), rel=1e-9)
    np.testing.assert_allclose(data["h_c_warm"], data["phi_T"] * cold["h_c"], rtol=1e-12)
    spent = data["power_loss_warm"] - data["power_loss_warm"][0]
    np.testing.assert_allclose(spent, data["mu_sliding_warm"] * 20.0 * data["slide_to_roll"], rtol=1e-6, atol=1e-9)
    for part in ("mu_sliding_warm", "T_film_max (degC)", "have the heat"):
        assert part in repr(curve)
    panels = {axes.get_ylabel(): axes for axes in curve.plot().axes}
    assert len(panels) == 6
    shown = panels["temperature (°C)"].lines[0].get_ydata()
    np.testing.assert_allclose(shown, data["T_film_max"] - 273.15, rtol=1e-12)


IMPACT = parse_case({"contact": {"M": 20, "L": 10}, "solver": {"nodes": 33}})
DIMENSIONLESS = parse_case({"contact": {"kind": "rolling", "M": 20, "L": 10}, "solver": {"nodes": 33}})


@pytest.mark.parametrize(
    ("case", "given", "said"),
    [
        (physical(), {}, "exactly one of slide_to_roll, mean_speed, load; got none"),
        (physical(), {"slide_to_roll": [0], "load": [1]}, "got slide_to_roll and load"),
        (physical(), {"load": "1:5"}, "load = .*FIRST:LAST:NUMBER"),
        (physical(), {"mean_speed": [1.0, 900.0]}, 'at mean_speed = "900.0 m/s": solver.half_width .* give it there'),
        (physical(), {"mean_speed": [1.0], "film": "once"}, "film depends on mean_speed"),
        (physical(), {"slide_to_roll": [0.0], "film": "twice"}, "film = .twice.: allowed: each, once"),
        (IMPACT, {"slide_to_roll": [0.1]}, 'solver.method = "2d": .* steady contact'),
        (DIMENSIONLESS, {"load": [1.0]}, "load = .*dimensionless"),
        (replace(physical(), drive=Drive(load=constant(2.0))), {"load": [1.0]}, r"motion\.load = 2: multiplies"),
    ],
)
def test_wrong_arguments(case: Case, given: dict[str, Any], said: str) -> None:
    with pytest.raises(ConfigError, match=said):
        traction(case, **given)
