"""Curve networks: drawn curves cut and joined where they meet.

Where two curves come closest (find_approaches), their ends drawn out if need be, is where they may
meet; a joint is where its curves do so at one place (find_meeting); resolve_network fits every
curve through its joints.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from itertools import combinations, pairwise

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.optimize import minimize_scalar
from scipy.spatial.distance import cdist

from patterndb.geometry.points import Floats, Points, as_points
from patterndb.geometry.polyline import arc_length
from patterndb_sketch.features.errors import InvalidFeatureError
from patterndb_sketch.features.splines import Constraint, Spline, fit_spline

#: Samples to a knot span, and the least and most samples of a curve: closest approaches that
#: are farther apart than two samples are told apart.
PER_SPAN = 8

LEAST, MOST = 60, 400

#: Rounds of Newton's method, and the damping beyond which no step is worth a try.
ROUNDS = 40

MOST_DAMPING = 1e6

#: Approaches this close, as a share of the curves' diagonal, are one: two samples led to it.
SAME = 1e-5

#: Curves that meet at a smaller angle than 20 degrees run on into each other: where they come
#: closest says nothing about where one ends.
LEAST_SINE = 0.34

#: Two places where a joint's curves meet are both meant if the better one wins by less than this
#: share of the tolerance, in gaps and in what curves had to be drawn out.
DOUBT = 0.5

#: How far curves may pass and still meet, as a share of the diagonal of all curves: ends of
#: drawn curves are off by some hundredths of a car's length.
TOLERANCE = 0.02

#: Samples to a control point of the curve as drawn when it is fitted anew, and the fewest.
SAMPLES_PER_CONTROL = 10

FEWEST_SAMPLES = 60

#: Steps of the table of a curve's arc length between two corners.
STEPS = 512


@dataclass(frozen=True, slots=True, eq=False)
class DrawnNetwork:
    """Curves as drawn, by name, and what else is known of where they meet.

    meet, near, tolerance: as :func:`resolve_network` takes them; None: by default.
    """

    curves: Mapping[str, Spline]
    meet: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    near: Mapping[str, Points] = field(default_factory=dict)
    tolerance: float | None = None


@dataclass(frozen=True, slots=True, eq=False)
class FeatureNetwork:
    """Curves that meet exactly.

    curves:     by name, each from its first corner to its last; closed ones are closed.
    nodes:      by the corner's name, (3,) float64.
    parameters: by (curve, corner), where on the curve the corner is.
    gaps:       by corner, how far the curves as drawn passed each other there at most.
    """

    curves: Mapping[str, Spline]
    nodes: Mapping[str, Points]
    parameters: Mapping[tuple[str, str], float]
    gaps: Mapping[str, float]

    @property
    def diagonal(self) -> float:
        """Of the box of all control points."""
        return _diagonal(self.curves.values())

    def interval(self, curve: str, start: str, end: str) -> tuple[Floats, Floats]:
        """Parameters (k,) of a curve from a corner to another, and the lengths (k,) up to them.

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


@dataclass(frozen=True, slots=True)
class CurveJoint:
    """A corner of a network: at least two curves that meet there."""

    name: str
    curves: tuple[str, ...]


def resolve_network(
    curves: Mapping[str, Spline],
    joints: Sequence[CurveJoint],
    *,
    tolerance: float | None = None,
    near: Mapping[str, ArrayLike] | None = None,
    meet: Mapping[str, Sequence[str]] | None = None,
    plane: tuple[Collection[str], Collection[str]] = ((), ()),
) -> FeatureNetwork:
    """The network of drawn curves that meet in the joints.

    tolerance: how far curves may pass and still meet, by default TOLERANCE of the diagonal.
    near:      by joint, a point (3,) near it, where the same curves meet more than once.
    meet:      by joint, those of its curves that say where it is, by default all: the others
               are drawn up to it, as one that ends short.
    plane:     curves and joints that lie in the plane y = 0; their y becomes exactly 0.

    A joint is the mean of the pairwise intersections of its curves; an intersection is midway
    between the points where two curves are closest; curves that end short are drawn out by as
    much as the tolerance, straight on, to find it. Each curve is cut at its first and its last
    joint and fitted anew, so that it passes through its joints; a closed one is not cut, and one
    joint of it is enough.

    Source: feature curve recovery paper, section 5.1.1. Differs from the paper: it does not
    say what becomes of curves that end short; its curves have ends; and pairs of curves that run
    on into each other do not count if the joint has others, since their intersection is anywhere
    along both.

    Raises InvalidFeatureError for curves that are not there, that pass each other beyond the
    tolerance, or that meet twice while nothing says where.
    """
    wanted = [name for joint in joints for name in joint.curves]
    missing = [name for name in dict.fromkeys(wanted) if name not in curves]
    if missing:
        raise InvalidFeatureError(
            f"the network lacks the curves {', '.join(missing)}; draw them, or take another "
            "template"
        )
    if tolerance is None:
        tolerance = TOLERANCE * _diagonal(curves[name] for name in wanted)
    hints = {
        name: as_points(np.asarray(place)[None], f"the point near {name}", InvalidFeatureError)[0]
        for name, place in (near or {}).items()
    }
    unknown = sorted(set(hints) - {joint.name for joint in joints})
    if unknown:
        raise InvalidFeatureError(f"there is no joint {unknown[0]!r} that a point could be near")
    counted = _restrict_joints(joints, meet or {})
    longer = {name: extend_curve(curves[name], tolerance) for name in dict.fromkeys(wanted)}
    found = {
        joint.name: find_meeting(curves, longer, joint, counted[joint.name], tolerance, hints)
        for joint in joints
    }
    nodes: dict[str, Points] = {}
    for name, (node, _, _) in found.items():
        if name in plane[1]:
            _check_plane(f"joint {name}", node[None], tolerance)
            node[1] = 0.0
        nodes[name] = node
    cut: dict[str, Spline] = {}
    parameters: dict[tuple[str, str], float] = {}
    for name in dict.fromkeys(wanted):
        at = {joint: where[name] for joint, (_, where, _) in found.items() if name in where}
        cut[name], places = _cut(name, longer[name], at, nodes, name in plane[0], tolerance)
        parameters |= {(name, joint): t for joint, t in places.items()}
    gaps = {name: gap for name, (_, _, gap) in found.items()}
    return FeatureNetwork(cut, nodes, parameters, gaps)


def _restrict_joints(
    joints: Sequence[CurveJoint], meet: Mapping[str, Sequence[str]]
) -> dict[str, CurveJoint]:
    """By name, the joints with those of their curves that say where they are."""
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


def _cut(
    name: str,
    curve: Spline,
    at: Mapping[str, float],
    nodes: Mapping[str, Points],
    planar: bool,
    tolerance: float,
) -> tuple[Spline, dict[str, float]]:
    """The curve from its first joint to its last, through all; and their new parameters."""
    if curve.closed:
        return _hold_closed(name, curve, at, nodes, planar, tolerance)
    order = sorted(at, key=lambda joint: at[joint])
    if len(order) < 2:
        raise InvalidFeatureError(f"the curve {name} ends at {order[0]} alone; it needs two joints")
    low, high = curve.domain
    for a, b in pairwise(order):
        if at[b] - at[a] <= 1e-6 * (high - low):
            raise InvalidFeatureError(
                f"the joints {a} and {b} are at one place of the curve {name}"
            )
    share = (at[order[-1]] - at[order[0]]) / (high - low)
    count = max(FEWEST_SAMPLES, round(SAMPLES_PER_CONTROL * share * len(curve.control)))
    parts: list[Floats] = []
    for a, b in pairwise(order):
        part = max(8, round(count * (at[b] - at[a]) / (at[order[-1]] - at[order[0]])))
        parts.append(np.linspace(at[a], at[b], part, endpoint=False))
    t = np.concatenate([*parts, [at[order[-1]]]])
    numbers = np.r_[0, np.cumsum([len(part) for part in parts])]
    samples = curve(t)
    if planar:
        _check_plane(f"the curve {name}", samples, tolerance)
        samples[:, 1] = 0.0
    held: list[Constraint] = [
        (int(i), nodes[joint]) for i, joint in zip(numbers, order, strict=True)
    ]
    fit = fit_spline(samples, degree=curve.degree, constraints=held)
    control = fit.spline.control.copy()
    # The fit meets its constraints to some digits; a curve's ends are its first and last control
    # points, which can be the nodes to the last bit.
    control[0], control[-1] = nodes[order[0]], nodes[order[-1]]
    if planar:
        control[:, 1] = 0.0
    spline = Spline(fit.spline.degree, fit.spline.knots, control)
    places = {j: float(fit.parameters[i]) for i, j in zip(numbers, order, strict=True)}
    return spline, places


def _hold_closed(
    name: str,
    curve: Spline,
    at: Mapping[str, float],
    nodes: Mapping[str, Points],
    planar: bool,
    tolerance: float,
) -> tuple[Spline, dict[str, float]]:
    """The closed curve through all its joints, and their new parameters."""
    low, high = curve.domain
    period = high - low
    # The first joint is the first sample: between two of them samples are at equal steps.
    places = {joint: low + (t - low) % period for joint, t in at.items()}
    order = sorted(places, key=lambda joint: places[joint])
    begin = [places[joint] for joint in order]
    spans = np.diff([*begin, begin[0] + period])
    for a, b, span in zip(order, order[1:] + order[:1], spans.tolist(), strict=True):
        if span <= 1e-6 * period:
            raise InvalidFeatureError(
                f"the joints {a} and {b} are at one place of the curve {name}"
            )
    count = max(FEWEST_SAMPLES, SAMPLES_PER_CONTROL * len(curve.control))
    counts = np.maximum(8, np.round(count * spans / period)).astype(np.int64)
    t = np.concatenate([
        first + np.arange(n) * (span / n)
        for first, span, n in zip(begin, spans, counts, strict=True)
    ])  # fmt: skip
    samples = curve(t)
    if planar:
        _check_plane(f"the curve {name}", samples, tolerance)
        samples[:, 1] = 0.0
    numbers = np.r_[0, np.cumsum(counts)[:-1]].tolist()
    held: list[Constraint] = [(i, nodes[joint]) for i, joint in zip(numbers, order, strict=True)]
    fit = fit_spline(samples, degree=curve.degree, constraints=held, closed=True)
    spline = fit.spline
    if planar:
        control = spline.control.copy()
        control[:, 1] = 0.0
        spline = Spline(spline.degree, spline.knots, control, closed=True)
    return spline, {j: float(fit.parameters[i]) for i, j in zip(numbers, order, strict=True)}


def _diagonal(curves: Iterable[Spline]) -> float:
    every = np.concatenate([curve.control for curve in curves])
    return float(np.linalg.norm(np.ptp(every, axis=0)))


def find_meeting(
    curves: Mapping[str, Spline],
    longer: Mapping[str, Spline],
    every: CurveJoint,
    joint: CurveJoint,
    tolerance: float,
    hints: Mapping[str, Points],
) -> tuple[Points, dict[str, float], float]:
    """The node (3,) of a joint, where it is on every curve, and the largest gap there.

    curves: as drawn; longer: the same, drawn out at their ends by the tolerance. every: the
    joint; joint: the same with those of its curves that say where it is. hints: by joint, a
    point near it.
    """
    pairs: dict[tuple[str, str], list[Approach]] = {}
    for one, two in combinations(joint.curves, 2):
        pairs[one, two] = find_approaches(longer[one], longer[two], tolerance)
        if not pairs[one, two]:
            gap = measure_least_gap(curves[one], curves[two])
            raise InvalidFeatureError(
                f"at {joint.name}, the curves {one} and {two} pass each other at {gap:.3g}, beyond "
                f"the tolerance of {tolerance:.3g}; draw them to meet, or give a larger tolerance"
            )
    if not pairs:
        raise InvalidFeatureError(f"only {joint.curves[0]} ends at {joint.name}; two curves meet")
    crossing = {
        pair: [one for one in found if one.sine >= LEAST_SINE] for pair, found in pairs.items()
    }
    crossing = {pair: found for pair, found in crossing.items() if found}
    if not crossing:
        # Drawn out, curves that run on into each other would lie side by side.
        for one, two in pairs:
            found = find_approaches(curves[one], curves[two], tolerance)
            crossing[one, two] = found or pairs[one, two]
    places = [
        [(one, _overshoot(one, (curves[a], curves[b]))) for one in found]
        for (a, b), found in crossing.items()
    ]
    chosen = _choose_together(joint, places, tolerance, hints.get(joint.name))
    node = np.mean([one.middle for one in chosen], axis=0)
    where = {name: find_foot(longer[name], node) for name in every.curves}
    return node, where, max(one.gap for one in chosen)


def _overshoot(found: Approach, pair: tuple[Spline, Spline]) -> float:
    """How far beyond the ends of the curves as drawn two curves approach; 0 for closed curves."""
    ends = [curve(at)[0] for curve, at in zip(pair, found.parameters, strict=True)]
    return sum(_apart(end, point) for end, point in zip(ends, found.points, strict=True))


def _choose_together(
    joint: CurveJoint,
    found: list[list[tuple[Approach, float]]],
    tolerance: float,
    hint: Points | None,
) -> list[Approach]:
    """One approach of every pair, all about one place; found: with their overshoots."""
    if hint is not None:
        return [_closest(pair, hint)[0] for pair in found]
    places: list[tuple[float, list[Approach]]] = []
    for pole, _ in found[0]:
        near = [_closest(pair, pole.middle) for pair in found]
        spread = max(_apart(one.middle, pole.middle) for one, _ in near)
        # Each of two curves may be off by the tolerance.
        if spread <= 2.0 * tolerance:
            cost = spread + sum(one.gap + beyond for one, beyond in near)
            places.append((cost, [one for one, _ in near]))
    if not places:
        raise InvalidFeatureError(
            f"the curves {', '.join(joint.curves)} meet in pairs, not all at one place, as "
            f"{joint.name} wants"
        )
    places.sort(key=lambda place: place[0])
    least, best = places[0]
    for cost, other in places[1:]:
        apart = min(_apart(a.middle, b.middle) for a, b in zip(best, other, strict=True))
        if cost <= least + DOUBT * tolerance and apart > tolerance:
            spots = " and ".join(str(near[0].middle.round(4).tolist()) for near in (best, other))
            raise InvalidFeatureError(
                f"the curves {', '.join(joint.curves)} meet at {spots}; give a point near "
                f"{joint.name}"
            )
    return best


def _closest(pair: list[tuple[Approach, float]], place: Points) -> tuple[Approach, float]:
    return min(pair, key=lambda one: _apart(one[0].middle, place))


def _apart(a: Points, b: Points) -> float:
    return float(np.linalg.norm(a - b))


@dataclass(frozen=True, slots=True, eq=False)
class Approach:
    """Two curves' points that are closest among those near them.

    parameters: of the two. points: (2, 3) float64, the first curve's and the second's.
    gap:        their distance.
    sine:       of the angle between the curves there, 0 where they run side by side or on
                into each other.
    """

    parameters: tuple[float, float]
    points: Points
    gap: float
    sine: float

    @property
    def middle(self) -> Points:
        """(3,) midway between the two points."""
        return self.points.mean(axis=0)


def find_approaches(first: Spline, second: Spline, tolerance: float) -> list[Approach]:
    """All closest approaches of two curves within the tolerance, the closest first.

    Both curves are sampled; pairs of samples that are closer than those around them are refined
    on the curves themselves. Where curves run side by side there may be several.
    """
    one, two = _sample(first), _sample(second)
    places = first(one), second(two)
    distance = np.asarray(cdist(*places), np.float64)
    # Between samples curves may be closer than at them, by half a step of each.
    steps = sum(float(np.linalg.norm(np.diff(at, axis=0), axis=1).max()) for at in places)
    i, j = np.nonzero(_find_lowest(distance) & (distance <= tolerance + steps))
    if not len(i):
        return []
    s, t = _refine(first, second, one[i], two[j])
    a, b = first(s), second(t)
    gap = np.linalg.norm(a - b, axis=1)
    sine = np.linalg.norm(np.cross(first.tangent(s), second.tangent(t)), axis=1)
    reach = SAME * float(np.linalg.norm(np.ptp(np.concatenate(places), axis=0)))
    found: list[Approach] = []
    for k in np.argsort(gap, kind="stable"):
        if gap[k] > tolerance:
            break
        pair = np.stack([a[k], b[k]])
        if all(np.linalg.norm(pair - other.points, axis=1).max() > reach for other in found):
            parameters = float(s[k]), float(t[k])
            found.append(Approach(parameters, pair, float(gap[k]), float(sine[k])))
    return found


def extend_curve(curve: Spline, by: float) -> Spline:
    """The curve with a straight piece of length by > 0 at each end, along its tangents.

    A closed one stays as it is.

    Its parameters are those of the curve, and go on beyond them at the speed of its ends.
    """
    if curve.closed:
        return curve
    p = curve.degree
    low, high = curve.domain
    ends = curve.evaluate([low, high])
    along = curve.tangent([low, high])
    speed = np.linalg.norm(curve.derivative([low, high]), axis=1)
    # An end where the curve stands still has no speed: its mean speed will do.
    speed = np.where(speed > 0.0, speed, curve.length / (high - low))
    before, after = by / speed
    steps = by * np.arange(1, p + 1)[:, None] / p
    control = np.concatenate([
        (ends[0] - steps * along[0])[::-1], curve.control, ends[1] + steps * along[1]
    ])  # fmt: skip
    knots = np.r_[
        np.full(p + 1, low - before), np.full(p, low), curve.knots[p + 1 : -p - 1],
        np.full(p, high), np.full(p + 1, high + after),
    ]  # fmt: skip
    return Spline(p, knots, control)


def measure_least_gap(first: Spline, second: Spline) -> float:
    """How close two curves come to each other at all."""
    return find_approaches(first, second, np.inf)[0].gap


def find_foot(curve: Spline, point: Points) -> float:
    """The parameter where a curve is closest to a point (3,)."""
    t = _sample(curve)
    k = int(np.argmin(np.linalg.norm(curve(t) - point, axis=1)))
    low, high = t[max(k - 1, 0)], t[min(k + 1, len(t) - 1)]
    if curve.closed and k in (0, len(t) - 1):
        # The first sample is the last again: the foot may be on either side of it.
        period = t[-1] - t[0]
        low, high = t[-2] - period, t[1]

    def off(at: float) -> float:
        return float(np.linalg.norm(curve(at)[0] - point))

    # The distance itself, not its square, tells parameters apart down to rounding.
    found = minimize_scalar(off, bounds=(low, high), method="bounded", options={"xatol": 1e-10})
    return min((float(found.x), low, high), key=off)  # type: ignore[attr-defined]


@lru_cache(maxsize=256)
def _sample(curve: Spline) -> Floats:
    """Parameters at equal arc length; kept, since a curve is in several pairs."""
    spans = len(np.unique(curve.knots)) - 1
    count = min(max(PER_SPAN * spans, LEAST), MOST)
    result = curve.at_lengths(np.linspace(0.0, curve.length, count))
    result.flags.writeable = False
    return result


def _find_lowest(distance: Floats) -> NDArray[np.bool_]:
    """(m, n) bool, is an entry at most those around it?"""
    m, n = distance.shape
    padded = np.pad(distance, 1, constant_values=np.inf)
    result = np.ones((m, n), np.bool_)
    for di in range(3):
        for dj in range(3):
            result &= distance <= padded[di : di + m, dj : dj + n]
    return result


def _refine(first: Spline, second: Spline, s: Floats, t: Floats) -> tuple[Floats, Floats]:
    """Parameters (k,), (k,) of closest approaches near those given, within the domains.

    Newton's method with Levenberg's damping: a step is taken only if the distance falls; a
    parameter at an end of its curve is held there while the step would leave the curve.
    """
    endless = -np.inf, np.inf
    ends = tuple(endless if curve.closed else curve.domain for curve in (first, second))
    damping = np.full(len(s), 1e-9)
    off = first(s) - second(t)
    for _ in range(ROUNDS):
        a, b = first.derivative(s), -second.derivative(t)
        bend = first.derivative(s, 2), -second.derivative(t, 2)
        right = _dot(a, off), _dot(b, off)
        for at, slope, by, (low, high) in ((s, a, right[0], ends[0]), (t, b, right[1], ends[1])):
            slope[((at <= low) & (by > 0.0)) | ((at >= high) & (by < 0.0))] = 0.0
        right = _dot(a, off), _dot(b, off)
        aa, bb, ab = _dot(a, a), _dot(b, b), _dot(a, b)
        # A parameter that is held has no slope, and nothing for its own equation but 1.
        aa = np.where(aa > 0.0, aa * (1.0 + damping) + _dot(bend[0], off), 1.0)
        bb = np.where(bb > 0.0, bb * (1.0 + damping) + _dot(bend[1], off), 1.0)
        size = aa * bb - ab * ab
        good = (aa > 0.0) & (size > 0.0)
        size = np.where(good, size, np.inf)
        new_s = np.clip(s - (bb * right[0] - ab * right[1]) / size, *ends[0])
        new_t = np.clip(t - (aa * right[1] - ab * right[0]) / size, *ends[1])
        new_off = first(new_s) - second(new_t)
        better = good & (_dot(new_off, new_off) < _dot(off, off))
        if not better.any() and damping.min() > MOST_DAMPING:
            break
        s, t = np.where(better, new_s, s), np.where(better, new_t, t)
        off = np.where(better[:, None], new_off, off)
        damping = np.where(better, damping * 0.1, np.maximum(damping * 100.0, 1e-4))
    return s, t


def _dot(a: Points, b: Points) -> Floats:
    return np.einsum("kc,kc->k", a, b)
