"""The state at one time, the key values of its film, and the two interfaces of methods: in time, and steady."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple, Protocol

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array
from numpy.typing import NDArray

from ertel.case.status import Status
from ertel.numerics import bdf, multigrid
from ertel.numerics.grid import Grid, Symmetry
from ertel.numerics.integrals import Plane
from ertel.numerics.programs import ANY_SIZE, Program, exportable
from ertel.numerics.stencils import FloatLike, integral, total

Field = Any  # an array of NumPy or of JAX
THIN = 0.1  # of the film scale: below this the time error of a film is not taken relative to itself
TIE = 1e-6  # relative difference of two extremes that mirror each other


class Work(NamedTuple):
    """Iterations, and convolutions counted by the nodes of the finest grid."""

    newton: int = 0
    krylov: int = 0
    convolutions: float = 0.0


@dataclass(frozen=True)
class State:
    """The contact at one time: T in t0, approach in delta*, velocity dDelta/dT, fields of shape (n, n) or (n,) by name.

    The fields are P, H and others that a method needs to go on; where asperities touch, P_asperity is their part of P.
    load, outside: the double integral of P on the grid and outside it.  around: the number of nodes with P > 0 outside
    the middle of the grid, None where nobody has counted them, as after a change of the fields.  status, work, error,
    record: of the step that made this state: its outcome, its work, how far the film is from its prediction (relative),
    and its numbers by name (those of `Stepper.measure` and of `account`).
    """

    T: float
    approach: float
    velocity: float
    fields: Mapping[str, Field]
    status: Status = Status.CONVERGED
    work: Work = field(default_factory=Work)
    outside: float = 0.0
    load: float = 0.0
    error: float = 0.0
    around: float | None = None
    record: Mapping[str, float] = field(default_factory=dict)

    @property
    def P(self) -> Field:
        """The pressure."""
        return self.fields["P"]

    @property
    def P_f(self) -> Field:
        """The pressure of the oil."""
        return own_pressure(self.fields)

    @property
    def H(self) -> Field:
        """The film thickness."""
        return self.fields["H"]


def combined(weights: bdf.Weights, values: Sequence[Field]) -> Field:
    """The weighted sum of values at several times, numbers or arrays."""
    return sum(w * value for w, value in zip(weights, values, strict=True))


def interpolated(levels: Sequence[State], T: float) -> State:
    """The state at a time between or after the levels, by polynomial interpolation; P is not below zero."""
    weights = bdf.interpolation_weights(T, [level.T for level in levels])
    fields = {
        name: combined(weights, [np.asarray(level.fields[name]) for level in levels]) for name in levels[0].fields
    }
    if "P" in fields:
        fields["P"] = fields["P"].clip(0.0)
    if "P_asperity" in fields:
        fields["P_asperity"] = fields["P_asperity"].clip(0.0, fields["P"])
    approach, velocity, outside, load = (
        float(combined(weights, [getattr(level, name) for level in levels]))
        for name in ("approach", "velocity", "outside", "load")
    )
    return State(T, approach, velocity, fields, outside=outside, load=load)


def padded(levels: Sequence[State]) -> list[State]:
    """Three levels, the oldest repeated: one shape, so one compilation, whatever the history."""
    return [*levels, *[levels[-1]] * 2][:3]


# -- key values of a film on the plane: thicknesses, pressures, load, and where the extremes lie ----------------------


def measure(grid: Grid, P: Array, H: Array) -> dict[str, float]:
    """The key values of a film of shape `grid.shape`, dimensionless.

    H_c, P_c: at (0, 0).  H_min: the minimum where P > 0, at (X_min, Y_min).  P_max: at (X_P_max, Y_P_max); P_fall: how
    much lower the mean of the next nodes is (four, two on a line), as a share of it.  load: integral of P.  Of two
    extremes that mirror each other about an axis, the one on its positive side is named.
    """
    return unpacked(_numbers(Plane.of(grid), P, H))


def lowest_point(r: NDArray[np.float64], H: NDArray[np.float64]) -> tuple[float, float]:
    """Radius and value of the minimum of H: the vertex of the parabola through the lowest node and its neighbours."""
    i = int(np.argmin(H))
    if i in (0, len(r) - 1):
        return float(r[i]), float(H[i])
    curvature, slope, value = np.polyfit(r[i - 1 : i + 2] - r[i], H[i - 1 : i + 2], 2)
    return float(r[i] - slope / (2 * curvature)), float(value - slope**2 / (4 * curvature))


def key_values(plane: Plane, P: Array, H: Array) -> dict[str, Array]:
    """The values of `measure`; traceable by JAX."""
    pressed = jnp.where((P > 0.0) | (P.max() <= 0.0), H, jnp.inf)
    H_min, P_max = pressed.min(), P.max()
    negative = TIE * ((plane.y < 0).astype(P.dtype) + (plane.x < 0))
    thin, high = _lowest(pressed + jnp.abs(H_min) * negative), _lowest(P_max * negative - P)
    lines = list(zip((P[:, high[1]], P[high[0]]), high, plane.even, strict=True))[-1 if len(P) == 1 else 0 :]
    around = sum(_beside(*line) for line in lines) / (2 * len(lines))
    fall = jnp.where(P_max > 0, 1 - around / P_max, 0.0)
    (X_min, Y_min), (X_P_max, Y_P_max) = ((plane.x[j], plane.y[i, 0]) for i, j in (thin, high))
    films = {"H_c": H.ravel()[plane.centre], "H_min": H_min, "X_min": X_min, "Y_min": Y_min}
    peak = {"P_max": P_max, "X_P_max": X_P_max, "Y_P_max": Y_P_max, "P_fall": fall}
    load = integral(P, plane.spacing, plane.even)
    return {**films, "P_c": P.ravel()[plane.centre], **peak, "load": load}


def _lowest(field: Array) -> tuple[Array, Array]:
    """Row and column of the first lowest value: along the rows first, because XLA searches a whole field slowly."""
    row = jnp.argmin(field.min(axis=1))
    return row, jnp.argmin(field[row])


def _beside(line: Array, node: Array, even: bool) -> Array:
    """The sum of the values on either side of a node; zero beyond an end that is not an axis of symmetry."""
    p = jnp.pad(line, 1)
    before = p.at[0].set(p[2]) if even else p
    return before[node] + p[node + 2]


def packed(numbers: Mapping[str, FloatLike]) -> dict[str, Array]:
    """The numbers as one array under all their names, so that the host reads the device once; traceable by JAX."""
    return {" ".join(numbers): jnp.stack([jnp.asarray(number, float) for number in numbers.values()])}


def unpacked(numbers: Mapping[str, Array]) -> dict[str, float]:
    """The numbers on the host by name, from `packed`."""
    [(names, values)] = numbers.items()
    return dict(zip(names.split(), np.asarray(values).tolist(), strict=True))


def _key_numbers(plane: Plane, P: Array, H: Array) -> dict[str, Array]:
    return packed(key_values(plane, P, H))


_numbers = Program(jax.jit(_key_numbers), ANY_SIZE)


def film_error(film: Array, predicted: Array, P: Array, thin: Array | float, even: Symmetry, coarsenings: int) -> Array:
    """Relative difference of two films, root mean square over the load that P carries; `thin`: see `THIN`.

    It is taken on a coarser grid: a pressure spike of a few cells that moves has an error at every node that it
    passes, which does not grow into the film and would make the number of steps that of the nodes.
    """
    for _ in range(coarsenings):
        film, predicted, P = (multigrid.restrict(field, even) for field in (film, predicted, P))
    relative = (film - predicted) / (jnp.abs(film) + thin)
    return jnp.sqrt(total(P * relative**2, even) / jnp.maximum(total(P, even), jnp.finfo(P.dtype).tiny))


# -- the interfaces of methods ----------------------------------------------------------------------------------------


def level_fields(P: Array, P_f: Array | None, H: Array, mass: Array) -> dict[str, Array]:
    """The fields of a level.  P_f: the pressure of the oil, where asperities carry the rest of P; otherwise None."""
    return {"P": P, **({} if P_f is None else {"P_asperity": P - P_f}), "H": H, "mass": mass}


def own_pressure(fields: Mapping[str, Field]) -> Field:
    """The pressure of the oil: P less what asperities carry."""
    return fields["P"] - fields["P_asperity"] if "P_asperity" in fields else fields["P"]


class StepNumbers(NamedTuple):
    """The numbers of a step that a `State` has beside its record."""

    approach: Any
    velocity: Any
    load: Any
    outside: Any
    error: Any
    around: Any
    converged: Any
    newton: Any
    krylov: Any


@exportable
class StepSolution(NamedTuple):
    """The new fields, and all numbers of the step, `packed`: `StepNumbers` and those of the film by their names."""

    fields: Mapping[str, Array]
    numbers: Mapping[str, Array]


class Stepper(Protocol):
    """A method that steps a contact forward in time, made of a case.

    coordinates: axes of the fields in order, by name, in units a*.
    """

    coordinates: Mapping[str, Any]

    def start(self) -> State:
        """The state at T = 0."""

    def advance(self, levels: Sequence[State], step: float) -> State:
        """One step on from one to three levels, newest first; the new state has its error and its record."""

    def measure(self, level: State) -> dict[str, float]:
        """F (in units of the Hertz load F*) and the key values of `measure`.

        If the contact is axisymmetric, the extremes lie on rings: X_min, X_P_max are their radii, Y_min, Y_P_max are 0.
        """

    def friction(self, level: State) -> Any:
        """The `account.Friction` of a level; its maps are of the shape of the fields."""

    def whole(self, field: Field, odd: bool = False) -> Field:
        """A field on all nodes of `coordinates`: a level may keep one side of an axis of symmetry only.

        odd: whether the field changes its sign at the axis Y = 0.
        """


class SteadySolver(Protocol):
    """A method that finds a steady contact on one grid after the other, made of a case.

    grids: coarsest first, each with its `coordinates` and its number of `nodes`; the last one is that of the case.  A
    solution on a grid has P, H and its history of residuals, its plain numbers and its status as
    `solvers.grid_solution.GridSolution`, all of which are stored, and its `record` and `maps`, which are shown.
    """

    grids: Sequence[Any]

    def compile_ahead(self) -> None:
        """Compile what the grids need, or load it, in the background."""

    def solve(self, done: Sequence[Any]) -> Any:
        """The solution on the next grid, after those that are done."""

    def restored(self, number: int, stored: Mapping[str, Any]) -> Any:
        """The solution on a grid, by its number, from what was stored of it."""
