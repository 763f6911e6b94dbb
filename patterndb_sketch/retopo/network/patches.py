"""Find which loops of half-chains are patches, anew where a network changed.

Equation 1 of Takayama et al. 2013 says whether a loop encloses a part of the surface, seen from
outside (:func:`measure_enclosed`). What it does not see:

- A strip that goes three quarters around a limb has its middle beside itself, inside the limb: seen
  from there it has hardly any area. What spans the loop from side to side lies along the strip, and
  tells (:func:`is_strip`).
- The ring around a fingertip, or below the sharp rim of a foot, has normals that point away from
  its axis: seen along them it encloses nothing. But what is beyond it is a small piece of the
  surface, a disk, and empty (:func:`is_cap`).
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from patterndb._native.retopo.network.patches import sum_areas
from patterndb.core.halfedge import Int32Array
from patterndb.geometry.points import Points, units
from patterndb.geometry.polyline import arc_length
from patterndb.geometry.surface import Surface
from patterndb_sketch.retopo.errors import InvalidRetopoError
from patterndb_sketch.retopo.network.faces import has_dead_end, walk_face
from patterndb_sketch.retopo.network.flooding import CLEAR, flood_triangles, make_wall
from patterndb_sketch.retopo.network.structure import Chain, HalfChain, Network, Patch

#: A loop encloses if its area is this part of a circle's of its length. Source: Takayama et
#: al. 2013, section 5.1.
ROUND = 0.1

#: ... or this part of the area that its triangles have without their signs: long ribbons are
#: far from round.
FLAT = 0.5

#: ... and is more than this part of a circle's: less is rounding, of a curve that runs back upon
#: itself. A ribbon is so round if it is a million times as long as wide.
NOTHING = 1e-6


@dataclass(frozen=True, slots=True)
class Enclosed:
    """What a loop encloses.

    area:     signed, positive if the loop runs counter-clockwise seen from outside.
    unsigned: the same without the signs of its triangles.
    length:   of the loop.
    """

    area: float
    unsigned: float
    length: float

    @property
    def roundness(self) -> float:
        """The area as a part of that of a circle of the same length: 1 for a circle."""
        return self.area * 4.0 * math.pi / self.length**2 if self.length > 0.0 else 0.0

    @property
    def encloses(self) -> bool:
        """Is it to be a patch?

        Differs from the paper: counter-clockwise ribbons count however long they are. Equation
        1 with its lambda = 0.1 loses rectangles longer than 29 to 1.
        """
        roundness = self.roundness
        return roundness > ROUND or (roundness > NOTHING and self.area > FLAT * self.unsigned)


def measure_enclosed(points: Points, normals: Points) -> Enclosed:
    """Of a closed polyline (n, 3), which does not repeat its first point, with the surface's
    normals (n, 3).

    Source: Takayama et al. 2013, equation 1, with the mean of the points as the centre.
    """
    if len(points) < 2:
        return Enclosed(0.0, 0.0, 0.0)
    return Enclosed(*sum_areas(np.ascontiguousarray(points), np.ascontiguousarray(normals)))


#: Points along a side of what spans the loop.
POINTS = 17

#: A loop runs around a strip if what spans it faces as the surface does, by this share of its
#: area: a ring around a limb, spanned by a disk across it, has 0, and a strip from behind -1.
FACING = 0.5


def is_strip(sides: Sequence[tuple[Points, Points]]) -> bool:
    """Is a loop of four sides counter-clockwise around a strip, seen from outside?

    sides: (n, 3) points and (n, 3) normals of each from corner to corner, in the loop's sense. What
    spans it is a bilinearly blended patch (Coons 1967).
    """
    points = _blend_sides([_space_evenly(line, line) for line, _ in sides])
    normals = _blend_sides([_space_evenly(line, up) for line, up in sides])
    across = points[1:, 1:] - points[:-1, :-1], points[:-1, 1:] - points[1:, :-1]
    area = np.cross(*across).reshape(-1, 3) / 2.0
    up = units(
        (normals[1:, 1:] + normals[:-1, :-1] + normals[:-1, 1:] + normals[1:, :-1]).reshape(-1, 3)
    )
    whole = float(np.linalg.norm(area, axis=1).sum())
    return whole > 0.0 and float(np.einsum("nc,nc->", area, up)) > FACING * whole


def _space_evenly(line: Points, values: Points) -> Points:
    """(POINTS, 3) of the values along a polyline (n, 3), at equal arc length."""
    along = arc_length(line)
    wanted = np.linspace(0.0, along[-1], POINTS)
    return np.stack([np.interp(wanted, along, values[:, d]) for d in range(3)], axis=1)


def _blend_sides(sides: list[Points]) -> Points:
    """(POINTS, POINTS, 3) between the four sides of a loop; rows follow the first."""
    south, east, north, west = sides[0], sides[1], sides[2][::-1], sides[3][::-1]
    t = np.linspace(0.0, 1.0, POINTS)
    u, v = t[:, None, None], t[None, :, None]
    ruled = (1 - v) * south[:, None] + v * north[:, None] + (1 - u) * west[None] + u * east[None]
    corners = (
        (1 - u) * (1 - v) * south[0]
        + u * (1 - v) * south[-1]
        + u * v * north[-1]
        + (1 - u) * v * north[0]
    )
    return ruled - corners


#: The surface beyond a loop has at most this many times the area of the flat disk with the loop's
#: length, l^2 / 4 pi. Half a ball has 2; a fingertip, which is half a ball on a piece of the finger
#: a quarter as long as it is thick, 3. A hand beyond the wrist has some 8, a foot 12.
ROUNDNESS = 3.0

#: Of the triangles beside a loop that the flooding reached, this many times as many must be on
#: its left as on its right: else the loop parts nothing, as one around a handle.
LEFT = 3


def is_cap(network: Network, loop: tuple[HalfChain, ...], points: Points, length: float) -> bool:
    """Is the surface on the left of a loop (n, 3) an empty disk, no larger than a cap?

    False where the network knows no surface, and where the loop lies within a few triangles, which
    are flat, so that equation 1 sees it. Costs no more than looking at that much of the surface.
    """
    surface = network.surface
    if surface is None or length <= 0.0:
        return False
    wall = make_wall(surface, [(points, True)])
    if wall.gaps:
        return False
    most = ROUNDNESS * length**2 / (4.0 * math.pi)
    # What is crossed counts if its middle is beyond the loop.
    walls = np.flatnonzero(wall.crossed).astype(np.int32)
    most -= float(surface.areas[walls[wall.side_of(surface, walls)[1] > 0.0]].sum())
    _, side = wall.side_of(surface, wall.beside)
    found = flood_triangles(surface, wall.crossed, wall.beside[side > CLEAR], most)
    if found is None or len(found[0]) == 0:
        return False
    inside = np.zeros(len(surface.triangles), np.bool_)
    inside[found[0]] = True
    return (
        _is_on_left(side[inside[wall.beside]])
        and _is_disk(surface, inside | wall.crossed)
        and not _has_curve_within(network, {half >> 1 for half in loop}, surface, found[0], inside)
    )


def _is_on_left(side: NDArray[np.float64]) -> bool:
    return int((side > CLEAR).sum()) >= LEFT * int((side < -CLEAR).sum())


def _is_disk(surface: Surface, inside: NDArray[np.bool_]) -> bool:
    """Euler's formula: V - E + F = 1 of a disk; 0 where there is a hole in it, or a handle."""
    triangles = surface.triangles[inside]
    edges = surface.adjacency.edges.reshape(-1, 3)[inside]
    return len(np.unique(triangles)) - len(np.unique(edges)) + len(triangles) == 1


def _has_curve_within(
    network: Network,
    own: set[int],
    surface: Surface,
    found: Int32Array,
    inside: NDArray[np.bool_],
) -> bool:
    """Does a curve that is none of the loop's lie on the triangles?"""
    corners = surface.vertices[surface.triangles[found].ravel()]
    low, high = corners.min(axis=0), corners.max(axis=0)
    samples = [
        chain.points[[0, len(chain.points) // 2, -1]]
        for chain in network.chains.values()
        if chain.id not in own
        and (chain.points.max(axis=0) >= low).all()
        and (chain.points.min(axis=0) <= high).all()
    ]
    if not samples:
        return False
    return bool(inside[surface.nearest(np.concatenate(samples)).triangles].any())


#: A patch has this many corners or more: each of its sides is a curve of its own.
FEWEST_CORNERS = 2


def trace_outline(network: Network, loop: Iterable[HalfChain]) -> tuple[Points, Points]:
    """(n, 3) points and normals around a loop of half-chains, no point twice."""
    points: list[Points] = []
    normals: list[Points] = []
    for half in loop:
        chain = network.chains[half >> 1]
        line, up = chain.directed(half)
        last = len(line) if chain.is_closed_loop else -1
        points.append(line[:last])
        normals.append(up[:last])
    return np.concatenate(points), np.concatenate(normals)


def measure_loop(network: Network, loop: tuple[HalfChain, ...]) -> Enclosed:
    """What equation 1 says of a loop."""
    return measure_enclosed(*trace_outline(network, loop))


def may_be_patch(network: Network, loop: tuple[HalfChain, ...], corners: tuple[int, ...]) -> bool:
    """May a loop be a patch, whatever it encloses: corners enough, no open end, no mark?"""
    return (
        len(corners) >= FEWEST_CORNERS
        and not any(network.mark(half) for half in loop)
        and not has_dead_end(network.nodes, network.chains, loop)
    )


def is_patch(network: Network, loop: tuple[HalfChain, ...], corners: tuple[int, ...]) -> bool:
    """Is a loop to be a patch?

    Source: Takayama et al. 2013, section 5.1. Differs from the paper: any number of corners
    from two on, since any such loop has fills; and what equation 1 does not see: strips that are
    bent far around a limb (see the module), and the ends of limbs (:func:`is_cap`).
    """
    if not may_be_patch(network, loop, corners):
        return False
    if measure_loop(network, loop).length > network.longest:
        return False
    return is_end(network, loop) or (
        len(corners) == 4 and is_strip(_list_sides(network, loop, corners))
    )


def find_long_loops(network: Network, chains: Iterable[int]) -> list[float]:
    """Find the loops along some chains that would be patches if they were not longer than the
    network's ``longest``; their lengths."""
    found: list[float] = []
    visited: set[HalfChain] = set()
    for half in (half for chain in chains for half in (2 * chain, 2 * chain + 1)):
        if half in visited:
            continue
        loop, corners = walk_face(network.nodes, network.chains, half)
        visited.update(loop)
        if may_be_patch(network, loop, corners):
            length = measure_loop(network, loop).length
            if length > network.longest and is_end(network, loop):
                found.append(length)
    return found


def is_end(network: Network, loop: tuple[HalfChain, ...]) -> bool:
    """Does a loop enclose by equation 1, or the end of a limb, which the surface tells?"""
    points, normals = trace_outline(network, loop)
    found = measure_enclosed(points, normals)
    # Clockwise around a piece of the surface seen from outside, it is around the rest of it.
    return found.encloses or (
        found.roundness > -ROUND and is_cap(network, loop, points, found.length)
    )


def _list_sides(
    network: Network, loop: tuple[HalfChain, ...], corners: tuple[int, ...]
) -> list[tuple[Points, Points]]:
    """(n, 3) points and normals of every side of a loop, both of its corners included."""
    found: list[tuple[Points, Points]] = []
    for begin, end in zip(corners, (*corners[1:], len(loop)), strict=True):
        lines = [network.chains[half >> 1].directed(half) for half in loop[begin:end]]
        found.append(
            (
                np.concatenate([line for line, _ in lines]),
                np.concatenate([up for _, up in lines]),
            )
        )
    return found


def find_patches(
    network: Network,
    nodes: Iterable[int],
    chains: Iterable[int],
    also: Iterable[HalfChain] = (),
    forget: bool = False,
) -> Network:
    """The network with its patches right again, after nodes and chains changed.

    nodes: ids of those whose ends, flags or places changed; chains: of those that are new or
    run elsewhere; ids that are not there any more do no harm. Patches whose loops and corners
    are as they were stay, with their ids and choices, even if their chains moved; all others
    that lost a chain or touch what changed go.

    also:   the loops on the left of these become patches whatever they enclose. Raises
            InvalidRetopoError if one cannot.
    forget: are counts that a patch used, and none does any more, forgotten? Not pinned ones.
    """
    at, lines = network.nodes, network.chains
    forced = set(also)
    starts: set[HalfChain] = set(forced)
    for node in nodes:
        if node in at:
            starts.update(half ^ 1 for half in at[node].ends)
    for chain in chains:
        if chain in lines:
            starts.update((2 * chain, 2 * chain + 1))
    old_of = network.patch_of()
    kept: set[int] = set()
    touched: set[int] = set()
    visited: set[HalfChain] = set()
    made: list[tuple[tuple[HalfChain, ...], tuple[int, ...]]] = []
    for half in sorted(starts):
        if half in visited:
            continue
        loop, corners = walk_face(at, lines, half)
        visited.update(loop)
        touched.update(old_of[h] for h in loop if h in old_of)
        old = network.patches.get(old_of.get(loop[0], -1))
        if old is not None and old.loop == loop and old.corners == corners:
            kept.add(old.id)
        elif not forced.isdisjoint(loop):
            if not may_be_patch(network, loop, corners):
                raise InvalidRetopoError(
                    f"the loop of half-chain {loop[0]} can be no patch: it has {len(corners)} "
                    "corners, an open end or a marked side"
                )
            made.append((loop, corners))
        elif is_patch(network, loop, corners):
            made.append((loop, corners))
    gone = {p for half, p in old_of.items() if (half >> 1) not in lines} | (touched - kept)
    if not gone and not made:
        return network
    patches = {p: patch for p, patch in network.patches.items() if p not in gone}
    next_id = network.next_id
    for loop, corners in made:
        patches[next_id] = Patch(next_id, loop, corners)
        next_id += 1
    result = replace(network, patches=patches, next_id=next_id)
    if forget:
        unused = _find_unused(result, (network.patches[p] for p in gone))
        result = replace(result, chains={**lines, **unused})
    return result


def remove_patch(network: Network, patch: int) -> Network:
    """The network with a patch less; counts that only it used, and no user chose, are forgotten."""
    patches = {p: one for p, one in network.patches.items() if p != patch}
    result = replace(network, patches=patches)
    unused = _find_unused(result, [network.patches[patch]])
    return replace(result, chains={**network.chains, **unused})


def _find_unused(network: Network, gone: Iterable[Patch]) -> dict[int, Chain]:
    """The chains of dissolved patches that no patch uses now, without their counts."""
    used = {half >> 1 for patch in network.patches.values() for half in patch.loop}
    found: dict[int, Chain] = {}
    for patch in gone:
        for chain in {half >> 1 for half in patch.loop} - used:
            line = network.chains.get(chain)
            if line is not None and line.count and not line.pinned:
                found[chain] = replace(line, count=0)
    return found
