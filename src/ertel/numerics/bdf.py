"""Second-order backward differences with variable steps: weights, prediction, error estimate, step control.

Everything follows from a polynomial through the last time levels.  Times are given newest first.
"""

from collections.abc import Sequence
from math import prod
from typing import Any

import numpy as np
from numpy.typing import NDArray

Weights = NDArray[np.float64]
SAFETY, LARGEST_GROWTH, LARGEST_CUT = 0.8, 1.5, 0.25  # of a step
REJECTED = 2.0  # a step is repeated only if its error is above this, in units of the tolerance


def lagrange(t: Any, nodes: Sequence[float]) -> list[Any]:
    """Lagrange's weights of the nodes for the value at t (extrapolated outside them); exactly 1 and 0 at a node."""
    return [prod((t - m) / (node - m) for m in nodes if m != node) for node in nodes]


def interpolation_weights(t: float, times: Sequence[float]) -> Weights:
    """Weights w with y(t) = sum_k w[k] y(times[k])."""
    return np.array(lagrange(t, times), dtype=float)


def derivative_weights(times: Sequence[float]) -> Weights:
    """Weights w with y'(times[0]) = sum_k w[k] y(times[k]): two times give BDF1 (Euler), three BDF2."""
    t0, *earlier = times
    w = [sum(1.0 / (t0 - t) for t in earlier)]
    for tk in earlier:
        others = [t for t in earlier if t != tk]
        w.append(prod(t0 - t for t in others) / prod(tk - t for t in [t0, *others]))
    return np.array(w)


def backward_integral(times: NDArray[np.float64], rates: NDArray[np.float64]) -> float:
    """The integral from times[1] to the last time, whose backward differences are the rates at times[1:].

    So it obeys the equations of a run that starts from one level at times[0].
    """
    before, now = (times[0] - times[1]) * rates[0], 0.0
    for k, rate in enumerate(rates[1:], 2):
        of_new, of_now, of_before = derivative_weights(times[[k, k - 1, k - 2]].tolist())
        before, now = now, (rate - of_now * now - of_before * before) / of_new
    return float(now)


def three(weights: Weights) -> Weights:
    """At most three weights as three, the missing ones zero: one shape, whatever the history."""
    return np.array([*weights, 0.0, 0.0][:3])


def error_factor(times: Sequence[float]) -> float:
    """Local error of BDF2 as a fraction of (solution - prediction).

    times are the new time and the three before it; the prediction is the parabola through those three.  Let h1, h0, hm
    be the last three steps.  The prediction's error is (y'''/6) h1 (h1+h0)(h1+h0+hm).  The error of BDF2 is
    (y'''/6) h1^2 (h1+h0)^2/(2 h1+h0), with the opposite sign.
    """
    t, t0, t1, t2 = times
    bdf2 = (t - t0) ** 2 * (t - t1) ** 2 / ((t - t0) + (t - t1))
    return bdf2 / (bdf2 + (t - t0) * (t - t1) * (t - t2))


def adapted(step: float, error: float) -> float:
    """Step at which a third-order local error meets the tolerance; its growth is limited so that BDF2 is stable.

    error: of the last step, in units of the tolerance; after nan the step is as short as it may be.
    """
    factor: float = SAFETY * max(error, 1e-12) ** (-1.0 / 3.0)
    return step * min(max(LARGEST_CUT, factor), LARGEST_GROWTH)  # in this order: max keeps its first value beside nan
