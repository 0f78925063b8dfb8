"""The film of squalane against the slide-to-roll ratio: Carreau's law beside a Newtonian oil.

    python validation/friction/film_thinning.py

prints the table of README.md.  The constants of Carreau's law are those of the library (`ertel oils squalane`).
"""

import jax

import ertel
from ertel.case.case import Case
from ertel.solvers import steady

jax.config.update("jax_enable_x64", True)  # ertel itself asks for it in its public functions alone

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


def main() -> None:
    """Print the table."""
    plain = case(0.0, "newtonian")
    assert plain.scales is not None
    print(f"M = {plain.parameters.M:.0f}, L = {plain.parameters.L:.1f}, p_h = {plain.scales.p_h / 1e9:.2f} GPa\n")
    newtonian = films(0.0, "newtonian")
    print("| oil | S | h_c (nm) | h_min (nm) | h_c/Newtonian, 129 nodes | 65 nodes | Krylov iterations, 129 nodes |")
    print("|---|---|---|---|---|---|---|")
    for S, rheology in ((0.0, "newtonian"), *((S, "carreau") for S in SLIDE_TO_ROLL)):
        coarse, fine = films(S, rheology)
        ratios = [found[0] / plain_found[0] for found, plain_found in zip((fine, coarse), newtonian[::-1], strict=True)]
        name = "Newtonian" if rheology == "newtonian" else "Carreau"
        shown = f"{fine[0] * 1e9:.1f} | {fine[1] * 1e9:.1f} | {ratios[0]:.4f} | {ratios[1]:.4f} | {fine[2]}"
        print(f"| {name} | {S:g} | {shown} |", flush=True)


if __name__ == "__main__":
    main()
