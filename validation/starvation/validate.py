"""Validate starved contacts: films and restitution on layers of oil; writes the tables in this folder.

    python validation/starvation/validate.py [impact] [order] [track] [work] [settled] [again]

Times on two cores: impact 4 minutes, order 4, track 4, work 3, settled 3, again 1.
"""

import sys
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

import ertel

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


def table(head: list[str], rows: list[list[str]]) -> str:
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines) + "\n"


def roll(M: float, layer: Any, nodes: int) -> ertel.Result:
    return ertel.simulate(ertel.rolling(M=M, L=L, nodes=nodes, layer=layer))


def impact(M: float, layer: float | None, **more: Any) -> dict[str, Any]:
    case = ertel.impact(M=M, L=L, method="radial", nodes=201, half_width=3.0, layer=layer, **more)
    return ertel.simulate(case).summary


def impacts() -> str:
    """Films and restitution on layers, against the radial program."""
    rows = []
    for M, layers in RADIAL.items():
        for layer, (H_c, e) in layers.items():
            s = impact(M, layer, until="rebound")
            film, bounce = s["H_c"], s["restitution"]
            about = [
                f"{M:g}",
                "flooded" if layer is None else f"{layer:g}",
                f"{film:.5f}",
                f"{100 * (film / H_c - 1):+.2f}",
            ]
            rows.append([*about, f"{bounce:.4f}", f"{bounce - e:+.4f}", str(s["steps"])])
            print(*rows[-1], flush=True)
    thin = ertel.simulate(ertel.impact(M=1000, L=L, nodes=257, half_width=2.0, layer=0.02)).summary["H_c"]
    rows.append(
        ["1000", "0.02, 2-D, 257 nodes", f"{thin:.5f}", f"{100 * (thin / RADIAL[1000][0.02][0] - 1):+.2f}", *"   "]
    )
    return table(["M", "layer (a*²/R)", "H_c", "deviation (%)", "restitution", "deviation", "steps"], rows)


def order() -> str:
    """Steady films on four grids, with the order that the last three show, and the error that the third one tells."""
    rows = []
    for layer in (None, 0.62, 0.162, 0.081, 0.04, 0.02):
        runs = [roll(200, layer, nodes).summary for nodes in GRIDS]
        for film in ("H_c", "H_min"):
            values = [run[film] for run in runs]
            changes = np.diff(values)
            falls = abs(changes[-1]) < abs(changes[-2]) and changes[-2] * changes[-1] > 0
            shown = f"{np.log2(changes[-2] / changes[-1]):.1f}" if falls else "irregular"
            told, left = runs[2][f"{film}_error"], abs(runs[3][f"{film}_extrapolated"] - values[2])
            row = ["flooded" if layer is None else f"{layer:g}", film, *(f"{value:.5f}" for value in values)]
            rows.append([*row, shown, f"{told:.5f}", f"{left:.5f}"])
            print(*rows[-1], flush=True)
    grids = [f"{nodes} nodes" for nodes in GRIDS]
    return table(["layer (a²/R)", "film", *grids, "order", "error told on 257", "found"], rows)


def track() -> str:
    """The film on a track that is rolled over many times, at M = 200."""
    rows = []
    for layer, nodes in ((0.0712, 129), (0.2, 129), (0.0712, 257)):
        given: Any = layer
        films: list[float] = []
        for _ in range(PASSES[-1]):
            run = roll(200, given, nodes)
            films.append(run.summary["H_c"])
            given = run.track
        mean = float(np.mean(np.array(given)[:, 1]))
        slope = float(np.log(films[PASSES[-1] - 1] / films[PASSES[-2] - 1]) / np.log(PASSES[-1] / PASSES[-2]))
        rows.append([f"{layer:g}", f"{nodes}", *(f"{films[n - 1]:.5f}" for n in PASSES)])
        rows[-1] += [f"{slope:.2f}", f"{mean / layer - 1:.0e}"]
        print(*rows[-1], flush=True)
    passes = [f"pass {n}" for n in PASSES]
    return table(["layer (a²/R)", "nodes", *passes, "exponent of the last two", "change of all oil"], rows)


def work() -> str:
    """Newton and Krylov iterations of steady films on all grids together, flooded and for each r, at M = 200."""
    rows = []
    for nodes in GRIDS:
        flooded = roll(200, None, nodes)
        s = flooded.summary
        oil = float(flooded.case.lubricant.density(s["P_c"])) * s["H_c"]
        runs = [s, *(roll(200, r * oil, nodes).summary for r in RATIOS)]
        rows.append([f"{nodes}", *(f"{run['newton_iterations']}, {run['krylov_iterations']}" for run in runs)])
        print(*rows[-1], flush=True)
    return table(["nodes", "flooded", *(f"r = {r:g}" for r in RATIOS)], rows)


def settled() -> str:
    """Steady films, and those of runs in time 13 t0 after the speed has come to the same value, at M = 200."""
    rows = []
    for layer in (None, 0.0712, 0.2):
        for nodes in (65, 129):
            steady = roll(200, layer, nodes).summary["H_c"]
            for start in (1.2, 0.8):
                more = {"motion": {"entrainment": [[0, start], [1, 1]]}, "until": 14.0}
                case = ertel.rolling(M=200, L=L, nodes=nodes, layer=layer, method="transient", **more)
                H = ertel.simulate(case).dataset["H_c"].values
                row = ["flooded" if layer is None else f"{layer:g}", f"{nodes}", f"{start:g}", f"{H[0]:.5f}"]
                rows.append([*row, f"{H[-1]:.5f}", f"{steady:.5f}", f"{H[-1] / steady - 1:+.2%}"])
                print(*rows[-1], flush=True)
    return table(["layer (a²/R)", "nodes", "first speed", "H_c then", "H_c at the end", "steady", "deviation"], rows)


def again() -> str:
    """What a contact finds of its own cavity: a ball that falls twice, a track that stops or turns back."""
    rows = []
    for layer in (None, 0.3, 0.2, 0.1, 0.05):
        more = {"motion": {"load": 0.1}, "until": 40.0, "time_tolerance": 1e-3, "half_width": 3.0}
        run = ertel.simulate(ertel.impact(M=200, L=L, nodes=65, layer=layer, **more))
        V, H = run.dataset["V"].values, run.dataset["H_c"].values
        first, second = H[1:][(V[:-1] > 0) & (V[1:] <= 0)][:2]
        rows.append(["two impacts, M = 200, load 0.1", *_cells(layer, first, second, run)])
    motions = {
        "stop and start": [[0, 1], [2, 0], [3, 0], [5, 1]],
        "there and back": [[0, 1], [4, -1]],
    }
    for name, entrainment in motions.items():
        for layer in (None, 0.4, 0.15):
            more = {"motion": {"entrainment": entrainment}, "until": 12.0, "time_tolerance": 1e-3}
            run = ertel.simulate(ertel.rolling(M=20, L=L, nodes=65, layer=layer, method="transient", **more))
            first, second = run.dataset["H_c"].values[[0, -1]]
            rows.append([f"{name}, M = 20", *_cells(layer, first, second, run)])
    return table(["contact", "layer", "H_c before", "H_c after", "after/before", "imbalance of mass"], rows)


def _cells(layer: float | None, first: float, second: float, run: ertel.Result) -> list[str]:
    imbalance = run.summary["budgets"]["mass"]["imbalance"]
    told = ["flooded" if layer is None else f"{layer:g}", f"{first:.4f}", f"{second:.4f}", f"{second / first:.3f}"]
    print(*told, flush=True)
    return [*told, "nothing flows" if imbalance is None else f"{imbalance:.0e}"]


TABLES: Mapping[str, tuple[str, Callable[[], str]]] = {
    "impact": ("Impacts on layers of oil", impacts),
    "order": ("Steady films on layers of oil, M = 200, L = 10", order),
    "track": ("A track that is rolled over many times", track),
    "work": ("Newton and Krylov iterations of steady films", work),
    "settled": ("Steady films and films after a long time", settled),
    "again": ("Twice over the same place", again),
}

if __name__ == "__main__":
    wanted = sys.argv[1:] or list(TABLES)
    for name in wanted:
        title, made = TABLES[name]
        (HERE / f"{name}.md").write_text(f"# {title}\n\n{made()}", encoding="utf-8")
