"""The temperatures of a sheared film and its two surfaces, where the heat itself depends on the temperature.

The film releases the heat q(T_f) per area, tau_m.(u1 - u2), which falls as the film gets warmer.  It conducts the heat
to both surfaces, and they warm up as the heat flows into them.  With the resistance r = h/k of the film

    q_1 = q/2 + c,   q_2 = q/2 - c,   r c = T_2 - T_1                      (conduction across the film, `thermal`)
    T_i = T_b,i + K_i q_i                                                  (flash temperature of each surface, `flash`)
    T_f = (T_1 + T_2)/2 + r q/12                                           (mean over the film)
    q = q(T_f)

K_i is linear, of any kind: a moving surface, one at rest, or none at all (walls that stay cold).  Newton's iteration
solves for q and c at all nodes together, with GMRES for its linear equations, which need nothing but K_1 and K_2.

There is exactly one solution.  Take the difference d of two, and sums over all nodes.  The released heat falls with
the temperature, so the sum of dq dT_f is not above zero.  The surfaces store heat and never give back more than they
took, so that the sums of dq_i K_i dq_i are not below zero.  By the equations, dq dT_f is the sum of dq_1 K_1 dq_1,
dq_2 K_2 dq_2, r dc^2 and r dq^2/12.  Therefore dq = 0.  What is known as two branches near the traction's maximum is
one of two things: an iteration T <- T(q(T)) that jumps to and fro, or two speeds of sliding with the same traction.
"""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

Real = NDArray[np.float64]
Rise = Callable[[Real], Real]  # K_i: temperature rise (K) of a surface from the heat flux into it (W/m^2), linear
Release = Callable[[Real], tuple[Real, Real]]  # q (W/m^2) and dq/dT_f <= 0 from the mean temperature of the film

TOLERANCE = 1e-6  # of the last change of T_f over its largest rise; the error is about its square
LIMIT = 100  # of Newton iterations; each makes a film that is far too stiff e times less so
REDUCTION = 1e-2  # of the residual of the linear equations
KRYLOV_LIMIT = 60


class Warmed(NamedTuple):
    """Temperatures and what it took to find them.

    heat: q in W/m^2.  surface_1, surface_2, film: T_1, T_2, T_f in K.  iterations: of Newton's method.
    applications: how often K_1 and K_2 were applied.
    """

    heat: Real
    surface_1: Real
    surface_2: Real
    film: Real
    iterations: int
    applications: int
    converged: bool


def cold(heat: Real) -> Real:
    """K_i = 0: a wall that keeps its temperature."""
    return np.zeros_like(heat)


def warmed(
    release: Release,
    rises: Sequence[Rise],
    resistance: Real,
    bodies: Sequence[float] = (0.0, 0.0),
    heat: Real | None = None,
) -> Warmed:
    """The temperatures of the film and of both surfaces.

    Parameters
    ----------
    release : callable
        q and dq/dT_f at T_f, of the shape of the film.
    rises : two callables
        K_1 and K_2.
    resistance : array
        r = h/k of the film, m^2 K/W, above zero, of any shape.
    bodies : two floats
        T_b,1 and T_b,2, the temperatures of the bodies, in the scale in which `release` takes T_f.
    heat : array, optional
        q from which the iteration starts; a film that releases none if it is left out.
    """
    problem = _Problem(release, rises, resistance, bodies)
    q = np.zeros_like(resistance) if heat is None else heat
    x, applications = np.stack([q, np.zeros_like(q)]), 2
    state = problem.at(x)
    for iteration in range(1, LIMIT + 1):
        if not np.all(np.isfinite(state.film + state.slope)):
            break
        change, needed = problem.newton_change(state)
        x = x + change
        before, state = state.film, problem.at(x)
        applications += needed + 1
        if np.max(np.abs(state.film - before)) <= TOLERANCE * np.max(np.abs(state.film - min(bodies)), initial=1e-300):
            return Warmed(x[0], state.surface_1, state.surface_2, state.film, iteration, applications, True)
    return Warmed(x[0], state.surface_1, state.surface_2, state.film, iteration, applications, False)


class _State(NamedTuple):
    x: Real
    surface_1: Real
    surface_2: Real
    film: Real
    release: Real
    slope: Real


class _Problem:
    """The equations for x = (q, c), each divided by about the diagonal of its own derivative."""

    def __init__(self, release: Release, rises: Sequence[Rise], resistance: Real, bodies: Sequence[float]):
        self.release, self.rises, self.r, self.bodies = release, rises, resistance, bodies
        ones = np.ones_like(resistance)
        self.surfaces = rises[0](ones) + rises[1](ones)  # the most that they resist, under heat everywhere upstream

    def at(self, x: Real) -> _State:
        T_1, T_2 = (body + rise for body, rise in zip(self.bodies, self._rises(x), strict=True))
        film = 0.5 * (T_1 + T_2) + self.r * x[0] / 12.0
        # no film gets colder than both bodies, but an iterate may, and the viscosity of very cold oil is no number
        return _State(x, T_1, T_2, film, *self.release(np.maximum(film, min(self.bodies))))

    def newton_change(self, s: _State) -> tuple[Real, int]:
        """The change of x, and how often K_1 and K_2 were applied for it."""
        from scipy.sparse.linalg import LinearOperator, gmres

        along, across = 1.0 - s.slope * (0.25 * self.surfaces + self.r / 12.0), self.r + self.surfaces
        wrong = np.stack([(s.x[0] - s.release) / along, (self.r * s.x[1] + s.surface_1 - s.surface_2) / across])
        shape, count = s.x.shape, [0]

        def derivative(flat: Any) -> Any:
            count[0] += 1
            d = flat.reshape(shape)
            rise_1, rise_2 = self._rises(d)
            film = 0.5 * (rise_1 + rise_2) + self.r * d[0] / 12.0
            return np.stack([(d[0] - s.slope * film) / along, (self.r * d[1] + rise_1 - rise_2) / across]).ravel()

        operator = LinearOperator((s.x.size, s.x.size), matvec=derivative, dtype=float)
        found, _ = gmres(operator, -wrong.ravel(), rtol=REDUCTION, restart=KRYLOV_LIMIT, maxiter=1)
        return found.reshape(shape), count[0]

    def _rises(self, x: Real) -> tuple[Real, Real]:
        return self.rises[0](0.5 * x[0] + x[1]), self.rises[1](0.5 * x[0] - x[1])
