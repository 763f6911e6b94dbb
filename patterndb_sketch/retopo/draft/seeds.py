"""Choose regular places from which lines are traced, too: where regions would be rings or long."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from patterndb.geometry.points import Points
from patterndb.geometry.surface import Surface
from patterndb_sketch.retopo.draft.crossfield import CrossField
from patterndb_sketch.retopo.draft.frames import TangentFrames
from patterndb_sketch.retopo.network import Network
from patterndb_sketch.retopo.network.faces import SurfaceParts

#: Where a field has no singularity, regions with a longer border, in diagonals, are cut by a
#: further place. It is the longest loop that Takayama et al.'s program takes for a patch.
LONGEST_LOOP = 2.0

#: Lines across a ring that has no corner: a patch goes no further around it than a quarter.
ACROSS_RING = 4

#: Number of lines after which a ring gets no more.
LEAST_ACROSS = 3


@dataclass(frozen=True, slots=True, eq=False)
class RegularParts:
    """The parts of a surface on which a field has no singularity, as on a torus.

    Elsewhere singularities cut as finely as the shape asks for. at: (v,) of the field's mesh, is
    this vertex on such a part? of_triangle: (t,) the part of each triangle of the surface.
    longest: by part, how long a region's border may be; infinite where there are singularities.
    """

    at: NDArray[np.bool_]
    of_triangle: NDArray[np.signedinteger[Any]]
    longest: NDArray[np.float64]

    @classmethod
    def of(cls, field: CrossField, surface: Surface) -> RegularParts:
        parts = SurfaceParts.of(surface)
        part = parts.part[surface.nearest(field.mesh.vertices).triangles]
        longest = np.empty(parts.parts)
        for k in range(parts.parts):
            corners = surface.vertices[surface.triangles[parts.part == k]].reshape(-1, 3)
            longest[k] = LONGEST_LOOP * np.linalg.norm(np.ptp(corners, axis=0))
        longest[part[field.singular]] = np.inf
        return cls(np.isfinite(longest[part]), parts.part, longest)


def has_long_patch(network: Network, surface: Surface, regular: RegularParts) -> bool:
    if not regular.at.any():
        return False
    for patch in network.patches.values():
        chains = [network.chains[half >> 1] for half in patch.loop]
        at = surface.nearest(np.concatenate([chain.points for chain in chains])).triangles
        part = np.bincount(regular.of_triangle[at]).argmax()
        if sum(chain.length for chain in chains) > regular.longest[part]:
            return True
    return False


def find_seed(field: CrossField, regular: RegularParts, seeds: list[int]) -> int:
    """The inner regular vertex furthest from singularities, borders and other seeds, of parts that
    have no singularity where there are any."""
    from scipy.sparse.csgraph import dijkstra

    mesh = field.mesh
    graph = mesh.edge_graph
    sources = [*field.singular.tolist(), *seeds, *np.flatnonzero(mesh.on_border).tolist()]
    # What has no triangle is on no part, and infinitely far, too.
    inner = ~mesh.on_border & (field.index == 0) & (mesh.leaving >= 0)
    if (inner & regular.at).any():
        inner &= regular.at
    if not sources:
        return int(np.flatnonzero(inner)[0])
    far = dijkstra(graph, indices=sources, min_only=True)
    # Parts that have none of these are infinitely far.
    far[~inner] = -1.0
    return int(far.argmax())


def seed_rings(field: CrossField, seeds: list[int]) -> list[int]:
    """A vertex of each part between drawn curves that no line begins in: of its border, or within
    it where it has none."""
    mesh = field.mesh
    parts = SurfaceParts.of(mesh.surface)
    of_vertex = np.full(len(mesh.vertices), -1)
    of_vertex[mesh.triangles.ravel()] = np.repeat(parts.part, 3)
    # Of a ring few lines would leave patches that go around it, which have no shape.
    lines = np.zeros(parts.parts)
    for vertex in (*field.singular.tolist(), *seeds):
        all_of = (1 if mesh.on_border[vertex] else 4) - int(field.index[vertex])
        lines[of_vertex[vertex]] += max(all_of, 0)
    corners = np.bincount(
        of_vertex[np.flatnonzero(mesh.on_border & (field.index == 1))], minlength=parts.parts
    )
    rims = np.bincount([of_vertex[loop[0]] for loop in mesh.rims] or [0], minlength=parts.parts)
    begun = (lines >= LEAST_ACROSS) | ((rims < 2) & (lines + corners > 0))
    found: list[int] = []
    for part in np.flatnonzero(~begun).tolist():
        own = of_vertex == part
        rim = np.flatnonzero(own & mesh.on_border)
        if len(rim):
            found += [v for v in _spread_along_rim(mesh, own) if field.index[v] == 0]
    return found


def seed_rims_at(field: CrossField, at: Points, near: float, seeds: list[int]) -> list[int]:
    """Vertices that divide borders at a point evenly, of those that have no seed yet."""
    mesh = field.mesh
    found: list[int] = []
    for loop in mesh.rims:
        away = np.linalg.norm(mesh.vertices[loop] - at, axis=1).min()
        if away <= near and not set(loop) & set(seeds):
            found += [v for v in _divide_rim(mesh, loop) if field.index[v] == 0]
    return found


def _spread_along_rim(mesh: TangentFrames, own: NDArray[np.bool_]) -> list[int]:
    """Vertices that divide the longest border of a part evenly."""
    loops = [loop for loop in mesh.rims if own[loop[0]]]
    return _divide_rim(mesh, max(loops, key=lambda one: float(_measure_rim(mesh, one).sum())))


def _measure_rim(mesh: TangentFrames, loop: list[int]) -> NDArray[np.float64]:
    return np.linalg.norm(np.diff(mesh.vertices[[*loop, loop[0]]], axis=0), axis=1)


def _divide_rim(mesh: TangentFrames, loop: list[int]) -> list[int]:
    along = np.cumsum(_measure_rim(mesh, loop))
    wanted = along[-1] * np.arange(ACROSS_RING) / ACROSS_RING
    found = dict.fromkeys(np.searchsorted(along, wanted).tolist())
    return [loop[k] for k in found if k < len(loop)]


def find_tips(network: Network, field: CrossField, near: float) -> list[int]:
    """The vertices at open ends of drawn curves that are regular: there a line goes on straight, as
    one leaves every regular vertex of a border, and only there it is needed."""
    mesh = field.mesh
    rim = np.flatnonzero(mesh.on_border)
    found: list[int] = []
    for node in network.nodes.values():
        if node.open and len(rim):
            away = np.linalg.norm(mesh.vertices[rim] - node.point, axis=1)
            vertex = int(rim[away.argmin()])
            if away.min() <= near and field.index[vertex] == 0:
                found.append(vertex)
    return found
