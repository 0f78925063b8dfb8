"""Made-up runs, of which everything is known: the dry impact with a film, rolling contacts, steady and in time.

And random fields that are even about an axis.
"""

from dataclasses import dataclass, field, replace

import numpy as np
import pytest
import xarray as xr

from ertel.case.case import Case
from ertel.case.estimates import grid_of
from ertel.case.methods import METHODS
from ertel.case.status import Status
from ertel.inputs.case_files import parse_case
from ertel.inputs.python import Oil, rolling
from ertel.numerics.grid import NO_SYMMETRY, Symmetry
from ertel.physics import hertz
from ertel.results import variables
from ertel.results.dataset import Frame, assemble, assemble_steady
from ertel.solvers.grid_solution import GridSolution

FIRST_TOUCH = 1.0  # t0: of `dry_front`
every_symmetry = pytest.mark.parametrize(
    "even", [NO_SYMMETRY, Symmetry(y=True), Symmetry(x=True), Symmetry(True, True)], ids=str
)


def even_fields(even: Symmetry, *shape: int, seed: int = 0) -> np.ndarray:
    """Random fields on the whole plane, the last two axes."""
    field = np.random.default_rng(seed).random(shape)
    field = (field + field[..., ::-1, :]) / 2 if even.y else field
    return (field + field[..., ::-1]) / 2 if even.x else field


BALL_FALLS = {
    "contact": {"radius": "10 mm", "mass": "32.6726 g", "speed": "0.1 m/s", "E_prime": "226.37 GPa"},
    "lubricant": {"eta0": "0.1 Pa*s", "alpha": "22 / GPa"},
}
MOES_FALLS = {"contact": {"M": 1000, "L": 10}}


def maps(P: np.ndarray, H: np.ndarray) -> dict[str, np.ndarray]:
    """A film with a shear stress that is a share of the pressure."""
    return {"P": P, "H": H, "oil": H, "tau_x": 3.0 * P, "tau_y": 0.0 * P, "loss": 0.9 * P}


def dry_impact(case_data, radial=False, rebound=True) -> xr.Dataset:
    """The dry impact with a made-up film: everything about it is known."""
    case = parse_case(case_data)
    times = np.linspace(0.05, 3.9 if rebound else 2.45, 78 if rebound else 49)
    axis = np.linspace(0, 2, 41) if radial else np.linspace(-2, 2, 81)
    r = axis if radial else np.hypot(axis[:, None], axis[None, :])
    records, frames = [], []
    for T in times:
        A = max(float(hertz.contact_radius(T - 1)), 1e-3)
        P, H = hertz.pressure(r, A), hertz.gap(r, A) + 0.05 + max(1 - T, 0)
        scalars = {"Delta": float(hertz.approach(T - 1)), "V": float(hertz.velocity(T - 1)), "F": A**3}
        scalars |= {"P_c": A, "P_max": A, "H_c": float(H.min()), "H_min": float(H.min()) / 2, "X_min": A}
        records.append({"T": T, **dict.fromkeys(variables.STEPS, 0.0), **scalars})
        event = "max-approach" if abs(T - 2.45) < 1e-9 else ""
        frames.append(Frame(float(T), maps(P, H), event))
    coordinates = {"r": axis} if radial else {"Y": axis, "X": axis}
    return assemble(case, records, frames, coordinates)


BARUS = Oil(eta0=0.04, alpha=2.2e-8, viscosity="barus", density="incompressible")
BALL_ROLLS = rolling(  # M = 200, L = 10
    radius=0.01, load=38.885237, mean_speed=0.502636, E_prime=2.197802e11, oil=BARUS, nodes=81, name="steel_ball"
)
C1 = BALL_ROLLS.contact.scales
assert C1 is not None
BARS = BALL_ROLLS.parameters
MOES_ROLLS = rolling(lambda_bar=BARS.lambda_bar, alpha_bar=BARS.alpha_bar, oil=BARUS, nodes=81)
X, Y = np.linspace(-4.5, 1.5, 81), np.linspace(-3.0, 3.0, 81)
NODES = (33, 65, 129)
H_C, H_MIN = np.array([0.07, 0.09, 0.095]), np.array([-0.01, 0.03, 0.04])


def fields(x: np.ndarray, y: np.ndarray, film: float, flow: float = 1.0) -> tuple[np.ndarray, np.ndarray]:
    """Hertz' pressure with an inlet upstream, and Hertz' gap with a film and two side lobes: P, H of shape (Y, X)."""
    r = np.hypot(x[None, :], y[:, None])
    P = hertz.pressure(r) + np.where(flow * x[None, :] < 0, 1e-3 * np.exp(-(r**2)), 0.0)
    lobes = 0.5 * film * np.exp(-20 * ((x[None, :] - 0.2) ** 2 + (np.abs(y[:, None]) - 0.8) ** 2))
    return P, hertz.gap(r) + film - lobes


@dataclass(frozen=True)
class Solved(GridSolution):
    """A solution that measures what it is told."""

    values: dict[str, float] = field(default_factory=dict)

    def measure(self) -> dict[str, float]:
        return self.values


def solutions(case: Case, flow: float = 1.0) -> tuple[Solved, ...]:
    solved = []
    histories = [(1.0, 1e-3, 1e-9), (1.0, 1e-2, 1e-5, 1e-9), (1.0, 1e-4, 2e-9)]
    for nodes, H_c, H_min, past in zip(NODES, H_C, H_MIN, histories, strict=True):
        grid = grid_of(replace(case, solver=replace(case.solver, nodes=nodes, fold=False)))
        there = variables.names_where(lambda v: v.at_moment and v.over and v.scale != variables.COEFFICIENT)
        values = dict.fromkeys((name for name in there if name not in ("F", "power_loss")), 1.0)
        values |= {"H_c": float(H_c), "H_min": float(H_min), "load": 2 * np.pi / 3}
        P, H = fields(np.asarray(grid.x), np.asarray(grid.y), H_c, flow)
        converged = Status.CONVERGED
        solved.append(Solved(case, grid, P, H, 1.0, 1e-9, converged, 3, 9, 50.0, history=past, values=values))
    return tuple(solved)


def steady(case: Case, flow: float = 1.0) -> xr.Dataset:
    solved = solutions(case, flow)
    return assemble_steady(case, solved[-1].grid, solved)


def with_temperature(data: xr.Dataset) -> xr.Dataset:
    """A steady contact whose surface 1 is 10 K and surface 2 20 K warmer than its inlet, and the film yet warmer."""
    zeta, loaded = np.array([-0.5, 0.0, 0.5]), data["P"].sel(Y=0.0, method="nearest").values ** 0.5
    T = 300.0 + np.outer([20.0, 40.0, 10.0], loaded)
    about = variables.variable_attributes("T_across", None)
    return data.assign_coords(zeta=zeta).assign(T_across=(("zeta", "X"), T, about))


def as_in_time(case: Case) -> Case:
    """The same contact, as a run in time."""
    return replace(case, solver=replace(METHODS["transient"].defaults, nodes=81))


def in_time(case: Case, flow: float = 1.0) -> xr.Dataset:
    """A film that breathes, as `assemble` gives it."""
    case = as_in_time(case)
    records, frames = [], []
    for T in np.linspace(0, 4, 41):
        film = 0.1 + 0.02 * float(np.sin(T))
        P, H = fields(X, Y, film, flow)
        known = {"T": T, "dT": 0.1, "F": 1.0, "w": 1.0, "U": flow, "Delta": 0.9, "H_c": film, "H_min": film / 2}
        known |= {"X_min": 0.2, "Y_min": 0.8, "P_c": 1.0, "P_max": 1.0}
        records.append({**dict.fromkeys(variables.STEPS, 0.0), **known})
        frames.append(Frame(float(T), maps(P, H), "end" if T == 4 else ""))
    return assemble(case, records, frames, {"Y": Y, "X": X})


def dry_front(interval: float = 0.02, two_dimensional: bool = False) -> xr.Dataset:
    """The dry impact as if it were a run: Hertz' pressure, and a film that is least at the contact's edge."""
    end = FIRST_TOUCH + hertz.HALF_CONTACT_TIME
    frames = np.append(np.arange(0.5, end, interval), end)
    A = hertz.contact_radius(frames - FIRST_TOUCH)[:, None]
    X = np.linspace(-1.5, 1.5, 601) if two_dimensional else np.linspace(0.0, 1.5, 301)
    fields = {"P": np.sqrt(np.maximum(A**2 - X**2, 0.0)), "H": 0.01 + (np.abs(X) - A) ** 2}
    dims, axes = ("frame", "r"), {"r": X}
    if two_dimensional:
        dims, axes = ("frame", "Y", "X"), {"Y": np.array([-0.5, 0.0, 0.5]), "X": X}
        fields = {name: np.stack([0.3 * f, f, 0.3 * f], axis=1) for name, f in fields.items()}
    scalars = {"Delta": hertz.approach(frames - FIRST_TOUCH), "X_min": A[:, 0], "Y_min": 0 * A[:, 0], "P_max": A[:, 0]}
    variables = {name: ("time", values) for name, values in scalars.items()}
    variables |= {name: (dims, f) for name, f in fields.items()}
    variables["event"] = "frame", (frames == end).astype(int)
    return xr.Dataset(variables, {"time": frames, "frame": frames, **axes})
