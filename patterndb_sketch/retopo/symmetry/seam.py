"""Begin symmetry: cut a network by the plane, and lay the seam along it.

The seam is the curves in which the plane cuts the surface, as marked chains of the network.
:func:`cut_at_plane` drops what lies beyond the plane; :func:`begin_symmetry` does it all.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from patterndb._native.retopo.network.attaching import find_departure, measure_turn
from patterndb.geometry.points import Points, units
from patterndb_sketch.retopo.errors import RefusedError
from patterndb_sketch.retopo.network import (
    BORDER,
    NONE,
    SYMMETRY,
    AtNode,
    Chain,
    Edit,
    Gap,
    HalfChain,
    Network,
    NetworkBuilder,
)
from patterndb_sketch.retopo.network.attaching import measure_reach
from patterndb_sketch.retopo.network.samples import (
    Samples,
    find_nearest_place,
    interpolate_places,
    take_chain_samples,
)
from patterndb_sketch.retopo.symmetry.half import (
    Half,
    SeamRun,
    find_plane_crossings,
    measure_heights,
)
from patterndb_sketch.retopo.symmetry.images import mirror_density

#: A node on the plane is on the seam if it is this near to it, in samplings: its curve's samples
#: are on the surface, what is between them a little off.
NEAR_SEAM = 2.0

#: A node this near to the end of the seam at a border, in samples, is there.
AT_END = 1e-6


def begin_symmetry(network: Network, half: Half, sampling: float) -> Edit:
    """The network on half of the surface: the cut is there as chains marked SYMMETRY.

    Curves that cross the plane are cut there, and what is beyond it goes, which is told; what
    lies in the plane becomes the seam. All other chains, nodes and patches are as they were.
    Density painted on either side holds on both.
    sampling: greatest distance of neighbouring samples of the seam.

    Raises RefusedError if the network has a seam already, and where two curves cross the plane
    at one place without meeting. Source: Takayama et al. 2013, whose program drops all curves.
    """
    if any(SYMMETRY in chain.marks for chain in network.chains.values()):
        raise RefusedError("symmetry is on already; switch it off before you take another plane")
    builder = NetworkBuilder(network)
    parting = cut_at_plane(builder, half)
    level = [builder.chains[chain] for chain in parting.level]
    # Nodes that have nothing but what lies in the plane are none of the seam.
    joined = [
        node
        for node in find_nodes_on_plane(builder, half)
        if any(end >> 1 not in parting.level for end in builder.nodes[node].ends)
    ]
    lines = [_sample_run(half, run, sampling) for run in half.seams()]
    places = _place_nodes(builder, joined, lines, NEAR_SEAM * sampling, half.near)
    kept: set[int] = set()
    for k, line in enumerate(lines):
        kept |= _add_line(builder, half, line, places[k], level)
    for chain in level:
        if chain.id not in kept:
            builder.remove_chain(chain.id)
    for node in {node for at in places for _, node in at}:
        if node in builder.nodes and builder.nodes[node].valence > 1:
            builder.flag(_order_from_outside(builder, half, node)[-1], False)
    after = builder.finish()
    # A patch beyond, all of whose curves have become the seam, is left.
    inside = {
        patch: one
        for patch, one in after.patches.items()
        if not any(after.mark(end) for end in one.loop)
    }
    density = mirror_density(network.density, half.plane)
    after = replace(after, patches=inside, density=density)
    return Edit.of(network, after, _note_changes(half, parting.beyond, parting.cut, len(lines)))


def _note_changes(half: Half, beyond: int, cut: int, seams: int) -> list[str]:
    notes: list[str] = []
    if beyond:
        notes.append(
            f"{beyond} curves on the other side of the plane are gone: undo has them back, and "
            "the plane with its normal turned round keeps them instead"
        )
    if cut:
        notes.append(f"{cut} curves are cut at the plane")
    if half.in_plane:
        notes.append(f"{half.in_plane} triangles that lie in the plane are left out")
    if not seams:
        notes.append("the plane does not cut the surface: its image lies apart")
    return notes


@dataclass(frozen=True, slots=True, eq=False)
class SeamLine:
    """Samples along the seam, the half surface on the left, with a view of them to search."""

    chain: Chain
    of: Samples

    @property
    def closed(self) -> bool:
        return self.chain.is_closed_loop


def _sample_run(half: Half, run: SeamRun, sampling: float) -> SeamLine:
    """(n, 3) samples of a run, its vertices among them."""
    corners, up = half.surface.vertices[run.vertices], half.surface.normals[run.vertices]
    ends = np.roll(corners, -1, axis=0), np.roll(up, -1, axis=0)
    n = len(corners) if run.closed else len(corners) - 1
    lengths = np.linalg.norm(ends[0] - corners, axis=1)[:n]
    parts = [max(1, math.ceil(length / sampling)) for length in lengths]
    edge = np.repeat(np.arange(n), parts)
    share = np.concatenate([np.arange(k) / k for k in parts])[:, None]
    points = (1.0 - share) * corners[edge] + share * ends[0][edge]
    normals = units((1.0 - share) * up[edge] + share * ends[1][edge])
    if not run.closed:
        points = np.concatenate([points, corners[-1:]])
        normals = np.concatenate([normals, up[-1:]])
    ends_at = NONE if run.closed else 0
    chain = Chain(0, ends_at, ends_at, half.plane.flatten(points), normals)
    return SeamLine(chain, take_chain_samples({0: chain}))


def _place_nodes(
    builder: NetworkBuilder, nodes: list[int], lines: list[SeamLine], reach: float, near: float
) -> list[list[tuple[float, int]]]:
    """For every line of the seam the places and nodes of a network that are on it, in order.

    reach: how far a node may be off; it is moved there unless it is ``near``. An open line has
    nodes at its ends.
    """
    found: list[list[tuple[float, int]]] = [[] for _ in lines]
    for node in nodes:
        at = builder.nodes[node]
        close = [
            (place.distance, k, place.place)
            for k, line in enumerate(lines)
            if (place := find_nearest_place(line.of, at.point, at.normal, reach)) is not None
        ]
        if not close:
            continue
        off, k, place = min(close)
        line = lines[k].chain
        last = len(line.points) - 1
        if lines[k].closed:
            place = place % (last + 1)
        elif min(place, last - place) <= AT_END:
            place = float(round(place))
        if off > near:
            points, normals = interpolate_places(line.points, line.normals, np.array([place]))
            builder.move_node(node, points[0], normals[0])
        found[k].append((place, node))
    for line, places in zip(lines, found, strict=True):
        places.sort()
        if line.closed:
            continue
        for place in (0, len(line.chain.points) - 1):
            if all(there != place for there, _ in places):
                point, normal = line.chain.points[place], line.chain.normals[place]
                places.append((float(place), builder.add_node(point, normal)))
        places.sort()
    return found


def _add_line(
    builder: NetworkBuilder,
    half: Half,
    line: SeamLine,
    places: list[tuple[float, int]],
    level: list[Chain],
) -> set[int]:
    """Add a line of the seam to a network, from node to node; the chains of ``level`` that
    are in its place already stay, and are marked. Returns their ids."""
    points, normals = line.chain.points, line.chain.normals
    marks = ("", SYMMETRY)
    if not places:
        for chain in level:
            if chain.is_closed_loop and is_alongside(chain, points):
                return {_mark_side(builder, chain, points)}
        builder.add_loop(points, normals, marks=marks)
        return set()
    kept: set[int] = set()
    n = len(points)
    ends = [*places[1:], (places[0][0] + n, places[0][1])] if line.closed else places[1:]
    for (begin, one), (finish, two) in zip(places, ends, strict=False):
        if finish - begin <= AT_END:
            x, y, z = builder.nodes[one].point.tolist()
            raise RefusedError(
                f"two curves cross the plane at one place, ({x:.6g}, {y:.6g}, {z:.6g}), and do "
                "not meet there; move or erase one of them"
            )
        inner = np.arange(math.floor(begin + AT_END) + 1, math.ceil(finish - AT_END))
        at = np.concatenate([[begin], inner, [finish]])
        piece, up = interpolate_places(points, normals, at)
        same = [
            chain
            for chain in level
            if {chain.start, chain.end} == {one, two} and is_alongside(chain, piece)
        ]
        if same:
            kept.add(_mark_side(builder, same[0], piece))
            continue
        gaps = _find_gap(builder, half, one, True), _find_gap(builder, half, two, False)
        builder.add_chain(piece, up, AtNode(one), AtNode(two), marks=marks, gaps=gaps)
    return kept


def _mark_side(builder: NetworkBuilder, chain: Chain, line: Points) -> int:
    """Mark the side of a chain that is on the right of a polyline (n, 3) beside it."""
    # A piece of two points begins at its first.
    k = min(len(line) // 2, len(line) - 2)
    ahead = line[k + 1] - line[k]
    near = int(np.argmin(np.linalg.norm(chain.points - line[k], axis=1)))
    m = len(chain.points)
    one, two = (near, (near + 1) % m) if chain.is_closed_loop or near + 1 < m else (near - 1, near)
    along = float((chain.points[two] - chain.points[one]) @ ahead) > 0.0
    marks = ("", SYMMETRY) if along else (SYMMETRY, "")
    builder.chains[chain.id] = replace(builder.chains[chain.id], marks=marks)
    return chain.id


def _find_gap(builder: NetworkBuilder, half: Half, node: int, leaving: bool) -> Gap | None:
    """Where at a node the seam goes: it leaves before all curves of the half, counter-clockwise
    from the outside, and arrives after them."""
    if not builder.nodes[node].ends:
        return None
    ends = _order_from_outside(builder, half, node)
    return Gap(ends[0], False) if leaving else Gap(ends[-1], True)


def _order_from_outside(builder: NetworkBuilder, half: Half, node: int) -> tuple[HalfChain, ...]:
    """The ends of a node on the plane, counter-clockwise from the direction out of the half."""
    at = builder.nodes[node]
    outward = -np.array(half.plane.normal)
    turns: list[float] = []
    for end in at.ends:
        chain = builder.chains[end >> 1]
        reach = measure_reach([chain])
        turns.append(
            measure_turn(at.normal, outward, find_departure(chain.points, bool(end & 1), reach))
        )
    first = int(np.argmin(turns))
    return at.ends[first:] + at.ends[:first]


@dataclass(frozen=True, slots=True, eq=False)
class Parting:
    """What became of a network's chains.

    level: chains that lie in the plane, as they are now. beyond: how many curves lay beyond the
    plane as a whole, and are gone; borders of the surface do not count. cut: how many were cut.
    """

    level: tuple[int, ...]
    beyond: int
    cut: int


def cut_at_plane(builder: NetworkBuilder, half: Half) -> Parting:
    """Cut the chains of a network where they cross the plane, and drop what lies beyond it.

    Chains in the plane stay, for the caller to use or drop.
    """
    level: list[int] = []
    beyond, cut = 0, 0
    for chain in sorted(builder.chains):
        old = builder.chains[chain]
        height = measure_heights(half, old.points)
        if not height.any():
            level.append(chain)
            continue
        if not (height > 0.0).any():
            builder.remove_chain(chain)
            beyond += BORDER not in old.marks
            continue
        places = find_plane_crossings(height, old.is_closed_loop)
        for place in places:
            points, normals = interpolate_places(old.points, old.normals, np.array([place]))
            known = set(builder.nodes)
            node = builder.cut_chain(chain, place, (half.plane.flatten(points)[0], normals[0]))
            point, normal = builder.nodes[node].point, builder.nodes[node].normal
            if node in known and measure_heights(half, point[None]).any():
                # A crossing so near to an end is the end, which may lie a little off.
                builder.move_node(node, half.plane.flatten(point[None])[0], normal)
        cut += bool(places) and BORDER not in old.marks
        for piece in sorted(builder.pieces([chain])):
            there = measure_heights(half, builder.chains[piece].points)
            if not there.any():
                level.append(piece)
            elif there.sum() < 0.0:
                builder.remove_chain(piece)
    return Parting(tuple(level), beyond, cut)


def find_nodes_on_plane(builder: NetworkBuilder, half: Half) -> list[int]:
    """The nodes of a network that are on the plane."""
    ids = sorted(node for node, at in builder.nodes.items() if at.ends)
    if not ids:
        return []
    points: Points = np.array([builder.nodes[node].point for node in ids])
    return [
        node
        for node, h in zip(ids, measure_heights(half, points).tolist(), strict=True)
        if h == 0.0
    ]


def is_alongside(one: Chain, line: Points) -> bool:
    """Does a chain run as a polyline (n, 3) between the same places does, seen at its middle?"""
    middle, there = one.points[len(one.points) // 2], line[len(line) // 2]
    step = float(np.linalg.norm(np.diff(line, axis=0), axis=1).max()) if len(line) > 1 else 0.0
    gaps = np.linalg.norm(line - middle, axis=1)
    back = np.linalg.norm(one.points - there, axis=1)
    return bool(gaps.min() <= step and back.min() <= step)
