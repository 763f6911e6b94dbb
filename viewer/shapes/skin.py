"""What stays the same of every shape of a model: triangles, creases, edges and curves."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array

from patterndb.core.halfedge import Int64Array
from patterndb.geometry.points import Points
from patterndb_sketch.features.registration import Template
from patterndb_sketch.features.shapemodel import ShapeModel
from patterndb_sketch.features.shapemodel.shaping import ShapeLine, list_shape_lines

#: Cosines of the angles between two faces from which on they are shaded as one smooth surface,
#: and up to which there is a crease between them: 30 and 45 degrees. Between, a bit of both.
SMOOTH, CREASED = np.cos(np.radians(30.0)), np.cos(np.radians(45.0))


@dataclass(frozen=True, slots=True, eq=False)
class ShapeSkin:
    """The topology of all shapes of a model.

    n_vertices: of a shape. quads: (q, 4). corners: (2 q, 3) for every triangle the numbers of its
    corners among the 4 q corners of quads; of mirror images the diagonals are mirrored.
    edges: (e, 2) vertices. beside: (e, 2, 2) for the two faces at each edge the numbers of their
    corners at its two ends; the first face's again at a rim.
    lines: the features, then their mirror images that are not themselves.
    """

    n_vertices: int
    quads: Int64Array
    corners: Int64Array
    edges: Int64Array
    beside: Int64Array
    lines: tuple[ShapeLine, ...]
    _alike: tuple[Int64Array, Int64Array]

    @classmethod
    def of(cls, shapes: ShapeModel, template: Template) -> ShapeSkin:
        """Of a shape model and the template that its shapes were laid with.

        Raises InvalidFeatureError if it is another template.
        """
        lines = list_shape_lines(shapes, template)
        quads = np.asarray(shapes.quads, np.int64)
        edges, beside = _edges(quads)
        corners = _corners(len(quads), len(template.quads))
        alike = _alike(quads, len(shapes.mean))
        return cls(len(shapes.mean), quads, corners, edges, beside, lines, alike)

    @property
    def vertices(self) -> Int64Array:
        """(2 q, 3) the vertices of every triangle."""
        return self.quads.ravel()[self.corners]

    def face_normals(self, points: Points) -> Points:
        """(q, 3) normals of faces, as long as twice their area."""
        a, b, c, d = (points[self.quads[:, k]] for k in range(4))
        return np.cross(c - a, d - b)

    def normals(self, points: Points) -> Points:
        """(4 q, 3) unit normals at the corners of faces: smooth, but not over creases."""
        faces = self.face_normals(points)
        size = np.linalg.norm(faces, axis=1, keepdims=True)
        unit = faces / np.where(size > 0.0, size, 1.0)
        one, other = self._alike
        cosine = np.einsum("pc,pc->p", unit[one // 4], unit[other // 4])
        share = np.clip((cosine - CREASED) / (SMOOTH - CREASED), 0.0, 1.0)
        share = np.where(one == other, 1.0, share)
        total = np.zeros((4 * len(faces), 3))
        weighted = share[:, None] * faces[other // 4]
        for axis in range(3):
            total[:, axis] = np.bincount(one, weighted[:, axis], len(total))
        size = np.linalg.norm(total, axis=1, keepdims=True)
        return total / np.where(size > 0.0, size, 1.0)

    def outline(self, points: Points, normals: Points, toward: Points) -> Points:
        """(k, 2, 3) the lines along which a shape turns away from who looks against ``toward``
        (3,), over smooth faces and along creases, and its rims.

        normals: as from :meth:`normals`.
        """
        ahead = normals @ toward
        one, other = ahead[self.beside].sum(axis=2).T > 0.0
        rim = self.beside[:, 0, 0] == self.beside[:, 1, 0]
        sharp = points[self.edges[(one != other) | rim]]
        value = ahead[self.corners]
        sign = value > 0.0
        count = sign.sum(axis=1)
        mixed = np.flatnonzero((count > 0) & (count < 3))
        # The corner that is alone on its side of the line.
        alone = np.where(count[mixed] == 1, sign[mixed].argmax(axis=1), sign[mixed].argmin(axis=1))
        ends: list[Points] = []
        places = points[self.vertices[mixed]]
        row = np.arange(len(mixed))
        for step in (1, 2):
            next_ = (alone + step) % 3
            a, b = value[mixed, alone], value[mixed, next_]
            share = (a / (a - b))[:, None]
            ends.append(places[row, alone] * (1.0 - share) + places[row, next_] * share)
        return np.concatenate([sharp, np.stack(ends, axis=1)])


def _edges(quads: Int64Array) -> tuple[Int64Array, Int64Array]:
    first = np.arange(quads.size)
    corners = np.stack([first, np.where(first % 4 == 3, first - 3, first + 1)], axis=1)
    pairs = quads.ravel()[corners]
    order = np.argsort(pairs, axis=1, kind="stable")
    pairs, corners = (np.take_along_axis(one, order, axis=1) for one in (pairs, corners))
    edges, number = np.unique(pairs, axis=0, return_inverse=True)
    number = number.ravel()
    beside = np.empty((len(edges), 2, 2), np.int64)
    # The last one written stays: forwards the second face, backwards the first.
    beside[number, 1] = corners
    beside[number[::-1], 0] = corners[::-1]
    return edges, beside


def _corners(n_quads: int, n_half: int) -> Int64Array:
    """Quads of the half are cut from their first corner to the third, images the other way."""
    half = np.array([[0, 1, 2], [0, 2, 3]])
    image = np.array([[3, 0, 1], [3, 1, 2]])
    first = 4 * np.arange(n_quads)[:, None, None]
    own = (np.arange(n_quads) < n_half)[:, None, None]
    return (first + np.where(own, half, image)).reshape(-1, 3)


def _alike(quads: Int64Array, n_vertices: int) -> tuple[Int64Array, Int64Array]:
    """All ordered pairs of corners at one vertex, each with itself, too."""
    n = quads.size
    at = csr_array((np.ones(n, np.int8), (quads.ravel(), np.arange(n))), (n_vertices, n))
    one, other = (at.T @ at).tocoo().coords
    return one.astype(np.int64), other.astype(np.int64)
