"""Checks of Fig. 6: A_d/A_i does not depend on the height of the waves, and hardly on the time steps.

In rolling it is computed without time steps; time steps over waves of finite height lead to the same value.
"""

from pandas import DataFrame

from ertel.apps.boundary_layers.plans import Plan
from ertel.apps.boundary_layers.smooth import Results
from ertel.apps.boundary_layers.waves import (
    CHECKED,
    HEIGHT,
    SHORTER,
    check_name,
    impact_name,
    last_wave,
    rolling_name,
    wave_name,
)

EDGE = 1.0  # a*: of the contact


def tables(results: Results, plan: Plan) -> dict[str, DataFrame]:
    """Title -> table of each check."""
    M, L = plan.waves.shown
    wavelength, nodes = plan.waves.impacts[M, L][0], plan.waves.grids[0]
    heights = f"Height of the waves: M = {M:g}, L = {L:g}, wavelength {wavelength:g}, {nodes} nodes"
    return {
        heights: _by_height(results, plan),
        "Time steps": _by_step(results, plan),
        "Rolling with and without time steps": _by_marching(results, plan),
    }


def _by_height(results: Results, plan: Plan) -> DataFrame:
    wavelength = plan.waves.impacts[plan.waves.shown][0]
    ratios = {"0: tangent-linear": _ratio(results, check_name("linear", plan), HEIGHT, wavelength)}
    for height in CHECKED:
        ratios[f"{height:g}"] = _ratio(results, check_name("heights", plan), height, wavelength)
    return DataFrame({"A_i / sqrt(L/M)": height, "A_d/A_i": f"{ratio:.4f}"} for height, ratio in ratios.items())


def _by_step(results: Results, plan: Plan) -> DataFrame:
    (M, L), nodes = plan.waves.shown, plan.waves.grids[0]
    names = impact_name(M, L, nodes), check_name("steps", plan)
    rows = [
        _row(
            f"impact, M = {M:g}, L = {L:g}", wavelength, nodes, *(_ratio(results, n, HEIGHT, wavelength) for n in names)
        )
        for wavelength in plan.waves.impacts[M, L]
    ]
    return DataFrame(rows)


def _by_marching(results: Results, plan: Plan) -> DataFrame:
    M, L, wavelength, nodes = plan.waves.marched
    own = plan.waves.rolling[M, L] if nodes in plan.waves.rolling_grids else (wavelength,)
    linear = results[rolling_name(M, L, nodes)][own.index(wavelength)]
    run = f"M = {M:g}, L = {L:g}, wavelength {wavelength:g}, {nodes} nodes"
    steps = f"time steps of one cell, A_i = {HEIGHT:g} of the film scale"
    found = {"without time steps, to first order": linear, steps: results[check_name("marched", plan)]}
    return DataFrame({"rolling": run, "computed": how, "A_d/A_i": f"{ratio:.4f}"} for how, ratio in found.items())


def _ratio(results: Results, name: str, height: float, wavelength: float) -> float:
    return last_wave(results[name].sel(wave=wave_name(height, wavelength)), EDGE).amplitude


def _row(case: str, wavelength: float, nodes: int, usual: float, shorter: float) -> dict[str, str]:
    return {
        "run": f"{case}, wavelength {wavelength:g}, {nodes} nodes",
        "A_d/A_i, usual steps": f"{usual:.4f}",
        f"{SHORTER} times as many": f"{shorter:.4f}",
    }
