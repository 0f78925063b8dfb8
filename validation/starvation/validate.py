"""Validate starved contacts: films and restitution on layers of oil; writes the tables in this folder.

    python validation/starvation/validate.py [impact] [order] [track] [work] [settled] [again]

Times on two cores: impact 4 minutes, order 4, track 4, work 3, settled 3, again 1.
"""

import sys
from collections.abc import Iterator, Mapping
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np

import ertel

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from common import table, write

HERE = Path(__file__).parent
L = 10
RATIOS = (8.0, 2.0, 1.0, 0.5, 0.25)
GRIDS = (65, 129, 257, 513)
PASSES = (1, 2, 3, 5, 10, 20)
# layer: H_c and restitution of impacts by a radial program of its own, to 0.3 % and 0.002
RADIAL: Mapping[float, Mapping[float | None, tuple[float, float]]] = {
    200: {
        None: (0.15347, 0.9413), 1.0: (0.15278, 0.9491), 0.5: (0.1482, 0.9580), 0.3: (0.13611, 0.9665),
        0.2: (0.11628, 0.9738), 0.15: (0.0984, 0.9788), 0.1: (0.07302, 0.9857), 0.05: (0.03971, 0.9942),
    },
    1000: {
        None: (0.06787, 0.9883), 0.5: (0.06751, 0.9900), 0.3: (0.06660, 0.9909), 0.2: (0.06456, 0.9918),
        0.12: (0.05778, 0.9931), 0.09: (0.05114, 0.9939), 0.06: (0.03981, 0.9951), 0.04: (0.02893, 0.9963),
        0.02: (0.01568, 0.9982),
    },
}  # fmt: skip


def roll(M: float, layer: Any, nodes: int) -> ertel.Result:
    return ertel.simulate(ertel.rolling(M=M, L=L, nodes=nodes, layer=layer))


def impact(M: float, layer: float | None, **more: Any) -> dict[str, Any]:
    case = ertel.impact(M=M, L=L, method="radial", nodes=201, half_width=3.0, layer=layer, **more)
    return ertel.simulate(case).summary


def named(layer: float | None) -> str:
    return "flooded" if layer is None else f"{layer:g}"


def impacts() -> str:
    """Films and restitution on layers, against the radial program."""
    return table(["M", "layer (a*²/R)", "H_c", "deviation (%)", "restitution", "deviation", "steps"], _impacts())


def _impacts() -> Iterator[list[str]]:
    for M, layers in RADIAL.items():
        for layer, (H_c, e) in layers.items():
            s = impact(M, layer, until="rebound")
            film, bounce = s["H_c"], s["restitution"]
            about = [f"{M:g}", named(layer), f"{film:.5f}", f"{100 * (film / H_c - 1):+.2f}"]
            yield [*about, f"{bounce:.4f}", f"{bounce - e:+.4f}", str(s["steps"])]
    thin = ertel.simulate(ertel.impact(M=1000, L=L, nodes=257, half_width=2.0, layer=0.02)).summary["H_c"]
    deviation = f"{100 * (thin / RADIAL[1000][0.02][0] - 1):+.2f}"
    yield ["1000", "0.02, 2-D, 257 nodes", f"{thin:.5f}", deviation, *"   "]


def order() -> str:
    """Steady films on four grids, with the order that the last three show, and the error that the third one tells."""
    grids = [f"{nodes} nodes" for nodes in GRIDS]
    return table(["layer (a²/R)", "film", *grids, "order", "error told on 257", "found"], _orders())


def _orders() -> Iterator[list[str]]:
    for layer in (None, 0.62, 0.162, 0.081, 0.04, 0.02):
        runs = [roll(200, layer, nodes).summary for nodes in GRIDS]
        for film in ("H_c", "H_min"):
            values = [run[film] for run in runs]
            changes = np.diff(values)
            falls = abs(changes[-1]) < abs(changes[-2]) and changes[-2] * changes[-1] > 0
            shown = f"{np.log2(changes[-2] / changes[-1]):.1f}" if falls else "irregular"
            told, left = runs[2][f"{film}_error"], abs(runs[3][f"{film}_extrapolated"] - values[2])
            yield [named(layer), film, *(f"{value:.5f}" for value in values), shown, f"{told:.5f}", f"{left:.5f}"]


def track() -> str:
    """The film on a track that is rolled over many times, at M = 200."""
    passes = [f"pass {n}" for n in PASSES]
    head = ["layer (a²/R)", "nodes", *passes, "exponent of the last two", "change of all oil"]
    return table(head, (_passes(*each) for each in ((0.0712, 129), (0.2, 129), (0.0712, 257))))


def _passes(layer: float, nodes: int) -> list[str]:
    given: Any = layer
    films: list[float] = []
    for _ in range(PASSES[-1]):
        run = roll(200, given, nodes)
        films.append(run.summary["H_c"])
        given = run.track
    mean = float(np.mean(np.array(given)[:, 1]))
    slope = float(np.log(films[PASSES[-1] - 1] / films[PASSES[-2] - 1]) / np.log(PASSES[-1] / PASSES[-2]))
    shown = [f"{films[n - 1]:.5f}" for n in PASSES]
    return [f"{layer:g}", f"{nodes}", *shown, f"{slope:.2f}", f"{mean / layer - 1:.0e}"]


def work() -> str:
    """Newton and Krylov iterations of steady films on all grids together, flooded and for each r, at M = 200."""
    return table(["nodes", "flooded", *(f"r = {r:g}" for r in RATIOS)], map(_works, GRIDS))


def _works(nodes: int) -> list[str]:
    flooded = roll(200, None, nodes)
    s = flooded.summary
    oil = float(flooded.case.lubricant.density(s["P_c"])) * s["H_c"]
    runs = [s, *(roll(200, r * oil, nodes).summary for r in RATIOS)]
    return [f"{nodes}", *(f"{run['newton_iterations']}, {run['krylov_iterations']}" for run in runs)]


def settled() -> str:
    """Steady films, and those of runs in time 13 t0 after the speed has come to the same value, at M = 200."""
    head = ["layer (a²/R)", "nodes", "first speed", "H_c then", "H_c at the end", "steady", "deviation"]
    return table(head, (_settled(*each) for each in product((None, 0.0712, 0.2), (65, 129), (1.2, 0.8))))


def _settled(layer: float | None, nodes: int, start: float) -> list[str]:
    steady = roll(200, layer, nodes).summary["H_c"]
    more = {"motion": {"entrainment": [[0, start], [1, 1]]}, "until": 14.0}
    case = ertel.rolling(M=200, L=L, nodes=nodes, layer=layer, method="transient", **more)
    H = ertel.simulate(case).dataset["H_c"].values
    films = f"{H[0]:.5f}", f"{H[-1]:.5f}", f"{steady:.5f}", f"{H[-1] / steady - 1:+.2%}"
    return [named(layer), f"{nodes}", f"{start:g}", *films]


def again() -> str:
    """What a contact finds of its own cavity: a ball that falls twice, a track that stops or turns back."""
    return table(["contact", "layer", "H_c before", "H_c after", "after/before", "imbalance of mass"], _again())


def _again() -> Iterator[list[str]]:
    for layer in (None, 0.3, 0.2, 0.1, 0.05):
        more = {"motion": {"load": 0.1}, "until": 40.0, "time_tolerance": 1e-3, "half_width": 3.0}
        run = ertel.simulate(ertel.impact(M=200, L=L, nodes=65, layer=layer, **more))
        V, H = run.dataset["V"].values, run.dataset["H_c"].values
        first, second = H[1:][(V[:-1] > 0) & (V[1:] <= 0)][:2]
        yield ["two impacts, M = 200, load 0.1", *_cells(layer, first, second, run)]
    motions = {"stop and start": [[0, 1], [2, 0], [3, 0], [5, 1]], "there and back": [[0, 1], [4, -1]]}
    for (name, entrainment), layer in product(motions.items(), (None, 0.4, 0.15)):
        more = {"motion": {"entrainment": entrainment}, "until": 12.0, "time_tolerance": 1e-3}
        run = ertel.simulate(ertel.rolling(M=20, L=L, nodes=65, layer=layer, method="transient", **more))
        first, second = run.dataset["H_c"].values[[0, -1]]
        yield [f"{name}, M = 20", *_cells(layer, first, second, run)]


def _cells(layer: float | None, first: float, second: float, run: ertel.Result) -> list[str]:
    imbalance = run.summary["budgets"]["mass"]["imbalance"]
    told = [named(layer), f"{first:.4f}", f"{second:.4f}", f"{second / first:.3f}"]
    return [*told, "nothing flows" if imbalance is None else f"{imbalance:.0e}"]


if __name__ == "__main__":
    write(
        HERE,
        {
            "impact": ("Impacts on layers of oil", impacts, None),
            "order": ("Steady films on layers of oil, M = 200, L = 10", order, None),
            "track": ("A track that is rolled over many times", track, None),
            "work": ("Newton and Krylov iterations of steady films", work, None),
            "settled": ("Steady films and films after a long time", settled, None),
            "again": ("Twice over the same place", again, None),
        },
    )
