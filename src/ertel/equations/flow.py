"""The rate of change of the oil following the mean flow: squeeze and wedge as one term.

    Dm/DT = dm/dT + U dm/dX,    m = rho H where the gap is full,  m = rho H - void in a cavity

The past of the film is the oil that was there, `State.fields["mass"]`.  A cavity keeps its void: it fills when the gap
closes or when oil flows in.  Source: Elrod HG, Adams ML. Leeds-Lyon Symp 1974:37; P and the void as a complementary
pair: Almqvist A, Wall P. 2016, doi 10.5772/63533.

U is the same everywhere, so all oil moves by the same distance s = integral of U dT.  The oil that is at X now was at
X - s before, and backward differences along its way need nothing but the earlier masses, moved downstream:

    Dm/DT = w0 m(X, T) + w1 m(X - s1, T1) + w2 m(X - s2, T2)

* impact: the oil stays, s = 0.  This is the squeeze term.
* rolling in time: the oil comes from upstream.  Waves that ride with it are carried without loss.
* steady rolling: the oil's past is the same film upstream, s1 = h, s2 = 2 h on a grid of spacing h.  This is the wedge,
  by the second-order upstream difference U (3 m(X) - 4 m(X - h) + m(X - 2 h))/(2 h).

A run in time starts from a film that is steady (rolling) or without pressure (impact).  The rate of that film is its
steady rate, and only what has changed since follows the oil.  So a steady film stays as it is whatever the step.

In a steady film the void of a cavity is a sum along the flow, `void_downstream`.
All quantities are dimensionless; U in a/t0.
"""

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
from jax import Array

from ertel.numerics.bdf import Weights
from ertel.numerics.programs import exportable
from ertel.numerics.stencils import FloatLike, carried_along_x, upstream_slope


class Rate(NamedTuple):
    """The rate of change of the mass m following the flow: new * m + past + wedge * (slope of m from upstream).

    new: weight of the mass at the node now.  past: the known part, from the earlier masses, shape (n, n) or a number.
    wedge: the entrainment speed U >= 0 where the film is steady, so that its past is the film upstream; else None.
    through: what the flow takes through the faces across X, shape (n, n + 1), None where the oil stays.
    layer: the oil per area that enters a steady contact, a number or of shape (n, 1); None where the inlet is full.
    held: where a steady starved film is kinked, whatever P is (see `kinked_at`); None where P tells it.
    """

    new: FloatLike
    past: FloatLike
    wedge: FloatLike | None = None
    layer: FloatLike | None = None
    held: Array | None = None
    through: Array | None = None

    def of(self, mass: Array, spacing: FloatLike, kinked: Array | None = None) -> Array:
        """The rate of a mass, shape (n, n); kinked: as from `kinked_at`, for a starved film."""
        in_time = self.new * mass + self.past
        return in_time if self.wedge is None else in_time + self.wedge * slope_of_full(mass, spacing, kinked)

    def kinked(self, P: Array) -> Array | None:
        """The nodes at which a steady starved film is kinked, None for any other film."""
        if self.layer is None or self.wedge is None:
            return None
        return kinked_at(P) if self.held is None else self.held


def steady_rate(entrainment: FloatLike, layer: FloatLike | None = None) -> Rate:
    """The rate in a steady film; X points downstream (entrainment >= 0)."""
    return Rate(0.0, 0.0, entrainment, layer)


@exportable
class OilContent(NamedTuple):
    """The oil in a steady film, as mass; fields of shape (n, n).

    oil: what is there at the nodes.  full: what would fill the gap.  void: from `void_downstream`.  entrainment: of the
    film.  kinked: as from `kinked_at`, None where the inlet is full.
    """

    oil: Array
    full: Array
    void: Array
    entrainment: FloatLike
    kinked: Array | None = None

    @classmethod
    def without_void(cls, mass: Array, kinked: Array | None = None) -> "OilContent":
        """A gap that is full, or a layer that does not change along X, which is nowhere kinked."""
        return cls(mass, mass, jnp.zeros_like(mass), 1.0, kinked)


class Flow(NamedTuple):
    """The movement of the oil in one time step.

    entrainment: U at the new time.  distances: by which the oil has moved in this step and in the one before, newest
    first, in nodes.  start: the film from which the run started.  settles: whether load, speeds and gap do not change.
    """

    entrainment: FloatLike
    distances: Sequence[FloatLike]
    start: OilContent
    settles: bool | Array = False

    def beside(self, P: Array, mass: Array) -> "Flow":
        """This movement, with a start film that has the menisci of a later one in the inlet, and its height there.

        P, mass: of the later film, shape (n, n).  The two then differ little where transport is of first order, so that
        a film which has settled is that of the steady scheme, whatever the start and the step.  In each row the oil
        that enters is upstream of the meniscus, with what flows back to the last node that is not full; downstream is
        the gap of the start, shifted.  A film that does not settle, or runs back, keeps its start film: a node that
        fills would change the flow.
        """
        if self.start.kinked is None:
            return self
        turned = partial(flow_aligned, steady_rate(self.start.entrainment))
        oil, full, void = map(turned, self.start[:3])
        P, mass, was_wet = turned(P), turned(mass), oil >= full
        wet = (P > 0.0).at[:, 0].set(was_wet[:, 0])
        was_dry, dry, behind = (jnp.cumsum(each, axis=1) == 0 for each in (was_wet, wet, wet[:, ::-1]))
        last, filled = dry & jnp.pad(~dry[:, 1:], ((0, 0), (0, 1))), was_dry & ~dry & ~behind[:, ::-1]
        inlet = upstream_of(dry | was_dry).at[:, 0].set(True)
        kinked = jnp.where(inlet, kinked_at(P), turned(self.start.kinked))
        back = HELD / jnp.maximum(jnp.abs(self.distances[0]), HELD) * (mass - oil[:, :1])
        shift = jnp.sum(jnp.where(upstream_of(last), mass - full, 0.0), axis=1, keepdims=True)
        moved = (dry != was_dry).any(axis=1, keepdims=True)
        before = jnp.where(last, oil[:, :1] + back, jnp.where(moved, oil[:, :1], oil))
        oil, full = jnp.where(dry, before, jnp.where(filled, full, oil) + shift), full + shift
        void = jnp.where(dry, downstream(full, kinked) - oil, jnp.where(filled, 0.0, void))
        oil, full, void, kinked = map(turned, (oil, full, void, kinked))
        there = OilContent(oil, full, void, self.start.entrainment, kinked)
        onwards = (jnp.asarray(self.entrainment) >= 0) == (jnp.asarray(self.start.entrainment) >= 0)
        return self._replace(start=jax.tree.map(partial(jnp.where, onwards & self.settles), there, self.start))


def rate_in_time(
    weights: Weights | Array,
    masses: Sequence[Array] | Array,
    flow: Flow | None,
    spacing: FloatLike,
    pressures: Sequence[Array] = (),
    bent: tuple[Array | None, Array] | None = None,
) -> Rate:
    """The rate at the new time by backward differences along the flow.

    weights: for the new and the earlier times, newest first.  masses: at the earlier times, each of shape (n, n).
    flow: None where the oil stays.  pressures: at the earlier times, for a run that starts from a starved film.  bent:
    the parabola of the gap, None where it stays, and by how much of it the gap was another one than at the start.
    """
    if flow is None:
        return Rate(weights[0], sum(w * m for w, m in zip(weights[1:], masses, strict=True)))
    changes = [mass - flow.start.oil for mass in masses]
    starved, was_full = flow.start.kinked is not None, flow.start.oil >= flow.start.full
    full = [was_full & (P > 0.0) for P in pressures] if starved else None
    past, passed = -weights[0] * flow.start.oil, 0.0
    if bent is not None and bent[0] is not None and not starved:
        changes = [change - more * bent[0] for change, more in zip(changes, bent[1], strict=True)]
        ways = flow.distances[0], flow.distances[0] + flow.distances[1]
        for weight, more, way in zip(weights[1:], bent[1], ways, strict=False):
            gap, through = parabola_moved(bent[0], way)
            past, passed = past + weight * more * gap, passed + weight * more * through
    moved, through = followed(weights[1:], changes, flow.distances, full)
    start = through_faces(flow.start, flow.entrainment)
    past += moved + jnp.diff(start, axis=1) / spacing
    return Rate(weights[0], past, through=start - spacing * (passed + through))


def parabola_moved(gap: Array, nodes: FloatLike) -> tuple[Array, Array]:
    """A parabola after it has moved by a number of nodes along X, exactly, and what has passed the faces.

    Upstream of the grid it goes on, where `stencils.carried_along_x` has nothing but the value of the edge.
    """
    first, second, third = (gap[:, i : i + 1] for i in range(3))
    bend, i = third - 2.0 * second + first, jnp.arange(gap.shape[1])
    slope = second - first + (i - 0.5) * bend

    def before(nodes: FloatLike) -> Array:
        return gap - nodes * slope + 0.5 * nodes**2 * bend

    # the mean over a cell is the value at its node if the parabola lies lower by bend/24
    passed = nodes * (before(0.5 * (nodes + 1.0)) + bend * (nodes**2 - 1.0) / 24.0)
    return before(nodes), jnp.pad(passed, ((0, 0), (0, 1)))


def followed(
    weights: Weights | Array,
    masses: Sequence[Array],
    distances: Sequence[FloatLike],
    full: Sequence[Array] | None = None,
) -> tuple[Array, Array]:
    """The weighted sum of earlier masses, each moved to where its oil is now, and what has passed the faces in all.

    The oldest is moved step by step, as the newer ones were: what the interpolation takes from a wave is then the same
    in all of them, and the differences in time are not disturbed by it.  full: where the gap was full, in a starved
    film: there alone the interpolation is of high order.
    """
    moved, passed = jnp.zeros_like(masses[-1]), jnp.zeros(())
    for k in reversed(range(len(masses))):
        smooth = None if full is None else full[k]
        moved, through = carried_along_x(weights[k] * masses[k] + moved, distances[k], smooth)
        passed += through
    return moved, passed


def through_faces(content: OilContent, entrainment: FloatLike) -> Array:
    """Flow of oil through the faces across X of a steady film that moves with the speed U, shape (n, n + 1).

    The flux of a full gap is of second order, that of a void of first, because it ends at a meniscus.  Against the way
    of the steady film the void is not a sum along the flow: nodes that are not full pass on the oil that they have.
    Nothing changes in the half cells at the inlet.
    """
    turned = partial(flow_aligned, steady_rate(content.entrainment))
    oil, full, void = map(turned, content[:3])
    kinked = None if content.kinked is None else turned(content.kinked)

    def with_inlet(passing: Array) -> Array:
        return jnp.concatenate([passing[:, :1], passing], axis=1)

    onwards = with_inlet(downstream(full, kinked) - void)
    oil, full = oil[:, ::-1], full[:, ::-1]
    back = with_inlet(jnp.where(oil < full, oil, downstream(full)))[:, ::-1]
    same_way = (jnp.asarray(content.entrainment) >= 0) == (jnp.asarray(entrainment) >= 0)
    return entrainment * turned(jnp.where(same_way, onwards, back))


def flow_aligned(rate: Rate, field: Any) -> Any:
    """A field with X in the direction of entrainment; the same reversal undoes it.  None or a number is not changed."""
    if rate.wedge is None or field is None or jnp.ndim(field) < 2:
        return field
    return jnp.where(rate.wedge >= 0, field, field[..., ::-1])


def downstream(full: Array, kinked: Array | None = None) -> Array:
    """The mass that passes the faces downstream of the nodes in unit flow, whose differences are `upstream_slope`.

    It is that of the node itself where the film is kinked.
    """
    passing = 1.5 * full[:, 1:] - 0.5 * full[:, :-1]
    passing = jnp.concatenate([0.5 * (full[:, :1] + full[:, 1:2]), passing], axis=1)
    return passing if kinked is None else jnp.where(kinked, full, passing)


def kinked_at(P: Array) -> Array:
    """Whether a node lies beside a meniscus in the inlet: the last that is not full, and the first full one.

    X points downstream.  A line through two nodes upstream would there cross the kink in the film.  Without it the oil
    that passes jumps less when a node fills.
    """
    meniscus = (P[:, :-1] <= 0.0) & (P[:, 1:] > 0.0)
    return jnp.pad(meniscus, ((0, 0), (0, 1))) | jnp.pad(meniscus, ((0, 0), (1, 0)))


def slope_of_full(full: Array, spacing: FloatLike, kinked: Array | None = None) -> Array:
    """The slope of a full gap from upstream: of second order, but for the nodes at a kink."""
    if kinked is None:
        return upstream_slope(full, spacing)
    return jnp.pad(jnp.diff(downstream(full, kinked), axis=1), ((0, 0), (1, 0))) / spacing


HELD = 2.5  # nodes that oil moves in a step; in longer ones less of what flowed back is held
FULL = -1e30  # a change of the void that leaves none
_Map = tuple[Array, Array]  # of the void upstream of each node to that downstream of it


def void_downstream(P: Array, r: Array, first: FloatLike, entrainment: FloatLike, spacing: FloatLike) -> Array:
    """The void w of a steady film, shape (n, n), X pointing downstream, on the faces downstream of the nodes.

    There U dw/dX = r, w >= 0, and w = 0 where P > 0; by upstream differences of first order

        w_i = max(0, w_(i-1) + h r_i/U)  where P = 0,     w_0 = max(0, first)

    The oil that passes a face is `downstream` of the full gap, less w.

    r: the rate at which the gap grows beyond what flows in.  first: at the inlet, shape (n,) or a number.
    """
    return _void(P > 0.0, r * spacing / entrainment, jnp.asarray(first))


@jax.custom_jvp
def _void(full: Array, more: Array, first: Array) -> Array:
    """The void w; full: where P > 0; more: h r/U.

    Each node maps the void upstream of it to max(least, w + more).  Such maps compose to maps of the same kind.
    """
    more = jnp.where(full, FULL, more).at[:, 0].set(FULL)
    least = jnp.zeros_like(more).at[:, 0].set(jnp.maximum(first, 0.0))

    def then(one: _Map, other: _Map) -> _Map:
        return jnp.maximum(other[0], other[1] + one[0]), jnp.maximum(one[1] + other[1], FULL)

    return _composed(then, (least, more), (FULL, 0.0))[0]


@_void.defjvp
def _(primals: Any, tangents: Any) -> tuple[Array, Array]:
    void: Array = _void(*primals)
    return void, void_change(jnp.asarray(void > 0.0, void.dtype), *tangents[1:])


def void_change(held: Array, more: Array, first: Array) -> Array:
    """The change of `void_downstream` by changes of more = h r/U and of the void at the inlet.

    held: 1 where P = 0; 0 where there is no void that changes.
    """
    change = (held * more).at[:, 0].set(held[:, 0] * first)

    def then(one: _Map, other: _Map) -> _Map:
        return one[0] * other[0], other[0] * one[1] + other[1]

    return _composed(then, (held.at[:, 0].set(0.0), change), (1.0, 0.0))[1]


def _composed(then: Callable[[_Map, _Map], _Map], maps: _Map, nothing: tuple[float, float]) -> _Map:
    """The maps of all nodes up to each, one after the other.  nothing: the map that changes nothing.

    The maps of 1, 2, 4, ... nodes are composed.  `lax.associative_scan` does less work, but a starved program then has
    a quarter more operations, and takes as much longer to compile.
    """
    step = 1
    while step < maps[0].shape[1]:
        earlier = (
            jnp.pad(part[:, :-step], ((0, 0), (step, 0)), constant_values=neutral)
            for part, neutral in zip(maps, nothing, strict=True)
        )
        maps, step = then((next(earlier), next(earlier)), maps), 2 * step
    return maps


def upstream_of(field: Array) -> Array:
    """The field at the next node upstream, zero at the inlet."""
    return jnp.pad(field[:, :-1], ((0, 0), (1, 0)))
