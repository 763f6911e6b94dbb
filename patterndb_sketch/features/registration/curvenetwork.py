"""Networks of feature curves: where curves drawn one by one meet, and how they run in between."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike

from patterndb.geometry.points import Floats, Points, as_points
from patterndb.geometry.polyline import arc_length
from patterndb_sketch.features.errors import InvalidFeatureError
from patterndb_sketch.features.registration.approach import extended
from patterndb_sketch.features.registration.meeting import Joint, meeting
from patterndb_sketch.features.splines import Constraint, Spline, fit_spline

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

    meet, near, tolerance: as :func:`resolved` takes them; None: by default.
    """

    curves: Mapping[str, Spline]
    meet: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    near: Mapping[str, Points] = field(default_factory=dict)
    tolerance: float | None = None


@dataclass(frozen=True, slots=True, eq=False)
class CurveNetwork:
    """Curves that meet exactly.

    curves:     by name, each from its first corner to its last.
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
        """Parameters (k,) of a curve from a corner to another, and the lengths (k,) up to them."""
        a, b = (self.parameters[curve, corner] for corner in (start, end))
        t = np.linspace(a, b, STEPS + 1)
        return t, arc_length(self.curves[curve](t))


def resolved(
    curves: Mapping[str, Spline],
    joints: Sequence[Joint],
    *,
    tolerance: float | None = None,
    near: Mapping[str, ArrayLike] | None = None,
    meet: Mapping[str, Sequence[str]] | None = None,
    plane: tuple[Collection[str], Collection[str]] = ((), ()),
) -> CurveNetwork:
    """The network of drawn curves that meet in the joints.

    tolerance: how far curves may pass and still meet, by default TOLERANCE of the diagonal.
    near:      by joint, a point (3,) near it, where the same curves meet more than once.
    meet:      by joint, those of its curves that say where it is, by default all: the others
               are drawn up to it, as one that ends short.
    plane:     curves and joints that lie in the plane y = 0; their y becomes exactly 0.

    A joint is the mean of the pairwise intersections of its curves; an intersection is midway
    between the points where two curves are closest; curves that end short are drawn out by as
    much as the tolerance, straight on, to find it. Each curve is cut at its first and its last
    joint and fitted anew, so that it passes through its joints.

    Source: feature curve recovery paper, section 5.1.1. Differs from the paper: it does not
    say what becomes of curves that end short; and pairs of curves that run on into each other do
    not count if the joint has others, since their intersection is anywhere along both.

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
    counted = _counted(joints, meet or {})
    longer = {name: extended(curves[name], tolerance) for name in dict.fromkeys(wanted)}
    found = {
        joint.name: meeting(curves, longer, joint, counted[joint.name], tolerance, hints)
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
    return CurveNetwork(cut, nodes, parameters, gaps)


def _diagonal(curves: Iterable[Spline]) -> float:
    every = np.concatenate([curve.control for curve in curves])
    return float(np.linalg.norm(np.ptp(every, axis=0)))


def _counted(joints: Sequence[Joint], meet: Mapping[str, Sequence[str]]) -> dict[str, Joint]:
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
        result[name] = Joint(name, tuple(dict.fromkeys(curves)))
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
