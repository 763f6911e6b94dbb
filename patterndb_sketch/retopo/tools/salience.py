"""Find what of a surface is salient: ridges and valleys, and where they pull a curve."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from patterndb._native.retopo.tools.salience import sum_dots
from patterndb.core.halfedge import Int64Array
from patterndb.geometry.points import Points, units
from patterndb.geometry.surface import Surface
from patterndb_sketch.retopo.errors import InvalidRetopoError

Mode = Literal["ridge", "valley", "both"]

#: What a curve is aligned to.
MODES: tuple[Mode, ...] = ("ridge", "valley", "both")

#: Curvature is gathered with Gaussian weights of this width, in target edges: what bends within
#: one quad is one feature.
WIDTH = 1.0

#: Beyond this many widths the weights, below e^-8, are left out.
REACH = 4.0

#: A feature of this size, in radians that an edge of a quad bends by, pulls half as much as a
#: strong one: 1 degree, below which a quad mesh cannot show it.
FAINT = math.radians(1.0)

#: Curvature is kept in dots at most this far apart, in target edges: fine beside the width.
SPACING = 0.25

#: Edges that bend by less, in radians, are flat: what rounding leaves of a plane.
FLAT = 1e-9

#: More dots than this would take gigabytes: the target edge is surely a slip.
MOST_DOTS = 20_000_000

#: Numbers of cells are this many bits wide in a key of 63, for each of the three axes.
CELL_BITS = 21

#: Rows and columns of the six numbers of a symmetric matrix.
ROWS, COLUMNS = np.array([0, 1, 2, 0, 0, 1]), np.array([0, 1, 2, 1, 2, 2])


@dataclass(frozen=True, slots=True, eq=False)
class Salience:
    """The curvature of a surface in dots, for one target edge; made once for both.

    edge:    the target edge.
    points:  (d, 3) float64, where the dots are, and normals: (d, 3) the surface's there.
    tensors: (d, 6) float64, the curvature of each, times its area: a symmetric matrix as
             xx, yy, zz, xy, xz, yz. Positive along a ridge, negative along a valley.

    Source: Cohen-Steiner and Morvan 2003 (normal cycles): every edge of the triangles counts
    with its angle and length, along itself. That needs no neighbourhood of vertices, so it suits
    even scans and the long triangles of machine parts alike, and noise cancels.
    """

    edge: float
    points: Points
    normals: Points
    tensors: Points
    _low: Points
    _keys: Int64Array
    _starts: Int64Array

    @classmethod
    def of(cls, surface: Surface, edge: float) -> Salience:
        """Of a surface, for a target edge; raises InvalidRetopoError for one too short for it."""
        if not (math.isfinite(edge) and edge > 0.0):
            raise InvalidRetopoError(f"the target edge is {edge}; give a length above 0")
        ends, angle, normal = _measure_bends(surface)
        step = ends[:, 1] - ends[:, 0]
        length = np.linalg.norm(step, axis=1)
        dots = np.maximum(1.0, np.ceil(length / (SPACING * edge)))
        cells = surface.diagonal / (SPACING * edge)
        if dots.sum() > MOST_DOTS or cells >= 1 << CELL_BITS:
            raise InvalidRetopoError(
                f"the target edge {edge:g} is too short for this surface, of diagonal "
                f"{surface.diagonal:g}, to look for ridges and valleys; make it longer"
            )
        count = dots.astype(np.int64)
        which = np.repeat(np.arange(len(count)), count)
        share = (np.arange(len(which)) - np.repeat(np.cumsum(count) - count, count) + 0.5) / count[
            which
        ]
        points = ends[which, 0] + share[:, None] * step[which]
        along = step / np.maximum(length, np.finfo(float).tiny)[:, None]
        weight = angle * length / count
        tensors = (weight[:, None] * along[:, ROWS] * along[:, COLUMNS])[which]
        points, normals, tensors = _gather(
            points, normal[which], tensors, np.abs(weight)[which], SPACING * edge
        )
        low = points.min(axis=0) if len(points) else np.zeros(3)
        keys = _key_cells(points, low, REACH * WIDTH * edge)
        order = np.argsort(keys, kind="stable")
        keys, starts = np.unique(keys[order], return_index=True)
        return cls(
            edge,
            points[order],
            normals[order],
            tensors[order],
            low,
            keys,
            np.append(starts, len(points)),
        )

    def feel(
        self, points: ArrayLike, normals: ArrayLike, mode: Mode
    ) -> tuple[NDArray[np.float64], Points]:
        """The feature (n,) at points (n, 3) with normals (n, 3), and where it pulls them (n, 3).

        The feature is the largest curvature of the mode, gathered over about a target edge, times
        the target edge: the angle that an edge of a quad across it bends by, in radians; none
        below 0. The pull is tangential: its gradient over itself, times the squared width, which is
        the way to the centre of what is felt (mean shift). So it is long enough far off, where the
        gradient itself is next to nothing; but it fades where the feature is FAINT.
        Raises InvalidRetopoError for a mode that is none.
        """
        if mode not in MODES:
            raise InvalidRetopoError(f"curves are aligned to {', '.join(MODES)}, not to {mode!r}")
        at, up = np.asarray(points, np.float64), np.asarray(normals, np.float64)
        width = WIDTH * self.edge
        sums = sum_dots(
            np.ascontiguousarray(at),
            np.ascontiguousarray(up),
            self.points,
            self.normals,
            self.tensors,
            self._low,
            self._keys,
            self._starts,
            width,
        )
        matrix = np.empty((len(at), 3, 3))
        matrix[:, ROWS, COLUMNS] = matrix[:, COLUMNS, ROWS] = sums[:, 0]
        values, vectors = np.linalg.eigh(matrix)
        sign = {"ridge": np.ones(len(at)), "valley": -np.ones(len(at))}.get(
            mode, np.where(values[:, 2] >= -values[:, 0], 1.0, -1.0)
        )
        column = np.where(sign > 0.0, 2, 0)
        index = np.arange(len(at))
        size = np.maximum(sign * values[index, column], 0.0)
        v = vectors[index, :, column]
        twice = np.array([1.0, 1.0, 1.0, 2.0, 2.0, 2.0])
        square = sign[:, None] * twice * v[:, ROWS] * v[:, COLUMNS]
        pull = np.einsum("nk,nck->nc", square, sums[:, 1:])
        to_feature = self.edge / (2.0 * math.pi * width**2)
        pull /= (size + FAINT / to_feature)[:, None]
        pull[size <= 0.0] = 0.0
        pull -= np.einsum("nc,nc->n", pull, up)[:, None] * up
        return to_feature * size, pull


def _measure_bends(surface: Surface) -> tuple[Points, NDArray[np.float64], Points]:
    """The edges that bend: ends (e, 2, 3), angles (e,), above 0 where it is a ridge, and
    normals (e, 3)."""
    across, triangles, vertices = surface.adjacency.across, surface.triangles, surface.vertices
    side = np.flatnonzero(across > np.arange(len(across)))
    other = across[side]
    corner = vertices[triangles]
    face = units(np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]))
    tail, tip = triangles[side // 3, side % 3], triangles[side // 3, (side + 1) % 3]
    apex = vertices[triangles[other // 3, (other + 2) % 3]]
    one, two = face[side // 3], face[other // 3]
    # A neighbour that is turned against this triangle runs along the edge the same way.
    turned = triangles[other // 3, other % 3] == tail
    two = np.where(turned[:, None], -two, two)
    angle = np.arctan2(np.linalg.norm(np.cross(one, two), axis=1), np.einsum("nc,nc->n", one, two))
    below = np.einsum("nc,nc->n", apex - vertices[tail], one) < 0.0
    bent = angle > FLAT
    ends = np.stack([vertices[tail], vertices[tip]], axis=1)
    return ends[bent], np.where(below, angle, -angle)[bent], units(one + two)[bent]


def _key_cells(points: Points, low: Points, size: float) -> Int64Array:
    """(n,) the number of the cell, of a size, that each point (n, 3) is in."""
    cell = np.floor((points - low) / size).astype(np.int64)
    return (cell[:, 0] << (2 * CELL_BITS)) | (cell[:, 1] << CELL_BITS) | cell[:, 2]


def _gather(
    points: Points, normals: Points, tensors: Points, weight: NDArray[np.float64], size: float
) -> tuple[Points, Points, Points]:
    """Dots in one cell of a size, on the same side of a sheet, taken together at their mean."""
    if not len(points):
        return points, normals, tensors
    key = _key_cells(points, points.min(axis=0), size)
    # Which way a normal looks most: the sides of a sheet look oppositely.
    axis = np.abs(normals).argmax(axis=1)
    looks = 2 * axis + (normals[np.arange(len(axis)), axis] < 0.0)
    order = np.lexsort((looks, key))
    key, looks = key[order], looks[order]
    first = np.flatnonzero(np.r_[True, (key[1:] != key[:-1]) | (looks[1:] != looks[:-1])])
    share = weight[order][:, None]
    total = np.add.reduceat(share, first)
    middle = np.add.reduceat(share * points[order], first) / total
    up = units(np.add.reduceat(share * normals[order], first))
    return middle, up, np.add.reduceat(tensors[order], first)
