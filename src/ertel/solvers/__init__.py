"""How a steady contact or one time step is found: one class for each method, by its name in `case.methods`."""

from collections.abc import Callable

from ertel.case.case import Case
from ertel.equations.state import SteadySolver, Stepper
from ertel.solvers.radial import RadialImpact
from ertel.solvers.steady import SteadyFilm
from ertel.solvers.transient import Transient2D

SOLVERS: dict[str, Callable[[Case], Stepper | SteadySolver]] = {
    "2d": Transient2D,
    "radial": RadialImpact,
    "steady": SteadyFilm,
    "transient": Transient2D,
}
