"""Joints of feature curves: curves drawn one by one are made to meet exactly.

Where two curves come closest, their ends drawn out if need be, is where they may meet
(:func:`patterndb_sketch.curvenetwork.crossings.find_closest_places`); a joint is where its curves
do so at one place; every curve is then fitted through its joints.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import combinations

import numpy as np
from scipy.spatial import KDTree

from patterndb.core.halfedge import Int64Array
from patterndb.geometry.points import Floats, Points, as_points
from patterndb.geometry.polyline import arc_length
from patterndb_sketch.curvenetwork.crossings import ClosestPlaces, find_closest_places
from patterndb_sketch.curvenetwork.polylines import PackedCurves, pack_curves
from patterndb_sketch.curvenetwork.smoothcurves import guess_curves
from patterndb_sketch.features.errors import InvalidFeatureError
from patterndb_sketch.features.splines import Constraint, Spline, fit_spline

#: Samples of a curve at equal arc lengths, and as many at equal parameters: the smooth curve
#: through them is off by less than 1e-9 of its length if it bends by half a turn.
SAMPLES = 400

#: Curves that meet at a smaller angle than 20 degrees run on into each other: where they come
#: closest says nothing about where one ends.
LEAST_SINE = 0.34

#: Two places where a joint's curves meet are both meant if the better one wins by less than this
#: share of the tolerance, in gaps and in what curves had to be drawn out.
DOUBT = 0.5

#: How far curves may pass and still meet, as a share of the diagonal of all curves: ends of
#: drawn curves are off by some hundredths of a car's length.
TOLERANCE = 0.02

#: Samples to a control point of the curve as drawn when it is fitted again, and the fewest; and
#: the fewest between two joints.
SAMPLES_PER_CONTROL = 10
FEWEST_SAMPLES = 60
FEWEST_BETWEEN = 8

#: Joints this close, as a share of a curve's length, are at one place.
ONE_PLACE = 1e-6

#: Steps of the table of a curve's arc length between two corners.
STEPS = 512


@dataclass(frozen=True, slots=True, eq=False)
class FeatureCurves:
    """Feature curves as drawn, by name, and what else is known of where they meet.

    near:      by joint, a point (3,) near it, where the same curves meet more than once.
    meet:      by joint, those of its curves that define where it is, by default all: the others
               are drawn up to it, as one that ends short.
    tolerance: how far curves may pass and still meet, by default TOLERANCE of the diagonal.
    """

    curves: Mapping[str, Spline]
    meet: Mapping[str, Sequence[str]] = field(default_factory=dict)
    near: Mapping[str, Points] = field(default_factory=dict)
    tolerance: float | None = None


@dataclass(frozen=True, slots=True)
class CurveJoint:
    """A corner of a network: at least two curves that meet there."""

    name: str
    curves: tuple[str, ...]


@dataclass(frozen=True, slots=True, eq=False)
class JoinedFeatures:
    """Feature curves that meet exactly.

    curves:     by name, each from its first corner to its last; closed ones are closed.
    nodes:      by the corner's name, (3,) float64.
    parameters: by (curve, corner), where on the curve the corner is.
    gaps:       by corner, how far the curves as drawn passed each other there at most.
    """

    curves: Mapping[str, Spline]
    nodes: Mapping[str, Points]
    parameters: Mapping[tuple[str, str], float]
    gaps: Mapping[str, float]

    def interval(self, curve: str, start: str, end: str) -> tuple[Floats, Floats]:
        """Return parameters (k,) of a curve between two corners, and the lengths (k,) up to them.

        Along a closed curve there are two ways: the one that passes no other corner of it; if
        neither does or both do, the way that it was drawn, and so from a corner to itself.
        """
        a, b = (self.parameters[curve, corner] for corner in (start, end))
        spline = self.curves[curve]
        if spline.closed:
            period = spline.domain[1] - spline.domain[0]
            others = [t for (name, _), t in self.parameters.items() if name == curve]
            others = [t for t in others if t not in (a, b)]
            b = a + ((b - a) % period or period)
            passed = sum((t - a) % period < b - a for t in others)
            if passed and passed == len(others) and start != end:
                b -= period
        t = np.linspace(a, b, STEPS + 1)
        return t, arc_length(spline(t))


def join_features(
    drawn: FeatureCurves,
    joints: Sequence[CurveJoint],
    plane: tuple[Collection[str], Collection[str]] = ((), ()),
) -> JoinedFeatures:
    """Make drawn curves meet in the joints.

    A joint is the mean of the pairwise intersections of its curves; an intersection is midway
    between the points where two curves are closest; curves that end short are drawn out by as
    much as the tolerance, straight on, to find it. Each curve is cut at its first and its last
    joint and fitted again, so that it passes through its joints; a closed one is not cut, and one
    joint of it is enough.

    Parameters
    ----------
    drawn : FeatureCurves
    joints : sequence of CurveJoint
    plane : pair of collections of names
        Curves and joints that lie in the plane y = 0; their y becomes exactly 0.

    Raises
    ------
    InvalidFeatureError
        For curves that are missing, that pass each other beyond the tolerance, or that meet twice
        while nothing defines where.

    References
    ----------
    Feature curve recovery paper, section 5.1.1. Differs from the paper: it leaves open what becomes
    of curves that end short; its curves have ends; and pairs of curves that run on into each other
    do not count if the joint has others, since their intersection is anywhere along both.
    """
    curves = drawn.curves
    wanted = list(dict.fromkeys(name for joint in joints for name in joint.curves))
    missing = [name for name in wanted if name not in curves]
    if missing:
        raise InvalidFeatureError(
            f"the network lacks the curves {', '.join(missing)}; draw them, or take another "
            "template"
        )
    tolerance = drawn.tolerance
    if tolerance is None:
        every = np.concatenate([curves[name].control for name in wanted])
        tolerance = TOLERANCE * float(np.linalg.norm(np.ptp(every, axis=0)))
    hints = {
        name: as_points(np.asarray(place)[None], f"the point near {name}", InvalidFeatureError)[0]
        for name, place in drawn.near.items()
    }
    unknown = sorted(set(hints) - {joint.name for joint in joints})
    if unknown:
        raise InvalidFeatureError(f"there is no joint {unknown[0]!r} that a point could be near")
    counted = _restrict_joints(joints, drawn.meet)
    lines = {name: DrawnLine.of(curves[name], tolerance) for name in wanted}
    nodes: dict[str, Points] = {}
    gaps: dict[str, float] = {}
    for name, joint in counted.items():
        node, gaps[name] = find_meeting(joint, lines, tolerance, hints.get(name))
        if name in plane[1]:
            _check_plane(f"joint {name}", node[None], tolerance)
            node[1] = 0.0
        nodes[name] = node
    fitted: dict[str, Spline] = {}
    parameters: dict[tuple[str, str], float] = {}
    for name, line in lines.items():
        at = {joint.name: nodes[joint.name] for joint in joints if name in joint.curves}
        off = tolerance if name in plane[0] else None
        fitted[name], places = _fit_through(name, line, at, off)
        parameters |= {(name, joint): t for joint, t in places.items()}
    return JoinedFeatures(fitted, nodes, parameters, gaps)


def _restrict_joints(
    joints: Sequence[CurveJoint], meet: Mapping[str, Sequence[str]]
) -> dict[str, CurveJoint]:
    """By name, the joints with those of their curves that define where they are."""
    result = {joint.name: joint for joint in joints}
    for name, curves in meet.items():
        if name not in result:
            raise InvalidFeatureError(f"there is no joint {name!r} where curves could meet")
        known = result[name].curves
        other = [curve for curve in curves if curve not in known]
        if other or len(set(curves)) < 2:
            raise InvalidFeatureError(
                f"at {name} two or more of the curves {', '.join(known)} meet, got {list(curves)}"
            )
        result[name] = CurveJoint(name, tuple(dict.fromkeys(curves)))
    return result


def _check_plane(what: str, points: Points, tolerance: float) -> None:
    off = float(np.abs(points[:, 1]).max())
    if off > tolerance:
        raise InvalidFeatureError(
            f"{what} must lie in the plane y = 0 and is {off:.3g} off; place the model with its "
            "middle plane at y = 0"
        )


@dataclass(frozen=True, slots=True, eq=False)
class DrawnLine:
    """A curve as a dense polyline, which goes straight on beyond the ends of an open one.

    drawn:  (k, 3) float64 samples of the curve itself.
    packed: these with the pieces beyond, each ``beyond`` long, 0 of a closed curve.
    """

    spline: Spline
    drawn: Points
    packed: PackedCurves
    beyond: float

    @classmethod
    def of(cls, spline: Spline, beyond: float) -> DrawnLine:
        """Sample a curve at equal arc lengths and, since it is slow where it bends most, at equal
        parameters; at its knots too, where it may have corners."""
        low, high = spline.domain
        even = spline.at_lengths(np.linspace(0.0, spline.length, SAMPLES))
        t = np.unique(np.r_[even, np.linspace(low, high, SAMPLES), spline.knots])
        t = t[np.r_[True, np.diff(t) > 1e-9 * (high - low)]]
        t[-1] = high
        drawn = spline(t)
        if spline.closed:
            return cls(spline, drawn, pack_curves([drawn]), 0.0)
        steps = int(np.ceil(beyond * SAMPLES / spline.length)) + 1
        share = np.linspace(0.0, beyond, steps + 1)[1:, None]
        before, after = spline.tangent([low, high])
        whole = np.concatenate([
            (drawn[0] - share * before)[::-1], drawn, drawn[-1] + share * after
        ])  # fmt: skip
        return cls(spline, drawn, pack_curves([whole]), beyond)

    @property
    def length(self) -> float:
        """Arc length, with the pieces beyond."""
        return float(self.packed.lasts[0])

    def locate(self, lengths: Floats) -> Points:
        """(m, 3) the places of the smooth curve at arc lengths (m,) of the polyline."""
        curve = np.zeros(len(lengths), np.int64)
        edges = self.packed.find_edges(curve, lengths)
        along = self.packed.along
        shares = (lengths - along[edges]) / (along[edges + 1] - along[edges])
        return guess_curves(self.packed).locate(edges, shares)[0]

    def find_foot(self, place: Points) -> float:
        """Find the arc length at which the polyline is nearest to a place (3,)."""
        return self.packed.find_nearest(0, place, (0.0, self.length))[0]

    def measure_overshoot(self, lengths: Floats) -> Floats:
        """(m,) how far arc lengths (m,) are beyond the ends of the curve as drawn."""
        last = self.length - self.beyond
        return np.maximum(self.beyond - lengths, 0.0) + np.maximum(lengths - last, 0.0)


def find_meeting(
    joint: CurveJoint,
    lines: Mapping[str, DrawnLine],
    tolerance: float,
    hint: Points | None = None,
) -> tuple[Points, float]:
    """Find the node (3,) of a joint, and the largest gap of its curves there.

    hint: a point near it, None if the curves meet once.
    """
    pairs: dict[tuple[str, str], ClosestPlaces] = {}
    for one, two in combinations(joint.curves, 2):
        both = pack_curves([lines[name].packed.points for name in (one, two)])
        pairs[one, two] = find_closest_places(both, tolerance)
        if not len(pairs[one, two]):
            gap = float(np.min(KDTree(lines[one].drawn).query(lines[two].drawn)[0]))
            raise InvalidFeatureError(
                f"at {joint.name}, the curves {one} and {two} pass each other at {gap:.3g}, beyond "
                f"the tolerance of {tolerance:.3g}; draw them to meet, or give a larger tolerance"
            )
    if not pairs:
        raise InvalidFeatureError(f"only {joint.curves[0]} ends at {joint.name}; two curves meet")
    crossing = {pair: found.take(found.sines >= LEAST_SINE) for pair, found in pairs.items()}
    crossing = {pair: found for pair, found in crossing.items() if len(found)}
    beyond = {
        (one, two): lines[one].measure_overshoot(found.lengths[:, 0])
        + lines[two].measure_overshoot(found.lengths[:, 1])
        for (one, two), found in crossing.items()
    }
    if not crossing:
        # Drawn out, curves that run on into each other would lie side by side.
        for (one, two), found in pairs.items():
            both = pack_curves([lines[name].drawn for name in (one, two)])
            as_drawn = find_closest_places(both, tolerance)
            crossing[one, two] = as_drawn if len(as_drawn) else found
            beyond[one, two] = np.zeros(len(crossing[one, two]))
    found = list(crossing.values())
    chosen = _choose_together(joint, found, list(beyond.values()), tolerance, hint)
    node = np.mean([one.middles[k] for one, k in zip(found, chosen, strict=True)], axis=0)
    return node, max(float(one.gaps[k]) for one, k in zip(found, chosen, strict=True))


def _choose_together(
    joint: CurveJoint,
    found: Sequence[ClosestPlaces],
    beyond: Sequence[Floats],
    tolerance: float,
    hint: Points | None,
) -> list[int]:
    """For every pair of curves the number of a place, all about one place.

    beyond: of every place how far the curves are drawn out there.
    """
    if hint is not None:
        return _list_nearest(found, hint)
    places: list[tuple[float, list[int]]] = []
    for pole in found[0].middles:
        near = _list_nearest(found, pole)
        spread = max(_apart(one.middles[k], pole) for one, k in zip(found, near, strict=True))
        # Each of two curves may be off by the tolerance.
        if spread <= 2.0 * tolerance:
            cost = sum(
                float(one.gaps[k] + out[k]) for one, out, k in zip(found, beyond, near, strict=True)
            )
            places.append((spread + cost, near))
    if not places:
        raise InvalidFeatureError(
            f"the curves {', '.join(joint.curves)} meet in pairs, not all at one place, as "
            f"{joint.name} wants"
        )
    places.sort(key=lambda place: place[0])
    least, best = places[0]
    for cost, other in places[1:]:
        apart = min(
            _apart(one.middles[a], one.middles[b])
            for one, a, b in zip(found, best, other, strict=True)
        )
        if cost <= least + DOUBT * tolerance and apart > tolerance:
            spots = " and ".join(
                str(found[0].middles[near[0]].round(4).tolist()) for near in (best, other)
            )
            raise InvalidFeatureError(
                f"the curves {', '.join(joint.curves)} meet at {spots}; give a point near "
                f"{joint.name}"
            )
    return best


def _list_nearest(found: Iterable[ClosestPlaces], place: Points) -> list[int]:
    """For every pair of curves the number of the place nearest to a point (3,)."""
    return [int(np.linalg.norm(one.middles - place, axis=1).argmin()) for one in found]


def _apart(a: Points, b: Points) -> float:
    return float(np.linalg.norm(a - b))


def _fit_through(
    name: str, line: DrawnLine, nodes: Mapping[str, Points], off_plane: float | None
) -> tuple[Spline, dict[str, float]]:
    """Fit a curve from its first joint to its last, or all round, and find their parameters.

    nodes: of the joints. off_plane: how far a curve in the plane y = 0 may be off it; None for
    others.
    """
    spline = line.spline
    at = {joint: line.find_foot(node) for joint, node in nodes.items()}
    # The first joint of a closed curve is its first sample.
    order = sorted(at, key=lambda joint: at[joint] % line.length if spline.closed else at[joint])
    begin = np.array([at[joint] for joint in order])
    if spline.closed:
        begin %= line.length
        spans = np.diff([*begin, begin[0] + line.length])
    elif len(order) < 2:
        raise InvalidFeatureError(f"the curve {name} ends at {order[0]} alone; it needs two joints")
    else:
        spans = np.diff(begin)
    for a, b, span in zip(order, order[1:] + order[:1], spans.tolist(), strict=False):
        if span <= ONE_PLACE * line.length:
            raise InvalidFeatureError(
                f"the joints {a} and {b} are at one place of the curve {name}"
            )
    # The straight pieces beyond the ends would have control points of their own.
    controls = len(spline.control) + (0 if spline.closed else 2 * spline.degree)
    wanted = SAMPLES_PER_CONTROL * controls * spans.sum() / line.length
    count = max(FEWEST_SAMPLES, round(wanted))
    counts = np.maximum(FEWEST_BETWEEN, np.round(count * spans / spans.sum())).astype(np.int64)
    lengths = np.concatenate([
        *(first + np.arange(n) * (span / n)
          for first, span, n in zip(begin.tolist(), spans, counts, strict=False)),
        begin[len(spans) :],
    ])  # fmt: skip
    samples = line.locate(lengths % line.length if spline.closed else lengths)
    if off_plane is not None:
        _check_plane(f"the curve {name}", samples, off_plane)
        samples[:, 1] = 0.0
    numbers: Int64Array = np.r_[0, np.cumsum(counts)][: len(order)]
    held: list[Constraint] = [
        (int(i), nodes[joint]) for i, joint in zip(numbers, order, strict=True)
    ]
    fit = fit_spline(samples, degree=spline.degree, constraints=held, closed=spline.closed)
    control = fit.spline.control.copy()
    if not spline.closed:
        # The fit meets its constraints to some digits; a curve's ends are its first and last
        # control points, which can be the nodes to the last bit.
        control[0], control[-1] = nodes[order[0]], nodes[order[-1]]
    if off_plane is not None:
        control[:, 1] = 0.0
    result = Spline(fit.spline.degree, fit.spline.knots, control, spline.closed)
    return result, {j: float(fit.parameters[i]) for i, j in zip(numbers, order, strict=True)}
