"""Waviness at rest under a sliding oil against Hooke's linear theory: a Newtonian oil beside Eyring's.

    python validation/friction/waviness.py [--nodes 257]

prints the tables of waviness.md.
"""

import sys
from collections.abc import Iterator
from pathlib import Path

import ertel
from ertel.case.case import Case
from ertel.physics.fluidity import ReeEyring
from ertel.runs.response import respond_in_rolling

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "tests"))
import ripples
from common import nodes, table

WAVELENGTHS = (0.25, 0.35, 0.5, 1.0)  # a
OILS = {"20": (20e-9, (None, 5e6, 1e6)), "4": (4e-9, (None, 1e6))}  # alpha in 1/GPa: alpha, Eyring's stresses


def case(alpha: float, tau0: float | None, nodes: int) -> Case:
    """A ball of 20 mm, 20 N, 1 m/s; the wavy surface is at rest and the other one slides with 2 m/s."""
    return ertel.rolling(
        radius="10 mm",
        E_prime="226 GPa",
        load="20 N",
        mean_speed="1 m/s",
        slide_to_roll=-2.0,
        oil=ertel.Oil(eta0="40 mPa*s", alpha=alpha),
        rheology="newtonian" if tau0 is None else ReeEyring(tau0),
        half_width=2.0,
        inlet=2.5,
        nodes=nodes,
    )


def rows(nodes: int) -> Iterator[list[str]]:
    """Those of all oils."""
    for alpha_in_gpa, (alpha, stresses) in OILS.items():
        for tau0 in stresses:
            name = "Newtonian" if tau0 is None else f"Eyring {tau0 / 1e6:g} MPa"
            for row in of_oil(case(alpha, tau0, nodes)):
                yield [f"{alpha_in_gpa}, {name}", *row]


def of_oil(chosen: Case) -> Iterator[list[str]]:
    """The rows of one oil."""
    data = respond_in_rolling(chosen, [wave for length in WAVELENGTHS for wave in ripples.pair(length)])
    assert data.attrs["status"] == "converged"
    at = ripples.centre(chosen, data)
    cells = (chosen.solver.nodes - 1) / (2 * chosen.solver.half_width)
    for number, length in enumerate(WAVELENGTHS):
        found, theory = ripples.ripples(data, 2 * number, length), ripples.hooke(chosen, at, length)
        film, expected = abs(found.clearance), abs(theory.clearance)
        pressure = abs(found.pressure / theory.pressure)
        Q = ripples.hooke_number(chosen, at, length)
        about = f"{at.film * 1e9:.0f}", f"{length:g}", f"{length * cells:.0f}", f"{Q:.3g}"
        yield [*about, *(f"{value:.3f}" for value in (film, expected, film / expected, pressure))]


def refined(nodes: int) -> Iterator[list[str]]:
    """The ratio of film ripples on two grids, for alpha = 20 /GPa and Eyring's law with 5 MPa."""
    coarse, fine = ([row[6] for row in of_oil(case(20e-9, 5e6, n))] for n in ((nodes - 1) // 2 + 1, nodes))
    for length, *ratios in zip(WAVELENGTHS, coarse, fine, strict=True):
        yield [f"{length:g}", *ratios]


if __name__ == "__main__":
    chosen = nodes(257)
    head = ["alpha (1/GPa), oil", "h_c (nm)", "wavelength (a)", "cells", "Q", "film ripple/height", "Hooke", "ratio"]
    table([*head, "ratio of pressure ripples"], rows(chosen))
    print()
    table(["wavelength (a)", f"{(chosen - 1) // 2 + 1} nodes", f"{chosen} nodes"], refined(chosen))
