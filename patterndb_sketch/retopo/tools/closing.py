"""Closing: a patch in the plane becomes curves and a patch of the network."""

from __future__ import annotations

from collections.abc import Sequence

from patterndb.geometry.points import Points
from patterndb_sketch.retopo.errors import InvalidRetopoError, RefusedError
from patterndb_sketch.retopo.ground import LocalMap
from patterndb_sketch.retopo.network import AtNode, Draft, Edit, HalfChain, Network
from patterndb_sketch.retopo.sizes import Sizes
from patterndb_sketch.retopo.tools.around import Edge, sampled_line
from patterndb_sketch.retopo.tools.plane import Corner, NewSide, OldSide, PlanarPatch

#: How far behind its first place a stretch of a boundary is looked at, in samples, to see which
#: chain it runs along: beyond where a cut may have been moved to a sample.
BEYOND = 0.4


def closed_patch(
    network: Network,
    patch: PlanarPatch,
    edges: Sequence[Edge],
    onto: LocalMap,
    sizes: Sizes,
) -> Edit:
    """The network with a planar patch's curves, and with the patch.

    edges: the boundaries that the patch's numbers mean. onto: the map that it is in the plane of.
    The patch's corners are corners of it alone: where new curves meet a boundary those behind
    have T-junctions, and nodes within its sides are T-junctions for it.
    Raises RefusedError if a new curve leaves the map, or the loop does not close.
    """
    draft = Draft(network)
    parts = _parts(patch)
    for _, part, _ in parts:
        if isinstance(part, OldSide) and part.end - part.start < 2.0 * BEYOND:
            raise RefusedError("two corners of the patch would be in one place; take a wider brush")
    # Places first: cutting later would move them.
    nodes = [_node(draft, network, corner, edges, onto) for corner, _, _ in parts]
    inner = [_within(network, part, edges) for _, part, _ in parts]
    leaving: list[HalfChain] = []
    for k, (_, part, _) in enumerate(parts):
        start, end = nodes[k], nodes[(k + 1) % len(nodes)]
        if isinstance(part, NewSide):
            points = onto_ground(onto, sampled_line(part.points, sizes.sampling))
            leaving.append(2 * draft.add_chain(*points, AtNode(start), AtNode(end)))
        else:
            leaving.append(_leaving(draft, network, edges[part.boundary], part))
    for half in (half for halves in inner for half in halves):
        draft.flag(half, False)
    for half, (_, _, corner) in zip(leaving, parts, strict=True):
        draft.flag(half, corner)
    try:
        after = draft.finished(also=leaving[:1])
    except InvalidRetopoError as error:
        raise RefusedError(
            f"the curves would not close to a patch ({error}); draw it a little elsewhere"
        ) from error
    return Edit.of(network, after, draft.notes)


def onto_ground(onto: LocalMap, line: Points) -> tuple[Points, Points]:
    """(m, 3) points and normals of a line in the plane; RefusedError where there is no ground."""
    feet, found = onto.at(line)
    if not found.all():
        raise RefusedError(
            "the patch would reach beyond the surface, or around something too sharply; draw it "
            "elsewhere, or take a smaller brush"
        )
    return feet.points, feet.normals


def _parts(patch: PlanarPatch) -> list[tuple[Corner, OldSide | NewSide, bool]]:
    """Each part of the patch's border: where it begins, and is that a corner of the patch?"""
    found: list[tuple[Corner, OldSide | NewSide, bool]] = []
    for corner, side in zip(patch.corners, patch.sides, strict=True):
        at = corner
        for number, part in enumerate(side):
            if isinstance(part, OldSide):
                at = Corner(at.point, part.boundary, part.start)
            found.append((at, part, number == 0))
            if isinstance(part, OldSide):
                at = Corner(at.point, part.boundary, part.end)
            else:
                at = Corner(part.points[-1])
    return found


def _node(
    draft: Draft, network: Network, corner: Corner, edges: Sequence[Edge], onto: LocalMap
) -> int:
    if corner.boundary is not None:
        end = edges[corner.boundary].end(network, corner.place)
        return end.node if isinstance(end, AtNode) else draft.cut_chain(end.chain, end.place)
    points, normals = onto_ground(onto, corner.point[None])
    return draft.add_node(points[0], normals[0])


def _within(network: Network, part: OldSide | NewSide, edges: Sequence[Edge]) -> list[HalfChain]:
    """The half-chains that leave nodes inside a part."""
    if isinstance(part, NewSide):
        return []
    return edges[part.boundary].nodes_within(network, part.start, part.end)


def _leaving(draft: Draft, network: Network, edge: Edge, part: OldSide) -> HalfChain:
    """The half-chain by which a stretch of a boundary leaves its first node, after cutting."""
    half, local = edge.located(network, part.start + min(BEYOND, (part.end - part.start) / 2.0))
    chain, _ = draft.located(half >> 1, local)
    return 2 * chain + (half & 1)
