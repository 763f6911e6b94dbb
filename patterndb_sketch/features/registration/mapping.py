"""Mapping: a membrane spanned by a template's feature vertices, and drawn to a model.

The membrane's normals leave the model at hits, which are trusted the less the farther off they are
(find_hits); what other components hide, as a body's top beneath the roof, asks for none
(find_occluded); map_membrane is the compromise between hits and smoothness.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array, diags_array, vstack
from scipy.sparse.linalg import SuperLU, splu

from patterndb.core.halfedge import Int32Array
from patterndb.geometry.points import Bools, Floats, Points
from patterndb.geometry.surface import Surface
from patterndb_sketch.features.errors import InvalidFeatureError
from patterndb_sketch.features.registration.template import MIRROR, Template, list_edges


@dataclass(frozen=True, slots=True, eq=False)
class Membrane:
    """The uniform Laplace system of a template, factored once for all models.

    free, fixed: numbers of the vertices that are not and those that are feature vertices.
    rows:        (free, v) sparse: a vertex less the mean of its neighbours.
    inner:       (free, free) sparse, the part of it for the free vertices.
    factor:      of inner; None if all vertices are feature vertices.

    Source: feature curve recovery paper, section 5.1.2; Kobbelt, Campagna, Vorsatz and Seidel
    1998, "Interactive multi-resolution modeling on arbitrary meshes".
    """

    free: NDArray[np.int64]
    fixed: NDArray[np.int64]
    rows: csr_array
    inner: csr_array
    factor: SuperLU | None

    @classmethod
    def of(cls, template: Template) -> Membrane:
        mask = template.fixed
        free, fixed = np.flatnonzero(~mask), np.flatnonzero(mask)
        near = template.adjacency()
        degree = np.asarray(near.sum(axis=1)).ravel()
        own = diags_array(np.ones(template.n_vertices)).tocsr()
        every = csr_array(own - diags_array(1.0 / degree).tocsr() @ near)
        rows = csr_array(every[free])
        inner = csr_array(rows[:, free])
        factor = splu(inner.tocsc()) if len(free) else None
        return cls(free, fixed, rows, inner, factor)

    def pull(self, features: Points) -> Points:
        """(free, 3) what the feature vertices, of places (v, 3), ask of the others.

        The Laplacian of the free vertices' places p is ``inner @ p - pull``.
        """
        return -(self.rows[:, self.fixed] @ features[self.fixed])

    def spanned(self, features: Points) -> Points:
        """(v, 3) the membrane through the feature vertices of (v, 3); others are not looked at.

        Raises InvalidFeatureError for feature vertices that have no place.
        """
        if not np.isfinite(features[self.fixed]).all():
            raise InvalidFeatureError("a feature vertex has no place; sample every feature")
        result = np.array(features, np.float64)
        if self.factor is not None:
            result[self.free] = self.factor.solve(self.pull(result))
        return result


def find_occluded(template: Template, points: Points, normals: Points) -> Bools:
    """(v,) bool, the free vertices that a component hides to which their own yields.

    points, normals: (v, 3) of the membrane. A vertex is hidden if the ray along its normal hits
    such a component, or if the ray against it first hits one from in front: then the vertex
    spans an opening, as a body's side does before a wheelhouse. Of a half that is mirrored, the
    other half hides too.

    Source: feature curve recovery paper, section 5.1.2. Differs from the paper: it does not say
    which way normals go; the ray along them alone never meets a wheelhouse, which is behind the
    side, and both ways alike would take the hood above a wheelhouse for hidden.
    """
    result = np.zeros(template.n_vertices, np.bool_)
    free = ~template.fixed & (normals != 0.0).any(axis=1)
    for number, part in enumerate(template.parts):
        mine = np.flatnonzero(free & (template.of_part == number))
        if not part.yields_to or not len(mine):
            continue
        mesh = Surface.from_corners(_triangles(template, points, part.yields_to))
        begin, along = points[mine], normals[mine]
        ahead = mesh.cast_rays(begin, along).found
        behind = mesh.cast_rays(begin, -along).triangles
        a, b, c = mesh.corners[behind].transpose(1, 0, 2)
        facing = np.einsum("nc,nc->n", np.cross(b - a, c - a), along) > 0.0
        result[mine] = ahead | ((behind >= 0) & facing)
    return result


def _triangles(template: Template, points: Points, parts: tuple[str, ...]) -> Points:
    """(t, 3, 3) the triangles of parts, turned as their quads are, and their mirror images."""
    quads: Int32Array = np.concatenate([template.part_quads(name) for name in parts])
    corners = points[np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])]
    if template.mirrored:
        corners = np.concatenate([corners, (corners * MIRROR)[:, ::-1]])
    return np.ascontiguousarray(corners)


@dataclass(frozen=True, slots=True, eq=False)
class Lines:
    """Lines through points (v, 3) along normals (v, 3).

    asked: (v,) bool, those that a model is asked about. hollow: (v,) bool, of hollow parts.
    """

    points: Points
    normals: Points
    asked: Bools
    hollow: Bools


@dataclass(frozen=True, slots=True, eq=False)
class Hits:
    """Where vertices' normals leave a model.

    points: (v, 3) float64, nan without a hit. found: (v,) bool.
    doubt:  (v,) float64, the paper's d: the distance from the membrane over the reach, at most
            1; 1 without a hit. A hit counts with the weight 1 - d, smoothness with d.
    """

    points: Points
    found: Bools
    doubt: Floats

    @classmethod
    def nothing(cls, v: int) -> Hits:
        """No hit at any of v vertices."""
        return cls(np.full((v, 3), np.nan), np.zeros(v, np.bool_), np.ones(v))

    @property
    def trusted(self) -> Bools:
        """(v,) bool, does the hit count at all?"""
        return self.found & (self.doubt < 1.0)


def find_hits(model: Surface, lines: Lines, reach: Floats) -> Hits:
    """The hits of the lines along vertices' normals.

    reach: (v,) from which distance on a hit is no more believed: delta times the shortest edge.

    Source: feature curve recovery paper, section 5.1.2. Differs from the paper: of hollow
    parts it takes the nearest hit, not the outermost. The outermost hit of a wheelhouse is
    the wheel in it, or the far end of the car.
    """
    v = len(reach)
    places, found, doubt = np.full((v, 3), np.nan), np.zeros(v, np.bool_), np.ones(v)
    asked = lines.asked & (lines.normals != 0.0).any(axis=1)
    length = np.full(v, np.inf)
    for chosen, ask in (
        (np.flatnonzero(asked & ~lines.hollow), find_outermost),
        (np.flatnonzero(asked & lines.hollow), _find_nearest),
    ):
        places[chosen], along = ask(model, lines.points[chosen], lines.normals[chosen])
        length[chosen], found[chosen] = np.abs(along), np.isfinite(along)
    near = found & (length < reach)
    doubt[near] = length[near] / reach[near]
    return Hits(places, found, doubt)


def find_outermost(model: Surface, origins: Points, directions: Points) -> tuple[Points, Floats]:
    """Return the last hits (n, 3) of lines along their directions, which may lie behind the
    origins, and how far along (n,) they are: nan and inf for lines that hit nothing.

    Source: feature curve recovery paper, section 5.1.2; the lengths are its gamma_max.
    """
    offsets, hits = model.cast_lines(origins, directions)
    met = np.diff(offsets) > 0
    last = offsets[1:][met] - 1
    points, lengths = np.full((len(met), 3), np.nan), np.full(len(met), np.inf)
    points[met], lengths[met] = hits.points[last], hits.distances[last]
    return points, lengths


def _find_nearest(model: Surface, origins: Points, directions: Points) -> tuple[Points, Floats]:
    """Return the hits (n, 3) of lines nearest to their origins, before or behind them, and how far
    along (n,) they are."""
    ahead = model.cast_rays(origins, directions)
    behind = model.cast_rays(origins, -directions)
    first = ahead.distances <= behind.distances
    points = np.where(first[:, None], ahead.points, behind.points)
    return points, np.where(first, ahead.distances, -behind.distances)


def map_membrane(membrane: Membrane, features: Points, found: Hits) -> Points:
    """(v, 3) the places with the least sum of squares that keep the feature vertices (v, 3).

    The sum has two kinds of terms for a free vertex: d times its distance from the mean of its
    neighbours, and, with a hit, 1 - d times its distance from the hit. Feature vertices are
    taken out of the system, so they stay to the last bit.

    Source: feature curve recovery paper, equations 2 to 4.
    """
    result = np.array(features, np.float64)
    free = membrane.free
    if not len(free):
        return result
    smooth, pull = found.doubt[free], membrane.pull(result)
    met = np.flatnonzero(found.trusted[free])
    trust = 1.0 - smooth[met]
    select = csr_array((trust, (np.arange(len(met)), met)), (len(met), len(free)))
    system = vstack([diags_array(smooth).tocsr() @ membrane.inner, select]).tocsr()
    wanted = np.concatenate([smooth[:, None] * pull, trust[:, None] * found.points[free][met]])
    normal = (system.T @ system).tocsc()
    factor = splu(normal)
    places = factor.solve(system.T @ wanted)
    # The normal matrix has half the digits: one round on the residual gets them back.
    places += factor.solve(system.T @ (wanted - system @ places))
    result[free] = places
    return result


def find_normals(points: Points, quads: Int32Array) -> Points:
    """(v, 3) unit normals at vertices, of quads by their areas; 0 where there is no direction."""
    a, b, c, d = (points[quads[:, k]] for k in range(4))
    area = np.cross(c - a, d - b)
    total = np.zeros_like(points)
    for k in range(4):
        np.add.at(total, quads[:, k], area)
    size = np.linalg.norm(total, axis=1, keepdims=True)
    tiny = 1e-14 * float(np.linalg.norm(np.ptp(points, axis=0))) ** 2
    return np.where(size > tiny, total / np.where(size > tiny, size, 1.0), 0.0)


def measure_shortest_edges(points: Points, quads: Int32Array) -> Floats:
    """(v,) the length of the shortest edge at every vertex."""
    tail, head = list_edges(quads).T
    length = np.linalg.norm(points[head] - points[tail], axis=1)
    result = np.full(len(points), np.inf)
    np.minimum.at(result, tail, length)
    np.minimum.at(result, head, length)
    return result
