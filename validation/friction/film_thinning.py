"""The film of squalane against the slide-to-roll ratio: Carreau's law beside a Newtonian oil.

    python validation/friction/film_thinning.py

prints the table of README.md.  The constants of Carreau's law are those of the library (`ertel oils squalane`).
"""

import sys
from collections.abc import Iterator
from pathlib import Path

import ertel
from ertel.case.case import Case
from ertel.solvers import steady

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from common import table

SLIDE_TO_ROLL = (0.0, 0.1, 0.3, 1.0, 1.9)
NODES = 129  # nested iteration solves 65 on the way: the difference of the two shows the error of the grid


def case(slide_to_roll: float, rheology: str) -> Case:
    """A steel ball of 20 mm on a steel disc, 20 N, 2 m/s, at 25 degC."""
    return ertel.rolling(
        radius="10 mm",
        load="20 N",
        mean_speed="2 m/s",
        slide_to_roll=slide_to_roll,
        material_1="steel",
        material_2="steel",
        oil="squalane",
        temperature="25 degC",
        rheology=rheology,
        nodes=NODES,
    )


def films(slide_to_roll: float, rheology: str) -> list[tuple[float, float, int]]:
    """Central and minimum film thickness (m) and Krylov iterations on the two finest grids."""
    chosen = case(slide_to_roll, rheology)
    assert chosen.scales is not None
    found = []
    for s in steady.steady_film(chosen).solutions[-2:]:
        assert s.status.ok
        H = s.measure()
        found.append((H["H_c"] * chosen.scales.film, H["H_min"] * chosen.scales.film, s.krylov))
    return found


def rows() -> Iterator[list[str]]:
    """One for each slide-to-roll ratio, after that of the Newtonian oil."""
    newtonian = films(0.0, "newtonian")
    for S, rheology in ((0.0, "newtonian"), *((S, "carreau") for S in SLIDE_TO_ROLL)):
        coarse, fine = films(S, rheology)
        ratios = [found[0] / plain[0] for found, plain in zip((fine, coarse), newtonian[::-1], strict=True)]
        thickness = f"{fine[0] * 1e9:.1f}", f"{fine[1] * 1e9:.1f}", *(f"{ratio:.4f}" for ratio in ratios)
        yield [rheology.title(), f"{S:g}", *thickness, str(fine[2])]


if __name__ == "__main__":
    contact = case(0.0, "newtonian")
    assert contact.scales is not None
    p = contact.parameters
    print(f"M = {p.M:.0f}, L = {p.L:.1f}, p_h = {contact.scales.p_h / 1e9:.2f} GPa\n")
    head = ["oil", "S", "h_c (nm)", "h_min (nm)", "h_c/Newtonian, 129 nodes", "65 nodes"]
    table([*head, "Krylov iterations, 129 nodes"], rows())
