"""Draft a surface part by part: what does not hang together has nothing to do with each other.

Eyes, buttons and laces lie close to bodies, or within them. Each part is a ground of its own, so
that no line goes over to another, and gets the setting that suits it; the networks of all parts
together are the draft.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from patterndb.geometry.points import Points, units
from patterndb_sketch.retopo.draft.judging import DraftJudge
from patterndb_sketch.retopo.draft.proposing import LaceError, ProposedDraft, propose_draft
from patterndb_sketch.retopo.errors import RefusedError
from patterndb_sketch.retopo.filling import fill_network
from patterndb_sketch.retopo.ground import Ground
from patterndb_sketch.retopo.network import Chain, Network
from patterndb_sketch.retopo.network.faces import GroundParts
from patterndb_sketch.retopo.sizes import Sizes
from patterndb_sketch.retopo.symmetry import Half
from query.engine import PatternSource

#: Of more parts all are drafted at once: each takes a tenth of a second by itself.
MOST_PARTS = 100

#: Drafts of a part with edges so many times as long are made, until one is sound: finer ones find
#: their way round what is small, coarser ones leave it out.
EDGES = (1.0, 0.75, 1.3)

#: A part with a thin handle gets edges that close around it, less this part, unless it would have
#: more quads than so many times what the whole surface has with edges as asked for.
CLOSING, MOST_QUADS = 0.9, 1.8

#: Borders of two parts may lie on each other, in opposite directions: where one runs counts as
#: much as being this part of a sampling away.
DIRECTED = 1.0


@dataclass(frozen=True, slots=True, eq=False)
class PartsDraft:
    """A draft of all parts, and what there is to say of how it came."""

    made: ProposedDraft
    notes: tuple[str, ...]


def propose_by_parts(
    network: Network,
    ground: Ground,
    sizes: Sizes,
    source: PatternSource,
    half: Half | None = None,
    edges: Sequence[float] = EDGES[:1],
) -> PartsDraft:
    """The best draft of every part; see :func:`propose_draft`, also for what is refused.

    edges: in target edges, that are tried in this order until a draft of the part is sound.
    Where curves are drawn, and where there are very many parts, all are drafted at once.
    """
    parts = GroundParts.of(ground)
    bare = all(chain.marked for chain in network.chains.values()) and not network.patches
    if not bare or not 1 < parts.parts <= MOST_PARTS:
        return _propose_by_edges(network, ground, sizes, source, half, edges, 1.0)
    told: list[str] = []
    total = float(ground.surface.areas.sum())
    own = share_chains(network, ground, parts, sizes.sampling)
    nodes, chains, patches = dict(network.nodes), dict(network.chains), dict(network.patches)
    next_id = network.next_id
    for k, (part, half_part) in enumerate(_list_parts(ground, parts, half)):
        mine = {c: chain for c, chain in network.chains.items() if own[c] == k}
        ends = {n for chain in mine.values() if not chain.loose for n in (chain.start, chain.end)}
        begun = replace(
            network,
            nodes={n: network.nodes[n] for n in sorted(ends)},
            chains=mine,
            next_id=next_id,
            ground=part,
        )
        share = float(part.surface.areas.sum()) / total
        one = _propose_by_edges(begun, part, sizes, source, half_part, edges, share)
        made = one.made
        told += one.notes
        for kept, now in ((chains, begun.chains), (nodes, begun.nodes)):
            for number in now:
                del kept[number]
        nodes |= made.network.nodes
        chains |= made.network.chains
        patches |= made.network.patches
        next_id = made.network.next_id
    together = replace(network, nodes=nodes, chains=chains, patches=patches, next_id=next_id)
    # As the editor will fill it: beside other parts, some places may be seen otherwise.
    found = fill_network(together, ground, source, sizes.edge)
    whole = ProposedDraft.of(found, DraftJudge(ground, half))
    return PartsDraft(whole, tuple(told))


def _propose_by_edges(
    network: Network,
    ground: Ground,
    sizes: Sizes,
    source: PatternSource,
    half: Half | None,
    edges: Sequence[float],
    share: float,
) -> PartsDraft:
    """The first draft that is sound, with edges of several lengths, or the best.

    share: of the part in the whole surface's area."""
    best: PartsDraft | None = None
    why: RefusedError | None = None
    left = list(edges)
    while left:
        times = left.pop(0)
        tried = replace(sizes, edge=times * sizes.edge)
        try:
            made = propose_draft(network, ground, tried, source, half)
        except RefusedError as error:
            if why is None and isinstance(error, LaceError):
                finer = CLOSING * error.edge / sizes.edge
                if share <= MOST_QUADS * finer**2:
                    left = [finer]
            why = error if why is None else why
            continue
        if best is None or made.rank < best.made.rank:
            told: tuple[str, ...] = ()
            if times != edges[0]:
                flaws = str(why) if best is None else f"there would be {'; '.join(best.made.flaws)}"
                told = (f"edges are {times:.2g} times as long as asked for: else {flaws}",)
            best = PartsDraft(made, told)
        if made.sound:
            break
    if best is None:
        assert why is not None
        raise why
    return best


def _list_parts(
    ground: Ground, parts: GroundParts, half: Half | None
) -> Iterator[tuple[Ground, Half | None]]:
    """Every part as a ground, and as a half of the parts that it is of, if the ground is one."""
    whole = None if half is None else GroundParts.of(half.whole)
    for k in range(parts.parts):
        part, vertices = take_triangles(ground, parts.part == k)
        if half is None or whole is None:
            yield part, None
            continue
        own = ground.vertices[vertices]
        near = {
            int(np.bincount(whole.part[half.whole.nearest(at).triangles]).argmax())
            for at in (own, half.plane.mirror(own))
        }
        both, _ = take_triangles(half.whole, np.isin(whole.part, sorted(near)))
        on = np.zeros(len(part.vertices), np.bool_)
        on[part.vertex] = half.on[vertices]
        yield part, replace(half, ground=part, whole=both, on=on)


def take_triangles(
    ground: Ground, which: NDArray[np.bool_]
) -> tuple[Ground, NDArray[np.signedinteger]]:
    """A ground of some triangles (t,) of a ground, with its normals and its diagonal, which all
    sizes are parts of; and the vertices (v,) of the ground that its own are of."""
    vertices, corners = np.unique(ground.triangles[which], return_inverse=True)
    part = Ground.of(ground.vertices[vertices], corners.reshape(-1, 3))
    normals = np.empty_like(part.normals)
    normals[part.vertex] = ground.normals[vertices]
    surface = replace(part.surface, normals=normals)
    return replace(part, surface=surface, diagonal=ground.diagonal), vertices


def share_chains(
    network: Network, ground: Ground, parts: GroundParts, sampling: float
) -> dict[int, int]:
    """The part of every chain of a network of borders and seams."""
    border = ground.topology.border
    tail = ground.vertices[ground.triangles.ravel()[border]]
    head = ground.vertices[ground.triangles[border // 3, (border % 3 + 1) % 3]]
    if not len(border):
        return {}
    steps = np.maximum(np.ceil(np.linalg.norm(head - tail, axis=1) / sampling), 1).astype(int)
    side = np.repeat(np.arange(len(border)), steps)
    share = np.concatenate([(np.arange(n) + 0.5) / n for n in steps.tolist()])[:, None]
    weight = DIRECTED * sampling
    places = tail[side] + share * (head - tail)[side]
    tree = KDTree(np.concatenate([places, weight * units(head - tail)[side]], axis=1))
    found: dict[int, int] = {}
    for number, chain in network.chains.items():
        points, ahead = _take_steps(chain)
        _, nearest = tree.query(np.concatenate([points, weight * ahead], axis=1))
        part = parts.part[border[side[nearest]] // 3]
        found[number] = int(np.bincount(part).argmax())
    return found


def _take_steps(chain: Chain) -> tuple[Points, Points]:
    """(n, 3) the middles of a marked chain's steps, and (n, 3) where they lead with the surface on
    their left."""
    line = np.concatenate([chain.points, chain.points[:1]]) if chain.loose else chain.points
    ahead = units(np.diff(line, axis=0))
    return 0.5 * (line[1:] + line[:-1]), ahead if chain.marks[0] == "" else -ahead
