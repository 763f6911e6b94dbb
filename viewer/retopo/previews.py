"""Previews: what a tool would make of where the pointer is, found in a thread of their own."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from concurrent.futures import wait as wait_for
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial import KDTree

from patterndb.core.halfedge import Int32Array
from patterndb.errors import PatternDBError
from patterndb.geometry.points import Points
from patterndb.geometry.strips import trace_strip
from patterndb.geometry.surface import SurfacePoints
from patterndb_sketch.retopo.arguments import read_arguments
from patterndb_sketch.retopo.editor import TOOLS, Call
from patterndb_sketch.retopo.filling import RetopoMesh
from patterndb_sketch.retopo.filling.fills import fill_patch
from patterndb_sketch.retopo.filling.location import find_patch
from patterndb_sketch.retopo.filling.placing import divide_chain
from patterndb_sketch.retopo.network import Network, find_nearest_place, take_samples
from patterndb_sketch.retopo.tool import ToolWork
from patterndb_sketch.retopo.tools.autocomplete import find_completions
from patterndb_sketch.retopo.tools.insertloop import find_edge_at
from patterndb_sketch.retopo.tools.loop import preview_loop
from patterndb_sketch.retopo.tools.pull import find_held, pull_held
from patterndb_sketch.retopo.tools.spine import preview_spine


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


#: A vertex is where it was if it moves by less than this part of the surface's diagonal: placing
#: a patch again gives the same within rounding, and less is not seen.
STILL = 1e-4


@dataclass(frozen=True, slots=True, eq=False)
class Preview:
    """What would be made.

    network: that it was found for. at: (3,) where the pointer was. curves: (m, 3) each.
    corners: (k, 3). number, count: it is this one of so many. refused: why there is none, "" if
    there is one. quads: (q, 4, 3) that would be other ones.
    """

    network: Network
    at: Points
    curves: tuple[Points, ...] = ()
    corners: Points | None = None
    number: int = 0
    count: int = 0
    refused: str = ""
    quads: Points | None = None


def preview_completion(work: ToolWork, foot: SurfacePoints, radius: float, number: int) -> Preview:
    """Preview a patch that could be completed around a foot; number: which of them, from 0 on, the
    last if there are not so many."""
    network, point = work.network, foot.points[0]
    sizes = replace(work.state.sizes, autocompletion=radius)
    try:
        found = find_completions(network, work.surface, point, foot.normals[0], sizes)
        if not found:
            return Preview(network, point)
        number = min(number, len(found) - 1)
        one = found[number]
        curves = tuple(one.curves(sizes))
        return Preview(network, point, curves, one.corners(), number, len(found))
    except PatternDBError as error:
        return Preview(network, point, refused=str(error))


def preview_spine_outline(work: ToolWork, line: Points, width: float) -> Preview:
    """Preview the outline of the patch about a line (k, 3)."""
    network, sizes = work.network, replace(work.state.sizes, spine=width / 2.0)
    try:
        stroke = work.clean_stroke_here(line, "the spine", False)
        found = preview_spine(network, work.surface, stroke, sizes)
        return Preview(network, line[-1], tuple(found.curves(sizes)))
    except PatternDBError as error:
        return Preview(network, line[-1], refused=str(error))


def preview_cut(work: ToolWork, point: Points, normal: Points, limit: float) -> Preview:
    """Preview the curve in which a plane through a point (3,) cuts the surface."""
    network = work.network
    try:
        start = work.find_foot(point)
        stroke = preview_loop(work.surface, work.state.sizes, start, normal, limit)
    except PatternDBError as error:
        return Preview(network, point, refused=str(error))
    line = stroke.points
    if stroke.closed:
        line = np.concatenate([line, line[:1]])
    return Preview(network, point, (line,))


def preview_pull(work: ToolWork, begun: Points, point: Points) -> Preview:
    """Preview the curves that follow when what is at one point (3,) is pulled to another."""
    network, sizes = work.network, work.state.sizes
    try:
        start, end = work.find_foot(begun), work.find_foot(point)
        at = find_held(network, sizes, start.points[0], start.normals[0])
        made = pull_held(network, work.surface, sizes, at, end.points[0], end.normals[0]).network
    except PatternDBError as error:
        return Preview(network, point, refused=str(error))
    moved = [c.round for k, c in made.chains.items() if network.chains.get(k) is not c]
    return Preview(network, point, tuple(moved))


def preview_inserted_loop(work: ToolWork, mesh: RetopoMesh, foot: SurfacePoints) -> Preview:
    """Preview where a loop would run that is inserted at a foot, along a strip of a mesh."""
    network, point = work.network, foot.points[0]
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
        return Preview(network, point)
    if not len(which):
        return Preview(network, point)
    half = find_nearest_edge(mesh, which, point)
    line = trace_strip(mesh.vertices, mesh.quads, half)
    return Preview(network, point, (line,))


def preview_call(work: ToolWork, mesh: RetopoMesh, call: Call, at: Points) -> Preview:
    """Preview the quads that would not be as those of a mesh after a call of a tool; at: (3,) where
    the pointer is."""
    network, tool = work.network, TOOLS[call.tool]
    try:
        made = tool.act(work, read_arguments(call.tool, tool.arguments, call.arguments)).state
        after = made.network
        found: list[Points] = []
        for number, patch in made.network.patches.items():
            former = network.patches.get(number)
            same = former is not None and former.choice == patch.choice
            chains = {half >> 1 for half in patch.loop}
            if same and all(after.chains[c] is network.chains.get(c) for c in chains):
                continue
            after, placed = fill_patch(after, work.surface, work.source, number)
            found.append(placed.vertices[placed.quads])
    except PatternDBError as error:
        return Preview(network, at, refused=str(error))
    if not found or not len(mesh.vertices):
        return Preview(network, at)
    quads = np.concatenate(found)
    away, _ = KDTree(mesh.vertices).query(quads)
    moved = (away > STILL * work.surface.diagonal).any(axis=1)
    return Preview(network, at, quads=quads[moved])


class Latest:
    """Finds what was wanted last; what was wanted before and not begun is dropped."""

    def __init__(self) -> None:
        self._worker = ThreadPoolExecutor(1, thread_name_prefix="previewing")
        self._wanted: tuple[object, Future[Preview]] | None = None

    def want(self, key: object, make: Callable[[], Preview]) -> None:
        """Have it found, unless the same is being found already."""
        if self._wanted is not None:
            if self._wanted[0] == key:
                return
            self._wanted[1].cancel()
        self._wanted = (key, self._worker.submit(make))

    def drop(self) -> None:
        """Nothing is wanted any more."""
        if self._wanted is not None:
            self._wanted[1].cancel()
        self._wanted = None

    @property
    def busy(self) -> bool:
        """Is it still to be found?"""
        return self._wanted is not None and not self._wanted[1].done()

    def wait(self, seconds: float | None = None) -> None:
        """Until it is found, or time is out."""
        if self._wanted is not None:
            wait_for([self._wanted[1]], seconds)

    def found(self) -> Preview | None:
        """What was wanted last, if it is found."""
        if self._wanted is None or not self._wanted[1].done():
            return None
        return self._wanted[1].result()

    def close(self) -> None:
        """Wait for what was begun."""
        self._worker.shutdown(wait=True, cancel_futures=True)
