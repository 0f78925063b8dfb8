"""The likeliest of the films that an intensity allows along a profile: passed fringes, turns and orders.

The phase of a smooth film is a random walk whose third derivative is white noise, by a share of a fringe over the
distance to the next fringe; how large a share, the profile says.  Films that differ by the fringes they passed are
followed side by side by Kalman filters (near a fringe by quadrature of the likelihood of the intensity itself, because
there the phase is not linear in it); of films that come to the same branch the likelier goes on, as Viterbi does.  The
noise is what cubics through eight points leave, after averaging to about 30 points a fringe.

Sources: Reid DB. An algorithm for tracking multiple targets. IEEE Trans Autom Control 1979;24:843-854; Hagenauer J,
Hoeher P. A Viterbi algorithm with soft-decision outputs. Proc GLOBECOM 1989:1680-1686, for the odds.

The branch j of phases reaches from j pi, a bright fringe where j is even, to (j + 1) pi.
"""

from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Self

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Integers = NDArray[np.int64]
Flags = NDArray[np.bool_]
HALF_FRINGE = 15  # points that are kept of it
SHARES = (1.0, 3.0, 10.0)  # of the random walk, of which the likeliest is taken
LONGEST = 1.0 / 8.0  # of the profile: the longest distance over which a film is held to be smooth
LEAST_NOISE = 3e-3  # of the cosine: round-off, and what no random walk follows
NEAR, NEAREST, FURTHEST = 8.0, 0.3, 1.2  # rad: phases are near a fringe where an error of NEAR/2 sigma can hide it
WELL_OFF = 1.0  # rad from a fringe from which on films on the same branch are the same
PATHS, HOPELESS = 32, 40.0  # the most films that are followed, and the log of the odds to which they are
STANDARD = np.linspace(-4.0, 4.0, 65)  # standard deviations of the quadrature


def phase_on(branch: Integers, spread: Array) -> Array:
    """The phase on a branch.  spread: of the bright fringe, 0 to pi."""
    return np.where(branch % 2 == 0, branch * np.pi + spread, (branch + 1) * np.pi - spread)


def likeliest(nodes: "Nodes", cosine: Array, first: int) -> tuple[Integers, Array]:
    """The branch of every point, and the log of how much likelier it is there than any other film.

    cosine: that of the nodes, at all points.  first: branch of the first point.
    """
    candidates = sorted((_followed(nodes, first, share) for share in SHARES), key=lambda path: path.cost[0])
    best = candidates[0]
    for other in candidates[1:]:
        _limit_odds(best.odds[0], best.branch[0] != other.branch[0], other.cost[0] - best.cost[0], nodes.clear)
    repeats = np.diff(np.append(nodes.begin, len(cosine)))
    return _at_all_points(best.branch[0], nodes, cosine), np.repeat(best.odds[0], repeats)


# -- the profile, averaged --------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Nodes:
    """Means over so many points that about 30 are left of a fringe.

    begin: the first point of each.  length: points from a fringe to the next.  noise: of the cosine.  distance: from
    the nearest fringe (rad).  clear: which are not near one.
    """

    begin: Integers
    place: Array
    length: Array
    cosine: Array
    noise: Array
    spread: Array
    distance: Array
    clear: Flags

    @classmethod
    def of(cls, cosine: Array, weight: Array) -> Self:
        """The means of a profile.  cosine: of the phase, with noise.  weight: with it all errors have the same size."""
        points = len(cosine)
        half, ends = _half_fringes(cosine)
        begin = _begins(np.maximum(half // HALF_FRINGE, 1).astype(int))
        count = np.diff(np.append(begin, points))
        mean = np.add.reduceat(cosine, begin) / count
        noise = _noise(cosine * weight, ends) * np.sqrt(count) / np.add.reduceat(weight, begin)
        spread = np.arccos(np.clip(mean, -1.0, 1.0))
        distance = np.minimum(spread, np.pi - spread)
        return cls(
            begin=begin,
            place=begin + 0.5 * (count - 1.0),
            length=np.minimum(half[begin], LONGEST * points),
            cosine=mean,
            noise=noise,
            spread=spread,
            distance=distance,
            clear=distance >= np.clip(np.sqrt(NEAR * noise), NEAREST, FURTHEST),
        )


def _half_fringes(cosine: Array) -> tuple[Array, Integers]:
    """Points from a bright to a dark fringe or back, around every point; and where the next such stretch begins.

    They grow by one a point at most, so that a film slows down before it is flat.
    """
    certain = np.flatnonzero(np.abs(cosine) > 0.5)
    turns = certain[1:][np.diff(np.sign(cosine[certain])) != 0]
    ends = np.concatenate([[0], turns, [len(cosine)]])
    half = np.repeat(np.diff(ends), np.diff(ends)).astype(float)
    place = np.arange(len(half), dtype=float)
    half = np.minimum.accumulate(half - place) + place
    return (np.minimum.accumulate(half[::-1] - place) + place)[::-1], ends


def _begins(size: Integers) -> Integers:
    begins = [0]
    while begins[-1] + size[begins[-1]] < len(size):
        begins.append(begins[-1] + int(size[begins[-1]]))
    return np.array(begins)


def _noise(values: Array, ends: Integers) -> float:
    """The standard deviation of the noise: the median of what cubics through about eight points leave."""
    parts = [
        part
        for begin, end in pairwise(ends)
        for part in np.array_split(values[begin:end], max(1, (end - begin) // 8))
        if len(part) >= 6
    ]
    if not parts and len(values) < 4:
        return LEAST_NOISE
    if not parts:  # fringes of few points
        return max(float(np.median(np.abs(np.diff(values, 3))) / 3.016), LEAST_NOISE)  # 0.6745 sqrt(20)
    left = [np.polynomial.Polynomial.fit(np.arange(len(p)), p, 3, full=True)[1][0].item() / (len(p) - 4) for p in parts]
    return max(float(np.sqrt(np.median(left))), LEAST_NOISE)


# -- films side by side -----------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Paths:
    """Films, the first axis of all arrays.

    state, covariance: phase and its first two derivatives.  cost: minus the log of the likelihood.  branch, odds: of
    each node; the log of how much likelier than those were that lost against it.
    """

    state: Array
    covariance: Array
    cost: Array
    branch: Integers
    odds: Array

    def __getitem__(self, which: Integers | Flags) -> Self:
        return type(self)(*(part[which] for part in vars(self).values()))

    def likely(self) -> Self:
        """The likeliest, best first."""
        order = np.argsort(self.cost)[:PATHS]
        return self[order[self.cost[order] < self.cost[order[0]] + HOPELESS]]

    def predicted(self, step: float, noise: float) -> Self:
        """The prediction a number of points further on."""
        t = step
        move = np.array([[1.0, t, t * t / 2.0], [0.0, 1.0, t], [0.0, 0.0, 1.0]])
        spread = [
            [t**5 / 20.0, t**4 / 8.0, t**3 / 6.0],
            [t**4 / 8.0, t**3 / 3.0, t**2 / 2.0],
            [t**3 / 6.0, t**2 / 2.0, t],
        ]
        covariance = move @ self.covariance @ move.T + noise * np.array(spread)
        return replace(self, state=self.state @ move.T, covariance=covariance)

    def updated(self, node: int, branch: Integers, mean: Array, variance: Array, cost: Array) -> Self:
        """The films with the phase at a node measured, by mean and variance."""
        before = self.covariance[:, 0, 0]
        gain = self.covariance[:, :, 0] / before[:, None]
        state = self.state + gain * (mean - self.state[:, 0])[:, None]
        outer = gain[:, :, None] * gain[:, None, :]
        branches = self.branch.copy()
        branches[:, node] = branch
        covariance = self.covariance - outer * (before - variance)[:, None, None]
        return replace(self, state=state, covariance=covariance, cost=self.cost + cost, branch=branches)


def _followed(nodes: Nodes, first: int, share: float) -> Paths:
    """The likeliest film of a random walk."""
    paths = _begun(nodes, first)
    for node in range(1, len(nodes.begin)):
        length = min(nodes.length[node - 1 : node + 1])
        paths = paths.predicted(nodes.place[node] - nodes.place[node - 1], share**2 / length**5)
        paths = (_beside if nodes.clear[node] else _on_fringe)(paths, nodes, node).likely()
        if nodes.distance[node] > WELL_OFF:
            paths = _merged(paths, nodes, node)
    best = paths[np.array([0])]
    for other in range(1, len(paths.cost)):
        differing = paths.branch[other] != best.branch[0]
        _limit_odds(best.odds[0], differing, paths.cost[other] - best.cost[0], nodes.clear)
    return best


def _begun(nodes: Nodes, first: int) -> Paths:
    """The film at the first node, of any slope and curvature."""
    phase = float(phase_on(np.array(first), nodes.spread[0]))
    length = nodes.length[0]
    error = nodes.noise[0] / max(np.sin(nodes.spread[0]), NEAREST)
    covariance = np.diag([error**2, (6.0 / length) ** 2, (10.0 / length**2) ** 2])
    number = len(nodes.begin)
    branch, odds = np.full((1, number), first, dtype=np.int64), np.full((1, number), np.inf)
    return Paths(np.array([[phase, 0.0, 0.0]]), covariance[None], np.zeros(1), branch, odds)


def _beside(paths: Paths, nodes: Nodes, node: int) -> Paths:
    """Away from fringes every film goes on with the two next phases that the intensity allows."""
    periods = paths.state[:, 0] / np.pi
    below = np.floor(periods).astype(np.int64)
    branch = np.concatenate([below, np.where(periods - below > 0.5, below + 1, below - 1)])
    paths = paths[np.tile(np.arange(len(below)), 2)]
    before, error = paths.covariance[:, 0, 0], (nodes.noise[node] / np.sin(nodes.spread[node])) ** 2
    total = before + error
    off = phase_on(branch, nodes.spread[node]) - paths.state[:, 0]
    mean = paths.state[:, 0] + before / total * off
    return paths.updated(node, branch, mean, before * error / total, 0.5 * (off**2 / total + np.log(total)))


def _on_fringe(paths: Paths, nodes: Nodes, node: int) -> Paths:
    """Near a fringe every film goes on on either side of it, with the phases that agree with the intensity."""
    before = paths.state[:, 0] / np.pi
    dark = int(nodes.cosine[node] < 0.0)
    fringe = (2 * np.round(0.5 * (before - dark)) + dark).astype(np.int64)
    below = np.repeat([True, False], len(before))
    paths, fringe = paths[np.tile(np.arange(len(before)), 2)], np.tile(fringe, 2)
    variance = paths.covariance[:, 0, 0]
    phase = paths.state[:, :1] + np.sqrt(variance)[:, None] * STANDARD
    rest = (nodes.cosine[node] - np.cos(phase)) / nodes.noise[node]
    inside = (phase < np.pi * fringe[:, None]) == below[:, None]
    log = np.where(inside, -0.5 * (STANDARD**2 + rest**2), -np.inf)
    any_inside = inside.any(axis=1)
    paths, log, phase, branch = paths[any_inside], log[any_inside], phase[any_inside], (fringe - below)[any_inside]
    most = log.max(axis=1)
    likelihood = np.exp(log - most[:, None])
    total = likelihood.sum(axis=1)
    mean = (likelihood * phase).sum(axis=1) / total
    spread = (likelihood * (phase - mean[:, None]) ** 2).sum(axis=1) / total
    least = 1e-3 * paths.covariance[:, 0, 0]  # that of phases between two of the quadrature
    return paths.updated(node, branch, mean, spread + least, -most - np.log(total))


def _merged(paths: Paths, nodes: Nodes, node: int) -> Paths:
    """Keep the likeliest of the films that rise, or fall, on the same branch, with the odds against the others."""
    kept: dict[tuple[int, bool], int] = {}
    for path, (branch, slope) in enumerate(zip(paths.branch[:, node], paths.state[:, 1], strict=True)):
        better = kept.setdefault((int(branch), bool(slope > 0.0)), path)
        differing = paths.branch[path, :node] != paths.branch[better, :node]
        _limit_odds(paths.odds[better, :node], differing, paths.cost[path] - paths.cost[better], nodes.clear[:node])
    return paths[np.array(list(kept.values()))]


def _limit_odds(odds: Array, differing: Flags, cost: float, clear: Flags) -> None:
    """Note the odds against another film where it differs; beside fringes, as on them it hardly does."""
    where = differing & clear
    odds[where] = np.minimum(odds[where], cost)


# -- back to all points -----------------------------------------------------------------------------------------------


def _at_all_points(branch: Integers, nodes: Nodes, cosine: Array) -> Integers:
    """The branches of all points: where the film passes a fringe, it does so at the point that agrees best."""
    spread = np.arccos(np.clip(cosine, -1.0, 1.0))
    passed = np.flatnonzero(np.diff(branch)) + 1
    at_points = np.repeat(branch, np.diff(np.append(nodes.begin, len(cosine))))
    limits = np.append(nodes.begin, len(cosine))
    for number, node in enumerate(passed):
        low = max(node - 2, (passed[number - 1] + node) // 2 if number else 0)
        high = min(node + 2, (passed[number + 1] + node + 1) // 2 if number + 1 < len(passed) else len(branch))
        fringe = max(branch[node - 1], branch[node])
        distance = spread if fringe % 2 == 0 else np.pi - spread
        begin, end = int(limits[low]), int(limits[high])
        point = _behind(distance, begin, end)
        at_points[begin:point], at_points[point:end] = branch[node - 1], branch[node]
    return at_points


def _behind(distance: Array, begin: int, end: int) -> int:
    """The first point behind the fringe: the nearest to it, or the next, so that the steps are more even."""
    nearest = begin + int(distance[begin:end].argmin())
    if not 0 < nearest < len(distance) - 1:
        return nearest
    uneven = distance[nearest - 1] - distance[nearest + 1]
    return nearest if abs(uneven + 2.0 * distance[nearest]) < abs(uneven - 2.0 * distance[nearest]) else nearest + 1
