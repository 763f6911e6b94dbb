"""Where the curves of a joint meet."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from patterndb.geometry.points import Points
from patterndb_sketch.features.errors import InvalidFeatureError
from patterndb_sketch.features.registration.approach import Approach, approaches, foot, least_gap
from patterndb_sketch.features.splines import Spline

#: Curves that meet at a smaller angle than 20 degrees run on into each other: where they come
#: closest says nothing about where one ends.
LEAST_SINE = 0.34

#: Two places where a joint's curves meet are both meant if the better one wins by less than this
#: share of the tolerance, in gaps and in what curves had to be drawn out.
DOUBT = 0.5


@dataclass(frozen=True, slots=True)
class Joint:
    """A corner of a network: at least two curves that meet there."""

    name: str
    curves: tuple[str, ...]


def meeting(
    curves: Mapping[str, Spline],
    longer: Mapping[str, Spline],
    every: Joint,
    joint: Joint,
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
        pairs[one, two] = approaches(longer[one], longer[two], tolerance)
        if not pairs[one, two]:
            gap = least_gap(curves[one], curves[two])
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
            found = approaches(curves[one], curves[two], tolerance)
            crossing[one, two] = found or pairs[one, two]
    places = [
        [(one, _overshoot(one, (curves[a], curves[b]))) for one in found]
        for (a, b), found in crossing.items()
    ]
    chosen = _together(joint, places, tolerance, hints.get(joint.name))
    node = np.mean([one.middle for one in chosen], axis=0)
    where = {name: foot(longer[name], node) for name in every.curves}
    return node, where, max(one.gap for one in chosen)


def _overshoot(found: Approach, pair: tuple[Spline, Spline]) -> float:
    """How far beyond the ends of the curves as drawn two curves approach."""
    ends = [curve(at)[0] for curve, at in zip(pair, found.parameters, strict=True)]
    return sum(_apart(end, point) for end, point in zip(ends, found.points, strict=True))


def _together(
    joint: Joint,
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
