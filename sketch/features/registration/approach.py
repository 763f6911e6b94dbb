"""Where two curves come closest to each other."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar
from scipy.spatial.distance import cdist

from query.polyline import Points
from sketch.features.splines import Spline

Floats = NDArray[np.float64]

#: Samples to a knot span, and the least and most samples of a curve: closest approaches that
#: are farther apart than two samples are told apart.
PER_SPAN = 8
LEAST, MOST = 60, 400

#: Rounds of the Gauss-Newton method; it doubles the digits of a crossing with each.
ROUNDS = 30

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


def _sampled(curve: Spline) -> Floats:
    spans = len(np.unique(curve.knots)) - 1
    count = min(max(PER_SPAN * spans, LEAST), MOST)
    return curve.at_lengths(np.linspace(0.0, curve.length, count))


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

    Levenberg's damping: a step is taken only if the distance falls; a parameter at an end of
    its curve is held there while the step would leave the curve.
    """
    ends = first.domain, second.domain
    damping = np.full(len(s), 1e-9)
    off = first(s) - second(t)
    for _ in range(ROUNDS):
        a, b = first.derivative(s), -second.derivative(t)
        right = np.einsum("kc,kc->k", a, off), np.einsum("kc,kc->k", b, off)
        for at, slope, by, (low, high) in ((s, a, right[0], ends[0]), (t, b, right[1], ends[1])):
            slope[((at <= low) & (by > 0.0)) | ((at >= high) & (by < 0.0))] = 0.0
        aa, bb, ab = (np.einsum("kc,kc->k", u, v) for u, v in ((a, a), (b, b), (a, b)))
        right = np.einsum("kc,kc->k", a, off), np.einsum("kc,kc->k", b, off)
        aa, bb = aa * (1.0 + damping) + 1e-300, bb * (1.0 + damping) + 1e-300
        size = aa * bb - ab * ab
        size = np.where(size > 0.0, size, np.inf)
        new_s = np.clip(s - (bb * right[0] - ab * right[1]) / size, *ends[0])
        new_t = np.clip(t - (aa * right[1] - ab * right[0]) / size, *ends[1])
        new_off = first(new_s) - second(new_t)
        better = np.einsum("kc,kc->k", new_off, new_off) < np.einsum("kc,kc->k", off, off)
        if not better.any() and damping.min() > 1e3:
            break
        s, t = np.where(better, new_s, s), np.where(better, new_t, t)
        off = np.where(better[:, None], new_off, off)
        damping = np.where(better, damping * 0.1, damping * 30.0)
    return s, t
