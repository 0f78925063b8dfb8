"""The steady contact on one grid: its fields, its account, its temperatures, and what is stored and shown of them."""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array
from numpy.typing import NDArray

from ertel.case.case import Case
from ertel.case.status import Status
from ertel.equations import account, contact, discretise
from ertel.equations.contact import Contact
from ertel.equations.flow import OilContent, Rate, steady_rate, through_faces
from ertel.equations.state import level_fields, measure
from ertel.equations.warm import WarmFlow
from ertel.numerics import stencils
from ertel.numerics.grid import Grid
from ertel.numerics.integrals import Plane
from ertel.numerics.lobatto import Lobatto
from ertel.numerics.programs import ANY_SIZE, Program
from ertel.numerics.stencils import Pair
from ertel.solvers.guesses import motion_of
from ertel.solvers.heat import Heated, WarmFactors, heated

Floats = NDArray[np.float64]


def warm_contact(case: Case, grid: Grid, factors: WarmFactors | None = None, stress: Array | None = None) -> Contact:
    """The contact at T = 0 with the flow of a warm film, if there is one.  stress: in the middle of the film."""
    c = discretise.contact_of(case, grid)
    if factors is None:
        return c
    there = np.zeros((2, *grid.shape)) if stress is None else stress
    share, along_x, along_y, there = jax.device_put((factors.share, *factors.theta, there))
    return replace(c, flow=WarmFlow(share, Pair(along_x, along_y), there, case.motion.entrainment(0.0), c.flow))


class SteadyAccount(NamedTuple):
    """The terms of the balances and the coefficients of the friction by name, the friction, and the oil there."""

    terms: dict[str, float]
    friction: account.Friction
    oil: OilContent


@dataclass(frozen=True)
class GridSolution:
    """The steady contact of a case on one grid: fields of its shape, approach in a^2/R, status and work.

    The account of the film and its temperatures are computed once, when they are first asked for.
    history: maximum residual before the first and after each Newton iteration.  convolutions: work on this grid.
    outside: the load that the oil outside the grid carries (double integral of P).  kinked: where a starved film is.
    P_asperity: what asperities carry of P, None where none touch.  share, theta, T: of a film that is solved with its
    heat, see `heat.WarmFactors`.
    """

    case: Case
    grid: Grid
    P: Any
    H: Any
    approach: float
    residual: float
    status: Status
    newton: int
    krylov: int
    convolutions: float
    history: tuple[float, ...] = ()
    outside: float = 0.0
    kinked: Any = None
    P_asperity: Any = None
    share: Any = None
    theta: Any = None
    T: Any = None

    def measure(self) -> dict[str, float]:
        """Films, pressures and load, see `state.measure`, and Delta."""
        return {"Delta": self.approach, **self._values, "load": self._values["load"] + self.outside}

    @cached_property
    def _values(self) -> dict[str, float]:
        return measure(self.grid, self.P, self.H)

    @property
    def fields(self) -> dict[str, Array]:
        """P, H and the oil that is there, as mass, as in a `State`."""
        return level_fields(self.P, None if self.P_asperity is None else self.P_f, self.H, self.content.oil)

    @property
    def P_f(self) -> Any:
        """The pressure of the oil."""
        return self.P if self.P_asperity is None else self.P - self.P_asperity

    @property
    def content(self) -> OilContent:
        """The oil that is there."""
        return self.account.oil

    @property
    def load(self) -> float:
        """The double integral of P on the grid."""
        return self._values["load"]

    @cached_property
    def account(self) -> SteadyAccount:
        """Its balances, its friction and its oil."""
        m, scale = self.case.motion, self.case.geometry.hertz_load
        U, load = m.entrainment(0.0), m.load(0.0)
        gap_change = discretise.gap_change(self.case, self.grid, 0.0)
        moment = account.Moment(self.approach, U, m.sliding(0.0), gap_change, load, scale)
        heat = None if self.T is None else self.heat
        stress = None if heat is None else heat.stress.at[0].add(-heat.boundary)  # of the oil
        c, layer = warm_contact(self.case, self.grid, self.factors, stress), discretise.layer_of(self.case, self.grid)
        rate = steady_rate(U, layer)._replace(held=self.kinked)
        fields = self.P_f, self.H, self.P_asperity
        terms, friction, content = _account_program(Plane.of(self.grid), c, *fields, rate, moment)
        around = discretise.outside_of(self.case, self.grid).at(motion_of(self.case, self.approach))
        around = around._replace(load=self.outside)
        terms = account.with_outside(jax.tree.map(float, jax.device_get(terms)), 0.0, around, scale)
        return SteadyAccount(terms, friction, content)

    @cached_property
    def heat(self) -> Heated | None:
        """Its temperatures; None without a section [thermal]."""
        if self.case.thermal is None:
            return None
        return heated(self.case, self.P_f, self.H, self.grid, self.P_asperity, self.factors)

    @property
    def factors(self) -> WarmFactors | None:
        """Those of a film that is solved with its heat."""
        return None if self.T is None else WarmFactors(self.share, self.theta, self.T)

    @property
    def record(self) -> dict[str, float]:
        """Its numbers by name: those of `measure`, of the account, and the work."""
        work = {"newton_iterations": self.newton, "krylov_iterations": self.krylov, "convolutions": self.convolutions}
        return {**self.measure(), **self.account.terms, "residual": self.residual, **work}

    @property
    def maps(self) -> dict[str, Floats]:
        """Its fields on the whole plane by name: those of `account.whole_maps`, and the temperatures."""
        maps = account.whole_maps(self.whole, self.fields, self.account.friction)
        heat = self.heat
        if heat is not None:
            maps |= {name: np.asarray(self.whole(getattr(heat, name))) for name in ("T_1", "T_2", "T_film", "share")}
        if heat is not None and self.T is None:
            warm = dict(zip(("tau_x_warm", "tau_y_warm"), heat.stress, strict=True))
            maps |= {name: np.asarray(self.whole(each, odd=name[4] == "y")) for name, each in warm.items()}
        return maps

    @property
    def across(self) -> tuple[Floats, Floats]:
        """The heights in the film, and the temperatures there over X at Y = 0 (K), shape (heights, nodes)."""
        assert self.heat is not None and self.case.thermal is not None
        T = self.case.thermal.temperature + np.asarray(self.heat.T)
        return np.ravel(Lobatto.of(len(T)).z), T[:, int(np.abs(self.grid.kept_y).argmin())]

    def whole(self, field: Any, odd: bool = False) -> Any:
        """A field on the whole plane, shape (nodes, nodes), or along a line.

        The grid may keep one side of an axis of symmetry only.

        odd: whether it changes its sign at the axis Y = 0.
        """
        return stencils.shown(np.asarray(field), self.grid.even, odd)  # type: ignore[arg-type]


def _account(
    space: Plane, c: Contact, P: Array, H: Array, P_asperity: Array | None, rate: Rate, m: account.Moment
) -> tuple[dict[str, Array], account.Friction, OilContent]:
    content = contact.steady_oil(c, P, H, rate)
    through = through_faces(content, m.U)
    change = jnp.diff(through, axis=1) / c.spacing
    if isinstance(c.flow, WarmFlow):  # so far it was what moves with the surfaces
        content = content._replace(oil=content.oil / c.flow.share)
    return *account.account(space, c, P, H, m, content.oil, change, through, P_asperity), content


_account_program = Program(jax.jit(_account), ANY_SIZE)
