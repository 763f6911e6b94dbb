"""A placed fill as it is drawn: every quad as a small patch that follows the surface."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from patterndb.geometry.neighbours import Neighbours
from patterndb.geometry.points import Points, units
from patterndb.geometry.quadshape import own_normals
from query import Fill, Stroke
from query.placing import Placement, Region, Surface
from query.placing.flow import follow_strokes

#: Pieces of an edge: enough that a quad hugs a head with some twenty along it.
PIECES = 6

#: A point of a quad this much of the quad's size away from the surface is left where it is: the
#: surface has a gap there, or the fill was not placed on it.
FAR = 0.75


@dataclass(frozen=True, slots=True, eq=False)
class Net:
    """A fill's quads cut fine, laid on the surface.

    patches: (q, n, n, 3) float64 points of every quad, n = PIECES + 1; vertex 0 at [0, 0],
             1 at [-1, 0], 2 at [-1, -1], 3 at [0, -1]. normals: the same, unit normals.
    edges:   (e, n, 3) float64 inner edges; border: (P, n, 3) boundary edges, in order.
    carried: (c,) int32 quads of the strands that carry strokes.
    irregular: (i, 3) irregular inner vertices; valences: (i,) int32 theirs.
    odd:     (o, 3) boundary vertices whose number of quads is not what their place asks for.
    edge:    the median length of an edge.
    """

    patches: Points
    normals: Points
    edges: Points
    border: Points
    carried: NDArray[np.int32]
    irregular: Points
    valences: NDArray[np.int32]
    odd: Points
    edge: float

    @classmethod
    def of(
        cls,
        fill: Fill,
        placement: Placement,
        on: Surface | Region | None,
        corner_counts: Sequence[int],
        strokes: Sequence[Stroke],
        tolerance: int,
    ) -> Net:
        """Of a placed fill; corner_counts: quads that the boundary asks for at its corners."""
        vertices = placement.vertices
        beside = Neighbours.of(fill.quads, fill.n_vertices, fill.perimeter)
        normals = own_normals(fill.quads, vertices, beside)
        corner = vertices[fill.quads]
        patches = _bilinear(corner)
        bent = _bilinear(normals[fill.quads])
        bent = units(bent.reshape(-1, 3)).reshape(bent.shape)
        surface = on.surface if isinstance(on, Region) else on
        if surface is not None:
            patches, bent = _laid(patches, bent, corner, surface)
        inner, border = _edges(fill, patches)
        disk = fill.disk()
        irregular = disk.irregular()
        valence = disk.valence()
        wanted = np.full(fill.perimeter, 2)
        starts = np.cumsum([0, *fill.lengths[:-1]])
        if corner_counts:
            wanted[starts] = corner_counts
        odd = np.flatnonzero(valence[: fill.perimeter] != wanted)
        return cls(
            patches=patches,
            normals=bent,
            edges=inner,
            border=border,
            carried=_carried(fill, vertices, strokes, tolerance, beside),
            irregular=vertices[irregular],
            valences=valence[irregular].astype(np.int32),
            odd=vertices[odd],
            edge=float(np.median(np.linalg.norm(corner - np.roll(corner, 1, axis=1), axis=2))),
        )


def _bilinear(corner: Points) -> Points:
    """(q, n, n, 3) from (q, 4, 3)."""
    t = np.linspace(0.0, 1.0, PIECES + 1)
    u, v = np.meshgrid(t, t, indexing="ij")
    weights = np.stack([(1 - u) * (1 - v), u * (1 - v), u * v, (1 - u) * v], axis=-1)
    return np.einsum("uvk,qkc->quvc", weights, corner)


def _laid(
    patches: Points, normals: Points, corner: Points, surface: Surface
) -> tuple[Points, Points]:
    feet = surface.nearest(patches.reshape(-1, 3))
    size = np.linalg.norm(corner - np.roll(corner, 1, axis=1), axis=2).max(axis=1)
    points = feet.points.reshape(patches.shape)
    far = np.linalg.norm(points - patches, axis=3) > FAR * size[:, None, None]
    # The corners are where they were placed, to the last bit.
    far[:, ::PIECES, ::PIECES] = True
    there = feet.normals.reshape(patches.shape)
    astray = np.linalg.norm(points - patches, axis=3) > FAR * size[:, None, None]
    return (
        np.where(far[..., None], patches, points),
        np.where(astray[..., None], normals, there),
    )


def _edges(fill: Fill, patches: Points) -> tuple[Points, Points]:
    """Every edge once, as a side of its first quad's patch: inner ones, and those around."""
    along = np.stack(
        [patches[:, :, 0], patches[:, -1, :], patches[:, ::-1, -1], patches[:, 0, ::-1]], axis=1
    ).reshape(-1, PIECES + 1, 3)
    tail = fill.quads.ravel()
    head = np.roll(fill.quads, -1, axis=1).ravel()
    p = fill.perimeter
    around = (tail < p) & (head == (tail + 1) % p)
    # Two quads beside an edge run along it in opposite senses; one counts.
    kept = ~around & (tail < head)
    order = np.argsort(tail[around])
    return along[kept], along[around][order]


def _carried(
    fill: Fill, vertices: Points, strokes: Sequence[Stroke], tolerance: int, beside: Neighbours
) -> NDArray[np.int32]:
    """The quads between the transversal edges of strands that strokes have."""
    found: list[NDArray[np.int32]] = []
    for one in follow_strokes(fill, vertices, strokes, tolerance, beside):
        if one is None:
            continue
        key = {frozenset(edge) for edge in one.edges.tolist()}
        for q, quad in enumerate(fill.quads.tolist()):
            for e in (0, 1):
                across = (
                    frozenset((quad[e], quad[e + 1])),
                    frozenset((quad[e + 2], quad[(e + 3) % 4])),
                )
                if across[0] in key and across[1] in key:
                    found.append(np.array([q], np.int32))
    return np.unique(np.concatenate(found)) if found else np.zeros(0, np.int32)
