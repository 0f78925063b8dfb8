"""Squalane thins under shear: its film against that of a Newtonian oil of the same viscosity, and the traction.

    python examples/thinning_film.py

A steel ball rolls and slides on a glass disc in squalane at 25 degrees C, by Carreau's law with the constants of the
library.  The picture is thinning_film.png.
"""

from matplotlib.figure import Figure

import ertel

SLIDING = [0.0, 0.25, 0.5, 1.0, 1.5]


def curves(nodes: int = 65) -> dict[str, ertel.TractionCurve]:
    """Film and traction against the slide-to-roll ratio, with and without thinning."""
    found = {}
    for rheology in ("newtonian", "carreau"):
        case = ertel.rolling(
            radius="9.525 mm",
            load="20 N",
            mean_speed="2 m/s",
            material_1="steel",
            material_2="glass",
            oil="squalane",
            temperature="25 degC",
            rheology=rheology,
            nodes=nodes,
        )
        found[rheology] = ertel.traction(case, slide_to_roll=SLIDING)
    return found


def picture(found: dict[str, ertel.TractionCurve]) -> Figure:
    """The films of both oils side by side with the traction of the one that thins."""
    figure = Figure(figsize=(9, 3.6), layout="constrained")
    film, traction = figure.subplots(1, 2)
    for rheology, curve in found.items():
        data = curve.dataset
        film.plot(data["slide_to_roll"], 1e9 * data["h_c"], "o-", label=rheology)
    traction.plot(data["slide_to_roll"], data["mu_sliding"], "o-", color="C1")
    film.set(title="Film", xlabel="slide-to-roll ratio", ylabel="central film thickness (nm)")
    traction.set(title="Traction, carreau", xlabel="slide-to-roll ratio", ylabel="traction coefficient", ylim=(0, None))
    film.legend()
    return figure


if __name__ == "__main__":
    picture(curves()).savefig("thinning_film.png", dpi=120)
