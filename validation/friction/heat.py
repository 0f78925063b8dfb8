"""Tables of heat.md: the warm film of a line contact, of a ball, with the grid and across the film; what it costs.

python validation/friction/heat.py
python validation/friction/heat.py one-mobility
python validation/friction/heat.py across-the-film

The last two change the equations, as trials did, and are for one of them in a process.
"""

import sys
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from scipy.interpolate import lagrange

import ertel
from ertel.case.case import Case
from ertel.equations.across import Vector, length
from ertel.equations.columns import WarmColumns
from ertel.equations.energy import Energy
from ertel.equations.thinning import ThinningFlow
from ertel.numerics.lobatto import Lobatto
from ertel.numerics.programs import Program, double_precision
from ertel.physics.fluidity import ReeEyring
from ertel.physics.lubricant import Oil
from ertel.physics.thermal import gupta_factor, wilson_sheu_factor
from ertel.solvers import heat
from ertel.solvers.steady import Rolling, steady_film

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "tests"))
from common import table
from solvers.test_heat import PROGRAM, STEEL, roller

BALL = [(1, 0), (5, 0), (10, 0), (20, 0), (5, 0.2), (10, 0.2), (5, 1), (10, 1)]  # m/s, S


def ball(speed: float, slides: float, nodes: int, inlet: str = "solved") -> Case:
    """A steel ball of R = 10 mm, 0.97 GPa, 40 mPa s, 22 /GPa, Eyring's stress 5 MPa."""
    bodies = {f"{key}_{number}": value for number in (1, 2) for key, value in STEEL.items()}
    thermal = {"temperature": 313.0, "beta": 0.04, "conductivity": 0.14, "inlet": inlet, **bodies}
    oil = Oil(eta0=0.04, alpha=22e-9, rheology=ReeEyring(5e6))
    contact = {"radius": 0.01, "load": 37.0, "E_prime": 226e9, "oil": oil, "nodes": nodes}
    return ertel.rolling(**contact, mean_speed=float(speed), slide_to_roll=slides, thermal=thermal)


def solved(case: Case) -> tuple[Rolling, float]:
    """The film, and the CPU seconds that it took."""
    start = time.process_time()
    return steady_film(case), time.process_time() - start


def factors() -> None:
    """Both formulas against L_t."""
    rows = [
        [
            L_t,
            *(gupta_factor(L_t, S, 0.5 / 226) for S in (0, 0.2, 1)),
            *(wilson_sheu_factor(L_t, S) for S in (0, 0.2, 1)),
        ]
        for L_t in (0.01, 0.1, 0.5, 1.0, 3.0)
    ]
    names = ["L_t", "Gupta S = 0", "0.2", "1", "Wilson-Sheu S = 0", "0.2", "1"]
    table(names, [[f"{row[0]:g}", *(f"{each:.4f}" for each in row[1:])] for row in rows])


def lines(nodes: int = 257) -> None:
    """The rows of the independent program."""
    rows = []
    for speed, slides, *bodies, ratio, hottest, share, traction in PROGRAM:
        given = speed, slides, *bodies
        warm, cold = (steady_film(roller(*given, nodes=nodes, inlet=way)).finest for way in ("solved", "none"))
        h, a = warm.heat, warm.case.scales.a_over_R
        new, old = warm.measure(), cold.measure()
        films = [new[name] / old[name] for name in ("H_c", "H_min")]
        c = float(h.share[0, np.abs(warm.grid.x).argmin()])
        found = f"{films[0]:.4f}", f"{ratio:.3f}", f"{films[1]:.4f}", f"{h.T.max():.1f}", f"{hottest:g}"
        friction = f"{float(h.sliding[0]) * a:.4f}", f"{traction:.4f}"
        rows.append([f"{speed:g}", f"{slides:g}", ", ".join(bodies), *found, f"{c:.3f}", f"{share:.3f}", *friction])
    heads = ["u (m/s)", "S", "bodies, the fast one first", "H_c over cold", "program", "H_min over cold"]
    table([*heads, "hottest (K)", "program", "c", "program", "mu", "program"], rows)


def balls(nodes: int = 129) -> None:
    """Films of a ball with heat over those without, beside the formula, and what they cost."""
    rows = []
    for speed, slides in BALL:
        for _ in range(2):  # the second time nothing is compiled
            (warm, seconds), (cold, less) = (
                solved(ball(speed, slides, nodes)),
                solved(ball(speed, slides, nodes, "none")),
            )
        new, old, h = warm.finest.measure(), cold.finest.measure(), warm.finest.heat
        phi = gupta_factor(h.inlet.L_t, slides, warm.finest.case.scales.p_h / 226e9)
        films = f"{new['H_c'] / old['H_c']:.4f}", f"{phi:.3f}", f"{new['H_min'] / old['H_min']:.4f}"
        work = f"{sum(s.newton for s in warm.solutions)} / {sum(s.newton for s in cold.solutions)}"
        cost = f"{warm.convolutions / cold.convolutions:.1f}", f"{seconds / less:.1f}"
        rows.append([f"{speed:g}", f"{slides:g}", f"{h.inlet.L_t:.2f}", *films, f"{h.T.max():.1f}", work, *cost])
    heads = ["u (m/s)", "S", "L_t", "H_c over cold", "phi_T", "H_min over cold", "hottest (K)"]
    table([*heads, "Newton iterations, warm / cold", "convolutions, ratio", "CPU time, ratio"], rows)


def finer() -> None:
    """The grid and the points across the film, in pure rolling at 10 m/s and with S = 1 at 5 m/s."""
    given, rows = ((10.0, 0.0, "steel", "steel"), (5.0, 1.0, "steel", "steel")), []
    for nodes in (129, 257, 513, 1025):
        films = [steady_film(roller(*each, nodes=nodes)).finest.measure()["H_c"] for each in given]
        rows.append([str(nodes), str(heat.POINTS), *(f"{film:.6f}" for film in films)])
    for points in (5, 9, 13):
        heat.POINTS, heat._program = points, Program(jax.jit(heat._temperatures), heat.SMALL)
        films = [steady_film(roller(*each, nodes=257)).finest.measure()["H_c"] for each in given]
        rows.append(["257", str(points), *(f"{film:.6f}" for film in films)])
    table(["nodes", "points across", "H_c, 10 m/s, S = 0", "H_c, 5 m/s, S = 1"], rows)


def changed(*functions: tuple[Any, str, Any]) -> None:
    """Put other functions into the equations of this process, before any program is compiled."""
    for owner, name, function in functions:
        setattr(owner, name, function)


def one_mobility(nodes: int = 65) -> None:
    """Sliding balls with the mobility along the sliding for both directions, as the trial of the method had it."""
    film, force, mobility = ThinningFlow._film, ThinningFlow._force, WarmColumns.mobility

    def along_x(gradient: Vector) -> Vector:
        return Vector(length(gradient), 0.0 * gradient.x)

    def one_force(flow: ThinningFlow, contact: Any, points: Any, solution: Any) -> Vector:
        return force(flow, contact, points, solution).x / length(points.slope) * points.slope

    def one(columns: WarmColumns, warmer: Any) -> Any:
        both = mobility(replace(columns, gradient=along_x(columns.gradient)), warmer)
        return jnp.stack([both[0], both[0]])

    changed(
        (ThinningFlow, "_film", lambda flow, c, points: film(flow, c, points._replace(slope=along_x(points.slope)))),
        (ThinningFlow, "_force", one_force),
        (WarmColumns, "mobility", one),
    )
    rows = []
    for speed, slides in BALL[4:]:
        films = [steady_film(ball(speed, slides, nodes, way)).finest.measure()["H_c"] for way in ("solved", "none")]
        rows.append([f"{speed:g}", f"{slides:g}", f"{films[0] / films[1]:.4f}"])
    table(["u (m/s)", "S", "H_c over cold, one mobility"], rows)


def across_the_film(nodes: int = 129) -> None:
    """Lines whose oil takes its heat along from one height to another, too: rho c w dT/dz, with w by continuity."""
    kept, z = Energy._kept, np.ravel(Lobatto.of(heat.POINTS).z)
    slope = np.array([[lagrange(z, row).deriv()(at) for row in np.eye(len(z))] for at in z])

    def with_lift(energy: Energy, T: Any, m: Any, released: Any, inlet: Any) -> Any:
        columns, across = energy.columns, energy.columns.across
        flow = jnp.pad(energy.capacity * columns.film * m.u, ((0, 0), (0, 0), (1, 1)), mode="edge")
        up = -across.from_below(flow[..., 2:] - flow[..., :-2]) / (2.0 * energy.spacing)
        up = (up - (across.z + 0.5) * up[-1]) / columns.film  # the film of both grids keeps its mass to their error
        return kept(energy, T, m, released, inlet) + across.weights * up * jnp.tensordot(jnp.asarray(slope), T, 1)

    changed((Energy, "_kept", with_lift))
    rows = []
    for speed, slides, *bodies, ratio, _, _, _ in PROGRAM:
        given = speed, slides, *bodies
        warm, cold = (steady_film(roller(*given, nodes=nodes, inlet=way)).finest for way in ("solved", "none"))
        films = [each.measure()["H_c"] for each in (warm, cold)]
        found = f"{films[0] / films[1]:.4f}", f"{ratio:.3f}", str(warm.status)
        rows.append([f"{speed:g}", f"{slides:g}", ", ".join(bodies), *found])
    table(["u (m/s)", "S", "bodies, the fast one first", "H_c over cold", "program", "status"], rows)


TRIALS = {"one-mobility": one_mobility, "across-the-film": across_the_film}

if __name__ == "__main__":
    with double_precision():
        for part in [TRIALS[name] for name in sys.argv[1:]] or (factors, lines, balls, finer):
            part()
