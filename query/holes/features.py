"""Features of a loop's vertices, by which the corner model judges how many quads each will get.

:func:`measure_loop` measures a vertex and its neighbours along the loop. :func:`measure_hole` adds
how a strand arrives from outside, where it would come out across the hole, and where the next
corners are that the neighbourhood asks for. Nothing beyond three rings of faces is looked at.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from patterndb._native.query.holes.features import own_features
from patterndb._native.query.holes.neighbourhood import count_faces
from patterndb.core.halfedge import Int32Array
from patterndb.geometry.points import Floats
from query.holes.loops import Hole
from query.holes.neighbourhood import Neighbourhood
from query.holes.topology import MeshTopology

#: Loop vertices either side whose numbers count too.
REACH = 4

#: Numbers of one vertex, before those of its neighbours are added; and those of the loop.
OWN, WHOLE = 15, 4

#: Numbers of the edge after a vertex, and of that before.
AFTER_AND_BEFORE = ((5, 6), (7, 8), (9, 10))

#: How many numbers :func:`measure_loop` gives a vertex.
N_FEATURES = OWN * (2 * REACH + 1) + WHOLE

#: Loop vertices either side whose view outwards counts too.
VIEW_REACH = 2

#: Numbers of a vertex's view outwards and across; of the corners next to it and its place in the
#: loop; of the loop.
VIEW, PLACE, LOOP_WHOLE = 17, 13, 9

#: Numbers of the view, and of the place, that tell of what comes after a vertex, and before.
VIEW_SWAPPED = ((6, 7), (8, 9))
PLACE_SWAPPED = ((0, 1), (2, 3), (4, 5), (6, 7))

#: How many numbers :func:`measure_hole` gives a vertex.
N_HOLE_FEATURES = N_FEATURES + VIEW * (2 * VIEW_REACH + 1) + PLACE + LOOP_WHOLE

#: How much nearer a vertex must be, as a power of e, to be opposite in spite of an angle.
NEARER = 0.15

_TINY = 1e-300


def measure_hole(hole: Hole, around: Neighbourhood) -> Floats:
    """(L, N_HOLE_FEATURES) float64: all that the corner model looks at."""
    n = len(hole)
    view = np.zeros((n, VIEW))
    inwards = _look_outwards(hole, around, view)
    _look_across(around, inwards, view)
    at = (np.arange(n)[:, None] + np.arange(-VIEW_REACH, VIEW_REACH + 1)[None, :]) % n
    points = hole.points - hole.points.mean(axis=0)
    _, size, axes = np.linalg.svd(points, full_matrices=False)
    place = np.hstack(
        [_find_next_corners(around.clamped_valence), _locate(points, size, axes, inwards)]
    )
    whole = _measure_whole(around, points, size)
    return np.hstack(
        [
            measure_loop(hole, around),
            view[at].reshape(n, -1),
            place,
            np.broadcast_to(whole, (n, LOOP_WHOLE)),
        ]
    )


def mirror_hole(features: Floats) -> Floats:
    """(L, N_HOLE_FEATURES) what :func:`measure_hole` gives of the mirror image, vertices in the
    same order."""
    n = len(features)
    end = N_FEATURES + VIEW * (2 * VIEW_REACH + 1)
    view = features[:, N_FEATURES:end].reshape(n, 2 * VIEW_REACH + 1, VIEW)[:, ::-1]
    place = features[:, end : end + PLACE]
    turned = view[:, :, _swap(VIEW, VIEW_SWAPPED)].reshape(n, -1)
    return np.hstack(
        [
            mirror_features(features[:, :N_FEATURES]),
            turned,
            place[:, _swap(PLACE, PLACE_SWAPPED)],
            features[:, end + PLACE :],
        ]
    )


def measure_loop(hole: Hole, around: Neighbourhood) -> Floats:
    """(L, N_FEATURES) float64: the numbers that tell how many quads each vertex will get."""
    own = own_features(
        hole.points,
        around.normals,
        around.angle_outside,
        around.outside,
        around.clamped_valence,
        around.scale,
        around.spokes,
        around.far_valence,
    )
    n = len(own)
    at = (np.arange(n)[:, None] + np.arange(-REACH, REACH + 1)[None, :]) % n
    window = own[at].reshape(n, -1)
    turning = float((2 - around.clamped_valence).sum())
    by_angle = float((2.0 - own[:, 1] / (np.pi / 2)).sum())
    whole = np.array(
        [np.log(n), turning - 4.0, by_angle - 4.0, float((around.clamped_valence != 2).mean())]
    )
    return np.hstack([window, np.broadcast_to(whole, (n, WHOLE))])


def mirror_features(features: Floats) -> Floats:
    """(L, N_FEATURES) what :func:`measure_loop` gives of the mirror image, vertices in the same
    order."""
    n = len(features)
    window = features[:, : OWN * (2 * REACH + 1)].reshape(n, 2 * REACH + 1, OWN)
    swapped = list(range(OWN))
    for after, before in AFTER_AND_BEFORE:
        swapped[after], swapped[before] = before, after
    turned = window[:, ::-1][:, :, swapped].reshape(n, -1)
    return np.hstack([turned, features[:, OWN * (2 * REACH + 1) :]])


def _swap(n: int, pairs: tuple[tuple[int, int], ...]) -> list[int]:
    order = list(range(n))
    for a, b in pairs:
        order[a], order[b] = b, a
    return order


def _look_outwards(hole: Hole, around: Neighbourhood, view: Floats) -> Floats:
    """Measure what leads outwards from each vertex, and the faces beyond; return the unit
    directions (L, 3) in which they lead inwards."""
    t = hole.outside
    n, points = len(hole), hole.points
    after = _unit(np.roll(points, -1, axis=0) - points)
    before = _unit(np.roll(points, 1, axis=0) - points)
    # Where nothing leads outwards, the loop tells which way is in.
    inwards = np.cross(around.normals, after - before)
    view[:, 5] = ((after + before) * around.normals).sum(axis=1)
    for i in range(n):
        spokes = around.fans[i][:-1]
        if spokes:
            rows = [_follow_spoke(t, h, around.normals[i]) for h in spokes]
            valences = [row[0] for row, _ in rows]
            view[i, 0], view[i, 1] = max(valences), min(valences)
            view[i, 2] = sum(row[1] for row, _ in rows)
            view[i, 3] = sum(row[2] for row, _ in rows) / len(rows)
            view[i, 4] = sum(row[3] for row, _ in rows) / len(rows)
            inwards[i] = sum(direction for _, direction in rows)
        view[i, 6], view[i, 8] = _weigh_faces(t, int(hole.edges[i]))
    view[:, 7], view[:, 9] = np.roll(view[:, 6], 1), np.roll(view[:, 8], 1)
    return _unit(inwards)


def _follow_spoke(
    t: MeshTopology, h: int, normal: Floats
) -> tuple[tuple[float, float, float, float], Floats]:
    """Follow an edge outwards, and straight on: faces, less 4, at its end and at the next; log
    ratio of the lengths and bend against the normal; and the direction back."""
    points = t.mesh.points
    back = int(t.previous[h])
    at, far = int(t.head[back]), int(t.tail[back])
    out = points[far] - points[at]
    length = float(np.linalg.norm(out))
    valence = count_faces(t.twin, t.next, back) - 4
    direction = -out / max(length, _TINY)
    on = int(t.twin[back])
    on = int(t.twin[int(t.next[on])]) if valence == 0 and on >= 0 else -1
    if on < 0:
        return (float(valence), 0.0, 0.0, 0.0), direction
    on = int(t.next[on])
    further = points[int(t.head[on])] - points[far]
    longer = float(np.linalg.norm(further))
    bend = float((further / max(longer, _TINY) + direction) @ normal)
    second = count_faces(t.twin, t.next, int(t.next[on])) - 4
    ratio = float(np.log(max(longer, _TINY) / max(length, _TINY)))
    return (float(valence), float(second), ratio, bend), direction


def _weigh_faces(t: MeshTopology, edge: int) -> tuple[float, float]:
    """Faces, less 4, at the far vertices of the face outside an edge of the loop, and at those of
    the next face straight on."""
    if edge < 0:
        return 0.0, 0.0
    h = int(t.next[edge])
    total, sides = 0.0, 2
    while int(t.next[h]) != edge:
        total += count_faces(t.twin, t.next, int(t.next[h])) - 4
        sides += 1
        h = int(t.next[h])
    beyond = int(t.twin[int(t.next[int(t.next[edge])])]) if sides == 4 else -1
    if beyond < 0:
        return total, 0.0
    h = int(t.next[int(t.next[beyond])])
    there = count_faces(t.twin, t.next, h) + count_faces(t.twin, t.next, int(t.next[h]))
    return total, float(there - 8)


def _look_across(around: Neighbourhood, inwards: Floats, view: Floats) -> None:
    """Measure, for each vertex, the one that lies opposite: in the direction inwards of both."""
    n = len(inwards)
    points = around.points[:n]
    across = points[None] - points[:, None]
    distance = np.linalg.norm(across, axis=2) + _TINY
    across /= distance[:, :, None]
    there = np.einsum("ijk,ik->ij", across, inwards)
    back = -np.einsum("ijk,jk->ij", across, inwards)
    at = np.arange(n)
    gap = np.abs(at[:, None] - at[None])
    gap = np.minimum(gap, n - gap)
    fits = there + back - NEARER * np.log(distance / around.scale)
    fits[gap < 2] = -np.inf
    opposite = fits.argmax(axis=1)
    chosen = at, opposite
    view[:, 10] = np.log(distance[chosen] / around.scale)
    view[:, 11], view[:, 12] = there[chosen], back[chosen]
    view[:, 13] = around.clamped_valence[opposite]
    view[:, 14] = gap[chosen] / n
    view[:, 15] = np.minimum(gap[chosen] - distance[chosen] / around.scale, 1e3)
    view[:, 16] = opposite[opposite] == at


def _find_next_corners(valence: Int32Array) -> Floats:
    """(L, 8) steps to the next corner of the clamped valences (L,) and its quads, after and before
    each vertex; and to the one after that."""
    n = len(valence)
    corners = np.flatnonzero(valence != 2)
    rows = np.empty((n, 8))
    for column, step in ((0, 1), (1, -1)):
        rows[:, column] = rows[:, column + 4] = n
        rows[:, column + 2] = rows[:, column + 6] = 2
        if not len(corners):
            continue
        steps = (step * (corners[None] - np.arange(n)[:, None])) % n
        steps[steps == 0] = n
        order = np.argsort(steps, axis=1, kind="stable")[:, :2]
        found = np.take_along_axis(steps, order, axis=1)
        for k in range(found.shape[1]):
            rows[:, column + 4 * k] = found[:, k]
            rows[:, column + 4 * k + 2] = valence[corners[order[:, k]]]
    return rows


def _locate(points: Floats, size: Floats, axes: Floats, inwards: Floats) -> Floats:
    """(L, 5) where each vertex lies along the loop's main axes, how its edges run along the first,
    and how straight it looks at the middle. points: (L, 3) from the middle."""
    n = len(points)
    along = np.abs(points @ axes.T) / max(float(size[0]), _TINY) * np.sqrt(n)
    run = _unit(np.roll(points, -1, axis=0) - np.roll(points, 1, axis=0))
    middle = -(_unit(points) * inwards).sum(axis=1)
    return np.column_stack([along, np.abs(run @ axes[0]), middle])


def _measure_whole(around: Neighbourhood, points: Floats, size: Floats) -> NDArray[np.float64]:
    """(LOOP_WHOLE,) of the loop: how long, flat and round it is, how the normals spread, and the
    corners that would be regular."""
    first = max(float(size[0]), _TINY)
    turned = np.cross(points, np.roll(points, -1, axis=0)).sum(axis=0)
    area = float(np.linalg.norm(turned)) / 2
    length = float(np.linalg.norm(np.roll(points, -1, axis=0) - points, axis=1).sum())
    square = max(length * length, _TINY)
    return np.array(
        [
            size[1] / first,
            size[2] / first,
            area / square,
            np.log(max(area, 1e-12 * square) / around.scale**2),
            np.linalg.norm(around.normals.mean(axis=0)),
            (around.clamped_valence == 1).sum(),
            (around.clamped_valence == 3).sum(),
            (around.clamped_valence == 4).sum(),
            (around.regular_valence < 1).sum(),
        ]
    )


def _unit(vectors: Floats) -> Floats:
    size = np.linalg.norm(vectors, axis=1, keepdims=True)
    return vectors / np.maximum(size, _TINY)
