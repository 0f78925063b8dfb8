"""Validate the impact: work, orders, reference numbers, errors.  Writes a table NAME.md of each here.

    python validation/impact/validate.py [work] [orders] [reference] [errors]     (all: about 50 minutes on two cores)

The reference numbers are read from ../shared/reference/impact.json beside the checkout (or from ERTEL_REFERENCE).
"""

import itertools
import json
import os
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from unittest import mock

import numpy as np

import ertel
from ertel import Case, Result, parse_case, simulate
from ertel.equations import outside
from ertel.results.fronts import at_max_approach
from ertel.results.summary import comparisons, with_error

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from common import BARUS, ISOVISCOUS, table, write

HERE = Path(__file__).parent
REFERENCE = Path(os.environ.get("ERTEL_REFERENCE", HERE.parents[2] / "shared" / "reference")) / "impact.json"
QUANTITIES = ("T", "Delta", "F", "P_c", "H_c", "H_min")
ACCURACY = {"T": 0.0025, "Delta": 0.001, "F": 0.001, "P_c": 0.002, "H_c": 0.003, "H_min": 0.03}  # stated there


def case(contact: dict[str, Any], nodes: int, oil: dict[str, Any] | None = None, **options: Any) -> Case:
    until, step = options.pop("until", "max-approach"), options.pop("step", None)
    time = {"until": until, "tolerance": options.pop("time_tolerance", 1e-4)} | ({"step": step} if step else {})
    solver = {"nodes": nodes, **options}
    return parse_case(
        {"contact": {"kind": "impact", **contact}, "lubricant": oil or {}, "solver": solver, "time": time}
    )


# restitution, contact time, largest load: their order from 401 to 801 rings, for the truth
WHOLE = {"restitution": 1.5, "contact_time": 2.0, "F_max": 2.0}
GRIDS = ((129, 3.0, 5e-5), (129, 2.0, 5e-5), (129, 8.0, 3e-4), (257, 4.0, 5e-5))  # rings, half width, time tolerance


def errors() -> str:
    """Errors of --error of whole impacts beside the true ones, along the radius."""
    head = ["M", "L", "rings", "half width", "time tolerance", "number", "value", "its error", "true error", "ratio"]
    return table(head, _errors())


def _errors() -> Iterator[list[str]]:
    for M, L in ((50, 5), (200, 10), (1000, 10)):
        coarse, fine = (simulate(_whole(M, L, *grid)).summary for grid in ((401, 12.0, 1e-5), (801, 12.0, 1.25e-6)))
        for nodes, half_width, tolerance in GRIDS:
            chosen = _whole(M, L, nodes, half_width, tolerance)
            others = {part: simulate(other).summary for part, other in comparisons(chosen).items()}
            estimates = with_error(chosen, simulate(chosen).summary, others)["error_estimate"]
            for name, order in WHOLE.items():
                truth = fine[name] + (fine[name] - coarse[name]) / (2.0**order - 1.0)
                value, error = (estimates[name][key] for key in ("value", "error"))
                off = abs(value - truth)
                numbers = [f"{value:.5f}", f"{error:.1e}", f"{off:.1e}", f"{off / error:.2f}"]
                yield [*map(str, (M, L, nodes, half_width, tolerance)), name.replace("_", " "), *numbers]


def _whole(M: float, L: float, nodes: int, half_width: float, tolerance: float) -> Case:
    options = {"method": "radial", "half_width": half_width, "until": "rebound", "time_tolerance": tolerance}
    return case({"M": M, "L": L}, nodes, **options)


def work() -> str:
    """Iterations over whole impacts, approach to rebound."""
    head = ["M", "grid", "steps", "Newton a step", "Krylov a solve, to maximum", "after", "maximum"]
    return table([*head, "convolutions a step", "restitution", "minimum film thickness"], _works())


def _works() -> Iterator[list[str]]:
    for M, nodes in itertools.product((200, 1000, 10000), (65, 129, 257, 513)):
        result = simulate(case({"M": M, "L": 10}, nodes, until="rebound"))
        data, s = result.dataset, result.summary
        per_solve = data.krylov_iterations / data.newton_iterations
        before = data.time < float(at_max_approach(data)["frame"])
        split = [float(per_solve[part].mean()) for part in (before, ~before)]
        ends = ["", "vanishes"]
        if result.status.ok:
            ends = [f"{s['restitution']:.4f}", f"{float(data.H_min.min()):.2g}"]
        yield [
            *(f"{M}", f"{nodes}²", f"{s['steps']}", f"{s['newton_iterations'] / s['steps']:.2f}"),
            *(f"{value:.2f}" for value in (*split, float(per_solve.max()))),
            *(f"{s['convolutions'] / s['steps']:.1f}", *ends),
        ]


def orders() -> str:
    """Observed orders in space and time at maximum approach."""
    grids, steps = (33, 65, 129, 257), (0.04, 0.02, 0.01, 0.005)
    runs = {
        "space (nodes " + ", ".join(map(str, grids)) + ")": [
            simulate(case({"M": 20, "L": 5}, n, time_tolerance=1e-5)) for n in grids
        ],
        "time (steps " + ", ".join(map(str, steps)) + ")": [
            simulate(case({"M": 20, "L": 5}, 65, step=step, tolerance=1e-9)) for step in steps
        ],
    }
    rows = []
    for name, results in runs.items():
        for quantity in ("Delta", "F", "H_c"):
            rows.append([name, quantity, *observed([r.summary[quantity] for r in results])])
        rows.append([name, "H, mean square over the contact", *observed([inner_film(r) for r in results])])
    return table(["refined in", "of", "order, coarse", "order, fine"], rows)


def inner_film(result: Result) -> Any:
    """The film at maximum approach on the nodes of the 33 x 33 grid within |X|, |Y| <= 1."""
    H = at_max_approach(result.dataset).H.values
    step = (H.shape[0] - 1) // 32
    return H[::step, ::step][8:25, 8:25]


def observed(values: list[Any]) -> list[str]:
    changes = [np.sqrt(np.mean(np.square(np.subtract(b, a)))) for a, b in itertools.pairwise(values)]
    return [f"{order:.2f}" for order in np.log2(np.divide(changes[:-1], changes[1:]))]


def nothing(X: Any, Y: Any, *_: Any) -> Any:
    """No pressure: the references have P = 0 at the edge."""
    return 0.0 * X * Y


@mock.patch.multiple(outside, far_pressure=nothing, rigid_pressure=nothing)
def reference() -> str:
    """Every case of the reference, by the 2-D method (M <= 1000) and by the radial twin, on two grids each."""
    text = "Deviation from `reference/impact.json` of the value extrapolated from two grids, the change that the\n"
    text += "extrapolation makes to the finer one (its discretisation error), and the reference's own accuracy.\n"
    for stated in json.loads(REFERENCE.read_text())["cases"]:
        contact, _ = translate(stated)
        text += f"\n## {stated['fluid']}, " + ", ".join(f"{k} = {v}" for k, v in contact.items()) + "\n\n"
        head = ["method, nodes", "of", "ertel", "reference", "deviation", "discretisation", "accuracy"]
        rows = [*_compared(stated, "radial", (301, 601), 4.0)]
        if stated["M"] <= 1000:
            rows += _compared(stated, "2d", (257, 513), 4.0 if stated["M"] < 500 else 2.0)
        text += table(head, rows)
    return text


def _compared(stated: dict[str, Any], method: str, grids: tuple[int, int], half_width: float) -> Iterator[list[str]]:
    contact, oil = translate(stated)
    options = {"method": method, "time_tolerance": 2e-5, "half_width": half_width}
    ends = "rebound" if method == "radial" else "max-approach", "max-approach"
    coarse, fine = (
        simulate(case(contact, nodes, oil, until=until, **options)).summary
        for nodes, until in zip(grids, ends, strict=True)
    )
    for q in QUANTITIES:
        a, b = coarse[q], fine[q]
        best, ref = b + (b - a) / 3, stated.get({"T": "T_max", "Delta": "Delta_max", "F": "F_max"}.get(q, q))
        if ref:
            errors = f"{best / ref - 1:+.2%}", f"{(b - a) / 3 / ref:+.2%}", f"{ACCURACY[q]:.2%}"
            yield [f"{method} {grids[0]}, {grids[1]}", q, f"{best:.5g}", f"{ref}", *errors]
    if coarse["restitution"] and "restitution" in stated:
        e, ref = coarse["restitution"], stated["restitution"]
        yield [f"{method} {grids[0]}", "restitution", f"{e:.4f}", f"{ref}", f"{e - ref:+.4f}", "", "0.001"]


def translate(stated: dict[str, Any]) -> tuple[dict[str, float], dict[str, str]]:
    """A reference case's contact and lubricant as ertel's input."""
    fluid = stated["fluid"]
    if fluid.startswith("isoviscous"):
        return {"lambda_bar": 16 / (15 * stated["St"])}, ISOVISCOUS
    return {"M": stated["M"], "L": stated["L"]}, BARUS if fluid.startswith("barus") else {}


if __name__ == "__main__":
    ertel.cache()
    write(
        HERE,
        {
            "work": ("Work: Krylov iterations per reduction by 100, L = 10, approach to rebound", work, None),
            "orders": ("Orders of convergence, M = 20, L = 5, at maximum approach", orders, None),
            "reference": ("Reference numbers", reference, None),
            "errors": ("Errors of whole impacts, with 801 rings for the truth", errors, None),
        },
    )
