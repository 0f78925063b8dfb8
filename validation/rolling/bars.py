"""How often the printed bar of a steady film contains the true film; writes bars.md and the films in bars.jsonl.

    python validation/rolling/bars.py [--resume]

Fifty contacts, drawn at random, are solved on 33, 65, 129 and 257 nodes.  What a run on 65 and on 129 nodes prints, the
extrapolated film with its bar, follows from its grids alone.  The truth is the film extrapolated from 129 and 257.
Left out are the bars that a run does not print: of failed runs, and of films that it calls not known.

Each contact is stored in bars.jsonl as soon as it is solved; --resume solves only those that are not there.
"""

import json
import sys
from collections.abc import Iterator
from itertools import product
from math import exp, log, log2, nan
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ertel import Oil, cache, rolling, simulate
from ertel.numerics.grid import on_grids
from ertel.results.numbers import UNKNOWN
from ertel.results.variables import FILMS

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from common import table

FOLDER = Path(__file__).parent
STORED = FOLDER / "bars.jsonl"
SEED, COUNT = 39, 50
NODES = (33, 65, 129, 257)
PRINTED = (65, 129)  # nodes of the runs whose bars are looked at
KINDS = ("circle", "starved", "ellipse", "thinning")
SQUARE = {"half_width": 3.0, "half_width_y": 3.0}  # of ellipses: the grid of the circle, whose program they share
BALL = {"radius": 0.01, "E_prime": 226e9}  # that rolls and slides on a plane with Ree-Eyring oil, in SI
WORDS = ("M", "L", "layer", "radius_ratio")
HEAD = ["contact", "film", "nodes", "bars", "hold", "rate", "largest deviation over bar", "middle", "undecided"]
HEAD += ["not known", "failed"]


class Bar(NamedTuple):
    """A printed film beside the truth: deviation and doubt (of the truth) over the bar, and whether it is printed."""

    kind: str
    film: str
    nodes: int
    deviation: float = nan
    doubt: float = nan
    failed: bool = False
    known: bool = True

    @property
    def shown(self) -> bool:
        return self.known and not self.failed


def cases() -> list[dict[str, Any]]:
    """Circles, starved ones, ellipses and circles with Ree-Eyring oil in turn, drawn evenly in their logarithms."""
    draw = np.random.default_rng(SEED)

    def between(low: float, high: float) -> float:
        return float(f"{exp(draw.uniform(log(low), log(high))):.4g}")

    found: list[dict[str, Any]] = []
    for number in range(COUNT):
        kind = KINDS[number % len(KINDS)]
        if kind == "thinning":
            contact: dict[str, Any] = {**BALL, "load": between(1, 60), "mean_speed": between(0.3, 10)}
            contact |= {"slide_to_roll": between(0.01, 0.5)}
            contact["oil"] = {"eta0": between(0.01, 0.1), "alpha": between(12e-9, 25e-9)}
            contact["rheology"] = {"law": "ree-eyring", "tau0": f"{between(2, 10)} MPa"}
        else:
            contact = {"M": between(5 if kind == "ellipse" else 3, 500), "L": between(2, 15)}
        if kind == "starved":
            contact["layer"] = between(0.3, 2.0)
        if kind == "ellipse":
            contact |= {"radius_ratio": between(0.5, 2.0), **SQUARE}
        found.append({"kind": kind, "contact": contact})
    return found


def films(contact: dict[str, Any]) -> dict[str, list[float]]:
    """The films on all grids, coarsest first; empty where there is none on the finest.

    A layer is given as a share of the flooded film on 65 nodes; empty where there is none.
    """
    if "layer" in contact:
        flooded = simulate(rolling(**{**contact, "layer": None, "nodes": 65}))
        if not flooded.status.ok:
            return {}
        contact = {**contact, "layer": contact["layer"] * flooded.summary["H_c"]}
    if "oil" in contact:
        contact = {**contact, "oil": Oil(**contact["oil"])}
    result = simulate(rolling(**contact, nodes=NODES[-1]))
    return {name: result.dataset[name].values.tolist() for name in FILMS} if result.status.ok else {}


def solved(resume: bool) -> Iterator[dict[str, Any]]:
    """All cases with their films, from the file as far as they are there."""
    lines = STORED.read_text(encoding="utf-8").splitlines() if resume and STORED.exists() else []
    known = {line["case"]: line["films"] for line in map(json.loads, lines)}
    STORED.write_text("".join(f"{line}\n" for line in lines), encoding="utf-8")
    for case in cases():
        if (name := json.dumps(case)) not in known:
            known[name] = films(case["contact"])
            with STORED.open("a", encoding="utf-8") as file:
                file.write(json.dumps({"case": name, "films": known[name]}) + "\n")
        yield {**case, "films": known[name]}


def bars(case: dict[str, Any]) -> Iterator[Bar]:
    """The bars of a case by film and grid; there are none where the finest grid has no film."""
    regular = case["kind"] != "starved"  # as ertel has it
    for (name, values), nodes in product(case["films"].items(), PRINTED):
        grids = NODES.index(nodes) + 1
        bar, (*_, before, truth) = on_grids(values[:grids], regular)[-1], on_grids(values, regular)
        deviation, doubt = (abs(one.extrapolated - truth.extrapolated) for one in (bar, before))
        yield Bar(
            *(case["kind"], name, nodes, deviation / bar.error, doubt / 3 / bar.error),
            failed=case["films"]["H_min"][grids - 1] <= 0.0,
            known=bar.error <= UNKNOWN * bar.extrapolated,
        )


def row(contact: str, film: str, nodes: str, found: list[Bar]) -> list[str]:
    """A line of the table."""
    shown = [bar for bar in found if bar.shown]
    deviations = [bar.deviation for bar in shown] or [nan]
    holds = sum(deviation <= 1.0 for deviation in deviations)
    undecided = sum(abs(bar.deviation - 1.0) < bar.doubt for bar in shown)
    failed = sum(bar.failed for bar in found)
    counts = [str(len(shown)), str(holds), f"{holds / max(len(shown), 1):.0%}"]
    worst = [f"{max(deviations):.2f}", f"{np.median(deviations):.2f}"]
    return [contact, film, nodes, *counts, *worst, *map(str, (undecided, len(found) - len(shown) - failed, failed))]


def rates(found: list[Bar]) -> Iterator[list[str]]:
    """The lines of the table: each kind of contact by film and nodes, then all."""
    for kind, film, nodes in product(KINDS, FILMS, PRINTED):
        yield row(kind, film, str(nodes), [bar for bar in found if bar[:3] == (kind, film, nodes)])
    for film, nodes in product(FILMS, PRINTED):
        yield row("all", film, str(nodes), [bar for bar in found if bar[1:3] == (film, nodes)])
    yield row("all", "both", "both", found)


def orders(case: dict[str, Any]) -> Iterator[str]:
    """The observed order of each film on 33, 65, 129 and on 65, 129, 257 nodes, "-" where the sign changes."""
    for name in FILMS:
        changes = np.diff(case["films"][name])
        for ratio in changes[:-1] / changes[1:]:
            yield f"{log2(ratio):.1f}" if ratio > 0.0 else "-"


def described(case: dict[str, Any]) -> str:
    """The contact in words."""
    words = [f"{name} {value:.3g}" for name, value in case["contact"].items() if name in WORDS]
    if case["kind"] == "thinning":
        words += [f"{case['contact']['load']:.3g} N", f"{case['contact']['mean_speed']:.3g} m/s"]
    return ", ".join([case["kind"], *words])


def main() -> None:
    cache()
    every = list(solved("--resume" in sys.argv[1:]))
    there = [case for case in every if case["films"]]
    found = [bar for case in there for bar in bars(case)]
    without = f"{len(every) - len(there)} of {len(every)} contacts have no film on {NODES[-1]} nodes.\n\n"
    text = "# Error bars of steady films\n\n" + table(HEAD, rates(found)) + "\n" + without
    head = ["contact", *(f"order of {name}, to {nodes}" for name in FILMS for nodes in NODES[2:])]
    text += table(head, ([described(case), *orders(case)] for case in there))
    (FOLDER / "bars.md").write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
