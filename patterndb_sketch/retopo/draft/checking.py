"""Refuse surfaces on which no field lies, and handles that no ring of quads closes around."""

from __future__ import annotations

import numpy as np

from patterndb.geometry.surface import Surface
from patterndb_sketch.retopo.draft.frames import TangentFrames
from patterndb_sketch.retopo.draft.handles import find_shortest_handle
from patterndb_sketch.retopo.errors import RefusedError
from patterndb_sketch.retopo.wording import format_place, round_down

#: Least length of a loop around a handle, or through one, in target edges: three quads close
#: a tube, and it has no shape with fewer.
LEAST_AROUND = 3.0

#: Edges that close around a thin handle are shorter by this part: on a finer mesh the loop is a
#: little shorter.
CLOSING = 0.9

#: Edges of a draft are no shorter than this part of the diagonal: they give a hundred thousand
#: quads.
LEAST_EDGE = 0.004


class LaceError(RefusedError):
    """A handle of the surface is too thin; edge: a length with which it is not, perhaps shorter
    than a draft may have."""

    def __init__(self, message: str, edge: float) -> None:
        super().__init__(message)
        self.edge = edge


def refuse_laces(mesh: TangentFrames, edge: float, diagonal: float) -> None:
    """LaceError, with the place, for a surface with a handle that no ring of quads of this edge
    goes around, or through: a lace, or the slit below it."""
    found = find_shortest_handle(mesh)
    if found is not None and found.length < LEAST_AROUND * edge:
        finer = round_down(CLOSING * found.length / LEAST_AROUND)
        ways = ["close the opening if it is not meant", "draw by hand"]
        if finer >= LEAST_EDGE * diagonal:
            ways.insert(0, f"take an edge of {finer:g}")
        raise LaceError(
            f"no draft: a handle of the surface, or the opening through it, is {found.length:.3g} "
            f"around at {format_place(found.middle)}, and an edge is {edge:.3g}: no ring of quads "
            f"closes there; {', '.join(ways[:-1])}, or {ways[-1]}",
            finer,
        )


def check_surface(surface: Surface) -> None:
    """Raise RefusedError, with the place, for a surface on which no field can lie."""
    topology, triangles = surface.adjacency, surface.triangles
    uses = np.diff(topology.side_start)
    shared = np.flatnonzero(uses > 2)
    if len(shared):
        raise RefusedError(
            # How many is not told: the surface may be a finer one than the surface that was given.
            "edges have more than two triangles, the first at "
            f"{format_place(topology.middles[shared[0]])}: part the sheets that touch there"
        )
    fans = np.bincount(triangles.ravel(), minlength=len(surface.vertices))
    mesh = TangentFrames.of(surface)
    for vertex in np.flatnonzero(fans).tolist():
        if len(mesh.list_ring(vertex)) != fans[vertex]:
            raise RefusedError(
                "parts of the surface touch in one vertex at "
                f"{format_place(surface.vertices[vertex])}: part them, or join them along an edge"
            )
