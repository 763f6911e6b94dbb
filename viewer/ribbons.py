"""Curves as bands of triangles that face the viewer, shaded as if they were round."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from patterndb.geometry.points import Points
from viewer.raster import Grid
from viewer.style import circle, rgb

Triangles = tuple[Points, Grid]

#: Mitres longer than so many half widths are cut: there the curve turns back.
LONGEST_MITRE = 1.6

#: How bright a band's rim is, its middle being 1 and lighter than the colour by GLOSS of white.
#: Bands narrower than ROUND points are of one colour.
RIM, GLOSS, ROUND = 0.72, 0.2, 2.5

NOTHING: Triangles = (np.zeros((0, 3, 3)), np.zeros((0, 3, 3), np.float32))


def ribbons(lines: Sequence[Points], colour: str, width: float, lift: float) -> Triangles:
    """Bands along polylines (k, 3) as they are seen, ``width`` points wide.

    lift: how much nearer to the viewer they are than what they lie on, in points.
    """
    kept = [line for line in lines if len(line) > 1]
    if not kept:
        return NOTHING
    points = np.concatenate(kept)
    starts = np.cumsum([0, *(len(line) for line in kept)])
    joined = np.ones(len(points) - 1, np.bool_)
    joined[starts[1:-1] - 1] = False
    across = _across(points[:, :2], joined) * (width / 2.0)
    raised = points + np.array([0.0, 0.0, lift])
    side = np.concatenate([across, np.zeros((len(across), 1))], axis=1)
    # Nearer in the middle: where bands cross, the crossing looks round, too.
    rows = np.stack(
        [raised - side, raised + np.array([0.0, 0.0, width / 4.0]), raised + side], axis=1
    )
    a, b = rows[:-1][joined], rows[1:][joined]
    base = rgb(colour)
    rim = middle = base
    if width >= ROUND:
        rim, middle = base * RIM, base * (1.0 - GLOSS) + GLOSS
    shades = [rim, middle, rim]
    corners: list[Points] = []
    colours: list[Points] = []
    for i, j in ((0, 1), (1, 2)):
        corners += [
            np.stack([a[:, i], a[:, j], b[:, j]], axis=1),
            np.stack([a[:, i], b[:, j], b[:, i]], axis=1),
        ]
        colours += [
            np.stack([shades[i], shades[j], shades[j]]),
            np.stack([shades[i], shades[j], shades[i]]),
        ]
    n = len(a)
    painted = np.concatenate([np.broadcast_to(shade, (n, 3, 3)) for shade in colours])
    return np.concatenate(corners), painted.astype(np.float32)


def discs(places: Points, colour: str, radius: float, lift: float, inner: float = 0.0) -> Triangles:
    """Discs at places (n, 3) as they are seen, or rings with an inner radius."""
    if not len(places):
        return NOTHING
    rim = circle()
    after = np.roll(rim, -1, axis=0)
    zero = np.zeros((len(rim), 1))
    outer = [np.hstack([ends * radius, zero]) for ends in (rim, after)]
    within = [np.hstack([ends * inner, zero]) for ends in (rim, after)]
    fan = np.stack([within[0], outer[0], outer[1]], axis=1)
    if inner > 0.0:
        fan = np.concatenate([fan, np.stack([within[0], outer[1], within[1]], axis=1)])
    corners = (places + np.array([0.0, 0.0, lift]))[:, None, None] + fan
    flat = np.broadcast_to(rgb(colour), (len(places) * len(fan), 3, 3))
    return corners.reshape(-1, 3, 3), flat.astype(np.float32)


def dashed(line: Points, dash: float) -> list[Points]:
    """A polyline (k, 3) as it is seen, in dashes of so many points with gaps as long."""
    along = np.r_[0.0, np.cumsum(np.linalg.norm(np.diff(line[:, :2], axis=0), axis=1))]
    if along[-1] <= dash:
        return [line]
    count = max(1, round(along[-1] / (2.0 * dash)))
    step = along[-1] / count
    dashes: list[Points] = []
    for k in range(count):
        first, last = k * step, (k + 0.55) * step
        inner = along[(along > first) & (along < last)]
        at = np.r_[first, inner, last]
        dashes.append(np.stack([np.interp(at, along, line[:, c]) for c in range(3)], axis=1))
    return dashes


def _across(flat: Points, joined: NDArray[np.bool_]) -> Points:
    """(k, 2) to the left of lines at each of their points, as long as a mitre wants."""
    step = np.diff(flat, axis=0)
    size = np.linalg.norm(step, axis=1, keepdims=True)
    step = np.where(joined[:, None] & (size > 0.0), step / np.where(size > 0.0, size, 1.0), 0.0)
    before = np.vstack([np.zeros((1, 2)), step])
    after = np.vstack([step, np.zeros((1, 2))])
    total = before + after
    length = np.linalg.norm(total, axis=1, keepdims=True)
    # Where a line turns right back, its own last direction is as good as any.
    total = np.where(length > 1e-6, total / np.where(length > 1e-6, length, 1.0), before)
    own = np.where(np.abs(after).sum(axis=1, keepdims=True) > 0.0, after, before)
    cosine = np.abs((total * own).sum(axis=1, keepdims=True))
    mitre = np.minimum(1.0 / np.maximum(cosine, 1e-6), LONGEST_MITRE)
    return np.stack([-total[:, 1], total[:, 0]], axis=1) * mitre
