"""The cylinder tool.

Source: sketch-based quad meshes paper, section 4 and Fig. 6.
"""

from __future__ import annotations

from patterndb.geometry.points import Points
from patterndb_sketch.retopo.errors import InvalidRetopoError, RefusedError
from patterndb_sketch.retopo.ground import Ground, Stroke, geodesic
from patterndb_sketch.retopo.network import AtNode, Draft, Edit, Network
from patterndb_sketch.retopo.network.stops import Nearness
from patterndb_sketch.retopo.network.weaving import weave
from patterndb_sketch.retopo.sizes import Sizes
from patterndb_sketch.retopo.tools.cylinder.caps import CAPS, Caps, flag_beyond, wants_cap
from patterndb_sketch.retopo.tools.cylinder.pairing import paired
from patterndb_sketch.retopo.tools.cylinder.rings import Ring, ring_at, rings
from patterndb_sketch.retopo.tools.stroke import NODE_NEAR, dragged

#: Patches between two loops without corners, unless told. Source: the released program of
#: Takayama et al. 2013.
DIVISION = 4

#: The most: a patch for every few samples of a loop.
MOST = 64

CROSS = (
    "two of the curves between the loops would cross, or one would cross a curve that is there; "
    "draw the stroke elsewhere, or erase what is in the way"
)


def cylinder(
    network: Network,
    ground: Ground,
    sizes: Sizes,
    stroke: Stroke,
    division: int = DIVISION,
    caps: Caps = "auto",
) -> Edit:
    """The network with a row of patches between two closed loops that a stroke joins.

    Its ends snap to the loops, of loops with corners to one. Corner goes to corner; from a loop
    with corners to one without, to the points at the same parts of the way round; between
    loops without, ``division`` (2 to 64) pairs of points divide both evenly. The stroke is one
    of the curves between, the others are shortest paths.
    caps: "auto" for patches beyond the loops too, where these enclose an end of the surface;
    "always", or "never". Where the other side already has curves there is none.

    Raises RefusedError, and nothing changes, for an end at no loop, both at one, numbers of
    corners that do not agree, and curves that would cross.
    """
    if not 2 <= division <= MOST:
        raise InvalidRetopoError(f"a division into {division}; give 2 to {MOST}")
    if caps not in CAPS:
        raise InvalidRetopoError(f"caps is {caps!r}; there are {', '.join(CAPS)}")
    draft = Draft(network, ground)
    one, other = _ends(network, stroke, sizes.snap)
    pairs = paired(one, other, division)
    capped = [ring for ring, _ in (one, other) if wants_cap(draft.before, ring, caps)]
    nodes = [
        [_node(draft, network, ring, pair[k]) for pair in pairs]
        for k, (ring, _) in enumerate((one, other))
    ]
    if any(len(set(found)) < len(found) for found in nodes):
        raise RefusedError("two of the curves would begin in one place; divide into fewer")
    joins = [
        _join(draft, ground, sizes, a, b, stroke if k == 0 else None)
        for k, (a, b) in enumerate(zip(*nodes, strict=True))
    ]
    also = [2 * chain for chain in joins]
    for k, (ring, _) in enumerate((one, other)):
        if ring in capped:
            beyond = [
                flag_beyond(draft, node, 2 * chain + k)
                for node, chain in zip(nodes[k], joins, strict=True)
            ]
            also += beyond[:1]
    try:
        after = draft.finished(also=also)
    except InvalidRetopoError as error:
        raise RefusedError(f"the loops would not close to patches: {error}") from error
    return Edit.of(network, after, draft.notes)


def _ends(
    network: Network, stroke: Stroke, snap: float
) -> tuple[tuple[Ring, int], tuple[Ring, int]]:
    """The rings that the stroke joins, with the vertices it snaps to."""
    if stroke.closed:
        raise RefusedError("this stroke is closed; draw one from loop to loop")
    found = rings(network)
    line, up = stroke.points, stroke.normals
    # The direction over a few samples: the first ones may run along the loop.
    ahead = min(len(line) - 1, 4)
    one, other = (
        _snapped(found, line[end], up[end], line[end + step] - line[end], snap, name)
        for end, step, name in ((0, ahead, "start"), (-1, -ahead, "end"))
    )
    if one[0] is other[0] or set(one[0].edge.halves) == set(other[0].edge.halves):
        raise RefusedError("the stroke begins and ends at one loop; draw it to another")
    return one, other


def _snapped(
    found: list[Ring], point: Points, normal: Points, direction: Points, snap: float, name: str
) -> tuple[Ring, int]:
    at = ring_at(found, point, normal, direction, snap)
    if at is None:
        raise RefusedError(
            f"there is no closed loop, empty towards the stroke, at its {name}; on a loop "
            "with corners it must begin and end at one of them"
        )
    return at


def _node(draft: Draft, network: Network, ring: Ring, place: float) -> int:
    end = ring.edge.end(network, place)
    return end.node if isinstance(end, AtNode) else draft.cut_chain(end.chain, end.place)


def _join(
    draft: Draft, ground: Ground, sizes: Sizes, one: int, other: int, stroke: Stroke | None
) -> int:
    """The chain from node to node: the stroke, or the shortest path; it must cross nothing."""
    ends = AtNode(one), AtNode(other)

    def project(points: Points, normals: Points) -> tuple[Points, Points]:
        done = ground.project_near(points, normals, sizes)
        return done.points, done.normals

    if stroke is None:
        a, b = draft.nodes[one], draft.nodes[other]
        feet = [ground.nearest_facing(n.point[None], n.normal[None]).feet for n in (a, b)]
        stroke = geodesic(ground, feet[0], feet[1]).sampled(ground, sizes.sampling)
    line, up = dragged(stroke.points, stroke.normals, draft, list(ends), project)
    near = Nearness(min(NODE_NEAR * sizes.sampling, 0.25 * sizes.snap), (0.0, 0.0))
    made = weave(draft, line, up, *ends, near, project)
    if len(made) != 1:
        raise RefusedError(CROSS)
    return made[0]
