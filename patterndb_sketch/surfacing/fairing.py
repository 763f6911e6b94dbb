"""Fairing: patches that meet in a curve through which the surface goes on smoothly share normals.

A grid of near parallelograms knows nothing of what is beyond its loop. Where the curves that cross
another one at its ends go on through it without a break, so does the surface that is meant. There
each grid is moved within its loop so that it leaves the curve in the plane halfway between those of
the two patches, by the movement that bends least; the curves themselves stay.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_array
from scipy.sparse.linalg import splu

from patterndb.core.halfedge import Int64Array
from patterndb.geometry.points import Floats, Points
from patterndb.geometry.polyline import arc_length
from patterndb_sketch.curvenetwork.network import CurveNetwork, Cycle
from patterndb_sketch.curvenetwork.normals import sample_normals
from patterndb_sketch.curvenetwork.polylines import CORNER_ANGLE, measure_angles
from patterndb_sketch.surfacing.cycles.found import list_users
from patterndb_sketch.surfacing.parallelograms import SectorGrid, lay_grid, measure_borders
from patterndb_sketch.surfacing.sampling import Loop, Sampling

#: A crossing curve that leaves a curve at an angle with a lesser sine tells no plane.
LEAST_SINE = 0.5

#: Faces on a round surface bend from one to the next, so those beside a curve are to bend by this
#: part of what the crossing curves do from sample to sample at its ends. On the first half of
#: benchmarks/surfacing/fairing.py the mean distance is 3.39 thousandths with 0, 3.32 with 0.5, and
#: 3.38 with 1, where the angle across curves is 5.5, 7.4 and 9.6 degrees.
BEND_KEPT = 0.5

#: How much the sum of the movement's squared bends gives way to a border left in another plane.
#: From 0.5 to 100 the distance to what is meant changes by no more than a tenth.
HOLD = 4.0


@dataclass(frozen=True, slots=True)
class SmoothCurve:
    """A curve through which a surface goes on smoothly from one patch into another.

    curve:   its number.
    patches: the two, as places in the list of cycles.
    bends:   radians by which the surface bends at its two ends from sample to sample about the
             curve's sense, from the second patch to the first.
    """

    curve: int
    patches: tuple[int, int]
    bends: tuple[float, float]


@dataclass(frozen=True, slots=True)
class GuidedCurve:
    """A curve along which the surface has known normals.

    curve:   its number.
    patches: those that it bounds, as places in the list of cycles.
    normals: (k, 3) unit normals at its samples, of either sense.
    """

    curve: int
    patches: tuple[int, ...]
    normals: Points = field(repr=False)


@dataclass(frozen=True, slots=True)
class FilledLoop:
    """The surface of a cycle, as fairing needs it.

    loop:    the loop of n vertices that it fills.
    corners: positions in the loop of the corners of its grid; () if it has none, and stays.
    points:  (n + k, 3) the loop's vertices and those inside.
    faces:   (f, 3) int64 triangles of these, in the loop's sense.
    """

    loop: Loop
    corners: tuple[int, ...]
    points: Points
    faces: Int64Array


def find_smooth_curves(
    network: CurveNetwork, sampling: Sampling, cycles: Sequence[Cycle]
) -> list[SmoothCurve]:
    """Find the curves through which the surface of some cycles goes on smoothly.

    Such a curve bounds two cycles. At one of its ends at least two other curves go on from one
    cycle into the other, and at none do they turn about it by more than CORNER_ANGLE, from sample
    to sample; a bend beside it, within the surface, is no crease.
    """
    at: dict[int, list[tuple[int, int]]] = {}
    for number, cycle in enumerate(cycles):
        for place, (curve, _) in enumerate(cycle.steps):
            at.setdefault(curve, []).append((number, place))
    found: list[SmoothCurve] = []
    for curve, sides in sorted(at.items()):
        if len(sides) != 2:
            continue
        bends: list[float | None] = []
        for end in (False, True):
            ahead, behind = (_find_beyond(cycles[number], place, end) for number, place in sides)
            if ahead[0] == behind[0]:
                # A curve along which both cycles go on tells nothing of what is across.
                bends.append(None)
                continue
            along = _leave(sampling, (curve, end)) * (-1.0 if end else 1.0)
            bends.append(_measure_bend(along, _leave(sampling, ahead), -_leave(sampling, behind)))
        known = [bend for bend in bends if bend is not None]
        if known and max(map(abs, known)) <= CORNER_ANGLE:
            first, last = (known[0] if bend is None else bend for bend in bends)
            (one, _), (other, _) = sides
            found.append(SmoothCurve(curve, (one, other), (first, last)))
    return found


def _measure_bend(along: Points, leaving: Points, arriving: Points) -> float | None:
    """The angle about a direction by which one goes over into the next, in radians.

    None where one of the two runs beside ``along``, unless they hardly differ: 0 then.
    """
    along = along / np.linalg.norm(along)
    one, other = leaving - (leaving @ along) * along, arriving - (arriving @ along) * along
    if np.linalg.norm(one) < LEAST_SINE * np.linalg.norm(leaving) or np.linalg.norm(
        other
    ) < LEAST_SINE * np.linalg.norm(arriving):
        straight = measure_angles(arriving[None], leaving[None])[0] <= CORNER_ANGLE
        return 0.0 if straight else None
    return float(np.arctan2(np.cross(other, one) @ along, one @ other))


def _find_beyond(cycle: Cycle, place: int, end: bool) -> tuple[int, bool]:
    """The step by which a cycle goes on from the first or second node of one of its curves."""
    _, backward = cycle.steps[place]
    if end != backward:
        return cycle.steps[(place + 1) % len(cycle.steps)]
    curve, turned = cycle.steps[place - 1]
    return curve, not turned


def _leave(sampling: Sampling, step: tuple[int, bool]) -> Points:
    """(3,) the first edge of a step, away from its node."""
    curve, backward = step
    along = sampling.along[curve][::-1] if backward else sampling.along[curve]
    return sampling.points[along[1]] - sampling.points[along[0]]


def find_guided_curves(
    network: CurveNetwork, sampling: Sampling, cycles: Sequence[Cycle]
) -> list[GuidedCurve]:
    """Find the curves of some cycles whose normals are known, at their samples."""
    found: list[GuidedCurve] = []
    for number, users in sorted(list_users(cycles).items()):
        curve = network.curves[number]
        if curve.normals is not None:
            at = sampling.points[sampling.along[number]]
            normals = sample_normals(curve.points, curve.normals, at)
            found.append(GuidedCurve(number, tuple(patch for patch, _ in users), normals))
    return found


def fair_patches(
    sampling: Sampling,
    patches: Sequence[FilledLoop],
    curves: Sequence[SmoothCurve],
    guides: Sequence[GuidedCurve] = (),
) -> list[Points | None]:
    """Move the grids of patches so that they share normals along smooth curves, and have those of
    guides along these.

    Returns for every patch its inner vertices (k, 3), None where it stays as it is. Beside a patch
    without a grid the other one alone gives way.
    """
    wanted = [np.full((len(patch.loop.points), 2, 3), np.nan) for patch in patches]
    apices = [_find_apices(patch) for patch in patches]
    places = [
        {vertex: i for i, vertex in enumerate(patch.loop.vertices.tolist())} for patch in patches
    ]
    for smooth in curves:
        pair = [patches[number] for number in smooth.patches]
        along = sampling.along[smooth.curve].tolist()
        positions = [[places[number][v] for v in along] for number in smooth.patches]
        leaving = [
            _measure_conormals(patches[number], apices[number], at)
            for number, at in zip(smooth.patches, positions, strict=True)
        ]
        # Of two patches both give way, of one with a grid and one without the first.
        stays = [not patch.corners for patch in pair]
        one, other = (0.0 if stays[1 - k] and not stays[k] else 1.0 for k in (0, 1))
        across = _normalise(one * leaving[0] - other * leaving[1])
        # Patches that fold back on each other have no plane between them.
        across[(leaving[0] * leaving[1]).sum(axis=1) >= 0.0] = np.nan
        here = _normalise(_average_neighbours(across))
        lengths = arc_length(sampling.points[along])
        bend = np.interp(lengths, lengths[[0, -1]], smooth.bends)[:, None] * BEND_KEPT / 2.0
        sideways = np.cross(_normalise(np.gradient(sampling.points[along], axis=0)), here)
        for number, at, sign in zip(smooth.patches, positions, (1.0, -1.0), strict=True):
            inward = sign * here * np.cos(bend) + sideways * np.sin(bend)
            _enter_conormals(wanted[number], at, inward)
    for guide in guides:
        along = sampling.along[guide.curve].tolist()
        across = _normalise(np.cross(guide.normals, np.gradient(sampling.points[along], axis=0)))
        across[np.linalg.norm(across, axis=1) < LEAST_SINE] = np.nan
        for number in guide.patches:
            at = [places[number][v] for v in along]
            leaving = _average_neighbours(_measure_conormals(patches[number], apices[number], at))
            # Normals have two senses; the patch lies on this side of its curve.
            inward = across if np.nansum(across * leaving) >= 0.0 else -across
            _enter_conormals(wanted[number], at, inward)
    return [
        _fair_grid(patch.loop, patch.corners, conormals)
        if patch.corners and not np.isnan(conormals).all()
        else None
        for patch, conormals in zip(patches, wanted, strict=True)
    ]


def _find_apices(patch: FilledLoop) -> Int64Array:
    """(n,) for every edge of the loop, from vertex i on, the third vertex of its triangle."""
    n = len(patch.loop.points)
    apices = np.empty(n, np.int64)
    for k in range(3):
        a, b, c = (patch.faces[:, (k + i) % 3] for i in range(3))
        on_border = (a < n) & (b == (a + 1) % n)
        apices[a[on_border]] = c[on_border]
    return apices


def _walk_edges(n: int, at: Sequence[int]) -> Iterator[tuple[int, bool]]:
    """The edges of a loop of n vertices along positions in a row: where each begins, and whether
    the loop walks it the other way."""
    for i, j in pairwise(at):
        forward = (i + 1) % n == j
        yield (i if forward else j), not forward


def _measure_conormals(patch: FilledLoop, apices: Int64Array, at: Sequence[int]) -> Points:
    """(k - 1, 3) unit vectors in the faces beside edges, across these, into the patch."""
    points = patch.points
    edges = [edge for edge, _ in _walk_edges(len(patch.loop.points), at)]
    along = _normalise(points[at[1:]] - points[at[:-1]])
    inward = points[apices[edges]] - points[at[:-1]]
    return _normalise(inward - (inward * along).sum(axis=1, keepdims=True) * along)


def _enter_conormals(wanted: Points, at: Sequence[int], inward: Points) -> None:
    """Enter unit vectors (k, 3) at the positions along a curve at both ends of its edges."""
    for k, (edge, backward) in enumerate(_walk_edges(len(wanted), at)):
        wanted[edge] = inward[[k + 1, k]] if backward else inward[[k, k + 1]]


def _normalise(vectors: Points) -> Points:
    return vectors / np.maximum(np.linalg.norm(vectors, axis=1, keepdims=True), 1e-300)


def _average_neighbours(of_edges: Points) -> Points:
    """(k, 3) at vertices the mean of what (k - 1, 3) is known at the edges beside."""
    both = np.stack([np.r_[of_edges[:1], of_edges], np.r_[of_edges, of_edges[-1:]]])
    known = ~np.isnan(both).any(axis=2, keepdims=True)
    total = np.where(known, both, 0.0).sum(axis=0)
    return np.where(known.any(axis=0), total, np.nan)


def _fair_grid(loop: Loop, corners: Sequence[int], conormals: Points) -> Points:
    """Move the inner vertices of a loop's grid so that it leaves its border as wanted.

    conormals: (n, 2, 3) at both ends of the loop's edges unit vectors, across the border, in which
    the surface is to leave it; nan where that is free. Returns the inner vertices (k, 3).
    """
    grid, points = lay_grid(loop.points, corners)
    lengths = arc_length(np.r_[loop.points, loop.points[:1]])
    at = measure_borders(lengths, np.array([corners]), np.diff(grid.starts))
    target = _interpolate(lengths, conormals, at[0])
    border = points[: grid.border]
    tangents = _normalise(np.roll(border, -1, axis=0) - np.roll(border, 1, axis=0))
    # At corners two sides would have a say; the curves there know best.
    sides = np.delete(np.arange(grid.border), grid.starts[:-1])
    beside, tangents, target = np.concatenate(grid.ring), tangents[sides], target[sides]
    leaving = points[beside] - points[sides]
    across = leaving - (leaving * tangents).sum(axis=1, keepdims=True) * tangents
    target = _normalise(target - (target * tangents).sum(axis=1, keepdims=True) * tangents)
    change = np.linalg.norm(across, axis=1, keepdims=True) * target - across
    held = ~np.isnan(change).any(axis=1)
    return points[grid.border :] + _bend_least(grid, beside[held], change[held])


def _bend_least(grid: SectorGrid, beside: NDArray[np.int64], change: Points) -> Points:
    """(k, 3) the movement of a grid's inner vertices that bends least, its border held.

    beside: (m,) vertices beside the border that are to move by ``change`` (m, 3). Bends are a
    clamped plate's in finite differences: at the border the Laplacian is that of a movement which
    goes on beyond it as it began, twice the way of the vertex beside less what was asked.
    """
    b = grid.border
    inside = grid.laplacian[b:, b:]
    m = len(beside)
    pick = csc_array((np.full(m, 2.0), (np.arange(m), beside - b)), shape=(m, inside.shape[0]))
    system = csc_array(inside.T @ inside + HOLD * (pick.T @ pick))
    return splu(system).solve(HOLD * (pick.T @ (2.0 * change)))


def _interpolate(lengths: Floats, values: Points, at: Floats) -> Points:
    """(m, 3) values (n, 2, 3) at both ends of a closed loop's edges, at lengths along it.

    lengths: (n + 1,) where the vertices are, the first again at the end.
    """
    edge = np.clip(np.searchsorted(lengths, at, side="right") - 1, 0, len(values) - 1)
    share = ((at - lengths[edge]) / (lengths[edge + 1] - lengths[edge]))[:, None]
    return (1.0 - share) * values[edge, 0] + share * values[edge, 1]
