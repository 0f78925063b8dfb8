"""Films from fringes: how often `film_of_intensity` is right, and what its warning says about it.

    python validation/optics/films.py [--films 500]

prints the tables of README.md.  Each film has 400 points, eight at least from a fringe to the next like it, and noise
of 0, 0.3 or 1 % of the contrast.  It is wrong where more than one point of fifty is off by half the distance of two
possible films or more.
"""

import argparse
import sys
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ertel.optics import DoubtfulFilm, Rig, film_of_intensity

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from common import table

GREEN, POINTS, NOISE = 532e-9, 400, (0.0, 0.003, 0.01)
CONTRAST = 0.43  # of fringes between chromium and steel
PERIOD = GREEN / (2 * Rig().index(1.0))  # film from a fringe to the next like it
KINDS = ("ball", "wedge", "dimple", "wedge with waves of 5 to 20 nm", "two slopes with a kink")
ODDS = ((-1.0, 2.0), (2.0, 5.0), (5.0, 10.0))


class Found(NamedTuple):
    """A film that was found.  kind: index in KINDS; odds: of the warning, infinite without one."""

    kind: int
    is_wrong: bool
    odds: float


def film_of(kind: int, random: np.random.Generator, x: np.ndarray) -> np.ndarray:
    """A film (m) of a kind, of any size."""
    thinnest, centre = random.uniform(0.15e-6, 0.4e-6), random.uniform(-0.4, 0.4)
    if kind == 0:
        return thinnest + random.uniform(0.4e-6, 1.4e-6) * (x - centre) ** 2
    if kind == 2:
        rim, height = random.uniform(0.4, 0.7), random.uniform(0.2e-6, 0.8e-6)
        outside = random.uniform(2e-6, 4e-6) * np.maximum(np.abs(x) - rim, 0.0) ** 2
        return thinnest + height * np.maximum(1 - (x / rim) ** 2, 0.0) ** 2 + outside
    if kind == 4:
        left, right = random.uniform(0.2e-6, 1e-6, size=2)
        return thinnest + left * np.maximum(centre - x, 0.0) + right * np.maximum(x - centre, 0.0)
    wedge = thinnest + random.uniform(0.2e-6, 1e-6) * (x + 1)
    if kind == 1:
        return wedge + random.uniform(-0.1e-6, 0.1e-6) * x**2
    return wedge + random.uniform(5e-9, 20e-9) * np.cos(2 * np.pi * x / random.uniform(0.1, 0.5) + 6.3 * centre)


def found(seed: int) -> Found:
    """The film of a seed, from its fringes with noise; one that begins on a fringe is replaced."""
    random, rig, kind = np.random.default_rng(seed), Rig(), seed % len(KINDS)
    while True:
        film = film_of(kind, random, np.linspace(-1.0, 1.0, POINTS))
        if np.abs(np.diff(film)).max() > PERIOD / 8:
            continue
        fringes = rig.fringes(GREEN, rig.index(1.0)).reflectance(rig.index(1.0) * film)
        intensity = fringes + random.choice(NOISE) * CONTRAST * random.standard_normal(POINTS)
        with warnings.catch_warnings(record=True) as given:
            warnings.simplefilter("always")
            try:
                seen = film_of_intensity(intensity, rig, GREEN, film[0])
            except ValueError:
                continue
        odds = [warning.message.odds for warning in given if isinstance(warning.message, DoubtfulFilm)]
        return Found(kind, bool(np.mean(np.abs(seen - film) > PERIOD / 4) > 0.02), min(odds, default=np.inf))


def by_kind(films: list[Found]) -> Iterator[list[str]]:
    """A row for each kind, and one for all."""
    for name, chosen in (*((name, [f for f in films if f.kind == k]) for k, name in enumerate(KINDS)), ("all", films)):
        warned = [f for f in chosen if np.isfinite(f.odds)]
        silent = [f for f in chosen if not np.isfinite(f.odds)]
        yield [name, f"{len(chosen)}", f"{np.mean([f.is_wrong for f in chosen]):.0%}", *map(right, (silent, warned))]


def right(films: list[Found]) -> str:
    """How many of these films are right."""
    return f"{sum(not f.is_wrong for f in films)} of {len(films)}"


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("--films", type=int, default=500)
    films = [found(seed) for seed in range(parser.parse_args().films)]
    table(["film", "number", "wrong", "right without a warning", "right with a warning"], by_kind(films))
    print()
    rows = ([f"{a:g} to {b:g}", right([f for f in films if a <= f.odds < b])] for a, b in ODDS)
    table(["odds of the warning (log)", "right"], rows)
