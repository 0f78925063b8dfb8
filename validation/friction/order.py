"""Order of film and traction under refinement: Eyring's and Carreau's law beside a Newtonian oil.

    python validation/friction/order.py [--nodes 257]

prints the table of README.md.
"""

import sys
from collections.abc import Iterator
from math import log2
from pathlib import Path

import ertel
from ertel.physics.fluidity import Carreau, Fluidity, ReeEyring
from ertel.solvers import steady

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from common import nodes, table

OILS: dict[str, str | Fluidity] = {
    "Newtonian": "newtonian",
    "Eyring, 2 MPa": ReeEyring(2e6),
    "Carreau, 6 MPa, 0.42": Carreau(6e6, 0.42),
}


def levels(rheology: str | Fluidity, nodes: int) -> list[tuple[int, float, float, int]]:
    """Nodes, central film (a^2/R), traction coefficient and Krylov iterations on the three finest grids.

    A ball of 20 mm under 20 N, 1 m/s, S = 0.5: M = 61, L = 11, p_h = 0.79 GPa.
    """
    case = ertel.rolling(
        radius="10 mm",
        E_prime="226 GPa",
        load="20 N",
        mean_speed="1 m/s",
        slide_to_roll=0.5,
        oil=ertel.Oil(eta0="40 mPa*s", alpha="20 / GPa"),
        rheology=rheology,
        nodes=nodes,
    )
    assert case.scales is not None
    found = []
    for s in steady.steady_film(case).solutions[-3:]:
        assert s.status.ok
        mu = float(s.account.friction.sliding[0]) * case.scales.a / case.scales.R
        found.append((s.grid.nodes, s.measure()["H_c"], mu, s.krylov))
    return found


def order(values: list[float]) -> float:
    """From the values on three grids, each with half the spacing of the one before."""
    coarse, middle, fine = values
    return log2(abs(middle - coarse) / abs(fine - middle))


def rows(nodes: int) -> Iterator[list[str]]:
    """Those of all oils."""
    for name, rheology in OILS.items():
        found = levels(rheology, nodes)
        for n, H_c, mu, krylov in found:
            yield [name, f"{n}", f"{H_c:.6f}", f"{mu:.6f}", f"{krylov}"]
        yield [name, "order", *(f"{order([row[k] for row in found]):.2f}" for k in (1, 2)), ""]


if __name__ == "__main__":
    table(["oil", "nodes", "H_c", "traction coefficient", "Krylov iterations"], rows(nodes(257)))
