"""Previews: what a call of a tool would make, without its being done.

:func:`preview_call` takes the same call that the editor would obey. Some tools have a preview of
their own (:data:`CURVE_PREVIEWS`, and that of ``insertloop``); for all others the call is done on
the side, and the quads that would differ are the preview.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial import KDTree

from patterndb.core.halfedge import Int32Array
from patterndb.errors import PatternDBError
from patterndb.geometry.points import Points
from patterndb.geometry.strips import trace_strip
from patterndb_sketch.retopo.arguments import read_arguments
from patterndb_sketch.retopo.editor import Call
from patterndb_sketch.retopo.filling import RetopoMesh
from patterndb_sketch.retopo.filling.fills import fill_patch
from patterndb_sketch.retopo.filling.location import find_patch
from patterndb_sketch.retopo.filling.placing import divide_chain
from patterndb_sketch.retopo.network import Network, find_nearest_place, take_samples
from patterndb_sketch.retopo.table import TOOLS
from patterndb_sketch.retopo.tool import SNAP, ToolWork
from patterndb_sketch.retopo.tools.autocomplete import find_completions
from patterndb_sketch.retopo.tools.insertloop import find_edge_at
from patterndb_sketch.retopo.tools.loop import preview_loop
from patterndb_sketch.retopo.tools.pull import find_held, pull_held
from patterndb_sketch.retopo.tools.spine import preview_spine

#: A vertex is where it was if it moves by less than this part of the surface's diagonal: placing
#: a patch again gives the same within rounding, and less is not seen.
STILL = 1e-4


@dataclass(frozen=True, slots=True, eq=False)
class Preview:
    """What a call would make.

    network: that it was found for. curves: (m, 3) each. corners: (k, 3). number, count: it is this
    one of so many. refused: why there is none, "" if there is one. quads: (q, 4, 3) that would be
    other ones.
    """

    network: Network
    curves: tuple[Points, ...] = ()
    corners: Points | None = None
    number: int = 0
    count: int = 0
    refused: str = ""
    quads: Points | None = None


def preview_call(work: ToolWork, mesh: RetopoMesh, call: Call) -> Preview:
    """Preview a call on a state whose quads are those of a mesh; nothing is changed.

    Raises InvalidRetopoError for a tool or arguments that do not exist.
    """
    tool = TOOLS[call.tool]
    arguments = read_arguments(call.tool, tool.arguments, call.arguments)
    state, snap = work.state, arguments.pop(SNAP, None)
    if snap is not None:
        work = replace(work, state=replace(state, sizes=replace(state.sizes, snap=snap)))
    try:
        if call.tool in CURVE_PREVIEWS:
            made = CURVE_PREVIEWS[call.tool](work, arguments)
        elif call.tool == "insertloop":
            made = _preview_inserted_loop(work, mesh, arguments)
        else:
            made = _preview_quads(work, mesh, call)
    except PatternDBError as error:
        return Preview(state.network, refused=str(error))
    return replace(made, network=state.network)


def _preview_completion(work: ToolWork, a: dict[str, Any]) -> Preview:
    """Preview a patch that could be completed around a point; its choice is the last if there are
    not so many."""
    foot, sizes = work.find_foot(a["at"]), work.state.sizes
    if a["radius"] is not None:
        sizes = replace(sizes, autocompletion=a["radius"])
    found = find_completions(work.network, work.surface, foot.points[0], foot.normals[0], sizes)
    if not found:
        return Preview(work.network)
    number = min(a["choice"], len(found) - 1)
    one = found[number]
    return Preview(work.network, tuple(one.curves(sizes)), one.corners(), number, len(found))


def _preview_spine(work: ToolWork, a: dict[str, Any]) -> Preview:
    """Preview the outline of the patch about a line."""
    sizes = work.state.sizes
    if a["width"] is not None:
        sizes = replace(sizes, spine=a["width"] / 2.0)
    stroke = work.clean_stroke_here(a["points"], "the spine", False)
    found = preview_spine(work.network, work.surface, stroke, sizes)
    return Preview(work.network, tuple(found.curves(sizes)))


def _preview_cut(work: ToolWork, a: dict[str, Any]) -> Preview:
    """Preview the curve in which a plane cuts the surface."""
    start = work.find_foot(a["at"])
    stroke = preview_loop(work.surface, work.state.sizes, start, a["normal"], a["limit"])
    line = stroke.points
    return Preview(work.network, (np.concatenate([line, line[:1]]) if stroke.closed else line,))


def _preview_pull(work: ToolWork, a: dict[str, Any]) -> Preview:
    """Preview the curves that follow when what is at one point is pulled to another."""
    network, sizes = work.network, work.state.sizes
    start, end = work.find_foot(a["at"]), work.find_foot(a["to"])
    at = find_held(network, sizes, start.points[0], start.normals[0])
    made = pull_held(network, work.surface, sizes, at, end.points[0], end.normals[0]).network
    moved = [c.round for k, c in made.chains.items() if network.chains.get(k) is not c]
    return Preview(network, tuple(moved))


#: Previews of tools whose curves are shown alone, by the tools' names.
CURVE_PREVIEWS: Mapping[str, Callable[[ToolWork, dict[str, Any]], Preview]] = {
    "autocomplete": _preview_completion,
    "spine": _preview_spine,
    "loop": _preview_cut,
    "pull": _preview_pull,
}


def _preview_inserted_loop(work: ToolWork, mesh: RetopoMesh, a: dict[str, Any]) -> Preview:
    """Preview where a loop would run that is inserted along a strip of a mesh."""
    network, foot = work.network, work.find_foot(a["at"])
    point = foot.points[0]
    near = find_nearest_place(take_samples(network), point, foot.normals[0], work.state.sizes.snap)
    sides = network.patch_of()
    which: Int32Array
    try:
        if near is not None and not sides.keys().isdisjoint((2 * near.chain, 2 * near.chain + 1)):
            chain = network.chains[near.chain]
            ends = divide_chain(chain, network.density)[0]
            first = find_edge_at(chain, near.place, network.density)
            point = ends[[first, first + 1]].mean(axis=0)
            which = np.arange(len(mesh.quads), dtype=np.int32)
        else:
            patch = find_patch(network, work.surface, point)
            which = np.flatnonzero(mesh.patch == patch).astype(np.int32)
    except PatternDBError:
        return Preview(network)
    if not len(which):
        return Preview(network)
    half = find_nearest_edge(mesh, which, point)
    return Preview(network, (trace_strip(mesh.vertices, mesh.quads, half),))


def find_nearest_edge(mesh: RetopoMesh, which: Int32Array, point: ArrayLike) -> int:
    """Find the half-edge of some quads, (k,) their numbers, whose edge is nearest to a point
    (3,)."""
    at = np.asarray(point, np.float64)
    corners = mesh.vertices[mesh.quads[which]]
    one, along = corners, np.roll(corners, -1, axis=1) - corners
    size = np.maximum((along**2).sum(axis=2), np.finfo(np.float64).tiny)
    share = np.clip(((at - one) * along).sum(axis=2) / size, 0.0, 1.0)
    away = np.linalg.norm(one + share[..., None] * along - at, axis=2)
    quad, k = divmod(int(away.argmin()), 4)
    return 4 * int(which[quad]) + k


def _preview_quads(work: ToolWork, mesh: RetopoMesh, call: Call) -> Preview:
    """Preview the quads that would not be as those of a mesh after a call."""
    network, tool = work.network, TOOLS[call.tool]
    arguments = read_arguments(call.tool, tool.arguments, call.arguments)
    after = tool.act(work, arguments).state.network
    found: list[Points] = []
    for number, patch in tuple(after.patches.items()):
        former = network.patches.get(number)
        same = former is not None and former.choice == patch.choice
        chains = {half >> 1 for half in patch.loop}
        if same and all(after.chains[c] is network.chains.get(c) for c in chains):
            continue
        after, placed = fill_patch(after, work.surface, work.source, number)
        found.append(placed.vertices[placed.quads])
    if not found or not len(mesh.vertices):
        return Preview(network)
    quads = np.concatenate(found)
    away, _ = KDTree(mesh.vertices).query(quads)
    moved = (away > STILL * work.surface.diagonal).any(axis=1)
    return Preview(network, quads=quads[moved])
