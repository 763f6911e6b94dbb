"""Draft a surface part by part: parts that do not hang together do not affect each other.

Eyes, buttons and laces lie close to bodies, or within them. Each part is a surface of its own, so
that no line goes over to another, and gets the setting that suits it; the networks of all parts
together are the draft.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from patterndb.geometry.points import Points, units
from patterndb.geometry.surface import Surface
from patterndb.system.progress import report_progress
from patterndb_sketch.retopo.draft.judging import WRONG, Draft, DraftJudge
from patterndb_sketch.retopo.draft.proposing import propose_by_creases
from patterndb_sketch.retopo.draft.settings import SETTINGS
from patterndb_sketch.retopo.draft.task import DraftTask
from patterndb_sketch.retopo.errors import RefusedError
from patterndb_sketch.retopo.filling import FilledNetwork, PlacedPatch, fill_network, filling_of
from patterndb_sketch.retopo.network import Chain, Network, set_choice
from patterndb_sketch.retopo.network.faces import SurfaceParts, find_joined_chains
from patterndb_sketch.retopo.symmetry import Half
from patterndb_sketch.retopo.wording import format_place
from query.engine import PatternSource

#: What is nearer than this part of the diagonal is at the same place: more than rounding, less
#: than the flat parts of an edge.
SAME_PLACE = 1e-9


#: Borders of two parts may lie on each other, in opposite directions: where one runs counts as
#: much as being this part of a sampling away.
DIRECTED = 1.0


def propose_by_parts(
    task: DraftTask, edges: Sequence[float] = SETTINGS.edges[:1], *, strict: bool = True
) -> Draft:
    """Propose the best draft of every part; see :func:`propose_draft`, also for what is refused.

    edges: in target edges, that are tried in this order until a draft of the part is sound.
    strict: is all refused where a part is? Else that part is left open, and named in the notes; the
    draft of a part that is not sound is kept then, with its flaws. Of each part as many creases are
    kept as go: all, closed ones, none.
    Where curves are drawn, and where there are very many parts, all are drafted at once.
    """
    with report_progress("drafting" if task.half is None else "drafting one half") as progress:
        parts = SurfaceParts.of(task.surface)
        network = task.network
        bare = all(chain.marked for chain in network.chains.values()) and not network.patches
        if not bare or not 1 < parts.parts <= SETTINGS.most_parts:
            return propose_by_creases(task, edges, 1.0, progress)
        return _propose_all(task, parts, edges, strict, progress)


def _propose_all(
    task: DraftTask,
    parts: SurfaceParts,
    edges: Sequence[float],
    strict: bool,
    progress: Callable[[float], None],
) -> Draft:
    network, surface, half = task.network, task.surface, task.half
    notes: list[str] = []
    alone: dict[int, PlacedPatch] = {}
    done, creased = 0.0, True
    total = float(surface.areas.sum())
    own = share_chains(network, surface, parts, task.sizes.sampling)
    nodes, chains, patches = dict(network.nodes), dict(network.chains), dict(network.patches)
    next_id = network.next_id
    for k, (part, half_part) in enumerate(_list_parts(surface, parts, half)):
        mine = {c: chain for c, chain in network.chains.items() if own[c] == k}
        ends = {
            n
            for chain in mine.values()
            if not chain.is_closed_loop
            for n in (chain.start, chain.end)
        }
        begun = replace(
            network,
            nodes={n: network.nodes[n] for n in sorted(ends)},
            chains=mine,
            next_id=next_id,
            surface=part,
        )
        share = float(part.areas.sum()) / total
        progress(done)
        done += share
        try:
            of_part = replace(task, network=begun, surface=part, half=half_part)
            one = propose_by_creases(of_part, edges, share)
        except RefusedError as error:
            if strict:
                raise
            middle = part.vertices[part.triangles].mean(axis=(0, 1))
            notes.append(f"the part around {format_place(middle)} is left open: {error}")
            # The other parts are still to be tried.
            task.budget.left = max(task.budget.left, SETTINGS.work_left)
            continue
        notes += one.notes
        creased = creased and one.creased
        if (
            strict
            and not one.sound
            and not _may_be_covered(one, part, half_part, surface, parts.part == k)
        ):
            # With it nothing is sound, whatever the other parts come to.
            return replace(one, notes=tuple(notes), creased=creased)
        alone |= one.found.placed
        for kept, now in ((chains, begun.chains), (nodes, begun.nodes)):
            for number in now:
                del kept[number]
        nodes |= one.network.nodes
        chains |= one.network.chains
        patches |= one.network.patches
        next_id = one.network.next_id
    if not patches:
        raise RefusedError("no part of the surface could be drafted: " + "; ".join(notes))
    together = replace(network, nodes=nodes, chains=chains, patches=patches, next_id=next_id)
    # As the editor will fill it.
    found = fill_as_placed(together, surface, task.source, task.sizes.edge, alone)
    judge = DraftJudge(surface, half, task.goal.allow_off(surface))
    return replace(Draft.of(found, judge, tuple(notes)), creased=creased)


def fill_as_placed(
    network: Network,
    surface: Surface,
    source: PatternSource,
    edge: float,
    placed: Mapping[int, PlacedPatch],
) -> FilledNetwork:
    """The filled network of a surface of which patches were placed on another, such as a part of
    it: those that would be placed elsewhere, since other parts are nearer, hold all their
    vertices."""
    found = fill_network(network, surface, source, edge)
    network = found.network
    for patch, former in placed.items():
        now = found.placed.get(patch)
        if now is not None and now.vertices.shape == former.vertices.shape:
            off = np.linalg.norm(now.vertices - former.vertices, axis=1).max()
            if off <= SAME_PLACE * surface.diagonal:
                continue
        filling = filling_of(network.patches[patch])
        if filling.choice is None or filling.choice.n_vertices != len(former.vertices):
            continue
        held = filling.with_moved(np.arange(len(former.vertices)), former.vertices)
        network = set_choice(network, patch, held)
    if network is found.network:
        return found
    return fill_network(network, surface, source, edge)


def _may_be_covered(
    made: Draft, part: Surface, half: Half | None, surface: Surface, own: NDArray[np.bool_]
) -> bool:
    """Is all that is wrong with a draft of a part that it is off, where other parts are near?
    Then the draft of all may be near enough."""
    if any(made.rank[: WRONG - 1]):
        return False
    furthest = DraftJudge(part, half).find_furthest(made.found)
    others, _ = take_triangles(surface, ~own)
    at = furthest[None]
    if half is not None:
        at = np.concatenate([at, half.plane.mirror(at)])
    off = np.linalg.norm(others.nearest(at).points - at, axis=1).min()
    return bool(off <= SETTINGS.most_off * surface.diagonal)


def _list_parts(
    surface: Surface, parts: SurfaceParts, half: Half | None
) -> Iterator[tuple[Surface, Half | None]]:
    """Every part as a surface, and as a half of the parts that it is of, if the surface is one."""
    whole = None if half is None else SurfaceParts.of(half.whole)
    for k in range(parts.parts):
        part, vertices = take_triangles(surface, parts.part == k)
        if half is None or whole is None:
            yield part, None
            continue
        # By the middles of triangles, and by where these face: vertices may lie on other parts.
        corners = part.vertices[part.triangles]
        own = corners.mean(axis=1)
        up = units(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]))
        images = half.plane.mirror(own), half.plane.mirror_directions(up)
        near: set[int] = set()
        for at, facing in ((own, up), images):
            feet = half.whole.nearest_facing(at, facing)
            # What is on one side alone has no image, and is near to nothing beyond.
            there = np.linalg.norm(feet.points - at, axis=1) <= SETTINGS.most_off * surface.diagonal
            if there.any():
                near.add(int(np.bincount(whole.part[feet.triangles[there]]).argmax()))
        both, _ = take_triangles(half.whole, np.isin(whole.part, sorted(near)))
        on = np.zeros(len(part.vertices), np.bool_)
        on[part.repairs.vertex] = half.on[vertices]
        yield part, replace(half, surface=part, whole=both, on=on)


def take_triangles(
    surface: Surface, which: NDArray[np.bool_]
) -> tuple[Surface, NDArray[np.signedinteger]]:
    """A surface of some triangles (t,) of a surface, with its normals and its diagonal, which all
    sizes are parts of; and the vertices (v,) of the surface that its own are of."""
    vertices, corners = np.unique(surface.triangles[which], return_inverse=True)
    part = Surface.from_arrays(surface.vertices[vertices], corners.reshape(-1, 3)).orient()
    normals = np.empty_like(part.normals)
    normals[part.repairs.vertex] = surface.normals[vertices]
    return part.inherit(normals, surface.diagonal), vertices


def share_chains(
    network: Network, surface: Surface, parts: SurfaceParts, sampling: float
) -> dict[int, int]:
    """The part of every chain of a network of borders and seams; chains that meet are of one."""
    border = surface.adjacency.border
    tail = surface.vertices[surface.triangles.ravel()[border]]
    head = surface.vertices[surface.triangles[border // 3, (border % 3 + 1) % 3]]
    if not len(border):
        return {}
    steps = np.maximum(np.ceil(np.linalg.norm(head - tail, axis=1) / sampling), 1).astype(int)
    side = np.repeat(np.arange(len(border)), steps)
    share = np.concatenate([(np.arange(n) + 0.5) / n for n in steps.tolist()])[:, None]
    weight = DIRECTED * sampling
    places = tail[side] + share * (head - tail)[side]
    tree = KDTree(np.concatenate([places, weight * units(head - tail)[side]], axis=1))
    found: dict[int, int] = {}
    left = set(network.chains)
    while left:
        joined = find_joined_chains(network.nodes, network.chains, min(left))
        votes = np.zeros(parts.parts, np.int64)
        for number in sorted(joined):
            points, ahead = _take_steps(network.chains[number])
            _, nearest = tree.query(np.concatenate([points, weight * ahead], axis=1))
            part = parts.part[border[side[nearest]] // 3]
            votes += np.bincount(part, minlength=parts.parts)
        found |= dict.fromkeys(joined, int(votes.argmax()))
        left -= joined
    return found


def _take_steps(chain: Chain) -> tuple[Points, Points]:
    """(n, 3) the middles of a marked chain's steps, and (n, 3) where they lead with the surface on
    their left."""
    line = (
        np.concatenate([chain.points, chain.points[:1]]) if chain.is_closed_loop else chain.points
    )
    ahead = units(np.diff(line, axis=0))
    return 0.5 * (line[1:] + line[:-1]), ahead if chain.marks[0] == "" else -ahead
