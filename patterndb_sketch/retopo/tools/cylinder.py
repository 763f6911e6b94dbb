"""The cylinder tool: a stroke from loop to loop makes a row of patches between, and their caps.

Source: sketch-based quad meshes paper, section 4 and Fig. 6. A ring is a closed loop with nothing
on its left yet: :func:`find_rings` finds them, :func:`_pair_places` says which points of one
belong to which of the other, shortest paths join these, and caps are the patches beyond the rings.
"""

from __future__ import annotations

from typing import Any, Literal, get_args

import numpy as np

from patterndb.geometry.points import Points
from patterndb.geometry.surface import Surface
from patterndb_sketch.retopo.arguments import POINTS, Argument, Number, Word
from patterndb_sketch.retopo.errors import InvalidRetopoError, RefusedError
from patterndb_sketch.retopo.network import (
    AtNode,
    Edit,
    HalfChain,
    Network,
    NetworkBuilder,
    has_dead_end,
    is_end,
    trace_outline,
    walk_face,
)
from patterndb_sketch.retopo.network.flooding import explain_no_disk
from patterndb_sketch.retopo.network.insertion import Nearness, insert_curve
from patterndb_sketch.retopo.sizes import Sizes
from patterndb_sketch.retopo.tool import Control, Result, Tool, ToolWork
from patterndb_sketch.retopo.tools.closing import SurfaceBoundary, join_half_chains
from patterndb_sketch.retopo.tools.stroke import NODE_NEAR, drag_to_ends
from patterndb_sketch.retopo.tracing import SurfaceCurve, trace_geodesic
from patterndb_sketch.retopo.tracing.curves import take_to_surface

#: Patches between two loops without corners, unless told. Source: the released program of
#: Takayama et al. 2013.
DIVISION = 4

#: The most: a patch for every few samples of a loop.
MOST = 64

CROSS = (
    "two of the curves between the loops would cross, or one would cross a curve that is there; "
    "draw the stroke elsewhere, or erase what is in the way"
)


def join_loops(
    network: Network,
    surface: Surface,
    sizes: Sizes,
    stroke: SurfaceCurve,
    division: int = DIVISION,
    caps: Caps = "auto",
) -> Edit:
    """The network with a row of patches between two closed loops that a stroke joins.

    Its ends snap to the loops, of loops with corners to one. Corner goes to corner; from a loop
    with corners to one without, to the points at the same parts of the way round; between
    loops without, ``division`` (2 to 64) pairs of points divide both evenly. The stroke is one
    of the curves between, the others are shortest paths.
    caps: "auto" for patches beyond the loops too, where these enclose an end of the surface that
    is a disk; "always", or "never". Where the other side already has curves there is none.

    Raises RefusedError, and nothing changes, for an end at no loop, both at one, numbers of
    corners that do not agree, curves that would cross, and a cap that is always to be there and
    would be no disk of the surface.
    """
    if not 2 <= division <= MOST:
        raise InvalidRetopoError(f"a division into {division}; give 2 to {MOST}")
    if caps not in CAPS:
        raise InvalidRetopoError(f"caps is {caps!r}; there are {', '.join(CAPS)}")
    builder = NetworkBuilder(network, surface)
    one, other = _find_ends(network, stroke, sizes.snap)
    pairs = _pair_places(one, other, division)
    capped = [
        ring for ring, _ in (one, other) if _is_cap_wanted(builder.before, surface, ring, caps)
    ]
    nodes = [
        [ring.make_node(builder, network, pair[k]) for pair in pairs]
        for k, (ring, _) in enumerate((one, other))
    ]
    if any(len(set(found)) < len(found) for found in nodes):
        raise RefusedError("two of the curves would begin in one place; divide into fewer")
    joins = [
        _join(builder, surface, sizes, a, b, stroke if k == 0 else None)
        for k, (a, b) in enumerate(zip(*nodes, strict=True))
    ]
    also = [2 * chain for chain in joins]
    for k, (ring, _) in enumerate((one, other)):
        if ring in capped:
            beyond = [
                _flag_beyond(builder, node, 2 * chain + k)
                for node, chain in zip(nodes[k], joins, strict=True)
            ]
            also += beyond[:1]
    try:
        after = builder.finish(also=also)
    except InvalidRetopoError as error:
        raise RefusedError(f"the loops would not close to patches: {error}") from error
    return Edit.of(network, after, builder.notes)


def _find_ends(
    network: Network, stroke: SurfaceCurve, snap: float
) -> tuple[tuple[SurfaceBoundary, int], tuple[SurfaceBoundary, int]]:
    """The rings that the stroke joins, with the vertices it snaps to."""
    if stroke.closed:
        raise RefusedError("this stroke is closed; draw one from loop to loop")
    found = find_rings(network)
    line, up = stroke.points, stroke.normals
    # The direction over a few samples: the first ones may run along the loop.
    ahead = min(len(line) - 1, 4)
    one, other = (
        _snap_to_ring(found, line[end], up[end], line[end + step] - line[end], snap, name)
        for end, step, name in ((0, ahead, "start"), (-1, -ahead, "end"))
    )
    if one[0] is other[0] or set(one[0].halves) == set(other[0].halves):
        raise RefusedError("the stroke begins and ends at one loop; draw it to another")
    return one, other


def _snap_to_ring(
    found: list[SurfaceBoundary],
    point: Points,
    normal: Points,
    direction: Points,
    snap: float,
    name: str,
) -> tuple[SurfaceBoundary, int]:
    at = find_ring(found, point, normal, direction, snap)
    if at is None:
        raise RefusedError(
            f"there is no closed loop, empty towards the stroke, at its {name}; on a loop "
            "with corners it must begin and end at one of them"
        )
    return at


def _join(
    builder: NetworkBuilder,
    surface: Surface,
    sizes: Sizes,
    one: int,
    other: int,
    stroke: SurfaceCurve | None,
) -> int:
    """The chain from node to node: the stroke, or the shortest path; it must cross nothing."""
    ends = AtNode(one), AtNode(other)

    def project(points: Points, normals: Points) -> tuple[Points, Points]:
        return take_to_surface(points, normals, surface, sizes)

    if stroke is None:
        a, b = builder.nodes[one], builder.nodes[other]
        feet = [surface.nearest_facing(n.point[None], n.normal[None]) for n in (a, b)]
        stroke = trace_geodesic(surface, feet[0], feet[1]).sample(surface, sizes.sampling)
    stroke = drag_to_ends(stroke, builder, ends, project)
    near = Nearness(min(NODE_NEAR * sizes.sampling, 0.25 * sizes.snap), (0.0, 0.0))
    made = insert_curve(builder, stroke, *ends, near, project)
    if len(made) != 1:
        raise RefusedError(CROSS)
    return made[0]


def _pair_places(
    first: tuple[SurfaceBoundary, int], second: tuple[SurfaceBoundary, int], division: int
) -> list[tuple[float, float]]:
    """Places on two rings that belong together, beginning with the vertices given.

    The part between the rings lies on the left of both, so that one is walked forwards and the
    other backwards. Where both have nodes, one belongs to the next; where one has, each belongs
    to the point at the same part of the way round; where neither has, ``division`` pairs
    divide both evenly.
    Raises RefusedError if both have nodes, and not the same number.

    Source: sketch-based quad meshes paper, section 4, and its released program.
    """
    (one, start), (other, end) = first, second
    k, m = len(one.corners), len(other.corners)
    if k and m:
        if k != m:
            raise RefusedError(
                f"one loop has {k} corners and the other {m}; add or delete corners until they "
                "have as many, or none"
            )
        ahead = _walk_corners(one, start, backwards=False)
        back = _walk_corners(other, end, backwards=True)
        return [(float(a), float(b)) for a, b in zip(ahead, back, strict=True)]
    if k:
        ahead = _walk_corners(one, start, backwards=False)
        way = one.fractions(start, backwards=False)
        return [(float(a), other.place(end, float(way[a]), backwards=True)) for a in ahead]
    if m:
        back = _walk_corners(other, end, backwards=True)
        way = other.fractions(end, backwards=True)
        return [(one.place(start, float(way[b]), backwards=False), float(b)) for b in back]
    return [
        (
            one.place(start, j / division, backwards=False),
            other.place(end, j / division, backwards=True),
        )
        for j in range(division)
    ]


def _walk_corners(ring: SurfaceBoundary, start: int, *, backwards: bool) -> list[int]:
    """The nodes of a ring as they are met from one of them on."""
    n = len(ring.points)
    way = (start - ring.corners) % n if backwards else (ring.corners - start) % n
    return [int(ring.corners[k]) for k in np.argsort(way)]


Caps = Literal["auto", "always", "never"]
CAPS = get_args(Caps)


def _is_cap_wanted(network: Network, surface: Surface, ring: SurfaceBoundary, caps: Caps) -> bool:
    """Is there to be a patch on the other side of a ring?

    Never where that side has a patch, a mark or other curves; else always, or, by itself, where
    the loop encloses a disk of the surface there as a patch does, or the end of a limb. Raises
    RefusedError for one that is always to be there, where the surface has no disk.
    """
    if caps == "never":
        return False
    beyond = tuple(half ^ 1 for half in reversed(ring.halves))
    if any(half in network.patch_of() or network.mark(half) for half in beyond):
        return False
    loop, _ = walk_face(network.nodes, network.chains, beyond[0])
    if set(loop) != set(beyond):
        return False
    if caps == "auto" and not is_end(network, loop):
        return False
    why = explain_no_disk(surface, trace_outline(network, loop)[0])
    if why is not None and caps == "always":
        raise RefusedError(f"there can be no cap beyond a loop: {why}, or take the caps off")
    return why is None


def _flag_beyond(builder: NetworkBuilder, node: int, join: HalfChain) -> HalfChain:
    """Make the wedge at a node across from a join a corner; the half-chain on its right."""
    ends = builder.nodes[node].ends
    after = ends[(ends.index(join) + 1) % len(ends)]
    builder.flag(after, True)
    return after


def find_rings(network: Network) -> list[SurfaceBoundary]:
    """All closed loops of half-chains without a patch on their left, those of lower half-chains
    first."""
    taken = network.patch_of()
    done: set[HalfChain] = set()
    found: list[SurfaceBoundary] = []
    for chain in sorted(network.chains):
        for half in (2 * chain, 2 * chain + 1):
            if half in done or half in taken:
                continue
            loop, _ = walk_face(network.nodes, network.chains, half)
            done.update(loop)
            if has_dead_end(network.nodes, network.chains, loop):
                continue
            if any(network.mark(one) for one in loop):
                continue
            found.append(join_half_chains(network, list(loop), closed=True))
    return found


def find_ring(
    found: list[SurfaceBoundary], point: Points, normal: Points, direction: Points, snap: float
) -> tuple[SurfaceBoundary, int] | None:
    """The ring nearest to an end of a stroke, and the vertex it snaps to, or None.

    point, normal: (3,) of the end; direction: (3,) into the stroke. The stroke must lie on the
    ring's left. Of a ring with nodes only those count. The radius is ``snap``.
    """
    best, at = snap, None
    for ring in found:
        points = ring.points
        along = np.roll(points, -1, axis=0) - np.roll(points, 1, axis=0)
        inward = np.einsum("nc,nc->n", np.cross(along, direction), ring.normals)
        away = np.linalg.norm(points - point, axis=1)
        away[(inward <= 0.0) | (ring.normals @ normal <= 0.0)] = np.inf
        if ring.corner.any():
            away[~ring.corner] = np.inf
        k = int(np.argmin(away))
        if away[k] < best or (at is None and away[k] <= best):
            best, at = float(away[k]), (ring, k)
    return at


def _act(work: ToolWork, a: dict[str, Any]) -> Result:
    drawn = work.clean_stroke_here(a["points"], "the stroke", False)
    return work.keep_edit(
        join_loops(work.network, work.surface, work.state.sizes, drawn, a["division"], a["caps"])
    )


CYLINDER = Tool(
    "cylinder",
    "Join two closed loops by a row of patches.",
    {
        "points": POINTS,
        "division": Argument(
            Number(2, MOST, whole=True), "patches between loops without corners", DIVISION
        ),
        "caps": Argument(Word(CAPS), "patches beyond the loops", "auto"),
    },
    _act,
    position=40,
    snaps=True,
    control=Control("c", "cylinder", "draw from one closed loop to another", brush="snap"),
)
