"""How often the error bar of a steady film holds; writes bars.md.

    python validation/rolling/bars.py [--nodes N]

Every case is solved on all grids up to the finest.  A film on 33, 65 and 129 nodes is extrapolated from this grid and
the coarser ones alone, as a run on that grid shows it, and compared with the reference: the film extrapolated from the
two finest grids.  The reference has an uncertainty of its own, the same rule on the finest grid; where it is above a
third of the bar, the number tells nothing and is left out.
"""

import sys
from itertools import product
from math import exp, log
from pathlib import Path
from typing import Any

import numpy as np

from ertel import parse_case, simulate
from ertel.numerics.grid import Extrapolation, on_grids
from ertel.results.variables import FILMS

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from common import table, write

SEED, COUNT = 39, 50
KINDS = ("circle", "starved", "ellipse")
RADII = (0.5, 3.0)  # R_x/R_y: few shapes of grids to compile
QUICK = (33, 65, 129)  # nodes
KNOWN = 1 / 3  # of the bar: the largest uncertainty of a reference that tells whether the bar holds
UNKNOWN = 0.5  # of the film: a larger bar is shown as "not known"
HEAD = ["contact", "nodes", "bars", "hold", "rate", "largest deviation over bar", "middle", "not known", "left out"]


def cases(nodes: int) -> list[dict[str, Any]]:
    """Circles, starved circles and ellipses in turn, with M, L and oil drawn evenly in their logarithms."""
    draw = np.random.default_rng(SEED)

    def between(low: float, high: float) -> float:
        return exp(draw.uniform(log(low), log(high)))

    found = []
    for number in range(COUNT):
        contact = {"kind": "rolling", "M": between(8, 500), "L": between(2, 15)}
        oil = {"layer": between(0.3, 2.0)} if KINDS[number % 3] == "starved" else {}
        contact |= {"radius_ratio": float(draw.choice(RADII))} if KINDS[number % 3] == "ellipse" else {}
        found.append({"contact": contact, "lubricant": oil, "solver": {"nodes": nodes}})
    return found


def films(data: dict[str, Any]) -> dict[str, list[float]]:
    """The films on all grids, coarsest first; empty where a grid has none."""
    if "layer" in data["lubricant"]:  # given as a share of the flooded film
        flooded = simulate(parse_case({**data, "lubricant": {}, "solver": {"nodes": 65}}))
        share = data["lubricant"]["layer"] * flooded.summary["H_c"]
        data = {**data, "lubricant": {"layer": share}}
    result = simulate(parse_case(data))
    return {name: result.dataset[name].values.tolist() for name in FILMS} if result.status.ok else {}


def deviations(values: list[float], regular: bool, quick: int) -> tuple[float, float, float]:
    """The bar over the film, the deviation over the bar, and the uncertainty of the reference over the bar.

    quick: how many grids the run with the bar has; the last values are of finer grids.
    """
    reference: Extrapolation = on_grids(values, regular)[-1]
    bar = on_grids(values[:quick], regular)[-1]
    deviation = abs(bar.extrapolated - reference.extrapolated)
    return abs(bar.error / bar.extrapolated), deviation / bar.error, reference.error / bar.error


def row(kind: str, nodes: str, found: list[tuple[float, float, float]]) -> list[str]:
    """A line of the table from the deviations of one kind of contact on one grid."""
    shown = [each for each in found if each[0] <= UNKNOWN]
    told = [deviation for _, deviation, doubt in shown if doubt <= KNOWN or deviation > 1 + doubt]
    holds, unknown = sum(deviation <= 1 for deviation in told), len(found) - len(shown)
    rate = f"{holds / len(told):.0%}" if told else "-"
    worst, middle = (f"{max(told):.2f}", f"{np.median(told):.2f}") if told else ("-", "-")
    numbers = [str(len(told)), str(holds), rate, worst, middle, str(unknown), str(len(shown) - len(told))]
    return [kind, nodes, *numbers]


def bars(nodes: int) -> str:
    """The table of all cases, each solved on all grids up to that of `nodes`."""
    found: dict[tuple[str, int], list[tuple[float, float, float]]] = {}
    for number, data in enumerate(cases(nodes)):
        kind, solved = KINDS[number % 3], films(data)
        print(kind, data["contact"], solved, file=sys.stderr, flush=True)
        for values, quick in product(solved.values(), QUICK):
            grids = len(values) - round(log((nodes - 1) / (quick - 1), 2))
            if 1 < grids < len(values) and min(values[grids - 1 :]) > 0.0:
                found.setdefault((kind, quick), []).append(deviations(values, kind != "starved", grids))
    rows = [row(kind, str(quick), each) for (kind, quick), each in sorted(found.items())]
    return table(HEAD, [*rows, row("all", "", [one for each in found.values() for one in each])])


if __name__ == "__main__":
    write(Path(__file__).parent, {"bars": ("Error bars of steady films", bars, 257)})
