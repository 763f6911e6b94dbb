"""Where two curves come closest to each other, their ends drawn out if need be."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar
from scipy.spatial.distance import cdist

from patterndb.geometry.points import Floats, Points
from patterndb_sketch.features.splines import Spline

#: Samples to a knot span, and the least and most samples of a curve: closest approaches that
#: are farther apart than two samples are told apart.
PER_SPAN = 8
LEAST, MOST = 60, 400

#: Rounds of Newton's method, and the damping beyond which no step is worth a try.
ROUNDS = 40
MOST_DAMPING = 1e6

#: Approaches this close, as a share of the curves' diagonal, are one: two samples led to it.
SAME = 1e-5


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


def approaches(first: Spline, second: Spline, tolerance: float) -> list[Approach]:
    """All closest approaches of two curves within the tolerance, the closest first.

    Both curves are sampled; pairs of samples that are closer than those around them are refined
    on the curves themselves. Where curves run side by side there may be several.
    """
    one, two = _sampled(first), _sampled(second)
    places = first(one), second(two)
    distance = np.asarray(cdist(*places), np.float64)
    # Between samples curves may be closer than at them, by half a step of each.
    steps = sum(float(np.linalg.norm(np.diff(at, axis=0), axis=1).max()) for at in places)
    i, j = np.nonzero(_lowest(distance) & (distance <= tolerance + steps))
    if not len(i):
        return []
    s, t = _refined(first, second, one[i], two[j])
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


def extended(curve: Spline, by: float) -> Spline:
    """The curve with a straight piece of length by > 0 at each end, along its tangents.

    Its parameters are those of the curve, and go on beyond them at the speed of its ends.
    """
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


def least_gap(first: Spline, second: Spline) -> float:
    """How close two curves come to each other at all."""
    return approaches(first, second, np.inf)[0].gap


def foot(curve: Spline, point: Points) -> float:
    """The parameter where a curve is closest to a point (3,)."""
    t = _sampled(curve)
    k = int(np.argmin(np.linalg.norm(curve(t) - point, axis=1)))
    low, high = t[max(k - 1, 0)], t[min(k + 1, len(t) - 1)]

    def off(at: float) -> float:
        return float(np.linalg.norm(curve(at)[0] - point))

    # The distance itself, not its square, tells parameters apart down to rounding.
    found = minimize_scalar(off, bounds=(low, high), method="bounded", options={"xatol": 1e-10})
    return min((float(found.x), low, high), key=off)  # type: ignore[attr-defined]


@lru_cache(maxsize=256)
def _sampled(curve: Spline) -> Floats:
    """Parameters at equal arc length; kept, since a curve is in several pairs."""
    spans = len(np.unique(curve.knots)) - 1
    count = min(max(PER_SPAN * spans, LEAST), MOST)
    result = curve.at_lengths(np.linspace(0.0, curve.length, count))
    result.flags.writeable = False
    return result


def _lowest(distance: Floats) -> NDArray[np.bool_]:
    """(m, n) bool, is an entry at most those around it?"""
    m, n = distance.shape
    padded = np.pad(distance, 1, constant_values=np.inf)
    result = np.ones((m, n), np.bool_)
    for di in range(3):
        for dj in range(3):
            result &= distance <= padded[di : di + m, dj : dj + n]
    return result


def _refined(first: Spline, second: Spline, s: Floats, t: Floats) -> tuple[Floats, Floats]:
    """Parameters (k,), (k,) of closest approaches near those given, within the domains.

    Newton's method with Levenberg's damping: a step is taken only if the distance falls; a
    parameter at an end of its curve is held there while the step would leave the curve.
    """
    ends = first.domain, second.domain
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
