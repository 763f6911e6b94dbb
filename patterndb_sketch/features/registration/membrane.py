"""Membranes: surfaces that a template's feature vertices span, and normals of its vertices."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array, diags_array
from scipy.sparse.linalg import SuperLU, splu

from patterndb.core.halfedge import Int32Array
from patterndb.geometry.points import Floats, Points
from patterndb_sketch.features.errors import InvalidFeatureError
from patterndb_sketch.features.registration.template import Template, edges


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


def vertex_normals(points: Points, quads: Int32Array) -> Points:
    """(v, 3) unit normals at vertices, of quads by their areas; 0 where there is no direction."""
    a, b, c, d = (points[quads[:, k]] for k in range(4))
    area = np.cross(c - a, d - b)
    total = np.zeros_like(points)
    for k in range(4):
        np.add.at(total, quads[:, k], area)
    size = np.linalg.norm(total, axis=1, keepdims=True)
    tiny = 1e-14 * float(np.linalg.norm(np.ptp(points, axis=0))) ** 2
    return np.where(size > tiny, total / np.where(size > tiny, size, 1.0), 0.0)


def shortest_edges(points: Points, quads: Int32Array) -> Floats:
    """(v,) the length of the shortest edge at every vertex."""
    tail, head = edges(quads).T
    length = np.linalg.norm(points[head] - points[tail], axis=1)
    result = np.full(len(points), np.inf)
    np.minimum.at(result, tail, length)
    np.minimum.at(result, head, length)
    return result
