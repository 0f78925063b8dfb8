"""Validate rolling: reference numbers, limits, a measured micro-cavity; waves that pass; writes a table of each.

    python validation/rolling/validate.py [reference] [limits] [cavity] [waves] [--nodes N]

Times on two cores, once compiled: reference 10 minutes, limits 3, cavity 1 on 257 nodes (8 on 513),
waves 2 with --nodes 257.
The reference numbers are read from ../shared/reference beside the checkout (or from ERTEL_REFERENCE); they stay there.
"""

import csv
import json
import os
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any
from unittest import mock

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

import ertel
from ertel import Case, Parameters, amplitude_reduction, load_case, parse_case, simulate
from ertel.equations import outside
from ertel.physics import film_formulas
from ertel.solvers import steady

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "papers"))
from boundary_layers.runs import marched_rolling, rolling_response
from common import BARUS, ISOVISCOUS, extrapolated, table, write

HERE = Path(__file__).parent
REFERENCE = Path(os.environ.get("ERTEL_REFERENCE", HERE.parents[2] / "shared" / "reference"))
MOURIER = REFERENCE / "mourier_2006"
FLUIDS = {
    "barus incompressible": BARUS,
    "roelands + dowson-higginson": {"p0": "196078400 Pa", "z": 0.668678},  # the file's
}
BLACK, BLUE, ORANGE = "black", "#0072B2", "#D55E00"
Values = NDArray[np.float64]


def case(M: float, L: float, nodes: int, oil: dict[str, Any], **solver: Any) -> Case:
    contact = {"kind": "rolling", "M": M, "L": L}
    return parse_case({"contact": contact, "lubricant": oil, "solver": {"nodes": nodes, **solver}})


# -- reference numbers ------------------------------------------------------------------------------------------------


def reference(nodes: int) -> str:
    """Every case of rolling.json: the discrete solutions, the extrapolated film, its order, and the error estimate."""
    head = ["fluid", "M", "L", "maximum deviation of the discrete solution", "H_c", "extrapolated", "reference"]
    head += ["order", "true error/estimate of H_c", "of H_min", "H_c that users get, with oil outside"]
    entries = json.loads((REFERENCE / "rolling.json").read_text())["cases"]
    return table(head, (_compare(entry, nodes) for entry in entries))


def _compare(entry: dict[str, Any], nodes: int) -> list[str]:
    oil = FLUIDS[entry["fluid"]] if entry["L"] else ISOVISCOUS
    chosen = case(entry["M"], entry["L"], nodes, oil)
    with mock.patch.object(outside, "far_pressure", lambda X, Y, *_: 0.0 * X * Y):  # P = 0 at the edge, as there
        rolling = steady.steady_film(chosen)
    users = f"{extrapolated(steady.steady_film(chosen), 'H_c').extrapolated:.6f}"
    deviations = []
    for s in rolling.solutions:
        found, exact = s.measure(), entry["grids"].get(str(s.grid.nodes), {})
        deviations += [abs(found[name] / exact[name] - 1) for name in ("Delta", "H_c", "H_min", "P_c") if name in exact]
    H_c = [s.measure()["H_c"] for s in rolling.solutions[-3:]]
    order = np.log2((H_c[1] - H_c[0]) / (H_c[2] - H_c[1]))
    converged = entry["converged"]
    ratios = []
    for name in ("H_c", "H_min"):
        e = extrapolated(rolling, name)
        ratios.append(f"{abs(e.value - converged[name]) / e.error:.2f}")
    numbers = [f"{extrapolated(rolling, 'H_c').value:.6f}", f"{extrapolated(rolling, 'H_c').extrapolated:.6f}"]
    exact = f"{converged['H_c']:.6f} ± {entry['plus_minus']['H_c']:.0e}"
    status = "" if rolling.finest.status.ok else f" ({rolling.finest.status.value})"
    first = [entry["fluid"] + status, f"{entry['M']:g}", f"{entry['L']:g}", f"{max(deviations):.0e}"]
    return [*first, *numbers, exact, f"{order:.2f}", *ratios, users]


# -- limits -----------------------------------------------------------------------------------------------------------


def limits(nodes: int) -> str:
    """The isoviscous film of soft bodies and the piezoviscous one, towards high load."""
    head = ["M", "L", "H_c", "error", "extrapolated", "over its asymptote", "over Nijenbanning-Venner-Moes"]
    loads = [*((M, 0, ISOVISCOUS) for M in (30, 100, 300, 1000)), *((M, 10, BARUS) for M in (100, 300, 1000))]
    return table(head, (_limit(M, L, nodes, oil) for M, L, oil in loads))


def _limit(M: float, L: float, nodes: int, oil: dict[str, Any]) -> list[str]:
    e = extrapolated(steady.steady_film(case(M, L, nodes, oil)), "H_c")
    limit = film_formulas.piezoviscous_elastic(M, L) if L else film_formulas.isoviscous_elastic(M)
    curve = film_formulas.nijenbanning_venner_moes(M, L)
    film = [f"{e.value:.5f}", f"{e.error / e.value:.1%}", f"{e.extrapolated:.5f}"]
    return [f"{M:g}", f"{L:g}", *film, f"{e.extrapolated / limit:.3f}", f"{e.extrapolated / curve:.3f}"]


# -- a micro-cavity through the contact -------------------------------------------------------------------------------


def cavity(nodes: int) -> str:
    """Film along the middle while a cavity passes, beside what was measured and computed by Mourier et al. (2006)."""
    c = load_case(HERE / "micro_cavity.toml", [f"solver.nodes={nodes}"])
    steady = simulate(_undisturbed(c)).summary
    data = simulate(c, observers=[_report]).dataset.sel(Y=0.0, method="nearest")
    T, x = data["frame"].values, data["X"].values * c.scales.a * 1e6
    films = data["H"].values * c.scales.film * 1e9
    way = (_cavity_at(c, T[1]) - _cavity_at(c, T[0])) * c.scales.a * 1e6  # from map to map
    rows, figure = [], Figure(figsize=(6.5, 11), layout="constrained", dpi=150)
    for number, axes in enumerate(figure.subplots(5, 1, sharex=True, sharey=True), start=1):
        measured, published = (_curve(f"{kind}_{number}{end}") for kind, end in (("exp", ""), ("sim", "_h")))
        frame, shift = (0, 0.0) if number == 1 else _nearest(x, films, published, way)
        centre = _cavity_at(c, T[frame]) * c.scales.a * 1e6 + shift
        rows.append(_row(number, x + shift, films[frame], centre, measured, published))
        axes.plot(*measured.T, "o", color=BLACK, ms=3, label="measured")
        axes.plot(*published.T, color=BLUE, lw=1, label="computed, published")
        axes.plot(x + shift, films[frame], color=ORANGE, lw=1.4, label="ertel")
        axes.set(xlim=(-180, 180), ylim=(0, 450), ylabel="film thickness (nm)")
        axes.set_title(f"cavity at {centre:.0f} µm" if number > 1 else "no cavity in the contact", fontsize="small")
    axes.set_xlabel("x (µm), flow from left to right")
    figure.axes[0].legend(frameon=False, fontsize="small", loc="upper center", ncols=3)
    figure.savefig(HERE / "cavity.png")
    si = steady["si"]
    film = f"h_c = {si['h_c_m'] * 1e9:.1f} nm, error {si['h_c_error_m'] * 1e9:.1f} nm on {nodes}², extrapolated "
    film += f"{steady['H_c_extrapolated'] * c.scales.film * 1e9:.1f} nm; measured 206 to 217 nm"
    head = ["position", "cavity's centre (µm)", "r.m.s. to the published computation (nm)"]
    return f"Undisturbed film: {film}.\n\n" + table([*head, "median to the measurement outside the cavity (nm)"], rows)


def _undisturbed(c: Case) -> Case:
    steady = replace(c.solver, method="steady", tolerance=1e-8)
    return replace(c, solver=steady, roughness=(), time=None, output=None)


def _curve(name: str) -> Values:
    """Two columns, x in µm and film in nm, by rising x."""
    with (MOURIER / f"mourier_ssr0_{name}.csv").open() as file:
        rows = [[float(value) for value in row] for row in list(csv.reader(file))[1:] if len(row) == 2]
    values = np.array(rows)
    return values[np.argsort(values[:, 0])]


def _nearest(x: Values, films: Values, published: Values, way: float) -> tuple[int, float]:
    """The map that comes closest to the published film inside the contact: its time is not stated there.

    And by how much it is moved for that, at most half of the way from map to map (µm).
    """
    inside, shifts = published[np.abs(published[:, 0]) < 130], way * np.linspace(-0.5, 0.5, 33)
    moved = [[np.interp(inside[:, 0], x + shift, film) for shift in shifts] for film in films]
    distance = np.mean((np.array(moved) - inside[:, 1]) ** 2, axis=-1)
    frame, column = np.unravel_index(np.argmin(distance), distance.shape)
    return int(frame), float(shifts[column])


def _cavity_at(c: Case, T: float) -> float:
    feature = c.features[0]
    return feature.shape.x + c.motion.travel(feature.surface, T)


def _row(number: int, x: Values, film: Values, centre: float, measured: Values, published: Values) -> list[str]:
    inside = published[np.abs(published[:, 0]) < 130]
    to_published = np.sqrt(np.mean((np.interp(inside[:, 0], x, film) - inside[:, 1]) ** 2))
    smooth = measured[(np.abs(measured[:, 0]) < 110) & (np.abs(measured[:, 0] - centre) > 40)]
    to_measured = np.median(np.abs(np.interp(smooth[:, 0], x, film) - smooth[:, 1]))
    place = f"{centre:.0f}" if number > 1 else "outside"
    return [f"{number}", place, f"{to_published:.1f}", f"{to_measured:.1f}"]


def _report(step: Any) -> None:
    if step.state.counts.steps % 25 == 0:
        print(f"T = {step.record['T']:.3f}, {step.record['convolutions']:.0f} convolutions", flush=True)


# -- waves that pass --------------------------------------------------------------------------------------------------

WAVE = 1007.6, 12.05, 0.25  # M, L, wavelength
PUBLISHED = 0.739  # Venner CH, Lubrecht AA: their computation for this case


def waves(nodes: int) -> str:
    """A_d/A_i of isotropic waviness in pure rolling on three grids and more, by time steps and by the response."""
    M, L, wavelength = WAVE
    grids = [(nodes - 1) // 4 + 1, (nodes - 1) // 2 + 1, nodes, 2 * nodes - 1]
    ratios = [rolling_response(M, L, (wavelength,), n)[0] for n in grids]

    def row(i: int, n: int) -> list[str]:
        marched = f"{marched_rolling(M, L, wavelength, n):.4f}" if n <= nodes else ""
        extrapolated = f"{ratios[i] + (ratios[i] - ratios[i - 1]) / 3:.4f}" if i else ""
        order = f"{np.log2((ratios[i - 2] - ratios[i - 1]) / (ratios[i - 1] - ratios[i])):.2f}" if i > 1 else ""
        return [f"{n}²", marched, f"{ratios[i]:.4f}", extrapolated, order]

    curve = float(amplitude_reduction.ratio_left(Parameters.from_moes(M, L).nabla2(wavelength)))
    head = ["nodes", "time steps of one cell", "periodic response", "extrapolated, second order", "order observed"]
    others = f"Eq. (15) gives {curve:.4f}, the published computation {PUBLISHED}.\n"
    text = f"M = {M:g}, L = {L:g}, wavelength {wavelength:g}: A_d/A_i.\n\n"
    return text + table(head, map(row, range(len(grids)), grids)) + f"\n{others}"


if __name__ == "__main__":
    ertel.cache()
    write(
        HERE,
        {
            "reference": ("Rolling: reference values", reference, 257),
            "limits": ("Rolling: limits", limits, 513),
            "cavity": ("Rolling: a measured micro-cavity", cavity, 257),
            "waves": ("Rolling: waves that pass", waves, 513),
        },
    )
