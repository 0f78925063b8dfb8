"""Validate elliptical contacts: formulas, rolling resistance, flow at an angle, mass; writes a table of each.

    python validation/contacts/validate.py [formula] [resistance] [angle] [mass] [--nodes N]

Each table takes some minutes on two cores, most of them for compiling: every ellipse has a grid of its own.
"""

import sys
from collections.abc import Iterator
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np

from ertel import Case, Oil, load_case, parse_case, rolling
from ertel.physics.film_formulas import expected_film
from ertel.results import balances, diagnostics
from ertel.results.parameters import formula_films
from ertel.solvers import steady
from ertel.solvers.grid_solution import GridSolution

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from common import BARUS, ISOVISCOUS, extrapolated, table, write

HERE = Path(__file__).parent
FLUIDS = {"barus, incompressible": BARUS, "roelands, dowson-higginson": {}}
TABLE = [(20, 10), (200, 10), (1000, 10), (200, 5), (200, 0)]
RATIOS = [1.0, 0.5, 0.2, 0.1, 0.05]


def case(M: float, L: float, D: float, nodes: int, oil: dict[str, Any], **more: Any) -> Case:
    contact = {"kind": "rolling", "M": M, "L": L, "radius_ratio": D, **more.pop("contact", {})}
    return parse_case(
        {
            "contact": contact,
            "lubricant": oil if L else ISOVISCOUS,
            "solver": {"nodes": nodes, "tolerance": 0.03, **more},
        }
    )


def moes(c: Case) -> float:
    """H of Moes over H in a^2/R."""
    p = c.parameters
    return float((1.5 * p.hertz.kappa * p.hertz.beta * p.M) ** (2 / 3))


# -- film thickness formula -------------------------------------------------------------------------------------------


def formula(nodes: int) -> str:
    """The central film against Nijenbanning, Venner and Moes, in Moes' unit."""
    head = ["R_x/R_y", "M", "L", "fluid", "grid", "H_Moes", "extrapolated", "formula", "formula/extrapolated - 1"]
    head += ["the same at ambient pressure", "Krylov per Newton iteration", "warned of"]
    return table(head, _formulas(nodes))


def _formulas(nodes: int) -> Iterator[list[str]]:
    for D, (M, L), (fluid, oil) in product(RATIOS, TABLE, FLUIDS.items()):
        if L or oil:
            cells = (nodes - 1) * (2 if M > 500 and D > 0.1 else 1)
            yield _formula(case(M, L, D, cells + 1, oil), fluid if L else "isoviscous", M, L, D)


def _formula(c: Case, fluid: str, M: float, L: float, D: float) -> list[str]:
    rolling = steady.steady_film(c)
    s, x, unit = rolling.finest, extrapolated(rolling, "H_c"), moes(c)
    joined = expected_film(c.parameters) * unit
    ambient = float(c.lubricant.density(s.measure()["P_c"])) * x.extrapolated * unit  # the oil of the film, expanded
    warnings = diagnostics.steady_warnings(c, rolling.solutions)
    said = [name for name in ("inlet", "uncertain") if any(name in text for text in warnings)]
    return [
        *(f"{D:g}", f"{M:g}", f"{L:g}", fluid, f"{s.grid.nodes_x} x {s.grid.nodes_y}"),
        *(f"{x.value * unit:.3f}", f"{x.extrapolated * unit:.3f}", f"{joined:.3f}"),
        *(f"{joined / (x.extrapolated * unit) - 1:+.1%}", f"{joined / ambient - 1:+.1%}"),
        *(f"{s.krylov / s.newton:.1f}", ", ".join(said)),
    ]


# -- rolling resistance -----------------------------------------------------------------------------------------------


def resistance(nodes: int) -> str:
    """1/2 of the double integral of H dP/dX, over the limit 7.5/(kappa M_BH) of Biboulet and Houpert (2010)."""
    return table(["R_x/R_y", "M_BH", "inlet", "share of the limit", "extrapolated"], _resistances(nodes))


def _resistances(nodes: int) -> Iterator[list[str]]:
    for D, M_BH, inlet in product([1.0, 0.25], [50.0, 100.0, 200.0], [4.5, 9.0, 18.0]):
        c = _long_inlet(D, M_BH, inlet, nodes)
        kappa = c.parameters.hertz.kappa
        coarse, fine = (_moment(s) * kappa * M_BH / 7.5 for s in steady.steady_film(c).solutions[-2:])
        yield [f"{D:g}", f"{M_BH:g}", f"{inlet:g}", f"{fine:.3f}", f"{fine + (fine - coarse) / 3:.3f}"]


def _long_inlet(D: float, M_BH: float, inlet: float, nodes: int) -> Case:
    """With Barus' oil, L = 10; the spacing is that of the inlet 4.5."""
    e = case(100.0, 10.0, D, nodes, BARUS).parameters.hertz
    cells = {4.5: nodes - 1, 9.0: 7 * (nodes - 1) // 4, 18.0: 13 * (nodes - 1) // 4}[inlet]
    length = 6.0 * cells / (nodes - 1)
    inlet = length * round(inlet / length * 16) / 16
    return case(M_BH / (e.beta**0.25 * e.kappa), 10.0, D, cells + 1, BARUS, half_width=length / 2, inlet=inlet)


def _moment(s: GridSolution) -> float:
    P, H, h = s.whole(s.P), s.whole(s.H), s.grid.spacing
    return float(0.5 * (H * np.gradient(P, h, axis=1)).sum() * h**2)


# -- flow at an angle -------------------------------------------------------------------------------------------------


def angle(nodes: int) -> str:
    """Films at angles from 0 to 90 degrees against Chittenden's formula; a steel contact with R_x/R_y = 1/4."""
    head = ["angle", "grid", "h_c (nm)", "extrapolated", "Chittenden", "h_min (nm)", "extrapolated", "Chittenden"]
    return table(head, (_angle(nodes, degrees) for degrees in (0.0, 30.0, 60.0, 90.0)))


def _angle(nodes: int, degrees: float) -> list[str]:
    c = parse_case(
        {
            "contact": {
                "kind": "rolling",
                "radius_x": "10 mm",
                "radius_y": "40 mm",
                "load": "60 N",
                "mean_speed": "1.5 m/s",
                "E_prime": "226.37 GPa",
                "entrainment_angle": f"{degrees} deg",
            },
            "lubricant": {**BARUS, "eta0": "40 mPa*s", "alpha": "22 / GPa"},
            "solver": {"nodes": nodes, "tolerance": 0.03},
        }
    )
    assert c.scales is not None
    rolling, nm = steady.steady_film(c), c.scales.film * 1e9
    chittenden = next(film for film in formula_films(c) if film.name.startswith("Chittenden"))
    cells = []
    for name, by in (("H_c", chittenden.central), ("H_min", chittenden.minimum)):
        x = extrapolated(rolling, name)
        cells += [f"{value * nm:.0f}" for value in (x.value, x.extrapolated, by or 0.0)]
    grid = rolling.finest.grid
    return [f"{degrees:g}", f"{grid.nodes_x} x {grid.nodes_y}", *cells]


# -- the balances of mass and energy -----------------------------------------------------------------------------------


def mass(nodes: int) -> str:
    """What the balances of mass and energy lack in oils that thin, on grids up to one of `nodes` nodes along x."""
    grids = [1 + (nodes - 1) // 2**k for k in reversed(range((nodes - 1).bit_length() - 5))]
    lacks = [f"{name} on {n}" for name in ("mass", "energy") for n in grids]
    return table(["contact", "grid", *lacks], _masses(nodes))


def _masses(nodes: int) -> Iterator[list[str]]:
    for name, c in _thinning(nodes):
        solutions = steady.steady_film(c).solutions
        grid, stands = solutions[-1].grid, solutions[-1].status.ok
        found = [balances.steady(c, s.account.terms, 1.0) for s in solutions]
        size = f"{grid.nodes_x} x {grid.nodes_y}" + ("" if stands else ", no film")
        masses, energies = ([each[which]["imbalance"] or 0.0 for each in found] for which in ("mass", "energy"))
        yield [name, size, *(f"{lack:.0e}" for lack in masses), *(f"{lack:.2%}" for lack in energies)]


def _thinning(nodes: int) -> Iterator[tuple[str, Case]]:
    """Contacts with Ree-Eyring oil: two examples, and a long ellipse."""
    for name in ("ball_bearing", "gear_flanks"):
        yield name, load_case(HERE.parents[1] / "examples" / f"{name}.toml", [f"solver.nodes={nodes}"])
    given = {"radius_x": 0.01, "mean_speed": 1.0, "slide_to_roll": 0.1, "E_prime": 226e9, "tolerance": 0.03}
    given |= {"oil": Oil(eta0=0.04, alpha=20e-9), "rheology": {"law": "ree-eyring", "tau0": "5 MPa"}, "nodes": nodes}
    yield "R_x/R_y = 0.05, 100 N", rolling(**given, radius_y=0.2, load=100.0)


if __name__ == "__main__":
    write(
        HERE,
        {
            "formula": ("Ellipses: the film formula", formula, 129),
            "resistance": ("Ellipses: rolling resistance", resistance, 129),
            "angle": ("Ellipses: flow at an angle", angle, 129),
            "mass": ("Ellipses: the balances of mass and energy with Ree-Eyring oil", mass, 129),
        },
    )
